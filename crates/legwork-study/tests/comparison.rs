//! Two robots beside each other: each figure of a gait again from the log of the run.

use legwork::episode::Run;
use legwork_study::comparison::{Gait, PERSON};
use legwork_study::{Base, rollout};

fn base(name: &str, sets: &[&str]) -> Base {
    Base::load(name, &sets.iter().map(|&set| set.to_owned()).collect::<Vec<_>>()).expect("built in")
}

fn gait(name: &str, sets: &[&str], speed: f64) -> Gait {
    let base = base(name, sets);
    Gait::of(&base, base.walks().expect("it walks"), speed, || false).expect("nothing stops it")
}

/// The columns whose names begin and end so, from `first` on.
fn columns(run: &Run, first: usize, begin: &str, end: &str) -> Vec<Vec<f64>> {
    let names = run.log.columns().iter().enumerate();
    let found = names.filter(|(_, column)| column.name.starts_with(begin) && column.name.ends_with(end));
    found.map(|(index, _)| run.log.column(index).skip(first).collect()).collect()
}

fn check(name: &str, path: &str, speed: f64, from: f64, joints: &[&str]) {
    let walk = base(name, &[&format!("{path}={speed}"), "duration_s=6"]);
    let run = rollout::simulate(walk.variant(), || false).expect("it can start");
    let gait = gait(name, &["duration_s=6"], speed);
    let figures = gait.figures.expect("it walks");
    assert_eq!((gait.speed_mps, gait.failure), (speed, None));
    let first = (0..run.log.len()).find(|&tick| run.log.time(tick) >= from).expect("it lasts longer");
    let ticks = (run.log.len() - first) as f64;
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 2e-3 * b.abs(), "{name}: {a} {b}");

    let names: Vec<&str> = figures.joints.iter().map(|joint| joint.joint.as_str()).collect();
    assert_eq!(names, joints);
    for joint in &figures.joints {
        let torques = columns(&run, first, "torque_applied.", &joint.joint);
        assert_eq!(torques.len(), 2, "right and left");
        close(joint.peak_nm, torques.concat().iter().fold(0.0, |peak, torque| torque.abs().max(peak)));
        close(joint.mean_nm, torques.concat().iter().map(|torque| torque.abs()).sum::<f64>() / (2.0 * ticks));
    }
    let squared = columns(&run, first, "torque.", "").concat().iter().map(|torque| torque * torque).sum::<f64>();
    close(figures.u2_n2m2.expect("it walks"), squared / ticks);
    let swing = &columns(&run, first, "swing", "swing")[0];
    close(
        figures.single_support_fraction.expect("it walks"),
        swing.iter().filter(|foot| **foot >= 0.0).count() as f64 / ticks,
    );
    let [x, z] = ["_x", "_z"].map(|axis| columns(&run, first, "grf_simulated.", axis));
    let sum = |forces: &[Vec<f64>], tick: usize| forces.iter().map(|force| force[tick]).sum::<f64>();
    let force = (0..x[0].len()).map(|tick| sum(&x, tick).hypot(sum(&z, tick))).fold(0.0, f64::max);
    close(figures.ground_force_peak_n, force);
    let com = &columns(&run, first, "com_x", "com_x")[0];
    close(figures.mean_speed_mps, (com[com.len() - 1] - com[0]) / (1e-3 * (ticks - 1.0)));
    let torso = &columns(&run, first, "torso", "torso")[0];
    let [least, most] = [f64::min, f64::max].map(|of| torso.iter().copied().reduce(of).expect("it lasts"));
    close(figures.torso_range_rad, most - least);
    let used = gait.used.expect("it walks");
    assert_eq!((used.scenario, used.points[0].len()), (format!("{name} at {speed} m/s"), com.len()));
}

#[test]
fn the_figures_are_those_of_the_steady_walk() {
    check("walk", "reference.com.speed_mps", 0.5, 3.0, &["hip", "knee"]);
    check("feet-walk", "reference.walker.speed_mps", 1.0, 3.9431, &["hip", "knee", "ankle"]);
}

#[test]
fn feet_walk_with_less_torque_and_effort_than_points() {
    let [points, feet] = ["walk", "feet-walk"].map(|name| gait(name, &[], 0.5).figures.expect("it walks"));
    let peak = |figures: &legwork_study::comparison::Figures, index: usize| figures.joints[index].peak_nm;
    for (joint, (_, of_person)) in PERSON.peaks_nm.iter().enumerate().take(2) {
        assert!(peak(&feet, joint) < 0.5 * peak(&points, joint), "joint {joint}");
        assert!(peak(&points, joint) > 3.0 * of_person);
    }
    let [u2, support] =
        [[points.u2_n2m2, feet.u2_n2m2], [points.single_support_fraction, feet.single_support_fraction]]
            .map(|pair| pair.map(|value| value.expect("it walks")));
    assert!(u2[1] < 0.4 * u2[0] && feet.cost_of_transport < points.cost_of_transport);
    assert!(support[1] > support[0] + 0.3);
}

#[test]
fn a_speed_that_is_not_walked_is_a_result_with_its_reason() {
    for (name, sets, speed, said) in [
        ("walk", &[][..], 1.6, " m/s on average where 1.600 m/s was asked for"),
        ("feet-walk", &[], 2.2, "fell at "),
        ("feet-walk", &[], 2.4, "takes steps of "),
        ("walk", &["duration_s=2"], 0.5, "the run is too short for a steady walk"),
    ] {
        let gait = gait(name, sets, speed);
        assert!(gait.figures.is_none() && gait.used.is_none());
        assert!(gait.failure.as_ref().is_some_and(|reason| reason.contains(said)), "{name}: {:?}", gait.failure);
    }
}
