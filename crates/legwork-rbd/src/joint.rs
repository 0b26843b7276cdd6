//! Joints, bases, rotations. Featherstone 2008, Section 4.4; quaternions are Hamilton's, w first.

use nalgebra::{Matrix3, Unit, Vector3};
use serde::{Deserialize, Serialize};

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

/// How a body moves against its parent. Axes are in the joint's (= the body's) own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Joint {
    /// Rigidly attached: no coordinate.
    Fixed,
    /// Turns about an axis through the body's origin; the coordinate is the angle [rad], right-handed.
    Revolute {
        /// The axis of rotation.
        axis: Unit<Vector3<f64>>,
    },
    /// Slides along an axis; the coordinate is the distance [m].
    Prismatic {
        /// The direction of positive motion.
        axis: Unit<Vector3<f64>>,
    },
    /// Moves freely: 7 position and 6 velocity coordinates. Only the root of a floating base is of this kind.
    Floating,
}

impl Joint {
    /// The number of position coordinates.
    #[must_use]
    pub fn nq(&self) -> usize {
        match self {
            Joint::Fixed => 0,
            Joint::Revolute { .. } | Joint::Prismatic { .. } => 1,
            Joint::Floating => 7,
        }
    }

    /// The number of velocity coordinates.
    #[must_use]
    pub fn nv(&self) -> usize {
        match self {
            Joint::Fixed => 0,
            Joint::Revolute { .. } | Joint::Prismatic { .. } => 1,
            Joint::Floating => 6,
        }
    }
}

/// A pose: the rotation and position of one frame in another (`parent_from_child`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Takes child axes to parent axes.
    pub rotation: Matrix3<f64>,
    /// The child's origin in the parent frame [m].
    pub translation: Vector3<f64>,
}

impl Placement {
    /// Both frames coincide.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// A point of the child frame, in the parent frame [m].
    #[must_use]
    pub fn point(&self, position: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * position + self.translation
    }
}

/// The rotation by `angle` about the unit vector `axis` (Rodrigues): c 1 + s \[a\]× + (1 − c) a aᵀ.
#[inline]
pub(crate) fn rotation_about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    let a = axis;
    let (sx, sy, sz) = (s * a.x, s * a.y, s * a.z);
    let (tx, ty, tz) = ((1.0 - c) * a.x, (1.0 - c) * a.y, (1.0 - c) * a.z);
    let (xy, xz, yz) = (tx * a.y, tx * a.z, ty * a.z);
    Matrix3::new(tx * a.x + c, xy - sz, xz + sy, xy + sz, ty * a.y + c, yz - sx, xz - sy, yz + sx, tz * a.z + c)
}

/// `rotation` times the rotation by `angle` about the unit vector `axis`. An axis of the frame itself, which most joints
/// turn about, mixes the two other columns only.
#[inline]
pub(crate) fn turned(rotation: &Matrix3<f64>, axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
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

/// Fixed-axis roll, pitch, yaw (as in URDF): `Rz(yaw) Ry(pitch) Rx(roll)`.
pub(crate) fn rotation_from_rpy(rpy: [f64; 3]) -> Matrix3<f64> {
    rotation_about(&Vector3::z(), rpy[2])
        * rotation_about(&Vector3::y(), rpy[1])
        * rotation_about(&Vector3::x(), rpy[0])
}

/// The rotation of a quaternion (w, x, y, z); it need not be of unit length, only not zero.
#[inline]
pub(crate) fn rotation_from_quaternion(q: &[f64]) -> Matrix3<f64> {
    let (w, x, y, z) = (q[0], q[1], q[2], q[3]);
    let two = 2.0 / (w * w + x * x + y * y + z * z);
    let (xx, yy, zz) = (two * x * x, two * y * y, two * z * z);
    let (xy, xz, yz) = (two * x * y, two * x * z, two * y * z);
    let (wx, wy, wz) = (two * w * x, two * w * y, two * w * z);
    Matrix3::new(1.0 - yy - zz, xy - wz, xz + wy, xy + wz, 1.0 - xx - zz, yz - wx, xz - wy, yz + wx, 1.0 - xx - yy)
}

/// The Hamilton product of two quaternions (w, x, y, z).
fn quaternion_product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// Follows the constant body-frame twist (ω, u) for a time `dt` from the pose `q` (quaternion, position): the
/// exponential map of SE(3). The quaternion that it writes has unit length.
pub(crate) fn integrate_floating(q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
    let phi = Vector3::new(v[0], v[1], v[2]) * dt;
    let d = Vector3::new(v[3], v[4], v[5]) * dt;
    let angle_squared = phi.norm_squared();
    let angle = libm::sqrt(angle_squared);
    // sin(φ/2)/φ, (1 − cos φ)/φ², (φ − sin φ)/φ³; their series below 1e-2 rad err by less than 1e-16.
    let (half_sinc, half_cos, b, c) = if angle_squared < 1e-4 {
        let s = angle_squared;
        (
            0.5 - s / 48.0 + s * s / 3840.0 - s * s * s / 645_120.0,
            1.0 - s / 8.0 + s * s / 384.0 - s * s * s / 46_080.0,
            0.5 - s / 24.0 + s * s / 720.0 - s * s * s / 40_320.0,
            1.0 / 6.0 - s / 120.0 + s * s / 5040.0 - s * s * s / 362_880.0,
        )
    } else {
        let (sin_half, cos_half) = libm::sincos(0.5 * angle);
        let (sin, _) = libm::sincos(angle);
        (sin_half / angle, cos_half, 2.0 * sin_half * sin_half / angle_squared, (angle - sin) / (angle_squared * angle))
    };
    let rotation = rotation_from_quaternion(&q[..4]);
    let turn = [half_cos, half_sinc * phi.x, half_sinc * phi.y, half_sinc * phi.z];
    let next = quaternion_product([q[0], q[1], q[2], q[3]], turn);
    let norm = libm::sqrt(next.iter().map(|x| x * x).sum());
    for i in 0..4 {
        out[i] = next[i] / norm;
    }
    let phi_cross_d = phi.cross(&d);
    let travelled = rotation * (d + b * phi_cross_d + c * phi.cross(&phi_cross_d));
    for i in 0..3 {
        out[4 + i] = q[4 + i] + travelled[i];
    }
}
