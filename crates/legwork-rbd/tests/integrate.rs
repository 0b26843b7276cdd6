//! Positions: the exponential map of a floating base, quaternions, places far from the origin.

#![allow(non_snake_case)]

mod common;

use common::{Random, assert_close, moved};
use legwork_rbd::{Base, Dynamics, Model};

fn norm(q: &[f64]) -> f64 {
    q[..4].iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn quaternion_comes_out_with_unit_length() {
    let model = common::biped18();
    let mut random = Random(8);
    let v = random.v(&model);
    let mut q = random.q(&model);
    let mut unit = Dynamics::new(&model);
    unit.update(&model, &q, &v);
    let next = moved(&model, &q, &v, 1e-3);
    // A quaternion that has drifted means the same rotation
    q[..4].iter_mut().for_each(|x| *x *= 1.7);
    let mut drifted = Dynamics::new(&model);
    drifted.update(&model, &q, &v);
    assert_close("M", drifted.mass_matrix.as_slice(), unit.mass_matrix.as_slice(), 1e-14);
    q = moved(&model, &q, &v, 1e-3);
    assert_close("next", &q, &next, 1e-14);
    assert!((norm(&q) - 1.0).abs() < 1e-15);
    for _ in 0..100_000 {
        q = moved(&model, &q, &v, 1e-3);
    }
    assert!((norm(&q) - 1.0).abs() < 1e-15);
}

#[test]
fn constant_twist_is_followed_exactly() {
    let model = common::biped18();
    let mut random = Random(9);
    let q = random.q(&model);
    let v = random.v(&model);
    // One step, a thousand steps, and back; both branches of the series
    let once = moved(&model, &q, &v, 0.5);
    let mut often = q.clone();
    for _ in 0..1000 {
        often = moved(&model, &often, &v, 0.5e-3);
    }
    assert_close("steps", &often, &once, 1e-12);
    assert_close("back", &moved(&model, &once, &v, -0.5), &q, 1e-14);
    // A full turn about z while moving forward is a circle: back at the start, quaternion −1
    let mut spin = vec![0.0; model.nv()];
    (spin[2], spin[3]) = (std::f64::consts::TAU, 1.0);
    let start = model.neutral().as_slice().to_vec();
    let end = moved(&model, &start, &spin, 1.0);
    let mut opposite = start.clone();
    opposite[0] = -1.0;
    assert_close("circle", &end, &opposite, 1e-14);
    let half = moved(&model, &start, &spin, 0.5);
    let diameter = 1.0 / std::f64::consts::PI;
    assert_close("half a circle", &half[4..7], &[0.0, diameter, 0.0], 1e-15);
}

#[test]
fn series_meets_the_closed_form_at_its_border() {
    let model = common::biped18();
    let q = model.neutral().as_slice().to_vec();
    let mut v = vec![0.0; model.nv()];
    (v[0], v[1], v[4], v[5]) = (0.6, 0.8, 1.0, -2.0);
    let below = moved(&model, &q, &v, 1e-2 * (1.0 - 1e-12));
    let above = moved(&model, &q, &v, 1e-2 * (1.0 + 1e-12));
    assert_close("border", &above, &below, 1e-13);
}

/// A turn by φ about z while moving forward: the quaternion `(cos φ/2, 0, 0, sin φ/2)`, and the place `(sin φ, 1 − cos φ) / φ`. All of
/// these to their last digits, from where the series is used to where it is not.
#[test]
fn small_turns_have_the_digits_of_their_closed_form() {
    let model = common::biped18();
    let q = model.neutral().as_slice().to_vec();
    for turn in [1e-4_f64, 1e-3, 5e-3, 9.9e-3, 1.1e-2, 0.1] {
        let mut v = vec![0.0; model.nv()];
        (v[2], v[3]) = (turn, 1.0);
        let next = moved(&model, &q, &v, 1.0);
        let (sin, cos) = (0.5 * turn).sin_cos();
        let expected = [(0, cos), (3, sin), (4, turn.sin() / turn), (5, 2.0 * sin * sin / turn)];
        for (index, expected) in expected {
            let relative = (next[index] / expected - 1.0).abs();
            assert!(relative < 1e-15, "{turn} rad: {} instead of {expected}", next[index]);
        }
        assert!([1, 2, 6].iter().all(|&index| next[index] == 0.0));
    }
}

/// A robot a kilometre away has the same dynamics to the last bit: everything is computed near its own root.
#[test]
fn dynamics_do_not_depend_on_the_place() {
    for model in [common::planar_humanoid(), common::biped18()] {
        let mut random = Random(10);
        let (q, v) = (random.q(&model), random.v(&model));
        let mut far = q.clone();
        // 1000 m in x, as exact as the doubles there are
        let x = if model.base == Base::Floating { 4 } else { 0 };
        far[x] = q[x] + 1000.0;
        let (mut near, mut distant) = (Dynamics::new(&model), Dynamics::new(&model));
        near.update(&model, &q, &v);
        distant.update(&model, &far, &v);
        assert_eq!(near.mass_matrix, distant.mass_matrix);
        assert_eq!(near.bias, distant.bias);
        assert_eq!(near.momentum_matrix, distant.momentum_matrix);
        assert_eq!(near.momentum_bias, distant.momentum_bias);
        assert_eq!(near.contact_jacobian, distant.contact_jacobian);
        assert_eq!(near.contact_bias, distant.contact_bias);
        assert_eq!(near.com_velocity, distant.com_velocity);
        assert_eq!(near.contact_velocities, distant.contact_velocities);
        assert!((distant.com.x - near.com.x - 1000.0).abs() < 1e-12);
        // A point given in the world is itself rounded to 1e-13 m there
        let mut J = nalgebra::DMatrix::zeros(model.linear_axes().len(), model.nv());
        distant.point_jacobian(&model, model.contacts[1].body, &distant.contact_positions[1], &mut J);
        let d = model.linear_axes().len();
        let rows = near.contact_jacobian.rows(d, d).clone_owned();
        assert_close("point Jacobian", J.as_slice(), rows.as_slice(), 1e-12);
    }
}

#[test]
fn names_and_neutral_position() {
    let planar = common::planar_humanoid();
    let names = ["base_x", "base_z", "base_pitch", "right_knee", "right_hip", "left_hip", "left_knee"];
    assert_eq!(planar.q_names(), names);
    assert_eq!(planar.v_names(), names);
    assert_eq!(planar.actuated().collect::<Vec<_>>(), [3, 4, 5, 6]);
    assert!((planar.total_mass() - 72.5).abs() < 1e-12);
    assert!(planar.neutral().iter().all(|x| *x == 0.0));
    let limits: Vec<[f64; 2]> =
        planar.dofs[2..].iter().map(|dof| [dof.lower.to_degrees(), dof.upper.to_degrees()]).collect();
    let table_c1 = [[-175.0, 175.0], [10.0, 175.0], [-175.0, 175.0], [-300.0, -60.0], [-175.0, -10.0]];
    for (limits, table) in limits.iter().zip(&table_c1) {
        assert_close("Table C.1", limits, table, 1e-15);
    }
    assert!(planar.dofs[0].lower.is_infinite() && planar.dofs[3].effort_limit.is_infinite());

    let spatial = common::biped18();
    assert_eq!((spatial.nq(), spatial.nv()), (19, 18));
    assert_eq!(spatial.q_names()[..7], ["base_qw", "base_qx", "base_qy", "base_qz", "base_x", "base_y", "base_z"]);
    assert_eq!(spatial.v_names()[..6], ["base_wx", "base_wy", "base_wz", "base_vx", "base_vy", "base_vz"]);
    assert_eq!(spatial.q_names()[7..], spatial.v_names()[6..]);
    assert_close("neutral", &spatial.neutral().as_slice()[..2], &[1.0, 0.0], 0.0);
    assert_eq!(spatial.actuated().count(), 12);
}

#[test]
fn wrong_lengths_and_foreign_scratch_are_refused() {
    let (planar, spatial) = (common::planar_humanoid(), common::biped18());
    let panics = |f: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(f)).is_err();
    let update = |model: &Model, scratch: &Model, nq: usize, nv: usize| {
        Dynamics::new(scratch).update(model, &vec![0.0; nq], &vec![0.0; nv]);
    };
    assert!(!panics(&|| update(&planar, &planar, 7, 7)));
    assert!(panics(&|| update(&planar, &planar, 8, 7)));
    assert!(panics(&|| update(&planar, &planar, 7, 6)));
    assert!(panics(&|| update(&planar, &spatial, 7, 7)));
    assert!(panics(&|| planar.integrate(&[0.0; 7], &[0.0; 7], 1.0, &mut [0.0; 6])));
}
