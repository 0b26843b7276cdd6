//! Everything that the thesis reports, beside what is measured: its tables, figures, limits and claims, and the
//! questions that it left open.
//!
//! All of it is run in both readings of the least step length ([`case::Reading`]). What is run is fixed
//! ([`sweep::STUDIES`], [`trial::trials`], [`limits::sought`]); what it says is computed from it, and [`files`] writes
//! it so that others can.

pub mod case;
pub mod claims;
mod curve;
pub mod evidence;
pub mod files;
pub mod limits;
pub mod published;
pub mod questions;
mod replay;
mod statistics;
pub mod sweep;
pub mod tables;
pub mod terms;
pub mod trial;
pub mod words;

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use case::{Case, Reading};
use claims::Claim;
use evidence::Evidence;
use limits::{Sought, sought};
use questions::Question;
use sweep::{Sweep, momentum_rate_limited_fraction};
use trial::{Trial, TrialResult};

use legwork::episode::{Outcome, Run};
use legwork::error::Error;
use legwork_study::parallel::run_all;
use legwork_study::rollout::{Column, simulate};
use legwork_study::{Rollout, Study};

/// The whole comparison.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// What was run.
    pub evidence: Evidence,
    /// Tables 6.1 to 6.5.
    pub tables: Vec<tables::Table>,
    /// The claims with their verdicts.
    pub claims: Vec<Claim>,
    /// The questions with their answers.
    pub questions: Vec<Question>,
    /// The figures of a rollout, in their order.
    pub columns: Vec<Column>,
}

/// What is run, and about how many rollouts each piece of it takes.
struct Plan {
    studies: Vec<Study>,
    limits: Vec<(&'static Sought, Reading)>,
    timed: Vec<Case>,
    cases: Vec<Case>,
    /// The study, and the number of its rollout.
    levels: Vec<(usize, u64)>,
    trials: Vec<Trial>,
}

const LIMIT_SIZE: u64 = 14;
const TIMED_SIZE: u64 = 6;

impl Plan {
    fn new() -> Result<Self, Error> {
        let studies = sweep::studies()?;
        let levels = studies.iter().enumerate().flat_map(|(s, study)| sweep::levels_of(study).map(move |l| (s, l)));
        Ok(Self {
            limits: sought().iter().flat_map(|sought| Reading::ALL.map(|reading| (sought, reading))).collect(),
            timed: questions::timed_cases().collect(),
            cases: Case::all().collect(),
            levels: levels.collect(),
            trials: trial::trials(),
            studies,
        })
    }

