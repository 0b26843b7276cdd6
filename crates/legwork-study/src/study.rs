//! A study: scenarios, factors with their levels and a design, read from a file and numbered rollout by rollout.

use std::path::{Path, PathBuf};

use toml::Value;

use crate::design::{Design, Sampler, grid_count, grid_point, one_at_a_time};
use crate::file::{Source, StudyFile, leaves};
use crate::rollout;
use crate::rollout::Column;
use crate::{Base, Change, Factor, Level, Rollout, Variant};
use legwork::error::Error;
use legwork::library::{self, Kind};
use legwork::settings::holds;
use legwork_rbd::content::Content;
use legwork_rbd::words::{list, quoted};

/// Scenarios, factors and a design: what is run, and in which order.
#[derive(Clone, Debug)]
pub struct Study {
    /// Its name.
    pub name: String,
    /// What it asks, in a sentence or two.
    pub description: String,
    /// The scenarios; the design is carried out for each.
    pub bases: Vec<Base>,
    /// What is varied.
    pub factors: Vec<Factor>,
    /// How.
    pub design: Design,
    /// The seed of all that is random in it.
    pub seed: u64,
    /// The names of the figures that it is about, of [`Study::columns`].
    pub metrics: Vec<String>,
    sampler: Option<Sampler>,
    /// Rollouts of each scenario.
    each: u64,
    text: String,
}

/// One rollout of a study: the scenario and the levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its scenario, in [`Study::bases`].
    pub base: usize,
    /// The level of each factor; none where the scenario's own value stays.
    pub levels: Vec<Option<Level>>,
}

/// More chunks than these would be no help to anybody.
const MOST_ROLLOUTS: u64 = 1_000_000_000;

/// The settings that name files.
const FILES: [&str; 2] = ["model", "reference.com.file"];

/// The figures of Appendices E and F: tracking, then operating cost.
const METRICS: [&str; 12] = [
    "com_error_m.mean",
    "com_error_m.peak",
    "feet_error_m.mean",
    "feet_error_m.peak",
    "torso_deviation_rad.mean",
    "torso_deviation_rad.peak",
    "torque_nm.mean",
    "torque_nm.peak",
    "grf_n.mean",
    "grf_n.peak",
    "u2_n2m2.mean",
    "u2_n2m2.peak",
];

impl Study {
    /// Reads a built-in study or a file, and all that it names; `sets` change settings of every scenario.
    ///
    /// # Errors
    /// Neither is called so, it cannot be read, or something in it is not valid: names file, line and key. A level
    /// that the scenario or the model cannot have is such an error.
    pub fn load(name_or_path: &str, sets: &[String]) -> Result<Self, Error> {
        let document = library::open(Kind::Study, name_or_path, None)?;
        Self::parse(&document.text, &document.file_name, document.folder(), sets)
    }

