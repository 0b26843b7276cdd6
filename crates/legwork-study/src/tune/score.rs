//! How good a candidate is.
//!
//! Falls, bounds and objective are never added up: what stands beats what falls, and what keeps its bounds beats what
//! does not, by however much. K. Deb, "An efficient constraint handling method for genetic algorithms", Computer Methods
//! in Applied Mechanics and Engineering 186 (2000), 311-338, with falls as the worst class of all.

use serde::Serialize;

use super::{Bound, Case, Constraint, Term};
use crate::rollout::Column;
use crate::ties;
use crate::{Ending, Rollout};
use legwork::error::Error;

/// What a candidate is worth; the lesser is the better one.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Score {
    /// It stands in all cases and keeps all bounds: the objective, 1 as that of the base.
    Feasible(f64),
    /// It stands in all cases: by which shares it is beyond its bounds, in sum. A figure that the run does not have, as
    /// the recovery time of one that did not recover, counts as one at twice its bound.
    Violating(f64),
    /// It falls: of each case that it falls in, 1 and the share of the time that was still to go; 2 where it cannot be
    /// run at all.
    Falling(f64),
}

impl Score {
    /// A finite number in the same order, below 1, from 1 to 2, and above 2.
    pub fn cost(self) -> f64 {
        let squashed = |x: f64| (1.0 - 1.0 / (1.0 + x.abs())).copysign(x);
        match self {
            Self::Feasible(objective) => squashed(objective),
            Self::Violating(excess) => 1.0 + squashed(excess),
            Self::Falling(falls) => 2.0 + falls,
        }
    }

    /// Whether it is better than `other`, by more than rounding ([`ties`]).
    pub fn beats(self, other: Self) -> bool {
        let are_equal = match (self, other) {
            (Self::Feasible(a), Self::Feasible(b))
            | (Self::Violating(a), Self::Violating(b))
            | (Self::Falling(a), Self::Falling(b)) => ties::are_equal(a, b),
            _ => false,
        };
        self < other && !are_equal
    }

    /// The objective, where all is well.
    pub fn objective(self) -> Option<f64> {
        match self {
            Self::Feasible(objective) => Some(objective),
            Self::Violating(_) | Self::Falling(_) => None,
        }
    }
}

/// A figure of one case; `number` is what it is multiplied by or its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    case: usize,
    column: usize,
    number: f64,
}

/// Objective and constraints, once the base's figures are known.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    durations: Vec<f64>,
    /// With weight / figure of the base
    parts: Vec<Part>,
    total_weight: f64,
    /// The most that figures may be.
    highest: Vec<Part>,
    /// The least.
    lowest: Vec<Part>,
}

impl Judge {
    /// By the base's rollouts `base`, one a case.
    ///
    /// # Errors
    /// Something is to be compared with a figure that the base does not have, or has as zero.
    pub(super) fn new(
        cases: &[Case],
        columns: &[Column],
        objective: &[Term],
        constraints: &[Constraint],
        base: &[Rollout],
    ) -> Result<Self, Error> {
        let mut judge = Self {
            durations: cases.iter().map(|case| case.variant().scenario.duration_s).collect(),
            parts: Vec::new(),
            total_weight: 0.0,
            highest: Vec::new(),
            lowest: Vec::new(),
        };
        for term in objective {
            for (&case, figure) in term.cases.iter().zip(term.of_base(cases, columns, base)?) {
                let weight = term.weight * cases[case].weight;
                judge.parts.push(Part { case, column: term.column, number: weight / figure });
                judge.total_weight += weight;
            }
        }
        for Constraint { term, bound } in constraints {
            let figures = match bound {
                Bound::AtMost(number) | Bound::AtLeast(number) => vec![*number; term.cases.len()],
                Bound::AtMostTimesBase(times) => {
                    term.of_base(cases, columns, base)?.iter().map(|figure| times * figure).collect()
                }
            };
            let of = |(&case, number)| Part { case, column: term.column, number };
            let bounds = if matches!(bound, Bound::AtLeast(_)) { &mut judge.lowest } else { &mut judge.highest };
            bounds.extend(term.cases.iter().zip(figures).map(of));
        }
        Ok(judge)
    }

