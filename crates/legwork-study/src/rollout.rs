//! One rollout of a study: what it gave, as a row of a table.

use std::panic::{AssertUnwindSafe, catch_unwind};

use serde::{Deserialize, Serialize};

use crate::Variant;
use legwork::clock;
use legwork::episode::{self, Outcome, Parts, Run};
use legwork::error::Error;
use legwork::metrics::{FIGURES, JOINT_METRICS, Metrics};

/// What is said of rollouts with [`Rollout::violations`].
pub const DOUBTFUL: &str = "broke bounds of the simulation";

/// The same as the end of a warning.
pub const DOUBT: &str = "broke bounds of the simulation; the column violations says which";

/// How a rollout ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// It lasted its full time.
    Completed,
    /// It lasted its full time, with a force on a contact point that injures ([`Run::injurious_force_n`]).
    Injurious,
    /// The robot fell.
    Fell,
    /// This combination of values cannot be run, say because no start pose exists; see the reason.
    Invalid,
    /// The program itself failed; see the reason.
    Failed,
}

impl Ending {
    /// Whether the robot was on its feet to the end.
    pub fn stood(self) -> bool {
        matches!(self, Self::Completed | Self::Injurious)
    }

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Injurious => "injurious",
            Self::Fell => "fell",
            Self::Invalid => "invalid",
            Self::Failed => "failed",
        }
    }
}

/// What a run gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rollout {
    /// How it ended.
    pub ending: Ending,
    /// When the robot fell [s].
    pub fell_at_s: Option<f64>,
    /// The first cause of the fall, as [`legwork::diagnosis`] names it.
    pub cause: Option<String>,
    /// Why it fell or could not be run, in a sentence.
    pub reason: Option<String>,
    /// Bounds of the simulator's audit that the run broke, in words; nothing where it kept them.
    pub violations: Option<String>,
    /// The figures in the order of [`columns`]; empty where it could not be run.
    pub figures: Vec<Option<f64>>,
    /// Hash of all that went in, in hexadecimal digits.
    pub input_hash: String,
    /// Hash of the log, in hexadecimal digits.
    pub result_hash: String,
}

impl Rollout {
    /// Whether the robot was on its feet to the end.
    pub fn survived(&self) -> bool {
        self.ending.stood()
    }

    /// What could not be run, and why.
    pub fn invalid(reason: String) -> Self {
        Self::without_figures(Ending::Invalid, reason)
    }

    fn without_figures(ending: Ending, reason: String) -> Self {
        let (input_hash, result_hash) = (String::new(), String::new());
        Self {
            ending,
            fell_at_s: None,
            cause: None,
            reason: Some(reason),
            violations: None,
            figures: Vec::new(),
            input_hash,
            result_hash,
        }
    }

    /// What is kept of a run.
    pub fn of(run: &Run) -> Self {
        let (ending, fell_at_s) = match &run.outcome {
            Outcome::Fell(fall) => (Ending::Fell, Some(fall.time)),
            _ if run.injurious_force_n().is_some() => (Ending::Injurious, None),
            Outcome::Completed | Outcome::Stopped => (Ending::Completed, None),
        };
        Self {
            ending,
            fell_at_s,
            cause: run.diagnosis.as_ref().map(|diagnosis| diagnosis.cause.label().to_owned()),
            reason: run.reason.clone(),
            violations: violations(run),
            figures: figures(&run.metrics),
            input_hash: format!("{:032x}", run.input_hash),
            result_hash: format!("{:032x}", run.result_hash),
        }
    }
}

/// Bounds of the simulator's audit that `run` broke, in words; nothing where it kept them.
pub fn violations(run: &Run) -> Option<String> {
    Some(run.violations().join("; ")).filter(|text| !text.is_empty())
}

/// Runs `variant`; none where `stop` says so before its end. What goes wrong is a result.
pub fn run(variant: &Variant, stop: impl Fn() -> bool) -> Option<Rollout> {
    let tried = catch_unwind(AssertUnwindSafe(|| simulate(variant, &stop)));
    match tried {
        Ok(Ok(run)) if matches!(run.outcome, Outcome::Stopped) => None,
        Ok(Ok(run)) => Some(Rollout::of(&run)),
        Ok(Err(error)) => Some(Rollout::invalid(error.to_string())),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            let reason = format!("a defect of the program: {}", text.unwrap_or("without words"));
            Some(Rollout::without_figures(Ending::Failed, reason))
        }
    }
}

/// The whole run of `variant`, log and all.
///
/// # Errors
/// As [`episode::run`].
pub fn simulate(variant: &Variant, stop: impl Fn() -> bool) -> Result<Run, Error> {
    let parts = Parts { samples: variant.samples.clone(), clock: Some(clock::system), ..Parts::default() };
    episode::run_with(&variant.scenario, &variant.model, parts, |_time| stop())
}

/// The figures of a run in the order of [`columns`].
pub fn figures(metrics: &Metrics) -> Vec<Option<f64>> {
    let joints = metrics.joints.iter().flat_map(|joint| JOINT_METRICS.iter().map(|metric| metric.of(joint)[0]));
    let figures = FIGURES.iter().map(|figure| figure.of(metrics)).chain(joints);
    figures.map(|value| value.filter(|v| v.is_finite())).collect()
}

/// A column of a table of rollouts: `com_error_m.mean`, `joint.right_hip.torque_peak_nm`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// It in words.
    pub label: String,
    /// Its unit, or nothing.
    pub unit: &'static str,
}

/// The columns of a rollout's figures; `joints` are the names of the actuated joints.
pub fn columns<'a>(joints: impl IntoIterator<Item = &'a str>) -> Vec<Column> {
    let of_run = FIGURES.iter().map(|figure| Column {
        name: figure.name.clone(),
        label: figure.label.clone(),
        unit: figure.unit,
    });
    let of_joints = joints.into_iter().flat_map(|joint| {
        JOINT_METRICS.iter().map(move |metric| Column {
            name: format!("joint.{joint}.{}", metric.name),
            label: format!("{}, {}", metric.label, joint.replace('_', " ")),
            unit: metric.unit,
        })
    });
    of_run.chain(of_joints).collect()
}
