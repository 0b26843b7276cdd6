//! Contact that obeys its laws whatever the ground, the step and the phase of an impact in it: no energy from the ground, no
//! rebound, friction opposite to the slip, loads without squeezing.

mod common;

use legwork::log::Field;
use legwork::scenario::{Integrator, Push, Scenario};
use legwork::sim::Simulator;
use legwork_rbd::{Dynamics, Model};

/// A body of 10 kg in the plane with contact points at `points` (x, z) from its centre of mass.
fn planar(points: &[[f64; 2]]) -> Model {
    let contact = |(index, [x, z]): (usize, &[f64; 2])| {
        format!("{{ name = \"p{index}\", foot = \"f{index}\", body = \"box\", position_m = [{x:?}, 0.0, {z:?}] }},\n")
    };
    let contacts: String = points.iter().enumerate().map(contact).collect();
    let text = format!(
        "name = \"box\"\nbase = \"planar\"\ntorso = \"box\"\ncontacts = [{contacts}]\n\
         [[bodies]]\nname = \"box\"\nmass_kg = 10.0\ncom_m = [0.0, 0.0, 0.0]\ninertia_kgm2 = 0.0417\n"
    );
    Model::from_toml(&text, "box.toml").expect("a valid model")
}

const CORNERS: [[f64; 2]; 2] = [[-0.1, -0.05], [0.1, -0.05]];

fn energy(simulator: &Simulator) -> f64 {
    simulator.dynamics().kinetic_energy + simulator.dynamics().potential_energy
}

/// Steps of `period` for `seconds` without torques; returns the energy at the end and its largest rise over any time.
fn drift(simulator: &mut Simulator, period: f64, seconds: f64) -> [f64; 2] {
    let (mut least, mut rise) = (energy(simulator), 0.0f64);
    for step in 0..(seconds / period).round() as usize {
        assert!(simulator.step(&[]), "numbers out of bounds in step {step}");
        let now = energy(simulator);
        rise = rise.max(now - least);
        least = least.min(now);
    }
    [energy(simulator), rise]
}

/// A push that gives 10 kg the `speed` [m/s] at once.
fn kick(scenario: &mut Scenario, speed: f64) {
    scenario.pushes = vec![Push { force_n: 10.0 * speed / 1e-5, duration_s: 1e-5, ..Push::default() }];
}

/// In another simulator such a cube rose by 0.3 m and tumbled (Genesis, pull request 3126). With less friction than 1 it cannot: it slides
/// v² / (2 µ g).
#[test]
fn a_fast_cube_slides_and_neither_rises_nor_tips() {
    let (speed, friction) = (6.0, 0.5);
    for period in [2e-3, 1e-3, 2.5e-4] {
        let mut scenario = Scenario::default();
        scenario.simulation.period_s = period;
        scenario.ground.friction = friction;
        kick(&mut scenario, speed);
        let cube = planar(&[[-0.05, -0.05], [0.05, -0.05]]);
        let mut simulator = scenario.simulator(&cube, &[0.0, 0.05, 0.0]).expect("valid");
        for step in 0..(2.0 / period) as usize {
            assert!(simulator.step(&[]));
            let [x, z, pitch] = [0, 1, 2].map(|k| simulator.q()[k]);
            assert!(
                (z - 0.05).abs() < 1e-6 && pitch.abs() < 1e-5,
                "step {step} of {period} s at {x} m: {z} m, {pitch} rad"
            );
        }
        let way = speed * speed / (2.0 * friction * 9.81);
        assert!((simulator.q()[0] - way).abs() < 2.0 * speed * period, "{} m, not {way} m", simulator.q()[0]);
    }
}

#[test]
fn a_riser_gave_a_sliding_box_energy() {
    // MuJoCo's box at the same edge stays down and keeps at most its 5.105 J.
    for period in [2e-3, 1e-3, 2.5e-4] {
        for speed in [0.2, 1.0, 3.0] {
            for width in [1e-3, 1e-2, 0.1] {
                let mut scenario = Scenario::default();
                scenario.simulation.period_s = period;
                scenario.ground.friction = 0.0;
                scenario.ground.profile = vec![[0.3, 0.0], [0.3 + width, 0.05]];
                kick(&mut scenario, speed);
                let mut simulator = scenario.simulator(&planar(&CORNERS), &[0.0, 0.05, 0.0]).expect("valid");
                assert!(simulator.step(&[]));
                let before = energy(&simulator);
                let [after, rise] = drift(&mut simulator, period, 2.0);
                let what = format!("{period} s, {speed} m/s, {width} m: {before} to {after} J, rise {rise}");
                assert!(rise < 1e-3 * before, "{what}");
                assert!(simulator.audit().penetration_m < 1e-3, "{what}: {}", simulator.audit().penetration_m);
                if speed < 0.5 && width < 0.05 {
                    assert!(simulator.q()[0] < 0.2 + 1e-3 && simulator.q()[1] < 0.06, "{what}: {:?}", simulator.q());
                }
            }
        }
    }
}

