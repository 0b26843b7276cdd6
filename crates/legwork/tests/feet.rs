//! Walking on feet: speeds, starting, stopping, stepping in place, backward, on ice, and what the program is told.

mod common;

use legwork::episode::{Outcome, Run};
use legwork::feet::{FeetMotion, Footing};
use legwork::log::Field;
use legwork::{episode, library, scenario_file};
use legwork_rbd::Dynamics;

/// The place along x of the centre of mass at `time` [s].
fn com(run: &Run, time: f64) -> f64 {
    run.log.get((time * 1e3).round() as usize, Field::Com)[0]
}

/// Mean of the distance of XcoM and reference from `time` [s] on [m].
fn xcom_error(run: &Run, time: f64) -> f64 {
    let ticks = (time * 1e3) as usize..run.log.len();
    let error = |tick| (run.log.get(tick, Field::Xcom)[0] - run.log.get(tick, Field::Balance)[1]).abs();
    ticks.clone().map(error).sum::<f64>() / ticks.len() as f64
}

fn stood(run: &Run) {
    assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
    assert_eq!(run.violations(), Vec::<String>::new());
}

#[test]
fn one_set_of_settings_walks_at_three_speeds() {
    for speed in [0.5, 1.0, 1.25] {
        let run = common::run("feet-walk", &[&format!("reference.walker.speed_mps={speed}"), "duration_s=9"]);
        stood(&run);
        let measured = (com(&run, 8.9) - com(&run, 4.9)) / 4.0;
        assert!((measured / speed - 1.0).abs() < 0.04, "{measured} m/s for {speed}");
        assert!(xcom_error(&run, 4.0) < 0.012, "{} m at {speed} m/s", xcom_error(&run, 4.0));
        let swinging = (4000..run.log.len()).filter(|&tick| run.log.get(tick, Field::Swing)[0] >= 0.0).count();
        let single = swinging as f64 / (run.log.len() - 4000) as f64;
        assert!((0.75..0.85).contains(&single), "single support {single} at {speed} m/s");
    }
}

#[test]
fn it_starts_stops_and_stands() {
    let speeds = "reference.walker.speeds=[[0.0,0.0],[1.0,0.0],[1.5,0.8],[4.0,0.8],[5.0,0.0]]";
    let run = common::run("feet-walk", &[speeds, "duration_s=11"]);
    stood(&run);
    let swing = |time: f64| run.log.get((time * 1e3) as usize, Field::Swing)[0];
    assert!((0..9).all(|k| swing(0.1 * f64::from(k)) < 0.0), "it stands until it is told to go");
    assert!((com(&run, 4.0) - com(&run, 3.0) - 0.8).abs() < 0.08, "{} m in a second", com(&run, 4.0) - com(&run, 3.0));
    assert!((0..10).all(|k| swing(10.0 + 0.099 * f64::from(k)) < 0.0), "it stands in the end");
    assert!((com(&run, 10.9) - com(&run, 10.0)).abs() < 0.01);
}

#[test]
fn a_live_command_is_followed_as_a_profile_is() {
    let loaded =
        scenario_file::load("feet-walk", &["reference.walker.speed_mps=0".to_owned(), "duration_s=13".to_owned()])
            .expect("built in");
    let model = library::load_model("planar_humanoid_feet", None).expect("built in");
    let mut episode = episode::Episode::new(&loaded.scenario, &model, &[]).expect("it can start");
    for (until, speed) in [(1.0, 0.0), (6.0, 0.8), (13.0, 0.0)] {
        episode.set("reference.walker.speed_mps", &speed.to_string()).expect("a speed that legs can walk");
        while episode.time() < until && episode.advance().expect("nothing that could fail") {}
    }
    for wrong in ["nan", "2.4", "fast"] {
        let error = episode.set("reference.walker.speed_mps", wrong).expect_err("no walk").to_string();
        assert!(error.contains("reference.walker.speed_mps"), "{error}");
    }
    let live = episode.finish(0.0).expect("nothing that could fail");
    stood(&live);
    let profile = "reference.walker.speeds=[[0,0],[1,0],[1.000001,0.8],[6,0.8],[6.000001,0]]";
    let planned = common::run("feet-walk", &[profile]);
    assert!((com(&live, 5.0) - com(&planned, 5.0)).abs() < 0.05 && com(&live, 5.0) > 2.5, "{}", com(&live, 5.0));
    assert!((com(&live, 12.9) - com(&live, 12.0)).abs() < 0.02, "it stands again");
}

