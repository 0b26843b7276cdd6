//! Feet tracking as hard equality against a cost: what exactly fails, and when? (6.3.5, 7.4)

use super::{Entry, Found, ending, says};
use crate::case::Case;
use crate::evidence::Evidence;
use crate::trial::{HARD_FEET_WITH, TrialResult, hard_feet};
use crate::words::{list, with_unit};

pub(super) fn found(evidence: &Evidence) -> Found {
    let hard = |case, with| evidence.trial(case, &hard_feet(with));
    let row = |(case, with): (Case, (f64, Option<f64>))| {
        let (result, soft) = (hard(case, with), evidence.trial(case, &[]));
        let (program, own) = (&result.program, evidence.run(case).scenario.reference.step.duration_s);
        vec![
            case.scenario().into(),
            with.0.into(),
            with.1.unwrap_or(own).into(),
            if with == HARD_FEET_WITH[0] { ending(soft).into() } else { Entry::Number(None) },
            ending(result).into(),
            (program.infeasible as f64).into(),
            program.first_infeasible_s.into(),
            program.since_trigger_s.map(|time| 1e3 * time).into(),
            program.conflict.join(", ").into(),
            (program.tasks_yielded as f64).into(),
            (program.torque_held as f64).into(),
        ]
    };
    let rows = Case::all().flat_map(|case| HARD_FEET_WITH.map(|with| row((case, with)))).collect();
    let mut sentences: Vec<String> = HARD_FEET_WITH
        .map(|with| {
            let step = with.1.map_or(String::new(), |step| format!(" with steps of {}", with_unit(step, "s")));
            let results: Vec<&TrialResult> = Case::all().map(|case| hard(case, with)).collect();
            sentence(&format!("{}{step}", with_unit(with.0, "Nm")), &results)
        })
        .into();
    let able: Vec<Case> = Case::all().filter(|&case| evidence.trial(case, &[]).stands()).collect();
    let fall = able.iter().filter(|&&case| !hard(case, HARD_FEET_WITH[0]).stands()).count();
    let (limit, able) = (with_unit(HARD_FEET_WITH[0].0, "Nm"), able.len());
    let key = if fall == 0 { "stand" } else { "fall" };
    sentences.push(says("hard-feet", key, &[("fall", &fall), ("able", &able), ("limit", &limit)]));
    (vec![rows], sentences)
}

fn sentence(limit: &str, hard: &[&TrialResult]) -> String {
    let failed: Vec<_> = hard.iter().filter(|result| result.program.infeasible > 0).collect();
    let when = |result: &&&TrialResult| {
        let program = &result.program;
        let since = program.since_trigger_s.map(|time| format!("{} after a trigger", with_unit(1e3 * time, "ms")));
        let place = since.unwrap_or_else(|| "in double support".to_owned());
        format!("{} ({} ticks, first {place})", result.trial.scenario, program.infeasible)
    };
    let which = list(&failed.iter().map(when).collect::<Vec<_>>());
    let limits = failed.iter().flat_map(|result| &result.program.limited);
    let mut limits: Vec<String> = limits.map(|limit| (*limit).to_owned()).collect();
    limits.sort();
    limits.dedup();
    let key = if failed.is_empty() { "solved" } else { "fails" };
    let (limits, runs, failed) = (list(&limits), hard.len(), failed.len());
    says(
        "hard-feet",
        key,
        &[("limit", &limit), ("runs", &runs), ("failed", &failed), ("which", &which), ("limits", &limits)],
    )
}
