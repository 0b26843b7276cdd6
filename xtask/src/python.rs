//! Python with the packages that tests need, in environments below `target`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{root, say, succeeds};

/// The interpreter of the environment `target/NAME` that holds the packages of `xtask/python/REQUIREMENTS`; `options` are for pip.
pub(crate) fn environment(name: &str, requirements: &str, options: &[&str]) -> Result<PathBuf, String> {
    let folder = root().join("target").join(name);
    let listed = format!("xtask/python/{requirements}");
    let wanted = read(&root().join(&listed))?;
    let (python, installed) = (folder.join("bin/python"), folder.join("installed.txt"));
    if read(&installed).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    say(&format!("installing the packages of {listed}, which takes some minutes"));
    let mut venv = Command::new("python3");
    venv.args(["-m", "venv"]).arg(&folder);
    if !succeeds(&mut venv) {
        return Err("python3 -m venv fails; it needs Python 3.11 or later with its module venv".to_owned());
    }
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--only-binary", ":all:"]).args(options);
    if !succeeds(pip.arg("-r").arg(root().join(&listed))) {
        return Err(format!("pip cannot install the packages of {listed}"));
    }
    fs::write(&installed, wanted).map_err(|error| format!("{}: {error}", installed.display()))?;
    Ok(python)
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}
