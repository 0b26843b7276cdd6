//! The few vector operations that everything else is made of, and exact scale factors.

/// `aᵀb`. Four sums side by side, as the compiler may not reorder one.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_chunks, a_rest) = a.as_chunks::<4>();
    let (b_chunks, b_rest) = b.as_chunks::<4>();
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let mut rest = 0.0;
    for (a, b) in a_rest.iter().zip(b_rest) {
        rest += a * b;
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// `∑ |a_j b_j|`, the size of what cancels in [`dot`].
pub(crate) fn dot_abs(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a * b).abs()).sum()
}

/// `y += alpha x`.
pub(crate) fn axpy(alpha: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += alpha * x;
    }
}

/// Largest absolute value.
pub(crate) fn max_abs(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |largest, a| a.abs().max(largest))
}

/// The largest power of two that is not above `x > 0`: scaling by it rounds nothing.
pub(crate) fn power_of_two(x: f64) -> f64 {
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & 0x7ff0_0000_0000_0000)
}

/// Cosine, sine and `√(a² + b²)` of the rotation that turns `(a, b)` into `(√(a² + b²), 0)`.
pub(crate) fn givens(a: f64, b: f64) -> (f64, f64, f64) {
    let largest = a.abs().max(b.abs());
    if largest == 0.0 {
        return (1.0, 0.0, 0.0);
    }
    let (x, y) = (a / largest, b / largest);
    let length = (x * x + y * y).sqrt();
    (x / length, y / length, largest * length)
}

/// The largest power of two that is not above `√x`, `x > 0`.
pub(crate) fn power_of_two_root(x: f64) -> f64 {
    let exponent = (x.max(f64::MIN_POSITIVE).to_bits() >> 52 & 0x7ff) as i64 - 1023;
    f64::from_bits((((exponent >> 1) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dot_of_all_lengths() {
        let numbers: Vec<f64> = (1..=40).map(f64::from).collect();
        for length in 0..=40 {
            let squares: u32 = (1..=length as u32).map(|k| k * k).sum();
            assert!((dot(&numbers[..length], &numbers[..length]) - f64::from(squares)).abs() < 0.5);
        }
    }

    #[test]
    fn power_of_two_is_below_and_within_a_factor_of_two() {
        for x in [1.0, 1.999, 2.0, 3.7e-5, 8.1e200, 5e-300] {
            let p = power_of_two(x);
            assert!(p <= x && x < 2.0 * p, "{p} for {x}");
            assert_eq!(p.to_bits() & 0x000f_ffff_ffff_ffff, 0);
            let root = power_of_two_root(x);
            assert!(root * root <= x && x < 4.0 * root * root, "{root} for {x}");
        }
    }

    #[test]
    fn givens_zeroes_the_second_entry() {
        for (a, b) in [(3.0, 4.0), (-3.0, 4.0), (0.0, 2.0), (1e200, -1e200), (5.0, 0.0)] {
            let (c, s, length) = givens(a, b);
            assert!((c * a + s * b - length).abs() <= 1e-15 * length && (c * b - s * a).abs() <= 1e-15 * length);
        }
    }
}
