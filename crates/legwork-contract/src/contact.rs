//! Contact geometry that controller and simulator share: a piece of ground, the contact basis and the rows of the friction
//! cone. No solver.

use legwork_rbd::Model;
use nalgebra::{Matrix3, Vector3};

/// An inclined plane with Coulomb friction: the ground at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Coefficient of friction.
    pub friction: f64,
    /// Slope, upward in x [rad].
    pub slope: f64,
    /// Unit normal, out of the ground.
    pub normal: Vector3<f64>,
    /// How far that is turned about the second tangent from upright: the slope, where the ground is level across [rad].
    pub turn: f64,
    /// Unit tangents, the second along the line of constant x; a planar robot has the first alone.
    tangents: [Vector3<f64>; 2],
    axes: usize,
}

impl Surface {
    /// The plane as `model` meets it, with its slopes upward in x and in y [rad]; a planar robot meets none across.
    pub fn new(model: &Model, friction: f64, [slope, cross_slope]: [f64; 2]) -> Self {
        let (axes, cross_slope) = if model.is_planar() { (1, 0.0) } else { (2, cross_slope) };
        let (rise, along) = libm::sincos(cross_slope);
        let tangents = [Vector3::x(), Vector3::new(0.0, along, rise)];
        Self { friction, slope, normal: Vector3::z(), turn: 0.0, tangents, axes }.inclined(slope)
    }

    /// The same with another slope upward in x [rad].
    #[must_use]
    pub fn inclined(&self, slope: f64) -> Self {
        let across = self.tangents[1];
        let turn = if across.z == 0.0 { slope } else { libm::atan(libm::tan(slope) * across.y) };
        let (sin, cos) = libm::sincos(turn);
        // Thesis (4.12) and (4.15): P_n and P_t, turned about the line of constant x. The differences from zero keep its sign.
        let normal = Vector3::new(-sin, 0.0 - cos * across.z, cos * across.y);
        let tangent = Vector3::new(cos, 0.0 - sin * across.z, sin * across.y);
        Self { slope, normal, turn, tangents: [tangent, across], ..*self }
    }

    /// The orientation of what lies on it: its axes are both tangents and the normal.
    pub fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&[self.tangents[0], self.tangents[1], self.normal])
    }

    /// Unit tangents: one for a planar robot, two for a spatial one.
    #[inline]
    pub fn tangents(&self) -> &[Vector3<f64>] {
        &self.tangents[..self.axes]
    }

    /// How the plane rises with x and with y.
    #[inline]
    pub fn steepness(&self) -> [f64; 2] {
        [-self.normal.x / self.normal.z, -self.normal.y / self.normal.z]
    }

    /// Height at `(x, y)` of the plane through the world's origin [m].
    #[inline]
    pub fn height_at(&self, x: f64, y: f64) -> f64 {
        let [along, across] = self.steepness();
        along * x + across * y
    }

    /// The directions of contact coordinates: the tangents, then the normal.
    #[inline]
    pub fn directions(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.tangents().iter().chain([&self.normal])
    }
}

/// The cone of friction as inequalities, the rows of `Q_c` for one contact (4.16). In the plane they are the cone. In space they are a
/// pyramid inside the cone, with edges on it: what it allows the ground can give.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    /// The direction of each side along the tangents, and how much of the friction it allows.
    sides: Vec<([f64; 2], f64)>,
}

impl Pyramid {
    /// That of `model`; in space of so many `edges`, the first along the first tangent.
    pub fn new(model: &Model, edges: usize) -> Self {
        if model.is_planar() {
            return Self { sides: vec![([1.0, 0.0], 1.0), ([-1.0, 0.0], 1.0)] };
        }
        let half = std::f64::consts::PI / edges as f64;
        let side = |k: usize| {
            let (across, along) = libm::sincos((2 * k + 1) as f64 * half);
            ([along, across], libm::cos(half))
        };
        Self { sides: (0..edges).map(side).collect() }
    }

    /// Number of rows: the normal's, then one for each side.
    pub fn rows(&self) -> usize {
        1 + self.sides.len()
    }

    /// Row `index` on a piece of ground, as a vector in the world that is multiplied with the force and must not be positive.
    #[inline]
    pub fn row(&self, ground: &Surface, index: usize) -> Vector3<f64> {
        let Some(side) = index.checked_sub(1) else { return -ground.normal };
        let (along, share) = &self.sides[side];
        let mut row = -(share * ground.friction) * ground.normal;
        for (tangent, value) in ground.tangents().iter().zip(along) {
            row += *value * tangent;
        }
        row
    }
}
