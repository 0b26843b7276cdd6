//! Settings that are stated for one robot and scaled to another: robots of one shape move alike, whatever their size and gravity.

use legwork::channel::Field;
use legwork::episode::{self, Outcome, Run};
use legwork::fit::{Fit, Size, fitted};
use legwork::{Robot, library, scenario_file};

/// A robot of the shape of `model`: its mass, its lengths and its gravity times these. Speeds of joints follow, and torques.
fn sized(model: &Robot, [mass, length, gravity]: [f64; 3]) -> Robot {
    let mut model = model.clone();
    for body in &mut model.bodies {
        body.placement.translation *= length;
        body.mass *= mass;
        body.com *= length;
        body.inertia *= mass * length * length;
    }
    for contact in &mut model.contacts {
        contact.position *= length;
    }
    model.gravity *= gravity;
    for dof in &mut model.dofs {
        dof.effort_limit *= mass * length * gravity;
        dof.velocity_limit *= (gravity / length).sqrt();
        dof.damping *= mass * length * length * (gravity / length).sqrt();
        dof.stiffness *= mass * length * gravity;
        dof.stop_stiffness *= mass * length * gravity;
        dof.stop_damping *= mass * length * length * (gravity / length).sqrt();
    }
    model
}

/// Runs a built-in scenario, whose settings are for its own model, for so many ticks with that model at another size.
fn run(name: &str, size: [f64; 3], ticks: u32, sets: &[&str]) -> Run {
    let loaded =
        scenario_file::load(name, &sets.iter().map(|&set| set.to_owned()).collect::<Vec<_>>()).expect("built in");
    let (mut scenario, model) = (loaded.scenario.clone(), loaded.model().expect("built in"));
    scenario.fit = match scenario.model.as_str() {
        "exo18" => Fit::Exo18,
        "planar_humanoid" => Fit::PlanarHumanoid,
        _ => Fit::PlanarHumanoidFeet,
    };
    // The computer's own times do not scale by themselves.
    let time = (size[1] / size[2]).sqrt();
    scenario.controller.period_s *= time;
    scenario.simulation.period_s *= time;
    scenario.duration_s = f64::from(ticks) * scenario.controller.period_s;
    episode::run(&scenario, &sized(&model, size), &[], |_| false).expect("it starts")
}

/// Positions of all joints that turn, in a record.
fn angles(run: &Run, index: usize) -> Vec<f64> {
    let joints = run.model.dofs.iter().filter(|dof| dof.actuated && dof.rotational);
    joints.map(|dof| run.log.get(index, Field::Q)[run.model.bodies[dof.body].q_index]).collect()
}

