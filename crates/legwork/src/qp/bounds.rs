//! The bounds of the program. Thesis 4.4.4

use legwork_qp::Problem;

use super::{Inputs, Layout};
use crate::scenario::QpForm;

/// Each component of a contact's force is limited; a contact is switched off by its bounds (in the slack form by the
/// rows of (4.10)).
pub fn forces(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    for k in 0..layout.rho.len() {
        let off = layout.form == QpForm::Direct && !inputs.stance[k / layout.dimension()];
        let limit = if off { 0.0 } else { inputs.limits.grf_n };
        problem.lower_mut()[layout.rho.start + k] = -limit;
        problem.upper_mut()[layout.rho.start + k] = limit;
    }
}

/// Largest torque of an actuated joint [Nm]: the setting, or the joint's own if it is smaller.
pub fn torque_limit(inputs: &Inputs<'_>, dof: usize) -> f64 {
    inputs.limits.torque_nm.min(inputs.model.dofs[dof].effort_limit)
}

/// Torque limits: bounds on τ, or in the direct form on `M_j q̈ + h_j - J_jᵀ ρ` (4.22).
pub fn torques(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    for (index, &dof) in layout.actuated.iter().enumerate() {
        let limit = torque_limit(inputs, dof);
        match layout.form {
            QpForm::Direct => {
                let row = layout.dynamics_rows.start + dof;
                problem.row_lower_mut()[row] -= limit; // around -h_j
                problem.row_upper_mut()[row] += limit;
            }
            QpForm::Slack => {
                problem.lower_mut()[layout.tau.start + index] = -limit;
                problem.upper_mut()[layout.tau.start + index] = limit;
            }
        }
    }
}

/// Joint limits by braking distance (4.32) and the largest acceleration, for the actuated joints.
///
/// Where the former have yielded ([`super::Relaxation::joint_limits`]), a braking joint's bound is a cost instead; the
/// latter can be dropped as well.
pub fn accelerations(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    let n = problem.n();
    for &dof in &layout.actuated {
        let variable = layout.qdd.start + dof;
        let largest =
            if inputs.relaxed.accelerations { f64::INFINITY } else { inputs.limits.joint_acceleration_radps2 };
        let (mut lower, mut upper) = (-largest, largest);
        match braking(inputs, dof) {
            Some(target) if inputs.relaxed.joint_limits => {
                problem.hessian_mut()[variable * n + variable] += 2.0 * inputs.weights.braking;
                problem.gradient_mut()[variable] -= 2.0 * inputs.weights.braking * target;
            }
            Some(target) if target < 0.0 => upper = target,
            Some(target) => lower = target,
            None => {}
        }
        problem.lower_mut()[variable] = lower;
        problem.upper_mut()[variable] = upper;
    }
}

/// The acceleration that a joint is forced to so that it stops before its limit [rad/s²], if it is. Thesis (4.32)
pub fn braking(inputs: &Inputs<'_>, dof: usize) -> Option<f64> {
    let joint = &inputs.model.dofs[dof];
    let (q, v) = (inputs.q[inputs.model.bodies[joint.body].q_index], inputs.v[dof]);
    let largest = inputs.limits.joint_acceleration_radps2;
    let distance = v * v / (2.0 * largest); // b_i
    if v > 0.0 && q + distance >= joint.upper {
        Some(-largest)
    } else if v < 0.0 && q - distance <= joint.lower {
        Some(largest)
    } else {
        None
    }
}
