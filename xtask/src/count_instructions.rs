//! How many instructions the hot paths take, by callgrind: a gate against slow code that no noise can trip.
//!
//! The example `counted` does the work on recorded inputs; `bench/instructions.toml` holds what it took.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};

use crate::{Sum, cargo, root, say};

/// What the example can do, its name in words, and the functions within it that are counted as well.
type Work = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

const WORKS: [Work; 7] = [
    ("tick_walk", "a control tick of the walk, direct form", &[(SOLVE, "its solve"), (UPDATE, "its dynamics")]),
    ("tick_push", "a control tick of the push, while the force acts and a step begins", &[(SOLVE, "its solve")]),
    ("tick_slack", "a control tick of the walk, slack form", &[(SOLVE, "its solve")]),
    ("tick_exo", "a control tick of the exoskeleton in double support", &[(SOLVE, "its solve")]),
    ("step_push", "a simulation step of the push", &[]),
    ("step_exo", "a simulation step of the exoskeleton in double support", &[]),
    ("dynamics_exo18", "Dynamics::update of the exoskeleton, 18 degrees of freedom", &[]),
];
const SOLVE: &str = "Solver::solve";
const UPDATE: &str = "Dynamics::update";

/// By how much a count may differ from the recorded one: by the same compiler, and by another, whose optimiser differs.
const TOLERANCE: f64 = 0.03;
const TOLERANCE_OTHER_RUSTC: f64 = 0.15;

const RENEW: &str = "`cargo xtask count-instructions --write` renews bench/instructions.toml";

/// Instructions of each work, a call each, and the compiler that made them.
#[derive(Debug, Default, PartialEq)]
struct Counts {
    rustc: String,
    target: String,
    counts: BTreeMap<String, u64>,
}

/// The task by itself: compares, or with `--write` records.
pub(crate) fn run(options: &[String]) -> ExitCode {
    let mut sum = Sum::default();
    match options {
        [] => compare(&mut sum),
        [option] if option == "--write" => match count() {
            Ok(counts) => {
                sum.count("bench/instructions.toml cannot be written", fs::write(file(), counts.text()).is_ok())
            }
            Err(problem) => sum.count(&problem, false),
        },
        _ => {
            say(&format!("found {}; valid is --write, or nothing", options.join(" ")));
            return ExitCode::from(2);
        }
    }
    if sum.is_passed() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Counts, and compares with what is recorded: a check each.
pub(crate) fn compare(sum: &mut Sum) {
    let recorded = fs::read_to_string(file()).ok().and_then(|text| Counts::read(&text));
    let (recorded, counted) = match (recorded, count()) {
        (Some(recorded), Ok(counted)) => (recorded, counted),
        (None, _) => return sum.count(&format!("bench/instructions.toml cannot be read; {RENEW}"), false),
        (_, Err(problem)) => return sum.count(&problem, false),
    };
    if recorded.target != counted.target {
        // Another machine's instructions are others.
        return say(&format!("skipped: recorded for {}, this is {}", recorded.target, counted.target));
    }
    let mut tolerance = TOLERANCE;
    if recorded.rustc != counted.rustc {
        tolerance = TOLERANCE_OTHER_RUSTC;
        let (recorded, counted) = (&recorded.rustc, &counted.rustc);
        say(&format!("recorded by {recorded}, this is {counted}: {:.0} % may differ; {RENEW}", 100.0 * tolerance));
    }
    for (name, count) in judge(&recorded, &counted, tolerance) {
        match count {
            Ok(line) => {
                say(&line);
                sum.count(&name, true);
            }
            Err(problem) => sum.count(&problem, false),
        }
    }
}

/// For each name in either: a line, or what is wrong.
fn judge(recorded: &Counts, counted: &Counts, tolerance: f64) -> Vec<(String, Result<String, String>)> {
    let names: BTreeMap<&String, ()> =
        recorded.counts.keys().chain(counted.counts.keys()).map(|name| (name, ())).collect();
    let verdict = |name: &String| match (recorded.counts.get(name), counted.counts.get(name)) {
        (Some(&before), Some(&now)) => {
            let change = now as f64 / before as f64 - 1.0;
            let line = format!("{name}: {now} instructions, recorded {before}, {:+.2} %", 100.0 * change);
            if change.abs() <= tolerance {
                Ok(line)
            } else if change > 0.0 {
                Err(format!("{line}: slower; if that is meant, {RENEW}"))
            } else {
                // Else the next slower change would hide in what this one has gained.
                Err(format!("{line}: faster; {RENEW}, so that it stays so"))
            }
        }
        (None, _) => Err(format!("{name} is not recorded; {RENEW}")),
        (_, None) => Err(format!("{name} is recorded and was not counted; {RENEW}")),
    };
    names.into_keys().map(|name| (name.clone(), verdict(name))).collect()
}

impl Counts {
    fn text(&self) -> String {
        let mut text = format!(
            "# Instructions a call, counted by callgrind in the release profile: `cargo xtask count-instructions --write`\n\
             # writes this file, `cargo xtask test` holds every change to it (docs/benchmarks.md).\n\
             rustc = \"{}\"\ntarget = \"{}\"\n",
            self.rustc, self.target
        );
        for (work, what, inner) in WORKS {
            let names = std::iter::once((work.to_owned(), what));
            for (name, what) in names.chain(inner.iter().map(|(function, what)| (inner_name(work, function), *what))) {
                if let Some(count) = self.counts.get(&name) {
                    text += &format!("{name} = {count}    # {what}\n");
                }
            }
        }
        text
    }

    /// None where it is not what [`Counts::text`] writes.
    fn read(text: &str) -> Option<Self> {
        let mut read = Self::default();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let (name, value) = line.split_once(" = ")?;
            let value = value.split("    #").next()?;
            match name {
                "rustc" => read.rustc = value.trim_matches('"').to_owned(),
                "target" => read.target = value.trim_matches('"').to_owned(),
                _ => drop(read.counts.insert(name.to_owned(), value.parse().ok()?)),
            }
        }
        Some(read)
    }
}

