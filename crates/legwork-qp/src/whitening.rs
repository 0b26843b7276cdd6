//! The variables in which the Hessian is the identity: `y = Lᵀz` where `H = L Lᵀ`. A normal `a` becomes `L⁻¹a`.
//!
//! `L⁻¹` is formed along with `L`, row by row, block by block of a block-diagonal `H`: a variable with a cost of its own (a
//! force, a slack) costs one square root. Products with `L⁻¹` have no chain of dependent operations, unlike
//! solutions of triangular systems, and the norms of its columns bound rounding errors.

use std::ops::Range;

use crate::lanes::{Lanes, Span, WIDTH, add_product, axpy, axpys, dot, dots, lane, zeros};
use crate::linear;
use crate::scale::Scaled;

/// A pivot of the Cholesky factorisation of a matrix with a diagonal of order one counts as zero below this times n.
const PIVOT: f64 = 64.0 * f64::EPSILON;

#[derive(Clone, Debug)]
pub(crate) struct Whitening {
    width: usize,
    /// Rows of `H`, then those of `L` with the inverses of its diagonal.
    l: Vec<Lanes>,
    /// `L⁻¹`, by columns: column `j` from entry `j` to the end of its block, for coupled blocks.
    inverse: Vec<Lanes>,
    block: Vec<Span>,
    /// The blocks of more than one variable; and of the other variables, the diagonal of `L⁻¹`.
    coupled: Vec<Span>,
    diagonal: Vec<Lanes>,
    /// Where column `j` is, in lanes.
    lanes: Vec<Range<usize>>,
    /// `√(H⁻¹)_jj`.
    norms: Vec<Lanes>,
}

impl Whitening {
    pub(crate) fn new(n: usize) -> Self {
        let width = zeros(n).len();
        Self {
            width,
            l: zeros(WIDTH * width * n),
            inverse: zeros(WIDTH * width * n),
            block: vec![Span::EMPTY; n],
            coupled: Vec::with_capacity(n),
            diagonal: zeros(n),
            lanes: vec![0..0; n],
            norms: zeros(n),
        }
    }

    /// `√(H⁻¹)_jj`: with `|a_j|` these bound the length of `L⁻¹a`.
    pub(crate) fn norms(&self) -> &[Lanes] {
        &self.norms
    }

    /// Factorises the Hessian with the squares of the program's chosen equalities. False if it is not positive definite.
    pub(crate) fn factorise(&mut self, program: &Scaled) -> bool {
        let width = self.width;
        self.block.copy_from_slice(&program.block);
        for (j, block) in program.block.iter().enumerate() {
            let row = block.lanes();
            self.l[j * width..][row.clone()].copy_from_slice(&program.hessian_row(j)[row]);
            self.lanes[j] = lane(j)..block.lanes().end;
        }
        for &c in &program.squared {
            let Some(row) = program.row(c) else {
                let j = c - program.m;
                self.l[j * width..].as_flattened_mut()[j] += 1.0;
                continue;
            };
            for j in program.span[c].entries() {
                let lanes = program.span[c].lanes();
                axpy(row.as_flattened()[j], &row[lanes.clone()], &mut self.l[j * width..][lanes]);
            }
        }
        self.coupled.clear();
        self.diagonal.fill([0.0; WIDTH]);
        for i in 0..self.block.len() {
            if !self.factorise_row(i) {
                return false;
            }
        }
        for (j, lanes) in self.lanes.iter().enumerate() {
            let inverse = self.diagonal.as_flattened()[j];
            let column = &self.inverse[j * width..][lanes.clone()];
            self.norms.as_flattened_mut()[j] = if inverse > 0.0 { inverse } else { dot(column, column).sqrt() };
        }
        true
    }

