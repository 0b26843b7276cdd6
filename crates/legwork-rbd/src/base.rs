//! What joins the root link to the world: a list of joints.

use nalgebra::{Unit, Vector3};
use serde::{Deserialize, Serialize};

use crate::joints::{Floating, Joint, Prismatic, Revolute};
use crate::model::Model;

/// What joins the root link to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Base {
    /// Bolted to the world; no coordinates.
    Fixed,
    /// Free in the x-z plane: prismatic x, prismatic z, revolute about −y (thesis Section 2.1). v = q̇.
    Planar,
    /// Free in space: a unit quaternion (w, x, y, z) and the position; v is the body-frame angular velocity, then the
    /// body-frame linear velocity of the root link's origin.
    Floating,
}

impl Base {
    /// The joints from the world to the root link, with their names. The last one is the root link's own, each of the
    /// others moves a virtual body without mass; without any the root link keeps the joint of its file.
    pub(crate) fn joints(self) -> Vec<(&'static str, Joint)> {
        match self {
            Base::Fixed => Vec::new(),
            Base::Planar => vec![
                ("base_x", Joint::Prismatic(Prismatic { axis: Vector3::x_axis() })),
                ("base_z", Joint::Prismatic(Prismatic { axis: Vector3::z_axis() })),
                ("base_pitch", Joint::Revolute(Revolute { axis: Unit::new_unchecked(-Vector3::y()) })),
            ],
            Base::Floating => vec![("base", Joint::Floating(Floating))],
        }
    }

    /// The names of its velocity coordinates.
    pub(crate) fn coordinates(self) -> Vec<String> {
        let names = |(name, joint): (&str, Joint)| {
            joint.kind().velocities.iter().map(|(suffix, _)| format!("{name}{suffix}")).collect::<Vec<_>>()
        };
        self.joints().into_iter().flat_map(names).collect()
    }

    /// The root link's origin in the world at the position `q` [m].
    pub(crate) fn origin(self, model: &Model, q: &[f64]) -> Vector3<f64> {
        match self {
            Base::Fixed => model.bodies[0].placement.translation,
            Base::Planar => Vector3::new(q[0], 0.0, q[1]),
            Base::Floating => Vector3::new(q[4], q[5], q[6]),
        }
    }
}
