//! `legwork study`: many rollouts by a plan, kept in a folder, and what they say together.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use legwork::error::Error;
use legwork_study::parallel::{self, run_chunks};
use legwork_study::results::{self, Results};
use legwork_study::rollout::DOUBT;
use legwork_study::store::{self, Shard, Store, Survey};
use legwork_study::{Rollout, Study};

use crate::args::{MergeArgs, StudyArgs};
use crate::long_work::{INTERRUPTED, Progress, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, say, warn, write_page, write_text};
use crate::study_summary;

/// What a rollout takes on the disk, and its rows in both tables, at most [bytes].
const BYTES_PER_ROLLOUT: u64 = 2500;
const BYTES_PER_ROW: u64 = 3500;

/// What the page and its figures take at most, about [bytes].
const BYTES_OF_PAGE: u64 = 10_000_000;

pub(crate) fn run(options: &StudyArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    // Wrong files and unwritable places are found before anything runs.
    let shard = options.shard.as_deref().map(Shard::parse).transpose()?;
    let studies =
        options.studies.iter().map(|name| Study::load(name, &options.sets)).collect::<Result<Vec<_>, Error>>()?;
    let folders = folders(options, &studies)?;
    let mut stores = Vec::new();
    for (study, folder) in studies.iter().zip(&folders) {
        let store = Store::open(folder, study.to_toml(), study.identity(), study.len(), shard)?;
        let tables = study.len().saturating_mul(BYTES_PER_ROW) + BYTES_OF_PAGE;
        store.check_space(BYTES_PER_ROLLOUT, if shard.is_none() { tables } else { 0 })?;
        stores.push(store);
    }
    listen_for_interrupt();
    for ((study, folder), store) in studies.iter().zip(&folders).zip(&stores) {
        let complete = fill(study, store, folder, options.threads.map(usize::from))?;
        if interrupted() {
            return Ok(ExitCode::from(INTERRUPTED));
        }
        if complete {
            publish(study, store, folder, options.json, output)?;
        } else {
            let merge = format!("`legwork study merge {}` reads it when all are done", folder.display());
            say(&format!("{}: this shard is done; {merge}", study.name));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Joins what shards did and makes tables and report of it.
pub(crate) fn merge(options: &MergeArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    let into = options.into.as_ref().unwrap_or(&options.folders[0]);
    let survey = store::merge(&options.folders, into)?;
    let store = Store::read(into)?;
    if let Some(problem) = lacks(&survey, store.number_of_chunks()) {
        return Err(Error::invalid(into.display().to_string(), problem).into());
    }
    for damaged in &survey.damaged {
        warn(&format!("{}: {}; another folder has it whole", damaged.path.display(), damaged.problem));
    }
    let study = Study::parse(store.text(), &into.join("study.toml").display().to_string(), None, &[])?;
    if (study.identity(), study.len()) != (store.identity(), store.total()) {
        let problem = "a scenario or a robot that the study names, or what is measured, has changed since it was run; \
                       put it back, or run it anew in another folder";
        return Err(Error::invalid(into.display().to_string(), problem).into());
    }
    publish(&study, &store, into, options.json, output)?;
    Ok(ExitCode::SUCCESS)
}

/// What a merge cannot go on without: chunks that are nowhere, and those that are nowhere whole.
fn lacks(survey: &Survey, all: u64) -> Option<String> {
    let (mut absent, mut damaged) = (0, Vec::new());
    for chunk in &survey.missing {
        match survey.damaged.iter().find(|damaged| damaged.chunk == *chunk) {
            Some(found) => damaged.push(format!("{} {}", found.path.display(), found.problem)),
            None => absent += 1,
        }
    }
    let absent = (absent > 0)
        .then(|| format!("{absent} of {all} chunks are missing; run the shards that lack them to their end"));
    let damaged = (!damaged.is_empty()).then(|| {
        let (count, first) = (damaged.len(), &damaged[0]);
        let more = if count > 1 { format!("; so are {} more", count - 1) } else { String::new() };
        format!("{count} of {all} chunks are damaged: {first}{more}; run their shards again, which makes them anew")
    });
    let said: Vec<String> = damaged.into_iter().chain(absent).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// The folder of each study: the one given, or one below it for each of several, or one by its name here.
fn folders(options: &StudyArgs, studies: &[Study]) -> Result<Vec<PathBuf>, Error> {
    for (index, study) in studies.iter().enumerate() {
        if studies[..index].iter().any(|other| other.name == study.name) {
            let problem = format!("two studies are called \"{}\"; run them one by one", study.name);
            return Err(Error::invalid("study", problem));
        }
    }
    let folder = |study: &Study| match &options.out {
        Some(out) if studies.len() == 1 => out.clone(),
        Some(out) => out.join(&study.name),
        None => format!("legwork-{}", study.name).into(),
    };
    Ok(studies.iter().map(folder).collect())
}

/// Makes the rollouts that are missing; whether all of the study are there afterwards.
fn fill(study: &Study, store: &Store, folder: &Path, threads: Option<usize>) -> Result<bool, Failure> {
    let survey = store.survey()?;
    for damaged in &survey.damaged {
        warn(&format!("{}: {}; it is made again", damaged.path.display(), damaged.problem));
    }
    let missing: u64 =
        survey.missing.iter().map(|&chunk| store.range(chunk)).map(|range| range.end - range.start).sum();
    let own: u64 = store.own_chunks().map(|chunk| store.range(chunk)).map(|range| range.end - range.start).sum();
    let earlier = own - missing;
    if missing > 0 && earlier > 0 {
        say(&format!("{}: goes on; {earlier} of {own} rollouts are there", study.name));
    }
    let bar = Progress::new(&study.name, missing, "{pos} of {len} rollouts");
    let job = |index| study.rollout(index, interrupted);
    let told = |done: u64| bar.tell(done - earlier);
    let progress = parallel::with_threads(threads, || run_chunks::<Rollout>(store, &survey, job, told, interrupted))?;
    bar.finish();
    let progress = progress?;
    if interrupted() {
        let kept = format!("interrupted; {} of {} rollouts are kept", progress.done, progress.total);
        say(&format!("{}: {kept} in {}, the same command goes on", study.name, folder.display()));
        return Ok(false);
    }
    Ok(store.is_complete()?)
}

/// Writes tables, figures and report of a complete study, and prints what it says.
fn publish(study: &Study, store: &Store, folder: &Path, json: bool, output: &mut Output) -> Result<(), Failure> {
    results::write_table(study, folder, store.records())?;
    let results = Results::new(study, store.records())?;
    for (number, base) in study.bases.iter().enumerate() {
        let endings = results.endings(number);
        if endings.invalid + endings.failed > 0 {
            let count = endings.invalid + endings.failed;
            warn(&format!(
                "{}: {count} of {} rollouts could not be run; the column reason says why",
                base.name(),
                endings.rollouts
            ));
        }
        if endings.doubtful > 0 {
            warn(&format!("{}: {} of {} rollouts {DOUBT}", base.name(), endings.doubtful, endings.rollouts));
        }
    }
    let summary = study_summary::json(&results)?;
    write_text(&folder.join("results.json"), &format!("{summary:#}\n"))?;
    write_page(&legwork_report::study::page(&results)?, folder)?;
    output.line(if json { summary.to_string() } else { study_summary::text(&results)? })?;
    output.flush()?;
    say(&format!("report: {}", folder.join("report.html").display()));
    Ok(())
}
