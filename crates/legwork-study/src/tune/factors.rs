//! What a tuning changes: the factors, and their levels as points of the unit cube.

use toml::Spanned;

use super::{Case, Family};
use crate::file::{FactorEntry, Source};
use crate::study::check_levels;
use crate::{Base, Factor, Levels, Range};
use legwork::error::Error;
use legwork::settings::{Setting, Valid, in_words};

/// Reads the factors, none of which may be what a case sets itself.
pub(super) fn read(
    entries: &[Spanned<FactorEntry>],
    source: &Source,
    families: &[Family],
    cases: &[Case],
) -> Result<Vec<Factor>, Error> {
    let bases: Vec<Base> = families.iter().map(|family| family.base.clone()).collect();
    let mut factors: Vec<Factor> = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        let wrong = |problem: String| source.error(entry.span().start, &format!("factors.{index}"), problem);
        let factor = entry.get_ref().factor(true).map_err(wrong)?;
        if matches!(factor.levels, Levels::List(_)) {
            return Err(wrong("a list has nothing between its levels; valid are linear and logarithmic".into()));
        }
        for path in &factor.paths {
            bases[0].value(path).map_err(|error| wrong(error.to_string()))?;
            let setting = Setting::find(path).filter(|setting| matches!(setting.valid, Valid::Number { .. }));
            if setting.is_none_or(|setting| setting.path.contains('N')) {
                return Err(wrong(format!("{path}: valid are settings that hold one number; no push, no model")));
            }
            if let Some(case) = cases.iter().find(|case| case.changes(path)) {
                return Err(wrong(format!("the case \"{}\" sets {path} as well; one of both must go", case.name)));
            }
            if let Some(other) = factors.iter().find(|other| other.paths.contains(path)) {
                return Err(wrong(format!("\"{}\" changes {path} as well", other.name)));
            }
        }
        if factors.iter().any(|other| other.name == factor.name) {
            return Err(wrong(format!("another factor is called \"{}\" as well", factor.name)));
        }
        check_levels(&factor, &bases).map_err(wrong)?;
        factors.push(factor);
    }
    if factors.is_empty() {
        return Err(Error::invalid(source.file_name, "no [[factors]]; a tuning changes at least one setting"));
    }
    Ok(factors)
}

/// The level of each factor at which the scenarios are what they are: where the search starts.
pub(super) fn own_levels(
    factors: &[Factor],
    entries: &[Spanned<FactorEntry>],
    source: &Source,
    families: &[Family],
) -> Result<Vec<f64>, Error> {
    let own = |(index, factor): (usize, &Factor)| {
        let own = if factor.relative { Ok(1.0) } else { common_value(factor, families) };
        let range = range(factor);
        own.and_then(|own| match own {
            own if (range.from..=range.to).contains(&own) => Ok(own),
            own => Err(format!("starts from the own {own}, which is not between {} and {}", range.from, range.to)),
        })
        .map_err(|problem| source.error(entries[index].span().start, &format!("factors.{index}"), problem))
    };
    factors.iter().enumerate().map(own).collect()
}

/// The value that stands at all paths of a factor in all scenarios.
fn common_value(factor: &Factor, families: &[Family]) -> Result<f64, String> {
    let mut first: Option<(f64, String)> = None;
    for (family, path) in families.iter().flat_map(|family| factor.paths.iter().map(move |path| (family, path))) {
        let value = family.base.value(path).map_err(|error| error.to_string())?;
        let number = value.as_float().ok_or_else(|| format!("{path} is {}", in_words(&value)))?;
        let place = format!("{path} of {}", family.base.name());
        match &first {
            Some((other, there)) if *other != number => {
                let hint = "the search starts from one value; relative = true makes the levels factors of each";
                return Err(format!("{there} is {other}, {place} is {number}; {hint}"));
            }
            Some(_) => {}
            None => first = Some((number, place)),
        }
    }
    first.map(|(number, _)| number).ok_or_else(|| "changes nothing".to_owned())
}

fn range(factor: &Factor) -> Range {
    match &factor.levels {
        Levels::Linear(range) | Levels::Logarithmic(range) => *range,
        Levels::List(_) => unreachable!("lists are refused when a tuning is read"),
    }
}

/// How far through its range a factor's level lies, from 0 to 1.
pub(super) fn share(factor: &Factor, level: f64) -> f64 {
    let Range { from, to, .. } = range(factor);
    let share = match factor.levels {
        Levels::Logarithmic(_) => libm::log(level / from) / libm::log(to / from),
        _ => (level - from) / (to - from),
    };
    share.clamp(0.0, 1.0)
}

/// The level at a share of the range, rounded to four digits: a setting that needs more is none to build on.
pub(super) fn level(factor: &Factor, share: f64) -> f64 {
    let Range { from, to, .. } = range(factor);
    let level = factor.levels.at(share).number().unwrap_or(from);
    format!("{level:.3e}").parse().unwrap_or(level).clamp(from, to)
}
