//! Writing to stdout and to files without a panic or a half file, and what can go wrong on the way to an exit code.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Stdout, Write};
use std::path::{Path, PathBuf};

use legwork::error::Error;
use legwork_rbd::words::{PLACE, PROBLEM, one_line};
use legwork_report::document::Page;
use legwork_study::files::Unfinished;
use textwrap::{Options, WordSeparator, WordSplitter};

/// Columns of a terminal that everything fits into.
const WIDTH: usize = 80;

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
        problem: String,
    },
}

impl Failure {
    pub(crate) fn output(path: impl Into<PathBuf>, problem: impl fmt::Display) -> Self {
        Self::Output { path: path.into(), problem: problem.to_string() }
    }

    /// Why the file at `path` was not written.
    pub(crate) fn unwritten(path: &Path, error: Error) -> Self {
        match error {
            Error::Io { problem, .. } => Self::output(path, problem),
            other => Self::Input(other),
        }
    }

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
            Self::Output { path, problem } => {
                let (path, problem) = (path.display().to_string(), one_line(problem, PROBLEM));
                write!(f, "{}: cannot be written: {problem}", one_line(&path, PLACE))
            }
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
    match error.kind() {
        ErrorKind::BrokenPipe => Failure::output("stdout", "closed by its reader"),
        _ => Failure::output("stdout", error),
    }
}

/// Says something on stderr; a closed stderr hears nothing.
pub(crate) fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Warns on stderr, in one line of at most some hundred characters.
pub(crate) fn warn(text: &str) {
    say(&format!("warning: {}", one_line(text, PLACE + PROBLEM)));
}

/// Ends the program with what the command line's `error` says, or with the help that was asked for.
pub(crate) fn refuse(error: &clap::Error) -> ! {
    let text = error.render().to_string();
    let plain = |line: &str| line.len() <= PROBLEM && !line.contains(char::is_control);
    if error.use_stderr() && !text.lines().all(plain) {
        text.trim_end().lines().for_each(|line| say(&one_line(line, PROBLEM)));
        std::process::exit(error.exit_code());
    }
    error.exit()
}

/// The text in lines that fit a terminal; all but the first are indented.
pub(crate) fn folded(text: &str, indent: usize) -> String {
    let indent = " ".repeat(indent);
    let options = Options::new(WIDTH).subsequent_indent(&indent).break_words(false);
    let options = options.word_splitter(WordSplitter::NoHyphenation).word_separator(WordSeparator::AsciiSpace);
    textwrap::fill(text, options)
}

/// Finds out whether a file can be written at `path`, before the work that it is for.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    let tried = match path.metadata() {
        Ok(found) if found.is_dir() => return Err(Failure::output(path, "is a folder; give the name of a file")),
        Ok(found) if found.is_file() => OpenOptions::new().append(true).open(path).map(drop),
        // A device, or a pipe, which could not be opened without waiting for its reader.
        Ok(_) => Ok(()),
        Err(_) if path.is_symlink() => Ok(()),
        Err(_) => File::create(path).and_then(|_| fs::remove_file(path)),
    };
    tried.map_err(|error| match error.kind() {
        ErrorKind::NotFound => Failure::output(path, "its folder does not exist"),
        _ => Failure::output(path, error),
    })
}

/// Has `write` make the file at `path`: under another name beside it, which takes its place once all is written, so
/// that a failure harms nothing. A device or a pipe is written to directly.
pub(crate) fn write_file(path: &Path, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Failure> {
    let failed = |error| Failure::unwritten(path, error);
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        return write(path).map_err(failed);
    }
    let file = Unfinished::new(path).map_err(failed)?;
    write(file.written()).and_then(|()| file.finish()).map_err(failed)
}

/// Writes a text as [`write_file`] does.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    write_file(path, |path| fs::write(path, text).map_err(|error| Error::io(path, &error)))
}

/// The name of a page in the folder of its data.
pub(crate) const PAGE: &str = "report.html";

/// Writes a page into `folder`, and its figures into a folder of their own in it.
pub(crate) fn write_page(page: &Page, folder: &Path) -> Result<(), Failure> {
    let figures = folder.join("figures");
    fs::create_dir_all(&figures).map_err(|error| Error::io(&figures, &error))?;
    page.figures.iter().try_for_each(|(name, svg)| write_text(&figures.join(name), svg))?;
    write_text(&folder.join(PAGE), &page.html)
}

#[cfg(test)]
mod tests {
    use super::folded;

    #[test]
    fn long_lines_are_folded_between_words() {
        assert_eq!(folded("  short  text", 4), "  short  text");
        let text = folded(&["word"; 40].join(" "), 4);
        assert_eq!(text.lines().map(str::len).collect::<Vec<_>>(), [79, 78, 48]);
        assert!(text.lines().skip(1).all(|line| line.starts_with("    word")), "{text}");
        assert_eq!(folded(&format!("a {}", "x".repeat(99)), 2), format!("a\n  {}", "x".repeat(99)));
    }
}
