//! Work that takes a while: Ctrl-C, and the bar that shows how long there is to wait.

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use legwork_study::parallel::run_all;
use serde::Serialize;

use crate::output::{Failure, Output, say};

/// Exit code after Ctrl-C, as shells have it: 128 and the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// Progress shows where work takes longer than this.
const PATIENCE: Duration = Duration::from_secs(2);

/// Whether Ctrl-C was pressed.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C asks the work to stop; a second one ends the program at once.
pub(crate) fn listen_for_interrupt() {
    // A second handler in one process cannot be set; then Ctrl-C just ends the program.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
}

/// Prints a report, as JSON or in words, has its files written also where nobody reads what is printed, and says where it was
/// `interrupted`.
pub(crate) fn conclude<R: Serialize>(
    output: &mut Output,
    report: &R,
    words: Option<fn(&R) -> String>,
    interrupted: bool,
    write: impl FnOnce() -> Result<(), Failure>,
) -> Result<ExitCode, Failure> {
    let json = || serde_json::to_string(report).expect("a report is plain data");
    let printed = output.line(words.map_or_else(json, |words| words(report))).and_then(|()| output.flush());
    if interrupted {
        say("interrupted; what was finished is kept");
    }
    write()?;
    printed?;
    Ok(if interrupted { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

/// Whether Ctrl-C was pressed.
pub(crate) fn interrupted() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// A bar on a terminal, hidden until the work takes longer than one is ready to wait without it.
pub(crate) struct Progress {
    bar: ProgressBar,
    begin: Instant,
}

impl Progress {
    /// Of the work `name`, which has `length` parts; `template` says how many of them are done, in indicatif's words.
    pub(crate) fn new(name: &str, length: u64, template: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr());
        let template = format!("{{msg}} {{bar:30}} {template}, {{eta}} left");
        bar.set_style(ProgressStyle::with_template(&template).expect("the template is valid"));
        bar.set_message(name.to_owned());
        Self { bar, begin: Instant::now() }
    }

    /// That `done` parts are done by now.
    pub(crate) fn tell(&self, done: u64) {
        if self.begin.elapsed() > PATIENCE {
            self.bar.set_position(done.max(self.bar.position()));
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Many jobs of different kinds whose progress is shown as one.
pub(crate) struct Jobs {
    progress: Progress,
    done: AtomicU64,
}

impl Jobs {
    /// Work of about so many rollouts.
    pub(crate) fn new(name: &str, rollouts: u64) -> Self {
        let progress = Progress::new(name, rollouts, "{percent} % of about {len} rollouts");
        Self { progress, done: AtomicU64::new(0) }
    }

    /// The results of `job(0)` to `job(count - 1)`, each of about so many rollouts, without those that were stopped.
    pub(crate) fn all<T: Send>(&self, count: usize, rollouts: u64, job: impl Fn(usize) -> Option<T> + Sync) -> Vec<T> {
        let results = run_all(count, |index| {
            let result = if interrupted() { None } else { job(index) };
            self.progress.tell(self.done.fetch_add(rollouts, Ordering::Relaxed) + rollouts);
            Some(result)
        });
        results.into_iter().flatten().flatten().collect()
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        self.progress.finish();
    }
}
