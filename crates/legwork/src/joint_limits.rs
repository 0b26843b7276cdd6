//! Which limits of its joints a robot passed: not every physics and not every controller holds to all that a model says.

use crate::contract::{Command, Sensed};
use crate::rbd::Dof;
use crate::robot::Robot;

/// What of a joint is limited, in the order in which it is told.
const KINDS: usize = 3;
/// A joint is past the end of its range where it is farther than this [rad or m].
const RANGE: f64 = 0.01;
/// It is too fast, or is driven too hard, where it is so by more than this share.
const SHARE: f64 = 0.01;

/// The farthest that each joint was past each of its limits so far, and when [s].
#[derive(Clone, Debug)]
pub(crate) struct JointLimits(Vec<[(f64, f64); KINDS]>);

impl JointLimits {
    pub(crate) fn new(model: &Robot) -> Self {
        Self(vec![[(0.0, 0.0); KINDS]; model.nv()])
    }

    /// Takes in the true state at the end of a control period and the torques that acted in it. Allocates nothing.
    pub(crate) fn watch(&mut self, model: &Robot, state: &Sensed, command: &Command) {
        for (index, (dof, worst)) in model.dofs.iter().zip(&mut self.0).enumerate() {
            let q = state.q[model.bodies[dof.body].q_index];
            enter(&mut worst[0], (q - dof.upper).max(dof.lower - q), state.time);
            enter(&mut worst[1], state.v[index].abs() - dof.velocity_limit, state.time);
        }
        for (dof, torque) in model.actuated().zip(&command.torque) {
            enter(&mut self.0[dof][2], torque.abs() - model.dofs[dof].effort_limit, state.time);
        }
    }

    /// The limits that were passed, in words.
    pub(crate) fn in_words(&self, model: &Robot) -> Vec<String> {
        let of = |(dof, worst): (&Dof, &[(f64, f64); KINDS])| {
            let (angle, unit, speed, effort) = if dof.rotational {
                (180.0 / std::f64::consts::PI, "deg", "rad/s", "Nm")
            } else {
                (1e3, "mm", "m/s", "N")
            };
            let [(range, when), (over, fast), (driven, hard)] = *worst;
            let stops = if dof.stop_stiffness > 0.0 {
                "its stop gave way as far"
            } else {
                "its model gives it no stop, so nothing held it"
            };
            let range = (range > RANGE).then(|| {
                format!(
                    "{} went {:.1} {unit} past the end of its range at {when:.3} s: {stops}",
                    dof.name,
                    range * angle
                )
            });
            let speed = (over > SHARE * dof.velocity_limit).then(|| {
                let (reached, most) = (dof.velocity_limit + over, dof.velocity_limit);
                format!("{} moved at {reached:.3} {speed} at {fast:.3} s; its model allows {most} {speed}", dof.name)
            });
            let effort = (driven > SHARE * dof.effort_limit).then(|| {
                let (reached, most) = (dof.effort_limit + driven, dof.effort_limit);
                format!(
                    "{} was driven with {reached:.3} {effort} at {hard:.3} s; its model allows {most} {effort}",
                    dof.name
                )
            });
            [range, speed, effort].into_iter().flatten()
        };
        // What a base has is where its start is looked for, and no limit.
        let joints = model.dofs.iter().zip(&self.0).filter(|(dof, _)| !dof.name.starts_with("base_"));
        joints.flat_map(of).collect()
    }
}

fn enter(worst: &mut (f64, f64), past: f64, time: f64) {
    if past > worst.0 {
        *worst = (past, time);
    }
}
