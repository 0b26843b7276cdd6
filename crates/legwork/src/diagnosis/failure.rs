//! What went wrong: the first half of the rules.
//!
//! Each of four figures is followed back from the fall to the last time it was in order: the height of the centre of
//! mass, the lean of the torso, the path of the swinging foot, the reach of the XcoM. The one that left its order first
//! is what went wrong first.

use std::ops::Range;

use super::evidence::Evidence;
use super::reach::Steps;
use super::{Event, What};
use crate::momentum::tasks::{feet, momentum, torso};

// What is out of order. The built-in scenarios, which stand, reach 0.05 m, 15 deg and 0.06 m on point feet; with soles 0.1 m, and
// 29 deg after a push and uphill, from which they come back.

/// The centre of mass is this far below its reference [m].
const SUNK: f64 = 0.06;
/// The torso is this far from its reference [rad]: 25 deg.
const LEANT: f64 = 0.436;
/// A swinging foot is this far off its path [m].
pub(super) const ASTRAY: f64 = 0.1;
/// A figure begins to go wrong where it was last at this share of its bound.
const BEGINS: f64 = 0.2;
/// A window is at least this long [s]: a quarter of a step, so that a share in it means something.
const SHORTEST_WINDOW: f64 = 0.05;
/// An XcoM of the walker is not back in reach where it stays there for less than this [s].
const BRIEF: f64 = 0.15;
/// Where nothing was out of order before the fall, the window is this long [s].
const LAST_WINDOW: f64 = 0.3;

/// What went wrong first.
#[derive(Clone, Debug)]
pub(super) struct Failure {
    pub(super) kind: Kind,
    /// From the last tick in order to the first that is out of it.
    pub(super) window: Range<usize>,
    /// From the same tick to the end of the step or double support in which it went out of order.
    pub(super) growth: Range<usize>,
}

impl Failure {
    /// A failure that began in tick `begin` and was out of order in tick `out`.
    fn new(evidence: &Evidence<'_>, kind: Kind, begin: usize, out: usize) -> Self {
        let begin = begin.min(out.saturating_sub(evidence.ticks_in(SHORTEST_WINDOW)));
        Self { kind, window: begin..out + 1, growth: begin..evidence.stretch(out).ticks.end }
    }

    /// The task that should keep the figure in order.
    pub(super) fn task(&self) -> Option<&'static str> {
        match self.kind {
            Kind::Sinking => Some(momentum::NAME),
            Kind::Leaning => Some(torso::NAME),
            Kind::Astray(_) => Some(feet::NAME),
            Kind::OutOfReach | Kind::Sudden => None,
        }
    }

    /// What the task misses in tick `i` that should keep the figure in order: N, rad/s² or m/s².
    pub(super) fn missed(&self, evidence: &Evidence<'_>, i: usize) -> f64 {
        match self.kind {
            Kind::Sinking => evidence.missed_force(i),
            Kind::Leaning => evidence.missed_torso(i),
            Kind::Astray(foot) => evidence.missed_foot(i, foot),
            Kind::OutOfReach | Kind::Sudden => 1.0,
        }
    }

    /// Mean of a `figure` over the time in which the failure grew.
    pub(super) fn mean(&self, figure: impl Fn(usize) -> f64) -> f64 {
        self.growth.clone().map(figure).sum::<f64>() / self.growth.len() as f64
    }

    /// What a task misses at least, in the mean, where a limit or weights are to blame for it: N for a robot of that `weight` [N], rad/s²
    /// or m/s².
    pub(super) fn something(&self, weight: f64) -> f64 {
        match self.kind {
            Kind::Sinking => 1e-3 * weight,
            Kind::Leaning | Kind::Astray(_) => 0.1,
            Kind::OutOfReach | Kind::Sudden => 0.0,
        }
    }
}

/// Which figure it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The XcoM is beyond what steps can catch.
    OutOfReach,
    /// The centre of mass is too low.
    Sinking,
    /// The torso is too far from its reference.
    Leaning,
    /// This swinging foot is off its path.
    Astray(usize),
    /// Nothing was out of order until the fall.
    Sudden,
}

