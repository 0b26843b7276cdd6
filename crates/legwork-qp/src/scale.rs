//! The program in scaled variables `z = D x` and with rows of unit norm.
//!
//! `D` makes the Hessian's diagonal one (Jacobi), so that the norms of rows and steps compare what is comparable. All
//! factors are powers of two: scaling rounds nothing, and a residual of the scaled program is one of the original.

use crate::input::{are_bounds, check, unit_of_cost, variable_unit};
use crate::lanes::{self, Lanes, Span, WIDTH, zeros};
use crate::linear::{max_abs, power_of_two, power_of_two_root};
use crate::replaced::{self, Replaced};
use crate::working_set::Member;
use crate::{Constraint, Defect, Problem};

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

impl Kind {
    /// Of a constraint with nonzero entries.
    #[inline]
    fn of(lower: f64, upper: f64) -> Self {
        if lower >= upper {
            Self::Equality
        } else if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
            Self::Free
        } else {
            Self::Inequality
        }
    }
}

/// The scaled program. Constraints have one index: rows `0..m`, then bounds `m..m + n`.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    pub(crate) n: usize,
    pub(crate) m: usize,
    pub(crate) width: usize,
    /// Scaled Hessian, symmetrised, by rows; valid within blocks.
    pub(crate) hessian: Vec<Lanes>,
    /// Of a block-diagonal Hessian, with the squares, the block that each variable is in.
    pub(crate) block: Vec<Span>,
    /// Where the rows of the Hessian are not zero.
    pub(crate) hessian_span: Vec<Span>,
    pub(crate) gradient: Vec<Lanes>,
    rows: Vec<Lanes>,
    /// Where a row is not zero; of a bound, its variable.
    pub(crate) span: Vec<Span>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) kind: Vec<Kind>,
    /// Variables that equality rows define: zero here, with a cost of one, while the rows hold their bounds.
    pub(crate) replaced: Vec<Replaced>,
    /// Equalities whose squares are added to the Hessian.
    pub(crate) squared: Vec<usize>,
    /// `D⁻¹`: `x_j = unit_j z_j`.
    pub(crate) unit: Vec<Lanes>,
    /// What each row was multiplied by after the scaling of the variables.
    pub(crate) row_factor: Vec<f64>,
}

