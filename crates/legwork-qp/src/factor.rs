//! The thin factorisation of the working set's whitened normals, and its updates.
//!
//! With the normals `L⁻¹N` as columns, `L⁻¹N = Q R`: `Q` has as many orthonormal columns as there are members, `R` is upper
//! triangular. Normals enter by Gram-Schmidt orthogonalisation, repeated where much has cancelled, and leave by rotations:
//! J. W. Daniel, W. B. Gragg, L. Kaufman, G. W. Stewart, *Reorthogonalization and stable algorithms for updating the
//! Gram-Schmidt QR factorization*, Mathematics of Computation 30 (1976). The method of Goldfarb & Idnani (1983, section 4)
//! carries the full `Q` along instead, which costs `n²` for each entry where this costs `n q`.

use std::ops::Range;

use crate::lanes::{self, Lanes, Span, WIDTH, rotate, zeros};
use crate::linear::{axpy, dot, givens};

/// Orthogonalisation is repeated where less than this is left of a vector's length.
const REPEAT: f64 = 0.1;
/// Rounding errors have no length to be orthogonal to anything with: at most so many passes.
const PASSES: usize = 4;

#[derive(Clone, Debug)]
pub(crate) struct Factor {
    n: usize,
    width: usize,
    q: usize,
    /// `Q`, by columns, and where these are not zero.
    columns: Vec<Lanes>,
    spans: Vec<Span>,
    /// Column `k` of `R` at `k n`; its diagonal holds the inverses.
    r: Vec<f64>,
    pass: Vec<f64>,
}

impl Factor {
    pub(crate) fn new(n: usize) -> Self {
        let width = zeros(n).len();
        Self {
            n,
            width,
            q: 0,
            columns: zeros(WIDTH * width * n),
            spans: vec![Span::EMPTY; n],
            r: vec![0.0; n * n],
            pass: vec![0.0; n],
        }
    }

    /// Empties the working set.
    pub(crate) fn clear(&mut self) {
        self.q = 0;
    }

    /// Size of the working set.
    pub(crate) fn q(&self) -> usize {
        self.q
    }

    /// Column `k` of `Q` in its lanes.
    pub(crate) fn column(&self, k: usize) -> (&[Lanes], Range<usize>) {
        let lanes = self.spans[k].lanes();
        (&self.columns[k * self.width..][lanes.clone()], lanes)
    }

    /// Splits `v`, which is zero outside of `span`: `d = Qᵀv`, and `v` becomes `v − Q d`. Returns the new span and the
    /// length of what is left.
    pub(crate) fn project(&mut self, v: &mut [Lanes], mut span: Span, d: &mut [f64]) -> (Span, f64) {
        let q = self.q;
        d[..q].fill(0.0);
        let mut squares = lanes::dot(&v[span.lanes()], &v[span.lanes()]);
        if q == 0 {
            return (span, squares.sqrt());
        }
        for _ in 0..PASSES {
            let before = squares;
            span = self.project_once(v, span);
            for (d, pass) in d[..q].iter_mut().zip(&self.pass) {
                *d += pass;
            }
            squares = lanes::dot(&v[span.lanes()], &v[span.lanes()]);
            if squares > REPEAT * REPEAT * before {
                break;
            }
        }
        (span, squares.sqrt())
    }

    fn project_once(&mut self, v: &mut [Lanes], span: Span) -> Span {
        let (q, fours) = (self.q, self.q - self.q % WIDTH);
        let mut pass = std::mem::take(&mut self.pass);
        for k in (0..fours).step_by(WIDTH) {
            let lanes = self.span_of_four(k).common_lanes(span);
            let products = lanes::dots(self.four(k, &lanes), &v[lanes]);
            pass[k..k + WIDTH].copy_from_slice(&products);
        }
        for k in fours..q {
            let lanes = self.spans[k].common_lanes(span);
            pass[k] = lanes::dot(&self.columns[k * self.width..][lanes.clone()], &v[lanes]);
        }
        let reached = self.subtract(&pass[..q], v, span);
        self.pass = pass;
        reached
    }

