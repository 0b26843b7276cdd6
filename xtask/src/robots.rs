//! Robots of other people in their formats, beside the programs that those are of: `xtask/python/mjcf.py`, `xtask/python/urdf.py`.

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
    for (script, example, what) in
        [("mjcf.py", "dynamics", "the robots in MJCF"), ("urdf.py", "states", "the robots in URDF")]
    {
        let Some(program) = built(example, sum) else { return };
        let mut tests = Command::new(&python);
        // MuJoCo writes its log where it is started.
        tests.arg(root().join("xtask/python").join(script)).arg(program).current_dir(root().join("target"));
        counted(tests, what, sum);
    }
}

/// An example of legwork-rbd that tells the dynamics of files.
fn built(example: &str, sum: &mut Sum) -> Option<PathBuf> {
    let mut build = cargo(&["build", "--release", "--quiet", "--package", "legwork-rbd", "--example", example], &[]);
    if !succeeds(&mut build) {
        sum.count(&format!("the program {example} that tells the dynamics of files can be built"), false);
        return None;
    }
    Some(root().join("target/release/examples").join(example))
}
