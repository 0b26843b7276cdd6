//! The files that legwork writes, read by other people's libraries: `xtask/python/tables.py`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Sum, cargo, counted, root, say, succeeds};

/// Installs the libraries where they are not there yet, and runs the tests.
pub(crate) fn test(sum: &mut Sum) {
    let python = match environment() {
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

/// Python with the packages of `requirements.txt`, in an environment below `target`; its interpreter.
fn environment() -> Result<PathBuf, String> {
    let folder = root().join("target/python");
    let requirements = root().join("xtask/python/requirements.txt");
    let wanted = read(&requirements)?;
    let (python, installed) = (folder.join("bin/python"), folder.join("installed.txt"));
    if read(&installed).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    say("installing the packages of xtask/python/requirements.txt, which takes some minutes");
    let mut venv = Command::new("python3");
    venv.args(["-m", "venv"]).arg(&folder);
    if !succeeds(&mut venv) {
        return Err("python3 -m venv fails; it needs Python 3.11 or later with its module venv".to_owned());
    }
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--only-binary", ":all:", "-r"]).arg(&requirements);
    if !succeeds(&mut pip) {
        return Err("pip cannot install the packages of xtask/python/requirements.txt".to_owned());
    }
    fs::write(&installed, wanted).map_err(|error| format!("{}: {error}", installed.display()))?;
    Ok(python)
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}
