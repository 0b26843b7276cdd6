//! Robots in space: ground that inclines across, and results that do not depend on where a robot points.

mod common;

use legwork::Robot;
use legwork::episode::{self, Outcome, Parts, Run};
use legwork::log::Field;
use legwork::scenario::Scenario;
use legwork::start::start_pose;
use legwork::{library, scenario_file};
use legwork_rbd::{Joint, Model, Revolute};
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

const BOX_IN_SPACE: &str = include_str!("data/box_in_space.toml");

/// How fast the box is after 1 s on a slope [m/s], and how far its contact points slipped [m].
fn on_slope(friction: f64, slope_deg: f64, cross_slope_deg: f64) -> (Vector3<f64>, f64) {
    let model = Model::from_toml(BOX_IN_SPACE, "box.toml").expect("a valid model");
    let mut scenario = Scenario::default();
    (scenario.ground.friction, scenario.ground.slope_deg) = (friction, slope_deg);
    scenario.ground.cross_slope_deg = cross_slope_deg;
    let ground = scenario.terrain(&model);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(ground.base().rotation()));
    let place = 0.05 * ground.base().normal;
    let q = [turn.w, turn.i, turn.j, turn.k, place.x, place.y, place.z];
    let mut simulator = scenario.simulator(&model, &q).expect("a valid state");
    for _ in 0..1000 {
        assert!(simulator.step(&[]), "numbers out of bounds");
    }
    assert_eq!(simulator.audit().violations(), Vec::<String>::new(), "on {slope_deg} and {cross_slope_deg} deg");
    (simulator.dynamics().com_velocity, simulator.audit().slip_m)
}

#[test]
fn a_box_sticks_on_slopes_up_to_that_of_its_friction_and_slides_on_steeper_ones() {
    for [slope, across] in [[0.0, 20.0], [0.0, -20.0], [12.0, 15.0], [-25.0, 10.0], [20.0, 0.0]] {
        let tan = |degrees: f64| degrees.to_radians().tan();
        let steepness = tan(slope).hypot(tan(across));
        let (velocity, slip) = on_slope(1.01 * steepness, slope, across);
        assert!(velocity.norm() < 1e-9 && slip < 1e-9, "{slope}, {across}: {velocity}");
        let friction = 0.8 * steepness;
        let (velocity, _) = on_slope(friction, slope, across);
        // Down the line of greatest slope, as Coulomb says.
        let (sin, cos) = steepness.atan().sin_cos();
        let level = -Vector3::new(tan(slope), tan(across), 0.0) / steepness;
        let expected = 9.81 * (sin - friction * cos) * (cos * level - sin * Vector3::z());
        // Four points share the load in more than one way; the solver turns the box by what its tolerance leaves open.
        assert!(
            (velocity - expected).norm() < 0.01 * expected.norm(),
            "{slope}, {across}: {velocity}, expected {expected}"
        );
    }
}

/// The sum of the ground's forces at the end [N].
fn ground_force(run: &Run) -> Vector3<f64> {
    run.log.get(run.log.len() - 1, Field::GrfSimulated).chunks_exact(3).map(Vector3::from_column_slice).sum()
}

#[test]
fn an_exoskeleton_stands_and_lifts_a_foot_on_ground_that_inclines_across() {
    let still = ["reference.stance.sway_m=[0,0,0]", "reference.stance.squat_m=0", "pushes=[]", "duration_s=1"];
    for across in ["ground.cross_slope_deg=5", "ground.cross_slope_deg=-5"] {
        let run = common::run("exo-sway", &[&still[..], &[across]].concat());
        assert_eq!(run.outcome, Outcome::Completed);
        assert_eq!(run.violations(), Vec::<String>::new());
        let weight = run.model.total_mass() * run.model.gravity;
        assert!((ground_force(&run) - weight * Vector3::z()).norm() < 1e-2, "{}", ground_force(&run));
        for point in run.log.get(run.log.len() - 1, Field::Feet).chunks_exact(3) {
            let ground = run.scenario.terrain(&run.model).height_at(point[0], point[1]);
            assert!((point[2] - ground).abs() < 1e-4, "{point:?} over {ground} m");
        }
    }
    let run = common::run("exo-lift", &["ground.cross_slope_deg=3"]);
    assert_eq!((run.outcome.clone(), run.violations()), (Outcome::Completed, Vec::new()));
    assert!(run.metrics.com_error_m.expect("a reference").peak < 1e-3);
}

