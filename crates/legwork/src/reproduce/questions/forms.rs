//! Slack variables against tracking in the cost: the same optimum, and at what time? (7.4)

use serde::Serialize;

use super::{Entry, Question, Table, replay_of};
use crate::episode::Timing;
use crate::error::Error;
use crate::qp::Layout;
use crate::reproduce::case::{Case, Gains};
use crate::reproduce::evidence::Evidence;
use crate::reproduce::replay::Replay;
use crate::reproduce::trial::Trial;
use crate::reproduce::words::digits;
use crate::scenario::QpForm;

/// The setting of the slack form.
pub(super) const SLACK: &str = "controller.form=slack";
/// Largest difference of a torque up to which two optima are one [Nm].
const SAME_NM: f64 = 1e-4;
/// How much longer one form must take to be called slower.
const SLOWER: f64 = 1.05;
/// How often each form is run, turn by turn.
const TURNS: usize = 2;

/// Control tick durations of both forms in a scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormTimes {
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
pub fn time_forms(case: Case, stop: impl Fn() -> bool) -> Result<Option<FormTimes>, Error> {
    let mut ticks = [Vec::new(), Vec::new()];
    for _ in 0..TURNS {
        for (form, ticks) in ticks.iter_mut().enumerate() {
            let sets = if form == 1 { vec![SLACK.to_owned()] } else { Vec::new() };
            let run = Trial { scenario: case.scenario(), sets }.run(&stop)?;
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

pub(super) fn question(evidence: &Evidence, times: &[FormTimes], replays: &[Replay]) -> Question {
    let mut rows = Vec::new();
    let (mut ratios, mut differences) = (Vec::new(), Vec::new());
    for (case, times) in cases().zip(times) {
        let replay = replay_of(replays, case.scenario(), &[SLACK.to_owned()]);
        let difference = replay.map(|replay| replay.torque_difference_nm);
        let ratio = times.slack_us[0] / times.direct_us[0];
        ratios.push(ratio);
        differences.extend(difference);
        let [direct, slack] = [times.direct_us, times.slack_us];
        let mut row: Vec<Entry> = vec![case.scenario().into(), difference.into()];
        row.extend([direct[0], slack[0], ratio, direct[1], slack[1]].map(Entry::from));
        rows.push(row);
    }
    let columns = vec![
        ("scenario", ""),
        ("largest difference of a torque", "Nm"),
        ("direct, median", "µs"),
        ("slack, median", "µs"),
        ("slack over direct", ""),
        ("direct, 99 %", "µs"),
        ("slack, 99 %", "µs"),
    ];
    let run = evidence.run(cases().next().expect("there are cases"));
    let size = |form| {
        let layout = Layout::new(form, &run.scenario.controller, &run.model);
        vec![Entry::from(layout.variables() as f64), (layout.rows() as f64).into()]
    };
    let sizes = [("direct", QpForm::Direct), ("slack", QpForm::Slack)];
    let sizes = sizes.map(|(name, form)| [vec![Entry::from(name)], size(form)].concat());
    Question {
        id: "slack",
        section: "7.4",
        asks: "Do slack variables cost computation time against tracking written into the cost, and is the optimum \
               the same?",
        method: format!(
            "Each run of the final design, {TURNS} times in both forms turn by turn; times are of a whole control \
             tick (dynamics, references, program). The slack form also solves the programs of the direct form's run, \
             state by state."
        ),
        tables: vec![
            Table { title: "Time of a control tick", columns, rows },
            Table {
                title: "Size of the program",
                columns: vec![("form", ""), ("variables", ""), ("rows", "")],
                rows: sizes.to_vec(),
            },
        ],
        answer: answer(&ratios, &differences),
        has_times: true,
    }
}

fn answer(ratios: &[f64], differences: &[f64]) -> String {
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let difference = most(differences);
    let optimum = if difference <= SAME_NM { "The optimum is the same" } else { "The optima differ" };
    let (low, high) = (least(ratios), most(ratios));
    let range = format!("{} to {} times", digits(low), digits(high));
    let time = if low >= SLOWER {
        format!(
            "Slack variables cost time: the median control tick takes {range} as long as with tracking in the cost."
        )
    } else if high <= 1.0 / SLOWER {
        format!(
            "Slack variables save time: the median control tick takes {range} as long as with tracking in the cost."
        )
    } else {
        format!("The time is about the same: with slack variables the median control tick takes {range} as long.")
    };
    format!("{optimum}: on the same states no torque differs by more than {} Nm. {time}", digits(difference))
}

#[cfg(test)]
mod tests {
    use super::answer;

    #[test]
    fn the_answer_follows_the_figures() {
        let slow = answer(&[2.0, 3.0], &[1e-9]);
        assert!(
            slow.starts_with("The optimum is the same") && slow.contains("cost time") && slow.contains("2 to 3 times")
        );
        let fast = answer(&[0.5, 0.6], &[1.0]);
        assert!(fast.starts_with("The optima differ") && fast.contains("save time"));
        assert!(answer(&[0.9, 1.2], &[0.0]).contains("about the same"));
    }
}
