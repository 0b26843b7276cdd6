//! Every limit that a model gives a joint acts, or the run says that it did not.

use legwork::channel::Field;
use legwork::episode::{self, Outcome, Run};
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
