//! The simulator against closed forms, against itself at finer steps, and against its own books.

mod common;

use legwork::Robot;
use legwork::contract::Sensed;
use legwork::episode::Episode;
use legwork::log::Field;
use legwork::scenario::{ContactModel, Integrator, Push, Scenario};
use legwork::sim::Simulator;
use legwork::{library, scenario_file};
use legwork_rbd::Model;

/// A box of 10 kg with two contact points under it, 0.2 m apart.
const BOX: &str = r#"
name = "box"
base = "planar"
gravity_mps2 = 9.81
torso = "box"
contacts = [
    { name = "rear", foot = "rear", body = "box", position_m = [-0.1, 0.0, -0.05] },
    { name = "front", foot = "front", body = "box", position_m = [0.1, 0.0, -0.05] },
]
[[bodies]]
name = "box"
mass_kg = 10.0
com_m = [0.0, 0.0, 0.0]
inertia_kgm2 = 0.1
"#;

fn a_box() -> Model {
    Model::from_toml(BOX, "box.toml").expect("a valid model")
}

fn humanoid() -> Robot {
    library::load_model("planar_humanoid", None).expect("a built-in model")
}

fn simulator(scenario: &Scenario, model: &Model, q: &[f64]) -> Simulator {
    scenario.simulator(model, q).expect("valid pushes")
}

/// Runs a built-in scenario and shows of every tick the truth and what the controller was told.
fn watch(name: &str, sets: &[&str], mut see: impl FnMut(&Sensed, &Sensed)) {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = scenario_file::load(name, &sets).expect("a built-in scenario");
    let mut episode = Episode::new(&loaded.scenario, &loaded.model().expect("built in"), &[]).expect("it can start");
    loop {
        let truth = episode.truth().clone();
        let goes_on = episode.advance().expect("no sink");
        see(&truth, episode.told());
        if !goes_on {
            break;
        }
    }
}

/// Runs `seconds` with constant torques.
fn advance(simulator: &mut Simulator, torque: &[f64], period: f64, seconds: f64) {
    for _ in 0..(seconds / period).round() as usize {
        assert!(simulator.step(torque), "numbers out of bounds");
    }
}

/// A box at rest on a slope [deg], its contact points on the ground.
fn box_on_slope(friction: f64, slope_deg: f64) -> Simulator {
    let mut scenario = Scenario::default();
    scenario.ground.friction = friction;
    scenario.ground.slope_deg = slope_deg;
    let slope = slope_deg.to_radians();
    simulator(&scenario, &a_box(), &[-0.05 * slope.sin(), 0.05 * slope.cos(), slope])
}

#[test]
fn a_box_sticks_on_a_slope_that_friction_holds() {
    let mut simulator = box_on_slope(0.5, 20.0); // tan 20° = 0.36
    advance(&mut simulator, &[], 1e-3, 1.0);
    assert!(simulator.v().iter().all(|v| v.abs() < 1e-9), "{:?}", simulator.v());
    assert!(simulator.audit().slip_m < 1e-9);
}

#[test]
fn a_box_slides_down_a_slope_as_coulomb_says() {
    let (friction, slope_deg) = (0.2, 20.0_f64);
    let mut simulator = box_on_slope(friction, slope_deg);
    advance(&mut simulator, &[], 1e-3, 1.0);
    let slope = slope_deg.to_radians();
    let speed = 9.81 * (slope.sin() - friction * slope.cos()) * 1.0;
    let along = -simulator.v()[0] * slope.cos() - simulator.v()[1] * slope.sin();
    assert!((along - speed).abs() < 1e-9, "{along} m/s, expected {speed}");
    let way = 0.5 * speed * 1.0;
    assert!((simulator.audit().slip_m - 2.0 * way).abs() < 2.0 * 2e-3, "both points slip {way} m");
    // Each step with the velocity at its end, which friction opposes: n (n + 1) / 2 steps of a dt².
    let audited = simulator.audit().slip_m / 2.0;
    assert!((audited - 0.5 * speed * (1.0 + 1e-3)).abs() < 1e-6, "{audited} m");
}

