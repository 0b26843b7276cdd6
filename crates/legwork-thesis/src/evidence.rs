//! All that was run, and how claims and questions find in it what they need.

use super::case::{Case, Experiment, Gains, Reading};
use super::limits::{LimitRow, Measured};
use super::sweep::Sweep;
use super::trial::{Trial, TrialResult};
use legwork::episode::Run;

/// The runs, sweeps, trials and limits.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// The eight cases with their whole logs, in the order of [`Case::all`].
    pub runs: Vec<Run>,
    /// The nine sweeps of each of the baseline's cases.
    pub sweeps: Vec<Sweep>,
    /// The cases and their variants.
    pub trials: Vec<TrialResult>,
    /// The limits.
    pub limits: Vec<LimitRow>,
}

impl Evidence {
    /// The run of a case.
    pub fn run(&self, case: Case) -> &Run {
        let index = Case::all().position(|other| other == case).expect("there are eight cases");
        &self.runs[index]
    }

    /// The run of an experiment's final design.
    pub fn final_run(&self, reading: Reading, experiment: Experiment) -> &Run {
        self.run(Case::new(reading, experiment, Gains::Final))
    }

    /// The run of an experiment's baseline.
    pub(crate) fn baseline_run(&self, reading: Reading, experiment: Experiment) -> &Run {
        self.run(Case::new(reading, experiment, Gains::Baseline))
    }

    /// A sweep by its study.
    ///
    /// # Panics
    /// If `study` is none of [`super::sweep::STUDIES`].
    pub fn sweep(&self, study: &str, reading: Reading, experiment: Experiment) -> &Sweep {
        let is_it = |s: &&Sweep| s.study == study && s.reading() == reading && s.case.experiment == experiment;
        self.sweeps.iter().find(is_it).unwrap_or_else(|| panic!("no sweep {study}"))
    }

    /// What a case with settings gave.
    ///
    /// # Panics
    /// If it is none of [`super::trial::trials`] and no case.
    pub fn trial(&self, case: Case, sets: &[String]) -> &TrialResult {
        self.result(&Trial::of_case(case, sets.to_vec()))
    }

    /// What a trial gave.
    ///
    /// # Panics
    /// As [`Self::trial`].
    pub(crate) fn result(&self, wanted: &Trial) -> &TrialResult {
        let found = self.trials.iter().find(|result| result.trial == *wanted);
        found.unwrap_or_else(|| panic!("not run: {}", wanted.command()))
    }

    /// A limit in a reading.
    ///
    /// # Panics
    /// If there is none of that name.
    pub fn limit(&self, quantity: &str, reading: Reading) -> &Measured {
        self.limit_row(quantity, reading).1
    }

    pub(crate) fn limit_row(&self, quantity: &str, reading: Reading) -> (&LimitRow, &Measured) {
        let row = self.limits.iter().find(|row| row.quantity == quantity);
        let row = row.unwrap_or_else(|| panic!("no limit {quantity}"));
        (row, row.measured.iter().find(|measured| measured.reading == reading).expect("both readings are measured"))
    }
}
