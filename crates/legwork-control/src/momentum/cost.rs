//! The cost. Thesis (4.23) and (4.28); `xᵀ C x` becomes `1/2 xᵀ (2C) x` of the standard form (B.3).

use std::ops::Range;

use legwork_qp::Problem;
use nalgebra::DMatrix;

use super::{Inputs, Layout};
use crate::settings::{QpForm, Tracking};

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
            let offset = inputs.dynamics.passive(dof);
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
    for (task, aim) in layout.tasks().iter().zip(inputs.aims) {
        let (jacobian, bias) = aim.law.motion(inputs.dynamics, inputs.feet);
        let errors = Errors { jacobian, goal: &aim.goal, bias: bias.as_slice() };
        let soft = task.how == Tracking::Cost || inputs.relaxed.tasks;
        aim.law.weigh(inputs, &aim.goal, &mut |rows, weight| match layout.form {
            QpForm::Slack => {
                let n = problem.n();
                for variable in rows.map(|row| task.variables.start + row) {
                    problem.hessian_mut()[variable * n + variable] += 2.0 * weight;
                }
            }
            QpForm::Direct if soft => squared_errors(problem, &errors, rows, weight),
            QpForm::Direct => {}
        });
    }
}

/// What a task is missed by: `goal - bias - jacobian q̈`.
struct Errors<'a> {
    jacobian: &'a DMatrix<f64>,
    goal: &'a [f64],
    bias: &'a [f64],
}

/// Adds `weight |goal - bias - jacobian q̈|²` over `rows`, without its constant. Thesis (4.25)
fn squared_errors(problem: &mut Problem, task: &Errors<'_>, rows: Range<usize>, weight: f64) {
    if rows.is_empty() {
        return;
    }
    let (n, height) = (problem.n(), task.jacobian.nrows());
    let columns = || task.jacobian.as_slice().chunks_exact(height).map(|column| &column[rows.clone()]);
    for (j, own) in columns().enumerate() {
        if own.iter().all(|&entry| entry == 0.0) {
            continue;
        }
        let product = |other: &[f64]| 2.0 * weight * own.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        let (above, row) = problem.hessian_mut().split_at_mut(j * n);
        for ((entry, mirrored), other) in row[..j].iter_mut().zip(above.chunks_exact_mut(n)).zip(columns()) {
            let product = product(other);
            *entry += product;
            mirrored[j] += product;
        }
        row[j] += product(own);
        let errors = task.goal[rows.clone()].iter().zip(&task.bias[rows.clone()]).map(|(goal, bias)| goal - bias);
        problem.gradient_mut()[j] -= 2.0 * weight * own.iter().zip(errors).map(|(a, e)| a * e).sum::<f64>();
    }
}
