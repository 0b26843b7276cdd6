//! The built-in models, scenarios, studies and tunings, and the data files that a scenario may name.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use legwork_rbd::content::Content;
use legwork_rbd::words::{list, quoted};
use legwork_rbd::{Base, file};

use crate::error::Error;
use crate::robot::Robot;
use crate::settings::{TRAJECTORY_COLUMNS, Valid};

/// A built-in file: its name and its text.
type Entry = (&'static str, &'static str);

const MODELS: &[Entry] = &[
    ("planar_humanoid", include_str!("../../../models/planar_humanoid.toml")),
    ("planar_humanoid_feet", include_str!("../../../models/planar_humanoid_feet.toml")),
    ("exo18", include_str!("../../../models/exo18.urdf")),
];

/// What URDF cannot say of a built-in model.
const SIDE_FILES: &[Entry] = &[("exo18", include_str!("../../../models/exo18.legwork.toml"))];

const SCENARIOS: &[Entry] = &[
    ("stand", include_str!("../../../scenarios/stand.toml")),
    ("walk", include_str!("../../../scenarios/walk.toml")),
    ("push", include_str!("../../../scenarios/push.toml")),
    ("push-replan", include_str!("../../../scenarios/push-replan.toml")),
    ("walk-support", include_str!("../../../scenarios/walk-support.toml")),
    ("push-support", include_str!("../../../scenarios/push-support.toml")),
    ("walk-slope", include_str!("../../../scenarios/walk-slope.toml")),
    ("walk-baseline", include_str!("../../../scenarios/walk-baseline.toml")),
    ("push-baseline", include_str!("../../../scenarios/push-baseline.toml")),
    ("walk-support-baseline", include_str!("../../../scenarios/walk-support-baseline.toml")),
    ("push-support-baseline", include_str!("../../../scenarios/push-support-baseline.toml")),
    ("walk-tuned", include_str!("../../../scenarios/walk-tuned.toml")),
    ("push-tuned", include_str!("../../../scenarios/push-tuned.toml")),
    ("waypoints", include_str!("../../../scenarios/waypoints.toml")),
    ("exo-sway", include_str!("../../../scenarios/exo-sway.toml")),
    ("exo-lift", include_str!("../../../scenarios/exo-lift.toml")),
    ("feet-walk", include_str!("../../../scenarios/feet-walk.toml")),
    ("feet-slope", include_str!("../../../scenarios/feet-slope.toml")),
    ("walk-uneven", include_str!("../../../scenarios/walk-uneven.toml")),
    ("push-walking", include_str!("../../../scenarios/push-walking.toml")),
    ("stop-and-go", include_str!("../../../scenarios/stop-and-go.toml")),
    ("stand-push", include_str!("../../../scenarios/stand-push.toml")),
    ("walk-spring-damper", include_str!("../../../scenarios/walk-spring-damper.toml")),
];

const STUDIES: &[Entry] = &[
    ("torque-limit", include_str!("../../../studies/torque-limit.toml")),
    ("grf-limit", include_str!("../../../studies/grf-limit.toml")),
    ("grf-weight", include_str!("../../../studies/grf-weight.toml")),
    ("acceleration-weight", include_str!("../../../studies/acceleration-weight.toml")),
    ("momentum-weight", include_str!("../../../studies/momentum-weight.toml")),
    ("feet-weight", include_str!("../../../studies/feet-weight.toml")),
    ("torso-weight", include_str!("../../../studies/torso-weight.toml")),
    ("com-gain", include_str!("../../../studies/com-gain.toml")),
    ("foot-gain", include_str!("../../../studies/foot-gain.toml")),
    ("interactions", include_str!("../../../studies/interactions.toml")),
    ("screening", include_str!("../../../studies/screening.toml")),
    ("wearer", include_str!("../../../studies/wearer.toml")),
    ("ground", include_str!("../../../studies/ground.toml")),
    ("pushes", include_str!("../../../studies/pushes.toml")),
    ("sensing", include_str!("../../../studies/sensing.toml")),
    ("step-time", include_str!("../../../studies/step-time.toml")),
    ("feet-speeds", include_str!("../../../studies/feet-speeds.toml")),
    ("feet-terrain", include_str!("../../../studies/feet-terrain.toml")),
    ("feet-monte-carlo", include_str!("../../../studies/feet-monte-carlo.toml")),
    ("feet-wearers", include_str!("../../../studies/feet-wearers.toml")),
    ("feet-every-speed", include_str!("../../../studies/feet-every-speed.toml")),
    ("feet-pushes", include_str!("../../../studies/feet-pushes.toml")),
    ("feet-exoskeleton", include_str!("../../../studies/feet-exoskeleton.toml")),
    ("feet-late", include_str!("../../../studies/feet-late.toml")),
    ("feet-torque", include_str!("../../../studies/feet-torque.toml")),
];

