//! From a [`Problem`] to the scaled program, all but its Hessian; the units of variables, and what no problem may have.

use crate::lanes::{self, Lanes, Span, WIDTH};
use crate::linear::{max_abs, power_of_two, power_of_two_root};
use crate::replaced;
use crate::scale::{Kind, Scaled, are_finite};
use crate::{Constraint, Defect, Problem};

/// `H` may differ from its transpose by this fraction of `√(H_ii H_jj)` or of the entry itself.
const ASYMMETRY: f64 = 1e-8;

impl Scaled {
    /// Fills itself from `problem`, but for the Hessian, or tells what is wrong with it. The Hessian may still be found
    /// wrong by [`Scaled::load_hessian`]. With `slacks` these are replaced, and every error may be one without them.
    pub(crate) fn load(&mut self, problem: &Problem, slacks: bool) -> Result<(), Defect> {
        let (n, m) = (self.n, self.m);
        self.replaced.clear();
        if (problem.n(), problem.m()) != (n, m) {
            return Err(Defect::WrongSize { expected: (n, m), found: (problem.n(), problem.m()) });
        }
        self.survey(problem, slacks);
        self.load_units(problem)?;
        let mut sound = true;
        let of_bounds = self.lower[m..].iter_mut().zip(&mut self.upper[m..]).zip(&mut self.kind[m..]);
        let of_variables = self.unit.as_flattened().iter().zip(self.gradient.as_flattened_mut());
        let given = problem.gradient().iter().zip(problem.lower().iter().zip(problem.upper()));
        for ((((low, up), kind), (unit, slope)), (g, (lower, upper))) in of_bounds.zip(of_variables).zip(given) {
            *slope = g * unit;
            sound &= slope.is_finite() && are_bounds(*lower, *upper);
            let inverse = 1.0 / unit;
            (*low, *up) = (lower * inverse, upper * inverse);
            *kind = Kind::of(*low, *up);
        }
        sound &= self.load_rows(problem);
        self.replace(problem);
        if sound {
            return Ok(());
        }
        check(problem)?;
        let row = |i: usize| &self.rows[i * self.width..][self.span[i].lanes()];
        let finite = are_finite(&self.gradient) && (0..m).all(|i| are_finite(row(i)));
        if finite { Ok(()) } else { Err(Defect::Overflow) }
    }

    /// Where the problem's numbers are, most often where they were, and which variables rows define.
    fn survey(&mut self, problem: &Problem, slacks: bool) {
        for (i, known) in self.row_span.iter_mut().enumerate() {
            *known = Span::expected(problem.row(i), *known);
        }
        let rows = problem.hessian().chunks_exact(self.n.max(1));
        for (i, (row, known)) in rows.zip(&mut self.hessian_span).enumerate() {
            let span = Span::expected(row, *known).union(Span::one(i));
            self.blocks_known &= span == *known;
            *known = span;
        }
        self.replaced.find(problem, &self.row_span, &self.hessian_span, slacks);
        for (i, (known, span)) in self.span.iter_mut().zip(&self.row_span).enumerate() {
            *known = match self.replaced.of(i) {
                Some(replaced) => replaced::without(problem.row(i), *span, replaced.variable, *known),
                None => *span,
            };
        }
    }

    /// The units make the diagonal of the Hessian one, with the costs of slacks that have become costs of others.
    fn load_units(&mut self, problem: &Problem) -> Result<(), Defect> {
        let n = self.n;
        let diagonal = &mut self.unit.as_flattened_mut()[..n];
        for (j, diagonal) in diagonal.iter_mut().enumerate() {
            *diagonal = problem.hessian()[j * (n + 1)];
        }
        let slacks = self.replaced.slacks();
        for slack in slacks {
            let (weight, entries) = (slack.weight(), self.span[slack.row].entries());
            let own = diagonal[slack.variable];
            for (diagonal, a) in diagonal[entries.clone()].iter_mut().zip(&problem.row(slack.row)[entries]) {
                *diagonal += weight * (a * a);
            }
            diagonal[slack.variable] = own;
        }
        if !slacks.is_empty() && !diagonal.iter().all(|diagonal| diagonal.is_finite()) {
            return Err(Defect::Overflow);
        }
        for j in 0..n {
            let unit = unit_of_cost(self.unit.as_flattened()[j]);
            self.unit.as_flattened_mut()[j] = unit.unwrap_or_else(|| self.unit_without_cost(problem, j));
        }
        Ok(())
    }

