//! A scenario measured: rounds of ticks, parts, steps, a rollout, and rollouts on more and more threads.

use std::time::Instant;

use legwork::control::Fallback;
use legwork::episode::{Outcome, Run};
use legwork::error::Error;
use legwork::log::Field;
use legwork::recording::Recording;
use legwork::sim::Simulator;
use legwork_study::parallel::{run_all, with_threads};
use legwork_study::{Base, Variant, rollout};
use serde::Serialize;

use super::machine::Clock;
use super::replay;
use super::rounds::Rounds;
use super::samples::{Histogram, Samples, Statistics, median};
use crate::long_work::interrupted;

/// All that is said of a scenario.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Measured {
    /// Its name.
    pub(super) scenario: String,
    /// Degrees of freedom of the robot.
    pub(super) dofs: usize,
    /// Its contact points.
    pub(super) contacts: usize,
    /// Variables of the program.
    pub(super) variables: usize,
    /// Its rows.
    pub(super) rows: usize,
    /// Ticks of a rollout.
    pub(super) ticks: usize,
    /// Simulation steps of a rollout.
    pub(super) steps: usize,
    /// Rounds in which everything was measured.
    pub(super) rounds: usize,
    /// The whole control tick.
    pub(super) tick: Statistics,
    /// How its durations are spread.
    pub(super) tick_histogram: Histogram,
    /// Its parts, measured apart.
    pub(super) parts: Vec<PartFigures>,
    /// The simulation step.
    pub(super) step: Statistics,
    /// The same under random torques of up to 20 Nm.
    pub(super) step_under_random_torques: Statistics,
    /// What the solver does.
    pub(super) solver: Solver,
    /// The whole run with log and figures.
    pub(super) rollout: Rollout,
    /// Many of them at once.
    pub(super) threads: Vec<Threads>,
}

/// A part of the tick.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PartFigures {
    /// Which.
    pub(super) part: &'static str,
    /// Its share of the whole tick: that of the means.
    pub(super) share: f64,
    /// Its durations.
    #[serde(flatten)]
    pub(super) durations: Statistics,
}

/// What the solver does in a tick; the same on every machine.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Solver {
    /// Iterations: changes of its working set after the guess, all attempts together. Mean.
    pub(super) iterations_mean: f64,
    /// Most of them.
    pub(super) iterations_max: u32,
    /// Limits that are met or left from a tick to the next. Mean.
    pub(super) limits_changed_mean: f64,
    /// Most of them.
    pub(super) limits_changed_max: usize,
    /// Programs solved. Mean: one, and more with fallbacks.
    pub(super) programs_mean: f64,
    /// Ticks that ended with a fallback.
    pub(super) fallbacks: usize,
}

/// The whole run.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Rollout {
    /// Simulated time [s].
    pub(super) simulated_s: f64,
    /// Median of its duration over the rounds [s].
    pub(super) median_s: f64,
    /// The longest [s].
    pub(super) max_s: f64,
    /// Simulated time over the median.
    pub(super) times_real_time: f64,
}

/// Rollouts on several threads.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Threads {
    /// How many.
    pub(super) threads: usize,
    /// Median over the rounds.
    pub(super) rollouts_per_s: f64,
    /// That over the one of a single thread.
    pub(super) speed_up: f64,
    /// Simulation steps alone, under random torques. Median over the rounds.
    pub(super) steps_per_s: f64,
}

/// Rollouts that each thread does at a time.
const BATCH: usize = 2;
/// Robots that each thread steps at a time, and how often it does so.
const ROBOTS: usize = 16;
const STEPS: usize = 500;
/// Largest random torque [Nm].
const RANDOM_NM: f64 = 20.0;

/// What is being measured.
struct Measurement<'a> {
    variant: &'a Variant,
    clock: Clock,
    recording: Recording,
    random: Recording,
    tick: Samples,
    parts: [Samples; replay::PARTS.len()],
    step: Samples,
    random_step: Samples,
    rollouts: Vec<f64>,
    counts: Vec<usize>,
    /// Rollouts a second, and steps, for each of the counts.
    rates: Vec<Vec<[f64; 2]>>,
}

/// Measures `base` on `cores` cores for about `seconds`; none where Ctrl-C was pressed before a round was whole.
pub(super) fn measure(base: &Base, clock: Clock, cores: usize, seconds: f64) -> Result<Option<Measured>, Error> {
    let rounds = Rounds::new(base.name(), seconds);
    let run = rollout::simulate(base.variant(), interrupted)?;
    if matches!(run.outcome, Outcome::Stopped) {
        return Ok(None);
    }
    let counts = thread_counts(cores);
    let recording = Recording::of(&run, &base.variant().samples);
    let mut measurement = Measurement {
        variant: base.variant(),
        clock,
        random: recording.clone().with_random_torques(RANDOM_NM),
        recording,
        tick: Samples::default(),
        parts: Default::default(),
        step: Samples::default(),
        random_step: Samples::default(),
        rollouts: Vec::new(),
        rates: vec![Vec::new(); counts.len()],
        counts,
    };
    while rounds.go_on(measurement.rollouts.len()) {
        measurement.round()?;
    }
    rounds.finish();
    Ok((!measurement.rollouts.is_empty()).then(|| measurement.figures(&run)))
}

/// One, two, four and so on, and all.
fn thread_counts(cores: usize) -> Vec<usize> {
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1), |count| Some(2 * count)).take_while(|&c| c < cores).collect();
    counts.push(cores);
    counts
}

