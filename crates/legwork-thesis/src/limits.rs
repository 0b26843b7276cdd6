//! The thesis's limits (Chapters 6 and 7): how fast, with how little torque and force, how hard a push.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::case::{Case, Experiment, Gains, Reading};
use super::sweep::definition;
use super::trial::set;
use legwork::episode::Run;
use legwork::error::Error;
use legwork_study::Base;
use legwork_study::limits::{Answer, Held, Question, SPEED_SHARE};
use legwork_study::rollout::violations;
use legwork_study::search::Search;

/// A limit that is searched for.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sought {
    /// Its name.
    pub quantity: String,
    thesis: Option<f64>,
    remark: String,
    of: String,
    experiment: Experiment,
    gains: Gains,
    torque_nm: f64,
    #[serde(default)]
    sets: Vec<String>,
    /// The largest mean CoM error of a speed that is followed closely [m].
    follows: Option<f64>,
}

/// What is varied to find a limit, from one value to another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Varied {
    section: String,
    unit: String,
    path: String,
    range: [f64; 2],
    resolution: f64,
    /// The limit as a multiple of the value.
    #[serde(default = "one")]
    factor: f64,
}

fn one() -> f64 {
    1.0
}

/// A limit that is a figure of the final design's run.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OfRuns {
    quantity: String,
    section: String,
    thesis: f64,
    remark: String,
    experiment: Experiment,
    figure: String,
}

#[derive(Debug, Deserialize)]
struct Limits {
    varied: BTreeMap<String, Varied>,
    sought: Vec<Sought>,
    of_runs: Vec<OfRuns>,
}

static LIMITS: LazyLock<Limits> =
    LazyLock::new(|| toml::from_str(include_str!("limits.toml")).expect("the file of limits is ours"));

/// Largest push of the final design, in `limits.toml`.
pub const LARGEST_PUSH: &str = "largest push";
/// Largest push with re-planning in mid-swing, which is not the thesis's.
pub const LARGEST_PUSH_REPLAN: &str = "largest push, re-planned in mid-swing";
/// Intervals in which a search looks for a first failure.
const PARTS: u32 = 6;

/// All that are searched for.
pub fn sought() -> &'static [Sought] {
    &LIMITS.sought
}

/// A limit beside the thesis's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitRow {
    /// Its name.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where the thesis gives it.
    pub section: &'static str,
    /// What the thesis gives.
    pub thesis: Option<f64>,
    /// How it was measured.
    pub remark: &'static str,
    /// What was measured, a reading each.
    pub measured: Vec<Measured>,
}

/// A limit in a reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// The reading.
    pub reading: Reading,
    /// The limit: the last value before the first failure; none where already the start of the search fails.
    pub value: Option<f64>,
    /// The nearest value that failed.
    pub first_failure: Option<f64>,
    /// Why it failed.
    pub reason: Option<String>,
    /// The furthest value that held, perhaps beyond the first failure.
    pub furthest_held: Option<f64>,
    /// Bounds of the simulator's audit that a rollout which it rests on broke, in words.
    pub violations: Option<String>,
}

impl Sought {
    fn varied(&self) -> &'static Varied {
        &LIMITS.varied[&self.of]
    }

    /// Searches; none where `stop` says so before.
    ///
    /// # Errors
    /// A setting is not one of the scenario.
    pub fn search(&'static self, reading: Reading, stop: impl Fn() -> bool + Sync) -> Result<Option<Answer>, Error> {
        let (case, varied) = (Case::new(reading, self.experiment, self.gains), self.varied());
        let sets: Vec<String> =
            self.sets.iter().cloned().chain([set("controller.limits.torque_nm", self.torque_nm)]).collect();
        let base = Base::load(case.scenario(), &sets)?;
        let [from, to] = varied.range;
        let held = match (self.follows, self.of.as_str()) {
            (Some(error_m), _) => Held::Follows(error_m),
            (None, "speed") => Held::KeepsSpeed(SPEED_SHARE),
            (None, _) => Held::OnItsFeet,
        };
        let mut question = Question::new(&base, &self.quantity, (&varied.path, from, to), Vec::new(), held)?;
        let resolution = varied.resolution;
        question.search = Search { resolution, parts: PARTS, neighbours: 2, nudges: 0, ..question.search };
        (question.unit, question.factor) = (&varied.unit, varied.factor);
        Ok(question.answer(stop))
    }

    /// The row of its answers, which are in the order of [`Reading::ALL`].
    pub(crate) fn row(&'static self, answers: &[Answer]) -> LimitRow {
        let measured = Reading::ALL.iter().zip(answers).map(|(&reading, answer)| Measured {
            reading,
            value: answer.found.value,
            first_failure: answer.found.first_failure,
            reason: answer.found.reason_beyond.clone(),
            furthest_held: answer.found.furthest_held,
            violations: answer.found.violations.clone(),
        });
        let Varied { unit, section, .. } = self.varied();
        let (quantity, thesis, remark) = (&self.quantity, self.thesis, &self.remark);
        LimitRow { quantity, unit, section, thesis, remark, measured: measured.collect() }
    }
}

/// The rows that are figures of the final design's runs; `run` finds them.
pub(crate) fn of_runs<'a>(run: impl Fn(Case) -> &'a Run) -> Vec<LimitRow> {
    let row = |limit: &'static OfRuns| {
        let figure = definition(&limit.figure);
        let measured = |reading| {
            let run = run(Case::new(reading, limit.experiment, Gains::Final));
            let (value, violations) = (figure.of(&run.metrics), violations(run));
            Measured { reading, value, first_failure: None, reason: None, furthest_held: None, violations }
        };
        LimitRow {
            quantity: &limit.quantity,
            unit: figure.unit,
            section: &limit.section,
            thesis: Some(limit.thesis),
            remark: &limit.remark,
            measured: Reading::ALL.map(measured).into(),
        }
    };
    LIMITS.of_runs.iter().map(row).collect()
}
