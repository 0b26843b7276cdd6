//! What the thesis left open (7.1.2, 7.2, 7.4, 6.3.7), answered by measurements. The sentences of an answer are chosen
//! by the figures.

mod damping;
mod forms;
mod hard_feet;
mod operating_weights;
mod replanning;

use serde::Serialize;

use super::case::Case;
use super::evidence::Evidence;
use super::replay::Replay;
use super::sweep::figure;
use super::trial::TrialResult;
pub use forms::{FormTimes, time_forms};

/// A question with its answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Question {
    /// Its short name.
    pub id: &'static str,
    /// The thesis's section that leaves it open.
    pub section: &'static str,
    /// The question.
    pub asks: &'static str,
    /// What was run.
    pub method: String,
    /// What came of it.
    pub tables: Vec<Table>,
    /// The answer.
    pub answer: String,
    /// Whether measured times are in it, which differ from run to run.
    pub has_times: bool,
}

/// A table of figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// What it is of.
    pub title: &'static str,
    /// Its columns with their units.
    pub columns: Vec<(&'static str, &'static str)>,
    /// Its rows, with an entry for each column.
    pub rows: Vec<Vec<Entry>>,
}

/// An entry of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Entry {
    /// A number; none where there is none.
    Number(Option<f64>),
    /// A text.
    Text(String),
}

impl From<f64> for Entry {
    fn from(number: f64) -> Self {
        Self::Number(Some(number))
    }
}

impl From<Option<f64>> for Entry {
    fn from(number: Option<f64>) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Entry {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Entry {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// All questions.
pub fn questions(evidence: &Evidence, times: &[FormTimes], replays: &[Replay]) -> Vec<Question> {
    vec![
        forms::question(evidence, times, replays),
        hard_feet::question(evidence),
        operating_weights::question(evidence, replays),
        replanning::question(evidence),
        damping::question(evidence),
    ]
}

/// The cases in which both forms are timed.
pub(super) fn timed_cases() -> impl Iterator<Item = Case> {
    forms::cases()
}

/// The replays that the questions need: a case, and the settings that differ.
pub(super) fn replayed() -> impl Iterator<Item = (Case, Vec<String>)> {
    let forms = forms::cases().map(|case| (case, vec![forms::SLACK.to_owned()]));
    let with = |case| {
        let sets = [Vec::new()].into_iter().chain(operating_weights::raised_weights().map(|set| vec![set]));
        sets.map(move |sets| (case, sets))
    };
    forms.chain(operating_weights::cases().flat_map(with))
}

/// How a trial ended: `stands` or `falls at 1.23 s`.
fn ending(result: &TrialResult) -> String {
    match result.rollout.fell_at_s {
        Some(time) => format!("falls at {time:.2} s"),
        None if result.stands() => "stands".to_owned(),
        None => result.rollout.ending.name().to_owned(),
    }
}

/// A figure of a trial that stands.
fn standing(result: &TrialResult, name: &str) -> Option<f64> {
    figure(&result.rollout, name).filter(|_| result.stands())
}

/// The replay of a scenario with these settings.
fn replay_of<'a>(replays: &'a [Replay], scenario: &str, sets: &[String]) -> Option<&'a Replay> {
    replays.iter().find(|replay| replay.scenario == scenario && replay.sets == sets)
}
