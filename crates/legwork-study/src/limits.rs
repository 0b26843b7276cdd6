//! Limits: the top speed, the largest push, the lowest torque limit that the robot copes with. [`crate::search`] has
//! the method, docs/limits.md the definitions.

use serde::Serialize;
use toml::Value;

use crate::rollout::{self, Rollout};
use crate::search::{Attempt, Found, Search};
use crate::{Base, Change, Variant};
use legwork::error::Error;
use legwork::metrics::FIGURES;
use legwork::scenario::CommandedSpeed;
use legwork::settings::{Setting, Valid};

/// What the start pose's centre of mass is moved by in the tries that confirm a value [m].
const NUDGES_M: [f64; 2] = [-0.001, 0.001];

/// How far the mean speed of the steady walk may be from the one asked for, as a share of it.
pub const SPEED_SHARE: f64 = 0.05;

/// Torque limits at which the thesis asks for the top speed [Nm].
const TORQUES_NM: [f64; 2] = [220.0, 300.0];

/// The change of the whole robot's speed by a push that it will not survive [m/s].
const HOPELESS_MPS: f64 = 4.0;

/// What counts as held; a fall never does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// The robot is on its feet to the end.
    OnItsFeet,
    /// The mean speed of its steady walk is within this share of the one asked for.
    KeepsSpeed(f64),
    /// The mean CoM error of its steady walk is at most this [m].
    Follows(f64),
}

impl Held {
    /// Why a rollout of `variant` did not hold.
    pub fn failure(self, variant: &Variant, rollout: &Rollout) -> Option<String> {
        if !rollout.survived() {
            return Some(rollout.reason.clone().unwrap_or_else(|| rollout.ending.name().to_owned()));
        }
        match self {
            Self::OnItsFeet => None,
            Self::KeepsSpeed(share) => {
                let asked = variant.scenario.reference.commanded_speed().map_or(0.0, |commanded| commanded.speed_mps);
                let Some(speed) = figure(rollout, "steady_speed_mps") else {
                    return Some("the run is too short for a steady walk".to_owned());
                };
                let lost = (speed - asked).abs() > share * asked.abs();
                lost.then(|| format!("{speed:.3} m/s on average where {asked:.3} m/s was asked for"))
            }
            Self::Follows(bound) => match figure(rollout, "steady_com_error_m") {
                Some(error) if error <= bound => None,
                Some(error) => Some(format!("{error:.3} m from its reference on average")),
                None => Some("the run is too short for a CoM error of its steady walk".to_owned()),
            },
        }
    }
}

/// A figure of a rollout by its name in [`FIGURES`].
pub fn figure(rollout: &Rollout, name: &str) -> Option<f64> {
    let index = FIGURES.iter().position(|figure| figure.name == name)?;
    rollout.figures.get(index).copied().flatten()
}

/// The largest force on a contact point of a rollout [N].
pub fn largest_force(rollout: &Rollout) -> Option<f64> {
    figure(rollout, "grf_simulated_n.peak")
}

/// A question for a limit.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// It in words: `largest push forward`.
    pub label: String,
    /// The unit of the answer.
    pub unit: &'static str,
    /// The answer as a multiple of the value that is varied: the duration, where a force is and an impulse is asked for.
    pub factor: f64,
    /// The search.
    pub search: Search,
    base: &'a Base,
    path: &'static str,
    fixed: Vec<(&'static str, Change)>,
    held: Held,
}

/// The answer to a question, all values in its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The scenario.
    pub scenario: String,
    /// The question in words.
    pub question: String,
    /// The unit.
    pub unit: &'static str,
    /// What was found.
    #[serde(flatten)]
    pub found: Found,
}

