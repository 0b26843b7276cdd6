//! What `study` prints: tables for people, a JSON object for programs.

use std::fmt::Write as _;

use legwork::error::Error;
use legwork_report::study::{BOOTSTRAP, endings, range};
use legwork_study::Level;
use legwork_study::design::Design;
use legwork_study::results::{Range, Results, SURVIVED};
use legwork_study::rollout::DOUBTFUL;
use legwork_study::sensitivity::Estimate;
use serde_json::{Map, Value, json};

use crate::output::folded;

/// The study in tables, scenario by scenario.
pub(crate) fn text(results: &Results) -> Result<String, Error> {
    let study = results.study;
    let space = if study.description.is_empty() { "" } else { " " };
    let mut text = folded(&format!("{}: {}{space}{} rollouts", study.name, study.description, study.len()), 2);
    for (number, base) in study.bases.iter().enumerate() {
        let _ = write!(text, "\n\n{}: {}", base.name(), endings(&results.endings(number)));
        match study.design {
            Design::OneAtATime => {
                for factor in 0..study.factors.len() {
                    text += &sweep(results, number, factor);
                }
                text += &ranges(results, number);
            }
            Design::Saltelli { .. } => text += &sobol(results, number)?,
            Design::Morris { .. } => text += &morris(results, number)?,
            Design::Grid | Design::LatinHypercube { .. } | Design::SobolSequence { .. } => {
                text += &spread(results, number);
                text += &ranges(results, number);
            }
        }
    }
    text.push('\n');
    Ok(text)
}

/// Columns of a table that fit a terminal.
const COLUMNS: usize = 5;

/// A factor's levels with the first of the study's metrics, or why there are none.
fn sweep(results: &Results, base: usize, factor: usize) -> String {
    let means = |name: &str| !name.ends_with(".peak");
    let shown: Vec<usize> =
        (0..results.columns.len()).filter(|&i| means(&results.columns[i].name)).take(COLUMNS).collect();
    let mut text = format!("\n  {:<24} ", results.study.factors[factor].label());
    for &metric in &shown {
        let name = results.columns[metric].name.split('.').next().unwrap_or_default();
        let _ = write!(text, "{:>11}", short(name));
    }
    for (level, row) in results.sweep(base, factor) {
        let _ = write!(text, "\n  {:<24} ", level_text(&level));
        if row.ending.stood() {
            shown.iter().for_each(|&metric| {
                let _ = write!(text, "{:>11}", row.metrics[metric].map_or("none".to_owned(), digits));
            });
            if row.is_doubtful {
                let _ = write!(text, "  {DOUBTFUL}");
            }
        } else {
            let when = row.fell_at_s.map_or(String::new(), |time| format!(" at {time:.2} s"));
            let cause = row.cause.as_ref().map_or(String::new(), |cause| format!(": {cause}"));
            let _ = write!(text, "     {}{when}{cause}", row.ending.name());
        }
    }
    text
}

/// How the metrics of the runs without a fall are spread.
fn spread(results: &Results, base: usize) -> String {
    let mut text = format!("\n  {:<32}{:>12}{:>12}{:>12}", "of the runs without a fall", "5 %", "median", "95 %");
    for (metric, column) in results.columns.iter().enumerate() {
        let [low, median, high] =
            results.quantiles(base, metric, [0.05, 0.5, 0.95]).map(|q| q.map_or("none".into(), digits));
        let _ = write!(text, "\n  {:<32}{low:>12}{median:>12}{high:>12}", column.name);
    }
    text
}

/// From where to where each metric goes.
fn ranges(results: &Results, base: usize) -> String {
    let mut text = format!("\n  {:<32}", "least to greatest of these");
    for found in results.ranges(base) {
        let _ = write!(text, "\n  {:<32}  {}", found.column.name, with_unit(&found));
    }
    text
}

/// A range with its unit.
fn with_unit(found: &Range) -> String {
    format!("{} {}", range(found), found.column.unit).trim_end().to_owned()
}

/// The name of a metric with its range; `flat` where it is the same in all rollouts.
fn head(results: &Results, base: usize, metric: &str, flat: bool) -> String {
    let words = if flat { Some("the same in all rollouts".to_owned()) } else { None };
    let range = results.range(base, metric).map(|found| with_unit(&found));
    let said: Vec<String> = words.into_iter().chain(range).collect();
    if said.is_empty() { metric.to_owned() } else { format!("{metric}: {}", said.join(", ")) }
}

/// A name that fits its column.
fn short(name: &str) -> String {
    name.replace("_deviation", "").replace("_error", "").chars().take(10).collect()
}

pub(crate) fn level_text(level: &Level) -> String {
    level.number().map_or_else(|| level.to_string(), digits)
}

/// Four significant digits.
pub(crate) fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        size => {
            let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
            let text = format!("{value:.digits$}");
            let trimmed = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
            trimmed.to_owned()
        }
    }
}

/// The factors in the order of their total index, for survival and each metric.
fn sobol(results: &Results, base: usize) -> Result<String, Error> {
    let mut text = String::new();
    for sensitivity in results.sobol(base, &BOOTSTRAP)? {
        let shares = &sensitivity.found.shares;
        let _ = write!(text, "\n  {}", head(results, base, &sensitivity.metric, shares.is_none()));
        let Some(shares) = shares else { continue };
        let _ = write!(text, "\n    {:<24} {:>26} {:>26}", "", "first order", "total");
        let mut order: Vec<usize> = (0..shares.total.len()).collect();
        order.sort_by(|&a, &b| shares.total[b].value.total_cmp(&shares.total[a].value));
        for factor in order {
            let name = &results.study.factors[factor].name;
            let (first, total) = (interval(&shares.first[factor]), interval(&shares.total[factor]));
            let _ = write!(text, "\n    {name:<24} {first:>26} {total:>26}");
        }
    }
    Ok(text)
}

