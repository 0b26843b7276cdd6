//! Masses and inertias of bodies: given, or from their shapes, and what the compiler makes of them.

use nalgebra::{Matrix3, Vector3};

use super::bodies::{Body, Geom, GeomType};
use super::compiler::Compiler;
use super::mesh::{Meshes, placed};
use crate::error::ModelError;
use crate::spatial::Placement;

/// Lighter shapes are left out, as MuJoCo does [kg].
const TINY: f64 = 1e-14;

#[derive(Clone, Copy, Debug)]
pub(super) struct Mass {
    /// [kg]
    pub(super) mass: f64,
    /// In the body frame [m].
    pub(super) com: Vector3<f64>,
    /// About the centre of mass, body axes [kg m²].
    pub(super) inertia: Matrix3<f64>,
}

impl Mass {
    pub(super) const fn none() -> Self {
        Self {
            mass: 0.0,
            com: Vector3::new(0.0, 0.0, 0.0),
            inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        }
    }

    /// Of a body, but for the total mass that the file may ask for.
    pub(super) fn of(body: &Body, compiler: &Compiler, meshes: &mut Meshes) -> Result<Self, ModelError> {
        let from_geoms = compiler.inertia_from_geoms.unwrap_or(body.inertial.is_none());
        let given = body.inertial.as_ref().map(|inertial| Self {
            mass: inertial.mass,
            com: inertial.placement.translation,
            inertia: turned(&inertial.inertia, &inertial.placement.rotation),
        });
        let computed = if from_geoms { Self::from_geoms(body, compiler, meshes)? } else { None };
        let mut mass = computed.or(given).unwrap_or(Self::none());
        mass.bound(compiler);
        Ok(mass)
    }

    /// The sum of a body's shapes; none where none has mass.
    fn from_geoms(body: &Body, compiler: &Compiler, meshes: &mut Meshes) -> Result<Option<Self>, ModelError> {
        let [first, last] = compiler.inertia_groups;
        let mut parts = Vec::new();
        for geom in body.geoms.iter().filter(|geom| (first..=last).contains(&geom.group)) {
            parts.extend(geom.mass(meshes)?.filter(|part| part.mass > TINY));
        }
        if let [part] = parts[..] {
            return Ok(Some(part));
        }
        let mass: f64 = parts.iter().map(|part| part.mass).sum();
        if parts.is_empty() {
            return Ok(None);
        }
        let com = parts.iter().map(|part| part.com * part.mass).sum::<Vector3<f64>>() / mass;
        let inertia = parts.iter().map(|part| part.inertia + point_mass(part.mass, &(part.com - com))).sum();
        Ok(Some(Self { mass, com, inertia }))
    }

    /// Least mass and moments; moments that no body has made equal.
    fn bound(&mut self, compiler: &Compiler) {
        self.mass = self.mass.max(compiler.bound_mass);
        if compiler.bound_inertia <= 0.0 && !compiler.balance_inertia {
            return;
        }
        let (rotation, moments) = principal(&self.inertia);
        if moments.min() < compiler.bound_inertia {
            let moments = moments.map(|moment| moment.max(compiler.bound_inertia));
            self.inertia = turned(&Matrix3::from_diagonal(&moments), &rotation);
        }
        let moments = moments.map(|moment| moment.max(compiler.bound_inertia));
        if compiler.balance_inertia && 2.0 * moments.max() > moments.sum() {
            self.inertia = Matrix3::identity() * (moments.sum() / 3.0);
        }
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.mass *= factor;
        self.inertia *= factor;
    }
}

impl Geom<'_> {
    /// Of the shape, in its body's frame; none of one that has no volume.
    fn mass(&self, meshes: &mut Meshes) -> Result<Option<Mass>, ModelError> {
        if self.mass == Some(0.0) || (self.mass.is_none() && self.density == 0.0) {
            return Ok(None);
        }
        let Placement { rotation, translation } = &self.placement;
        if matches!(self.kind, GeomType::Plane | GeomType::HeightField) {
            return Ok(None);
        }
        if self.is_shell {
            return Err(self.element().invalid("shellinertia is not supported; give the body an <inertial>"));
        }
        if let Some(name) = self.mesh {
            if self.kind != GeomType::Mesh {
                let problem =
                    "a shape that is fitted to a mesh has no inertia here; give its size, or the body an <inertial>";
                return Err(self.element().invalid(problem));
            }
            let volume = meshes.volume(name, &self.item)?;
            let mass = self.mass.unwrap_or(self.density * volume.volume);
            let (com, inertia) = placed(&volume, &self.placement);
            return Ok(Some(Mass { mass, com, inertia: inertia * (mass / volume.volume) }));
        }
        if matches!(self.kind, GeomType::Mesh | GeomType::Sdf) {
            return Err(self.element().invalid("a geom of this type needs a mesh, or its body an <inertial>"));
        }
        let (volume, moments) = solid(self.kind, self.size);
        if volume <= TINY {
            return Ok(None);
        }
        let mass = self.mass.unwrap_or(self.density * volume);
        let inertia = turned(&Matrix3::from_diagonal(&(moments * mass)), rotation);
        Ok(Some(Mass { mass, com: *translation, inertia }))
    }
}

