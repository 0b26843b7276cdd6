//! The report in a real browser: it opens from disk, its script runs without an error, and the slider moves the robot.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::{Sum, cargo, root, say};

/// Where Chromium goes by which name.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Makes a report and looks at it.
pub(crate) fn test(sum: &mut Sum) {
    let Some(chromium) = find().or_else(install) else {
        if env::var_os("CI").is_some() {
            sum.count("no Chromium found, and none could be installed", false);
        } else {
            say("skipped: no Chromium found (install the package chromium to run this part)");
        }
        return;
    };
    let folder = root().join("target/xtask");
    let report = folder.join("report.html");
    let _ = std::fs::create_dir_all(&folder);
    let made = cargo(&["run", "--release", "--quiet", "--", "run", "walk", "push", "--report"], &[])
        .arg(&report)
        .stdout(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    sum.count("a report can be made", made);
    if !made {
        return;
    }
    for (name, query, expected) in [
        ("the script of the report runs", "", "data-animation=\"ready\""),
        ("the slider moves the robot", "#walk@2.00", "data-time=\"2.00\""),
    ] {
        let page = open(&chromium, &folder, &format!("file://{}{query}", report.display()));
        let found = page.as_ref().is_some_and(|page| page.contains(expected) && !page.contains("data-error"));
        sum.count(&format!("{name} ({expected} in the page)"), found);
    }
}

/// The page as it stands once its script has run.
fn open(chromium: &Path, folder: &Path, address: &str) -> Option<String> {
    let profile = folder.join("chromium-profile");
    let _ = std::fs::remove_dir_all(&profile);
    let output = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"])
        .args(["--disable-component-update", "--disable-sync", "--virtual-time-budget=3000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(address)
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Chromium on the path.
fn find() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// Installs Debian's Chromium where that is possible without asking.
fn install() -> Option<PathBuf> {
    let apt = |arguments: &[&str]| {
        Command::new("apt-get")
            .args(arguments)
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .status()
            .is_ok_and(|status| status.success())
    };
    say("installing chromium");
    (apt(&["update"]) && apt(&["install", "--yes", "--no-install-recommends", "chromium"])).then(find).flatten()
}
