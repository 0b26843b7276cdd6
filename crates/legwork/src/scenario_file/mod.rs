//! Reading and writing scenarios: TOML files, `extends`, `--set`, and the checks.
//!
//! A file holds only what differs from [`Scenario::default`], or from the scenario that its key `extends` names (a
//! built-in one, or a file relative to the file's own folder). Tables are merged, lists are replaced as a whole; `name`
//! and `description` are a file's own. `--set` comes last. The checks see the result, so that what is out of range in
//! one layer and put right by the next does no harm.

pub(crate) mod checks;
mod draft;
mod write;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::error::Error;
use crate::library::{self, Kind, load_model, load_samples, model_text};
use crate::posture;
use crate::robot::Robot;
use crate::scenario::{Scenario, TrajectoryKind};
use crate::settings::{Setting, at, tree};
use crate::wearer;
use draft::{Draft, Places, Source};
use legwork_rbd::content::Content;
use legwork_rbd::words::matches;

pub use write::to_toml;

/// A scenario with the folder that its paths are relative to.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// Resolved and checked.
    pub scenario: Scenario,
    /// The folder of its file; none for a built-in scenario, whose paths are relative to the current folder.
    pub folder: Option<PathBuf>,
    file_name: String,
    places: Places,
}

impl Loaded {
    /// Reads the model that the scenario names, fits it to the wearer, and locks the joints that the scenario says.
    ///
    /// # Errors
    /// As [`load_model`] and [`wearer::fit`].
    pub fn model(&self) -> Result<Robot, Error> {
        let fitted = load_model(&self.scenario.model, self.folder.as_deref()).and_then(|mut model| {
            wearer::fit(&mut model, &self.scenario.wearer, &self.scenario.exoskeleton)?;
            lock(&mut model, &self.scenario)?;
            Ok(model)
        });
        fitted.map_err(|error| self.locate(error))
    }

    /// The scenario with the values that are in use with its `model`: scaled where they are stated for another robot.
    ///
    /// # Errors
    /// As [`crate::fit::fitted`].
    pub fn fitted(&self, model: &Robot) -> Result<Scenario, Error> {
        crate::fit::fitted(&self.portable(), model).map_err(|error| self.locate(error))
    }

    /// Reads the samples of the CoM trajectory; none where the scenario's trajectory is not from a file.
    ///
    /// # Errors
    /// As [`load_samples`].
    pub fn samples(&self) -> Result<Vec<[f64; 3]>, Error> {
        let com = &self.scenario.reference.com;
        if com.trajectory == TrajectoryKind::File {
            load_samples(&self.resolve_path(&com.file))
        } else {
            Ok(Vec::new())
        }
    }

    /// The path of a file that the scenario names.
    pub fn resolve_path(&self, text: &str) -> PathBuf {
        self.folder.as_deref().unwrap_or(Path::new("")).join(text)
    }

    /// The scenario with its paths made absolute: one that means the same in another folder.
    pub fn portable(&self) -> Scenario {
        let mut scenario = self.scenario.clone();
        for path in [&mut scenario.model, &mut scenario.reference.com.file] {
            let found = self.resolve_path(path);
            if !path.is_empty() && model_text(path).is_none() && found.is_file() {
                *path = std::path::absolute(&found).unwrap_or(found).display().to_string();
            }
        }
        scenario
    }

    /// An `error` that names a setting by its path alone, with the file and line where that was set.
    #[must_use]
    pub fn locate(&self, error: Error) -> Error {
        match error {
            Error::Invalid { place, problem } if at(&mut tree(&self.scenario), &place).is_some() => {
                let place = match self.places.of(&[&place]) {
                    Some(place) => place.to_owned(),
                    None => format!("{}: {place}", self.file_name),
                };
                Error::Invalid { place, problem }
            }
            other => other,
        }
    }
}

