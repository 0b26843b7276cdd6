//! Tuning: settings that better a design by its figures, found by CMA-ES in some cases and judged in others.
//!
//! A tuning is data (`tunings/*.toml`): factors, the cases that candidates are tried in, an objective and constraints
//! relative to the scenarios as they stand, and the cases that are held out. Those are run once, after the search.

mod aims;
mod cases;
mod factors;
mod file;
mod score;
mod search;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use serde::{Deserialize, Serialize};
use toml::Value;

pub use aims::{Bound, Constraint, Term};
pub use cases::{Case, Family};
pub use score::Score;
pub use search::{Generation, Settings, Stop, Trial};

use crate::parallel::run_all;
use crate::rollout::Column;
use crate::store::Store;
use crate::ties;
use crate::{Change, Factor, Level, Rollout};
use legwork::error::Error;
use legwork::library::{self, Kind};
use legwork::settings::Setting;
use score::Judge;
use search::search;

/// What is tuned, in which cases, to which end.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// Its name.
    pub name: String,
    /// What it is after, in a sentence or two.
    pub description: String,
    /// How it searches.
    pub settings: Settings,
    /// What it changes.
    pub factors: Vec<Factor>,
    /// The level of each factor in the scenarios as they stand.
    pub own: Vec<f64>,
    /// The scenarios that are tuned: those of the training cases.
    pub families: Vec<Family>,
    /// The cases that candidates are tried in.
    pub training: Vec<Case>,
    /// The cases that only the result is tried in.
    pub held_out: Vec<Case>,
    /// The figures of the rollouts, in the order of [`Rollout::figures`].
    pub columns: Vec<Column>,
    /// What is to become less: the mean of these figures, each divided by that of the scenario as it stands.
    pub objective: Vec<Term>,
    /// What must be kept.
    pub constraints: Vec<Constraint>,
    /// Its file without the budget.
    text: String,
}

/// A candidate in a folder.
#[derive(Deserialize, Serialize)]
struct Candidate {
    /// The level of each factor.
    levels: Vec<f64>,
    /// One a training case.
    rollouts: Vec<Rollout>,
}

/// What a tuning found.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The best level of each factor; those of [`Tuning::own`] where nothing better was found.
    pub levels: Vec<f64>,
    /// What they are worth.
    pub score: Score,
    /// What the scenarios as they stand are worth.
    pub base_score: Score,
    /// The training cases.
    pub training: Vec<Comparison>,
    /// The held-out cases; none where the search was interrupted.
    pub held_out: Vec<Comparison>,
    /// The generations of the search.
    pub history: Vec<Generation>,
    /// How many candidates were tried beside the base.
    pub evaluations: u64,
    /// Why the search ended.
    pub why: Stop,
}

/// A case as it stands and with the levels that were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The case's name.
    pub case: String,
    /// The name of its scenario.
    pub scenario: String,
    /// The run as it stands.
    pub base: Rollout,
    /// The run with the levels.
    pub tuned: Rollout,
}

impl Comparison {
    /// A figure of both runs, and the tuned one's as a multiple of the base's, 1 where they are equal but for rounding; none where a run fell or lacks it.
    pub fn figure(&self, column: usize) -> Option<(f64, f64, f64)> {
        let of = |rollout: &Rollout| rollout.figures.get(column).copied().flatten().filter(|_| rollout.survived());
        let (base, tuned) = (of(&self.base)?, of(&self.tuned)?);
        Some((base, tuned, if ties::are_equal(base, tuned) { 1.0 } else { tuned / base })).filter(|f| f.2.is_finite())
    }
}

impl Tuning {
    /// Reads a built-in tuning or a file, and all that it names.
    ///
    /// # Errors
    /// Neither is called so, it cannot be read, or something in it is not valid: names file, line and key.
    pub fn load(name_or_path: &str) -> Result<Self, Error> {
        let document = library::open(Kind::Tuning, name_or_path, None)?;
        Self::parse(&document.text, &document.file_name, document.folder())
    }

    /// Reads a tuning from its text; `file_name` is used in messages, `folder` for the relative paths in it.
    ///
    /// # Errors
    /// As [`Tuning::load`].
    pub fn parse(text: &str, file_name: &str, folder: Option<&Path>) -> Result<Self, Error> {
        file::read(text, file_name, folder)
    }

    /// It as a file that can be run again from any folder.
    pub fn to_toml(&self) -> String {
        format!("budget = {}\n{}", self.settings.budget, self.text)
    }

