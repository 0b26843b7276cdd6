//! Project tasks: `cargo xtask test` does all that must pass, `cargo xtask count-instructions` a part of it.

mod bench_peers;
mod browser;
mod count_instructions;
mod mutants;
mod python;
mod robots;
mod tables;
mod wasm;

use std::env;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

const USAGE: &str =
    "usage: cargo xtask TASK, which is one of

  test                 format, lint, documentation, all Rust tests and doc tests, tables read by pandas, pyarrow, polars
                       and duckdb (installed below target/python), robots of other people beside MuJoCo (below
                       target/robots), the report in a real browser, runs in WebAssembly, and the instructions; ends
                       with the sum alone on a line
  count-instructions [--write]
                       the instructions of tick, step, solve and dynamics beside those of bench/instructions.toml;
                       with --write they become those
  mutants [--shard K/N] [GROUP...]
                       puts faults into the code, one at a time, and says how many the tests notice and which they do not; of
                       N faults one, the K-th, with --shard K/N; groups are dynamics, program, planner, generator, simulator, metrics,
                       balance
  bench-peers [--quick] [--only GROUPS]
                       ours beside other people's programs, which it installs below target/peers; writes
                       docs/performance.md
  robots               reads robots of other people and compares their dynamics with those of MuJoCo
  tables               reads what legwork writes with pandas, pyarrow, polars and duckdb
  wasm [--debian]      builds controller, simulator and run for WebAssembly and compares the bits of runs in Node with
                       the native ones; --debian takes Debian's compiler, which it unpacks below target/wasm";

fn main() -> ExitCode {
    match env::args().nth(1).as_deref() {
        Some("test") => test(),
        Some("count-instructions") => count_instructions::run(&env::args().skip(2).collect::<Vec<_>>()),
        Some("mutants") => mutants::run(&env::args().skip(2).collect::<Vec<_>>()),
        Some("bench-peers") => bench_peers::run(&env::args().skip(2).collect::<Vec<String>>()),
        Some("tables") => {
            let mut sum = Sum::default();
            tables::test(&mut sum);
            sum.end()
        }
        Some("robots") => {
            let mut sum = Sum::default();
            robots::test(&mut sum);
            sum.end()
        }
        Some("wasm") => wasm::run(&env::args().skip(2).collect::<Vec<_>>()),
        Some("help" | "--help" | "-h") => {
            say(USAGE);
            ExitCode::SUCCESS
        }
        other => {
            say(&format!("found {}\n{USAGE}", other.map_or("no task".into(), |task| format!("the task '{task}'"))));
            ExitCode::from(2)
        }
    }
}

/// What passed and failed so far.
#[derive(Debug, Default)]
pub(crate) struct Sum {
    passed: u64,
    failed: u64,
}

impl Sum {
    /// Whether nothing failed.
    pub(crate) fn is_passed(&self) -> bool {
        self.failed == 0
    }

    /// Says the sum alone on a line.
    fn end(&self) -> ExitCode {
        say("");
        say(&format!("{} passed, {} failed", self.passed, self.failed));
        if self.is_passed() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }

    /// Counts one check.
    pub(crate) fn count(&mut self, name: &str, passed: bool) {
        if passed {
            self.passed += 1;
        } else {
            self.failed += 1;
            say(&format!("FAILED: {name}"));
        }
    }
}

fn test() -> ExitCode {
    let mut sum = Sum::default();
    let mut check = |name: &str, arguments: &[&str], variables: &[(&str, &str)]| {
        say(&format!("== {name}"));
        let passed = cargo(arguments, variables).status().is_ok_and(|status| status.success());
        sum.count(name, passed);
    };
    check("format", &["fmt", "--all", "--check"], &[]);
    check("lint", &["clippy", "--workspace", "--all-targets", "--release", "--", "--deny", "warnings"], &[]);
    check(
        "documentation",
        &["doc", "--workspace", "--no-deps", "--document-private-items", "--release"],
        &[("RUSTDOCFLAGS", "--deny warnings")],
    );
    say("== tests");
    rust_tests(&mut sum);
    say("== tables read by other people's libraries");
    tables::test(&mut sum);
    say("== robots of other people");
    robots::test(&mut sum);
    say("== report in a browser");
    browser::test(&mut sum);
    say("== WebAssembly");
    wasm::test(&mut sum);
    say("== instructions");
    count_instructions::compare(&mut sum);
    sum.end()
}

/// Runs all tests in the release profile and adds up the harnesses' own counts.
fn rust_tests(sum: &mut Sum) {
    counted(cargo(&["test", "--workspace", "--release", "--no-fail-fast"], &[]), "the tests", sum);
}

/// Whether a command ends well; what it says on stdout is not shown.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    command.stdin(Stdio::null()).stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// Runs a command whose lines `test result: ... 12 passed; 3 failed` are counted; `name` is "the tests".
pub(crate) fn counted(mut command: Command, name: &str, sum: &mut Sum) {
    let mut child = match command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn() {
        Ok(child) => child,
        Err(error) => return sum.count(&format!("{name} cannot be started: {error}"), false),
    };
    let (mut passed, mut failed) = (0, 0);
    for line in BufReader::new(child.stdout.take().expect("stdout is piped")).lines().map_while(Result::ok) {
        if let Some(counts) = line.strip_prefix("test result: ") {
            passed += number_before(counts, " passed");
            failed += number_before(counts, " failed");
        }
        say(&line);
    }
    sum.passed += passed;
    sum.failed += failed;
    let succeeded = child.wait().is_ok_and(|status| status.success());
    if !succeeded && failed == 0 {
        sum.count(&format!("{name} did not build or did not run to their end"), false);
    }
    if passed == 0 {
        sum.count(&format!("none of {name} was executed"), false);
    }
}

/// The number that stands before `word` in `text`.
fn number_before(text: &str, word: &str) -> u64 {
    let before = text.split(word).next().unwrap_or_default();
    before.rsplit(|c: char| !c.is_ascii_digit()).next().and_then(|digits| digits.parse().ok()).unwrap_or(0)
}

/// The project's folder.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the project").to_owned()
}

/// Cargo in the project's folder.
pub(crate) fn cargo(arguments: &[&str], variables: &[(&str, &str)]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).envs(variables.iter().copied()).current_dir(root()).stdin(Stdio::null());
    command
}

/// Writes a line to stdout.
pub(crate) fn say(line: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "{line}");
    let _ = stdout.flush();
}

#[cfg(test)]
mod tests {
    use super::number_before;

    #[test]
    fn counts_of_a_harness_are_read() {
        let line = "FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s";
        assert_eq!((number_before(line, " passed"), number_before(line, " failed")), (12, 3));
    }
}
