//! The scenarios that a study starts from, and how settings of scenario and model are varied.

use legwork_rbd::ModelError;
use legwork_rbd::words::list;
use toml::Value;

use legwork::Robot;
use legwork::episode::{self, Episode};
use legwork::error::Error;
use legwork::scenario::{CommandedSpeed, GeneratorKind, Scenario};
use legwork::scenario_file::{self, Loaded};
use legwork::settings::{self, Setting, Valid};
use legwork::wearer;

/// The paths into the robot's model begin with this; all others are settings of the scenario.
const MODEL: &str = "model.";

/// What names a scenario or the files that it was read with: these cannot be varied.
const FIXED: [&str; 4] = ["name", "description", "model", "reference.com.file"];

/// A scenario with its model and all else that a run needs.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The scenario.
    pub scenario: Scenario,
    /// The robot.
    pub model: Robot,
    /// The rows of the CoM file, where the scenario names one.
    pub samples: Vec<[f64; 3]>,
}

/// What a factor does to the values at its paths.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// They become this.
    To(Value),
    /// They are multiplied by this; so is each number of a list.
    Times(f64),
}

/// A scenario that is varied: a [`Variant`], and the model as a tree of values.
#[derive(Clone, Debug)]
pub struct Base {
    variant: Variant,
    scenario_tree: Value,
    model_tree: Value,
}

impl Base {
    /// The base that a scenario is, as loaded.
    ///
    /// # Errors
    /// The model or the CoM samples cannot be read, or the start pose cannot be taken.
    pub fn new(loaded: &Loaded) -> Result<Self, Error> {
        let (model, samples) = (loaded.model()?, loaded.samples()?);
        let variant = Variant { scenario: loaded.scenario.clone(), model, samples };
        variant.check().map_err(|error| loaded.locate(error))?;
        let model_tree = toml::from_str(&variant.model.to_toml()).expect("a model is written as TOML");
        Ok(Self { scenario_tree: settings::tree(&variant.scenario), variant, model_tree })
    }

    /// Reads a built-in scenario or a file; see [`scenario_file::load`].
    ///
    /// # Errors
    /// As [`scenario_file::load`] and [`Base::new`].
    pub fn load(name_or_path: &str, sets: &[String]) -> Result<Self, Error> {
        Self::new(&scenario_file::load(name_or_path, sets)?)
    }

    /// It as it stands.
    pub fn variant(&self) -> &Variant {
        &self.variant
    }

    /// Its scenario's name.
    pub fn name(&self) -> &str {
        &self.variant.scenario.name
    }

    /// The constant speed at which it walks.
    ///
    /// # Errors
    /// It does not walk, or not at a constant speed.
    pub fn walks(&self) -> Result<CommandedSpeed, Error> {
        let reference = &self.variant.scenario.reference;
        let commanded = reference.commanded_speed();
        if let Some(commanded) = commanded.filter(|commanded| commanded.speed_mps != 0.0) {
            return Ok(commanded);
        }
        let (path, valid) = match (commanded, reference.generator) {
            (Some(zero), _) => (zero.path, "a speed that is not zero"),
            (None, GeneratorKind::Steps) => ("reference.com.trajectory", "\"constant-velocity\" with a speed"),
            (None, GeneratorKind::Walker) => ("reference.walker.speeds", "an empty list with a speed_mps"),
            (None, GeneratorKind::Stance) => ("reference.generator", "\"steps\" or \"walker\" with a speed"),
        };
        let problem = format!("found a scenario that does not walk at a constant speed; valid is {valid}");
        Err(Error::invalid(format!("{}: {path}", self.name()), problem))
    }

    /// The base with `commanded` made another speed [m/s].
    ///
    /// # Errors
    /// As [`Base::vary`].
    pub fn at_speed(&self, commanded: CommandedSpeed, speed_mps: f64) -> Result<Self, Error> {
        let speed = Change::To(Value::Float(speed_mps));
        let variant = self.vary([(commanded.path, &speed)])?;
        let scenario_tree = settings::tree(&variant.scenario);
        Ok(Self { variant, scenario_tree, model_tree: self.model_tree.clone() })
    }

