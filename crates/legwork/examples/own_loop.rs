//! A control loop of one's own: the controller and the simulator of a scenario, called by hand.
//!
//! `cargo run --release --package legwork --example own_loop`

#![allow(clippy::print_stdout)]

use legwork::contract::Sensed;
use legwork::control::Controller;
use legwork::error::Error;
use legwork::scenario_file;
use legwork::sim::{Health, Plant};
use legwork::start::start_pose;

fn main() -> Result<(), Error> {
    let loaded = scenario_file::load("walk", &[])?;
    let (scenario, model) = (&loaded.scenario, loaded.model()?);

    // The robot stands in its start pose; what it senses there is where the controller begins.
    let q = start_pose(scenario, &model, &scenario.terrain(&model))?;
    let mut robot = scenario.simulator(&model, q.as_slice())?;
    let mut sensed = Sensed::new(&model);
    robot.read(&mut sensed);
    let mut controller = scenario.momentum_controller(&model, &[], &sensed)?;

    while sensed.time < 2.0 {
        let command = controller.tick(&sensed, robot.dynamics());
        if robot.apply(command, 0.001) == Health::OutOfBounds {
            break;
        }
        robot.read(&mut sensed);
    }
    let com = robot.dynamics().com;
    println!("after {:.1} s the centre of mass is at x = {:.3} m, {:.3} m high", sensed.time, com.x, com.z);
    Ok(())
}
