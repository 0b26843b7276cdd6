//! Variables without a cost that only one equality row contains, as the torques of a program in which they are free.
//!
//! Such a row `aᵀx + e t = b` defines `t`, and its bounds are those of a row of the others: `b − e t_upper <= aᵀx <= b − e t_lower`
//! for `e > 0`. Nothing but `t` is lost, and the Hessian of the others may well be definite, and sparse. With the multiplier
//! `u` of the new row, `λ = u + g_t / e` is that of the old one and `μ = −e u` that of the bounds of `t`, by the
//! stationarity of `t`, `g_t = e λ + μ`.

use crate::lanes::Span;
use crate::working_set::Member;
use crate::{Problem, Side};

/// A variable with the row that defines it, and its entry there.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Replaced {
    pub(crate) variable: usize,
    pub(crate) row: usize,
    pub(crate) entry: f64,
}

/// All variables without a cost, if each can be replaced; or none.
pub(crate) fn find(problem: &Problem, found: &mut Vec<Replaced>) {
    found.clear();
    for j in 0..problem.n() {
        if problem.hessian()[j * problem.n() + j] == 0.0 {
            match defining_row(problem, j).filter(|new| found.iter().all(|old| old.row != new.row)) {
                Some(new) => found.push(new),
                None => {
                    found.clear();
                    return;
                }
            }
        }
    }
}

fn defining_row(problem: &Problem, j: usize) -> Option<Replaced> {
    let n = problem.n();
    let mut rows = (0..problem.m()).filter(|&i| problem.row(i)[j] != 0.0);
    let row = rows.next()?;
    let entry = problem.row(row)[j];
    let alone = rows.next().is_none() && Span::of(&problem.hessian()[j * n..(j + 1) * n]) == Span::EMPTY;
    let is_equality = problem.row_lower()[row] == problem.row_upper()[row];
    let has_others = without(problem.row(row), j) != Span::EMPTY;
    let is_free = problem.lower()[j] < problem.upper()[j];
    (alone && is_equality && has_others && is_free && entry.is_finite()).then_some(Replaced { variable: j, row, entry })
}

/// Where a row has other entries than that of variable `j`.
pub(crate) fn without(row: &[f64], j: usize) -> Span {
    let (before, after) = (Span::of(&row[..j]), Span::of(&row[j + 1..]));
    if after == Span::EMPTY {
        return before;
    }
    before.union(Span { first: after.first + j + 1, end: after.end + j + 1 })
}

impl Replaced {
    /// The bounds of the new row.
    pub(crate) fn row_bounds(&self, problem: &Problem) -> (f64, f64) {
        let b = problem.row_lower()[self.row];
        let ends = [problem.lower(), problem.upper()].map(|bounds| b - self.entry * bounds[self.variable]);
        if self.entry > 0.0 { (ends[1], ends[0]) } else { (ends[0], ends[1]) }
    }

    /// The sign of the new row's side that is the given side of the variable, and the other way round.
    pub(crate) fn turned(&self, sign: f64) -> f64 {
        -sign * self.entry.signum()
    }

    /// The variable's side at which the new row is.
    pub(crate) fn side(&self, member: Member) -> Side {
        if self.turned(member.sign) > 0.0 { Side::Lower } else { Side::Upper }
    }

    /// Value and multipliers, once all others and the new row's multiplier are known.
    pub(crate) fn restore(
        &self,
        problem: &Problem,
        x: &mut [f64],
        rows: &mut [f64],
        bounds: &mut [f64],
        optimal: bool,
    ) {
        let Self { variable: j, row, entry } = *self;
        let of_others = problem.row(row).iter().zip(&*x).enumerate().filter(|(k, _)| *k != j);
        let rest: f64 = of_others.map(|(_, (a, x))| a * x).sum();
        let value = (problem.row_lower()[row] - rest) / entry;
        bounds[j] = -entry * rows[row];
        rows[row] += problem.gradient()[j] / entry;
        let (lower, upper) = (problem.lower()[j], problem.upper()[j]);
        x[j] = match optimal {
            true if bounds[j] > 0.0 => lower,
            true if bounds[j] < 0.0 => upper,
            true => value.clamp(lower, upper),
            false => value,
        };
    }
}