    /// The largest torque limit that any joint of it has [Nm]: the controller's, or the strongest joint's where that is lower.
    pub fn torque_limit_nm(&self) -> f64 {
        self.variant.scenario.controller.limits.torque_nm.min(self.strongest_joint_nm())
    }

    /// The most that the model gives a joint [Nm]; infinite where it gives some joint no limit.
    pub fn strongest_joint_nm(&self) -> f64 {
        let model = &self.variant.model;
        model.actuated().map(|dof| model.dofs[dof].effort_limit).fold(0.0, f64::max)
    }

    /// The value at `path`: of a setting (`ground.friction`) or of the model (`model.bodies.torso.mass_kg`, with bodies
    /// and contacts by name; angles in radians).
    ///
    /// # Errors
    /// There is none; names what is near.
    pub fn value(&self, path: &str) -> Result<Value, Error> {
        let value = match path.strip_prefix(MODEL) {
            Some(rest) => find(&self.model_tree, rest),
            None => find(&self.scenario_tree, path),
        };
        let value = value.ok_or_else(|| self.unknown(path))?;
        if FIXED.contains(&path) {
            return Err(Error::invalid(path, "cannot be varied; give each of them a scenario of its own"));
        }
        if value.is_table() {
            let problem = "is a table; valid is the path of one value in it";
            return Err(Error::invalid(path, problem));
        }
        Ok(value.clone())
    }

    /// The base with each path changed; [`Base::value`] says what paths there are.
    ///
    /// # Errors
    /// A path is unknown, or scenario or model are not valid with these values. The start pose is not tried.
    pub fn vary<'a>(&self, changes: impl IntoIterator<Item = (&'a str, &'a Change)>) -> Result<Variant, Error> {
        let mut variant = self.variant.clone();
        let mut scenario = self.scenario_tree.clone();
        let mut model = None;
        let mut last = String::new();
        for (path, change) in changes {
            self.value(path)?;
            let slot = match path.strip_prefix(MODEL) {
                Some(rest) => at(model.get_or_insert_with(|| self.model_tree.clone()), rest),
                None => settings::at(&mut scenario, path),
            };
            let slot = slot.ok_or_else(|| self.unknown(path))?;
            let whole = matches!(Setting::find(path), Some(Setting { valid: Valid::Integer { .. }, .. }));
            match change {
                // They have defaults, and keys that they must have.
                Change::To(pushes) if path == "pushes" => *slot = scenario_file::pushes(pushes)?,
                _ => *slot = change.apply(slot, whole).map_err(|problem| Error::invalid(path, problem))?,
            }
            if path.starts_with(MODEL) {
                path.clone_into(&mut last);
            }
        }
        variant.scenario = scenario_file::check(scenario, self.name())?;
        if let Some(tree) = model {
            let text = toml::to_string(&tree).expect("values can be written as TOML");
            variant.model = Robot::from_toml(&text, &variant.model.name).map_err(|error| match error {
                // The line is one of a text that nobody has seen.
                ModelError::Invalid { subject, problem, .. } => Error::invalid(last, format!("{subject}: {problem}")),
                ModelError::Syntax { message, .. } => Error::invalid(last, message),
                other => other.into(),
            })?;
        }
        let (before, after) = (&self.variant.scenario, &variant.scenario);
        if (&before.wearer, &before.exoskeleton) != (&after.wearer, &after.exoskeleton) {
            wearer::refit(&mut variant.model, before, after)?;
        }
        Ok(variant)
    }

    fn unknown(&self, path: &str) -> Error {
        let problem = match path.strip_prefix(MODEL) {
            Some(rest) => unknown_in(&self.model_tree, rest),
            None => {
                let near = settings::nearest(path).map_or(String::new(), |near| format!("did you mean {near}? "));
                format!("unknown; {near}`legwork list settings` has all; the model's begin with {MODEL}bodies")
            }
        };
        Error::invalid(path, problem)
    }
}

impl Variant {
    /// Whether it can be run: the start pose can be taken, and so on.
    ///
    /// # Errors
    /// As [`Episode::new`].
    pub fn check(&self) -> Result<(), Error> {
        Episode::new(&self.scenario, &self.model, &self.samples).map(drop)
    }

