//! Many robots stepped together: each as if it were alone, on any number of threads, without allocation.

use legwork::Robot;
use legwork::library;
use legwork::scenario::{Push, Scenario};
use legwork::sim::Simulator;
use legwork::sim::batch::Batch;
use legwork_study::parallel::{step_batch, with_threads};

fn humanoid() -> Robot {
    library::load_model("planar_humanoid", None).expect("a built-in model")
}

/// Robots in different postures, the lower foot of each between 5 mm and some centimetres above the ground.
fn starts(count: usize) -> Vec<Vec<f64>> {
    let model = humanoid();
    let mut dynamics = legwork_rbd::Dynamics::new(&model);
    let start = |k: usize| {
        let k = k as f64;
        let mut q = vec![0.0, 0.0, -0.1, 0.4 + 0.01 * k, -0.6, 0.2, -0.5 - 0.01 * k];
        dynamics.update(&model, &q, &[0.0; 7]);
        let lowest = dynamics.contact_positions.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
        q[1] = 0.005 + 0.001 * k - lowest;
        q
    };
    (0..count).map(start).collect()
}

fn torques(step: usize, count: usize) -> Vec<f64> {
    (0..4 * count).map(|j| 20.0 * ((step + 7 * j) as f64 * 0.01).sin()).collect()
}

fn scenario() -> Scenario {
    let mut scenario = Scenario::default();
    scenario.pushes.push(Push { force_n: 50.0, start_s: 0.02, duration_s: 0.05, ..Push::default() });
    scenario
}

fn batch(starts: &[Vec<f64>]) -> Result<Batch, legwork::error::Error> {
    let (scenario, model) = (scenario(), humanoid());
    Batch::new(&scenario.simulation, &scenario.pushes, &scenario.terrain(&model), &model, starts)
}

fn bits(robot: &Simulator) -> Vec<u64> {
    robot.q().iter().chain(robot.v()).chain(robot.contact_forces()).map(|value| value.to_bits()).collect()
}

#[test]
fn each_robot_moves_as_if_it_were_alone() {
    let (count, model, scenario) = (40, humanoid(), scenario());
    let mut batch = batch(&starts(count)).expect("valid starts");
    let mut on_threads = batch.clone();
    let mut alone: Vec<Simulator> =
        starts(count).iter().map(|q| scenario.simulator(&model, q).expect("a valid push")).collect();
    let mut landed = 0;
    for step in 0..300 {
        let torques = torques(step, count);
        assert_eq!(batch.step(&torques), count);
        assert_eq!(with_threads(Some(3), || step_batch(&mut on_threads, &torques)).expect("three threads"), count);
        for (index, robot) in alone.iter_mut().enumerate() {
            assert!(robot.step(&torques[4 * index..4 * index + 4]));
            landed += usize::from(robot.contact_forces().iter().any(|force| *force != 0.0));
        }
    }
    assert!(landed > 100, "the ground must take part: {landed}");
    for ((together, threaded), alone) in batch.robots().iter().zip(on_threads.robots()).zip(&alone) {
        assert_eq!(bits(together), bits(alone));
        assert_eq!(bits(threaded), bits(alone));
    }
}

#[test]
fn a_batch_step_allocates_nothing() {
    let mut batch = batch(&starts(8)).expect("valid starts");
    let torques: Vec<Vec<f64>> = (0..200).map(|step| torques(step, 8)).collect();
    let allocations = allocation_counter::measure(|| {
        for torques in &torques {
            batch.step(torques);
        }
    });
    assert_eq!(allocations.count_total, 0);
}

#[test]
fn a_bad_start_is_refused_with_its_place() {
    for (start, says) in [(vec![0.0; 6], "found 6 values; expected 7"), (vec![f64::NAN; 7], "found NaN")] {
        let starts = [vec![0.0; 7], start];
        let error = batch(&starts).expect_err("a bad start").to_string();
        assert!(error.contains("starts.1") && error.contains(says), "{error}");
    }
}