/// Fixes the joints of `model` that `scenario` says where its start's posture has them.
fn lock(model: &mut Robot, scenario: &Scenario) -> Result<(), Error> {
    let locked = &scenario.locked;
    if locked.is_empty() {
        return Ok(());
    }
    posture::check_names(model, locked).map_err(|problem| Error::invalid("locked", problem))?;
    let given = scenario.start.posture.positions(model).map_err(|why| Error::invalid("start.posture", why))?;
    let positions = given.into_iter().zip(posture::neutral(model)).map(|(given, neutral)| given.unwrap_or(neutral));
    let is_locked = |dof: usize| locked.iter().any(|pattern| matches(pattern, &model.dofs[dof].name));
    let welds: Vec<(usize, f64)> =
        positions.enumerate().filter(|(dof, _)| model.dofs[*dof].actuated && is_locked(*dof)).collect();
    model.weld(&welds);
    Ok(())
}

/// Reads a built-in scenario or a file, and applies the `sets`, each `path=value`.
///
/// # Errors
/// Neither is called so, it cannot be read, or its content or a `--set` is not valid.
pub fn load(name_or_path: &str, sets: &[String]) -> Result<Loaded, Error> {
    resolve(Origin::open(name_or_path, None)?, sets)
}

/// Reads a scenario from its text; `file_name` is used in messages and for the name of a scenario that states none,
/// `folder` for the relative paths in it.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, file_name: &str, folder: Option<&Path>, sets: &[String]) -> Result<Loaded, Error> {
    let (file_name, folder) = (file_name.to_owned(), folder.map(Path::to_owned));
    resolve(Origin { identity: PathBuf::from(&file_name), file_name, folder, text: Cow::Borrowed(text) }, sets)
}

/// A scenario from its tree of values; `name` is for what no setting can be blamed for.
///
/// # Errors
/// A value, or a pair of values, is not valid.
pub fn check(tree: toml::Value, name: &str) -> Result<Scenario, Error> {
    Draft { tree, places: Places::default() }.check(name)
}

/// The scenario with the value of one setting changed while it runs; `text` is a value as `--set` takes it.
///
/// # Errors
/// There is no such setting, it may not change while a run goes on, or its value is not valid.
pub(crate) fn change(scenario: &Scenario, path: &str, text: &str) -> Result<Scenario, Error> {
    let mut draft = Draft { tree: tree(scenario), places: Places::default() };
    draft.set(&format!("{path}={text}")).map_err(not_of_a_set)?;
    match Setting::find(path).map(Setting::fixed) {
        Some(Some(why)) => return Err(Error::invalid(path, format!("may not change while a run goes on: {why}"))),
        None if path != "pushes" => return Err(Error::invalid(path, "found a table; valid is one setting of it")),
        _ => {}
    }
    if path == "reference.walker.speed_mps" {
        // From now on it is asked for, whatever was to come.
        *at(&mut draft.tree, "reference.walker.speeds").expect("a setting") = toml::Value::Array(Vec::new());
    }
    draft.check(path).map_err(not_of_a_set)
}

/// A list of pushes, with the defaults of what each leaves out.
///
/// # Errors
/// It is no such list.
pub fn pushes(list: &toml::Value) -> Result<toml::Value, Error> {
    let mut draft = Draft::default();
    draft.set(&format!("pushes={list}")).map_err(not_of_a_set)?;
    Ok(draft.tree["pushes"].clone())
}

/// The error of a [`Draft::set`] that no `--set` asked for.
fn not_of_a_set(error: Error) -> Error {
    match error {
        Error::Invalid { place, problem } => Error::invalid(place.trim_start_matches("--set "), problem),
        other => other,
    }
}

fn resolve(origin: Origin, sets: &[String]) -> Result<Loaded, Error> {
    let mut draft = origin.draft(&mut Vec::new())?;
    for assignment in sets {
        draft.set(assignment)?;
        // On the command line a path is relative to the current folder, in a file to the file's.
        if let (Some(_), Ok(here)) = (&origin.folder, std::env::current_dir()) {
            let path = assignment.split('=').next().unwrap_or("").trim();
            draft.move_path(path, &here);
        }
    }
    let mut scenario = draft.check(&origin.file_name)?;
    if model_text(&scenario.model).is_none() && draft.places.of(&["start.com_height_m"]).is_none() {
        // That of the default belongs to a robot that is built in.
        scenario.start.com_height_m = 0.0;
    }
    Ok(Loaded { scenario, folder: origin.folder, file_name: origin.file_name, places: draft.places })
}

