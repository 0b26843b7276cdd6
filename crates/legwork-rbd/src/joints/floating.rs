//! A body that moves freely in space. Quaternions are Hamilton's, w first.

use nalgebra::{Matrix3, Vector3};

use super::{Joint, JointType, Kind};
use crate::spatial::{Force, Motion, Placement};

/// Free in space: a unit quaternion (w, x, y, z) and the position in the parent's frame; v is the body-frame angular velocity,
/// then the body-frame linear velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Floating;

impl JointType for Floating {
    const KIND: Kind = Kind {
        name: "floating",
        positions: &["_qw", "_qx", "_qy", "_qz", "_x", "_y", "_z"],
        velocities: &[("_wx", true), ("_wy", true), ("_wz", true), ("_vx", false), ("_vy", false), ("_vz", false)],
        keys: &[],
        urdf: &["floating"],
        read: Some(|_| Ok(Joint::Floating(Floating))),
    };

    #[inline]
    fn pose(&self, q: &[f64], frame: &mut Placement, subspace: &mut [Motion]) {
        let translation = frame.point(&Vector3::new(q[4], q[5], q[6]));
        frame.rotation *= rotation_from_quaternion(&q[..4]);
        frame.translation = translation;
        for k in 0..3 {
            let axis = Vector3::from(frame.rotation.column(k));
            subspace[k] = Motion { angular: axis, linear: translation.cross(&axis) };
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
        let angular = frame.rotation * Vector3::new(v[0], v[1], v[2]);
        let linear = frame.rotation * Vector3::new(v[3], v[4], v[5]) + frame.translation.cross(&angular);
        add_twist(Motion { angular, linear }, velocity, acceleration);
    }

    /// The subspace are the axes of the frame: the components along them of the force about the frame's origin.
    #[inline]
    fn generalised_force(frame: &Placement, _: &[Motion], force: &Force, out: &mut [f64]) {
        let angular = frame.rotation.tr_mul(&force.angular_about(&frame.translation));
        let linear = frame.rotation.tr_mul(&force.linear);
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

/// Adds the twist of a joint whose subspace moves with its body. Its rate is V_i × S v = V_λ × S v, as S v × S v = 0.
#[inline]
pub(super) fn add_twist(joint: Motion, velocity: &mut Motion, acceleration: &mut Motion) {
    let rate = velocity.cross(&joint);
    *acceleration = Motion { angular: acceleration.angular + rate.angular, linear: acceleration.linear + rate.linear };
    *velocity = Motion { angular: velocity.angular + joint.angular, linear: velocity.linear + joint.linear };
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

/// Turns the quaternion `q` by the body-frame rotation vector `phi` [rad] and writes it to `out`, with unit length. Returns
/// sin(φ/2).
pub(super) fn follow_rotation(q: &[f64], phi: &Vector3<f64>, out: &mut [f64]) -> f64 {
    let angle_squared = phi.norm_squared();
    let angle = libm::sqrt(angle_squared);
    let (sin_half, half_sinc, half_cos) = if angle_squared < SMALL {
        let s = angle_squared;
        let sinc = 0.5 - s / 48.0 + s * s / 3840.0 - s * s * s / 645_120.0;
        (sinc * angle, sinc, 1.0 - s / 8.0 + s * s / 384.0 - s * s * s / 46_080.0)
    } else {
        let (sin_half, cos_half) = libm::sincos(0.5 * angle);
        (sin_half, sin_half / angle, cos_half)
    };
    let turn = [half_cos, half_sinc * phi.x, half_sinc * phi.y, half_sinc * phi.z];
    let next = quaternion_product([q[0], q[1], q[2], q[3]], turn);
    let norm = libm::sqrt(next.iter().map(|x| x * x).sum());
    for i in 0..4 {
        out[i] = next[i] / norm;
    }
    sin_half
}

/// The square of the angle [rad²] below which sin(φ/2)/φ, (1 − cos φ)/φ² and (φ − sin φ)/φ³ are taken from their series, which err
/// by less than 1e-16.
const SMALL: f64 = 1e-4;

/// Follows the constant body-frame twist (ω, u) for a time `dt` from the pose `q` (quaternion, position): the
/// exponential map of SE(3). The quaternion that it writes has unit length.
fn follow_twist(q: &[f64], v: &[f64], dt: f64, out: &mut [f64]) {
    let phi = Vector3::new(v[0], v[1], v[2]) * dt;
    let d = Vector3::new(v[3], v[4], v[5]) * dt;
    let sin_half = follow_rotation(q, &phi, out);
    let angle_squared = phi.norm_squared();
    let (b, c) = if angle_squared < SMALL {
        let s = angle_squared;
        (
            0.5 - s / 24.0 + s * s / 720.0 - s * s * s / 40_320.0,
            1.0 / 6.0 - s / 120.0 + s * s / 5040.0 - s * s * s / 362_880.0,
        )
    } else {
        let angle = libm::sqrt(angle_squared);
        let (sin, _) = libm::sincos(angle);
        (2.0 * sin_half * sin_half / angle_squared, (angle - sin) / (angle_squared * angle))
    };
    let phi_cross_d = phi.cross(&d);
    let travelled = rotation_from_quaternion(&q[..4]) * (d + b * phi_cross_d + c * phi.cross(&phi_cross_d));
    for i in 0..3 {
        out[4 + i] = q[4 + i] + travelled[i];
    }
}
