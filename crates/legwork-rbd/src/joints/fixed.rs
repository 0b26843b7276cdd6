//! A body that is rigidly attached.

use super::{Joint, JointType, Kind};
use crate::spatial::{Motion, Placement};

/// Rigidly attached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed;

impl JointType for Fixed {
    const KIND: Kind = Kind {
        name: "fixed",
        positions: &[],
        velocities: &[],
        keys: &[],
        urdf: &["fixed"],
        read: Some(|_| Ok(Joint::Fixed(Fixed))),
    };

    #[inline]
    fn pose(&self, _: &[f64], _: &mut Placement, _: &mut [Motion]) {}
}