#[test]
fn a_particle_keeps_what_the_slope_leaves_of_its_speed() {
    for (width, period) in [(1e-3, 1e-3), (1e-3, 1e-4), (0.05, 1e-3)] {
        let mut scenario = Scenario::default();
        scenario.simulation.period_s = period;
        scenario.ground.friction = 0.0;
        scenario.ground.profile = vec![[0.3, 0.0], [0.3 + width, 0.05]];
        kick(&mut scenario, 1.0);
        let mut simulator = scenario.simulator(&planar(&[[0.0, 0.0]]), &[0.0, 0.0, 0.0]).expect("valid");
        let mut after = None;
        let mut most = 0.0f64;
        for _ in 0..(0.6 / period) as usize {
            assert!(simulator.step(&[]));
            let now = energy(&simulator);
            if simulator.q()[0] > 0.2985 && after.is_none() {
                eprintln!("{:?} {:?} {now}", simulator.q(), simulator.v());
            }
            if simulator.q()[0] > 0.2 && now < 4.0 {
                after.get_or_insert(now);
            }
            most = most.max(now);
        }
        // ½ m v² cos² of the slope's angle.
        let expected = 5.0 / (1.0 + (0.05 / width).powi(2));
        let after = after.expect("it meets the slope");
        assert!((after - expected).abs() < 1e-6, "{width}, {period}: {after} J, expected {expected}");
        assert!(most <= 5.0 + 1e-9, "{most}");
    }
}

#[test]
fn a_box_that_slides_onto_a_ramp_gained_energy() {
    for period in [2e-3, 1e-3, 5e-4] {
        for integrator in [Integrator::Midpoint, Integrator::SemiImplicitEuler] {
            let mut scenario = Scenario::default();
            scenario.simulation.period_s = period;
            scenario.simulation.integrator = integrator;
            scenario.ground.friction = 0.0;
            scenario.ground.profile = vec![[0.3, 0.0], [1.3, 10f64.to_radians().tan()]];
            kick(&mut scenario, 1.5);
            let mut simulator = scenario.simulator(&planar(&CORNERS), &[0.0, 0.05, 0.0]).expect("valid");
            assert!(simulator.step(&[]));
            let before = energy(&simulator);
            let [after, rise] = drift(&mut simulator, period, 2.0);
            assert!(rise < 2e-3 * before, "{integrator:?} {period}: {before} to {after} J, rise {rise} J");
        }
    }
}

#[test]
fn a_dropped_box_rebounded_by_what_the_step_had_gone_too_far() {
    for phase in 0..20 {
        for speed in [0.01, 0.3, 3.178] {
            let height = 0.05 + speed * speed / (2.0 * 9.81) + 1e-5 + 0.0002 * f64::from(phase);
            let mut simulator = Scenario::default().simulator(&planar(&CORNERS), &[0.0, height, 0.0]).expect("valid");
            let (mut fastest, mut rebound) = (0.0f64, 0.0f64);
            for _ in 0..1000 {
                assert!(simulator.step(&[]));
                fastest = fastest.max(-simulator.v()[1]);
                rebound = rebound.max(simulator.v()[1]);
            }
            assert!(rebound < 1e-3 * fastest, "{speed} m/s, phase {phase}: {rebound} of {fastest} m/s");
            // The gap that the impact left is closed but for the tolerance of the forces, 1e-6 N on 10 kg for a step.
            let gap = simulator.q()[1] - 0.05;
            assert!(gap.abs() < 1e-9 && simulator.v()[1].abs() < 1e-9, "{speed} m/s, phase {phase}: {gap} m");
        }
    }
}

