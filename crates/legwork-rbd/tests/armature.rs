//! The inertia of rotors at joints: in the mass matrix, in inverse and forward dynamics, in the energy, in files.

mod common;

use common::{Random, assert_close};
use legwork_rbd::{Base, Dynamics, ForwardDynamics, InverseDynamics, Model};
use nalgebra::DVector;

const PENDULUM: &str = r#"
name = "pendulum"
base = "fixed"
[[bodies]]
name = "stand"
[[bodies]]
name = "rod"
parent = "stand"
mass_kg = 2
com_m = [0, 0, -0.5]
inertia_kgm2 = { xx = 0.1, yy = 0.1, zz = 0.01 }
joint = { name = "swing", type = "revolute", axis = [0, -1, 0], armature_kgm2 = 0.25 }
[[bodies]]
name = "bob"
parent = "rod"
mass_kg = 3
joint = { name = "slide", type = "prismatic", axis = [0, 0, 1], armature_kg = 0.5 }
"#;

/// A random tree with a rotor at every joint, and a state of it.
fn case(seed: u64, base: Base) -> (Model, Dynamics, Vec<f64>) {
    let mut model = Model::from_toml(&common::random_tree(seed, 8, base), "tree.toml").unwrap();
    let mut random = Random(!seed);
    let first = base_coordinates(base);
    for dof in &mut model.dofs[first..] {
        dof.armature = random.between(0.1, 2.0);
    }
    let (q, v) = (random.q(&model), random.v(&model));
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &q, &v);
    (model, dynamics, v)
}

fn base_coordinates(base: Base) -> usize {
    match base {
        Base::Fixed => 0,
        Base::Planar => 3,
        Base::Floating => 6,
    }
}

#[test]
fn a_pendulum_with_rotors_in_closed_form() {
    let model = Model::from_toml(PENDULUM, "pendulum.toml").unwrap();
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &[0.0, 0.2], &[2.0, 3.0]);
    let turning = 0.1 + 2.0 * 0.25 + 3.0 * 0.04;
    assert_close("M", dynamics.mass_matrix.as_slice(), &[turning + 0.25, 0.0, 0.0, 3.5], 1e-15);
    assert_close("energy", &[dynamics.kinetic_energy], &[0.5 * (turning + 0.25) * 4.0 + 0.5 * 3.5 * 9.0], 1e-15);
    // Coriolis: 2 m r ṙ θ̇; centrifugal: −m r θ̇². A rotor adds to neither.
    let gravity = 9.81 * 3.0;
    assert_close("h", dynamics.bias.as_slice(), &[2.0 * 3.0 * 0.2 * 3.0 * 2.0, gravity - 3.0 * 0.2 * 4.0], 1e-14);
    let again = Model::from_toml(&model.to_toml(), "again.toml").unwrap();
    assert_eq!(model, again);
    assert!(!common::planar_humanoid().to_toml().contains("armature"));
}

#[test]
fn all_routes_agree() {
    for seed in 0..30 {
        for base in [Base::Fixed, Base::Planar, Base::Floating] {
            let (model, dynamics, v) = case(seed, base);
            let (nv, rho) = (model.nv(), vec![0.0; model.nc() * model.linear_axes().len()]);
            let v = DVector::from_vec(v);
            let energy = 0.5 * v.dot(&(&dynamics.mass_matrix * &v));
            assert_close("energy", &[dynamics.kinetic_energy], &[energy], 1e-12);
            let (mut tau, mut again) = (vec![0.0; nv], vec![0.0; nv]);
            let mut inverse = InverseDynamics::new(&model);
            let mut random = Random(seed);
            let vdot = random.v(&model);
            inverse.solve(&model, &dynamics, &vdot, &rho, &mut tau);
            let passive = DVector::from_fn(nv, |j, _| dynamics.passive(j));
            let by_matrix = &dynamics.mass_matrix * DVector::from_vec(vdot.clone()) + passive;
            assert_close("tau", &tau, by_matrix.as_slice(), 1e-11);
            assert!(ForwardDynamics::new(&model).solve(&model, &dynamics, &tau, &rho, &mut again));
            assert_close("vdot", &again, &vdot, 1e-8);
        }
    }
}

#[test]
fn momentum_is_that_of_the_bodies() {
    let (model, with, _) = case(3, Base::Floating);
    let mut bare = model.clone();
    bare.dofs.iter_mut().for_each(|dof| dof.armature = 0.0);
    let mut random = Random(!3);
    bare.dofs[6..].iter().for_each(|_| _ = random.between(0.1, 2.0));
    let (q, v) = (random.q(&bare), random.v(&bare));
    let mut without = Dynamics::new(&bare);
    without.update(&bare, &q, &v);
    assert_eq!(with.momentum_matrix, without.momentum_matrix);
    assert_eq!(with.bias, without.bias);
    let difference = &with.mass_matrix - &without.mass_matrix;
    for (j, dof) in model.dofs.iter().enumerate() {
        assert_close("rotor", &[difference[(j, j)]], &[dof.armature], 1e-12);
    }
    assert_eq!(difference.iter().filter(|entry| **entry != 0.0).count(), model.nv() - 6);
}

#[test]
fn a_negative_armature_is_refused() {
    let text = PENDULUM.replace("armature_kgm2 = 0.25", "armature_kgm2 = -0.25");
    let refused = Model::from_toml(&text, "p.toml").unwrap_err().to_string();
    assert_eq!(refused, "p.toml:12: joint \"swing\": armature -0.25 is negative");
}
