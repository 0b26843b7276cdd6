//! Composite rigid bodies and the mass matrix. Featherstone 2008, Section 6.2 and Table 6.2.

use nalgebra::Matrix3;

use crate::dynamics::Dynamics;
use crate::model::Model;
use crate::spatial::Inertia;
use crate::tree::NONE;

impl Dynamics {
    /// Each body's own inertia about the reference point, world axes, and their sums from the tips to the base:
    /// I^c_i = Σ_{k in subtree of i} I_k.
    pub(crate) fn inertias(&mut self, model: &Model) {
        for (i, body) in model.bodies.iter().enumerate() {
            let frame = &self.relative[i];
            self.inertia[i] = if body.mass > 0.0 || body.inertia != Matrix3::zeros() {
                let about_com = rotated(&body.inertia, &frame.rotation);
                Inertia::new(body.mass, &frame.point(&body.com), &about_com)
            } else {
                Inertia::zero()
            };
        }
        self.composite.copy_from_slice(&self.inertia);
        for (i, body) in model.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                let inertia = self.composite[i];
                self.composite[parent] += inertia;
            }
        }
    }

    /// F_j = I^c S_j and M_ij = S_iᵀ F_j for i = j and all i that carry j; the rest of M stays zero. Armature is added to M_jj.
    pub(crate) fn mass_matrix(&mut self, model: &Model) {
        if self.tree.is_coupled() {
            return self.coupled_mass_matrix(model);
        }
        let nv = self.subspace.len();
        let M = self.mass_matrix.as_mut_slice();
        // The first joint carries everything: its rows are filled at once.
        let (first, frame) = (&model.bodies[0].joint, self.relative[0]);
        let base = first.nv();
        for (j, (dof, subspace)) in model.dofs.iter().zip(&self.subspace).enumerate() {
            let momentum = self.composite[dof.body].momentum(subspace);
            self.subspace_momentum[j] = momentum;
            let column = &mut M[j * nv..(j + 1) * nv];
            first.generalised_force(&frame, &self.subspace, &momentum, column);
            let mut i = j;
            while i != NONE && i >= base {
                column[i] = self.subspace[i].dot(&momentum);
                i = self.tree.parent[i];
            }
            // A rotor turns with its joint alone; what it adds to the motion of the body that it sits on is in that body's inertia.
            column[j] += dof.armature;
        }
        // The other triangle. Where neither coordinate carries the other there is a zero to copy.
        for j in 1..nv {
            let (before, column) = M.split_at_mut(j * nv);
            for (row, entry) in before.chunks_exact_mut(nv).zip(&*column) {
                row[j] = *entry;
            }
        }
    }
}

/// `R I Rᵀ` of a symmetric I.
#[inline]
fn rotated(inertia: &Matrix3<f64>, rotation: &Matrix3<f64>) -> Matrix3<f64> {
    let half = rotation * inertia;
    let entry = |i: usize, j: usize| {
        half[(i, 0)] * rotation[(j, 0)] + half[(i, 1)] * rotation[(j, 1)] + half[(i, 2)] * rotation[(j, 2)]
    };
    let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
    Matrix3::new(entry(0, 0), xy, xz, xy, entry(1, 1), yz, xz, yz, entry(2, 2))
}
