//! A figure over the levels of a sweep, and what is asked of it in the terms of [`super::terms`].

use std::fmt::Display;

use super::statistics::{spearman, spread, straightness};
use super::sweep::{Sweep, Tried, figure};
use super::terms::{Check, DIMINISHED, FEWEST, POOR, STRAIGHT, TREND, VISIBLE};
use super::words::{digits, with_unit};
use legwork::metrics::Figure;

/// A figure over some levels of a sweep.
#[derive(Clone, Debug)]
pub(crate) struct Curve<'a> {
    sweep: &'a Sweep,
    figure: &'static Figure,
    tried: Vec<&'a Tried>,
}

impl<'a> Curve<'a> {
    /// The figure over the levels from `low` to `high`.
    pub(crate) fn new(sweep: &'a Sweep, figure: &'static Figure, low: f64, high: f64) -> Self {
        Self { sweep, figure, tried: sweep.between(low, high).collect() }
    }

    /// Levels and values where the robot stands.
    fn points(&self) -> (Vec<f64>, Vec<f64>) {
        self.tried.iter().filter_map(|tried| Some((tried.level, tried.figure(&self.figure.name)?))).unzip()
    }

    fn own(&self) -> Option<f64> {
        self.sweep.at_marked().figure(&self.figure.name)
    }

    /// It and where it goes, in words: `walk: mean feet error 0.0026 m at 200 Nm, 0.0018 m at 500 Nm`.
    fn words(&self) -> String {
        let (levels, values) = self.points();
        let at = |i: usize| {
            format!("{} at {}", with_unit(values[i], self.figure.unit), with_unit(levels[i], self.sweep.unit))
        };
        let path = match levels.len() {
            0 => "at no level".to_owned(),
            1 => at(0),
            last => format!("{}, {}", at(0), at(last - 1)),
        };
        format!("{}: {} {path}", self.sweep.case.experiment.name(), self.figure.label)
    }

    /// What `judge` says of levels and values, where the robot stands at enough levels.
    fn judged(&self, judge: impl Fn(&[f64], &[f64]) -> (bool, String)) -> Check {
        let (levels, values) = self.points();
        let (holds, finding) = if levels.len() < FEWEST {
            (false, format!("stands at {} of {} levels only", levels.len(), self.tried.len()))
        } else {
            judge(&levels, &values)
        };
        self.check(holds, finding)
    }

    fn check(&self, holds: bool, finding: impl Display) -> Check {
        Check::new(holds, format!("{}; {finding}", self.words()))
    }

    fn trend(&self, sign: f64) -> Check {
        self.judged(|levels, values| {
            let Some(rank) = spearman(levels, values) else { return (false, "the same at all levels".to_owned()) };
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let change = spread(values).unwrap_or(0.0) / mean;
            let finding = format!("rank correlation {rank:.2}, change {:.1} %", 100.0 * change);
            (sign * rank >= TREND && change >= VISIBLE, finding)
        })
    }

    /// It rises with the parameter.
    pub(crate) fn rises(&self) -> Check {
        self.trend(1.0)
    }

    /// It sinks with the parameter.
    pub(crate) fn sinks(&self) -> Check {
        self.trend(-1.0)
    }

    /// It is a straight line.
    pub(crate) fn is_straight(&self) -> Check {
        self.judged(|levels, values| {
            let share = straightness(levels, values).unwrap_or(0.0);
            (share >= STRAIGHT, format!("a line explains {:.0} %", 100.0 * share))
        })
    }

    /// It sinks less in the upper half of the levels than in the lower.
    pub(crate) fn diminishes(&self) -> Check {
        self.judged(|levels, values| {
            let (half, last) = (levels.len() / 2, levels.len() - 1);
            let (lower, upper) = (values[0] - values[half], values[half] - values[last]);
            let middle = with_unit(levels[half], self.sweep.unit);
            let finding = format!("sinks by {} up to {middle} and by {} above", digits(lower), digits(upper));
            (lower > 0.0 && upper < DIMINISHED * lower, finding)
        })
    }

    /// It changes by no more than `share` of the baseline's own, and the robot stands at all levels.
    pub(crate) fn changes_at_most(&self, share: f64) -> Check {
        let (_, values) = self.points();
        let (fallen, of) = (self.tried.len() - values.len(), self.tried.len());
        let Some((own, spread)) = self.own().zip(spread(&values)) else {
            return self.check(false, "the baseline itself falls");
        };
        let falls = if fallen > 0 { format!("; falls at {fallen} of {of} levels") } else { String::new() };
        let finding = format!("changes by {:.1} % of the baseline's{falls}", 100.0 * spread / own);
        self.check(fallen == 0 && spread <= share * own, finding)
    }

