//! The work whose instructions `cargo xtask count-instructions` counts: recorded inputs through functions that are never
//! inlined, so that callgrind can collect within them and nothing else. Prints how many of them there were.
//!
//! `counted WORK`, with the names of `bench/instructions.toml`. Not for timing: `legwork bench` is.

use std::error::Error;
use std::hint::black_box;
use std::io::{self, Write};
use std::path::Path;

use legwork::contract::Sensed;
use legwork::control::{Controller, MomentumController};
use legwork::recording::Recording;
use legwork::sim::Simulator;
use legwork::{episode, scenario_file};
use legwork_rbd::{Dynamics, Model};

/// Ticks before the first that is counted, and how many are: half a second.
const WARM_UP: usize = 100;
const TICKS: usize = 500;
/// States of the exoskeleton.
const STATES: usize = 200;

// Without closures in them: these would be functions of like names, at which collecting would be switched off.

#[inline(never)]
fn count_ticks(model: &Model, dynamics: &mut Dynamics, controller: &mut MomentumController, estimates: &[Sensed]) {
    for estimate in estimates {
        dynamics.update(model, &estimate.q, &estimate.v);
        black_box(controller.tick(estimate, dynamics));
    }
}

#[inline(never)]
fn count_steps(simulator: &mut Simulator, torques: &[Vec<f64>]) {
    for torques in torques {
        black_box(simulator.step(torques));
    }
}

#[inline(never)]
fn count_updates(model: &Model, dynamics: &mut Dynamics, states: &[[Vec<f64>; 2]]) {
    for [q, v] in states {
        dynamics.update(model, q, v);
        black_box(&dynamics);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // In the counted half second of the push the force acts and a step begins.
    let push = ["pushes.0.start_s=0.2"];
    let count = match std::env::args().nth(1).as_deref() {
        Some("tick_walk") => ticks("walk", &[])?,
        Some("tick_push") => ticks("push", &push)?,
        Some("tick_slack") => ticks("walk", &["controller.form=slack"])?,
        Some("tick_exo") => ticks("exo-sway", &[])?,
        Some("step_push") => steps("push", &push)?,
        Some("step_exo") => steps("exo-sway", &[])?,
        Some("dynamics_exo18") => updates("exo18.urdf")?,
        other => return Err(format!("no such work: {other:?}").into()),
    };
    writeln!(io::stdout(), "{count}")?;
    Ok(())
}

fn ticks(scenario: &str, sets: &[&str]) -> Result<usize, Box<dyn Error>> {
    let recording = record(scenario, sets)?;
    let (before, counted) = recording.estimates.split_at(WARM_UP);
    let mut controller = recording.controller()?;
    let mut dynamics = Dynamics::new(recording.known());
    for estimate in before {
        dynamics.update(recording.known(), &estimate.q, &estimate.v);
        controller.tick(estimate, &dynamics);
    }
    count_ticks(recording.known(), &mut dynamics, &mut controller, counted);
    Ok(counted.len())
}

fn steps(scenario: &str, sets: &[&str]) -> Result<usize, Box<dyn Error>> {
    let recording = record(scenario, sets)?;
    assert_eq!(recording.steps_per_tick, 1, "a step a tick");
    let (before, counted) = recording.torques.split_at(WARM_UP);
    let mut simulator = recording.simulator()?;
    for torques in before {
        simulator.step(torques);
    }
    count_steps(&mut simulator, counted);
    Ok(counted.len())
}

/// On a path on which everything moves.
fn updates(file: &str) -> Result<usize, Box<dyn Error>> {
    let model = Model::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(file))?;
    let v: Vec<f64> = (0..model.nv()).map(|j| 0.1 * (j + 1) as f64).collect();
    let mut q = model.neutral().as_slice().to_vec();
    let mut states = Vec::new();
    for _ in 0..STATES {
        let before = q.clone();
        model.integrate(&before, &v, 0.01, &mut q);
        states.push([before, v.clone()]);
    }
    count_updates(&model, &mut Dynamics::new(&model), &states);
    Ok(states.len())
}

/// The inputs of a run that is just long enough.
fn record(scenario: &str, sets: &[&str]) -> Result<Recording, Box<dyn Error>> {
    let mut sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    sets.push("duration_s=0.6".to_owned());
    let loaded = scenario_file::load(scenario, &sets)?;
    let samples = loaded.samples()?;
    let run = episode::run(&loaded.scenario, &loaded.model()?, &samples, |_| false)?;
    assert_eq!(run.log.len(), WARM_UP + TICKS, "ticks of {scenario}");
    Ok(Recording::of(&run, &samples))
}
