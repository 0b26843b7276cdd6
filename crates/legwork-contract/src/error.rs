//! What the caller did wrong: a file, a key, a value. A fall or an infeasible program is a result, not an error.

use std::path::PathBuf;

use legwork_rbd::file::Unread;
use legwork_rbd::words::{PLACE, PROBLEM, one_line};

/// Why a scenario could not be read or run.
///
/// Every message names the place (file, line, key), what was found and what would be valid, in one line of a few hundred
/// characters whatever is quoted in it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder could not be read or written.
    #[error("{}: {}", one_line(&path.display().to_string(), PLACE), one_line(.problem, PROBLEM))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What went wrong, in words.
        problem: String,
    },
    /// The content of a file or of a `--set` is not valid.
    #[error("{}: {}", one_line(.place, PLACE), one_line(.problem, PROBLEM))]
    Invalid {
        /// Where: `file:line: key`, or the key alone.
        place: String,
        /// What was found and what would be valid.
        problem: String,
    },
    /// The robot's model is not valid.
    #[error(transparent)]
    Model(#[from] legwork_rbd::ModelError),
}

impl Error {
    /// The content at `place` is not valid.
    pub fn invalid(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), problem: problem.into() }
    }

    /// An I/O error at `path`.
    pub fn io(path: impl Into<PathBuf>, error: &std::io::Error) -> Self {
        let problem = match error.kind() {
            std::io::ErrorKind::NotFound => "no such file or folder".to_owned(),
            std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
            std::io::ErrorKind::IsADirectory => "is a folder, expected a file".to_owned(),
            _ => error.to_string(),
        };
        Self::Io { path: path.into(), problem }
    }

    /// Why the file at `path` is not read.
    pub fn unread(path: impl Into<PathBuf>, why: &Unread) -> Self {
        let path = path.into();
        if why.is_io() {
            return Self::Io { path, problem: why.to_string() };
        }
        Self::invalid(path.display().to_string(), why.to_string())
    }

    /// Whether the operating system, and not the content, is at fault (exit code 1 instead of 2).
    pub fn is_io(&self) -> bool {
        match self {
            Self::Io { .. } => true,
            Self::Model(error) => error.is_io(),
            Self::Invalid { .. } => false,
        }
    }
}
