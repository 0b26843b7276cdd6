//! Every limit that a model gives a joint acts, or the run says that it did not.

use legwork::channel::Field;
use legwork::episode::{self, Outcome, Run};
use legwork::momentum::LimitKind;
use legwork::rbd::Dof;
use legwork::robot::Robot;
use legwork::start::start_pose;
use legwork::{library, scenario_file};

const KNEE: &str = "right_knee";

/// A run whose robot has another line in the table of its right knee.
fn run(scenario: &str, line: &str, sets: &[&str]) -> Run {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = scenario_file::load(scenario, &sets).expect("built in");
    let text = library::load_model(&loaded.scenario.model, None).expect("built in").to_toml();
    let knee = format!("name = \"{KNEE}\"\n");
    assert_eq!(text.matches(&knee).count(), 1);
    let robot = Robot::from_toml(&text.replace(&knee, &format!("{knee}{line}\n")), "knee.toml").expect("a sound model");
    episode::run(&loaded.scenario, &robot, &[], |_| false).expect("it can start")
}

/// The highest speed of the right knee [rad/s].
fn fastest(run: &Run) -> f64 {
    let knee = run.model.dofs.iter().position(|dof| dof.name == KNEE).expect("a knee");
    (0..run.log.len()).map(|i| run.log.get(i, Field::V)[knee].abs()).fold(0.0, f64::max)
}

#[test]
fn the_controller_keeps_a_joint_below_its_largest_speed() {
    let free = run("push-support", "", &[]);
    let most = fastest(&free);
    for share in [0.95, 0.85] {
        let limit = share * most;
        let slow = run("push-support", &format!("max_velocity_radps = {limit}"), &[]);
        assert_eq!(slow.outcome, Outcome::Completed, "{limit}: {:?}", slow.reason);
        assert!(fastest(&slow) < 1.01 * limit, "{} of {limit}, {most} without", fastest(&slow));
        assert_eq!(slow.limits_passed, Vec::<String>::new());
    }
}

#[test]
fn a_limit_that_nothing_holds_is_told() {
    // The joint-space hold knows nothing of ranges and of speeds.
    let weak = [
        "controller.kind=hold",
        "controller.hold.stiffness_nmprad=5",
        "controller.hold.damping_nmsprad=1",
        "fall.min_com_height_fraction=0.3",
        "fall.max_torso_angle_deg=180",
    ];
    let run = run("push", "max_velocity_radps = 1", &weak);
    let [range, speed] = run.limits_passed.as_slice() else { panic!("{:?}", run.limits_passed) };
    let knee = run.model.dofs.iter().find(|dof| dof.name == KNEE).expect("a knee");
    let last = run.log.len() - 1;
    let q = run.log.get(last, Field::Q)[run.model.bodies[knee.body].q_index];
    let past = (q - knee.upper).max(knee.lower - q).to_degrees();
    assert!(past > 90.0, "{past}");
    let says = format!("right_knee went {:.0}", past / 10.0);
    assert!(
        range.starts_with(&says[..says.len() - 1]) && range.ends_with("gives it no stop, so nothing held it"),
        "{range}"
    );
    let most = format!("right_knee moved at {:.0}", fastest(&run).floor());
    assert!(speed.starts_with(&most) && speed.ends_with("its model allows 1 rad/s"), "{speed}");
}

#[test]
fn a_limit_beside_the_start_pose_does_not_hide_it() {
    let loaded = scenario_file::load("push-support", &[]).expect("built in");
    let mut model = library::load_model(&loaded.scenario.model, None).expect("built in");
    let hip = model.dofs.iter().position(|dof| dof.name == "left_hip").expect("a left hip");
    let place = model.bodies[model.dofs[hip].body].q_index;
    let terrain = loaded.scenario.terrain(&model);
    let free = start_pose(&loaded.scenario, &model, &terrain).expect("a pose");
    for beyond in 1..20 {
        model.dofs[hip].lower = free[place] - 0.5_f64.to_radians() * f64::from(beyond);
        let pose = start_pose(&loaded.scenario, &model, &terrain).expect("the same pose is within the limits");
        assert!((pose - &free).amax() < 1e-9, "{beyond}");
    }
}

/// A limit that makes the robot fall where it is the only one that holds its joint.
struct Case {
    scenario: &'static str,
    sets: &'static [&'static str],
    /// Gives the joint its limit.
    limit: fn(&mut Dof),
    joint: &'static str,
    label: &'static str,
    says: &'static str,
    modes: &'static [&'static str],
    /// Whether the limit holds the joint at its position, its velocity and the program's acceleration, coming to it at a rate [1/s].
    holds: fn([f64; 3], f64) -> bool,
}