#[test]
fn a_dropped_box_lands_without_a_bounce_and_the_ground_takes_its_energy() {
    let mut simulator = simulator(&Scenario::default(), &a_box(), &[0.0, 0.55, 0.0]);
    let mut highest_after: f64 = 0.0;
    let mut landed = false;
    for _ in 0..1000 {
        assert!(simulator.step(&[]));
        landed |= simulator.touching(0);
        if landed {
            highest_after = highest_after.max(simulator.q()[1]);
        }
    }
    assert!(landed && highest_after < 0.0515, "rose to {highest_after} m again");
    let energy = 10.0 * 9.81 * 0.5;
    assert!((simulator.audit().contact_loss_j - energy).abs() < 0.01 * energy);
    assert_eq!(simulator.audit().violations(), Vec::<String>::new());
}

#[test]
fn a_spring_damper_ground_bounces_which_is_the_argument_against_it() {
    let mut scenario = Scenario::default();
    scenario.simulation.contact.model = ContactModel::SpringDamper;
    scenario.simulation.contact.damping_nspm = 100.0;
    let mut simulator = simulator(&scenario, &a_box(), &[0.0, 0.55, 0.0]);
    let (mut landed, mut left_again, mut deepest) = (false, false, 0.0_f64);
    for _ in 0..1000 {
        assert!(simulator.step(&[]));
        let gap = simulator.q()[1] - 0.05;
        landed |= gap < 0.0;
        left_again |= landed && gap > 0.01;
        deepest = deepest.max(-gap);
    }
    assert!(landed && left_again && deepest > 1e-3);
    assert!(!simulator.audit().violations().is_empty(), "the penetration must be shown");
}

const BOX_IN_SPACE: &str = include_str!("data/box_in_space.toml");

#[test]
fn a_box_in_space_sticks_and_slides_as_in_the_plane() {
    let model = Model::from_toml(BOX_IN_SPACE, "box.toml").expect("a valid model");
    let (slope_deg, height) = (20.0_f64, 0.05);
    let slope = slope_deg.to_radians();
    for friction in [0.5, 0.2] {
        let mut scenario = Scenario::default();
        scenario.ground.friction = friction;
        scenario.ground.slope_deg = slope_deg;
        // Turned about -y by the slope, resting on its four points.
        let (half_sin, half_cos) = ((0.5 * slope).sin(), (0.5 * slope).cos());
        let q = [half_cos, 0.0, -half_sin, 0.0, -height * slope.sin(), 0.0, height * slope.cos()];
        let mut simulator = simulator(&scenario, &model, &q);
        advance(&mut simulator, &[], 1e-3, 0.5);
        let expected = (9.81 * (slope.sin() - friction * slope.cos()) * 0.5).max(0.0);
        let velocity = simulator.dynamics().com_velocity;
        let along = -velocity.x * slope.cos() - velocity.z * slope.sin();
        assert!((along - expected).abs() < 1e-9, "friction {friction}: {along} m/s, expected {expected}");
        assert!(velocity.y.abs() < 1e-12, "no sideways motion: {}", velocity.y);
        assert_eq!(simulator.audit().violations(), Vec::<String>::new());
    }
}

/// `exo18` with bent knees, soles on the ground.
fn exo18() -> (Model, Vec<f64>) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/exo18.urdf");
    let model = Model::load(&path).expect("a valid model");
    let mut q = model.neutral().as_slice().to_vec();
    for leg in [7, 13] {
        (q[leg + 1], q[leg + 3], q[leg + 4]) = (0.2, 0.4, 0.2);
    }
    let mut dynamics = legwork_rbd::Dynamics::new(&model);
    dynamics.update(&model, &q, &vec![0.0; model.nv()]);
    q[6] = -dynamics.contact_positions[0].z;
    (model, q)
}

#[test]
fn box_feet_carry_the_weight_on_corners_that_nothing_tells_apart() {
    let (model, start) = exo18();
    let mut simulator = simulator(&Scenario::default(), &model, &start);
    let mut torque = vec![0.0; 12];
    let (mut carried, mut steps) = (0.0, 0.0);
    for step in 0..1500 {
        for (j, torque) in torque.iter_mut().enumerate() {
            *torque = 1500.0 * (start[7 + j] - simulator.q()[7 + j]) - 60.0 * simulator.v()[6 + j];
        }
        assert!(simulator.step(&torque));
        if step >= 1000 {
            carried += simulator.contact_forces().chunks(3).map(|force| force[2]).sum::<f64>();
            steps += 1.0;
        }
    }
    let weight = model.total_mass() * model.gravity;
    assert!((carried / steps - weight).abs() < 0.01 * weight, "{} of {weight} N", carried / steps);
    assert_eq!(simulator.audit().violations(), Vec::<String>::new());
    assert!(simulator.audit().contact_residual_n <= 2e-6, "{}", simulator.audit().contact_residual_n);
    assert!(simulator.audit().slip_m < 1e-3, "stands: {}", simulator.audit().slip_m);
}

