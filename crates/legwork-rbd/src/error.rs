//! Why a model could not be read.

use thiserror::Error;

use crate::file::Unread;
use crate::words::{PLACE, PROBLEM, one_line};

/// Most characters of what a message is about.
const SUBJECT: usize = 80;

/// Why a model could not be read: every message names the file, the line where it is known, and what would be valid.
#[derive(Debug, Error)]
pub enum ModelError {
    /// The file could not be read.
    #[error("{}: {source}", one_line(.file, PLACE))]
    Unread {
        /// The path as given.
        file: String,
        /// Why.
        source: Unread,
    },
    /// The path is a folder.
    #[error("{}: is a folder; name a model file (.toml, .urdf or .xml) in it{files}", one_line(.file, PLACE))]
    Folder {
        /// The path as given.
        file: String,
        /// The model files in the folder, as an insertion into the message.
        files: String,
    },
    /// The file's kind is not known.
    #[error("{}: unknown kind of file; valid are .toml, .urdf, .xml and .mjcf", one_line(.file, PLACE))]
    UnknownKind {
        /// The path as given.
        file: String,
    },
    /// The text is no TOML or XML, or has a key too many, too few or of the wrong type.
    #[error("{}: {}", place(.file, *.line), one_line(.message, PROBLEM))]
    Syntax {
        /// The file's name.
        file: String,
        /// Counted from one, where known.
        line: Option<usize>,
        /// What was found and what would be valid.
        message: String,
    },
    /// The text can be read, but is no possible robot.
    #[error("{}: {}: {}", place(.file, *.line), one_line(.subject, SUBJECT), one_line(.problem, PROBLEM))]
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
    /// All that is wrong, two problems at least.
    #[error("{}: {} problems:\n{}", one_line(.file, PLACE), .problems.len(), lines(.problems))]
    Several {
        /// The robot's file.
        file: String,
        /// In the order in which they were found.
        problems: Vec<ModelError>,
    },
}

/// Most problems that a message names.
const NAMED: usize = 20;

fn lines(problems: &[ModelError]) -> String {
    let mut lines: Vec<String> = problems.iter().take(NAMED).map(|problem| format!("  {problem}")).collect();
    if problems.len() > NAMED {
        lines.push(format!("  and {} more", problems.len() - NAMED));
    }
    lines.join("\n")
}

/// What was found wrong so far, so that one message may name all of it.
#[derive(Default)]
pub(crate) struct Problems(Vec<ModelError>);

impl Problems {
    pub(crate) fn add(&mut self, problem: ModelError) {
        match problem {
            ModelError::Several { problems, .. } => self.0.extend(problems),
            problem => self.0.push(problem),
        }
    }

    pub(crate) fn extend(&mut self, others: Problems) {
        self.0.extend(others.0);
    }

    /// The value, or none where it has a problem, which is added.
    pub(crate) fn keep<T>(&mut self, read: Result<T, ModelError>) -> Option<T> {
        read.map_err(|problem| self.add(problem)).ok()
    }

    /// # Errors
    /// All that was added.
    pub(crate) fn none(&mut self, file: &str) -> Result<(), ModelError> {
        match self.0.len() {
            0 => Ok(()),
            1 => Err(self.0.remove(0)),
            _ => Err(ModelError::Several { file: file.to_owned(), problems: std::mem::take(&mut self.0) }),
        }
    }
}

impl ModelError {
    /// What is wrong at a place of a text that cannot be read.
    pub(crate) fn syntax(file: &str, line: Option<usize>, message: impl Into<String>) -> Self {
        Self::Syntax { file: file.to_owned(), line, message: message.into() }
    }

    /// What is impossible about a robot.
    pub(crate) fn invalid(
        file: &str,
        line: Option<usize>,
        subject: impl Into<String>,
        problem: impl Into<String>,
    ) -> Self {
        Self::Invalid { file: file.to_owned(), line, subject: subject.into(), problem: problem.into() }
    }

    /// Whether the file could not be read at all, as opposed to having bad content.
    #[must_use]
    pub fn is_io(&self) -> bool {
        match self {
            Self::Unread { source, .. } => source.is_io(),
            Self::Folder { .. } => true,
            _ => false,
        }
    }
}

fn place(file: &str, line: Option<usize>) -> String {
    let file = one_line(file, PLACE);
    line.map_or_else(|| file.clone(), |line| format!("{file}:{line}"))
}
