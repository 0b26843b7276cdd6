//! A body that moves freely in space. Quaternions are Hamilton's, w first.

use nalgebra::{Matrix3, Vector3};

use super::{JointType, Kind};
use crate::spatial::{Force, Motion, Placement};

/// Free in space: a unit quaternion (w, x, y, z) and the position; v is the body-frame angular velocity, then the
/// body-frame linear velocity. Its frame's origin is the point of reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Floating;

impl JointType for Floating {
    const KIND: Kind = Kind {
        name: "floating",
        positions: &["_qw", "_qx", "_qy", "_qz", "_x", "_y", "_z"],
        velocities: &[("_wx", true), ("_wy", true), ("_wz", true), ("_vx", false), ("_vy", false), ("_vz", false)],
        keys: &[],
        urdf: &[],
        read: None,
    };

    #[inline]
    fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]) {
        frame.rotation = rotation_from_quaternion(&q[..4]);
        frame.translation = Vector3::zeros();
        for k in 0..3 {
            let axis = Vector3::from(frame.rotation.column(k));
            subspace[k] = Motion { angular: axis, linear: Vector3::zeros() };
            subspace[k + 3] = Motion { angular: Vector3::zeros(), linear: axis };
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
        *velocity = Motion {
            angular: frame.rotation * Vector3::new(v[0], v[1], v[2]),
            linear: frame.rotation * Vector3::new(v[3], v[4], v[5]),
        };
        // The subspace moves with the body: S˙ v = V × S v = V × V = 0.
        *acceleration = Motion::zero();
    }

    /// The subspace are the axes of the frame: the force's components along them.
    #[inline]
    fn generalised_force(frame: &Placement, _: &[Motion], force: &Force, out: &mut [f64]) {
        let (angular, linear) = (frame.rotation.tr_mul(&force.angular), frame.rotation.tr_mul(&force.linear));
        out[..3].copy_from_slice(angular.as_slice());
        out[3..6].copy_from_slice(linear.as_slice());
    }

    #[inline]
    fn integrate(q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
        follow_twist(q, v, dt, out);
    }

    fn neutral(out: &mut [f64]) {
        out[0] = 1.0;
    }
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
fn follow_twist(q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
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
