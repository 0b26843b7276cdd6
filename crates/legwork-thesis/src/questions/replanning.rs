//! Re-planning the step in mid-swing, on and off. (7.1.1)

use super::{Entry, Question, Table, ending, standing};
use crate::case::{Case, Experiment, Gains, Reading};
use crate::evidence::Evidence;
use crate::limits::{LARGEST_PUSH, LARGEST_PUSH_REPLAN};
use crate::trial::REPLAN;
use crate::words::with_unit;

const FIGURES: [&str; 7] = [
    "com_error_m.mean",
    "com_error_m.peak",
    "feet_error_m.mean",
    "torque_nm.mean",
    "steps",
    "recovery_time_s",
    "recovery_distance_m",
];

pub(super) fn question(evidence: &Evidence) -> Question {
    let sets = [Vec::new(), vec![REPLAN.to_owned()]];
    let mut rows = Vec::new();
    for case in Case::all() {
        for sets in &sets {
            let result = evidence.trial(case, sets);
            let mode = if sets.is_empty() { "never" } else { "in mid-swing" };
            let mut row: Vec<Entry> = vec![case.scenario().into(), mode.into(), ending(result).into()];
            row.extend(FIGURES.map(|figure| Entry::from(standing(result, figure))));
            rows.push(row);
        }
    }
    let mut columns = vec![("scenario", ""), ("re-planned", ""), ("ending", "")];
    columns.extend([
        ("mean CoM error", "m"),
        ("peak CoM error", "m"),
        ("mean feet error", "m"),
        ("mean torque", "Nm"),
        ("steps", ""),
        ("recovery time", "s"),
        ("recovery distance", "m"),
    ]);
    let pushes = Reading::ALL.map(|reading| {
        let limit = |quantity| Entry::from(evidence.limit(quantity, reading).value);
        vec![Entry::from(reading.name()), limit(LARGEST_PUSH), limit(LARGEST_PUSH_REPLAN)]
    });
    Question {
        id: "replanning",
        section: "7.1.1",
        asks: "What would it change if the step were planned again while the foot swings?",
        method:
            "The eight runs with the step length planned once, at the trigger, and again at every tick of the swing \
                 (reference.step.replan); and the largest push of both."
                .to_owned(),
        tables: vec![
            Table { title: "Runs", columns, rows },
            Table {
                title: "Largest push",
                columns: vec![("reading", ""), ("never", "Ns"), ("in mid-swing", "Ns")],
                rows: pushes.to_vec(),
            },
        ],
        answer: answer(evidence),
        has_times: false,
    }
}

fn answer(evidence: &Evidence) -> String {
    let mut sentences = Vec::new();
    for reading in Reading::ALL {
        let case = Case::new(reading, Experiment::Push, Gains::Final);
        let [off, on] = [Vec::new(), vec![REPLAN.to_owned()]].map(|sets| {
            let result = evidence.trial(case, &sets);
            (standing(result, "recovery_distance_m"), standing(result, "steps"))
        });
        let words = |(distance, steps): (Option<f64>, Option<f64>)| match (distance, steps) {
            (Some(distance), Some(steps)) => format!("{} and {steps} steps", with_unit(distance, "m")),
            _ => "a fall".to_owned(),
        };
        let change = match (off.0, on.0) {
            (Some(off), Some(on)) if on < 0.95 * off => "shortens the recovery",
            (Some(off), Some(on)) if on > 1.05 * off => "lengthens the recovery",
            (Some(_), Some(_)) => "leaves the recovery as it is",
            (None, Some(_)) => "saves the robot",
            (Some(_), None) => "makes the robot fall",
            (None, None) => "does not save the robot",
        };
        let [small, large] =
            [LARGEST_PUSH, LARGEST_PUSH_REPLAN].map(|quantity| evidence.limit(quantity, reading).value);
        let ns = |value: Option<f64>| value.map_or("none".to_owned(), |value| with_unit(value, "Ns"));
        sentences.push(format!(
            "With the least step length as {} re-planning {change} from the push of 140 Ns ({} instead of {}), and the \
             largest push is {} instead of {}.",
            reading.name(),
            words(on),
            words(off),
            ns(large),
            ns(small)
        ));
    }
    let walks: Vec<Case> = Case::all().filter(|case| case.experiment == Experiment::Walk).collect();
    let fall = walks.iter().filter(|&&case| !evidence.trial(case, &[REPLAN.to_owned()]).stands()).count();
    let change = |figure: &'static str| {
        let ratio = |&case: &Case| {
            let [old, new] = [&[][..], &[REPLAN.to_owned()]].map(|sets| standing(evidence.trial(case, sets), figure));
            Some(new? / old?)
        };
        let ratios: Vec<f64> = walks.iter().filter_map(ratio).collect();
        let (least, most) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), &ratio| (l.min(ratio), m.max(ratio)));
        format!("{least:.1} to {most:.1} times")
    };
    sentences.push(format!(
        "Of the {} walks {} stand with it, their mean CoM error is {} and their feet error {} that without.",
        walks.len(),
        walks.len() - fall,
        change("com_error_m.mean"),
        change("feet_error_m.mean")
    ));
    let saved =
        |case: &Case| !evidence.trial(*case, &[]).stands() && evidence.trial(*case, &[REPLAN.to_owned()]).stands();
    let saved: Vec<&str> = Case::all().filter(saved).map(Case::scenario).collect();
    if !saved.is_empty() {
        sentences.push(format!("It saves {}.", saved.join(" and ")));
    }
    sentences.join(" ")
}