/// What went out of order for good, the first first; never empty.
pub(super) fn failures(evidence: &Evidence<'_>) -> Vec<Failure> {
    // A landing has the walker's bound jump.
    let brief = if matches!(evidence.steps, Steps::Walker(_)) { evidence.ticks_in(BRIEF) } else { 0 };
    let found = [
        failing(evidence, Kind::OutOfReach, 0.0, brief, |i| evidence.out_of_reach(i)),
        failing(evidence, Kind::Sinking, SUNK, 0, |i| evidence.sunk(i)),
        failing(evidence, Kind::Leaning, LEANT, 0, |i| evidence.lean(i).abs()),
        astray(evidence),
    ];
    let mut found: Vec<Failure> = found.into_iter().flatten().collect();
    found.sort_by_key(|failure| failure.window.end);
    if found.is_empty() {
        let last = evidence.log.len();
        found.push(Failure::new(evidence, Kind::Sudden, last.saturating_sub(evidence.ticks_in(LAST_WINDOW)), last - 1));
    }
    found
}

/// Where `figure` exceeded `bound` and never came back, or not for longer than `brief` ticks.
fn failing(
    evidence: &Evidence<'_>,
    kind: Kind,
    bound: f64,
    brief: usize,
    figure: impl Fn(usize) -> f64,
) -> Option<Failure> {
    let count = evidence.log.len();
    let mut out = count;
    for i in (0..count).rev() {
        if figure(i) > bound {
            out = i;
        } else if out - i > brief {
            break;
        }
    }
    if out == count {
        return None;
    }
    let begin = (0..out).rev().find(|&i| figure(i) <= BEGINS * bound).unwrap_or(0);
    Some(Failure::new(evidence, kind, begin, out))
}

/// Where the steps before the fall, each of them, began to lead astray.
fn astray(evidence: &Evidence<'_>) -> Option<Failure> {
    let mut found = None;
    let swings = evidence.stretches.iter().rev().filter_map(|stretch| Some((stretch.foot?, &stretch.ticks)));
    for (number, (foot, ticks)) in swings.enumerate() {
        match ticks.clone().find(|&i| evidence.foot_off(i, foot) > ASTRAY) {
            Some(out) => found = Some(Failure::new(evidence, Kind::Astray(foot), ticks.start, out)),
            None if number == 0 => {} // The step that the fall cut off.
            None => break,
        }
    }
    found
}

