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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_called_by_what_it_holds() {
        let (robot, side) = ("robot.toml", "robot.legwork.toml");
        for (wanted, name, text, expected) in [
            (Scenario, robot, "bodies = []", Some(Model)),
            (Model, robot, "duration_s = 1", Some(Scenario)),
            (Model, robot, "samples = 3", Some(Study)),
            (Model, robot, "budget = 3", Some(Tuning)),
            // Of several the one that is wanted, else the first.
            (Study, robot, "samples = 3\nduration_s = 1", None),
            (Model, robot, "samples = 3\nduration_s = 1", Some(Scenario)),
            // A side file has a model's keys but for its bodies, and its name tells it.
            (Model, side, "torso = 'trunk'", Some(SideFile)),
            (Model, side, "bodies = []", None),
            (SideFile, side, "torso = 'trunk'", None),
            (SideFile, side, "bodies = []", None),
            (Model, robot, "torso = 'trunk'", None),
            (Scenario, robot, "unknown = 1", None),
            // No TOML, but a URDF or nothing that is known.
            (Scenario, "robot.urdf", " <?xml?><robot/>", Some(Model)),
            (Scenario, "robot.urdf", "<html/>", None),
            (Scenario, "robot.urdf", "robot <robot", None),
        ] {
            assert_eq!(Content::other_than(wanted, name, text), expected, "{wanted:?} in {name}: {text}");
        }
    }

    #[test]
    fn what_stands_instead_is_told_with_the_command_that_takes_it() {
        for (found, wanted, expected) in [
            (Scenario, Model, "found a scenario, expected a robot model; `legwork run a.legwork.toml` runs it"),
            (Study, Scenario, "found a study, expected a scenario; `legwork study a.legwork.toml` runs it"),
            (Tuning, Study, "found a tuning, expected a study; `legwork tune a.legwork.toml` runs it"),
            (
                SideFile,
                Model,
                "found the side file of a robot's URDF or MJCF, expected a robot model; it is read with a.urdf, which is to be named",
            ),
            (
                Model,
                Scenario,
                "found a robot model, expected a scenario; `legwork run SCENARIO --set model=a.urdf` simulates it",
            ),
        ] {
            assert_eq!(found.instead_of(wanted, "a.legwork.toml"), expected);
        }
    }
}
