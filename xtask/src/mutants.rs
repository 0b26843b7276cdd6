//! Faults put in by cargo-mutants, one at a time, and whether the tests notice: `cargo xtask mutants [--share N] [NAME...]`.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};

use crate::{cargo, root, say, succeeds};

const VERSION: &str = "27.0.0";

/// What is mutated, by name: its files, the packages whose tests are run, and the arguments that choose the fast ones of them.
type Group = (&'static str, &'static [&'static str], &'static [&'static str], &'static [&'static str]);

const GROUPS: [Group; 7] = [
    ("dynamics", &["crates/legwork-rbd/src/**"], &["legwork-rbd"], &[]),
    ("program", &["crates/legwork-qp/src/**"], &["legwork-qp"], &[]),
    (
        "planner",
        &["crates/legwork-control/src/planner.rs", "crates/legwork-control/src/momentum/**"],
        &["legwork-control", "legwork"],
        &["--lib", "--test", "goals", "--test", "program", "--test", "tasks", "--test", "joint_limits"],
    ),
    (
        "generator",
        &["crates/legwork-control/src/generator/**", "crates/legwork-control/src/contacts.rs"],
        &["legwork-control", "legwork"],
        &["--lib", "--test", "goals", "--test", "sensing", "--test", "feet", "--test", "terrain"],
    ),
    (
        "simulator",
        &["crates/legwork-sim/src/**"],
        &["legwork-sim", "legwork"],
        &["--lib", "--test", "simulation", "--test", "contact", "--test", "space", "--test", "terrain"],
    ),
    (
        "metrics",
        &["crates/legwork/src/measuring.rs", "crates/legwork/src/metrics.rs"],
        &["legwork"],
        &["--lib", "--test", "metrics"],
    ),
    ("balance", &["crates/legwork/src/balance/**"], &["legwork"], &["--lib", "--test", "balance"]),
];

pub(crate) fn run(options: &[String]) -> ExitCode {
    let (mut share, mut names) = ("1".to_owned(), Vec::new());
    let mut rest = options.iter();
    while let Some(option) = rest.next() {
        match option.as_str() {
            "--share" => share = rest.next().cloned().unwrap_or_default(),
            name => names.push(name),
        }
    }
    let known = |name: &&str| GROUPS.iter().any(|(group, ..)| group == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        let valid: Vec<&str> = GROUPS.iter().map(|(group, ..)| *group).collect();
        say(&format!("found '{unknown}'; valid are {}, and --share N before a number", valid.join(", ")));
        return ExitCode::from(2);
    }
    if share.parse::<u32>().is_ok_and(|share| share > 0) {
        match GROUPS
            .iter()
            .filter(|(name, ..)| names.is_empty() || names.contains(name))
            .try_for_each(|group| test(group, &share))
        {
            Ok(()) => ExitCode::SUCCESS,
            Err(problem) => {
                say(&problem);
                ExitCode::FAILURE
            }
        }
    } else {
        say(&format!("found --share {share}; valid is a whole number: of so many faults one is tried"));
        ExitCode::from(2)
    }
}

/// Tries one of `share` faults of a group, and says how many the tests noticed and which they did not.
fn test((name, files, packages, tests): &Group, share: &str) -> Result<(), String> {
    let folder = root().join("target/mutants").join(name);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    say(&format!("== {name}"));
    let mut mutants = Command::new(program()?);
    mutants.current_dir(root()).args([
        "mutants",
        "--profile",
        "mutants",
        "--no-shuffle",
        "--sharding",
        "round-robin",
        "--colors",
        "never",
    ]);
    mutants.arg("--workspace").args(["--shard", &format!("0/{share}"), "--timeout", "90", "--output"]).arg(&folder);
    mutants.args(files.iter().flat_map(|file| ["--file", file]));
    mutants.args(packages.iter().flat_map(|package| ["--test-package", package]));
    // Without `--workspace` faults are looked for in the package of the program alone. A missed fault is a result: the outcomes say it.
    mutants.arg("--").args(*tests).stdin(Stdio::null()).status().map_err(|error| format!("cargo-mutants: {error}"))?;
    let list = |outcome: &str| {
        let path = folder.join(format!("mutants.out/{outcome}.txt"));
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let [caught, timeout, missed, unviable] = ["caught", "timeout", "missed", "unviable"].map(list);
    let (noticed, missed) = (caught?.lines().count() + timeout?.lines().count(), missed?);
    let tried = noticed + missed.lines().count();
    let percent = 100.0 * noticed as f64 / tried.max(1) as f64;
    say(&format!(
        "{name}: {noticed} of {tried} faults noticed, {percent:.0} %; {} do not build",
        unviable?.lines().count()
    ));
    say(&missed);
    Ok(())
}

/// The program, installed below `target` where it is not there yet.
fn program() -> Result<PathBuf, String> {
    let folder = root().join("target/tools");
    let program = folder.join("bin/cargo-mutants");
    if !program.exists() {
        say("installing cargo-mutants, which takes some minutes");
        let mut install = cargo(&["install", "cargo-mutants", "--version", VERSION, "--locked", "--root"], &[]);
        if !succeeds(install.arg(&folder)) {
            return Err("cargo install cannot install cargo-mutants".to_owned());
        }
    }
    Ok(program)
}
