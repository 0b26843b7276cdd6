//! The settings of a scenario: unit, range, thesis symbol and source of each, in one table.
//!
//! Reading ([`crate::scenario_file`]) checks against it; `legwork list` and the comments of `legwork show` print it.
//! The defaults themselves stand in [`Scenario::default`].

mod table;
mod valid;

use toml::Value;

use crate::scenario::{Push, Scenario};

pub use table::SETTINGS;
pub use valid::in_words;
pub use valid::{Column, Valid};

/// The columns of a way-point and of a sampled CoM trajectory.
pub const TRAJECTORY_COLUMNS: [Column; 3] =
    [Column::new("t_s", 0.0, 3600.0), Column::new("x_m", -1e3, 1e3), Column::new("z_m", -1e3, 1e3)];

/// What a push must state; the rest of it has defaults.
pub const REQUIRED_OF_A_PUSH: [&str; 3] = ["force_n", "start_s", "duration_s"];

/// Bytes of a wrong path above which no similar one is looked for: it is no slip, and the search would take long.
const LONGEST: usize = 200;

/// One value of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Where it stands, as `controller.weights.feet`; `N` is the number of a list's element, as in `pushes.N.force_n`.
    pub path: &'static str,
    /// The thesis's symbol in ASCII (`C_f`), or nothing.
    pub symbol: &'static str,
    /// Its unit, or nothing where it has none.
    pub unit: &'static str,
    /// What it may be.
    pub valid: Valid,
    /// Where the default comes from; "fitted" to the thesis's results where the thesis does not give it.
    pub source: &'static str,
    /// What it means.
    pub help: &'static str,
}

/// The settings, and the tables of settings, that may not change while a run goes on, and why.
const FIXED: [(&str, &[&str]); 8] = [
    ("it names and describes the run", &["name", "description"]),
    ("the robot is made before the first tick", &["model", "fit", "locked", "wearer", "exoskeleton", "start"]),
    (
        "the run counts its ticks from the begin; it can be stopped at any of them",
        &["duration_s", "controller.period_s", "controller.known_delay_s"],
    ),
    ("it is drawn before the first tick", &["seed"]),
    (
        "the reference is planned before the first tick",
        &[
            "reference.generator",
            "reference.com",
            "reference.stance",
            "controller.planner.torso_angle_deg",
            "controller.planner.posture",
        ],
    ),
    ("the program has its variables and rows from the begin", &["controller.form", "controller.tracking"]),
    (
        "the ground's shape, and what the controller is told of it, are made before the first tick",
        &[
            "ground.slope_deg",
            "ground.cross_slope_deg",
            "ground.known",
            "ground.profile",
            "ground.unevenness_m",
            "ground.unevenness_spacing_m",
            "ground.unevenness_from_m",
            "ground.patches",
            "ground.relief_known",
            "controller.assumed_friction",
            "controller.assumed_slope_deg",
        ],
    ),
    (
        "the simulator and the metrics count from the begin",
        &[
            "simulation.period_s",
            "simulation.integrator",
            "simulation.model_error",
            "simulation.sensors",
            "simulation.actuators",
            "metrics",
        ],
    ),
];

/// Settings, and tables of settings, that mean something only where another setting has one of these values.
const USED_WITH: [(&str, &str, &[&str]); 16] = [
    ("reference", "controller.kind", &["momentum"]),
    ("reference.com", "reference.generator", &["steps", "stance"]),
    ("reference.step", "reference.generator", &["steps"]),
    ("reference.stance", "reference.generator", &["stance"]),
    ("reference.walker", "reference.generator", &["walker"]),
    ("controller.form", "controller.kind", &["momentum"]),
    ("controller.weights", "controller.kind", &["momentum"]),
    ("controller.weights.posture", "controller.tracking.posture", &["free", "cost", "equality"]),
    ("controller.planner.posture_gain", "controller.tracking.posture", &["free", "cost", "equality"]),
    ("controller.planner.posture", "controller.tracking.posture", &["free", "cost", "equality"]),
    ("controller.tracking", "controller.kind", &["momentum"]),
    ("controller.limits", "controller.kind", &["momentum"]),
    ("controller.hold", "controller.kind", &["hold"]),
    ("controller.lift_height_m", "controller.kind", &["momentum"]),
    ("controller.known_delay_s", "controller.kind", &["momentum"]),
    ("simulation.sensors.flag_force_n", "simulation.sensors.flag", &["force"]),
];

