//! What the measurement ran on: processor, compilers, packages.

use std::process::Command;

use super::setup::{FLAGS, NATIVE, Peer};
use super::{Places, setup};

/// Lines of the page's table of the machine: what, and which.
pub(super) type Machine = Vec<(String, String)>;

/// Asks the machine.
pub(super) fn describe(places: &Places, peers: &[Peer]) -> Machine {
    let cores = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().unwrap_or("unknown").to_owned();
    let mut lines = vec![
        ("processor".to_owned(), processor()),
        ("cores".to_owned(), cores.to_string()),
        ("load at the end (1 is this run)".to_owned(), load),
        ("ours".to_owned(), format!("{}, release profile, no flags for this processor", version("rustc"))),
        (
            "theirs".to_owned(),
            format!(
                "{}, `{}`, sources also `{NATIVE}`; libraries of wheels as shipped",
                version("g++"),
                FLAGS.join(" ")
            ),
        ),
    ];
    lines.push(("packages".to_owned(), packages(places)));
    for peer in peers {
        if let Err(reason) = &peer.command {
            lines.push((peer.name.to_owned(), format!("not available: {reason}")));
        }
    }
    lines
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name"));
    line.map_or("unknown".to_owned(), |line| line.trim_matches([' ', '\t', ':']).to_owned())
}

fn version(program: &str) -> String {
    let output = Command::new(program).arg("--version").output();
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    text.lines().next().unwrap_or("unknown").to_owned()
}

/// Those that are measured, at the versions that are installed.
fn packages(places: &Places) -> String {
    let output = Command::new(places.peers.join("venv/bin/pip")).arg("freeze").output();
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    let measured =
        ["pin", "libpinocchio", "libtsid", "eiquadprog", "mujoco", "proxsuite", "osqp", "numpy", "cmeel-eigen"];
    let lines = text.lines().filter(|line| line.split_once("==").is_some_and(|(name, _)| measured.contains(&name)));
    let mut all: Vec<String> = lines.map(|line| line.replace("==", " ")).collect();
    let sources = ["daqp", "piqp", "quadprog"].map(|name| setup::find(&places.peers.join("sources"), name));
    all.extend(
        sources
            .into_iter()
            .flatten()
            .map(|path| path.file_name().unwrap_or_default().to_string_lossy().replace('-', " ")),
    );
    let lock = std::fs::read_to_string(places.root.join("Cargo.lock")).unwrap_or_default();
    let clarabel = lock.split("name = \"clarabel\"\nversion = \"").nth(1).and_then(|rest| rest.split('"').next());
    all.extend(clarabel.map(|version| format!("clarabel {version} (crate)")));
    all.join(", ")
}
