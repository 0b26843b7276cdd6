//! Springs and stops at joints, in the simulator and in the controller.

use legwork::episode::Outcome;
use legwork::log::Field;
use legwork::scenario::{Integrator, Scenario};
use legwork::sim::Simulator;
use legwork::{episode, library, scenario_file};
use legwork_rbd::Model;

const DT: f64 = 1e-3;
const INTEGRATORS: [Integrator; 2] = [Integrator::Midpoint, Integrator::SemiImplicitEuler];
/// About the vertical axis of its joint [kg m²].
const INERTIA: f64 = 0.02 + 2.0 * 0.5 * 0.5;

/// A rod of 2 kg that turns about a vertical axis, so that nothing but its joint drives it.
fn rod(keys: &str) -> Model {
    let text = format!(
        r#"
        name = "rod"
        base = "fixed"
        torso = "rod"
        [[bodies]]
        name = "stand"
        [[bodies]]
        name = "rod"
        parent = "stand"
        mass_kg = 2.0
        com_m = [0.5, 0.0, 0.0]
        inertia_kgm2 = {{ xx = 0.001, yy = 0.02, zz = 0.02 }}
        [bodies.joint]
        name = "hinge"
        type = "revolute"
        axis = [0, 0, 1]
        {keys}
        "#
    );
    Model::from_toml(&text, "rod.toml").expect("a valid model")
}

fn simulator(integrator: Integrator, model: &Model, q: f64) -> Simulator {
    let mut scenario = Scenario::default();
    (scenario.simulation.integrator, scenario.simulation.period_s) = (integrator, DT);
    scenario.simulator(model, &[q]).expect("soft enough")
}

#[test]
fn a_spring_swings_with_its_closed_form_and_keeps_its_energy() {
    let (stiffness, rest, amplitude) = (250.0, 0.2, 0.3);
    let model = rod(&format!("spring_nmpr = {stiffness}\nrest_rad = {rest}"));
    let natural = (stiffness / INERTIA).sqrt();
    // A step turns the phase by acos(1 − (ω dt)²/2): faster than ω dt by (ω dt)²/24.
    let phase = (1.0 - 0.5 * (natural * DT).powi(2)).acos();
    assert!((phase / (natural * DT) - 1.0 - (natural * DT).powi(2) / 24.0).abs() < 1e-7);
    let energy = 0.5 * stiffness * amplitude * amplitude;
    for integrator in INTEGRATORS {
        let mut simulator = simulator(integrator, &model, rest + amplitude);
        // The Euler rule begins as if it had been released half a step earlier.
        let (lead, errs) = match integrator {
            Integrator::Midpoint => (0.0, (natural * DT).powi(2) / 4.0),
            Integrator::SemiImplicitEuler => (0.5 * phase, natural * DT / 2.0),
        };
        for step in 1..=5000 {
            assert!(simulator.step(&[0.0]));
            let expected = amplitude * (f64::from(step) * phase + lead).cos() / lead.cos();
            let found = simulator.q()[0] - rest;
            assert!((found - expected).abs() < 1e-9, "{integrator:?}, step {step}: {found}, expected {expected}");
        }
        let audit = simulator.audit();
        assert!(audit.energy_error_j < 1.1 * errs * energy, "{integrator:?}: {} of {energy} J", audit.energy_error_j);
        assert!((audit.stiffness_share - 0.25 * (natural * DT).powi(2)).abs() < 1e-12);
        assert_eq!(audit.violations(), Vec::<String>::new());
    }
}

