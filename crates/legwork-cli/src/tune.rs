//! `legwork tune`: settings that better a design, found in some cases and judged in others.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use legwork::error::Error;
use legwork_study::parallel;
use legwork_study::tune::{Comparison, Stop, Tuned, Tuning};

use crate::args::TuneArgs;
use crate::long_work::{INTERRUPTED, Progress, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, check_writable, say, write_text};
use crate::tune_summary;

const RESULTS: &str = "results.json";

pub(crate) fn run(options: &TuneArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    // Wrong files and unwritable places are found before anything runs.
    let mut tuning = Tuning::load(&options.tuning)?;
    tuning.settings.budget = options.budget.unwrap_or(tuning.settings.budget);
    let folder = options.out.clone().unwrap_or_else(|| format!("legwork-tuning-{}", tuning.name).into());
    prepare(&folder, &tuning)?;
    listen_for_interrupt();
    let bar = Progress::new(&tuning.name, tuning.rollouts(), "{pos} of {len} rollouts");
    let threads = options.threads.map(usize::from);
    let tuned = parallel::with_threads(threads, || tuning.run(|done| bar.tell(done), interrupted));
    bar.finish();
    let Some(tuned) = tuned?? else {
        say(&format!("{}: interrupted before anything was tried", tuning.name));
        return Ok(ExitCode::from(INTERRUPTED));
    };
    publish(&tuning, &tuned, &folder, options.json, output)?;
    if tuned.why == Stop::Interrupted || tuned.held_out.is_empty() {
        say("interrupted; this is the best so far, and no held-out case was run");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ExitCode::SUCCESS)
}

/// Makes the folder; one that holds what no tuning with these scenarios writes is refused.
fn prepare(folder: &Path, tuning: &Tuning) -> Result<(), Failure> {
    let found = match fs::read_dir(folder) {
        Ok(entries) => entries.collect::<Result<Vec<_>, _>>().map_err(|error| Error::io(folder, &error))?,
        Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
        Err(error) => return Err(Error::io(folder, &error).into()),
    };
    let files = file_names(tuning);
    let foreign =
        found.iter().map(|entry| entry.file_name()).find(|name| !files.iter().any(|file| name == file.as_str()));
    if let Some(foreign) = foreign {
        let problem = format!("holds {}, which is not of this tuning; give a new folder", foreign.display());
        return Err(Error::invalid(folder.display().to_string(), problem).into());
    }
    fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    files.iter().try_for_each(|file| check_writable(&folder.join(file)))
}

fn file_names(tuning: &Tuning) -> Vec<String> {
    let tuned = tuning.scenarios(&tuning.own).into_iter().map(|(name, _)| format!("{name}.toml"));
    tuned.chain(["tuning.toml", "history.csv", "cases.csv", RESULTS].map(str::to_owned)).collect()
}

/// Writes the files and prints the tables. The results come last: where they are, all is there.
fn publish(tuning: &Tuning, tuned: &Tuned, folder: &Path, json: bool, output: &mut Output) -> Result<(), Failure> {
    let mut scenarios: Vec<PathBuf> = Vec::new();
    for (name, text) in tuning.scenarios(&tuned.levels) {
        scenarios.push(folder.join(format!("{name}.toml")));
        write_text(scenarios.last().expect("it was pushed"), &text)?;
    }
    write_text(&folder.join("tuning.toml"), tuning.to_toml())?;
    write_text(&folder.join("history.csv"), &history(tuning, tuned))?;
    write_text(&folder.join("cases.csv"), &cases(tuning, tuned))?;
    let results = tune_summary::json(tuning, tuned);
    write_text(&folder.join(RESULTS), &format!("{results:#}\n"))?;
    output.line(if json { results.to_string() } else { tune_summary::text(tuning, tuned) })?;
    output.flush()?;
    for scenario in scenarios {
        say(&format!("scenario: {}", scenario.display()));
    }
    Ok(())
}

/// A line a generation; the centre in levels is that of the factors.
fn history(tuning: &Tuning, tuned: &Tuned) -> String {
    let mut text = "evaluations,feasible,best_objective,mean_objective,best_so_far_objective,sigma".to_owned();
    for factor in &tuning.factors {
        text += &format!(",{}", quoted(&format!("centre: {}", factor.name)));
    }
    text.push('\n');
    for generation in &tuned.history {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
        let objectives = [generation.best.objective(), generation.mean, generation.best_so_far.objective()];
        text += &format!("{},{}", generation.evaluations, generation.feasible);
        for value in
            objectives.into_iter().chain([Some(generation.sigma)]).chain(generation.centre.iter().copied().map(Some))
        {
            text += &format!(",{}", number(value));
        }
        text.push('\n');
    }
    text
}

/// Two lines a case: as it stands, and tuned.
fn cases(tuning: &Tuning, tuned: &Tuned) -> String {
    let mut text = "set,case,scenario,design,ending,fell_at_s,cause,input_hash".to_owned();
    for column in &tuning.columns {
        let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
        text += &format!(",{}{unit}", column.name);
    }
    text.push('\n');
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    for (set, comparison) in sets(tuned) {
        for (design, rollout) in [("base", &comparison.base), ("tuned", &comparison.tuned)] {
            let (case, scenario) = (quoted(&comparison.case), quoted(&comparison.scenario));
            let cause = rollout.cause.as_deref().unwrap_or("");
            text += &format!("{set},{case},{scenario},{design},{},", rollout.ending.name());
            text += &format!("{},{},{}", number(rollout.fell_at_s), quoted(cause), rollout.input_hash);
            for column in 0..tuning.columns.len() {
                text += &format!(",{}", number(rollout.figures.get(column).copied().flatten()));
            }
            text.push('\n');
        }
    }
    text
}

/// All cases, each with the name of its set.
fn sets(tuned: &Tuned) -> impl Iterator<Item = (&'static str, &Comparison)> {
    let training = tuned.training.iter().map(|case| ("training", case));
    training.chain(tuned.held_out.iter().map(|case| ("held-out", case)))
}

/// A cell of a CSV file. RFC 4180
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
