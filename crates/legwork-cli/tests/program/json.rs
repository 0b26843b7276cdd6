//! The contract of `run --json`: every key, its type, and null where there is nothing.

use std::collections::BTreeSet;

use legwork::metrics::{FIGURES, JOINT_METRICS};
use serde_json::{Value, json};

use crate::Folder;

/// The shape of a value: its keys, and below them the names of types.
fn shape(value: &Value) -> Value {
    match value {
        Value::Null => json!("null"),
        Value::Bool(_) => json!("bool"),
        Value::Number(number) if number.is_f64() => json!("number"),
        Value::Number(_) => json!("count"),
        Value::String(_) => json!("text"),
        Value::Array(_) => json!("list"),
        Value::Object(object) => object.iter().map(|(key, value)| (key.clone(), shape(value))).collect(),
    }
}

/// The shape of a run that stood and was not pushed.
fn contract() -> Value {
    let pair = json!({ "mean": "number", "peak": "number" });
    let joint = json!({
        "torque_peak_nm": "number",
        "torque_rms_nm": "number",
        "speed_peak_radps": "number",
        "power_peak_w": "number",
        "power_mean_w": "number",
    });
    json!({
        "scenario": "text",
        "outcome": "text",
        "fell_at_s": "null",
        "reason": "null",
        "cause": "null",
        "input_hash": "text",
        "result_hash": "text",
        "metrics": {
            "com_error_m": pair,
            "com_error_vertical_m": pair,
            "feet_error_m": pair,
            "torso_deviation_rad": pair,
            "torque_nm": pair,
            "grf_n": pair,
            "grf_simulated_n": pair,
            "u2_n2m2": pair,
            "single_support_fraction": "number",
            "steps": "count",
            "recovery_time_s": "null",
            "recovery_distance_m": "null",
            "mean_speed_mps": "number",
            "steady_speed_mps": "null",
            "steady_com_error_m": "null",
            "xcom_error_m": pair,
            "xcom_margin_min_m": "number",
            "xcom_outside_fraction": "number",
            "cmp_offset_m": pair,
            "capture_steps": "count",
            "uncapturable_fraction": "number",
            "cost_of_transport": "null",
            "joints": { "right_hip": joint, "right_knee": joint, "left_hip": joint, "left_knee": joint },
        },
        "audit": {
            "energy_error_j": "number",
            "work_j": "number",
            "contact_loss_j": "number",
            "contact_gain_j": "number",
            "momentum_error_mps": "number",
            "penetration_m": "number",
            "friction_excess_n": "number",
            "friction_angle_deg": "number",
            "pull_n": "number",
            "slip_m": "number",
            "contact_sweeps_max": "count",
            "contact_residual_n": "number",
            "violations": "list",
        },
        "limits_passed": "list",
        "qp": {
            "solves": "count",
            "infeasible": "count",
            "first_infeasible": "null",
            "fallbacks": "count",
            "iterations_mean": "number",
            "iterations_max": "count",
        },
        "timing": {
            "tick_us": { "p50": "number", "p99": "number", "max": "number" },
            "wall_s": "number",
            "simulated_s": "number",
            "real_time_factor": "number",
        },
    })
}

