//! The states of a finished run, given once more to a controller with other settings: what would it have done there?
//!
//! The loop stays open, so states and references are those of the finished run (the step state machine and the
//! trajectory see nothing but the state), and what differs is the program's doing.

use legwork_rbd::Dynamics;
use serde::Serialize;

use super::statistics::root_mean_square;
use legwork::control::{Controller, Fallback};
use legwork::episode::Run;
use legwork::error::Error;
use legwork::log::Field;
use legwork::momentum::tasks::{feet, momentum};
use legwork_study::{Base, Variant};

/// What a program did with the states and references of another run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Replay {
    /// The scenario whose run is replayed.
    pub scenario: String,
    /// The settings that differ.
    pub sets: Vec<String>,
    /// Ticks.
    pub ticks: usize,
    /// Vertical force that the momentum task misses, mean over the ticks, as a share of the robot's weight; positive
    /// where the program carries too little.
    pub weight_missed_fraction: f64,
    /// The miss of the linear momentum task, root mean square, as a share of the robot's weight.
    pub momentum_missed_fraction: f64,
    /// The miss of the swing foot's acceleration, root mean square over the swings, as a share of that of what is
    /// asked.
    pub swing_foot_missed_fraction: f64,
    /// The same of feet that stand, in m/s².
    pub stance_foot_missed_mps2: f64,
    /// Largest difference of a torque to the finished run's [Nm].
    pub torque_difference_nm: f64,
    /// Ticks that ended with a fallback.
    pub fallbacks: usize,
}

/// Replays `run`, a run of the built-in `scenario`, with the settings `sets`.
///
/// # Errors
/// A setting is not valid.
pub(crate) fn replay(run: &Run, sets: &[String]) -> Result<Replay, Error> {
    let name = run.scenario.name.clone();
    let Variant { scenario, model, samples } = Base::load(&name, sets)?.variant().clone();
    let mut controller = scenario.momentum_controller(&model, &samples, &run.log.truth(0))?;
    let mut dynamics = Dynamics::new(&model);
    let weight = model.total_mass() * model.gravity;
    let (angular, dimension) = (model.angular_axes().len(), model.linear_axes().len());
    let (mut vertical, mut linear, mut swing, mut asked, mut stance) = (0.0, vec![], vec![], vec![], vec![]);
    let (mut torque_difference_nm, mut fallbacks) = (0.0_f64, 0);
    for index in 0..run.log.len() {
        let estimate = run.log.truth(index);
        dynamics.update(&model, &estimate.q, &estimate.v);
        controller.tick(&estimate, &dynamics);
        let (tick, goal) = (controller.latest(), controller.planner().goal(feet::NAME));
        let [momentum, feet] = [momentum::NAME, feet::NAME].map(|task| controller.slack(task));
        vertical += momentum[angular + dimension - 1];
        linear.extend_from_slice(&momentum[angular..]);
        for foot in 0..model.feet.len() {
            let rows = controller.feet().rows(foot).linear.clone();
            if controller.reference().and_then(|reference| reference.swing).is_some_and(|swing| swing.foot == foot) {
                swing.extend_from_slice(&feet[rows.clone()]);
                asked.extend_from_slice(&goal[rows]);
            } else {
                stance.extend_from_slice(&feet[rows]);
            }
        }
        let torques = tick.solution.tau.iter().zip(run.log.get(index, Field::Torque));
        torque_difference_nm = torques.map(|(a, b)| (a - b).abs()).fold(torque_difference_nm, f64::max);
        fallbacks += usize::from(tick.program.fallback != Fallback::None);
    }
    // The norm of the vectors, not of their components.
    let norm = |values: &[f64]| root_mean_square(values.iter().copied()) * (dimension as f64).sqrt();
    let asked = norm(&asked);
    Ok(Replay {
        scenario: name,
        sets: sets.to_vec(),
        ticks: run.log.len(),
        weight_missed_fraction: vertical / run.log.len() as f64 / weight,
        momentum_missed_fraction: norm(&linear) / weight,
        swing_foot_missed_fraction: if asked > 0.0 { norm(&swing) / asked } else { 0.0 },
        stance_foot_missed_mps2: norm(&stance),
        torque_difference_nm,
        fallbacks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::Trial;

    #[test]
    fn the_same_settings_give_the_same_torques_and_others_do_not() {
        let trial = Trial { scenario: "walk".into(), sets: Vec::new() };
        let run = trial.run(|| false).expect("it is built in");
        let same = replay(&run, &[]).expect("no setting");
        assert_eq!((same.torque_difference_nm, same.fallbacks, same.ticks), (0.0, 0, run.log.len()));
        // The slack is that of the log as well.
        let column = run.log.range(Field::Slack).start + 2;
        let vertical = run.log.column(column).sum::<f64>() / run.log.len() as f64;
        let weight = run.model.total_mass() * run.model.gravity;
        assert!((same.weight_missed_fraction - vertical / weight).abs() < 1e-12);
        let heavy = replay(&run, &["controller.weights.grf=10".to_owned()]).expect("it is a setting");
        assert!(heavy.torque_difference_nm > 10.0 && heavy.weight_missed_fraction > 0.1, "{heavy:?}");
    }
}
