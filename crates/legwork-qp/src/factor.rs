//! The factors of the active-set method and their updates.
//!
//! With `H = L Lᵀ` and the normals `N` of the working set as columns, `Jᵀ N = [R; 0]` where `J = L⁻ᵀ Q`, `Q` orthogonal
//! and `R` upper triangular: Goldfarb & Idnani 1983, section 4. The first `q` columns of `J` are `J1`, the others `J2`.
//! `J2` spans the directions that keep the working set, and `JᵀHJ = 1`.
//!
//! `J` is stored by columns. Below each column stands one more number, its product with the gradient: the updates of `J`
//! then keep `Jᵀg` up to date as well.

use crate::linear::{axpy, dot, givens, rotate};

/// A pivot of the Cholesky factorisation of a matrix with a diagonal of order one counts as zero below this times n.
const PIVOT: f64 = 64.0 * f64::EPSILON;

#[derive(Clone, Debug)]
pub(crate) struct Factor {
    n: usize,
    q: usize,
    /// `n + 1` numbers a column: the column of `J`, then its product with the gradient.
    j: Vec<f64>,
    /// Column `k` of `R` at `k n`.
    r: Vec<f64>,
    /// `L`, by columns.
    l: Vec<f64>,
    /// Norms of the rows of `J`, which no rotation changes: `√(H⁻¹)_ii`.
    row_norms: Vec<f64>,
}

impl Factor {
    pub(crate) fn new(n: usize) -> Self {
        Self { n, q: 0, j: vec![0.0; (n + 1) * n], r: vec![0.0; n * n], l: vec![0.0; n * n], row_norms: vec![0.0; n] }
    }

    /// Size of the working set.
    pub(crate) fn q(&self) -> usize {
        self.q
    }

    /// Column `k` of `J`.
    pub(crate) fn column(&self, k: usize) -> &[f64] {
        &self.j[k * (self.n + 1)..][..self.n]
    }

    /// Component `k` of `Jᵀg`.
    pub(crate) fn gradient(&self, k: usize) -> f64 {
        self.j[k * (self.n + 1) + self.n]
    }

    pub(crate) fn row_norms(&self) -> &[f64] {
        &self.row_norms
    }

    /// A place for the matrix to factorise, before [`Factor::factorise`] overwrites it.
    pub(crate) fn matrix_mut(&mut self) -> &mut [f64] {
        &mut self.l
    }

    /// Starts anew, with an empty working set, from the matrix in [`Factor::matrix_mut`]. False if it is not positive
    /// definite.
    pub(crate) fn factorise(&mut self, gradient: &[f64]) -> bool {
        self.q = 0;
        if !self.cholesky() {
            return false;
        }
        self.invert();
        let n = self.n;
        self.row_norms.fill(0.0);
        for column in self.j.chunks_exact_mut(n + 1) {
            column[n] = dot(&column[..n], gradient);
            for (norm, entry) in self.row_norms.iter_mut().zip(column.iter()) {
                *norm += entry * entry;
            }
        }
        for norm in &mut self.row_norms {
            *norm = norm.sqrt();
        }
        true
    }

    /// `H = L Lᵀ` in place.
    fn cholesky(&mut self) -> bool {
        let n = self.n;
        let threshold = PIVOT * n as f64;
        for j in 0..n {
            let (done, rest) = self.l.split_at_mut((j + 1) * n);
            let column = &mut done[j * n..];
            let pivot = column[j];
            // A NaN fails too.
            if pivot.is_nan() || pivot <= threshold {
                return false;
            }
            let inverse = 1.0 / pivot.sqrt();
            for entry in &mut column[j..] {
                *entry *= inverse;
            }
            for (k, other) in rest.chunks_exact_mut(n).enumerate() {
                let k = j + 1 + k;
                axpy(-column[k], &column[k..], &mut other[k..]);
            }
        }
        true
    }

    /// `J = L⁻ᵀ`, upper triangular: column `k` solves `Lᵀ x = e_k`.
    fn invert(&mut self) {
        let n = self.n;
        self.j.fill(0.0);
        for (k, x) in self.j.chunks_exact_mut(n + 1).enumerate() {
            x[k] = 1.0 / self.l[k * n + k];
            for i in (0..k).rev() {
                let column = &self.l[i * n..(i + 1) * n];
                x[i] = -dot(&column[i + 1..=k], &x[i + 1..=k]) / column[i];
            }
        }
    }

