//! The eight runs with a setting and without: re-planning the step in mid-swing (7.1.1); true critical damping, D = 2 √(m P), against
//! the printed D = √(2 m P) (6.3.7, 6.3.8).

use super::{Entry, Found, Rows, ending, range, says};
use crate::case::{Case, Experiment, Gains, Reading};
use crate::evidence::Evidence;
use crate::limits::{LARGEST_PUSH, LARGEST_PUSH_REPLAN};
use crate::sweep::{COM, FEET, TORQUE};
use crate::trial::{CRITICAL, REPLAN};
use crate::words::{list, signed_percent, with_unit};

/// The runs without `set` and with it, called by these names, with their `figures`.
fn rows(evidence: &Evidence, set: &str, names: [&str; 2], figures: &[&str]) -> Rows {
    let row = |case: Case, name: &str, sets: &[String]| {
        let result = evidence.trial(case, sets);
        let row = [Entry::from(case.scenario()), name.into(), ending(result).into()];
        row.into_iter().chain(figures.iter().map(|figure| result.standing(figure).into())).collect()
    };
    Case::all().flat_map(|case| [row(case, names[0], &[]), row(case, names[1], &[set.to_owned()])]).collect()
}

/// A figure of a case's run without `set` and with it, where the robot stands.
fn pair(evidence: &Evidence, case: Case, set: &str, figure: &str) -> [Option<f64>; 2] {
    [&[][..], &[set.to_owned()]].map(|sets| evidence.trial(case, sets).standing(figure))
}

/// The ratios of a figure with `set` to that without, in the cases in which both stand.
fn ratios(evidence: &Evidence, cases: &[Case], set: &str, figure: &str) -> Vec<f64> {
    let ratio = |&case: &Case| {
        let [old, new] = pair(evidence, case, set, figure);
        Some(new? / old?)
    };
    cases.iter().filter_map(ratio).collect()
}

/// Whether a case stands without `set`, and with it.
fn stands(evidence: &Evidence, case: Case, set: &str) -> [bool; 2] {
    [&[][..], &[set.to_owned()]].map(|sets| evidence.trial(case, sets).stands())
}

pub(super) fn replanning(evidence: &Evidence) -> Found {
    let figures = [COM, "com_error_m.peak", FEET, TORQUE, "steps", "recovery_time_s", "recovery_distance_m"];
    let pushes = Reading::ALL.map(|reading| {
        let limit = |quantity| Entry::from(evidence.limit(quantity, reading).value);
        vec![Entry::from(reading.name()), limit(LARGEST_PUSH), limit(LARGEST_PUSH_REPLAN)]
    });
    let mut sentences: Vec<String> = Reading::ALL.map(|reading| push(evidence, reading)).into();
    let walks: Vec<Case> = Case::all().filter(|case| case.experiment == Experiment::Walk).collect();
    let stand = walks.iter().filter(|&&case| stands(evidence, case, REPLAN)[1]).count();
    let change = |figure| {
        let (least, most) = range(ratios(evidence, &walks, REPLAN, figure).into_iter());
        format!("{least:.1} to {most:.1} times")
    };
    let values: [(&str, &dyn std::fmt::Display); 4] =
        [("walks", &walks.len()), ("stand", &stand), ("com", &change(COM)), ("feet", &change(FEET))];
    sentences.push(says("replanning", "walks", &values));
    let saved = Case::all().filter(|&case| stands(evidence, case, REPLAN) == [false, true]);
    let saved: Vec<&str> = saved.map(Case::scenario).collect();
    if !saved.is_empty() {
        sentences.push(says("replanning", "saves", &[("saved", &saved.join(" and "))]));
    }
    (vec![rows(evidence, REPLAN, ["never", "in mid-swing"], &figures), pushes.into()], sentences)
}

/// What re-planning changes of the push.
fn push(evidence: &Evidence, reading: Reading) -> String {
    let case = Case::new(reading, Experiment::Push, Gains::Final);
    let [distances, steps] = ["recovery_distance_m", "steps"].map(|figure| pair(evidence, case, REPLAN, figure));
    let words = |with: usize| match (distances[with], steps[with]) {
        (Some(distance), Some(steps)) => format!("{} and {steps} steps", with_unit(distance, "m")),
        _ => "a fall".to_owned(),
    };
    let change = match distances {
        [Some(off), Some(on)] if on < 0.95 * off => "shortens the recovery",
        [Some(off), Some(on)] if on > 1.05 * off => "lengthens the recovery",
        [Some(_), Some(_)] => "leaves the recovery as it is",
        [None, Some(_)] => "saves the robot",
        [Some(_), None] => "makes the robot fall",
        [None, None] => "does not save the robot",
    };
    let largest = |quantity| {
        let value = evidence.limit(quantity, reading).value;
        value.map_or("none".to_owned(), |value| with_unit(value, "Ns"))
    };
    let (small, large) = (largest(LARGEST_PUSH), largest(LARGEST_PUSH_REPLAN));
    let (on, off, reading) = (words(1), words(0), reading.name());
    says(
        "replanning",
        "push",
        &[("reading", &reading), ("change", &change), ("on", &on), ("off", &off), ("large", &large), ("small", &small)],
    )
}

pub(super) fn damping(evidence: &Evidence) -> Found {
    let figures = [COM, "com_error_m.peak", FEET, "torso_deviation_rad.mean", TORQUE, "recovery_distance_m"];
    let those = |wanted: [bool; 2]| {
        let cases = Case::all().filter(|&case| stands(evidence, case, CRITICAL) == wanted);
        cases.map(|case| case.scenario().to_owned()).collect::<Vec<_>>()
    };
    let (fall, stand) = (those([true, false]), those([false, true]));
    let key = match (fall.is_empty(), stand.is_empty()) {
        (true, true) => "neither",
        (false, true) => "fall",
        (true, false) => "stand",
        (false, false) => "both",
    };
    let mut sentences = vec![says("damping", key, &[("fall", &list(&fall)), ("stand", &list(&stand))])];
    for experiment in Experiment::ALL {
        let finals = Case::all().filter(|case| case.experiment == experiment && case.gains == Gains::Final);
        let cases: Vec<Case> = finals.filter(|&case| stands(evidence, case, CRITICAL) == [true, true]).collect();
        let change = |figure| {
            let changes =
                ratios(evidence, &cases, CRITICAL, figure).into_iter().map(|ratio| signed_percent(ratio - 1.0));
            changes.collect::<Vec<_>>().join(" and ")
        };
        if !cases.is_empty() {
            let (com, feet, torque) = (change(COM), change(FEET), change(TORQUE));
            let experiment = experiment.name();
            let values: [(&str, &dyn std::fmt::Display); 4] =
                [("experiment", &experiment), ("com", &com), ("feet", &feet), ("torque", &torque)];
            sentences.push(says("damping", "change", &values));
        }
    }
    (vec![rows(evidence, CRITICAL, ["printed", "critical"], &figures)], sentences)
}
