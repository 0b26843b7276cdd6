//! Joints that are locked: what they moved becomes part of what carries it.

use crate::joints::{Fixed, Joint};
use crate::model::Model;
use crate::spatial::Motion;

impl Model {
    /// Locks coordinates where they are told to be: each is a velocity coordinate, in [`Model::dofs`], of a joint that has one, and its
    /// position [rad, m]. Their joints are fixed ones from now on; bodies, contact points and frames stay, the other coordinates keep
    /// their order. A [`Dynamics`](crate::Dynamics) of the model before is none of this one.
    pub fn weld(&mut self, positions: &[(usize, f64)]) {
        for &(dof, position) in positions {
            let body = &mut self.bodies[self.dofs[dof].body];
            if body.joint.nv() != 1 {
                continue;
            }
            let mut subspace = [Motion::zero()];
            body.joint.pose(&[position], &mut body.placement, &mut subspace);
            body.joint = Joint::Fixed(Fixed);
        }
        self.dofs.retain(|dof| self.bodies[dof.body].joint.nv() > 0);
        let (mut q_index, mut v_index) = (0, 0);
        for body in &mut self.bodies {
            (body.q_index, body.v_index) = (q_index, v_index);
            q_index += body.joint.nq();
            v_index += body.joint.nv();
        }
    }
}