const TUNINGS: &[Entry] =
    &[("thesis", include_str!("../../../tunings/thesis.toml")), ("feet", include_str!("../../../tunings/feet.toml"))];

/// The names of the built-in models.
pub fn model_names() -> impl Iterator<Item = &'static str> {
    MODELS.iter().map(|(name, _)| *name)
}

/// The file of a built-in model.
pub fn model_text(name: &str) -> Option<&'static str> {
    text(MODELS, name)
}

/// The names of the built-in scenarios.
pub fn scenario_names() -> impl Iterator<Item = &'static str> {
    SCENARIOS.iter().map(|(name, _)| *name)
}

/// The file of a built-in scenario.
pub fn scenario_text(name: &str) -> Option<&'static str> {
    text(SCENARIOS, name)
}

/// The names of the built-in studies.
pub fn study_names() -> impl Iterator<Item = &'static str> {
    STUDIES.iter().map(|(name, _)| *name)
}

/// The file of a built-in study.
pub fn study_text(name: &str) -> Option<&'static str> {
    text(STUDIES, name)
}

/// The names of the built-in tunings.
pub fn tuning_names() -> impl Iterator<Item = &'static str> {
    TUNINGS.iter().map(|(name, _)| *name)
}

/// The file of a built-in tuning.
pub fn tuning_text(name: &str) -> Option<&'static str> {
    text(TUNINGS, name)
}

fn text(entries: &[Entry], name: &str) -> Option<&'static str> {
    entries.iter().find(|entry| entry.0 == name).map(|entry| entry.1)
}

/// Reads a built-in model or a model file; a relative path is one from `folder`, where there is one.
///
/// # Errors
/// Neither a built-in model nor a file has this name, or the file is no valid model.
pub fn load_model(name_or_path: &str, folder: Option<&Path>) -> Result<Robot, Error> {
    load_model_with_base(name_or_path, folder, None)
}

/// As [`load_model`], with another base than the model names.
///
/// # Errors
/// As [`load_model`].
pub fn load_model_with_base(name_or_path: &str, folder: Option<&Path>, base: Option<Base>) -> Result<Robot, Error> {
    if let Some(text) = model_text(name_or_path) {
        return Ok(match self::text(SIDE_FILES, name_or_path) {
            Some(side) => Robot::from_urdf(
                text,
                &format!("built-in {name_or_path}.urdf"),
                Some((side, &format!("built-in {name_or_path}.legwork.toml"))),
                base,
            )?,
            None => Robot::from_toml_with_base(text, &format!("built-in {name_or_path}.toml"), base)?,
        });
    }
    let path = folder.unwrap_or(Path::new("")).join(name_or_path);
    if is_mere_name(name_or_path) && !path.exists() {
        return Err(Error::invalid("model", not_found(Content::Model, name_or_path)));
    }
    may_read(&path)?;
    Ok(Robot::load_with_base(&path, base)?)
}

/// The kinds of files of which some are built in, beside the models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What is simulated.
    Scenario,
    /// Many runs of scenarios.
    Study,
    /// A search for better settings of scenarios.
    Tuning,
}

impl Kind {
    fn entries(self) -> &'static [Entry] {
        match self {
            Self::Scenario => SCENARIOS,
            Self::Study => STUDIES,
            Self::Tuning => TUNINGS,
        }
    }

    fn content(self) -> Content {
        match self {
            Self::Scenario => Content::Scenario,
            Self::Study => Content::Study,
            Self::Tuning => Content::Tuning,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Study => "study",
            Self::Tuning => "tuning",
        }
    }
}

/// The text of a file, or of what is built in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Document {
    /// Its text.
    pub text: Cow<'static, str>,
    /// What to call it in messages.
    pub file_name: String,
    /// The path of the file; none of what is built in.
    pub path: Option<PathBuf>,
}

impl Document {
    /// The folder of the file, which relative paths in it start from; none of what is built in.
    pub fn folder(&self) -> Option<&Path> {
        self.path.as_deref().and_then(Path::parent)
    }
}

/// Finds what is built in under this name, or else reads the file; a relative path is one from `folder`, where there is one.
///
/// # Errors
/// Nothing of this kind is called so (names what is near), or the file cannot be read.
pub fn open(kind: Kind, name_or_path: &str, folder: Option<&Path>) -> Result<Document, Error> {
    if let Some(text) = text(kind.entries(), name_or_path) {
        return Ok(Document { text: text.into(), file_name: format!("built-in {name_or_path}.toml"), path: None });
    }
    let path = folder.unwrap_or(Path::new("")).join(name_or_path);
    if !path.exists() {
        let problem = not_found(kind.content(), name_or_path);
        return Err(if is_mere_name(name_or_path) {
            Error::invalid(kind.name(), problem)
        } else {
            Error::Io { path, problem }
        });
    }
    Ok(Document { text: read_text(&path, file::TEXT)?.into(), file_name: path.display().to_string(), path: Some(path) })
}