/// The factors in the order of their mean absolute effect, for survival and each metric.
fn morris(results: &Results, base: usize) -> Result<String, Error> {
    let mut text = String::new();
    for sensitivity in results.morris(base, &BOOTSTRAP)? {
        let _ = write!(text, "\n  {}", head(results, base, &sensitivity.metric, sensitivity.found.is_none()));
        let Some(effects) = sensitivity.found else { continue };
        let _ = write!(text, "\n    {:<24} {:>28} {:>12}", "", "mean absolute effect", "deviation");
        let mut order: Vec<usize> = (0..effects.len()).collect();
        order.sort_by(|&a, &b| effects[b].mu_star.value.total_cmp(&effects[a].mu_star.value));
        for factor in order {
            let (name, effect) = (&results.study.factors[factor].name, &effects[factor]);
            let _ = write!(text, "\n    {name:<24} {:>28} {:>12}", interval(&effect.mu_star), digits(effect.sigma));
        }
    }
    Ok(text)
}

/// The estimate with its interval.
fn interval(estimate: &Estimate) -> String {
    format!("{} [{}, {}]", digits(estimate.value), digits(estimate.low), digits(estimate.high))
}

/// The study as one JSON object; see docs/studies.md.
pub(crate) fn json(results: &Results) -> Result<Value, Error> {
    let study = results.study;
    let mut scenarios = Vec::new();
    for (number, base) in study.bases.iter().enumerate() {
        let endings = results.endings(number);
        let mut scenario = Map::new();
        scenario.insert("scenario".into(), base.name().into());
        scenario.insert("rollouts".into(), endings.rollouts.into());
        scenario.insert("completed".into(), endings.completed.into());
        scenario.insert("injurious".into(), endings.injurious.into());
        scenario.insert("fell".into(), endings.fell.into());
        scenario.insert("invalid".into(), endings.invalid.into());
        scenario.insert("failed".into(), endings.failed.into());
        scenario.insert("doubtful".into(), endings.doubtful.into());
        scenario.insert("causes".into(), json!(endings.causes));
        if study.design == Design::OneAtATime {
            let sweeps = (0..study.factors.len()).map(|factor| sweep_json(results, number, factor));
            scenario.insert("sweeps".into(), sweeps.collect());
        }
        scenario.insert("metrics".into(), metrics_json(results, number)?);
        scenarios.push(Value::Object(scenario));
    }
    let factors: Vec<Value> = study
        .factors
        .iter()
        .map(|factor| json!({ "name": factor.name, "paths": factor.paths, "unit": factor.unit(), "relative": factor.relative }))
        .collect();
    Ok(json!({
        "study": study.name,
        "description": study.description,
        "design": study.design,
        "seed": study.seed,
        "identity": format!("{:032x}", study.identity()),
        "rollouts": study.len(),
        "factors": factors,
        "metrics": study.metrics,
        "scenarios": scenarios,
    }))
}

/// Each metric with its range, and what the design says of it.
fn metrics_json(results: &Results, base: usize) -> Result<Value, Error> {
    let entry = |metric: &str, found: Value| {
        let unit = results.columns.iter().find(|column| column.name == metric).map_or("", |column| column.unit);
        let (least, greatest) = results.range(base, metric).map(|found| (found.least, found.greatest)).unzip();
        let mut entry = json!({ "metric": metric, "unit": unit, "least": least, "greatest": greatest });
        let (known, more) = (entry.as_object_mut(), if let Value::Object(more) = found { more } else { Map::new() });
        known.expect("it was made as one").extend(more);
        entry
    };
    let names = || results.columns.iter().map(|column| column.name.as_str()).enumerate();
    Ok(match results.study.design {
        Design::Saltelli { .. } => {
            let found = results.sobol(base, &BOOTSTRAP)?;
            found.iter().map(|s| entry(&s.metric, json!({ "sobol": s.found }))).collect()
        }
        Design::Morris { .. } => {
            let found = results.morris(base, &BOOTSTRAP)?;
            found.iter().map(|s| entry(&s.metric, json!({ "morris": s.found }))).collect()
        }
        Design::OneAtATime => names().map(|(_, name)| entry(name, Value::Null)).collect(),
        Design::Grid | Design::LatinHypercube { .. } | Design::SobolSequence { .. } => names()
            .map(|(metric, name)| {
                let [low, median, high] = results.quantiles(base, metric, [0.05, 0.5, 0.95]);
                entry(name, json!({ "p05": low, "median": median, "p95": high }))
            })
            .collect(),
    })
}

fn sweep_json(results: &Results, base: usize, factor: usize) -> Value {
    let entry = |(level, row): &(Level, &legwork_study::results::Row)| {
        let metrics = results.study.metrics.iter().cloned().zip(row.metrics.iter().map(|value| json!(value)));
        json!({
            "level": level,
            "ending": row.ending,
            SURVIVED: row.ending.stood(),
            "fell_at_s": row.fell_at_s,
            "cause": row.cause,
            "doubtful": row.is_doubtful,
            "metrics": metrics.collect::<Map<_, _>>(),
        })
    };
    let levels: Vec<Value> = results.sweep(base, factor).iter().map(entry).collect();
    json!({ "factor": results.study.factors[factor].name, "levels": levels })
}
