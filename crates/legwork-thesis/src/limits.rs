//! The thesis's limits (Chapters 6 and 7): how fast, with how little torque and force, how hard a push.

use serde::Serialize;

use super::case::{Case, Experiment, Gains, Reading};
use super::trial::{REPLAN, torque_limit};
use legwork::episode::Run;
use legwork::error::Error;
use legwork_study::limits::{Answer, Held, Question, SPEED_SHARE};
use legwork_study::search::Search;
use legwork_study::{Base, Change};

/// A limit that is searched for.
#[derive(Clone, Debug)]
pub struct Sought {
    /// Its name.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where the thesis gives it.
    pub section: &'static str,
    /// What the thesis gives.
    pub thesis: Option<f64>,
    /// What is said of it beside the figures.
    pub remark: &'static str,
    experiment: Experiment,
    gains: Gains,
    sets: &'static [&'static str],
    torque_nm: f64,
    path: &'static str,
    range: [f64; 2],
    resolution: f64,
    parts: u32,
    held: Held,
    factor: f64,
}

/// Top speed at the final design's torque limit.
pub const TOP_SPEED_220: &str = "top speed at 220 Nm";
/// Top speed with more torque.
pub const TOP_SPEED_300: &str = "top speed at 300 Nm";
/// Top speed that is followed closely, at the final design's torque limit.
pub const FOLLOWED_220: &str = "top speed followed, 220 Nm";
/// The same with more torque.
pub const FOLLOWED_300: &str = "top speed followed, 300 Nm";
/// Lowest torque limit of the baseline's walk.
pub const TORQUE_WALK: &str = "lowest torque limit, walk";
/// Lowest torque limit of the baseline's push.
pub const TORQUE_PUSH: &str = "lowest torque limit, push";
/// Lowest force limit of the baseline's walk.
pub const FORCE_WALK: &str = "lowest force limit, walk";
/// Lowest force limit of the baseline's push.
pub const FORCE_PUSH: &str = "lowest force limit, push";
/// Largest push of the final design.
pub const LARGEST_PUSH: &str = "largest push";
/// Largest push with re-planning in mid-swing, which is not the thesis's.
pub const LARGEST_PUSH_REPLAN: &str = "largest push, re-planned in mid-swing";

const SPEED: Sought = Sought {
    quantity: TOP_SPEED_220,
    unit: "m/s",
    section: "7.1.3",
    thesis: Some(0.60),
    remark: "mean speed within 5 % of the one asked for, from 0.5 m/s up; the final design",
    experiment: Experiment::Walk,
    gains: Gains::Final,
    sets: &[],
    torque_nm: 220.0,
    path: "reference.com.speed_mps",
    range: [0.5, 2.0],
    resolution: 0.025,
    parts: 6,
    held: Held::KeepsSpeed(SPEED_SHARE),
    factor: 1.0,
};
const TORQUE: Sought = Sought {
    quantity: TORQUE_WALK,
    unit: "Nm",
    section: "6.1",
    thesis: Some(200.0),
    remark: "on its feet to the end, from 500 Nm down; the baseline",
    gains: Gains::Baseline,
    torque_nm: 500.0,
    path: "controller.limits.torque_nm",
    range: [500.0, 100.0],
    resolution: 5.0,
    parts: 6,
    held: Held::OnItsFeet,
    ..SPEED
};
const FORCE: Sought = Sought {
    quantity: FORCE_WALK,
    unit: "N",
    section: "6.3.1",
    thesis: None,
    remark: "on its feet to the end, from 1000 N down; the baseline at 220 Nm",
    torque_nm: 220.0,
    path: "controller.limits.grf_n",
    range: [1000.0, 300.0],
    resolution: 10.0,
    parts: 6,
    ..TORQUE
};
const PUSH: Sought = Sought {
    quantity: LARGEST_PUSH,
    unit: "Ns",
    section: "7.1.4",
    thesis: Some(140.0),
    remark: "on its feet to the end, a push of 0.2 s forward, from none up; the final design",
    experiment: Experiment::Push,
    gains: Gains::Final,
    path: "pushes.0.force_n",
    range: [0.0, 1400.0],
    resolution: 10.0,
    parts: 6,
    factor: 0.2,
    ..FORCE
};

