//! What a person sees.

use crate::Folder;

#[test]
fn without_arguments_the_experiments_of_the_thesis_are_repeated() {
    let folder = Folder::new("main-job");
    let done = folder.legwork(&[]).succeeds();
    assert_eq!(folder.names(), ["legwork-report.html"]);
    assert_eq!(done.err, "report: legwork-report.html\n");
    let report = folder.text("legwork-report.html");
    assert!(report.starts_with("<!DOCTYPE html>") && report.contains("walk") && report.contains("push"));
    let tables: Vec<&str> = done.out.split("\n\n").filter(|table| !table.trim().is_empty()).collect();
    assert_eq!(tables.len(), 2, "{}", done.out);
    assert!(
        tables[0].starts_with("walk: completed 8 s\n") && tables[1].starts_with("push: completed "),
        "{}",
        done.out
    );
    // The published figures as they are printed: mean and peak at the end of the line
    for (table, label, published) in [
        (tables[0], "CoM error [m]", "0.013 0.028"),
        (tables[0], "force on a contact point [N]", "356.1 1027"),
        (tables[0], "single support", "0.35"),
        (tables[1], "joint torque [Nm]", "59.6 220"),
        (tables[1], "recovery time [s]", "4.2"),
    ] {
        let line = table.lines().find(|line| line.trim_start().starts_with(label)).unwrap_or_else(|| panic!("{label}"));
        let words = line.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.ends_with(&format!(" {published}")), "{line}");
    }
    assert_fits(&done.out);
}

fn assert_fits(text: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?}");
    }
}

/// The label of the simulated force was wider than its column and pushed its numbers aside.
#[test]
fn numbers_stand_under_their_headings() {
    let folder = Folder::new("columns");
    let done = folder.legwork(&["run", "push", "--duration", "1"]).succeeds();
    let end = |line: &str| line.chars().count();
    let heading = done.out.lines().find(|line| line.trim_start().starts_with("mean")).expect("a heading");
    let measured = heading.find("peak").unwrap() + 4;
    for label in ["simulated force on a contact point [N]", "steps"] {
        let line = done.out.lines().find(|line| line.trim_start().starts_with(label)).expect("a row");
        let column = if label == "steps" { heading.find("mean").unwrap() + 4 } else { measured };
        assert_eq!(end(line), column, "{heading}\n{line}");
    }
    assert_fits(&done.out);
}

#[test]
fn a_fall_comes_first_and_changed_settings_are_told() {
    let folder = Folder::new("fall");
    let done = folder.legwork(&["run", "push", "--set", "pushes.0.force_n=1500"]).succeeds();
    assert!(done.out.starts_with("push: fell at "), "{}", done.out);
    assert!(done.out.contains("the thesis's figures are for the built-in scenario, not for these settings"));
    assert_fits(&done.out);
    let row = done.out.lines().find(|line| line.contains("recovery time")).unwrap();
    assert_eq!(row.split_whitespace().collect::<Vec<_>>().join(" "), "recovery time [s] \u{2013} 4.2");

    let done = folder.legwork(&["run", "walk-slope", "--duration", "0.2"]).succeeds();
    assert!(!done.out.contains("thesis"), "nothing is published of it: {}", done.out);
}
