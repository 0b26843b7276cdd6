//! Files that are there as a whole or not at all.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use legwork::error::Error;
use legwork_rbd::file::{self, Unread};

/// The ending of a file that is still being written.
const UNFINISHED: &str = ".tmp";

fn unfinished(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(UNFINISHED);
    name.into()
}

/// Writes a file beside `path`, onto the disk, and gives it the name `path` when it is whole.
///
/// # Errors
/// The disk is full, the folder is read-only and the like; `path` is then as it was.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let unfinished = unfinished(path);
    let write = || {
        let mut file = File::create(&unfinished)?;
        file.write_all(bytes)?;
        // Before the rename, or a crash of the machine could leave the name without the content.
        file.sync_all()?;
        fs::rename(&unfinished, path)
    };
    write().map_err(|error| {
        let _ = fs::remove_file(&unfinished);
        Error::io(path, &error)
    })
}

/// Removes what a crashed run left of writing `path`.
pub(super) fn remove_unfinished(path: &Path) -> Result<(), Error> {
    let path = unfinished(path);
    match fs::remove_file(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(path, &error)),
        _ => Ok(()),
    }
}

/// The name of the file that `name` is, or was to become.
pub(super) fn finished(name: &str) -> &str {
    name.strip_suffix(UNFINISHED).unwrap_or(name)
}

/// No file of a store holds more [bytes].
const LARGEST: u64 = 1_000_000_000;

/// The bytes of the file, if there is one.
pub(super) fn read_if_there(path: &Path) -> Result<Option<Vec<u8>>, Error> {
    match file::read(path, LARGEST) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(Unread::Io(error)) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(why) => Err(Error::unread(path, &why)),
    }
}

/// The names in `folder` that are text; none if there is no such folder.
pub(super) fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let failed = |error: &std::io::Error| Error::io(folder, error);
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(|error| failed(&error))?,
    };
    entries.map(|entry| Ok(entry.map_err(|error| failed(&error))?.file_name().to_string_lossy().into_owned())).collect()
}
