//! Composite rigid bodies and the mass matrix. Featherstone 2008, Section 6.2 and Table 6.2.

use crate::dynamics::{Dynamics, NONE};
use crate::model::Model;
use crate::spatial::Inertia;

impl Dynamics {
    /// Each body's own inertia about the reference point, world axes; `composite` still holds single bodies.
    pub(crate) fn body_inertias(&mut self, model: &Model) {
        for (i, body) in model.bodies.iter().enumerate() {
            let frame = &self.relative[i];
            self.composite[i] = if body.mass > 0.0 {
                let about_com = frame.rotation * body.inertia * frame.rotation.transpose();
                Inertia::new(body.mass, &frame.point(&body.com), &about_com)
            } else {
                Inertia::zero()
            };
        }
    }

    /// Sums inertias and bias forces from the tips to the base: I^c_i = Σ_{k in subtree of i} I_k.
    pub(crate) fn accumulate(&mut self, model: &Model) {
        for (i, body) in model.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                let (inertia, force) = (self.composite[i], self.force[i]);
                self.composite[parent] += inertia;
                self.force[parent] += force;
            }
        }
    }

    /// F_j = I^c S_j and M_ij = S_iᵀ F_j for i = j and all i that carry j; the rest of M stays zero.
    pub(crate) fn mass_matrix(&mut self, model: &Model) {
        let nv = self.subspace.len();
        let M = self.mass_matrix.as_mut_slice();
        for j in 0..nv {
            let momentum = self.composite[model.dofs[j].body].momentum(&self.subspace[j]);
            self.subspace_momentum[j] = momentum;
            let mut i = j;
            while i != NONE {
                let entry = self.subspace[i].dot(&momentum);
                M[i * nv + j] = entry;
                M[j * nv + i] = entry;
                i = self.parent_dof[i];
            }
        }
    }
}
