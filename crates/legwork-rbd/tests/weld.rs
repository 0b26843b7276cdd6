//! A locked joint is one that does not move: mass matrix, bias and places of the other coordinates stay.

use legwork_rbd::{Dynamics, Model};

const URDF: &str = include_str!("data/biped18.urdf");
const SIDE: &str = include_str!("data/biped18.legwork.toml");

#[test]
fn a_welded_model_is_the_free_one_whose_locked_coordinates_rest() {
    let free = Model::from_urdf(URDF, "biped18.urdf", Some((SIDE, "biped18.legwork.toml")), None).unwrap();
    for locked in [&[8][..], &[6, 11, 17], &[17, 6]] {
        let at = |dof: usize| 0.3 - 0.05 * dof as f64;
        let mut welded = free.clone();
        welded.weld(&locked.iter().map(|&dof| (dof, at(dof))).collect::<Vec<_>>());
        let kept: Vec<usize> = (0..free.nv()).filter(|dof| !locked.contains(dof)).collect();
        assert_eq!((welded.nv(), welded.nq()), (kept.len(), kept.len() + 1));
        let names = |model: &Model| model.dofs.iter().map(|dof| dof.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&welded), kept.iter().map(|&dof| names(&free)[dof].clone()).collect::<Vec<_>>());

        let (mut q, mut v) = (free.neutral(), vec![0.0; free.nv()]);
        for dof in 0..free.nv() {
            v[dof] = if locked.contains(&dof) { 0.0 } else { 0.4 - 0.07 * dof as f64 };
            if dof >= 6 {
                q[dof + 1] = if locked.contains(&dof) { at(dof) } else { 0.02 * dof as f64 };
            }
        }
        let q_kept: Vec<f64> =
            (0..7).map(|k| q[k]).chain(kept.iter().filter(|&&dof| dof >= 6).map(|&dof| q[dof + 1])).collect();
        let v_kept: Vec<f64> = kept.iter().map(|&dof| v[dof]).collect();
        let dynamics = |model: &Model, q: &[f64], v: &[f64]| {
            let mut dynamics = Dynamics::new(model);
            dynamics.update(model, q, v);
            dynamics
        };
        let (one, other) = (dynamics(&free, q.as_slice(), &v), dynamics(&welded, &q_kept, &v_kept));
        for (i, &a) in kept.iter().enumerate() {
            assert!((one.bias[a] - other.bias[i]).abs() < 1e-10, "{locked:?}: bias of {a}");
            for (j, &b) in kept.iter().enumerate() {
                assert!(
                    (one.mass_matrix[(a, b)] - other.mass_matrix[(i, j)]).abs() < 1e-11,
                    "{locked:?}: M of {a}, {b}"
                );
            }
        }
        let moved = |a: &Dynamics, b: &Dynamics| {
            let pairs = a.contact_positions.iter().zip(&b.contact_positions);
            pairs.map(|(a, b)| (a - b).norm()).fold((a.com - b.com).norm(), f64::max)
        };
        assert!(moved(&one, &other) < 1e-12);
        // Written and read, it is the same model.
        let again = Model::from_toml(&welded.to_toml(), "again.toml").unwrap();
        assert_eq!((again.nv(), again.to_toml()), (welded.nv(), welded.to_toml()));
    }
}
