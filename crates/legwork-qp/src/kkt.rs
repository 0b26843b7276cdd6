//! How far a point and its multipliers are from the optimality conditions of Karush, Kuhn and Tucker, from the problem's
//! own data alone: nothing of the solver enters but the rule for the units of the variables.

use crate::Problem;
use crate::input::variable_unit;
use crate::linear::{dot, dot_abs};

/// Where the terms of a component nearly vanish, its residual is compared with this fraction of the largest ones.
const FLOOR: f64 = 1e-4;

/// An error in the unit of the data, and the same as a fraction of what it is the error of.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Residual {
    /// Largest absolute value, in the unit of the data.
    pub absolute: f64,
    /// Largest value after scaling as [`KktResiduals`] says.
    pub relative: f64,
}

impl Residual {
    /// NaN counts as infinite.
    fn raise(&mut self, absolute: f64, scale: f64) {
        if absolute.abs() > 0.0 || absolute.is_nan() {
            let relative = absolute.abs() / scale;
            let or_infinite = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
            self.absolute = self.absolute.max(or_infinite(absolute.abs()));
            self.relative = self.relative.max(or_infinite(relative));
        }
    }
}

/// What [`Problem::kkt`] finds.
///
/// The relative residuals do not change with the units of variables, rows and objective. They use units `u_j = 1/√H_jj` of
/// the variables, rounded to powers of two (where `H_jj = 0`: from the equality rows), and `z_max`, the
/// largest `|x_j| / u_j` or `|g_j| u_j`.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct KktResiduals {
    /// `Hx + g − Aᵀλ − μ`. Relative: each component to `t_j`, the sum of the absolute values of its terms, but to no less
    /// than 1e-4 of the largest `t_k u_k / u_j`.
    pub stationarity: Residual,
    /// Violation of rows and bounds. Relative: to `|b| + ∑ |a_j x_j|`, but to no less than 1e-4 of `z_max ∑ |a_j| u_j`;
    /// to 1 for a row without a nonzero entry.
    pub primal: Residual,
    /// Multipliers of a sign whose side is infinite. Relative: what they add to `t_j u_j`, to the largest of these.
    pub dual: Residual,
    /// `λ` times the distance to the side that its sign names. Relative: to the sum of the absolute values of all terms
    /// of the objective and of `λ (|b| + ∑ |a_j x_j|)`, but to no less than 1e-4 `z_max²`.
    pub complementarity: Residual,
}

impl KktResiduals {
    /// The largest of the four relative residuals.
    pub fn worst_relative(&self) -> f64 {
        let Self { stationarity, primal, dual, complementarity } = self;
        let both = stationarity.relative.max(primal.relative);
        both.max(dual.relative).max(complementarity.relative)
    }
}

/// A row or bound at a point.
struct Condition {
    /// `a x` and `∑ |a_j x_j|`.
    value: f64,
    size: f64,
    /// `∑ |a_j| u_j` and the largest of these terms.
    reach: f64,
    largest: f64,
    lower: f64,
    upper: f64,
    multiplier: f64,
}

impl Problem {
    /// Residuals of the optimality conditions at `x` (length n), with multipliers of the rows (length m) and of the bounds
    /// (length n): `Hx + g = Aᵀλ + μ`, positive at a lower, negative at an upper side.
    pub fn kkt(&self, x: &[f64], row_multipliers: &[f64], bound_multipliers: &[f64]) -> KktResiduals {
        let mut residuals = KktResiduals::default();
        let (n, m) = (self.n(), self.m());
        let stationarity = |j: usize| {
            let row = &self.hessian()[j * n..(j + 1) * n];
            let (g, mu) = (self.gradient()[j], bound_multipliers[j]);
            let mut sum = dot(row, x) + g - mu;
            let mut size = dot_abs(row, x) + g.abs() + mu.abs();
            for i in 0..m {
                let term = self.row(i)[j] * row_multipliers[i];
                sum -= term;
                size += term.abs();
            }
            (sum, size)
        };
        let (mut z_max, mut steepest) = (0.0_f64, 0.0_f64);
        let mut terms = 0.0;
        for j in 0..n {
            let unit = variable_unit(self, j);
            z_max = z_max.max(x[j].abs() / unit).max(self.gradient()[j].abs() * unit);
            steepest = steepest.max(stationarity(j).1 * unit);
            let row = &self.hessian()[j * n..(j + 1) * n];
            terms += x[j].abs() * (dot_abs(row, x) + self.gradient()[j].abs());
        }
        for j in 0..n {
            let (sum, size) = stationarity(j);
            residuals.stationarity.raise(sum, size.max(FLOOR * steepest / variable_unit(self, j)));
        }
        let conditions = || {
            let rows = (0..m).map(|i| self.row_condition(i, x, row_multipliers[i]));
            rows.chain((0..n).map(|j| self.bound_condition(j, x[j], bound_multipliers[j])))
        };
        for condition in conditions() {
            let side = if condition.multiplier > 0.0 { condition.lower } else { condition.upper };
            if side.is_finite() {
                terms += condition.multiplier.abs() * (side.abs() + condition.size);
            }
        }
        terms = terms.max(FLOOR * z_max * z_max);
        for Condition { value, size, reach, largest, lower, upper, multiplier } in conditions() {
            for (violation, bound) in [(lower - value, lower), (value - upper, upper)] {
                if violation > 0.0 || violation.is_nan() {
                    let scale = (bound.abs() + size).max(FLOOR * z_max * reach);
                    residuals.primal.raise(violation, if reach > 0.0 { scale } else { 1.0 });
                }
            }
            let side = if multiplier > 0.0 { lower } else { upper };
            if multiplier.abs() > 0.0 || multiplier.is_nan() {
                if side.is_finite() {
                    residuals.complementarity.raise(multiplier * (value - side), terms);
                } else {
                    residuals.dual.raise(multiplier, steepest / largest);
                }
            }
        }
        residuals
    }

    fn row_condition(&self, i: usize, x: &[f64], multiplier: f64) -> Condition {
        let row = self.row(i);
        let (mut reach, mut largest) = (0.0, 0.0_f64);
        for (j, a) in row.iter().enumerate() {
            if a.abs() > 0.0 {
                let term = a.abs() * variable_unit(self, j);
                reach += term;
                largest = largest.max(term);
            }
        }
        Condition {
            value: dot(row, x),
            size: dot_abs(row, x),
            reach,
            largest,
            lower: self.row_lower()[i],
            upper: self.row_upper()[i],
            multiplier,
        }
    }

    fn bound_condition(&self, j: usize, x: f64, multiplier: f64) -> Condition {
        let unit = variable_unit(self, j);
        Condition {
            value: x,
            size: x.abs(),
            reach: unit,
            largest: unit,
            lower: self.lower()[j],
            upper: self.upper()[j],
            multiplier,
        }
    }
}