/// Heel and toe of each foot on the ground, feet 0.3 m apart, joined by ankles, knees and hips.
fn planar_with_soles() -> (Model, Vec<f64>) {
    let mut text = String::from("name = \"soles\"\nbase = \"planar\"\ntorso = \"trunk\"\ncontacts = [\n");
    for side in ["right", "left"] {
        for (name, x) in [("heel", -0.12), ("toe", 0.12)] {
            text += &format!(
                "{{ name = \"{side}_{name}\", foot = \"{side}\", body = \"{side}_foot\", position_m = [{x:?}, 0.0, 0.0] }},\n"
            );
        }
    }
    text += "]\n[[bodies]]\nname = \"trunk\"\nmass_kg = 40.0\ncom_m = [0.0, 0.0, 0.25]\ninertia_kgm2 = 2.0\n";
    for side in ["right", "left"] {
        for (name, parent, z, mass) in [
            ("thigh", "trunk".to_owned(), 0.0, 7.0),
            ("shank", format!("{side}_thigh"), -0.43, 4.0),
            ("foot", format!("{side}_shank"), -0.43, 1.0),
        ] {
            text += &format!(
                "[[bodies]]\nname = \"{side}_{name}\"\nparent = \"{parent}\"\nmass_kg = {mass:?}\n\
                 com_m = [0.0, 0.0, {:?}]\ninertia_kgm2 = 0.05\njoint = {{ name = \"{side}_{name}\", type = \"revolute\", \
                 axis = [0.0, -1.0, 0.0], origin_m = [0.0, 0.0, {z:?}] }}\n",
                if name == "foot" { 0.0 } else { -0.2 }
            );
        }
    }
    let model = Model::from_toml(&text, "soles.toml").expect("a valid model");
    let mut q = vec![0.0; model.nq()];
    q[1] = 0.8;
    for (leg, x) in [(3, 0.15_f64), (6, -0.15)] {
        let (lean, bend) = ((x / 0.8).atan(), (x.hypot(0.8) / 0.86).acos());
        (q[leg], q[leg + 1], q[leg + 2]) = (lean + bend, -2.0 * bend, bend - lean);
    }
    (model, q)
}

#[test]
fn heel_and_toe_of_one_foot_kept_the_contact_solver_at_its_last_sweep() {
    let (model, start) = planar_with_soles();
    let mut simulator = simulator(&Scenario::default(), &model, &start);
    let mut torque = vec![0.0; 6];
    for step in 0..1000 {
        for (j, torque) in torque.iter_mut().enumerate() {
            let asked = start[3 + j] + 0.01 * (0.03 * f64::from(step) + j as f64).sin();
            *torque = 2000.0 * (asked - simulator.q()[3 + j]) - 50.0 * simulator.v()[3 + j];
        }
        assert!(simulator.step(&torque));
    }
    let audit = simulator.audit();
    assert_eq!(audit.violations(), Vec::<String>::new());
    assert!(audit.contact_residual_n <= 1e-4 && audit.contact_sweeps <= 20, "{audit:?}");
}

#[test]
fn a_foot_lifted_and_put_down_left_the_contact_solver_short_of_its_tolerance() {
    let run = common::run("exo-lift", &[]);
    let residual = run.audit.as_ref().expect("our simulator").contact_residual_n;
    assert!(residual < 1e-4, "{residual} N");
    let contact = |index: usize| run.log.get(index, Field::Contact);
    let long = (0..run.log.len()).filter(|&index| contact(index)[0] > 20.0).count();
    assert!(long < run.log.len() / 500, "{long} steps of more than 20 sweeps");
}

#[test]
fn what_was_simulated_before_leaves_no_trace_in_a_fresh_simulator() {
    let (model, start) = exo18();
    let run = || {
        let mut simulator = simulator(&Scenario::default(), &model, &start);
        advance(&mut simulator, &[5.0; 12], 1e-3, 0.05);
        simulator.q().iter().chain(simulator.contact_forces()).map(|value| value.to_bits()).collect::<Vec<u64>>()
    };
    assert_eq!(run(), run());
}