impl<'a> Question<'a> {
    /// The question how far the number at `path` can go from `from` towards `to`, where `held` says what is held; further
    /// values stay `fixed`.
    ///
    /// # Errors
    /// As [`Base::vary`] with the values at both ends.
    pub fn new(
        base: &'a Base,
        label: &str,
        (path, from, to): (&'static str, f64, f64),
        fixed: Vec<(&'static str, Change)>,
        held: Held,
    ) -> Result<Self, Error> {
        if from == to {
            return Err(Error::invalid(path, format!("found a search from {from} to {to}; valid are two values")));
        }
        let unit = Setting::find(path).map_or("", |setting| setting.unit);
        let (label, search) = (label.to_owned(), Search::new(from, to, NUDGES_M.len() as u32));
        let question = Self { label, unit, factor: 1.0, search, base, path, fixed, held };
        question.variant(from, 0)?;
        question.variant(to, 0)?;
        Ok(question)
    }

    /// What is run to try `value` under a nudge.
    ///
    /// # Errors
    /// As [`Base::vary`].
    pub fn variant(&self, value: f64, nudge: u32) -> Result<Variant, Error> {
        let tried = Change::To(Value::Float(value));
        let mut variant =
            self.base.vary(self.fixed.iter().map(|(path, change)| (*path, change)).chain([(self.path, &tried)]))?;
        variant.scenario.start.com_x_m += nudge_m(nudge);
        Ok(variant)
    }

    /// Searches for the answer; none where `stop` says so before. The same on any number of threads.
    pub fn answer(&self, stop: impl Fn() -> bool + Sync) -> Option<Answer> {
        let mut found = self.search.run(|value, nudge| {
            let (failure, violations, force_n) = match self.variant(value, nudge) {
                Ok(variant) => {
                    let rollout = rollout::run(&variant, &stop)?;
                    let force_n = largest_force(&rollout);
                    (self.held.failure(&variant, &rollout), rollout.violations, force_n)
                }
                Err(error) => (Some(error.to_string()), None, None),
            };
            Some(Attempt { failure: failure.map(|reason| after_nudge(nudge, reason)), violations, force_n })
        })?;
        let scale = |value: &mut f64| *value = (*value * self.factor * 1e9).round() / 1e9;
        [&mut found.value, &mut found.first_failure, &mut found.furthest_held].into_iter().flatten().for_each(scale);
        found.tried.iter_mut().for_each(|trial| scale(&mut trial.value));
        Some(Answer { scenario: self.base.name().to_owned(), question: self.label.clone(), unit: self.unit, found })
    }
}

fn nudge_m(nudge: u32) -> f64 {
    nudge.checked_sub(1).map_or(0.0, |index| NUDGES_M[index as usize])
}

fn after_nudge(nudge: u32, reason: String) -> String {
    if nudge == 0 { reason } else { format!("with the CoM started {:+} mm off: {reason}", 1e3 * nudge_m(nudge)) }
}

/// The questions for a scenario that walks: its top speed at several torque limits, and the lowest limits and friction at
/// which it keeps its speed.
///
/// # Errors
/// The scenario does not walk at a constant speed.
pub fn of_walk(base: &Base) -> Result<Vec<Question<'_>>, Error> {
    let commanded = base.walks()?;
    let (speed, own) = (commanded.speed_mps, base.torque_limit_nm());
    let mut torques = TORQUES_NM.to_vec();
    // A limit above all joints' own is none.
    torques.retain(|&torque| torque <= base.strongest_joint_nm());
    if !torques.contains(&own) {
        torques.push(own);
    }
    let mut questions = Vec::new();
    for torque in torques {
        let criteria = [("kept to 5 %", Held::KeepsSpeed(SPEED_SHARE)), ("followed", follows(base))];
        for (words, held) in criteria {
            let fixed = vec![("controller.limits.torque_nm", Change::To(Value::Float(torque)))];
            let label = format!("top speed {words} at {torque} Nm");
            let range = (commanded.path, speed, fastest(base, commanded, 5.0 * speed));
            questions.push(Question::new(base, &label, range, fixed, held)?);
        }
    }
    questions.extend(lowest(base, Held::KeepsSpeed(SPEED_SHARE))?);
    Ok(questions)
}

/// The questions for a scenario with a push: the largest that it survives forward and backward, and the lowest limits and
/// friction at which it survives its own.
///
/// # Errors
/// The scenario has no push.
pub fn of_push(base: &Base) -> Result<Vec<Question<'_>>, Error> {
    let Variant { scenario, model, .. } = base.variant();
    let Some(push) = scenario.pushes.first() else {
        let problem = "found no push; a question for the largest needs one, as in `push`";
        return Err(Error::invalid(format!("{}: pushes", base.name()), problem));
    };
    let most = (model.total_mass() * HOPELESS_MPS / push.duration_s).min(1e6);
    let mut questions = Vec::new();
    for (way, direction) in [("forward", 0.0), ("backward", 180.0)] {
        let fixed = vec![("pushes.0.direction_deg", Change::To(Value::Float(direction)))];
        let range = ("pushes.0.force_n", 0.0, most);
        let mut question = Question::new(base, &format!("largest push {way}"), range, fixed, Held::OnItsFeet)?;
        (question.unit, question.factor) = ("Ns", push.duration_s);
        questions.push(question);
    }
    questions.extend(lowest(base, Held::OnItsFeet)?);
    Ok(questions)
}

/// The speed that can be set nearest to `hopeless` [m/s], in twentieths of what it is more than the scenario's own.
pub(crate) fn fastest(base: &Base, commanded: CommandedSpeed, hopeless: f64) -> f64 {
    let hopeless = match Setting::find(commanded.path).map(|setting| &setting.valid) {
        Some(&Valid::Number { min, max }) => hopeless.clamp(min, max),
        _ => hopeless,
    };
    let more = |share: u32| commanded.speed_mps + (hopeless - commanded.speed_mps) * f64::from(share) / 20.0;
    let mut speeds = (1..=20).rev().map(|share| if share == 20 { hopeless } else { (more(share) * 1e9).round() / 1e9 });
    speeds.find(|&speed| base.at_speed(commanded, speed).is_ok()).unwrap_or(commanded.speed_mps)
}

/// What counts as following the reference.
pub fn follows(base: &Base) -> Held {
    Held::Follows(base.variant().scenario.metrics.followed_within_m)
}

/// The questions for what can be too low, down to a fiftieth of the scenario's own value; of the torque limit, which begins
/// at the largest that any joint really has.
fn lowest(base: &Base, held: Held) -> Result<Vec<Question<'_>>, Error> {
    let scenario = &base.variant().scenario;
    let limits = &scenario.controller.limits;
    [
        ("lowest torque limit", "controller.limits.torque_nm", base.torque_limit_nm(), 0.1),
        ("lowest force limit", "controller.limits.grf_n", limits.grf_n, 1.0),
        ("lowest friction", "ground.friction", scenario.ground.friction, 0.0),
    ]
    .into_iter()
    .map(|(label, path, own, least)| (label, (path, own, f64::max(0.02 * own, least))))
    // Nothing is below the least that the setting can be.
    .filter(|(_, (_, own, to))| own > to)
    .map(|(label, range)| Question::new(base, label, range, Vec::new(), held))
    .collect()
}
