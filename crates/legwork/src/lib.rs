//! legwork finds out, reproducibly, what a biped or exoskeleton controller can survive, and why it fell: a momentum-based
//! whole-body controller, a rigid-contact simulator, and runs of the two together.
//!
//! A [`scenario`] says what is run; an [`episode`] runs it, tick by tick: a [`control`]ler is given what is sensed and answers
//! with torques, a [`sim`]ulator turns torques into the next state. Controller, reference generator, physics and where the
//! records go may be one's own. A run leaves a [`log`], [`metrics`], the simulator's books ([`sim::audit`]) and, where the robot
//! fell, a sentence of why ([`diagnosis`]).
//!
//! ```
//! use legwork::{episode, scenario_file};
//!
//! let loaded = scenario_file::load("push", &["pushes.0.force_n=300".to_owned()])?;
//! let run = episode::run(&loaded.scenario, &loaded.model()?, &[], |_time| false)?;
//! println!("{:?}, furthest {:?} m", run.outcome, run.metrics.recovery_distance_m);
//! # Ok::<(), legwork::error::Error>(())
//! ```

pub mod adopt;
pub mod balance;
#[cfg(feature = "clock")]
pub mod clock;
pub mod diagnosis;
pub mod episode;
pub mod fit;
mod joint_limits;
pub mod library;
pub mod log;
#[cfg(feature = "files")]
pub mod log_file;
mod measuring;
pub mod metrics;
mod record;
pub mod recording;
pub mod scenario;
pub mod scenario_file;
pub mod settings;
pub mod sink;
pub mod start;
pub mod wearer;

pub use legwork_contract::{
    channel, contact, contract, error, feet, names, posture, redundancy, robot, robot::Robot, terrain,
};
pub use legwork_control as control;
pub use legwork_control::{generator, momentum, planner};
pub use legwork_rbd as rbd;
pub use legwork_sim as sim;
pub use nalgebra;
