//! The types of joints, one file each. Featherstone 2008, Section 4.4.
//!
//! All that depends on a joint's type is in that type's file: as data ([`Kind`]) the names of its coordinates and what
//! model files say of it, as functions ([`JointType`]) its equations. A new type is a file, and an entry in the list of
//! [`Joint`].

mod ball;
mod fixed;
mod floating;
mod prismatic;
mod revolute;

use nalgebra::{Unit, Vector3};

pub use ball::Ball;
pub use fixed::Fixed;
pub use floating::Floating;
pub(crate) use floating::rotation_from_quaternion;
pub use prismatic::Prismatic;
pub use revolute::Revolute;

use crate::error::ModelError;
use crate::model::Dof;
use crate::spatial::{Force, Motion, Placement};

/// What a type of joint is called, and what model files say of it.
#[derive(Debug)]
pub(crate) struct Kind {
    /// In TOML and in messages.
    pub(crate) name: &'static str,
    /// What follows the joint's name in the name of each position coordinate.
    pub(crate) positions: &'static [&'static str],
    /// What follows the joint's name in the name of each velocity coordinate, and whether the coordinate is an angle.
    pub(crate) velocities: &'static [(&'static str, bool)],
    /// The keys in TOML of the coordinate's numbers.
    pub(crate) keys: &'static [Key],
    /// The types in URDF that are read as this one.
    pub(crate) urdf: &'static [&'static str],
    /// Makes the joint from what a file says; `None` for a type that no file can name.
    pub(crate) read: Option<fn(ReadAxis<'_>) -> Result<Joint, ModelError>>,
}

/// Reads the direction of a joint's axis.
pub(crate) type ReadAxis<'a> = &'a dyn Fn() -> Result<Unit<Vector3<f64>>, ModelError>;

/// A number of a coordinate under its name in TOML.
#[derive(Debug)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    pub(crate) of: fn(&mut Dof) -> &mut f64,
    pub(crate) form: Form,
}

/// In which unit a number is read, and when it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Read in degrees; never written.
    Degrees,
    /// Written where it is finite.
    Finite,
    /// Written where it is not zero.
    NonZero,
}

const fn key(name: &'static str, of: fn(&mut Dof) -> &mut f64, form: Form) -> Key {
    Key { name, of, form }
}

/// The equations of a type of joint. Slices of coordinates begin with the joint's own; columns of the motion subspace S
/// and all motions and forces are in world axes about the point of reference.
pub(crate) trait JointType {
    const KIND: Kind;

    /// The axis, of a type that has one.
    fn axis(&self) -> Option<Unit<Vector3<f64>>> {
        None
    }

    /// Moves `frame`, the joint's frame at zero position, to the position `q`, and writes the columns of S.
    fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]);

    /// Adds the joint's motion to the velocity and the acceleration (at v̇ = 0) of its parent. Featherstone 2008, (5.7) and
    /// (5.8), column by column: V_i = V_λ + S q̇ and A_i = A_λ + V_i × S q̇, where V_i × S = V_λ × S + q̇ S × S and the last
    /// term vanishes.
    #[inline]
    fn add_velocity(
        &self,
        _frame: &Placement,
        subspace: &[Motion],
        v: &[f64],
        velocity: &mut Motion,
        acceleration: &mut Motion,
    ) {
        for (s, &speed) in subspace.iter().zip(v).take(Self::KIND.velocities.len()) {
            let joint = Motion { angular: s.angular * speed, linear: s.linear * speed };
            let rate = velocity.cross(&joint);
            acceleration.angular += rate.angular;
            acceleration.linear += rate.linear;
            velocity.angular += joint.angular;
            velocity.linear += joint.linear;
        }
    }

    /// Sᵀ f.
    #[inline]
    fn generalised_force(_frame: &Placement, subspace: &[Motion], force: &Force, out: &mut [f64]) {
        for (out, s) in out.iter_mut().zip(subspace).take(Self::KIND.velocities.len()) {
            *out = s.dot(force);
        }
    }

    /// Moves with the constant velocity `v` for `dt` [s].
    #[inline]
    fn integrate(q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
        for ((out, q), v) in out.iter_mut().zip(q).zip(v).take(Self::KIND.positions.len()) {
            *out = q + v * dt;
        }
    }

    /// The zero position, written over zeros.
    fn neutral(_out: &mut [f64]) {}
}

/// The enum of joint types with static dispatch to their equations, from the one list of types.
macro_rules! joint_types {
    ($($(#[$doc:meta])* $name:ident,)+) => {
        /// How a body moves against its parent. Axes are in the joint's (= the body's) own frame.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Joint {
            $($(#[$doc])* $name($name),)+
        }

        impl Kind {
            /// Of all types.
            pub(crate) const ALL: &[Kind] = &[$($name::KIND),+];
        }

        impl Joint {
            #[inline]
            pub(crate) const fn kind(&self) -> &'static Kind {
                match self {
                    $(Joint::$name(_) => const { &$name::KIND },)+
                }
            }

            /// The axis of a joint that turns about one or slides along one.
            #[must_use]
            pub fn axis(&self) -> Option<Unit<Vector3<f64>>> {
                match self {
                    $(Joint::$name(joint) => joint.axis(),)+
                }
            }

            #[inline]
            pub(crate) fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]) {
                match self {
                    $(Joint::$name(joint) => joint.pose(q, frame, subspace),)+
                }
            }

            #[inline]
            pub(crate) fn add_velocity(
                &self,
                frame: &Placement,
                subspace: &[Motion],
                v: &[f64],
                velocity: &mut Motion,
                acceleration: &mut Motion,
            ) {
                match self {
                    $(Joint::$name(joint) => joint.add_velocity(frame, subspace, v, velocity, acceleration),)+
                }
            }

            #[inline]
            pub(crate) fn generalised_force(
                &self,
                frame: &Placement,
                subspace: &[Motion],
                force: &Force,
                out: &mut [f64],
            ) {
                match self {
                    $(Joint::$name(_) => $name::generalised_force(frame, subspace, force, out),)+
                }
            }

            #[inline]
            pub(crate) fn integrate(&self, q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
                match self {
                    $(Joint::$name(_) => $name::integrate(q, v, dt, out),)+
                }
            }

            pub(crate) fn neutral(&self, out: &mut [f64]) {
                match self {
                    $(Joint::$name(_) => $name::neutral(out),)+
                }
            }
        }
    };
}

joint_types! {
    /// Rigidly attached: no coordinate.
    Fixed,
    /// Turns about an axis through the body's origin; the coordinate is the angle [rad], right-handed.
    Revolute,
    /// Slides along an axis; the coordinate is the distance [m].
    Prismatic,
    /// Turns about every axis through the body's origin: 4 position and 3 velocity coordinates.
    Ball,
    /// Moves freely: 7 position and 6 velocity coordinates. The root of a floating base is of this type.
    Floating,
}

impl Joint {
    /// The type's name: `fixed`, `revolute`, `prismatic`, `ball` or `floating`.
    #[must_use]
    pub const fn type_name(&self) -> &'static str {
        self.kind().name
    }

    /// The number of position coordinates.
    #[inline]
    #[must_use]
    pub const fn nq(&self) -> usize {
        self.kind().positions.len()
    }

    /// The number of velocity coordinates.
    #[inline]
    #[must_use]
    pub const fn nv(&self) -> usize {
        self.kind().velocities.len()
    }
}
