//! Whether the instability at high operating weights comes from the program or from the references. (7.1.2)
//!
//! Two experiments. The program alone: the states and references of a healthy run of the baseline are given to a
//! program with a high weight, whose loop stays open. If it gives up a task there already, the program is at fault.
//! The references: longer step times ask for less acceleration. If the robot stands with these where it fell, the
//! references are.

use super::{Entry, Found, ending, range, replay_of, says};
use crate::case::{Case, Gains};
use crate::evidence::Evidence;
use crate::replay::Replay;
use crate::trial::{HIGH_WEIGHTS, STEP_TIMES, set, step_time};
use legwork::settings::Setting;

/// A task counts as given up where the program misses by so much more of it than with the baseline's weight on the same
/// states: as a share of the robot's weight, or of the swing foot's acceleration.
const GIVEN_UP: f64 = 0.10;

/// The baseline's weights and the raised ones as settings.
pub(super) fn weights() -> impl Iterator<Item = Vec<String>> {
    let raised = HIGH_WEIGHTS.into_iter().flat_map(|(path, values)| values.map(|value| vec![set(path, value)]));
    [Vec::new()].into_iter().chain(raised)
}

/// The baselines, of which those that stand are replayed.
pub(super) fn cases() -> impl Iterator<Item = Case> {
    Case::all().filter(|case| case.gains == Gains::Baseline)
}

pub(super) fn found(evidence: &Evidence, replays: &[Replay]) -> Found {
    let name = |sets: &[String]| Entry::from(sets.first().map_or("baseline".to_owned(), |set| named(set)));
    let (mut replayed, mut closed) = (Vec::new(), Vec::new());
    for case in cases() {
        for sets in weights() {
            let Some(r) = replay_of(replays, case.scenario(), &sets) else { continue };
            let missed = [r.weight_missed_fraction, r.momentum_missed_fraction, r.swing_foot_missed_fraction];
            let mut row = vec![case.scenario().into(), name(&sets)];
            row.extend(missed.into_iter().chain([r.stance_foot_missed_mps2]).map(Entry::from));
            replayed.push(row);
        }
        let highest = HIGH_WEIGHTS.map(|(path, [_, highest])| vec![set(path, highest)]);
        for own in [Vec::new()].into_iter().chain(highest) {
            let with = |duration| [own.clone(), vec![step_time(duration)]].concat();
            let mut row = vec![case.scenario().into(), name(&own), ending(evidence.trial(case, &own)).into()];
            row.extend(STEP_TIMES.map(|duration| Entry::from(ending(evidence.trial(case, &with(duration))))));
            closed.push(row);
        }
    }
    let answers = HIGH_WEIGHTS.map(|(path, [_, highest])| answer(evidence, replays, set(path, highest)));
    (vec![replayed, closed], answers.into())
}

/// `C_rho = 10` of `controller.weights.grf=10`.
fn named(set: &str) -> String {
    let (path, value) = set.split_once('=').unwrap_or((set, ""));
    format!("{} = {value}", Setting::find(path).map_or(path, |setting| setting.symbol))
}

/// What the highest level of a weight says.
fn answer(evidence: &Evidence, replays: &[Replay], set: String) -> String {
    let (name, sets) = (named(&set), [set]);
    let stands = |case: Case, sets: &[String]| evidence.trial(case, sets).stands();
    let healthy: Vec<Case> = cases().filter(|&case| stands(case, &[])).collect();
    let falls: Vec<Case> = healthy.iter().copied().filter(|&case| !stands(case, &sets)).collect();
    let say = |key: &str, values: &[_]| says("operating-weights", key, values);
    if falls.is_empty() {
        return say("stands", &[("name", &name)]);
    }
    // Only a step time that the robot stands with the baseline's weight can tell.
    let tried = falls.iter().flat_map(|&case| STEP_TIMES.map(|duration| (case, step_time(duration))));
    let tried: Vec<(Case, String)> = tried.filter(|(case, set)| stands(*case, std::slice::from_ref(set))).collect();
    let saved = tried.iter().filter(|(case, set)| stands(*case, &[sets[0].clone(), set.clone()])).count();
    let missed = |of: fn(&Replay) -> f64| Missed::new(&falls, replays, &sets, of);
    let (momentum, foot) = (missed(|r| r.momentum_missed_fraction), missed(|r| r.swing_foot_missed_fraction));
    let task = match (momentum.is_given_up(), foot.is_given_up()) {
        (true, true) => "both",
        (true, false) => "momentum",
        (false, true) => "foot",
        (false, false) => "none",
    };
    let verdict = match (task, saved) {
        ("none", 0) => "unknown",
        ("none", _) => "references",
        (_, 0) => "program",
        _ => "program-and-steps",
    };
    let (falls, healthy, tried, momentum, foot) =
        (falls.len(), healthy.len(), tried.len(), momentum.words(), foot.words());
    let (verdict, task) = (say(verdict, &[]), say(task, &[]));
    say(
        "falls",
        &[
            ("name", &name),
            ("falls", &falls),
            ("healthy", &healthy),
            ("verdict", &verdict),
            ("task", &task),
            ("momentum", &momentum),
            ("foot", &foot),
            ("saved", &saved),
            ("tried", &tried),
        ],
    )
}

/// What replays miss of a task with a high weight and with the baseline's own.
struct Missed(Vec<[f64; 2]>);

impl Missed {
    fn new(cases: &[Case], replays: &[Replay], sets: &[String], of: fn(&Replay) -> f64) -> Self {
        let share = |case: &Case, sets: &[String]| replay_of(replays, case.scenario(), sets).map(of);
        Self(cases.iter().filter_map(|case| Some([share(case, sets)?, share(case, &[])?])).collect())
    }

    /// In most of the runs.
    fn is_given_up(&self) -> bool {
        2 * self.0.iter().filter(|[high, own]| high - own >= GIVEN_UP).count() > self.0.len()
    }

    fn words(&self) -> String {
        let range = |of: usize| {
            let (least, most) = range(self.0.iter().map(|pair| pair[of]));
            format!("{:.0} to {:.0} %", 100.0 * least, 100.0 * most)
        };
        format!("{} (with the baseline's weight {})", range(0), range(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_given_up_where_most_runs_miss_much_more_than_before() {
        assert!(Missed(vec![[0.4, 0.1], [0.5, 0.3], [0.35, 0.3]]).is_given_up());
        assert!(!Missed(vec![[0.4, 0.35], [0.5, 0.3], [0.35, 0.3]]).is_given_up());
        assert_eq!(Missed(vec![[0.4, 0.1], [0.5, 0.3]]).words(), "40 to 50 % (with the baseline's weight 10 to 30 %)");
        assert_eq!(named("controller.weights.grf=10"), "C_rho = 10");
    }
}
