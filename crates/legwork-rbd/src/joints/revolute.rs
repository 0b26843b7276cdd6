//! A joint that turns about an axis. Featherstone 2008, Table 4.1.

use nalgebra::{Matrix3, Unit, Vector3};

use super::{Form, Joint, JointType, Key, Kind, key};
use crate::spatial::{Motion, Placement, rotation_about};

/// Turns about an axis through the body's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolute {
    /// The axis of rotation.
    pub axis: Unit<Vector3<f64>>,
}

const KEYS: &[Key] = &[
    key("lower_deg", |dof| &mut dof.lower, Form::Degrees),
    key("upper_deg", |dof| &mut dof.upper, Form::Degrees),
    key("lower_rad", |dof| &mut dof.lower, Form::Finite),
    key("upper_rad", |dof| &mut dof.upper, Form::Finite),
    key("max_velocity_radps", |dof| &mut dof.velocity_limit, Form::Finite),
    key("max_torque_nm", |dof| &mut dof.effort_limit, Form::Finite),
    key("damping_nmspr", |dof| &mut dof.damping, Form::Finite),
    key("armature_kgm2", |dof| &mut dof.armature, Form::NonZero),
    key("spring_nmpr", |dof| &mut dof.stiffness, Form::NonZero),
    key("rest_deg", |dof| &mut dof.rest, Form::Degrees),
    key("rest_rad", |dof| &mut dof.rest, Form::NonZero),
    key("stop_nmpr", |dof| &mut dof.stop_stiffness, Form::NonZero),
    key("stop_damping_nmspr", |dof| &mut dof.stop_damping, Form::NonZero),
];

impl Revolute {
    /// The keys of its limits of position.
    pub(crate) const LIMITS: &[Key] = KEYS.split_at(4).0;
}

impl JointType for Revolute {
    const KIND: Kind = Kind {
        name: "revolute",
        positions: &[""],
        velocities: &[("", true)],
        keys: KEYS,
        // A planar joint is two that slide before one that turns.
        urdf: &["revolute", "continuous", "planar"],
        read: Some(|axis| Ok(Joint::Revolute(Revolute { axis: axis()? }))),
    };

    fn axis(&self) -> Option<Unit<Vector3<f64>>> {
        Some(self.axis)
    }

    #[inline]
    fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]) {
        let axis_world = frame.rotation * self.axis.as_ref();
        frame.rotation = turned(&frame.rotation, &self.axis, q[0]);
        subspace[0] = Motion { angular: axis_world, linear: frame.translation.cross(&axis_world) };
    }
}

/// `rotation` times the rotation by `angle` about the unit vector `axis`. An axis of the frame itself, which most joints
/// turn about, mixes the two other columns only.
#[inline]
fn turned(rotation: &Matrix3<f64>, axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (a, b, sign) = match (axis.x, axis.y, axis.z) {
        (x, 0.0, 0.0) => (1, 2, x),
        (0.0, y, 0.0) => (2, 0, y),
        (0.0, 0.0, z) => (0, 1, z),
        _ => return rotation * rotation_about(axis, angle),
    };
    let (s, c) = libm::sincos(angle);
    let s = sign * s;
    let mut out = *rotation;
    for r in 0..3 {
        let (p, q) = (rotation[(r, a)], rotation[(r, b)]);
        out[(r, a)] = c * p + s * q;
        out[(r, b)] = c * q - s * p;
    }
    out
}
