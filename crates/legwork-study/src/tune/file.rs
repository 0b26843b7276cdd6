//! The file of a tuning: its keys, and the checks of those that stand alone.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::{Spanned, Table};

use super::cases::Reader;
use super::{Settings, Tuning, aims, factors};
use crate::file::{FactorEntry, Source};
use crate::rollout::columns;
use legwork::error::Error;
use legwork_rbd::content::Content;
use legwork_rbd::words::quoted;

/// A tuning as its file has it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TuningFile {
    name: Option<Spanned<String>>,
    #[serde(default)]
    description: String,
    #[serde(default)]
    seed: u64,
    /// Kept beside the text of a tuning, for it may change.
    #[serde(skip_serializing)]
    budget: Spanned<i64>,
    population: Option<Spanned<i64>>,
    sigma: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) factors: Vec<Spanned<FactorEntry>>,
    #[serde(default)]
    cases: Vec<Spanned<CaseEntry>>,
    #[serde(default)]
    held_out: Vec<Spanned<CaseEntry>>,
    #[serde(default)]
    pub(super) objective: Vec<Spanned<TermEntry>>,
    #[serde(default)]
    pub(super) constraints: Vec<Spanned<ConstraintEntry>>,
}

/// A case as a file has it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseEntry {
    pub(super) name: Option<String>,
    pub(super) scenario: String,
    /// Path to value, of scenario and model.
    #[serde(default)]
    pub(super) set: Table,
    /// Path to what the value there is multiplied by.
    #[serde(default)]
    pub(super) scale: Table,
    pub(super) weight: Option<f64>,
}

/// A term of the objective as a file has it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TermEntry {
    pub(super) metric: String,
    pub(super) weight: Option<f64>,
    pub(super) cases: Option<Vec<String>>,
    pub(super) scenarios: Option<Vec<String>>,
}

/// A constraint as a file has it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConstraintEntry {
    pub(super) metric: String,
    pub(super) at_most: Option<f64>,
    pub(super) at_most_times_base: Option<f64>,
    pub(super) at_least: Option<f64>,
    pub(super) cases: Option<Vec<String>>,
    pub(super) scenarios: Option<Vec<String>>,
}

/// More than these would be a slip.
const MOST_CANDIDATES: i64 = 10_000_000;
const MOST_OF_A_GENERATION: i64 = 10_000;

/// The first standard deviation where a file gives none.
const SIGMA: f64 = 0.2;

/// Reads a tuning from its text; see [`Tuning::parse`].
pub(super) fn read(text: &str, file_name: &str, folder: Option<&Path>) -> Result<Tuning, Error> {
    if text.trim().is_empty() {
        return Err(Error::invalid(file_name, "nothing in it; docs/tuning.md shows what a tuning needs"));
    }
    let source = Source { file_name, text };
    let mut file: TuningFile = source.parse(Content::Tuning)?;
    let (name, settings) = (file.name(&source)?, file.settings(&source)?);
    let mut reader = Reader { source, folder, families: Vec::new() };
    let training = reader.cases(&mut file.cases, "cases", &[])?;
    let tuned = reader.families.len();
    let held_out = reader.cases(&mut file.held_out, "held_out", &training)?;
    let families = reader.families;
    let factors = factors::read(&file.factors, &source, &families, &[&training[..], &held_out[..]].concat())?;
    let own = factors::own_levels(&factors, &file.factors, &source, &families[..tuned])?;
    let model = &families[0].base.variant().model;
    let columns = columns(model.dofs.iter().filter(|dof| dof.actuated).map(|dof| dof.name.as_str()));
    let (objective, constraints) = aims::read(&file, &source, &columns, &training)?;
    let text = toml::to_string(&file).expect("a tuning is plain data");
    let (description, families) = (file.description, families[..tuned].to_vec());
    let tuning = Tuning {
        name,
        description,
        settings,
        factors,
        own,
        families,
        training,
        held_out,
        columns,
        objective,
        constraints,
        text,
    };
    Ok(tuning)
}

impl TuningFile {
    /// Its name, or that of the file.
    fn name(&self, source: &Source) -> Result<String, Error> {
        let Some(name) = &self.name else {
            let stem = Path::new(source.file_name).file_stem().unwrap_or_default();
            return Ok(stem.to_string_lossy().into_owned());
        };
        let text = name.get_ref();
        if text.trim().is_empty() || text.contains(['/', '\\']) || text.contains(char::is_control) {
            let problem = "valid is a text that can be part of a file's name";
            let problem = format!("found {}; {problem}", quoted(text));
            return Err(source.error(name.span().start, "name", problem));
        }
        Ok(text.clone())
    }

    fn settings(&self, source: &Source) -> Result<Settings, Error> {
        let whole = |key: &str, value: &Spanned<i64>, least: i64, most: i64| {
            let found = *value.get_ref();
            if (least..=most).contains(&found) {
                return Ok(found.unsigned_abs());
            }
            let problem = format!("found {found}; valid is a whole number from {least} to {most}");
            Err(source.error(value.span().start, key, problem))
        };
        let budget = whole("budget", &self.budget, 1, MOST_CANDIDATES)?;
        let population = self.population.as_ref().map(|value| whole("population", value, 4, MOST_OF_A_GENERATION));
        let sigma = self.sigma.as_ref().map_or(SIGMA, |sigma| *sigma.get_ref());
        if !(1e-6..=1.0 / 3.0).contains(&sigma) {
            let start = self.sigma.as_ref().map_or(0, |sigma| sigma.span().start);
            let problem = format!("found {sigma}; valid is a share of the ranges from 1e-6 to 1/3");
            return Err(source.error(start, "sigma", problem));
        }
        Ok(Settings { budget, population: population.transpose()?.map(|count| count as usize), sigma, seed: self.seed })
    }
}

/// Refuses what is no positive number, NaN among it.
pub(super) fn check_positive(key: &str, number: f64) -> Result<(), Error> {
    if (1e-9..=1e12).contains(&number) {
        return Ok(());
    }
    Err(Error::invalid(key, format!("found {number}; valid is a number from 1e-9 to 1e12")))
}
