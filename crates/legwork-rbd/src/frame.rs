//! Frames, bodies and their points: pose, velocity, Jacobian, bias.

use nalgebra::{DMatrix, Vector3};

use crate::dynamics::Dynamics;
use crate::model::Model;
use crate::spatial::{Motion, Placement};

/// A place of interest that is fixed to a body: a hand, a sensor, a handle.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Unique among frames and bodies.
    pub name: String,
    /// The body it is fixed to, in [`Model::bodies`].
    pub body: usize,
    /// `body_from_frame`.
    pub placement: Placement,
}

impl Model {
    /// The frame of this name, or that of the body of this name.
    #[must_use]
    pub fn frame(&self, name: &str) -> Option<Frame> {
        let of_body = || {
            let body = self.body_index(name)?;
            Some(Frame { name: name.to_owned(), body, placement: Placement::identity() })
        };
        self.frames.iter().find(|frame| frame.name == name).cloned().or_else(of_body)
    }
}

impl Dynamics {
    /// Where a frame is: `world_from_frame`. Of the latest position.
    #[must_use]
    pub fn frame_pose(&self, frame: &Frame) -> Placement {
        let body = &self.world_from_body[frame.body];
        Placement {
            rotation: body.rotation * frame.placement.rotation,
            translation: body.point(&frame.placement.translation),
        }
    }

    /// How a frame moves: angular [rad/s], and linear at its origin [m/s], in world axes.
    #[must_use]
    pub fn frame_velocity(&self, frame: &Frame) -> Motion {
        let velocity = &self.velocity[frame.body];
        let at = self.relative[frame.body].point(&frame.placement.translation);
        Motion { angular: velocity.angular, linear: velocity.linear_at(&at) }
    }

    /// The acceleration of a frame at v̇ = 0, that is J̇ v: angular [rad/s²], and linear at its origin [m/s²].
    #[must_use]
    pub fn frame_bias(&self, frame: &Frame) -> Motion {
        let origin = self.world_from_body[frame.body].point(&frame.placement.translation);
        Motion { angular: self.angular_bias(frame.body), linear: self.point_bias(frame.body, &origin) }
    }

    /// The Jacobian (r × nv) of a frame, written to `out`: its angular velocity along the angular axes, then the linear
    /// velocity of its origin along the linear axes. Of the latest position.
    ///
    /// # Panics
    /// If `out` has a wrong shape.
    pub fn frame_jacobian(&self, model: &Model, frame: &Frame, out: &mut DMatrix<f64>) {
        let (angular, linear) = (model.angular_axes(), model.linear_axes());
        assert_eq!(out.shape(), (angular.len() + linear.len(), model.nv()), "shape of the frame's Jacobian");
        let at = self.relative[frame.body].point(&frame.placement.translation);
        out.fill(0.0);
        self.tree.columns(&self.subspace, frame.body, |j, s| {
            let column = s.linear_at(&at);
            let rows = angular.iter().map(|axis| axis.dot(&s.angular));
            for (r, value) in rows.chain(linear.iter().map(|axis| axis.dot(&column))).enumerate() {
                out[(r, j)] = value;
            }
        });
    }

    /// The Jacobian (d × nv) of a point that is fixed to `body` and now at `world_point` [m], written to `out`.
    ///
    /// # Panics
    /// If `out` has a wrong shape.
    pub fn point_jacobian(&self, model: &Model, body: usize, world_point: &Vector3<f64>, out: &mut DMatrix<f64>) {
        let axes = model.linear_axes();
        assert_eq!(out.shape(), (axes.len(), model.nv()), "shape of the point's Jacobian");
        let at = world_point - self.reference;
        out.fill(0.0);
        self.tree.columns(&self.subspace, body, |j, s| {
            let column = s.linear_at(&at);
            for (r, axis) in axes.iter().enumerate() {
                out[(r, j)] = axis.dot(&column);
            }
        });
    }

    /// The angular velocity of `body`, and the velocity of its point that is now at `world_point` [m].
    #[inline]
    #[must_use]
    pub fn motion_at(&self, body: usize, world_point: &Vector3<f64>) -> Motion {
        let velocity = &self.velocity[body];
        Motion { angular: velocity.angular, linear: velocity.linear_at(&(world_point - self.reference)) }
    }

    /// The velocity [m/s] of a point that is fixed to `body` and now at `world_point` [m].
    #[must_use]
    pub fn point_velocity(&self, body: usize, world_point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity[body].linear_at(&(world_point - self.reference))
    }

    /// The acceleration [m/s²] at v̇ = 0, that is J̇ v, of a point that is fixed to `body` and now at `world_point` [m].
    #[must_use]
    pub fn point_bias(&self, body: usize, world_point: &Vector3<f64>) -> Vector3<f64> {
        let at = world_point - self.reference;
        let velocity = &self.velocity[body];
        // From the spatial to the point's own acceleration: + ω × (velocity of the point). Featherstone 2008, (2.48)
        self.acceleration[body].linear_at(&at) + velocity.angular.cross(&velocity.linear_at(&at))
    }

    /// The Jacobian (angular axes × nv) of a body's angular velocity, written to `out`.
    ///
    /// # Panics
    /// If `out` has a wrong shape.
    pub fn angular_jacobian(&self, model: &Model, body: usize, out: &mut DMatrix<f64>) {
        let axes = model.angular_axes();
        assert_eq!(out.shape(), (axes.len(), model.nv()), "shape of the angular Jacobian");
        out.fill(0.0);
        self.tree.columns(&self.subspace, body, |j, s| {
            for (r, axis) in axes.iter().enumerate() {
                out[(r, j)] = axis.dot(&s.angular);
            }
        });
    }

    /// The angular acceleration [rad/s²] of a body at v̇ = 0, that is J̇ v of its angular velocity.
    #[must_use]
    pub fn angular_bias(&self, body: usize) -> Vector3<f64> {
        self.acceleration[body].angular
    }
}
