//! Places that cannot be written to, and places that must not be harmed.

use std::fs;
use std::io::PipeWriter;
use std::process::Stdio;
use std::time::Duration;

use crate::{Done, Folder};

const RUN: [&str; 4] = ["run", "stand", "--duration", "0.02"];

fn run_with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&RUN[..], more].concat()
}

#[test]
fn unwritable_places_are_found_before_anything_runs() {
    let folder = Folder::new("unwritable");
    folder.file("file", "");
    fs::create_dir(folder.0.join("folder.csv")).unwrap();
    let long = format!("{}.csv", "n".repeat(5000));
    for (more, words) in [
        (["--report", "nowhere/a.html"], ["nowhere/a.html: cannot be written", "its folder does not exist"]),
        (["--report", "."], [".: cannot be written", "is a folder; give the name of a file"]),
        (["--report", "file/a.html"], ["file/a.html: cannot be written", "Not a directory"]),
        (["--log", "nowhere/a.csv"], ["nowhere/a.csv: cannot be written", "its folder does not exist"]),
        (["--log", "folder.csv"], ["folder.csv: cannot be written", "is a folder; give the name of a file"]),
        (["--log", &long], ["cannot be written", "name too long"]),
        (["--plots", "file"], ["file: cannot be written", "is a file; give the name of a folder"]),
        (["--plots", "file/plots"], ["file/plots: cannot be written", "Not a directory"]),
    ] {
        folder.refuses(1, &run_with(&more), &words);
    }
    folder.refuses(2, &run_with(&["--log", "a.txt"]), &["a.txt: a log ends in .csv or .parquet"]);
    folder.refuses(2, &run_with(&["--log", "folder"]), &["folder: a log ends in .csv or .parquet"]);
    folder.refuses(1, &["run", "stand", "walk", "--log", "nowhere/a.csv"], &["nowhere/a-stand.csv: cannot be written"]);
    assert_eq!(folder.names(), ["file", "folder.csv"], "nothing is left behind");
}

#[cfg(unix)]
#[test]
fn a_file_without_permission() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("permission");
    folder.file("a.csv", "precious");
    fs::set_permissions(folder.0.join("a.csv"), fs::Permissions::from_mode(0o400)).unwrap();
    if fs::OpenOptions::new().append(true).open(folder.0.join("a.csv")).is_ok() {
        return; // As root nothing is forbidden.
    }
    folder.refuses(1, &run_with(&["--log", "a.csv"]), &["a.csv: cannot be written", "ermission denied"]);
    assert_eq!(folder.text("a.csv"), "precious");
}

/// The report took the place of the device `/dev/full` itself: it was written beside it and renamed.
#[cfg(target_os = "linux")]
#[test]
fn a_report_on_a_full_disk_replaced_the_disk() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = Folder::new("full");
    let is_device = || fs::metadata("/dev/full").is_ok_and(|found| found.file_type().is_char_device());
    if !is_device() {
        return;
    }
    symlink("/dev/full", folder.0.join("full.csv")).unwrap();
    symlink("/dev/full", folder.0.join("full.parquet")).unwrap();
    for (option, path) in [("--report", "/dev/full"), ("--log", "full.csv"), ("--log", "full.parquet")] {
        let done = folder.legwork(&run_with(&[option, path]));
        assert_eq!(done.code, 1, "{}", done.err);
        assert!(done.err.contains(&format!("error: {path}: cannot be written: ")), "{}", done.err);
        assert!(done.err.contains("No space left on device"), "{}", done.err);
        assert!(done.out.starts_with("stand: "), "a log that cannot go on stops its run, which is told: {}", done.out);
    }
    assert!(is_device());
    assert_eq!(folder.names(), ["full.csv", "full.parquet"]);

    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let done = Done::from(folder.command(&RUN).stdout(full).output().unwrap());
    assert_eq!(
        (done.code, done.err.as_str()),
        (1, "error: stdout: cannot be written: No space left on device (os error 28)\n")
    );
}

#[cfg(unix)]
#[test]
fn a_link_to_a_report_stays_a_link() {
    let folder = Folder::new("link");
    folder.file("there/report.html", "old");
    std::os::unix::fs::symlink("there/report.html", folder.0.join("latest.html")).unwrap();
    folder.legwork(&run_with(&["--report", "latest.html"])).succeeds();
    assert!(folder.0.join("latest.html").is_symlink());
    assert!(folder.text("there/report.html").starts_with("<!DOCTYPE html>"));
    assert_eq!(fs::read_dir(folder.0.join("there")).unwrap().count(), 1);
}

/// A pipe that nobody reads any more.
fn closed_pipe() -> PipeWriter {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    // Another test's child may hold a copy of the reader from its fork to its exec.
    std::thread::sleep(Duration::from_millis(50));
    writer
}

/// With several scenarios the second was not run and nothing was written.
#[test]
fn a_closed_pipe_lost_the_log_and_the_report() {
    let folder = Folder::new("pipe");
    let refused = |arguments: &[&str]| {
        let child = folder.command(arguments).stdout(closed_pipe()).stderr(Stdio::piped()).spawn().unwrap();
        let done = Done::from(child.wait_with_output().unwrap());
        assert_eq!(done.code, 1, "{}", done.err);
        assert!(done.err.ends_with("error: stdout: cannot be written: closed by its reader\n"), "{}", done.err);
    };
    refused(&run_with(&["--log", "a.csv", "--report", "a.html"]));
    assert_eq!(folder.names(), ["a.csv", "a.html"]);
    refused(&["list"]);
    refused(&["show", "push"]);
    refused(&["inspect", "planar_humanoid", "--json"]);
}

#[test]
fn a_report_does_not_take_the_place_of_its_scenario_or_of_a_log() {
    let folder = Folder::new("clash");
    folder.file("my.toml", "seed = 1\n");
    folder.refuses(2, &["run", "my.toml", "--report", "my.toml"], &["--report: found my.toml", "give another"]);
    folder.refuses(2, &run_with(&["--log", "a.csv", "--report", "a.csv"]), &["--report: found a.csv", "give another"]);
    assert_eq!(folder.text("my.toml"), "seed = 1\n");
}

/// The second log replaced the first.
#[test]
fn one_scenario_twice_left_one_log() {
    let folder = Folder::new("twice");
    folder.file("there/stand.toml", "extends = \"stand\"\nseed = 1\n");
    folder.file("stand-2.toml", "extends = \"stand\"\nseed = 2\n");
    let arguments = ["run", "stand", "stand", "there/stand.toml", "stand-2.toml", "--duration", "0.02"];
    let done = folder.legwork(&[&arguments[..], &["--log", "a.csv", "--plots", "plots"]].concat()).succeeds();
    for name in ["a-stand.csv", "a-stand-2.csv", "a-stand-3.csv", "a-stand-2-2.csv"] {
        assert!(folder.0.join(name).is_file() && done.err.contains(&format!("log: {name}\n")), "{name}: {}", done.err);
    }
    let plots: Vec<_> = fs::read_dir(folder.0.join("plots")).unwrap().collect();
    assert!(!plots.is_empty() && plots.len() % 4 == 0, "{plots:?}");
    for name in ["stand", "stand-2", "stand-3", "stand-2-2"] {
        assert!(folder.0.join(format!("plots/{name}-torques.svg")).is_file(), "{plots:?}");
    }
}
