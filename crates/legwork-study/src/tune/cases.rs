//! The cases that candidates are tried in: scenarios, with settings and values of the robot changed.

use std::path::Path;

use toml::Spanned;

use super::file::{CaseEntry, check_positive};
use crate::file::{Source, leaves};
use crate::{Base, Change, Factor, Level, Rollout, Variant, rollout};
use legwork::error::Error;
use legwork::library;
use legwork::settings::in_words;

/// A scenario that cases are made of.
#[derive(Clone, Debug)]
pub struct Family {
    /// Its name, or where its file is: what a file that extends it names.
    pub extends: String,
    /// The scenario.
    pub base: Base,
}

/// What a candidate is tried in.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name, which no other case has.
    pub name: String,
    /// How much it counts in the objective.
    pub weight: f64,
    base: Base,
    changes: Vec<(String, Change)>,
    variant: Variant,
    hash: u128,
}

impl Case {
    /// It as it stands.
    pub fn variant(&self) -> &Variant {
        &self.variant
    }

    /// The name of its scenario.
    pub fn scenario(&self) -> &str {
        self.base.name()
    }

    /// Whether the case itself changes what stands at `path`.
    pub(super) fn changes(&self, path: &str) -> bool {
        self.changes.iter().any(|(changed, _)| changed == path)
    }

    /// Its run as it stands.
    pub fn run(&self) -> Rollout {
        run(&self.variant)
    }

    /// Its run with the `factors` at these `levels`.
    pub fn run_at(&self, factors: &[Factor], levels: &[f64]) -> Rollout {
        let levels: Vec<Level> = levels.iter().map(|&level| Level::Number(level)).collect();
        let tuned: Vec<(&str, Change)> =
            factors.iter().zip(&levels).flat_map(|(factor, level)| factor.changes(level)).collect();
        let own = self.changes.iter().map(|(path, change)| (path.as_str(), change));
        match self.base.vary(own.chain(tuned.iter().map(|(path, change)| (*path, change)))) {
            Ok(variant) => run(&variant),
            Err(error) => Rollout::invalid(error.to_string()),
        }
    }
}

fn run(variant: &Variant) -> Rollout {
    rollout::run(variant, || false).expect("nothing stops it")
}

/// What is read so far.
pub(super) struct Reader<'a> {
    pub(super) source: Source<'a>,
    pub(super) folder: Option<&'a Path>,
    pub(super) families: Vec<Family>,
}

impl Reader<'_> {
    /// The cases below `key`, none of which may be one of the `others`. Afterwards each entry names its scenario as it
    /// can be found from any folder.
    pub(super) fn cases(
        &mut self,
        entries: &mut [Spanned<CaseEntry>],
        key: &str,
        others: &[Case],
    ) -> Result<Vec<Case>, Error> {
        let mut cases: Vec<Case> = Vec::with_capacity(entries.len());
        for (index, entry) in entries.iter_mut().enumerate() {
            let start = entry.span().start;
            let source = self.source;
            let wrong = |problem: String| source.error(start, &format!("{key}.{index}"), problem);
            let case = self.case(entry.get_mut()).map_err(|error| match error {
                error @ Error::Io { .. } => error,
                error => wrong(error.to_string()),
            })?;
            for other in others.iter().chain(&cases) {
                if other.name == case.name {
                    return Err(wrong(format!("another case is called \"{}\" as well", other.name)));
                }
                if other.hash == case.hash {
                    return Err(wrong(format!("\"{}\" is the case \"{}\" over again", case.name, other.name)));
                }
            }
            cases.push(case);
        }
        if cases.is_empty() {
            let why = match key {
                "cases" => "candidates are tried in at least one",
                _ => "what a tuning is worth shows in cases that it has not seen; give at least one",
            };
            return Err(Error::invalid(self.source.file_name, format!("no [[{key}]]; {why}")));
        }
        Ok(cases)
    }

    fn case(&mut self, entry: &mut CaseEntry) -> Result<Case, Error> {
        let weight = entry.weight.unwrap_or(1.0);
        check_positive("weight", weight)?;
        let base = self.base(entry)?;
        let mut changes: Vec<_> =
            leaves(&entry.set).into_iter().map(|(path, value)| (path, Change::To(value))).collect();
        for (path, value) in leaves(&entry.scale) {
            let factor = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
            let Some(factor) = factor.filter(|factor| factor.is_finite()) else {
                let problem = format!("found {}; valid is a number to multiply with", in_words(&value));
                return Err(Error::invalid(format!("scale, {path}"), problem));
            };
            changes.push((path, Change::Times(factor)));
        }
        let variant = base.vary(changes.iter().map(|(path, change)| (path.as_str(), change)))?;
        variant.check()?;
        let name = entry.name.clone().unwrap_or_else(|| described(base.name(), &changes));
        Ok(Case { name, weight, base, changes, hash: variant.input_hash(), variant })
    }

    /// The scenario that the entry names, read once.
    fn base(&mut self, entry: &mut CaseEntry) -> Result<Base, Error> {
        let path = self.folder.unwrap_or(Path::new("")).join(&entry.scenario);
        if library::scenario_text(&entry.scenario).is_none() && path.exists() {
            entry.scenario = std::path::absolute(&path).unwrap_or(path).display().to_string();
        }
        let families = &self.families;
        if let Some(known) = families.iter().find(|family| family.extends == entry.scenario) {
            return Ok(known.base.clone());
        }
        let base = Base::load(&entry.scenario, &[])?;
        let wrong = |problem| Err(Error::invalid(format!("scenario, {}", entry.scenario), problem));
        if families.iter().any(|family| family.base.name() == base.name()) {
            return wrong(format!("another scenario is called \"{}\" as well", base.name()));
        }
        let joints = |base: &Base| base.variant().model.dofs.iter().map(|dof| dof.name.clone()).collect::<Vec<_>>();
        if let Some(other) = families.first().filter(|family| joints(&family.base) != joints(&base)) {
            return wrong(format!("it has another robot than {}; give it a tuning of its own", other.base.name()));
        }
        self.families.push(Family { extends: entry.scenario.clone(), base: base.clone() });
        Ok(base)
    }
}

/// A name for a case that has none.
fn described(scenario: &str, changes: &[(String, Change)]) -> String {
    let change = |(path, change): &(String, Change)| match change {
        Change::To(value) => format!(", {path} = {value}"),
        Change::Times(factor) => format!(", {path} × {factor}"),
    };
    scenario.to_owned() + &changes.iter().map(change).collect::<String>()
}