/// No key holds the value of another: each figure is that of the same run in the library.
#[test]
fn every_figure_is_the_runs() {
    let line = &Folder::new("audit").json(&["run", "push", "--duration", "2", "--json"])[0];
    let loaded = legwork::scenario_file::load("push", &["duration_s=2".to_owned()]).unwrap();
    let run = legwork::episode::run(&loaded.scenario, &loaded.model().unwrap(), &[], |_| false).unwrap();
    let audit = run.audit.unwrap();
    let figures = [
        ("energy_error_j", audit.energy_error_j),
        ("work_j", audit.work_j),
        ("contact_loss_j", audit.contact_loss_j),
        ("contact_gain_j", audit.contact_gain_j),
        ("momentum_error_mps", audit.momentum_error_mps),
        ("penetration_m", audit.penetration_m),
        ("friction_excess_n", audit.friction_excess_n),
        ("friction_angle_deg", audit.friction_angle_deg),
        ("pull_n", audit.pull_n),
        ("slip_m", audit.slip_m),
        ("contact_sweeps_max", f64::from(audit.contact_sweeps)),
        ("contact_residual_n", audit.contact_residual_n),
    ];
    for (key, value) in figures {
        assert_eq!(line["audit"][key].as_f64(), Some(value), "{key}");
    }
    assert_eq!(line["audit"].as_object().unwrap().len(), figures.len() + 1, "and the violations");
    assert!(audit.contact_loss_j > 1.0 && audit.slip_m > 0.0, "figures that are zero tell nothing");
    let program = &run.program;
    let counts = [
        ("solves", program.solves as f64),
        ("infeasible", program.infeasible as f64),
        ("fallbacks", program.fallbacks as f64),
        ("iterations_mean", program.iterations_mean),
        ("iterations_max", f64::from(program.iterations_max)),
    ];
    for (key, count) in counts {
        assert_eq!(line["qp"][key].as_f64(), Some(count), "{key}");
    }
    assert!(program.iterations_mean > 0.0 && program.solves >= 2000);
    // A time in JSON is rounded to the nanosecond.
    let same = |found: &Value, value: Option<f64>| match value {
        Some(value) => found.as_f64().is_some_and(|found| (found - value).abs() <= 1e-9 * value.abs()),
        None => found.is_null(),
    };
    for figure in FIGURES.iter() {
        let path = format!("/metrics/{}", figure.name.replace('.', "/"));
        let found = line.pointer(&path).unwrap_or(&Value::Null);
        assert!(same(found, figure.of(&run.metrics)), "{path} is {found}");
    }
    for (joint, metric) in run.metrics.joints.iter().flat_map(|joint| JOINT_METRICS.iter().map(move |m| (joint, m))) {
        let found = &line["metrics"]["joints"][&joint.joint][metric.name];
        assert!(same(found, metric.of(joint)[0]), "{} {} is {found}", joint.joint, metric.name);
    }
    assert!(same(&line["timing"]["simulated_s"], Some(2.0)));
    assert_eq!(line["input_hash"], format!("{:032x}", run.input_hash));
    assert_eq!(line["result_hash"], format!("{:032x}", run.result_hash));
}

#[test]
fn a_line_a_scenario_with_every_key() {
    let folder = Folder::new("contract");
    let lines = folder.json(&["run", "stand", "walk", "walk", "--duration", "0.5", "--json"]);
    assert_eq!(
        lines.iter().map(|line| line["scenario"].as_str().unwrap()).collect::<Vec<_>>(),
        ["stand", "walk", "walk"]
    );
    assert_eq!(lines[1]["result_hash"], lines[2]["result_hash"]);

    for line in &lines {
        let mut expected = contract();
        if line["scenario"] == "walk" {
            for name in ["cost_of_transport", "steady_speed_mps", "steady_com_error_m"] {
                expected["metrics"][name] = json!("number");
            }
        }
        assert_eq!(shape(line), expected);
        assert_eq!(line["outcome"], "completed");
        assert_eq!(line["timing"]["simulated_s"], 0.5);
        assert_eq!(line["audit"]["violations"], json!([]));
        for hash in [&line["input_hash"], &line["result_hash"]] {
            let hash = hash.as_str().unwrap();
            assert!(hash.len() == 32 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()), "{hash}");
        }
    }
    assert!(lines[0]["qp"]["solves"].as_u64().is_some_and(|solves| solves >= 500));
}

