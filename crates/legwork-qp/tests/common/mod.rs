//! Families of programs, and what every answer must satisfy.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part")]

pub mod families;
pub mod recorded;

use legwork_qp::{Conflict, Constraint, Problem, Side, Solver};

/// SplitMix64.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [a, b).
    pub fn uniform(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Near normal, mean 0, deviation 1.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform(-0.5, 0.5)).sum()
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.uniform(0.0, 1.0) < p
    }

    /// In `0..end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// Uniform in the exponent.
    pub fn magnitude(&mut self, lowest: f64, highest: f64) -> f64 {
        10f64.powf(self.uniform(lowest, highest))
    }
}

/// Relative KKT residuals of the solver's answer are all below `tolerance`, bounds and the signs of multipliers hold
/// exactly; or a message.
pub fn kkt_below(problem: &Problem, solver: &Solver, tolerance: f64) -> Result<(), String> {
    let residuals = problem.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
    if residuals.worst_relative() >= tolerance || residuals.dual.absolute > 0.0 {
        return Err(format!("{residuals:?}"));
    }
    for (j, x) in solver.x().iter().enumerate() {
        if *x < problem.lower()[j] || *x > problem.upper()[j] {
            return Err(format!("variable {j} is {x}"));
        }
    }
    Ok(())
}

/// Is the conflict a proof, from the problem's own data?
///
/// `∑ weight s a` must vanish, and `∑ weight s b` be positive by more than what is left of the former can make up for, with
/// variables up to `reach` in size. That rest must be below 1e-9 of its terms.
pub fn conflict_proves(problem: &Problem, conflict: &[Conflict], reach: &[f64]) -> Result<(), String> {
    if conflict.is_empty() {
        return Err("no conflict".into());
    }
    let n = problem.n();
    let (mut sum, mut size, mut gap, mut gap_size) = (vec![0.0; n], vec![0.0; n], 0.0, 0.0);
    for &Conflict { constraint, side, weight } in conflict {
        if weight.is_nan() || weight <= 0.0 {
            return Err(format!("weight {weight} of {constraint:?}"));
        }
        let sign = if side == Side::Lower { 1.0 } else { -1.0 };
        let bound = match (constraint, side) {
            (_, Side::Equal) => return Err("a conflict names a side".into()),
            (Constraint::Row(i), Side::Lower) => problem.row_lower()[i],
            (Constraint::Row(i), Side::Upper) => problem.row_upper()[i],
            (Constraint::Bound(j), Side::Lower) => problem.lower()[j],
            (Constraint::Bound(j), Side::Upper) => problem.upper()[j],
        };
        match constraint {
            Constraint::Row(i) => {
                for (j, a) in problem.row(i).iter().enumerate() {
                    sum[j] += weight * sign * a;
                    size[j] += (weight * a).abs();
                }
            }
            Constraint::Bound(j) => {
                sum[j] += weight * sign;
                size[j] += weight;
            }
        }
        gap += weight * sign * bound;
        gap_size += (weight * bound).abs();
    }
    let total = |terms: &[f64]| terms.iter().zip(reach).map(|(a, x)| (a * x).abs()).sum::<f64>();
    let (rest, terms) = (total(&sum), total(&size));
    if rest > 1e-9 * terms {
        return Err(format!("{rest:e} of {terms:e} remains"));
    }
    let slack = rest + 1e-12 * gap_size;
    if gap > slack { Ok(()) } else { Err(format!("gap {gap:e}, slack {slack:e}, terms {gap_size:e}")) }
}