    /// It is poor at every level; of a fall, which alone says nothing of its mechanism, the figure up to it counts.
    pub(crate) fn is_poor(&self) -> Check {
        let Some(own) = self.own() else { return self.check(false, "the baseline itself falls") };
        let value =
            |tried: &&&Tried| figure(&tried.rollout, &self.figure.name).is_some_and(|value| value >= POOR * own);
        let (poor, of) = (self.tried.iter().filter(value).count(), self.tried.len());
        let fallen = self.tried.iter().filter(|tried| !tried.rollout.survived()).count();
        self.check(of > 0 && poor == of, format!("poor at {poor} of {of} levels, a fall at {fallen}"))
    }

    /// It changes from the first to the last level at which the robot stands by more than `share` of the first, upwards
    /// for a positive sign.
    pub(crate) fn moves(&self, sign: f64, share: f64) -> Check {
        let (_, values) = self.points();
        let [first, .., last] = values.as_slice() else {
            return self.check(false, "too few levels at which it stands");
        };
        let change = last / first - 1.0;
        self.check(sign * change > share, format!("{:+.1} %", 100.0 * change))
    }
}

/// The robot falls at every level of the sweep from `low` to `high`, and does not with the baseline's own.
pub(crate) fn falls_at_all(sweep: &Sweep, low: f64, high: f64) -> Check {
    let (stands, text) = endings(sweep, low, high);
    let tried = sweep.between(low, high).next().is_some();
    if !sweep.at_marked().rollout.survived() {
        return Check::new(false, format!("{text}; the baseline itself falls"));
    }
    Check::new(tried && stands.is_empty(), text)
}

/// The robot stands at every level of the sweep from `low` to `high`.
pub(crate) fn stands_at_all(sweep: &Sweep, low: f64, high: f64) -> Check {
    let (stands, text) = endings(sweep, low, high);
    Check::new(stands.len() == sweep.between(low, high).count(), text)
}

