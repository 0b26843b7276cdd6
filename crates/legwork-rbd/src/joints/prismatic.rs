//! A joint that slides along an axis. Featherstone 2008, Table 4.1.

use nalgebra::{Unit, Vector3};

use super::{Form, Joint, JointType, Key, Kind, key};
use crate::spatial::{Motion, Placement};

/// Slides along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prismatic {
    /// The direction of positive motion.
    pub axis: Unit<Vector3<f64>>,
}

const KEYS: &[Key] = &[
    key("lower_m", |dof| &mut dof.lower, Form::Finite),
    key("upper_m", |dof| &mut dof.upper, Form::Finite),
    key("max_velocity_mps", |dof| &mut dof.velocity_limit, Form::Finite),
    key("max_force_n", |dof| &mut dof.effort_limit, Form::Finite),
    key("damping_nspm", |dof| &mut dof.damping, Form::Finite),
    key("armature_kg", |dof| &mut dof.armature, Form::NonZero),
    key("spring_npm", |dof| &mut dof.stiffness, Form::NonZero),
    key("rest_m", |dof| &mut dof.rest, Form::NonZero),
    key("stop_npm", |dof| &mut dof.stop_stiffness, Form::NonZero),
    key("stop_damping_nspm", |dof| &mut dof.stop_damping, Form::NonZero),
];

impl JointType for Prismatic {
    const KIND: Kind = Kind {
        name: "prismatic",
        positions: &[""],
        velocities: &[("", false)],
        keys: KEYS,
        urdf: &["prismatic"],
        read: Some(|axis| Ok(Joint::Prismatic(Prismatic { axis: axis()? }))),
    };

    fn axis(&self) -> Option<Unit<Vector3<f64>>> {
        Some(self.axis)
    }

    #[inline]
    fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]) {
        let axis_world = frame.rotation * self.axis.as_ref();
        frame.translation += axis_world * q[0];
        subspace[0] = Motion { angular: Vector3::zeros(), linear: axis_world };
    }
}
