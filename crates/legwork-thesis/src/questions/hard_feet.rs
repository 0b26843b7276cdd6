//! Feet tracking as hard equality against a cost: what exactly fails, and when? (6.3.5, 7.4)

use super::{Entry, Question, Table, ending};
use crate::case::Case;
use crate::evidence::Evidence;
use crate::trial::{HARD_FEET_WITH, TrialResult, hard_feet};
use crate::words::{list, with_unit};

/// A torque limit with a step time.
type With = (f64, Option<f64>);

pub(super) fn question(evidence: &Evidence) -> Question {
    let pairs: Vec<(Case, With, &TrialResult)> = Case::all()
        .flat_map(|case| HARD_FEET_WITH.map(|with| (case, with)))
        .map(|(case, with)| (case, with, evidence.trial(case, &hard_feet(with))))
        .collect();
    let rows = pairs.iter().map(|&(case, with, hard)| {
        let program = &hard.program;
        let soft = (with == HARD_FEET_WITH[0]).then(|| ending(evidence.trial(case, &[])));
        vec![
            case.scenario().into(),
            with.0.into(),
            step_s(evidence, case, with).into(),
            soft.map_or(Entry::Number(None), Entry::from),
            ending(hard).into(),
            (program.infeasible as f64).into(),
            program.first_infeasible_s.into(),
            program.since_trigger_s.map(|time| 1e3 * time).into(),
            program.conflict.join(", ").into(),
            (program.tasks_yielded as f64).into(),
            (program.torque_held as f64).into(),
        ]
    });
    let columns = vec![
        ("scenario", ""),
        ("torque limit", "Nm"),
        ("step time", "s"),
        ("feet in the cost", ""),
        ("hard feet", ""),
        ("ticks without solution", ""),
        ("first", "s"),
        ("after the trigger", "ms"),
        ("what contradicts", ""),
        ("ticks in which the hard task yielded", ""),
        ("ticks in which torques were held", ""),
    ];
    Question {
        id: "hard-feet",
        section: "6.3.5, 7.4",
        asks: "With feet tracking as hard equality, what exactly fails, and when?",
        method: "The eight runs with hard feet at 220 Nm, at 500 Nm, and at 220 Nm with steps of 0.20 s. Where the \
                 program has no solution, braking bounds, largest accelerations and then the hard task become costs \
                 for that tick, and the log says so; the thesis has no such rule, so its robot is left without \
                 torques there."
            .to_owned(),
        tables: vec![Table { title: "Runs with hard feet", columns, rows: rows.collect() }],
        answer: answer(evidence, &pairs),
        has_times: false,
    }
}

fn step_s(evidence: &Evidence, case: Case, (_, step): With) -> f64 {
    step.unwrap_or(evidence.run(case).scenario.reference.step.duration_s)
}

fn answer(evidence: &Evidence, pairs: &[(Case, With, &TrialResult)]) -> String {
    let mut sentences = Vec::new();
    for with in HARD_FEET_WITH {
        let hard: Vec<&TrialResult> = pairs.iter().filter(|pair| pair.1 == with).map(|pair| pair.2).collect();
        let step = with.1.map_or(String::new(), |step| format!(" with steps of {}", with_unit(step, "s")));
        sentences.push(sentence(&format!("{}{step}", with_unit(with.0, "Nm")), &hard));
    }
    let stands_soft = |case: Case| evidence.trial(case, &[]).stands();
    let able: Vec<_> =
        pairs.iter().filter(|(case, with, _)| *with == HARD_FEET_WITH[0] && stands_soft(*case)).collect();
    let fall = able.iter().filter(|(.., hard)| !hard.stands()).count();
    let (limit, able) = (with_unit(HARD_FEET_WITH[0].0, "Nm"), able.len());
    sentences.push(match fall {
        0 => format!(
            "As the hard task yields in those ticks here, all {able} runs stand that stand with soft feet at \
                      {limit}."
        ),
        _ => format!(
            "Though the hard task yields in those ticks here, {fall} of {able} fall that stand with soft \
                      feet at {limit}."
        ),
    });
    sentences.join(" ")
}

fn sentence(limit: &str, hard: &[&TrialResult]) -> String {
    let infeasible: Vec<&TrialResult> = hard.iter().copied().filter(|result| result.program.infeasible > 0).collect();
    if infeasible.is_empty() {
        return format!("At {limit} all programs of all {} runs have a solution.", hard.len());
    }
    let when = |result: &&TrialResult| {
        let program = &result.program;
        let since = program.since_trigger_s.map(|time| format!("{} after a trigger", with_unit(1e3 * time, "ms")));
        let place = since.unwrap_or_else(|| "in double support".to_owned());
        format!("{} ({} ticks, first {place})", result.trial.scenario, program.infeasible)
    };
    let runs: Vec<String> = infeasible.iter().map(when).collect();
    let limits = infeasible.iter().flat_map(|result| &result.program.limited);
    let mut limits: Vec<String> = limits.map(|limit| (*limit).to_owned()).collect();
    limits.sort();
    limits.dedup();
    format!(
        "At {limit} {} of {} runs meet programs without solution: {}; there the feet's accelerations contradict the \
         limits on {}.",
        infeasible.len(),
        hard.len(),
        list(&runs),
        list(&limits)
    )
}