/// Whether a setting or table at the path `outer` is that at `path` or holds it.
pub fn holds(outer: &str, path: &str) -> bool {
    path.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Why the setting at `path` has no effect in the scenario `tree`; none where it has.
pub(crate) fn idle(tree: &mut Value, path: &str) -> Option<String> {
    USED_WITH.iter().filter(|(outer, ..)| holds(outer, path)).find_map(|(_, with, values)| {
        let found = at(tree, with).and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default();
        let quoted: Vec<String> = values.iter().map(|value| format!("\"{value}\"")).collect();
        (!values.contains(&found.as_str()))
            .then(|| format!("has no effect with {with} = \"{found}\"; it is there with {}", quoted.join(" or ")))
    })
}

/// The settings of `scenario` that are in use, as a tree: what identifies it.
pub(crate) fn in_use(scenario: &Scenario) -> Value {
    let mut tree = tree(scenario);
    let unused: Vec<&str> =
        USED_WITH.map(|(outer, ..)| outer).into_iter().filter(|outer| idle(&mut tree, outer).is_some()).collect();
    for outer in unused {
        remove(&mut tree, outer);
    }
    tree
}

/// Settings that came later, each with a value that is what there was before it could be said.
const LATER: [(&str, &str); 7] = [
    ("ground.cross_slope_deg", "0.0"),
    ("start.posture", "\"neutral\""),
    ("fit", "\"none\""),
    ("locked", "[]"),
    ("reference.stance.shift_s", "1.5"),
    ("reference.walker.unit_m", "1.0"),
    ("reference.walker.unit_s", "1.0"),
];

/// Takes settings that came later out of `tree` where they say what there was before.
pub(crate) fn remove_later(tree: &mut Value) {
    for (path, before) in LATER {
        if at(tree, path).is_some_and(|value| value.to_string() == before) {
            remove(tree, path);
        }
    }
}

/// Takes the setting or table at `path` out of `tree`.
pub(crate) fn remove(tree: &mut Value, path: &str) {
    let (table, key) = split(path);
    let table = if table.is_empty() { Some(tree) } else { at(tree, table) };
    table.and_then(Value::as_table_mut).map(|table| table.remove(key));
}

impl Setting {
    /// The setting at a path with or without numbers: `pushes.0.force_n`, `pushes.N.force_n`.
    pub fn find(path: &str) -> Option<&'static Self> {
        let pattern = pattern(path);
        SETTINGS.iter().find(|setting| setting.path == pattern)
    }

    /// The default; none where a value must be given.
    pub fn default(&self) -> Option<Value> {
        let required = REQUIRED_OF_A_PUSH.iter().any(|key| self.path == format!("pushes.N.{key}"));
        if required { None } else { at(&mut template(), &self.path.replace('N', "0")).cloned() }
    }

    /// What is valid, with the unit: `a number from 0 to 10 [s]`.
    pub fn valid_in_words(&self) -> String {
        if self.unit.is_empty() { self.valid.to_string() } else { format!("{} [{}]", self.valid, self.unit) }
    }

    /// Why the setting may not change while a run goes on; none where it may.
    pub fn fixed(&self) -> Option<&'static str> {
        FIXED.iter().find(|(_, paths)| paths.iter().any(|outer| holds(outer, self.path))).map(|(why, _)| *why)
    }

    /// The table that it stands in, as `controller.weights`; nothing at the top.
    pub fn table(&self) -> &'static str {
        split(self.path).0
    }

    /// The last key of the path.
    pub fn key(&self) -> &'static str {
        split(self.path).1
    }
}

/// The default scenario as a tree, with one default push as the pattern of all pushes.
pub(crate) fn template() -> Value {
    tree(&Scenario { pushes: vec![Push::default()], ..Scenario::default() })
}

/// A scenario as a tree.
///
/// # Panics
/// If the seed is above `i64::MAX`, the largest whole number of TOML.
pub fn tree(scenario: &Scenario) -> Value {
    Value::try_from(scenario).expect("a scenario can be written as TOML if its seed is at most i64::MAX")
}

/// The value at a dotted path; elements of lists by their number.
pub fn at<'a>(tree: &'a mut Value, path: &str) -> Option<&'a mut Value> {
    path.split('.').try_fold(tree, |value, key| match value {
        Value::Table(table) => table.get_mut(key),
        Value::Array(list) => list.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    })
}

/// The path with `N` for the numbers of elements.
fn pattern(path: &str) -> String {
    let key = |key| if is_number(key) { "N" } else { key };
    path.split('.').map(key).collect::<Vec<_>>().join(".")
}

fn is_number(key: &str) -> bool {
    !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_digit())
}

/// The setting or table whose path a wrong `path` probably means: the same key with another unit, the same key in
/// another place, or a similar spelling.
pub fn nearest(path: &str) -> Option<String> {
    if path.len() > LONGEST {
        return None;
    }
    let pattern = pattern(path);
    let (parent, key) = split(&pattern);
    let in_parent = |candidate: &&str| split(candidate).0 == parent;
    let same_quantity = |candidate: &&str| {
        let stem = stem(split(candidate).1);
        stem.is_some() && (stem == Some(key) || stem == self::stem(key))
    };
    let candidates = paths();
    let found = candidates
        .iter()
        .copied()
        .find(|candidate| in_parent(candidate) && same_quantity(candidate))
        .or_else(|| similar(&pattern, &candidates))
        .or_else(|| candidates.iter().copied().find(|candidate| split(candidate).1 == key))
        .or_else(|| candidates.iter().copied().find(same_quantity))?;
    let number = path.split('.').find(|key| is_number(key)).unwrap_or("0");
    Some(found.replace('N', number))
}

