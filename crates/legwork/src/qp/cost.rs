//! The cost. Thesis (4.23) and (4.28); `xᵀ C x` becomes `1/2 xᵀ (2C) x` of the standard form (B.3).

use legwork_qp::Problem;
use nalgebra::DMatrix;

use super::{Inputs, Layout};
use crate::scenario::{QpForm, Tracking};

/// Operating cost. Thesis (4.23): accelerations, forces, torques.
pub fn operating(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let n = problem.n();
    let weights = inputs.weights;
    let hessian = problem.hessian_mut();
    for (range, weight) in
        [(&layout.qdd, weights.joint_acceleration), (&layout.rho, weights.grf), (&layout.tau, weights.torque)]
    {
        for i in range.clone() {
            hessian[i * n + i] += 2.0 * weight;
        }
    }
    if layout.form == QpForm::Direct && weights.torque > 0.0 {
        // Thesis (4.22): the torque is linear in accelerations and forces.
        for &dof in &layout.actuated {
            let coefficient = |variable: usize| {
                if variable < layout.qdd.end {
                    inputs.dynamics.mass_matrix[(dof, variable)]
                } else {
                    -inputs.dynamics.contact_jacobian[(variable - layout.rho.start, dof)]
                }
            };
            let offset = inputs.dynamics.bias[dof] + inputs.dynamics.damping[dof];
            for i in 0..n {
                for j in 0..n {
                    problem.hessian_mut()[i * n + j] += 2.0 * weights.torque * coefficient(i) * coefficient(j);
                }
                problem.gradient_mut()[i] += 2.0 * weights.torque * offset * coefficient(i);
            }
        }
    }
}

/// Tracking cost. Thesis (4.28), or (4.24) in the direct form.
pub fn tracking(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let (dynamics, goal) = (inputs.dynamics, inputs.goal);
    let (weights, tasks) = (inputs.weights, inputs.tracking);
    let soft = |task: Tracking| task == Tracking::Cost || inputs.relaxed.tasks;

    if layout.form == QpForm::Slack {
        let n = problem.n();
        let hessian = problem.hessian_mut();
        for (range, weight) in
            [(&layout.s_m, weights.momentum), (&layout.s_f, weights.feet), (&layout.s_a, weights.torso)]
        {
            for i in range.clone() {
                hessian[i * n + i] += 2.0 * weight;
            }
        }
        return;
    }
    if soft(tasks.momentum) {
        for i in 0..layout.momentum_rows.len() {
            let target = goal.momentum_rate[i] - dynamics.momentum_bias[i];
            squared_error(layout, problem, &dynamics.momentum_matrix, i, target, weights.momentum);
        }
    }
    if soft(tasks.feet) {
        for i in 0..layout.feet_rows.len() {
            let target = goal.foot_acceleration[i] - dynamics.contact_bias[i];
            squared_error(layout, problem, &dynamics.contact_jacobian, i, target, weights.feet);
        }
    }
    if soft(tasks.torso) {
        let target = goal.torso_acceleration - dynamics.torso_bias[0];
        squared_error(layout, problem, &dynamics.torso_jacobian, 0, target, weights.torso);
    }
}

/// Adds `weight (jacobian_i q̈ - target)²`, without its constant. Thesis (4.25)
fn squared_error(layout: &Layout, problem: &mut Problem, jacobian: &DMatrix<f64>, i: usize, target: f64, weight: f64) {
    let (n, nv) = (problem.n(), layout.qdd.len());
    let hessian = problem.hessian_mut();
    for j in 0..nv {
        let scaled = 2.0 * weight * jacobian[(i, j)];
        if scaled == 0.0 {
            continue;
        }
        for k in 0..nv {
            hessian[j * n + k] += scaled * jacobian[(i, k)];
        }
    }
    let gradient = problem.gradient_mut();
    for j in 0..nv {
        gradient[j] -= 2.0 * weight * jacobian[(i, j)] * target;
    }
}
