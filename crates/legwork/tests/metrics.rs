//! Metrics are the same tick by tick and from a log, none where nothing tells what they are made of, and documented as they are
//! defined.

mod common;

use std::collections::{HashMap, HashSet};
use std::fmt::Debug;

use legwork::channel::{Channel, Columns, Field};
use legwork::episode::Run;
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
        ("feet-walk", ["duration_s=8", "metrics.from_s=7.5"]),
        ("exo-sway", ["duration_s=2", "metrics.from_s=0.0005"]),
    ] {
        let run = common::run(name, &sets);
        assert_eq!(digits(&run.metrics), digits(&measure(&run.scenario, &run.model, &run.log)), "{name}");
        let counted = run.log.since(if run.scenario.metrics.from_s > 50.0 { 0.0 } else { run.scenario.metrics.from_s });
        let late = measure(&run.scenario, &run.model, &counted);
        // Steps and recovery know of what was before.
        let same = |m: &Metrics| Metrics { steps: None, recovery_time_s: None, recovery_distance_m: None, ..m.clone() };
        assert_eq!(digits(&same(&run.metrics)), digits(&same(&late)), "{name}");
    }
}

/// The figures of a run as docs/metrics.md defines them, each from whole columns of the log; of the balance where it is logged.
fn by_definition(run: &Run) -> HashMap<String, f64> {
    let (log, settings) = (&run.log, &run.scenario.metrics);
    let axes = log.range(Field::Com).len();
    let from = |time: f64| (0..log.len()).filter(move |&i| log.time(i) >= time - 1e-9);
    let (counted, late) = (|| from(settings.from_s), || from(settings.from_s.max(settings.com_error_from_s)));
    let get = |i: usize, field| log.get(i, field);
    let length = |vector: &[f64]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart = |a: &[f64], b: &[f64]| length(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>());
    let com_error = |i: usize| apart(get(i, Field::Com), &get(i, Field::ComReference)[..axes]);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let peak = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut found = HashMap::new();
    let mut pair = |name: &str, values: Vec<f64>| {
        found.insert(format!("{name}.mean"), mean(&values));
        found.insert(format!("{name}.peak"), peak(&values));
    };
    pair("com_error_m", late().map(com_error).collect());
    let vertical = |i: usize| (get(i, Field::Com)[axes - 1] - get(i, Field::ComReference)[axes - 1]).abs();
    pair("com_error_vertical_m", late().map(vertical).collect());
    let foot = |i: usize, foot: usize| {
        let reference = &get(i, Field::FeetReference)[foot * 3 * axes..][..axes];
        apart(&log.foot(i, foot).collect::<Vec<_>>(), reference)
    };
    pair("feet_error_m", counted().flat_map(|i| [foot(i, 0), foot(i, 1)]).collect());
    let torso = |i: usize| (get(i, Field::Torso)[0] - get(i, Field::TorsoReference)[0]).abs();
    pair("torso_deviation_rad", counted().map(torso).collect());
    pair("torque_nm", counted().flat_map(|i| get(i, Field::Torque)).map(|torque| torque.abs()).collect());
    pair("u2_n2m2", counted().map(|i| length(get(i, Field::Torque)).powi(2)).collect());
    for (name, field) in [("grf_n", Field::Grf), ("grf_simulated_n", Field::GrfSimulated)] {
        pair(name, counted().flat_map(|i| get(i, field).chunks(axes)).map(length).collect());
    }
    let balance = !log.range(Field::Balance).is_empty();
    // Along x, and along y eight columns on.
    let of_balance = |i: usize, k: usize| get(i, Field::Balance).iter().copied().skip(k).step_by(8).collect::<Vec<_>>();
    if balance {
        pair("cmp_offset_m", counted().map(|i| apart(&of_balance(i, 5), &of_balance(i, 2))).collect());
        pair("xcom_error_m", late().map(|i| apart(get(i, Field::Xcom), &of_balance(i, 1))).collect());
    }
    let share = |is: &dyn Fn(usize) -> bool| mean(&counted().map(|i| f64::from(u8::from(is(i)))).collect::<Vec<_>>());
    let mut one = |name: &str, value: f64| _ = found.insert(name.to_owned(), value);
    if balance {
        one("xcom_margin_min_m", counted().map(|i| get(i, Field::Balance)[6]).fold(f64::INFINITY, f64::min));
        one("xcom_outside_fraction", share(&|i| get(i, Field::Balance)[6] < 0.0));
        one("uncapturable_fraction", share(&|i| get(i, Field::Balance)[7] < 0.0));
        one("capture_steps", peak(&counted().map(|i| get(i, Field::Balance)[7]).collect::<Vec<_>>()));
    }
    one("single_support_fraction", share(&|i| get(i, Field::Swing)[0] >= 0.0));
    let begins = |i: &usize| *i > 0 && get(*i, Field::Swing)[1] > get(*i - 1, Field::Swing)[1];
    one("steps", counted().filter(begins).count() as f64);
    let speed = |since: f64| {
        let (first, last) = (from(since).next().expect("a record"), log.len() - 1);
        (get(last, Field::Com)[0] - get(first, Field::Com)[0]) / (log.time(last) - log.time(first))
    };
    let mean_speed = speed(settings.from_s);
    one("mean_speed_mps", mean_speed);
    if let Some(commanded) = run.scenario.reference.commanded_speed().filter(|commanded| commanded.speed_mps != 0.0) {
        let steady = commanded.steady_from_s.max(settings.from_s);
        one("steady_speed_mps", speed(steady));
        one(
            "steady_com_error_m",
            mean(&late().filter(|&i| log.time(i) >= steady - 1e-9).map(com_error).collect::<Vec<_>>()),
        );
    }
    if let Some(push) = run.scenario.pushes.first().filter(|push| push.start_s < run.simulated_s) {
        let distance = |i: usize| (get(i, Field::Com)[0] - get(i, Field::ComReference)[0]).abs();
        one("recovery_distance_m", peak(&from(push.start_s).map(distance).collect::<Vec<_>>()));
    }
    let mut power = 0.0;
    for (index, dof) in run.model.actuated().enumerate() {
        let joint = &run.metrics.joints[index];
        assert_eq!(joint.joint, run.model.dofs[dof].name);
        let torque: Vec<f64> = counted().map(|i| get(i, Field::TorqueApplied)[index]).collect();
        let speed: Vec<f64> = counted().map(|i| get(i, Field::V)[dof]).collect();
        let powers: Vec<f64> = torque.iter().zip(&speed).map(|(torque, speed)| (torque * speed).abs()).collect();
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        power += mean(&powers);
        let expected = [
            largest(&torque),
            length(&torque) / (torque.len() as f64).sqrt(),
            largest(&speed),
            peak(&powers),
            mean(&powers),
        ];
        for (metric, expected) in JOINT_METRICS.iter().zip(expected) {
            let found = metric.of(joint)[0].expect("a number");
            assert!((found - expected).abs() <= 1e-12 * expected, "{} {}: {found}", joint.joint, metric.name);
        }
    }
    if mean_speed.abs() >= 0.05 {
        one("cost_of_transport", power / (run.model.total_mass() * run.model.gravity * mean_speed.abs()));
    }
    found
}

