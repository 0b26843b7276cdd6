//! `study.toml`: which study a folder holds.
//!
//! The text is the caller's, after a first line (a comment in TOML) that tells the rest of what identifies the study.

use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

use super::files;
use legwork::error::Error;

pub(super) const NAME: &str = "study.toml";

const FORMAT: u32 = 1;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Manifest {
    pub(super) text: String,
    pub(super) identity: u128,
    pub(super) total: u64,
    /// Of all the above.
    pub(super) hash: u128,
}

impl Manifest {
    pub(super) fn new(text: &str, identity: u128, total: u64) -> Self {
        let mut hasher = Xxh3::new();
        hasher.update(&FORMAT.to_le_bytes());
        hasher.update(&identity.to_le_bytes());
        hasher.update(&total.to_le_bytes());
        hasher.update(text.as_bytes());
        Self { text: text.to_owned(), identity, total, hash: hasher.digest128() }
    }

    /// Refuses a study that was `found` in `folder` where `wanted`, which is this one, was to be.
    pub(super) fn require_same(&self, found: &Self, wanted: &str, folder: &Path) -> Result<(), Error> {
        if self == found {
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
            "holds another study ({:032x}) than {wanted} ({:032x}): {difference}; choose another folder, or delete this one",
            found.hash, self.hash
        );
        Err(Error::invalid(folder.display().to_string(), problem))
    }

    fn first_line(&self) -> String {
        let Self { identity, total, hash, .. } = self;
        format!("# legwork study, format {FORMAT}, records {total}, identity {identity:032x}, hash {hash:032x}")
    }

    /// Writes the study to `folder`.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Error> {
        files::write_whole(&folder.join(NAME), format!("{}\n{}", self.first_line(), self.text).as_bytes())
    }

    /// The study in `folder`, if it holds one.
    ///
    /// # Errors
    /// It cannot be read, or was changed after it was written.
    pub(super) fn read(folder: &Path) -> Result<Option<Self>, Error> {
        let path = folder.join(NAME);
        let Some(bytes) = files::read_if_there(&path)? else {
            return Ok(None);
        };
        let found = String::from_utf8(bytes).ok().and_then(|content| Self::parse(&content));
        found.map(Some).ok_or_else(|| {
            let problem = "was not written by a study of this version, or was changed or damaged since: \
                           expected a first line with format, records, identity and hash that fit what follows";
            Error::invalid(path.display().to_string(), problem)
        })
    }

    fn parse(content: &str) -> Option<Self> {
        let (line, text) = content.split_once('\n')?;
        let value = |key: &str| line.split(", ").find_map(|part| part.strip_prefix(key)?.strip_prefix(' '));
        let identity = u128::from_str_radix(value("identity")?, 16).ok()?;
        let found = Self::new(text, identity, value("records")?.parse().ok()?);
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
        assert_eq!(Manifest::parse(&content).as_ref(), Some(&manifest));
        assert!(toml::from_str::<toml::Table>(&content).is_ok(), "the first line is a comment");
        for at in 0..content.len() {
            let mut changed = content.clone().into_bytes();
            changed[at] ^= 1;
            assert_eq!(Manifest::parse(&String::from_utf8(changed).unwrap()), None, "byte {at}");
        }
    }

    #[test]
    fn text_identity_and_number_of_records_make_another_study() {
        let hash = |text, identity, total| Manifest::new(text, identity, total).hash;
        let hashes = [hash("a", 1, 2), hash("b", 1, 2), hash("a", 3, 2), hash("a", 1, 4)];
        assert!((0..4).all(|i| (0..i).all(|j| hashes[i] != hashes[j])), "{hashes:?}");
    }
}