#[test]
fn an_exoskeleton_slides_down_ice_that_inclines_across_and_falls_with_a_reason() {
    let ice =
        ["ground.cross_slope_deg=10", "ground.friction=0.05", "controller.assumed_friction=0.8", "ground.known=false"];
    let run = common::run("exo-sway", &ice);
    let reason = run.reason.clone().unwrap_or_default();
    assert!(matches!(run.outcome, Outcome::Fell(_)) && reason.contains(" because "), "{reason}");
    assert!(run.violations().iter().all(|violation| !violation.starts_with("energy")), "{:?}", run.violations());
}

#[test]
fn a_planar_robot_has_no_slope_across() {
    let loaded = scenario_file::load("walk", &["ground.cross_slope_deg=2".to_owned()]).expect("a valid scenario");
    let model = library::load_model("planar_humanoid", None).expect("a built-in model");
    let error = episode::run(&loaded.scenario, &model, &[], |_| false).expect_err("a robot in the plane");
    assert_eq!(error.to_string(), "ground.cross_slope_deg: found 2; valid is 0 for a planar robot");
}

/// A run of exo-sway with `sets` in which robot and pushes are turned about z by `degrees`.
fn turned(sets: &[&str], degrees: f64) -> Run {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let mut scenario = scenario_file::load("exo-sway", &sets).expect("a built-in scenario").scenario;
    let model = library::load_model(&scenario.model, None).expect("a built-in model");
    let mut q = start_pose(&scenario, &model, &scenario.terrain(&model)).expect("a pose");
    let about_z = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), degrees.to_radians());
    let turn = about_z * UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
    let place = about_z * Vector3::new(q[4], q[5], q[6]);
    q.as_mut_slice()[..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k, place.x, place.y, place.z]);
    for push in &mut scenario.pushes {
        push.heading_deg += degrees;
    }
    let plant = scenario.simulator(&model, q.as_slice()).expect("a valid state");
    let parts = Parts { plant: Some(Box::new(plant)), ..Parts::default() };
    episode::run_with(&scenario, &model, parts, |_| false).expect("the scenario can start")
}

/// Places of the columns of [`Field::Balance`]: margin and steps; those along x and along y of the others.
const MARGIN: usize = 6;
const PLACES: [[usize; 2]; 6] = [[0, 8], [1, 9], [2, 10], [3, 11], [4, 12], [5, 13]];

#[test]
fn a_robot_that_points_elsewhere_has_the_same_margins_and_the_same_words() {
    let hard = ["pushes.0.force_n=2500", "pushes.0.start_s=0.3", "duration_s=3"];
    let aside = ["pushes.0.force_n=2500", "pushes.0.heading_deg=90", "pushes.0.start_s=0.3", "duration_s=3"];
    for (sets, falls) in [(&["duration_s=3"][..], false), (&hard[..], true), (&aside[..], true)] {
        let (run, quarter) = (turned(sets, 0.0), turned(sets, 90.0));
        assert_eq!(matches!(run.outcome, Outcome::Fell(_)), falls, "{:?}", run.outcome);
        // Figures may differ in their last digits: a fall lets rounding grow.
        let words = |run: &Run| run.reason.as_deref().unwrap_or("").replace(|c: char| c.is_ascii_digit(), "");
        assert_eq!(words(&run), words(&quarter));
        let mut least = f64::INFINITY;
        // Until the push of a fall is over, the whole run where there is none.
        for tick in 0..if falls { 400 } else { run.log.len() } {
            let [one, other] = [&run, &quarter].map(|run| run.log.get(tick, Field::Balance));
            assert!((one[MARGIN] - other[MARGIN]).abs() < 1e-6, "tick {tick}: {} and {}", one[MARGIN], other[MARGIN]);
            assert_eq!(one[MARGIN + 1], other[MARGIN + 1], "steps in tick {tick}");
            for [x, y] in PLACES {
                let off = (other[x] + one[y]).hypot(other[y] - one[x]);
                assert!(off < 1e-5, "tick {tick}, column {x}: {one:?} and {other:?}");
            }
            for field in [Field::Torso, Field::TorsoReference] {
                let [one, other] = [&run, &quarter].map(|run| run.log.get(tick, field));
                let off = one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
                assert!(off < 1e-5, "{field:?} in tick {tick}: {one:?} and {other:?}");
            }
            least = least.min(one[MARGIN]);
        }
        assert_eq!(least < 0.0, falls, "{least} m");
    }
}