const FOLLOWED: Sought = Sought {
    quantity: FOLLOWED_220,
    remark: "mean CoM error at most 0.05 m, from 0.5 m/s up; the final design",
    held: Held::Follows(0.05),
    ..SPEED
};

/// All that are searched for.
pub const SOUGHT: [Sought; 10] = [
    SPEED,
    Sought { quantity: TOP_SPEED_300, thesis: Some(1.25), torque_nm: 300.0, ..SPEED },
    FOLLOWED,
    Sought { quantity: FOLLOWED_300, thesis: Some(1.25), torque_nm: 300.0, ..FOLLOWED },
    TORQUE,
    Sought { quantity: TORQUE_PUSH, experiment: Experiment::Push, ..TORQUE },
    FORCE,
    Sought { quantity: FORCE_PUSH, thesis: Some(750.0), experiment: Experiment::Push, ..FORCE },
    PUSH,
    Sought {
        quantity: LARGEST_PUSH_REPLAN,
        thesis: None,
        remark: "as the largest push, the step length planned again while the foot swings; not in the thesis",
        sets: &[REPLAN],
        ..PUSH
    },
];

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
}

impl Sought {
    /// Searches; none where `stop` says so before.
    ///
    /// # Errors
    /// A setting is not one of the scenario.
    pub fn search(&self, reading: Reading, stop: impl Fn() -> bool + Sync) -> Result<Option<Answer>, Error> {
        let case = Case::new(reading, self.experiment, self.gains);
        let mut sets: Vec<String> = self.sets.iter().map(|&set| set.to_owned()).collect();
        sets.push(torque_limit(self.torque_nm));
        let base = Base::load(case.scenario(), &sets)?;
        let [from, to] = self.range;
        let fixed: Vec<(&'static str, Change)> = Vec::new();
        let mut question = Question::new(&base, self.quantity, (self.path, from, to), fixed, self.held)?;
        question.search =
            Search { resolution: self.resolution, parts: self.parts, neighbours: 2, nudges: 0, ..question.search };
        (question.unit, question.factor) = (self.unit, self.factor);
        Ok(question.answer(stop))
    }

    /// The row of its answers, which are in the order of [`Reading::ALL`].
    pub fn row(&self, answers: &[Answer]) -> LimitRow {
        let measured = Reading::ALL.iter().zip(answers).map(|(&reading, answer)| Measured {
            reading,
            value: answer.found.value,
            first_failure: answer.found.first_failure,
            reason: answer.found.reason_beyond.clone(),
            furthest_held: answer.found.furthest_held,
        });
        LimitRow {
            quantity: self.quantity,
            unit: self.unit,
            section: self.section,
            thesis: self.thesis,
            remark: self.remark,
            measured: measured.collect(),
        }
    }
}

/// The rows that are figures of the final design's runs; `run` finds them.
pub fn of_runs<'a>(run: impl Fn(Case) -> &'a Run) -> Vec<LimitRow> {
    type Figure = fn(&Run) -> Option<f64>;
    let rows: [(_, _, _, _, _, _, Figure); 4] = [
        (
            "recovery time",
            "s",
            "7.1.4",
            4.2,
            "from the push's beginning until the CoM error stays below 0.05 m",
            Experiment::Push,
            |run| run.metrics.recovery_time_s,
        ),
        (
            "recovery distance",
            "m",
            "7.1.4",
            0.85,
            "largest horizontal CoM error after the push",
            Experiment::Push,
            |run| run.metrics.recovery_distance_m,
        ),
        (
            "single support",
            "",
            "7.2.1",
            0.35,
            "share of the ticks from a step's trigger to its touchdown",
            Experiment::Walk,
            |run| Some(run.metrics.single_support_fraction),
        ),
        ("speed of the walk", "m/s", "7.1.3", 0.5, "displacement of the CoM over the time", Experiment::Walk, |run| {
            Some(run.metrics.mean_speed_mps)
        }),
    ];
    let row = |(quantity, unit, section, thesis, remark, experiment, figure): (_, _, _, _, _, _, Figure)| {
        let measured = |reading| {
            let value = figure(run(Case::new(reading, experiment, Gains::Final)));
            Measured { reading, value, first_failure: None, reason: None, furthest_held: None }
        };
        let measured = Reading::ALL.map(measured).to_vec();
        LimitRow { quantity, unit, section, thesis: Some(thesis), remark, measured }
    };
    rows.map(row).to_vec()
}
