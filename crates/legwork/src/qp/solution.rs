//! Reading the solution of either form.

use super::bounds::torque_limit;
use super::{Inputs, Layout};
use crate::scenario::QpForm;

/// The optimum in physical terms.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    /// Joint accelerations [rad/s², m/s²].
    pub qdd: Vec<f64>,
    /// Contact forces, a contact after the other along the linear axes [N].
    pub rho: Vec<f64>,
    /// Torques of the actuated joints [Nm], within their limits.
    pub tau: Vec<f64>,
    /// `s_m`, `s_f`, `s_a` of (B.9): desired minus achieved rate of momentum [Nm, N], acceleration of the feet [m/s²]
    /// and angular acceleration of the torso [rad/s²].
    pub slack: Vec<f64>,
}

impl Solution {
    /// Storage for solutions of `layout`.
    pub fn new(layout: &Layout) -> Self {
        Self {
            qdd: vec![0.0; layout.qdd.len()],
            rho: vec![0.0; layout.rho.len()],
            tau: vec![0.0; layout.actuated.len()],
            slack: vec![0.0; layout.momentum_rows.len() + layout.feet_rows.len() + 1],
        }
    }
}

/// Reads the optimum `x` of the program that [`super::build`] made of `inputs`.
///
/// The last digits of a torque at its limit are clipped to the limit.
pub fn read_solution(layout: &Layout, inputs: &Inputs<'_>, x: &[f64], solution: &mut Solution) {
    let dynamics = inputs.dynamics;
    solution.qdd.copy_from_slice(&x[layout.qdd.clone()]);
    solution.rho.copy_from_slice(&x[layout.rho.clone()]);
    for (index, &dof) in layout.actuated.iter().enumerate() {
        let torque = match layout.form {
            QpForm::Slack => x[layout.tau.start + index],
            QpForm::Direct => {
                // Thesis (4.22)
                let mut torque = dynamics.bias[dof] + dynamics.damping[dof];
                for j in 0..solution.qdd.len() {
                    torque += dynamics.mass_matrix[(dof, j)] * solution.qdd[j];
                }
                for k in 0..solution.rho.len() {
                    torque -= dynamics.contact_jacobian[(k, dof)] * solution.rho[k];
                }
                torque
            }
        };
        let limit = torque_limit(inputs, dof);
        solution.tau[index] = torque.clamp(-limit, limit);
    }
    let achieved = |jacobian: &nalgebra::DMatrix<f64>, i: usize| -> f64 {
        (0..solution.qdd.len()).map(|j| jacobian[(i, j)] * solution.qdd[j]).sum()
    };
    let goal = inputs.goal;
    let (momenta, feet) = (layout.momentum_rows.len(), layout.feet_rows.len());
    for i in 0..momenta {
        let bias = dynamics.momentum_bias[i];
        solution.slack[i] = goal.momentum_rate[i] - bias - achieved(&dynamics.momentum_matrix, i);
    }
    for i in 0..feet {
        let bias = dynamics.contact_bias[i];
        solution.slack[momenta + i] = goal.foot_acceleration[i] - bias - achieved(&dynamics.contact_jacobian, i);
    }
    solution.slack[momenta + feet] =
        goal.torso_acceleration - dynamics.torso_bias[0] - achieved(&dynamics.torso_jacobian, 0);
}
