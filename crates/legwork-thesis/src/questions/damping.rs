//! True critical damping, D = 2 √(m P), against the printed D = √(2 m P). (6.3.7, 6.3.8)

use super::{Entry, Question, Table, ending, standing};
use crate::case::{Case, Experiment, Gains};
use crate::evidence::Evidence;
use crate::sweep::{COM, FEET, TORQUE, TORSO};
use crate::trial::CRITICAL;
use crate::words::{list, signed_percent};

const FIGURES: [&str; 6] = [COM, "com_error_m.peak", FEET, TORSO, TORQUE, "recovery_distance_m"];

pub(super) fn question(evidence: &Evidence) -> Question {
    let mut rows = Vec::new();
    for case in Case::all() {
        for (name, sets) in variants() {
            let result = evidence.trial(case, &sets);
            let mut row: Vec<Entry> = vec![case.scenario().into(), name.into(), ending(result).into()];
            row.extend(FIGURES.map(|figure| Entry::from(standing(result, figure))));
            rows.push(row);
        }
    }
    let columns = vec![
        ("scenario", ""),
        ("damping", ""),
        ("ending", ""),
        ("mean CoM error", "m"),
        ("peak CoM error", "m"),
        ("mean feet error", "m"),
        ("mean torso deviation", "rad"),
        ("mean torque", "Nm"),
        ("recovery distance", "m"),
    ];
    Question {
        id: "damping",
        section: "6.3.7, 6.3.8",
        asks: "The printed damping D = √(2 m P) has the ratio 0.71: what would true critical damping, D = 2 √(m P), \
               change?",
        method: "The eight runs with both (controller.planner.damping), for CoM, feet and torso alike.".to_owned(),
        tables: vec![Table { title: "Runs", columns, rows }],
        answer: answer(evidence),
        has_times: false,
    }
}

fn variants() -> [(&'static str, Vec<String>); 2] {
    [("printed", Vec::new()), ("critical", vec![CRITICAL.to_owned()])]
}

fn answer(evidence: &Evidence) -> String {
    let stands = |case: Case, sets: &[String]| evidence.trial(case, sets).stands();
    let critical = [CRITICAL.to_owned()];
    let names = |cases: Vec<Case>| list(&cases.iter().map(|case| case.scenario().to_owned()).collect::<Vec<_>>());
    let falls: Vec<Case> = Case::all().filter(|&case| stands(case, &[]) && !stands(case, &critical)).collect();
    let saved: Vec<Case> = Case::all().filter(|&case| !stands(case, &[]) && stands(case, &critical)).collect();
    let mut sentences = Vec::new();
    sentences.push(match (falls.is_empty(), saved.is_empty()) {
        (true, true) => "Critical damping changes no ending.".to_owned(),
        (false, true) => format!("With critical damping {} fall, which stand with the printed.", names(falls)),
        (true, false) => format!("With critical damping {} stand, which fall with the printed.", names(saved)),
        (false, false) => format!("With critical damping {} fall and {} stand.", names(falls), names(saved)),
    });
    for experiment in Experiment::ALL {
        let cases: Vec<Case> = Case::all()
            .filter(|case| case.experiment == experiment && case.gains == Gains::Final)
            .filter(|&case| stands(case, &[]) && stands(case, &critical))
            .collect();
        if cases.is_empty() {
            continue;
        }
        let change = |figure: &str| {
            let ratio = |&case: &Case| {
                let [old, new] = [&[][..], &critical].map(|sets| standing(evidence.trial(case, sets), figure));
                Some(signed_percent(new? / old? - 1.0))
            };
            let changes: Vec<String> = cases.iter().filter_map(ratio).collect();
            changes.join(" and ")
        };
        sentences.push(format!(
            "In the final design's {} the mean CoM error changes by {}, the feet error by {}, the torque by {}.",
            experiment.name(),
            change(COM),
            change(FEET),
            change(TORQUE)
        ));
    }
    sentences.join(" ")
}