    /// Reads a study from its text; `file_name` is used in messages, `folder` for the relative paths in it.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse(text: &str, file_name: &str, folder: Option<&Path>, sets: &[String]) -> Result<Self, Error> {
        let source = Source { file_name, text };
        let mut file: StudyFile = source.parse(Content::Study)?;
        let bases = load_bases(&mut file, &source, folder, sets)?;
        let (design, factors) = (file.design(&source)?, file.factors(&source)?);
        for (factor, entry) in factors.iter().zip(&file.factors) {
            check_levels(factor, &bases).map_err(|problem| {
                let key = format!("factors, \"{}\"", factor.name);
                source.error(entry.span().start, &key, problem)
            })?;
        }
        let wrong = |error: Error| source.error(file.design.span().start, "design", error.to_string());
        let sampler = match design {
            Design::OneAtATime | Design::Grid => None,
            _ => Some(Sampler::new(&design, factors.len(), file.seed).map_err(wrong)?),
        };
        let name = file.name(&source)?;
        // The resolved file may go by another name.
        file.name = Some(toml::Spanned::new(0..0, name.clone()));
        let mut study = Self {
            name,
            description: file.description.clone(),
            bases,
            factors,
            design,
            seed: file.seed,
            metrics: METRICS.map(str::to_owned).to_vec(),
            sampler,
            each: 0,
            text: String::new(),
        };
        let columns = study.columns();
        for metric in &file.metrics {
            if !columns.iter().any(|column| column.name == *metric.get_ref()) {
                let names: Vec<_> = columns.iter().map(|column| column.name.as_str()).collect();
                let problem = format!("found {}; valid are {}", quoted(metric.get_ref()), list(names));
                return Err(source.error(metric.span().start, "metrics", problem));
            }
        }
        if !file.metrics.is_empty() {
            study.metrics = file.metrics.iter().map(|metric| metric.get_ref().clone()).collect();
        }
        study.each = study.count_each().map_err(wrong)?;
        study.text = toml::to_string(&file).expect("a study is plain data");
        Ok(study)
    }

    /// It as a file that can be run again from any folder.
    pub fn to_toml(&self) -> &str {
        &self.text
    }

    /// Number of rollouts.
    pub fn len(&self) -> u64 {
        self.each * self.bases.len() as u64
    }

    /// Whether there is nothing to run; never so.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn counts(&self) -> Vec<usize> {
        self.factors.iter().map(|factor| factor.levels.count().unwrap_or(0)).collect()
    }

    fn count_each(&self) -> Result<u64, Error> {
        let each = match &self.sampler {
            Some(sampler) => sampler.count(),
            // The scenario as it stands comes first.
            None if self.design == Design::OneAtATime => 1 + self.counts().iter().sum::<usize>() as u64,
            None => grid_count(&self.counts())?,
        };
        let most = MOST_ROLLOUTS / self.bases.len() as u64;
        if each > most {
            return Err(Error::invalid("rollouts", format!("found {each} a scenario; valid are at most {most}")));
        }
        Ok(each)
    }

    /// The rollout of number `index`, less than [`Study::len`]: scenario after scenario, each in the order of the design.
    pub fn point(&self, index: u64) -> Point {
        let (base, within) = ((index / self.each) as usize, index % self.each);
        let level = |(factor, index): (usize, usize)| self.factors[factor].levels.level(index);
        let levels = match &self.sampler {
            Some(sampler) => {
                let shares = sampler.point(within).into_iter();
                self.factors.iter().zip(shares).map(|(factor, share)| Some(factor.levels.at(share))).collect()
            }
            None if self.design == Design::OneAtATime => {
                let mut levels = vec![None; self.factors.len()];
                if let Some(changed) = within.checked_sub(1) {
                    let (factor, index) = one_at_a_time(&self.counts()).nth(changed as usize).expect("it was counted");
                    levels[factor] = Some(level((factor, index)));
                }
                levels
            }
            None => {
                grid_point(&self.counts(), within).into_iter().enumerate().map(|place| Some(level(place))).collect()
            }
        };
        Point { base, levels }
    }

    /// The points of a sampled design in the unit cube, those of one scenario; none of the other designs.
    pub fn unit_points(&self) -> Option<Vec<Vec<f64>>> {
        self.sampler.as_ref().map(|sampler| (0..sampler.count()).map(|index| sampler.point(index)).collect())
    }

    /// What is run at `point`.
    ///
    /// # Errors
    /// The combination of levels is not valid.
    pub fn variant(&self, point: &Point) -> Result<Variant, Error> {
        let changes: Vec<(&str, Change)> = (self.factors.iter().zip(&point.levels))
            .filter_map(|(factor, level)| Some(factor.changes(level.as_ref()?)))
            .flatten()
            .collect();
        self.bases[point.base].vary(changes.iter().map(|(path, change)| (*path, change)))
    }

    /// Runs the rollout of number `index`; none where `stop` says so before its end.
    pub fn rollout(&self, index: u64, stop: impl Fn() -> bool) -> Option<Rollout> {
        match self.variant(&self.point(index)) {
            Ok(variant) => rollout::run(&variant, stop),
            Err(error) => Some(Rollout::invalid(error.to_string())),
        }
    }

    /// The figures of its rollouts, in the order of [`Rollout::figures`]; all scenarios have the joints of the first.
    pub fn columns(&self) -> Vec<Column> {
        let model = &self.bases[0].variant().model;
        rollout::columns(model.dofs.iter().filter(|dof| dof.actuated).map(|dof| dof.name.as_str()))
    }

    /// What identifies its results: the study and all that it names, and the figures that this version takes.
    pub fn identity(&self) -> u128 {
        self.identity_with(&self.columns())
    }

    fn identity_with(&self, columns: &[Column]) -> u128 {
        let mut hasher = xxhash_rust::xxh3::Xxh3::new();
        hasher.update(self.text.as_bytes());
        for base in &self.bases {
            hasher.update(&base.variant().input_hash().to_le_bytes());
        }
        for Column { name, unit, .. } in columns {
            hasher.update(format!("\n{name} [{unit}]").as_bytes());
        }
        hasher.digest128()
    }
}

