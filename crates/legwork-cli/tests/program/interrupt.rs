//! Ctrl-C, and the bar that shows how long there is to wait.
#![cfg(unix)]

use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::{Done, Folder};

/// A run of some minutes whose log is small: many steps of physics a tick.
const LONG: [&str; 8] = [
    "run",
    "stand",
    "--set",
    "simulation.period_s=1e-5",
    "--set",
    "controller.period_s=0.005",
    "--set",
    "duration_s=600",
];

fn interrupt(child: &Child) {
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("there is kill").success());
}

#[test]
fn what_was_done_is_kept() {
    let folder = Folder::new("interrupt");
    let files = ["walk", "--json", "--log", "a.csv", "--report", "a.html"];
    let mut command = folder.command(&[&LONG[..], &files].concat());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Longer than the patience after which a bar would show on a terminal
    sleep(Duration::from_secs(3));
    interrupt(&child);
    let done = Done::from(child.wait_with_output().unwrap());
    assert_eq!(done.code, 130, "{}", done.err);
    assert_eq!(done.out.lines().count(), 1, "the second scenario is not begun: {}", done.out);
    let line: serde_json::Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!((&line["outcome"], &line["fell_at_s"]), (&"stopped".into(), &serde_json::Value::Null));
    let simulated = line["timing"]["simulated_s"].as_f64().unwrap();
    assert!(simulated > 0.0 && simulated < 599.0, "{simulated}");
    let ticks = (simulated / 0.005).round() as usize;
    assert_eq!(folder.text("a-stand.csv").lines().count(), 1 + ticks);
    assert!(folder.text("a.html").contains("</html>"));
    let said = "log: a-stand.csv\ninterrupted; what was simulated so far is kept\nreport: a.html\n";
    assert_eq!(done.err, said, "and no bar without a terminal");
}

/// `script` of util-linux gives the program a terminal.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_shows_a_bar() {
    let folder = Folder::new("bar");
    let program = env!("CARGO_BIN_EXE_legwork");
    let mut command = Command::new("script");
    // No shell stays between the terminal and the program: shells differ in what they do on Ctrl-C.
    command.args(["--quiet", "--return", "--command", &format!("exec {program} {}", LONG.join(" ")), "typescript"]);
    command.env("SHELL", "/bin/sh").env("TERM", "xterm").current_dir(&folder.0);
    let Ok(mut child) = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn() else {
        return; // No such program here
    };
    let seen = |what: &str| {
        std::fs::read(folder.0.join("typescript")).is_ok_and(|text| String::from_utf8_lossy(&text).contains(what))
    };
    within(Duration::from_secs(60), "a bar", || seen("% simulated"));
    // Ctrl-C, as the terminal passes it on
    std::io::Write::write_all(child.stdin.as_mut().unwrap(), b"\x03").unwrap();
    within(Duration::from_secs(60), "the end", || child.try_wait().unwrap().is_some());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(seen("stand: stopped at "));
}

fn within(patience: Duration, what: &str, mut is_there: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_there() {
        assert!(begin.elapsed() < patience, "no {what} after {patience:?}");
        sleep(Duration::from_millis(50));
    }
}
