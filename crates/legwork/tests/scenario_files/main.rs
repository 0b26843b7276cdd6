//! Scenario files, `extends`, `--set`: what is read, and that each mistake is met with its place and a way out.

mod any;
mod data_files;
mod reads;
mod refuses;
mod refuses_sets;

use std::fs;
use std::path::PathBuf;

use legwork::error::Error;
use legwork::scenario::Scenario;
use legwork::scenario_file::{load, parse};

fn sets(assignments: &[&str]) -> Vec<String> {
    assignments.iter().map(|text| (*text).to_owned()).collect()
}

fn read(text: &str, assignments: &[&str]) -> Result<Scenario, Error> {
    parse(text, "my.toml", None, &sets(assignments)).map(|loaded| loaded.scenario)
}

/// The message begins with the place and holds all the words.
#[track_caller]
fn assert_says(result: Result<impl std::fmt::Debug, Error>, place: &str, words: &[&str]) {
    let message = result.expect_err("it is not valid").to_string();
    assert!(message.starts_with(&format!("{place}: ")), "place {place:?} in {message:?}");
    for word in words {
        assert!(message.contains(word), "{word:?} in {message:?}");
    }
}

#[track_caller]
fn refuses(text: &str, place: &str, words: &[&str]) {
    assert_says(read(text, &[]), place, words);
}

/// A `--set` on a scenario with one push.
#[track_caller]
fn refuses_set(assignment: &str, place: &str, words: &[&str]) {
    assert_says(load("push", &sets(&[assignment])), place, words);
}

/// A folder of its own, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("legwork-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("the folder for temporary files can be written to");
        Self(path)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().expect("it is in the folder")).expect("it can be made");
        fs::write(&path, content).expect("it can be written");
        path.display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
