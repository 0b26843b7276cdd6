//! The same quantity by different routes, on random trees.
//!
//! Tolerances: with bodies of up to 5 kg, 0.5 m and 2 rad/s a quantity is a sum of a few hundred terms of its own
//! magnitude, so rounding leaves about 1e-14 of the largest entry; the tests allow 1e-11.

#![allow(non_snake_case)]

mod common;

use common::{Random, assert_close, rnea, unit};
use legwork_rbd::{Base, Dynamics, Model};
use nalgebra::{DMatrix, DVector, Vector3};
use proptest::prelude::*;

fn any_base() -> impl Strategy<Value = Base> {
    prop_oneof![Just(Base::Fixed), Just(Base::Planar), Just(Base::Floating)]
}

fn random_state(seed: u64, bodies: usize, base: Base) -> (Model, Vec<f64>, Vec<f64>, Dynamics) {
    let text = common::random_tree(seed, bodies, base);
    let model = Model::from_toml(&text, "tree.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let mut random = Random(!seed);
    let (q, v) = (random.q(&model), random.v(&model));
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &q, &v);
    (model, q, v, dynamics)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mass_matrix_and_bias_equal_textbook_newton_euler(seed: u64, bodies in 1..9_usize, base in any_base()) {
        let (model, q, v, dynamics) = random_state(seed, bodies, base);
        let nv = model.nv();
        let rest = vec![0.0; nv];
        for j in 0..nv {
            let column = rnea(&model, &q, &rest, &unit(nv, j), 0.0);
            assert_close("column of M", dynamics.mass_matrix.column(j).as_slice(), column.as_slice(), 1e-11);
        }
        assert_close("h", dynamics.bias.as_slice(), rnea(&model, &q, &v, &rest, model.gravity).as_slice(), 1e-11);
        assert_close("G", dynamics.gravity.as_slice(), rnea(&model, &q, &rest, &rest, model.gravity).as_slice(), 1e-11);
    }

    #[test]
    fn mass_matrix_and_momentum_equal_sums_over_bodies(seed: u64, bodies in 1..9_usize, base in any_base()) {
        let (model, _, v, dynamics) = random_state(seed, bodies, base);
        let (d, nv) = (model.linear_axes().len(), model.nv());
        let angular_axes = model.angular_axes();
        let mut M = DMatrix::zeros(nv, nv);
        let mut A = DMatrix::zeros(angular_axes.len() + d, nv);
        let (mut J, mut W) = (DMatrix::zeros(d, nv), DMatrix::zeros(angular_axes.len(), nv));
        let mut twice_energy = 0.0;
        for (i, body) in model.bodies.iter().enumerate() {
            let pose = &dynamics.world_from_body[i];
            let com = pose.point(&body.com);
            dynamics.point_jacobian(&model, i, &com, &mut J);
            dynamics.angular_jacobian(&model, i, &mut W);
            let inertia = pose.rotation * body.inertia * pose.rotation.transpose();
            let I = DMatrix::from_fn(angular_axes.len(), angular_axes.len(), |r, c| {
                angular_axes[r].dot(&(inertia * angular_axes[c]))
            });
            M += body.mass * J.transpose() * &J + W.transpose() * &I * &W;
            // k = Σ I ω + (c_i − c) × m ċ_i, column by column
            let spin = &I * &W;
            for j in 0..nv {
                let velocity: Vector3<f64> =
                    model.linear_axes().iter().enumerate().map(|(r, axis)| axis * J[(r, j)]).sum();
                let orbit = (com - dynamics.com).cross(&(body.mass * velocity));
                for (r, axis) in angular_axes.iter().enumerate() {
                    A[(r, j)] += spin[(r, j)] + axis.dot(&orbit);
                }
                for r in 0..d {
                    A[(angular_axes.len() + r, j)] += body.mass * J[(r, j)];
                }
            }
            let velocity = dynamics.point_velocity(i, &com);
            let angular = dynamics.body_velocity[i].angular;
            twice_energy += body.mass * velocity.norm_squared() + angular.dot(&(inertia * angular));
            let origin = dynamics.point_velocity(i, &pose.translation);
            assert_close("body velocity", dynamics.body_velocity[i].linear.as_slice(), origin.as_slice(), 1e-12);
        }
        assert_close("M", dynamics.mass_matrix.as_slice(), M.as_slice(), 1e-11);
        assert_close("A", dynamics.momentum_matrix.as_slice(), A.as_slice(), 1e-11);
        let v = DVector::from_vec(v);
        assert_close("energy", &[dynamics.kinetic_energy], &[0.5 * twice_energy], 1e-11);
        assert_close("energy from M", &[dynamics.kinetic_energy], &[0.5 * v.dot(&(&M * &v))], 1e-11);
        let com_velocity = &dynamics.com_jacobian * &v;
        for (r, axis) in model.linear_axes().iter().enumerate() {
            assert_close("CoM velocity", &[axis.dot(&dynamics.com_velocity)], &[com_velocity[r]], 1e-11);
        }
    }

    #[test]
    fn points_move_as_their_jacobians_say(seed: u64, bodies in 1..9_usize, base in any_base()) {
        let (model, _, v, dynamics) = random_state(seed, bodies, base);
        let axes = model.linear_axes();
        let d = axes.len();
        let v = DVector::from_vec(v);
        let contact_velocity = &dynamics.contact_jacobian * &v;
        let mut J = DMatrix::zeros(d, model.nv());
        for (k, contact) in model.contacts.iter().enumerate() {
            let position = dynamics.contact_positions[k];
            let velocity = dynamics.contact_velocities[k];
            dynamics.point_jacobian(&model, contact.body, &position, &mut J);
            let rows = dynamics.contact_jacobian.rows(d * k, d).clone_owned();
            assert_close("point Jacobian", J.as_slice(), rows.as_slice(), 1e-12);
            let point_velocity = dynamics.point_velocity(contact.body, &position);
            assert_close("point velocity", point_velocity.as_slice(), velocity.as_slice(), 1e-12);
            let bias = dynamics.point_bias(contact.body, &position);
            for (r, axis) in axes.iter().enumerate() {
                assert_close("J v", &[contact_velocity[d * k + r]], &[axis.dot(&velocity)], 1e-11);
                assert_close("point bias", &[axis.dot(&bias)], &[dynamics.contact_bias[d * k + r]], 1e-11);
            }
        }
        let mut W = DMatrix::zeros(model.angular_axes().len(), model.nv());
        for (body, velocity) in dynamics.body_velocity.iter().enumerate() {
            dynamics.angular_jacobian(&model, body, &mut W);
            for (axis, turning) in model.angular_axes().iter().zip((&W * &v).iter()) {
                assert_close("W v", &[*turning], &[axis.dot(&velocity.angular)], 1e-12);
            }
        }
    }
}

