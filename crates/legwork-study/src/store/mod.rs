//! The folder of a study or a tuning: what is done, so that it can be added to by many runs and read at any time.
//!
//! ```text
//! study.toml             the study, and what else identifies it; of a tuning tuning.toml
//! chunks/000123.jsonl    the records of the 124th chunk; of a tuning the candidates of a generation
//! .lock*                 who writes at the moment
//! ```
//!
//! The records are cut into chunks by their number alone, and a chunk is written as a whole or not at all. So the folder
//! holds the same bytes whatever the number of threads, shards and interruptions. Every chunk is checked when it is
//! read. One chunk at a time is in memory.

mod chunk;
mod lock;
mod manifest;
mod merge;
mod shard;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::files;
use legwork::error::Error;
use lock::Lock;
use manifest::{Kind, Manifest};

pub use merge::merge;
pub use shard::Shard;

/// An open folder of a study: to add to, by [`Store::open`], or only to read, by [`Store::read`].
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    manifest: Manifest,
    /// Records in a full chunk.
    size: u64,
    shard: Shard,
    /// None in a store that is only read.
    lock: Option<Lock>,
}

/// What there is still to do.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    /// The chunks that are not there or damaged, in order.
    pub missing: Vec<u64>,
    /// The files that are there and no good.
    pub damaged: Vec<Damaged>,
}

/// A chunk's file that is no good: cut short, changed, of another study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damaged {
    /// The chunk that should be in it.
    pub chunk: u64,
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it, as `is cut short`.
    pub problem: String,
}

enum Found {
    Nothing,
    Damaged(String),
    Sound(Vec<u8>),
}

impl Store {
    /// Opens `folder` for a study of `total` records, or for a `shard` of them. Makes the folder where there is none.
    ///
    /// A study is identified by its `text` (TOML), by the number of records, and by `identity`, a hash of what else
    /// decides the records. What is in the folder from earlier runs of the same study stays and need not be done again.
    ///
    /// # Errors
    /// The folder holds another study, or files and no study; another run writes into it; it cannot be written.
    pub fn open(folder: &Path, text: &str, identity: u128, total: u64, shard: Option<Shard>) -> Result<Self, Error> {
        Self::open_with(folder, Manifest::new(text, identity, total), shard::chunk_size(total), shard, |_| None)
    }

