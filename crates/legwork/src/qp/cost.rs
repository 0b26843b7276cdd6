//! The cost. Thesis (4.23) and (4.28); `xᵀ C x` becomes `1/2 xᵀ (2C) x` of the standard form (B.3).

use std::ops::Range;

use legwork_qp::Problem;
use nalgebra::DMatrix;

use super::{Inputs, Layout};
use crate::feet::Footing;
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
            let dynamics = inputs.dynamics;
            let offset = dynamics.bias[dof] + dynamics.damping[dof] + dynamics.elastic[dof];
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
    let (weights, tasks) = (inputs.weights, inputs.tracking);
    let soft = |task: Tracking| task == Tracking::Cost || inputs.relaxed.tasks;
    let slack_form = layout.form == QpForm::Slack;
    let mut task = |rows: Range<usize>, slack: &Range<usize>, weight: f64, task: &Errors<'_>| {
        if slack_form {
            let n = problem.n();
            for variable in rows.map(|row| slack.start + row) {
                problem.hessian_mut()[variable * n + variable] += 2.0 * weight;
            }
        } else if soft(task.tracking) {
            squared_errors(layout, problem, task, rows, weight);
        }
    };

    let momentum = Errors {
        tracking: tasks.momentum,
        jacobian: &dynamics.momentum_matrix,
        goal: goal.momentum_rate.as_slice(),
        bias: dynamics.momentum_bias.as_slice(),
    };
    let (angular, all) = (inputs.model.angular_axes().len(), momentum.goal.len());
    task(0..angular, &layout.s_m, weights.angular_momentum_factor * weights.momentum, &momentum);
    let vertical = weights.vertical_momentum_factor;
    // Together where they weigh the same, which is faster.
    let horizontal = if vertical == 1.0 { angular..all } else { angular..all - 1 };
    task(horizontal.clone(), &layout.s_m, weights.momentum, &momentum);
    task(horizontal.end..all, &layout.s_m, vertical * weights.momentum, &momentum);

    let errors = Errors {
        tracking: tasks.feet,
        jacobian: &feet.jacobian,
        goal: goal.foot_acceleration.as_slice(),
        bias: feet.bias.as_slice(),
    };
    for foot in 0..inputs.model.feet.len() {
        let rows = feet.rows(foot);
        let (rotation, place) = match inputs.footing.get(foot) {
            Some(Footing::Swings) => (weights.swing_rotation_factor, weights.swing_feet_factor),
            Some(Footing::Rolls) => (weights.rolling_rotation_factor, 1.0),
            Some(Footing::Trails) => (weights.trailing_rotation_factor, 1.0),
            _ => (1.0, 1.0),
        };
        task(rows.angular.clone(), &layout.s_f, rotation * weights.foot_rotation, &errors);
        task(rows.linear.clone(), &layout.s_f, place * weights.feet, &errors);
    }

    let torso = Errors {
        tracking: tasks.torso,
        jacobian: &dynamics.torso_jacobian,
        goal: goal.torso_acceleration.as_slice(),
        bias: dynamics.torso_bias.as_slice(),
    };
    // A torso that leans far or turns fast is righted first.
    let asked = torso.goal.iter().map(|goal| goal * goal).sum::<f64>();
    let urgency = weights.torso_urgency_s4 * asked;
    task(0..angular, &layout.s_a, (1.0 + urgency * urgency) * weights.torso, &torso);
}

/// A task: `goal - bias - jacobian q̈` is what it is missed by.
struct Errors<'a> {
    tracking: Tracking,
    jacobian: &'a DMatrix<f64>,
    goal: &'a [f64],
    bias: &'a [f64],
}

/// Adds `weight |goal - bias - jacobian q̈|²` over `rows`, without its constant. Thesis (4.25)
fn squared_errors(layout: &Layout, problem: &mut Problem, task: &Errors<'_>, rows: Range<usize>, weight: f64) {
    if rows.is_empty() {
        return;
    }
    let (n, nv, height) = (problem.n(), layout.qdd.len(), task.jacobian.nrows());
    let column = |j: usize| &task.jacobian.as_slice()[j * height..][rows.clone()];
    for j in 0..nv {
        let own = column(j);
        if own.iter().all(|&entry| entry == 0.0) {
            continue;
        }
        for k in 0..=j {
            let product = 2.0 * weight * own.iter().zip(column(k)).map(|(a, b)| a * b).sum::<f64>();
            problem.hessian_mut()[j * n + k] += product;
            if k < j {
                problem.hessian_mut()[k * n + j] += product;
            }
        }
        let errors = task.goal[rows.clone()].iter().zip(&task.bias[rows.clone()]).map(|(goal, bias)| goal - bias);
        problem.gradient_mut()[j] -= 2.0 * weight * own.iter().zip(errors).map(|(a, e)| a * e).sum::<f64>();
    }
}
