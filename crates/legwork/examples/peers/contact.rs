//! Physics steps with contacts, and closed loops.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use legwork::contract::{Command, Sensed};
use legwork::control::{Controller, Fallback};
use legwork::scenario_file;
use legwork::sim::Plant;
use legwork::start::start_pose;
use legwork_rbd::Dynamics;

use crate::files::{Table, answer};
use crate::programs::{recorded, say, touching};

/// Records a closed loop, or the same robot under `random` torques of up to so much [Nm], a row a step: torques, q and v before it, q and v after it.
pub(crate) fn record(scenario: &str, random: Option<f64>, out: &Path) -> Result<(), Box<dyn Error>> {
    let mut recording = recorded(scenario, &[], usize::MAX)?;
    if let Some(limit) = random {
        recording = recording.with_random_torques(limit);
    }
    let mut simulator = recording.simulator()?;
    let (torques, model) = (recording.torques[0].len(), recording.known());
    let mut table = Table::new(torques + 2 * (model.nq() + model.nv()));
    let mut estimates = recording.estimates.clone();
    for (torques, estimate) in recording.torques.iter().zip(&mut estimates) {
        simulator.read(estimate);
        let mut row = torques.clone();
        row.extend(simulator.q().iter().chain(simulator.v()));
        simulator.step(torques);
        row.extend(simulator.q().iter().chain(simulator.v()));
        table.push(row);
    }
    tell("steps", &estimates.iter().collect::<Vec<&Sensed>>());
    Ok(table.write(out)?)
}

/// Says what the ground did in what was measured.
fn tell(what: &str, estimates: &[&Sensed]) {
    let count = estimates.len();
    let switches = estimates.windows(2).filter(|pair| touching(pair[0]) != touching(pair[1])).count();
    let contacts: usize =
        estimates.iter().map(|estimate| touching(estimate).iter().filter(|&&flag| flag).count()).sum();
    let mean = contacts as f64 / count as f64;
    say(&format!("{count} {what}, {switches} contact switches, {mean:.1} contact points on the ground in the mean"));
}

/// Writes the start pose as a row: q.
pub(crate) fn start(scenario: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let loaded = scenario_file::load(scenario, &[])?;
    let model = loaded.model()?;
    let q = start_pose(&loaded.scenario, &model, &loaded.scenario.terrain(&model))?;
    let mut table = Table::new(q.len());
    table.push(q.iter().copied());
    Ok(table.write(out)?)
}

/// Replays the recorded torques, which gives the same motion to the last bit. Answers: v after the step.
pub(crate) fn time(scenario: &str, steps: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    let loaded = scenario_file::load(scenario, &[])?;
    let model = loaded.model()?;
    let table = Table::read(steps)?;
    let torques = model.actuated().count();
    let q = table.rows().next().ok_or("no steps")?[torques..torques + model.nq()].to_vec();
    let mut answers = Table::new(3 + model.nv());
    for warm_up in [true, false] {
        let mut simulator = loaded.scenario.simulator(&model, &q)?;
        for row in table.rows().take(if warm_up { 200 } else { usize::MAX }) {
            let begin = Instant::now();
            let sound = simulator.step(&row[..torques]);
            let seconds = begin.elapsed().as_secs_f64();
            if !warm_up {
                let sweeps = simulator.contact_report().sweeps;
                answers.push(answer(seconds, sound, sweeps, simulator.v().iter().copied()));
            }
        }
    }
    Ok(answers.write(out)?)
}

/// Times the control ticks of a closed loop, with the dynamics of the estimated state, which is what a robot's computer does.
pub(crate) fn ticks(scenario: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let recording = recorded(scenario, &[], usize::MAX)?;
    let mut controller = recording.controller()?;
    let mut dynamics = Dynamics::new(recording.known());
    let mut answers = Table::new(3);
    let mut measured = Vec::new();
    for estimate in &recording.estimates {
        let begin = Instant::now();
        dynamics.update(recording.known(), &estimate.q, &estimate.v);
        controller.tick(estimate, &dynamics);
        let seconds = begin.elapsed().as_secs_f64();
        let (solved, iterations) = {
            let program = &controller.latest().program;
            (program.fallback == Fallback::None, program.iterations)
        };
        // Only a foot in the air makes single support.
        if scenario != "exo-lift" || controller.reference().is_some_and(|reference| reference.swing.is_some()) {
            answers.push(answer(seconds, solved, iterations, []));
            measured.push(estimate);
        }
    }
    tell("ticks", &measured);
    Ok(answers.write(out)?)
}

/// Times control and physics, tick by tick. Answers: q and v after the tick, and the share of the control [µs].
pub(crate) fn closed_loop(scenario: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let recording = recorded(scenario, &[], usize::MAX)?;
    let (mut controller, mut simulator) = (recording.controller()?, recording.simulator()?);
    let mut answers = Table::new(3 + simulator.q().len() + simulator.v().len() + 1);
    let mut estimate = recording.estimates[0].clone();
    for _ in &recording.estimates {
        let begin = Instant::now();
        simulator.read(&mut estimate);
        let command: Command = controller.tick(&estimate, simulator.dynamics()).clone();
        let control = begin.elapsed().as_secs_f64();
        let sound = (0..recording.steps_per_tick).all(|_| simulator.step(&command.torque));
        let seconds = begin.elapsed().as_secs_f64();
        let state = simulator.q().iter().chain(simulator.v()).copied();
        answers.push(answer(seconds, sound, controller.latest().program.iterations, state.chain([control * 1e6])));
    }
    tell("ticks", &recording.estimates.iter().collect::<Vec<&Sensed>>());
    Ok(answers.write(out)?)
}