impl Measurement<'_> {
    /// Everything once; nothing is kept of a round in which Ctrl-C was pressed.
    fn round(&mut self) -> Result<(), Error> {
        let (clock, recording) = (self.clock, &self.recording);
        let ticks = replay::ticks(clock, recording.known(), recording.controller()?, &recording.estimates);
        let parts = replay::parts(clock, recording.known(), recording.controller()?, &recording.estimates);
        let steps = replay::steps(clock, recording.simulator()?, &recording.torques, recording.steps_per_tick);
        let random = replay::steps(clock, self.random.simulator()?, &self.random.torques, recording.steps_per_tick);
        let (_, rollout) = clock.time(|| rollout::run(self.variant, interrupted));
        let rates = self.counts.iter().map(|&threads| self.rates(threads)).collect::<Result<Vec<_>, Error>>()?;
        if interrupted() {
            return Ok(());
        }
        self.tick.push(ticks);
        self.parts.iter_mut().zip(parts).for_each(|(samples, round)| samples.push(round));
        self.step.push(steps);
        self.random_step.push(random);
        self.rollouts.push(rollout);
        self.rates.iter_mut().zip(rates).for_each(|(rates, rate)| rates.push(rate));
        Ok(())
    }

    /// Rollouts a second, and simulation steps.
    fn rates(&self, threads: usize) -> Result<[f64; 2], Error> {
        let robots =
            (0..threads * ROBOTS).map(|_| self.random.simulator()).collect::<Result<Vec<Simulator>, Error>>()?;
        let steps = STEPS.min(self.random.torques.len());
        // Each robot is given the torques of another time.
        let step = |index: usize| {
            let mut robot = robots[index].clone();
            let torques = self.random.torques.iter().cycle().skip(index * steps).take(steps);
            torques.for_each(|torques| _ = robot.step(torques));
            robot
        };
        let rate = |count: usize, work: &(dyn Fn(usize) + Sync)| {
            let begin = Instant::now();
            run_all(count, |index| {
                work(index);
                Some(())
            });
            count as f64 / begin.elapsed().as_secs_f64()
        };
        with_threads(Some(threads), || {
            let rollouts = rate(BATCH * threads, &|_| _ = rollout::run(self.variant, interrupted));
            [rollouts, steps as f64 * rate(robots.len(), &|index| _ = step(index))]
        })
    }

    fn figures(mut self, run: &Run) -> Measured {
        let tick = self.tick.statistics();
        let parts = replay::PARTS.into_iter().zip(&mut self.parts).map(|(part, samples)| {
            let durations = samples.statistics();
            PartFigures { part, share: durations.mean_us / tick.mean_us, durations }
        });
        let parts: Vec<_> = parts.collect();
        let simulated_s = run.log.len() as f64 * run.scenario.controller.period_s;
        let median_s = median(&mut self.rollouts.clone());
        let middle =
            |rates: &Vec<[f64; 2]>| [0, 1].map(|k| median(&mut rates.iter().map(|rate| rate[k]).collect::<Vec<_>>()));
        let rates: Vec<[f64; 2]> = self.rates.iter().map(middle).collect();
        let threads = self.counts.iter().zip(&rates).map(|(&threads, &[rollouts_per_s, steps_per_s])| Threads {
            threads,
            rollouts_per_s,
            speed_up: rollouts_per_s / rates[0][0],
            steps_per_s,
        });
        Measured {
            scenario: run.scenario.name.clone(),
            dofs: run.model.nv(),
            contacts: run.model.nc(),
            variables: run.program.size[0],
            rows: run.program.size[1],
            ticks: self.recording.estimates.len(),
            steps: self.recording.torques.len() * self.recording.steps_per_tick,
            rounds: self.rollouts.len(),
            tick_histogram: self.tick.histogram(),
            tick,
            parts,
            step: self.step.statistics(),
            step_under_random_torques: self.random_step.statistics(),
            solver: Solver::of(run),
            rollout: Rollout {
                simulated_s,
                median_s,
                max_s: self.rollouts.iter().copied().fold(0.0, f64::max),
                times_real_time: simulated_s / median_s,
            },
            threads: threads.collect(),
        }
    }
}

impl Solver {
    fn of(run: &Run) -> Self {
        let ticks = run.log.len();
        let active = |index: usize| run.log.get(index, Field::ActiveLimit);
        let differ =
            |index: usize| active(index).iter().zip(active(index - 1)).filter(|(now, before)| now != before).count();
        let changes: Vec<usize> = (1..ticks).map(differ).collect();
        let program = |column: usize| (0..ticks).map(move |index| run.log.get(index, Field::Program)[column]);
        Self {
            iterations_mean: run.program.iterations_mean,
            iterations_max: run.program.iterations_max,
            limits_changed_mean: changes.iter().sum::<usize>() as f64 / changes.len().max(1) as f64,
            limits_changed_max: changes.iter().copied().max().unwrap_or(0),
            programs_mean: program(3).sum::<f64>() / ticks as f64,
            fallbacks: program(1).filter(|&fallback| fallback != f64::from(Fallback::None as u8)).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::thread_counts;

    #[test]
    fn threads_double_up_to_the_cores() {
        assert_eq!(thread_counts(1), [1]);
        assert_eq!(thread_counts(2), [1, 2]);
        assert_eq!(thread_counts(12), [1, 2, 4, 8, 12]);
    }
}
