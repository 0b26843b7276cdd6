//! The runs beside the sweeps: variants of the eight cases, for the claims and the open questions.

use serde::Serialize;

use super::case::{Case, Gains};
use super::claims;
use super::sweep::figure;
use legwork::control::Fallback;
use legwork::episode::Run;
use legwork::error::Error;
use legwork::log::{Channel, Field};
use legwork::momentum::{Condition, LimitKind};
use legwork_study::Rollout;
use legwork_study::rollout::simulate;
use legwork_study::{Base, Variant};

/// A scenario with settings as `--set` takes them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Trial {
    /// The built-in scenario.
    pub scenario: String,
    /// Its settings, as `controller.limits.torque_nm=500`.
    pub sets: Vec<String>,
}

/// A trial and what it gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialResult {
    /// What was run.
    #[serde(flatten)]
    pub trial: Trial,
    /// What it gave.
    pub rollout: Rollout,
    /// How its programs went.
    pub program: ProgramReport,
}

/// How the programs of a run went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProgramReport {
    /// Ticks.
    pub ticks: usize,
    /// Ticks whose program had no solution as it stood.
    pub infeasible: u64,
    /// The first of them [s].
    pub first_infeasible_s: Option<f64>,
    /// What contradicted each other there.
    pub conflict: Vec<String>,
    /// What the limits among that limit, as in `torque`.
    #[serde(skip)]
    pub limited: Vec<&'static str>,
    /// How long after the trigger of a step that was [s]; none in double support.
    pub since_trigger_s: Option<f64>,
    /// Linear momentum rate that was missed in the first tenth of steps [N], on the mean; none without a step.
    pub missed_at_start_n: Option<f64>,
    /// Ticks in which hard tasks became costs.
    pub tasks_yielded: usize,
    /// Ticks that had no solution at all.
    pub torque_held: usize,
}

/// What hard feet tracking is tried with: torque limit [Nm], and step time [s] where it is not the scenario's own.
pub(crate) const HARD_FEET_WITH: [(f64, Option<f64>); 3] = [(220.0, None), (500.0, None), (220.0, Some(0.20))];
/// Feet weights that are combined with foot gains (6.4).
pub(crate) const STACKED_WEIGHTS: [f64; 3] = [1e5, 1e6, 1e7];
/// Foot gains that they are combined with.
pub(crate) const STACKED_GAINS: [f64; 3] = [1000.0, 2000.0, 6000.0];
/// Momentum weights below those of the sweep, down to where the operating costs outweigh them.
pub const LOW_MOMENTUM: [f64; 2] = [1e-4, 1e-5];
/// Weights of forces and of joint accelerations: below those at which the baseline falls, and such.
pub(crate) const HIGH_WEIGHTS: [(&str, [f64; 2]); 2] =
    [("controller.weights.grf", [1.0, 10.0]), ("controller.weights.joint_acceleration", [1e3, 1e4])];
/// Step times that these are tried with [s].
pub(crate) const STEP_TIMES: [f64; 2] = [0.30, 0.35];
/// Re-planning of the step length in mid-swing.
pub(crate) const REPLAN: &str = "reference.step.replan=in-swing";
/// Critical damping as it is meant.
pub(crate) const CRITICAL: &str = "controller.planner.damping=critical";

/// A setting of a number, as [`Trial::sets`] has it.
pub fn set(path: &str, value: f64) -> String {
    format!("{path}={value}")
}

/// The step time as a setting.
pub(crate) fn step_time(duration_s: f64) -> String {
    set("reference.step.duration_s", duration_s)
}

/// Hard feet tracking as settings.
pub(crate) fn hard_feet((torque_nm, step_s): (f64, Option<f64>)) -> Vec<String> {
    let sets = ["controller.tracking.feet=equality".to_owned(), set("controller.limits.torque_nm", torque_nm)];
    sets.into_iter().chain(step_s.map(step_time)).collect()
}

/// Feet weight and foot gain as settings.
pub(crate) fn stacked(weight: f64, gain: f64) -> Vec<String> {
    vec![set("controller.weights.feet", weight), set("controller.planner.foot_gain", gain)]
}