/// Ground that came back from so deep would give energy.
#[test]
fn what_rests_a_millimetre_deep_stays_there() {
    let mut simulator = Scenario::default().simulator(&planar(&CORNERS), &[0.0, 0.049, 0.0]).expect("valid");
    for _ in 0..200 {
        assert!(simulator.step(&[]));
        assert!((simulator.q()[1] - 0.049).abs() < 1e-9 && simulator.v()[1].abs() < 1e-9, "{:?}", simulator.q());
    }
}

/// The same ramp as heights above a slope and as heights above level ground: a box slides over both alike.
#[test]
fn a_ramp_on_a_slope_is_the_ramp_that_it_makes_with_it() {
    let steepness = 5.0_f64.to_radians().tan();
    let end = |slope_deg: f64, profile: &[[f64; 2]]| {
        let mut scenario = Scenario::default();
        (scenario.ground.friction, scenario.ground.slope_deg) = (0.3, slope_deg);
        scenario.ground.profile = profile.to_vec();
        kick(&mut scenario, 2.5);
        let mut simulator = scenario.simulator(&planar(&CORNERS), &[-0.3, 0.06, 0.0]).expect("valid");
        (0..500).for_each(|_| assert!(simulator.step(&[])));
        simulator.q().to_vec()
    };
    let on_slope = end(5.0, &[[0.2, 0.0], [0.4, 0.02]]);
    let level = [[-2.0, 0.0], [0.2, 0.0], [0.4, 0.02], [3.0, 0.02]].map(|[x, z]| [x, z + steepness * x]);
    let on_level = end(0.0, &level);
    assert!(on_slope[0] > 0.3, "it has come to the ramp: {on_slope:?}");
    let apart = on_slope.iter().zip(&on_level).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-7, "{on_slope:?} and {on_level:?}");
}

/// The impact equation `M (v⁺ - v⁻) = Jᵀ λ`, `J v⁺ = 0` at `q`.
fn after_impact(model: &Model, q: &[f64], v: &[f64]) -> Vec<f64> {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q, v);
    let inverse = dynamics.mass_matrix.clone().try_inverse().expect("positive definite");
    let jacobian = &dynamics.contact_jacobian;
    let gain = (jacobian * &inverse * jacobian.transpose()).try_inverse().expect("independent contacts");
    let v = nalgebra::DVector::from_column_slice(v);
    (&v - inverse * jacobian.transpose() * gain * (jacobian * &v)).as_slice().to_vec()
}

#[test]
fn a_sticking_impact_is_that_of_the_impact_equation() {
    // Without gravity, so that nothing but the impact changes the velocities; a corner ahead of the centre of mass hits.
    let text = "name = \"box\"\nbase = \"planar\"\ngravity_mps2 = 0.0\ntorso = \"box\"\n\
        contacts = [{ name = \"p\", foot = \"f\", body = \"box\", position_m = [0.1, 0.0, -0.2] }]\n\
        [[bodies]]\nname = \"box\"\nmass_kg = 10.0\ncom_m = [0.0, 0.0, 0.0]\ninertia_kgm2 = 0.4\n";
    let model = Model::from_toml(text, "box.toml").expect("valid");
    let mut scenario = Scenario::default();
    scenario.ground.friction = 2.0;
    scenario.pushes = vec![Push { force_n: 2e6, direction_deg: -70.0, duration_s: 1e-5, ..Push::default() }];
    for phase in 0..10 {
        let mut simulator = scenario.simulator(&model, &[0.0, 0.21 + 2e-4 * f64::from(phase), 0.0]).expect("valid");
        let mut before = simulator.v().to_vec();
        let touches = |simulator: &Simulator| simulator.contact_forces()[1] > 0.0;
        while !touches(&simulator) {
            before = simulator.v().to_vec();
            assert!(simulator.step(&[]));
        }
        // The body does not turn before; it is at the ground when it hits.
        let expected = after_impact(&model, &[0.0, 0.2, 0.0], &before);
        // After the impact it turns about the point: compare what the turning keeps, its rate by the kinetic energy.
        let kinetic = |v: &[f64]| 5.0 * (v[0] * v[0] + v[1] * v[1]) + 0.2 * v[2] * v[2];
        let (found, wanted) = (kinetic(simulator.v()), kinetic(&expected));
        assert!((found - wanted).abs() < 1e-6 * wanted, "phase {phase}: {found} J, expected {wanted} J");
        assert!(
            (simulator.v()[2] - expected[2]).abs() < 1e-6 * expected[2].abs(),
            "{} {}",
            simulator.v()[2],
            expected[2]
        );
    }
}

