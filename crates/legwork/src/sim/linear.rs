//! Cholesky factorisation in place of the one symmetric matrix of a step.

use nalgebra::DMatrix;

/// Overwrites the lower triangle of the symmetric positive definite `matrix` with L, where `L Lᵀ = matrix`.
/// Returns false where it is not positive definite.
pub fn factor(matrix: &mut DMatrix<f64>) -> bool {
    let n = matrix.nrows();
    for j in 0..n {
        let mut pivot = matrix[(j, j)];
        for k in 0..j {
            pivot -= matrix[(j, k)] * matrix[(j, k)];
        }
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let pivot = libm::sqrt(pivot);
        matrix[(j, j)] = pivot;
        for i in j + 1..n {
            let mut value = matrix[(i, j)];
            for k in 0..j {
                value -= matrix[(i, k)] * matrix[(j, k)];
            }
            matrix[(i, j)] = value / pivot;
        }
    }
    true
}

/// `x := L⁻¹ x`
pub fn solve_lower(factor: &DMatrix<f64>, x: &mut [f64]) {
    for i in 0..x.len() {
        let mut value = x[i];
        for k in 0..i {
            value -= factor[(i, k)] * x[k];
        }
        x[i] = value / factor[(i, i)];
    }
}

/// `x := L⁻ᵀ x`
pub fn solve_upper(factor: &DMatrix<f64>, x: &mut [f64]) {
    for i in (0..x.len()).rev() {
        let mut value = x[i];
        for k in i + 1..x.len() {
            value -= factor[(k, i)] * x[k];
        }
        x[i] = value / factor[(i, i)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_system_and_refuses_an_indefinite_one() {
        let matrix = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0]);
        let expected = [1.0, -2.0, 0.5];
        let mut x: Vec<f64> = (0..3).map(|i| (0..3).map(|j| matrix[(i, j)] * expected[j]).sum()).collect();
        let mut l = matrix.clone();
        assert!(factor(&mut l));
        solve_lower(&l, &mut x);
        solve_upper(&l, &mut x);
        for i in 0..3 {
            assert!((x[i] - expected[i]).abs() < 1e-14);
        }
        assert!(!factor(&mut DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0])));
        assert!(!factor(&mut DMatrix::from_row_slice(1, 1, &[f64::NAN])));
    }
}