/// Most scenarios in a row of which each extends the next: the stack has an end.
const DEEPEST: usize = 100;

/// A scenario's text and where it is from.
struct Origin<'a> {
    /// Equal for the same file, however it is named.
    identity: PathBuf,
    file_name: String,
    folder: Option<PathBuf>,
    text: Cow<'a, str>,
}

impl Origin<'_> {
    /// Finds a built-in scenario, or a file relative to `folder`.
    fn open(name: &str, folder: Option<&Path>) -> Result<Self, Error> {
        let found = library::open(Kind::Scenario, name, folder)?;
        let identity = match &found.path {
            Some(path) => path.canonicalize().unwrap_or_else(|_| path.clone()),
            None => PathBuf::from(&found.file_name),
        };
        let folder = found.folder().map(Path::to_owned);
        Ok(Self { identity, file_name: found.file_name, folder, text: found.text })
    }

    /// Its values over those of the scenario that it extends; `extending` are the scenarios that extend this one.
    fn draft(&self, extending: &mut Vec<(PathBuf, String)>) -> Result<Draft, Error> {
        let source = Source::file(&self.file_name, &self.text);
        if let Some(content) = Content::other_than(Content::Scenario, &self.file_name, &self.text) {
            return Err(Error::invalid(&self.file_name, content.instead_of(Content::Scenario, &self.file_name)));
        }
        let mut document = DeTable::parse(&self.text)
            .map_err(|error| {
                let place = source.line(error.span().map_or(self.text.len(), |span| span.start));
                Error::invalid(place, format!("not TOML: {}", error.message()))
            })?
            .into_inner();
        if document.is_empty() {
            let problem = "nothing in it; `legwork show stand` prints a scenario to start from";
            return Err(Error::invalid(&self.file_name, problem));
        }
        let mut draft = match document.remove_entry("extends") {
            Some((key, value)) => {
                let place = source.place(key.span().start, "extends");
                extending.push((self.identity.clone(), self.file_name.clone()));
                self.base(value.get_ref(), &place, extending)?
            }
            None => Draft::default(),
        };
        let name = Path::new(&self.file_name).file_stem().unwrap_or_default();
        draft.rename(&name.to_string_lossy());
        draft.merge(&DeValue::Table(document), &source)?;
        Ok(draft)
    }

    /// The draft of the scenario that the key `extends` names at `place`.
    fn base(&self, name: &DeValue, place: &str, extending: &mut Vec<(PathBuf, String)>) -> Result<Draft, Error> {
        let Some(name) = name.as_str() else {
            let problem = format!("found {}; valid is the name of a built-in scenario or a file", draft::found(name));
            return Err(Error::invalid(place, problem));
        };
        let origin =
            Origin::open(name, self.folder.as_deref()).map_err(|error| Error::invalid(place, error.to_string()))?;
        if extending.iter().any(|(identity, _)| *identity == origin.identity) {
            let chain = extending.iter().map(|(_, name)| name.as_str()).chain([origin.file_name.as_str()]);
            let chain = chain.collect::<Vec<_>>().join(" -> ");
            return Err(Error::invalid(place, format!("the scenarios extend one another in a circle: {chain}")));
        }
        if extending.len() > DEEPEST {
            return Err(Error::invalid(place, format!("scenarios extend one another in a row of more than {DEEPEST}")));
        }
        let mut draft = origin.draft(extending)?;
        if let (Some(_), Some(folder)) = (&origin.folder, Path::new(name).parent()) {
            draft::PATHS.iter().for_each(|path| draft.move_path(path, folder));
        }
        Ok(draft)
    }
}
