//! `legwork reproduce`: once as a whole, its wrong calls, its interruption.

use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::{Done, Folder};

const DOCUMENT: &str = include_str!("../../../../docs/reproduction.md");

#[test]
fn page_figures_data_and_document_say_the_same() {
    let folder = Folder::new("reproduce");
    let [result] = &folder.json(&["reproduce", "--out", "all", "--json"])[..] else { panic!("one object") };
    let at = |name: &str| folder.text(&format!("all/{name}"));
    assert_eq!(serde_json::from_str::<Value>(&at("results.json")).unwrap(), *result);

    let page = at("report.html");
    assert!(
        page.contains("</html>") && !page.contains("NaN") && !page.contains("http://") && !page.contains("https://")
    );
    let claims = result["claims"].as_array().unwrap();
    assert!(claims.len() > 60);
    let mut counts = [[0; 4]; 2];
    for claim in claims {
        let id = claim["id"].as_str().unwrap();
        assert!(page.contains(&format!("id=\"claim-{id}\"")), "{id}");
        let verdicts = [0, 1].map(|k: usize| claim["findings"][k]["verdict"].as_str().unwrap());
        let names = ["reproduced", "partly", "not"];
        let basis = claim["basis"].as_str();
        for (counts, verdict) in counts.iter_mut().zip(verdicts) {
            counts[names.iter().position(|name| *name == verdict).unwrap()] += 1;
            counts[3] += usize::from(verdict == "reproduced" && basis.is_some());
        }
        // What the document says is what is measured.
        let says = match basis {
            Some(basis) => format!("{} ({})", claim["says"].as_str().unwrap(), basis.replace('-', " ")),
            None => claim["says"].as_str().unwrap().to_owned(),
        };
        let row = format!("| {id} | {says} | {} | {} |", verdicts[0], verdicts[1]);
        assert!(DOCUMENT.contains(&row), "docs/reproduction.md should have the row\n{row}");
        // Who doubts a claim finds its figures in the files beside the page.
        let file = claim["source"]["file"].as_str().unwrap();
        let there = |name: String| folder.0.join("all").join(name).exists();
        let table = there(format!("{file}.csv")) && there(format!("{file}.parquet"));
        assert!(table || (file == "logs" && there("logs/walk.parquet".to_owned())), "{id}: {file}");
    }
    for (name, counts) in ["way of the foot", "base of support"].iter().zip(counts) {
        let [reproduced, partly, not, without_evidence] = counts;
        let row = format!("| {name} | {reproduced} | {partly} | {not} | {without_evidence} |");
        assert!(DOCUMENT.contains(&row), "docs/reproduction.md should have the row\n{row}");
    }
    for table in ["6.1", "6.2", "6.3", "6.4", "6.5"] {
        assert!(page.contains(&format!("Table {table}: ")), "{table}");
    }
    // Two figures for each of the nine parameters, and those of the runs
    for study in [
        "torque-limit",
        "grf-limit",
        "grf-weight",
        "acceleration-weight",
        "momentum-weight",
        "feet-weight",
        "torso-weight",
        "com-gain",
        "foot-gain",
    ] {
        for experiment in ["walk", "push"] {
            assert!(at(&format!("figures/{study}-{experiment}.svg")).ends_with("</svg>\n"));
        }
    }
    for name in ["walk-tracking-x", "push-support-baseline-tracking-z", "push-poses", "walk-support-torques"] {
        assert!(at(&format!("figures/{name}.svg")).ends_with("</svg>\n"), "{name}");
    }
    for question in result["questions"].as_array().unwrap() {
        assert!(page.contains(&question["asks"].as_str().unwrap().replace('&', "&amp;")), "{question}");
    }
}

#[test]
fn wrong_calls_are_refused() {
    let folder = Folder::new("reproduce-wrong");
    folder.file("file", "");
    folder.refuses(1, &["reproduce", "--out", "file"], &["file"]);
    folder.refuses(1, &["reproduce", "--out", "file/below"], &["file/below"]);
    let done = folder.legwork(&["reproduce", "--threads", "0"]);
    assert_eq!((done.code, done.out.as_str()), (2, ""));
    assert!(done.err.contains("1..=1024"), "{}", done.err);
}

#[cfg(unix)]
#[test]
fn interrupted_it_writes_nothing() {
    let folder = Folder::new("reproduce-interrupted");
    let child = folder.command(&["reproduce"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    sleep(Duration::from_millis(1500));
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let done = Done::from(child.wait_with_output().unwrap());
    assert_eq!((done.code, done.out.as_str()), (130, ""), "{}", done.err);
    assert!(!folder.0.join("legwork-reproduction/report.html").exists());
}

/// One sentence was credited with what ten values do.
#[test]
fn reading_and_values_are_told_apart() {
    let folder = Folder::new("readings");
    let parameters = include_str!("../../../../docs/parameters.md");
    let cell = |scenario: &str, reading: &str| {
        let set = format!("reference.step.min_length_is={reading}");
        let run = &folder.json(&["run", scenario, "--set", &set, "--json"])[0];
        let metrics = &run["metrics"];
        let number = |value: &Value, digits: usize| format!("{:.digits$}", value.as_f64().expect("it recovers"));
        if run["outcome"] == "fell" {
            return "falls".to_owned();
        }
        let [distance, time] = [&metrics["recovery_distance_m"], &metrics["recovery_time_s"]];
        let [high, torso] = ["com_error_vertical_m", "torso_deviation_rad"].map(|name| &metrics[name]["peak"]);
        format!("{} m, {} s, {} m, {} rad", number(distance, 2), number(time, 1), number(high, 3), number(torso, 3))
    };
    for (name, reading) in [("way of the foot", "displacement"), ("base of support", "base-of-support")] {
        let [first, second] = ["push", "push-support"].map(|scenario| cell(scenario, reading));
        let row = format!("| {name} | {first} | {second} |");
        assert!(parameters.contains(&row), "docs/parameters.md should have the row\n{row}");
    }
}
