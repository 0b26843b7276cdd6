//! Balance of whole runs: what is measured twice agrees, and the log says what its records say.

mod common;

use legwork::balance::{Meter, margin};
use legwork::episode::Run;
use legwork::feet::FeetMotion;
use legwork::log::Field;
use legwork::scenario_file;

/// Places of the columns of [`Field::Balance`].
const COP: usize = 2;
const ZMP: usize = 3;

/// Largest and mean distance of the zero-moment point, of masses and velocities, from the centre of pressure, of contact
/// forces and contact points [m].
fn zmp_from_cop(run: &Run) -> [f64; 2] {
    let mut meter = Meter::new(&run.scenario, &run.model);
    let zmps = meter.zmps(&run.model, &run.log);
    let both = zmps.iter().enumerate().filter_map(|(tick, zmp)| zmp.zip(meter.at(&run.log, tick).cop));
    let distances: Vec<f64> = both.map(|([x, y], [cop_x, cop_y])| (x - cop_x).hypot(y - cop_y)).collect();
    assert!(distances.len() > run.log.len() / 2, "it is on the ground");
    let largest = distances.iter().copied().fold(0.0, f64::max);
    [largest, distances.iter().sum::<f64>() / distances.len() as f64]
}

#[test]
fn the_zero_moment_point_is_the_centre_of_pressure() {
    let torso = ["pushes.0.at=torso", "pushes.0.start_s=2.0", "pushes.1.start_s=3.0", "duration_s=5"];
    for (name, sets) in [
        ("walk", &[][..]),
        ("push", &["duration_s=3"]),
        ("walk-slope", &["duration_s=3"]),
        ("push-walking", &torso),
        ("exo-lift", &["duration_s=3"]),
    ] {
        let run = common::run(name, sets);
        let [largest, mean] = zmp_from_cop(&run);
        // A contact point that lands or slips at 2 m/s moves by 2 mm in the control period of 1 ms; those that stand do
        // not move. The forces of the pushes alone are worth centimetres.
        assert!(largest < 2e-3 && mean < 2e-5, "{name}: {largest} m, mean {mean} m");
    }
}

#[test]
fn a_centre_of_pressure_lies_in_the_support_and_a_wanted_one_may_not() {
    let run = common::run("push", &["duration_s=3"]);
    let meter = Meter::new(&run.scenario, &run.model);
    let (mut fictitious, mut stood) = (0, 0);
    for tick in 0..run.log.len() {
        let measures = meter.at(&run.log, tick);
        let Some((capture, cop)) = measures.capture.zip(measures.cop) else { continue };
        stood += 1;
        // The flags are of the tick's beginning; a foot may touch down in its period.
        let touched = run.log.get((tick + 1).min(run.log.len() - 1), Field::Touching);
        if touched == run.log.get(tick, Field::Touching) {
            assert!(margin(capture.support, cop[0]) > -1e-9, "{cop:?} outside of {:?} in tick {tick}", capture.support);
        }
        fictitious += usize::from(measures.wanted_zmp.is_some_and(|zmp| margin(capture.support, zmp[0]) < -0.1));
    }
    assert!(fictitious > 100 && stood > 2000, "{fictitious} of {stood}");
}

#[test]
fn the_log_of_soles_has_the_measures_of_its_records() {
    let run = common::run("push-walking", &["duration_s=6"]);
    let mut meter = Meter::new(&run.scenario, &run.model);
    let zmps = meter.zmps(&run.model, &run.log);
    let mut kept = [0.0; 5];
    for tick in 0..run.log.len() - 1 {
        let measures = meter.at(&run.log, tick);
        let along = [measures.cop, zmps[tick], measures.wanted_zmp, measures.cmp].map(|place| place.map(|[x, _]| x));
        let found = [along[0], along[1], along[2], along[3], measures.margin()];
        kept = std::array::from_fn(|k| found[k].unwrap_or(kept[k]));
        let logged = run.log.get(tick, Field::Balance);
        assert!(logged[COP..ZMP + 4].iter().zip(kept).all(|(a, b)| (a - b).abs() < 1e-12), "{logged:?}, {kept:?}");
        assert_eq!(logged[7], measures.steps().map_or(-1.0, f64::from));
    }
}

