//! What the steps of a reference generator can do, and what of the XcoM they catch.
//!
//! Two generators step, and each has a bound beyond which no number of steps catches the XcoM (the capturability of Koolen et
//! al. 2012): the step machine by its longest step and its duration, here; the walker, which chooses place and time of each
//! step, by how far foot and leg reach, in `landing.rs`.

use super::What;
use super::evidence::{Evidence, Stretch, below};
use super::landing::{Landing, WalkerSteps};
use crate::balance::support::along;
use crate::generator::{swing, xcom};
use crate::log::Field;
use crate::robot::Robot;
use crate::scenario::{GeneratorKind, Scenario, StepSettings};

/// The longest step that legs make, in heights of the CoM at the start: legs are about 1.05 of them long, and hips let
/// down to 0.78 of them reach 0.7 behind and 0.7 ahead.
const LONGEST_STEP: f64 = 1.4;
/// A foot of the step machine is late when its step has lasted this many times its duration: healthy ones last up to 1.3.
const LATE: f64 = 1.5;
/// A foot of the step machine should stand when its step has lasted this many times its duration.
const DUE: f64 = 1.1;
/// A foot whose reference is slower than this along the walking direction is above its place [m/s].
const ARRIVED: f64 = 1e-3;

/// What makes the steps.
#[derive(Debug)]
pub(super) enum Steps<'a> {
    /// The step machine.
    Machine(&'a StepSettings),
    /// The walker.
    Walker(Box<WalkerSteps>),
    /// Nothing: the robot stands, or lifts a foot as planned.
    None,
}

impl<'a> Steps<'a> {
    pub(super) fn of(scenario: &'a Scenario, model: &Robot) -> Self {
        match scenario.reference.generator {
            GeneratorKind::Steps => Self::Machine(&scenario.reference.step),
            GeneratorKind::Walker => Self::Walker(Box::new(WalkerSteps::of(scenario, model))),
            GeneratorKind::Stance => Self::None,
        }
    }
}

/// The step that the XcoM asks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// How far the XcoM is past `edge` [m].
    past: f64,
    edge: &'static str,
    longest: f64,
    /// How long a step lasts [s], where that is given.
    lasts: Option<f64>,
    /// By how much the longest step falls short of the XcoM [m].
    pub(super) short: f64,
    /// Whether legs make no step that long.
    pub(super) beyond_legs: bool,
}

impl Wanted {
    /// The longest step does not reach it; after pushes of an impulse [Ns], where they are the first cause.
    pub(super) fn missed(self, pushed: Option<f64>) -> What {
        let Self { past, edge, longest, lasts, short, .. } = self;
        What::OutOfReach { past, edge, longest, lasts, short, pushed }
    }
}