#[test]
fn planar_robot_stays_in_its_plane_when_turned_to_a_floating_one() {
    // The same planar tree with full inertias, once in the plane and once in space with in-plane motion
    let planar = Model::from_toml(&common::random_tree(7, 6, Base::Planar), "tree.toml").unwrap();
    let text = common::random_tree(7, 6, Base::Planar).replace("base = \"planar\"", "base = \"floating\"");
    let spatial = Model::from_toml(&text, "tree.toml").unwrap();
    let mut random = Random(3);
    let (q, v) = (random.q(&planar), random.v(&planar));
    // The root turned about −y by q[2]; its linear velocity in its own axes
    let (s, c) = (-0.5 * q[2]).sin_cos();
    let mut q3 = vec![c, 0.0, s, 0.0, q[0], 0.0, q[1]];
    q3.extend(&q[3..]);
    let (s, c) = q[2].sin_cos();
    let mut v3 = vec![0.0, -v[2], 0.0, c * v[0] + s * v[1], 0.0, -s * v[0] + c * v[1]];
    v3.extend(&v[3..]);
    let (mut flat, mut full) = (Dynamics::new(&planar), Dynamics::new(&spatial));
    flat.update(&planar, &q, &v);
    full.update(&spatial, &q3, &v3);
    assert_close("energy", &[full.kinetic_energy], &[flat.kinetic_energy], 1e-12);
    assert_close("CoM", full.com.as_slice(), flat.com.as_slice(), 1e-12);
    assert_close("CoM velocity", full.com_velocity.as_slice(), flat.com_velocity.as_slice(), 1e-12);
    let n = v.len();
    let joints = |M: &DMatrix<f64>, k: usize| M.view((k, k), (n - 3, n - 3)).clone_owned();
    assert_close("M", joints(&full.mass_matrix, 6).as_slice(), joints(&flat.mass_matrix, 3).as_slice(), 1e-12);
    assert_close("G", &full.gravity.as_slice()[6..], &flat.gravity.as_slice()[3..], 1e-12);
    for (full, flat) in full.world_from_body.iter().zip(&flat.world_from_body[planar.root()..]) {
        assert_close("orientation", full.rotation.as_slice(), flat.rotation.as_slice(), 1e-12);
    }
}

