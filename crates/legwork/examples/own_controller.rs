//! A controller of one's own: gravity compensation with a spring at each joint, beside the built-in ones in the same run.
//!
//! `cargo run --release --package legwork --example own_controller`

#![allow(clippy::print_stdout)]

use legwork::Robot;
use legwork::contract::{Command, Sensed};
use legwork::control::Controller;
use legwork::episode::{self, Parts};
use legwork::error::Error;
use legwork::rbd::Dynamics;
use legwork::scenario_file;

#[derive(Debug)]
struct Springs {
    model: Robot,
    /// Where the joints were in the first tick.
    posture: Option<Vec<f64>>,
    command: Command,
}

impl Controller for Springs {
    fn tick(&mut self, sensed: &Sensed, dynamics: &Dynamics) -> &Command {
        let posture = self.posture.get_or_insert_with(|| sensed.q.clone());
        for (torque, dof) in self.command.torque.iter_mut().zip(self.model.actuated()) {
            let joint = self.model.bodies[self.model.dofs[dof].body].q_index;
            *torque = dynamics.bias[dof] + 3000.0 * (posture[joint] - sensed.q[joint]) - 100.0 * sensed.v[dof];
        }
        &self.command
    }

    fn command(&self) -> &Command {
        &self.command
    }
}

fn main() -> Result<(), Error> {
    let loaded = scenario_file::load("feet-walk", &["duration_s=2".to_owned()])?;
    let model = loaded.model()?;
    let command = Command { torque: vec![0.0; model.actuated().count()] };
    let springs = Springs { model: model.clone(), posture: None, command };
    let parts = Parts { controller: Some(Box::new(springs)), ..Parts::default() };
    let run = episode::run_with(&loaded.scenario, &model, parts, |_time| false)?;
    println!("{:?}, with joint torques up to {:.0} Nm", run.outcome, largest(&run));
    Ok(())
}

fn largest(run: &episode::Run) -> f64 {
    let torques = run.log.range(legwork::log::Field::Torque);
    run.log.records().flat_map(|record| &record[torques.clone()]).fold(0.0, |most, torque| most.max(torque.abs()))
}
