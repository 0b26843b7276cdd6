//! The passes from base to tips: poses and motion subspaces, then velocities and accelerations at q̈ = 0.
//!
//! Everything is relative to a reference point near the robot, the origin of its root link, in world axes. The point is
//! at rest: it is chosen anew at each call. Positions of the order of the robot's size keep their precision wherever
//! the robot has walked to.

use nalgebra::{Matrix3, Vector3};

use crate::dynamics::Dynamics;
use crate::joint::{Base, Joint, Placement, rotation_from_quaternion, turned};
use crate::model::Model;
use crate::spatial::Motion;

impl Dynamics {
    /// Fills poses and `subspace`.
    pub(crate) fn poses(&mut self, model: &Model, q: &[f64]) {
        let origin = match model.base {
            Base::Fixed => model.bodies[0].placement.translation,
            Base::Planar => Vector3::new(q[0], 0.0, q[1]),
            Base::Floating => Vector3::new(q[4], q[5], q[6]),
        };
        self.reference = origin;
        for (i, body) in model.bodies.iter().enumerate() {
            let frame = match body.parent {
                Some(p) => self.relative[p],
                // The world's origin seen from the reference point. The root link comes out at exactly zero.
                None => Placement { rotation: Matrix3::identity(), translation: -origin },
            };
            // Most joints stand parallel to their parent: a product saved, with the same bits.
            let parallel = body.placement.rotation == Matrix3::identity();
            let mut rotation = if parallel { frame.rotation } else { frame.rotation * body.placement.rotation };
            let mut position = frame.point(&body.placement.translation);
            match &body.joint {
                Joint::Fixed => {}
                Joint::Revolute { axis } => {
                    let axis_world = rotation * axis.as_ref();
                    rotation = turned(&rotation, axis, q[body.q_index]);
                    self.subspace[body.v_index] = Motion { angular: axis_world, linear: position.cross(&axis_world) };
                }
                Joint::Prismatic { axis } => {
                    let axis_world = rotation * axis.as_ref();
                    position += axis_world * q[body.q_index];
                    self.subspace[body.v_index] = Motion { angular: Vector3::zeros(), linear: axis_world };
                }
                Joint::Floating => {
                    rotation = rotation_from_quaternion(&q[..4]);
                    position = Vector3::zeros();
                    for k in 0..3 {
                        let axis = Vector3::from(rotation.column(k));
                        self.subspace[k] = Motion { angular: axis, linear: Vector3::zeros() };
                        self.subspace[k + 3] = Motion { angular: Vector3::zeros(), linear: axis };
                    }
                }
            }
            self.relative[i] = Placement { rotation, translation: position };
            self.world_from_body[i] = Placement { rotation, translation: origin + position };
        }
        for (position, contact) in self.contact_positions.iter_mut().zip(&model.contacts) {
            *position = origin + self.relative[contact.body].point(&contact.position);
        }
    }

    /// Fills `velocity`, `acceleration`. Featherstone 2008, (5.7) and (5.8) with q̈ = 0.
    pub(crate) fn velocities(&mut self, model: &Model, v: &[f64]) {
        for (i, body) in model.bodies.iter().enumerate() {
            let (mut velocity, mut acceleration) = match body.parent {
                Some(p) => (self.velocity[p], self.acceleration[p]),
                None => (Motion::zero(), Motion::zero()),
            };
            let placement = &self.relative[i];
            match &body.joint {
                Joint::Fixed => {}
                // V_i = V_λ + S q̇ and A_i = A_λ + V_i × S q̇, where V_i × S = V_λ × S + q̇ S × S and the last term vanishes.
                Joint::Revolute { .. } | Joint::Prismatic { .. } => {
                    let (s, speed) = (&self.subspace[body.v_index], v[body.v_index]);
                    let joint = Motion { angular: s.angular * speed, linear: s.linear * speed };
                    let rate = velocity.cross(&joint);
                    acceleration.angular += rate.angular;
                    acceleration.linear += rate.linear;
                    velocity.angular += joint.angular;
                    velocity.linear += joint.linear;
                }
                Joint::Floating => {
                    velocity = Motion {
                        angular: placement.rotation * Vector3::new(v[0], v[1], v[2]),
                        linear: placement.rotation * Vector3::new(v[3], v[4], v[5]),
                    };
                    // The subspace moves with the body: S˙ v = V × S v = V × V = 0.
                    acceleration = Motion::zero();
                }
            }
            self.velocity[i] = velocity;
            self.acceleration[i] = acceleration;
        }
    }
}
