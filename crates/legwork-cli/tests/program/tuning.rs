//! `legwork tune`: its tables, its files, and Ctrl-C.

use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::{Done, Folder};

/// A second of walking is a case, so that a candidate takes some milliseconds.
const SMALL: &str = r#"
name = "small"
description = "A small one."
budget = 6
[[factors]]
name = "CoM gain"
path = "controller.planner.com_gain"
logarithmic = { from = 500, to = 5000 }
[[cases]]
name = "a, short walk"
scenario = "my/walk.toml"
[[held_out]]
name = "fast"
scenario = "my/walk.toml"
set.reference.com.speed_mps = 0.55
[[objective]]
metric = "com_error_m.mean"
[[constraints]]
metric = "torque_nm.mean"
at_most_times_base = 1.0
"#;

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.file("my/walk.toml", "extends = \"walk\"\nname = \"short\"\nduration_s = 1\n");
    folder.file("small.toml", SMALL);
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_tuning_writes_its_folder_and_prints_base_against_tuned() {
    let folder = folder("tune");
    let done = folder.legwork(&["tune", "small.toml"]).succeeds();
    for words in ["small: A small one.", "6 candidates; the budget is spent", "CoM gain P_C [N/m]", "a, short walk"] {
        assert!(done.out.contains(words), "{words:?} is not in {}", done.out);
    }
    assert!(done.out.contains("training: 1 of 1 stand as they are, 1 of 1 tuned"), "{}", done.out);
    assert!(done.out.contains("held out: 1 of 1 stand as they are, 1 of 1 tuned"), "{}", done.out);
    assert!(done.out.lines().all(|line| line.chars().count() <= 80), "{}", done.out);
    assert_eq!(done.err, "scenario: legwork-tuning-small/short-tuned.toml\n");
    let inside = |name: &str| folder.text(&format!("legwork-tuning-small/{name}"));
    let names = [
        ".lock",
        ".lock-start",
        "cases.csv",
        "chunks",
        "history.csv",
        "results.json",
        "short-tuned.toml",
        "tuning.toml",
    ];
    let entries = folder.0.join("legwork-tuning-small").read_dir().unwrap();
    let mut found: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    found.sort();
    assert_eq!(found, names);
    assert_eq!(inside("history.csv").lines().count(), 1 + 2, "a generation of 4, and 2 of the next");
    let cases = inside("cases.csv");
    let rows: Vec<&str> = cases.lines().collect();
    assert!(
        rows[0]
            .starts_with("set,case,scenario,design,ending,fell_at_s,cause,violations,input_hash,com_error_m.mean [m],")
    );
    assert!(rows[1].starts_with("training,\"a, short walk\",short,base,completed,,,,"), "{}", rows[1]);
    assert_eq!(
        (rows.len(), rows[4].split(',').take(4).collect::<Vec<_>>().join(" ")),
        (5, "held-out fast short tuned".into())
    );
    // The scenario that was written gives the figures of the table.
    let run = &folder.json(&["run", "legwork-tuning-small/short-tuned.toml", "--json"])[0];
    let results: Value = serde_json::from_str(&inside("results.json")).unwrap();
    let tuned = &results["training"][0]["tuned"];
    assert_eq!(run["result_hash"], tuned["result_hash"]);
    assert_eq!(run["metrics"]["com_error_m"]["mean"], tuned["figures"]["com_error_m.mean"]);
    let score = number(&results["score"]["feasible"]);
    let com = |design: &str| number(&results["training"][0][design]["figures"]["com_error_m.mean"]);
    assert!(score <= 1.0 && (com("tuned") / com("base") - score).abs() < 1e-12);
    // It can be done again, in its folder and from its own copy, with the same end.
    let again = &folder.json(&["tune", "legwork-tuning-small/tuning.toml", "--json", "--threads", "1"])[0];
    assert_eq!(*again, results);
}

