//! The file of a study: its keys, and the checks of what is in it.

use std::collections::BTreeSet;
use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::de::{DeString, DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::design::Design;
use crate::factor::{Factor, Level, Levels, Range};
use legwork::error::Error;
use legwork::settings;
use legwork_rbd::content::Content;
use legwork_rbd::file::Lines;
use legwork_rbd::words::quoted;

/// A study as its file has it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    pub(super) name: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) description: String,
    pub(super) scenarios: Spanned<Vec<Spanned<String>>>,
    pub(super) design: Spanned<DesignName>,
    pub(super) samples: Option<Spanned<u64>>,
    pub(super) morris_levels: Option<Spanned<u32>>,
    #[serde(default)]
    pub(super) seed: u64,
    #[serde(default)]
    pub(super) metrics: Vec<Spanned<String>>,
    /// Settings changed in every scenario: path to value.
    #[serde(default)]
    pub(super) set: Table,
    pub(super) factors: Vec<Spanned<FactorEntry>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum DesignName {
    OneAtATime,
    Grid,
    LatinHypercube,
    SobolSequence,
    Morris,
    Saltelli,
}

/// A factor as a file has it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FactorEntry {
    pub(super) name: Option<String>,
    pub(super) path: Option<String>,
    pub(super) paths: Option<Vec<String>>,
    pub(super) list: Option<Vec<Value>>,
    pub(super) linear: Option<Range>,
    pub(super) logarithmic: Option<Range>,
    #[serde(default)]
    pub(super) relative: bool,
    pub(super) marked: Option<f64>,
    pub(super) mark: Option<String>,
}

/// Columns of the table of rollouts.
const RESERVED: [&str; 10] = [
    "rollout",
    "scenario",
    "ending",
    "cause",
    "reason",
    "violations",
    "input_hash",
    "result_hash",
    "survived",
    "fell_at_s",
];

/// Whether no path among the `taken` is `path` or leads into what the other holds; it is taken then.
fn take(path: &str, taken: &mut BTreeSet<String>) -> bool {
    let outer = path.match_indices('.').any(|(dot, _)| taken.contains(&path[..dot]));
    let within = format!("{path}.");
    let inner = taken.range(within.clone()..).next().is_some_and(|next| next.starts_with(&within));
    !outer && !inner && taken.insert(path.to_owned())
}

/// The values of nested tables with their paths: `set.ground.friction = 0.5` means the same as
/// `set = { "ground.friction" = 0.5 }`.
pub(super) fn leaves(table: &Table) -> Vec<(String, Value)> {
    let below = |(key, value): (&String, &Value)| match value {
        Value::Table(inner) => {
            leaves(inner).into_iter().map(|(path, value)| (format!("{key}.{path}"), value)).collect()
        }
        value => vec![(key.clone(), value.clone())],
    };
    table.iter().flat_map(below).collect()
}

/// The paths of [`leaves`] with the place of each key in the text.
fn places(table: &DeTable) -> Vec<(String, usize)> {
    let below = |(key, value): (&Spanned<DeString>, &Spanned<DeValue>)| match value.get_ref() {
        DeValue::Table(inner) => {
            places(inner).into_iter().map(|(path, start)| (format!("{}.{path}", key.get_ref()), start)).collect()
        }
        _ => vec![(key.get_ref().to_string(), key.span().start)],
    };
    table.iter().flat_map(below).collect()
}

/// A text with its file's name, to say where something stands.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) file_name: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    fn line(&self, offset: usize) -> String {
        format!("{}:{}", self.file_name, Lines::of(self.text).line(offset))
    }

    /// What is wrong with the `key` at `offset`.
    pub(super) fn error(&self, offset: usize, key: &str, problem: impl Into<String>) -> Error {
        Error::invalid(format!("{}: {key}", self.line(offset)), problem)
    }

    /// What is wrong with what the table `set` gives the setting at `path`.
    pub(super) fn error_of_set(&self, path: &str, problem: String) -> Error {
        let document = DeTable::parse(self.text).ok();
        let set = document.as_ref().and_then(|document| document.get_ref().get("set")?.get_ref().as_table());
        let place = set.and_then(|set| places(set).into_iter().find(|(given, _)| given == path));
        self.error(place.map_or(0, |(_, start)| start), &format!("set.{path}"), problem)
    }

    /// Reads the text, which should hold what is `wanted`.
    pub(super) fn parse<T: for<'de> Deserialize<'de>>(&self, wanted: Content) -> Result<T, Error> {
        if self.text.trim().is_empty() {
            let problem = "nothing in it; `legwork show interactions` prints a study to start from";
            return Err(Error::invalid(self.file_name, problem));
        }
        toml::from_str(self.text).map_err(|error| {
            if let Some(content) = Content::other_than(wanted, self.file_name, self.text) {
                return Error::invalid(self.file_name, content.instead_of(wanted, self.file_name));
            }
            let place = error.span().map_or_else(|| self.file_name.to_owned(), |span| self.line(span.start));
            Error::invalid(place, error.message())
        })
    }
}

