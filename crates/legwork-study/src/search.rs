//! The search for a limit: how far a value can go from where the robot copes until it no longer does.
//!
//! What a robot survives is no interval: beyond its first fall there are islands where it gets by with luck, and one
//! value that held says little of its neighbours. A limit is therefore the last value before the *first* failure, and it
//! is confirmed: neighbours on the safe side hold too, and so do all of these under small changes of something else.
//! docs/limits.md has the rule with its reasons.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::parallel::run_all;

/// Steps that a range is divided into where nobody says how many.
const STEPS: f64 = 200.0;

/// How far apart the neighbours of a limit are that must hold as well, as a share of it.
const NEIGHBOUR: f64 = 0.01;

/// A search from one value to another on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Where the robot should cope.
    pub from: f64,
    /// Where it should no longer; above or below `from`.
    pub to: f64,
    /// Distance of the grid's values from each other, and so the resolution.
    pub resolution: f64,
    /// Parts of the range whose ends are tried first.
    pub parts: u32,
    /// The most steps of the grid between two values that are tried from the start up to the limit: a hole that is
    /// narrower may go unseen.
    pub gap: u32,
    /// Neighbours on the safe side, spaced by a hundredth of the value, that must hold too.
    pub neighbours: u32,
    /// Changes of something else under which a value must hold to be confirmed.
    pub nudges: u32,
}

/// What came of a try.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attempt {
    /// Why the value did not hold; none where it did.
    pub failure: Option<String>,
    /// Bounds of the simulator's audit that its rollout broke, in words.
    pub violations: Option<String>,
    /// Largest force on a contact point [N].
    pub force_n: Option<f64>,
}

/// One value that was tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// The value.
    pub value: f64,
    /// Why it did not hold; none where it did.
    pub failure: Option<String>,
    /// Whether it was tried under the nudges too.
    pub nudged: bool,
    /// Bounds of the simulator's audit that a rollout of it broke, in words.
    pub violations: Option<String>,
    /// Largest force on a contact point [N].
    pub force_n: Option<f64>,
}

/// What a search found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// The limit: the last value that is confirmed before the first failure; none where the start fails.
    pub value: Option<f64>,
    /// The nearest value beyond that failed; none where all hold, so that the limit is at least the range's end.
    pub first_failure: Option<f64>,
    /// Why that one failed.
    pub reason_beyond: Option<String>,
    /// Bounds of the simulator's audit that were broken on the way from the start to the first failure, which all of the
    /// answer rests on: those of the value nearest to the limit; none where all rollouts kept them.
    pub violations: Option<String>,
    /// Largest force on a contact point of what held from the start to the limit [N].
    pub force_n: Option<f64>,
    /// The furthest value that held at all, perhaps on an island beyond the first failure.
    pub furthest_held: Option<f64>,
    /// How many rollouts it took.
    pub rollouts: usize,
    /// All values tried, from the start on.
    pub tried: Vec<Trial>,
}

impl Search {
    /// A thorough search under so many nudges; its resolution is a 1, 2 or 5 with zeros that makes at least 200 steps of
    /// the range.
    pub fn new(from: f64, to: f64, nudges: u32) -> Self {
        let resolution = one_two_five((to - from).abs() / STEPS);
        Self { from, to, resolution, parts: 24, gap: 2, neighbours: 4, nudges }
    }

    /// A search with half of the parts and neighbours, a fifth of the resolution, no gaps, and no nudges.
    pub fn quick(self) -> Self {
        Self {
            resolution: 5.0 * self.resolution,
            parts: self.parts.div_ceil(2),
            gap: 1,
            neighbours: self.neighbours / 2,
            nudges: 0,
            ..self
        }
    }

    /// The number of the grid's last value.
    fn last(&self) -> u32 {
        ((self.to - self.from).abs() / self.resolution).round().max(1.0) as u32
    }

    /// The grid's value, without the last digits that adding leaves.
    fn value(&self, step: u32) -> f64 {
        match step {
            0 => self.from,
            step if step == self.last() => self.to,
            step => ((self.from + f64::from(step) * self.resolution.copysign(self.to - self.from)) * 1e9).round() / 1e9,
        }
    }

    /// The neighbours of a step, and the step itself, as far as they are in the range.
    fn with_neighbours(&self, step: u32) -> impl Iterator<Item = u32> {
        let spacing = (NEIGHBOUR * self.value(step).abs() / self.resolution).round().max(1.0) as u32;
        (0..=self.neighbours).map_while(move |number| step.checked_sub(number * spacing))
    }