#[test]
fn folders_with_other_things_in_them_are_left_alone() {
    let folder = folder("tune-foreign");
    folder.file("out/thesis.pdf", "precious");
    let words = ["out: holds files (thesis.pdf) and no tuning: expected a new or empty folder"];
    folder.refuses(2, &["tune", "small.toml", "--out", "out"], &words);
    assert_eq!(
        (folder.names(), folder.text("out/thesis.pdf").as_str()),
        (vec!["my".into(), "out".into(), "small.toml".into()], "precious")
    );
    folder.file("file", "");
    folder.refuses(1, &["tune", "small.toml", "--out", "file"], &["file: "]);
    folder.refuses(
        2,
        &["tune", "small"],
        &["tuning: neither a built-in tuning nor a file is called \"small\"; built-in: thesis"],
    );
    folder.refuses(1, &["tune", "no/small.toml"], &["no/small.toml: neither a built-in tuning nor a file"]);
    folder.file("bad.toml", SMALL.replace("com_error_m.mean", "com_error"));
    folder.refuses(
        2,
        &["tune", "bad.toml"],
        &["bad.toml:16: objective.0: metric: found \"com_error\"; valid are com_error_m.mean"],
    );
    let lacks = SMALL.replace("com_error_m.mean", "recovery_time_s");
    folder.file("lacks.toml", lacks);
    let words = ["lacks.toml:16: objective.0: the case \"a, short walk\" has no recovery_time_s as it stands"];
    folder.refuses(2, &["tune", "lacks.toml", "--out", "new"], &words);
    let left = folder.0.join("new").read_dir().unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.into_iter().all(|name| name.to_string_lossy().starts_with(".lock")), "no half results");
    // What is put right is another tuning, and has the folder.
    folder.legwork(&["tune", "small.toml", "--out", "new"]).succeeds();
}

#[test]
fn the_folder_keeps_the_budget_and_the_candidates() {
    let folder = folder("tune-budget");
    let tune = |more: &[&str]| folder.legwork(&[&["tune", "small.toml", "--json"], more].concat()).succeeds();
    let first = tune(&["--budget", "9", "--out", "a"]);
    assert!(folder.text("a/tuning.toml").contains("\nbudget = 9\n"));
    let generation = folder.0.join("a/chunks/000000.jsonl");
    let modified = || std::fs::metadata(&generation).unwrap().modified().unwrap();
    let before = modified();
    let again = tune(&["--out", "a"]);
    // Two generations of 4; the ninth is run again.
    let said = "small: goes on; 8 of 9 candidates are there\n\
                small: a budget of 9, which the folder keeps; the file says 6, --budget gives another\n";
    assert_eq!((again.err.strip_prefix(said), &again.out), (Some("scenario: a/short-tuned.toml\n"), &first.out));
    let more = tune(&["--budget", "14", "--out", "a"]);
    assert!(more.err.starts_with("small: goes on; 8 of 14 candidates are there\n"), "{}", more.err);
    assert_eq!((more.out, modified()), (tune(&["--budget", "14", "--out", "b"]).out, before));
    assert!(folder.text("a/tuning.toml").contains("\nbudget = 14\n"));
    // Fewer are those that come first.
    let fewer = tune(&["--budget", "6", "--out", "a"]);
    assert_eq!(fewer.out, tune(&["--out", "c"]).out);
    assert!(fewer.err.starts_with("small: goes on; 6 of 6 candidates are there\n"), "{}", fewer.err);
}