    fn size(&self) -> u64 {
        let single = self.cases.len() + self.levels.len() + self.trials.len();
        LIMIT_SIZE * self.limits.len() as u64 + TIMED_SIZE * self.timed.len() as u64 + single as u64
    }
}

/// How much there is to do, in rollouts.
///
/// # Errors
/// As [`run`].
pub fn amount() -> Result<u64, Error> {
    Ok(Plan::new()?.size())
}

/// Runs everything on all cores and compares. Same on any number of threads, but for measured times.
///
/// `progress` is told how much of [`amount`] is done, out of order at times. None where `stop` says so before the end.
///
/// # Errors
/// None, unless a built-in file is not valid.
pub fn run(progress: impl Fn(u64) + Sync, stop: impl Fn() -> bool + Sync) -> Result<Option<Reproduction>, Error> {
    let (plan, done) = (Plan::new()?, AtomicU64::new(0));
    let (stop, studies) = (&stop, &plan.studies);
    let told = |size: u64| progress(done.fetch_add(size, Relaxed) + size);
    let whole = |run: Run| (!matches!(run.outcome, Outcome::Stopped)).then_some(run);
    // None of a piece that was stopped.
    let limit = |(sought, reading): &(&'static Sought, _)| sought.search(*reading, stop);
    let case = |case: &Case| Ok(whole(Trial::of_case(*case, Vec::new()).run(stop)?));
    let level = |(study, index): &(usize, u64)| {
        let run = whole(simulate(&studies[*study].variant(&studies[*study].point(*index))?, stop)?);
        Ok(run.map(|run| (*index, Rollout::of(&run), momentum_rate_limited_fraction(&run))))
    };
    let trial = |trial: &Trial| Ok(whole(trial.run(stop)?).map(|run| TrialResult::of(trial.clone(), &run)));
    let Some(answers) = all(&plan.limits, limit, || told(LIMIT_SIZE), stop)? else { return Ok(None) };
    let timed = |case: &Case| questions::time_forms(*case, stop);
    let Some(times) = all(&plan.timed, timed, || told(TIMED_SIZE), stop)? else { return Ok(None) };
    let Some(runs) = all(&plan.cases, case, || told(1), stop)? else { return Ok(None) };
    let Some(levels) = all(&plan.levels, level, || told(1), stop)? else { return Ok(None) };
    let Some(trials) = all(&plan.trials, trial, || told(1), stop)? else { return Ok(None) };

    let (mut sweeps, mut levels) = (Vec::new(), levels.into_iter());
    for study in studies {
        sweeps.extend(Sweep::all_of(study, levels.by_ref().take(sweep::levels_of(study).count()))?);
    }
    let cases = plan.cases.iter().zip(&runs).map(|(case, run)| TrialResult::of(Trial::of_case(*case, Vec::new()), run));
    let trials = cases.chain(trials).collect();
    let pairs = answers.chunks(Reading::ALL.len());
    let limits = sought().iter().zip(pairs).map(|(sought, answers)| sought.row(answers)).collect();
    let mut evidence = Evidence { runs, sweeps, trials, limits };
    evidence.limits.extend(limits::of_runs(|case| evidence.run(case)));
    let replayed = questions::replayed().filter(|(case, _)| evidence.run(*case).reason.is_none());
    let replay = |(case, sets): &(Case, Vec<String>)| replay::replay(evidence.run(*case), sets).map(Some);
    let Some(replays) = all(&replayed.collect::<Vec<_>>(), replay, || (), stop)? else { return Ok(None) };
    Ok(Some(Reproduction {
        tables: tables::tables(|case| evidence.run(case)),
        claims: claims::claims(&evidence),
        questions: questions::questions(&evidence, &times, &replays),
        columns: studies[0].columns(),
        evidence,
    }))
}

/// Does `work` for each piece on all cores; none where it is stopped.
fn all<J: Sync, T: Send>(
    pieces: &[J],
    work: impl Fn(&J) -> Result<Option<T>, Error> + Sync,
    done: impl Fn() + Sync,
    stop: &(impl Fn() -> bool + Sync),
) -> Result<Option<Vec<T>>, Error> {
    let results = run_all(pieces.len(), |index| {
        let result = if stop() { None } else { work(&pieces[index]).transpose() }?;
        done();
        Some(result)
    });
    results.map(|results| results.into_iter().collect()).transpose()
}

impl Reproduction {
    /// How many claims have each of [`claims::Verdict::ALL`] in a reading.
    pub fn counts(&self, reading: Reading) -> [usize; 3] {
        claims::Verdict::ALL.map(|verdict| {
            let has = |claim: &&Claim| claim.findings.iter().any(|f| f.reading == reading && f.verdict == verdict);
            self.claims.iter().filter(has).count()
        })
    }

    /// How many of the claims that are reproduced in a reading are no evidence: [`claims::Basis`].
    pub fn without_evidence(&self, reading: Reading) -> usize {
        let reproduced = |claim: &Claim| {
            claim.findings.iter().any(|f| f.reading == reading && f.verdict == claims::Verdict::Reproduced)
        };
        self.claims.iter().filter(|claim| claim.basis.is_some() && reproduced(claim)).count()
    }

    /// How many of the runs and of the sweeps' rollouts broke bounds of the simulator's audit, and how many there are.
    pub fn doubtful(&self) -> [usize; 2] {
        let levels = self.evidence.sweeps.iter().flat_map(|sweep| &sweep.levels).map(|tried| &tried.rollout);
        let rollouts = || levels.clone().chain(self.evidence.trials.iter().map(|result| &result.rollout));
        [rollouts().filter(|rollout| rollout.violations.is_some()).count(), rollouts().count()]
    }

    /// All but the logs as JSON.
    pub fn to_json(&self) -> serde_json::Value {
        let columns: Vec<_> = self
            .columns
            .iter()
            .map(|column| serde_json::json!({ "name": column.name, "label": column.label, "unit": column.unit }))
            .collect();
        let terms: Vec<_> = terms::terms()
            .into_iter()
            .map(|(term, meaning)| serde_json::json!({ "term": term, "meaning": meaning }))
            .collect();
        serde_json::json!({
            "readings": Reading::ALL,
            "terms": terms,
            "tables": self.tables,
            "limits": self.evidence.limits,
            "claims": self.claims,
            "questions": self.questions,
            "columns": columns,
            "sweeps": self.evidence.sweeps,
            "runs": self.evidence.trials,
        })
    }
}
