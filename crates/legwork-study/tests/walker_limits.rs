//! Limits of the robot with feet: its own commanded speed, its joints' own limits, its steady walk.

use legwork::episode::Run;
use legwork::log::Field;
use legwork_study::limits::{self, Held, Question};
use legwork_study::robustness::{Plan, Robustness};
use legwork_study::search::Search;
use legwork_study::sizing::{Coping, SpeedTorque, Use};
use legwork_study::{Base, Change, Variant, rollout};
use toml::Value;

fn base(name: &str, sets: &[&str]) -> Base {
    Base::load(name, &sets.iter().map(|&set| set.to_owned()).collect::<Vec<_>>()).expect("it is built in")
}

fn simulated(name: &str, sets: &[&str]) -> Run {
    rollout::simulate(base(name, sets).variant(), || false).expect("it can start")
}

fn vary(base: &Base, path: &str, value: f64) -> Variant {
    base.vary([(path, &Change::To(Value::Float(value)))]).expect("it is valid")
}

/// Why `variant` does not hold.
fn failure(held: Held, variant: &Variant) -> Option<String> {
    held.failure(variant, &rollout::run(variant, || false).expect("nothing stops it"))
}

#[test]
fn a_scenario_has_one_commanded_speed_whatever_its_generator() {
    for (name, sets, path, speed, steady_from) in [
        ("walk", &[][..], "reference.com.speed_mps", 0.5, 0.0),
        ("walk", &["reference.com.ramp_s=1.5"], "reference.com.speed_mps", 0.5, 1.5),
        // Four steps of 0.5691 s, one of 0.519 s; the gain of 0.6 1/s has 1.667 s.
        ("feet-walk", &[], "reference.walker.speed_mps", 1.0, 3.9431),
        ("feet-walk", &["reference.walker.speed_mps=-0.25"], "reference.walker.speed_mps", -0.25, 2.1857),
    ] {
        let commanded = base(name, sets).walks().expect("it walks");
        assert_eq!((commanded.path, commanded.speed_mps), (path, speed));
        assert!((commanded.steady_from_s - steady_from).abs() < 1e-3, "{name} {sets:?}: {}", commanded.steady_from_s);
    }
    for (name, sets, said) in [
        ("push", &[][..], "push: reference.com.trajectory: found a scenario that does not walk at a constant speed"),
        ("stop-and-go", &[], "stop-and-go: reference.walker.speeds: found"),
        ("feet-walk", &["reference.walker.speed_mps=0"], "feet-walk: reference.walker.speed_mps: found"),
        ("exo-sway", &[], "exo-sway: reference.generator: found"),
    ] {
        let words = base(name, sets).walks().expect_err("it does not walk").to_string();
        assert!(words.starts_with(said), "{words}");
    }
}

#[test]
fn the_start_from_standing_does_not_count_for_the_speed() {
    let run = simulated("feet-walk", &["duration_s=8"]);
    let com = |tick: usize| run.log.get(tick, Field::Com)[0];
    let (first, last) = (3944, run.log.len() - 1);
    let by_hand = (com(last) - com(first)) / (run.log.time(last) - run.log.time(first));
    let speed = run.metrics.steady_speed_mps.expect("it lasts long enough");
    assert!((speed - by_hand).abs() < 1e-3 && (speed - 1.0).abs() < 0.05, "{speed} {by_hand}");
    assert!(run.metrics.mean_speed_mps < 0.95, "the start is slow: {}", run.metrics.mean_speed_mps);
    let errors = (first..=last).map(|tick| legwork::metrics::com_error(&run.log, tick));
    let mean = errors.sum::<f64>() / (last - first + 1) as f64;
    assert!((run.metrics.steady_com_error_m.expect("it lasts long enough") - mean).abs() < 1e-4);
    let short = base("feet-walk", &["duration_s=3"]);
    let words = failure(Held::KeepsSpeed(0.05), short.variant()).expect("it is no steady walk yet");
    assert_eq!(words, "the run is too short for a steady walk");
    let never = base("feet-walk", &["duration_s=3", "reference.walker.speed_change_mps=0"]);
    assert_eq!(failure(Held::KeepsSpeed(0.05), never.variant()), Some(words));
    // The thesis's walk is commanded its speed from the first moment on.
    let walk = simulated("walk", &["duration_s=4"]).metrics;
    assert_eq!(walk.steady_speed_mps, Some(walk.mean_speed_mps));
    assert_eq!(walk.steady_com_error_m, walk.com_error_m.map(|error| error.mean));
}