#[test]
fn every_figure_is_what_the_documents_define() {
    let mut compared = HashSet::new();
    for (name, sets) in [
        ("walk", &["duration_s=3", "metrics.from_s=0.7", "metrics.com_error_from_s=0.9"] as &[&str]),
        ("walk", &["duration_s=2", "simulation.actuators.lag_s=0.001"]),
        ("feet-walk", &["duration_s=8", "metrics.from_s=6.5", "metrics.com_error_from_s=0.9"]),
        ("stand-push", &["duration_s=2", "pushes.0.start_s=0.5"]),
        ("exo-sway", &["duration_s=1"]),
    ] {
        let run = common::run(name, sets);
        let expected = by_definition(&run);
        for figure in FIGURES.iter() {
            let Some(expected) = expected.get(&figure.name) else { continue };
            let found = figure.of(&run.metrics).unwrap_or(f64::NAN);
            assert!(
                (found - expected).abs() <= 1e-9 * expected.abs(),
                "{name} {}: {found}, not {expected}",
                figure.name
            );
            compared.insert(&figure.name);
        }
    }
    let left: Vec<_> = FIGURES.iter().map(|figure| &figure.name).filter(|name| !compared.contains(name)).collect();
    assert_eq!(left, ["recovery_time_s"], "which another test has");
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

#[test]
fn another_first_push_begins_its_recovery_anew_and_another_setting_does_not() {
    let run = common::run("push", &["pushes.0.start_s=0.5", "duration_s=3"]);
    let log = &run.log;
    let distance = |i: usize| (log.get(i, Field::Com)[0] - log.get(i, Field::ComReference)[0]).abs();
    let farthest = (0..log.len()).max_by(|&a, &b| distance(a).total_cmp(&distance(b))).expect("records");
    let begin = log.time(farthest + 200);
    let mut later = run.scenario.clone();
    later.pushes[0].start_s = begin;
    let after = (0..log.len()).filter(|&i| log.time(i) >= begin).map(distance).fold(0.0, f64::max);
    for (other, expected) in [(&run.scenario, run.metrics.recovery_distance_m), (&later, Some(after))] {
        let mut measuring = Measuring::new(&run.scenario, &run.model, log.layout());
        for (i, record) in log.records().enumerate() {
            if log.time(i) == begin {
                measuring.change(other, &run.model);
            }
            measuring.take(record);
        }
        assert_eq!(measuring.finish().recovery_distance_m, expected);
    }
    assert!(run.metrics.recovery_distance_m > Some(after));
}

#[test]
fn a_push_that_is_too_strong_leaves_ticks_without_a_number_of_steps() {
    let run = common::run("stand-push", &["duration_s=1", "pushes.0.start_s=0.3", "pushes.0.force_n=1500"]);
    let supported = |i: &usize| run.log.get(*i, Field::Touching).contains(&1.0);
    let ticks = (0..run.log.len()).filter(supported).count();
    let lost = (0..run.log.len()).filter(supported).filter(|&i| run.log.get(i, Field::Balance)[7] < 0.0).count();
    assert!(lost > 0 && ticks < run.log.len(), "{lost} of {ticks}");
    assert_eq!(run.metrics.uncapturable_fraction, Some(lost as f64 / ticks as f64));
}

#[test]
fn a_commanded_speed_that_changes_is_no_constant_one() {
    let run = common::run("walk", &["duration_s=2"]);
    let mut faster = run.scenario.clone();
    faster.reference.com.speed_mps += 0.1;
    for (other, expected) in [(&run.scenario, run.metrics.steady_speed_mps), (&faster, None)] {
        let mut measuring = Measuring::new(&run.scenario, &run.model, run.log.layout());
        for (i, record) in run.log.records().enumerate() {
            if i == 1500 {
                measuring.change(other, &run.model);
            }
            measuring.take(record);
        }
        assert_eq!(measuring.finish().steady_speed_mps, expected);
    }
}

#[test]
fn one_record_has_no_speed() {
    let metrics = common::run("walk", &["duration_s=0.001", "metrics.from_s=0"]).metrics;
    assert_eq!((metrics.mean_speed_mps, metrics.steady_speed_mps, metrics.cost_of_transport), (0.0, None, None));
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