#[test]
fn a_torso_leans_the_way_that_it_is_pushed_however_far() {
    let hard = ["pushes.0.force_n=2500", "pushes.0.start_s=0.3", "fall.min_com_height_fraction=0.05", "duration_s=3"];
    for (set, way) in [
        ("fall.max_torso_angle_deg=60", "60 deg forward"),
        ("fall.max_torso_angle_deg=100", "100 deg forward"),
        ("pushes.0.heading_deg=-90", "60 deg to the right"),
        ("pushes.0.heading_deg=90", "60 deg to the left"),
    ] {
        let reason = common::run("exo-sway", &[&hard[..], &[set]].concat()).reason.expect("it falls");
        assert!(reason.ends_with(&format!("the torso leaned {way} of its reference")), "{reason}");
    }
}

/// The robot with the axes of its feet's bodies turned about z by `degrees`, and nothing else: the same robot.
fn with_turned_feet(mut robot: Robot, degrees: f64) -> Robot {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians()).into_inner();
    let mut feet: Vec<usize> = robot.contacts.iter().map(|contact| contact.body).collect();
    feet.dedup();
    for foot in feet {
        let body = &mut robot.bodies[foot];
        body.placement.rotation *= turn;
        body.com = turn.transpose() * body.com;
        body.inertia = turn.transpose() * body.inertia * turn;
        let Joint::Revolute(Revolute { axis }) = &mut body.joint else { panic!("an ankle turns") };
        *axis = Unit::new_unchecked(turn.transpose() * axis.into_inner());
    }
    for contact in &mut robot.contacts {
        contact.position = turn.transpose() * contact.position;
    }
    robot
}

#[test]
fn the_axes_of_a_foot_do_not_matter() {
    for (name, degrees) in [("exo-sway", 90.0), ("exo-sway", -30.0), ("feet-walk", 180.0)] {
        let loaded = scenario_file::load(name, &["duration_s=1".to_owned()]).expect("built in");
        let robot = loaded.model().expect("built in");
        let run = |robot: &Robot| episode::run(&loaded.scenario, robot, &[], |_| false).expect("it can start");
        let (one, other) = (run(&robot), run(&with_turned_feet(robot.clone(), degrees)));
        assert_eq!((&one.outcome, &other.outcome), (&Outcome::Completed, &Outcome::Completed), "{:?}", other.reason);
        let last = one.log.len() - 1;
        for field in [Field::Com, Field::Feet, Field::Q] {
            let [one, other] = [&one, &other].map(|run| run.log.get(last, field));
            let off = one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
            assert!(off < 1e-4, "{name}, {degrees} deg, {field:?}: {off}");
        }
    }
}

#[test]
fn a_robot_without_two_feet_is_refused_where_two_are_wanted() {
    let robot = Robot::from_toml(BOX_IN_SPACE, "box.toml").expect("a robot with four feet");
    let loaded = scenario_file::load("exo-sway", &["controller.kind=hold".to_owned()]).expect("built in");
    let error = episode::run(&loaded.scenario, &robot, &[], |_| false).expect_err("it has four feet");
    assert_eq!(error.to_string(), "model: found a robot with 4 feet; valid is one with two, right before left");
}