/// The humanoid high above the ground, driven by constant torques.
fn in_flight(integrator: Integrator, period: f64) -> Simulator {
    let mut scenario = Scenario::default();
    scenario.simulation.integrator = integrator;
    scenario.simulation.period_s = period;
    let mut simulator = simulator(&scenario, &humanoid(), &[0.0, 20.0, -0.8, 1.0, -0.3, -2.2, -0.9]);
    advance(&mut simulator, &[8.0, -6.0, 5.0, -3.0], period, 0.4);
    simulator
}

#[test]
fn steps_converge_with_the_order_of_their_rule() {
    for (integrator, order) in [(Integrator::SemiImplicitEuler, 1.0), (Integrator::Midpoint, 2.0)] {
        let states: Vec<Vec<f64>> =
            [4e-3, 2e-3, 1e-3].iter().map(|&period| in_flight(integrator, period).q().to_vec()).collect();
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt();
        let ratio = difference(&states[0], &states[1]) / difference(&states[1], &states[2]);
        let measured = ratio.log2();
        assert!((measured - order).abs() < 0.2, "{integrator:?}: order {measured}, expected {order}");
    }
}

#[test]
fn flight_keeps_momentum_and_energy() {
    let simulator = in_flight(Integrator::Midpoint, 1e-3);
    let audit = simulator.audit();
    assert!(audit.momentum_error_mps < 1e-4, "{}", audit.momentum_error_mps);
    assert!(audit.energy_error_j < 1e-4 * audit.work_j, "{} of {}", audit.energy_error_j, audit.work_j);
    // No force but gravity from outside: the angular momentum about the CoM stays zero.
    let momentum = &simulator.dynamics().momentum_matrix * nalgebra::DVector::from_column_slice(simulator.v());
    assert!(momentum[0].abs() < 1e-3, "angular momentum {}", momentum[0]);
    let fall = simulator.dynamics().com_velocity.z + 9.81 * 0.4;
    assert!(fall.abs() < 1e-4 && simulator.dynamics().com_velocity.x.abs() < 1e-4);
}

#[test]
fn a_push_changes_the_momentum_by_its_impulse() {
    let model = humanoid();
    let q = [0.0, 20.0, -0.8, 1.0, -0.3, -2.2, -0.9];
    for (at, point_m) in [("com", [0.0; 3]), ("torso", [0.0, 0.0, 0.3])] {
        let mut scenario = Scenario::default();
        scenario.pushes.push(Push {
            force_n: 100.0,
            direction_deg: 60.0,
            heading_deg: 0.0,
            start_s: 0.05,
            duration_s: 0.1,
            at: at.into(),
            point_m,
        });
        let mut simulator = simulator(&scenario, &model, &q);
        advance(&mut simulator, &[0.0; 4], 1e-3, 0.2);
        let velocity = simulator.dynamics().com_velocity;
        let impulse = 100.0 * 0.1 / model.total_mass();
        assert!((velocity.x - impulse * 0.5).abs() < 1e-4, "{at}: {}", velocity.x);
        assert!((velocity.z + 9.81 * 0.2 - impulse * 60.0_f64.to_radians().sin()).abs() < 1e-4, "{at}: {}", velocity.z);
        let momentum = &simulator.dynamics().momentum_matrix * nalgebra::DVector::from_column_slice(simulator.v());
        assert_eq!(momentum[0].abs() < 1e-3, at == "com", "{at}: angular momentum {}", momentum[0]);
    }
}

#[test]
fn a_push_shorter_than_a_step_vanished() {
    let q = [0.0, 20.0, -0.8, 1.0, -0.3, -2.2, -0.9];
    for (start_s, duration_s) in [(0.05, 0.0004), (0.0507, 0.0011), (0.0503, 0.0002)] {
        let mut scenario = Scenario::default();
        scenario.pushes.push(Push { force_n: 1e4, start_s, duration_s, ..Push::default() });
        let mut simulator = simulator(&scenario, &humanoid(), &q);
        advance(&mut simulator, &[0.0; 4], 1e-3, 0.1);
        let expected = 1e4 * duration_s / humanoid().total_mass();
        let found = simulator.dynamics().com_velocity.x;
        assert!((found - expected).abs() < 1e-4 * expected.max(1.0), "{duration_s} s: {found}, expected {expected}");
    }
}

#[test]
fn a_foot_on_unknown_ground_was_pulled_to_a_plane_that_is_a_guess() {
    for sets in [["ground.slope_deg=5", "ground.known=false"], ["ground.slope_deg=-5", "ground.known=false"]] {
        let run = common::run("stand", &sets);
        assert_eq!(run.outcome, legwork::episode::Outcome::Completed, "{sets:?}: {:?}", run.reason);
    }
    let run = common::run("walk", &["ground.slope_deg=3", "ground.known=false"]);
    assert_eq!(run.outcome, legwork::episode::Outcome::Completed, "{:?}", run.reason);
}

