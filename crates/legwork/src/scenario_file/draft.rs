//! A scenario while it is put together: a tree of values, and where each was set.

use std::path::Path;

use legwork_rbd::file::Lines;
use legwork_rbd::words::list;
use toml::Value;
use toml::de::DeValue;

use crate::error::Error;
use crate::library::model_text;
use crate::scenario::Scenario;
use crate::settings::{self, REQUIRED_OF_A_PUSH, Setting, Valid, at};

/// The settings that name files.
pub(super) const PATHS: [&str; 2] = ["model", "reference.com.file"];

/// Where values come from.
pub(super) enum Source<'a> {
    File { name: &'a str, lines: Lines },
    CommandLine,
}

impl<'a> Source<'a> {
    /// A file of this text.
    pub(super) fn file(name: &'a str, text: &str) -> Self {
        Self::File { name, lines: Lines::of(text) }
    }

    /// `file:line` of a byte.
    pub(super) fn line(&self, offset: usize) -> String {
        match self {
            Self::File { name, lines } => format!("{name}:{}", lines.line(offset)),
            Self::CommandLine => "--set".to_owned(),
        }
    }

    /// `file:line: path`, or `--set path`.
    pub(super) fn place(&self, offset: usize, path: &str) -> String {
        match self {
            Self::File { .. } => format!("{}: {path}", self.line(offset)),
            Self::CommandLine => format!("--set {path}"),
        }
    }
}

/// A scenario's values, not yet checked. It has the shape of a scenario's tables and lists from the start.
pub(super) struct Draft {
    pub(super) tree: Value,
    pub(super) places: Places,
}

/// Path and place of each value that was set, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Places(Vec<(String, String)>);

impl Places {
    /// Where the value at the first of the `paths` comes from, or at another of them if that was set later.
    pub(super) fn of(&self, paths: &[&str]) -> Option<&str> {
        let holds = |outer: &str, inner: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let set = |(set, _): &&(String, String)| paths.iter().any(|path| holds(path, set) || holds(set, path));
        self.0.iter().rev().find(set).map(|(_, place)| place.as_str())
    }

    /// Path and place of what the command line set.
    pub(super) fn of_sets(&self) -> impl Iterator<Item = (&str, &str)> {
        let all = self.0.iter().map(|(path, place)| (path.as_str(), place.as_str()));
        all.filter(|(_, place)| place.starts_with("--set "))
    }

    fn push(&mut self, path: &str, place: &str) {
        self.0.push((path.to_owned(), place.to_owned()));
    }
}

impl Default for Draft {
    fn default() -> Self {
        Self { tree: settings::tree(&Scenario::default()), places: Places::default() }
    }
}

impl Draft {
    /// Gives it a name of its own and no description: those are not inherited.
    pub(super) fn rename(&mut self, name: &str) {
        for (key, text) in [("name", name), ("description", "")] {
            self.tree[key] = Value::String(text.to_owned());
            self.places.0.retain(|(path, _)| path != key);
        }
    }

    /// Puts a document over it.
    pub(super) fn merge(&mut self, document: &DeValue, source: &Source) -> Result<(), Error> {
        let start = source.line(0);
        merge(&mut self.tree, document, "", &start, source, &mut self.places)
    }

    /// Applies a `path=value`.
    pub(super) fn set(&mut self, assignment: &str) -> Result<(), Error> {
        let Some((path, text)) = assignment.split_once('=') else {
            let problem = "found no \"=\"; valid is path=value, such as ground.friction=0.5";
            return Err(Error::invalid("--set ".to_owned() + assignment, problem));
        };
        let (path, text) = (path.trim(), text.trim());
        let place = format!("--set {path}");
        if at(&mut self.tree, path).is_none() {
            return Err(Error::invalid(place, self.why_unknown(path)));
        }
        let valid = Setting::find(path).map(|setting| setting.valid);
        let parsed = DeValue::parse(text);
        let value = match (valid, &parsed) {
            (Some(Valid::Text | Valid::OneOf(_)), Ok(value)) if value.get_ref().is_str() => value.get_ref().clone(),
            (Some(Valid::Text | Valid::OneOf(_)), _) | (Some(_), Err(_)) => DeValue::String(text.into()),
            (_, Ok(value)) => value.get_ref().clone(),
            (None, Err(error)) => return Err(Error::invalid(place, format!("not a TOML value: {}", error.message()))),
        };
        let slot = at(&mut self.tree, path).expect("it was there a moment ago");
        merge(slot, &value, path, &place, &Source::CommandLine, &mut self.places)
    }

