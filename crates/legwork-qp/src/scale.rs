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

/// Which equalities' squares are added to the Hessian.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Squares {
    None,
    /// Of those with an entry at a variable without a cost.
    OfFreeVariables,
    All,
}

/// The scaled program. Constraints have one index: rows `0..m`, then bounds `m..m + n`.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    pub(crate) n: usize,
    pub(crate) m: usize,
    width: usize,
    /// Scaled Hessian, symmetrised, by rows; valid within blocks.
    hessian: Vec<Lanes>,
    /// Of a block-diagonal Hessian, with the squares, the block that each variable is in.
    pub(crate) block: Vec<Span>,
    /// Where the rows of the Hessian are not zero.
    hessian_span: Vec<Span>,
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
    unit: Vec<Lanes>,
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
        for j in 0..n {
            let cost = problem.hessian()[j * n + j];
            let unit = unit_of_cost(cost).unwrap_or_else(|| self.unit_without_cost(problem, j));
            self.unit.as_flattened_mut()[j] = unit;
            let gradient = problem.gradient()[j] * unit;
            self.gradient.as_flattened_mut()[j] = gradient;
            let (lower, upper) = (problem.lower()[j], problem.upper()[j]);
            sound &= gradient.is_finite() && are_bounds(lower, upper);
            self.lower[m + j] = lower / unit;
            self.upper[m + j] = upper / unit;
            self.kind[m + j] = self.kind_of(m + j, false);
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
            None => Span::of(problem.row(i)),
        };
        self.span[i] = span;
        let sound = are_bounds(problem.row_lower()[i], problem.row_upper()[i]);
        let (lower, upper) = match defined {
            Some(replaced) => replaced.row_bounds(problem),
            None => (problem.row_lower()[i], problem.row_upper()[i]),
        };
        if span == Span::EMPTY {
            (self.row_factor[i], self.lower[i], self.upper[i]) = (1.0, lower, upper);
            self.kind[i] = self.kind_of(i, true);
            return sound;
        }
        let lanes = span.lanes();
        let row = &mut self.rows[i * self.width..][lanes.clone()];
        let source = &problem.row(i)[WIDTH * lanes.start..self.n.min(WIDTH * lanes.end)];
        lanes::load_product(1.0, &self.unit[lanes.clone()], source, row);
        if let Some(replaced) = defined.filter(|replaced| lanes.contains(&lanes::lane(replaced.variable))) {
            row.as_flattened_mut()[replaced.variable - WIDTH * lanes.start] = 0.0;
        }
        let squares = lanes::dot(row, row);
        let mut factor = 1.0;
        let mut empty = true;
        if (1e-200..1e200).contains(&squares) {
            factor = 1.0 / power_of_two_root(squares);
            empty = false;
        } else {
            // By the largest entry first, so that the squares neither over- nor underflow.
            let largest = max_abs(row.as_flattened());
            if largest > 0.0 {
                factor = 1.0 / power_of_two(largest);
                let squares = row.as_flattened().iter().map(|a| (a * factor) * (a * factor)).sum::<f64>();
                factor /= power_of_two_root(squares);
                empty = false;
            }
        }
        lanes::scale(factor, row);
        self.row_factor[i] = factor;
        self.lower[i] = lower * factor;
        self.upper[i] = upper * factor;
        self.kind[i] = self.kind_of(i, empty);
        squares < f64::INFINITY && sound
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

    /// Fills in the Hessian with the blocks that it and the squares of equalities make.
    pub(crate) fn load_hessian(&mut self, problem: &Problem, squares: Squares) -> Result<(), Defect> {
        let n = self.n;
        let h = problem.hessian();
        self.choose_squares(problem, squares);
        for (i, row) in h.chunks_exact(n.max(1)).enumerate() {
            self.hessian_span[i] = Span::of(row).union(Span::one(i));
        }
        self.find_blocks();
        let mut regular = true;
        for i in 0..n {
            for j in self.block[i].first..i {
                let (a, b) = (h[i * n + j], h[j * n + i]);
                regular &= (a - b).abs() <= 2.0 * f64::EPSILON * a.abs();
            }
            regular &= h[i * n + i].is_finite();
            let lanes = self.block[i].lanes();
            let source = &h[i * n..(i + 1) * n][WIDTH * lanes.start..n.min(WIDTH * lanes.end)];
            let row = &mut self.hessian[i * self.width..][lanes.clone()];
            lanes::load_product(self.unit.as_flattened()[i], &self.unit[lanes], source, row);
        }
        for replaced in &self.replaced {
            self.hessian[replaced.variable * self.width..].as_flattened_mut()[replaced.variable] = 1.0;
        }
        if regular { Ok(()) } else { self.symmetrise(problem) }
    }

    /// A closer look at a Hessian with what is not a finite number, or with more than rounding errors between its triangles.
    fn symmetrise(&mut self, problem: &Problem) -> Result<(), Defect> {
        check(problem)?;
        let matrix = self.hessian.as_flattened_mut();
        let stride = WIDTH * self.width;
        for i in 0..self.n {
            for j in self.block[i].first..i {
                let mean = 0.5 * matrix[i * stride + j] + 0.5 * matrix[j * stride + i];
                matrix[i * stride + j] = mean;
                matrix[j * stride + i] = mean;
            }
        }
        let finite = (0..self.n).all(|i| are_finite(&self.hessian_row(i)[self.block[i].lanes()]));
        if finite { Ok(()) } else { Err(Defect::Overflow) }
    }

    fn choose_squares(&mut self, problem: &Problem, squares: Squares) {
        let has_cost = |j: usize| problem.hessian()[j * self.n + j] != 0.0;
        self.squared.clear();
        if squares == Squares::None {
            return;
        }
        for c in (0..self.constraints()).filter(|&c| self.kind[c] == Kind::Equality) {
            let is_entry = |j: usize| c >= self.m || problem.row(c)[j] != 0.0;
            if squares == Squares::All || self.span[c].entries().any(|j| is_entry(j) && !has_cost(j)) {
                self.squared.push(c);
            }
        }
    }

    /// Spans that overlap belong to one block.
    fn find_blocks(&mut self) {
        for j in 0..self.n {
            self.block[j] = Span::one(j);
        }
        let rows = self.squared.iter().map(|&c| self.span[c]);
        for span in self.hessian_span.iter().copied().chain(rows) {
            let end = &mut self.block[span.first].end;
            *end = span.end.max(*end);
        }
        let mut first = 0;
        while first < self.n {
            let (mut end, mut j) = (first, first);
            while j == first || j < end {
                end = end.max(self.block[j].end);
                j += 1;
            }
            self.block[first..end].fill(Span { first, end });
            first = end;
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

fn are_finite(numbers: &[Lanes]) -> bool {
    numbers.as_flattened().iter().all(|x| x.is_finite())
}
