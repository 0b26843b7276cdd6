//! The search itself: CMA-ES from the base's own levels, for as long as its budget lasts.

use serde::Serialize;

use super::Score;
use crate::Rollout;
use crate::cma_es::{CmaEs, default_population};
use crate::ties;
use legwork::error::Error;

/// How to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How many candidates are tried beside the base.
    pub budget: u64,
    /// Candidates of a generation; none for 4 + ⌊3 ln n⌋ of n factors.
    pub population: Option<usize>,
    /// The first standard deviation, as a share of each factor's range.
    pub sigma: f64,
    /// Seed of the draws.
    pub seed: u64,
}

impl Settings {
    /// Candidates of a generation for so many factors.
    pub(super) fn generation(&self, factors: usize) -> u64 {
        self.population.unwrap_or_else(|| default_population(factors)) as u64
    }
}

/// A candidate that was tried: what it is worth, and its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// What it is worth.
    pub score: Score,
    /// One a training case.
    pub rollouts: Vec<Rollout>,
}

impl Trial {
    fn is_doubtful(&self) -> bool {
        self.rollouts.iter().any(|rollout| rollout.violations.is_some())
    }
}

/// A generation of the search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Generation {
    /// Candidates tried up to its end.
    pub evaluations: u64,
    /// The best of its candidates.
    pub best: Score,
    /// The best up to its end, the base among them.
    pub best_so_far: Score,
    /// How many of its candidates are feasible.
    pub feasible: usize,
    /// The mean objective of those.
    pub mean: Option<f64>,
    /// How many of its candidates have a rollout that broke bounds of the simulator's audit.
    pub doubtful: usize,
    /// The step size that its candidates were drawn with, as a share of the ranges.
    pub sigma: f64,
    /// The centre of its candidates, each coordinate as a share of its range.
    pub centre: Vec<f64>,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stop {
    /// All of its budget is spent.
    Budget,
    /// Going on is of no use; see `CmaEs::converged`.
    Converged(&'static str),
    /// It was told to.
    Interrupted,
}

/// What a search found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// The best point, in the unit cube; none where nothing is better than the base.
    pub(super) point: Option<Vec<f64>>,
    pub(super) trial: Trial,
    pub(super) history: Vec<Generation>,
    pub(super) evaluations: u64,
    pub(super) why: Stop,
}

/// Looks around `start`, a point of the unit cube, for what is better than the `base`. A point for which `evaluate`
/// gives nothing was not tried, and ends the search.
///
/// # Errors
/// Those of `evaluate`.
pub(super) fn search(
    start: &[f64],
    base: Trial,
    settings: &Settings,
    mut evaluate: impl FnMut(&[Vec<f64>]) -> Result<Vec<Option<Trial>>, Error>,
) -> Result<Found, Error> {
    let mut cma_es = CmaEs::new(start, settings.sigma, settings.population, settings.seed);
    let mut found = Found { point: None, trial: base, history: Vec::new(), evaluations: 0, why: Stop::Budget };
    while found.evaluations < settings.budget {
        if let Some(reason) = cma_es.converged() {
            found.why = Stop::Converged(reason);
            break;
        }
        let (sigma, centre) = (cma_es.sigma(), cma_es.mean().to_vec());
        let mut points = cma_es.ask();
        let population = points.len();
        points.truncate(usize::try_from(settings.budget - found.evaluations).unwrap_or(population));
        let asked = points.len();
        let trials = evaluate(&points)?;
        let scores: Vec<Score> = trials.iter().flatten().map(|trial| trial.score).collect();
        let doubtful = trials.iter().flatten().filter(|trial| trial.is_doubtful()).count();
        found.take(points, trials);
        found.evaluations += scores.len() as u64;
        if let Some(best) = scores.iter().copied().min_by(|a, b| a.cost().total_cmp(&b.cost())) {
            let objectives: Vec<f64> = scores.iter().filter_map(|score| score.objective()).collect();
            let feasible = objectives.len();
            found.history.push(Generation {
                evaluations: found.evaluations,
                best,
                best_so_far: found.trial.score,
                feasible,
                mean: (feasible > 0).then(|| objectives.iter().sum::<f64>() / feasible as f64),
                doubtful,
                sigma,
                centre,
            });
        }
        if scores.len() < asked {
            found.why = Stop::Interrupted;
            break;
        }
        // The last generation may be cut short by the budget; no other comes after it.
        if scores.len() == population {
            cma_es.tell(&scores.iter().map(|score| rounded(score.cost())).collect::<Vec<_>>());
        }
    }
    Ok(found)
}

/// A cost to the digits that are more than rounding: those below have no order.
fn rounded(cost: f64) -> f64 {
    (cost / ties::SHARE).round() * ties::SHARE
}

