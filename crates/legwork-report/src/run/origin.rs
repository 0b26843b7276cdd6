//! Where a run comes from: the settings that differ from the defaults, and the command that repeats it.

use legwork::scenario::{Push, Scenario};
use legwork::settings::{SETTINGS, Setting};
use legwork::{library, scenario_file};
use serde_json::Value;

/// A setting that two scenarios differ in.
#[derive(Clone, Debug)]
pub(super) struct Difference {
    pub(super) path: String,
    pub(super) setting: &'static Setting,
    /// The run's value.
    pub(super) value: String,
    /// The other's.
    pub(super) other: String,
}

/// How a run is repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Command {
    pub(super) line: String,
    /// Whether the scenario must be saved as a file first.
    pub(super) needs_file: bool,
}

/// What differs from the defaults, each push from a default push. Name and description are left out.
pub(super) fn differences_from_defaults(scenario: &Scenario) -> Vec<Difference> {
    let pushes = vec![Push::default(); scenario.pushes.len()];
    differences(scenario, &Scenario { pushes, ..Scenario::default() })
}

/// What differs from the built-in scenario of the same name, if there is one with as many pushes.
pub(super) fn differences_from_built_in(scenario: &Scenario) -> Option<Vec<Difference>> {
    let name = library::scenario_names().find(|name| *name == scenario.name)?;
    let built_in = scenario_file::load(name, &[]).ok()?.scenario;
    (built_in.pushes.len() == scenario.pushes.len()).then(|| differences(scenario, &built_in))
}

fn differences(scenario: &Scenario, other: &Scenario) -> Vec<Difference> {
    let tree = |scenario: &Scenario| serde_json::to_value(scenario).unwrap_or_default();
    let (ours, theirs) = (tree(scenario), tree(other));
    let mut found = Vec::new();
    for setting in SETTINGS.iter().filter(|setting| !["name", "description"].contains(&setting.path)) {
        let several = if setting.path.contains(".N.") { scenario.pushes.len() } else { 1 };
        for index in 0..several {
            let path = setting.path.replace(".N.", &format!(".{index}."));
            let pointer = format!("/{}", path.replace('.', "/"));
            let [value, other] = [&ours, &theirs].map(|tree| tree.pointer(&pointer).map(plain).unwrap_or_default());
            if value != other {
                found.push(Difference { path, setting, value, other });
            }
        }
    }
    found
}

/// A value as `--set` takes it.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// The command that repeats a run of `scenario`.
pub(super) fn command(scenario: &Scenario) -> Command {
    match differences_from_built_in(scenario) {
        Some(differences) => {
            let sets =
                differences.iter().map(|set| format!(" --set {}", quoted(&format!("{}={}", set.path, set.value))));
            Command { line: format!("legwork run {}{}", scenario.name, sets.collect::<String>()), needs_file: false }
        }
        None => {
            let file = quoted(&format!("{}.toml", crate::file_name(&scenario.name)));
            Command { line: format!("legwork run {file}"), needs_file: true }
        }
    }
}

/// A word of a shell's command line.
fn quoted(word: &str) -> String {
    let harmless = |c: char| c.is_ascii_alphanumeric() || "._+-/=:,".contains(c);
    if word.chars().all(harmless) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_built_in_scenario_is_repeated_with_its_changes() {
        let sets = ["pushes.0.force_n=655", "reference.step.replan=in-swing", "pushes.0.point_m=[0.1, 0.0, 0.0]"];
        let sets: Vec<String> = sets.map(str::to_owned).into();
        let scenario = scenario_file::load("push", &sets).expect("a built-in scenario").scenario;
        let Command { line, needs_file } = command(&scenario);
        assert!(!needs_file);
        assert!(line.starts_with("legwork run push --set "), "{line}");
        for set in [
            "--set pushes.0.force_n=655.0",
            "--set reference.step.replan=in-swing",
            "--set 'pushes.0.point_m=[0.1,0.0,0.0]'",
        ] {
            assert!(line.contains(set), "{line}");
        }
        let again: Vec<String> = differences_from_built_in(&scenario)
            .expect("built-in")
            .iter()
            .map(|set| format!("{}={}", set.path, set.value))
            .collect();
        assert_eq!(scenario_file::load("push", &again).expect("valid").scenario, scenario);
    }

    #[test]
    fn a_scenario_of_ones_own_is_repeated_from_a_file() {
        let scenario = Scenario { name: "it's mine".into(), ..Scenario::default() };
        assert_eq!(command(&scenario), Command { line: "legwork run it-s-mine.toml".into(), needs_file: true });
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }

    #[test]
    fn the_defaults_do_not_differ_from_themselves() {
        assert!(differences_from_defaults(&Scenario::default()).is_empty());
        let walk = scenario_file::load("walk", &[]).expect("a built-in scenario").scenario;
        let paths: Vec<_> = differences_from_defaults(&walk).into_iter().map(|set| set.path).collect();
        assert_eq!(paths, ["duration_s", "reference.com.trajectory", "reference.com.speed_mps"]);
    }
}
