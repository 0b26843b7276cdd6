//! What the thesis says of its results, claim by claim, each with its test: `claims.toml`, tested by the judges.

mod judge;
mod logs;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::case::{Case, Experiment, Gains, Reading};
use super::evidence::Evidence;
use super::terms::Check;
use super::trial::Trial;
use judge::{Asked, judge};

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
        ["reproduced", "partly", "not"][self as usize]
    }

    fn of(checks: &[Check]) -> Self {
        match checks.iter().filter(|check| check.holds).count() {
            0 => Self::Not,
            held if held == checks.len() => Self::Reproduced,
            _ => Self::Partly,
        }
    }
}

/// Why a claim that is reproduced is no evidence for the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// The values that the thesis does not give were chosen so that its figure comes out.
    Fitted,
    /// The code does what the claim says; only a defect could fail the test.
    ByConstruction,
}

impl Basis {
    /// It in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Fitted => "fitted",
            Self::ByConstruction => "by construction",
        }
    }
}

/// Where the figures of a claim can be looked up.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// The file, without its ending.
    pub file: String,
    /// Its rows: of `sweeps` those of this study, else in words.
    pub rows: String,
    /// Its columns.
    pub columns: Vec<String>,
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
    /// Why a success says less than it seems to, where it does.
    pub basis: Option<Basis>,
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

impl Claim {
    /// What the thesis says, and in brackets why a success says less than it seems to.
    pub fn says_and_basis(&self) -> String {
        self.basis.map_or_else(|| self.says.to_owned(), |basis| format!("{} ({})", self.says, basis.words()))
    }

    /// The section of the thesis.
    pub fn section(&self) -> &'static str {
        self.id.rsplit_once('-').map_or(self.id, |(section, _)| section)
    }
}

/// The file of claims.
#[derive(Deserialize)]
struct Claims {
    /// Why the claims about the push fail in one reading, which `why` calls `falls`.
    falls: String,
    claims: BTreeMap<String, Test>,
}

/// A claim with its test.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Test {
    says: String,
    test: String,
    basis: Option<Basis>,
    parts: Vec<Part>,
    source: Option<Source>,
    /// By reading, or of `both`.
    #[serde(default)]
    why: BTreeMap<String, String>,
}

/// A part of a test: a judge and what it asks about. Which of these fields a judge needs, it says.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Part {
    is: String,
    /// A study.
    #[serde(default)]
    over: String,
    /// Its first level and its last.
    #[serde(default)]
    from: f64,
    #[serde(default = "unbounded")]
    to: f64,
    /// Figures of a run by their columns, or limits by their names.
    #[serde(default)]
    of: Vec<String>,
    only: Option<Experiment>,
    /// Another run than the final design's: a scenario, or the final design's own where none is named, with these settings.
    scenario: Option<String>,
    #[serde(default)]
    with: Vec<String>,
    /// What the thesis publishes, and how far from it is still met.
    #[serde(default)]
    published: f64,
    #[serde(default)]
    within: f64,
}

fn unbounded() -> f64 {
    f64::INFINITY
}

static CLAIMS: LazyLock<Claims> =
    LazyLock::new(|| toml::from_str(include_str!("claims.toml")).expect("the file of claims is ours"));

impl Part {
    /// The experiments that it is asked of.
    fn experiments(&self) -> impl Iterator<Item = Experiment> {
        let only = self.only;
        Experiment::ALL.into_iter().filter(move |&experiment| only.is_none_or(|only| only == experiment))
    }

    /// The run that it is about.
    fn trial(&self, case: Case) -> Trial {
        let scenario = self.scenario.clone().unwrap_or_else(|| case.scenario().to_owned());
        Trial { scenario, sets: self.with.clone() }
    }
}

/// The runs that claims need beside those of the thesis, each once.
pub(super) fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for part in CLAIMS.claims.values().flat_map(|test| &test.parts) {
        for (experiment, reading) in part.experiments().flat_map(|e| Reading::ALL.map(|r| (e, r))) {
            let trial = part.trial(Case::new(reading, experiment, Gains::Final));
            if (part.scenario.is_some() || !part.with.is_empty()) && !trials.contains(&trial) {
                trials.push(trial);
            }
        }
    }
    trials
}

