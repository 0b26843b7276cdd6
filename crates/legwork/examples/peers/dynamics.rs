//! All dynamic quantities of a state.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use legwork_rbd::{Base, Dynamics, Model};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::files::{Table, answer};
use crate::models::load;

/// Random states in legwork's coordinates: q, then v. Joints lie within their limits, as far as they have any.
pub(crate) fn states(model: &str, count: usize, out: &Path) -> Result<(), Box<dyn Error>> {
    let model = load(model)?;
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut table = Table::new(model.nq() + model.nv());
    for _ in 0..count {
        let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let mut q = model.neutral();
        if model.base == Base::Floating {
            for value in q.as_mut_slice()[..4].iter_mut() {
                *value += uniform(-0.5, 0.5);
            }
            let norm = q.rows(0, 4).norm();
            q.rows_mut(0, 4).scale_mut(1.0 / norm);
            for value in q.as_mut_slice()[4..7].iter_mut() {
                *value = uniform(-1.0, 1.0);
            }
        }
        for dof in model.dofs.iter().skip(if model.base == Base::Floating { 6 } else { 0 }) {
            q[model.bodies[dof.body].q_index] = uniform(dof.lower.max(-1.0), dof.upper.min(1.0).max(dof.lower));
        }
        let v: Vec<f64> = (0..model.nv()).map(|_| uniform(-1.0, 1.0)).collect();
        table.push(q.iter().copied().chain(v));
    }
    Ok(table.write(out)?)
}

/// Answers: M (row by row), h, contact Jacobian (row by row), its J̇ v, A (row by row), Ȧ v, centre of mass.
pub(crate) fn time(model: &str, states: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    let model = load(model)?;
    let states = Table::read(states)?;
    let mut dynamics = Dynamics::new(&model);
    let mut answers = Table::new(3 + values(&dynamics).len());
    for row in states.rows().take(200) {
        let (q, v) = row.split_at(model.nq());
        dynamics.update(&model, q, v);
    }
    for row in states.rows() {
        let (q, v) = row.split_at(model.nq());
        let begin = Instant::now();
        update(&mut dynamics, &model, q, v);
        let seconds = begin.elapsed().as_secs_f64();
        answers.push(answer(seconds, true, 0, values(&dynamics)));
    }
    Ok(answers.write(out)?)
}

fn update(dynamics: &mut Dynamics, model: &Model, q: &[f64], v: &[f64]) {
    dynamics.update(black_box(model), black_box(q), black_box(v));
    black_box(dynamics);
}

fn values(dynamics: &Dynamics) -> Vec<f64> {
    let by_rows = |matrix: &nalgebra::DMatrix<f64>| matrix.transpose().as_slice().to_vec();
    let parts = [
        by_rows(&dynamics.mass_matrix),
        dynamics.bias.as_slice().to_vec(),
        by_rows(&dynamics.contact_jacobian),
        dynamics.contact_bias.as_slice().to_vec(),
        by_rows(&dynamics.momentum_matrix),
        dynamics.momentum_bias.as_slice().to_vec(),
        dynamics.com.as_slice().to_vec(),
    ];
    parts.concat()
}
