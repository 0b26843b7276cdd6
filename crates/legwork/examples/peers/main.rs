//! Our side of `cargo xtask bench-peers`: writes models, states and programs for all contenders, and times legwork on them.
//!
//! `cargo run --release -p legwork --example peers -- TASK ...`; every task reads and writes the files that [`files`] describes.

// M, A, J are the field's names.
#![allow(non_snake_case)]

mod contact;
mod dynamics;
mod files;
mod models;
mod programs;
mod solvers;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "usage: peers TASK FILES
  model MODEL STEM              writes STEM.urdf, STEM.xml (MJCF) and STEM.txt for other people's programs
  states MODEL COUNT OUT        random states
  dynamics MODEL STATES OUT     times Dynamics::update
  programs WHICH OUT            records programs: slack, direct, humanoid or standing
  qp PROGRAMS OUT               times legwork_qp
  clarabel PROGRAMS OUT         times Clarabel
  start SCENARIO OUT            the start pose
  steps SCENARIO [LIMIT] OUT    records states and torques of a closed loop, or those under random torques of up to LIMIT Nm
  contact SCENARIO STEPS OUT    times Simulator::step on them
  tick SCENARIO OUT             times the control ticks of a closed loop
  loop SCENARIO OUT             times control and physics together";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("peers {}: {error}", words.join(" "));
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[&str]) -> Result<(), Box<dyn Error>> {
    match *words {
        ["model", model, stem] => models::write(model, Path::new(stem)),
        ["states", model, count, out] => dynamics::states(model, count.parse()?, Path::new(out)),
        ["dynamics", model, states, out] => dynamics::time(model, Path::new(states), Path::new(out)),
        ["programs", form, out] => programs::record(form, Path::new(out)),
        ["qp", programs, out] => solvers::legwork(Path::new(programs), Path::new(out)),
        ["clarabel", programs, out] => solvers::clarabel(Path::new(programs), Path::new(out)),
        ["start", scenario, out] => contact::start(scenario, Path::new(out)),
        ["steps", scenario, out] => contact::record(scenario, None, Path::new(out)),
        ["steps", scenario, limit, out] => contact::record(scenario, Some(limit.parse()?), Path::new(out)),
        ["contact", scenario, steps, out] => contact::time(scenario, Path::new(steps), Path::new(out)),
        ["tick", scenario, out] => contact::ticks(scenario, Path::new(out)),
        ["loop", scenario, out] => contact::closed_loop(scenario, Path::new(out)),
        _ => Err(USAGE.into()),
    }
}
