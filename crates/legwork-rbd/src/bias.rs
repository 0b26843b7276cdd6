//! Forces without acceleration: Coriolis and centrifugal, gravity, damping. Featherstone 2008, Section 5.3.

use crate::dynamics::Dynamics;
use crate::model::Model;
use crate::spatial::Force;

impl Dynamics {
    /// The force that each body alone needs to move as it does at q̈ = 0: f_i = I_i A_i + V_i ×* I_i V_i. Featherstone
    /// 2008, (5.9), without gravity. Sums momentum and kinetic energy on the way.
    pub(crate) fn body_forces(&mut self) {
        self.momentum = Force::zero();
        let mut twice_energy = 0.0;
        for i in 0..self.composite.len() {
            let inertia = &self.composite[i];
            if inertia.mass == 0.0 {
                self.force[i] = Force::zero();
                continue;
            }
            let momentum = inertia.momentum(&self.velocity[i]);
            let mut force = inertia.momentum(&self.acceleration[i]);
            force += self.velocity[i].cross_force(&momentum);
            twice_energy += self.velocity[i].dot(&momentum);
            self.force[i] = force;
            self.momentum += momentum;
        }
        self.kinetic_energy = 0.5 * twice_energy;
    }

    /// h = C v + G and G from the accumulated forces and inertias; B v from the joints' damping.
    pub(crate) fn generalised_forces(&mut self, model: &Model, v: &[f64]) {
        for (j, dof) in model.dofs.iter().enumerate() {
            let s = &self.subspace[j];
            let subtree = &self.composite[dof.body];
            // Bearing the weight of what j carries, m g upward at its centre of mass: S_j · (m c × g ẑ, m g ẑ)
            let c = &subtree.first_moment;
            let gravity = model.gravity * (subtree.mass * s.linear.z + s.angular.x * c.y - s.angular.y * c.x);
            self.gravity[j] = gravity;
            self.bias[j] = s.dot(&self.force[dof.body]) + gravity;
            self.damping[j] = dof.damping * v[j];
        }
    }
}
