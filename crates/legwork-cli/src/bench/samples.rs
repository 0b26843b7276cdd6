//! Durations of the same work in several rounds, and what is said of them.

use serde::Serialize;

/// Bins of a histogram.
const BINS: usize = 12;

/// Durations [s] of the same inputs, once a round.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    rounds: Vec<Vec<f64>>,
}

/// What is said of durations. Quantiles are medians of those of the rounds.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Statistics {
    /// Median [µs].
    pub(super) median_us: f64,
    /// What 99 % stay below [µs].
    pub(super) p99_us: f64,
    /// What 99.9 % stay below [µs].
    pub(super) p999_us: f64,
    /// The longest [µs].
    pub(super) max_us: f64,
    /// Of each input's median over the rounds, the longest [µs]: what the work itself takes at worst, without what else
    /// the machine did in some round.
    pub(super) slowest_input_us: f64,
    /// Mean of each input's median over the rounds [µs]: these add up.
    pub(super) mean_us: f64,
}

/// How often which duration occurred, in bins of equal ratio.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Histogram {
    /// Where bins begin and end [µs].
    pub(super) edges_us: Vec<f64>,
    /// The share of all durations in each bin.
    pub(super) shares: Vec<f64>,
    /// The share above the last: the longest hundredth.
    pub(super) above: f64,
}

impl Samples {
    /// Takes in a round, of as many inputs as the others.
    pub(super) fn push(&mut self, round: Vec<f64>) {
        self.rounds.push(round);
    }

    /// What there is to say; there must be a round and an input in it.
    pub(super) fn statistics(&self) -> Statistics {
        let sorted: Vec<Vec<f64>> = self.rounds.iter().cloned().map(sorted).collect();
        let of_rounds =
            |share: f64| 1e6 * median(&mut sorted.iter().map(|round| quantile(round, share)).collect::<Vec<_>>());
        let inputs: Vec<f64> = (0..self.rounds[0].len())
            .map(|input| 1e6 * median(&mut self.rounds.iter().map(|round| round[input]).collect::<Vec<_>>()))
            .collect();
        Statistics {
            median_us: of_rounds(0.5),
            p99_us: of_rounds(0.99),
            p999_us: of_rounds(0.999),
            max_us: of_rounds(1.0),
            slowest_input_us: inputs.iter().copied().fold(0.0, f64::max),
            mean_us: inputs.iter().sum::<f64>() / inputs.len() as f64,
        }
    }

    /// All rounds together.
    pub(super) fn histogram(&self) -> Histogram {
        let all = sorted(self.rounds.concat());
        let low = 1e6 * all[0].max(1e-9);
        let high = (1e6 * quantile(&all, 0.99)).max(1.01 * low);
        let edges_us: Vec<f64> = (0..=BINS).map(|k| low * (high / low).powf(k as f64 / BINS as f64)).collect();
        let below = |edge: f64| all.partition_point(|duration| 1e6 * duration < edge) as f64 / all.len() as f64;
        // The first edge is the shortest duration, up to rounding.
        let mut heads: Vec<f64> = edges_us.iter().map(|&edge| below(edge)).collect();
        heads[0] = 0.0;
        Histogram {
            shares: heads.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            above: 1.0 - heads[BINS],
            edges_us,
        }
    }
}

/// Of values of which there is one at least.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

/// By nearest rank.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rounds: &[&[f64]]) -> Samples {
        Samples { rounds: rounds.iter().map(|round| round.iter().map(|us| us * 1e-6).collect()).collect() }
    }

    #[test]
    fn one_disturbed_round_changes_nothing() {
        let quiet: &[f64] = &[1.0, 2.0, 3.0, 9.0];
        let told = |rounds: &[&[f64]]| {
            let s = samples(rounds).statistics();
            [s.median_us, s.p99_us, s.p999_us, s.max_us, s.slowest_input_us, s.mean_us]
                .map(|us| (us * 1e6).round() as i64)
        };
        let once = told(&[quiet]);
        assert_eq!(once, [3_000_000, 9_000_000, 9_000_000, 9_000_000, 9_000_000, 3_750_000]);
        assert_eq!(told(&[quiet, &[70.0, 80.0, 90.0, 900.0], quiet]), once);
    }

    /// Each round has another input disturbed: the maximum knows, the slowest input does not.
    #[test]
    fn the_slowest_input_is_slow_in_most_rounds() {
        let rounds: [&[f64]; 3] = [&[50.0, 2.0, 4.0], &[1.0, 50.0, 4.0], &[1.0, 2.0, 50.0]];
        let told = samples(&rounds).statistics();
        assert!((told.max_us - 50.0).abs() < 1e-9 && (told.slowest_input_us - 4.0).abs() < 1e-9, "{told:?}");
    }

    #[test]
    fn a_histogram_holds_everything_in_bins_of_equal_ratio() {
        let values: Vec<f64> = (0..2000).map(|k| 1.0 + 0.001 * f64::from(7 * k % 2000)).chain([1e4]).collect();
        let histogram = samples(&[&values]).histogram();
        let total: f64 = histogram.shares.iter().sum::<f64>() + histogram.above;
        assert!((total - 1.0).abs() < 1e-12 && histogram.shares.iter().all(|&share| share >= 0.0), "{histogram:?}");
        assert!((histogram.above - 0.01).abs() < 1e-3, "{}", histogram.above);
        let ratios: Vec<f64> = histogram.edges_us.windows(2).map(|pair| pair[1] / pair[0]).collect();
        assert!(ratios.iter().all(|ratio| (ratio / ratios[0] - 1.0).abs() < 1e-9));
        let same = samples(&[&[2.0; 9]]).histogram();
        assert!((same.shares[0] - 1.0).abs() < 1e-12, "{same:?}");
    }
}
