//! Spatial (six-dimensional) vectors and inertias, all in one world-aligned frame; poses and rotations.
//!
//! Featherstone 2008, Chapter 2, in Plücker coordinates of a single frame. Since no quantity is ever carried from one
//! frame to another, there are no 6×6 transforms: a spatial vector is a pair of [`Vector3`].

use nalgebra::{Matrix3, Vector3};

/// A motion vector: a velocity, an acceleration, or a column of a joint's motion subspace.
///
/// World axes. `linear` belongs to the body-fixed point that coincides with the point of reference, which is the frame's
/// origin inside the algorithms, and a body's own origin in [`Dynamics::body_velocity`](crate::Dynamics::body_velocity).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Angular part [rad/s, rad/s²].
    pub angular: Vector3<f64>,
    /// Linear part [m/s, m/s²].
    pub linear: Vector3<f64>,
}

impl Motion {
    /// No motion.
    #[must_use]
    pub const fn zero() -> Self {
        Self { angular: Vector3::new(0.0, 0.0, 0.0), linear: Vector3::new(0.0, 0.0, 0.0) }
    }

    /// `v × m`, the rate of change of a motion vector that moves with velocity `v`. Featherstone 2008, (2.31).
    #[must_use]
    pub fn cross(&self, m: &Motion) -> Motion {
        Motion {
            angular: self.angular.cross(&m.angular),
            linear: self.angular.cross(&m.linear) + self.linear.cross(&m.angular),
        }
    }

    /// `v ×* f`, the rate of change of a force vector that moves with velocity `v`. Featherstone 2008, (2.32).
    #[must_use]
    pub fn cross_force(&self, f: &Force) -> Force {
        Force {
            angular: self.angular.cross(&f.angular) + self.linear.cross(&f.linear),
            linear: self.angular.cross(&f.linear),
        }
    }

    /// The scalar product of a motion and a force: power, or a generalised force.
    #[must_use]
    pub fn dot(&self, f: &Force) -> f64 {
        self.angular.dot(&f.angular) + self.linear.dot(&f.linear)
    }

    /// Adds `factor` times `other`.
    pub(crate) fn add_scaled(&mut self, other: &Motion, factor: f64) {
        self.angular += other.angular * factor;
        self.linear += other.linear * factor;
    }

    /// The linear part at the point `at`, given relative to the point of reference.
    #[must_use]
    pub fn linear_at(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(at)
    }
}

/// A force vector: a wrench or a momentum, taken about the frame's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// Moment [Nm] or angular momentum [kg m²/s].
    pub angular: Vector3<f64>,
    /// Force [N] or linear momentum [kg m/s].
    pub linear: Vector3<f64>,
}

impl Force {
    /// No force.
    #[must_use]
    pub const fn zero() -> Self {
        Self { angular: Vector3::new(0.0, 0.0, 0.0), linear: Vector3::new(0.0, 0.0, 0.0) }
    }

    /// Adds `factor` times `other`.
    pub(crate) fn add_scaled(&mut self, other: &Force, factor: f64) {
        self.angular += other.angular * factor;
        self.linear += other.linear * factor;
    }

    /// The angular part about the point `at`, given relative to the present origin.
    #[must_use]
    pub fn angular_about(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.angular - at.cross(&self.linear)
    }
}

impl std::ops::AddAssign for Force {
    fn add_assign(&mut self, other: Force) {
        self.angular += other.angular;
        self.linear += other.linear;
    }
}

/// A rigid body's (or a rigidly composed subtree's) inertia about the frame's origin, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass `m` [kg].
    pub mass: f64,
    /// First moment of mass `m c` [kg m].
    pub first_moment: Vector3<f64>,
    /// Rotational inertia about the origin [kg m²].
    pub rotational: Matrix3<f64>,
}

impl Inertia {
    /// No inertia.
    #[must_use]
    pub const fn zero() -> Self {
        Self {
            mass: 0.0,
            first_moment: Vector3::new(0.0, 0.0, 0.0),
            rotational: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        }
    }

    /// Whether there is nothing that could move.
    #[inline]
    pub(crate) fn is_zero(&self) -> bool {
        self.mass == 0.0 && self.rotational == Matrix3::zeros()
    }

    /// From the mass, the centre of mass and the inertia about it (world axes). Featherstone 2008, (2.62).
    #[must_use]
    pub fn new(mass: f64, com: &Vector3<f64>, about_com: &Matrix3<f64>) -> Self {
        let first_moment = mass * com;
        // Parallel axes: I_O = I_C + m (c·c 1 − c cᵀ)
        let (xx, yy, zz) = (first_moment.x * com.x, first_moment.y * com.y, first_moment.z * com.z);
        let (xy, xz, yz) = (first_moment.x * com.y, first_moment.x * com.z, first_moment.y * com.z);
        let shift = Matrix3::new(yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy);
        Self { mass, first_moment, rotational: about_com + shift }
    }

    /// The momentum of the body moving with `v`. Featherstone 2008, (2.61) and (2.63).
    #[must_use]
    pub fn momentum(&self, v: &Motion) -> Force {
        Force {
            angular: self.rotational * v.angular + self.first_moment.cross(&v.linear),
            linear: self.mass * v.linear + v.angular.cross(&self.first_moment),
        }
    }
}

impl std::ops::AddAssign for Inertia {
    fn add_assign(&mut self, other: Inertia) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.rotational += other.rotational;
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

/// Fixed-axis roll, pitch, yaw (as in URDF): `Rz(yaw) Ry(pitch) Rx(roll)`.
pub(crate) fn rotation_from_rpy(rpy: [f64; 3]) -> Matrix3<f64> {
    rotation_about(&Vector3::z(), rpy[2])
        * rotation_about(&Vector3::y(), rpy[1])
        * rotation_about(&Vector3::x(), rpy[0])
}
