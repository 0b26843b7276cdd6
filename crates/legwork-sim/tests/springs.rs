//! Springs and stops at joints in the simulator, against closed forms.

use std::sync::Arc;

use legwork_contract::error::Error;
use legwork_contract::terrain::Terrain;
use legwork_rbd::Model;
use legwork_sim::Simulator;
use legwork_sim::settings::{Integrator, SimulationSettings};

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

fn simulator(integrator: Integrator, model: Model, q: f64) -> Result<Simulator, Error> {
    let settings = SimulationSettings { integrator, period_s: DT, ..SimulationSettings::default() };
    let ground = Terrain::plane(&model, 1.0, [0.0; 2]);
    Simulator::new(&settings, &[], ground, Arc::new(model), &[q])
}

#[test]
fn a_spring_swings_with_its_closed_form_and_keeps_its_energy() {
    let (stiffness, rest, amplitude) = (250.0_f64, 0.2, 0.3);
    let model = rod(&format!("spring_nmpr = {stiffness}\nrest_rad = {rest}"));
    let natural = (stiffness / INERTIA).sqrt();
    // A step turns the phase by acos(1 − (ω dt)²/2): faster than ω dt by (ω dt)²/24.
    let phase = (1.0 - 0.5 * (natural * DT).powi(2)).acos();
    assert!((phase / (natural * DT) - 1.0 - (natural * DT).powi(2) / 24.0).abs() < 1e-7);
    let energy = 0.5 * stiffness * amplitude * amplitude;
    for integrator in INTEGRATORS {
        let mut simulator = simulator(integrator, model.clone(), rest + amplitude).expect("soft enough");
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
    let (torque, way, stiffness, damping) = (20.0_f64, 0.2, 5000.0, 30.0);
    for integrator in INTEGRATORS {
        for (side, range) in [(1.0, format!("upper_rad = {way}")), (-1.0, format!("lower_rad = -{way}"))] {
            let stop = format!("{range}\nstop_nmpr = {stiffness}\nstop_damping_nmspr = ");
            // Without damping: the work of the torque goes into the stop, torque (way + p) = k p² / 2.
            let deepest = (torque + f64::sqrt(torque * torque + 2.0 * stiffness * torque * way)) / stiffness;
            let speed = (2.0 * torque * way / INERTIA).sqrt();
            let mut bouncing = simulator(integrator, rod(&format!("{stop}0")), 0.0).expect("soft enough");
            let mut found: f64 = 0.0;
            for _ in 0..300 {
                assert!(bouncing.step(&[side * torque]));
                found = found.max(side * bouncing.q()[0] - way);
            }
            // It arrives within a step.
            assert!((found - deepest).abs() < speed * DT, "{integrator:?}: {found} rad, expected {deepest}");
            assert_eq!(bouncing.audit().violations(), Vec::<String>::new());

            let mut damped = simulator(integrator, rod(&format!("{stop}{damping}")), 0.0).expect("soft enough");
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
    let error = simulator(Integrator::Midpoint, stop(1.001 * unstable), 0.0).expect_err("too stiff");
    let said = error.to_string();
    assert!(said.contains("joint \"hinge\"") && said.contains("simulation.period_s"), "{said}");

    for integrator in INTEGRATORS {
        let mut simulator = simulator(integrator, stop(0.95 * unstable), 0.0).expect("just stable");
        for _ in 0..2000 {
            assert!(simulator.step(&[20.0]));
            assert!(simulator.q()[0] < 0.3 && simulator.v()[0].abs() < 20.0);
        }
        let audit = simulator.audit();
        assert!((audit.stiffness_share - 0.95).abs() < 1e-9, "{}", audit.stiffness_share);
        assert!(audit.violations().iter().any(|said| said.contains("springs and stops")), "{:?}", audit.violations());
    }
}
