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
    let (dynamics, feet, goal) = (inputs.dynamics, inputs.feet, inputs.goal);
    let tasks = inputs.tracking;
    let soft = |task: Tracking| task == Tracking::Cost || inputs.relaxed.tasks;
    let angular = inputs.model.angular_axes().len();
    let momentum_weight = |row: usize| {
        let factor = if row < angular { inputs.weights.angular_momentum_factor } else { 1.0 };
        factor * inputs.weights.momentum // C_m
    };

    if layout.form == QpForm::Slack {
        let n = problem.n();
        let hessian = problem.hessian_mut();
        for (range, weight) in [
            (&layout.s_m, &momentum_weight as &dyn Fn(usize) -> f64),
            (&layout.s_f, &|i| foot_weight(inputs, i)),
            (&layout.s_a, &|_| inputs.weights.torso),
        ] {
            for (i, variable) in range.clone().enumerate() {
                hessian[variable * n + variable] += 2.0 * weight(i);
            }
        }
        return;
    }
    if soft(tasks.momentum) {
        for i in 0..goal.momentum_rate.len() {
            let target = goal.momentum_rate[i] - dynamics.momentum_bias[i];
            squared_error(layout, problem, &dynamics.momentum_matrix, i, target, momentum_weight(i));
        }
    }
    if soft(tasks.feet) {
        for i in 0..goal.foot_acceleration.len() {
            let target = goal.foot_acceleration[i] - feet.bias[i];
            squared_error(layout, problem, &feet.jacobian, i, target, foot_weight(inputs, i));
        }
    }
    if soft(tasks.torso) {
        for i in 0..goal.torso_acceleration.len() {
            let target = goal.torso_acceleration[i] - dynamics.torso_bias[i];
            squared_error(layout, problem, &dynamics.torso_jacobian, i, target, inputs.weights.torso);
        }
    }
}

/// `C_f` of a row of the feet.
fn foot_weight(inputs: &Inputs<'_>, row: usize) -> f64 {
    if inputs.feet.is_angular(row) { inputs.weights.foot_rotation } else { inputs.weights.feet }
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
