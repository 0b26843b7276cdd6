//! One pass over recorded inputs, timed: whole ticks, the parts of ticks, steps.
//!
//! Whole ticks and their parts are measured in passes of their own, so that the clock read between the parts is not in
//! the whole.

use std::time::Instant;

use legwork::contract::Sensed;
use legwork::control::{Controller, MomentumController};
use legwork::sim::Simulator;
use legwork_rbd::{Dynamics, Model};

use super::machine::Clock;

/// The dynamics, then the controller's [parts](legwork::momentum::Part).
pub(super) const PARTS: [&str; 5] = ["dynamics", "references, goals", "assembly", "solve", "reading"];

/// Duration of each tick, with the dynamics of its state [s].
pub(super) fn ticks(clock: Clock, model: &Model, mut controller: MomentumController, estimates: &[Sensed]) -> Vec<f64> {
    let mut dynamics = Dynamics::new(model);
    estimates
        .iter()
        .map(|estimate| {
            let begin = Instant::now();
            dynamics.update(model, &estimate.q, &estimate.v);
            controller.tick(estimate, &dynamics);
            clock.since(begin)
        })
        .collect()
}

/// Duration of each of [`PARTS`], and in it of each tick [s].
pub(super) fn parts(
    clock: Clock,
    model: &Model,
    mut controller: MomentumController,
    estimates: &[Sensed],
) -> [Vec<f64>; PARTS.len()] {
    let mut dynamics = Dynamics::new(model);
    let mut durations = PARTS.map(|_| vec![0.0; estimates.len()]);
    for (index, estimate) in estimates.iter().enumerate() {
        let mut begin = Instant::now();
        dynamics.update(model, &estimate.q, &estimate.v);
        durations[0][index] = clock.since(begin);
        begin = Instant::now();
        controller.tick_in_parts(estimate, &dynamics, |part| {
            // Parts of several attempts add up.
            durations[1 + part as usize][index] += clock.since(begin);
            begin = Instant::now();
        });
    }
    durations
}

/// Duration of each of the steps that come after each tick [s].
pub(super) fn steps(clock: Clock, mut simulator: Simulator, torques: &[Vec<f64>], per_tick: usize) -> Vec<f64> {
    let mut durations = Vec::with_capacity(torques.len() * per_tick);
    for torques in torques {
        for _ in 0..per_tick {
            let begin = Instant::now();
            simulator.step(torques);
            durations.push(clock.since(begin));
        }
    }
    durations
}
