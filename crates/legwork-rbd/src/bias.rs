//! Forces without acceleration: Coriolis and centrifugal, gravity, damping. Featherstone 2008, Section 5.3.

use crate::dynamics::Dynamics;
use crate::model::Model;
use crate::spatial::{Force, Inertia, Motion};

impl Dynamics {
    /// The force that each body alone needs to move as it does at q̈ = 0: f_i = I_i A_i + V_i ×* I_i V_i. Featherstone
    /// 2008, (5.9), without gravity; then summed from the tips to the base. Sums momentum and kinetic energy on the way.
    pub(crate) fn forces(&mut self, model: &Model) {
        self.momentum = Force::zero();
        let mut twice_energy = 0.0;
        for ((force, inertia), (velocity, acceleration)) in
            self.force.iter_mut().zip(&self.inertia).zip(self.velocity.iter().zip(&self.acceleration))
        {
            if inertia.is_zero() {
                *force = Force::zero();
                continue;
            }
            let momentum = inertia.momentum(velocity);
            *force = inertia.momentum(acceleration);
            *force += velocity.cross_force(&momentum);
            twice_energy += velocity.dot(&momentum);
            self.momentum += momentum;
        }
        self.kinetic_energy = 0.5 * twice_energy;
        for (i, body) in model.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                let force = self.force[i];
                self.force[parent] += force;
            }
        }
    }

    /// G from the accumulated inertias.
    pub(crate) fn gravity(&mut self, model: &Model) {
        let force = |s: &Motion, subtree: &Inertia| {
            // Bearing the weight of what j carries, m g upward at its centre of mass: S_j · (m c × g ẑ, m g ẑ)
            let c = &subtree.first_moment;
            model.gravity * (subtree.mass * s.linear.z + s.angular.x * c.y - s.angular.y * c.x)
        };
        for (j, dof) in model.dofs.iter().enumerate() {
            self.gravity[j] = force(&self.subspace[j], &self.composite[dof.body]);
        }
        for (follower, s) in self.tree.followers(&self.subspace) {
            self.gravity[follower.coordinate] += follower.ratio * force(s, &self.composite[follower.body]);
        }
    }

    /// h = C v + G from the accumulated forces; B v from the joints' damping. Adds the kinetic energy of rotors: what they show at
    /// their joints is constant, so that h has nothing of them.
    pub(crate) fn generalised_forces(&mut self, model: &Model, v: &[f64]) {
        let mut twice_energy = 0.0;
        for (j, dof) in model.dofs.iter().enumerate() {
            twice_energy += dof.armature * v[j] * v[j];
            self.bias[j] = self.subspace[j].dot(&self.force[dof.body]) + self.gravity[j];
            self.damping[j] = dof.damping * v[j];
        }
        for (follower, s) in self.tree.followers(&self.subspace) {
            // Its weight is in that of the joint that it follows.
            self.bias[follower.coordinate] += follower.ratio * s.dot(&self.force[follower.body]);
        }
        self.kinetic_energy += 0.5 * twice_energy;
        self.stop_dampers(model, v);
    }
}