fn endings(sweep: &Sweep, low: f64, high: f64) -> (Vec<f64>, String) {
    let (mut stands, mut falls) = (Vec::new(), Vec::new());
    for tried in sweep.between(low, high) {
        if tried.rollout.survived() { &mut stands } else { &mut falls }.push(tried.level);
    }
    let list = |levels: &[f64]| match levels {
        [] => "none".to_owned(),
        [one] => with_unit(*one, sweep.unit),
        [first, .., last] => format!("{} ({} to {})", levels.len(), digits(*first), with_unit(*last, sweep.unit)),
    };
    let text = format!(
        "{}: from {} to {} ({} levels) it stands at {}, falls at {}",
        sweep.case.experiment.name(),
        digits(stands.iter().chain(&falls).copied().fold(f64::INFINITY, f64::min)),
        with_unit(stands.iter().chain(&falls).copied().fold(0.0, f64::max), sweep.unit),
        stands.len() + falls.len(),
        list(&stands),
        list(&falls)
    );
    (stands, text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Case, Experiment, Gains, Reading};
    use crate::sweep::{COM, definition};
    use crate::terms::LITTLE;
    use legwork_study::{Ending, Rollout};

    /// A sweep of the mean CoM error over levels 1, 2, 3, ...; none is a fall. The baseline is level 1.
    fn sweep(values: &[Option<f64>]) -> Sweep {
        let tried = |(index, value): (usize, &Option<f64>)| {
            let mut rollout = Rollout::invalid(String::new());
            rollout.ending = if value.is_some() { Ending::Completed } else { Ending::Fell };
            rollout.figures = vec![*value];
            Tried { level: index as f64 + 1.0, rollout, momentum_rate_limited_fraction: 0.0 }
        };
        Sweep {
            study: String::new(),
            symbol: "",
            figure: "",
            scenario: String::new(),
            case: Case::new(Reading::Displacement, Experiment::Walk, Gains::Baseline),
            factor: String::new(),
            path: String::new(),
            unit: "Nm",
            is_logarithmic: false,
            marked: 1.0,
            levels: values.iter().enumerate().map(tried).collect(),
        }
    }

    fn check(values: &[Option<f64>], of: impl Fn(&Curve) -> Check) -> bool {
        of(&Curve::new(&sweep(values), definition(COM), 0.0, f64::INFINITY)).holds
    }

    fn all(values: &[f64]) -> Vec<Option<f64>> {
        values.iter().copied().map(Some).collect()
    }

    #[test]
    fn trends_need_order_size_and_enough_levels() {
        assert!(check(&all(&[4.0, 3.0, 2.0, 1.0]), |c| c.sinks()) && check(&all(&[1.0, 2.0, 3.0, 4.0]), |c| c.rises()));
        assert!(!check(&all(&[4.0, 3.0, 2.0, 1.0]), |c| c.rises()));
        assert!(!check(&all(&[1.0, 3.0, 1.0, 3.0]), |c| c.rises()), "no order");
        assert!(!check(&all(&[1.0, 1.001, 1.002, 1.003]), |c| c.rises()), "too small to be seen");
        assert!(!check(&[Some(1.0), Some(2.0), None, Some(3.0)], |c| c.rises()), "three levels are too few");
        assert!(check(&all(&[1.0, 2.0, 3.0, 4.0]), |c| c.is_straight()));
        assert!(!check(&all(&[0.1, 0.1, 0.1, 9.0]), |c| c.is_straight()));
    }

    #[test]
    fn returns_diminish_where_the_upper_half_gains_less_than_half_of_the_lower() {
        assert!(check(&all(&[8.0, 4.0, 2.0, 1.0, 0.9]), |c| c.diminishes()));
        assert!(!check(&all(&[4.0, 3.0, 2.0, 1.0]), |c| c.diminishes()));
        assert!(!check(&all(&[1.0, 2.0, 3.0, 3.1]), |c| c.diminishes()), "it grows");
    }

    #[test]
    fn a_change_is_a_share_of_the_baselines_own_and_a_fall_is_one() {
        let little = |values: &[Option<f64>]| check(values, |curve| curve.changes_at_most(LITTLE));
        assert!(little(&all(&[1.0, 1.1, 0.95])) && !little(&all(&[1.0, 1.1, 0.85])));
        assert!(!little(&[Some(1.0), Some(1.0), None]), "it falls");
        assert!(!little(&[None, Some(1.0), Some(1.0)]), "the baseline falls");
        assert!(check(&all(&[1.0, 1.5, 0.7]), |curve| curve.moves(-1.0, LITTLE)));
        assert!(!check(&all(&[1.0, 0.5, 0.9]), |curve| curve.moves(-1.0, LITTLE)), "only the ends count");
    }

    #[test]
    fn poor_is_twice_the_baselines_at_every_level_and_up_to_a_fall() {
        let poor =
            |values: &[Option<f64>]| Curve::new(&sweep(values), definition(COM), 2.0, f64::INFINITY).is_poor().holds;
        assert!(poor(&[Some(1.0), Some(2.0)]) && !poor(&[Some(1.0), Some(1.9)]));
        assert!(!poor(&[None, Some(9.0)]) && !poor(&[Some(1.0)]));
        assert!(!poor(&[Some(1.0), Some(2.0), None]), "a fall whose figure is not known");
        let mut fallen = sweep(&[Some(1.0), Some(2.0)]);
        fallen.levels[1].rollout.ending = Ending::Fell;
        assert!(Curve::new(&fallen, definition(COM), 2.0, 9.0).is_poor().holds, "poor up to the fall");
    }

    #[test]
    fn endings_are_those_of_the_levels_in_the_range() {
        let some = sweep(&[Some(1.0), Some(1.0), None]);
        assert!(falls_at_all(&some, 2.5, 9.0).holds && !falls_at_all(&some, 2.0, 9.0).holds);
        assert!(!falls_at_all(&some, 4.0, 9.0).holds, "no level is in the range");
        assert!(!falls_at_all(&sweep(&[None, None]), 2.0, 9.0).holds, "the baseline falls as well");
        assert!(stands_at_all(&some, 0.0, 2.0).holds && !stands_at_all(&some, 0.0, 9.0).holds);
        let finding = stands_at_all(&some, 0.0, 9.0).finding;
        assert_eq!(finding, "walk: from 1 to 3 Nm (3 levels) it stands at 2 (1 to 2 Nm), falls at 3 Nm");
    }
}
