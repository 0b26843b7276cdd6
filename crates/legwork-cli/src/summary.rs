//! What `run` prints of a run: a table for people, a JSON object for programs.

use legwork::episode::{Outcome, Run};
use legwork::metrics::{JOINT_METRICS, METRICS, Metric, Metrics, Value as Measured};
use legwork::momentum::Condition;
use legwork::scenario::Scenario;
use legwork::scenario_file;
use legwork::sim::audit::Audit;
use legwork_thesis::published::{self, Row};
use serde_json::{Value, json};

use crate::output::folded;

/// How a run ended, in words.
pub(crate) fn outcome(run: &Run) -> String {
    let duration = run.scenario.duration_s;
    match &run.outcome {
        Outcome::Completed => match run.injurious_force_n() {
            Some(force) => format!("completed {duration} s, with an injurious contact force of {:.1} kN", 1e-3 * force),
            None => format!("completed {duration} s"),
        },
        Outcome::Fell(_) => run.reason.clone().unwrap_or_else(|| "fell".to_owned()),
        Outcome::Stopped => format!("stopped at {:.2} s of {duration} s", simulated(run)),
    }
}

/// Outcome and table: each figure of the thesis beside the measured one.
pub(crate) fn text(run: &Run) -> String {
    let (name, outcome) = (&run.scenario.name, outcome(run));
    let rows: Vec<Row> = published::compare(name, &run.metrics)
        .into_iter()
        .filter(|row| row.measured.is_some() || row.published.is_some())
        .collect();
    let known = rows.iter().any(|row| row.published.is_some());
    let width = rows.iter().map(|row| label(row).chars().count()).max().unwrap_or(0);
    let line = |label: &str, measured: [&str; 2], thesis: [&str; 2]| {
        let mut line = format!("\n  {label:<width$}{:>9}{:>9}", measured[0], measured[1]);
        if known {
            line += &format!("{:>12}{:>9}", thesis[0], thesis[1]);
        }
        line.truncate(line.trim_end().len());
        line
    };
    let mut text = folded(&format!("{name}: {outcome}"), 2);
    text += &line("", ["", "measured"], ["", "thesis"]);
    text += &line("", ["mean", "peak"], ["mean", "peak"]);
    for row in &rows {
        let measured =
            [row.measured.map_or("\u{2013}".into(), number), row.measured_peak.map_or(String::new(), number)];
        // As printed, without digits that the thesis does not give.
        let thesis = [row.published, row.published_peak].map(|value| value.map_or(String::new(), |v| v.to_string()));
        text += &line(&label(row), measured.each_ref().map(String::as_str), thesis.each_ref().map(String::as_str));
    }
    text += &format!("\n{}", folded(&format!("  ({})", run.scenario.metrics.counted()), 3));
    if known && is_altered(&run.scenario) {
        text += "\n  (the thesis's figures are for the built-in scenario, not for these settings)";
    }
    if let Some((time, conflict)) = &run.program.first_infeasible {
        let what = format!(
            "{} programs had no solution as they stood, the first at {time:.3} s: {} contradict each other",
            run.program.infeasible,
            in_words(run, conflict).join(", ")
        );
        text += &format!("\n  {}", folded(&what, 2));
    }
    let [median, p99] = [0.5, 0.99].map(|share| run.timing.tick_quantile_us(share));
    text += &format!(
        "\n  {} ticks, {:.0} times real time; control tick {median:.1} µs median, {p99:.1} µs p99\n",
        (run.simulated_s / run.scenario.controller.period_s).round(),
        real_time_factor(run),
    );
    text
}

fn label(row: &Row) -> String {
    if row.unit.is_empty() { row.label.to_owned() } else { format!("{} [{}]", row.label, row.unit) }
}

/// Whether something was changed in the built-in scenario of that name.
fn is_altered(scenario: &Scenario) -> bool {
    scenario_file::load(&scenario.name, &[]).is_ok_and(|built_in| built_in.scenario != *scenario)
}

