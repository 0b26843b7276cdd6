//! The variables in which the Hessian is the identity: `y = Lᵀz` where `H = L Lᵀ`. A normal `a` becomes `L⁻¹a`.
//!
//! `L⁻¹` takes the place of `H` by elimination of rows, block by block of a block-diagonal `H`: a variable with a cost of its
//! own (a force, a slack) costs one square root. Products with `L⁻¹` have no chain of dependent operations, unlike
//! solutions of triangular systems, and the norms of its columns bound rounding errors.

use crate::lanes::{Lanes, Span, WIDTH, axpy, axpys, dots, four_rows, lane, scale, zeros};
use crate::scale::Scaled;

/// A pivot of the Cholesky factorisation of a matrix with a diagonal of order one counts as zero below this times n.
const PIVOT: f64 = 64.0 * f64::EPSILON;
/// With slacks replaced, below this: the step of refinement leaves errors that grow with its inverse square.
const PIVOT_WITH_SLACKS: f64 = 1e-10;

#[derive(Clone, Debug)]
pub(crate) struct Whitening {
    width: usize,
    /// `L⁻¹` by rows. Four rows make a lane; they are valid, with zeros, from the first lane of any to that of their diagonal.
    rows: Vec<Lanes>,
    block: Vec<Span>,
    /// Of each four rows the first lane with an entry; and their diagonal, if that is all they have.
    first: Vec<usize>,
    diagonal: Vec<Option<Lanes>>,
    /// `√(H⁻¹)_jj`.
    norms: Vec<Lanes>,
    least_pivot: f64,
}

impl Whitening {
    pub(crate) fn new(n: usize) -> Self {
        let width = zeros(n).len();
        Self {
            width,
            rows: vec![[0.0; WIDTH]; width * width * WIDTH],
            block: vec![Span::EMPTY; n],
            first: vec![0; width],
            diagonal: vec![None; width],
            norms: zeros(n),
            least_pivot: 0.0,
        }
    }

    /// `√(H⁻¹)_jj`: with `|a_j|` these bound the length of `L⁻¹a`.
    pub(crate) fn norms(&self) -> &[Lanes] {
        &self.norms
    }

    /// Factorises the Hessian with the squares of the program's chosen equalities. False if it is not positive definite.
    pub(crate) fn factorise(&mut self, program: &Scaled) -> bool {
        self.load(program);
        let has_slacks = !program.replaced.slacks().is_empty();
        self.least_pivot = if has_slacks { PIVOT_WITH_SLACKS } else { PIVOT * self.block.len() as f64 };
        let mut i = 0;
        while i < self.block.len() {
            let block = self.block[i];
            let definite = if block.end == i + 1 { self.invert(i) } else { self.eliminate(block) };
            if !definite {
                return false;
            }
            i = block.end;
        }
        self.norms.fill([0.0; WIDTH]);
        for (i, four) in self.block.chunks(WIDTH).enumerate() {
            let lanes = self.first[i]..i + 1;
            let rows = four_rows(&self.rows, self.width, i, &lanes);
            for (l, norms) in self.norms[lanes].iter_mut().enumerate() {
                for k in 0..WIDTH {
                    let [a, b, c, d] = rows.map(|row| row[l][k]);
                    norms[k] += (a * a + b * b) + (c * c + d * d);
                }
            }
            let single = four.iter().all(|block| block.end == block.first + 1);
            self.diagonal[i] = single.then(|| std::array::from_fn(|k| rows[k][0][k]));
        }
        self.norms.as_flattened_mut().iter_mut().for_each(|norm| *norm = norm.sqrt());
        true
    }