#[test]
fn it_steps_in_place_and_walks_backward() {
    let march =
        common::run("feet-walk", &["reference.walker.speed_mps=0", "reference.walker.march=true", "duration_s=6"]);
    stood(&march);
    assert!(
        march.metrics.steps >= Some(7) && (com(&march, 5.9) - com(&march, 1.0)).abs() < 0.05,
        "{:?}",
        march.metrics.steps
    );
    let back = common::run("feet-walk", &["reference.walker.speed_mps=-0.3", "duration_s=8"]);
    stood(&back);
    let speed = (com(&back, 7.9) - com(&back, 3.9)) / 4.0;
    assert!((speed + 0.3).abs() < 0.03, "{speed} m/s");
}

#[test]
fn it_stands_without_stepping_when_told_to() {
    let run = common::run("feet-walk", &["reference.walker.speed_mps=0", "duration_s=4"]);
    stood(&run);
    assert_eq!(run.metrics.steps, Some(0));
    assert!(run.metrics.feet_error_m.expect("it is measured").peak < 2e-3, "{:?}", run.metrics.feet_error_m);
}

#[test]
fn the_rear_foot_hands_its_load_over_and_rolls_over_its_toe() {
    let run = common::run("feet-walk", &["duration_s=6"]);
    stood(&run);
    // In the middle of double support the rear heel is up and only its toe is loaded.
    let (mut seen, width) = (0, 2);
    for tick in 4000..run.log.len() - 50 {
        let begins = run.log.get(tick, Field::Swing)[0] < 0.0 && run.log.get(tick - 1, Field::Swing)[0] >= 0.0;
        if !begins {
            continue;
        }
        seen += 1;
        let (landed, middle) = (run.log.get(tick - 1, Field::Swing)[0] as usize, tick + 40);
        let rear = 1 - landed;
        let feet = run.log.get(middle, Field::Feet);
        let [heel, toe] = [0, 1].map(|point| feet[(2 * rear + point) * width + 1]);
        assert!(heel > 0.05 && toe.abs() < 3e-3, "heel {heel} m, toe {toe} m");
        assert_eq!(run.log.get(middle, Field::Grf)[2 * rear * width + 1], 0.0, "no force at the heel");
    }
    assert!(seen >= 2, "{seen} landings");
}

#[test]
fn slack_and_direct_form_are_one_program_on_feet_too() {
    let sets = |form: &'static str| ["duration_s=1.5", form];
    let (direct, slack) = (
        common::run("feet-walk", &sets("controller.form=direct")),
        common::run("feet-walk", &sets("controller.form=slack")),
    );
    stood(&slack);
    let last = direct.log.len() - 1;
    for (a, b) in direct.log.get(last, Field::Q).iter().zip(slack.log.get(last, Field::Q)) {
        assert!((a - b).abs() < 1e-5, "{a} and {b}");
    }
}

#[test]
fn a_foot_on_its_toe_is_where_its_toe_is() {
    let model = library::load_model("planar_humanoid_feet", None).expect("built in");
    let mut dynamics = Dynamics::new(&model);
    let q: Vec<f64> = (0..model.nq()).map(|k| 0.1 + 0.07 * k as f64).collect();
    let v: Vec<f64> = (0..model.nv()).map(|k| 0.3 - 0.11 * k as f64).collect();
    dynamics.update(&model, &q, &v);
    let mut feet = FeetMotion::new(&model);
    feet.update(&model, &dynamics);
    let centre = 0.5 * (dynamics.contact_positions[0] + dynamics.contact_positions[1]);
    assert!((feet.position[0] - centre).norm() < 1e-14);
    feet.place(&model, &dynamics, 0, Footing::Rolls);
    assert_eq!(feet.position[0], dynamics.contact_positions[1], "right heel, right toe");
    assert_eq!(feet.velocity[0], dynamics.contact_velocities[1]);
    let velocity: Vec<f64> =
        feet.rows(0).linear.clone().map(|row| (0..model.nv()).map(|j| feet.jacobian[(row, j)] * v[j]).sum()).collect();
    assert!((velocity[0] - feet.velocity[0].x).abs() + (velocity[1] - feet.velocity[0].z).abs() < 1e-13);
}