/// All of them.
pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for case in Case::all() {
        let mut add = |sets: Vec<String>| trials.push(Trial::of_case(case, sets));
        HARD_FEET_WITH.iter().for_each(|&with| add(hard_feet(with)));
        add(vec![REPLAN.to_owned()]);
        add(vec![CRITICAL.to_owned()]);
        if case.gains == Gains::Baseline {
            for weight in STACKED_WEIGHTS {
                STACKED_GAINS.iter().for_each(|&gain| add(stacked(weight, gain)));
            }
            STEP_TIMES.iter().for_each(|&duration| add(vec![step_time(duration)]));
            LOW_MOMENTUM.iter().for_each(|&value| add(vec![set("controller.weights.momentum", value)]));
            for (path, [_, highest]) in HIGH_WEIGHTS {
                add(vec![set(path, highest)]);
                STEP_TIMES.iter().for_each(|&duration| add(vec![set(path, highest), step_time(duration)]));
            }
        }
    }
    trials.extend(claims::trials());
    trials
}

impl Trial {
    /// A case with settings.
    pub(crate) fn of_case(case: Case, sets: Vec<String>) -> Self {
        Self { scenario: case.scenario().to_owned(), sets }
    }

    /// What is run.
    ///
    /// # Errors
    /// A setting is not one of the scenario.
    pub(crate) fn variant(&self) -> Result<Variant, Error> {
        Ok(Base::load(&self.scenario, &self.sets)?.variant().clone())
    }

    /// Runs it.
    ///
    /// # Errors
    /// As `Trial::variant`.
    pub fn run(&self, stop: impl Fn() -> bool) -> Result<Run, Error> {
        simulate(&self.variant()?, stop)
    }

    /// The command that runs it alone.
    pub fn command(&self) -> String {
        let sets: String = self.sets.iter().map(|set| format!(" --set {set}")).collect();
        format!("legwork run {}{sets}", self.scenario)
    }
}

impl TrialResult {
    /// What a run of `trial` gave.
    pub(crate) fn of(trial: Trial, run: &Run) -> Self {
        Self { trial, rollout: Rollout::of(run), program: ProgramReport::of(run) }
    }

    /// A figure of it, where the robot stands to the end.
    pub(crate) fn standing(&self, name: &str) -> Option<f64> {
        figure(&self.rollout, name).filter(|_| self.stands())
    }

    /// Whether the robot stands to the end.
    pub fn stands(&self) -> bool {
        self.rollout.survived()
    }
}

/// How far into a step its start reaches, as a share of the step time.
pub(crate) const START_OF_STEP: f64 = 0.1;

/// The linear momentum rate that the program missed at the start of steps [N], on the mean.
fn missed_at_start(run: &Run) -> Option<f64> {
    let is_momentum = |(_, channel): &(usize, &Channel)| channel.name.starts_with("slack.momentum.linear_");
    let columns: Vec<usize> = run.log.columns().iter().enumerate().filter(is_momentum).map(|(i, _)| i).collect();
    let start = START_OF_STEP * run.scenario.reference.step.duration_s;
    let starts = |&index: &usize| {
        let swing = run.log.get(index, Field::Swing);
        swing[0] >= 0.0 && run.log.time(index) - swing[1] <= start
    };
    let missed = |index: usize| columns.iter().map(|&i| run.log.record(index)[i].powi(2)).sum::<f64>().sqrt();
    let missed: Vec<f64> = (0..run.log.len()).filter(starts).map(missed).collect();
    (!missed.is_empty()).then(|| missed.iter().sum::<f64>() / missed.len() as f64)
}

impl ProgramReport {
    fn of(run: &Run) -> Self {
        let fallbacks = |which: Fallback| {
            let column = run.log.range(Field::Program).start + 1;
            run.log.column(column).filter(|&fallback| fallback == f64::from(which as u32)).count()
        };
        let (first_infeasible_s, conflict) = run.program.first_infeasible.clone().unzip();
        let conflict: Vec<Condition> = conflict.unwrap_or_default();
        let since = |time: f64| {
            let index = (0..run.log.len()).find(|&i| run.log.time(i) >= time)?;
            let swing = run.log.get(index, Field::Swing);
            (swing[0] >= 0.0).then(|| ((time - swing[1]) * 1e6).round() / 1e6)
        };
        Self {
            ticks: run.log.len(),
            infeasible: run.program.infeasible,
            first_infeasible_s,
            limited: conflict.iter().filter_map(Condition::limit).map(LimitKind::quantity).collect(),
            conflict: conflict.iter().map(|condition| condition.in_words(&run.model)).collect(),
            since_trigger_s: first_infeasible_s.and_then(since),
            missed_at_start_n: missed_at_start(run),
            tasks_yielded: fallbacks(Fallback::TasksYield),
            torque_held: fallbacks(Fallback::HoldTorque),
        }
    }
}
