//! Metrics are the same tick by tick and from a log, none where nothing tells what they are made of, and documented as they are
//! defined.

mod common;

use std::fmt::Debug;

use legwork::channel::{Channel, Columns, Field};
use legwork::log::Log;
use legwork::metrics::{FIGURES, JOINT_METRICS, METRICS, Measuring, Metric, Metrics, measure};

/// Every digit of every metric: two metrics of the same text have the same bits.
fn digits(metrics: &Metrics) -> String {
    format!("{metrics:?}")
}

#[test]
fn a_run_has_the_metrics_of_its_log() {
    for (name, sets) in [
        ("walk", ["duration_s=2", "metrics.from_s=0.5"]),
        ("push", ["pushes.0.start_s=0.5", "duration_s=6"]),
        ("push", ["pushes.0.force_n=1500", "metrics.from_s=100"]), // falls before its metrics count
        ("feet-walk", ["duration_s=5", "metrics.from_s=4"]),
        ("exo-sway", ["duration_s=2", "metrics.from_s=0.0005"]),
    ] {
        let run = common::run(name, &sets);
        assert_eq!(digits(&run.metrics), digits(&measure(&run.scenario, &run.model, &run.log)), "{name}");
        let counted = run.log.since(if run.scenario.metrics.from_s > 50.0 { 0.0 } else { run.scenario.metrics.from_s });
        let late = measure(&run.scenario, &run.model, &counted);
        // Steps, recovery and the steady walk know of what was before.
        let same = |m: &Metrics| Metrics {
            steps: None,
            recovery_time_s: None,
            recovery_distance_m: None,
            steady_speed_mps: None,
            steady_com_error_m: None,
            ..m.clone()
        };
        assert_eq!(digits(&same(&run.metrics)), digits(&same(&late)), "{name}");
        assert!(run.metrics.steps.is_some() && run.metrics.joints.len() == run.model.actuated().count(), "{name}");
    }
}

#[test]
fn recovery_ends_when_the_error_was_too_large_for_the_last_time() {
    let run = common::run("push", &[]);
    let (log, metrics) = (&run.log, &run.metrics);
    let begin = run.scenario.pushes[0].start_s;
    let out = (0..log.len()).rfind(|&index| {
        log.time(index) >= begin && legwork::metrics::com_error(log, index) > run.scenario.metrics.recovered_within_m
    });
    assert_eq!(metrics.recovery_time_s, out.map(|index| log.time(index + 1) - begin));
    let cut = common::run("push", &[format!("duration_s={}", begin + 0.3).as_str()]);
    assert_eq!(cut.metrics.recovery_time_s, None, "it ends while the error is too large");
}

/// A joint-space hold has neither a reference nor a program. It was a panic.
#[test]
fn what_nothing_tells_is_none() {
    let run = common::run("push", &["controller.kind=hold", "duration_s=0.5", "pushes.0.start_s=0.1"]);
    let has =
        |name: &str| FIGURES.iter().find(|figure| figure.name == name).expect("a figure").of(&run.metrics).is_some();
    for name in [
        "com_error_m.mean",
        "com_error_vertical_m.peak",
        "feet_error_m.mean",
        "torso_deviation_rad.peak",
        "grf_n.mean",
        "single_support_fraction",
        "steps",
        "recovery_time_s",
        "recovery_distance_m",
        "steady_com_error_m",
        "xcom_error_m.mean",
        "capture_steps",
        "uncapturable_fraction",
    ] {
        assert!(!has(name), "{name}");
    }
    for name in ["torque_nm.mean", "grf_simulated_n.peak", "u2_n2m2.mean", "mean_speed_mps", "xcom_margin_min_m"] {
        assert!(has(name), "{name}");
    }
    assert_eq!(run.metrics.joints.len(), 4);
}

/// Of a run that tells no more than every run does.
#[test]
fn a_physics_that_tells_no_forces_leaves_what_is_made_of_them_out() {
    let run = common::run("walk", &["duration_s=0.5"]);
    let told =
        [Field::Time, Field::Com, Field::ComVelocity, Field::Torso, Field::Feet, Field::Touching, Field::V, Field::Q];
    let kept = |channel: &&Channel| told.contains(&channel.field);
    let columns = Columns::new(run.log.columns().iter().filter(kept).cloned().collect()).expect("names that differ");
    let mut measuring = Measuring::new(&run.scenario, &run.model, &columns);
    let mut log = Log::new(columns, &run.model, run.log.len());
    for record in run.log.records() {
        let fields = run.log.columns().iter().zip(record);
        let values: Vec<f64> = fields.filter(|(channel, _)| kept(channel)).map(|(_, value)| *value).collect();
        measuring.take(&values);
        log.push(&values);
    }
    let metrics = measuring.finish();
    assert_eq!(digits(&metrics), digits(&measure(&run.scenario, &run.model, &log)));
    let measured = FIGURES.iter().filter(|figure| figure.of(&metrics).is_some()).map(|figure| figure.name.as_str());
    let expected = ["mean_speed_mps", "steady_speed_mps", "xcom_margin_min_m", "xcom_outside_fraction"];
    assert_eq!(measured.collect::<Vec<_>>(), expected);
    assert!(metrics.joints.is_empty());
}

/// `docs/metrics.md` has the definitions, in their order.
#[test]
fn the_documents_say_what_is_defined() {
    fn table<Of: Debug>(metrics: &[Metric<Of>]) -> String {
        let row = |metric: &Metric<Of>| {
            format!("| `{}` | {} | {} | {} |\n", metric.name, metric.unit, metric.kind(), metric.help)
        };
        format!(
            "| metric | unit | kind | definition |\n|---|---|---|---|\n{}\n",
            metrics.iter().map(row).collect::<String>()
        )
    }
    let text = include_str!("../../../docs/metrics.md");
    for table in [table(METRICS), table(JOINT_METRICS)] {
        assert!(text.contains(&table), "docs/metrics.md should have the table\n\n{table}");
    }
    for metric in METRICS {
        assert!(metric.help.ends_with('.') && !metric.label.is_empty(), "{}", metric.name);
    }
}