/// A rod of a metre on one point, tilted about x, that a push across makes slip: normal and tangents are coupled.
#[test]
fn friction_of_a_leaning_rod_was_off_the_slip() {
    let text = "name = \"rod\"\nbase = \"floating\"\ntorso = \"rod\"\n\
        contacts = [{ name = \"p\", foot = \"f\", body = \"rod\", position_m = [0.0, 0.0, -0.5] }]\n\
        [[bodies]]\nname = \"rod\"\nmass_kg = 10.0\ncom_m = [0.0, 0.0, 0.0]\n\
        inertia_kgm2 = { xx = 0.8333333333333334, yy = 0.8333333333333334, zz = 0.0135 }\n";
    let model = Model::from_toml(text, "rod.toml").expect("valid");
    for tilt_deg in [10.0f64, 25.0, 45.0] {
        let half = 0.5 * tilt_deg.to_radians();
        let mut scenario = Scenario::default();
        scenario.ground.friction = 0.5;
        scenario.pushes =
            vec![Push { force_n: 2000.0, heading_deg: 90.0, start_s: 0.005, duration_s: 0.01, ..Push::default() }];
        let q = [half.cos(), 0.0, half.sin(), 0.0, 0.0, 0.0, 0.5 * (2.0 * half).cos()];
        let mut simulator = scenario.simulator(&model, &q).expect("valid");
        let mut slipped = 0;
        for _ in 0..200 {
            assert!(simulator.step(&[]));
            let (force, slip) = (simulator.contact_forces(), simulator.dynamics().contact_velocities[0]);
            let (friction, speed) = (force[0].hypot(force[1]), slip.x.hypot(slip.y));
            if force[2] > 1.0 && speed > 0.05 {
                slipped += 1;
                let cosine = -(force[0] * slip.x + force[1] * slip.y) / (friction * speed);
                // The slip turns while the step is under way.
                assert!(cosine.clamp(-1.0, 1.0).acos().to_degrees() < 2.0, "{tilt_deg} deg: {cosine}");
                assert!((friction - 0.5 * force[2]).abs() < 1e-6 * force[2]);
            }
        }
        assert!(slipped > 20, "{tilt_deg} deg: slipped in {slipped} steps");
        let audit = simulator.audit();
        assert!(audit.friction_angle_deg < 0.1, "{tilt_deg} deg: {}", audit.friction_angle_deg);
        assert_eq!(audit.violations(), Vec::<String>::new());
    }
}

#[test]
fn on_ground_that_it_knew_it_asked_for_more_friction_than_there_is() {
    let slip = |more: &[&str]| {
        let push = "pushes=[{force_n=400,heading_deg=225,start_s=2.5,duration_s=0.2}]";
        let run = common::run("exo-sway", &[&["duration_s=4", "ground.friction=0.2", push], more].concat());
        for record in 0..run.log.len() {
            for force in run.log.get(record, Field::Grf).chunks(3) {
                let (friction, limit) = (force[0].hypot(force[1]), 0.2 * force[2]);
                assert!(friction <= limit + 1e-6, "{friction} N of {limit} N");
            }
        }
        run.audit.expect("our simulator").slip_m
    };
    // Eight points, some 4 mm each; 260 mm together with a pyramid around the cone.
    let (four, eight) = (slip(&[]), slip(&["controller.friction_edges=8"]));
    assert!(four < 0.06 && eight < 0.06, "{four} m, {eight} m");
}

/// A foot on four corners carries an even load evenly, and squeezes nothing.
#[test]
fn corners_of_a_foot_share_its_load_evenly() {
    let run = common::run("exo-sway", &["duration_s=1", "pushes=[]", "seed=0"]);
    let (mut jump, mut before): (f64, Option<Vec<f64>>) = (0.0, None);
    for record in 300..run.log.len() {
        let forces = run.log.get(record, Field::GrfSimulated);
        for foot in forces.chunks(12) {
            let [a, b, c, d] = [0, 3, 6, 9].map(|k| foot[k + 2]);
            // Of least norm: without a part that twists a flat sole.
            assert!((a - b - c + d).abs() < 1e-3 * (a + b + c + d), "{a} {b} {c} {d} N");
        }
        if let Some(before) = &before {
            jump = forces.iter().zip(before).map(|(now, then)| (now - then).abs()).fold(jump, f64::max);
        }
        before = Some(forces.to_vec());
    }
    assert!(jump < 30.0, "{jump} N in a tick");
}
