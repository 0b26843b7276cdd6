//! Inverse dynamics: the recursive Newton-Euler algorithm. Featherstone 2008, Table 5.1.

use nalgebra::Vector3;

use crate::dynamics::Dynamics;
use crate::model::Model;
use crate::spatial::{Force, Motion};

/// From accelerations to the forces that they need, in time that grows with the number of bodies. It holds the scratch.
#[derive(Clone, Debug)]
pub struct InverseDynamics {
    acceleration: Vec<Motion>,
    force: Vec<Force>,
}

impl InverseDynamics {
    /// Allocates the scratch for `model`.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let bodies = model.bodies.len();
        Self { acceleration: vec![Motion::zero(); bodies], force: vec![Force::zero(); bodies] }
    }

    /// Writes the generalised forces `tau` (nv) [Nm or N] with which the robot accelerates by `vdot` (nv) [rad/s² or
    /// m/s²] in the state of `dynamics`, while the contact forces `rho` (d nc) [N] act along the linear axes:
    /// `tau = M v̇ + bias + damping + elastic − Jᵀ ρ`. Allocates nothing.
    ///
    /// # Panics
    /// If a slice has a wrong length, or if `self` was made for another model.
    pub fn solve(&mut self, model: &Model, dynamics: &Dynamics, vdot: &[f64], rho: &[f64], tau: &mut [f64]) {
        assert_eq!((vdot.len(), tau.len()), (model.nv(), model.nv()), "lengths of vdot, tau");
        assert_eq!(self.force.len(), model.bodies.len(), "this InverseDynamics was made for another model");
        take_contact_forces(model, dynamics, rho, &mut self.force);
        // What v̇ adds to the forces that `bias` holds already: they are linear in it.
        for (i, body) in model.bodies.iter().enumerate() {
            let mut acceleration = body.parent.map_or(Motion::zero(), |parent| self.acceleration[parent]);
            let ratio = body.follows.map_or(1.0, |follows| follows.ratio);
            for j in 0..body.joint.nv() {
                acceleration.add_scaled(&dynamics.subspace[dynamics.tree.first[i] + j], ratio * vdot[body.v_index + j]);
            }
            self.acceleration[i] = acceleration;
            self.force[i] += dynamics.inertia[i].momentum(&acceleration);
        }
        for (i, body) in model.bodies.iter().enumerate().rev() {
            for j in body.v_index..body.v_index + body.nv() {
                tau[j] =
                    dynamics.subspace[j].dot(&self.force[i]) + model.dofs[j].armature * vdot[j] + dynamics.passive(j);
            }
            if let Some(parent) = body.parent {
                let force = self.force[i];
                self.force[parent] += force;
            }
        }
        for (follower, s) in dynamics.tree.followers(&dynamics.subspace) {
            tau[follower.coordinate] += follower.ratio * s.dot(&self.force[follower.body]);
        }
    }
}

/// Writes minus the contact forces `rho` (d nc) [N] on each body, about the point of reference.
pub(crate) fn take_contact_forces(model: &Model, dynamics: &Dynamics, rho: &[f64], out: &mut [Force]) {
    let axes = model.linear_axes();
    assert_eq!(rho.len(), axes.len() * model.nc(), "length of rho");
    out.fill(Force::zero());
    for (contact, rho) in model.contacts.iter().zip(rho.chunks_exact(axes.len())) {
        let force: Vector3<f64> = axes.iter().zip(rho).map(|(axis, value)| axis * -value).sum();
        let at = dynamics.relative[contact.body].point(&contact.position);
        out[contact.body] += Force { angular: at.cross(&force), linear: force };
    }
}