impl Scaled {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        let width = zeros(n).len();
        Self {
            n,
            m,
            width,
            hessian: zeros(WIDTH * width * n),
            block: vec![Span::EMPTY; n],
            hessian_span: vec![Span::EMPTY; n],
            gradient: zeros(n),
            rows: zeros(WIDTH * width * m),
            span: (0..m).map(|_| Span::EMPTY).chain((0..n).map(Span::one)).collect(),
            lower: vec![f64::NEG_INFINITY; m + n],
            upper: vec![f64::INFINITY; m + n],
            kind: vec![Kind::Free; m + n],
            replaced: Vec::with_capacity(n),
            squared: Vec::with_capacity(m + n),
            unit: zeros(n),
            row_factor: vec![1.0; m],
        }
    }

    /// Fills itself from `problem`, but for the Hessian, or tells what is wrong with it. The Hessian may still be found
    /// wrong by [`Scaled::load_hessian`].
    pub(crate) fn load(&mut self, problem: &Problem) -> Result<(), Defect> {
        let (n, m) = (self.n, self.m);
        self.replaced.clear();
        if (problem.n(), problem.m()) != (n, m) {
            return Err(Defect::WrongSize { expected: (n, m), found: (problem.n(), problem.m()) });
        }
        replaced::find(problem, &mut self.replaced);
        let mut sound = true;
        let (hessian, gradient) = (problem.hessian(), problem.gradient());
        for j in 0..n {
            let unit = unit_of_cost(hessian[j * n + j]).unwrap_or_else(|| self.unit_without_cost(problem, j));
            self.unit.as_flattened_mut()[j] = unit;
        }
        let of_bounds = self.lower[m..].iter_mut().zip(&mut self.upper[m..]).zip(&mut self.kind[m..]);
        let of_variables = self.unit.as_flattened().iter().zip(self.gradient.as_flattened_mut());
        let given = gradient.iter().zip(problem.lower().iter().zip(problem.upper()));
        for ((((low, up), kind), (unit, slope)), (g, (lower, upper))) in of_bounds.zip(of_variables).zip(given) {
            *slope = g * unit;
            sound &= slope.is_finite() && are_bounds(*lower, *upper);
            let inverse = 1.0 / unit;
            (*low, *up) = (lower * inverse, upper * inverse);
            *kind = Kind::of(*low, *up);
        }
        for i in 0..m {
            sound &= self.load_row(problem, i);
        }
        self.replace(problem);
        if sound {
            return Ok(());
        }
        check(problem)?;
        let row = |i: usize| &self.rows[i * self.width..][self.span[i].lanes()];
        let finite = are_finite(&self.gradient) && (0..m).all(|i| are_finite(row(i)));
        if finite { Ok(()) } else { Err(Defect::Overflow) }
    }

    fn unit_without_cost(&self, problem: &Problem, j: usize) -> f64 {
        if self.replaced.is_empty() { variable_unit(problem, j) } else { 1.0 }
    }

    /// Leaves nothing of the variables that rows define but their share in the gradient.
    fn replace(&mut self, problem: &Problem) {
        for k in 0..self.replaced.len() {
            let Replaced { variable, row, entry } = self.replaced[k];
            self.kind[self.m + variable] = Kind::Free;
            let mut gradient = std::mem::take(&mut self.gradient);
            gradient.as_flattened_mut()[variable] = 0.0;
            self.add_to(row, -problem.gradient()[variable] / (entry * self.row_factor[row]), &mut gradient);
            self.gradient = gradient;
        }
    }

    /// The variable that row `c` defines.
    pub(crate) fn defines(&self, c: usize) -> Option<Replaced> {
        self.replaced.iter().copied().find(|replaced| replaced.row == c)
    }

    /// A bound of a variable that a row defines is a side of that row.
    pub(crate) fn translated(&self, member: Member) -> Member {
        match self.replaced.iter().find(|replaced| self.m + replaced.variable == member.c) {
            Some(replaced) => Member { c: replaced.row, sign: replaced.turned(member.sign) },
            None => member,
        }
    }

    /// False if something may be wrong.
    fn load_row(&mut self, problem: &Problem, i: usize) -> bool {
        let defined = self.defines(i);
        let span = match defined {
            Some(replaced) => replaced::without(problem.row(i), replaced.variable),
            None => Span::expected(problem.row(i), self.span[i]),
        };
        self.span[i] = span;
        let sound = are_bounds(problem.row_lower()[i], problem.row_upper()[i]);
        let (lower, upper) = match defined {
            Some(replaced) => replaced.row_bounds(problem),
            None => (problem.row_lower()[i], problem.row_upper()[i]),
        };
        if span == Span::EMPTY {
            (self.row_factor[i], self.lower[i], self.upper[i]) = (1.0, lower, upper);
            let free = Kind::of(lower, upper) == Kind::Free;
            self.kind[i] = if free { Kind::Free } else { Kind::Empty };
            return sound;
        }
        let lanes = span.lanes();
        let row = &mut self.rows[i * self.width..][lanes.clone()];
        let source = &problem.row(i)[WIDTH * lanes.start..self.n.min(WIDTH * lanes.end)];
        let removed = defined.map(|replaced| replaced.variable).filter(|j| lanes.contains(&lanes::lane(*j)));
        let load = |factor: f64, row: &mut [Lanes]| {
            lanes::load_product(factor, &self.unit[lanes.clone()], source, row);
            if let Some(j) = removed {
                row.as_flattened_mut()[j - WIDTH * lanes.start] = 0.0;
            }
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
        let (lower, upper) = (lower * factor, upper * factor);
        (self.row_factor[i], self.lower[i], self.upper[i]) = (factor, lower, upper);
        self.kind[i] = match Kind::of(lower, upper) {
            Kind::Free => Kind::Free,
            _ if empty => Kind::Empty,
            kind => kind,
        };
        squares < f64::INFINITY && sound
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
        if c < self.m { self.row_factor[c] } else { 1.0 / self.unit()[c - self.m] }
    }

    /// `D⁻¹`: `x_j = unit_j z_j`.
    pub(crate) fn unit(&self) -> &[f64] {
        &self.unit.as_flattened()[..self.n]
    }

    /// Row `i` of the Hessian, valid within the block of `i`.
    pub(crate) fn hessian_row(&self, i: usize) -> &[Lanes] {
        &self.hessian[i * self.width..][..self.width]
    }

    /// Row `c` of `A`, valid within its span; none for a bound.
    pub(crate) fn row(&self, c: usize) -> Option<&[Lanes]> {
        (c < self.m).then(|| &self.rows[c * self.width..][..self.width])
    }

    /// `(H v)_i`.
    pub(crate) fn hessian_times(&self, i: usize, v: &[Lanes]) -> f64 {
        let lanes = self.block[i].lanes();
        lanes::dot(&self.hessian_row(i)[lanes.clone()], &v[lanes])
    }

    /// `a_cᵀ v`.
    pub(crate) fn times(&self, c: usize, v: &[Lanes]) -> f64 {
        if c < self.m {
            let lanes = self.span[c].lanes();
            lanes::dot(&self.rows[c * self.width..][lanes.clone()], &v[lanes])
        } else {
            v.as_flattened()[c - self.m]
        }
    }

    /// Calls `with` the index of each inequality, and by how much `a_cᵀz` is below its lower and above its upper side.
    #[inline]
    pub(crate) fn for_each_inequality(&self, z: &[Lanes], mut with: impl FnMut(usize, f64, f64)) {
        let (row_lower, lower) = self.lower.split_at(self.m);
        let (row_upper, upper) = self.upper.split_at(self.m);
        let (row_kind, kind) = self.kind.split_at(self.m);
        let rows = self.rows.chunks_exact(self.width.max(1)).zip(&self.span);
        for (c, (((row, span), kind), (lower, upper))) in
            rows.zip(row_kind).zip(row_lower.iter().zip(row_upper)).enumerate()
        {
            if *kind == Kind::Inequality {
                let lanes = span.lanes();
                let value = lanes::dot(&row[lanes.clone()], &z[lanes]);
                with(c, lower - value, value - upper);
            }
        }
        let bounds = kind.iter().zip(lower.iter().zip(upper));
        for (c, (value, (kind, (lower, upper)))) in (self.m..).zip(z.as_flattened().iter().zip(bounds)) {
            if *kind == Kind::Inequality {
                with(c, lower - value, value - upper);
            }
        }
    }

    /// `∑ |a_cj v_j|`.
    pub(crate) fn times_abs(&self, c: usize, v: &[Lanes]) -> f64 {
        if c < self.m {
            let lanes = self.span[c].lanes();
            lanes::dot_abs(&self.rows[c * self.width..][lanes.clone()], &v[lanes])
        } else {
            v.as_flattened()[c - self.m].abs()
        }
    }

    /// `v += alpha a_c`.
    pub(crate) fn add_to(&self, c: usize, alpha: f64, v: &mut [Lanes]) {
        if c < self.m {
            let lanes = self.span[c].lanes();
            lanes::axpy(alpha, &self.rows[c * self.width..][lanes.clone()], &mut v[lanes]);
        } else {
            v.as_flattened_mut()[c - self.m] += alpha;
        }
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

pub(crate) fn are_finite(numbers: &[Lanes]) -> bool {
    numbers.as_flattened().iter().all(|x| x.is_finite())
}
