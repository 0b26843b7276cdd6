//! Reading the solution of either form.

use nalgebra::{DMatrix, DVector};

use super::bounds::torque_range;
use super::constraints::column;
use super::{Inputs, Layout};
use crate::settings::QpForm;

/// The optimum in physical terms.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    /// Joint accelerations [rad/s², m/s²].
    pub qdd: Vec<f64>,
    /// Contact forces, a contact after the other along the linear axes [N].
    pub rho: Vec<f64>,
    /// Torques of the actuated joints [Nm], within their limits.
    pub tau: Vec<f64>,
    /// What the tasks were missed by, desired minus achieved, at their [`super::Task::rows`]. Thesis (B.9)
    pub slack: Vec<f64>,
}

impl Solution {
    /// Storage for solutions of `layout`.
    pub fn new(layout: &Layout) -> Self {
        Self {
            qdd: vec![0.0; layout.qdd.len()],
            rho: vec![0.0; layout.rho.len()],
            tau: vec![0.0; layout.actuated.len()],
            slack: vec![0.0; layout.tasks().last().map_or(0, |task| task.rows.end)],
        }
    }

    /// Keeps the torques and nothing else: there is no optimum.
    pub fn hold_torque(&mut self) {
        self.qdd.fill(0.0);
        self.rho.fill(0.0);
        self.slack.fill(0.0);
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
                let mut torque = dynamics.passive(dof);
                for (m, qdd) in column(&dynamics.mass_matrix, dof).iter().zip(&solution.qdd) {
                    torque += m * qdd; // M is symmetric
                }
                for (jacobian, rho) in column(&dynamics.contact_jacobian, dof).iter().zip(&solution.rho) {
                    torque -= jacobian * rho;
                }
                torque
            }
        };
        let [lower, upper] = torque_range(inputs, index, dof);
        solution.tau[index] = torque.clamp(lower, upper);
    }
    for (task, aim) in layout.tasks().iter().zip(inputs.aims) {
        let (jacobian, bias) = aim.law.motion(dynamics, inputs.feet);
        missed(&mut solution.slack[task.rows.clone()], &aim.goal, jacobian, &solution.qdd, bias);
    }
}

/// `slack = goal - jacobian q̈ - bias`.
fn missed(slack: &mut [f64], goal: &[f64], jacobian: &DMatrix<f64>, qdd: &[f64], bias: &DVector<f64>) {
    for ((slack, goal), bias) in slack.iter_mut().zip(goal).zip(bias.iter()) {
        *slack = goal - bias;
    }
    for (j, acceleration) in qdd.iter().enumerate() {
        for (slack, entry) in slack.iter_mut().zip(column(jacobian, j)) {
            *slack -= entry * acceleration;
        }
    }
}
