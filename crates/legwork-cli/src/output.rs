//! Writing to stdout without a panic, and what can go wrong on the way to an exit code.

use std::fmt;
use std::io::{self, BufWriter, Stdout, Write};
use std::path::{Path, PathBuf};

use legwork::error::Error;

/// Why the program ends with an error.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A wrong file, key or value, or a file that could not be read.
    Input(Error),
    /// The output could not be written.
    Output {
        /// Where to.
        path: PathBuf,
        /// What went wrong.
        error: io::Error,
    },
}

impl Failure {
    /// 1 where the operating system is at fault, else 2.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Input(error) if !error.is_io() => 2,
            Self::Input(_) | Self::Output { .. } => 1,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => write!(f, "{error}"),
            Self::Output { path, error } if error.kind() == io::ErrorKind::BrokenPipe => {
                write!(f, "{}: closed before everything was written", path.display())
            }
            Self::Output { path, error } => write!(f, "{}: cannot be written: {error}", path.display()),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Input(error)
    }
}

/// Stdout, buffered; a closed pipe is an error, not a panic.
#[derive(Debug)]
pub(crate) struct Output {
    writer: BufWriter<Stdout>,
}

impl Output {
    /// The program's stdout.
    pub(crate) fn stdout() -> Self {
        Self { writer: BufWriter::new(io::stdout()) }
    }

    /// Writes a line.
    pub(crate) fn line(&mut self, text: impl fmt::Display) -> Result<(), Failure> {
        writeln!(self.writer, "{text}").map_err(on_stdout)
    }

    /// Writes what is buffered.
    pub(crate) fn flush(&mut self) -> Result<(), Failure> {
        self.writer.flush().map_err(on_stdout)
    }
}

fn on_stdout(error: io::Error) -> Failure {
    Failure::Output { path: "stdout".into(), error }
}

/// Says something on stderr; a closed stderr hears nothing.
pub(crate) fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Writes `content` to `path` through a temporary file beside it, so that a failure leaves no half file.
pub(crate) fn write_file(path: &Path, content: &str) -> Result<(), Failure> {
    let fail = |error| Failure::Output { path: path.to_owned(), error };
    let mut name = path.file_name().unwrap_or_default().to_owned();
    if path.is_dir() || name.is_empty() {
        return Err(fail(io::Error::new(io::ErrorKind::IsADirectory, "is a folder, expected a file name")));
    }
    name.push(".partial");
    let partial = path.with_file_name(name);
    std::fs::write(&partial, content).and_then(|()| std::fs::rename(&partial, path)).map_err(fail)
}
