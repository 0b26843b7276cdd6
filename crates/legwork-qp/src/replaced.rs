//! Variables that only one equality row contains, which are gone once that row has told what they are.
//!
//! **Without a cost**, as the torques of a program in which they are free. Such a row `aᵀx + e t = b` defines `t`, and its
//! bounds are those of a row of the others: `b − e t_upper <= aᵀx <= b − e t_lower` for `e > 0`. Nothing but `t` is lost, and
//! the Hessian of the others may well be definite, and sparse. With the multiplier `u` of the new row, `λ = u + g_t / e` is
//! that of the old one and `μ = −e u` that of the bounds of `t`, by the stationarity of `t`, `g_t = e λ + μ`.
//!
//! **Without bounds**, as the slack `s` of a task, with a cost `½ h s² + g_s s` of its own. The row `aᵀx + e s = b` makes it a
//! cost of the others, `½ w (b − aᵀx)²` with the weight `w = h / e²` and `−(g_s / e) aᵀx`, and is no constraint any more. With
//! `u = w (b − aᵀx)`, `s = u e / h`, and `λ = u + g_s / e` is the row's multiplier, by the stationarity of `s`,
//! `h s + g_s = e λ`.

use crate::lanes::Span;
use crate::linear::dot;
use crate::working_set::Member;
use crate::{Problem, Side};

/// A variable with the row that defines it, its entry there, and its cost `h`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Replaced {
    pub(crate) variable: usize,
    pub(crate) row: usize,
    pub(crate) entry: f64,
    pub(crate) cost: f64,
}

/// The variables of a problem that rows define, those without a cost first.
#[derive(Clone, Debug)]
pub(crate) struct Replacements {
    pub(crate) all: Vec<Replaced>,
    /// Of each row the position of its variable in `all`, or one beyond all.
    of_row: Vec<usize>,
    /// Of each variable the sum over its rows of [`ONCE`] and the row's index.
    seen: Vec<u64>,
}

/// More than a sum of indices of rows.
const ONCE: u64 = 1 << 40;

impl Replacements {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Self { all: Vec::with_capacity(n), of_row: vec![usize::MAX; m], seen: vec![0; n] }
    }

    pub(crate) fn clear(&mut self) {
        self.all.clear();
        self.of_row.fill(usize::MAX);
    }

    /// The variable that constraint `c` defines.
    #[inline]
    pub(crate) fn of(&self, c: usize) -> Option<Replaced> {
        self.all.get(*self.of_row.get(c)?).copied()
    }

    /// Those with a cost.
    pub(crate) fn slacks(&self) -> &[Replaced] {
        let first = self.all.partition_point(|replaced| replaced.cost == 0.0);
        &self.all[first..]
    }

    /// All variables without a cost, if each can be replaced, or none of them; and all `slacks`, if they are wished.
    /// `rows` and `hessian` are the spans of rows of `A` and `H`.
    pub(crate) fn find(&mut self, problem: &Problem, rows: &[Span], hessian: &[Span], slacks: bool) {
        self.clear();
        let n = problem.n();
        let cost = |j: usize| problem.hessian()[j * (n + 1)];
        let bounds = |j: usize| (problem.lower()[j], problem.upper()[j]);
        let is_slack = |j: usize| cost(j) > 0.0 && bounds(j) == (f64::NEG_INFINITY, f64::INFINITY);
        let is_free = |j: usize| cost(j) == 0.0 && bounds(j).0 < bounds(j).1;
        if !(0..n).any(|j| hessian[j] == Span::one(j) && (is_slack(j) && slacks || is_free(j))) {
            return;
        }
        self.count(problem, rows);
        for j in (0..n).filter(|&j| cost(j) == 0.0) {
            let found =
                if hessian[j] == Span::one(j) && is_free(j) { self.defining_row(problem, rows, j, 0.0) } else { None };
            if !found.is_some_and(|found| self.push(found)) {
                self.clear();
                break;
            }
        }
        for j in (0..n).filter(|&j| slacks && hessian[j] == Span::one(j) && is_slack(j)) {
            if let Some(found) = self.defining_row(problem, rows, j, cost(j)).filter(|found| found.weight().is_normal())
            {
                self.push(found);
            }
        }
    }

    /// In how many rows each variable is, and the sum of their indices.
    fn count(&mut self, problem: &Problem, rows: &[Span]) {
        self.seen.fill(0);
        for (i, span) in rows.iter().enumerate() {
            let entries = span.entries();
            let one = ONCE | i as u64;
            for (seen, a) in self.seen[entries.clone()].iter_mut().zip(&problem.row(i)[entries]) {
                *seen = seen.wrapping_add(if *a != 0.0 { one } else { 0 });
            }
        }
    }

    /// False if the row defines another variable already.
    fn push(&mut self, new: Replaced) -> bool {
        let is_first = self.of_row[new.row] == usize::MAX;
        if is_first {
            self.of_row[new.row] = self.all.len();
            self.all.push(new);
        }
        is_first
    }

    /// The only row with variable `j`, which has this `cost`, if it is an equality with other variables too.
    fn defining_row(&self, problem: &Problem, rows: &[Span], j: usize, cost: f64) -> Option<Replaced> {
        let row = self.seen[j].checked_sub(ONCE).filter(|row| *row < ONCE)? as usize;
        let entry = problem.row(row)[j];
        let is_equality = problem.row_lower()[row] == problem.row_upper()[row];
        let has_others = rows[row] != Span::one(j);
        (is_equality && has_others && entry.is_finite()).then_some(Replaced { variable: j, row, entry, cost })
    }
}

