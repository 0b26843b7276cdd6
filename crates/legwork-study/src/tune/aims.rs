//! What a tuning is after: the objective's terms, and the constraints.

use super::Case;
use super::file::{ConstraintEntry, TermEntry, TuningFile, check_positive};
use crate::file::Source;
use crate::rollout::Column;
use legwork::error::Error;
use legwork_rbd::words::{list, quoted};

/// A figure of some of the training cases.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The figure, in [`super::Tuning::columns`].
    pub column: usize,
    /// How much it counts.
    pub weight: f64,
    /// The cases, in [`super::Tuning::training`].
    pub cases: Vec<usize>,
    /// Where it stands, as `file:line: key`.
    pub(super) place: String,
}

/// What a figure may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// This, in its unit.
    AtMost(f64),
    /// This times that of the scenario as it stands, case by case.
    AtMostTimesBase(f64),
    /// At least this, in its unit.
    AtLeast(f64),
}

/// A figure that must keep a bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// The figure.
    pub term: Term,
    /// What it may be.
    pub bound: Bound,
}

/// Reads objective and constraints.
pub(super) fn read(
    file: &TuningFile,
    source: &Source,
    columns: &[Column],
    training: &[Case],
) -> Result<(Vec<Term>, Vec<Constraint>), Error> {
    let mut objective = Vec::with_capacity(file.objective.len());
    for (index, entry) in file.objective.iter().enumerate() {
        let wrong = |problem| source.error(entry.span().start, &format!("objective.{index}"), problem);
        objective.extend(terms(entry.get_ref(), wrong, columns, training)?);
    }
    if objective.is_empty() {
        let problem = "no [[objective]]; give at least one metric to lower, such as com_error_m.mean";
        return Err(Error::invalid(source.file_name, problem));
    }
    let mut constraints = Vec::with_capacity(file.constraints.len());
    for (index, entry) in file.constraints.iter().enumerate() {
        let wrong = |problem| source.error(entry.span().start, &format!("constraints.{index}"), problem);
        constraints.extend(constraint(entry.get_ref(), wrong, columns, training)?);
    }
    Ok((objective, constraints))
}

fn constraint(
    entry: &ConstraintEntry,
    wrong: impl Fn(String) -> Error,
    columns: &[Column],
    training: &[Case],
) -> Result<Vec<Constraint>, Error> {
    let (key, bound) = match (entry.at_most, entry.at_most_times_base, entry.at_least) {
        (Some(most), None, None) => ("at_most", Bound::AtMost(most)),
        (None, Some(times), None) => ("at_most_times_base", Bound::AtMostTimesBase(times)),
        (None, None, Some(least)) => ("at_least", Bound::AtLeast(least)),
        _ => {
            let problem = "needs one of at_most (in the metric's unit), at_most_times_base, at_least";
            return Err(wrong(problem.into()));
        }
    };
    let (Bound::AtMost(number) | Bound::AtMostTimesBase(number) | Bound::AtLeast(number)) = bound;
    check_positive(key, number).map_err(|error| wrong(error.to_string()))?;
    let ConstraintEntry { metric, cases, scenarios, .. } = entry;
    let entry = TermEntry { metric: metric.clone(), weight: None, cases: cases.clone(), scenarios: scenarios.clone() };
    let terms = terms(&entry, wrong, columns, training)?;
    Ok(terms.into_iter().map(|term| Constraint { term, bound }).collect())
}

/// The term, or where its metric has a `*` one of each figure that is meant; these share the weight.
fn terms(
    entry: &TermEntry,
    wrong: impl Fn(String) -> Error,
    columns: &[Column],
    training: &[Case],
) -> Result<Vec<Term>, Error> {
    let metric = &entry.metric;
    let meant: Vec<usize> = (0..columns.len()).filter(|&column| matches(metric, &columns[column].name)).collect();
    if meant.is_empty() {
        let names: Vec<_> = columns.iter().map(|column| column.name.as_str()).collect();
        let problem = format!("metric: found {}; valid are {}", quoted(metric), list(names));
        return Err(wrong(problem));
    }
    let weight = entry.weight.unwrap_or(1.0);
    check_positive("weight", weight).map_err(|error| wrong(error.to_string()))?;
    let cases = match (&entry.cases, &entry.scenarios) {
        (None, None) => (0..training.len()).collect(),
        (Some(names), None) => chosen("cases", names, training, |case| &case.name).map_err(&wrong)?,
        (None, Some(names)) => chosen("scenarios", names, training, Case::scenario).map_err(&wrong)?,
        (Some(_), Some(_)) => return Err(wrong("give cases or scenarios, or neither for all cases".into())),
    };
    let Error::Invalid { place, .. } = wrong(String::new()) else { unreachable!("it is an error of content") };
    let weight = weight / meant.len() as f64;
    Ok(meant.into_iter().map(|column| Term { column, weight, cases: cases.clone(), place: place.clone() }).collect())
}

/// Whether `pattern`, in which a `*` stands for any text, means the figure `name`.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, end)) => name.len() >= begin.len() + end.len() && name.starts_with(begin) && name.ends_with(end),
        None => pattern == name,
    }
}

/// The cases that are called by one of the `names`.
fn chosen(
    key: &str,
    names: &[String],
    training: &[Case],
    name_of: impl Fn(&Case) -> &str,
) -> Result<Vec<usize>, String> {
    let unknown = names.iter().find(|name| !training.iter().any(|case| name_of(case) == name.as_str()));
    if unknown.is_some() || names.is_empty() {
        let mut known: Vec<_> = training.iter().map(&name_of).collect();
        known.dedup();
        let found = unknown.map_or("none".to_owned(), |name| quoted(name));
        return Err(format!("{key}: found {found}; valid are {}", list(known)));
    }
    let is_chosen = |&case: &usize| names.iter().any(|name| name == name_of(&training[case]));
    Ok((0..training.len()).filter(is_chosen).collect())
}
