//! The thesis's two experiments reach its published figures, within the tolerances that the project promises.

mod common;

use legwork::episode::{Outcome, Run};
use legwork::log::Field;
use legwork::metrics::com_error;

fn within(what: &str, value: f64, low: f64, high: f64) {
    assert!((low..=high).contains(&value), "{what}: {value} is not in [{low}, {high}]");
}

fn around(what: &str, value: f64, published: f64, share: f64) {
    within(what, value, published * (1.0 - share), published * (1.0 + share));
}

fn clean(run: &Run) {
    assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
    assert_eq!(run.violations(), Vec::<String>::new());
    assert_eq!(run.program.infeasible, 0);
}

/// What the project promises of the walk, beside Table 6.4.
fn walks(run: &Run) {
    clean(run);
    let m = &run.metrics;
    let com_error_m = m.com_error_m.expect("it lasts");
    within("CoM error, mean", com_error_m.mean, 0.0, 0.013);
    let late = (0..run.log.len()).filter(|&i| run.log.time(i) >= 2.0);
    within("CoM error after 2 s, peak", late.map(|i| com_error(&run.log, i)).fold(0.0, f64::max), 0.0, 0.028);
    within("feet error, mean", m.feet_error_m.expect("it is measured").mean, 0.0, 1.8e-3);
    within("feet error, peak", m.feet_error_m.expect("it is measured").peak, 0.0, 0.034);
    around("torque, mean", m.torque_nm.expect("it is measured").mean, 69.6, 0.03);
    within("torque, peak", m.torque_nm.expect("it is measured").peak, 0.0, 220.0);
    around("force, mean", m.grf_n.expect("it is measured").mean, 356.0, 0.02);
    around("u2, mean", m.u2_n2m2.expect("it is measured").mean, 3.0e4, 0.05);
    within("single support", m.single_support_fraction.expect("it is measured"), 0.31, 0.39);
    within("mean speed", m.mean_speed_mps, 0.49, 0.51);
}

/// What the project promises of the push, beside Table 6.5.
fn recovers(run: &Run) {
    clean(run);
    let m = &run.metrics;
    let com_error_m = m.com_error_m.expect("it lasts");
    within("CoM error, mean", com_error_m.mean, 0.0, 0.50);
    within("CoM error, peak", com_error_m.peak, 0.0, 1.2);
    within("feet error, mean", m.feet_error_m.expect("it is measured").mean, 0.0, 1.8e-3);
    within("feet error, peak", m.feet_error_m.expect("it is measured").peak, 0.0, 0.06);
    around("torque, mean", m.torque_nm.expect("it is measured").mean, 59.6, 0.10);
    within("torque, peak", m.torque_nm.expect("it is measured").peak, 0.0, 220.0);
    around("force, mean", m.grf_n.expect("it is measured").mean, 362.0, 0.03);
    around("u2, mean", m.u2_n2m2.expect("it is measured").mean, 2.8e4, 0.15);
    within("recovery time", m.recovery_time_s.expect("it recovers"), 3.6, 4.8);
    within("CoM error at the end", com_error(&run.log, run.log.len() - 1), 0.0, 0.05);
}

#[test]
fn the_walk_is_table_6_4() {
    walks(&common::run("walk", &[]));
}

#[test]
fn the_push_is_table_6_5() {
    recovers(&common::run("push", &[]));
}

/// The least step length read as a least base of support: the figures that the other reading misses as well.
#[test]
fn a_least_base_of_support_comes_closer_to_the_push() {
    let walk = common::run("walk-support", &[]);
    walks(&walk);
    around(
        "torso deviation of the walk, peak",
        walk.metrics.torso_deviation_rad.expect("it is measured").peak,
        0.058,
        0.10,
    );
    let push = common::run("push-support", &[]);
    recovers(&push);
    let m = &push.metrics;
    around("CoM error, peak", m.com_error_m.expect("it lasts").peak, 0.85, 0.05);
    within("vertical CoM error, peak", m.com_error_vertical_m.expect("it lasts").peak, 0.0, 0.028);
    around("torso deviation, peak", m.torso_deviation_rad.expect("it is measured").peak, 0.058, 0.05);
    around("u2, mean", m.u2_n2m2.expect("it is measured").mean, 2.8e4, 0.05);
}

#[test]
fn replanning_in_the_swing_halves_the_way() {
    let run = common::run("push-replan", &[]);
    clean(&run);
    within("furthest point", run.metrics.recovery_distance_m.expect("there is a push"), 0.0, 0.7);
}

#[test]
fn the_push_takes_steps_and_the_reference_comes_to_rest() {
    let run = common::run("push", &[]);
    assert!(run.metrics.steps >= Some(3), "only {:?} steps", run.metrics.steps);
    let last = run.log.len() - 1;
    assert!(run.log.get(last, Field::Swing)[0] < 0.0);
}

/// The first steps of the walk and the push, against an independent prototype with another integrator.
#[test]
fn the_first_steps_are_those_of_an_independent_prototype() {
    for (name, until) in [("walk", 1.0), ("push", 0.7)] {
        let run = common::run(name, &["simulation.integrator=semi-implicit-euler"]);
        let path = format!("{}/tests/data/prototype_{name}.csv", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("the data is there");
        let mut rows = 0;
        for line in text.lines().skip(2) {
            let row: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            if row[0] > until {
                break;
            }
            rows += 1;
            let i = (row[0] * 1000.0).round() as usize;
            let log = &run.log;
            let measured = [log.get(i, Field::Com), log.get(i, Field::Feet), &log.get(i, Field::Torso)[..1]].concat();
            for (k, (ours, theirs)) in measured.iter().zip(&row[1..8]).enumerate() {
                assert!((ours - theirs).abs() < 5e-3, "{name} at {} s, column {k}: {ours} against {theirs}", row[0]);
            }
            if row[0] < 0.5 {
                for (ours, theirs) in log.get(i, Field::Torque).iter().zip(&row[8..]) {
                    assert!((ours - theirs).abs() < 2.0, "{name} at {} s: torque {ours} against {theirs}", row[0]);
                }
            }
        }
        assert!(rows > 30, "only {rows} rows of {name}");
    }
}