impl Test {
    fn checks(&'static self, evidence: &Evidence, reading: Reading) -> Vec<Check> {
        let of = |part: &'static Part| {
            part.experiments()
                .flat_map(move |experiment| judge(&part.is)(&Asked { part, evidence, reading, experiment }))
        };
        self.parts.iter().flat_map(of).collect()
    }

    fn why(&'static self, reading: Reading) -> Option<&'static str> {
        let why = self.why.get(reading.name()).or(self.why.get("both"))?;
        Some(if why == "falls" { &CLAIMS.falls } else { why })
    }

    /// Where nothing else is said: the figures of the first part, or endings where it has none.
    fn source(&self) -> Source {
        let of = |part: &Part| if part.of.is_empty() { vec!["ending".to_owned()] } else { part.of.clone() };
        let first = || Source { file: "sweeps".into(), rows: self.parts[0].over.clone(), columns: of(&self.parts[0]) };
        self.source.clone().unwrap_or_else(first)
    }
}

/// All claims, tested.
pub(super) fn claims(evidence: &Evidence) -> Vec<Claim> {
    let claim = |(id, test): (&'static String, &'static Test)| {
        let finding = |reading| {
            let checks = test.checks(evidence, reading);
            let verdict = Verdict::of(&checks);
            let why = test.why(reading).filter(|_| verdict != Verdict::Reproduced);
            Finding { reading, verdict, checks, why }
        };
        let findings = Reading::ALL.map(finding).to_vec();
        Claim { id, says: &test.says, test: &test.test, basis: test.basis, source: test.source(), findings }
    };
    CLAIMS.claims.iter().map(claim).collect()
}

#[cfg(test)]
mod unit_tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::sweep::{STUDIES, studies};

    #[test]
    fn every_section_has_its_claims_and_every_part_its_judge() {
        let sections: BTreeSet<_> = CLAIMS.claims.keys().map(|id| id.rsplit_once('-').expect("a letter").0).collect();
        let wanted = "6.1 6.3.1 6.3.2 6.3.3 6.3.4 6.3.5 6.3.6 6.3.7 6.3.8 6.4 7.1 7.1.1 7.1.2 7.1.3 7.1.4 7.1.5 7.2.1 7.2.2 7.4 \
             7.5 8.1.1 8.1.2 8.2";
        assert_eq!(sections, wanted.split(' ').collect());
        let used: BTreeSet<&str> =
            CLAIMS.claims.values().flat_map(|test| &test.parts).map(|part| part.is.as_str()).collect();
        assert_eq!(used, judge::judges().map(|(name, _)| *name).collect());
        for (id, test) in &CLAIMS.claims {
            let known = |reading: &String| reading == "both" || Reading::ALL.iter().any(|r| r.name() == reading);
            assert!(!test.parts.is_empty() && test.why.keys().all(known), "{id}");
            assert!(test.parts.iter().all(|part| part.over.is_empty() || STUDIES.iter().any(|s| s.0 == part.over)));
        }
    }

    #[test]
    fn an_explanation_names_what_shows_it_or_is_called_a_conjecture() {
        let shows = ["(limits: ", "(sweep", "(question ", "(runs: ", "(tables: ", "(logs: ", "As 6", "As 7", "docs/"];
        for (id, why) in CLAIMS.claims.iter().flat_map(|(id, test)| test.why.values().map(move |why| (id, why))) {
            let shown = why == "falls" || shows.iter().any(|name| why.contains(name));
            assert!(shown || why.contains("Conjecture: "), "{id}: {why}");
        }
    }

    #[test]
    fn the_sources_of_sweeps_are_studies_and_their_columns() {
        let studies = studies().expect("they are built in");
        let mut seen = BTreeSet::new();
        for (id, test) in CLAIMS.claims.iter().filter(|(_, test)| test.source().file == "sweeps") {
            let source = test.source();
            let study = studies.iter().find(|study| study.name == source.rows);
            let study = study.unwrap_or_else(|| panic!("{id}: no study {}", source.rows));
            seen.insert(&study.name);
            for name in &source.columns {
                let known = study.columns().iter().any(|column| column.name == *name);
                let ours = ["ending", "momentum_rate_limited_fraction"].contains(&name.as_str());
                assert!(known || ours, "{id}: no column {name}");
            }
        }
        assert_eq!(seen.len(), studies.len());
    }

    #[test]
    fn the_verdict_follows_from_the_parts() {
        use Verdict::*;
        let verdict = |held: &[bool]| Verdict::of(&held.iter().map(|&h| Check::new(h, "")).collect::<Vec<_>>());
        let verdicts = [&[true, true][..], &[true, false], &[false], &[]].map(verdict);
        assert_eq!(verdicts, [Reproduced, Partly, Not, Not]);
    }
}
