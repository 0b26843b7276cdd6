//! Studies: many runs by a plan, and what they say together.
//!
//! A study is data (`studies/*.toml`): scenarios, factors with their levels, a design. [`Study`] numbers its rollouts;
//! [`store`] keeps them in chunks, [`parallel`] makes them on all cores, [`table`] writes them, and [`results`] and
//! [`sensitivity`] say what they mean, with [`ties`] for figures that are equal. The others ask questions of their own:
//!
//! | module | question |
//! |---|---|
//! | [`search`], [`limits`] | how far a value can go before the robot falls, or no longer follows |
//! | [`robustness`] | how hard a push can be, by direction and phase of the gait |
//! | [`sizing`] | which torque and speed the joints need, and what weaker joints cope with |
//! | [`comparison`] | what two robots need for the same walk, beside a person |
//! | [`tune`] | which settings are better, by CMA-ES with held-out cases |

mod base;
mod cma_es;
pub mod comparison;
pub mod design;
mod factor;
mod file;
pub mod files;
pub mod limits;
pub mod parallel;
pub mod results;
pub mod robustness;
pub mod rollout;
pub mod search;
pub mod sensitivity;
pub mod sizing;
mod sobol_sequence;
pub mod store;
mod study;
pub mod table;
pub mod ties;
pub mod tune;

pub use base::{Base, Change, Variant};
pub use factor::{Factor, Level, Levels, Range};
pub use rollout::{Ending, Rollout};
pub use study::{Point, Study};