/// What is listed is what a run has.
#[test]
fn every_metric_that_is_listed_is_in_the_run() {
    let folder = Folder::new("listed-metrics");
    let listed = &folder.json(&["list", "metrics", "--json"])[0];
    let run = &folder.json(&["run", "stand", "--duration", "0.02", "--json"])[0];
    let names = |table: &str| -> Vec<String> {
        let metrics = listed[table].as_array().expect("a list").iter();
        metrics.map(|metric| metric["name"].as_str().expect("a name").to_owned()).collect()
    };
    let keys = |value: &Value| value.as_object().expect("an object").keys().cloned().collect::<BTreeSet<_>>();
    let with_joints = names("metrics").into_iter().chain(["joints".to_owned()]).collect();
    assert_eq!(keys(&run["metrics"]), with_joints);
    assert_eq!(keys(&run["metrics"]["joints"]["left_knee"]), names("joint_metrics").into_iter().collect());
    // The CoM error counts from 0.4 s on, and a joint-space hold has no reference for the feet.
    assert_eq!(run["metrics"]["com_error_m"], Value::Null);
    let hold = &folder.json(&["run", "stand", "--duration", "0.02", "--set", "controller.kind=hold", "--json"])[0];
    assert_eq!((&run["metrics"]["steps"], &hold["metrics"]["steps"]), (&json!(0), &Value::Null));
    assert_eq!((keys(&hold["metrics"]), &hold["metrics"]["feet_error_m"]), (keys(&run["metrics"]), &Value::Null));
}

#[test]
fn a_fall_has_a_time_and_a_reason_and_a_recovery_a_time() {
    let folder = Folder::new("falls");
    let absurd = ["--set", "ground.friction=0.02", "--set", "pushes.0.force_n=5000"];
    let fell = &folder.json(&[&["run", "push", "--json"], &absurd[..]].concat())[0];
    let mut expected = contract();
    (expected["fell_at_s"], expected["reason"]) = (json!("number"), json!("text"));
    expected["cause"] = json!("text");
    expected["metrics"]["recovery_distance_m"] = json!("number");
    expected["metrics"]["cost_of_transport"] = json!("number");
    assert_eq!((&fell["outcome"], shape(fell)), (&json!("fell"), expected));
    let begin = format!("fell at {:.2} s: ", fell["fell_at_s"].as_f64().unwrap());
    assert!(fell["reason"].as_str().unwrap().starts_with(&begin), "{fell}");

    let recovered = &folder.json(&["run", "push", "--json"])[0];
    let mut expected = contract();
    expected["metrics"]["recovery_distance_m"] = json!("number");
    expected["metrics"]["recovery_time_s"] = json!("number");
    // Its point feet strike the ground with 8.4 kN.
    assert_eq!((&recovered["outcome"], shape(recovered)), (&json!("injurious"), expected));

    let too_short = &folder.json(&["run", "push", "--set", "pushes.0.start_s=0.1", "--duration", "0.5", "--json"])[0];
    assert_eq!(too_short["metrics"]["recovery_time_s"], Value::Null);
    assert!(too_short["metrics"]["recovery_distance_m"].as_f64().is_some_and(|distance| distance > 0.1));
}

/// It was said to have recovered at once, by 0 m.
#[test]
fn a_run_that_ends_before_the_push_recovers_from_nothing() {
    let folder = Folder::new("before");
    let line = &folder.json(&["run", "push", "--set", "pushes.0.start_s=1", "--duration", "0.5", "--json"])[0];
    assert_eq!(shape(line), contract());
}

#[test]
fn a_fall_is_no_failure_unless_standing_was_expected() {
    let folder = Folder::new("standing");
    let fall = ["run", "stand", "--set", "controller.limits.torque_nm=1"];
    let done = folder.legwork(&fall).succeeds();
    assert!(done.out.starts_with("stand: fell at "), "{}", done.out);
    let done = folder.legwork(&[&fall[..], &["--expect-standing", "--json"]].concat());
    assert_eq!(done.code, 1);
    assert!(done.out.contains("\"outcome\":\"fell\"") && done.out.lines().count() == 1, "{}", done.out);
    folder.legwork(&["run", "stand", "--duration", "0.1", "--expect-standing"]).succeeds();
}

#[test]
fn words_go_to_stderr_and_data_to_stdout() {
    let folder = Folder::new("words-and-data");
    let files = ["--log", "a.csv", "--report", "a.html", "--plots", "plots"];
    let done = folder.legwork(&[&["run", "stand", "--duration", "0.02", "--json"], &files[..]].concat()).succeeds();
    assert_eq!(done.out.lines().count(), 1);
    assert_eq!(done.err, "log: a.csv\nplots: plots\nreport: a.html\n");
}