    /// Opens `folder` for a tuning with generations of `size` candidates, and remembers there the budget that `budget` makes
    /// of what the folder has so far. A tuning is identified by its `text` (TOML, without the budget) and by `identity`.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn open_tuning(
        folder: &Path,
        text: &str,
        identity: u128,
        size: u64,
        budget: impl FnOnce(Option<u64>) -> u64,
    ) -> Result<Self, Error> {
        let manifest = Manifest::of(Kind::Tuning, text, identity, u64::MAX);
        Self::open_with(folder, manifest, size, None, |kept| Some(budget(kept)))
    }

    fn open_with(
        folder: &Path,
        mut manifest: Manifest,
        size: u64,
        shard: Option<Shard>,
        budget: impl FnOnce(Option<u64>) -> Option<u64>,
    ) -> Result<Self, Error> {
        make_folder(folder, manifest.kind)?;
        let lock = Some(Lock::take(folder, shard)?);
        let start = Lock::take_start(folder)?;
        let found = Manifest::read(folder, manifest.kind)?;
        if let Some(found) = &found {
            manifest.require_same(found, "the given one", folder)?;
        }
        manifest.budget = budget(found.as_ref().and_then(|found| found.budget));
        if found.as_ref() != Some(&manifest) {
            manifest.write(folder)?;
        }
        drop(start);
        let store = Self { folder: folder.to_owned(), manifest, size, shard: shard.unwrap_or(Shard::WHOLE), lock };
        fs::create_dir_all(store.chunk_folder()).map_err(|error| Error::io(store.chunk_folder(), &error))?;
        for unfinished in files::names(&store.chunk_folder())?.iter().filter_map(|name| files::to_become(name)) {
            if chunk_of(&unfinished).is_some_and(|chunk| store.shard.owns(chunk)) {
                files::remove_unfinished(&store.chunk_folder().join(unfinished))?;
            }
        }
        Ok(store)
    }

    /// Opens the study in `folder` to read what is done, also while a run adds to it. Writes nothing.
    ///
    /// # Errors
    /// There is no study, or it cannot be read.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
        let Some(manifest) = Manifest::read(folder, Kind::Study)? else {
            let problem = format!("holds no study: expected a file {} in it", Kind::Study.file());
            return Err(Error::invalid(folder.display().to_string(), problem));
        };
        let size = shard::chunk_size(manifest.total);
        Ok(Self { folder: folder.to_owned(), manifest, size, shard: Shard::WHOLE, lock: None })
    }

    /// The study, as it was given.
    pub fn text(&self) -> &str {
        &self.manifest.text
    }

    /// The hash of what identifies the study beside its text.
    pub fn identity(&self) -> u128 {
        self.manifest.identity
    }

    /// Hash of text, number of records and identity.
    pub fn hash(&self) -> u128 {
        self.manifest.hash
    }

    /// How many candidates a tuning tries; none of a study.
    pub fn budget(&self) -> Option<u64> {
        self.manifest.budget
    }

    /// The number of records in the whole study.
    pub fn total(&self) -> u64 {
        self.manifest.total
    }

    /// The number of chunks in the whole study.
    pub fn number_of_chunks(&self) -> u64 {
        self.total().div_ceil(self.size)
    }

    /// The indices of the records in `chunk`.
    pub fn range(&self, chunk: u64) -> Range<u64> {
        shard::range(chunk, self.size, self.total())
    }

    /// The chunks of this store's shard.
    pub fn own_chunks(&self) -> impl Iterator<Item = u64> + use<> {
        self.shard.of(self.number_of_chunks())
    }

    /// Checks that the disk has room for what this shard has still to do, at `bytes_per_record` (of JSON, with its end
    /// of line), and for so many bytes `besides`. Quick however many records there are to be; so it comes before
    /// [`Store::survey`].
    ///
    /// # Errors
    /// It has not, or does not tell.
    pub fn check_space(&self, bytes_per_record: u64, besides: u64) -> Result<(), Error> {
        let records = self.range(0).end.saturating_mul(bytes_per_record);
        let per_chunk = on_disk(records.saturating_add(chunk::HEADER_BYTES));
        let missing = self.shard.size(self.number_of_chunks()).saturating_sub(self.own_files()?.len() as u64);
        let needed = missing.saturating_mul(per_chunk).saturating_add(besides);
        let free = fs4::available_space(&self.folder).map_err(|error| Error::io(&self.folder, &error))?;
        if needed <= free {
            return Ok(());
        }
        let problem = format!(
            "what is still to be written needs about {}, and the disk has {} free: \
             choose a folder on another disk, fewer records, or shards on several disks",
            in_words(needed),
            in_words(free)
        );
        Err(Error::Io { path: self.folder.clone(), problem })
    }

    /// Reads and checks all chunks of this store's shard.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn survey(&self) -> Result<Survey, Error> {
        self.survey_of(self.own_chunks())
    }

    /// Whether all chunks of the whole study, not of a shard alone, are there and sound.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn is_complete(&self) -> Result<bool, Error> {
        Ok(self.survey_of(0..self.number_of_chunks())?.missing.is_empty())
    }

    /// The records that the chunks with a file hold, and those chunks that are no good.
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn kept(&self) -> Result<(u64, Vec<Damaged>), Error> {
        let chunks = self.own_files()?;
        let survey = self.survey_of(chunks.iter().copied())?;
        let sound = (chunks.len() - survey.damaged.len()) as u64;
        Ok((sound * self.size, survey.damaged))
    }

    /// The records of `chunk`; none where it is not there, damaged, or of other records than `T`.
    ///
    /// # Errors
    /// The file is there and cannot be read.
    pub fn chunk<T: DeserializeOwned>(&self, chunk: u64) -> Result<Option<Vec<T>>, Error> {
        let Found::Sound(bytes) = self.find(chunk)? else { return Ok(None) };
        let records = chunk::verify(&self.place(chunk), &bytes).and_then(chunk::decode);
        Ok(records.ok())
    }

    /// Forgets what the folder is for, so that it can be for another: where nothing came of it.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn abandon(self) -> Result<(), Error> {
        let path = self.folder.join(self.manifest.kind.file());
        let removed = fs::remove_dir_all(self.chunk_folder()).and_then(|()| fs::remove_file(&path));
        removed.map_err(|error| Error::io(path, &error))
    }

    fn survey_of(&self, chunks: impl Iterator<Item = u64>) -> Result<Survey, Error> {
        let mut survey = Survey::default();
        for chunk in chunks {
            match self.find(chunk)? {
                Found::Sound(_) => continue,
                Found::Nothing => {}
                Found::Damaged(problem) => {
                    survey.damaged.push(Damaged { chunk, path: self.chunk_path(chunk), problem });
                }
            }
            survey.missing.push(chunk);
        }
        Ok(survey)
    }

    /// Writes the records of `chunk`, those of [`Store::range`] in this order: all of them or, on an error, none.
    ///
    /// # Errors
    /// The disk is full, the folder is read-only and the like, or a record cannot be read back, as one with a NaN.
    ///
    /// # Panics
    /// The store is only read, the chunk is another shard's, or the number of records is not the chunk's.
    pub fn write<T: Serialize + DeserializeOwned>(&self, chunk: u64, records: &[T]) -> Result<(), Error> {
        let place = self.place(chunk);
        assert_eq!(records.len() as u64, place.range.end - place.range.start, "records in chunk {chunk}");
        let bytes = chunk::encode(&place, records)
            .map_err(|(index, problem)| Error::invalid(format!("record {index}"), problem))?;
        self.write_bytes(chunk, &bytes)
    }

    fn write_bytes(&self, chunk: u64, bytes: &[u8]) -> Result<(), Error> {
        assert!(self.lock.is_some(), "the store is only read");
        assert!(self.shard.owns(chunk), "chunk {chunk} is not of shard {}", self.shard);
        files::write_whole(&self.chunk_path(chunk), bytes)
    }

    /// All records of the study, in the order of their indices. It ends after an error.
    ///
    /// The items are errors where a chunk is missing or damaged, or holds other records than `T`.
    pub fn records<T: DeserializeOwned>(&self) -> impl Iterator<Item = Result<T, Error>> {
        let mut failed = false;
        let chunks = (0..self.number_of_chunks()).map_while(move |chunk| {
            let records = (!failed).then(|| self.records_of(chunk));
            failed = matches!(records, Some(Err(_)));
            records
        });
        chunks.flat_map(|records| match records {
            Ok(records) => records.into_iter().map(Ok).collect(),
            Err(error) => vec![Err(error)],
        })
    }

    fn records_of<T: DeserializeOwned>(&self, chunk: u64) -> Result<Vec<T>, Error> {
        let refused = |problem: String| Error::invalid(self.chunk_path(chunk).display().to_string(), problem);
        let bytes = match self.find(chunk)? {
            Found::Sound(bytes) => bytes,
            Found::Damaged(problem) => return Err(refused(format!("{problem}; run the study again to redo it"))),
            Found::Nothing => {
                return Err(refused("is not there yet; run the study again, or merge the shards".to_owned()));
            }
        };
        let body = chunk::verify(&self.place(chunk), &bytes).map_err(&refused)?;
        chunk::decode(body).map_err(&refused)
    }

    fn find(&self, chunk: u64) -> Result<Found, Error> {
        let Some(bytes) = files::read_if_there(&self.chunk_path(chunk))? else {
            return Ok(Found::Nothing);
        };
        Ok(match chunk::verify(&self.place(chunk), &bytes) {
            Ok(_) => Found::Sound(bytes),
            Err(problem) => Found::Damaged(problem),
        })
    }

    fn place(&self, chunk: u64) -> chunk::Place {
        chunk::Place { study: self.hash(), range: self.range(chunk) }
    }

    fn chunk_folder(&self) -> PathBuf {
        self.folder.join("chunks")
    }

    fn chunk_path(&self, chunk: u64) -> PathBuf {
        self.chunk_folder().join(format!("{chunk:06}.jsonl"))
    }

    /// The chunks of this shard that have a file.
    fn own_files(&self) -> Result<Vec<u64>, Error> {
        let names = files::names(&self.chunk_folder())?;
        Ok(names.iter().filter_map(|name| chunk_of(name)).filter(|&chunk| self.shard.owns(chunk)).collect())
    }
}

