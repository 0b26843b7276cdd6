//! Joints that are locked: what they moved becomes part of what carries it.

use std::collections::HashMap;

use crate::joints::{Fixed, Joint};
use crate::model::Model;
use crate::spatial::Motion;

impl Model {
    /// Locks coordinates where they are told to be: each is a velocity coordinate, in [`Model::dofs`], of a joint that has one, and its
    /// position [rad, m]. Their joints are fixed ones from now on; bodies, contact points and frames stay, the other coordinates keep
    /// their order. A [`Dynamics`](crate::Dynamics) of the model before is none of this one.
    pub fn weld(&mut self, positions: &[(usize, f64)]) {
        for body in self.bodies.iter_mut().filter(|body| body.joint.nv() == 1) {
            let Some((_, position)) = positions.iter().find(|(dof, _)| *dof == body.v_index) else { continue };
            // One that follows is where it is led to.
            let position = body.follows.map_or(*position, |follows| follows.ratio * position + follows.offset);
            body.joint.pose(&[position], &mut body.placement, &mut [Motion::zero()]);
            (body.joint, body.follows) = (Joint::Fixed(Fixed), None);
        }
        self.dofs.retain(|dof| self.bodies[dof.body].joint.nv() > 0);
        let (mut q_index, mut v_index, mut moved) = (0, 0, HashMap::new());
        for body in self.bodies.iter_mut().filter(|body| body.follows.is_none()) {
            if body.joint.nv() > 0 {
                moved.insert(body.v_index, (q_index, v_index));
            }
            (body.q_index, body.v_index) = (q_index, v_index);
            q_index += body.joint.nq();
            v_index += body.joint.nv();
        }
        for body in self.bodies.iter_mut().filter(|body| body.follows.is_some()) {
            (body.q_index, body.v_index) = moved[&body.v_index];
        }
    }
}
