//! The robustness map: the largest impulse that the robot survives, by direction and by the gait phase at which it
//! strikes.

use serde::Serialize;

use crate::limits::largest_force;
use crate::rollout::{self, Rollout};
use crate::search::{Attempt, Found, Search};
use crate::{Base, Variant};
use legwork::error::Error;
use legwork::log::{Field, Log};
use legwork::scenario::Push;

/// From when on the steps of a walk count as steady, at the earliest [s].
pub(crate) const STEADY_FROM_S: f64 = 3.0;

/// How long after that the stride is looked for [s].
const STRIDE_WITHIN_S: f64 = 5.0;

/// When the standing robot is struck [s].
const STANDING_STRIKE_S: f64 = 0.5;

/// What a map asks.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Directions of the push: 0 forward, 90 up, 180 backward [deg].
    pub directions_deg: Vec<f64>,
    /// Phases of the stride, from 0 on and below 1.
    pub phases: Vec<f64>,
    /// How long a push lasts [s].
    pub push_s: f64,
    /// How long the robot must be on its feet from the push's end on [s].
    pub after_s: f64,
    /// The search, in impulse per kilogram of the robot [Ns/kg].
    pub search: Search,
}

impl Plan {
    /// So many directions and phases, evenly spaced, with pushes of 0.2 s up to 5 Ns/kg.
    pub fn new(directions: usize, phases: usize) -> Self {
        let even = |count: usize, whole: f64| (0..count).map(|i| whole * i as f64 / count as f64).collect();
        let search = Search { resolution: 0.1, parts: 10, gap: 1, neighbours: 2, ..Search::new(0.0, 5.0, 0) };
        Self { directions_deg: even(directions, 360.0), phases: even(phases, 1.0), push_s: 0.2, after_s: 4.0, search }
    }
}

/// A stride in the steady walk: from a foot's step to its next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stride {
    /// When the step is triggered [s].
    pub start_s: f64,
    /// Until the same foot's next [s].
    pub period_s: f64,
}

/// A map to be made, cell by cell.
#[derive(Clone, Debug)]
pub struct Robustness {
    /// The stride whose phases are struck; none where the robot does not walk for long enough.
    pub stride: Option<Stride>,
    walk: Variant,
    stand: Variant,
    plan: Plan,
}

/// The answer for one direction and phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The scenario.
    pub scenario: String,
    /// Phase of the stride; none standing.
    pub phase: Option<f64>,
    /// Direction of the push: 0 forward, 90 up, 180 backward [deg].
    pub direction_deg: f64,
    /// When it strikes [s].
    pub start_s: f64,
    /// Impulses per kilogram [Ns/kg].
    #[serde(flatten)]
    pub found: Found,
}

impl Robustness {
    /// The map for `walk`, struck in its stride, and for `stand`, struck at rest: one that walks is commanded a speed of zero
    /// for it. Pushes of their own are left out.
    ///
    /// # Errors
    /// As [`rollout::simulate`].
    pub fn new(walk: &Base, stand: &Base, plan: Plan, stop: impl Fn() -> bool) -> Result<Self, Error> {
        let unpushed = |base: &Base| {
            let mut variant = base.variant().clone();
            variant.scenario.pushes.clear();
            variant
        };
        let mut reference = unpushed(walk);
        let commanded = reference.scenario.reference.commanded_speed();
        let steady_from = commanded.map_or(0.0, |commanded| commanded.steady_from_s).max(STEADY_FROM_S);
        // A robot that speeds up for longer than its scenario lasts has no steady stride.
        let longest = reference.scenario.duration_s.max(STEADY_FROM_S + STRIDE_WITHIN_S);
        reference.scenario.duration_s = longest.min(steady_from + STRIDE_WITHIN_S);
        let stride = stride(&rollout::simulate(&reference, stop)?.log, steady_from);
        let stand = match stand.variant().scenario.reference.commanded_speed() {
            Some(commanded) => unpushed(&stand.at_speed(commanded, 0.0)?),
            None => unpushed(stand),
        };
        Ok(Self { stride, walk: unpushed(walk), stand, plan })
    }

    /// How many cells it has: all directions standing, then those of one phase after the other.
    pub fn cells(&self) -> usize {
        self.plan.directions_deg.len() * (1 + if self.stride.is_some() { self.plan.phases.len() } else { 0 })
    }

    /// Searches for the answer of cell `index`; none where `stop` says so before. The same on any number of threads.
    pub fn answer(&self, index: usize, stop: impl Fn() -> bool + Sync) -> Option<Cell> {
        let directions = self.plan.directions_deg.len();
        let direction_deg = self.plan.directions_deg[index % directions];
        let phase = (index / directions).checked_sub(1).map(|row| self.plan.phases[row]);
        let (variant, start_s) = match (phase, self.stride) {
            (Some(phase), Some(stride)) => (&self.walk, stride.start_s + phase * stride.period_s),
            _ => (&self.stand, STANDING_STRIKE_S),
        };
        let found = self.plan.search.run(|impulse, _nudge| {
            let rollout = rollout::run(&self.struck(variant, impulse, direction_deg, start_s), &stop)?;
            let failure = (!rollout.survived()).then(|| reason(&rollout));
            Some(Attempt { failure, force_n: largest_force(&rollout), violations: rollout.violations })
        })?;
        Some(Cell { scenario: variant.scenario.name.clone(), phase, direction_deg, start_s, found })
    }

    /// What is run for one try.
    pub fn struck(&self, variant: &Variant, impulse_nspkg: f64, direction_deg: f64, start_s: f64) -> Variant {
        let (mut struck, push_s) = (variant.clone(), self.plan.push_s);
        let force_n = impulse_nspkg * variant.model.total_mass() / push_s;
        struck.scenario.pushes = vec![Push { force_n, direction_deg, start_s, duration_s: push_s, ..Push::default() }];
        struck.scenario.duration_s = start_s + push_s + self.plan.after_s;
        struck
    }
}

fn reason(rollout: &Rollout) -> String {
    rollout.reason.clone().unwrap_or_else(|| rollout.ending.name().to_owned())
}

/// The first stride that begins at `from` [s] or later and ends in the log.
pub fn stride(log: &Log, from: f64) -> Option<Stride> {
    let mut begun: Option<(f64, f64)> = None;
    let mut before = -1.0;
    for index in 0..log.len() {
        let [foot, since] = log.get(index, Field::Swing) else { return None };
        if *since > before {
            before = *since;
            match begun {
                Some((first, start_s)) if first == *foot => return Some(Stride { start_s, period_s: since - start_s }),
                None if *since >= from => begun = Some((*foot, *since)),
                _ => {}
            }
        }
    }
    None
}