#[test]
fn a_stop_holds_a_joint_near_its_end() {
    let (torque, way, stiffness, damping) = (20.0, 0.2, 5000.0, 30.0);
    for integrator in INTEGRATORS {
        for (side, range) in [(1.0, format!("upper_rad = {way}")), (-1.0, format!("lower_rad = -{way}"))] {
            let stop = format!("{range}\nstop_nmpr = {stiffness}\nstop_damping_nmspr = ");
            // Without damping: the work of the torque goes into the stop, torque (way + p) = k p² / 2.
            let deepest = (torque + f64::sqrt(torque * torque + 2.0 * stiffness * torque * way)) / stiffness;
            let speed = (2.0 * torque * way / INERTIA).sqrt();
            let mut bouncing = simulator(integrator, &rod(&format!("{stop}0")), 0.0);
            let mut found: f64 = 0.0;
            for _ in 0..300 {
                assert!(bouncing.step(&[side * torque]));
                found = found.max(side * bouncing.q()[0] - way);
            }
            // It arrives within a step.
            assert!((found - deepest).abs() < speed * DT, "{integrator:?}: {found} rad, expected {deepest}");
            assert_eq!(bouncing.audit().violations(), Vec::<String>::new());

            let mut damped = simulator(integrator, &rod(&format!("{stop}{damping}")), 0.0);
            let mut most: f64 = 0.0;
            for _ in 0..3000 {
                assert!(damped.step(&[side * torque]));
                most = most.max(side * damped.q()[0] - way);
            }
            assert!(most < deepest, "{most} rad, without damping {deepest}");
            let rest = side * damped.q()[0] - way;
            assert!((rest - torque / stiffness).abs() < 1e-6, "{integrator:?}: at rest {rest} rad beyond the end");
            assert_eq!(damped.audit().violations(), Vec::<String>::new());
        }
    }
}

#[test]
fn a_stop_that_no_step_can_resolve_is_refused_and_a_very_stiff_one_is_told_of() {
    // dt² k / (4 I) = 1
    let unstable = 4.0 * INERTIA / (DT * DT);
    let stop = |stiffness: f64| rod(&format!("upper_rad = 0.2\nstop_nmpr = {stiffness}"));
    let error = Scenario::default().simulator(&stop(1.001 * unstable), &[0.0]).expect_err("too stiff");
    let said = error.to_string();
    assert!(said.contains("joint \"hinge\"") && said.contains("simulation.period_s"), "{said}");

    for integrator in INTEGRATORS {
        let mut simulator = simulator(integrator, &stop(0.95 * unstable), 0.0);
        for _ in 0..2000 {
            assert!(simulator.step(&[20.0]));
            assert!(simulator.q()[0] < 0.3 && simulator.v()[0].abs() < 20.0);
        }
        let audit = simulator.audit();
        assert!((audit.stiffness_share - 0.95).abs() < 1e-9, "{}", audit.stiffness_share);
        assert!(audit.violations().iter().any(|said| said.contains("springs and stops")), "{:?}", audit.violations());
    }
}

/// The exoskeleton without motors for the rotation of the hip and the inversion of the ankle, whose springs pull aside.
#[test]
fn the_controller_stands_on_passive_joints_with_springs() {
    let mut model = library::load_model("exo18", None).expect("built in");
    for dof in &mut model.dofs {
        if dof.name.ends_with("_hie") || dof.name.ends_with("_aie") {
            (dof.actuated, dof.stiffness, dof.rest, dof.stop_stiffness) = (false, 60.0, 0.1, 500.0);
        }
    }
    let sets = ["duration_s=2".to_owned(), "pushes=[]".to_owned(), "reference.stance.sway_m=[0.01,0,0]".to_owned()];
    let loaded = scenario_file::load("exo-sway", &sets).expect("valid");
    let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it runs");
    assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
    assert_eq!((run.program.infeasible, run.audit.violations()), (0, vec![]));
    let error = run.metrics.com_error_m.expect("it ran long enough");
    println!("{error:?}");
    assert!(error.peak < 0.005, "{error:?}");
    // What the program expects of the ground is what the ground gives, tick by tick: the springs' 6 Nm are known.
    for index in 100..run.log.len() {
        let (expected, found) = (run.log.get(index, Field::Grf), run.log.get(index, Field::GrfSimulated));
        let up = |forces: &[f64]| forces.chunks(3).map(|force| force[2]).sum::<f64>();
        println!("{} {}", up(expected), up(found));
    }
}
