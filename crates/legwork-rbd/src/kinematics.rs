//! The passes from base to tips: poses and motion subspaces, then velocities and accelerations at q̈ = 0.
//!
//! Everything is relative to a reference point near the robot, the origin of its root link, in world axes. The point is
//! at rest: it is chosen anew at each call. Positions of the order of the robot's size keep their precision wherever
//! the robot has walked to.

use nalgebra::Matrix3;

use crate::dynamics::Dynamics;
use crate::model::{Follows, Model};
use crate::spatial::{Motion, Placement};

impl Dynamics {
    /// Fills poses and `subspace`.
    pub(crate) fn poses(&mut self, model: &Model, q: &[f64]) {
        let origin = model.base.origin(model, q);
        self.reference = origin;
        for (i, body) in model.bodies.iter().enumerate() {
            let frame = match body.parent {
                Some(p) => self.relative[p],
                // The world's origin seen from the reference point. The root link comes out at exactly zero.
                None => Placement { rotation: Matrix3::identity(), translation: -origin },
            };
            // Most joints stand parallel to their parent: a product saved, with the same bits.
            let parallel = body.placement.rotation == Matrix3::identity();
            let rotation = if parallel { frame.rotation } else { frame.rotation * body.placement.rotation };
            let mut frame = Placement { rotation, translation: frame.point(&body.placement.translation) };
            let led;
            let (own, first) = match body.follows {
                None => (&q[body.q_index..], body.v_index),
                Some(_) => {
                    led = [body.position(q)];
                    (&led[..], self.tree.first[i])
                }
            };
            body.joint.pose(own, &mut frame, &mut self.subspace[first..]);
            self.relative[i] = frame;
            self.world_from_body[i] = Placement { rotation: frame.rotation, translation: origin + frame.translation };
        }
        for (position, contact) in self.contact_positions.iter_mut().zip(&model.contacts) {
            *position = origin + self.relative[contact.body].point(&contact.position);
        }
    }

    /// Fills `velocity`, `acceleration`.
    pub(crate) fn velocities(&mut self, model: &Model, v: &[f64]) {
        for (i, body) in model.bodies.iter().enumerate() {
            let (mut velocity, mut acceleration) = match body.parent {
                Some(p) => (self.velocity[p], self.acceleration[p]),
                None => (Motion::zero(), Motion::zero()),
            };
            let led;
            let (own, first) = match body.follows {
                None => (&v[body.v_index..], body.v_index),
                Some(Follows { ratio, .. }) => {
                    led = [ratio * v[body.v_index]];
                    (&led[..], self.tree.first[i])
                }
            };
            let (frame, subspace) = (&self.relative[i], &self.subspace[first..]);
            body.joint.add_velocity(frame, subspace, own, &mut velocity, &mut acceleration);
            self.velocity[i] = velocity;
            self.acceleration[i] = acceleration;
        }
    }
}