    fn unit_without_cost(&self, problem: &Problem, j: usize) -> f64 {
        let is_replaced = self.replaced.all.iter().any(|replaced| replaced.variable == j);
        if is_replaced { 1.0 } else { variable_unit(problem, j) }
    }

    /// Leaves nothing of the variables that rows define but their share in the gradient.
    fn replace(&mut self, problem: &Problem) {
        for k in 0..self.replaced.all.len() {
            let replaced = self.replaced.all[k];
            self.kind[self.m + replaced.variable] = Kind::Free;
            let mut gradient = std::mem::take(&mut self.gradient);
            gradient.as_flattened_mut()[replaced.variable] = 0.0;
            let slope = problem.gradient()[replaced.variable];
            if slope != 0.0 {
                self.add_to(replaced.row, -slope / (replaced.entry * self.row_factor[replaced.row]), &mut gradient);
            }
            self.gradient = gradient;
        }
    }

    /// False if something may be wrong.
    fn load_rows(&mut self, problem: &Problem) -> bool {
        let mut sound = true;
        for i in 0..self.m {
            let lanes = self.span[i].lanes();
            let (unit, entries) = (&self.unit[lanes.clone()], WIDTH * lanes.start..self.n.min(WIDTH * lanes.end));
            let row = &mut self.rows[i * self.width..][lanes.clone()];
            let given = &problem.row(i)[entries.clone()];
            let (mut lower, mut upper) = (problem.row_lower()[i], problem.row_upper()[i]);
            sound &= are_bounds(lower, upper);
            let defined = self.replaced.of(i);
            let removed = defined.map(|replaced| replaced.variable).filter(|j| entries.contains(j));
            let load = |factor: f64, row: &mut [Lanes]| {
                let squares = lanes::load_product(factor, unit, given, row);
                let Some(j) = removed else {
                    return squares;
                };
                row.as_flattened_mut()[j - entries.start] = 0.0;
                lanes::dot(row, row)
            };
            // Most often the factor is that of the solve before.
            let mut factor = self.row_factor[i];
            let mut squares = load(factor, row);
            let mut empty = false;
            if !(1.0..4.0).contains(&squares) {
                squares = load(1.0, row);
                (factor, empty) = unit_factor(row, squares);
                lanes::scale(factor, row);
            }
            if let Some(replaced) = defined.filter(|replaced| replaced.cost == 0.0) {
                (lower, upper) = replaced.row_bounds(problem);
            }
            (lower, upper) = (lower * factor, upper * factor);
            (self.row_factor[i], self.lower[i], self.upper[i]) = (factor, lower, upper);
            self.kind[i] = match Kind::of(lower, upper) {
                _ if defined.is_some_and(|replaced| replaced.cost > 0.0) => Kind::Free,
                Kind::Free => Kind::Free,
                _ if empty => Kind::Empty,
                kind => kind,
            };
            sound &= squares < f64::INFINITY;
        }
        sound
    }
}

/// What makes the norm of a row one, or up to two, and whether it is zero.
fn unit_factor(row: &[Lanes], squares: f64) -> (f64, bool) {
    if (1e-200..1e200).contains(&squares) {
        return (1.0 / power_of_two_root(squares), false);
    }
    // By the largest entry first, so that the squares neither over- nor underflow.
    let largest = max_abs(row.as_flattened());
    if largest > 0.0 {
        let factor = 1.0 / power_of_two(largest);
        let squares = row.as_flattened().iter().map(|a| (a * factor) * (a * factor)).sum::<f64>();
        (factor / power_of_two_root(squares), false)
    } else {
        (1.0, true)
    }
}

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
