//! `study.toml` or `tuning.toml`: which study or tuning a folder holds.
//!
//! The text is the caller's, after a first line (a comment in TOML) that tells the rest of what identifies it. A tuning's
//! second line is its budget, which may change.

use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

use crate::files;
use legwork::error::Error;

const FORMAT: u32 = 1;

/// How the line of a tuning's budget begins.
const BUDGET: &str = "budget = ";

/// What a folder is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Study,
    Tuning,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Study => "study",
            Self::Tuning => "tuning",
        }
    }

    /// The name of its file.
    pub(super) fn file(self) -> String {
        format!("{}.toml", self.name())
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Manifest {
    pub(super) kind: Kind,
    pub(super) text: String,
    pub(super) identity: u128,
    pub(super) total: u64,
    /// Of all the above.
    pub(super) hash: u128,
    /// How many candidates a tuning tries.
    pub(super) budget: Option<u64>,
}

impl Manifest {
    pub(super) fn new(text: &str, identity: u128, total: u64) -> Self {
        Self::of(Kind::Study, text, identity, total)
    }

    pub(super) fn of(kind: Kind, text: &str, identity: u128, total: u64) -> Self {
        let mut hasher = Xxh3::new();
        hasher.update(&FORMAT.to_le_bytes());
        hasher.update(&identity.to_le_bytes());
        hasher.update(&total.to_le_bytes());
        hasher.update(text.as_bytes());
        Self { kind, text: text.to_owned(), identity, total, hash: hasher.digest128(), budget: None }
    }

    /// Refuses one that was `found` in `folder` where `wanted`, which is this one, was to be; budgets may differ.
    pub(super) fn require_same(&self, found: &Self, wanted: &str, folder: &Path) -> Result<(), Error> {
        if self.hash == found.hash {
            return Ok(());
        }
        let line = self.text.lines().zip(found.text.lines()).find(|(mine, theirs)| mine != theirs);
        let difference = match line {
            Some((mine, theirs)) => format!("it says {theirs:?}, not {mine:?}"),
            None if self.total != found.total => format!("it has {} records, not {}", found.total, self.total),
            None if self.text != found.text => "one of the two has more lines".to_owned(),
            None => {
                "the same settings, with another version of the program, model or data, or other figures".to_owned()
            }
        };
        let problem = format!(
            "holds another {} ({:032x}) than {wanted} ({:032x}): {difference}; choose another folder, or delete this one",
            self.kind.name(),
            found.hash,
            self.hash
        );
        Err(Error::invalid(folder.display().to_string(), problem))
    }

    fn first_line(&self) -> String {
        let Self { identity, total, hash, .. } = self;
        let kind = self.kind.name();
        format!("# legwork {kind}, format {FORMAT}, records {total}, identity {identity:032x}, hash {hash:032x}")
    }

    fn content(&self) -> String {
        let budget = self.budget.map_or(String::new(), |budget| format!("{BUDGET}{budget}\n"));
        format!("{}\n{budget}{}", self.first_line(), self.text)
    }

    /// Writes it to `folder`.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Error> {
        files::write_whole(&folder.join(self.kind.file()), self.content().as_bytes())
    }

    /// What `folder` holds of this kind, if it does.
    ///
    /// # Errors
    /// It cannot be read, or was changed after it was written.
    pub(super) fn read(folder: &Path, kind: Kind) -> Result<Option<Self>, Error> {
        let path = folder.join(kind.file());
        let Some(bytes) = files::read_if_there(&path)? else {
            return Ok(None);
        };
        let found = String::from_utf8(bytes).ok().and_then(|content| Self::parse(kind, &content));
        found.map(Some).ok_or_else(|| {
            let problem = format!(
                "was not written by a {} of this version, or was changed or damaged since: \
                 expected a first line with format, records, identity and hash that fit what follows",
                kind.name()
            );
            Error::invalid(path.display().to_string(), problem)
        })
    }

    fn parse(kind: Kind, content: &str) -> Option<Self> {
        let (line, mut text) = content.split_once('\n')?;
        let mut budget = None;
        if kind == Kind::Tuning {
            let (first, rest) = text.split_once('\n')?;
            (budget, text) = (Some(first.strip_prefix(BUDGET)?.parse().ok()?), rest);
        }
        let value = |key: &str| line.split(", ").find_map(|part| part.strip_prefix(key)?.strip_prefix(' '));
        let identity = u128::from_str_radix(value("identity")?, 16).ok()?;
        let found = Self { budget, ..Self::of(kind, text, identity, value("records")?.parse().ok()?) };
        (found.first_line() == line).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_any_byte_is_noticed() {
        let manifest = Manifest::new("rollouts = 10\n[push]\n", 77, 10);
        let content = format!("{}\n{}", manifest.first_line(), manifest.text);
        assert_eq!(Manifest::parse(Kind::Study, &content).as_ref(), Some(&manifest));
        assert!(toml::from_str::<toml::Table>(&content).is_ok(), "the first line is a comment");
        for at in 0..content.len() {
            let mut changed = content.clone().into_bytes();
            changed[at] ^= 1;
            assert_eq!(Manifest::parse(Kind::Study, &String::from_utf8(changed).unwrap()), None, "byte {at}");
        }
    }

    #[test]
    fn a_tuning_with_another_budget_is_the_same_and_one_of_another_text_is_not() {
        let tuning = |text, budget| Manifest { budget: Some(budget), ..Manifest::of(Kind::Tuning, text, 7, u64::MAX) };
        let (few, many) = (tuning("seed = 1\n", 6), tuning("seed = 1\n", 600));
        assert_eq!(Manifest::parse(Kind::Tuning, &many.content()).as_ref(), Some(&many));
        assert_eq!(toml::from_str::<toml::Table>(&few.content()).unwrap()["budget"].as_integer(), Some(6));
        assert!(few.require_same(&many, "the given one", Path::new("a")).is_ok());
        let refused = few.require_same(&tuning("seed = 2\n", 6), "the given one", Path::new("a")).unwrap_err();
        assert!(refused.to_string().contains("holds another tuning") && refused.to_string().contains("\"seed = 2\""));
        assert_eq!(Manifest::parse(Kind::Study, &few.content()), None);
    }

    #[test]
    fn text_identity_and_number_of_records_make_another_study() {
        let hash = |text, identity, total| Manifest::new(text, identity, total).hash;
        let hashes = [hash("a", 1, 2), hash("b", 1, 2), hash("a", 3, 2), hash("a", 1, 4)];
        assert!((0..4).all(|i| (0..i).all(|j| hashes[i] != hashes[j])), "{hashes:?}");
    }
}
