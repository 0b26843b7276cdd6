//! The invariants of ARCHITECTURE.md.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All Rust files below `folder` (or the one file), with their code: no comments, no unit tests.
fn sources(path: &str) -> Vec<(String, String)> {
    let path = root().join(path);
    let mut files = Vec::new();
    let mut open = vec![path];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path()));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).expect("a source file");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let code: String = code
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"))
                .map(|line| format!("{line}\n"))
                .collect();
            files.push((path.display().to_string(), code));
        }
    }
    assert!(!files.is_empty(), "no sources: has the code moved?");
    files
}

fn nobody_names(places: &[&str], words: &[&str]) {
    for (file, code) in places.iter().flat_map(|place| sources(place)) {
        for word in words {
            assert!(!code.contains(word), "{file} names {word}");
        }
    }
}

const SRC: &str = "crates/legwork/src";

/// The sources of the library crates.
const LIBRARIES: [&str; 8] = [
    SRC,
    "crates/legwork-rbd/src",
    "crates/legwork-qp/src",
    "crates/legwork-contract/src",
    "crates/legwork-control/src",
    "crates/legwork-sim/src",
    "crates/legwork-study/src",
    "crates/legwork-thesis/src",
];
const PROGRAMS: [&str; 3] = ["crates/legwork-report/src", "crates/legwork-cli/src", "xtask/src"];

#[test]
fn the_lower_crates_know_nothing_of_the_upper_ones() {
    for name in ["legwork-rbd", "legwork-qp"] {
        let manifest = fs::read_to_string(root().join(format!("crates/{name}/Cargo.toml"))).expect("a manifest");
        let dependencies = manifest.split("[dependencies]").nth(1).expect("a section");
        assert!(!dependencies.contains("legwork"), "{name} depends on a crate of ours");
    }
}

#[test]
fn nothing_is_unsafe() {
    for places in [&LIBRARIES[..], &PROGRAMS] {
        nobody_names(places, &["unsafe {", "unsafe fn", "unsafe impl"]);
    }
}

#[test]
fn no_function_of_the_platform_decides_bits() {
    let names =
        ["sin", "cos", "tan", "sin_cos", "exp", "ln", "log10", "atan2", "asin", "acos", "powf", "cbrt", "hypot"];
    let calls: Vec<String> = names.iter().flat_map(|name| [format!(".{name}("), format!("f64::{name}(")]).collect();
    let calls: Vec<&str> = calls.iter().map(String::as_str).collect();
    nobody_names(&LIBRARIES, &calls);
}

#[test]
fn time_is_measured_in_one_place_and_threads_are_in_another() {
    for (file, code) in LIBRARIES.iter().flat_map(|place| sources(place)) {
        if !file.ends_with("clock.rs") {
            assert!(!code.contains("Instant") && !code.contains("SystemTime"), "{file} reads a clock");
        }
        if !file.ends_with("legwork-study/src/parallel.rs") {
            assert!(!code.contains("thread") && !code.contains("rayon"), "{file} names threads");
        }
    }
}

/// One function has the largest size, refuses devices, and knows byte order marks; but the machine's own files are others.
#[test]
fn files_are_read_in_one_place() {
    for (file, code) in LIBRARIES.iter().chain(&PROGRAMS[..2]).flat_map(|place| sources(place)) {
        if !file.ends_with("legwork-rbd/src/file.rs") && !file.ends_with("bench/machine.rs") {
            for word in ["fs::read(", "read_to_string", "File::open", "read_to_end"] {
                assert!(!code.contains(word), "{file} reads a file by {word}");
            }
        }
    }
}

#[test]
fn every_source_file_says_what_it_holds() {
    for place in LIBRARIES.iter().chain(&PROGRAMS) {
        for (file, _) in sources(place) {
            let text = fs::read_to_string(&file).expect("a source file");
            assert!(text.starts_with("//!") || file.ends_with("tests.rs"), "{file} does not open with //!");
        }
    }
}

#[test]
fn the_code_map_names_every_module() {
    let map = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    for (file, _) in LIBRARIES.iter().flat_map(|place| sources(place)) {
        let name = Path::new(&file).file_stem().expect("a name").to_string_lossy().into_owned();
        let folder =
            Path::new(&file).parent().and_then(Path::file_name).expect("a folder").to_string_lossy().into_owned();
        let covered = ["lib", "mod", "error"].contains(&name.as_str())
            || ["settings", "scenario_file", "joints"].contains(&folder.as_str())
            || map.contains(&format!("`{name}"));
        assert!(covered, "ARCHITECTURE.md does not name {file}");
    }
}