/// `tick_walk` and `Solver::solve` to `tick_walk_solve`.
fn inner_name(work: &str, function: &str) -> String {
    format!("{work}_{}", function.rsplit("::").next().unwrap_or_default())
}

fn file() -> PathBuf {
    root().join("bench/instructions.toml")
}

/// Builds the example and counts all of its works.
fn count() -> Result<Counts, String> {
    if !has_valgrind() {
        install()?;
    }
    // Built for the whole workspace, as the tests are: nothing is built twice.
    let built = cargo(&["build", "--workspace", "--release", "--quiet", "--example", "counted"], &[]).status();
    if !built.is_ok_and(|status| status.success()) {
        return Err("the example `counted` cannot be built".to_owned());
    }
    let (rustc, target) = compiler()?;
    let mut counts = BTreeMap::new();
    for (work, _, inner) in WORKS {
        let (calls, profile) = profile(work)?;
        let a_call = |total: u64| (total as f64 / calls as f64).round() as u64;
        let total = total(&profile).filter(|&total| total > 0).ok_or(format!("callgrind counted nothing of {work}"))?;
        counts.insert(work.to_owned(), a_call(total));
        for (function, _) in inner {
            let within = inclusive(&profile, function);
            if within == 0 {
                return Err(format!("{function} was not called in {work}: is it inlined?"));
            }
            counts.insert(inner_name(work, function), a_call(within));
        }
    }
    Ok(Counts { rustc, target, counts })
}

/// How many calls a work made, and the profile of them.
fn profile(work: &str) -> Result<(u64, String), String> {
    let target = env::var_os("CARGO_TARGET_DIR").map_or(root().join("target"), |folder| root().join(folder));
    let out = target.join(format!("callgrind.{work}"));
    let example = target.join("release/examples/counted");
    // An empty environment: its length moves the stack, and with it what copying memory takes.
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no", "--toggle-collect=counted::count_*"])
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(example)
        .arg(work)
        .env_clear()
        .envs(env::var_os("PATH").map(|path| ("PATH", path)))
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("valgrind cannot be started: {error}"))?;
    let failed = || format!("{work} failed under valgrind:\n{}", String::from_utf8_lossy(&output.stderr));
    let calls = String::from_utf8_lossy(&output.stdout).trim().parse().map_err(|_| failed())?;
    let profile = fs::read_to_string(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    let _ = fs::remove_file(&out);
    if output.status.success() { Ok((calls, profile)) } else { Err(failed()) }
}

/// All that was collected. Valgrind manual, Callgrind Format Specification: `totals: N`.
fn total(profile: &str) -> Option<u64> {
    profile.lines().find_map(|line| line.strip_prefix("totals: "))?.trim().parse().ok()
}