/// Loads the scenarios, with the settings of the study's `set` and of the command line; afterwards the file names them
/// as they can be found from any folder.
fn load_bases(
    file: &mut StudyFile,
    source: &Source,
    folder: Option<&Path>,
    sets: &[String],
) -> Result<Vec<Base>, Error> {
    // What the command line sets is no longer the file's.
    let given = |path: &str| sets.iter().filter_map(|set| set.split_once('=')).any(|(set, _)| holds(set.trim(), path));
    let mut own: Vec<(String, Value)> = leaves(&file.set).into_iter().filter(|(path, _)| !given(path)).collect();
    // In a file a path is relative to the file, on the command line to the current folder.
    for (path, value) in &mut own {
        if let (true, Value::String(text), Some(folder)) = (FILES.contains(&path.as_str()), &mut *value, folder) {
            let found = folder.join(text.as_str());
            if library::model_text(text).is_none() && found.is_file() {
                *text = std::path::absolute(&found).unwrap_or(found).display().to_string();
            }
        }
    }
    let of_own = |place: &str| own.iter().map(|(path, _)| path.as_str()).find(|path| holds(path, place));
    let several = file.scenarios.get_ref().len() > 1;
    let mut bases: Vec<Base> = Vec::new();
    for name in file.scenarios.get_mut() {
        let (start, text) = (name.span().start, name.get_ref().clone());
        let wrong = |problem: String| source.error(start, "scenarios", problem);
        let built_in = library::scenario_text(&text).is_some();
        let path: PathBuf = if built_in { text.clone().into() } else { folder.unwrap_or(Path::new("")).join(&text) };
        let own = own.iter().map(|(path, value)| format!("{path}={value}"));
        let sets: Vec<String> = own.chain(sets.iter().cloned()).collect();
        let base = Base::load(&path.to_string_lossy(), &sets).map_err(|error| match error {
            Error::Invalid { place, problem } => match place.strip_prefix("--set ").map(of_own) {
                Some(Some(path)) if several => source.error_of_set(path, format!("in the scenario {text}: {problem}")),
                Some(Some(path)) => source.error_of_set(path, problem),
                Some(None) => Error::invalid(place, problem),
                None => wrong(format!("{place}: {problem}")),
            },
            other => other,
        })?;
        if bases.iter().any(|other| other.name() == base.name()) {
            return Err(wrong(format!("another scenario is called \"{}\" as well", base.name())));
        }
        if let Some(first) = bases.first() {
            let joints = |base: &Base| base.variant().model.dofs.iter().map(|dof| dof.name.clone()).collect::<Vec<_>>();
            if joints(first) != joints(&base) {
                let problem =
                    format!("\"{text}\" has another robot than \"{}\"; give it a study of its own", first.name());
                return Err(wrong(problem));
            }
        }
        if !built_in {
            *name.get_mut() = std::path::absolute(&path).unwrap_or(path).display().to_string();
        }
        bases.push(base);
    }
    if bases.is_empty() {
        return Err(source.error(file.scenarios.span().start, "scenarios", "found none; a study needs at least one"));
    }
    file.set = own.into_iter().collect();
    for assignment in sets {
        if let Some((path, value)) = assignment.split_once('=') {
            let value = value.trim().parse().unwrap_or_else(|_| Value::String(value.trim().to_owned()));
            file.set.insert(path.trim().to_owned(), value);
        }
    }
    Ok(bases)
}

/// Whether every base can be run with the levels at which a factor's values leave their domain first.
pub(crate) fn check_levels(factor: &Factor, bases: &[Base]) -> Result<(), String> {
    for base in bases {
        for path in &factor.paths {
            let value = base.value(path).map_err(|error| error.to_string())?;
            let zero = value.as_float() == Some(0.0) || value.as_integer() == Some(0);
            if factor.relative && zero {
                return Err(format!("{path} is 0 in {}, which no level can multiply; leave relative out", base.name()));
            }
        }
        for level in factor.levels.extremes() {
            let changes: Vec<(&str, Change)> = factor.changes(&level).collect();
            let tried = base.vary(changes.iter().map(|(path, change)| (*path, change)));
            let tried = tried.and_then(|variant| variant.check());
            if let Err(error) = tried {
                return Err(format!("the level {level} is not one that {} can have: {error}", base.name()));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_figures_make_another_study() {
        let study = Study::load("ground", &[]).expect("it is built in");
        let columns = study.columns();
        assert_eq!(study.identity(), study.identity_with(&columns));
        let fewer = &columns[1..];
        let mut in_another_unit = columns.clone();
        in_another_unit[0].unit = "mm";
        let mut reversed = columns.clone();
        reversed.reverse();
        for other in [fewer, &in_another_unit, &reversed] {
            assert_ne!(study.identity_with(other), study.identity());
        }
    }
}