    /// `out = Jᵀ v` for a dense vector.
    pub(crate) fn transpose_times(&self, v: &[f64], out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            *out = dot(self.column(k), v);
        }
    }

    /// `out = alpha Jᵀ e_j`.
    pub(crate) fn transpose_times_unit(&self, j: usize, alpha: f64, out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            *out = alpha * self.j[k * (self.n + 1) + j];
        }
    }

    /// `out = J y`.
    pub(crate) fn times(&self, y: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (k, y) in y.iter().enumerate() {
            axpy(*y, self.column(k), out);
        }
    }

    /// `out = J2 d2` of a full vector `d`; `out` has length `n + 1`, its last entry is `gᵀ J2 d2`.
    pub(crate) fn free_direction(&self, d: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for k in self.q..self.n {
            axpy(d[k], &self.j[k * (self.n + 1)..][..self.n + 1], out);
        }
    }

    /// `R r = d1` in place, on the first `q` entries.
    pub(crate) fn solve(&self, d: &mut [f64]) {
        for i in (0..self.q).rev() {
            let column = &self.r[i * self.n..];
            d[i] /= column[i];
            let x = d[i];
            axpy(-x, &column[..i], &mut d[..i]);
        }
    }

    /// `Rᵀ y = b` in place, on the first `q` entries.
    pub(crate) fn solve_transposed(&self, b: &mut [f64]) {
        for i in 0..self.q {
            let column = &self.r[i * self.n..];
            b[i] = (b[i] - dot(&column[..i], &b[..i])) / column[i];
        }
    }

    /// Appends a normal to the working set, of which `d = Jᵀ n` and `direction` from [`Factor::free_direction`] are given.
    ///
    /// The Householder reflection that turns `d2` into a multiple of the first unit vector needs `J2 v` with
    /// `v = d2 − alpha e1`, which is the direction up to one column.
    pub(crate) fn add(&mut self, d: &[f64], direction: &mut [f64]) {
        let (n, q) = (self.n, self.q);
        let length = dot(&d[q..n], &d[q..n]).sqrt();
        let alpha = if d[q] > 0.0 { -length } else { length };
        let beta = 1.0 / (length * (length + d[q].abs()));
        axpy(-alpha, &self.j[q * (n + 1)..][..n + 1], direction);
        for k in q..n {
            let v = if k == q { d[q] - alpha } else { d[k] };
            axpy(-beta * v, direction, &mut self.j[k * (n + 1)..][..n + 1]);
        }
        let column = &mut self.r[q * n..(q + 1) * n];
        column[..q].copy_from_slice(&d[..q]);
        column[q] = alpha;
        self.q += 1;
    }

    /// Removes position `k` from the working set; rotations of neighbouring columns make `R` triangular again.
    pub(crate) fn drop(&mut self, k: usize) {
        let (n, ld) = (self.n, self.n + 1);
        for column in k + 1..self.q {
            self.r.copy_within(column * n..column * n + column + 1, (column - 1) * n);
        }
        self.q -= 1;
        for i in k..self.q {
            let (c, s, length) = givens(self.r[i * n + i], self.r[i * n + i + 1]);
            self.r[i * n + i] = length;
            for column in i + 1..self.q {
                let (a, b) = (self.r[column * n + i], self.r[column * n + i + 1]);
                self.r[column * n + i] = c * a + s * b;
                self.r[column * n + i + 1] = c * b - s * a;
            }
            let (left, right) = self.j.split_at_mut((i + 1) * ld);
            rotate(c, s, &mut left[i * ld..], &mut right[..ld]);
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

    fn matrix() -> Vec<f64> {
        let mut h = vec![0.0; N * N];
        for i in 0..N {
            for j in 0..N {
                h[i * N + j] = (0..N).map(|k| entry(i, k) * entry(j, k)).sum();
            }
            h[i * N + i] += 0.1;
        }
        h
    }

    fn normal(c: usize) -> Vec<f64> {
        (0..N).map(|j| entry(20 + c, 3 * j + 1)).collect()
    }

    fn add(factor: &mut Factor, c: usize) {
        let (mut d, mut direction) = (vec![0.0; N], vec![0.0; N + 1]);
        factor.transpose_times(&normal(c), &mut d);
        factor.free_direction(&d, &mut direction);
        factor.add(&d, &mut direction);
    }

    /// `JᵀHJ = 1`, `JᵀN = [R; 0]` with `R` triangular, and `Jᵀg`.
    fn check(factor: &Factor, gradient: &[f64], members: &[usize]) {
        let h = matrix();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        for k in 0..N {
            for l in 0..N {
                let hj: Vec<f64> = (0..N).map(|i| dot(&h[i * N..(i + 1) * N], factor.column(l))).collect();
                near(dot(factor.column(k), &hj), f64::from(u8::from(k == l)));
            }
            near(factor.gradient(k), dot(factor.column(k), gradient));
        }
        assert_eq!(factor.q(), members.len());
        for (column, &c) in members.iter().enumerate() {
            for k in 0..N {
                let expected = if k <= column { factor.r[column * N + k] } else { 0.0 };
                near(dot(factor.column(k), &normal(c)), expected);
            }
        }
    }

    #[test]
    fn the_factors_survive_adding_and_dropping() {
        let gradient: Vec<f64> = (0..N).map(|j| entry(40, j)).collect();
        let mut factor = Factor::new(N);
        factor.matrix_mut().copy_from_slice(&matrix());
        assert!(factor.factorise(&gradient));
        let mut members = Vec::new();
        check(&factor, &gradient, &members);
        // First, middle and last position, and a full set.
        for (new, dropped) in [(4, None), (3, Some(0)), (1, Some(2)), (3, Some(4)), (2, Some(6))] {
            while members.len() < new + 2 {
                members.push(10 * new + members.len());
                add(&mut factor, *members.last().unwrap());
                check(&factor, &gradient, &members);
            }
            if let Some(k) = dropped.filter(|&k| k < members.len()) {
                factor.drop(k);
                members.remove(k);
                check(&factor, &gradient, &members);
            }
        }
        while members.len() < N {
            members.push(100 + members.len());
            add(&mut factor, *members.last().unwrap());
        }
        check(&factor, &gradient, &members);
        factor.drop(N - 1);
        members.pop();
        check(&factor, &gradient, &members);
    }

    #[test]
    fn triangular_systems() {
        let mut factor = Factor::new(N);
        factor.matrix_mut().copy_from_slice(&matrix());
        assert!(factor.factorise(&[0.0; N]));
        for c in 0..4 {
            add(&mut factor, c);
        }
        let r = |i: usize, k: usize| if i <= k { factor.r[k * N + i] } else { 0.0 };
        let (mut x, mut y) = ([1.0, -2.0, 3.0, 0.5], [1.0, -2.0, 3.0, 0.5]);
        factor.solve(&mut x);
        factor.solve_transposed(&mut y);
        for (i, b) in [1.0, -2.0, 3.0, 0.5].into_iter().enumerate() {
            let (rx, ry) = ((0..4).map(|k| r(i, k) * x[k]), (0..4).map(|k| r(k, i) * y[k]));
            assert!((rx.sum::<f64>() - b).abs() < 1e-12 && (ry.sum::<f64>() - b).abs() < 1e-12);
        }
    }

    #[test]
    fn singular_matrices_are_refused() {
        let mut factor = Factor::new(2);
        for (matrix, definite) in [
            ([1.0, 1.0, 1.0, 1.0], false),
            ([1.0, 1.0, 1.0, 1.0 + 1e-9], true),
            ([0.0, 0.0, 0.0, 1.0], false),
            ([1.0, f64::NAN, f64::NAN, 1.0], false),
        ] {
            factor.matrix_mut().copy_from_slice(&matrix);
            assert_eq!(factor.factorise(&[0.0; 2]), definite, "{matrix:?}");
        }
    }

    /// Sums of fewer squares than variables: what rounding errors leave of the last pivots may be positive.
    #[test]
    fn rank_deficient_matrices_are_refused() {
        for rank in 1..5 {
            for example in 0..20 {
                let mut factor = Factor::new(N);
                for i in 0..N {
                    for j in 0..N {
                        let product = |k: usize| entry(i + example, k) * entry(j + example, k);
                        factor.matrix_mut()[i * N + j] = (0..rank).map(product).sum();
                    }
                }
                assert!(!factor.factorise(&[0.0; N]), "rank {rank}, example {example}");
            }
        }
    }
}
