//! Sensitivity analysis: how much each factor of a study moves an output.
//!
//! Variance-based indices ([`sobol_indices`]) say which share of the variance comes from which factor; elementary effects
//! ([`morris`]) sort out the factors that do nothing, at a far smaller cost. Each estimate has a bootstrap interval.

mod effects;
mod variance;

pub use effects::{Effects, morris};
pub use variance::{Indices, Pair, Shares, sobol_indices};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use legwork::error::Error;

/// An estimate with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimate from all samples.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// How confidence intervals are found: the percentile bootstrap (Efron 1979, doi:10.1214/aos/1176344552; for Sobol' indices
/// Archer, Saltelli and Sobol' 1997, doi:10.1080/00949659708811825).
///
/// Resampling takes base samples for independent. Those of a Sobol' sequence fill the cube more evenly, so that most of
/// their intervals are too wide. Those of factors that hardly matter can be too narrow: with the g-function of eight
/// factors, intervals of 95 % held the truth in 71 to 100 of 100 studies at `N` = 64, and in 84 to 100 at `N` = 512.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bootstrap {
    /// Number of resamples, enough for one or more to lie beyond each end of the interval.
    pub resamples: usize,
    /// Confidence level, between 0 and 1.
    pub level: f64,
    /// Seed of the resampling.
    pub seed: u64,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self { resamples: 1000, level: 0.95, seed: 0 }
    }
}

impl Bootstrap {
    fn check(&self) -> Result<(), Error> {
        if !(self.level > 0.0 && self.level < 1.0) {
            let problem = format!("found {}, expected a number between 0 and 1, such as 0.95", self.level);
            return Err(Error::invalid("bootstrap.level", problem));
        }
        // A hair less than exact, for levels such as 0.95 that doubles do not hold.
        let least = (2.0 / (1.0 - self.level) - 1e-6).ceil();
        if (self.resamples as f64) < least {
            let problem = format!("found {}, expected {least} or more for a level of {}", self.resamples, self.level);
            return Err(Error::invalid("bootstrap.resamples", problem));
        }
        Ok(())
    }

    fn random(&self) -> Pcg64Mcg {
        Pcg64Mcg::seed_from_u64(self.seed)
    }

    /// `value` with the interval that leaves the same share of `replicates` on both sides.
    fn estimate(&self, value: f64, mut replicates: Vec<f64>) -> Estimate {
        replicates.sort_unstable_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - self.level);
        Estimate { value, low: quantile(&replicates, tail), high: quantile(&replicates, 1.0 - tail) }
    }
}

/// Draws `count` of `count` things, with replacement.
fn resample(count: usize, random: &mut Pcg64Mcg) -> Vec<usize> {
    (0..count).map(|_| random.random_range(0..count)).collect()
}

/// The quantile of sorted values, between neighbours on a line (Hyndman and Fan 1996, type 7).
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_a_line_between_neighbours() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0];
        for (share, expected) in [(0.0, 1.0), (0.25, 2.0), (0.375, 3.0), (0.9, 12.8), (1.0, 16.0)] {
            assert!((quantile(&values, share) - expected).abs() < 1e-14);
        }
        assert_eq!(quantile(&[3.0], 0.975), 3.0);
    }

    #[test]
    fn the_interval_of_a_mean_is_that_of_the_normal_distribution() {
        // Means of resamples of 0, 1, ..., n-1 spread by sqrt((n² - 1) / 12 n); 1.96 of them hold 95 %.
        let count = 400;
        let bootstrap = Bootstrap { resamples: 4000, ..Bootstrap::default() };
        let mut random = bootstrap.random();
        let replicates = (0..4000).map(|_| mean(resample(count, &mut random).into_iter().map(|i| i as f64))).collect();
        let estimate = bootstrap.estimate(199.5, replicates);
        let spread = ((count * count - 1) as f64 / (12 * count) as f64).sqrt();
        // The 2.5 % quantile of r replicates deviates by sqrt(0.025 * 0.975 / r) / 0.0584 spreads.
        let tolerance = 4.0 * spread * (0.025_f64 * 0.975 / 4000.0).sqrt() / 0.0584;
        assert!((estimate.low - (199.5 - 1.96 * spread)).abs() < tolerance, "{estimate:?}");
        assert!((estimate.high - (199.5 + 1.96 * spread)).abs() < tolerance, "{estimate:?}");
    }

    #[test]
    fn levels_and_counts_out_of_range_are_refused() {
        let check =
            |resamples, level| Bootstrap { resamples, level, seed: 0 }.check().map_err(|error| error.to_string());
        for level in [0.0, 1.0, -0.1, f64::NAN] {
            assert!(check(1000, level).expect_err("no level").starts_with("bootstrap.level"));
        }
        assert!(check(40, 0.95).is_ok());
        assert!(check(39, 0.95).expect_err("too few").contains("expected 40 or more"));
        assert!(check(199, 0.99).expect_err("too few").contains("expected 200 or more"));
    }
}
