//! The robot: bodies, joints, contact points. Read once, then immutable.

use nalgebra::{DVector, Matrix3, Vector3};

use crate::base::Base;
use crate::frame::Frame;
use crate::joints::Joint;
use crate::spatial::Placement;

/// A rigid body with the joint that carries it. The body's frame is the joint's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Unique.
    pub name: String,
    /// Index of the parent in [`Model::bodies`]; smaller than the body's own. `None`: the world.
    pub parent: Option<usize>,
    /// Unique.
    pub joint_name: String,
    /// How it moves against the parent.
    pub joint: Joint,
    /// The joint's frame in the parent's at zero position: `parent_from_joint`.
    pub placement: Placement,
    /// \[kg\]. Zero for the virtual bodies of a planar base, for frames and for links without inertia.
    pub mass: f64,
    /// The centre of mass in the body frame [m].
    pub com: Vector3<f64>,
    /// The rotational inertia about the centre of mass, body axes [kg m²].
    pub inertia: Matrix3<f64>,
    /// Where the joint's coordinates begin in q.
    pub q_index: usize,
    /// Where the joint's velocities begin in v.
    pub v_index: usize,
    /// The coupling to another joint, whose coordinates are then those that `q_index` and `v_index` name.
    pub follows: Option<Follows>,
}

/// A mechanism by which a joint follows another one exactly: it has no coordinate of its own, and its position is
/// `ratio` times that of the other one plus `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follows {
    /// Its speed for unit speed of the other joint.
    pub ratio: f64,
    /// Its position where the other joint is at zero [rad or m].
    pub offset: f64,
}

impl Body {
    /// The number of velocity coordinates of its own: none for a joint that follows another one.
    #[must_use]
    pub fn nv(&self) -> usize {
        if self.follows.is_some() { 0 } else { self.joint.nv() }
    }

    /// The position of a joint of one coordinate [rad or m], where `q` (nq) is that of the robot.
    ///
    /// # Panics
    /// If `q` is shorter than the model's.
    #[inline]
    #[must_use]
    pub fn position(&self, q: &[f64]) -> f64 {
        let q = q[self.q_index];
        self.follows.as_ref().map_or(q, |follows| follows.ratio * q + follows.offset)
    }
}

/// A velocity coordinate: its name and limits, damper, spring and stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Dof {
    /// The joint's name; of a base `base_x`, `base_z`, `base_pitch`, or `base_wx` … `base_wz`, `base_vx` … `base_vz`.
    pub name: String,
    /// Whether a motor drives it. False for a base and for passive joints.
    pub actuated: bool,
    /// Lowest position [rad or m]; −∞ when not given.
    pub lower: f64,
    /// Highest position [rad or m]; ∞ when not given.
    pub upper: f64,
    /// Highest speed [rad/s or m/s]; ∞ when not given.
    pub velocity_limit: f64,
    /// Highest torque or force [Nm or N]; ∞ when not given.
    pub effort_limit: f64,
    /// Viscous damping [Nm s/rad or N s/m].
    pub damping: f64,
    /// Inertia that the motor's rotor shows at the joint, the gear ratio squared times its own [kg m² or kg]; zero without one.
    pub armature: f64,
    /// Stiffness of a spring at the joint [Nm/rad or N/m]; zero without one, and on a floating base.
    pub stiffness: f64,
    /// Where that spring is at rest [rad or m].
    pub rest: f64,
    /// Stiffness of the stops at `lower` and `upper` [Nm/rad or N/m]; zero where the joint moves freely through them.
    pub stop_stiffness: f64,
    /// Damping of the stops while the joint is beyond its end [Nm s/rad or N s/m].
    pub stop_damping: f64,
    /// Whether it is an angle rather than a distance.
    pub rotational: bool,
    /// The body it moves, in [`Model::bodies`].
    pub body: usize,
}

