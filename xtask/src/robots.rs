//! Robots of other people in their formats, beside the programs that those are of: `xtask/python/mjcf.py`.

use std::path::PathBuf;
use std::process::Command;

use crate::python::environment;
use crate::{Sum, cargo, counted, root, succeeds};

/// Installs the packages of `robots.txt` where they are not there yet, and runs the tests.
pub(crate) fn test(sum: &mut Sum) {
    let python = match environment("robots", "robots.txt", &["--no-deps"]) {
        Ok(python) => python,
        Err(problem) => return sum.count(&format!("robots of other people: {problem}"), false),
    };
    let Some(program) = example(sum) else { return };
    let mut tests = Command::new(python);
    // MuJoCo writes its log where it is started.
    tests.arg(root().join("xtask/python/mjcf.py")).arg(program).current_dir(root().join("target"));
    counted(tests, "the robots in MJCF", sum);
}

/// The program that tells the dynamics of a file.
fn example(sum: &mut Sum) -> Option<PathBuf> {
    let mut build = cargo(&["build", "--release", "--quiet", "--package", "legwork-rbd", "--example", "dynamics"], &[]);
    if !succeeds(&mut build) {
        sum.count("the program that tells the dynamics of a file can be built", false);
        return None;
    }
    Some(root().join("target/release/examples/dynamics"))
}