    /// `v −= Q d`; the span of the result.
    fn subtract(&self, d: &[f64], v: &mut [Lanes], mut span: Span) -> Span {
        let (fours, rest) = d.as_chunks::<WIDTH>();
        for (k, d) in fours.iter().enumerate() {
            if *d != [0.0; WIDTH] {
                let reached = self.span_of_four(k * WIDTH);
                let lanes = reached.lanes();
                lanes::axpys(d.map(|d| -d), self.four(k * WIDTH, &lanes), &mut v[lanes]);
                span = span.union(reached);
            }
        }
        for (k, d) in (fours.len() * WIDTH..).zip(rest) {
            if *d != 0.0 {
                let (column, lanes) = self.column(k);
                lanes::axpy(-d, column, &mut v[lanes]);
                span = span.union(self.spans[k]);
            }
        }
        span
    }

    fn span_of_four(&self, k: usize) -> Span {
        self.spans[k..k + WIDTH].iter().fold(Span::EMPTY, |all, span| all.union(*span))
    }

    /// Columns from `k` on.
    fn four(&self, k: usize, lanes: &Range<usize>) -> [&[Lanes]; WIDTH] {
        std::array::from_fn(|i| &self.columns[(k + i) * self.width..][lanes.clone()])
    }

    /// Appends a normal, projected into `d` and the rest `v` of the given length.
    pub(crate) fn add(&mut self, d: &[f64], v: &[Lanes], span: Span, length: f64) {
        let (n, q) = (self.n, self.q);
        let inverse = 1.0 / length;
        let column = &mut self.columns[q * self.width..][..self.width];
        column.fill([0.0; WIDTH]);
        lanes::axpy(inverse, &v[span.lanes()], &mut column[span.lanes()]);
        self.spans[q] = span;
        self.r[q * n..][..q].copy_from_slice(&d[..q]);
        self.r[q * n + q] = inverse;
        self.q += 1;
    }

    /// `v −= Q t`.
    pub(crate) fn subtract_times(&self, t: &[f64], v: &mut [Lanes]) {
        self.subtract(t, v, Span::EMPTY);
    }

    /// `R r = d` in place, on the first `q` entries.
    pub(crate) fn solve(&self, d: &mut [f64]) {
        for i in (0..self.q).rev() {
            let (done, rest) = d.split_at_mut(i);
            let column = &self.r[i * self.n..][..i + 1];
            rest[0] *= column[i];
            axpy(-rest[0], &column[..i], done);
        }
    }

    /// `Rᵀ y = b` in place, on the first `q` entries.
    pub(crate) fn solve_transposed(&self, b: &mut [f64]) {
        for i in 0..self.q {
            let column = &self.r[i * self.n..][..i + 1];
            b[i] = (b[i] - dot(&column[..i], &b[..i])) * column[i];
        }
    }

