//! The examples of parts of one's own run, and say what their texts promise.

use std::path::Path;
use std::process::Command;

/// Runs an example, which `cargo test` has built beside this test.
fn output(name: &str) -> String {
    let test = std::env::current_exe().expect("a path");
    let folder = test.parent().and_then(Path::parent).expect("the profile's folder").join("examples");
    let run = Command::new(folder.join(name)).output().unwrap_or_else(|error| panic!("{name}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(run.status.success(), "{name}: {}{}", text(&run.stdout), text(&run.stderr));
    text(&run.stdout)
}

#[test]
fn every_part_of_a_run_can_be_ones_own() {
    for (name, says) in [
        ("own_loop", "after 2.0 s the centre of mass is at x = 1.276 m"),
        ("own_controller", "Completed, with joint torques up to 44 Nm"),
        ("own_generator", "Completed; the centre of mass moved between 0.930 and 0.970 m"),
        ("own_plant", "Completed; 500 records without a ground"),
        ("own_sink", "Completed; the largest joint torque was 220.0 Nm"),
    ] {
        let said = output(name);
        assert!(said.contains(says), "{name} says {said}, not {says}");
    }
}

#[test]
fn the_first_of_them_is_in_the_readme_and_each_is_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect(path);
    let code = read("examples/own_loop.rs");
    let body = code.split("fn main()").nth(1).expect("a main function");
    assert!(read("../../README.md").contains(body.trim_end()), "README.md has another own_loop");
    for name in ["own_loop", "own_controller", "own_generator", "own_plant", "own_sink"] {
        let lines = read(&format!("examples/{name}.rs")).lines().count();
        assert!(lines < 60, "{name} has {lines} lines");
    }
}
