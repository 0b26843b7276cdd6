//! What the thesis says of its results, claim by claim, each with its test.

mod gains;
mod limits;
mod motion;
mod performance;
mod weights;
mod why;

use serde::Serialize;

use super::case::{Experiment, Reading};
use super::curve::Curve;
use super::evidence::Evidence;
use super::sweep::Sweep;
use super::terms::Check;

/// Whether a claim is reproduced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// All parts of the test hold.
    Reproduced,
    /// Some do.
    Partly,
    /// None does.
    Not,
}

impl Verdict {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Reproduced, Self::Partly, Self::Not];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Partly => "partly",
            Self::Not => "not",
        }
    }

    fn of(checks: &[Check]) -> Self {
        match checks.iter().filter(|check| check.holds).count() {
            0 => Self::Not,
            held if held == checks.len() => Self::Reproduced,
            _ => Self::Partly,
        }
    }
}

/// Where the figures of a claim can be looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Source {
    /// The file, without its ending.
    pub file: &'static str,
    /// Its rows: of `sweeps` those of this study, else in words.
    pub rows: &'static str,
    /// Its columns.
    pub columns: &'static [&'static str],
}

/// A claim and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// The thesis's section and a letter.
    pub id: &'static str,
    /// What the thesis says, in our words.
    pub says: &'static str,
    /// What is computed, in the terms of [`super::terms::terms`].
    pub test: &'static str,
    /// Where the figures are.
    pub source: Source,
    /// What was found, in the order of [`Reading::ALL`].
    pub findings: Vec<Finding>,
}

/// What was found in a reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The reading.
    pub reading: Reading,
    /// The verdict.
    pub verdict: Verdict,
    /// The parts of the test.
    pub checks: Vec<Check>,
    /// Where it is not reproduced: why, as far as known.
    pub why: Option<&'static str>,
}

/// A claim with its test.
pub(super) struct Test {
    id: &'static str,
    says: &'static str,
    test: &'static str,
    source: Source,
    run: fn(&Evidence, Reading) -> Vec<Check>,
}

impl Claim {
    /// The section of the thesis.
    pub fn section(&self) -> &'static str {
        self.id.rsplit_once('-').map_or(self.id, |(section, _)| section)
    }
}

fn tests() -> impl Iterator<Item = &'static Test> {
    [limits::TESTS, weights::TESTS, gains::TESTS, performance::TESTS, motion::TESTS].into_iter().flatten()
}

/// All claims, tested.
pub fn claims(evidence: &Evidence) -> Vec<Claim> {
    let claim = |test: &Test| {
        let finding = |reading| {
            let checks = (test.run)(evidence, reading);
            let verdict = Verdict::of(&checks);
            let why = if verdict == Verdict::Reproduced { None } else { why::why(test.id, reading) };
            Finding { reading, verdict, checks, why }
        };
        let findings = Reading::ALL.map(finding).to_vec();
        Claim { id: test.id, says: test.says, test: test.test, source: test.source, findings }
    };
    let mut claims: Vec<Claim> = tests().map(claim).collect();
    claims.sort_by_key(|claim| claim.id);
    claims
}

const fn sweep_source(study: &'static str, columns: &'static [&'static str]) -> Source {
    Source { file: "sweeps", rows: study, columns }
}

/// A part for the walk and one for the push.
fn each(of: impl Fn(Experiment) -> Check) -> Vec<Check> {
    Experiment::ALL.map(of).to_vec()
}

/// A part for each of the `figures` in the `experiments`, over the levels of a range.
fn curves(
    (evidence, study, reading): (&Evidence, &str, Reading),
    experiments: &[Experiment],
    figures: &[&'static str],
    range: (f64, f64),
    test: impl Fn(Curve) -> Check,
) -> Vec<Check> {
    let of = |experiment| figures.iter().map(move |&figure| (experiment, figure));
    let pairs = experiments.iter().copied().flat_map(of);
    pairs.map(|(experiment, figure)| test(evidence.curve((study, reading, experiment), figure, range))).collect()
}

/// A part for the walk's sweep and one for the push's.
fn sweeps(evidence: &Evidence, study: &str, reading: Reading, test: impl Fn(&Sweep) -> Check) -> Vec<Check> {
    each(|experiment| test(evidence.sweep(study, reading, experiment)))
}

#[cfg(test)]
mod unit_tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::sweep::studies;

    #[test]
    fn every_claim_has_its_own_name_and_every_section_its_claims() {
        let ids: Vec<_> = tests().map(|test| test.id).collect();
        assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "{ids:?}");
        let sections: BTreeSet<_> = ids.iter().map(|id| id.rsplit_once('-').expect("section and letter").0).collect();
        let wanted =
            "6.1 6.3.1 6.3.2 6.3.3 6.3.4 6.3.5 6.3.6 6.3.7 6.3.8 6.4 7.1 7.1.1 7.1.2 7.1.3 7.1.4 7.1.5 7.2.1 7.4 8.1.2";
        assert_eq!(sections, wanted.split(' ').collect());
    }

    #[test]
    fn the_sources_of_sweeps_are_studies_and_their_columns() {
        let studies = studies().expect("they are built in");
        let mut seen = BTreeSet::new();
        for test in tests().filter(|test| test.source.file == "sweeps") {
            let study = studies.iter().find(|study| study.name == test.source.rows);
            let study = study.unwrap_or_else(|| panic!("{}: no study {}", test.id, test.source.rows));
            seen.insert(&study.name);
            for name in test.source.columns {
                let known = study.columns().iter().any(|column| column.name == *name);
                let ours = ["ending", "momentum_rate_limited_fraction"].contains(name);
                assert!(known || ours, "{}: no column {name}", test.id);
            }
        }
        assert_eq!(seen.len(), studies.len());
    }

    #[test]
    fn reasons_are_given_for_claims_that_there_are() {
        for id in why::ids() {
            assert!(tests().any(|test| test.id == id), "no claim {id}");
        }
    }

    #[test]
    fn the_verdict_follows_from_the_parts() {
        let parts = |held: &[bool]| held.iter().map(|&holds| Check::new(holds, "")).collect::<Vec<_>>();
        let verdict = |held: &[bool]| Verdict::of(&parts(held));
        assert_eq!([&[true, true][..], &[true, false], &[false], &[]].map(verdict), {
            use Verdict::*;
            [Reproduced, Partly, Not, Not]
        });
    }
}
