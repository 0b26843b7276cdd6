//! `legwork run`: scenarios to tables, JSON, logs, reports.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, MutexGuard};

use legwork::Robot;
use legwork::channel::Columns;
use legwork::episode::{Episode, Outcome, Parts, Run};
use legwork::error::Error;
use legwork::scenario::Scenario;
use legwork::sink::{Hashes, Sink};
use legwork::{clock, episode, log_file, scenario_file};
use legwork_report::run as report;
use legwork_study::files::Unfinished;

use crate::args::RunArgs;
use crate::long_work::{INTERRUPTED, Progress, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, check_writable, say, warn, write_file, write_text};
use crate::summary;

pub(crate) fn run(options: &RunArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    // Wrong files and unwritable places are found before anything runs.
    let jobs = jobs(options)?;
    check_outputs(options, &jobs)?;
    listen_for_interrupt();

    let (mut fell, mut reported, mut printed) = (false, Vec::new(), Ok(()));
    for job in &jobs {
        let (run, without_log, log) = job.run()?;
        let text = if options.json { summary::json(&run).to_string() } else { summary::text(&run) };
        printed = output.line(text).and_then(|()| output.flush());
        for violation in run.violations() {
            warn(&format!("{}: the simulation broke its own bounds: {violation}", run.scenario.name));
        }
        for passed in &run.limits_passed {
            warn(&format!("{}: {passed}", run.scenario.name));
        }
        if let (Some(path), Some(error)) = (&job.log, without_log) {
            return Err(Failure::unwritten(path, error));
        }
        job.write_files(&run, log, options)?;
        fell |= matches!(run.outcome, Outcome::Fell(_));
        if options.report.is_some() {
            reported.push(run);
        }
        if printed.is_err() || interrupted() {
            break;
        }
    }
    if interrupted() {
        say("interrupted; what was simulated so far is kept");
    }
    if let Some(path) = &options.report {
        write_text(path, &report::html(&reported))?;
        say(&format!("report: {}", path.display()));
    }
    printed?;
    Ok(match (interrupted(), fell && options.expect_standing) {
        (true, _) => ExitCode::from(INTERRUPTED),
        (false, true) => ExitCode::from(1),
        (false, false) => ExitCode::SUCCESS,
    })
}

/// A scenario with all that it names.
struct Job {
    scenario: Scenario,
    model: Robot,
    samples: Vec<[f64; 3]>,
    /// Its name, made different from those of the other jobs.
    label: String,
    log: Option<PathBuf>,
    /// Whether the log is written while the run goes on: where nothing else needs all of it.
    streams: bool,
}

/// Reads the scenarios and what they name, and takes their start poses, so that mistakes show before anything runs.
fn jobs(options: &RunArgs) -> Result<Vec<Job>, Error> {
    let mut jobs: Vec<Job> = Vec::new();
    for name in &options.scenarios {
        let mut job = prepare(name, options)?;
        let name = job.label.clone();
        for number in 2.. {
            if jobs.iter().all(|other| other.label != job.label) {
                break;
            }
            job.label = format!("{name}-{number}");
        }
        let several = options.scenarios.len() > 1;
        job.log = options.log.as_ref().map(|path| if several { with_name(path, &job.label) } else { path.clone() });
        jobs.push(job);
    }
    Ok(jobs)
}

fn prepare(name: &str, options: &RunArgs) -> Result<Job, Error> {
    let mut sets = options.sets.clone();
    sets.extend(options.duration.iter().map(|duration| format!("duration_s={duration}")));
    let loaded = scenario_file::load(name, &sets).map_err(|error| as_typed(error, name, options))?;
    let (model, samples) = (loaded.model()?, loaded.samples()?);
    let streams = options.log.is_some() && options.report.is_none() && options.plots.is_none();
    let sink = || -> Box<dyn Sink> { Box::new(()) };
    let parts = Parts { samples: samples.clone(), sink: streams.then(sink), ..Parts::default() };
    Episode::with(&loaded.scenario, &model, parts).map_err(|error| as_typed(loaded.locate(error), name, options))?;
    let label = loaded.scenario.name.clone();
    Ok(Job { scenario: loaded.scenario, model, samples, label, log: None, streams })
}

/// `--duration` goes the way of a `--set`, but should not be called one; of several scenarios, the one is named.
fn as_typed(error: Error, name: &str, options: &RunArgs) -> Error {
    match error {
        Error::Invalid { place, problem } if place == "--set duration_s" && options.duration.is_some() => {
            Error::invalid("--duration", problem)
        }
        Error::Invalid { place, problem } if place.starts_with("--set ") && options.scenarios.len() > 1 => {
            Error::invalid(format!("{place} of {name}"), problem)
        }
        other => other,
    }
}

