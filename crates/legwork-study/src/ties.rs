//! Which figures of rollouts are equal: those that differ by no more than rounding.
//!
//! Everything that ranks or compares figures asks here, so that what is the same but for rounding has no sensitivity, no
//! order and no better one. docs/sensitivity.md has the measurement.

/// Two figures that differ by no more than this share of the larger are equal.
///
/// Runs that are equal by mathematics, as with all weights multiplied by one number or with a start that is one last digit
/// off, differ by 1e-13 in most figures and by up to 1.5e-8 after pushes.
pub const SHARE: f64 = 1e-7;

/// What is not above this, in its unit, is nothing: a mean speed that is zero comes out as 1e-14 m/s.
pub const NOTHING: f64 = 1e-12;

/// Whether two figures are equal. What is not finite equals itself alone.
pub fn are_equal(a: f64, b: f64) -> bool {
    a == b || ((a - b).is_finite() && (a - b).abs() <= (SHARE * a.abs().max(b.abs())).max(NOTHING))
}

/// The rank of each value, from 1 on; equal values share the mean of their ranks. What is not a number has no rank and
/// remains; infinite values rank first or last and are equal.
///
/// Values are taken together from the least on, as long as they are equal to the first of theirs: so a chain of small steps
/// is not one value.
pub fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).filter(|&index| !values[index].is_nan()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![f64::NAN; values.len()];
    let mut first = 0;
    while let Some(&least) = order.get(first) {
        let is_equal = |&index: &usize| are_equal(values[index], values[least]);
        let count = order[first..].partition_point(is_equal);
        let mean = first as f64 + 0.5 * (count as f64 + 1.0);
        order[first..first + count].iter().for_each(|&index| ranks[index] = mean);
        first += count;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_by_rounding_is_equal_and_what_differs_by_more_is_not() {
        for size in [1e-9, 0.004, 1.0, 3e4] {
            assert!(are_equal(size, size * (1.0 + 0.9e-7)) && are_equal(-size, -size * (1.0 - 0.9e-7)));
            assert!(!are_equal(size, size * (1.0 + 2e-3)) && !are_equal(size, -size));
        }
        assert!(are_equal(3e-14, -8e-15) && !are_equal(3e-11, -8e-12));
    }

    #[test]
    fn equal_values_share_the_mean_of_their_ranks() {
        assert_eq!(ranks(&[3.0, 1.0, 2.0, 1.0]), [4.0, 1.5, 3.0, 1.5]);
        assert_eq!(ranks(&[70.0, 70.0 + 1e-11, 70.0 - 1e-11, 71.0]), [2.0, 2.0, 2.0, 4.0]);
        assert_eq!(ranks(&[1e-14, -3e-15, 0.0]), [2.0; 3], "nothing is nothing");
        assert_eq!(ranks(&[-1e300, 0.0, 1e-11, 1e9, f64::INFINITY, f64::INFINITY]), [1.0, 2.0, 3.0, 4.0, 5.5, 5.5]);
        assert_eq!(ranks(&[]), [0.0; 0]);
        let with_hole = ranks(&[3.0, f64::NAN, 1.0]);
        assert!(with_hole[0] == 2.0 && with_hole[1].is_nan() && with_hole[2] == 1.0);
    }

    #[test]
    fn a_chain_of_small_steps_is_not_one_value() {
        let chain: Vec<f64> = (0..100).map(|step| 1.0 + 0.6e-7 * f64::from(step)).collect();
        let ranks = ranks(&chain);
        // Two of them are equal, three are not.
        assert!(ranks.chunks(2).enumerate().all(|(pair, two)| two == [2.0 * pair as f64 + 1.5; 2]), "{ranks:?}");
    }

    #[test]
    fn noise_that_is_far_below_the_differences_has_no_rank() {
        // In the case between, of noise of 1e-10 on steps of 1e-6, ranks are those of the steps.
        let noisy: Vec<f64> = (0..40).map(|i| 2.0 + 1e-6 * f64::from(i / 10) + 1e-10 * f64::from(i * 7 % 10)).collect();
        assert!(ranks(&noisy).chunks(10).enumerate().all(|(step, ten)| ten == [10.0 * step as f64 + 5.5; 10]));
    }
}