/// The chunk whose file has this name.
fn chunk_of(name: &str) -> Option<u64> {
    name.strip_suffix(".jsonl")?.parse().ok()
}

/// Makes `folder`, which must be empty or hold one of this kind.
fn make_folder(folder: &Path, kind: Kind) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|error| match folder.is_file() {
        true => Error::Io { path: folder.to_owned(), problem: "is a file, expected a folder".to_owned() },
        false => Error::io(folder, &error),
    })?;
    let file = kind.file();
    let ours =
        |name: &str| lock::is_lock(name) || name == file || files::to_become(name).is_some_and(|name| name == file);
    match files::names(folder)?.iter().find(|name| !ours(name)) {
        Some(name) if !folder.join(&file).exists() => {
            let problem = format!("holds files ({name}) and no {}: expected a new or empty folder", kind.name());
            Err(Error::invalid(folder.display().to_string(), problem))
        }
        _ => Ok(()),
    }
}

/// What a file of so many bytes takes, on a file system with the usual blocks of 4 KiB.
fn on_disk(bytes: u64) -> u64 {
    bytes.div_ceil(4096).saturating_mul(4096)
}

fn in_words(bytes: u64) -> String {
    let (unit, name) = match bytes {
        0..1_000_000_000 => (1e6, "MB"),
        1_000_000_000..1_000_000_000_000 => (1e9, "GB"),
        _ => (1e12, "TB"),
    };
    format!("{:.1} {name}", bytes as f64 / unit)
}
