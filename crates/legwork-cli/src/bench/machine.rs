//! On what, and by what, was measured.

use std::fs;
use std::time::Instant;

use serde::Serialize;

use crate::output::warn;

/// The machine, the program and the clock.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Machine {
    /// The processor, as it names itself; none where the operating system does not say.
    pub(super) processor: Option<String>,
    /// Threads that can run at a time.
    pub(super) cores: usize,
    /// Threads that ran or wanted to, on average over the last minute, before anything was measured.
    pub(super) load: Option<f64>,
    /// Version of legwork.
    pub(super) legwork: &'static str,
    /// The compiler that made it.
    pub(super) rustc: &'static str,
    /// What it was compiled for.
    pub(super) target: &'static str,
    /// How far it was optimised: 3 is what figures should be of.
    pub(super) opt_level: &'static str,
    /// What reading the clock takes [ns]; it is taken off every figure of ticks, parts and steps.
    pub(super) clock_ns: f64,
}

impl Machine {
    /// This one.
    pub(super) fn new(clock: &Clock) -> Self {
        let field = |text: String| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let load = fs::read_to_string("/proc/loadavg").ok();
        Self {
            processor: fs::read_to_string("/proc/cpuinfo").ok().and_then(field),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            load: load.and_then(|text| text.split(' ').next()?.parse().ok()),
            legwork: env!("CARGO_PKG_VERSION"),
            rustc: env!("LEGWORK_RUSTC"),
            target: env!("LEGWORK_TARGET"),
            opt_level: env!("LEGWORK_OPT_LEVEL"),
            clock_ns: clock.overhead_s * 1e9,
        }
    }

    /// Says what speaks against the figures.
    pub(super) fn warn(&self) {
        if self.opt_level != "3" {
            let level = self.opt_level;
            warn(&format!("built with opt-level {level}; `cargo build --release` makes what is worth measuring"));
        }
        if let Some(load) = self.load.filter(|&load| load > 0.5 * self.cores as f64) {
            warn(&format!("this machine is busy (load {load} of {} cores); figures may be too high", self.cores));
        }
    }
}

/// A clock that knows what reading it takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    overhead_s: f64,
}

impl Clock {
    /// Finds out what reading takes: the median over many intervals with nothing in them.
    pub(super) fn new() -> Self {
        let mut empty: Vec<f64> = (0..10_001).map(|_| Instant::now().elapsed().as_secs_f64()).collect();
        Self { overhead_s: super::samples::median(&mut empty) }
    }

    /// How long `work` takes [s].
    pub(super) fn time<T>(self, work: impl FnOnce() -> T) -> (T, f64) {
        let begin = Instant::now();
        let done = work();
        (done, self.since(begin))
    }

    /// How long it is since `begin` [s].
    pub(super) fn since(self, begin: Instant) -> f64 {
        (begin.elapsed().as_secs_f64() - self.overhead_s).max(0.0)
    }
}