#[test]
fn two_tunings_into_one_folder_wrote_one_over_the_other() {
    let folder = folder("tune-two");
    // A generation takes a second, and flatness shows after eleven.
    let large = SMALL.replace("budget", "population = 100\nbudget");
    folder.file("small.toml", &large);
    folder.file("long.toml", large.replace("budget = 6", "budget = 100_000"));
    let mut first = folder.command(&["tune", "long.toml", "--out", "a"]).stderr(Stdio::null()).spawn().unwrap();
    let begin = std::time::Instant::now();
    while !folder.0.join("a/chunks/000000.jsonl").exists() {
        assert!(begin.elapsed() < Duration::from_secs(120), "no generation was written");
        sleep(Duration::from_millis(10));
    }
    let words = ["a: another run writes into this folder: wait for its end, or choose another folder"];
    folder.refuses(1, &["tune", "long.toml", "--out", "a"], &words);
    first.kill().unwrap();
    first.wait().unwrap();
    folder.file("a/chunks/.000900.unfinished.jsonl", "half");
    folder.file("a/.results.unfinished.json", "half");
    folder.file("other.toml", large.replace("to = 5000", "to = 4000"));
    let words = ["a: holds another tuning (", ") than the given one (", "it says \"to = 5000.0\", not \"to = 4000.0\""];
    folder.refuses(2, &["tune", "other.toml", "--out", "a"], &words);
    folder.refuses(2, &["study", "merge", "a"], &["a: holds no study"]);
    // What the kill left is taken over and cleared.
    let done = folder.legwork(&["tune", "small.toml", "--out", "a", "--json", "--budget", "8"]).succeeds();
    assert!(done.err.starts_with("small: goes on; "), "{}", done.err);
    assert_eq!(
        done.out,
        folder.legwork(&["tune", "small.toml", "--json", "--budget", "8", "--out", "b"]).succeeds().out
    );
    let unfinished = |name: &str| {
        let entries = folder.0.join(name).read_dir().unwrap();
        entries.filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().contains("unfinished")).count()
    };
    assert_eq!((unfinished("a"), unfinished("a/chunks")), (0, 0));
}

#[test]
fn a_tuning_whose_rollouts_broke_bounds_says_so() {
    let folder = folder("tune-doubtful");
    folder.file("my/walk.toml", "extends = \"walk-spring-damper\"\nname = \"short\"\nduration_s = 1\n");
    let done = folder.legwork(&["tune", "small.toml"]).succeeds();
    let said = "warning: small: 4 of 4 rollouts broke bounds of the simulation; the column violations says which\n";
    assert!(done.err.ends_with(said), "{}", done.err);
    assert_eq!(done.out.matches("\n      broke bounds of the simulation").count(), 4, "{}", done.out);
    let cases = folder.text("legwork-tuning-small/cases.csv");
    assert_eq!(cases.lines().filter(|row| row.contains("penetration of the ground")).count(), 4, "{cases}");
    let history = folder.text("legwork-tuning-small/history.csv");
    let doubtful: Vec<&str> = history.lines().map(|line| line.split(',').nth(2).unwrap()).collect();
    assert_eq!(doubtful, ["doubtful", "4", "2"]);
    let results: Value = serde_json::from_str(&folder.text("legwork-tuning-small/results.json")).unwrap();
    assert!(results["held_out"][0]["tuned"]["violations"].as_str().unwrap().contains("penetration of the ground"));
}

#[cfg(unix)]
#[test]
fn what_an_interrupted_search_has_found_is_kept() {
    let folder = folder("tune-interrupt");
    // A generation of minutes, which cannot converge before the signal comes
    folder.file("small.toml", SMALL.replace("budget", "population = 10_000\nbudget"));
    let mut command = folder.command(&["tune", "small.toml", "--budget", "1000000", "--json", "--out", "out"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    sleep(Duration::from_secs(3));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("there is kill").success());
    let done = Done::from(child.wait_with_output().unwrap());
    assert_eq!(done.code, 130, "{}", done.err);
    assert!(
        done.err.ends_with(
            "interrupted; this is the best so far, and no held-out case was run; the same command goes on\n"
        ),
        "{}",
        done.err
    );
    let results: Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!((&results["why"], &results["held_out"]), (&"interrupted".into(), &Value::Array(Vec::new())));
    assert!(number(&results["evaluations"]) >= 1.0 && number(&results["score"]["feasible"]) <= 1.0);
    assert_eq!(folder.text("out/results.json"), format!("{results:#}\n"));
}