#[test]
fn the_stages_of_an_update_give_its_bits() {
    for base in [Base::Fixed, Base::Planar, Base::Floating] {
        let (model, q, v, whole) = random_state(7, 8, base);
        let other: Vec<f64> = v.iter().map(|v| 0.5 - v).collect();
        let mut staged = Dynamics::new(&model);
        staged.update_position(&model, &q);
        // Bias at another velocity in between: nothing of it may stay.
        staged.update_bias(&model, &other);
        assert_ne!(staged.bias, whole.bias);
        staged.update_bias(&model, &v);
        assert_eq!(staged.mass_matrix, whole.mass_matrix);
        assert_eq!((&staged.bias, &staged.gravity, &staged.damping), (&whole.bias, &whole.gravity, &whole.damping));
        assert_eq!((&staged.elastic, staged.elastic_energy), (&whole.elastic, whole.elastic_energy));
        assert_eq!(staged.contact_positions, whole.contact_positions);
        assert_eq!(staged.world_from_body, whole.world_from_body);
        assert_eq!(staged.kinetic_energy.to_bits(), whole.kinetic_energy.to_bits());
    }
}

#[test]
fn forces_on_points_and_on_the_centre_of_mass_go_through_their_jacobians() {
    for base in [Base::Fixed, Base::Planar, Base::Floating] {
        let (model, _, v, dynamics) = random_state(11, 8, base);
        let force = if base == Base::Planar { Vector3::new(3.0, 0.0, -2.0) } else { Vector3::new(3.0, 5.0, -2.0) };
        let components =
            DVector::from_iterator(model.linear_axes().len(), model.linear_axes().iter().map(|axis| axis.dot(&force)));
        let mut J = DMatrix::zeros(components.len(), model.nv());
        let (body, point) = (model.bodies.len() - 1, Vector3::new(0.2, 0.0, -0.4));
        dynamics.point_jacobian(&model, body, &point, &mut J);
        let mut out = vec![0.0; model.nv()];
        dynamics.add_point_force(body, &point, &force, &mut out);
        assert_close("on a point", &out, (J.transpose() * &components).as_slice(), 1e-12);
        out.fill(0.0);
        dynamics.add_com_force(&force, &mut out);
        assert_close("on the CoM", &out, (dynamics.com_jacobian.transpose() * &components).as_slice(), 1e-12);

        let chain = dynamics.chain(body);
        let mut sum = Vector3::zeros();
        for &j in &chain {
            sum += dynamics.unit_motion(body, j, &point).linear * v[j];
        }
        let motion = dynamics.motion_at(body, &point);
        assert_close("velocity", sum.as_slice(), motion.linear.as_slice(), 1e-12);
        assert_eq!(motion.linear, dynamics.point_velocity(body, &point));
    }
}