    fn load(&mut self, program: &Scaled) {
        let width = self.width;
        self.block.copy_from_slice(&program.block);
        for (first, four) in self.first.iter_mut().zip(self.block.chunks(WIDTH)) {
            *first = lane(four[0].first);
        }
        for (i, block) in self.block.iter().enumerate() {
            let upper = lane(i)..block.end.div_ceil(WIDTH);
            let row = &mut self.rows[i * width..][..width];
            row[upper.clone()].copy_from_slice(&program.hessian_row(i)[upper]);
            row[self.first[lane(i)]..lane(i)].fill([0.0; WIDTH]);
        }
        for &(c, weight) in &program.squared {
            let Some(row) = program.row(c) else {
                let j = c - program.m;
                self.rows[j * width..].as_flattened_mut()[j] += weight;
                continue;
            };
            let (entries, lanes) = (program.span[c].entries(), program.span[c].lanes());
            let (first, normal) = (entries.start, &row[lanes.clone()]);
            let targets = self.rows[first * width..].chunks_exact_mut(width);
            for (entry, target) in row.as_flattened()[entries].iter().zip(targets) {
                axpy(weight * entry, normal, &mut target[lanes.clone()]);
            }
        }
    }

    /// A block of one variable.
    fn invert(&mut self, i: usize) -> bool {
        let entry = &mut self.rows[i * self.width + lane(i)][i % WIDTH];
        let pivot = *entry;
        *entry = 1.0 / pivot.sqrt();
        is_pivot(pivot, self.least_pivot)
    }

    /// Turns a block of `H` into one of `L⁻¹` by elimination. False if a pivot is zero.
    ///
    /// Each row `j` that is subtracted from those below it adds column `j` of `L⁻¹` to them and takes one of `H`, of which only
    /// the upper triangle is read.
    fn eliminate(&mut self, block: Span) -> bool {
        let (width, lanes) = (self.width, block.lanes());
        let origin = lanes.start * WIDTH;
        for j in block.entries() {
            let (above, below) = self.rows.split_at_mut((j + 1) * width);
            let row = &mut above[j * width..][lanes.clone()];
            let pivot = row.as_flattened()[j - origin];
            if !is_pivot(pivot, self.least_pivot) {
                return false;
            }
            let reciprocal = 1.0 / pivot;
            for (i, other) in (j + 1..block.end).zip(below.chunks_exact_mut(width)) {
                let other = &mut other[lanes.clone()];
                let factor = -reciprocal * row.as_flattened()[i - origin];
                axpy(factor, row, other);
                other.as_flattened_mut()[j - origin] = factor;
            }
            scale(reciprocal.sqrt(), row);
            row.as_flattened_mut()[j - origin] = reciprocal.sqrt();
            row[lane(j) - lanes.start][j % WIDTH + 1..].fill(0.0);
        }
        true
    }

    /// `out = sign L⁻¹ a_c`, and where it is not zero.
    pub(crate) fn normal(&self, program: &Scaled, c: usize, sign: f64, out: &mut [Lanes]) -> Span {
        let span = program.span[c];
        if let Some(row) = program.row(c) {
            return self.times(row, span, sign, out);
        }
        let (j, end) = (span.first, self.block[span.first].end);
        out.fill([0.0; WIDTH]);
        let rows = self.rows.as_flattened().chunks_exact(WIDTH * self.width);
        for (out, row) in out.as_flattened_mut()[j..end].iter_mut().zip(rows.skip(j)) {
            *out = sign * row[j];
        }
        Span { first: j, end }
    }

    /// `out = alpha L⁻¹v` for a vector that is zero outside of `span`.
    pub(crate) fn times(&self, v: &[Lanes], span: Span, alpha: f64, out: &mut [Lanes]) -> Span {
        out.fill([0.0; WIDTH]);
        let within = span.lanes();
        // Blocks end in the order of their variables.
        let end = if span.end == 0 { 0 } else { self.block[span.end - 1].end };
        for i in within.start..end.div_ceil(WIDTH) {
            if let Some(diagonal) = self.diagonal[i] {
                if i < within.end {
                    out[i] = std::array::from_fn(|k| alpha * v[i][k] * diagonal[k]);
                }
            } else {
                let lanes = self.first[i].max(within.start)..(i + 1).min(within.end);
                if !lanes.is_empty() {
                    let products = dots(four_rows(&self.rows, self.width, i, &lanes), &v[lanes]);
                    out[i] = products.map(|product| alpha * product);
                }
            }
        }
        Span { first: span.first, end }
    }