/// The volume of a solid [m³] and its principal moments for each kilogram [m²].
fn solid(kind: GeomType, [a, b, c]: [f64; 3]) -> (f64, Vector3<f64>) {
    let pi = std::f64::consts::PI;
    match kind {
        GeomType::Sphere => (4.0 / 3.0 * pi * a * a * a, Vector3::repeat(0.4 * a * a)),
        GeomType::Ellipsoid => {
            (4.0 / 3.0 * pi * a * b * c, Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) / 5.0)
        }
        GeomType::Box => (8.0 * a * b * c, Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) / 3.0),
        GeomType::Cylinder => {
            let across = a * a / 4.0 + b * b / 3.0;
            (2.0 * pi * a * a * b, Vector3::new(across, across, a * a / 2.0))
        }
        GeomType::Capsule => {
            let (cylinder, ball) = (2.0 * pi * a * a * b, 4.0 / 3.0 * pi * a * a * a);
            let (along, ends) = (cylinder / (cylinder + ball), ball / (cylinder + ball));
            // Half a ball is at 3/8 a from its flat side, which is at b from the middle: (2/5 − (3/8)²) a² + (b + 3/8 a)².
            let across = along * (a * a / 4.0 + b * b / 3.0) + ends * (0.4 * a * a + b * b + 0.75 * a * b);
            (cylinder + ball, Vector3::new(across, across, along * a * a / 2.0 + ends * 0.4 * a * a))
        }
        GeomType::Plane | GeomType::HeightField | GeomType::Mesh | GeomType::Sdf => (0.0, Vector3::zeros()),
    }
}

/// `R I Rᵀ`, symmetric to the last bit.
fn turned(inertia: &Matrix3<f64>, rotation: &Matrix3<f64>) -> Matrix3<f64> {
    if *rotation == Matrix3::identity() {
        return *inertia;
    }
    let turned = rotation * inertia * rotation.transpose();
    (turned + turned.transpose()) * 0.5
}

/// Of a mass at a place, about the origin.
fn point_mass(mass: f64, at: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * at.norm_squared() - at * at.transpose()) * mass
}

/// The principal axes of a symmetric matrix, as columns, and its moments: Jacobi's rotations.
fn principal(inertia: &Matrix3<f64>) -> (Matrix3<f64>, Vector3<f64>) {
    let (mut rotation, mut matrix) = (Matrix3::identity(), *inertia);
    for _ in 0..50 {
        let (p, q) = [(0, 1), (0, 2), (1, 2)]
            .into_iter()
            .max_by(|a, b| matrix[*a].abs().total_cmp(&matrix[*b].abs()))
            .unwrap_or((0, 1));
        let off = matrix[(p, q)];
        if off.abs() <= 1e-18 * matrix.amax() {
            break;
        }
        let ratio = (matrix[(q, q)] - matrix[(p, p)]) / (2.0 * off);
        let tangent = ratio.signum() / (ratio.abs() + libm::sqrt(ratio * ratio + 1.0));
        let cosine = 1.0 / libm::sqrt(tangent * tangent + 1.0);
        let mut turn = Matrix3::identity();
        (turn[(p, p)], turn[(q, q)]) = (cosine, cosine);
        (turn[(p, q)], turn[(q, p)]) = (tangent * cosine, -tangent * cosine);
        matrix = turn.transpose() * matrix * turn;
        rotation *= turn;
    }
    (rotation, matrix.diagonal())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_diagonalise() {
        let matrix = Matrix3::new(2.0, 0.3, -0.4, 0.3, 1.5, 0.2, -0.4, 0.2, 1.0);
        let (rotation, moments) = principal(&matrix);
        let again = rotation * Matrix3::from_diagonal(&moments) * rotation.transpose();
        assert!((again - matrix).amax() < 1e-14);
        assert!((rotation * rotation.transpose() - Matrix3::identity()).amax() < 1e-14);
    }

    /// A solid as many small boxes.
    #[test]
    fn solids_are_what_small_boxes_sum_up_to() {
        let inside = |kind: GeomType, [a, b, c]: [f64; 3], p: Vector3<f64>| match kind {
            GeomType::Sphere => p.norm() < a,
            GeomType::Ellipsoid => p.component_div(&Vector3::new(a, b, c)).norm() < 1.0,
            GeomType::Box => p.x.abs() < a && p.y.abs() < b && p.z.abs() < c,
            GeomType::Cylinder => p.xy().norm() < a && p.z.abs() < b,
            _ => (p - Vector3::new(0.0, 0.0, p.z.clamp(-b, b))).norm() < a,
        };
        for kind in [GeomType::Sphere, GeomType::Ellipsoid, GeomType::Box, GeomType::Cylinder, GeomType::Capsule] {
            let size = [0.3, 0.4, 0.2];
            let (n, reach) = (90, 0.75);
            let side = 2.0 * reach / f64::from(n);
            let (mut count, mut second) = (0.0, Vector3::zeros());
            for i in 0..n * n * n {
                let at = |k: i32| (f64::from(k) + 0.5) * side - reach;
                let p = Vector3::new(at(i % n), at(i / n % n), at(i / n / n));
                if inside(kind, size, p) {
                    count += 1.0;
                    second += p.component_mul(&p);
                }
            }
            let (volume, moments) = solid(kind, size);
            assert!((count * side.powi(3) / volume - 1.0).abs() < 0.01, "{kind:?}");
            let summed = Vector3::repeat(second.sum()) - second;
            assert!((summed / count).component_div(&moments).add_scalar(-1.0).amax() < 0.01, "{kind:?}");
        }
    }
}
