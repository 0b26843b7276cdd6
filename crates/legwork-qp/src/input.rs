//! The units of a problem's variables, and what no problem may have.

use crate::linear::{power_of_two, power_of_two_root};
use crate::{Constraint, Defect, Problem};

/// `H` may differ from its transpose by this fraction of `√(H_ii H_jj)` or of the entry itself.
const ASYMMETRY: f64 = 1e-8;

/// The unit of variable `j`, a power of two near `1/√|H_jj|`.
///
/// Where `H_jj` is zero an equality row gives the unit: that which makes the entry as large as the row's largest one of a
/// variable with a unit; the smallest of all such rows; 1 without one.
pub(crate) fn variable_unit(problem: &Problem, j: usize) -> f64 {
    let n = problem.n();
    let from_diagonal = |k: usize| unit_of_cost(problem.hessian()[k * n + k]);
    if let Some(unit) = from_diagonal(j) {
        return unit;
    }
    let mut smallest = f64::INFINITY;
    for i in 0..problem.m() {
        let row = problem.row(i);
        if row[j] == 0.0 || problem.row_lower()[i] < problem.row_upper()[i] {
            continue;
        }
        let largest = (0..n).filter_map(|k| from_diagonal(k).map(|unit| row[k].abs() * unit)).fold(0.0, f64::max);
        if largest > 0.0 {
            smallest = smallest.min(largest / row[j].abs());
        }
    }
    if smallest < f64::INFINITY { power_of_two(smallest) } else { 1.0 }
}

/// The same where `H_jj` is not zero.
pub(crate) fn unit_of_cost(diagonal: f64) -> Option<f64> {
    let diagonal = diagonal.abs();
    (diagonal > 0.0).then(|| 1.0 / power_of_two_root(diagonal))
}

/// Finds what no program may have.
pub(crate) fn check(problem: &Problem) -> Result<(), Defect> {
    let n = problem.n();
    let h = problem.hessian();
    if let Some(k) = h.iter().position(|x| !x.is_finite()) {
        return Err(Defect::Hessian { row: k / n, column: k % n });
    }
    for i in 0..n {
        for j in 0..i {
            let (a, b) = (h[i * n + j], h[j * n + i]);
            let size = a.abs().max(b.abs()).max((h[i * n + i].abs() * h[j * n + j].abs()).sqrt());
            if (a - b).abs() > ASYMMETRY * size {
                return Err(Defect::Asymmetric { row: i, column: j });
            }
        }
    }
    if let Some(index) = problem.gradient().iter().position(|x| !x.is_finite()) {
        return Err(Defect::Gradient { index });
    }
    for row in 0..problem.m() {
        if let Some(column) = problem.row(row).iter().position(|x| !x.is_finite()) {
            return Err(Defect::Row { row, column });
        }
        let (lower, upper) = (problem.row_lower()[row], problem.row_upper()[row]);
        check_bounds(Constraint::Row(row), lower, upper)?;
    }
    for j in 0..n {
        check_bounds(Constraint::Bound(j), problem.lower()[j], problem.upper()[j])?;
    }
    Ok(())
}

fn check_bounds(constraint: Constraint, lower: f64, upper: f64) -> Result<(), Defect> {
    if are_bounds(lower, upper) {
        Ok(())
    } else if lower.is_nan() || upper.is_nan() || lower == f64::INFINITY || upper == f64::NEG_INFINITY {
        Err(Defect::Bound(constraint))
    } else {
        Err(Defect::Crossed(constraint))
    }
}

pub(crate) fn are_bounds(lower: f64, upper: f64) -> bool {
    lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY
}