    /// Searches: a scan of the range; bisection between the first value that fails and the one before it; confirmation by
    /// the neighbours; a sweep of the way there. Where something fails, it goes on with bisection before that.
    ///
    /// `attempt` tries a value, under no nudge (0) or one of them (1 and up). It must give the same again. None where an
    /// attempt gave none, as one that was stopped does.
    pub fn run(&self, attempt: impl Fn(f64, u32) -> Option<Attempt> + Sync) -> Option<Found> {
        let (mut tried, mut rollouts) = (Tried::new(), 0);
        let parts = u64::from(self.parts.max(1));
        let mut scan: Vec<u32> = (0..=parts).map(|part| (u64::from(self.last()) * part / parts) as u32).collect();
        scan.dedup();
        let mut next = Some((scan, false));
        while let Some((steps, nudged)) = next {
            let each = if nudged { self.nudges as usize + 1 } else { 1 };
            rollouts += steps.len() * each;
            let outcomes =
                run_all(steps.len() * each, |job| attempt(self.value(steps[job / each]), (job % each) as u32))?;
            for (&step, outcomes) in steps.iter().zip(outcomes.chunks(each)) {
                let failure = outcomes.iter().find_map(|outcome| outcome.failure.clone());
                let violations = outcomes.iter().find_map(|outcome| outcome.violations.clone());
                let force_n = outcomes.iter().filter_map(|outcome| outcome.force_n).reduce(f64::max);
                tried.insert(step, Trial { value: self.value(step), failure, nudged, violations, force_n });
            }
            next = self.next(&tried);
        }
        Some(found(tried.into_values().collect(), rollouts))
    }

    /// What is to be tried next, and whether under the nudges too; none where the limit is confirmed.
    fn next(&self, tried: &Tried) -> Option<(Vec<u32>, bool)> {
        let fails = tried.iter().find(|(_, trial)| trial.failure.is_some()).map(|(&step, _)| step);
        let (&holds, _) = tried.range(..fails.unwrap_or(u32::MAX)).next_back()?;
        if let Some(fails) = fails.filter(|fails| fails - holds > 1) {
            return Some((vec![holds + (fails - holds) / 2], true));
        }
        let is_open = |step: &u32| !tried.get(step).is_some_and(|trial| trial.nudged);
        let open: Vec<u32> = self.with_neighbours(holds).filter(is_open).collect();
        if !open.is_empty() {
            return Some((open, true));
        }
        let (known, gap): (Vec<u32>, _) = (tried.range(..=holds).map(|(&step, _)| step).collect(), self.gap.max(1));
        let between = |pair: &[u32]| (pair[0] + gap..pair[1]).step_by(gap as usize);
        let sweep: Vec<u32> = known.windows(2).flat_map(between).collect();
        if sweep.is_empty() { None } else { Some((sweep, false)) }
    }
}

/// What was tried, by the number of its step.
type Tried = BTreeMap<u32, Trial>;

fn found(tried: Vec<Trial>, rollouts: usize) -> Found {
    let first = tried.iter().position(|trial| trial.failure.is_some());
    let value = first.unwrap_or(tried.len()).checked_sub(1).map(|last| tried[last].value);
    let beyond = first.map(|first| &tried[first]);
    let rests_on = &tried[..first.map_or(tried.len(), |first| first + 1)];
    Found {
        value,
        first_failure: beyond.map(|trial| trial.value),
        reason_beyond: beyond.and_then(|trial| trial.failure.clone()),
        violations: rests_on.iter().rev().find_map(|trial| trial.violations.clone()),
        force_n: tried[..first.unwrap_or(tried.len())].iter().filter_map(|trial| trial.force_n).reduce(f64::max),
        furthest_held: tried.iter().rfind(|trial| trial.failure.is_none()).map(|trial| trial.value),
        rollouts,
        tried,
    }
}

/// The largest 1, 2 or 5 with zeros that is not above `value`, which is positive.
fn one_two_five(value: f64) -> f64 {
    let scale = 10_f64.powi(libm::log10(value).floor() as i32);
    let digit = [5.0, 2.0].into_iter().find(|digit| digit * scale <= value * (1.0 + 1e-9)).unwrap_or(1.0);
    digit * scale
}