/// What the cause did, told at the end of the step or double support in which it went wrong.
pub(super) fn consequence(evidence: &Evidence<'_>, failure: &Failure) -> Option<Event> {
    let (end, stretch) = (failure.growth.end - 1, evidence.stretch(failure.growth.end - 1));
    let what = match failure.kind {
        Kind::Sinking => What::Sank { by: evidence.sunk(end), missed: failure.mean(|i| evidence.missed_force(i)) },
        Kind::Leaning => What::Leaned { by: evidence.lean(end), missed: failure.mean(|i| evidence.missed_torso(i)) },
        Kind::Astray(foot) => What::FootAstray {
            foot: evidence.foot_name(foot),
            short: evidence.short(stretch, foot),
            off: stretch.ticks.clone().map(|i| evidence.foot_off(i, foot)).fold(0.0, f64::max),
            missed: failure.mean(|i| evidence.missed_foot(i, foot)),
        },
        Kind::OutOfReach => {
            let out = failure.window.end - 1;
            let what = evidence.wanted(out)?.missed(None);
            return Some(Event { time: evidence.time(out), what });
        }
        Kind::Sudden => return None,
    };
    Some(Event { time: evidence.time(end), what })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::{self, Outcome, Run};
    use crate::generator::xcom;
    use crate::{library, scenario_file};

    fn run(name: &str, set: &[&str]) -> Run {
        let set: Vec<String> = set.iter().map(|&set| set.to_owned()).collect();
        let loaded = scenario_file::load(name, &set).expect("a built-in scenario");
        let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
        episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can start")
    }

    #[test]
    fn runs_that_stand_keep_all_figures_in_order() {
        for name in ["stand", "walk", "walk-support", "walk-slope", "push", "push-support", "waypoints"] {
            let run = run(name, &["duration_s=3"]);
            assert_eq!(run.outcome, Outcome::Completed);
            let evidence = Evidence::new(&run.scenario, &run.model, &run.log, (&run.tasks, &run.limits));
            let most = |figure: &dyn Fn(usize) -> f64| (0..run.log.len()).map(figure).fold(0.0, f64::max);
            let sunk = most(&|i| evidence.sunk(i));
            let lean = most(&|i| evidence.lean(i).abs());
            let off = most(&|i| evidence.stretch(i).foot.map_or(0.0, |foot| evidence.foot_off(i, foot)));
            assert!(sunk < 0.9 * SUNK && lean < 0.7 * LEANT && off < 0.7 * ASTRAY, "{name}: {sunk} {lean} {off}");
            let slid = evidence
                .stretches
                .iter()
                .flat_map(|stretch| (0..2).map(|foot| evidence.slide(stretch.ticks.clone(), foot)));
            let slid = slid.fold(0.0, f64::max);
            assert!(slid < 0.01, "{name}: {slid}");
            assert!(evidence.out_of_reach(run.log.len() - 1) < 0.0, "{name}");
        }
    }

    #[test]
    fn walkers_that_stand_keep_all_figures_in_order() {
        for name in ["feet-walk", "feet-slope", "stop-and-go", "stand-push", "walk-uneven", "push-walking"] {
            let run = run(name, &[]);
            assert_eq!(run.outcome, Outcome::Completed);
            let evidence = Evidence::new(&run.scenario, &run.model, &run.log, (&run.tasks, &run.limits));
            let most = |figure: &dyn Fn(usize) -> f64| (0..run.log.len()).map(figure).fold(f64::NEG_INFINITY, f64::max);
            let sunk = most(&|i| evidence.sunk(i));
            let lean = most(&|i| evidence.lean(i).abs());
            let off = most(&|i| evidence.stretch(i).foot.map_or(0.0, |foot| evidence.foot_off(i, foot)));
            let beyond = most(&|i| evidence.out_of_reach(i));
            assert!(sunk < 0.9 * SUNK && off < ASTRAY && beyond < 0.0, "{name}: {sunk} {off} {beyond}");
            // After the pushes of a walk and uphill the torso swings far, and comes back.
            let far = ["push-walking", "feet-slope"].contains(&name);
            assert!(lean < if far { 0.55 } else { 0.95 * LEANT }, "{name}: {lean}");
            assert!(evidence.lean(run.log.len() - 1).abs() < LEANT, "{name}");
        }
    }

    #[test]
    fn a_pushed_walker_falls_where_its_xcom_is_out_of_reach_and_not_where_it_is_so_for_moments_only() {
        let mut fallen = 0;
        for (force, start) in
            [(500, 5.0), (500, 5.3), (550, 5.0), (550, 5.15), (600, 5.0), (650, 5.4), (700, 5.0), (800, 5.1)]
        {
            let [force, start] = [format!("pushes.0.force_n={force}"), format!("pushes.0.start_s={start}")];
            let run = run("push-walking", &[&force, &start, "duration_s=7.5"]);
            let evidence = Evidence::new(&run.scenario, &run.model, &run.log, (&run.tasks, &run.limits));
            let out = (0..run.log.len()).filter(|&i| evidence.out_of_reach(i) > 0.0).count() as f64 * 1e-3;
            let fell = run.outcome != Outcome::Completed;
            assert!(if fell { out > 0.45 } else { out < 0.35 }, "{force} {start}: {out} s, {:?}", run.reason);
            fallen += usize::from(fell);
        }
        assert_eq!(fallen, 5);
    }

    #[test]
    fn the_reach_is_that_of_longest_steps_on_the_pendulum() {
        let run = run("stand", &["duration_s=0.01"]);
        let evidence = Evidence::new(&run.scenario, &run.model, &run.log, (&run.tasks, &run.limits));
        let step = &run.scenario.reference.step;
        let (past, apart) = evidence.past_front(step, 0);
        let bound = past - evidence.out_of_machine(step, 0);
        // By steps: XcoM past the front foot, feet apart; just below the bound it stays, just above it runs away.
        for (start, stays) in [(bound - 1e-3, true), (bound + 1e-3, false)] {
            let (mut past, mut apart) = (start, apart);
            for _ in 0..20 {
                past =
                    xcom::predicted_xcom(past, 0.0, evidence.omega(0), step.duration_s) - (step.max_length_m - apart);
                apart = step.max_length_m - apart;
            }
            assert_eq!(past < bound, stays, "{start}: {past}");
        }
    }
}
