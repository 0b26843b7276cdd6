//! Held against Pinocchio 4.1: 25 states of the planar humanoid, 5 of a floating biped with 18 degrees of freedom.
//!
//! Both sides work in double precision, so they differ by rounding alone; 1e-10 of the largest entry leaves a thousandfold
//! margin and is far below what any wrong term would make.

#![allow(non_snake_case)]

mod common;

use common::{assert_close, crate_path, moved};
use legwork_rbd::{Dynamics, Model};
use nalgebra::DMatrix;
use serde_json::Value;

const TOLERANCE: f64 = 1e-10;

fn vector(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Column by column.
fn matrix(value: &Value) -> Vec<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(vector).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]).as_slice().to_vec()
}

fn cases(file: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(crate_path("tests/data").join(file)).unwrap();
    let data: Value = serde_json::from_str(&text).unwrap();
    data["cases"].as_array().unwrap().clone()
}

/// Jacobian and bias of a body's angular velocity along the angular axes.
fn turning(model: &Model, dynamics: &Dynamics, body: &str) -> (Vec<f64>, Vec<f64>) {
    let (body, axes) = (model.body_index(body).unwrap(), model.angular_axes());
    let mut jacobian = DMatrix::zeros(axes.len(), model.nv());
    dynamics.angular_jacobian(model, body, &mut jacobian);
    (jacobian.as_slice().to_vec(), axes.iter().map(|axis| axis.dot(&dynamics.angular_bias(body))).collect())
}

#[test]
fn planar_humanoid_agrees_with_pinocchio() {
    let model = common::planar_humanoid();
    let cases = cases("planar7_dynamics.json");
    assert_eq!(cases.len(), 25);
    let mut dynamics = Dynamics::new(&model);
    for case in cases {
        let (q, v) = (vector(&case["q"]), vector(&case["qd"]));
        dynamics.update(&model, &q, &v);
        assert_close("M", dynamics.mass_matrix.as_slice(), &matrix(&case["M"]), TOLERANCE);
        assert_close("h", dynamics.bias.as_slice(), &vector(&case["h"]), TOLERANCE);
        assert_close("J", dynamics.contact_jacobian.as_slice(), &matrix(&case["J"]), TOLERANCE);
        assert_close("Jdqd", dynamics.contact_bias.as_slice(), &vector(&case["Jdqd"]), TOLERANCE);
        assert_close("A", dynamics.momentum_matrix.as_slice(), &matrix(&case["A"]), TOLERANCE);
        assert_close("Adqd", dynamics.momentum_bias.as_slice(), &vector(&case["Adqd"]), TOLERANCE);
        assert_close("com", &[dynamics.com.x, dynamics.com.z], &vector(&case["com"]), TOLERANCE);
        assert_close("vcom", &[dynamics.com_velocity.x, dynamics.com_velocity.z], &vector(&case["vcom"]), TOLERANCE);
        let feet: Vec<f64> = dynamics.contact_positions.iter().flat_map(|foot| [foot.x, foot.z]).collect();
        assert_close("feet", &feet, &vector(&case["feet"]), TOLERANCE);
        let (S_c, s_a) = turning(&model, &dynamics, "torso");
        assert_close("S_c", &S_c, &[0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0], 1e-15);
        assert_close("torso bias", &s_a, &[0.0], 1e-15);
    }
}

#[test]
fn floating_biped_agrees_with_pinocchio() {
    let model = common::biped18();
    let cases = cases("biped18_vectors.json");
    assert_eq!(cases.len(), 5);
    let mut dynamics = Dynamics::new(&model);
    for case in cases {
        let (q, v) = (vector(&case["q"]), vector(&case["v"]));
        dynamics.update(&model, &q, &v);
        assert_close("M", dynamics.mass_matrix.as_slice(), &matrix(&case["M"]), TOLERANCE);
        assert_close("h", dynamics.bias.as_slice(), &vector(&case["h"]), TOLERANCE);
        assert_close("G", dynamics.gravity.as_slice(), &vector(&case["G"]), TOLERANCE);
        assert_close("A", dynamics.momentum_matrix.as_slice(), &matrix(&case["A"]), TOLERANCE);
        assert_close("Adv", dynamics.momentum_bias.as_slice(), &vector(&case["Adv"]), TOLERANCE);
        assert_close("com", dynamics.com.as_slice(), &vector(&case["com"]), TOLERANCE);
        assert_close("vcom", dynamics.com_velocity.as_slice(), &vector(&case["vcom"]), TOLERANCE);
        assert_close("Jcom", dynamics.com_jacobian.as_slice(), &matrix(&case["Jcom"]), TOLERANCE);
        assert_close("J", dynamics.contact_jacobian.as_slice(), &matrix(&case["J"]), TOLERANCE);
        assert_close("Jdv", dynamics.contact_bias.as_slice(), &vector(&case["Jdv"]), TOLERANCE);
        let contacts: Vec<f64> = dynamics.contact_positions.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        assert_close("contacts", &contacts, &vector(&case["contacts"]), TOLERANCE);
        let (J, Jdv) = turning(&model, &dynamics, "trunk");
        assert_close("torso J", &J, &matrix(&case["torso_J"]), TOLERANCE);
        assert_close("torso Jdv", &Jdv, &vector(&case["torso_Jdv"]), TOLERANCE);
        assert_close("energy", &[dynamics.kinetic_energy], &[case["kinetic_energy"].as_f64().unwrap()], TOLERANCE);
        let end = moved(&model, &q, &v, 0.1);
        assert_close("integrate", &end, &vector(&case["q_after_0.1_s"]), TOLERANCE);
    }
}
