//! Time of one physics step of 1 ms with rigid contacts, midpoint rule, on one core.
//!
//! The planar humanoid walks by the torques of a recorded walk; `exo18` stands on its box feet by gravity compensation
//! and joint springs, still and while it sways; by random torques it falls, slides and rolls on its edges. `cargo run --release -p legwork --example time_step -- [rounds] [case]`

use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use legwork::episode;
use legwork::log::Field;
use legwork::scenario::Scenario;
use legwork::sim::Simulator;
use legwork::{library, scenario_file};
use legwork_rbd::{Dynamics, Model};

type Failure = Box<dyn std::error::Error>;

/// Writes the torques of a step [Nm].
type Torque = dyn Fn(usize, &Simulator, &mut [f64]);

/// What is simulated, and the torques that are wanted in a state.
struct Case {
    start: Simulator,
    steps: usize,
    torque: Box<Torque>,
}

type MakeCase = fn() -> Result<Case, Failure>;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let rounds: usize = arguments.next().map_or(Ok(7), |text| text.parse())?;
    let only = arguments.next();
    let mut out = io::stdout();
    writeln!(out, "case           median [us]  p99 [us]  solves mean  max  residual [N]")?;
    let cases: [(&str, MakeCase); 5] = [
        ("planar walk", || walking("walk")),
        ("planar stand", || walking("stand")),
        ("exo18 stand", || standing(0.0)),
        ("exo18 sway", || standing(0.15)),
        ("exo18 tossed", tossed),
    ];
    for (name, case) in cases {
        if only.as_ref().is_none_or(|only| only == name) {
            measure(name, &case()?, rounds, &mut out)?;
        }
    }
    Ok(())
}

/// Runs the case `rounds` times; the time of each step is its least, which a shared machine disturbs least.
fn measure(name: &str, case: &Case, rounds: usize, out: &mut io::Stdout) -> Result<(), Failure> {
    let mut best = vec![f64::INFINITY; case.steps];
    let (mut sweeps, mut worst) = (0, 0);
    let mut residual = 0.0;
    for _ in 0..rounds {
        let mut simulator = case.start.clone();
        let mut torque = vec![0.0; simulator.applied_torques().len()];
        (sweeps, worst) = (0, 0);
        for (step, best) in best.iter_mut().enumerate() {
            (case.torque)(step, &simulator, &mut torque);
            let begin = Instant::now();
            let sound = simulator.step(&torque);
            *best = best.min(begin.elapsed().as_secs_f64());
            assert!(sound, "{name} left the bounds");
            sweeps += simulator.contact_report().sweeps;
            worst = worst.max(simulator.contact_report().sweeps);
        }
        residual = simulator.audit().contact_residual_n;
        assert_eq!(simulator.audit().violations(), Vec::<String>::new(), "{name}");
    }
    best.sort_by(f64::total_cmp);
    let quantile = |share: f64| 1e6 * best[(share * (best.len() - 1) as f64).round() as usize];
    let mean = f64::from(sweeps) / case.steps as f64;
    let (median, p99) = (quantile(0.5), quantile(0.99));
    writeln!(out, "{name:<15}{median:>11.2}{p99:>10.2}{mean:>13.2}{worst:>5}{residual:>14.1e}")?;
    Ok(())
}

/// A built-in scenario, replayed with the torques of its run.
fn walking(name: &str) -> Result<Case, Failure> {
    let scenario = scenario_file::load(name, &[])?.scenario;
    let model = library::load_model(&scenario.model, None)?;
    let run = episode::run(&scenario, &model, &[], |_| false)?;
    let range = run.log.range(Field::Torque);
    let torques: Vec<Vec<f64>> = run.log.records().map(|record| record[range.clone()].to_vec()).collect();
    let q: Vec<f64> = run.log.get(0, Field::Q).to_vec();
    Ok(Case {
        start: scenario.simulator(&model, &q)?,
        steps: torques.len(),
        torque: Box::new(move |step, _, torque| torque.copy_from_slice(&torques[step])),
    })
}

/// `exo18` with bent knees; `sway` [rad] is the amplitude of what its hips, knees and ankles are asked to do.
fn standing(sway: f64) -> Result<Case, Failure> {
    let model = Model::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/exo18.urdf"))?;
    let mut q = model.neutral();
    for leg in 0..2 {
        for (joint, angle) in [(1, 0.2), (3, 0.4), (4, 0.2)] {
            q[7 + 6 * leg + joint] = angle;
        }
    }
    let mut dynamics = Dynamics::new(&model);
    let v = vec![0.0; model.nv()];
    dynamics.update(&model, q.as_slice(), &v);
    q[6] = -dynamics.contact_positions.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    dynamics.update(&model, q.as_slice(), &v);
    // The weight on heels and toes so that its resultant passes through the centre of mass.
    let along: Vec<f64> = dynamics.contact_positions.iter().map(|point| point.x).collect();
    let (heel, toe) = (along[0], along[2]);
    let toe_share = (dynamics.com.x - heel) / (toe - heel);
    let weight = model.total_mass() * model.gravity;
    let hold: Vec<f64> = (6..model.nv())
        .map(|j| {
            let carried: f64 = (0..model.nc())
                .map(|k| {
                    let share = if along[k] == toe { toe_share } else { 1.0 - toe_share };
                    dynamics.contact_jacobian[(3 * k + 2, j)] * share * weight / 4.0
                })
                .sum();
            dynamics.gravity[j] - carried
        })
        .collect();
    let start = Scenario::default().simulator(&model, q.as_slice())?;
    Ok(Case {
        start,
        steps: 3000,
        torque: Box::new(move |step, simulator, torque| {
            let angle = sway * (1.0 - libm::cos(std::f64::consts::TAU * step as f64 * 1e-3));
            for (j, torque) in torque.iter_mut().enumerate() {
                let asked = match j % 6 {
                    1 | 4 => 0.5 * angle,
                    3 => angle,
                    _ => 0.0,
                };
                let error = q[7 + j] + asked - simulator.q()[7 + j];
                *torque = hold[j] + 1500.0 * error - 60.0 * simulator.v()[6 + j];
            }
        }),
    })
}

/// `exo18` with random torques of up to 20 Nm at each joint, held for 50 ms.
fn tossed() -> Result<Case, Failure> {
    let Case { start, steps, .. } = standing(0.0)?;
    let random = |step: usize, j: usize| {
        // Weyl's sequence: even, and the same everywhere.
        let turn = (step / 50 * 12 + j) as f64 * 0.618_033_988_749_895;
        2.0 * (turn - turn.floor()) - 1.0
    };
    let torque = move |step: usize, _: &Simulator, torque: &mut [f64]| {
        torque.iter_mut().enumerate().for_each(|(j, torque)| *torque = 20.0 * random(step, j));
    };
    Ok(Case { start, steps, torque: Box::new(torque) })
}
