//! The simulator: from torques to the next state, with rigid contacts or a spring-damper ground.
//!
//! It knows nothing of the controller. What a run asks of it is a [`Plant`]; another physics is whatever implements that.

pub mod actuators;
pub mod audit;
pub mod batch;
pub mod contact_law;
mod contact_solver;
mod elastic;
pub mod model_error;
mod plant;
pub mod push;
pub mod sensors;
pub mod settings;
mod simulator;
mod simultaneous;
pub mod spring_damper;
mod square;
mod tree_factor;
mod velocity;

pub use plant::{Health, Plant};
pub use simulator::Simulator;
