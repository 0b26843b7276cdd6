//! Jacobians and bias accelerations against central differences of positions and velocities.
//!
//! A central difference with step ε errs by ε² x'''/6 and by rounding 1e-16/ε: with ε = 1e-5, speeds of 2 rad/s and lengths
//! of a few metres about 1e-8 of the largest entry; the tests allow 1e-7.

#![allow(non_snake_case)]

mod common;

use common::{Random, assert_close, moved, unit};
use legwork_rbd::{Base, Dynamics, Frame, Model, Motion};
use nalgebra::{DMatrix, DVector, Vector3};
use proptest::prelude::*;

const STEP: f64 = 1e-5;
const TOLERANCE: f64 = 1e-7;

fn at(model: &Model, q: &[f64], v: &[f64]) -> Dynamics {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q, v);
    dynamics
}

/// Columns of the difference quotient of `f` along each velocity coordinate.
fn jacobian(model: &Model, q: &[f64], f: impl Fn(&Dynamics) -> Vec<f64>) -> DMatrix<f64> {
    let rest = vec![0.0; model.nv()];
    let columns: Vec<DVector<f64>> = (0..model.nv())
        .map(|j| {
            let e = unit(model.nv(), j);
            let ahead = f(&at(model, &moved(model, q, &e, STEP), &rest));
            let behind = f(&at(model, &moved(model, q, &e, -STEP), &rest));
            (DVector::from_vec(ahead) - DVector::from_vec(behind)) / (2.0 * STEP)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// The rate of `f` while the robot moves with constant `v`.
fn rate(model: &Model, q: &[f64], v: &[f64], f: impl Fn(&Dynamics) -> Vec<f64>) -> Vec<f64> {
    let ahead = f(&at(model, &moved(model, q, v, STEP), v));
    let behind = f(&at(model, &moved(model, q, v, -STEP), v));
    ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
}

fn along(axes: &[Vector3<f64>], vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|vector| axes.iter().map(move |axis| axis.dot(vector))).collect()
}

fn check(model: &Model, q: &[f64], v: &[f64]) {
    let dynamics = at(model, q, v);
    let (linear, angular) = (model.linear_axes(), model.angular_axes());

    let contacts = jacobian(model, q, |d| along(linear, &d.contact_positions));
    assert_close("contact Jacobian", dynamics.contact_jacobian.as_slice(), contacts.as_slice(), TOLERANCE);
    let com = jacobian(model, q, |d| along(linear, &[d.com]));
    assert_close("CoM Jacobian", dynamics.com_jacobian.as_slice(), com.as_slice(), TOLERANCE);
    let potential = jacobian(model, q, |d| vec![d.potential_energy]);
    assert_close("G", dynamics.gravity.as_slice(), potential.as_slice(), TOLERANCE);
    let elastic = jacobian(model, q, |d| vec![d.elastic_energy]);
    assert_close("elastic", dynamics.elastic.as_slice(), elastic.as_slice(), TOLERANCE);
    let mut W = DMatrix::zeros(angular.len(), model.nv());
    for body in 0..model.bodies.len() {
        // ω from Ṙ Rᵀ = [ω]×, column by column of the body's Jacobian
        let R = dynamics.world_from_body[body].rotation;
        let turning = jacobian(model, q, |d| d.world_from_body[body].rotation.as_slice().to_vec());
        dynamics.angular_jacobian(model, body, &mut W);
        for j in 0..model.nv() {
            let rate = nalgebra::Matrix3::from_column_slice(turning.column(j).as_slice()) * R.transpose();
            let omega = Vector3::new(rate[(2, 1)], rate[(0, 2)], rate[(1, 0)]);
            assert_close("angular Jacobian", W.column(j).as_slice(), &along(angular, &[omega]), TOLERANCE);
        }
        let bias = rate(model, q, v, |d| along(angular, &[d.body_velocity[body].angular]));
        assert_close("angular bias", &along(angular, &[dynamics.angular_bias(body)]), &bias, TOLERANCE);
    }

    for name in ["f0", "f1", "f2", "b0"].iter().filter(|name| model.frame(name).is_some()) {
        check_frame(model, q, v, &model.frame(name).unwrap());
    }

    let bias = rate(model, q, v, |d| along(linear, &d.contact_velocities));
    assert_close("contact bias", dynamics.contact_bias.as_slice(), &bias, TOLERANCE);
    let momentum = |d: &Dynamics| (&d.momentum_matrix * DVector::from_column_slice(v)).as_slice().to_vec();
    let bias = rate(model, q, v, momentum);
    assert_close("momentum bias", dynamics.momentum_bias.as_slice(), &bias, TOLERANCE);
    let bias = rate(model, q, v, |d| along(linear, &[d.com_velocity * model.total_mass()]));
    let rows = dynamics.momentum_bias.rows(angular.len(), linear.len()).clone_owned();
    assert_close("CoM bias", rows.as_slice(), &bias, TOLERANCE);
}

/// Pose, velocity, Jacobian and bias of a frame: each is the rate of the one before.
fn check_frame(model: &Model, q: &[f64], v: &[f64], frame: &Frame) {
    let dynamics = at(model, q, v);
    let (linear, angular) = (model.linear_axes(), model.angular_axes());
    let pose = dynamics.frame_pose(frame);
    let velocity = dynamics.frame_velocity(frame);
    let motion = |m: &Motion| [along(angular, &[m.angular]), along(linear, &[m.linear])].concat();

    let moving = rate(model, q, v, |d| d.frame_pose(frame).translation.as_slice().to_vec());
    assert_close("frame velocity", velocity.linear.as_slice(), &moving, TOLERANCE);
    let turning = rate(model, q, v, |d| d.frame_pose(frame).rotation.as_slice().to_vec());
    let omega = velocity.angular.cross_matrix() * pose.rotation;
    assert_close("frame rotation", omega.as_slice(), &turning, TOLERANCE);

    let mut J = DMatrix::zeros(angular.len() + linear.len(), model.nv());
    dynamics.frame_jacobian(model, frame, &mut J);
    let by_jacobian = &J * DVector::from_column_slice(v);
    assert_close("frame Jacobian times v", by_jacobian.as_slice(), &motion(&velocity), 1e-12);
    for j in 0..model.nv() {
        let e = unit(model.nv(), j);
        let column = motion(&at(model, q, &e).frame_velocity(frame));
        assert_close("frame Jacobian", J.column(j).as_slice(), &column, 1e-12);
    }
    let bias = rate(model, q, v, |d| motion(&d.frame_velocity(frame)));
    assert_close("frame bias", &motion(&dynamics.frame_bias(frame)), &bias, TOLERANCE);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_trees(
        seed: u64,
        bodies in 1..8_usize,
        base in prop_oneof![Just(Base::Fixed), Just(Base::Planar), Just(Base::Floating)],
    ) {
        let model = Model::from_toml(&common::random_tree(seed, bodies, base), "tree.toml").unwrap();
        let mut random = Random(!seed);
        if model.nv() > 0 {
            check(&model, &random.q(&model), &random.v(&model));
        }
    }
}

#[test]
fn planar_humanoid_and_biped() {
    for model in [common::planar_humanoid(), common::biped18()] {
        let mut random = Random(5);
        for _ in 0..5 {
            check(&model, &random.q(&model), &random.v(&model));
        }
    }
}

#[test]
fn coriolis_forces_equal_the_thesis_christoffel_form() {
    // Thesis Section 3.2, with the last term ∂M_jk/∂q_i where it prints ∂M_jk/∂q_j (docs/thesis.md)
    let model = common::planar_humanoid();
    let mut random = Random(11);
    for _ in 0..10 {
        let (q, v) = (random.q(&model), random.v(&model));
        let dynamics = at(&model, &q, &v);
        let n = model.nv();
        let dM = jacobian(&model, &q, |d| d.mass_matrix.as_slice().to_vec());
        let dM = |i: usize, j: usize, k: usize| dM[(i + j * n, k)]; // ∂M_ij/∂q_k
        let coriolis: Vec<f64> = (0..n)
            .map(|i| {
                let mut sum = 0.0;
                for j in 0..n {
                    for k in 0..n {
                        sum += 0.5 * (dM(i, j, k) + dM(i, k, j) - dM(j, k, i)) * v[k] * v[j];
                    }
                }
                sum
            })
            .collect();
        let got = &dynamics.bias - &dynamics.gravity;
        assert_close("C v", got.as_slice(), &coriolis, 1e-6);
        // The printed last term is another matrix: this test would notice
        let printed: f64 = (0..n)
            .map(|j| (0..n).map(|k| 0.5 * (dM(0, j, k) + dM(0, k, j) - dM(j, k, j)) * v[k] * v[j]).sum::<f64>())
            .sum();
        assert!((printed - coriolis[0]).abs() > 1e-3);
    }
}