    /// Row `i` of `L` (Crout) and of `L⁻¹`. False if its pivot is zero.
    fn factorise_row(&mut self, i: usize) -> bool {
        let (n, width, Span { first, end }) = (self.block.len(), self.width, self.block[i]);
        let stride = WIDTH * width;
        let (above, row) = self.l.as_flattened_mut().split_at_mut(i * stride);
        let row = &mut row[..=i];
        for (j, other) in (first..i).zip(above[first * stride..].chunks_exact(stride)) {
            row[j] = (row[j] - linear::dot(&row[first..j], &other[first..j])) * other[j];
        }
        let row_before = &row[first..i];
        let pivot = row[i] - linear::dot(row_before, row_before);
        // A NaN fails too.
        if pivot.is_nan() || pivot <= PIVOT * n as f64 {
            return false;
        }
        let inverse = 1.0 / pivot.sqrt();
        row[i] = inverse;
        if end == first + 1 {
            self.diagonal.as_flattened_mut()[i] = inverse;
            return true;
        }
        if i == first {
            self.coupled.push(self.block[i]);
        }
        self.inverse[i * width..][self.lanes[i].clone()].fill([0.0; WIDTH]);
        let columns = self.inverse.as_flattened_mut()[first * stride..].chunks_exact_mut(stride);
        for (j, column) in (first..i).zip(columns) {
            column[i] = -inverse * linear::dot(&row[j..i], &column[j..i]);
        }
        self.inverse.as_flattened_mut()[i * stride + i] = inverse;
        true
    }

    /// `out = sign L⁻¹ a_c`, and where it is not zero.
    pub(crate) fn normal(&self, program: &Scaled, c: usize, sign: f64, out: &mut [Lanes]) -> Span {
        let span = program.span[c];
        if let Some(row) = program.row(c) {
            return self.times(row, span, sign, out);
        }
        let (j, block) = (span.first, self.block[span.first]);
        out.fill([0.0; WIDTH]);
        if block.end == block.first + 1 {
            out.as_flattened_mut()[j] = sign * self.diagonal.as_flattened()[j];
        } else {
            axpy(sign, self.column(j), &mut out[self.lanes[j].clone()]);
        }
        Span { first: j, end: block.end }
    }

    /// `out = alpha L⁻¹v` for a vector that is zero outside of `span`.
    pub(crate) fn times(&self, v: &[Lanes], span: Span, alpha: f64, out: &mut [Lanes]) -> Span {
        out.fill([0.0; WIDTH]);
        let lanes = span.lanes();
        add_product(alpha, &self.diagonal[lanes.clone()], &v[lanes.clone()], &mut out[lanes]);
        for block in &self.coupled {
            let (first, end) = (span.first.max(block.first), span.end.min(block.end));
            let mut j = first;
            while j < end {
                // Four columns of one lane begin and end in the same lanes.
                let lanes = self.lanes[j].clone();
                if j % WIDTH == 0 && j + WIDTH <= end {
                    axpys(v[lane(j)].map(|v| alpha * v), self.four(j, &lanes), &mut out[lanes]);
                    j += WIDTH;
                } else {
                    axpy(alpha * v.as_flattened()[j], self.column(j), &mut out[lanes]);
                    j += 1;
                }
            }
        }
        // Blocks end in the order of their variables.
        Span { first: span.first, end: if span.end == 0 { 0 } else { self.block[span.end - 1].end } }
    }

    /// `z −= L⁻ᵀy`.
    pub(crate) fn subtract_unwhitened(&self, y: &[Lanes], z: &mut [Lanes]) {
        add_product(-1.0, &self.diagonal, y, z);
        for block in &self.coupled {
            let mut j = block.first;
            while j < block.end {
                let lanes = self.lanes[j].clone();
                if j % WIDTH == 0 && j + WIDTH <= block.end {
                    let products = dots(self.four(j, &lanes), &y[lanes]);
                    z[lane(j)].iter_mut().zip(products).for_each(|(z, product)| *z -= product);
                    j += WIDTH;
                } else {
                    z.as_flattened_mut()[j] -= dot(self.column(j), &y[lanes]);
                    j += 1;
                }
            }
        }
    }

    /// Columns of `L⁻¹` from `j` on.
    fn four(&self, j: usize, lanes: &Range<usize>) -> [&[Lanes]; WIDTH] {
        std::array::from_fn(|i| &self.inverse[(j + i) * self.width..][lanes.clone()])
    }

    /// Column `j` of `L⁻¹` in its lanes, in a coupled block.
    fn column(&self, j: usize) -> &[Lanes] {
        &self.inverse[j * self.width..][self.lanes[j].clone()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Problem;
    use crate::scale::Squares;

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
        program.load(&problem).unwrap();
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
                (0..N).for_each(|i| column.as_flattened_mut()[i] = program.hessian_times(i, &unit(j)));
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