/// Three significant digits, or all of a larger number's.
fn number(value: f64) -> String {
    if value.abs() > 0.0 && value.abs() < 1e-4 {
        return format!("{value:.0e}");
    }
    if value.fract() == 0.0 {
        return format!("{value:.0}");
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 6) as usize)
}

/// A time without the last digits that counting ticks leaves.
fn time(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e9
}

/// The run as one JSON object; see docs/output.md.
pub(crate) fn json(run: &Run) -> Value {
    let (outcome, fell_at_s) = match &run.outcome {
        Outcome::Completed if run.injurious_force_n().is_some() => ("injurious", None),
        Outcome::Completed => ("completed", None),
        Outcome::Fell(fall) => ("fell", Some(fall.time)),
        Outcome::Stopped => ("stopped", None),
    };
    let qp = &run.program;
    json!({
        "scenario": run.scenario.name,
        "outcome": outcome,
        "fell_at_s": fell_at_s,
        "reason": run.reason,
        "cause": run.diagnosis.as_ref().map(|diagnosis| diagnosis.cause.label()),
        "input_hash": format!("{:032x}", run.input_hash),
        "result_hash": format!("{:032x}", run.result_hash),
        "metrics": metrics(&run.metrics),
        "audit": run.audit.as_ref().map(audit),
        "limits_passed": run.limits_passed,
        "qp": {
            "solves": qp.solves,
            "infeasible": qp.infeasible,
            "first_infeasible": qp.first_infeasible.as_ref().map(|(time, conflict)| json!({ "time_s": time, "conflict": in_words(run, conflict) })),
            "fallbacks": qp.fallbacks,
            "iterations_mean": qp.iterations_mean,
            "iterations_max": qp.iterations_max,
        },
        "timing": {
            "tick_us": {
                "p50": run.timing.tick_quantile_us(0.5),
                "p99": run.timing.tick_quantile_us(0.99),
                "max": run.timing.tick_quantile_us(1.0),
            },
            "wall_s": run.timing.wall_s,
            "simulated_s": time(simulated(run)),
            "real_time_factor": real_time_factor(run),
        },
    })
}

/// The physics' books.
fn audit(audit: &Audit) -> Value {
    json!({
        "energy_error_j": audit.energy_error_j,
        "work_j": audit.work_j,
        "contact_loss_j": audit.contact_loss_j,
        "contact_gain_j": audit.contact_gain_j,
        "momentum_error_mps": audit.momentum_error_mps,
        "penetration_m": audit.penetration_m,
        "friction_excess_n": audit.friction_excess_n,
        "friction_angle_deg": audit.friction_angle_deg,
        "pull_n": audit.pull_n,
        "slip_m": audit.slip_m,
        "contact_sweeps_max": audit.contact_sweeps,
        "contact_residual_n": audit.contact_residual_n,
        "violations": audit.violations(),
    })
}

/// Every metric by its name, those of the joints by the joints' names; null where the run has none.
fn metrics(metrics: &Metrics) -> Value {
    let mut object = by_name(METRICS, metrics);
    let joints = metrics.joints.iter().map(|joint| (joint.joint.clone(), by_name(JOINT_METRICS, joint)));
    object["joints"] = Value::Object(joints.collect());
    object
}

fn by_name<Of>(table: &[Metric<Of>], metrics: &Of) -> Value {
    let value = |metric: &Metric<Of>| match metric.value {
        Measured::Pair(pair) => json!(pair(metrics).map(|pair| json!({ "mean": pair.mean, "peak": pair.peak }))),
        Measured::Number(number) if metric.unit == "s" => json!(number(metrics).map(time)),
        Measured::Number(number) => json!(number(metrics)),
        Measured::Count(count) => json!(count(metrics)),
    };
    Value::Object(table.iter().map(|metric| (metric.name.to_owned(), value(metric))).collect())
}

/// What contradicts each other in an infeasible program.
fn in_words(run: &Run, conflict: &[Condition]) -> Vec<String> {
    conflict.iter().map(|condition| condition.in_words(&run.model)).collect()
}

fn simulated(run: &Run) -> f64 {
    run.simulated_s
}

fn real_time_factor(run: &Run) -> f64 {
    simulated(run) / run.timing.wall_s.max(1e-9)
}
