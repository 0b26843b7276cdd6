//! `legwork run`: scenarios to tables, JSON, logs, reports.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use legwork::episode::{self, Outcome, Run};
use legwork::error::Error;
use legwork::{library, log_file, scenario_file};

use crate::args::RunArgs;
use crate::output::{Failure, Output, say, write_file};
use crate::{report, summary};

/// Whether Ctrl-C was pressed.
static STOP: AtomicBool = AtomicBool::new(false);

/// Progress shows where a run takes longer than this.
const PATIENCE: Duration = Duration::from_secs(2);

pub(crate) fn run(options: &RunArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    // Wrong files and unwritable places are found before anything runs.
    if let Some(path) = &options.log {
        log_file::Format::of(path)?;
    }
    let prepared: Vec<_> = options.scenarios.iter().map(|name| prepare(name, options)).collect::<Result<_, _>>()?;
    for path in [&options.log, &options.report].into_iter().flatten() {
        check_parent(path)?;
    }
    if let Some(folder) = &options.plots {
        std::fs::create_dir_all(folder).map_err(|error| Failure::Output { path: folder.clone(), error })?;
    }
    // A second handler in one process cannot be set; then Ctrl-C just ends the program.
    let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));

    let mut runs: Vec<Run> = Vec::new();
    for prepared in prepared {
        let bar = progress(&prepared.scenario.name, prepared.scenario.duration_s);
        let begin = Instant::now();
        let run = episode::run(&prepared.scenario, &prepared.model, &prepared.samples, |time| {
            if begin.elapsed() > PATIENCE {
                bar.set_position((time * 1e3) as u64);
            }
            STOP.load(Ordering::Relaxed)
        })?;
        bar.finish_and_clear();
        if options.json {
            output.line(summary::json(&run))?;
        } else {
            output.line(summary::text(&run))?;
        }
        for violation in run.audit.violations() {
            say(&format!("warning: {}: the simulation broke its own bounds: {violation}", run.scenario.name));
        }
        runs.push(run);
        if STOP.load(Ordering::Relaxed) {
            say("interrupted; what was simulated so far is kept");
            break;
        }
    }
    output.flush()?;
    write_files(options, &runs)?;
    let fell = runs.iter().any(|run| matches!(run.outcome, Outcome::Fell(_)));
    let stopped = runs.iter().any(|run| run.outcome == Outcome::Stopped);
    Ok(if stopped {
        ExitCode::from(130)
    } else if fell && options.expect_standing {
        ExitCode::from(1)
    } else {
        ExitCode::SUCCESS
    })
}

struct Prepared {
    scenario: legwork::scenario::Scenario,
    model: legwork_rbd::Model,
    samples: Vec<[f64; 3]>,
}

/// Reads a scenario and what it names, and takes its start pose, so that mistakes show before anything runs.
fn prepare(name: &str, options: &RunArgs) -> Result<Prepared, Error> {
    let mut sets = options.sets.clone();
    sets.extend(options.duration.iter().map(|duration| format!("duration_s={duration}")));
    let loaded = scenario_file::load(name, &sets)?;
    let model = library::load_model(&loaded.scenario.model, loaded.folder.as_deref())?;
    let file = &loaded.scenario.reference.com.file;
    let samples = if file.is_empty() { Vec::new() } else { library::load_samples(&loaded.resolve_path(file))? };
    episode::Episode::new(&loaded.scenario, &model, &samples)?;
    Ok(Prepared { scenario: loaded.scenario, model, samples })
}

fn write_files(options: &RunArgs, runs: &[Run]) -> Result<(), Failure> {
    for run in runs {
        if let Some(path) = &options.log {
            let path = if options.scenarios.len() > 1 { with_name(path, &run.scenario.name) } else { path.clone() };
            log_file::write(run, &path)?;
            say(&format!("log: {}", path.display()));
        }
        if let Some(folder) = &options.plots {
            for (name, svg) in report::plots(run) {
                write_file(&folder.join(name), &svg)?;
            }
            say(&format!("plots: {}", folder.display()));
        }
    }
    if let Some(path) = &options.report {
        write_file(path, &report::html(runs))?;
        say(&format!("report: {}", path.display()));
    }
    Ok(())
}

/// `run.csv` to `run-walk.csv`.
fn with_name(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{name}.{ending}"))
}

/// The folder of a file to be written must exist.
fn check_parent(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if parent.is_dir() {
        return Ok(());
    }
    let error = std::io::Error::new(std::io::ErrorKind::NotFound, format!("no folder {}", parent.display()));
    Err(Failure::Output { path: path.to_owned(), error })
}

/// A bar on a terminal, which stays hidden until it is moved.
fn progress(name: &str, duration: f64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some((duration * 1e3) as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent} % of the time simulated, {eta} left");
    bar.set_style(style.expect("the template is valid"));
    bar.set_message(name.to_owned());
    bar
}
