//! Why a model could not be read.

use thiserror::Error;

/// Why a model could not be read: every message names the file, the line where it is known, and what would be valid.
#[derive(Debug, Error)]
pub enum ModelError {
    /// The file could not be read.
    #[error("{file}: cannot be read: {source}")]
    Io {
        /// The path as given.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The path is a folder.
    #[error("{file}: is a folder; name a model file (.toml or .urdf) in it{files}")]
    Folder {
        /// The path as given.
        file: String,
        /// The model files in the folder, as an insertion into the message.
        files: String,
    },
    /// The file's kind is not known.
    #[error("{file}: unknown kind of file; valid are .toml and .urdf")]
    UnknownKind {
        /// The path as given.
        file: String,
    },
    /// The bytes are no text.
    #[error("{file}: not UTF-8 (first bad byte at {offset}); a model is a text file, .toml or .urdf")]
    NotUtf8 {
        /// The path as given.
        file: String,
        /// The number of valid bytes before the first bad one.
        offset: usize,
    },
    /// The text is no TOML or XML, or has a key too many, too few or of the wrong type.
    #[error("{}: {message}", place(.file, *.line))]
    Syntax {
        /// The file's name.
        file: String,
        /// Counted from one, where known.
        line: Option<usize>,
        /// What was found and what would be valid.
        message: String,
    },
    /// The text can be read, but is no possible robot.
    #[error("{}: {subject}: {problem}", place(.file, *.line))]
    Invalid {
        /// The file's name.
        file: String,
        /// Counted from one, where known.
        line: Option<usize>,
        /// The body, joint, contact or key in question.
        subject: String,
        /// What was found and what would be valid.
        problem: String,
    },
}

impl ModelError {
    /// Whether the file could not be read at all, as opposed to having bad content.
    #[must_use]
    pub fn is_io(&self) -> bool {
        matches!(self, ModelError::Io { .. } | ModelError::Folder { .. })
    }
}

fn place(file: &str, line: Option<usize>) -> String {
    line.map_or_else(|| file.to_owned(), |line| format!("{file}:{line}"))
}
