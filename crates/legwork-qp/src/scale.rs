//! The program in scaled variables `z = D x` and with rows of unit norm.
//!
//! `D` makes the Hessian's diagonal one (Jacobi), so that the norms of rows and steps compare what is comparable. All
//! factors are powers of two: scaling rounds nothing, and a residual of the scaled program is one of the original.

use crate::linear::{axpy, dot, dot_abs, max_abs, power_of_two};
use crate::{Constraint, Defect, Problem};

/// `H` may differ from its transpose by this fraction of `√(H_ii H_jj)` or of the entry itself.
const ASYMMETRY: f64 = 1e-8;

/// What a row or bound asks for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// Both sides infinite.
    Free,
    Inequality,
    Equality,
    /// A row without a nonzero entry: true or false whatever `z` is.
    Empty,
}

/// The scaled program. Constraints have one index: rows `0..m`, then bounds `m..m + n`.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    pub(crate) n: usize,
    pub(crate) m: usize,
    /// Scaled Hessian, symmetrised.
    pub(crate) hessian: Vec<f64>,
    pub(crate) gradient: Vec<f64>,
    rows: Vec<f64>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) kind: Vec<Kind>,
    /// `D⁻¹`: `x_j = unit_j z_j`.
    pub(crate) unit: Vec<f64>,
    /// What each row was multiplied by after the scaling of the variables.
    pub(crate) row_factor: Vec<f64>,
}

impl Scaled {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Self {
            n,
            m,
            hessian: vec![0.0; n * n],
            gradient: vec![0.0; n],
            rows: vec![0.0; m * n],
            lower: vec![f64::NEG_INFINITY; m + n],
            upper: vec![f64::INFINITY; m + n],
            kind: vec![Kind::Free; m + n],
            unit: vec![1.0; n],
            row_factor: vec![1.0; m],
        }
    }

    /// Fills itself from `problem`, or tells what is wrong with it.
    pub(crate) fn load(&mut self, problem: &Problem) -> Result<(), Defect> {
        let (n, m) = (self.n, self.m);
        if (problem.n(), problem.m()) != (n, m) {
            return Err(Defect::WrongSize { expected: (n, m), found: (problem.n(), problem.m()) });
        }
        check(problem)?;
        for j in 0..n {
            self.unit[j] = variable_unit(problem, j);
        }
        let h = problem.hessian();
        for i in 0..n {
            for j in 0..=i {
                let entry = (0.5 * h[i * n + j] + 0.5 * h[j * n + i]) * self.unit[i] * self.unit[j];
                self.hessian[i * n + j] = entry;
                self.hessian[j * n + i] = entry;
            }
            self.gradient[i] = problem.gradient()[i] * self.unit[i];
            self.lower[m + i] = problem.lower()[i] / self.unit[i];
            self.upper[m + i] = problem.upper()[i] / self.unit[i];
            self.kind[m + i] = self.kind_of(m + i, false);
        }
        for i in 0..m {
            self.load_row(problem, i);
        }
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        if finite(&self.hessian) && finite(&self.gradient) && finite(&self.rows) {
            Ok(())
        } else {
            Err(Defect::Overflow)
        }
    }

    fn load_row(&mut self, problem: &Problem, i: usize) {
        let row = &mut self.rows[i * self.n..(i + 1) * self.n];
        for ((scaled, a), unit) in row.iter_mut().zip(problem.row(i)).zip(&self.unit) {
            *scaled = a * unit;
        }
        // First by the largest entry, so that the squares neither over- nor underflow.
        let largest = max_abs(row);
        let mut factor = 1.0;
        if largest > 0.0 {
            factor = 1.0 / power_of_two(largest);
            let norm = row.iter().map(|a| (a * factor) * (a * factor)).sum::<f64>().sqrt();
            factor /= power_of_two(norm);
            for a in row.iter_mut() {
                *a *= factor;
            }
        }
        self.row_factor[i] = factor;
        self.lower[i] = problem.row_lower()[i] * factor;
        self.upper[i] = problem.row_upper()[i] * factor;
        self.kind[i] = self.kind_of(i, largest == 0.0);
    }

    fn kind_of(&self, c: usize, empty: bool) -> Kind {
        let (lower, upper) = (self.lower[c], self.upper[c]);
        if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
            Kind::Free
        } else if empty {
            Kind::Empty
        } else if lower >= upper {
            Kind::Equality
        } else {
            Kind::Inequality
        }
    }

    /// Number of constraints.
    pub(crate) fn constraints(&self) -> usize {
        self.m + self.n
    }

    pub(crate) fn constraint(&self, c: usize) -> Constraint {
        if c < self.m { Constraint::Row(c) } else { Constraint::Bound(c - self.m) }
    }

    /// What a multiplier of the scaled constraint `c` must be multiplied by to be one of the original.
    pub(crate) fn multiplier_factor(&self, c: usize) -> f64 {
        if c < self.m { self.row_factor[c] } else { 1.0 / self.unit[c - self.m] }
    }

    pub(crate) fn row(&self, c: usize) -> &[f64] {
        &self.rows[c * self.n..(c + 1) * self.n]
    }

    /// `a_cᵀ v`.
    pub(crate) fn times(&self, c: usize, v: &[f64]) -> f64 {
        if c < self.m { dot(self.row(c), v) } else { v[c - self.m] }
    }

    /// `∑ |a_cj v_j|`.
    pub(crate) fn times_abs(&self, c: usize, v: &[f64]) -> f64 {
        if c < self.m { dot_abs(self.row(c), v) } else { v[c - self.m].abs() }
    }

    /// `v += alpha a_c`.
    pub(crate) fn add_to(&self, c: usize, alpha: f64, v: &mut [f64]) {
        if c < self.m {
            axpy(alpha, self.row(c), v);
        } else {
            v[c - self.m] += alpha;
        }
    }
}

/// The unit of variable `j`, a power of two near `1/√|H_jj|`.
///
/// Where `H_jj` is zero an equality row gives the unit: that which makes the entry as large as the row's largest one of a
/// variable with a unit; the smallest of all such rows; 1 without one.
pub(crate) fn variable_unit(problem: &Problem, j: usize) -> f64 {
    let n = problem.n();
    let from_diagonal = |k: usize| {
        let diagonal = problem.hessian()[k * n + k].abs();
        (diagonal > 0.0).then(|| 1.0 / power_of_two(diagonal.sqrt()))
    };
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

/// Finds what no program may have.
fn check(problem: &Problem) -> Result<(), Defect> {
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
    if lower.is_nan() || upper.is_nan() || lower == f64::INFINITY || upper == f64::NEG_INFINITY {
        Err(Defect::Bound(constraint))
    } else if lower > upper {
        Err(Defect::Crossed(constraint))
    } else {
        Ok(())
    }
}
