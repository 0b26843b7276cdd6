//! The pass from base to tips: poses, motion subspaces, velocities, and accelerations at q̈ = 0.
//!
//! Everything is relative to a reference point near the robot, the origin of its root link, in world axes. The point is
//! at rest: it is chosen anew at each call. Positions of the order of the robot's size keep their precision wherever
//! the robot has walked to.

use nalgebra::{Matrix3, Vector3};

use crate::dynamics::Dynamics;
use crate::joint::{Base, Joint, Placement, rotation_about, rotation_from_quaternion};
use crate::model::Model;
use crate::spatial::Motion;

impl Dynamics {
    /// Fills poses, `subspace`, `velocity`, `acceleration`. Featherstone 2008, (5.7) and (5.8) with q̈ = 0.
    pub(crate) fn kinematics(&mut self, model: &Model, q: &[f64], v: &[f64]) {
        let origin = match model.base {
            Base::Fixed => model.bodies[0].placement.translation,
            Base::Planar => Vector3::new(q[0], 0.0, q[1]),
            Base::Floating => Vector3::new(q[4], q[5], q[6]),
        };
        self.reference = origin;
        for (i, body) in model.bodies.iter().enumerate() {
            let (frame, parent_velocity, parent_acceleration) = match body.parent {
                Some(p) => (self.relative[p], self.velocity[p], self.acceleration[p]),
                // The world's origin seen from the reference point. The root link comes out at exactly zero.
                None => {
                    let world = Placement { rotation: Matrix3::identity(), translation: -origin };
                    (world, Motion::zero(), Motion::zero())
                }
            };
            let mut rotation = frame.rotation * body.placement.rotation;
            let mut position = frame.point(&body.placement.translation);
            let (mut velocity, mut acceleration) = (parent_velocity, parent_acceleration);
            match &body.joint {
                Joint::Fixed => {}
                Joint::Revolute { axis } => {
                    let axis_world = rotation * axis.as_ref();
                    rotation *= rotation_about(axis, q[body.q_index]);
                    let s = Motion { angular: axis_world, linear: position.cross(&axis_world) };
                    self.add_joint_motion(body.v_index, s, v, &mut velocity, &mut acceleration);
                }
                Joint::Prismatic { axis } => {
                    let axis_world = rotation * axis.as_ref();
                    position += axis_world * q[body.q_index];
                    let s = Motion { angular: Vector3::zeros(), linear: axis_world };
                    self.add_joint_motion(body.v_index, s, v, &mut velocity, &mut acceleration);
                }
                Joint::Floating => {
                    rotation = rotation_from_quaternion(&q[..4]);
                    position = Vector3::zeros();
                    for k in 0..3 {
                        let axis = Vector3::from(rotation.column(k));
                        self.subspace[k] = Motion { angular: axis, linear: Vector3::zeros() };
                        self.subspace[k + 3] = Motion { angular: Vector3::zeros(), linear: axis };
                    }
                    velocity = Motion {
                        angular: rotation * Vector3::new(v[0], v[1], v[2]),
                        linear: rotation * Vector3::new(v[3], v[4], v[5]),
                    };
                    // The subspace moves with the body: S˙ v = V × S v = V × V = 0.
                    acceleration = Motion::zero();
                }
            }
            self.relative[i] = Placement { rotation, translation: position };
            self.world_from_body[i] = Placement { rotation, translation: origin + position };
            self.velocity[i] = velocity;
            self.acceleration[i] = acceleration;
            self.body_velocity[i] = Motion { angular: velocity.angular, linear: velocity.linear_at(&position) };
        }
    }

    /// V_i = V_λ + S q̇ and A_i = A_λ + V_i × S q̇, where V_i × S = V_λ × S + q̇ S × S and the last term vanishes.
    #[inline]
    fn add_joint_motion(&mut self, j: usize, s: Motion, v: &[f64], velocity: &mut Motion, acceleration: &mut Motion) {
        let joint = Motion { angular: s.angular * v[j], linear: s.linear * v[j] };
        let rate = velocity.cross(&joint);
        acceleration.angular += rate.angular;
        acceleration.linear += rate.linear;
        velocity.angular += joint.angular;
        velocity.linear += joint.linear;
        self.subspace[j] = s;
    }
}
