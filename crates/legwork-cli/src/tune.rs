//! `legwork tune`: settings that better a design, found in some cases and judged in others.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use legwork_study::parallel;
use legwork_study::rollout::DOUBT;
use legwork_study::store::Store;
use legwork_study::tune::{Comparison, Stop, Tuned, Tuning};

use crate::args::TuneArgs;
use crate::long_work::{INTERRUPTED, Progress, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, say, warn, write_text};
use crate::tune_summary;

const RESULTS: &str = "results.json";

pub(crate) fn run(options: &TuneArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    // Wrong files and unwritable places are found before anything runs.
    let mut tuning = Tuning::load(&options.tuning)?;
    let folder = options.out.clone().unwrap_or_else(|| format!("legwork-tuning-{}", tuning.name).into());
    let of_file = tuning.settings.budget;
    let store = tuning.open(&folder, options.budget)?;
    tell_what_is_kept(&tuning, &store, of_file, options)?;
    listen_for_interrupt();
    let bar = Progress::new(&tuning.name, tuning.rollouts(), "{pos} of {len} rollouts");
    let threads = options.threads.map(usize::from);
    let tuned = parallel::with_threads(threads, || tuning.run(Some(&store), |done| bar.tell(done), interrupted))?;
    bar.finish();
    if tuned.is_err() && store.kept()?.0 == 0 {
        // A corrected file is another tuning.
        store.abandon()?;
    }
    let Some(tuned) = tuned? else {
        say(&format!("{}: interrupted before anything was tried", tuning.name));
        return Ok(ExitCode::from(INTERRUPTED));
    };
    publish(&tuning, &tuned, &folder, options.json, output)?;
    let rollouts = || sets(&tuned).flat_map(|(_, case)| [&case.base, &case.tuned]);
    let doubtful = rollouts().filter(|rollout| rollout.violations.is_some()).count();
    if doubtful > 0 {
        warn(&format!("{}: {doubtful} of {} rollouts {DOUBT}", tuning.name, rollouts().count()));
    }
    if tuned.why == Stop::Interrupted || tuned.held_out.is_empty() {
        say("interrupted; this is the best so far, and no held-out case was run; the same command goes on");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(ExitCode::SUCCESS)
}

/// Says what the folder has already, and which budget it has where the file says another.
fn tell_what_is_kept(tuning: &Tuning, store: &Store, of_file: u64, options: &TuneArgs) -> Result<(), Failure> {
    let (kept, damaged) = store.kept()?;
    for damaged in damaged {
        warn(&format!("{}: {}; it is made again", damaged.path.display(), damaged.problem));
    }
    let budget = tuning.settings.budget;
    if kept > 0 {
        say(&format!("{}: goes on; {} of {budget} candidates are there", tuning.name, kept.min(budget)));
    }
    if options.budget.is_none() && budget != of_file {
        let hint = "--budget gives another";
        say(&format!("{}: a budget of {budget}, which the folder keeps; the file says {of_file}, {hint}", tuning.name));
    }
    Ok(())
}

/// Writes the files and prints the tables. The results come last: where they are, all is there.
fn publish(tuning: &Tuning, tuned: &Tuned, folder: &Path, json: bool, output: &mut Output) -> Result<(), Failure> {
    let mut scenarios: Vec<PathBuf> = Vec::new();
    for (name, text) in tuning.scenarios(&tuned.levels) {
        scenarios.push(folder.join(format!("{name}.toml")));
        write_text(scenarios.last().expect("it was pushed"), &text)?;
    }
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
    let mut text = "evaluations,feasible,doubtful,best_objective,mean_objective,best_so_far_objective,sigma".to_owned();
    for factor in &tuning.factors {
        text += &format!(",{}", quoted(&format!("centre: {}", factor.name)));
    }
    text.push('\n');
    for generation in &tuned.history {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
        let objectives = [generation.best.objective(), generation.mean, generation.best_so_far.objective()];
        text += &format!("{},{},{}", generation.evaluations, generation.feasible, generation.doubtful);
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
    let mut text = "set,case,scenario,design,ending,fell_at_s,cause,violations,input_hash".to_owned();
    for column in &tuning.columns {
        let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
        text += &format!(",{}{unit}", column.name);
    }
    text.push('\n');
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    for (set, comparison) in sets(tuned) {
        for (design, rollout) in [("base", &comparison.base), ("tuned", &comparison.tuned)] {
            let (case, scenario) = (quoted(&comparison.case), quoted(&comparison.scenario));
            let words = |text: &Option<String>| quoted(text.as_deref().unwrap_or(""));
            let (cause, violations) = (words(&rollout.cause), words(&rollout.violations));
            text += &format!("{set},{case},{scenario},{design},{},", rollout.ending.name());
            text += &format!("{},{cause},{violations},{}", number(rollout.fell_at_s), rollout.input_hash);
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
