//! Studies: many rollouts by a plan, and what they say together.

mod base;
pub mod parallel;
pub mod rollout;

pub use base::{Base, Change, Variant};
