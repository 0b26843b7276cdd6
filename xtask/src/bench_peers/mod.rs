//! `cargo xtask bench-peers`: ours beside other people's programs, on the same problems, in one run, interleaved round by
//! round, each on one core. It writes docs/performance.md, its data and its chart.
//!
//! The peers come from the Python package index into target/peers; what cannot be set up is named with its reason, and the
//! run goes on. Only `cargo`, `python3` and `g++` are needed.

mod cases;
mod chart;
mod machine;
mod measure;
mod page;
mod setup;
mod targets;

use std::path::PathBuf;
use std::process::ExitCode;

use crate::say;
use measure::Measured;

/// What the user asked for.
#[derive(Clone, Debug)]
struct Options {
    rounds: usize,
    only: Vec<String>,
}

/// Where things lie.
#[derive(Clone, Debug)]
struct Places {
    /// The workspace.
    root: PathBuf,
    /// Everything that this task downloads, builds and writes on the way.
    peers: PathBuf,
}

impl Places {
    fn new() -> Self {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace").to_owned();
        Self { peers: root.join("target/peers"), root }
    }

    fn data(&self, file: &str) -> PathBuf {
        self.peers.join("data").join(file)
    }
}

/// Runs the task with what follows its name on the command line.
pub(crate) fn run(arguments: &[String]) -> ExitCode {
    match options(arguments).and_then(|options| measure_all(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            say(&format!("bench-peers: {problem}"));
            ExitCode::FAILURE
        }
    }
}

fn options(arguments: &[String]) -> Result<Options, String> {
    let mut options = Options { rounds: 9, only: Vec::new() };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--quick" => options.rounds = 3,
            "--only" => {
                let list = rest.next().ok_or("--only needs a list of groups")?;
                options.only = list.split(',').map(str::to_owned).collect();
            }
            other => return Err(format!("found '{other}'; valid are --quick and --only {}", cases::GROUPS.join(","))),
        }
    }
    match options.only.iter().find(|group| !cases::GROUPS.contains(&group.as_str())) {
        Some(unknown) => Err(format!("found the group '{unknown}'; valid are {}", cases::GROUPS.join(", "))),
        None => Ok(options),
    }
}

fn measure_all(options: &Options) -> Result<(), String> {
    let places = Places::new();
    let peers = setup::set_up(&places)?;
    let wanted = |group: &str| options.only.is_empty() || options.only.iter().any(|only| only == group);
    let mut measured: Vec<Measured> = Vec::new();
    for case in cases::all().into_iter().filter(|case| wanted(case.group)) {
        say(&format!("== {}", case.title));
        match measure::case(&case, &peers, &places, options.rounds) {
            Ok(result) => measured.push(result),
            // The others are still worth their time.
            Err(problem) => say(&format!("{}: {problem}", case.key)),
        }
    }
    let machine = machine::describe(&places, &peers);
    say(&page::tables(&measured));
    if !options.only.is_empty() {
        say("docs/performance.md is left as it is: it holds all groups, and --only was given");
        return Ok(());
    }
    let write = |file: &str, text: String| {
        let path = places.root.join(file);
        std::fs::create_dir_all(path.parent().expect("a file in a folder"))
            .and_then(|()| std::fs::write(&path, text))
            .map_err(|error| format!("{file}: {error}"))
    };
    write("docs/performance.md", page::document(&measured, &peers, &machine, options.rounds))?;
    write("docs/data/performance.csv", page::csv(&measured))?;
    write("docs/images/performance-peers.svg", chart::svg(&measured))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Options, String> {
        options(&line.split_whitespace().map(str::to_owned).collect::<Vec<String>>())
    }

    #[test]
    fn options_are_read() {
        let all = parse("").expect("no option is needed");
        assert_eq!((all.rounds, all.only.len()), (9, 0));
        let some = parse("--only qp,loop --quick").expect("both are valid");
        assert_eq!((some.rounds, some.only), (3, vec!["qp".to_owned(), "loop".to_owned()]));
    }

    #[test]
    fn other_options_are_refused_with_the_valid_ones() {
        for (line, found, valid) in [
            ("--fast", "found '--fast'", "--quick and --only dynamics,qp,tick,contact,loop"),
            ("--only tick,walk", "found the group 'walk'", "dynamics, qp, tick, contact, loop"),
            ("--only", "--only needs", "a list of groups"),
        ] {
            let problem = parse(line).expect_err(line);
            assert!(problem.contains(found) && problem.contains(valid), "{problem}");
        }
    }

    #[test]
    fn every_case_belongs_to_a_group() {
        assert!(cases::all().iter().all(|case| cases::GROUPS.contains(&case.group)));
    }
}
