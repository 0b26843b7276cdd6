//! The program `legwork`: runs scenarios, studies and tunings, measures itself, shows what there is, inspects models.
//!
//! Data goes to stdout, words to stderr. Exit code 0: done what was asked (a simulated fall is a result); 1: a file
//! could not be read or written, or a robot fell under `--expect-standing`; 2: a wrong invocation or file.

mod adopt;
mod args;
mod bench;
mod compare;
mod inspect;
mod limits;
mod list;
mod long_work;
mod output;
mod reproduce;
mod run;
mod study;
mod study_summary;
mod summary;
mod tune;
mod tune_summary;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command, StudyCommand};
use output::{Failure, Output};

fn main() -> ExitCode {
    let args = Args::try_parse().unwrap_or_else(|error| output::refuse(&error));
    let mut output = Output::stdout();
    let done = match args.command.unwrap_or_else(Command::main_job) {
        Command::Run(options) => run::run(&options, &mut output),
        Command::Study(options) => match &options.command {
            Some(StudyCommand::Merge(options)) => study::merge(options, &mut output),
            None => study::run(&options, &mut output),
        },
        Command::Limits(options) => limits::limits(&options, &mut output),
        Command::Compare(options) => compare::compare(&options, &mut output),
        Command::Reproduce(options) => reproduce::reproduce(&options, &mut output),
        Command::Tune(options) => tune::run(&options, &mut output),
        Command::Bench(options) => bench::bench(&options, &mut output),
        Command::List(options) => list::list(&options, &mut output).map(|()| ExitCode::SUCCESS),
        Command::Show(options) => list::show(&options, &mut output).map(|()| ExitCode::SUCCESS),
        Command::Adopt(options) => adopt::adopt(&options, &mut output),
        Command::Inspect(options) => inspect::inspect(&options, &mut output).map(|()| ExitCode::SUCCESS),
    };
    done.and_then(|code| output.flush().map(|()| code)).unwrap_or_else(|failure: Failure| {
        output::say(&format!("error: {failure}"));
        ExitCode::from(failure.code())
    })
}
