//! Slack variables against tracking in the cost: the same optimum, and at what time? (7.4)

use serde::Serialize;

use super::{Entry, Found, range, replay_of, says};
use crate::case::{Case, Gains};
use crate::evidence::Evidence;
use crate::replay::Replay;
use crate::trial::Trial;
use crate::words::digits;
use legwork::episode::Timing;
use legwork::error::Error;
use legwork::momentum::Layout;
use legwork::scenario::QpForm;

/// The setting of the slack form.
pub(super) const SLACK: &str = "controller.form=slack";
/// Largest difference of a torque up to which two optima are one [Nm].
const SAME_NM: f64 = 1e-4;
/// How much longer one form must take to be called slower.
const SLOWER: f64 = 1.05;
/// How often each form is run, turn by turn.
pub(super) const TURNS: usize = 2;

/// Control tick durations of both forms in a scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FormTimes {
    /// The scenario.
    pub scenario: &'static str,
    /// Median and 99 % quantile of the direct form [µs].
    pub direct_us: [f64; 2],
    /// The same of the slack form [µs].
    pub slack_us: [f64; 2],
}

/// The cases that are timed: the final design.
pub(super) fn cases() -> impl Iterator<Item = Case> {
    Case::all().filter(|case| case.gains == Gains::Final)
}

/// Runs both forms turn by turn, so that what else the machine does falls on both, and times their control ticks; none
/// where `stop` says so before.
///
/// # Errors
/// None, unless the scenario is not valid.
pub(crate) fn time_forms(case: Case, stop: impl Fn() -> bool) -> Result<Option<FormTimes>, Error> {
    let mut ticks = [Vec::new(), Vec::new()];
    for _ in 0..TURNS {
        for (form, ticks) in ticks.iter_mut().enumerate() {
            let sets = if form == 1 { vec![SLACK.to_owned()] } else { Vec::new() };
            let run = Trial::of_case(case, sets).run(&stop)?;
            if stop() {
                return Ok(None);
            }
            ticks.extend(run.timing.ticks_s);
        }
    }
    let [direct_us, slack_us] = ticks.map(|ticks_s| {
        let timing = Timing { ticks_s, wall_s: 0.0 };
        [0.5, 0.99].map(|share| timing.tick_quantile_us(share))
    });
    Ok(Some(FormTimes { scenario: case.scenario(), direct_us, slack_us }))
}

pub(super) fn found(evidence: &Evidence, times: &[FormTimes], replays: &[Replay]) -> Found {
    let mut rows = Vec::new();
    let (mut ratios, mut differences) = (Vec::new(), Vec::new());
    for (case, times) in cases().zip(times) {
        let replay = replay_of(replays, case.scenario(), &[SLACK.to_owned()]);
        let difference = replay.map(|replay| replay.torque_difference_nm);
        let [direct, slack] = [times.direct_us, times.slack_us];
        ratios.push(slack[0] / direct[0]);
        differences.extend(difference);
        let numbers =
            [difference, Some(direct[0]), Some(slack[0]), ratios.last().copied(), Some(direct[1]), Some(slack[1])];
        rows.push([Entry::from(case.scenario())].into_iter().chain(numbers.map(Entry::from)).collect());
    }
    let run = evidence.run(cases().next().expect("there are cases"));
    let size = |(name, form): (&str, QpForm)| {
        let layout = Layout::new(form, &run.scenario.controller, &run.model);
        vec![name.into(), (layout.variables() as f64).into(), (layout.rows() as f64).into()]
    };
    let sizes = [("direct", QpForm::Direct), ("slack", QpForm::Slack)].map(size);
    (vec![rows, sizes.into()], answer(&ratios, &differences))
}

fn answer(ratios: &[f64], differences: &[f64]) -> Vec<String> {
    let difference = range(differences.iter().copied()).1;
    let optimum = if difference <= SAME_NM { "same" } else { "differ" };
    let (low, high) = range(ratios.iter().copied());
    let time = match (low >= SLOWER, high <= 1.0 / SLOWER) {
        (true, _) => "cost",
        (false, true) => "save",
        (false, false) => "neither",
    };
    let (difference, low, high) = (digits(difference), digits(low), digits(high));
    [optimum, time].map(|key| says("slack", key, &[("difference", &difference), ("low", &low), ("high", &high)])).into()
}

#[cfg(test)]
mod tests {
    use super::answer;

    #[test]
    fn the_answer_follows_the_figures() {
        let answer = |ratios: &[f64], differences: &[f64]| answer(ratios, differences).join(" ");
        let slow = answer(&[2.0, 3.0], &[1e-9]);
        assert!(
            slow.starts_with("The optimum is the same")
                && slow.contains("cost time: the median control tick takes 2 to 3 times")
        );
        let fast = answer(&[0.5, 0.6], &[1.0]);
        assert!(fast.starts_with("The optima differ") && fast.contains("save time"));
        assert!(answer(&[0.9, 1.2], &[0.0]).contains("about the same"));
    }
}
