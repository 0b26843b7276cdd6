//! `list`, `show`, and the help.

use std::process::{Command, Stdio};

use serde_json::Value;

use crate::{Done, Folder};

fn names(list: &Value) -> Vec<&str> {
    list.as_array().expect("a list").iter().map(|entry| entry["name"].as_str().expect("a name")).collect()
}

#[test]
fn a_shown_scenario_runs_as_the_original() {
    let folder = Folder::new("show");
    let scenarios = folder.json(&["list", "scenarios", "--json"]).remove(0);
    for name in names(&scenarios["scenarios"]) {
        let sets = ["--set", "ground.friction=0.7", "--set", "seed=3"];
        let changed = [&["show", name], &sets[..]].concat();
        folder.file("saved.toml", folder.legwork(&changed).succeeds().out);
        let run = |what: &[&str]| {
            let line = folder.json(&[&["run", "--json", "--duration", "0.3"], what].concat()).remove(0);
            ["input_hash", "result_hash", "scenario"].map(|key| line[key].clone())
        };
        assert_eq!(run(&["saved.toml"]), run(&[&[name], &sets[..]].concat()), "{name}");
        assert_eq!(folder.legwork(&["show", "saved.toml"]).succeeds().out, folder.text("saved.toml"), "{name}");
    }
}

#[test]
fn everything_is_listed() {
    let folder = Folder::new("list");
    let all = folder.json(&["list", "--json"]).remove(0);
    let keys: Vec<_> = all.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys, ["models", "scenarios", "studies", "settings", "metrics", "joint_metrics"]);
    assert_eq!(names(&all["models"]), ["planar_humanoid", "planar_humanoid_feet", "exo18"]);
    for name in ["walk", "push", "stand", "walk-slope", "push-replan"] {
        assert!(names(&all["scenarios"]).contains(&name), "{name}");
    }
    let settings = all["settings"].as_array().unwrap();
    for setting in settings {
        for key in ["path", "symbol", "unit", "valid", "source", "help"] {
            assert!(setting[key].is_string(), "{key} of {setting}");
        }
        assert!(setting.get("default").is_some(), "{setting}");
    }
    let torque = settings.iter().find(|setting| setting["path"] == "controller.limits.torque_nm").unwrap();
    assert_eq!((&torque["default"], &torque["unit"]), (&220.0.into(), &"Nm".into()));
    for part in ["models", "scenarios", "studies", "settings"] {
        let alone = folder.json(&["list", part, "--json"]).remove(0);
        assert_eq!(alone.as_object().unwrap().len(), 1);
        assert_eq!(alone[part], all[part]);
    }

    let text = folder.legwork(&["list", "settings"]).succeeds().out;
    for setting in settings {
        let path = setting["path"].as_str().unwrap();
        assert!(text.lines().any(|line| line.split(' ').nth(2) == Some(path)), "{path}");
    }
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
}

#[test]
fn the_overview_fits_a_screen_and_says_how_to_see_more() {
    let folder = Folder::new("overview");
    let all = folder.json(&["list", "--json"]).remove(0);
    let text = folder.legwork(&["list"]).succeeds().out;
    assert!(text.lines().count() <= 40 && text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let words: Vec<&str> = text.split([' ', ',', '\n']).collect();
    for part in ["models", "scenarios", "studies"] {
        assert!(names(&all[part]).iter().all(|name| words.contains(name)), "{part}: {text}");
    }
    for line in text.lines().filter_map(|line| line.split_once(": legwork ")) {
        let command: Vec<&str> = line.1.split(';').next().unwrap().split(' ').collect();
        folder.legwork(&command).succeeds();
    }
    for (group, count) in [("controller.weights", 16), ("wearer", 3), ("duration_s", 1)] {
        let found = folder.json(&["list", "settings", group, "--json"]).remove(0);
        assert_eq!(found["settings"].as_array().unwrap().len(), count, "{group}");
        let shown = if count == 1 { group.to_owned() } else { format!("{group} ({count})") };
        assert!(text.contains(&shown), "{shown}: {text}");
    }
    let walks = folder.json(&["list", "scenarios", "walk", "--json"]).remove(0);
    assert_eq!(names(&walks["scenarios"]), ["walk"]);
    let refused = folder.legwork(&["list", "settings", "controler"]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("\"controler\"") && refused.err.contains("controller.weights"), "{}", refused.err);
}

#[test]
fn comments_of_a_shown_scenario_are_wrapped() {
    let folder = Folder::new("wrapped");
    let text = folder.legwork(&["show", "push"]).succeeds().out;
    for line in text.lines().filter(|line| line.starts_with('#')) {
        assert!(line.chars().count() <= 100, "{line}");
    }
    assert!(text.lines().any(|line| line.chars().count() > 90), "as wide as it may be");
}

/// Runs the examples of all the help pages, one after the other, in one folder.
#[cfg(unix)]
#[test]
fn every_example_of_the_help_works() {
    let folder = Folder::new("examples");
    folder.file("robot.urdf", "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link></robot>");
    folder.file("state.json", "{\"q\": [0, 0, 0, 1, 0, -1.5, -0.5], \"v\": [0, 0, 0, 0, 0, 0, 0]}");
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_legwork"));
    let paths = std::env::join_paths([program.parent().unwrap(), "/usr/bin".as_ref(), "/bin".as_ref()]).unwrap();
    let mut count = 0;
    for page in [&["--help"][..], &["run", "--help"], &["list", "--help"], &["show", "--help"], &["inspect", "--help"]]
    {
        let help = folder.legwork(page).succeeds().out;
        let examples: Vec<_> = help.lines().filter(|line| line.starts_with("  legwork ")).collect();
        assert!(!examples.is_empty(), "{page:?} has no example");
        for example in examples {
            let mut shell = Command::new("sh");
            shell.args(["-c", example]).current_dir(&folder.0).env("PATH", &paths).stdin(Stdio::null());
            let done = Done::from(shell.output().expect("there is a shell"));
            assert_eq!(done.code, 0, "{example}: {}", done.err);
            count += 1;
        }
    }
    assert!(count >= 9, "{count}");
    for name in ["report.html", "push.html", "my-push.toml", "my-push.parquet", "figures"] {
        assert!(folder.0.join(name).exists(), "{name}");
    }
}
