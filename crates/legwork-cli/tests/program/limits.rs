//! `legwork limits`: tables, files, refusals, Ctrl-C.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::{Done, Folder};

/// Runs that are over soon: the push acts at 0.5 s.
const SHORT: [&str; 3] = ["--quick", "--set", "duration_s=0.9"];

fn limits<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["limits"], &SHORT[..], more].concat()
}

/// The rows of a CSV file of numbers and words without commas, by the names in its head.
fn rows(text: &str) -> Vec<Vec<(String, String)>> {
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    lines.map(|line| head.iter().zip(line.split(',')).map(|(a, b)| ((*a).to_owned(), b.to_owned())).collect()).collect()
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn the_same_answers_on_any_number_of_threads_with_every_key() {
    let folder = Folder::new("limits-threads");
    let [one, two] = ["1", "2"]
        .map(|threads| folder.legwork(&limits(&["--json", "--only", "limits", "--threads", threads])).succeeds());
    assert_eq!((&one.out, one.err.as_str()), (&two.out, ""));
    let report: Value = serde_json::from_str(&one.out).expect("JSON");
    assert_eq!(keys(&report), ["walk", "push", "quick", "interrupted", "limits", "robustness", "sizing", "map"]);
    assert_eq!(
        (&report["interrupted"], &report["sizing"], &report["map"]),
        (&false.into(), &Value::Null, &Value::Null)
    );
    let answers = report["limits"].as_array().expect("a list");
    let found =
        ["value", "first_failure", "reason_beyond", "violations", "force_n", "furthest_held", "rollouts", "tried"];
    assert_eq!(keys(&answers[0]), [&["scenario", "question", "unit"], &found[..]].concat());
    let of = |name: &str| answers.iter().filter(|answer| answer["scenario"] == name).count();
    assert_eq!((of("walk"), of("push")), (7, 5));
    for answer in answers {
        let tried = answer["tried"].as_array().expect("a list");
        assert!(answer["rollouts"].as_u64().is_some_and(|count| count as usize >= tried.len()), "{answer}");
        assert_eq!(answer["first_failure"].is_null(), tried.iter().all(|trial| trial["failure"].is_null()), "{answer}");
    }
}

#[test]
fn tables_for_people_fit_and_the_files_hold_the_same() {
    let folder = Folder::new("limits-tables");
    let done = folder.legwork(&limits(&["--out", "a/b", "--margin", "0.5"])).succeeds();
    assert_eq!(done.err, "report: a/b/report.html\n");
    for line in done.out.lines() {
        assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?}");
    }
    for title in
        ["Limits\n", "\n\nLargest impulse survived", "\n\nActuators\n", "with a margin of 50 %", "\n\nwalk by speed"]
    {
        assert!(done.out.contains(title), "{title:?} is not in {}", done.out);
    }
    let answers = rows(&folder.text("a/b/limits.csv"));
    assert_eq!(answers.len(), 12);
    for (row, scenario) in answers.iter().zip([["walk"; 7].as_slice(), &["push"; 5]].concat()) {
        let [name, question, unit, value] = [0, 1, 2, 3].map(|column| row[column].1.as_str());
        assert_eq!(name, scenario);
        let shown = done.out.lines().skip_while(|line| !line.trim_start().starts_with(scenario));
        let line = shown.into_iter().find(|line| line.trim_start().starts_with(question)).expect("it is shown");
        let value = if value.is_empty() { "none" } else { value.trim_end_matches(".0") };
        assert!(line.split_whitespace().any(|word| word == value) && line.contains(unit), "{line} {value}");
    }
    assert_eq!(rows(&folder.text("a/b/robustness.csv")).len(), 12);
    assert_eq!(rows(&folder.text("a/b/speed_torque_map.csv")).len(), 25);
    let demands = rows(&folder.text("a/b/sizing.csv"));
    let names: Vec<&str> = demands.iter().map(|row| row[0].1.as_str()).collect();
    assert_eq!(names.chunks(4).map(|four| four[0]).collect::<Vec<_>>(), ["walk", "push", "envelope", "required"]);
    let peak = |row: usize| demands[row][2].1.parse::<f64>().expect("a number");
    assert!((peak(12) - 1.5 * peak(0).max(peak(4))).abs() < 1e-9);
    let ticks: u32 = rows(&folder.text("a/b/torque_speed.csv"))
        .iter()
        .filter(|row| row[0].1 == "walk" && row[1].1 == "left_knee")
        .map(|row| row[6].1.parse::<u32>().expect("a count"))
        .sum();
    assert_eq!(ticks, 900);
}

