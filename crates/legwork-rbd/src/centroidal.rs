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

        let (angular, linear) = (model.angular_axes().len(), model.linear_axes().len());
        let A = self.momentum_matrix.as_mut_slice().chunks_exact_mut(angular + linear);
        let J = self.com_jacobian.as_mut_slice().chunks_exact_mut(linear);
        for ((momentum, A), J) in self.subspace_momentum.iter().zip(A).zip(J) {
            // Column j: the momentum of all that j carries at unit speed, shifted from the reference point to the CoM
            A[..angular].copy_from_slice(&model.angular_components(&momentum.angular_about(&com))[..angular]);
            A[angular..].copy_from_slice(&model.linear_components(&momentum.linear)[..linear]);
            J.copy_from_slice(&model.linear_components(&(momentum.linear / mass))[..linear]);
        }

        for (follower, momentum) in self.tree.followers(&self.subspace_momentum) {
            let (turn, push) = (momentum.angular_about(&com) * follower.ratio, momentum.linear * follower.ratio);
            let mut A = self.momentum_matrix.column_mut(follower.coordinate);
            let rows = model.angular_components(&turn).into_iter().take(angular);
            let rows = rows.chain(model.linear_components(&push).into_iter().take(linear));
            A.iter_mut().zip(rows).for_each(|(entry, value)| *entry += value);
            let J = self.com_jacobian.column_mut(follower.coordinate);
            J.into_iter().zip(model.linear_components(&(push / mass))).for_each(|(entry, value)| *entry += value);
        }

        // Ȧ v: the rate of momentum at q̈ = 0 is the force on the whole robot. The shift to the moving CoM adds −ċ × m ċ = 0.
        let force = &self.force[0];
        let bias = self.momentum_bias.as_mut_slice();
        bias[..angular].copy_from_slice(&model.angular_components(&force.angular_about(&com))[..angular]);
        bias[angular..].copy_from_slice(&model.linear_components(&force.linear)[..linear]);
    }
}