const CASES: [Case; 4] = [
    Case {
        scenario: "walk",
        sets: &["duration_s=4"],
        limit: |dof| dof.velocity_limit = 1.0,
        joint: "right_knee",
        label: "speed-limit",
        says: "the right knee was held to its speed limit of 1 rad/s for",
        modes: &["braking-distance", "approach"],
        holds: |[_, v, a], rate| [1.0, -1.0].iter().any(|speed| (rate * (speed - v) - a).abs() < 1e-6),
    },
    Case {
        scenario: "walk",
        sets: &["duration_s=4", "controller.limits.joint_acceleration_radps2=60"],
        limit: |_| {},
        joint: "right_hip",
        label: "acceleration-limit",
        says: "the right hip was at its limit of 60 rad/s2 for",
        modes: &["braking-distance", "approach"],
        holds: |[_, _, a], _| a.abs() > 60.0 - 1e-6,
    },
    Case {
        scenario: "push",
        sets: &[],
        limit: |dof| dof.lower = -128_f64.to_radians(),
        joint: "left_hip",
        label: "joint-limit",
        says: "the left hip was held back by its end at -128 deg for",
        modes: &["braking-distance"],
        // The distance in which it stops is all that is left (4.32).
        holds: |[q, v, _], _| v < 0.0 && q - v * v / 2000.0 <= -128_f64.to_radians(),
    },
    Case {
        scenario: "feet-walk",
        sets: &["reference.walker.speed_mps=2.2", "reference.walker.longest_m=1.4", "duration_s=8"],
        limit: |_| {},
        joint: "left_ankle",
        label: "joint-limit",
        says: "the left ankle was held back by its end at 40 deg for",
        modes: &["approach"],
        holds: |[q, v, a], rate| a < 0.0 && (rate * rate * (40_f64.to_radians() - q) - 2.0 * rate * v - a).abs() < 1e-6,
    },
];

/// Those of a model that is not built in are quoted by docs/diagnosis.md.
#[test]
fn a_fall_is_blamed_on_the_one_limit_that_held_a_joint() {
    let document = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/diagnosis.md"));
    let document = document.expect("docs/diagnosis.md").replace("\n> ", " ");
    for Case { scenario, sets, limit, joint, label, says, modes, holds } in CASES {
        for mode in modes {
            let sets = sets.iter().map(|&set| set.to_owned()).chain([format!("controller.limits.joint_limits={mode}")]);
            let loaded = scenario_file::load(scenario, &sets.collect::<Vec<_>>()).expect("built in");
            let mut model = library::load_model(&loaded.scenario.model, None).expect("built in");
            let index = model.dofs.iter().position(|dof| dof.name == joint).expect("a joint");
            limit(&mut model.dofs[index]);
            let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can start");
            let found = run.diagnosis.as_ref().expect("it falls");
            let context = format!("{scenario} {mode}: {}", found.sentence);
            assert_eq!((found.cause.label(), found.cause.part()), (label, Some(joint)), "{context}");
            let (_, told) = found.sentence.split_once(says).unwrap_or_else(|| panic!("{context}"));
            let told: f64 = told.split_once('%').expect("a share").0.trim().parse().expect("a number");
            let shares = shares(&run, index, holds);
            assert!(shares.iter().any(|share| (100.0 * share - told).abs() <= 0.5), "{shares:?}: {context}");
            if *mode == "braking-distance" && label != "acceleration-limit" {
                assert!(document.contains(&found.sentence), "{context}");
            }
        }
    }
}

/// The shares of the steps and double supports in which a joint's limit holds it.
fn shares(run: &Run, dof: usize, holds: fn([f64; 3], f64) -> bool) -> Vec<f64> {
    let limits = &run.limits;
    let limit = limits.iter().position(|limit| limit.kind == LimitKind::Acceleration { dof }).expect("a limit");
    let place = run.model.bodies[run.model.dofs[dof].body].q_index;
    let held = |&i: &usize| {
        let of = |field, index| run.log.get(i, field)[index];
        let state = [of(Field::Q, place), of(Field::V, dof), of(Field::Acceleration, dof)];
        // Where it asks for too much it becomes a cost, which the tick tells.
        (of(Field::ActiveLimit, limit) != 0.0 || of(Field::Program, 1) > 0.0)
            && holds(state, run.scenario.controller.limits.approach_rate_1ps)
    };
    let ticks: Vec<usize> = (0..run.log.len()).collect();
    let stretches = ticks.chunk_by(|&a, &b| run.log.get(a, Field::Swing) == run.log.get(b, Field::Swing));
    stretches.map(|ticks| ticks.iter().filter(|i| held(i)).count() as f64 / ticks.len() as f64).collect()
}
