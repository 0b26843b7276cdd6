//! Uneven ground: the same physics as on a slope, walking over it seen and unseen, patches that hold less.

mod common;

use legwork::episode::{Outcome, Run};
use legwork::log::Field;
use legwork::scenario_file;

/// Largest difference of a field between two runs.
fn apart(a: &Run, b: &Run, field: Field) -> f64 {
    assert_eq!(a.log.len(), b.log.len());
    let of = |i: usize| a.log.get(i, field).iter().zip(b.log.get(i, field)).map(|(a, b)| (a - b).abs());
    (0..a.log.len()).flat_map(of).fold(0.0, f64::max)
}

/// The ramp's contact directions are turned against those of its level plane; the slope's are its plane's own. Robots that
/// stand still as long as nothing pushes them, so that references do not differ.
#[test]
fn a_ramp_is_a_slope() {
    let rise = 20.0 * 4f64.to_radians().tan();
    let ramp = format!("ground.profile=[[-20,{:?}],[20,{rise:?}]]", -rise);
    for (scenario, more) in [("stand", "pushes=[{force_n=400,start_s=0.2,duration_s=0.2}]"), ("exo-sway", "seed=0")] {
        let common = ["duration_s=2", more];
        let slope = common::run(scenario, &[&common[..], &["ground.slope_deg=4"]].concat());
        let ramp = common::run(scenario, &[&common[..], &[&ramp, "ground.relief_known=true"]].concat());
        assert_eq!([&slope.outcome, &ramp.outcome], [&Outcome::Completed; 2], "{scenario}");
        assert_eq!(ramp.violations(), Vec::<String>::new());
        let apart = apart(&slope, &ramp, Field::Com);
        assert!(apart < 1e-6, "{scenario}: {apart} m");
    }
}

#[test]
fn it_walks_over_ground_that_it_does_not_see() {
    for (speed, seed) in [(0.5, 0), (0.5, 1), (1.0, 0), (1.0, 1)] {
        let run = common::run(
            "feet-walk",
            &[&format!("reference.walker.speed_mps={speed}"), "ground.unevenness_m=0.01", &format!("seed={seed}")],
        );
        assert_eq!(run.outcome, Outcome::Completed, "{speed} m/s, seed {seed}: {:?}", run.reason);
        assert_eq!(run.violations(), Vec::<String>::new());
        assert!(run.metrics.mean_speed_mps > 0.9 * speed);
    }
}

#[test]
fn slopes_that_nothing_tells_are_walked_at_the_commanded_speed() {
    let untold = |slope: i32| [format!("ground.slope_deg={slope}"), "ground.known=false".to_owned()];
    // As steep from 3 m on.
    let begins = |slope: i32| {
        let rise = 12.0 * f64::from(slope).to_radians().tan();
        [format!("ground.profile=[[3,0],[15,{rise:?}]]"), "ground.relief_known=false".to_owned()]
    };
    for (speed, ground) in [
        (0.5, untold(-8)),
        (1.0, untold(8)),
        (1.25, untold(-5)),
        (0.5, begins(5)),
        (0.5, begins(-5)),
        (1.0, begins(5)),
        (1.0, begins(-5)),
    ] {
        let set_speed = format!("reference.walker.speed_mps={speed}");
        let more = [&set_speed, "ground.unevenness_m=0.01", "seed=1", "metrics.from_s=4", &ground[0], &ground[1]];
        let run = common::run("feet-walk", &more);
        assert_eq!(run.outcome, Outcome::Completed, "{speed} m/s, {ground:?}: {:?}", run.reason);
        assert!(run.metrics.mean_speed_mps > 0.93 * speed, "{}", run.metrics.mean_speed_mps);
    }
}

#[test]
fn steps_that_it_sees_are_no_trouble() {
    let stairs = "ground.profile=[[1.5,0],[1.51,0.04],[3,0.04],[3.01,0.08],[5,0.08],[5.01,0.03]]";
    for speed in [0.5, 1.0] {
        let speed = format!("reference.walker.speed_mps={speed}");
        let run = common::run("feet-walk", &[&speed, stairs, "ground.relief_known=true"]);
        assert_eq!(run.outcome, Outcome::Completed, "{speed}: {:?}", run.reason);
    }
}

#[test]
fn a_patch_that_holds_less_is_slid_on_and_named() {
    let run = common::run("push", &["ground.patches=[[-1,3,0.1]]"]);
    assert!(matches!(run.outcome, Outcome::Fell(_)));
    let reason = run.reason.expect("a fall has one");
    assert!(reason.contains("slid") && reason.contains("friction 0.1, assumed to be 0.85"), "{reason}");
    // Told of it, the controller stays within the cone; elsewhere the ground holds as before.
    let told = common::run("push", &["ground.patches=[[-1,3,0.1]]", "ground.relief_known=true"]);
    assert!(told.reason.is_none_or(|reason| !reason.contains("slid")));
    let away = common::run("push", &["ground.patches=[[50,60,0.1]]"]);
    assert_eq!(away.outcome, Outcome::Completed);
}

#[test]
fn a_ground_that_makes_no_sense_is_refused() {
    for (setting, says) in [
        ("ground.profile=[[1,0],[1,0.1]]", "places that increase"),
        ("ground.patches=[[2,1,0.5]]", "an end beyond its begin"),
        ("ground.unevenness_m=-0.1", "valid is a number from 0 to 0.5"),
        ("ground.patches=[[1,2,-0.5]]", "friction"),
    ] {
        let error = scenario_file::load("feet-walk", &[setting.to_owned()]).expect_err(setting).to_string();
        assert!(error.contains(says), "{setting}: {error}");
    }
}

#[test]
fn the_normal_is_across_every_way_along_the_ground() {
    let sets = ["ground.slope_deg=3", "ground.cross_slope_deg=-7", "ground.profile=[[0,0],[0.5,0.2],[1.5,-0.3]]"];
    let loaded = scenario_file::load("exo-sway", &sets.map(str::to_owned)).expect("valid");
    let ground = loaded.scenario.terrain(&loaded.model().expect("built in"));
    for (x, y) in [(-0.4, 0.3), (0.2, -0.1), (1.0, 0.8), (2.0, 0.0)] {
        let normal = ground.normal_at(x, y);
        let rise = |dx: f64, dy: f64| ground.height_at(x + dx, y + dy) - ground.height_at(x, y);
        for [dx, dy] in [[1e-3, 0.0], [0.0, 1e-3], [-7e-4, 4e-4]] {
            let off = normal.x * dx + normal.y * dy + normal.z * rise(dx, dy);
            assert!(off.abs() < 1e-15 && (normal.norm() - 1.0).abs() < 1e-15, "{off} at ({x}, {y})");
        }
    }
}
