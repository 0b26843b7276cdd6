//! What a curve does: rank correlation, straightness, spread. Spearman 1904; least squares

use legwork_study::ties::ranks;

/// Spearman's rank correlation of two lists of one length, ties (also those but for rounding) by their mean rank; none for fewer than three pairs or
/// where one of them is constant.
pub(crate) fn spearman(x: &[f64], y: &[f64]) -> Option<f64> {
    if x.len() < 3 {
        return None;
    }
    pearson(&ranks(x), &ranks(y))
}

/// The share of the variance of `y` that a straight line through `x` explains, R²; none as [`spearman`].
pub(crate) fn straightness(x: &[f64], y: &[f64]) -> Option<f64> {
    if x.len() < 3 {
        return None;
    }
    pearson(x, y).map(|r| r * r)
}

/// Largest minus smallest; none of nothing.
pub(crate) fn spread(values: &[f64]) -> Option<f64> {
    let least = values.iter().copied().reduce(f64::min)?;
    let most = values.iter().copied().reduce(f64::max)?;
    Some(most - least)
}

/// Root of the mean square; zero of nothing.
pub(crate) fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u64), |(sum, count), value| (sum + value * value, count + 1));
    if count == 0 { 0.0 } else { (sum / count as f64).sqrt() }
}

fn pearson(x: &[f64], y: &[f64]) -> Option<f64> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mx, my) = (mean(x), mean(y));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
        yy += (y - my) * (y - my);
    }
    let product = xx * yy;
    (product > 0.0).then(|| xy / product.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];

    fn near(value: Option<f64>, expected: f64) {
        let value = value.expect("it is defined");
        assert!((value - expected).abs() < 1e-12, "{value} is not {expected}");
    }

    #[test]
    fn ranks_see_order_and_nothing_else() {
        near(spearman(&X, &[0.1, 0.2, 7.0, 8.0, 1e9]), 1.0);
        near(spearman(&X, &[5.0, 4.0, 3.0, 2.0, -99.0]), -1.0);
        // 1 - 6 Σd² / n(n² - 1) with d = 0, 0, 0, 1, -1, which holds without ties
        near(spearman(&X, &[1.0, 2.0, 3.0, 5.0, 4.0]), 1.0 - 6.0 * 2.0 / 120.0);
        // With ties, by hand: ranks 1.5, 1.5, 3, 4, 5; covariance 9.5, variances 10 and 9.5
        near(spearman(&X, &[2.0, 2.0, 3.0, 4.0, 5.0]), 9.5 / (10.0_f64 * 9.5).sqrt());
    }

    #[test]
    fn what_is_constant_or_short_has_no_correlation() {
        assert_eq!(spearman(&X, &[3.0; 5]), None);
        assert_eq!(spearman(&X[..2], &[1.0, 2.0]), None);
        assert_eq!(straightness(&X, &[3.0; 5]), None);
    }

    #[test]
    fn straightness_is_one_of_a_line_and_less_of_a_bend() {
        near(straightness(&X, &X.map(|x| 3.0 - 2.0 * x)), 1.0);
        // y = x² at 0, 1, 2: slope 2, residuals 1/3, -2/3, 1/3, so 1 - (2/3) / (26/3)
        near(straightness(&[0.0, 1.0, 2.0], &[0.0, 1.0, 4.0]), 1.0 - (2.0 / 3.0) / (26.0 / 3.0));
    }

    #[test]
    fn spread_and_root_mean_square() {
        assert_eq!((spread(&[3.0, -1.0, 2.0]), spread(&[])), (Some(4.0), None));
        assert_eq!(root_mean_square([3.0, -4.0, 0.0, 0.0].into_iter()), 2.5);
        assert_eq!(root_mean_square(std::iter::empty()), 0.0);
    }
}