    /// Hash of all that a run of it depends on.
    pub fn input_hash(&self) -> u128 {
        episode::input_hash(&self.scenario, &self.model, &self.samples)
    }
}

impl Change {
    /// The value that `old` becomes; `whole` asks for a whole number.
    fn apply(&self, old: &Value, whole: bool) -> Result<Value, String> {
        match (self, old) {
            (Self::To(Value::Float(new)), _) if whole => {
                if new.fract() == 0.0 && new.abs() < 1e15 {
                    Ok(Value::Integer(*new as i64))
                } else {
                    Err(format!("found {new}; valid is a whole number"))
                }
            }
            (Self::To(new), _) => Ok(new.clone()),
            (Self::Times(_), Value::Array(list)) => {
                list.iter().map(|element| self.apply(element, whole)).collect::<Result<_, _>>().map(Value::Array)
            }
            (Self::Times(factor), Value::Integer(old)) if whole => {
                Ok(Value::Integer((*old as f64 * factor).round() as i64))
            }
            (Self::Times(factor), Value::Integer(old)) => Ok(Value::Float(*old as f64 * factor)),
            (Self::Times(factor), Value::Float(old)) => Ok(Value::Float(old * factor)),
            (Self::Times(_), other) => {
                Err(format!("found {}; only numbers can be multiplied", settings::in_words(other)))
            }
        }
    }
}

/// The value at a dotted path; elements of lists by number or, where they have one, by `name`.
fn at<'a>(tree: &'a mut Value, path: &str) -> Option<&'a mut Value> {
    path.split('.').try_fold(tree, step)
}

fn step<'a>(value: &'a mut Value, key: &str) -> Option<&'a mut Value> {
    match value {
        Value::Array(list) => {
            let index = index(list, key)?;
            list.get_mut(index)
        }
        other => other.get_mut(key),
    }
}

/// As [`at`], of a tree that stays as it is.
fn find<'a>(tree: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.').try_fold(tree, |value, key| match value {
        Value::Array(list) => list.get(index(list, key)?),
        other => other.get(key),
    })
}

fn index(list: &[Value], key: &str) -> Option<usize> {
    key.parse().ok().or_else(|| list.iter().position(|element| name_of(element) == Some(key)))
}

fn name_of(element: &Value) -> Option<&str> {
    element.get("name").and_then(Value::as_str)
}

