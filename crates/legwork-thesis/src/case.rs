//! The eight runs that the thesis's tables and figures stand for: walk and push, baseline and final design, each in
//! both readings of the least step length.

use serde::{Deserialize, Serialize};

/// How the thesis's least step length is read (docs/parameters.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reading {
    /// As the least way of a foot: the default set of parameters.
    Displacement,
    /// As the least distance of the feet after a step: the set of `walk-support` and `push-support`.
    BaseOfSupport,
}

impl Reading {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Displacement, Self::BaseOfSupport];

    /// Its name, as the setting `reference.step.min_length_is` has it.
    pub fn name(self) -> &'static str {
        ["displacement", "base-of-support"][self as usize]
    }
}

/// Which of the thesis's two experiments (5.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Experiment {
    /// Walking at 0.5 m/s.
    Walk,
    /// A push of 140 Ns.
    Push,
}

impl Experiment {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Walk, Self::Push];

    /// Its name.
    pub fn name(self) -> &'static str {
        ["walk", "push"][self as usize]
    }
}

/// Which of the thesis's two sets of controller parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gains {
    /// Table D.1, at 220 Nm.
    Baseline,
    /// Tables 6.3 and G.1.
    Final,
}

/// One of the eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Case {
    /// The reading.
    pub reading: Reading,
    /// The experiment.
    pub experiment: Experiment,
    /// The parameters.
    pub gains: Gains,
}

impl Case {
    /// The case of these.
    pub fn new(reading: Reading, experiment: Experiment, gains: Gains) -> Self {
        Self { reading, experiment, gains }
    }

    /// All eight.
    pub fn all() -> impl Iterator<Item = Self> {
        let of = |reading| {
            let gains = [Gains::Baseline, Gains::Final];
            gains.into_iter().flat_map(move |g| Experiment::ALL.map(|experiment| Self::new(reading, experiment, g)))
        };
        Reading::ALL.into_iter().flat_map(of)
    }

    /// The built-in scenario.
    pub fn scenario(self) -> &'static str {
        use {Experiment::*, Gains::*, Reading::*};
        match (self.reading, self.experiment, self.gains) {
            (Displacement, Walk, Baseline) => "walk-baseline",
            (Displacement, Push, Baseline) => "push-baseline",
            (Displacement, Walk, Final) => "walk",
            (Displacement, Push, Final) => "push",
            (BaseOfSupport, Walk, Baseline) => "walk-support-baseline",
            (BaseOfSupport, Push, Baseline) => "push-support-baseline",
            (BaseOfSupport, Walk, Final) => "walk-support",
            (BaseOfSupport, Push, Final) => "push-support",
        }
    }

    /// The case of that scenario.
    pub(crate) fn of_scenario(name: &str) -> Option<Self> {
        Self::all().find(|case| case.scenario() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use legwork::library;
    use legwork::scenario::LeastStep;
    use legwork::scenario_file;

    #[test]
    fn each_case_is_a_scenario_of_its_reading_experiment_and_gains() {
        assert_eq!(Case::all().count(), 8);
        for case in Case::all() {
            assert!(library::scenario_text(case.scenario()).is_some());
            assert_eq!(Case::of_scenario(case.scenario()), Some(case));
            let scenario = scenario_file::load(case.scenario(), &[]).expect("it is built in").scenario;
            let is_support = scenario.reference.step.min_length_is == LeastStep::BaseOfSupport;
            assert_eq!(is_support, case.reading == Reading::BaseOfSupport);
            assert_eq!(!scenario.pushes.is_empty(), case.experiment == Experiment::Push);
            assert_eq!(scenario.controller.weights.feet == 1e5, case.gains == Gains::Baseline);
        }
    }
}
