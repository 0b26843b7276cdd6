//! The centre of mass and the momentum about it. Orin, Goswami, Lee 2013, (11)-(17).

use crate::dynamics::Dynamics;
use crate::model::Model;

impl Dynamics {
    /// Fills `com`, `com_velocity`, `com_jacobian`, `momentum_matrix`, `momentum_bias`, `potential_energy`.
    pub(crate) fn centroidal(&mut self, model: &Model) {
        let total = &self.composite[0];
        let mass = total.mass;
        let com = total.first_moment / mass;
        self.com = self.reference + com;
        self.com_velocity = self.momentum.linear / mass;
        self.potential_energy = mass * model.gravity * self.com.z;

        let (angular, linear) = (model.angular_axes(), model.linear_axes());
        let rows = angular.len() + linear.len();
        let A = self.momentum_matrix.as_mut_slice();
        let J = self.com_jacobian.as_mut_slice();
        for (j, momentum) in self.subspace_momentum.iter().enumerate() {
            // Column j: the momentum of all that j carries at unit speed, shifted from the reference point to the CoM
            let about_com = momentum.angular_about(&com);
            for (r, axis) in angular.iter().enumerate() {
                A[j * rows + r] = axis.dot(&about_com);
            }
            for (r, axis) in linear.iter().enumerate() {
                let row = axis.dot(&momentum.linear);
                A[j * rows + angular.len() + r] = row;
                J[j * linear.len() + r] = row / mass;
            }
        }

        // Ȧ v: the rate of momentum at q̈ = 0 is the force on the whole robot. The shift to the moving CoM adds −ċ × m ċ = 0.
        let force = &self.force[0];
        let about_com = force.angular_about(&com);
        for (r, axis) in angular.iter().enumerate() {
            self.momentum_bias[r] = axis.dot(&about_com);
        }
        for (r, axis) in linear.iter().enumerate() {
            self.momentum_bias[angular.len() + r] = axis.dot(&force.linear);
        }
    }
}