#[test]
fn the_walkers_wanted_centre_of_pressure_is_what_its_planner_wants_of_the_forces() {
    let run = common::run("feet-walk", &["duration_s=4", "controller.planner.angular_momentum_gain=0"]);
    let meter = Meter::new(&run.scenario, &run.model);
    for tick in 0..run.log.len() {
        let wanted = meter.at(&run.log, tick).wanted_zmp.expect("the planner wants to stand");
        let reference = run.log.get(tick, Field::Balance)[0];
        assert!((wanted[0] - reference).abs() < 1e-9, "{wanted:?} and {reference} in tick {tick}");
    }
}

/// A record in the plane, on a slope: the pendulum is as long as the centre of mass is above the ground.
#[test]
fn the_measures_of_a_record_made_by_hand() {
    let loaded = scenario_file::load("walk", &["ground.slope_deg=5".to_owned()]).expect("built in");
    let (scenario, model) = (&loaded.scenario, loaded.model().expect("built in"));
    let meter = Meter::new(scenario, &model);
    let step = &scenario.reference.step;
    let slope = 5.0_f64.to_radians().tan();
    let length = |x: f64, z: f64| ((z - x * slope) / 9.81).sqrt();
    for (touching, swing, support, landing_s) in [
        (&[1.0, 0.0], &[1.0, 0.9], [0.1, 0.1], step.duration_s - 0.1),
        (&[1.0, 0.0], &[1.0, 0.1], [0.1, 0.1], 0.0),
        (&[1.0, 1.0], &[-1.0, -1.0], [0.1, 0.6], step.duration_s),
        (&[0.0, 1.0], &[0.0, 1.0], [0.6, 0.6], step.duration_s),
    ] {
        let get = |field| -> &[f64] {
            match field {
                Field::Time => &[1.0],
                Field::Com => &[0.3, 1.0],
                Field::ComVelocity => &[0.5, 0.1],
                Field::ComReference => &[0.4, 0.9, -0.2, 0.0, 0.0, 0.0],
                Field::Feet => &[0.1, 0.02, 0.6, 0.06],
                Field::Touching => touching,
                Field::Swing => swing,
                Field::GrfSimulated => &[30.0, 300.0, -20.0, 500.0],
                _ => &[],
            }
        };
        let measures = meter.of(get);
        // From (0.3, 1) against (10, 800), the sum of both forces, to where z is the ground's.
        let pivot = 0.3 - 10.0 * (1.0 - 0.3 * slope) / (800.0 - 10.0 * slope);
        assert!((measures.cmp.expect("it is on the ground")[0] - pivot).abs() < 1e-12, "{measures:?}");
        let xcom = 0.3 + 0.5 * length(0.3, 1.0);
        assert!((measures.xcom[0] - xcom).abs() < 1e-12 && measures.xcom[1] == 0.0);
        let capture = measures.capture.expect("a foot stands");
        assert_eq!((capture.way, capture.support, capture.feet), ([1.0, 0.0], support, support));
        assert!((capture.landing_s - landing_s).abs() < 1e-12, "{}", capture.landing_s);
        let inside = (xcom - support[0]).min(support[1] - xcom);
        assert!((measures.margin().expect("a margin") - inside).abs() < 1e-12);
        let reference = meter.xcom_reference(get).expect("a reference");
        assert!((reference[0] - (0.4 - 0.2 * length(0.4, 0.9))).abs() < 1e-12 && reference[1] == 0.0);
    }
}