/// What is wrong with a path into the model, with what would be valid at the first wrong key.
fn unknown_in(tree: &Value, path: &str) -> String {
    let (mut tree, mut place) = (tree, "model".to_owned());
    for key in path.split('.') {
        let Some(found) = find(tree, key) else { break };
        (tree, place) = (found, format!("{place}.{key}"));
    }
    let valid: Vec<String> = match tree {
        Value::Table(table) => table.keys().cloned().collect(),
        Value::Array(list) => {
            list.iter().enumerate().map(|(i, e)| name_of(e).map_or(i.to_string(), str::to_owned)).collect()
        }
        _ => return format!("unknown; {place} is a single value"),
    };
    format!("unknown; valid in {place} are {}", list(valid))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk() -> Base {
        Base::load("walk", &[]).expect("it is built in")
    }

    fn vary(changes: &[(&str, Change)]) -> Result<Variant, Error> {
        walk().vary(changes.iter().map(|(path, change)| (*path, change)))
    }

    fn refusal(changes: &[(&str, Change)]) -> String {
        vary(changes).expect_err("it is not valid").to_string()
    }

    #[test]
    fn settings_and_the_model_can_be_varied() {
        let changes = [
            ("ground.friction", Change::To(Value::Float(0.4))),
            ("controller.weights.feet", Change::Times(2.0)),
            ("seed", Change::To(Value::Float(7.0))),
            ("controller.form", Change::To(Value::String("slack".into()))),
            ("model.bodies.torso.mass_kg", Change::Times(1.5)),
            ("model.contacts.left_foot.position_m", Change::Times(1.01)),
            ("model.bodies.torso.joint.upper_rad", Change::To(Value::Float(3.0))),
        ];
        let (base, variant) = (walk(), vary(&changes).expect("all valid"));
        let Variant { scenario, model, .. } = &variant;
        assert_eq!((scenario.ground.friction, scenario.seed), (0.4, 7));
        assert_eq!(scenario.controller.weights.feet, 2.0 * base.variant().scenario.controller.weights.feet);
        assert_eq!(scenario.controller.form, legwork::scenario::QpForm::Slack);
        let before = &base.variant().model;
        assert_eq!(model.bodies[model.torso].mass, 1.5 * before.bodies[before.torso].mass);
        assert_eq!(model.contacts[1].position, before.contacts[1].position * 1.01);
        assert_eq!(model.contacts[0], before.contacts[0]);
        assert_eq!(model.dofs.iter().find(|dof| dof.name == "right_hip").map(|dof| dof.upper), Some(3.0));
    }

    #[test]
    fn a_list_of_pushes_has_the_defaults_of_a_file() {
        let pushes = |text: &str| {
            let table: toml::Table = text.parse().expect("it is TOML");
            [("pushes", Change::To(table["pushes"].clone()))]
        };
        let given = "pushes = [{ force_n = 400, start_s = 1, duration_s = 0.2 }]";
        let variant = vary(&pushes(given)).expect("a valid push");
        let read = scenario_file::load("walk", &[given.replacen(' ', "", 2)]).expect("the same on the command line");
        assert_eq!(variant.scenario.pushes, read.scenario.pushes);
        assert_eq!(variant.scenario.pushes.len(), 1);
        let short = refusal(&pushes("pushes = [{ force_n = 400 }]"));
        assert!(short.starts_with("pushes.0: start_s is missing"), "{short}");
        let misspelt = refusal(&pushes("pushes = [{ force = 400 }]"));
        assert!(misspelt.starts_with("pushes.0.force: unknown; did you mean pushes.0.force_n?"), "{misspelt}");
        let number = refusal(&[("pushes", Change::To(Value::Integer(3)))]);
        assert!(number.starts_with("pushes: found 3; valid is a list of tables"), "{number}");
    }

    #[test]
    fn nothing_changes_without_changes() {
        let variant = vary(&[]).expect("it is the base");
        assert_eq!((&variant.scenario, &variant.model), (&walk().variant().scenario, &walk().variant().model));
        // Nor does the model by the way over its text.
        let same = vary(&[("model.gravity_mps2", Change::Times(1.0))]).expect("it is the base");
        assert_eq!(same.model, walk().variant().model);
    }

    #[test]
    fn what_is_not_valid_is_named() {
        let far = refusal(&[("ground.friction", Change::To(Value::Float(99.0)))]);
        assert_eq!(far, "ground.friction: found 99.0; valid is a number from 0 to 10");
        let near = refusal(&[("controler.weight.foot", Change::Times(2.0))]);
        assert!(near.contains("controler.weight.foot: unknown; did you mean controller.weights.feet?"), "{near}");
        let body = refusal(&[("model.bodies.toros.mass_kg", Change::Times(2.0))]);
        assert!(body.ends_with("valid in model.bodies are right_shank, right_thigh, torso, left_thigh, left_shank"));
        let mass = refusal(&[("model.bodies.torso.mass_kg", Change::To(Value::Float(-1.0)))]);
        assert_eq!(mass, "model.bodies.torso.mass_kg: body \"torso\": mass -1 kg is negative");
        let kind = refusal(&[("model.bodies.torso.mass_kg", Change::To(Value::String("heavy".into())))]);
        assert!(kind.starts_with("model.bodies.torso.mass_kg: invalid type"), "{kind}");
        let text = refusal(&[("model.name", Change::Times(2.0))]);
        assert!(text.contains("only numbers can be multiplied"), "{text}");
        for (path, change, said) in [
            ("model", "nope", "model: cannot be varied"),
            ("controller.limits", "nope", "controller.limits: is a table"),
        ] {
            assert!(refusal(&[(path, Change::To(Value::String(change.into())))]).starts_with(said));
        }
        assert_eq!(refusal(&[("seed", Change::To(Value::Float(1.5)))]), "seed: found 1.5; valid is a whole number");
        assert!(walk().value("model.bodies.torso.mass").is_err());
        assert_eq!(walk().value("ground.friction").ok(), Some(Value::Float(0.85)));
    }
}