#[test]
fn the_questions_begin_at_what_the_robot_really_has() {
    let (walk, push) = (base("feet-walk", &[]), base("push-walking", &[]));
    let questions = limits::of_walk(&walk).expect("it walks");
    let labels: Vec<&str> = questions.iter().map(|question| question.label.as_str()).collect();
    let expected = ["top speed kept to 5 % at 200 Nm", "top speed followed at 200 Nm", "lowest torque limit"];
    assert_eq!(labels, [&expected[..], &["lowest force limit", "lowest friction"]].concat());
    assert_eq!(questions[2].search.from, 200.0, "the controller's 1000 Nm are above every joint's own");
    let fastest = questions[0].search.to;
    assert!(questions[0].search.from == 1.0 && (2.1..2.4).contains(&fastest), "{fastest}");
    let commanded = walk.walks().expect("it walks");
    assert!(walk.at_speed(commanded, fastest).is_ok() && walk.at_speed(commanded, fastest + 0.15).is_err());
    let pushed = limits::of_push(&push).expect("it has a push");
    let torque = pushed.iter().find(|question| question.label == "lowest torque limit").expect("it is asked");
    assert_eq!(torque.search.from, 200.0);
}

/// The answer of a coarse search, and that its value holds and the next does not.
fn confirmed(question: &mut Question<'_>, base: &Base, path: &str, resolution: f64) -> f64 {
    question.search = Search { resolution, parts: 6, neighbours: 1, ..question.search.quick() };
    let found = question.answer(|| false).expect("nothing stops it").found;
    let (value, fails) = (found.value.expect("the start holds"), found.first_failure.expect("the end does not"));
    assert_eq!(failure(Held::KeepsSpeed(0.05), &vary(base, path, value)), None);
    assert!(failure(Held::KeepsSpeed(0.05), &vary(base, path, fails)).is_some(), "{fails}");
    value
}

#[test]
fn its_top_speed_and_its_lowest_torque_limit_are_found() {
    let base = base("feet-walk", &["duration_s=8"]);
    let mut questions = limits::of_walk(&base).expect("it walks");
    let speed = confirmed(&mut questions[0], &base, "reference.walker.speed_mps", 0.05);
    assert!((1.8..2.2).contains(&speed), "{speed} m/s");
    let torque = confirmed(&mut questions[2], &base, "controller.limits.torque_nm", 10.0);
    assert!((90.0..150.0).contains(&torque), "{torque} Nm");
}

#[test]
fn a_scenario_that_walks_is_struck_standing_too() {
    let (walk, push) = (base("feet-walk", &[]), base("push-walking", &[]));
    let mut plan = Plan::new(1, 1);
    plan.search = Search { parts: 5, neighbours: 0, to: 4.0, ..plan.search.quick() };
    let map = Robustness::new(&walk, &push, plan, || false).expect("it can run");
    let stride = map.stride.expect("it walks");
    assert!(stride.start_s > 3.8 && (1.0..1.3).contains(&stride.period_s), "{stride:?}");
    let [standing, walking] = [0, 1].map(|index| map.answer(index, || false).expect("nothing stops it"));
    assert_eq!((standing.phase, standing.start_s, walking.start_s), (None, 0.5, stride.start_s));
    let stands = push.at_speed(walk.walks().expect("it walks"), 0.0).expect("it is valid");
    let survives = |impulse: f64| {
        let variant = map.struck(stands.variant(), impulse, 0.0, 0.5);
        rollout::run(&variant, || false).expect("nothing stops it").survived()
    };
    let (value, fails) = (standing.found.value.expect("it stands"), standing.found.first_failure.expect("a limit"));
    assert!(value >= 0.5 && survives(value) && !survives(fails), "{value} {fails}");
    let struck = map.struck(stands.variant(), value, 0.0, 0.5);
    let force =
        rollout::simulate(&struck, || false).expect("it can run").metrics.grf_simulated_n.expect("it is measured");
    assert!(
        standing.found.force_n.is_some_and(|largest| largest >= force.peak),
        "{:?} {}",
        standing.found.force_n,
        force.peak
    );
}

#[test]
fn the_map_stays_within_what_can_be_commanded_and_any_joint_has() {
    let base = base("feet-walk", &["duration_s=7"]);
    let map = SpeedTorque::new(&base, 2, 2).expect("it walks");
    assert_eq!((map.torques_nm.as_slice(), map.speeds_mps[0]), (&[100.0, 200.0][..], 0.2));
    let cells: Vec<_> = (0..4).map(|index| map.answer(index, || false).expect("nothing stops it")).collect();
    let coping: Vec<Coping> = cells.iter().map(|cell| cell.coping).collect();
    assert_eq!(coping, [Coping::Follows, Coping::Falls, Coping::Follows, Coping::Falls]);
    assert!(cells[2].mean_speed_mps.is_some_and(|speed| (speed - 0.2).abs() < 0.01));
}

#[test]
fn a_joint_is_at_its_limit_where_it_is_at_its_own() {
    let run = simulated("push-walking", &["pushes.0.force_n=300", "duration_s=7"]);
    let used = Use::of(&run);
    let mut limited = 0;
    for (joint, column) in used.joints.iter().zip(run.log.range(Field::Torque)) {
        let own = if joint.joint.ends_with("ankle") { 150.0 } else { 200.0 };
        let count = run.log.column(column).filter(|torque| torque.abs() > own - 1e-3).count();
        assert!((joint.at_limit - count as f64 / run.log.len() as f64).abs() < 1e-9, "{}", joint.joint);
        limited += count;
    }
    assert!(limited > 0, "the push must be hard enough for this test to tell");
}