/// What the calls of functions whose name ends with `function` took, with all that they called: of each `cfn=(id) name`
/// the last number of the line after `calls=`. A name stands only where its number occurs first.
fn inclusive(profile: &str, function: &str) -> u64 {
    let mut ids = Vec::new();
    let (mut is_called, mut is_cost, mut sum) = (false, false, 0);
    for line in profile.lines() {
        let called = line.strip_prefix("cfn=");
        if let Some(name) = called.or(line.strip_prefix("fn=")) {
            let (id, name) = name.split_once(' ').unwrap_or((name, ""));
            if name.ends_with(function) {
                ids.push(id);
            }
            is_called = called.is_some() && ids.contains(&id);
        } else if line.starts_with("calls=") {
            is_cost = is_called;
        } else if std::mem::take(&mut is_cost) {
            sum += line.rsplit(' ').next().and_then(|cost| cost.parse::<u64>().ok()).unwrap_or(0);
        }
    }
    sum
}

/// The compiler's version and the target that it makes programs for.
fn compiler() -> Result<(String, String), String> {
    let unknown = || "rustc does not tell its version".to_owned();
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").current_dir(root()).output().map_err(|_| unknown())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let field =
        |name: &str| text.lines().find_map(|line| Some(line.strip_prefix(name)?.to_owned())).ok_or_else(unknown);
    Ok((field("release: ")?, field("host: ")?))
}

fn has_valgrind() -> bool {
    let found = Command::new("valgrind").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.is_ok_and(|status| status.success())
}

/// Installs Debian's valgrind where that is possible without asking.
fn install() -> Result<(), String> {
    say("installing valgrind");
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive").stdin(Stdio::null()).stdout(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let installed = apt(&["update"]) && apt(&["install", "--yes", "--no-install-recommends", "valgrind"]);
    if installed && has_valgrind() {
        Ok(())
    } else {
        Err("valgrind is missing, and could not be installed: no instructions were counted".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(values: &[(&str, u64)]) -> Counts {
        let counts = values.iter().map(|&(name, count)| (name.to_owned(), count)).collect();
        Counts { rustc: "1.95.0".into(), target: "x86_64-unknown-linux-gnu".into(), counts }
    }

    #[test]
    fn what_is_written_is_read() {
        let counts = counts(&[("tick_walk", 41_000), ("tick_walk_solve", 20_123), ("step_push", 7)]);
        assert_eq!(Counts::read(&counts.text()), Some(counts));
        assert_eq!(Counts::read("tick_walk = many"), None);
    }

    #[test]
    fn more_and_less_than_the_tolerance_fail_and_so_does_what_is_missing() {
        let recorded = counts(&[("a", 10_000), ("b", 10_000), ("c", 10_000), ("d", 10_000), ("gone", 1)]);
        let counted = counts(&[("a", 10_299), ("b", 10_301), ("c", 9_701), ("d", 9_699), ("new", 1)]);
        let verdicts = judge(&recorded, &counted, TOLERANCE);
        let failed: Vec<&str> =
            verdicts.iter().filter(|(_, verdict)| verdict.is_err()).map(|(name, _)| name.as_str()).collect();
        assert_eq!(failed, ["b", "d", "gone", "new"]);
        let [slower, faster] =
            ["b", "d"].map(|name| verdicts.iter().find(|(n, _)| n == name).unwrap().1.clone().unwrap_err());
        assert!(slower.contains("+3.01 %: slower") && slower.contains("--write"), "{slower}");
        assert!(faster.contains("-3.01 %: faster") && faster.contains("--write"), "{faster}");
    }

    #[test]
    fn the_calls_of_a_function_are_summed_however_its_name_is_abbreviated() {
        let profile = "totals: 170\n\nfn=(1) counted::count_ticks\n10 5\ncfn=(2) legwork_qp::solver::Solver::solve\n\
                       calls=3 20\n10 100\ncfn=(3) other::resolve\ncalls=1 1\n11 7\n\nfn=(2)\n20 90\n\
                       cfn=(3)\ncalls=1 1\n21 10\n\nfn=(4) again\ncfn=(2)\ncalls=1 20\n12 50\n";
        assert_eq!(inclusive(profile, SOLVE), 150);
        assert_eq!(total(profile), Some(170));
    }
}
