//! Sobol' indices: shares of an output's variance.
//!
//! First order: Saltelli et al. 2010 (doi:10.1016/j.cpc.2009.09.018), Table 2 (b). Total: Jansen 1999
//! (doi:10.1016/S0010-4655(98)00154-4), there (f). Second order: Saltelli 2002 (doi:10.1016/S0010-4655(02)00280-1).

use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::{Bootstrap, Estimate, mean, resample};
use crate::design::saltelli_rows;
use crate::ties;
use legwork::error::Error;

/// What [`sobol_indices`] finds about one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Indices {
    /// Number of base samples whose outputs are all there, which the rest rests on.
    pub used: usize,
    /// Number of base samples that were left out, with one or more outputs missing.
    pub left_out: usize,
    /// Mean of the output over the independent points, A and B.
    pub mean: f64,
    /// Variance of the output over the independent points, A and B.
    pub variance: f64,
    /// The indices, or nothing where the output is the same at all points of A and B but for rounding ([`ties`]): there is no
    /// variance to share.
    pub shares: Option<Shares>,
}

/// Shares of the variance; estimates can be a little below zero or above one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    /// First-order index of each factor: the share that goes away on average when the factor is fixed.
    pub first: Vec<Estimate>,
    /// Total index of each factor: the share that remains on average when all others are fixed.
    pub total: Vec<Estimate>,
    /// Second-order indices: the share of each pair beyond the first-order ones. Empty unless the design has them.
    pub second: Vec<Pair>,
}

/// The interaction of two factors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// The two factors, the lower index first.
    pub factors: [usize; 2],
    /// Their second-order index.
    pub index: Estimate,
}

/// First-order, total and (if the design has them) second-order Sobol' indices of the outputs of
/// [`Design::Saltelli`](crate::design::Design::Saltelli), in the order of its points.
///
/// An output that is not finite is missing, and its base sample is left out as a whole. Indices do not depend on the
/// output's unit or zero: outputs are centred at their mean first, without which a large mean would swamp the estimates of
/// first and second order (Sobol' et al. 2007, doi:10.1016/j.ress.2006.07.001).
///
/// # Errors
/// A number of outputs that the design does not have, fewer than two base samples with all outputs, or a [`Bootstrap`] out
/// of range.
pub fn sobol_indices(
    outputs: &[f64],
    factors: usize,
    second_order: bool,
    bootstrap: &Bootstrap,
) -> Result<Indices, Error> {
    bootstrap.check()?;
    let rows = saltelli_rows(factors, second_order) as usize;
    if factors == 0 || !outputs.len().is_multiple_of(rows) {
        let found = outputs.len();
        let problem = format!("found {found} for {factors} factors, expected a multiple of {rows}, one output a point");
        return Err(Error::invalid("outputs", problem));
    }
    let complete: Vec<&[f64]> =
        outputs.chunks(rows).filter(|sample| sample.iter().all(|output| output.is_finite())).collect();
    let (used, samples) = (complete.len(), outputs.len() / rows);
    if used < 2 {
        let problem = format!("{used} of {samples} base samples have all their outputs, expected 2 or more");
        return Err(Error::invalid("outputs", problem));
    }
    let (samples, centre, scale) = standardised(&complete);
    let samples = Samples { samples, factors, second_order };
    let all: Vec<usize> = (0..used).collect();
    let (middle, variance) = samples.moments(&all);
    Ok(Indices {
        used,
        left_out: outputs.len() / rows - used,
        mean: scale * (middle + centre),
        variance: scale * scale * variance,
        shares: (variance > 0.0).then(|| samples.shares(&all, bootstrap)),
    })
}

