//! The files that legwork writes, read by other people's libraries: `xtask/python/tables.py`.

use std::process::Command;

use crate::python::environment;
use crate::{Sum, cargo, counted, root, succeeds};

/// Installs the libraries where they are not there yet, and runs the tests.
pub(crate) fn test(sum: &mut Sum) {
    let python = match environment("python", "requirements.txt", &[]) {
        Ok(python) => python,
        Err(problem) => return sum.count(&format!("the libraries that read tables: {problem}"), false),
    };
    let mut built = cargo(&["build", "--release", "--quiet", "--package", "legwork-cli"], &[]);
    if !succeeds(&mut built) {
        return sum.count("the program that writes tables can be built", false);
    }
    let mut tests = Command::new(python);
    tests.arg(root().join("xtask/python/tables.py")).arg(root().join("target/release/legwork"));
    counted(tests, "the tests of tables", sum);
}
