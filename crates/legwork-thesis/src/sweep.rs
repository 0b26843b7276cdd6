//! The thesis's nine sweeps (Appendices E and F): a controller parameter over its levels, all others at the baseline.

use serde::Serialize;

use super::case::{Case, Experiment, Reading};
use legwork::episode::Run;
use legwork::error::Error;
use legwork::log::Field;
use legwork::metrics::{FIGURES, Figure};
use legwork_study::{Level, Rollout, Study};

/// Mean distance of the centre of mass from its reference.
pub const COM: &str = "com_error_m.mean";
/// Mean distance of a foot from its reference.
pub const FEET: &str = "feet_error_m.mean";
/// Mean absolute joint torque.
pub(crate) const TORQUE: &str = "torque_nm.mean";

/// The studies with the parameter's symbol and the thesis's figures of the walk and of the push.
pub const STUDIES: [(&str, &str, [&str; 2]); 9] = [
    ("torque-limit", "τ_max", ["E.1", "E.2"]),
    ("grf-limit", "ρ_max", ["F.1", "F.2"]),
    ("grf-weight", "C_ρ", ["F.3", "F.4"]),
    ("acceleration-weight", "C_v", ["F.5", "F.6"]),
    ("momentum-weight", "C_m", ["F.7", "F.8"]),
    ("feet-weight", "C_f", ["F.9", "F.10"]),
    ("torso-weight", "C_a", ["F.11", "F.12"]),
    ("com-gain", "P_C", ["F.13", "F.14"]),
    ("foot-gain", "P_f", ["F.15", "F.16"]),
];

/// A parameter's levels in one experiment and reading, with the rollout of each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sweep {
    /// The built-in study.
    pub study: String,
    /// The parameter's symbol in the thesis.
    pub symbol: &'static str,
    /// The thesis's figure.
    pub figure: &'static str,
    /// The scenario.
    pub scenario: String,
    /// Which of the eight cases that is.
    pub case: Case,
    /// The parameter in words.
    pub factor: String,
    /// Its setting.
    pub path: String,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// Whether its axis is best drawn logarithmic.
    pub is_logarithmic: bool,
    /// The baseline's own level.
    pub marked: f64,
    /// The levels in rising order.
    pub levels: Vec<Tried>,
}

/// A level that was tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tried {
    /// The level.
    pub level: f64,
    /// What the run gave; its figures are [`legwork_study::rollout::columns`].
    pub rollout: Rollout,
    /// Share of the ticks in which the horizontal momentum rate asked for is at the planner's limit.
    pub momentum_rate_limited_fraction: f64,
}

/// The share of the ticks of a run in which the horizontal momentum rate asked for (4.4) is at the planner's limit.
pub(crate) fn momentum_rate_limited_fraction(run: &Run) -> f64 {
    let horizontal = run.log.range(Field::MomentumRateGoal).start + run.model.angular_axes().len();
    let limit = run.scenario.controller.planner.max_horizontal_momentum_rate_n;
    let limited = run.log.column(horizontal).filter(|rate| rate.abs() >= limit).count();
    limited as f64 / run.log.len().max(1) as f64
}

/// The nine studies.
///
/// # Errors
/// None, unless a built-in study is not one of the thesis's sweeps.
pub fn studies() -> Result<Vec<Study>, Error> {
    STUDIES.iter().map(|(name, ..)| Study::load(name, &[])).collect()
}

/// The rollouts of a study that have a level: a study also runs the scenario as it stands, which is a level of each of
/// the thesis's sweeps already.
pub(crate) fn levels_of(study: &Study) -> impl Iterator<Item = u64> + '_ {
    (0..study.len()).filter(|&index| study.point(index).levels[0].is_some())
}