    /// Opens its folder, which keeps the candidates that are tried, generation by generation. The budget becomes the one
    /// given, or else that of the folder, or else stays that of the file; the folder keeps it.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn open(&mut self, folder: &Path, budget: Option<u64>) -> Result<Store, Error> {
        let (own, size) = (self.settings.budget, self.settings.generation(self.factors.len()));
        let of = |kept: Option<u64>| budget.or(kept).unwrap_or(own);
        let store = Store::open_tuning(folder, &self.text, self.identity(), size, of)?;
        self.settings.budget = store.budget().unwrap_or(own);
        Ok(store)
    }

    /// What identifies its results but for the budget: the tuning and all that it names, and the figures of this version.
    fn identity(&self) -> u128 {
        let mut hasher = xxhash_rust::xxh3::Xxh3::new();
        hasher.update(self.text.as_bytes());
        for case in self.training.iter().chain(&self.held_out) {
            hasher.update(&case.variant().input_hash().to_le_bytes());
        }
        for Column { name, unit, .. } in &self.columns {
            hasher.update(format!("\n{name} [{unit}]").as_bytes());
        }
        hasher.digest128()
    }

    /// How many rollouts it makes at most.
    pub fn rollouts(&self) -> u64 {
        (1 + self.settings.budget) * self.training.len() as u64 + 2 * self.held_out.len() as u64
    }

    /// Searches, and tries what it finds in the held-out cases. Whole generations are kept in the `store` that
    /// [`Tuning::open`] gave, and what it has already is not run again. `told` hears how many rollouts are done; threads may
    /// tell it out of order. When `stop` says so, no rollout is begun any more, and the best so far is the result; none
    /// where the base was not run yet.
    ///
    /// # Errors
    /// Objective or constraints compare with figures that the scenarios as they stand do not have; the store cannot be read
    /// or written.
    pub fn run(
        &self,
        store: Option<&Store>,
        told: impl Fn(u64) + Sync,
        stop: impl Fn() -> bool + Sync,
    ) -> Result<Option<Tuned>, Error> {
        let done = AtomicU64::new(0);
        let counted = |run: &dyn Fn() -> Rollout| (!stop()).then(run).inspect(|_| told(done.fetch_add(1, Relaxed) + 1));
        let training = &self.training;
        let Some(base) = run_all(training.len(), |case| counted(&|| training[case].run())) else { return Ok(None) };
        let judge = Judge::new(training, &self.columns, &self.objective, &self.constraints, &base)?;
        let base = Trial { score: judge.score(&base), rollouts: base };
        let mut generations = 0..;
        let evaluate = |points: &[Vec<f64>]| {
            let levels: Vec<Vec<f64>> = points.iter().map(|point| self.levels(point)).collect();
            let generation = generations.next().expect("there is no end of them");
            let runs = (levels.len() * training.len()) as u64;
            let trials = match self.kept(store, generation, &levels)? {
                Some(kept) => {
                    told(done.fetch_add(runs, Relaxed) + runs);
                    kept.into_iter().map(Some).collect()
                }
                None => {
                    let run = |index: usize| {
                        let (candidate, case) = (index / training.len(), &training[index % training.len()]);
                        Some(counted(&|| case.run_at(&self.factors, &levels[candidate])))
                    };
                    let rollouts = run_all(runs as usize, run).unwrap_or_default();
                    let tried: Vec<Option<Vec<Rollout>>> =
                        rollouts.chunks(training.len()).map(|rollouts| rollouts.iter().cloned().collect()).collect();
                    self.keep(store, generation, levels, &tried)?;
                    tried
                }
            };
            let trial = |rollouts: Vec<Rollout>| Trial { score: judge.score(&rollouts), rollouts };
            Ok(trials.into_iter().map(|rollouts| rollouts.map(trial)).collect())
        };
        let start: Vec<f64> = self.factors.iter().zip(&self.own).map(|(f, &own)| factors::share(f, own)).collect();
        let found = search(&start, base.clone(), &self.settings, evaluate)?;
        let levels = found.point.as_ref().map_or_else(|| self.own.clone(), |point| self.levels(point));
        let held_out = |case: usize| {
            let case = &self.held_out[case];
            let base = counted(&|| case.run())?;
            Some((case, base, counted(&|| case.run_at(&self.factors, &levels))?))
        };
        let runs = training.iter().zip(base.rollouts).zip(found.trial.rollouts);
        Ok(Some(Tuned {
            training: runs.map(|((case, base), tuned)| comparison((case, base, tuned))).collect(),
            held_out: run_all(self.held_out.len(), held_out).into_iter().flatten().map(comparison).collect(),
            levels,
            score: found.trial.score,
            base_score: base.score,
            history: found.history,
            evaluations: found.evaluations,
            why: found.why,
        }))
    }

    /// The rollouts of the candidates with these `levels`, where the store has them; the budget may end a generation before
    /// its last one.
    fn kept(
        &self,
        store: Option<&Store>,
        generation: u64,
        levels: &[Vec<f64>],
    ) -> Result<Option<Vec<Vec<Rollout>>>, Error> {
        let Some(store) = store else { return Ok(None) };
        let mut kept: Vec<Candidate> = store.chunk(generation)?.unwrap_or_default();
        kept.truncate(levels.len());
        let is_it = |(candidate, levels): (&Candidate, &Vec<f64>)| {
            candidate.levels == *levels && candidate.rollouts.len() == self.training.len()
        };
        let are_all = kept.len() == levels.len() && kept.iter().zip(levels).all(is_it);
        Ok(are_all.then(|| kept.into_iter().map(|candidate| candidate.rollouts).collect()))
    }

    /// Keeps a generation that is whole.
    fn keep(
        &self,
        store: Option<&Store>,
        generation: u64,
        levels: Vec<Vec<f64>>,
        tried: &[Option<Vec<Rollout>>],
    ) -> Result<(), Error> {
        let is_whole = levels.len() as u64 == self.settings.generation(self.factors.len());
        let candidates = levels.into_iter().zip(tried);
        let candidates = candidates.map(|(levels, rollouts)| Some(Candidate { levels, rollouts: rollouts.clone()? }));
        match (store, candidates.collect::<Option<Vec<_>>>()) {
            (Some(store), Some(candidates)) if is_whole => store.write(generation, &candidates),
            _ => Ok(()),
        }
    }

    /// The levels at a point of the unit cube.
    fn levels(&self, point: &[f64]) -> Vec<f64> {
        self.factors.iter().zip(point).map(|(factor, &share)| factors::level(factor, share)).collect()
    }

    /// The figures that objective and constraints are about, in [`Tuning::columns`], each once.
    pub fn metrics(&self) -> Vec<usize> {
        let constraints = self.constraints.iter().map(|constraint| &constraint.term);
        let mut metrics = Vec::new();
        for term in self.objective.iter().chain(constraints) {
            if !metrics.contains(&term.column) {
                metrics.push(term.column);
            }
        }
        metrics
    }

    /// Each scenario that is tuned with the `levels`, as name and text of a file that extends it.
    pub fn scenarios(&self, levels: &[f64]) -> Vec<(String, String)> {
        self.families
            .iter()
            .map(|family| (format!("{}-tuned", family.base.name()), self.fragment(family, levels)))
            .collect()
    }

    fn fragment(&self, family: &Family, levels: &[f64]) -> String {
        let mut tables: BTreeMap<&str, Vec<(&str, f64)>> = BTreeMap::new();
        for (factor, &level) in self.factors.iter().zip(levels) {
            for (path, change) in factor.changes(&Level::Number(level)) {
                let value = match change {
                    Change::Times(times) => {
                        times * family.base.value(path).ok().and_then(|v| v.as_float()).unwrap_or(0.0)
                    }
                    Change::To(_) => level,
                };
                let setting = Setting::find(path).expect("factors are settings");
                tables.entry(setting.table()).or_default().push((setting.key(), value));
            }
        }
        let text = |text: String| Value::String(text).to_string();
        let name = family.base.name();
        let mut file = format!("extends = {}\n", text(family.extends.clone()));
        let _ = writeln!(file, "name = {}", text(format!("{name}-tuned")));
        let _ =
            writeln!(file, "description = {}", text(format!("As {name}, with what the tuning {} found.", self.name)));
        for (table, values) in tables {
            let head = if table.is_empty() { String::new() } else { format!("\n[{table}]\n") };
            file += &head;
            for (key, value) in values {
                // 2.2e-8 instead of a row of zeros
                let small = value != 0.0 && value.abs() < 1e-4;
                let number = if small { format!("{value:e}") } else { Value::Float(value).to_string() };
                let _ = writeln!(file, "{key} = {number}");
            }
        }
        file
    }
}

fn comparison((case, base, tuned): (&Case, Rollout, Rollout)) -> Comparison {
    Comparison { case: case.name.clone(), scenario: case.scenario().to_owned(), base, tuned }
}