impl StudyFile {
    /// Its name, or that of the file.
    pub(super) fn name(&self, source: &Source) -> Result<String, Error> {
        let Some(name) = &self.name else {
            let stem = Path::new(source.file_name).file_stem().unwrap_or_default();
            return Ok(stem.to_string_lossy().into_owned());
        };
        let text = name.get_ref();
        if text.trim().is_empty() || text.contains(['/', '\\']) || text.contains(char::is_control) {
            let problem = format!("found {}; valid is a text that can be part of a file's name", quoted(text));
            return Err(source.error(name.span().start, "name", problem));
        }
        Ok(text.clone())
    }

    /// The design, with what belongs to it.
    pub(super) fn design(&self, source: &Source) -> Result<Design, Error> {
        let name = *self.design.get_ref();
        let sampled = !matches!(name, DesignName::OneAtATime | DesignName::Grid);
        match &self.samples {
            Some(samples) if !sampled => {
                let problem = "this design takes every level of its factors; leave samples out";
                return Err(source.error(samples.span().start, "samples", problem));
            }
            Some(samples) if !(2..=10_000_000).contains(samples.get_ref()) => {
                let problem = format!("found {}; valid is a whole number from 2 to 10000000", samples.get_ref());
                return Err(source.error(samples.span().start, "samples", problem));
            }
            None if sampled => {
                let problem = "this design needs samples, a whole number from 2 on";
                return Err(source.error(self.design.span().start, "design", problem));
            }
            _ => {}
        }
        if let Some(levels) = self.morris_levels.as_ref().filter(|_| name != DesignName::Morris) {
            let problem = "only the design \"morris\" has these; leave it out";
            return Err(source.error(levels.span().start, "morris_levels", problem));
        }
        let levels = self.morris_levels.as_ref().map_or(4, |levels| *levels.get_ref());
        if levels < 2 || levels % 2 == 1 || levels > 1000 {
            let start = self.morris_levels.as_ref().map_or(0, |levels| levels.span().start);
            let problem = format!("found {levels}; valid is an even number from 2 to 1000");
            return Err(source.error(start, "morris_levels", problem));
        }
        let samples = self.samples.as_ref().map_or(0, |samples| *samples.get_ref());
        Ok(match name {
            DesignName::OneAtATime => Design::OneAtATime,
            DesignName::Grid => Design::Grid,
            DesignName::LatinHypercube => Design::LatinHypercube { samples },
            DesignName::SobolSequence => Design::SobolSequence { samples },
            DesignName::Morris => Design::Morris { trajectories: samples, levels },
            DesignName::Saltelli => Design::Saltelli { samples, second_order: true },
        })
    }

    /// The factors, each checked by itself.
    pub(super) fn factors(&self, source: &Source) -> Result<Vec<Factor>, Error> {
        let sampled = !matches!(self.design.get_ref(), DesignName::OneAtATime | DesignName::Grid);
        let mut factors: Vec<Factor> = Vec::with_capacity(self.factors.len());
        let (mut names, mut taken) = (BTreeSet::new(), BTreeSet::new());
        for (index, entry) in self.factors.iter().enumerate() {
            let wrong = |problem: String| source.error(entry.span().start, &format!("factors.{index}"), problem);
            let factor = entry.get_ref().factor(sampled).map_err(wrong)?;
            if !names.insert(factor.name.clone()) {
                return Err(wrong(format!("another factor is called \"{}\" as well", factor.name)));
            }
            if RESERVED.contains(&factor.name.as_str()) || factor.name.contains('.') && entry.get_ref().name.is_some() {
                let problem = format!(
                    "name: \"{}\" is that of a column of the table, or looks like it; give another",
                    factor.name
                );
                return Err(wrong(problem));
            }
            if let Some(path) = factor.paths.iter().find(|path| !take(path, &mut taken)) {
                return Err(wrong(format!(
                    "{path} is changed twice, here and by another path; each value has one factor"
                )));
            }
            factors.push(factor);
        }
        if factors.is_empty() {
            return Err(Error::invalid(source.file_name, "no [[factors]]; a study varies at least one"));
        }
        Ok(factors)
    }
}

