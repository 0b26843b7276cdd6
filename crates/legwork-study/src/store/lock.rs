//! Locks on a study's folder: who writes into it.
//!
//! The operating system holds them on files and gives them back when a program ends, however it ends: a crashed run
//! leaves no lock. The files themselves stay, those of shards until a run of the whole.

use std::fs::{File, TryLockError};
use std::path::Path;

use super::shard::Shard;
use crate::files;
use legwork::error::Error;

const PREFIX: &str = ".lock";

/// The right to write into a folder, until it is dropped.
#[derive(Debug)]
pub(super) struct Lock {
    _files: Vec<File>,
}

impl Lock {
    /// A whole run has the folder alone. Shards share it, where each runs once and all cut the study alike.
    pub(super) fn take(folder: &Path, shard: Option<Shard>) -> Result<Self, Error> {
        let all = open(&folder.join(PREFIX))?;
        let Some(shard) = shard else {
            held(all.try_lock(), folder, "another run writes into this folder")?;
            // Nobody has these now: shards share the lock that is held alone here.
            for left in files::names(folder)?.iter().filter(|name| is_lock(name) && name.contains("-of-")) {
                let _ = std::fs::remove_file(folder.join(left));
            }
            return Ok(Self { _files: vec![all] });
        };
        held(all.try_lock_shared(), folder, "another run of the whole study writes into this folder")?;
        let name = name(&shard.to_string());
        let own = open(&folder.join(&name))?;
        held(own.try_lock(), folder, &format!("another run of shard {shard} writes into this folder"))?;
        // Shards of another number would write the same chunks. Looked for with the own lock in hand, so that of two
        // that start at once at least one sees the other.
        let same = format!("-of-{}", shard.number_of_shards());
        for other in files::names(folder)?.iter().filter(|other| other.contains("-of-") && !other.ends_with(&same)) {
            let problem = format!("a run into this folder cuts the study otherwise than shard {shard} ({other})");
            held(open(&folder.join(other))?.try_lock_shared(), folder, &problem)?;
        }
        Ok(Self { _files: vec![all, own] })
    }

    /// Waits until no other is about to look which study the folder holds, and to write one if it holds none.
    pub(super) fn take_start(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(format!("{PREFIX}-start"));
        let file = open(&path)?;
        file.lock().map_err(|error| Error::io(path, &error))?;
        Ok(Self { _files: vec![file] })
    }
}

fn name(shard: &str) -> String {
    format!("{PREFIX}-{}", shard.replace('/', "-of-"))
}

/// Whether a file of this name is a lock's.
pub(super) fn is_lock(name: &str) -> bool {
    name.starts_with(PREFIX)
}

fn open(path: &Path) -> Result<File, Error> {
    File::options().create(true).truncate(false).write(true).open(path).map_err(|error| Error::io(path, &error))
}

fn held(lock: Result<(), TryLockError>, folder: &Path, problem: &str) -> Result<(), Error> {
    let problem = match lock {
        Ok(()) => return Ok(()),
        Err(TryLockError::WouldBlock) => format!("{problem}: wait for its end, or choose another folder"),
        Err(TryLockError::Error(error)) => {
            format!("the file system grants no lock ({error}): choose a folder on another")
        }
    };
    Err(Error::Io { path: folder.to_owned(), problem })
}
