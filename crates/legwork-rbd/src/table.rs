//! A TOML table whose valid keys depend on a type that it names.

use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::{Spanned, Value};

use crate::error::ModelError;
use crate::read::Source;

/// The entries of a table in their order, each with its place.
#[derive(Clone, Default)]
pub(crate) struct Table(Vec<(Spanned<String>, Value)>);

impl Table {
    pub(crate) fn push(&mut self, key: &str, value: impl Into<Value>) {
        self.0.push((Spanned::new(0..0, key.to_owned()), value.into()));
    }

    pub(crate) fn append(&mut self, other: Table) {
        self.0.extend(other.0);
    }

    /// Takes the value of `key` out, where it is given.
    pub(crate) fn take<T: DeserializeOwned>(&mut self, source: &Source, key: &str) -> Result<Option<T>, ModelError> {
        let Some(index) = self.0.iter().position(|(other, _)| other.get_ref() == key) else { return Ok(None) };
        let (key, value) = self.0.remove(index);
        let value = value.try_into::<T>().map_err(|error| {
            source.syntax(source.line(key.span().start), format!("{}: {}", key.get_ref(), error.message()))
        })?;
        Ok(Some(value))
    }

    /// The keys that are left, each with its line.
    pub(crate) fn keys<'a>(&'a self, source: &'a Source) -> impl Iterator<Item = (&'a str, Option<usize>)> {
        self.0.iter().map(|(key, _)| (key.get_ref().as_str(), source.line(key.span().start)))
    }
}

impl<'de> Deserialize<'de> for Table {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;
        impl<'de> Visitor<'de> for Entries {
            type Value = Table;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a table")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Table, A::Error> {
                let mut table = Table::default();
                while let Some(entry) = map.next_entry()? {
                    table.0.push(entry);
                }
                Ok(table)
            }
        }
        deserializer.deserialize_map(Entries)
    }
}

impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, value)| (key.get_ref(), value)))
    }
}
