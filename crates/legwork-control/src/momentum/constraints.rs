//! The rows of the program, one function an equation.

use legwork_qp::Problem;
use nalgebra::DMatrix;

use super::{Inputs, Layout};
use crate::settings::{QpForm, Tracking};

/// Equation of motion. Thesis (4.8): `M q̈ - Jᵀ ρ - S_τ τ = -h`.
///
/// In the direct form the row of an actuated joint is its torque, bounded in [`super::bounds::torques`].
pub fn dynamics(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let dynamics = inputs.dynamics;
    for dof in 0..layout.qdd.len() {
        let index = layout.dynamics_rows.start + dof;
        let row = problem.row_mut(index);
        row[layout.qdd.clone()].copy_from_slice(column(&dynamics.mass_matrix, dof)); // symmetric
        for (entry, jacobian) in row[layout.rho.clone()].iter_mut().zip(column(&dynamics.contact_jacobian, dof)) {
            *entry = -jacobian;
        }
        equality(problem, index, -dynamics.passive(dof));
    }
    for (index, &dof) in layout.actuated.iter().enumerate() {
        if layout.form == QpForm::Slack {
            problem.row_mut(layout.dynamics_rows.start + dof)[layout.tau.start + index] = -1.0;
        }
    }
}

/// Friction cones. Thesis (4.16): `Q_c ρ <= 0`.
pub fn friction(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let (dimension, rows) = (layout.dimension(), layout.pyramid().rows());
    for contact in 0..inputs.stance.len() {
        for k in 0..rows {
            let index = layout.friction_rows.start + contact * rows + k;
            let direction = layout.pyramid().row(&inputs.ground[contact], k);
            let row = problem.row_mut(index);
            for (i, axis) in inputs.model.linear_axes().iter().enumerate() {
                row[layout.rho.start + contact * dimension + i] = axis.dot(&direction);
            }
            problem.row_upper_mut()[index] = 0.0;
        }
    }
}

/// Tracking. Thesis (4.17), (4.19), (4.20) with slack variables as in (B.9); without them a task has rows only where it
/// is an equality, and they bind only where it has not yielded.
pub fn tasks(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let slack = layout.form == QpForm::Slack;
    for (task, aim) in layout.tasks().iter().zip(inputs.aims) {
        let hard = task.how == Tracking::Equality && !inputs.relaxed.tasks;
        if !slack && !hard {
            continue; // in the cost alone
        }
        let (jacobian, bias) = aim.law.motion(inputs.dynamics, inputs.feet);
        for (i, index) in task.constraints.clone().enumerate() {
            let row = problem.row_mut(index);
            for j in 0..layout.qdd.len() {
                row[layout.qdd.start + j] = jacobian[(i, j)];
            }
            if slack {
                let variable = task.variables.start + i;
                row[variable] = 1.0;
                if hard {
                    problem.lower_mut()[variable] = 0.0;
                    problem.upper_mut()[variable] = 0.0;
                }
            }
            equality(problem, index, aim.goal[i] - bias[i]);
        }
    }
}

/// Complementarity. Thesis (4.10), (B.10): `d_f ρ = 0`, with the contact flag in place of the distance. In the direct
/// form the force's bounds say the same.
pub fn complementarity(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    if layout.form == QpForm::Direct {
        return;
    }
    for k in 0..layout.rho.len() {
        let in_contact = inputs.stance[k / layout.dimension()];
        let index = layout.complementarity_rows.start + k;
        problem.row_mut(index)[layout.rho.start + k] = if in_contact { 0.0 } else { 1.0 };
        equality(problem, index, 0.0);
    }
}

/// A column of a matrix.
pub(super) fn column(matrix: &DMatrix<f64>, j: usize) -> &[f64] {
    &matrix.as_slice()[j * matrix.nrows()..(j + 1) * matrix.nrows()]
}

fn equality(problem: &mut Problem, row: usize, value: f64) {
    problem.row_lower_mut()[row] = value;
    problem.row_upper_mut()[row] = value;
}