#[test]
fn the_walk_on_feet_is_not_for_point_feet() {
    let sets = ["model=planar_humanoid".to_owned(), "start.com_height_m=0.885".to_owned()];
    let loaded = scenario_file::load("feet-walk", &sets).expect("a valid file");
    let model = library::load_model("planar_humanoid", None).expect("built in");
    let error = episode::run(&loaded.scenario, &model, &[], |_| false).expect_err("it has no heel");
    assert!(error.to_string().contains("each with a heel and a toe"), "{error}");
}

#[test]
fn it_is_pushed_while_walking_and_while_standing() {
    for name in ["push-walking", "stand-push"] {
        let run = common::run(name, &[]);
        stood(&run);
    }
    let run = common::run("stand-push", &[]);
    assert!(run.metrics.steps > Some(0), "50 Ns are more than the feet can hold");
    let last = run.log.len() - 1;
    assert!(run.log.get(last, Field::Swing)[0] < 0.0 && run.log.get(last, Field::ComVelocity)[0].abs() < 0.01);
}

#[test]
fn one_run_goes_from_standing_to_full_speed_and_back_and_backward() {
    let run = common::run("stop-and-go", &[]);
    stood(&run);
    let speed = |from: f64, to: f64| (com(&run, to) - com(&run, from)) / (to - from);
    assert!(speed(7.5, 9.0) > 1.1, "{} m/s", speed(7.5, 9.0));
    assert!(speed(16.0, 17.0).abs() < 0.02 && speed(17.5, 19.5) < -0.15 && speed(23.0, 23.9).abs() < 0.02);
}

#[test]
fn other_people_walk_with_the_same_settings() {
    for (mass, height) in [(55.0, 1.6), (95.0, 1.9), (110.0, 1.75)] {
        let sets = [format!("wearer.mass_kg={mass}"), format!("wearer.height_m={height}")];
        let loaded = scenario_file::load("feet-walk", &sets).expect("valid");
        let model = loaded.model().expect("built in");
        assert!((model.total_mass() - mass).abs() < 1e-9);
        let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can start");
        stood(&run);
    }
}

/// Masses at the legs bring the centre of mass nearer to the hip; held at the height of the person alone it asked for more leg than
/// there is, and the robot stumbled.
#[test]
fn an_exoskeleton_does_not_stretch_the_legs() {
    let worn = ["torso_kg=8", "thigh_kg=3", "shank_kg=1.5", "foot_kg=0.5"].map(|set| format!("exoskeleton.{set}"));
    let mut sets: Vec<&str> = worn.iter().map(String::as_str).collect();
    sets.extend(["reference.walker.speed_mps=0.5", "duration_s=8"]);
    let run = common::run("feet-walk", &sets);
    stood(&run);
    let peak = |field| {
        (0..run.log.len()).flat_map(|i| run.log.get(i, field)).fold(0.0, |most: f64, value| most.max(value.abs()))
    };
    assert!(peak(Field::TorqueApplied) < 180.0 && peak(Field::GrfSimulated) < 1200.0);
}

/// A heel-off that a step either has or has not is a border which steps at 0.35 m/s cross to and fro.
#[test]
fn a_heel_off_by_degrees_walks_smoothly_where_steps_begin_to_have_one() {
    for speed in ["0.35", "0.36"] {
        let degrees = ["reference.walker.heel_off_from_m=0.15", "reference.walker.heel_off_full_m=0.25"];
        let run = common::run("feet-walk", &[&format!("reference.walker.speed_mps={speed}"), degrees[0], degrees[1]]);
        stood(&run);
        let peak = |field| {
            (0..run.log.len()).flat_map(|i| run.log.get(i, field)).fold(0.0, |most: f64, value| most.max(value.abs()))
        };
        assert!(peak(Field::TorqueApplied) < 150.0 && peak(Field::GrfSimulated) < 1200.0, "{speed} m/s");
    }
}

