//! A physics of one's own: the robot floats without gravity and ground, and the joint-space hold drives it.
//!
//! `cargo run --release --package legwork --example own_plant`

#![allow(clippy::print_stdout)]

use legwork::Robot;
use legwork::contract::{Command, Sensed};
use legwork::episode::{self, Parts};
use legwork::error::Error;
use legwork::rbd::Dynamics;
use legwork::scenario_file;
use legwork::sim::{Health, Plant};

/// A robot that floats: no gravity, no ground. Semi-implicit Euler with the mass matrix.
#[derive(Debug)]
struct Weightless {
    model: Robot,
    state: Sensed,
    dynamics: Dynamics,
}

impl Plant for Weightless {
    fn read(&self, sensed: &mut Sensed) {
        sensed.clone_from(&self.state);
    }

    fn apply(&mut self, command: &Command, period: f64) -> Health {
        self.dynamics.update(&self.model, &self.state.q, &self.state.v);
        let mut force = &self.dynamics.gravity - &self.dynamics.bias - &self.dynamics.damping;
        self.model.actuated().zip(&command.torque).for_each(|(dof, torque)| force[dof] += torque);
        let Some(factor) = self.dynamics.mass_matrix.clone().cholesky() else { return Health::OutOfBounds };
        let acceleration = factor.solve(&force);
        self.state.v.iter_mut().zip(acceleration.iter()).for_each(|(v, a)| *v += period * a);
        let q = self.state.q.clone();
        self.model.integrate(&q, &self.state.v, period, &mut self.state.q);
        self.state.time += period;
        Health::Sound
    }
}

fn main() -> Result<(), Error> {
    let loaded = scenario_file::load("stand", &["controller.kind=hold".to_owned(), "duration_s=0.5".to_owned()])?;
    let model = loaded.model()?;
    let mut state = Sensed::new(&model);
    (state.q[1], state.q[4], state.q[6]) = (1.2, -0.5, -0.5);
    let plant = Weightless { dynamics: Dynamics::new(&model), model: model.clone(), state };
    let parts = Parts { plant: Some(Box::new(plant)), ..Parts::default() };
    let run = episode::run_with(&loaded.scenario, &model, parts, |_time| false)?;
    println!("{:?}; {} records without a ground", run.outcome, run.log.len());
    Ok(())
}
