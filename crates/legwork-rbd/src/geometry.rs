//! The shapes of a robot, by which it touches: read and handed on, for the dynamics have points of contact instead.

use nalgebra::Vector3;

use crate::spatial::Placement;

/// A shape of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// The body that it is fixed to, by name.
    pub body: String,
    /// Its frame in the body's.
    pub placement: Placement,
    /// What it is.
    pub shape: Shape,
    /// Whether it can touch anything, and is not a picture alone.
    pub collides: bool,
}

/// What a shape is. Its centre is the origin of its frame, but for a mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// [m]
        radius: f64,
    },
    /// A cylinder along z with half a sphere at each end.
    Capsule {
        /// [m]
        radius: f64,
        /// Half the distance between the centres of the spheres [m].
        half_length: f64,
    },
    /// A cylinder along z.
    Cylinder {
        /// [m]
        radius: f64,
        /// [m]
        half_length: f64,
    },
    /// A box along the axes.
    Box {
        /// [m]
        half_sizes: Vector3<f64>,
    },
    /// An ellipsoid along the axes.
    Ellipsoid {
        /// [m]
        semi_axes: Vector3<f64>,
    },
    /// A file of triangles.
    Mesh {
        /// Its name, as the robot's file has it.
        file: String,
        /// By which its coordinates are multiplied.
        scale: Vector3<f64>,
    },
}

impl Geometry {
    /// The points of the body frame [m] that the shape is the hull of, once it has grown by a radius [m]: the corners of a box, the
    /// ends of a capsule's axis, the centre of a sphere. None of a shape that is the hull of no few points.
    ///
    /// ```
    /// use legwork_rbd::{Geometry, Placement, Shape};
    ///
    /// let shape = Shape::Capsule { radius: 0.1, half_length: 0.5 };
    /// let placement = Placement::identity();
    /// let thigh = Geometry { name: "thigh".into(), body: "leg".into(), placement, shape, collides: true };
    /// let (points, radius) = thigh.hull().unwrap();
    /// assert_eq!((points.len(), points[0].z, points[1].z, radius), (2, -0.5, 0.5, 0.1));
    /// ```
    #[must_use]
    pub fn hull(&self) -> Option<(Vec<Vector3<f64>>, f64)> {
        let (points, radius) = match &self.shape {
            Shape::Sphere { radius } => (vec![Vector3::zeros()], *radius),
            Shape::Capsule { radius, half_length } => {
                ([-1.0, 1.0].map(|end| Vector3::new(0.0, 0.0, end * half_length)).to_vec(), *radius)
            }
            Shape::Box { half_sizes } => {
                let sign = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
                let corner = |corner| Vector3::from_fn(|axis, _| sign(corner, axis) * half_sizes[axis]);
                ((0..8).map(corner).collect(), 0.0)
            }
            Shape::Cylinder { .. } | Shape::Ellipsoid { .. } | Shape::Mesh { .. } => return None,
        };
        Some((points.iter().map(|point| self.placement.point(point)).collect(), radius))
    }
}
