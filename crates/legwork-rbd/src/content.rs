//! What a text holds, by its keys: one that holds another thing than is wanted is called by its name.

use toml::de::DeTable;

/// What the files hold of which a robot's simulation is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A robot, as TOML, URDF or MJCF.
    Model,
    /// What a URDF or MJCF does not say of its robot.
    SideFile,
    /// An experiment with a robot.
    Scenario,
    /// Many runs of scenarios.
    Study,
    /// A search for better settings.
    Tuning,
}

use Content::{Model, Scenario, SideFile, Study, Tuning};

/// Keys that no other content has; a side file has a model's but for its bodies.
const KEYS: [(Content, &[&str]); 4] = [
    (Model, &["base", "base_pitch", "bodies", "contacts", "feet", "frames", "gravity_mps2", "torso"]),
    (
        Scenario,
        &[
            "controller",
            "duration_s",
            "extends",
            "fall",
            "ground",
            "model",
            "pushes",
            "reference",
            "simulation",
            "start",
            "exoskeleton",
            "wearer",
        ],
    ),
    (Study, &["design", "morris_levels", "samples", "scenarios", "set"]),
    (Tuning, &["budget", "cases", "constraints", "held_out", "objective", "population", "sigma"]),
];

impl Content {
    /// What the `text` of the file `name` holds, where that is not what is `wanted`.
    pub fn other_than(wanted: Self, name: &str, text: &str) -> Option<Self> {
        let Ok(table) = DeTable::parse(text) else {
            let is_robot = text.contains("<robot") || text.contains("<mujoco");
            return (text.trim_start().starts_with('<') && is_robot).then_some(Model);
        };
        let has = |key: &str| table.get_ref().contains_key(key);
        if wanted != SideFile && name.ends_with(".legwork.toml") && !has("bodies") {
            return Some(SideFile);
        }
        let mut found = KEYS.iter().filter(|(_, keys)| keys.iter().any(|key| has(key))).map(|(content, _)| *content);
        let known = |content: Self| content == wanted || (content, wanted) == (Model, SideFile);
        if found.clone().any(known) { None } else { found.next() }
    }

    /// That the file `name` holds it and not what is `wanted`, and which command takes it.
    pub fn instead_of(self, wanted: Self, name: &str) -> String {
        let robot = name.replace(".legwork.toml", ".urdf");
        let takes = match (self, wanted) {
            (SideFile, Model | SideFile) => format!("it is read with {robot}, which is to be named"),
            (Model | SideFile, _) => format!("`legwork run SCENARIO --set model={robot}` simulates it"),
            (Scenario, _) => format!("`legwork run {name}` runs it"),
            (Study, _) => format!("`legwork study {name}` runs it"),
            (Tuning, _) => format!("`legwork tune {name}` runs it"),
        };
        format!("found {}, expected {}; {takes}", self.in_words(), wanted.in_words())
    }

    fn in_words(self) -> &'static str {
        match self {
            Model => "a robot model",
            SideFile => "the side file of a robot's URDF or MJCF",
            Scenario => "a scenario",
            Study => "a study",
            Tuning => "a tuning",
        }
    }
}
