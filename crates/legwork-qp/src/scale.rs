//! The program in scaled variables `z = D x` and with rows of unit norm.
//!
//! `D` makes the Hessian's diagonal one (Jacobi), so that the norms of rows and steps compare what is comparable. All
//! factors are powers of two: scaling rounds nothing, and a residual of the scaled program is one of the original.

use std::ops::Range;

use crate::Constraint;
use crate::lanes::{self, Lanes, Span, WIDTH, zeros};
use crate::replaced::Replacements;
use crate::working_set::Member;

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
    pub(crate) fn of(lower: f64, upper: f64) -> Self {
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
    /// Scaled Hessian, symmetrised, by rows. Four rows are valid, with zeros, in the lanes of all their blocks.
    pub(crate) hessian: Vec<Lanes>,
    /// Of a block-diagonal Hessian, with the squares, the block that each variable is in.
    pub(crate) block: Vec<Span>,
    /// The blocks are those of the Hessian without squares.
    pub(crate) blocks_known: bool,
    /// Where the rows of the Hessian are not zero.
    pub(crate) hessian_span: Vec<Span>,
    pub(crate) gradient: Vec<Lanes>,
    pub(crate) rows: Vec<Lanes>,
    /// Where the problem's rows are not zero.
    pub(crate) row_span: Vec<Span>,
    /// Where a row is not zero; of a bound, its variable.
    pub(crate) span: Vec<Span>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) kind: Vec<Kind>,
    /// Variables that equality rows define: zero here, with a cost of one, while the rows hold their bounds or costs.
    pub(crate) replaced: Replacements,
    /// Equalities whose squares are added to the Hessian, with weights: rows of slacks in their order, then others.
    pub(crate) squared: Vec<(usize, f64)>,
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
            hessian: vec![[0.0; WIDTH]; width * width * WIDTH],
            block: vec![Span::EMPTY; n],
            blocks_known: false,
            hessian_span: vec![Span::EMPTY; n],
            gradient: zeros(n),
            rows: vec![[0.0; WIDTH]; width * m],
            row_span: vec![Span::EMPTY; m],
            span: (0..m).map(|_| Span::EMPTY).chain((0..n).map(Span::one)).collect(),
            lower: vec![f64::NEG_INFINITY; m + n],
            upper: vec![f64::INFINITY; m + n],
            kind: vec![Kind::Free; m + n],
            replaced: Replacements::new(n, m),
            squared: Vec::with_capacity(m + n),
            unit: zeros(n),
            row_factor: vec![1.0; m],
        }
    }

    /// A bound of a variable that a row defines is a side of that row.
    pub(crate) fn translated(&self, member: Member) -> Member {
        match self.replaced.all.iter().find(|replaced| self.m + replaced.variable == member.c) {
            Some(replaced) => Member { c: replaced.row, sign: replaced.turned(member.sign) },
            None => member,
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

    /// The lanes of the blocks of the rows in lane `i`.
    pub(crate) fn hessian_group(&self, i: usize) -> Range<usize> {
        let (first, last) = (self.block[i * WIDTH], self.block[self.n.min((i + 1) * WIDTH) - 1]);
        first.union(last).lanes()
    }

    /// Row `c` of `A`, valid within its span; none for a bound.
    pub(crate) fn row(&self, c: usize) -> Option<&[Lanes]> {
        (c < self.m).then(|| &self.rows[c * self.width..][..self.width])
    }

    /// Lane `i` of `H v`.
    pub(crate) fn hessian_times(&self, i: usize, v: &[Lanes]) -> Lanes {
        let lanes = self.hessian_group(i);
        lanes::dots(lanes::four_rows(&self.hessian, self.width, i, &lanes), &v[lanes])
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

pub(crate) fn are_finite(numbers: &[Lanes]) -> bool {
    numbers.as_flattened().iter().all(|x| x.is_finite())
}
