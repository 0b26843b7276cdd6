//! Files that are there as a whole or not at all.
//!
//! A file is written under another name beside its own, which it gets when it is whole. That name follows from its own, so
//! that the next run that writes the same file takes over what a killed one left.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use legwork::error::Error;
use legwork_rbd::file::{self, Unread};

/// What stands before the ending of a file that is still being written; its name begins with a dot.
const UNFINISHED: &str = ".unfinished";

/// A file that is being written; it is removed unless it is finished.
#[derive(Debug)]
pub struct Unfinished {
    path: PathBuf,
    written: PathBuf,
    is_finished: bool,
    /// Its lock goes with this run, however that ends.
    _claim: File,
}

impl Unfinished {
    /// Begins the file at `path`. A link stays one: the file that it leads to is replaced.
    ///
    /// # Errors
    /// Another run writes it at the moment; the folder cannot be written.
    pub fn new(path: &Path) -> Result<Self, Error> {
        let written = unfinished(&path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        let failed = |error: std::io::Error| Error::io(path, &error);
        let claim = File::options().create(true).truncate(false).write(true).open(&written).map_err(failed)?;
        // Elsewhere a lock would keep this run itself from writing by another handle.
        if cfg!(unix) && matches!(claim.try_lock(), Err(fs::TryLockError::WouldBlock)) {
            let problem = "another run writes this file: wait for its end, or give another name".to_owned();
            return Err(Error::Io { path: path.to_owned(), problem });
        }
        Ok(Self { path: path.to_owned(), written, is_finished: false, _claim: claim })
    }

    /// Where it is written until it is whole: beside its place, with the same ending.
    pub fn written(&self) -> &Path {
        &self.written
    }

    /// Gives it its name, in place of what was there.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn finish(mut self) -> Result<(), Error> {
        let target = self.path.canonicalize().unwrap_or_else(|_| self.path.clone());
        fs::rename(&self.written, target).map_err(|error| Error::io(&self.path, &error))?;
        self.is_finished = true;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if !self.is_finished {
            let _ = fs::remove_file(&self.written);
        }
    }
}

/// `.run.unfinished.csv` for `run.csv`.
fn unfinished(path: &Path) -> PathBuf {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let ending = path.extension().map_or(String::new(), |ending| format!(".{}", text(Some(ending))));
    path.with_file_name(format!(".{}{UNFINISHED}{ending}", text(path.file_stem())))
}

/// Writes a file onto the disk.
///
/// # Errors
/// The disk is full, the folder is read-only and the like; `path` is then as it was.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let file = Unfinished::new(path)?;
    let write = || {
        let mut written = File::create(file.written())?;
        written.write_all(bytes)?;
        // Before the rename, or a crash of the machine could leave the name without the content.
        written.sync_all()
    };
    write().map_err(|error| Error::io(path, &error))?;
    file.finish()
}

/// Removes what a killed run left of writing `path`.
pub(crate) fn remove_unfinished(path: &Path) -> Result<(), Error> {
    let path = unfinished(path);
    match fs::remove_file(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(&path, &error)),
        _ => Ok(()),
    }
}

/// The name of the file that the one called `name` was to become; none where it is no unfinished one.
pub(crate) fn to_become(name: &str) -> Option<String> {
    let (stem, ending) = name.strip_prefix('.')?.split_once(UNFINISHED)?;
    Some(format!("{stem}{ending}"))
}

/// No file of a store holds more [bytes].
const LARGEST: u64 = 1_000_000_000;

/// The bytes of the file, if there is one.
pub(crate) fn read_if_there(path: &Path) -> Result<Option<Vec<u8>>, Error> {
    match file::read(path, LARGEST) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(Unread::Io(error)) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(why) => Err(Error::unread(path, &why)),
    }
}

/// The names in `folder` that are text; none if there is no such folder.
pub(crate) fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let failed = |error: &std::io::Error| Error::io(folder, error);
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(|error| failed(&error))?,
    };
    entries.map(|entry| Ok(entry.map_err(|error| failed(&error))?.file_name().to_string_lossy().into_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_leads_to_its_unfinished_one_and_back() {
        for (name, expected) in [
            ("run.csv", ".run.unfinished.csv"),
            ("walk-torque_nm.mean.svg", ".walk-torque_nm.mean.unfinished.svg"),
            ("log", ".log.unfinished"),
        ] {
            assert_eq!(unfinished(&Path::new("a").join(name)), Path::new("a").join(expected));
            assert_eq!(to_become(expected).as_deref(), Some(name));
            assert_eq!(to_become(name), None);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_has_one_writer_at_a_time_and_what_a_killed_one_left_is_taken_over() {
        let folder = std::env::temp_dir().join(format!("legwork-unfinished-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.csv");
        fs::write(unfinished(&path), "what a killed run left, which is longer").unwrap();
        let first = Unfinished::new(&path).unwrap();
        let refused = Unfinished::new(&path).unwrap_err().to_string();
        assert!(refused.contains("a.csv: another run writes this file: wait for its end"), "{refused}");
        fs::write(first.written(), "whole").unwrap();
        first.finish().unwrap();
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(&folder).unwrap().len()), ("whole", 1));
        drop(Unfinished::new(&path).unwrap());
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(&folder).unwrap().len()), ("whole", 1));
        fs::remove_dir_all(&folder).unwrap();
    }
}
