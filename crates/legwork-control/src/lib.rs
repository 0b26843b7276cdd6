//! Controllers of bipeds and lower-limb exoskeletons.
//!
//! A [`Controller`] is given what is sensed and answers with torques. One tick of the [`MomentumController`] reads like the
//! folder: what is sensed goes through [`generator`] (where centre of mass, torso and feet should be), [`planner`] (which
//! momentum rate and accelerations that asks for) and [`momentum`] (which accelerations, forces and torques come closest).

pub mod contacts;
pub mod controller;
pub mod generator;
pub mod hold;
pub mod momentum;
pub mod planner;
mod prediction;
pub mod settings;

pub use controller::{Controller, Program};
pub use generator::Generator;
pub use hold::HoldController;
pub use momentum::{Fallback, MomentumController};
