//! Work that takes a while: Ctrl-C, and the bar that shows how long there is to wait.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

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
