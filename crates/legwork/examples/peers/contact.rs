//! Physics steps with contacts, and closed loops.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use legwork::control::Fallback;
use legwork::scenario_file;
use legwork::sim::Simulator;
use legwork_rbd::Dynamics;

use crate::files::{Table, answer};
use crate::programs::{Loop, say};

/// Records a closed loop, a row a step: torques, q and v before it, q and v after it.
pub(crate) fn record(scenario: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let scenario_data = scenario_file::load(scenario, &[])?.scenario;
    let mut run = Loop::new(scenario, &[])?;
    let torques = run.model.actuated().count();
    let mut table = Table::new(torques + 2 * (run.model.nq() + run.model.nv()));
    let (mut contacts, mut switches) = (0, 0);
    let mut before = run.estimate.touching.clone();
    for _ in 0..(scenario_data.duration_s / scenario_data.controller.period_s).round() as usize {
        run.tick();
        switches += usize::from(run.estimate.touching != before);
        contacts += run.estimate.touching.iter().filter(|&&touching| touching).count();
        before.copy_from_slice(&run.estimate.touching);
        let mut row = run.controller.latest().solution.tau.as_slice().to_vec();
        row.extend(run.estimate.q.iter().chain(&run.estimate.v));
        if !run.step() {
            return Err(format!("{scenario} left the bounds of the possible").into());
        }
        row.extend(run.simulator.q().iter().chain(run.simulator.v()));
        table.push(row);
    }
    let steps = table.rows().count();
    let mean = contacts as f64 / steps as f64;
    say(&format!("{steps} steps, {switches} contact switches, {mean:.1} contact points on the ground in the mean"));
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
        let mut simulator = Simulator::new(&loaded.scenario, &model, &q)?;
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
    let data = scenario_file::load(scenario, &[])?.scenario;
    let mut run = Loop::new(scenario, &[])?;
    let mut dynamics = Dynamics::new(&run.model);
    let mut answers = Table::new(3);
    for _ in 0..(data.duration_s / data.controller.period_s).round() as usize {
        run.sense();
        let begin = Instant::now();
        dynamics.update(&run.model, &run.estimate.q, &run.estimate.v);
        let tick = run.controller.tick(&run.estimate, &dynamics);
        let seconds = begin.elapsed().as_secs_f64();
        let (solved, iterations) = (tick.fallback == Fallback::None, tick.iterations);
        // Only a foot in the air makes single support.
        if scenario != "exo-lift" || run.controller.swing().is_some() {
            answers.push(answer(seconds, solved, iterations, []));
        }
        if !run.step() {
            return Err(format!("{scenario} left the bounds of the possible").into());
        }
    }
    Ok(answers.write(out)?)
}

/// Times control and physics, tick by tick. Answers: q and v after the tick, and the share of the control [µs].
pub(crate) fn closed_loop(scenario: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let data = scenario_file::load(scenario, &[])?.scenario;
    let mut run = Loop::new(scenario, &[])?;
    let mut answers = Table::new(3 + run.model.nq() + run.model.nv() + 1);
    for _ in 0..(data.duration_s / data.controller.period_s).round() as usize {
        let begin = Instant::now();
        run.tick();
        let control = begin.elapsed().as_secs_f64();
        let sound = run.step();
        let seconds = begin.elapsed().as_secs_f64();
        let state = run.simulator.q().iter().chain(run.simulator.v()).copied();
        let iterations = run.controller.latest().iterations;
        answers.push(answer(seconds, sound, iterations, state.chain([control * 1e6])));
    }
    Ok(answers.write(out)?)
}