impl Evidence<'_> {
    /// How far the XcoM is beyond what any number of steps can catch [m]; negative where it is in reach, or where nothing
    /// steps.
    pub(super) fn out_of_reach(&self, i: usize) -> f64 {
        match &self.steps {
            // What is above the feet is not past them, however far it would run in a step.
            Steps::Machine(_) if self.past_the_feet(i) <= 0.0 => f64::NEG_INFINITY,
            Steps::Machine(step) => self.out_of_machine(step, i),
            Steps::Walker(walker) => match walker.moment(self, i) {
                Some(moment) if moment.past > 0.0 => walker.best(&moment).beyond,
                _ => f64::NEG_INFINITY,
            },
            Steps::None => f64::NEG_INFINITY,
        }
    }

    /// The step that would catch the XcoM where the next one begins after tick `i`, if anything steps.
    pub(super) fn wanted(&self, i: usize) -> Option<Wanted> {
        match &self.steps {
            Steps::Machine(step) => {
                let legs = LONGEST_STEP * self.scenario.start.com_height_m;
                let (past, apart) = self.past_front(step, i);
                let wanted = xcom::predicted_xcom(past, 0.0, self.omega(i), step.duration_s) + apart; // Thesis (2.5)
                let longest = step.max_length_m;
                let (short, beyond_legs) = (wanted - longest, wanted > legs);
                Some(Wanted {
                    past: self.past_the_feet(i),
                    edge: "front foot",
                    longest,
                    lasts: Some(step.duration_s),
                    short,
                    beyond_legs,
                })
            }
            Steps::Walker(walker) => {
                let moment = walker.moment(self, i)?;
                let Landing { length: longest, short, .. } = walker.best(&moment);
                let edge = if moment.way > 0.0 { "toes" } else { "heels" };
                let beyond_legs = longest + short > moment.upright_step;
                // Reckoned, not set: to the centimetre.
                let longest = 0.01 * (100.0 * longest).round();
                Some(Wanted { past: moment.past, edge, longest, lasts: None, short, beyond_legs })
            }
            Steps::None => None,
        }
    }

    /// The tick at which an XcoM is told of that is out of reach since tick `out`, `over` [s] being when the pushes until then
    /// are: where the step machine's next step begins, or where the walker, which changes a step under way, has been pushed.
    pub(super) fn told_at(&self, out: usize, over: f64) -> usize {
        let last = self.log.len() - 1;
        let after = (out..last).find(|&i| self.time(i) >= over).unwrap_or(last);
        if !matches!(self.steps, Steps::Machine(_)) {
            return after;
        }
        let next = self.stretches.iter().find(|stretch| {
            stretch.foot.is_some() && stretch.ticks.start >= out && self.time(stretch.ticks.start) >= over
        });
        next.map_or(after, |stretch| stretch.ticks.start.max(1) - 1)
    }

    /// XcoM and feet as the step under way leaves them, or as they are in double support: how far the XcoM is past
    /// the front foot, and how far the feet are apart [m].
    pub(super) fn past_front(&self, step: &StepSettings, i: usize) -> (f64, f64) {
        let (mut xcom, mut feet) = (self.xcom(i), [0, 1].map(|foot| self.foot_ahead(i, foot)));
        let stretch = self.stretch(i);
        // In its last tick the foot is down.
        if let Some(foot) = stretch.foot.filter(|_| i + 1 < stretch.ticks.end) {
            let left = (step.duration_s - (self.time(i) - self.time(stretch.ticks.start))).max(0.0);
            xcom = xcom::predicted_xcom(xcom, feet[1 - foot], self.omega(i), left); // Thesis (2.5)
            feet[foot] = self.planned(step, stretch, foot);
        }
        past_the_farther(xcom, feet)
    }

    /// How far the XcoM is past the farther foot [m].
    fn past_the_feet(&self, i: usize) -> f64 {
        past_the_farther(self.xcom(i), [0, 1].map(|foot| self.foot_ahead(i, foot))).0
    }

    /// The XcoM, as the robot has it [m]: what the generator reckons may be late or noisy.
    fn xcom(&self, i: usize) -> f64 {
        let [com, velocity] =
            [Field::Com, Field::ComVelocity].map(|field| along(self.ahead, below(self.log.get(i, field))));
        xcom::xcom(com, velocity, self.omega(i))
    }

    /// With the XcoM b past the front foot and the feet s apart, the rear foot steps L in the time T and the
    /// pendulum's point foot stands still: b' = b e^(ωT) − (L − s), s' = L − s. Two such steps keep b where
    /// b (e^(2ωT) − 1) = (L − s) e^(ωT) + s. Koolen et al. 2012, "Capturability-based analysis", for this step machine.
    pub(super) fn out_of_machine(&self, step: &StepSettings, i: usize) -> f64 {
        let (past, apart) = self.past_front(step, i);
        let growth = libm::exp(self.omega(i) * step.duration_s);
        past - ((step.max_length_m - apart) * growth + apart) / (growth * growth - 1.0)
    }

    /// Where the step machine's foot that swings in `stretch` should come down along the walking direction [m], by the latest plan.
    fn planned(&self, step: &StepSettings, stretch: &Stretch, foot: usize) -> f64 {
        let (first, last) = (stretch.ticks.start, stretch.ticks.end - 1);
        let duration = step.duration_s;
        let elapsed = (self.time(last) - self.time(first)).min(duration);
        let done = swing::forward(elapsed, duration, 1.0).value;
        let from = self.goal_ahead(first, foot, 0);
        if done > 0.0 { from + (self.goal_ahead(last, foot, 0) - from) / done } else { from }
    }

    /// The tick from which on a walker's foot that swings in `stretch` is above its place; none where it never came that far.
    fn due(&self, stretch: &Stretch, foot: usize) -> Option<usize> {
        let above = |&i: &usize| self.goal_ahead(i, foot, 1).abs() < ARRIVED;
        stretch.ticks.clone().rev().take_while(above).last()
    }

    /// The ticks from which on the step machine's foot that swings in `stretch` should stand, and is late; other generators have no time
    /// for it.
    pub(super) fn due_and_late(&self, stretch: &Stretch) -> Option<[usize; 2]> {
        let Steps::Machine(step) = &self.steps else { return None };
        Some([DUE, LATE].map(|times| stretch.ticks.start + self.ticks_in(times * step.duration_s)))
    }

    /// How far short of its planned place the foot came down at the end of `stretch` [m], negative beyond it; none where
    /// it did not come down, or before it was to be there.
    pub(super) fn short(&self, stretch: &Stretch, foot: usize) -> Option<f64> {
        let landed = stretch.ticks.end;
        if landed >= self.log.len() {
            return None;
        }
        let place = match &self.steps {
            Steps::Machine(step) => self.planned(step, stretch, foot),
            _ => self.goal_ahead(self.due(stretch, foot)?, foot, 0),
        };
        let way = place - self.goal_ahead(stretch.ticks.start, foot, 0);
        Some((place - self.foot_ahead(landed, foot)) * way.signum())
    }
}

/// How far the XcoM is past the farther of two feet, and how far those are apart [m].
fn past_the_farther(xcom: f64, feet: [f64; 2]) -> (f64, f64) {
    let (middle, apart) = (0.5 * (feet[0] + feet[1]), (feet[0] - feet[1]).abs());
    ((xcom - middle).abs() - 0.5 * apart, apart)
}
