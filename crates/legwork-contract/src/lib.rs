//! What a controller and a physics share, and all that they share: what is sensed and what is commanded ([`contract`]),
//! what each writes down ([`channel`], [`names`]), the robot ([`robot`], [`posture`], which joints its tasks leave free: [`redundancy`]), the ground ([`terrain`], [`contact`]), the feet
//! that stand on it ([`feet`]), and what is wrong with an input ([`error`]).

pub mod channel;
pub mod contact;
pub mod contract;
pub mod error;
pub mod feet;
pub mod names;
mod orientation;
pub mod posture;
pub mod redundancy;
pub mod robot;
pub mod terrain;