    /// What a candidate is worth by its rollouts, one a case.
    pub(super) fn score(&self, rollouts: &[Rollout]) -> Score {
        let falls: f64 = rollouts.iter().zip(&self.durations).map(|(rollout, &duration)| fall(rollout, duration)).sum();
        if falls > 0.0 {
            return Score::Falling(falls);
        }
        let figure = |part: &Part| rollouts[part.case].figures.get(part.column).copied().flatten();
        let beyond = |bound: &Part, side: f64| {
            let excess = figure(bound).map_or(1.0, |figure| side * (figure / bound.number - 1.0));
            if excess > ties::SHARE { excess } else { 0.0 }
        };
        let missing = self.parts.iter().filter(|part| figure(part).is_none()).count();
        let above: f64 = self.highest.iter().map(|bound| beyond(bound, 1.0)).sum();
        let below: f64 = self.lowest.iter().map(|bound| beyond(bound, -1.0)).sum();
        let excess = missing as f64 + above + below;
        if excess > 0.0 {
            return Score::Violating(excess);
        }
        let sum: f64 = self.parts.iter().map(|part| part.number * figure(part).unwrap_or(0.0)).sum();
        Score::Feasible(sum / self.total_weight)
    }
}

/// 0 where it stood to the end.
fn fall(rollout: &Rollout, duration: f64) -> f64 {
    match rollout.ending {
        Ending::Completed | Ending::Injurious => 0.0,
        Ending::Fell => 2.0 - (rollout.fell_at_s.unwrap_or(0.0) / duration).clamp(0.0, 1.0),
        Ending::Invalid | Ending::Failed => 2.0,
    }
}