impl Dof {
    /// A coordinate without limits, damping, spring or motor; joint and body are not told yet.
    pub(crate) fn free() -> Self {
        Self {
            name: String::new(),
            actuated: false,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity_limit: f64::INFINITY,
            effort_limit: f64::INFINITY,
            damping: 0.0,
            armature: 0.0,
            stiffness: 0.0,
            rest: 0.0,
            stop_stiffness: 0.0,
            stop_damping: 0.0,
            rotational: false,
            body: 0,
        }
    }

    /// Its range [rad or m]; where one end is missing half a turn, or a metre, from the other. None where both are missing.
    #[must_use]
    pub fn usual_range(&self) -> Option<[f64; 2]> {
        let reach = if self.rotational { std::f64::consts::PI } else { 1.0 };
        match (self.lower.is_finite(), self.upper.is_finite()) {
            (true, true) => Some([self.lower, self.upper]),
            (true, false) => Some([self.lower, self.lower + reach]),
            (false, true) => Some([self.upper - reach, self.upper]),
            (false, false) => None,
        }
    }
}

/// A point of a body that may touch the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Unique among contact points.
    pub name: String,
    /// The body it is fixed to, in [`Model::bodies`].
    pub body: usize,
    /// In the body frame [m].
    pub position: Vector3<f64>,
}

/// A robot. Made by [`Model::load`], [`Model::from_toml`],
/// [`Model::from_urdf`] or [`Model::from_mjcf`], which check it.
///
/// The numbers (a mass, a limit, a contact's place) may be changed afterwards, say to study a model error; the tree
/// may not: a [`Dynamics`](crate::Dynamics) relies on the structure that it was made with.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The robot's name.
    pub name: String,
    /// What joins the root link to the world.
    pub base: Base,
    /// [m/s²], along −z.
    pub gravity: f64,
    /// Parents before children. A planar base puts two virtual bodies without mass before the root link.
    pub bodies: Vec<Body>,
    /// One for each velocity coordinate.
    pub dofs: Vec<Dof>,
    /// In the order of the file.
    pub contacts: Vec<ContactPoint>,
    /// Named places on bodies, in the order of the file. [`Model::frame`] finds them by name, and bodies too.
    pub frames: Vec<Frame>,
    pub(crate) warnings: Vec<String>,
}

/// Linear directions of a planar and of a spatial model.
const PLANAR_LINEAR: [Vector3<f64>; 2] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];
/// Counter-clockwise as seen with x to the right and z up.
const PLANAR_ANGULAR: [Vector3<f64>; 1] = [Vector3::new(0.0, -1.0, 0.0)];
const SPATIAL: [Vector3<f64>; 3] =
    [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];

impl Model {
    /// The number of position coordinates: `nv`, and one more on a floating base.
    #[must_use]
    pub fn nq(&self) -> usize {
        let last = self.bodies.iter().rev().find(|body| body.follows.is_none());
        last.map_or(0, |body| body.q_index + body.joint.nq())
    }

    /// The number of velocity coordinates.
    #[must_use]
    pub fn nv(&self) -> usize {
        self.dofs.len()
    }

    /// The number of contact points.
    #[must_use]
    pub fn nc(&self) -> usize {
        self.contacts.len()
    }

    /// Whether the robot lives in the x-z plane.
    #[must_use]
    pub fn is_planar(&self) -> bool {
        self.base == Base::Planar
    }

