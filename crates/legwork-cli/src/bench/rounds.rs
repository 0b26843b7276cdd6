//! How many rounds are measured: some at least, then as many as the time is for.

use std::time::Instant;

use crate::long_work::{Progress, interrupted};

/// Fewest and most rounds: a median of fewer says little, one of more says no more.
const FEWEST: usize = 3;
const MOST: usize = 300;

/// The time that there is for measuring.
pub(super) struct Rounds {
    begin: Instant,
    seconds: f64,
    progress: Progress,
}

impl Rounds {
    /// From now on, of the work `name`, about so many seconds.
    pub(super) fn new(name: &str, seconds: f64) -> Self {
        let progress = Progress::new(name, (seconds * 1e3) as u64, "{percent} % measured");
        Self { begin: Instant::now(), seconds, progress }
    }

    /// Whether there should be another round after `done` of them.
    pub(super) fn go_on(&self, done: usize) -> bool {
        let elapsed = self.begin.elapsed().as_secs_f64();
        self.progress.tell((elapsed.min(self.seconds) * 1e3) as u64);
        !interrupted() && (done < FEWEST || (done < MOST && elapsed < self.seconds))
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.progress.finish();
    }
}
