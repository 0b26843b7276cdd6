//! `legwork bench`: what legwork takes on this machine.
//!
//! Only here and in the library's `episode` is a clock read. What is timed gets the inputs of a finished run again
//! (`legwork::recording`), so that each round does the same work.

mod machine;
mod replay;
mod rounds;
mod samples;
mod scenario;
mod text;

use std::process::ExitCode;

use legwork::error::Error;
use legwork_study::Base;
use serde::Serialize;

use crate::args::BenchArgs;
use crate::long_work::{conclude, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output};
use machine::{Clock, Machine};
use scenario::Measured;

/// All that was measured.
#[derive(Debug, Serialize)]
struct Report {
    machine: Machine,
    /// Whether Ctrl-C was pressed, so that something is missing.
    interrupted: bool,
    scenarios: Vec<Measured>,
}

pub(crate) fn bench(options: &BenchArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    // Wrong scenarios are found before anything is measured.
    let bases = bases(options)?;
    listen_for_interrupt();
    let clock = Clock::new();
    let machine = Machine::new(&clock);
    machine.warn();

    let mut scenarios = Vec::new();
    for base in &bases {
        scenarios.extend(scenario::measure(base, clock, machine.cores, options.seconds)?);
        if interrupted() {
            break;
        }
    }
    let report = Report { machine, interrupted: interrupted(), scenarios };
    let words = (!options.json).then_some(text::text as fn(&Report) -> String);
    conclude(output, &report, words, report.interrupted, || Ok(()))
}

fn bases(options: &BenchArgs) -> Result<Vec<Base>, Error> {
    let default = ["walk".to_owned(), "push".to_owned()];
    let names = if options.scenarios.is_empty() { &default[..] } else { &options.scenarios };
    let load = |name: &String| {
        Base::load(name, &options.sets).map_err(|error| match error {
            Error::Invalid { place, problem } if place.starts_with("--set ") && names.len() > 1 => {
                Error::invalid(format!("{place} of {name}"), problem)
            }
            other => other,
        })
    };
    names.iter().map(load).collect()
}