    /// `z −= L⁻ᵀy`.
    pub(crate) fn subtract_unwhitened(&self, y: &[Lanes], z: &mut [Lanes]) {
        for (i, y) in y.iter().enumerate() {
            if let Some(diagonal) = self.diagonal[i] {
                for k in 0..WIDTH {
                    z[i][k] -= diagonal[k] * y[k];
                }
            } else {
                let lanes = self.first[i]..i + 1;
                axpys(y.map(|y| -y), four_rows(&self.rows, self.width, i, &lanes), &mut z[lanes]);
            }
        }
    }
}

/// A NaN is none.
fn is_pivot(pivot: f64, least: f64) -> bool {
    pivot > least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Problem;
    use crate::hessian::Squares;
    use crate::lanes::dot;

    const N: usize = 7;

    /// Entries of no pattern.
    fn entry(i: usize, j: usize) -> f64 {
        ((3 * i * i + 7 * j + i * j) as f64).sin()
    }

    fn factorised(h: &[f64]) -> (Scaled, Whitening, bool) {
        let n = h.len().isqrt();
        let mut problem = Problem::new(n, 0);
        problem.hessian_mut().copy_from_slice(h);
        let mut program = Scaled::new(n, 0);
        program.load(&problem, true).unwrap();
        program.load_hessian(&problem, Squares::None).unwrap();
        let mut whitening = Whitening::new(n);
        let definite = whitening.factorise(&program);
        (program, whitening, definite)
    }

    /// `L⁻ᵀ L⁻¹ H = 1`, for full matrices and such with blocks of all sizes.
    #[test]
    fn whitening_twice_undoes_the_hessian() {
        for ends in [[N, N, N], [1, 3, N], [3, 4, N], [5, 6, N], [2, 6, N]] {
            let block = |i: usize| ends.iter().position(|&end| i < end);
            let mut h = vec![0.0; N * N];
            for i in 0..N {
                for j in (0..N).filter(|&j| block(i) == block(j)) {
                    h[i * N + j] = (0..N).map(|k| entry(i, k) * entry(j, k)).sum();
                }
                h[i * N + i] += 0.1;
            }
            let (program, whitening, definite) = factorised(&h);
            assert!(definite);
            for j in 0..N {
                let mut column = zeros(N);
                (0..column.len()).for_each(|i| column[i] = program.hessian_times(i, &unit(j)));
                let (mut white, mut back) = (zeros(N), zeros(N));
                whitening.times(&column, Span { first: 0, end: N }, 1.0, &mut white);
                whitening.subtract_unwhitened(&white, &mut back);
                for i in 0..N {
                    let expected = f64::from(u8::from(i == j));
                    assert!((back.as_flattened()[i] + expected).abs() < 1e-12, "{ends:?}: {i} {j}");
                }
                let mut normal = zeros(N);
                let span = whitening.normal(&program, j, 1.0, &mut normal);
                assert_eq!(span, Span { first: j, end: ends[block(j).unwrap()] });
                assert!((dot(&normal, &normal).sqrt() - whitening.norms().as_flattened()[j]).abs() < 1e-12);
            }
        }
    }

    fn unit(j: usize) -> Vec<Lanes> {
        let mut v = zeros(N);
        v.as_flattened_mut()[j] = 1.0;
        v
    }

    #[test]
    fn singular_matrices_are_refused() {
        for (matrix, definite) in [
            ([1.0, 1.0, 1.0, 1.0], false),
            ([1.0, 1.0, 1.0, 1.0 + 1e-9], true),
            ([0.0, 0.0, 0.0, 1.0], false),
            ([1.0, 2.0, 2.0, 1.0], false),
        ] {
            assert_eq!(factorised(&matrix).2, definite, "{matrix:?}");
        }
    }

    /// Sums of fewer squares than variables: what rounding errors leave of the last pivots may be positive.
    #[test]
    fn rank_deficient_matrices_are_refused() {
        for rank in 1..5 {
            for example in 0..20 {
                let mut h = vec![0.0; N * N];
                for i in 0..N {
                    for j in 0..N {
                        let product = |k: usize| entry(i + example, k) * entry(j + example, k);
                        h[i * N + j] = (0..rank).map(product).sum();
                    }
                }
                assert!(!factorised(&h).2, "rank {rank}, example {example}");
            }
        }
    }
}