#[test]
fn every_built_in_scenario_on_rigid_ground_keeps_the_books() {
    for name in library::scenario_names() {
        let scenario = scenario_file::load(name, &[]).expect("a built-in scenario").scenario;
        let run = common::run(name, &[]);
        if scenario.simulation.contact.model == ContactModel::Rigid {
            assert_eq!(run.violations(), Vec::<String>::new(), "{name}");
        }
    }
}

#[test]
fn control_and_physics_rates_are_separate() {
    for (control, physics) in [("0.001", "0.00025"), ("0.002", "0.001"), ("0.002", "0.002")] {
        let run = common::run(
            "walk",
            &["duration_s=4", &format!("controller.period_s={control}"), &format!("simulation.period_s={physics}")],
        );
        assert_eq!(run.outcome, legwork::episode::Outcome::Completed, "{control}/{physics}: {:?}", run.reason);
        let ticks = (4.0 / control.parse::<f64>().expect("a number")).round() as usize;
        assert_eq!(run.log.len(), ticks);
        assert!((run.metrics.mean_speed_mps - 0.5).abs() < 0.02);
    }
}

#[test]
fn the_controller_knows_another_robot_than_is_simulated() {
    let run = |sets: &[&str]| common::run("feet-walk", sets);
    let ideal = run(&["duration_s=2"]);
    assert_eq!(ideal.result_hash, run(&["duration_s=2", "simulation.model_error=0", "seed=5"]).result_hash);
    assert_eq!(ideal.model, ideal.known);

    let walk = run(&["simulation.model_error=0.02", "seed=5"]);
    assert_eq!(walk.outcome, legwork::episode::Outcome::Completed, "{:?}", walk.reason);
    assert_eq!(walk.known, ideal.known);
    assert!((walk.model.total_mass() / walk.known.total_mass() - 1.0).abs() <= 0.02 + 1e-12);
    assert_eq!(walk.violations(), Vec::<String>::new());
    let short = |seed: &str| run(&["duration_s=0.5", "simulation.model_error=0.02", seed]).result_hash;
    assert_eq!(short("seed=5"), short("seed=5"));
    assert_ne!(short("seed=5"), short("seed=6"));
}

/// At rest the ground carries the weight of the robot that stands on it, whatever the program believes.
#[test]
fn the_ground_carries_the_true_weight_and_the_program_is_mistaken() {
    let stand = |error: &str| {
        let error = format!("simulation.model_error={error}");
        let run = common::run("feet-walk", &["duration_s=4", "reference.walker.speed_mps=0", "seed=1", &error]);
        let last = run.log.len() - 1;
        let vertical = |field| run.log.get(last, field).iter().skip(1).step_by(2).sum::<f64>();
        let weight = run.model.total_mass() * run.model.gravity;
        (vertical(Field::GrfSimulated) - weight, vertical(Field::Grf) - vertical(Field::GrfSimulated))
    };
    let ((ideal, predicted), (real, mistaken)) = (stand("0"), stand("0.05"));
    assert!(ideal.abs() < 0.01 && real.abs() < 0.01, "{ideal} N, {real} N");
    assert!(predicted.abs() < 1e-3 && mistaken.abs() > 0.1, "{predicted} N, {mistaken} N");
}

#[test]
fn sensors_and_actuators_are_ideal_unless_asked() {
    let ideal = common::run("walk", &["duration_s=2"]);
    let log = &ideal.log;
    let (wanted, applied) = (log.range(Field::Torque), log.range(Field::TorqueApplied));
    assert!(log.records().all(|record| record[wanted.clone()] == record[applied.clone()]));
    // A lag of 5 ms: the applied torque follows the wanted one exponentially, step by step.
    let lagging = common::run("stand", &["duration_s=0.2", "simulation.actuators.lag_s=0.005"]);
    let log = &lagging.log;
    let share = 1.0 - (-1e-3_f64 / 5e-3).exp();
    for i in 1..log.len() {
        let (before, now) = (log.get(i - 1, Field::TorqueApplied)[0], log.get(i, Field::TorqueApplied)[0]);
        let wanted = log.get(i, Field::Torque)[0];
        assert!((now - (before + share * (wanted - before))).abs() < 1e-9);
    }
}