impl Found {
    /// Keeps the best of what was tried; of equals the first.
    fn take(&mut self, points: Vec<Vec<f64>>, trials: Vec<Option<Trial>>) {
        for (point, trial) in points.into_iter().zip(trials) {
            if let Some(trial) = trial.filter(|trial| trial.score.beats(self.trial.score)) {
                (self.point, self.trial) = (Some(point), trial);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(budget: u64) -> Settings {
        Settings { budget, population: None, sigma: 0.2, seed: 1 }
    }

    fn found(
        start: &[f64],
        base: Trial,
        settings: &Settings,
        evaluate: impl FnMut(&[Vec<f64>]) -> Result<Vec<Option<Trial>>, Error>,
    ) -> Found {
        search(start, base, settings, evaluate).expect("nothing goes wrong")
    }

    fn trial(score: Score) -> Trial {
        Trial { score, rollouts: Vec::new() }
    }

    fn all(score: impl Fn(&[f64]) -> Score) -> impl FnMut(&[Vec<f64>]) -> Result<Vec<Option<Trial>>, Error> {
        move |points| Ok(points.iter().map(|point| Some(trial(score(point)))).collect())
    }

    /// Least, 1, at (0.3, 0.6, 0.45).
    fn bowl(x: &[f64]) -> f64 {
        1.0 + x.iter().zip([0.3, 0.6, 0.45]).map(|(x, o)| (x - o).powi(2)).sum::<f64>()
    }

    const START: [f64; 3] = [0.8, 0.8, 0.8];

    #[test]
    fn the_optimum_is_found() {
        let score = |x: &[f64]| Score::Feasible(bowl(x));
        let found = found(&START, trial(score(&START)), &settings(600), all(score));
        // Closer to the optimum there is no difference beyond rounding.
        assert!(bowl(&found.point.expect("something is better")) < 1.0 + 4e-7);
        assert!(matches!(found.why, Stop::Converged(reason) if reason.starts_with("flat")), "{:?}", found.why);
        assert!((200..600).contains(&found.evaluations), "{}", found.evaluations);
        let bests: Vec<f64> = found.history.iter().filter_map(|g| g.best_so_far.objective()).collect();
        assert_eq!(bests.len(), found.history.len());
        assert!(bests.is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn a_bound_across_the_way_is_kept_and_falls_are_left_behind() {
        // Feasible is x0 > 0.5, so that the optimum lies on that edge; the start falls.
        let score = |x: &[f64]| match x {
            [_, y, _] if *y > 0.7 => Score::Falling(1.0 + y),
            [x0, ..] if *x0 < 0.5 => Score::Violating(0.5 - x0),
            x => Score::Feasible(bowl(x)),
        };
        let found = found(&START, trial(score(&START)), &settings(900), all(score));
        let Score::Feasible(best) = found.trial.score else { panic!("{:?}", found.trial.score) };
        assert!(best > 1.0 + 0.2_f64.powi(2) && best < 1.0 + 0.2_f64.powi(2) + 1e-4, "{best}");
        assert!(found.point.expect("something is better")[0] >= 0.5);
    }

    #[test]
    fn where_nothing_is_better_the_base_stays() {
        for worse in [Score::Feasible(1.0), Score::Feasible(1.1), Score::Violating(0.1), Score::Falling(1.0)] {
            let found = found(&START, trial(Score::Feasible(1.0)), &settings(20), all(|_| worse));
            assert_eq!((found.point, found.trial.score), (None, Score::Feasible(1.0)), "{worse:?}");
            assert!(found.history.iter().all(|generation| generation.best == worse));
        }
    }

    #[test]
    fn the_budget_is_met_exactly() {
        for budget in [1, 6, 7, 8, 20] {
            let mut count = 0;
            let evaluate = |points: &[Vec<f64>]| {
                count += points.len() as u64;
                Ok(points.iter().map(|x| Some(trial(Score::Feasible(bowl(x))))).collect())
            };
            let found = found(&START, trial(Score::Feasible(9.0)), &settings(budget), evaluate);
            assert_eq!((count, found.evaluations, found.why), (budget, budget, Stop::Budget));
            // 4 + ⌊3 ln 3⌋ = 7
            assert_eq!(found.history.len() as u64, budget.div_ceil(7));
        }
    }

    #[test]
    fn what_cannot_get_better_ends_before_the_budget() {
        let found = found(&START, trial(Score::Falling(1.0)), &settings(10_000), all(|_| Score::Falling(2.0)));
        assert!(matches!(found.why, Stop::Converged(reason) if reason.starts_with("flat")), "{:?}", found.why);
        assert!(found.evaluations < 1000);
    }

    #[test]
    fn an_interrupted_generation_counts_as_far_as_it_went() {
        let mut count = 0;
        let evaluate = |points: &[Vec<f64>]| {
            let one = |point: &Vec<f64>| {
                count += 1;
                (count <= 10).then(|| trial(Score::Feasible(1.0 / f64::from(count) + 0.0 * point[0])))
            };
            Ok(points.iter().map(one).collect())
        };
        let found = found(&START, trial(Score::Feasible(9.0)), &settings(100), evaluate);
        assert_eq!((found.evaluations, found.history.len(), found.why), (10, 2, Stop::Interrupted));
        assert_eq!(found.trial.score, Score::Feasible(0.1));
    }
}
