//! Inverse and forward dynamics against each other, the equation of motion, and the textbook's Newton-Euler in body frames.
//!
//! Forward dynamics divide by inertias: rounding is that of M⁻¹. Held are therefore forces, not accelerations, each within
//! 1e-10 of the largest.

#![allow(non_snake_case)]

mod common;

use common::{Random, assert_close, rnea};
use legwork_rbd::{Base, Dynamics, ForwardDynamics, InverseDynamics, Model};
use nalgebra::DVector;
use proptest::prelude::*;

fn any_base() -> impl Strategy<Value = Base> {
    prop_oneof![Just(Base::Fixed), Just(Base::Planar), Just(Base::Floating)]
}

struct Case {
    model: Model,
    q: Vec<f64>,
    v: Vec<f64>,
    dynamics: Dynamics,
    vdot: Vec<f64>,
    rho: Vec<f64>,
}

fn case(seed: u64, bodies: usize, base: Base) -> Case {
    let model = Model::from_toml(&common::random_tree(seed, bodies, base), "tree.toml").unwrap();
    let mut random = Random(!seed);
    let (q, v, vdot) = (random.q(&model), random.v(&model), random.v(&model));
    let rho = (0..model.nc() * model.linear_axes().len()).map(|_| random.between(-50.0, 50.0)).collect();
    let mut dynamics = Dynamics::new(&model);
    dynamics.update_position(&model, &q);
    dynamics.update_bias(&model, &v);
    Case { model, q, v, dynamics, vdot, rho }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn inverse_dynamics_are_the_equation_of_motion(seed: u64, bodies in 1..12_usize, base in any_base()) {
        let Case { model, q, v, mut dynamics, vdot, rho } = case(seed, bodies, base);
        let mut inverse = InverseDynamics::new(&model);
        let mut tau = vec![0.0; model.nv()];
        inverse.solve(&model, &dynamics, &vdot, &vec![0.0; rho.len()], &mut tau);
        let textbook = rnea(&model, &q, &v, &vdot, model.gravity) + &dynamics.damping + &dynamics.elastic;
        assert_close("textbook", &tau, textbook.as_slice(), 1e-11);

        inverse.solve(&model, &dynamics, &vdot, &rho, &mut tau);
        dynamics.update(&model, &q, &v);
        let by_matrix = &dynamics.mass_matrix * DVector::from_vec(vdot) + &dynamics.bias + &dynamics.damping
            + &dynamics.elastic
            - dynamics.contact_jacobian.transpose() * DVector::from_vec(rho);
        assert_close("by M", &tau, by_matrix.as_slice(), 1e-11);
    }

    #[test]
    fn forward_dynamics_undo_inverse_dynamics(seed: u64, bodies in 1..12_usize, base in any_base()) {
        let Case { model, dynamics, vdot: tau, rho, .. } = case(seed, bodies, base);
        let (mut vdot, mut again) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        prop_assert!(ForwardDynamics::new(&model).solve(&model, &dynamics, &tau, &rho, &mut vdot));
        InverseDynamics::new(&model).solve(&model, &dynamics, &vdot, &rho, &mut again);
        // Forces cancel to reach tau: what they are rounded against is the largest of them.
        let largest = (&dynamics.bias + &dynamics.damping + &dynamics.elastic).amax().max((&dynamics.mass_matrix * DVector::from_vec(vdot)).amax());
        assert_close("tau", &again, &tau, 1e-10 * largest.max(1.0));
    }
}

#[test]
fn exoskeleton_in_any_state() {
    let model = Model::load(&common::crate_path("../../models/exo18.urdf")).unwrap();
    let (mut random, mut dynamics) = (Random(21), Dynamics::new(&model));
    let (mut forward, mut vdot) = (ForwardDynamics::new(&model), vec![0.0; model.nv()]);
    for _ in 0..20 {
        dynamics.update(&model, &random.q(&model), &random.v(&model));
        let tau: Vec<f64> = (0..model.nv()).map(|_| random.between(-100.0, 100.0)).collect();
        let rho: Vec<f64> = (0..3 * model.nc()).map(|_| random.between(-200.0, 200.0)).collect();
        assert!(forward.solve(&model, &dynamics, &tau, &rho, &mut vdot));
        let force = DVector::from_vec(tau) + dynamics.contact_jacobian.transpose() * DVector::from_vec(rho);
        let want =
            dynamics.mass_matrix.clone().cholesky().unwrap().solve(&(force - &dynamics.bias - &dynamics.damping));
        assert_close("vdot", &vdot, want.as_slice(), 1e-11);
    }
}

#[test]
fn what_moves_no_inertia_is_said() {
    let text = "name = \"r\"\nbase = \"fixed\"\nbodies = [{ name = \"a\" }, { name = \"b\", parent = \"a\", mass_kg = 1, \
        com_m = [0, 0, -1], joint = { name = \"j\", type = \"revolute\", axis = [0, 1, 0] } }]";
    let mut model = Model::from_toml(text, "r.toml").unwrap();
    model.bodies[1].mass = 0.0;
    let mut dynamics = Dynamics::new(&model);
    dynamics.update_position(&model, &[0.3]);
    dynamics.update_bias(&model, &[0.0]);
    assert!(!ForwardDynamics::new(&model).solve(&model, &dynamics, &[1.0], &[], &mut [0.0]));
}