/// In space: both feet point 30 degrees to the left, one stands, and the XcoM is ahead of its toes.
#[test]
fn the_way_out_of_a_turned_foot_is_where_it_points() {
    let loaded = scenario_file::load("exo-lift", &[]).expect("built in");
    let model = loaded.model().expect("built in");
    let (meter, motion) = (Meter::new(&loaded.scenario, &model), FeetMotion::new(&model));
    let ahead = [30.0_f64.to_radians().cos(), 30.0_f64.to_radians().sin()];
    let (mut feet, mut touching) = (vec![0.0; 3 * model.contacts.len()], vec![0.0; model.contacts.len()]);
    for foot in 0..2 {
        for (end, along) in motion.ends(foot).iter().zip([-0.1, 0.2]) {
            for (point, across) in end.iter().zip([-0.05, 0.05]) {
                feet[3 * point] = 0.4 + along * ahead[0] - across * ahead[1];
                feet[3 * point + 1] = [-0.1, 0.3][foot] + along * ahead[1] + across * ahead[0];
                touching[*point] = [1.0, 0.0][foot];
            }
        }
    }
    // The XcoM half a metre ahead of the middle between the toes of the right foot, at rest.
    let com = [0.4 + 0.7 * ahead[0], -0.1 + 0.7 * ahead[1], 0.9];
    let get = |field| -> &[f64] {
        match field {
            Field::Com => &com,
            Field::ComVelocity => &[0.0; 3],
            Field::Feet => &feet,
            Field::Touching => &touching,
            _ => &[],
        }
    };
    let close = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
    assert!(close(meter.ahead(get), ahead), "{:?}", meter.ahead(get));
    let measures = meter.of(get);
    let capture = measures.capture.expect("a foot stands");
    assert!(close(capture.way, ahead), "{:?}", capture.way);
    assert!((measures.margin().expect("a margin") + 0.5).abs() < 1e-12);
    assert!((capture.support[1] - capture.support[0] - 0.3).abs() < 1e-12);
}

#[test]
fn a_push_that_is_too_strong_leaves_no_number_of_steps() {
    let fraction = |force: &str| {
        let run = common::run("push", &[&format!("pushes.0.force_n={force}"), "duration_s=3"]);
        run.metrics.uncapturable_fraction.expect("it stands at first")
    };
    assert_eq!(fraction("300"), 0.0);
    assert!(fraction("2500") > 0.05);
}

#[test]
fn a_standing_robot_has_a_margin_and_no_cost_of_transport() {
    let run = common::run("stand", &["duration_s=1"]);
    let metrics = &run.metrics;
    assert_eq!((metrics.cost_of_transport, metrics.capture_steps), (None, Some(0)));
    assert_eq!((metrics.xcom_outside_fraction, metrics.uncapturable_fraction), (Some(0.0), Some(0.0)));
    assert!(metrics.xcom_margin_min_m.is_some_and(|margin| margin > 0.2));
}

#[test]
fn the_cost_of_transport_is_the_work_of_the_joints_over_weight_and_way() {
    let run = common::run("walk", &["duration_s=3"]);
    let (log, period) = (&run.log, run.scenario.controller.period_s);
    let actuated = log.range(Field::V).len() - log.range(Field::TorqueApplied).len();
    let work: f64 = (0..log.len() - 1)
        .map(|tick| {
            // The joints come after the base; each power over its period by the trapezium rule.
            let power = |t: usize| -> f64 {
                let speeds = &log.get(t, Field::V)[actuated..];
                log.get(t, Field::TorqueApplied).iter().zip(speeds).map(|(a, b)| (a * b).abs()).sum()
            };
            0.5 * period * (power(tick) + power(tick + 1))
        })
        .sum();
    let way = log.get(log.len() - 1, Field::Com)[0] - log.get(0, Field::Com)[0];
    let expected = work / (run.model.total_mass() * run.model.gravity * way);
    let measured = run.metrics.cost_of_transport.expect("it walks");
    // They differ by half of the first and last tick's work, of three thousand.
    assert!((measured / expected - 1.0).abs() < 2e-3, "{measured} and {expected}");
}
