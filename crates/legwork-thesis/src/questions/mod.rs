//! What the thesis left open (7.1.2, 7.2, 7.4, 6.3.7), answered by measurements: `questions.toml` with the figures filled in.

mod forms;
mod hard_feet;
mod operating_weights;
mod variants;

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::evidence::Evidence;
use super::replay::Replay;
use super::trial::TrialResult;
use super::words::filled;
pub(super) use forms::{FormTimes, time_forms};

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
    pub rows: Rows,
}

type Rows = Vec<Vec<Entry>>;

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

/// A question as the file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    section: String,
    asks: String,
    method: String,
    #[serde(default)]
    has_times: bool,
    tables: Vec<Columns>,
    says: BTreeMap<String, String>,
}

/// A table as the file has it; a column is `name` or `name [unit]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Columns {
    title: String,
    columns: Vec<String>,
}

static QUESTIONS: LazyLock<BTreeMap<String, Asked>> =
    LazyLock::new(|| toml::from_str(include_str!("questions.toml")).expect("the file of questions is ours"));

/// A sentence of a question's answer.
fn says(id: &str, key: &str, values: &[(&str, &dyn Display)]) -> String {
    filled(&QUESTIONS[id].says[key], values)
}

/// The rows of a question's tables and the sentences of its answer.
type Found = (Vec<Rows>, Vec<String>);

fn question(id: &'static str, (tables, sentences): Found) -> Question {
    let asked = &QUESTIONS[id];
    let column = |text: &'static String| {
        text.strip_suffix(']').and_then(|text| text.rsplit_once(" [")).unwrap_or((text.as_str(), ""))
    };
    let table = |(stated, rows): (&'static Columns, Rows)| Table {
        title: &stated.title,
        columns: stated.columns.iter().map(column).collect(),
        rows,
    };
    Question {
        id,
        section: &asked.section,
        asks: &asked.asks,
        method: filled(&asked.method, &[("turns", &forms::TURNS)]),
        tables: asked.tables.iter().zip(tables).map(table).collect(),
        answer: sentences.join(" "),
        has_times: asked.has_times,
    }
}

/// All questions.
pub(super) fn questions(evidence: &Evidence, times: &[FormTimes], replays: &[Replay]) -> Vec<Question> {
    vec![
        question("slack", forms::found(evidence, times, replays)),
        question("hard-feet", hard_feet::found(evidence)),
        question("operating-weights", operating_weights::found(evidence, replays)),
        question("replanning", variants::replanning(evidence)),
        question("damping", variants::damping(evidence)),
    ]
}

/// The cases in which both forms are timed.
pub(super) fn timed_cases() -> impl Iterator<Item = Case> {
    forms::cases()
}

/// The replays that the questions need: a case, and the settings that differ.
pub(super) fn replayed() -> impl Iterator<Item = (Case, Vec<String>)> {
    let forms = forms::cases().map(|case| (case, vec![forms::SLACK.to_owned()]));
    let with = |case| operating_weights::weights().map(move |sets| (case, sets));
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

/// The replay of a scenario with these settings.
fn replay_of<'a>(replays: &'a [Replay], scenario: &str, sets: &[String]) -> Option<&'a Replay> {
    replays.iter().find(|replay| replay.scenario == scenario && replay.sets == sets)
}

/// The least and the largest value.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, 0.0), |(least, most), value| (least.min(value), most.max(value)))
}