    /// Why there is nothing at `path`.
    fn why_unknown(&mut self, path: &str) -> String {
        let ends = path.match_indices('.').map(|(dot, _)| dot).rev();
        let parent = ends.map(|end| &path[..end]).find(|parent| at(&mut self.tree, parent).is_some());
        let container = match parent {
            Some(parent) => at(&mut self.tree, parent).expect("it was found"),
            None => &mut self.tree,
        };
        match (container, parent.unwrap_or("")) {
            (Value::Table(table), _) => unknown_key(path, table),
            (Value::Array(list), parent) => match list.len() {
                0 => format!("{parent} is empty, there are none; set the whole list with {parent}=[...]"),
                1 => format!("{parent} holds 1 element, valid is {parent}.0"),
                count => format!("{parent} holds {count} elements, valid are {parent}.0 to {parent}.{}", count - 1),
            },
            (_, parent) => format!("unknown path; {parent} is a single value"),
        }
    }

    /// Makes the path that setting `path` holds, if it does and if that is relative, one that starts from `folder`.
    pub(super) fn move_path(&mut self, path: &str, folder: &Path) {
        let is_no_path = |text: &str| text.is_empty() || (path == "model" && model_text(text).is_some());
        if PATHS.contains(&path)
            && let Some(Value::String(text)) = at(&mut self.tree, path)
            && !is_no_path(text)
        {
            *text = folder.join(text.as_str()).display().to_string();
        }
    }
}

/// Puts `found`, which stands at `place`, into the `slot` at `path`.
fn merge(
    slot: &mut Value,
    found: &DeValue,
    path: &str,
    place: &str,
    source: &Source,
    places: &mut Places,
) -> Result<(), Error> {
    match (slot, found) {
        (Value::Table(table), DeValue::Table(found)) if Setting::find(path).is_none() => {
            for (key, value) in found {
                let path = format!("{path}{}{}", if path.is_empty() { "" } else { "." }, key.get_ref());
                let place = source.place(key.span().start, &path);
                if !table.contains_key(key.get_ref().as_ref()) {
                    let more = if path.contains('.') { "" } else { "; a file may also say what it extends" };
                    return Err(Error::invalid(place, unknown_key(&path, table) + more));
                }
                merge(&mut table[key.get_ref().as_ref()], value.get_ref(), &path, &place, source, places)?;
            }
            Ok(())
        }
        (Value::Table(table), other) if Setting::find(path).is_none() => {
            let problem = format!("found {}; valid is a table with the keys {}", self::found(other), keys(table));
            Err(Error::invalid(place, problem))
        }
        (slot, found) if path == "pushes" => {
            *slot = pushes(found, place, source, places)?;
            Ok(())
        }
        (slot, found) => {
            *slot = plain(found);
            places.push(path, place);
            Ok(())
        }
    }
}

/// A list of pushes, each with what it must state.
fn pushes(found: &DeValue, place: &str, source: &Source, places: &mut Places) -> Result<Value, Error> {
    let Some(elements) = found.as_array() else {
        let problem = format!("found {}; valid is a list of tables, each headed [[pushes]]", self::found(found));
        return Err(Error::invalid(place, problem));
    };
    let template = settings::template()["pushes"][0].clone();
    let mut list = Vec::with_capacity(elements.len());
    for (index, element) in elements.iter().enumerate() {
        let path = format!("pushes.{index}");
        let place = source.place(element.span().start, &path);
        let mut push = template.clone();
        places.push(&path, &place);
        merge(&mut push, element.get_ref(), &path, &place, source, places)?;
        let states = |name: &str| element.get_ref().as_table().is_some_and(|table| table.contains_key(name));
        if let Some(missing) = REQUIRED_OF_A_PUSH.iter().find(|name| !states(name)) {
            let problem = format!("{missing} is missing; a push needs {}", REQUIRED_OF_A_PUSH.join(", "));
            return Err(Error::invalid(place, problem));
        }
        list.push(push);
    }
    Ok(Value::Array(list))
}

fn unknown_key(path: &str, table: &toml::Table) -> String {
    let hint = settings::nearest(path).map_or(String::new(), |near| format!("did you mean {near}? "));
    format!("unknown; {hint}valid here: {}", keys(table))
}

fn keys(table: &toml::Table) -> String {
    list(table.keys())
}

/// A value for "found ...".
pub(super) fn found(value: &DeValue) -> String {
    settings::in_words(&plain(value))
}

/// The value without its place. A number too large for its type becomes one that no range holds.
fn plain(value: &DeValue) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(integer) => Value::Integer(integer),
            Err(_) => Value::Float(number.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(number) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(boolean) => Value::Boolean(*boolean),
        DeValue::Datetime(datetime) => Value::Datetime(*datetime),
        DeValue::Array(list) => list.iter().map(|element| plain(element.get_ref())).collect::<Vec<_>>().into(),
        DeValue::Table(table) => {
            Value::Table(table.iter().map(|(key, value)| (key.get_ref().to_string(), plain(value.get_ref()))).collect())
        }
    }
}
