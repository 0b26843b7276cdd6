//! What `tune` prints: tables for people, a JSON object for programs.

use std::fmt::Write as _;

use legwork_study::Rollout;
use legwork_study::rollout::DOUBTFUL;
use legwork_study::tune::{Comparison, Score, Stop, Tuned, Tuning};
use serde_json::{Map, Value, json};

use crate::output::folded;
use crate::study_summary::digits;

/// Columns of a table that fit a terminal.
const COLUMNS: usize = 5;

/// What was found, and the cases with the first of the tuning's metrics.
pub(crate) fn text(tuning: &Tuning, tuned: &Tuned) -> String {
    let mut text = folded(&format!("{}: {}", tuning.name, tuning.description), 2);
    let why = match tuned.why {
        Stop::Budget => "the budget is spent",
        Stop::Converged(reason) => reason,
        Stop::Interrupted => "interrupted",
    };
    let (tried, before, after) = (tuned.evaluations, score(tuned.base_score), score(tuned.score));
    text += "\n\n";
    text += &folded(&format!("{tried} candidates; {why}. Training: {before} as it stands, {after} tuned."), 2);
    let _ = write!(text, "\n\n  {:<40}{:>12}{:>12}", "", "base", "tuned");
    for ((factor, own), level) in tuning.factors.iter().zip(&tuning.own).zip(&tuned.levels) {
        let _ = write!(text, "\n  {:<40}{:>12}{:>12}", factor.label(), digits(*own), digits(*level));
    }
    let metrics = tuning.metrics();
    for (title, cases) in [("training", &tuned.training), ("held out", &tuned.held_out)] {
        text += &table(title, cases, tuning, &metrics[..metrics.len().min(COLUMNS)]);
        metrics.iter().for_each(|&metric| text += &in_short(cases, tuning, metric));
    }
    text.push('\n');
    text
}

fn score(score: Score) -> String {
    match score {
        Score::Feasible(objective) => format!("objective {}", digits(objective)),
        Score::Violating(excess) => format!("beyond its bounds by {} in sum", digits(excess)),
        Score::Falling(_) => "falls".to_owned(),
    }
}

/// Two lines a case: as it stands, and tuned.
fn table(title: &str, cases: &[Comparison], tuning: &Tuning, metrics: &[usize]) -> String {
    let stand = |of: fn(&Comparison) -> &Rollout| cases.iter().filter(|case| of(case).survived()).count();
    let (base, tuned) = (stand(|case| &case.base), stand(|case| &case.tuned));
    let all = cases.len();
    let mut text = format!("\n\n{title}: {base} of {all} stand as they are, {tuned} of {all} tuned\n  {:<21}", "");
    for &metric in metrics {
        let _ = write!(text, "{:>11}", short(&tuning.columns[metric].name));
    }
    for case in cases {
        let _ = write!(text, "\n  {}", case.case);
        for (design, rollout) in [("base", &case.base), ("tuned", &case.tuned)] {
            let _ = write!(text, "\n    {design:<19}");
            if rollout.survived() {
                for &metric in metrics {
                    let value = rollout.figures.get(metric).copied().flatten();
                    let _ = write!(text, "{:>11}", value.map_or("none".to_owned(), digits));
                }
            } else {
                let when = rollout.fell_at_s.map_or(String::new(), |time| format!(" at {time:.2} s"));
                let _ = write!(text, "    {}{when}", rollout.ending.name());
            }
            if rollout.violations.is_some() {
                let _ = write!(text, "\n      {DOUBTFUL}");
            }
        }
    }
    text
}

/// In how many cases a figure is better, and by how much on average.
fn in_short(cases: &[Comparison], tuning: &Tuning, metric: usize) -> String {
    let shares: Vec<f64> = cases.iter().filter_map(|case| case.figure(metric)).map(|figure| figure.2).collect();
    if shares.is_empty() {
        return String::new();
    }
    let better = shares.iter().filter(|share| **share < 1.0).count();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let name = &tuning.columns[metric].name;
    format!("\n  {name:<32} × {} on average, less in {better} of {}", digits(mean), shares.len())
}

/// A name that fits its column: `com mean`; of a figure of a joint `r knee`.
fn short(name: &str) -> String {
    let (name, kind) = name.rsplit_once('.').unwrap_or((name, ""));
    let stem = |name: &str| name.split('_').next().unwrap_or_default().to_owned();
    let text = match name.strip_prefix("joint.").and_then(|joint| joint.split_once('_')) {
        Some((side, joint)) => format!("{} {}", side.chars().next().unwrap_or_default(), joint.replace('_', " ")),
        None => format!("{} {kind}", stem(name)),
    };
    text.trim().chars().take(10).collect()
}

/// All that a program, or a page, may want of it.
pub(crate) fn json(tuning: &Tuning, tuned: &Tuned) -> Value {
    let factors: Vec<Value> = (tuning.factors.iter().zip(&tuning.own).zip(&tuned.levels))
        .map(|((factor, own), level)| {
            json!({ "name": factor.name, "paths": factor.paths, "unit": factor.unit(), "relative": factor.relative, "base": own, "tuned": level })
        })
        .collect();
    let cases = |cases: &[Comparison]| cases.iter().map(|case| case_json(tuning, case)).collect::<Vec<_>>();
    json!({
        "tuning": tuning.name,
        "description": tuning.description,
        "budget": tuning.settings.budget,
        "seed": tuning.settings.seed,
        "evaluations": tuned.evaluations,
        "why": tuned.why,
        "base_score": tuned.base_score,
        "score": tuned.score,
        "factors": factors,
        "metrics": tuning.metrics().iter().map(|&metric| &tuning.columns[metric].name).collect::<Vec<_>>(),
        "training": cases(&tuned.training),
        "held_out": cases(&tuned.held_out),
        "history": tuned.history,
    })
}

fn case_json(tuning: &Tuning, case: &Comparison) -> Value {
    let run = |rollout: &Rollout| {
        let names = tuning.columns.iter().map(|column| column.name.clone());
        let figures: Map<String, Value> = names.zip(rollout.figures.iter().map(|value| json!(value))).collect();
        json!({
            "ending": rollout.ending,
            "fell_at_s": rollout.fell_at_s,
            "cause": rollout.cause,
            "reason": rollout.reason,
            "violations": rollout.violations,
            "figures": figures,
            "input_hash": rollout.input_hash,
            "result_hash": rollout.result_hash,
        })
    };
    json!({ "case": case.case, "scenario": case.scenario, "base": run(&case.base), "tuned": run(&case.tuned) })
}
