//! `legwork compare`: tables, JSON, page, refusals, Ctrl-C.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::{Done, Folder};

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn both_robots_stand_beside_the_person_in_tables_and_page() {
    let folder = Folder::new("compare-tables");
    let arguments = ["compare", "--quick", "--speeds", "0.5,2", "--set", "duration_s=7"];
    let done = folder.legwork(&[&arguments[..], &["--report", "page.html"]].concat()).succeeds();
    assert_eq!(done.err, "report: page.html\n");
    for line in done.out.lines() {
        assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?}");
    }
    let row = |words: &str| done.out.lines().find(|line| line.contains(words)).unwrap_or_else(|| panic!("no {words}"));
    assert_eq!(row("person").split_whitespace().collect::<Vec<_>>(), ["walk", "feet-walk", "person"]);
    let peak: Vec<&str> = row("ankle torque, peak").split_whitespace().skip(4).collect();
    assert_eq!((peak[0], peak[2]), ("\u{2013}", "92.0"));
    for title in [
        "Point feet against feet\n",
        "walk does not walk at 2 m/s: ",
        "Largest impulse survived at 0.5 m/s",
        "\n\nActuators of walk\n",
        "\n\nActuators of feet-walk\n",
        "\n\nwalk by speed",
        "\n\nfeet-walk by speed",
    ] {
        assert!(done.out.contains(title), "{title:?} is not in {}", done.out);
    }
    let page = folder.text("page.html");
    for words in ["Point feet against feet", "Peak torques at 0.5 m/s", "does not walk at 2 m/s", "Actuators of walk"] {
        assert!(page.contains(words), "{words} is not in the page");
    }
    // A page has torques, pushes, and for each robot a cloud and a map.
    assert_eq!(page.matches("<svg class=\"figure wide\"").count(), 1 + 1 + 2 * 2);
    assert!(!page.contains("NaN") && !page.contains(">inf"));
}

#[test]
fn the_same_json_on_any_number_of_threads_with_every_key() {
    let folder = Folder::new("compare-json");
    // Too short for a steady walk: no speed in common, and so no pushes.
    let arguments = ["compare", "--quick", "--json", "--speeds", "0.4", "--set", "duration_s=2", "--threads"];
    let [one, two] = ["1", "2"].map(|threads| folder.legwork(&[&arguments[..], &[threads]].concat()).succeeds());
    assert_eq!((&one.out, one.err.as_str()), (&two.out, ""));
    let report: Value = serde_json::from_str(&one.out).expect("JSON");
    assert_eq!(keys(&report), ["robots", "person", "quick", "interrupted"]);
    assert_eq!(keys(&report["person"]), ["mass_kg", "speed_mps", "source", "peaks_nm"]);
    let robots = report["robots"].as_array().expect("a list");
    assert_eq!(keys(&robots[0]), ["scenario", "mass_kg", "point_feet", "gaits", "pushes", "sizing", "map"]);
    assert_eq!((&robots[0]["point_feet"], &robots[1]["point_feet"]), (&true.into(), &false.into()));
    for robot in robots {
        assert_eq!(robot["gaits"][0]["failure"], "the run is too short for a steady walk");
        assert_eq!((&robot["gaits"][0]["figures"], &robot["pushes"]), (&Value::Null, &Value::Null));
        assert_eq!(robot["map"].as_array().map(Vec::len), Some(25));
    }
}

#[test]
fn wrong_comparisons_are_refused_before_anything_runs() {
    let folder = Folder::new("compare-refused");
    folder.file("own.toml", "extends = \"walk\"\n");
    for (arguments, words) in [
        (&["wlak"][..], "walk"),
        (&["walk", "stand"], "stand: reference.com.trajectory: found a scenario that does not walk"),
        (&["stop-and-go"], "stop-and-go: reference.walker.speeds: found a scenario that does not walk"),
        (&["--set", "pushes.0.force_n=1"], "--set pushes.0.force_n of walk"),
        (&["own.toml", "--report", "own.toml"], "which is a scenario's file; give another"),
    ] {
        folder.refuses(2, &[&["compare"], arguments].concat(), &[words]);
    }
    folder.refuses(1, &["compare", "--report", "none/page.html"], &["none/page.html", "its folder does not exist"]);
    for speeds in ["0", "nan", "6", "-6,0.5", "-0.5,0", "--json"] {
        let done = folder.legwork(&["compare", "--speeds", speeds]);
        assert_eq!((done.code, done.out.as_str()), (2, ""));
        assert!(done.err.contains("valid is a number from -5 to 5, not zero"), "{}", done.err);
    }
    assert_eq!(folder.names(), ["own.toml"]);
}

#[test]
fn a_list_of_speeds_may_begin_with_one_backward() {
    let folder = Folder::new("compare-backward");
    let arguments = ["compare", "--quick", "--json", "--speeds", "-0.3,0.5", "--set", "duration_s=1"];
    let report = &folder.json(&arguments)[0];
    let speeds =
        |robot: &Value| robot["gaits"].as_array().expect("a list").iter().map(|g| g["speed_mps"].clone()).collect();
    let found: Vec<Vec<Value>> = report["robots"].as_array().expect("a list").iter().map(speeds).collect();
    assert_eq!(found, [[-0.3, 0.5].map(Value::from), [-0.3, 0.5].map(Value::from)]);
}

#[cfg(unix)]
#[test]
fn what_was_finished_is_kept_at_ctrl_c() {
    let folder = Folder::new("compare-interrupt");
    let long = ["compare", "--json", "--report", "page.html", "--set", "duration_s=30"];
    let child = folder.command(&long).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    sleep(Duration::from_secs(8));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("there is kill").success());
    let done = Done::from(child.wait_with_output().expect("it ends"));
    assert_eq!((done.code, done.err.as_str()), (130, "interrupted; what was finished is kept\nreport: page.html\n"));
    let report: Value = serde_json::from_str(&done.out).expect("JSON");
    assert_eq!(report["interrupted"], true);
    assert!(report["robots"][1]["map"].as_array().is_some_and(|map| map.len() < 143));
    assert!(folder.text("page.html").contains("The work was interrupted"));
}