#[test]
fn what_rests_on_broken_bounds_of_the_simulation_is_marked_everywhere() {
    let folder = Folder::new("limits-doubtful");
    let soft = ["limits", "--quick", "--walk", "walk-spring-damper", "--set", "duration_s=1.5", "--only", "sizing,map"];
    let done = folder.legwork(&[&soft[..], &["--out", "out"]].concat()).succeeds();
    let map = rows(&folder.text("out/speed_torque_map.csv"));
    let broken: Vec<bool> = map.iter().map(|row| row[8] != ("violations".to_owned(), String::new())).collect();
    let count = broken.iter().filter(|is_broken| **is_broken).count();
    assert!((1..=25).contains(&count), "{map:?}");
    let said = format!(
        "warning: 1 of 2 runs, {count} of 25 pairs rest on rollouts that broke bounds of the simulation; \
         the column violations says which\nreport: out/report.html\n"
    );
    assert_eq!(done.err, said);
    assert_eq!(done.out.matches('*').count(), count + 1, "with what the stars mean: {}", done.out);
    assert!(done.out.contains("\n    broke bounds of the simulation: "), "{}", done.out);
    let sizing = rows(&folder.text("out/sizing.csv"));
    let marked = |name: &str| sizing.iter().filter(|row| row[0].1 == name).all(|row| !row[8].1.is_empty());
    assert!(marked("walk-spring-damper") && !marked("push") && marked("envelope") && marked("required"));
    // A ring each, and one in the legend.
    let figure = folder.text("out/figures/speed-torque-map.svg");
    assert_eq!(figure.matches("<path class=\"doubtful\"").count(), count + 1);
    assert!(folder.text("out/report.html").contains("The run broke bounds of the simulation: "));
    let kept = folder.legwork(&["limits", "--quick", "--set", "duration_s=1", "--only", "sizing"]).succeeds();
    assert_eq!(kept.err, "");
    assert!(!kept.out.contains("broke bounds"));
}

#[test]
fn wrong_questions_are_refused_before_anything_runs() {
    let folder = Folder::new("limits-refused");
    folder.file("file", "");
    for (arguments, words) in [
        (&["--walk", "wlak"][..], "walk"),
        (&["--walk", "stand"], "stand: reference.com.trajectory: found a scenario that does not walk"),
        (&["--push", "walk"], "walk: pushes: found no push"),
        (&["--set", "ground.frction=1"], "--set ground.frction of walk: unknown; did you mean ground.friction?"),
        (&["--set", "pushes.3.force_n=1"], "--set pushes.3.force_n of push: pushes holds 1 element"),
    ] {
        folder.refuses(2, &[&["limits"], arguments].concat(), &[words]);
    }
    folder.refuses(1, &["limits", "--out", "file"], &["file: cannot be written: is a file; give the name of a folder"]);
    for (arguments, words) in [
        (["--only", "speed"], "limits, robustness, sizing, map"),
        (["--threads", "0"], "1..=1024"),
        (["--margin", "nan"], "valid is a number from 0 to 10"),
    ] {
        let done = folder.legwork(&[&["limits"], &arguments[..]].concat());
        assert_eq!((done.code, done.out.as_str()), (2, ""));
        assert!(done.err.contains(words), "{}", done.err);
    }
    assert_eq!(folder.names(), ["file"]);
}

#[test]
fn a_scenario_that_falls_as_it_stands_is_a_result() {
    let folder = Folder::new("limits-none");
    let done =
        folder.legwork(&limits(&["--only", "limits,sizing", "--set", "controller.limits.torque_nm=5"])).succeeds();
    let row = done.out.lines().find(|line| line.contains("lowest torque limit")).expect("it is asked");
    assert_eq!(row.split_whitespace().skip(4).collect::<Vec<_>>(), ["none", "5"]);
    assert!(done.out.contains("  push\n") && done.out.contains("fell at "), "{}", done.out);
}

#[cfg(unix)]
#[test]
fn what_was_finished_is_kept_at_ctrl_c() {
    let folder = Folder::new("limits-interrupt");
    let long = ["limits", "--set", "duration_s=100", "--only", "sizing,limits", "--out", "kept", "--json"];
    let child = folder.command(&long).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    sleep(Duration::from_secs(4));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("there is kill").success());
    let done = Done::from(child.wait_with_output().expect("it ends"));
    assert_eq!(
        (done.code, done.err.as_str()),
        (130, "interrupted; what was finished is kept\nreport: kept/report.html\n")
    );
    let report: Value = serde_json::from_str(&done.out).expect("JSON");
    assert_eq!(report["interrupted"], true);
    assert!(report["limits"].as_array().is_some_and(|answers| answers.len() < 12));
    assert!(folder.text("kept/sizing.csv").starts_with("scenario,joint,"));
}
