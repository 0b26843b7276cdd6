//! Reading the solution of either form.

use legwork_rbd::Model;
use nalgebra::{DMatrix, DVector};

use super::bounds::torque_range;
use super::constraints::column;
use super::{Inputs, Layout};
use crate::feet::FootRows;
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
    /// What each task was missed by.
    pub slack: Slack,
}

/// What the tasks were missed by, desired minus achieved. Thesis (B.9)
#[derive(Clone, Debug, Default)]
pub struct Slack {
    /// `s_m`: rate of momentum, angular then linear [Nm, N].
    pub momentum: Vec<f64>,
    /// `s_f`: accelerations of the feet, in the rows of [`crate::feet::FeetMotion`] [rad/s², m/s²].
    pub feet: Vec<f64>,
    /// `s_a`: angular acceleration of the torso along the angular axes [rad/s²].
    pub torso: Vec<f64>,
}

impl Slack {
    /// All of them, in the order of (B.1).
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        self.momentum.iter().chain(&self.feet).chain(&self.torso).copied()
    }
}

impl Solution {
    /// Storage for solutions of `layout` for `model`.
    pub fn new(layout: &Layout, model: &Model) -> Self {
        let (angular, linear) = (model.angular_axes().len(), model.linear_axes().len());
        let feet = FootRows::count(model);
        Self {
            qdd: vec![0.0; layout.qdd.len()],
            rho: vec![0.0; layout.rho.len()],
            tau: vec![0.0; layout.actuated.len()],
            slack: Slack { momentum: vec![0.0; angular + linear], feet: vec![0.0; feet], torso: vec![0.0; angular] },
        }
    }
}

impl Solution {
    /// Keeps the torques and nothing else: there is no optimum.
    pub fn hold_torque(&mut self) {
        self.qdd.fill(0.0);
        self.rho.fill(0.0);
        self.slack.momentum.fill(0.0);
        self.slack.feet.fill(0.0);
        self.slack.torso.fill(0.0);
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
                let mut torque = dynamics.bias[dof] + dynamics.damping[dof] + dynamics.elastic[dof];
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
    let (goal, feet, slack) = (inputs.goal, inputs.feet, &mut solution.slack);
    let qdd = &solution.qdd;
    missed(&mut slack.momentum, goal.momentum_rate.as_slice(), &dynamics.momentum_matrix, qdd, &dynamics.momentum_bias);
    missed(&mut slack.feet, goal.foot_acceleration.as_slice(), &feet.jacobian, qdd, &feet.bias);
    missed(&mut slack.torso, goal.torso_acceleration.as_slice(), &dynamics.torso_jacobian, qdd, &dynamics.torso_bias);
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
