//! A joint that turns about every axis through a point.

use nalgebra::Vector3;

use super::floating::{add_twist, follow_rotation, rotation_from_quaternion};
use super::{Joint, JointType, Kind};
use crate::spatial::{Motion, Placement};

/// Turns about every axis through the body's origin: a unit quaternion (w, x, y, z); v is the body-frame angular velocity
/// against the parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ball;

impl JointType for Ball {
    const KIND: Kind = Kind {
        name: "ball",
        positions: &["_qw", "_qx", "_qy", "_qz"],
        velocities: &[("_wx", true), ("_wy", true), ("_wz", true)],
        keys: &[],
        urdf: &["ball", "spherical"],
        read: Some(|_| Ok(Joint::Ball(Ball))),
    };

    #[inline]
    fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]) {
        frame.rotation *= rotation_from_quaternion(&q[..4]);
        for k in 0..3 {
            let axis = Vector3::from(frame.rotation.column(k));
            subspace[k] = Motion { angular: axis, linear: frame.translation.cross(&axis) };
        }
    }

    #[inline]
    fn add_velocity(
        &self,
        frame: &Placement,
        _: &[Motion],
        v: &[f64],
        velocity: &mut Motion,
        acceleration: &mut Motion,
    ) {
        let angular = frame.rotation * Vector3::new(v[0], v[1], v[2]);
        add_twist(Motion { angular, linear: frame.translation.cross(&angular) }, velocity, acceleration);
    }

    #[inline]
    fn integrate(q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
        follow_rotation(q, &(Vector3::new(v[0], v[1], v[2]) * dt), out);
    }

    fn neutral(out: &mut [f64]) {
        out[0] = 1.0;
    }
}
