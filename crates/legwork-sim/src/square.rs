//! Square linear equations by Gauss's elimination with the largest pivots, the factors kept for further right sides.

/// Factors of a matrix, row by row, preallocated.
#[derive(Clone, Debug)]
pub(super) struct Square {
    n: usize,
    /// The matrix; after [`Square::factor`] U, and below its diagonal the multipliers.
    pub(super) entry: Vec<f64>,
    /// The row that took the place of each column's.
    pivot: Vec<usize>,
    /// 1 / U_kk.
    inverse: Vec<f64>,
}

impl Square {
    /// Storage for `n` equations.
    pub(super) fn new(n: usize) -> Self {
        Self { n, entry: vec![0.0; n * n], pivot: vec![0; n], inverse: vec![0.0; n] }
    }

    /// Takes `n` equations, at most as many as there is storage for; their entries are those of no matrix yet.
    pub(super) fn resize(&mut self, n: usize) {
        self.n = n;
        self.entry.resize(n * n, 0.0);
        self.pivot.resize(n, 0);
        self.inverse.resize(n, 0.0);
    }

    /// Factorises `entry` in place. False where the matrix is singular.
    pub(super) fn factor(&mut self) -> bool {
        let n = self.n;
        for k in 0..n {
            let (upper, lower) = self.entry.split_at_mut((k + 1) * n);
            let own = &mut upper[k * n..];
            let mut pivot = (k, own[k].abs());
            for (row, entries) in lower.chunks_exact(n).enumerate() {
                let size = entries[k].abs();
                if size > pivot.1 {
                    pivot = (k + 1 + row, size);
                }
            }
            if pivot.1.is_nan() || pivot.1 == 0.0 {
                return false;
            }
            self.pivot[k] = pivot.0;
            if pivot.0 != k {
                own.swap_with_slice(&mut lower[(pivot.0 - k - 1) * n..(pivot.0 - k) * n]);
            }
            let inverse = 1.0 / own[k];
            self.inverse[k] = inverse;
            for row in lower.chunks_exact_mut(n) {
                let factor = row[k] * inverse;
                row[k] = factor;
                for (value, own) in row[k + 1..].iter_mut().zip(&own[k + 1..]) {
                    *value -= factor * own;
                }
            }
        }
        true
    }

    /// `x := A⁻¹ x`
    pub(super) fn solve(&self, x: &mut [f64]) {
        let n = self.n;
        if n == 0 {
            return;
        }
        for (k, &pivot) in self.pivot.iter().enumerate() {
            x.swap(k, pivot);
        }
        for (k, row) in self.entry.chunks_exact(n).enumerate() {
            let (before, rest) = x.split_at_mut(k);
            rest[0] -= row.iter().zip(&*before).map(|(factor, x)| factor * x).sum::<f64>();
        }
        for (k, row) in self.entry.chunks_exact(n).enumerate().rev() {
            let (before, after) = x.split_at_mut(k + 1);
            let known: f64 = row[k + 1..].iter().zip(&*after).map(|(entry, x)| entry * x).sum();
            before[k] = (before[k] - known) * self.inverse[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_solves_satisfies_the_equations_for_every_right_side() {
        let matrix = [0.0, 2.0, -1.0, 0.5, 1.0, 0.0, 3.0, -2.0, 4.0, 1.0, 0.0, 7.0, -2.0, 5.0, 1.5, 0.25];
        let mut square = Square::new(4);
        square.entry.copy_from_slice(&matrix);
        assert!(square.factor());
        for right in [[1.0, 0.0, 0.0, 0.0], [0.5, -2.0, 3.0, 1.0]] {
            let mut x = right;
            square.solve(&mut x);
            for (row, right) in matrix.chunks(4).zip(right) {
                let left: f64 = row.iter().zip(x).map(|(entry, x)| entry * x).sum();
                assert!((left - right).abs() < 1e-14, "{left} and {right}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        for matrix in [[1.0, 2.0, 2.0, 4.0], [f64::NAN, 0.0, 0.0, 1.0]] {
            let mut square = Square::new(2);
            square.entry.copy_from_slice(&matrix);
            assert!(!square.factor());
        }
    }
}
