//! Same inputs, same bits: again, and on several threads.

mod common;

use legwork::{episode, scenario_file};

#[test]
fn repeated_and_parallel_runs_give_the_same_bits() {
    let noisy: &[&str] = &[
        "duration_s=2",
        "seed=7",
        "simulation.sensors.position_noise=0.0005",
        "simulation.sensors.velocity_noise=0.01",
        "simulation.sensors.delay_s=0.002",
        "simulation.actuators.lag_s=0.002",
    ];
    for (name, sets) in [("walk", &["duration_s=2"][..]), ("push", &["duration_s=2"][..]), ("walk", noisy)] {
        let first = common::run(name, sets);
        let others: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| common::run(name, sets))).collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        for other in others {
            assert_eq!(first.result_hash, other.result_hash, "{name} {sets:?}");
            assert_eq!(first.input_hash, other.input_hash);
        }
    }
}

#[test]
fn what_a_run_depends_on_is_in_its_input_hash() {
    let base = common::run("stand", &["duration_s=0.01"]);
    for set in ["seed=1", "ground.friction=0.84", "controller.planner.com_gain=1501", "fall.max_torso_angle_deg=61"] {
        let other = common::run("stand", &["duration_s=0.01", set]);
        assert_ne!(base.input_hash, other.input_hash, "{set}");
    }
}

/// The content of the file with the CoM trajectory was not in the hash, but its path was.
#[test]
fn two_trajectory_files_gave_one_input_hash() {
    let run = |path: &str, height: f64| {
        let sets = ["duration_s=0.01", "reference.com.trajectory=file", &format!("reference.com.file={path}")];
        let loaded = scenario_file::load("stand", &sets.map(str::to_owned)).expect("it is valid");
        let samples = [[0.0, 0.27, 0.885], [1.0, 0.27, height], [2.0, 0.27, height]];
        episode::run(&loaded.scenario, &loaded.model().expect("it is built in"), &samples, |_| false)
            .expect("it starts")
    };
    assert_eq!(run("com.csv", 0.88).input_hash, run("there/com.csv", 0.88).input_hash);
    assert_ne!(run("com.csv", 0.88).input_hash, run("com.csv", 0.87).input_hash);
}

#[test]
fn the_seed_matters_with_noise_and_only_then() {
    let silent = |seed: &str| common::run("stand", &["duration_s=0.1", seed]).result_hash;
    assert_eq!(silent("seed=1"), silent("seed=2"));
    let noisy = |seed: &str| {
        common::run("stand", &["duration_s=0.1", "simulation.sensors.velocity_noise=0.01", seed]).result_hash
    };
    assert_ne!(noisy("seed=1"), noisy("seed=2"));
}
