//! Contact geometry that controller and simulator share: the ground plane, the contact basis and the rows of the
//! friction cone. No solver.

use legwork_rbd::Model;
use nalgebra::Vector3;

use crate::scenario::Ground;

/// An inclined plane through the world's origin, with Coulomb friction.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundPlane {
    /// Coefficient of friction.
    pub friction: f64,
    /// Slope, upward in x [rad].
    pub slope: f64,
    /// Unit normal, out of the ground.
    pub normal: Vector3<f64>,
    /// Unit tangents: one for a planar robot, two for a spatial one.
    pub tangents: Vec<Vector3<f64>>,
}

impl GroundPlane {
    /// The plane as `model` meets it.
    pub fn new(model: &Model, friction: f64, slope: f64) -> Self {
        let (sin, cos) = libm::sincos(slope);
        // Thesis (4.12) and (4.15): P_n and P_t.
        let normal = Vector3::new(-sin, 0.0, cos);
        let mut tangents = vec![Vector3::new(cos, 0.0, sin)];
        if !model.is_planar() {
            tangents.push(Vector3::y());
        }
        Self { friction, slope, normal, tangents }
    }

    /// The true plane of a scenario, as `model` meets it.
    pub fn of(ground: &Ground, model: &Model) -> Self {
        Self::new(model, ground.friction, ground.slope_deg.to_radians())
    }

    /// Height of the ground below `x` [m].
    pub fn height_at(&self, x: f64) -> f64 {
        -self.normal.x / self.normal.z * x
    }

    /// Distance of `point` from the ground along its normal [m]; negative inside.
    pub fn gap(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point)
    }

    /// The directions of contact coordinates: the tangents, then the normal.
    pub fn directions(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.tangents.iter().chain([&self.normal])
    }

    /// Number of contact coordinates: 2 in the plane, 3 in space.
    pub fn dimension(&self) -> usize {
        self.tangents.len() + 1
    }

    /// Number of rows that [`GroundPlane::friction_row`] has a contact.
    pub fn friction_rows(&self) -> usize {
        1 + 2 * self.tangents.len()
    }

    /// Row `index` of `Q_c` for one contact (4.16), as a vector in the world that is multiplied with the force and
    /// must not be positive: first the normal, then each tangent in both directions (a pyramid in space).
    pub fn friction_row(&self, index: usize) -> Vector3<f64> {
        if index == 0 {
            return -self.normal;
        }
        let tangent = self.tangents[(index - 1) / 2];
        let sign = if index % 2 == 1 { 1.0 } else { -1.0 };
        sign * tangent - self.friction * self.normal
    }
}