/// The closest spelling, if it is close.
fn similar<'a>(path: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let distance = |candidate: &str| strsim::damerau_levenshtein(path, candidate);
    let likeness = |candidate: &str| strsim::normalized_damerau_levenshtein(split(path).1, split(candidate).1);
    candidates
        .iter()
        .copied()
        .filter(|candidate| distance(candidate) <= path.len().div_ceil(4) && likeness(candidate) >= 0.5)
        .min_by_key(|candidate| distance(candidate))
}

/// The paths of all settings and of the tables that hold them.
fn paths() -> Vec<&'static str> {
    let mut paths = Vec::new();
    for setting in SETTINGS {
        let ends = setting.path.match_indices('.').map(|(dot, _)| dot).chain([setting.path.len()]);
        for path in ends.map(|end| &setting.path[..end]).filter(|path| !path.ends_with(".N")) {
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
    }
    paths
}

/// Parent and last key.
fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// The key without the unit at its end: `duration` of `duration_ms`.
fn stem(key: &str) -> Option<&str> {
    key.rsplit_once('_').map(|(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paths of all values below `value`.
    fn leaves(value: &Value, path: &str, found: &mut Vec<String>) {
        let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        match value {
            Value::Table(table) => table.iter().for_each(|(key, value)| leaves(value, &join(key), found)),
            Value::Array(list) if path == "pushes" => leaves(&list[0], &join("N"), found),
            _ => found.push(path.to_owned()),
        }
    }

    #[test]
    fn the_table_holds_every_value_of_a_scenario_and_no_other() {
        let mut values = Vec::new();
        leaves(&template(), "", &mut values);
        let mut settings: Vec<_> = SETTINGS.iter().map(|setting| setting.path.to_owned()).collect();
        values.sort();
        settings.sort();
        assert_eq!(values, settings);
    }

    #[test]
    fn every_default_is_valid() {
        for setting in SETTINGS {
            match setting.default() {
                Some(default) => assert_eq!(setting.valid.check(&default).as_ref(), Ok(&default), "{}", setting.path),
                None => assert!(REQUIRED_OF_A_PUSH.contains(&setting.key())),
            }
        }
    }

    #[test]
    fn the_unit_is_the_one_that_the_key_ends_in() {
        const SUFFIXES: [(&str, &str); 10] = [
            ("s", "s"),
            ("m", "m"),
            ("deg", "deg"),
            ("n", "N"),
            ("nm", "Nm"),
            ("mps", "m/s"),
            ("radps", "rad/s"),
            ("radps2", "rad/s²"),
            ("npm", "N/m"),
            ("nspm", "Ns/m"),
        ];
        for setting in SETTINGS {
            let suffix = setting.key().rsplit_once('_').map_or("", |(_, suffix)| suffix);
            match SUFFIXES.iter().find(|(known, _)| *known == suffix) {
                Some((_, unit)) => assert_eq!(setting.unit, *unit, "{}", setting.path),
                None => assert!(
                    setting.key().ends_with("_gain") || SUFFIXES.iter().all(|(_, unit)| setting.unit != *unit),
                    "{} has a unit that its key does not say",
                    setting.path
                ),
            }
        }
    }

    /// The alternatives of an enumeration are those that serde knows, but that some tasks cannot be off.
    #[test]
    fn alternatives_are_complete() {
        for setting in SETTINGS {
            let Valid::OneOf(alternatives) = setting.valid else { continue };
            let mut tree = template();
            *at(&mut tree, setting.path).expect("it is in the scenario") = Value::String("?".into());
            let refusal = tree.try_into::<Scenario>().expect_err("no such alternative").to_string();
            let known = refusal.lines().next().unwrap_or("").split('`').skip(3).step_by(2);
            let listed: Vec<_> = known.filter(|known| *known != "off" || alternatives.contains(known)).collect();
            assert_eq!(listed, alternatives, "{}", setting.path);
        }
    }

    #[test]
    fn every_setting_says_what_it_means_and_where_it_comes_from() {
        for setting in SETTINGS {
            assert!(setting.help.ends_with('.') && !setting.source.is_empty(), "{}", setting.path);
        }
    }

    #[test]
    fn the_nearest_path_is_found() {
        for (wrong, right) in [
            ("duration_ms", Some("duration_s")),
            ("duration", Some("duration_s")),
            ("speed_mps", Some("reference.com.speed_mps")),
            ("speed_kmh", Some("reference.com.speed_mps")),
            ("contoller", Some("controller")),
            ("contoller.weights.feet", Some("controller.weights.feet")),
            ("controler.weight.foot", Some("controller.weights.feet")),
            ("controller.limits.torque_knm", Some("controller.limits.torque_nm")),
            ("ground.slope_rad", Some("ground.slope_deg")),
            ("pushes.3.force", Some("pushes.3.force_n")),
            ("pushes.force_n", Some("pushes.0.force_n")),
            ("friction", Some("ground.friction")),
            ("controller.weights.abc", None),
            (&"seed".repeat(1_000_000), None),
            ("", None),
            ("..", None),
        ] {
            assert_eq!(nearest(wrong).as_deref(), right, "{wrong}");
        }
    }
}