/// The outputs in units of `scale`, so that no square is too large for a double, and from `centre` on.
fn standardised(samples: &[&[f64]]) -> (Vec<Vec<f64>>, f64, f64) {
    let outputs = samples.concat();
    let largest = outputs.iter().fold(0.0_f64, |largest, y| largest.max(y.abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let centre = mean(outputs.iter().map(|y| y / scale));
    (samples.iter().map(|sample| sample.iter().map(|y| y / scale - centre).collect()).collect(), centre, scale)
}

/// Standardised outputs, one row a base sample, in the order of the design.
struct Samples {
    samples: Vec<Vec<f64>>,
    factors: usize,
    second_order: bool,
}

impl Samples {
    /// Mean and variance over A and B of the chosen base samples; no variance where all are equal.
    fn moments(&self, chosen: &[usize]) -> (f64, f64) {
        let last = self.samples[0].len() - 1;
        let outputs: Vec<f64> = chosen.iter().flat_map(|&i| [self.samples[i][0], self.samples[i][last]]).collect();
        let centre = mean(outputs.iter().copied());
        // Outputs are in units of the largest.
        let equal = outputs.iter().all(|&y| (y - outputs[0]).abs() <= ties::SHARE);
        (centre, if equal { 0.0 } else { mean(outputs.iter().map(|y| (y - centre).powi(2))) })
    }

    fn pairs(&self) -> Vec<[usize; 2]> {
        let pairs = (0..self.factors).flat_map(|i| (i + 1..self.factors).map(move |j| [i, j]));
        if self.second_order { pairs.collect() } else { Vec::new() }
    }

    /// First-order indices, total indices and those of the pairs, one after the other.
    fn indices(&self, chosen: &[usize], variance: f64, pairs: &[[usize; 2]]) -> Vec<f64> {
        let k = self.factors;
        let mut sums = vec![0.0; 2 * k + pairs.len()];
        for &sample in chosen {
            let sample = &self.samples[sample];
            let (a, ab, ba, b) = (sample[0], &sample[1..=k], &sample[k + 1..], sample[sample.len() - 1]);
            for i in 0..k {
                // Saltelli et al. 2010, Table 2 (b)
                sums[i] += b * (ab[i] - a);
                // Jansen 1999; Saltelli et al. 2010, Table 2 (f)
                sums[k + i] += 0.5 * (a - ab[i]).powi(2);
            }
            for (sum, &[i, j]) in sums[2 * k..].iter_mut().zip(pairs) {
                // Saltelli 2002, Theorem 1: the closed index of the pair
                *sum += ba[i] * ab[j] - a * b;
            }
        }
        let mut indices: Vec<f64> = sums.into_iter().map(|sum| sum / (chosen.len() as f64 * variance)).collect();
        for (pair, &[i, j]) in pairs.iter().enumerate() {
            indices[2 * k + pair] -= indices[i] + indices[j];
        }
        indices
    }

    fn shares(&self, all: &[usize], bootstrap: &Bootstrap) -> Shares {
        let pairs = self.pairs();
        let values = self.indices(all, self.moments(all).1, &pairs);
        let mut replicates = vec![Vec::with_capacity(bootstrap.resamples); values.len()];
        let mut random = bootstrap.random();
        for _ in 0..bootstrap.resamples {
            let (chosen, variance) = self.resample(&mut random);
            for (replicates, index) in replicates.iter_mut().zip(self.indices(&chosen, variance, &pairs)) {
                replicates.push(index);
            }
        }
        let mut estimates =
            values.into_iter().zip(replicates).map(|(value, replicates)| bootstrap.estimate(value, replicates));
        Shares {
            first: estimates.by_ref().take(self.factors).collect(),
            total: estimates.by_ref().take(self.factors).collect(),
            second: pairs.iter().zip(estimates).map(|(&factors, index)| Pair { factors, index }).collect(),
        }
    }

    /// A resample with variance to share, and that variance. One without is drawn again; with two different outputs
    /// among the samples this ends soon.
    fn resample(&self, random: &mut Pcg64Mcg) -> (Vec<usize>, f64) {
        loop {
            let chosen = resample(self.samples.len(), random);
            let (_, variance) = self.moments(&chosen);
            if variance > 0.0 {
                return (chosen, variance);
            }
        }
    }
}
