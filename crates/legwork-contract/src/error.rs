//! What the caller did wrong: a file, a key, a value. A fall or an infeasible program is a result, not an error.

use std::path::PathBuf;

/// Why a scenario could not be read or run.
///
/// Every message names the place (file, line, key), what was found and what would be valid.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder could not be read or written.
    #[error("{}: {problem}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What went wrong, in words.
        problem: String,
    },
    /// The content of a file or of a `--set` is not valid.
    #[error("{place}: {problem}")]
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

    /// Whether the operating system, and not the content, is at fault (exit code 1 instead of 2).
    pub fn is_io(&self) -> bool {
        match self {
            Self::Io { .. } => true,
            Self::Model(error) => error.is_io(),
            Self::Invalid { .. } => false,
        }
    }
}