#[test]
fn a_torque_changes_no_faster_than_its_rate() {
    let run = common::run("feet-walk", &["controller.limits.torque_rate_nmps=2e4", "duration_s=5"]);
    stood(&run);
    let torques = |tick: usize| run.log.get(tick, Field::Torque);
    let changes =
        (1..run.log.len()).flat_map(|tick| torques(tick).iter().zip(torques(tick - 1)).map(|(a, b)| (a - b).abs()));
    let most = changes.fold(0.0, f64::max);
    assert!(most <= 20.0 + 1e-9 && most > 10.0, "{most} Nm in a tick");
}

#[test]
fn what_no_leg_and_no_ground_could_bear_is_refused() {
    for (set, expected) in [
        ("reference.walker.speed_mps=2.4", "m; the longest are 1.1 m"),
        ("reference.walker.speeds=[[0,0],[1,0.5],[1,0.6]]", "row 2: valid are times that increase"),
        ("reference.walker.schedule=[]", "found no row"),
        (
            "reference.walker.schedule=[[0,0.6,0.98,0,0.1,0.1],[0,0.6,0.98,0,0.1,0.1]]",
            "row 1: valid are speeds that increase",
        ),
        ("reference.walker.schedule=[[0,0.25,0.98,0,0.1,0.1]]", "row 0: a step of 0.25 s"),
        ("ground.slope_deg=45", "a slope of 45 deg needs a friction of 1.000"),
        ("wearer.mass_kg=500", "found 500"),
    ] {
        let error = scenario_file::load("feet-walk", &[set.to_owned()]).expect_err(set);
        assert!(error.to_string().contains(expected), "{set}: {error}");
    }
    let mut model = library::load_model("planar_humanoid_feet", None).expect("built in");
    model.contacts.iter_mut().for_each(|contact| contact.position.z = 0.05);
    let loaded = scenario_file::load("feet-walk", &[]).expect("built in");
    let error = episode::run(&loaded.scenario, &model, &[], |_| false).expect_err("the sole is above the ankle");
    assert!(error.to_string().contains("both below it"), "{error}");
    // One point alone, and a sole that is not level or longer than the other.
    for (name, [x, z]) in [("right_heel", [-0.065, 0.02]), ("left_toe", [0.185, -0.09]), ("left_toe", [0.2, -0.06825])]
    {
        let mut model = library::load_model("planar_humanoid_feet", None).expect("built in");
        let contact = model.contacts.iter_mut().find(|contact| contact.name == name).expect("it has it");
        (contact.position.x, contact.position.z) = (x, z);
        let error = episode::run(&loaded.scenario, &model, &[], |_| false).expect_err(name).to_string();
        assert!(error.contains("contact point") && error.contains("from its ankle"), "{name}: {error}");
    }
    for set in ["reference.walker.leg_m=0.3", "reference.walker.schedule=[[0,0.6,3,0,0.1,0.1]]"] {
        let loaded = scenario_file::load("feet-walk", &[set.to_owned()]).expect("each value is valid");
        let model = library::load_model("planar_humanoid_feet", None).expect("built in");
        let error = episode::run(&loaded.scenario, &model, &[], |_| false).expect_err(set).to_string();
        assert!(error.contains("no leg of leg_m"), "{set}: {error}");
    }
}

#[test]
fn it_walks_up_and_down_a_known_slope() {
    for (slope, speed) in [(5.0, 0.5), (-8.0, 0.5), (8.0, 1.0), (-8.0, 1.0), (5.0, 1.25)] {
        let sets = [format!("ground.slope_deg={slope}"), format!("reference.walker.speed_mps={speed}")];
        let run = common::run("feet-walk", &sets.each_ref().map(String::as_str));
        // Uphill a toe lands hard; the audit says so (docs/walking.md).
        assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
        let measured = (com(&run, 9.9) - com(&run, 5.9)) / 4.0;
        assert!(measured > 0.8 * speed, "{measured} m/s on {slope} deg");
    }
}

/// A run at `speed` [m/s] in which the centre of mass is pushed by `impulse` [Ns], forward if positive, for 0.2 s.
fn pushed(speed: f64, impulse: f64, start: f64, more: &[&str]) -> Run {
    let (force, direction) = (impulse.abs() / 0.2, if impulse > 0.0 { 0 } else { 180 });
    let push = format!("pushes=[{{force_n={force},direction_deg={direction},start_s={start},duration_s=0.2}}]");
    let speed = format!("reference.walker.speed_mps={speed}");
    let duration = format!("duration_s={}", start + 4.2);
    common::run("feet-walk", &[&[push.as_str(), &speed, &duration], more].concat())
}

