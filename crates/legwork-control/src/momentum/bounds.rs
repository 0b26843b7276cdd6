//! The bounds of the program. Thesis 4.4.4

use legwork_qp::Problem;
use legwork_rbd::Dof;

use super::{Inputs, Layout};
use crate::settings::{JointLimits, Limits, QpForm};

/// Each component of a contact's force is limited; a contact is switched off by its bounds (in the slack form by the
/// rows of (4.10)).
pub fn forces(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    for k in 0..layout.rho.len() {
        let off = layout.form == QpForm::Direct && !inputs.stance[k / layout.dimension()];
        let limit = if off { 0.0 } else { inputs.limits.grf_n };
        problem.lower_mut()[layout.rho.start + k] = -limit;
        problem.upper_mut()[layout.rho.start + k] = limit;
    }
    // A foot that is being unloaded: each of its contact points carries no more than the foot may.
    let axes = layout.dimension();
    for (contact, &foot) in inputs.model.foot_of.iter().enumerate() {
        let Some(&most) = inputs.max_load.get(foot).filter(|most| most.is_finite()) else { continue };
        let vertical = &mut problem.upper_mut()[layout.rho.start + contact * axes + axes - 1];
        *vertical = most.min(*vertical);
    }
}

/// Largest torque of an actuated joint [Nm]: the setting, or the joint's own if it is smaller.
pub fn torque_limit(inputs: &Inputs<'_>, dof: usize) -> f64 {
    inputs.limits.torque_nm.min(inputs.model.dofs[dof].effort_limit)
}

/// Lowest and highest torque of an actuated joint, the `index`-th, in this tick [Nm]: within its limit, and no farther from
/// the torque of the tick before than its rate allows.
pub fn torque_range(inputs: &Inputs<'_>, index: usize, dof: usize) -> [f64; 2] {
    let limit = torque_limit(inputs, dof);
    let Some(before) = inputs.torque_before else { return [-limit, limit] };
    let change = inputs.limits.torque_rate_nmps * inputs.period;
    [(before[index] - change).clamp(-limit, limit), (before[index] + change).clamp(-limit, limit)]
}

/// Torque limits: bounds on τ, or in the direct form on `M_j q̈ + h_j - J_jᵀ ρ` (4.22).
pub fn torques(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    for (index, &dof) in layout.actuated.iter().enumerate() {
        let [lower, upper] = torque_range(inputs, index, dof);
        match layout.form {
            QpForm::Direct => {
                let row = layout.dynamics_rows.start + dof;
                problem.row_lower_mut()[row] += lower; // around -h_j
                problem.row_upper_mut()[row] += upper;
            }
            QpForm::Slack => {
                problem.lower_mut()[layout.tau.start + index] = lower;
                problem.upper_mut()[layout.tau.start + index] = upper;
            }
        }
    }
}

/// Joint limits, those of range and of speed, and the largest acceleration, for the actuated joints.
///
/// Where the former have yielded ([`super::Relaxation::joint_limits`]), a braking joint's bound is a cost instead; the
/// latter can be dropped as well.
pub fn accelerations(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let n = problem.n();
    for &dof in &layout.actuated {
        let variable = layout.qdd.start + dof;
        let largest =
            if inputs.relaxed.accelerations { f64::INFINITY } else { inputs.limits.joint_acceleration_radps2 };
        let [lower, upper] = joint_limits(inputs, dof).map(|bound| bound.clamp(-largest, largest));
        match braking(inputs, dof) {
            Some(target) if inputs.relaxed.joint_limits => {
                problem.hessian_mut()[variable * n + variable] += 2.0 * inputs.weights.braking;
                problem.gradient_mut()[variable] -= 2.0 * inputs.weights.braking * target;
                problem.lower_mut()[variable] = -largest;
                problem.upper_mut()[variable] = largest;
            }
            _ => {
                problem.lower_mut()[variable] = lower;
                problem.upper_mut()[variable] = upper;
            }
        }
    }
}

/// The acceleration that a joint is forced to so that it stops before the end of its range or comes back to its largest speed [rad/s²],
/// if it is.
pub fn braking(inputs: &Inputs<'_>, dof: usize) -> Option<f64> {
    let largest = inputs.limits.joint_acceleration_radps2;
    match joint_limits(inputs, dof) {
        [_, upper] if upper < 0.0 => Some(upper.max(-largest)),
        [lower, _] if lower > 0.0 => Some(lower.min(largest)),
        _ => None,
    }
}

/// The accelerations that keep a joint within its range and below its largest speed, lowest and highest [rad/s²].
fn joint_limits(inputs: &Inputs<'_>, dof: usize) -> [f64; 2] {
    let joint = &inputs.model.dofs[dof];
    let (q, v) = (inputs.q[inputs.model.bodies[joint.body].q_index], inputs.v[dof]);
    let [slowest, fastest] = speed(inputs.limits, joint, v);
    let [lower, upper] = range(inputs.limits, joint, q, v);
    let upper = upper.min(fastest).max(slowest);
    [lower.max(slowest).min(upper), upper]
}

/// The accelerations that keep a joint of velocity `v` below its largest speed, lowest and highest [rad/s²]: it comes to that no faster
/// than exponentially.
pub fn speed(limits: &Limits, joint: &Dof, v: f64) -> [f64; 2] {
    [-joint.velocity_limit, joint.velocity_limit].map(|speed| limits.approach_rate_1ps * (speed - v))
}

/// The accelerations that keep a joint of position `q` and velocity `v` within its range, lowest and highest [rad/s²].
pub fn range(limits: &Limits, joint: &Dof, q: f64, v: f64) -> [f64; 2] {
    let largest = limits.joint_acceleration_radps2;
    match limits.joint_limits {
        JointLimits::BrakingDistance => {
            // Thesis (4.32)
            let distance = v * v / (2.0 * largest); // b_i
            let upper = if v > 0.0 && q + distance >= joint.upper { -largest } else { f64::INFINITY };
            let lower = if v < 0.0 && q - distance <= joint.lower { largest } else { f64::NEG_INFINITY };
            [lower, upper]
        }
        JointLimits::Approach => {
            // The distance d to a limit shrinks no faster than critically damped: d̈ + 2 k ḋ + k² d ≥ 0.
            let k = limits.approach_rate_1ps;
            [joint.lower, joint.upper].map(|limit| k * k * (limit - q) - 2.0 * k * v)
        }
    }
}