impl Sweep {
    /// The sweeps that the rollouts of a study are, one for each of its scenarios; `runs` are those of [`levels_of`]
    /// with the share of [`momentum_rate_limited_fraction`].
    ///
    /// # Errors
    /// The study is not one of the thesis's sweeps.
    pub(crate) fn all_of(
        study: &Study,
        runs: impl IntoIterator<Item = (u64, Rollout, f64)>,
    ) -> Result<Vec<Self>, Error> {
        let wrong = |problem: &str| Error::invalid(format!("study {}", study.name), problem.to_owned());
        let known = STUDIES.iter().find(|(name, ..)| *name == study.name);
        let (_, symbol, figures) = known.ok_or_else(|| wrong("is none of the thesis's sweeps"))?;
        let [factor] = study.factors.as_slice() else { return Err(wrong("has not one factor")) };
        let (marked, _) = factor.marked.clone().ok_or_else(|| wrong("marks no level"))?;
        let mut sweeps = Vec::new();
        for base in &study.bases {
            let case = Case::of_scenario(base.name()).ok_or_else(|| wrong("has another scenario than the thesis"))?;
            sweeps.push(Self {
                study: study.name.clone(),
                symbol,
                figure: figures[usize::from(case.experiment == Experiment::Push)],
                scenario: base.name().to_owned(),
                case,
                factor: factor.name.clone(),
                path: factor.paths[0].clone(),
                unit: factor.unit(),
                is_logarithmic: factor.levels.is_logarithmic(),
                marked,
                levels: Vec::new(),
            });
        }
        for (index, rollout, momentum_rate_limited_fraction) in runs {
            let point = study.point(index);
            let level = point.levels[0].as_ref().and_then(Level::number);
            let level = level.ok_or_else(|| wrong("has a level that is no number"))?;
            sweeps[point.base].levels.push(Tried { level, rollout, momentum_rate_limited_fraction });
        }
        for sweep in &mut sweeps {
            sweep.levels.sort_by(|a, b| a.level.total_cmp(&b.level));
            if !sweep.levels.iter().any(|tried| is_same(tried.level, sweep.marked)) {
                return Err(wrong("does not run the level that it marks"));
            }
        }
        Ok(sweeps)
    }

    /// The reading that it is of.
    pub fn reading(&self) -> Reading {
        self.case.reading
    }

    /// What was tried at the baseline's own level.
    pub fn at_marked(&self) -> &Tried {
        self.at(self.marked).expect("it was checked when the sweep was made")
    }

    /// What was tried at `level`.
    pub fn at(&self, level: f64) -> Option<&Tried> {
        self.levels.iter().find(|tried| is_same(tried.level, level))
    }

    /// The levels from `low` to `high`, both with them.
    pub(crate) fn between(&self, low: f64, high: f64) -> impl DoubleEndedIterator<Item = &Tried> + Clone {
        let inside = move |level: f64| (level >= low || is_same(level, low)) && (level <= high || is_same(level, high));
        self.levels.iter().filter(move |tried| inside(tried.level))
    }
}

impl Tried {
    /// A figure of a run that lasted its full time; none of a fall, whose figures are of a shorter time.
    pub fn figure(&self, name: &str) -> Option<f64> {
        figure(&self.rollout, name).filter(|_| self.rollout.survived())
    }
}

/// A figure of a rollout by its name in [`FIGURES`], fallen or not.
pub(crate) fn figure(rollout: &Rollout, name: &str) -> Option<f64> {
    let index = FIGURES.iter().position(|figure| figure.name == name)?;
    rollout.figures.get(index).copied().flatten()
}

/// The figure of that name.
pub(crate) fn definition(name: &str) -> &'static Figure {
    FIGURES.iter().find(|figure| figure.name == name).unwrap_or_else(|| panic!("no figure {name}"))
}

/// Whether two levels are one, but for the last digits that a range in equal ratios leaves.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use legwork_study::Ending;

    fn rollout(com: f64, ending: Ending) -> Rollout {
        let mut rollout = Rollout::invalid(String::new());
        rollout.ending = ending;
        rollout.figures = vec![Some(com)];
        rollout
    }

    #[test]
    fn a_study_becomes_a_sweep_a_scenario_with_rising_levels() {
        for study in studies().expect("they are built in") {
            let runs = levels_of(&study).map(|index| (index, rollout(index as f64, Ending::Completed), 0.0));
            let sweeps = Sweep::all_of(&study, runs).expect("it is one of the thesis's");
            assert_eq!(sweeps.len(), 4);
            for sweep in &sweeps {
                assert_eq!(sweep.levels.len() as u64, study.len() / 4 - 1);
                assert!(sweep.levels.windows(2).all(|pair| pair[0].level < pair[1].level));
                // The figure is the number of the rollout, which leads back to the level.
                for tried in &sweep.levels {
                    let point = study.point(tried.figure(COM).expect("it stands") as u64);
                    assert_eq!(point.levels[0].as_ref().and_then(|level| level.number()), Some(tried.level));
                    assert_eq!(study.bases[point.base].name(), sweep.scenario);
                }
            }
        }
    }

    #[test]
    fn the_figures_of_a_fall_do_not_count() {
        let tried = |ending| Tried { level: 1.0, rollout: rollout(0.5, ending), momentum_rate_limited_fraction: 0.0 };
        assert_eq!((tried(Ending::Completed).figure(COM), tried(Ending::Fell).figure(COM)), (Some(0.5), None));
    }
}