impl FactorEntry {
    /// The factor, or what is wrong with it; designs that take every level need to know how many there are.
    pub(super) fn factor(&self, sampled: bool) -> Result<Factor, String> {
        let paths = match (&self.path, &self.paths) {
            (Some(path), None) => vec![path.clone()],
            (None, Some(paths)) if !paths.is_empty() => paths.clone(),
            _ => return Err("needs either path or paths, such as path = \"ground.friction\"".into()),
        };
        let levels = match (&self.list, self.linear, self.logarithmic) {
            (Some(list), None, None) => Levels::List(list.iter().map(level).collect::<Result<_, _>>()?),
            (None, Some(range), None) => Levels::Linear(checked(range, "linear", sampled)?),
            (None, None, Some(range)) => Levels::Logarithmic(checked(range, "logarithmic", sampled)?),
            _ => return Err("needs exactly one of list, linear and logarithmic".into()),
        };
        if let Levels::List(list) = &levels {
            let mut found = BTreeSet::new();
            for level in list {
                if let Level::Row(row) = level
                    && row.len() != paths.len()
                {
                    let (found, paths) = (row.len(), paths.len());
                    return Err(format!(
                        "list: found {found} numbers ({level}); valid is one for each path, of which there are {paths}"
                    ));
                }
            }
            if let Some(twice) = list.iter().find(|level| !found.insert(format!("{level:?}"))) {
                return Err(format!("list: {twice} is in it twice"));
            }
            if self.relative && list.iter().any(|level| level.number().is_none()) {
                return Err("list: only numbers can multiply; leave relative out".into());
            }
            if list.is_empty() || (sampled && list.len() < 2) {
                return Err(format!(
                    "list: found {} levels; valid are at least {}",
                    list.len(),
                    1 + usize::from(sampled)
                ));
            }
        }
        if let Levels::Logarithmic(range) = &levels
            && range.from <= 0.0
        {
            return Err(format!("logarithmic: from is {}; valid is a number above 0", range.from));
        }
        let mark = self.mark.clone().unwrap_or_else(|| "thesis".into());
        let name = self.name.clone().unwrap_or_else(|| paths[0].clone());
        Ok(Factor { name, paths, relative: self.relative, levels, marked: self.marked.map(|marked| (marked, mark)) })
    }
}

fn level(value: &Value) -> Result<Level, String> {
    match value {
        Value::Float(number) if number.is_finite() => Ok(Level::Number(*number)),
        Value::Integer(number) => Ok(Level::Number(*number as f64)),
        Value::Boolean(flag) => Ok(Level::Flag(*flag)),
        Value::String(text) => Ok(Level::Text(text.clone())),
        Value::Array(row) if row.len() > 1 => {
            let number = |value: &Value| level(value)?.number().ok_or_else(|| wrong(value));
            row.iter().map(number).collect::<Result<_, _>>().map(Level::Row)
        }
        other => Err(wrong(other)),
    }
}

fn wrong(value: &Value) -> String {
    let found = settings::in_words(value);
    format!(
        "list: found {found}; valid are numbers, texts, true and false, and lists of a number for each of several paths"
    )
}

fn checked(range: Range, key: &str, sampled: bool) -> Result<Range, String> {
    let Range { from, to, count } = range;
    if !from.is_finite() || !to.is_finite() {
        return Err(format!("{key}: from {from} to {to}; valid are finite numbers"));
    }
    if from >= to {
        return Err(format!(
            "{key}: from {from} to {to} is {}; valid is from < to",
            if from > to { "crossed" } else { "empty" }
        ));
    }
    match count {
        None if !sampled => Err(format!("{key}: count is missing; this design takes every level of a factor")),
        Some(count) if !(2..=100_000).contains(&count) => {
            Err(format!("{key}: count is {count}; valid is a whole number from 2 to 100000"))
        }
        _ => Ok(range),
    }
}
