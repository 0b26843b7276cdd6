//! Records the quadratic programs of a run, for the tests of `legwork-qp`:
//! `cargo run --release -p legwork --example record_programs -- walk direct 100..130,400..430 out.bin`.
//!
//! After the scenario's name may stand settings, as in `walk,duration_s=2`. The ranges choose the ticks; `..` is all of them.
//! The format is described in `crates/legwork-qp/tests/data/README.md`.

use std::env;
use std::fs;
use std::io;

use legwork::control::Controller;
use legwork::recording::Recording;
use legwork::{episode, library, scenario_file};
use legwork_qp::Problem;
use legwork_rbd::Dynamics;

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scenario, form, ranges, path] = &arguments[..] else {
        return Err(io::Error::other("usage: record_programs SCENARIO[,SETTING=VALUE...] slack|direct TICKS FILE"));
    };
    let mut words = scenario.split(',').map(str::to_owned);
    let name = words.next().unwrap_or_default();
    let programs = programs(&name, &words.collect::<Vec<_>>(), form, &|tick| is_chosen(ranges, tick));
    fs::write(path, encode(&programs))
}

fn is_chosen(ranges: &str, tick: usize) -> bool {
    ranges.split(',').any(|range| {
        let (first, end) = range.split_once("..").unwrap_or((range, ""));
        let at = |text: &str, missing: usize| text.parse().unwrap_or(missing);
        (at(first, 0)..at(end, usize::MAX)).contains(&tick)
    })
}

/// The run once more, with a controller that is told what was logged.
fn programs(name: &str, sets: &[String], form: &str, chosen: &dyn Fn(usize) -> bool) -> Vec<Problem> {
    let sets: Vec<String> = sets.iter().cloned().chain([format!("controller.form={form}")]).collect();
    let scenario = scenario_file::load(name, &sets).expect("a valid scenario").scenario;
    let model = library::load_model(&scenario.model, None).expect("a built-in model");
    let run = episode::run(&scenario, &model, &[], |_| false).expect("the scenario can start");
    let recording = Recording::of(&run, &[]);
    let mut controller = recording.controller().expect("it made the run");
    let mut dynamics = Dynamics::new(&model);
    let mut found = Vec::new();
    for (tick, estimate) in recording.estimates.iter().enumerate() {
        dynamics.update(&model, &estimate.q, &estimate.v);
        controller.tick(estimate, &dynamics);
        if chosen(tick) {
            found.push(controller.problem().clone());
        }
    }
    found
}

/// Sizes and count; then for each program a bit a number, which says whether it has changed, and the changed ones.
fn encode(programs: &[Problem]) -> Vec<u8> {
    let (n, m) = programs.first().map_or((0, 0), |problem| (problem.n(), problem.m()));
    let mut bytes: Vec<u8> = [n, m, programs.len()].iter().flat_map(|&size| (size as u32).to_le_bytes()).collect();
    let mut before: Vec<f64> = Vec::new();
    for problem in programs {
        let now = numbers(problem);
        before.resize(now.len(), 0.0);
        let changed: Vec<bool> = now.iter().zip(&before).map(|(a, b)| a.to_bits() != b.to_bits()).collect();
        bytes.extend(changed.chunks(8).map(|eight| eight.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit))));
        bytes.extend(now.iter().zip(&changed).filter(|pair| *pair.1).flat_map(|pair| pair.0.to_le_bytes()));
        before = now;
    }
    bytes
}

/// All numbers of a program, in one order.
fn numbers(problem: &Problem) -> Vec<f64> {
    let mut all = problem.hessian().to_vec();
    all.extend(problem.gradient());
    (0..problem.m()).for_each(|i| all.extend(problem.row(i)));
    all.extend(problem.row_lower().iter().chain(problem.row_upper()));
    all.extend(problem.lower().iter().chain(problem.upper()));
    all
}
