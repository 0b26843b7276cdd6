//! A momentum-based whole-body controller for bipeds and lower-limb exoskeletons, with a rigid-contact simulator.
//!
//! One control tick reads like the folder: a state estimate goes through [`reference`] (where centre of mass, torso and
//! feet should be), [`planner`] (which momentum rate and accelerations that asks for) and [`qp`] (which accelerations,
//! forces and torques come closest), composed in [`control`]; [`sim`] turns torques into the next state. [`episode`] is
//! the only module that sees both sides. A run leaves a [`log`], [`metrics`], the simulator's books
//! ([`sim::audit`]) and, where it fell, a sentence of why ([`diagnosis`]).
//!
//! ```
//! use legwork::{library, scenario_file};
//!
//! let loaded = scenario_file::load("push", &["pushes.0.force_n=300".to_owned()])?;
//! let model = library::load_model(&loaded.scenario.model, None)?;
//! let run = legwork::episode::run(&loaded.scenario, &model, &[], |_time| false)?;
//! println!("{:?}, furthest {:?} m", run.outcome, run.metrics.recovery_distance_m);
//! # Ok::<(), legwork::error::Error>(())
//! ```

pub mod balance;
pub mod contact;
pub mod control;
pub mod diagnosis;
pub mod episode;
pub mod error;
pub mod feet;
pub mod library;
pub mod log;
pub mod log_file;
pub mod metrics;
pub mod planner;
pub mod qp;
pub mod recording;
pub mod reference;
pub mod scenario;
pub mod scenario_file;
pub mod settings;
pub mod sim;
pub mod start;
pub mod terrain;
pub mod wearer;
