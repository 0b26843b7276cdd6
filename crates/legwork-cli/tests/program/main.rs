//! The program as its users meet it: started as a process, in a folder of its own.

mod bench;
mod commands;
mod compare;
mod files;
mod inspect;
mod interrupt;
mod json;
mod limits;
mod logs;
mod models;
mod outputs;
mod reproduce;
mod scenarios;
mod showing;
mod study;
mod tables;
mod tuning;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

const MODEL: &str = include_str!("../../../../models/planar_humanoid.toml");

/// A folder of its own, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("legwork-program-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the folder for temporary files can be written to");
        Self(path)
    }

    /// Writes a file, in a folder below where its name has one.
    fn file(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().expect("it is in the folder")).expect("it can be made");
        fs::write(path, content).expect("it can be written");
    }

    #[track_caller]
    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of the files and folders in it, hidden ones too.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("it is there");
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program in this folder.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_legwork"));
        command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        command
    }

    #[track_caller]
    fn legwork(&self, arguments: &[&str]) -> Done {
        Done::from(self.command(arguments).output().expect("the program can be started"))
    }

    /// Runs the program, which must end well, and reads its output as JSON Lines.
    #[track_caller]
    fn json(&self, arguments: &[&str]) -> Vec<Value> {
        let done = self.legwork(arguments).succeeds();
        done.out.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
    }

    /// The program refuses with `code`, prints nothing, and says one paragraph with all of the `words`.
    #[track_caller]
    fn refuses(&self, code: i32, arguments: &[&str], words: &[&str]) {
        let done = self.legwork(arguments);
        assert_eq!((done.code, done.out.as_str()), (code, ""), "{arguments:?}: {}", done.err);
        let message = done.err.strip_prefix("error: ").unwrap_or_else(|| panic!("{arguments:?}: {}", done.err));
        assert!(!message.trim_end().contains(char::is_control), "more than a line: {message}");
        assert!(message.chars().count() < 750, "no short message: {message}");
        for word in words {
            assert!(message.contains(word), "{word:?} is not in {message:?}");
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// What came of a call.
#[derive(Debug)]
struct Done {
    code: i32,
    out: String,
    err: String,
}

impl From<Output> for Done {
    #[track_caller]
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("output is text");
        let done = Self {
            code: output.status.code().expect("ended by itself"),
            out: text(output.stdout),
            err: text(output.stderr),
        };
        assert!(!done.err.contains("panicked"), "{}", done.err);
        done
    }
}

impl Done {
    #[track_caller]
    fn succeeds(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.err);
        self
    }
}
