//! Everything that the thesis reports, beside what is measured: its tables, figures, limits and claims, and the
//! questions that it left open.
//!
//! All of it is run in both readings of the least step length ([`case::Reading`]). What is run is fixed
//! ([`sweep::STUDIES`], [`trial::trials`], [`limits::SOUGHT`]); what it says is computed from it, and [`files`] writes
//! it so that others can.

pub mod case;
pub mod claims;
pub mod curve;
pub mod evidence;
pub mod files;
pub mod limits;
pub mod published;
pub mod questions;
pub mod replay;
pub mod statistics;
pub mod sweep;
pub mod tables;
pub mod terms;
pub mod trial;
pub mod words;

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use case::{Case, Reading};
use claims::Claim;
use evidence::Evidence;
use limits::{SOUGHT, Sought};
use questions::{FormTimes, Question};
use replay::Replay;
use sweep::{Sweep, momentum_rate_limited_fraction};
use trial::{Trial, TrialResult};

use legwork::episode::{Outcome, Run};
use legwork::error::Error;
use legwork_study::limits::Answer;
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

/// A piece of work that can be done beside others.
enum Job<'a> {
    /// A limit in a reading.
    Limit(&'a Sought, Reading),
    /// Both forms of the program in a case.
    Forms(Case),
    /// A case, with its log.
    Case(Case),
    /// A rollout of a study.
    Level(&'a Study, u64),
    /// A variant of a case.
    Trial(Trial),
}

/// What came of it.
enum Done {
    Limit(Answer),
    Forms(FormTimes),
    Case(Box<Run>),
    Level(u64, Rollout, f64),
    Trial(TrialResult),
}

/// Runs everything on all cores and compares. Same on any number of threads, but for measured times.
///
/// `progress` is told how much of [`amount`] is done, out of order at times. None where `stop` says so before the end.
///
/// # Errors
/// None, unless a built-in file is not valid.
pub fn run(progress: impl Fn(u64) + Sync, stop: impl Fn() -> bool + Sync) -> Result<Option<Reproduction>, Error> {
    let studies = sweep::studies()?;
    let jobs = jobs(&studies);
    let done = AtomicU64::new(0);
    let results = run_all(jobs.len(), |index| {
        let result = if stop() { None } else { jobs[index].run(&stop).transpose() }?;
        progress(done.fetch_add(jobs[index].size(), Relaxed) + jobs[index].size());
        Some(result)
    });
    let Some(results) = results else { return Ok(None) };
    let (evidence, times) = gather(&studies, results.into_iter().collect::<Result<Vec<_>, Error>>()?)?;
    let Some(replays) = replays(&evidence, &stop)? else { return Ok(None) };
    let find = |case| evidence.run(case);
    Ok(Some(Reproduction {
        tables: tables::tables(find),
        claims: claims::claims(&evidence),
        questions: questions::questions(&evidence, &times, &replays),
        columns: studies[0].columns(),
        evidence,
    }))
}

/// How much there is to do, in rollouts.
///
/// # Errors
/// As [`run`].
pub fn amount() -> Result<u64, Error> {
    Ok(jobs(&sweep::studies()?).iter().map(Job::size).sum())
}

/// What takes long comes first, so that nobody waits for it at the end.
fn jobs(studies: &[Study]) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for sought in &SOUGHT {
        jobs.extend(Reading::ALL.map(|reading| Job::Limit(sought, reading)));
    }
    jobs.extend(questions::timed_cases().map(Job::Forms));
    jobs.extend(Case::all().map(Job::Case));
    for study in studies {
        jobs.extend(sweep::levels_of(study).map(|index| Job::Level(study, index)));
    }
    jobs.extend(trial::trials().into_iter().map(Job::Trial));
    jobs
}

impl Job<'_> {
    /// About how many rollouts it takes.
    fn size(&self) -> u64 {
        match self {
            Self::Limit(..) => 14,
            Self::Forms(_) => 6,
            Self::Case(_) | Self::Level(..) | Self::Trial(_) => 1,
        }
    }

    /// None where it was stopped.
    fn run(&self, stop: &(impl Fn() -> bool + Sync)) -> Result<Option<Done>, Error> {
        let whole = |run: Run| (!matches!(run.outcome, Outcome::Stopped)).then_some(run);
        Ok(match self {
            Self::Limit(sought, reading) => sought.search(*reading, stop)?.map(Done::Limit),
            Self::Forms(case) => questions::time_forms(*case, stop)?.map(Done::Forms),
            Self::Case(case) => whole(Trial::of_case(*case).run(stop)?).map(|run| Done::Case(Box::new(run))),
            Self::Level(study, index) => whole(simulate(&study.variant(&study.point(*index))?, stop)?)
                .map(|run| Done::Level(*index, Rollout::of(&run), momentum_rate_limited_fraction(&run))),
            Self::Trial(trial) => whole(trial.run(stop)?).map(|run| Done::Trial(TrialResult::of(trial.clone(), &run))),
        })
    }
}

/// Sorts what came of the jobs, whose order it has.
fn gather(studies: &[Study], results: Vec<Done>) -> Result<(Evidence, Vec<FormTimes>), Error> {
    let (mut answers, mut times, mut runs, mut levels, mut trials) = (vec![], vec![], vec![], vec![], vec![]);
    for result in results {
        match result {
            Done::Limit(answer) => answers.push(answer),
            Done::Forms(form_times) => times.push(form_times),
            Done::Case(run) => runs.push(*run),
            Done::Level(index, rollout, limited) => levels.push((index, rollout, limited)),
            Done::Trial(trial) => trials.push(trial),
        }
    }
    let mut sweeps = Vec::new();
    let mut levels = levels.into_iter();
    for study in studies {
        sweeps.extend(Sweep::all_of(study, levels.by_ref().take(sweep::levels_of(study).count()))?);
    }
    let cases = Case::all().zip(&runs).map(|(case, run)| TrialResult::of(Trial::of_case(case), run));
    let trials = cases.collect::<Vec<_>>().into_iter().chain(trials).collect();
    let mut evidence = Evidence { runs, sweeps, trials, limits: Vec::new() };
    let pairs = answers.chunks(Reading::ALL.len());
    evidence.limits = SOUGHT.iter().zip(pairs).map(|(sought, answers)| sought.row(answers)).collect();
    evidence.limits.extend(limits::of_runs(|case| evidence.run(case)));
    Ok((evidence, times))
}

/// The replays that the questions need, of the runs that stand.
fn replays(evidence: &Evidence, stop: &(impl Fn() -> bool + Sync)) -> Result<Option<Vec<Replay>>, Error> {
    let plan: Vec<(Case, Vec<String>)> =
        questions::replayed().filter(|(case, _)| evidence.run(*case).reason.is_none()).collect();
    let replay = |index: usize| {
        let (case, sets) = &plan[index];
        if stop() { None } else { Some(replay::replay(evidence.run(*case), sets)) }
    };
    run_all(plan.len(), replay).map(|replays| replays.into_iter().collect()).transpose()
}

impl Reproduction {
    /// How many claims have each of [`claims::Verdict::ALL`] in a reading.
    pub fn counts(&self, reading: Reading) -> [usize; 3] {
        claims::Verdict::ALL.map(|verdict| {
            let has = |claim: &&Claim| claim.findings.iter().any(|f| f.reading == reading && f.verdict == verdict);
            self.claims.iter().filter(has).count()
        })
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