#[test]
fn what_is_late_is_what_it_was_that_long_before_to_the_bit() {
    // Two physics steps in a control period: a torque counts from the next step on.
    for (delay, ticks) in [("0.002", 2), ("0.0025", 2), ("0.003", 3)] {
        let set = format!("simulation.actuators.delay_s={delay}");
        let run = common::run("push", &["duration_s=1.3", "simulation.period_s=0.0005", &set]);
        for i in 0..run.log.len() {
            let wanted = run.log.get(i.saturating_sub(ticks), Field::Torque);
            assert_eq!(run.log.get(i, Field::TorqueApplied), wanted, "{delay} s, tick {i}");
        }
    }
    let sets = ["duration_s=1.3", "simulation.sensors.delay_s=0.003", "simulation.sensors.load_delay_s=0.002"];
    let (mut truths, mut told) = (Vec::new(), Vec::new());
    watch("push", &sets, |truth, estimate| {
        truths.push(truth.clone());
        told.push(estimate.clone());
    });
    for (i, told) in told.iter().enumerate() {
        let (then, forces) = (&truths[i.saturating_sub(3)], &truths[i.saturating_sub(5)]);
        assert_eq!((told.time, &told.q, &told.v), (truths[i].time, &then.q, &then.v), "tick {i}");
        for (foot, contact) in told.contacts.iter().enumerate() {
            assert_eq!(contact.touching, then.contacts[foot].touching, "tick {i}");
            assert_eq!(contact.load, forces.contacts[foot].load, "tick {i}");
        }
    }
    assert!(truths[0].contacts != truths[1299].contacts && truths[1299].v.iter().all(|v| *v != 0.0));
}

/// The deviations are normal with the given standard deviation: of n samples it is found to σ / √(2 n), their mean to σ / √n.
#[test]
fn noise_has_its_standard_deviation() {
    let sets = ["duration_s=1", "simulation.sensors.position_noise=1e-5", "simulation.sensors.velocity_noise=2e-4"];
    let mut deviations = [Vec::new(), Vec::new()];
    watch("stand", &sets, |truth, told| {
        deviations[0].extend(told.q.iter().zip(&truth.q).map(|(told, truth)| told - truth));
        deviations[1].extend(told.v.iter().zip(&truth.v).map(|(told, truth)| told - truth));
    });
    for (deviations, sigma) in deviations.iter().zip([1e-5, 2e-4]) {
        let n = deviations.len() as f64;
        assert_eq!(n, 7000.0);
        let mean = deviations.iter().sum::<f64>() / n;
        let found = (deviations.iter().map(|value| value * value).sum::<f64>() / n).sqrt();
        assert!(mean.abs() < 4.0 * sigma / n.sqrt(), "{mean}");
        assert!((found - sigma).abs() < 4.0 * sigma / (2.0 * n).sqrt(), "{found} instead of {sigma}");
    }
}

/// Which of a joint's limits are given decides nothing where the robot is far from them.
#[test]
fn a_joint_with_one_limit_only_made_infinite_poses_or_a_false_refusal() {
    for name in ["walk", "feet-walk", "exo-sway"] {
        let scenario = scenario_file::load(name, &["duration_s=0.05".to_owned()]).expect("built in").scenario;
        let whole = library::load_model(&scenario.model, None).expect("built in");
        let run = |model: &Robot| {
            let run = legwork::episode::run(&scenario, model, &[], |_| false).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(run.outcome, legwork::episode::Outcome::Completed, "{name}: {:?}", run.reason);
            assert!(run.log.records().flatten().all(|value| value.is_finite()), "{name}");
            run.log.get(0, Field::Q).to_vec()
        };
        let expected = run(&whole);
        for joint in whole.actuated() {
            for (keeps_lower, keeps_upper) in [(true, false), (false, true), (false, false)] {
                let mut model = whole.clone();
                let dof = &mut model.dofs[joint];
                if !keeps_lower {
                    dof.lower = f64::NEG_INFINITY;
                }
                if !keeps_upper {
                    dof.upper = f64::INFINITY;
                }
                let (what, found) = (format!("{name}, {}", dof.name), run(&model));
                let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // Where a limit is missing the joint may bend the other way.
                let (whole, at) = (&whole.dofs[joint], found[whole.bodies[whole.dofs[joint].body].q_index]);
                assert!(apart < 1e-6 || !(whole.lower..=whole.upper).contains(&at), "{what}: {apart}");
            }
        }
    }
}