impl Term {
    /// The base's figure in each of the term's cases. Where the base fell it has none that could be compared: there the
    /// mean over the others takes its place.
    fn of_base(&self, cases: &[Case], columns: &[Column], base: &[Rollout]) -> Result<Vec<f64>, Error> {
        let name = &columns[self.column].name;
        let wrong = |problem: String| Err(Error::invalid(&self.place, problem));
        let mut figures = Vec::with_capacity(self.cases.len());
        for &case in &self.cases {
            let figure = base[case].figures.get(self.column).copied().flatten();
            match figure.filter(|_| base[case].survived()) {
                None if base[case].survived() => {
                    let hint = "name the cases that have it with cases or scenarios";
                    return wrong(format!("the case \"{}\" has no {name} as it stands; {hint}", cases[case].name));
                }
                Some(figure) if figure < ties::NOTHING => {
                    let problem = "nothing can be relative to it";
                    return wrong(format!(
                        "{name} of the case \"{}\" is {figure} as it stands; {problem}",
                        cases[case].name
                    ));
                }
                figure => figures.push(figure),
            }
        }
        let known: Vec<f64> = figures.iter().copied().flatten().collect();
        if known.is_empty() {
            return wrong(format!(
                "in all of its cases the robot falls as it stands; nothing has a {name} to compare with"
            ));
        }
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        Ok(figures.into_iter().map(|figure| figure.unwrap_or(mean)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tune::Tuning;

    #[test]
    fn standing_beats_falling_and_keeping_bounds_beats_breaking_them() {
        let ordered = [
            Score::Feasible(-1e300),
            Score::Feasible(0.5),
            Score::Feasible(1e9),
            Score::Violating(1e-6),
            Score::Violating(f64::MAX),
            Score::Falling(1.0),
            Score::Falling(7.5),
        ];
        for pair in ordered.windows(2) {
            assert!(pair[0] < pair[1] && pair[0].cost() < pair[1].cost(), "{pair:?}");
        }
        assert!(Score::Feasible(0.5).beats(Score::Feasible(0.5 * (1.0 + 2e-7))));
        for score in [Score::Feasible, Score::Violating, Score::Falling] {
            assert!(!score(1.0 - 1e-9).beats(score(1.0)), "rounding is no better");
        }
        assert!(Score::Feasible(f64::INFINITY).cost() <= Score::Violating(0.0).cost());
    }

    const TEXT: &str = r#"
        budget = 1
        factors = [{ path = "controller.planner.com_gain", linear = { from = 1000, to = 2000 } }]
        cases = [{ scenario = "walk" }, { scenario = "push", weight = 3 }]
        held_out = [{ scenario = "stand" }]
        objective = [
            { metric = "com_error_m.mean", weight = 2 },
            { metric = "recovery_time_s", scenarios = ["push"] },
        ]
        constraints = [
            { metric = "torque_nm.mean", at_most = 80 },
            { metric = "u2_n2m2.mean", at_most_times_base = 1.1, cases = ["walk"] },
        ]
    "#;

    /// A run with these figures and no other.
    fn rollout(tuning: &Tuning, figures: [Option<f64>; 4]) -> Rollout {
        let names = ["com_error_m.mean", "recovery_time_s", "torque_nm.mean", "u2_n2m2.mean"];
        let of = |column: &Column| names.iter().position(|name| *name == column.name).and_then(|i| figures[i]);
        let figures = tuning.columns.iter().map(of).collect();
        Rollout { ending: Ending::Completed, reason: None, figures, ..Rollout::invalid(String::new()) }
    }

    fn judge(tuning: &Tuning, base: &[Rollout]) -> Result<Judge, Error> {
        Judge::new(&tuning.training, &tuning.columns, &tuning.objective, &tuning.constraints, base)
    }

    fn fallen(at: f64) -> Rollout {
        Rollout { ending: Ending::Fell, fell_at_s: Some(at), ..Rollout::invalid(String::new()) }
    }

    #[test]
    fn the_objective_is_the_weighted_mean_of_figures_relative_to_the_base() {
        let tuning = Tuning::parse(TEXT, "t.toml", None).unwrap();
        let walk = rollout(&tuning, [Some(0.01), None, Some(70.0), Some(30e3)]);
        let push = rollout(&tuning, [Some(0.5), Some(4.0), Some(60.0), Some(40e3)]);
        let judge = judge(&tuning, &[walk.clone(), push.clone()]).unwrap();
        assert_eq!(judge.score(&[walk.clone(), push.clone()]), Score::Feasible(1.0));
        // Weights 2, 6 and 3: the walk's error halved, the push's as it was, its recovery a quarter slower
        let better = rollout(&tuning, [Some(0.005), None, Some(80.0), Some(33e3)]);
        let slower = rollout(&tuning, [Some(0.5), Some(5.0), Some(60.0), Some(90e3)]);
        let Score::Feasible(found) = judge.score(&[better, slower]) else { panic!("all bounds are kept") };
        assert!((found - (2.0 * 0.5 + 6.0 + 3.0 * 1.25) / 11.0).abs() < 1e-15);
        // 10 % above 80, and a third more than 1.1 times 30 000
        let heavy = rollout(&tuning, [Some(0.001), None, Some(88.0), Some(44e3)]);
        let Score::Violating(found) = judge.score(&[heavy, push.clone()]) else { panic!("it breaks its bounds") };
        assert!((found - (0.1 + 1.0 / 3.0)).abs() < 1e-12);
        let lost = rollout(&tuning, [Some(0.01), None, Some(60.0), Some(30e3)]);
        assert_eq!(judge.score(&[walk, lost]), Score::Violating(1.0), "one that does not recover");
    }

    #[test]
    fn a_lower_bound_is_kept_from_above() {
        let text = TEXT.replace("at_most_times_base = 1.1", "at_least = 20e3");
        let tuning = Tuning::parse(&text, "t.toml", None).unwrap();
        let walk = |u2| rollout(&tuning, [Some(0.01), None, Some(70.0), u2]);
        let push = rollout(&tuning, [Some(0.5), Some(4.0), Some(60.0), Some(40e3)]);
        let judge = judge(&tuning, &[walk(Some(30e3)), push.clone()]).unwrap();
        let score = |u2| judge.score(&[walk(u2), push.clone()]);
        assert_eq!((score(Some(20e3)), score(Some(90e3))), (Score::Feasible(1.0), Score::Feasible(1.0)));
        assert_eq!((score(Some(15e3)), score(None)), (Score::Violating(0.25), Score::Violating(1.0)));
    }

    #[test]
    fn a_star_stands_for_any_text_and_its_figures_share_the_weight() {
        let text = TEXT.replace("\"com_error_m.mean\", weight = 2", "\"joint.*_knee.torque_peak_nm\", weight = 2");
        let tuning = Tuning::parse(&text.replace("\"torque_nm.mean\"", "\"*.peak\""), "t.toml", None).unwrap();
        let names = |columns: Vec<usize>| columns.iter().map(|&c| tuning.columns[c].name.as_str()).collect::<Vec<_>>();
        let objective: Vec<_> = tuning.objective.iter().map(|term| (term.column, term.weight)).collect();
        let knees = ["joint.right_knee.torque_peak_nm", "joint.left_knee.torque_peak_nm", "recovery_time_s"];
        assert_eq!(names(objective.iter().map(|term| term.0).collect()), knees);
        assert_eq!(objective.iter().map(|term| term.1).collect::<Vec<_>>(), [1.0, 1.0, 1.0]);
        let bounded = names(tuning.constraints.iter().map(|constraint| constraint.term.column).collect());
        let peaks = tuning.columns.iter().filter(|column| column.name.ends_with(".peak")).count();
        assert!(bounded.len() == peaks + 1 && bounded.contains(&"torque_nm.peak"), "{bounded:?}");
        let unknown = TEXT.replace("\"com_error_m.mean\"", "\"joint.*_elbow.torque_peak_nm\"");
        let error = Tuning::parse(&unknown, "t.toml", None).unwrap_err().to_string();
        assert!(error.contains("found \"joint.*_elbow.torque_peak_nm\"; valid are com_error_m.mean, "), "{error}");
    }

    #[test]
    fn a_later_fall_is_better_than_an_earlier_one_and_both_than_two() {
        let tuning = Tuning::parse(TEXT, "t.toml", None).unwrap();
        let good = rollout(&tuning, [Some(0.01), Some(4.0), Some(70.0), Some(30e3)]);
        let judge = judge(&tuning, &[good.clone(), good.clone()]).unwrap();
        // The walk lasts 8 s, the push 6.5 s.
        assert_eq!(judge.score(&[fallen(6.0), good.clone()]), Score::Falling(1.25));
        assert_eq!(judge.score(&[fallen(2.0), good.clone()]), Score::Falling(1.75));
        assert_eq!(judge.score(&[fallen(8.0), fallen(6.5)]), Score::Falling(2.0));
        assert_eq!(judge.score(&[Rollout::invalid("no start pose".into()), good]), Score::Falling(2.0));
    }

    #[test]
    fn where_the_base_falls_others_stand_in_and_where_it_lacks_a_figure_that_is_said() {
        let tuning = Tuning::parse(TEXT, "t.toml", None).unwrap();
        let text = TEXT.replace(", scenarios = [\"push\"]", "");
        let walk = rollout(&tuning, [Some(0.01), None, Some(70.0), Some(30e3)]);
        let push = rollout(&tuning, [Some(0.5), Some(4.0), Some(60.0), Some(40e3)]);
        let wrong = |text: &str, base: [&Rollout; 2]| {
            let tuning = Tuning::parse(text, "t.toml", None).unwrap();
            judge(&tuning, &base.map(Clone::clone)).unwrap_err().to_string()
        };
        let found = wrong(&text, [&walk, &push]);
        assert!(found.starts_with("t.toml:8: objective.1: the case \"walk\" has no recovery_time_s"), "{found}");
        let found = wrong(TEXT, [&walk, &fallen(3.0)]);
        assert!(found.contains("in all of its cases the robot falls"), "{found}");
        let zero = rollout(&tuning, [Some(0.0), None, Some(70.0), Some(30e3)]);
        assert!(wrong(TEXT, [&zero, &push]).contains("com_error_m.mean of the case \"walk\" is 0 as it stands"));
        // 0.5 stands in for the walk's error.
        let judge = judge(&tuning, &[push.clone(), push.clone()]).unwrap();
        let fell =
            super::Judge::new(&tuning.training, &tuning.columns, &tuning.objective, &[], &[fallen(1.0), push.clone()]);
        assert_eq!(fell.unwrap().score(&[push.clone(), push.clone()]), judge.score(&[push.clone(), push]));
    }
}