/// Where a row with the given span has other entries than that of variable `j`; `known` is what to expect.
pub(crate) fn without(row: &[f64], span: Span, j: usize, known: Span) -> Span {
    if j + 1 == span.end {
        Span::expected(&row[..j], known)
    } else if j == span.first {
        Span::of(&row[j + 1..]).shifted(j + 1)
    } else {
        span
    }
}

impl Replaced {
    /// `w`: what the square of its row counts.
    pub(crate) fn weight(&self) -> f64 {
        self.cost / (self.entry * self.entry)
    }

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

    /// Value and multiplier of a slack, once `u` stands for the latter.
    pub(crate) fn restore_slack(&self, problem: &Problem, x: &mut [f64], rows: &mut [f64]) {
        x[self.variable] = rows[self.row] * self.entry / self.cost;
        rows[self.row] += problem.gradient()[self.variable] / self.entry;
    }

    /// Value and multipliers of one without a cost, once all others and the new row's multiplier are known.
    pub(crate) fn restore(
        &self,
        problem: &Problem,
        x: &mut [f64],
        rows: &mut [f64],
        bounds: &mut [f64],
        optimal: bool,
    ) {
        let Self { variable: j, row, entry, .. } = *self;
        x[j] = 0.0;
        let rest = dot(problem.row(row), x);
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

#[cfg(test)]
mod tests {
    use super::*;

    const INF: f64 = f64::INFINITY;

    /// `x + y + 2 s = 5` with a slack s that costs 4 s² + 4 s, `x - 4 t = 6` with a free t in −1..3, and a row of x and y alone.
    fn problem() -> Problem {
        let mut problem = Problem::new(4, 3);
        for (j, cost) in [2.0, 1.0, 8.0, 0.0].into_iter().enumerate() {
            problem.hessian_mut()[5 * j] = cost;
        }
        problem.gradient_mut()[2] = 4.0;
        (problem.lower_mut()[3], problem.upper_mut()[3]) = (-1.0, 3.0);
        for (i, (row, lower, upper)) in
            [([1.0, 1.0, 2.0, 0.0], 5.0, 5.0), ([1.0, 0.0, 0.0, -4.0], 6.0, 6.0), ([1.0, 1.0, 0.0, 0.0], -INF, 7.0)]
                .into_iter()
                .enumerate()
        {
            problem.row_mut(i).copy_from_slice(&row);
            (problem.row_lower_mut()[i], problem.row_upper_mut()[i]) = (lower, upper);
        }
        problem
    }

    fn found(problem: &Problem, slacks: bool) -> Replacements {
        let rows: Vec<Span> = (0..3).map(|i| Span::of(problem.row(i))).collect();
        let hessian: Vec<Span> = (0..4).map(Span::one).collect();
        let mut replacements = Replacements::new(4, 3);
        replacements.find(problem, &rows, &hessian, slacks);
        replacements
    }

    #[test]
    fn a_slack_weighs_its_row_and_a_free_variable_bounds_it() {
        let problem = problem();
        let free = Replaced { variable: 3, row: 1, entry: -4.0, cost: 0.0 };
        let slack = Replaced { variable: 2, row: 0, entry: 2.0, cost: 8.0 };
        let all = found(&problem, true);
        assert_eq!((&all.all[..], all.slacks()), (&[free, slack][..], &[slack][..]));
        assert_eq!([0, 1, 2, 3].map(|c| all.of(c)), [Some(slack), Some(free), None, None]);
        assert_eq!(found(&problem, false).all, [free]);
        // w = 8 / 2², and x = 6 + 4 t, which is lowest where t is.
        assert_eq!((slack.weight(), free.row_bounds(&problem)), (2.0, (2.0, 18.0)));
        assert_eq!([free.turned(1.0), free.turned(-1.0)], [1.0, -1.0]);
        assert_eq!([slack.turned(1.0), slack.turned(-1.0)], [-1.0, 1.0]);
        // With u = 3: 8 s = 2 u, and 8 s + 4 = 2 λ.
        let (mut x, mut multipliers) = ([0.0; 4], [3.0, 0.0, 0.0]);
        slack.restore_slack(&problem, &mut x, &mut multipliers);
        assert_eq!((x[2], multipliers[0]), (0.75, 5.0));
    }

    #[test]
    fn what_a_second_row_or_a_bound_holds_is_no_slack_and_defines_nothing() {
        let slack = |change: &dyn Fn(&mut Problem)| {
            let mut problem = problem();
            change(&mut problem);
            let found = found(&problem, true);
            (found.all.len() - found.slacks().len(), found.slacks().len())
        };
        assert_eq!(slack(&|_| {}), (1, 1));
        assert_eq!(slack(&|problem| problem.row_mut(2)[2] = 1.0), (1, 0));
        assert_eq!(slack(&|problem| problem.lower_mut()[2] = 0.0), (1, 0));
        assert_eq!(slack(&|problem| problem.upper_mut()[2] = 9.0), (1, 0));
        assert_eq!(slack(&|problem| problem.row_upper_mut()[0] = 5.5), (1, 0));
        assert_eq!(slack(&|problem| problem.row_mut(0)[..2].fill(0.0)), (1, 0));
        assert_eq!(slack(&|problem| problem.row_mut(2)[3] = 1.0), (0, 1));
        assert_eq!(slack(&|problem| problem.lower_mut()[3] = 3.0), (0, 1));
        assert_eq!(slack(&|problem| problem.row_upper_mut()[1] = 6.5), (0, 1));
    }
}