#[test]
fn it_survives_pushes_at_any_time_of_a_step() {
    for (speed, step_time, forward, backward) in
        [(1.0, 0.571, 85.0, 90.0), (0.5, 0.523, 90.0, 90.0), (1.25, 0.522, 70.0, 80.0)]
    {
        for (phase, impulse) in (0..4).flat_map(|k| [(0.25 * f64::from(k), forward), (0.25 * f64::from(k), -backward)])
        {
            let run = pushed(speed, impulse, 4.0 + phase * step_time, &[]);
            let reason = &run.reason;
            assert_eq!(run.outcome, Outcome::Completed, "{speed} m/s, {impulse} Ns at {phase} of a step: {reason:?}");
        }
    }
}

#[test]
fn ankles_hips_and_steps_keep_the_balance_whichever_is_needed() {
    let leans = |run: &Run| {
        let reference = |tick: usize| run.log.get(tick, Field::TorsoReference)[0];
        (0..run.log.len()).map(|tick| (reference(tick) - reference(0)).abs()).fold(0.0, f64::max)
    };
    let no_hip = "reference.walker.hip_shift_m=0";
    for side in [1.0, -1.0] {
        let small = pushed(0.0, 8.0 * side, 1.0, &[]);
        assert!(small.metrics.steps == Some(0) && leans(&small) == 0.0, "the ankles suffice: {}", leans(&small));
        let middle = if side > 0.0 { 34.0 } else { 42.0 };
        let hip = pushed(0.0, middle * side, 1.0, &[]);
        assert!(hip.metrics.steps == Some(0) && leans(&hip) > 0.02, "{:?} steps, {}", hip.metrics.steps, leans(&hip));
        assert_eq!(hip.outcome, Outcome::Completed);
        assert!(pushed(0.0, middle * side, 1.0, &[no_hip]).metrics.steps > Some(0), "without the hips it steps");
        let large = pushed(0.0, 80.0 * side, 1.0, &[]);
        assert!(large.outcome == Outcome::Completed && large.metrics.steps > Some(0), "{:?}", large.reason);
    }
}

/// Each figure again, from the log's records of the last four seconds.
#[test]
fn figures_count_from_the_time_that_is_asked_for() {
    let run = common::run("feet-walk", &["metrics.from_s=6"]);
    let (log, metrics) = (&run.log, &run.metrics);
    let late: Vec<usize> = (0..log.len()).filter(|&index| log.time(index) > 5.9995).collect();
    assert_eq!(late.len(), 4000);
    let mean = |of: &dyn Fn(usize) -> f64| late.iter().map(|&index| of(index)).sum::<f64>() / late.len() as f64;
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} and {b}");
    close(
        metrics.u2_n2m2.expect("it is measured").mean,
        mean(&|index| log.get(index, Field::Torque).iter().map(|t| t * t).sum()),
    );
    close(
        metrics.single_support_fraction.expect("it is measured"),
        mean(&|index| f64::from(u8::from(log.get(index, Field::Swing)[0] >= 0.0))),
    );
    close(metrics.mean_speed_mps, (com(&run, 9.999) - com(&run, 6.0)) / 3.999);
    let knee = late.iter().map(|&index| log.get(index, Field::TorqueApplied)[1].abs()).fold(0.0, f64::max);
    assert_eq!((metrics.joints[1].joint.as_str(), metrics.joints[1].torque_peak_nm), ("right_knee", knee));
    let begun = |pair: &&[usize]| log.get(pair[1], Field::Swing)[1] > log.get(pair[0], Field::Swing)[1].max(5.9995);
    let indices: Vec<usize> = (0..log.len()).collect();
    assert_eq!(metrics.steps.expect("it is measured") as usize, indices.windows(2).filter(begun).count());

    let whole = common::run("feet-walk", &["duration_s=3"]);
    let ended = common::run("feet-walk", &["duration_s=3", "metrics.from_s=6"]);
    assert_eq!(ended.metrics.u2_n2m2, whole.metrics.u2_n2m2);
    assert!(whole.metrics.mean_speed_mps < 0.95, "it starts from standing");
    assert!((metrics.mean_speed_mps - 1.0).abs() < 0.02);
}