#[test]
fn robots_of_one_shape_move_alike_in_their_own_time() {
    let sizes = [[1.0 / 3.0, 0.6, 1.0], [2.0, 1.3, 1.0], [1.0, 1.0, 0.165]];
    // Landings of the walker fall into ticks, and small terms of the cost add metres to radians. Of feet side by side rounding would choose
    // the one that swings first.
    let apart = ["start.right_foot_x_m=-0.01"];
    let scenarios = [
        ("feet-walk", 2500, 0.03),
        ("stand-push", 1500, 0.03),
        ("exo-sway", 3500, 2e-3),
        ("exo-lift", 3000, 2e-3),
        ("walk", 1000, 0.03),
    ];
    for (name, ticks, bound) in scenarios {
        let own = run(name, [1.0; 3], ticks, &apart);
        for size in sizes {
            let other = run(name, size, ticks, &apart);
            assert_eq!(other.outcome, Outcome::Completed, "{name} {size:?}: {:?}", other.reason);
            let off = |i: usize| {
                let pairs = angles(&own, i).into_iter().zip(angles(&other, i));
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let off = (0..own.log.len()).map(off).fold(0.0, f64::max);
            assert!(off < bound, "{name} {size:?}: {off} rad");
            let torque = |run: &Run| run.metrics.torque_nm.expect("it has torques").mean;
            let ratio = torque(&other) / torque(&own) / (size[0] * size[1] * size[2]);
            assert!((ratio - 1.0).abs() < 0.02, "{name} {size:?}: torques {ratio}");
        }
    }
}

#[test]
fn a_robot_that_the_settings_are_for_is_not_scaled_by_a_bit() {
    for (name, fit) in [("exo-sway", Fit::Exo18), ("feet-walk", Fit::PlanarHumanoidFeet), ("walk", Fit::PlanarHumanoid)]
    {
        let loaded = scenario_file::load(name, &[]).expect("built in");
        let mut scenario = loaded.scenario.clone();
        scenario.fit = fit;
        let mut same = fitted(&scenario, &loaded.model().expect("built in")).expect("it has legs");
        assert_eq!(same.fit, Fit::Done);
        same.fit = Fit::None;
        assert_eq!(same, loaded.scenario, "{name}");
    }
}

#[test]
fn values_scale_as_their_units_say() {
    let loaded = scenario_file::load("exo-lift", &["fit=exo18".into()]).expect("built in");
    let model = sized(&loaded.model().expect("built in"), [0.5, 0.25, 1.0]);
    let (before, after) = (&loaded.scenario, fitted(&loaded.scenario, &model).expect("it has legs"));
    // M = 1/2, L = 1/4, hence T = 1/2.
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found}, not {expected}");
    near(after.controller.planner.com_gain, before.controller.planner.com_gain * 0.5 / 0.25);
    near(after.controller.planner.foot_gain, before.controller.planner.foot_gain * 4.0);
    near(after.controller.limits.torque_nm, before.controller.limits.torque_nm * 0.5 * 0.25);
    near(after.controller.limits.grf_n, before.controller.limits.grf_n * 0.5);
    near(after.reference.stance.period_s, before.reference.stance.period_s * 0.5);
    near(after.reference.stance.lift_height_m, before.reference.stance.lift_height_m * 0.25);
    near(after.start.com_height_m, before.start.com_height_m * 0.25);
    near(after.reference.walker.schedule[1][0], before.reference.walker.schedule[1][0] * 0.5);
    near(after.reference.walker.schedule[1][2], before.reference.walker.schedule[1][2] * 0.25);
    assert_eq!(after.controller.limits.torque_rate_nmps, before.controller.limits.torque_rate_nmps);
    assert_eq!((after.controller.period_s, after.simulation.period_s), (0.001, 0.001));
}

#[test]
fn feet_stand_below_hips_and_knees_bend_as_they_did() {
    let loaded = scenario_file::load("exo-sway", &["fit=exo18".into()]).expect("built in");
    let exo = loaded.model().expect("built in");
    let mut other = exo.clone();
    for body in &mut other.bodies {
        body.placement.translation.y *= 1.5;
    }
    let torso = other.torso;
    other.bodies[torso].com.z += 0.1;
    let (before, after) = (Size::of(&exo).expect("legs"), Size::of(&other).expect("legs"));
    let settings = fitted(&loaded.scenario, &other).expect("it has legs").start;
    assert!((settings.feet_width_m - 1.5 * loaded.scenario.start.feet_width_m).abs() < 1e-9);
    let higher = 0.1 * other.bodies[torso].mass / other.total_mass();
    assert!((after.com_above_hips - before.com_above_hips - higher).abs() < 1e-9 && after.leg == before.leg);
    assert!((settings.com_height_m - loaded.scenario.start.com_height_m - higher).abs() < 1e-9);
}

#[test]
fn a_robot_without_a_given_height_stands_on_legs_a_little_bent() {
    let text = "model = \"none.toml\"\nduration_s = 0.2\n[reference]\ngenerator = \"stance\"\n[start]\nleft_foot_x_m = 0.0\ncom_x_m = 0.0\n";
    let loaded = scenario_file::parse(text, "own.toml", None, &[]).expect("valid");
    let mut model = library::load_model("exo18", None).expect("built in");
    model.name = "another".into();
    let size = Size::of(&model).expect("legs");
    let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it starts");
    let height = run.scenario.start.com_height_m;
    assert!((height - size.com_above_hips - 0.95 * size.leg).abs() < 1e-12, "{height}");
    let given = scenario_file::parse(&text.replace("com_x_m", "com_height_m = 0.9\ncom_x_m"), "own.toml", None, &[]);
    assert_eq!(given.expect("valid").scenario.start.com_height_m, 0.9);
}
