//! Elementary effects: Morris 1991 (doi:10.1080/00401706.1991.10484804), with the mean of absolute values of Campolongo,
//! Cariboni and Saltelli 2007 (doi:10.1016/j.envsoft.2006.10.004).

use serde::{Deserialize, Serialize};

use super::{Bootstrap, Estimate, mean, resample};
use legwork::error::Error;

/// The elementary effects of one factor on one output, in the output's unit over the factor's whole range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effects {
    /// Number of effects that the rest rests on; one for each trajectory unless outputs are missing.
    pub used: usize,
    /// Their mean.
    pub mu: f64,
    /// The mean of their absolute values: how much the factor matters.
    pub mu_star: Estimate,
    /// Their standard deviation: how far the factor acts nonlinearly or together with others.
    pub sigma: f64,
}

/// The elementary effects of each factor.
///
/// `points` are those of [`Design::Morris`](crate::design::Design::Morris) in the unit cube, one trajectory after the
/// other, and `outputs` has one number a point. An output that is not finite is missing, and the two effects beside it
/// are left out.
///
/// # Errors
/// Points that are no such trajectories, another number of outputs than points, a factor with fewer than two effects, or
/// a [`Bootstrap`] out of range.
pub fn morris(points: &[Vec<f64>], outputs: &[f64], bootstrap: &Bootstrap) -> Result<Vec<Effects>, Error> {
    bootstrap.check()?;
    if outputs.len() != points.len() {
        let problem = format!("found {}, expected {}, one output a point", outputs.len(), points.len());
        return Err(Error::invalid("outputs", problem));
    }
    let effects = elementary_effects(points, outputs)?;
    if let Some(factor) = effects.iter().position(|effects| effects.len() < 2) {
        let problem = format!("factor {factor} has {} effects, expected 2 or more", effects[factor].len());
        return Err(Error::invalid("outputs", problem));
    }
    let mut random = bootstrap.random();
    let summary = |effects: Vec<f64>| {
        let used = effects.len();
        let mu = mean(effects.iter().copied());
        let sum_of_squares: f64 = effects.iter().map(|effect| (effect - mu).powi(2)).sum();
        let mu_star = |chosen: &[usize]| mean(chosen.iter().map(|&i| effects[i].abs()));
        let replicates = (0..bootstrap.resamples).map(|_| mu_star(&resample(used, &mut random))).collect();
        Effects {
            used,
            mu,
            // Campolongo et al. 2007, 3.1
            mu_star: bootstrap.estimate(mu_star(&Vec::from_iter(0..used)), replicates),
            sigma: (sum_of_squares / (used - 1) as f64).sqrt(),
        }
    };
    Ok(effects.into_iter().map(summary).collect())
}

/// The effects of each factor, a trajectory after the other.
fn elementary_effects(points: &[Vec<f64>], outputs: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
    let factors = points.first().map_or(0, Vec::len);
    if factors == 0 || !points.len().is_multiple_of(factors + 1) || points.iter().any(|point| point.len() != factors) {
        let problem =
            format!("{} points of {factors} coordinates are no trajectories of one more points", points.len());
        return Err(Error::invalid("points", problem));
    }
    let mut effects = vec![Vec::new(); factors];
    for (trajectory, outputs) in points.chunks(factors + 1).zip(outputs.chunks(factors + 1)) {
        let mut changed = vec![false; factors];
        for step in 0..factors {
            let (from, to) = (&trajectory[step], &trajectory[step + 1]);
            let factor = changed_factor(from, to).filter(|&factor| !changed[factor]);
            let Some(factor) = factor else {
                let problem = format!("{from:?} to {to:?} changes no factor, several, or one for the second time");
                return Err(Error::invalid("points", problem));
            };
            changed[factor] = true;
            // Morris 1991, (1)
            let effect = (outputs[step + 1] - outputs[step]) / (to[factor] - from[factor]);
            if effect.is_finite() {
                effects[factor].push(effect);
            }
        }
    }
    Ok(effects)
}

/// The only factor whose value differs.
fn changed_factor(from: &[f64], to: &[f64]) -> Option<usize> {
    let mut changed = (0..from.len()).filter(|&i| from[i] != to[i]);
    changed.next().filter(|_| changed.next().is_none())
}
