//! What the controller is told by whoever runs it: flags of any threshold, loads that are late or missing, samples that are none.

mod common;

use std::ops::Range;

use common::run;
use legwork::channel::Field;
use legwork::contract::Sensed;
use legwork::control::{Controller, Fallback};
use legwork::episode::Outcome;
use legwork::rbd::Dynamics;
use legwork::scenario_file;
use legwork::sim::{Health, Plant};
use legwork::start::start_pose;
use legwork_qp::Status;

/// Flags by gaps of 0.2 to 5 mm and by forces of 1 to 30 N; loads that are late, and none.
const CONTRACTS: [&[&str]; 12] = [
    &["simulation.contact.flag_height_m=0.0002"],
    &["simulation.contact.flag_height_m=0.001"],
    &["simulation.contact.flag_height_m=0.005"],
    &["simulation.sensors.flag=force", "simulation.sensors.flag_force_n=1"],
    &["simulation.sensors.flag=force", "simulation.sensors.flag_force_n=30"],
    &["simulation.sensors.load_delay_s=0.01"],
    &["simulation.sensors.load_delay_s=0.02"],
    &["simulation.sensors.load_delay_s=0.01", "simulation.sensors.flag=force"],
    &["simulation.sensors.loads=none"],
    &["simulation.sensors.loads=none", "simulation.contact.flag_height_m=0.005"],
    &["simulation.sensors.loads=none", "simulation.sensors.flag=force", "simulation.sensors.flag_force_n=1"],
    &["simulation.sensors.loads=none", "simulation.sensors.flag=force", "simulation.sensors.flag_force_n=30"],
];

fn survives_every_contract(scenario: &str) {
    for sets in CONTRACTS {
        let run = run(scenario, sets);
        assert_eq!(run.outcome, Outcome::Completed, "{scenario} with {sets:?}: {:?}", run.reason);
    }
}

#[test]
fn the_walk_of_the_thesis_survives_every_contract() {
    survives_every_contract("walk-support");
}

#[test]
fn steps_with_the_first_gains_survive_every_contract() {
    // Its feet come to rest above the ground without a force.
    survives_every_contract("walk-baseline");
}

#[test]
fn a_push_survives_every_contract() {
    survives_every_contract("push-support");
}

#[test]
fn a_walk_on_feet_survives_every_contract() {
    survives_every_contract("feet-walk");
}

#[test]
fn a_push_while_standing_on_feet_survives_every_contract() {
    survives_every_contract("stand-push");
}

#[test]
fn a_sway_in_space_survives_every_contract() {
    survives_every_contract("exo-sway");
}

/// Runs a scenario, of which the controller is told what `spoil` leaves of the samples of the ticks `bad`, or of those the dynamics
/// alone. Returns the height of the centre of mass at the end as a share of that at the start.
fn spoilt(scenario: &str, bad: Range<usize>, dynamics_alone: bool, spoil: impl Fn(&mut Sensed)) -> f64 {
    let loaded = scenario_file::load(scenario, &[]).expect("built in");
    let (scenario, model) = (&loaded.scenario, loaded.model().expect("built in"));
    let q = start_pose(scenario, &model, &scenario.terrain(&model)).expect("a pose");
    let mut robot = scenario.simulator(&model, q.as_slice()).expect("no push");
    let (mut told, mut dynamics) = (Sensed::new(&model), Dynamics::new(&model));
    robot.read(&mut told);
    let mut controller = scenario.momentum_controller(&model, &[], &told).expect("the model fits");
    let height = robot.dynamics().com.z;
    let mut before = controller.command().clone();
    for tick in 0..(scenario.duration_s / scenario.controller.period_s).round() as usize {
        robot.read(&mut told);
        if bad.contains(&tick) {
            spoil(&mut told);
        }
        if told.q.len() == model.nq() && told.v.len() == model.nv() {
            dynamics.update(&model, &told.q, &told.v);
        }
        if dynamics_alone {
            robot.read(&mut told);
        }
        let command = controller.tick(&told, &dynamics);
        assert!(command.torque.iter().all(|torque| torque.is_finite()), "at tick {tick}");
        if bad.contains(&tick) {
            assert_eq!(*command, before, "at tick {tick}");
        }
        before.clone_from(command);
        let program = controller.program().expect("it solves one");
        let refused = program.status == Status::InvalidInput && program.fallback == Fallback::HoldTorque;
        assert_eq!(refused, bad.contains(&tick), "at tick {tick}");
        assert_eq!(robot.apply(&before, scenario.controller.period_s), Health::Sound);
        told = Sensed::new(&model);
    }
    robot.dynamics().com.z / height
}

#[test]
fn one_bad_sample_is_one_bad_sample() {
    type Spoil = fn(&mut Sensed);
    let spoils: [Spoil; 7] = [
        |told| told.q[2] = f64::NAN,
        |told| told.v.fill(f64::NAN),
        |told| told.v[4] = f64::INFINITY,
        |told| told.q[1] = 1e300,
        |told| told.time = f64::NAN,
        |told| told.contacts[0].load = f64::NAN,
        |told| told.q.clear(),
    ];
    for scenario in ["walk-support", "feet-walk", "exo-sway"] {
        for spoil in spoils {
            let height = spoilt(scenario, 0..1, false, spoil).min(spoilt(scenario, 1503..1504, false, spoil));
            assert!(height > 0.9, "{scenario} is at {height} of its height");
        }
        for dynamics_alone in [false, true] {
            let height = spoilt(scenario, 1200..1205, dynamics_alone, |told| told.v.fill(f64::NAN));
            assert!(height > 0.9, "{scenario} is at {height} of its height");
        }
    }
}

/// Sensors that are 8 ms late, and actuators that lag by 10 ms.
const LATE: [&str; 2] = ["simulation.sensors.delay_s=0.008", "simulation.actuators.lag_s=0.01"];

#[test]
fn a_delay_that_is_known_hardly_changes_what_the_robot_does() {
    let torques = |sets: &[&str]| {
        let log = run("exo-sway", &[&["duration_s=1"], sets].concat()).log;
        (0..log.len()).flat_map(|tick| log.get(tick, Field::Torque).to_vec()).collect::<Vec<f64>>()
    };
    let ideal = torques(&[]);
    let apart = |sets: &[&str]| ideal.iter().zip(torques(sets)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    for late in [
        &["simulation.sensors.delay_s=0.008"][..],
        &["simulation.actuators.delay_s=0.008"],
        &["simulation.sensors.delay_s=0.005", "simulation.actuators.delay_s=0.003"],
    ] {
        let (unknown, known) = (apart(late), apart(&[late, &["controller.known_delay_s=0.008"]].concat()));
        assert!(known < 0.01 * unknown && unknown > 0.1, "{late:?}: {known} Nm, {unknown} Nm where it is not known");
    }
}

#[test]
fn with_a_known_delay_and_lag_noise_and_another_robot_it_walks_at_every_speed() {
    for (seed, speed) in (1..).zip([-0.3, -0.1, 0.1, 0.35, 0.6, 0.85, 1.1]) {
        let (speed, seed) = (format!("reference.walker.speed_mps={speed}"), format!("seed={seed}"));
        let noise = ["simulation.sensors.velocity_noise=0.03", "simulation.sensors.position_noise=0.001"];
        let sets =
            [&LATE[..], &noise, &["simulation.model_error=0.03", "controller.known_delay_s=0.018", &speed, &seed]];
        let run = run("feet-walk", &sets.concat());
        assert_eq!(run.outcome, Outcome::Completed, "{speed}: {:?}", run.reason);
    }
}
