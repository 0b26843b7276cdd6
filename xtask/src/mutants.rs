//! Faults put in by cargo-mutants, one at a time, and whether the tests notice: `cargo xtask mutants [--shard K/N] [NAME...]`.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};

use crate::{cargo, root, say, succeeds};

const VERSION: &str = "27.0.0";

/// What is mutated, by name: its files, the packages whose tests are run, and the arguments that choose the fast ones of them.
type Group = (&'static str, &'static [&'static str], &'static [&'static str], &'static [&'static str]);

const GROUPS: [Group; 7] = [
    ("dynamics", &["crates/legwork-rbd/src/**"], &["legwork-rbd"], &[]),
    (
        "program",
        &["crates/legwork-qp/src/**"],
        &["legwork-qp"],
        &[
            "--lib",
            "--test",
            "by_hand",
            "--test",
            "slacks",
            "--test",
            "whole_body",
            "--test",
            "random",
            "--test",
            "recorded",
            "--test",
            "fuzz",
            "--test",
            "clarabel",
        ],
    ),
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
        &[
            "--lib",
            "--test",
            "springs",
            "--test",
            "simulation",
            "--test",
            "contact",
            "--test",
            "space",
            "--test",
            "terrain",
        ],
    ),
    (
        "metrics",
        &["crates/legwork/src/measuring.rs", "crates/legwork/src/metrics.rs"],
        &["legwork"],
        &["--test", "metrics"],
    ),
    (
        "balance",
        &["crates/legwork/src/balance/**"],
        &["legwork"],
        &["--lib", "--test", "balance", "--", "--skip", "diagnosis"],
    ),
];

pub(crate) fn run(options: &[String]) -> ExitCode {
    let (mut shard, mut names) = ("0/1".to_owned(), Vec::new());
    let mut rest = options.iter();
    while let Some(option) = rest.next() {
        match option.as_str() {
            "--shard" => shard = rest.next().cloned().unwrap_or_default(),
            name => names.push(name),
        }
    }
    let known = |name: &&str| GROUPS.iter().any(|(group, ..)| group == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        let valid: Vec<&str> = GROUPS.iter().map(|(group, ..)| *group).collect();
        say(&format!("found '{unknown}'; valid are {}, and --shard K/N", valid.join(", ")));
        return ExitCode::from(2);
    }
    let whole = shard.split_once('/').and_then(|(k, n)| Some((k.parse::<u32>().ok()?, n.parse::<u32>().ok()?)));
    if whole.is_none_or(|(k, n)| k >= n) {
        say(&format!(
            "found --shard {shard}; valid is K/N with whole numbers K < N: the faults K, K + N, K + 2 N and so on are tried"
        ));
        return ExitCode::from(2);
    }
    let chosen = GROUPS.iter().filter(|(name, ..)| names.is_empty() || names.contains(name));
    match chosen.into_iter().try_for_each(|group| test(group, &shard)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            say(&problem);
            ExitCode::FAILURE
        }
    }
}

/// Tries the faults of a group that are in `shard`, K/N, and says how many the tests noticed and which they did not.
fn test((name, files, packages, tests): &Group, shard: &str) -> Result<(), String> {
    let folder = root().join("target/mutants").join(name);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    say(&format!("== {name}"));
    // cargo-mutants itself would run the tests beforehand in the packages of the faults alone, where not all of them are.
    let mut unharmed = cargo(&["test", "--profile", "mutants"], &[]);
    unharmed.args(packages.iter().flat_map(|package| ["--package", package])).args(*tests);
    if !succeeds(&mut unharmed) {
        return Err(format!("{name}: a test fails without any fault"));
    }
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
    mutants.args(["--workspace", "--baseline", "skip", "--shard", shard, "--timeout", "90", "--output"]).arg(&folder);
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
    if tried == 0 {
        return Err(format!("{name}: no fault was tried; {} says why", folder.join("mutants.out/debug.log").display()));
    }
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
