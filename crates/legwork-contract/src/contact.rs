//! Contact geometry that controller and simulator share: a piece of ground, the contact basis and the rows of the friction
//! cone. No solver.

use legwork_rbd::Model;
use nalgebra::Vector3;

/// An inclined plane with Coulomb friction: the ground at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Coefficient of friction.
    pub friction: f64,
    /// Slope, upward in x [rad].
    pub slope: f64,
    /// Unit normal, out of the ground.
    pub normal: Vector3<f64>,
    /// Unit tangents; a planar robot has the first alone.
    tangents: [Vector3<f64>; 2],
    axes: usize,
}

impl Surface {
    /// The plane as `model` meets it.
    pub fn new(model: &Model, friction: f64, slope: f64) -> Self {
        let axes = if model.is_planar() { 1 } else { 2 };
        let level = Self { friction, slope: 0.0, normal: Vector3::z(), tangents: [Vector3::x(), Vector3::y()], axes };
        level.inclined(slope)
    }

    /// The same with another slope [rad].
    #[must_use]
    pub fn inclined(&self, slope: f64) -> Self {
        let (sin, cos) = libm::sincos(slope);
        // Thesis (4.12) and (4.15): P_n and P_t.
        let normal = Vector3::new(-sin, 0.0, cos);
        Self { slope, normal, tangents: [Vector3::new(cos, 0.0, sin), Vector3::y()], ..*self }
    }

    /// Unit tangents: one for a planar robot, two for a spatial one.
    #[inline]
    pub fn tangents(&self) -> &[Vector3<f64>] {
        &self.tangents[..self.axes]
    }

    /// Height at `x` of the plane through the world's origin [m].
    #[inline]
    pub fn height_at(&self, x: f64) -> f64 {
        -self.normal.x / self.normal.z * x
    }

    /// The directions of contact coordinates: the tangents, then the normal.
    #[inline]
    pub fn directions(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.tangents().iter().chain([&self.normal])
    }

    /// Row `index` of `Q_c` for one contact (4.16), as a vector in the world that is multiplied with the force and
    /// must not be positive: first the normal, then each tangent in both directions (a pyramid in space).
    #[inline]
    pub fn friction_row(&self, index: usize) -> Vector3<f64> {
        if index == 0 {
            return -self.normal;
        }
        let tangent = self.tangents[(index - 1) / 2];
        let sign = if index % 2 == 1 { 1.0 } else { -1.0 };
        sign * tangent - self.friction * self.normal
    }
}

/// Number of rows that [`Surface::friction_row`] has a contact of `model`.
pub fn friction_rows(model: &Model) -> usize {
    2 * model.linear_axes().len() - 1
}