/// Whether a text can only be the name of something built in, and no path.
fn is_mere_name(text: &str) -> bool {
    !text.contains(['/', '\\', '.'])
}

/// What is built in.
const BUILT_IN: [(Content, &str, &[Entry]); 4] = [
    (Content::Model, "model", MODELS),
    (Content::Scenario, "scenario", SCENARIOS),
    (Content::Study, "study", STUDIES),
    (Content::Tuning, "tuning", TUNINGS),
];

/// That nothing that is `wanted` has this name, with what does.
fn not_found(wanted: Content, name: &str) -> String {
    if let Some((other, ..)) = BUILT_IN.iter().find(|(_, _, entries)| text(entries, name).is_some()) {
        return other.instead_of(wanted, name);
    }
    let of = BUILT_IN.iter().find(|(content, ..)| *content == wanted);
    let (_, kind, entries) = of.expect("nothing else is built in");
    let names: Vec<_> = entries.iter().map(|entry| entry.0).collect();
    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
    let likeness = |known: &str| strsim::jaro_winkler(&stem, known);
    let near = names.iter().copied().filter(|known| likeness(known) > 0.8);
    let near = near.max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    let hint = near.map_or(String::new(), |near| format!("did you mean {near}? "));
    format!("neither a built-in {kind} nor a file is called {}; {hint}built-in: {}", quoted(name), list(names))
}

/// Whether this build reads files.
fn may_read(path: &Path) -> Result<(), Error> {
    if cfg!(feature = "files") {
        return Ok(());
    }
    Err(Error::Io { path: path.to_owned(), problem: "this build reads no files".to_owned() })
}

/// A whole text file.
fn read_text(path: &Path, most: u64) -> Result<String, Error> {
    may_read(path)?;
    file::read_text(path, most).map_err(|why| Error::unread(path, &why))
}

/// The most that a file of samples may hold [bytes]: an hour of them at 1 kHz.
const SAMPLES: u64 = 256_000_000;

/// Reads the samples `[t_s, x_m, z_m]` of a CoM trajectory from a CSV file with these columns, among others perhaps.
///
/// # Errors
/// The file cannot be read, lacks a column, or holds what is no number, out of range or too short.
pub fn load_samples(path: &Path) -> Result<Vec<[f64; 3]>, Error> {
    let text = read_text(path, SAMPLES)?;
    let file = path.display();
    let invalid = |error: csv::Error| Error::invalid(file.to_string(), error.to_string());
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).flexible(true).from_reader(text.as_bytes());
    let header = reader.headers().map_err(invalid)?.clone();
    let mut columns = [0; 3];
    for (index, column) in columns.iter_mut().zip(&TRAJECTORY_COLUMNS) {
        *index = header.iter().position(|name| name == column.name).ok_or_else(|| {
            let needed = TRAJECTORY_COLUMNS.map(|column| column.name).join(", ");
            let (name, found) = (column.name, list(&header));
            Error::invalid(
                file.to_string(),
                format!("the column {name} is missing; found {found}; needed are {needed}"),
            )
        })?;
    }
    let mut samples = Vec::new();
    for record in reader.records() {
        let record = record.map_err(invalid)?;
        let mut sample = [0.0; 3];
        for ((value, index), column) in sample.iter_mut().zip(columns).zip(&TRAJECTORY_COLUMNS) {
            let cell = record.get(index).unwrap_or("");
            *value = cell.parse().ok().filter(|number| column.holds(*number)).ok_or_else(|| {
                let place = format!("{file}:{}: {}", line_of(&record, &text), column.name);
                let valid = Valid::Number { min: column.min, max: column.max };
                Error::invalid(place, format!("found {}; valid is {valid}", quoted(cell)))
            })?;
        }
        samples.push(sample);
    }
    if samples.len() < 3 {
        let problem = format!("found {} rows of samples; at least 3 are needed", samples.len());
        return Err(Error::invalid(file.to_string(), problem));
    }
    Ok(samples)
}

/// The line of a record; the reader's own count is that of the empty lines and comments before it.
fn line_of(record: &csv::StringRecord, text: &str) -> u64 {
    let Some(position) = record.position() else { return 0 };
    let rest = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or("");
    let skipped = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#'));
    position.line() + skipped.count() as u64
}