    /// The directions of linear rows: x, z in the plane, otherwise x, y, z. Their number is called d.
    #[must_use]
    pub fn linear_axes(&self) -> &'static [Vector3<f64>] {
        if self.is_planar() { &PLANAR_LINEAR } else { &SPATIAL }
    }

    /// The directions of angular rows: −y in the plane (counter-clockwise with x to the right and z up), otherwise
    /// x, y, z.
    #[must_use]
    pub fn angular_axes(&self) -> &'static [Vector3<f64>] {
        if self.is_planar() { &PLANAR_ANGULAR } else { &SPATIAL }
    }

    /// The components of `vector` along [`Model::linear_axes`]; the last one is zero in the plane.
    #[inline]
    pub(crate) fn linear_components(&self, vector: &Vector3<f64>) -> [f64; 3] {
        if self.is_planar() { [vector.x, vector.z, 0.0] } else { [vector.x, vector.y, vector.z] }
    }

    /// The components of `vector` along [`Model::angular_axes`]; all but the first are zero in the plane.
    #[inline]
    pub(crate) fn angular_components(&self, vector: &Vector3<f64>) -> [f64; 3] {
        if self.is_planar() { [-vector.y, 0.0, 0.0] } else { [vector.x, vector.y, vector.z] }
    }

    /// The root link's index in [`Model::bodies`].
    #[must_use]
    pub fn root(&self) -> usize {
        if self.is_planar() { 2 } else { 0 }
    }

    /// The sum of all masses [kg].
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass).sum()
    }

    /// The zero position (nq): every coordinate zero, the quaternion of a floating base 1.
    #[must_use]
    pub fn neutral(&self) -> DVector<f64> {
        let mut q = DVector::zeros(self.nq());
        for body in self.bodies.iter().filter(|body| body.follows.is_none()) {
            body.joint.neutral(&mut q.as_mut_slice()[body.q_index..]);
        }
        q
    }

    /// Moves from `q` (nq) with the constant velocity `v` (nv) for `dt` [s] and writes the new position to `out` (nq).
    ///
    /// The pose of a floating base follows its body-frame twist by the exponential map of SE(3), and its quaternion
    /// comes out with unit length; all else is q + v dt.
    ///
    /// # Panics
    /// If a slice has a wrong length.
    pub fn integrate(&self, q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
        assert_eq!((q.len(), v.len(), out.len()), (self.nq(), self.nv(), self.nq()), "lengths of q, v, out");
        for body in self.bodies.iter().filter(|body| body.follows.is_none()) {
            body.joint.integrate(&q[body.q_index..], &v[body.v_index..], dt, &mut out[body.q_index..]);
        }
    }

    /// The names of the position coordinates (nq).
    #[must_use]
    pub fn q_names(&self) -> Vec<String> {
        let names = |body: &Body| {
            body.joint.kind().positions.iter().map(|suffix| format!("{}{suffix}", body.joint_name)).collect::<Vec<_>>()
        };
        self.bodies.iter().filter(|body| body.follows.is_none()).flat_map(names).collect()
    }

    /// The names of the velocity coordinates (nv).
    #[must_use]
    pub fn v_names(&self) -> Vec<String> {
        self.dofs.iter().map(|dof| dof.name.clone()).collect()
    }

    /// The velocity coordinates that a motor drives, in order.
    pub fn actuated(&self) -> impl Iterator<Item = usize> + '_ {
        self.dofs.iter().enumerate().filter(|(_, dof)| dof.actuated).map(|(index, _)| index)
    }

    /// The body whose joint moves `body`: its own, or that of what it is fixed to; of what nothing moves the outermost carrier.
    #[must_use]
    pub fn mover(&self, mut body: usize) -> usize {
        while let (0, Some(parent)) = (self.bodies[body].joint.nv(), self.bodies[body].parent) {
            body = parent;
        }
        body
    }

    /// The index of a body in [`Model::bodies`].
    #[must_use]
    pub fn body_index(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.name == name)
    }

    /// The index of a velocity coordinate in [`Model::dofs`].
    #[must_use]
    pub fn dof_index(&self, name: &str) -> Option<usize> {
        self.dofs.iter().position(|dof| dof.name == name)
    }

    /// What is odd about the model without being impossible, one sentence each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn a_missing_end_is_half_a_turn_or_a_metre_away() {
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (rotational, lower, upper, expected) in [
            (true, -0.5, 2.0, Some([-0.5, 2.0])),
            (true, -0.5, high, Some([-0.5, -0.5 + PI])),
            (true, low, 2.0, Some([2.0 - PI, 2.0])),
            (false, 0.25, high, Some([0.25, 1.25])),
            (false, low, 0.25, Some([-0.75, 0.25])),
            (false, low, high, None),
        ] {
            let dof = Dof { rotational, lower, upper, ..Dof::free() };
            assert_eq!(dof.usual_range(), expected);
        }
    }
}