    /// Removes position `k` from the working set; rotations of neighbouring columns make `R` triangular again.
    pub(crate) fn drop(&mut self, k: usize) {
        let (n, width) = (self.n, self.width);
        for column in k + 1..self.q {
            self.r.copy_within(column * n..column * n + column + 1, (column - 1) * n);
        }
        self.q -= 1;
        for i in k..self.q {
            // Below the diagonal stands the inverse of what was the diagonal of the column dropped into this place.
            let (c, s, length) = givens(self.r[i * n + i], 1.0 / self.r[i * n + i + 1]);
            self.r[i * n + i] = 1.0 / length;
            for column in i + 1..self.q {
                let (a, b) = (self.r[column * n + i], self.r[column * n + i + 1]);
                self.r[column * n + i] = c * a + s * b;
                self.r[column * n + i + 1] = c * b - s * a;
            }
            let (left, right) = self.columns.split_at_mut((i + 1) * width);
            let span = self.spans[i].union(self.spans[i + 1]);
            rotate(c, s, &mut left[i * width..][span.lanes()], &mut right[span.lanes()]);
            self.spans[i] = span;
            self.spans[i + 1] = span;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 7;

    /// Entries of no pattern.
    fn entry(i: usize, j: usize) -> f64 {
        ((3 * i * i + 7 * j + i * j) as f64).sin()
    }

    /// Some of the normals are short.
    fn normal(c: usize) -> (Vec<Lanes>, Span) {
        let span = if c % 3 == 1 { Span { first: c % 5, end: c % 5 + 2 } } else { Span { first: 0, end: N } };
        let mut v = zeros(N);
        span.entries().for_each(|j| v.as_flattened_mut()[j] = entry(20 + c, 3 * j + 1));
        (v, span)
    }

    fn add(factor: &mut Factor, c: usize) {
        let (mut v, span) = normal(c);
        let mut d = [0.0; N];
        let (span, length) = factor.project(&mut v, span, &mut d);
        factor.add(&d, &v, span, length);
    }

    fn column(factor: &Factor, k: usize) -> &[Lanes] {
        &factor.columns[k * factor.width..][..factor.width]
    }

    fn r(factor: &Factor, i: usize, k: usize) -> f64 {
        let entry = factor.r[k * N + i];
        if i == k { 1.0 / entry } else { entry }
    }

    /// `QᵀQ = 1`, `QᵀN = R`, and `N = Q R`.
    fn check(factor: &Factor, members: &[usize]) {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
        assert_eq!(factor.q(), members.len());
        for (k, &c) in members.iter().enumerate() {
            let mut rest = normal(c).0;
            for l in 0..members.len() {
                near(lanes::dot(column(factor, k), column(factor, l)), f64::from(u8::from(k == l)));
                let product = lanes::dot(column(factor, l), &normal(c).0);
                near(product, if l <= k { r(factor, l, k) } else { 0.0 });
                lanes::axpy(-product, column(factor, l), &mut rest);
            }
            near(lanes::dot(&rest, &rest), 0.0);
        }
    }

    #[test]
    fn the_factors_survive_adding_and_dropping() {
        let mut factor = Factor::new(N);
        let mut members = Vec::new();
        // First, middle and last position, and a full set.
        for (new, dropped) in [(4, None), (3, Some(0)), (1, Some(2)), (3, Some(4)), (2, Some(6))] {
            while members.len() < new + 2 {
                members.push(10 * new + members.len());
                add(&mut factor, *members.last().unwrap());
                check(&factor, &members);
            }
            if let Some(k) = dropped.filter(|&k| k < members.len()) {
                factor.drop(k);
                members.remove(k);
                check(&factor, &members);
            }
        }
        while members.len() < N {
            members.push(100 + members.len());
            add(&mut factor, *members.last().unwrap());
        }
        check(&factor, &members);
        for k in [3, 0, N - 3] {
            factor.drop(k);
            members.remove(k);
            check(&factor, &members);
        }
    }

    /// Of a normal that is nearly in the span, the rest is orthogonal to it all the same.
    #[test]
    fn little_that_is_left_is_orthogonal() {
        let mut factor = Factor::new(N);
        (0..4).for_each(|c| add(&mut factor, c));
        let mut v = zeros(N);
        for c in 0..4 {
            lanes::axpy(1.0 + c as f64, &normal(c).0, &mut v);
        }
        v.as_flattened_mut()[5] += 1e-9;
        let mut d = [0.0; N];
        let (span, length) = factor.project(&mut v, Span { first: 0, end: N }, &mut d);
        assert!(length > 1e-11 && length < 1e-9);
        factor.add(&d, &v, span, length);
        for k in 0..4 {
            assert!(lanes::dot(column(&factor, k), column(&factor, 4)).abs() < 1e-15);
        }
    }

    #[test]
    fn triangular_systems() {
        let mut factor = Factor::new(N);
        (0..4).for_each(|c| add(&mut factor, c));
        let at = |i: usize, k: usize| if i <= k { r(&factor, i, k) } else { 0.0 };
        let (mut x, mut y) = ([1.0, -2.0, 3.0, 0.5], [1.0, -2.0, 3.0, 0.5]);
        factor.solve(&mut x);
        factor.solve_transposed(&mut y);
        for (i, b) in [1.0, -2.0, 3.0, 0.5].into_iter().enumerate() {
            let (rx, ry) = ((0..4).map(|k| at(i, k) * x[k]), (0..4).map(|k| at(k, i) * y[k]));
            assert!((rx.sum::<f64>() - b).abs() < 1e-12 && (ry.sum::<f64>() - b).abs() < 1e-12);
        }
    }
}
