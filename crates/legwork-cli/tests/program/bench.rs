//! `legwork bench`: what it says, not how long things take.

use std::process::Stdio;

use serde_json::Value;

use crate::Folder;

/// A rollout that is over at once, in as few rounds as there are.
const SHORT: [&str; 4] = ["--set", "duration_s=0.3", "--seconds", "0.1"];

fn bench<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["bench"], &SHORT[..], more].concat()
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn every_figure_is_there_and_they_agree_with_each_other() {
    let folder = Folder::new("bench-json");
    let report = folder.json(&bench(&["push", "--set", "duration_s=0.9", "--json"])).remove(0);
    assert_eq!(keys(&report), ["machine", "interrupted", "scenarios"]);
    assert_eq!(report["interrupted"], false);
    let machine = &report["machine"];
    assert!(machine["rustc"].as_str().is_some_and(|text| text.starts_with("rustc 1.")), "{machine}");
    assert_eq!(machine["legwork"], env!("CARGO_PKG_VERSION"));

    let push = &report["scenarios"][0];
    assert_eq!((&push["scenario"], &push["ticks"], &push["dofs"]), (&"push".into(), &900.into(), &7.into()));
    assert!(push["rounds"].as_u64().is_some_and(|rounds| rounds >= 3), "{}", push["rounds"]);
    let parts = push["parts"].as_array().expect("a list");
    let names: Vec<&Value> = parts.iter().map(|part| &part["part"]).collect();
    assert_eq!(names, ["dynamics", "references, goals", "assembly", "solve", "reading"]);
    for times in parts.iter().chain(["tick", "step", "step_under_random_torques"].map(|name| &push[name])) {
        let quantiles = ["median_us", "p99_us", "p999_us", "max_us"].map(|name| number(&times[name]));
        assert!(quantiles.is_sorted() && quantiles[0] > 0.0, "{times}");
        assert!(number(&times["slowest_input_us"]) >= number(&times["mean_us"]), "{times}");
    }
    let share = number(&parts[3]["mean_us"]) / number(&push["tick"]["mean_us"]);
    assert!((number(&parts[3]["share"]) - share).abs() < 1e-9);

    let histogram = &push["tick_histogram"];
    let shares: f64 = histogram["shares"].as_array().expect("a list").iter().map(number).sum();
    assert!((shares + number(&histogram["above"]) - 1.0).abs() < 1e-9, "{histogram}");
    let threads = push["threads"].as_array().expect("a list");
    assert_eq!((&threads[0]["threads"], number(&threads[0]["speed_up"])), (&1.into(), 1.0));
    assert_eq!(threads.last().expect("one")["threads"], machine["cores"]);
    assert!(threads.iter().all(|row| number(&row["steps_per_s"]) > number(&row["rollouts_per_s"])), "{threads:?}");

    // What does not depend on the machine is what `run` says.
    let run = folder.json(&["run", "push", "--duration", "0.9", "--json"]).remove(0);
    let solver = &push["solver"];
    assert_eq!(solver["iterations_mean"], run["qp"]["iterations_mean"], "{}", run["qp"]);
    assert_eq!(solver["iterations_max"], run["qp"]["iterations_max"]);
    assert!(number(&solver["iterations_max"]) > 0.0 && number(&solver["programs_mean"]) >= 1.0, "{solver}");
}

#[test]
fn tables_fit_a_terminal() {
    let folder = Folder::new("bench-tables");
    let done = folder.legwork(&bench(&[])).succeeds();
    for line in done.out.lines() {
        assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?}");
    }
    for word in [
        "walk: 7 degrees of freedom",
        "push: ",
        "control tick",
        "parts together",
        "speed-up",
        "█",
        "which is taken off",
    ] {
        assert!(done.out.contains(word), "{word:?} is not in\n{}", done.out);
    }
}

#[test]
fn wrong_invocations() {
    let folder = Folder::new("bench-wrong");
    folder.refuses(2, &["bench", "wlak"], &["wlak", "walk"]);
    folder.refuses(2, &bench(&["--set", "ground.friction=-1"]), &["--set ground.friction of walk", "found -1"]);
    let done = folder.legwork(&["bench", "--seconds", "0"]);
    assert_eq!((done.code, done.out.as_str()), (2, ""));
    assert!(done.err.contains("from 0.1 to 3600"), "{}", done.err);
    assert!(folder.names().is_empty());
}

/// The first scenario is measured for ten minutes, the second never.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_rounds_that_were_finished() {
    let folder = Folder::new("bench-interrupt");
    let mut command = folder.command(&["bench", "--set", "duration_s=1", "--seconds", "600", "--json"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it can be started");
    std::thread::sleep(std::time::Duration::from_secs(3));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("there is kill").success());
    let done = crate::Done::from(child.wait_with_output().expect("it ends"));
    assert_eq!(done.code, 130, "{}", done.err);
    assert!(done.err.ends_with("interrupted; what was finished is kept\n"), "{}", done.err);
    let report: Value = serde_json::from_str(&done.out).expect("JSON");
    assert_eq!(report["interrupted"], true);
}