/// `run.csv` to `run-walk.csv`.
fn with_name(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{name}.{ending}"))
}

fn check_outputs(options: &RunArgs, jobs: &[Job]) -> Result<(), Failure> {
    if let Some(path) = &options.log {
        log_file::Format::of(path)?;
    }
    let logs = || jobs.iter().filter_map(|job| job.log.as_deref());
    for path in logs().chain(options.report.as_deref()) {
        check_writable(path)?;
    }
    let taken = |report: &Path| options.scenarios.iter().map(Path::new).chain(logs()).any(|path| path == report);
    if let Some(report) = options.report.as_deref().filter(|report| taken(report)) {
        let problem = format!("found {}, which is a scenario's or a log's file; give another", report.display());
        return Err(Error::invalid("--report", problem).into());
    }
    if let Some(folder) = &options.plots {
        let problem = |error: std::io::Error| {
            if folder.exists() { "is a file; give the name of a folder".to_owned() } else { error.to_string() }
        };
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::Output { path: folder.clone(), problem: problem(error) })?;
    }
    Ok(())
}

/// A log that is written while the run goes on; where it cannot be, the run stops, and what was simulated so far is told all the same.
#[derive(Debug)]
struct Streamed {
    sink: Box<dyn Sink>,
    failed: Arc<Mutex<Option<Error>>>,
}

impl Streamed {
    fn failure(&self) -> MutexGuard<'_, Option<Error>> {
        self.failed.lock().expect("nobody panics with it")
    }

    fn note(&self, done: Result<(), Error>) -> Result<(), Error> {
        if let Err(error) = done {
            self.failure().get_or_insert(error);
        }
        Ok(())
    }
}

impl Sink for Streamed {
    fn record(&mut self, columns: &Columns, values: &[f64]) -> Result<(), Error> {
        let done = self.sink.record(columns, values);
        self.note(done)
    }

    fn finish(&mut self, hashes: &Hashes) -> Result<(), Error> {
        let done = if self.failure().is_none() { self.sink.finish(hashes) } else { Ok(()) };
        self.note(done)
    }
}

impl Job {
    /// Its run, why its log could not be written, and where that waits to be whole: nowhere, where the log is a pipe or a
    /// device, or is not written while the run goes on.
    fn run(&self) -> Result<(Run, Option<Error>, Option<Unfinished>), Error> {
        let length = (self.scenario.duration_s * 1e3) as u64;
        let failed = Arc::new(Mutex::new(None));
        let failure = || failed.lock().expect("nobody panics with it");
        let log = self.log.as_deref().filter(|_| self.streams);
        let is_file = |path: &Path| path.metadata().map_or(true, |found| found.is_file());
        let file = log.filter(|path| is_file(path)).map(Unfinished::new).transpose()?;
        let sink = |path: &Path| -> Result<Box<dyn Sink>, Error> {
            let sink = log_file::create(file.as_ref().map_or(path, Unfinished::written), &self.scenario.name)?;
            Ok(Box::new(Streamed { sink, failed: Arc::clone(&failed) }))
        };
        let parts = Parts {
            samples: self.samples.clone(),
            clock: Some(clock::system),
            sink: log.map(sink).transpose()?,
            ..Parts::default()
        };
        let bar = Progress::new(&self.label, length, "{percent} % simulated");
        let run = episode::run_with(&self.scenario, &self.model, parts, |time| {
            bar.tell((time * 1e3) as u64);
            interrupted() || failure().is_some()
        });
        bar.finish();
        let failure = failure().take();
        Ok((run?, failure, file))
    }

    /// Writes what was asked for beside tables; `log` is what was written while the run went on.
    fn write_files(&self, run: &Run, log: Option<Unfinished>, options: &RunArgs) -> Result<(), Failure> {
        if let Some(path) = &self.log {
            match log {
                Some(log) => log.finish()?,
                None if self.streams => {}
                None => write_file(path, |path| log_file::write(run, path))?,
            }
            say(&format!("log: {}", path.display()));
        }
        if let Some(folder) = &options.plots {
            for (name, svg) in report::plots(&self.labelled(run)) {
                write_text(&folder.join(name), &svg)?;
            }
            say(&format!("plots: {}", folder.display()));
        }
        Ok(())
    }

    /// The run under the job's label, which names its plots.
    fn labelled<'a>(&self, run: &'a Run) -> Cow<'a, Run> {
        let mut run = Cow::Borrowed(run);
        if run.scenario.name != self.label {
            run.to_mut().scenario.name.clone_from(&self.label);
        }
        run
    }
}
