//! What the actuators must deliver: a joint's torque, speed and power in a walk and a push, and the pairs of speed and
//! torque limit that the robot copes with.

use serde::Serialize;
use toml::Value;

use crate::limits::{Held, SPEED_SHARE, fastest, figure, follows};
use crate::rollout::{self, Ending};
use crate::{Base, Change, Variant};
use legwork::episode::Run;
use legwork::error::Error;
use legwork::log::Field;
use legwork::metrics::JointUse;

/// Bins of a torque-speed cloud along each axis.
const BINS: usize = 24;

/// What a joint's actuator must deliver; see [`JointUse`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Demand {
    /// The joint's name.
    pub joint: String,
    /// Largest absolute torque [Nm].
    pub torque_peak_nm: f64,
    /// Root of the mean squared torque [Nm].
    pub torque_rms_nm: f64,
    /// Largest absolute speed [rad/s].
    pub speed_peak_radps: f64,
    /// Largest absolute power [W].
    pub power_peak_w: f64,
    /// Mean absolute power [W].
    pub power_mean_w: f64,
    /// Share of the ticks in which the torque is at the joint's limit, the controller's or its own: the peak then says
    /// nothing of the need.
    pub at_limit: f64,
}

/// What a scenario asked of the actuators.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Use {
    /// The scenario.
    pub scenario: String,
    /// How it ended; where the robot fell, the figures are up to the fall.
    pub ending: Ending,
    /// Why it fell.
    pub reason: Option<String>,
    /// Bounds of the simulator's audit that the run broke, in words.
    pub violations: Option<String>,
    /// Each actuated joint.
    pub joints: Vec<Demand>,
    /// Torque against speed, a cloud for each joint.
    pub clouds: Vec<Cloud>,
    /// Speed [rad/s] and torque [Nm] of each joint at every tick, which the clouds count.
    #[serde(skip)]
    pub points: Vec<Vec<[f64; 2]>>,
}

/// How often a joint was at which speed and torque.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cloud {
    /// The joint's name.
    pub joint: String,
    /// Bounds of the bins in speed [rad/s].
    pub speed_edges_radps: Vec<f64>,
    /// Bounds of the bins in torque [Nm].
    pub torque_edges_nm: Vec<f64>,
    /// Ticks in each bin: a row for each bin of torque, from the least up, with a number for each bin of speed.
    pub ticks: Vec<Vec<u32>>,
}

/// The table of several scenarios together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sizing {
    /// Each scenario.
    pub uses: Vec<Use>,
    /// The largest of each figure over the scenarios.
    pub envelope: Vec<Demand>,
    /// How much more an actuator should be able to do, as a share.
    pub margin: f64,
    /// The envelope with the margin; of `at_limit` as it is.
    pub required: Vec<Demand>,
}

impl Demand {
    fn of(used: &JointUse, at_limit: f64) -> Self {
        Self {
            joint: used.joint.clone(),
            torque_peak_nm: used.torque_peak_nm,
            torque_rms_nm: used.torque_rms_nm,
            speed_peak_radps: used.speed_peak_radps,
            power_peak_w: used.power_peak_w,
            power_mean_w: used.power_mean_w,
            at_limit,
        }
    }

    /// Each figure made of both's; `at_limit` is the larger.
    fn with(&self, other: &Self, made: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            joint: self.joint.clone(),
            torque_peak_nm: made(self.torque_peak_nm, other.torque_peak_nm),
            torque_rms_nm: made(self.torque_rms_nm, other.torque_rms_nm),
            speed_peak_radps: made(self.speed_peak_radps, other.speed_peak_radps),
            power_peak_w: made(self.power_peak_w, other.power_peak_w),
            power_mean_w: made(self.power_mean_w, other.power_mean_w),
            at_limit: self.at_limit.max(other.at_limit),
        }
    }
}

impl Use {
    /// What a run asked of the actuators.
    pub fn of(run: &Run) -> Self {
        let limit = run.scenario.controller.limits.torque_nm;
        let row = rollout::Rollout::of(run);
        let asked = run.log.range(Field::Torque);
        let joints = run.metrics.joints.iter().zip(asked).map(|(used, column)| {
            let own =
                run.model.dofs.iter().find(|dof| dof.name == used.joint).map_or(f64::INFINITY, |dof| dof.effort_limit);
            let limit = limit.min(own);
            let at_limit = run.log.column(column).filter(|torque| torque.abs() >= limit * (1.0 - 1e-6)).count();
            Demand::of(used, at_limit as f64 / run.log.len().max(1) as f64)
        });
        let uses = run.metrics.joints.iter().enumerate();
        let points: Vec<Vec<[f64; 2]>> = uses.clone().map(|(index, used)| points(run, index, used)).collect();
        Self {
            scenario: run.scenario.name.clone(),
            ending: row.ending,
            reason: row.reason,
            violations: row.violations,
            joints: joints.collect(),
            clouds: uses.map(|(index, used)| cloud(&points[index], used)).collect(),
            points,
        }
    }
}

/// Speed and applied torque of one joint at every tick.
fn points(run: &Run, index: usize, used: &JointUse) -> Vec<[f64; 2]> {
    let torque = run.log.range(Field::TorqueApplied).start + index;
    let name = format!("v.{}", used.joint);
    let speed = run.log.columns().iter().position(|column| column.name == name).expect("an actuated joint moves");
    run.log.column(speed).zip(run.log.column(torque)).map(|(speed, torque)| [speed, torque]).collect()
}

/// The cloud of one joint, over symmetric ranges up to its peaks.
fn cloud(points: &[[f64; 2]], used: &JointUse) -> Cloud {
    let mut ticks = vec![vec![0; BINS]; BINS];
    for &[speed, torque] in points {
        ticks[bin(torque, used.torque_peak_nm)][bin(speed, used.speed_peak_radps)] += 1;
    }
    Cloud {
        joint: used.joint.clone(),
        speed_edges_radps: edges(used.speed_peak_radps),
        torque_edges_nm: edges(used.torque_peak_nm),
        ticks,
    }
}

/// The bin of `value` where the bins go from minus to plus `peak`; the last holds its upper bound too.
fn bin(value: f64, peak: f64) -> usize {
    let share = if peak > 0.0 { (value + peak) / (2.0 * peak) } else { 0.5 };
    ((share * BINS as f64) as usize).min(BINS - 1)
}

fn edges(peak: f64) -> Vec<f64> {
    (0..=BINS).map(|i| peak * (2.0 * i as f64 / BINS as f64 - 1.0)).collect()
}

impl Sizing {
    /// The table of these scenarios, which are of one robot.
    pub fn new(uses: Vec<Use>, margin: f64) -> Self {
        let mut envelope: Vec<Demand> = Vec::new();
        for joint in uses.iter().flat_map(|used| &used.joints) {
            match envelope.iter_mut().find(|so_far| so_far.joint == joint.joint) {
                Some(so_far) => *so_far = so_far.with(joint, f64::max),
                None => envelope.push(joint.clone()),
            }
        }
        let required = envelope.iter().map(|demand| demand.with(demand, |figure, _| (1.0 + margin) * figure)).collect();
        Self { uses, envelope, margin, required }
    }
}

/// A map over speed and torque limit to be made, cell by cell.
#[derive(Clone, Debug)]
pub struct SpeedTorque<'a> {
    /// The walk.
    pub base: &'a Base,
    path: &'static str,
    /// Speeds [m/s].
    pub speeds_mps: Vec<f64>,
    /// Torque limits [Nm].
    pub torques_nm: Vec<f64>,
}

/// How the robot copes with a speed and a torque limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coping {
    /// It keeps to its reference.
    Follows,
    /// It keeps its speed, but lags behind its reference.
    KeepsSpeed,
    /// It is on its feet at another speed.
    Survives,
    /// It falls, or cannot start.
    Falls,
}

/// A cell of the map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Speed asked for [m/s].
    pub speed_mps: f64,
    /// Torque limit [Nm].
    pub torque_limit_nm: f64,
    /// How the robot copes.
    pub coping: Coping,
    /// Mean speed of the steady walk [m/s].
    pub mean_speed_mps: Option<f64>,
    /// Mean CoM error of the steady walk [m].
    pub com_error_m: Option<f64>,
    /// When it fell [s].
    pub fell_at_s: Option<f64>,
    /// The fall's first cause.
    pub cause: Option<String>,
    /// Why it fell.
    pub reason: Option<String>,
    /// Bounds of the simulator's audit that the run broke, in words.
    pub violations: Option<String>,
}

/// So many values from one to the other, without the last digits that computing leaves.
fn even(from: f64, to: f64, count: usize) -> Vec<f64> {
    let share = |i| i as f64 / count.saturating_sub(1).max(1) as f64;
    (0..count).map(|i| ((from + (to - from) * share(i)) * 1e9).round() / 1e9).collect()
}

impl<'a> SpeedTorque<'a> {
    /// So many of each, evenly from 0.2 to 2.6 of the scenario's own speed and from 0.5 to 1.5 of its torque limit, as far
    /// as these can be set and any joint has them.
    ///
    /// # Errors
    /// As [`Base::walks`] and [`Base::vary`].
    pub fn new(base: &'a Base, speeds: usize, torques: usize) -> Result<Self, Error> {
        let commanded = base.walks()?;
        let (speed, torque) = (commanded.speed_mps, base.torque_limit_nm());
        let speeds_mps = even(0.2 * speed, fastest(base, commanded, 2.6 * speed), speeds);
        let most = (1.5 * torque).min(1e5).min(base.strongest_joint_nm());
        let torques_nm = even((0.5 * torque).max(0.1), most, torques);
        let map = Self { base, path: commanded.path, speeds_mps, torques_nm };
        (0..map.cells()).try_for_each(|index| map.variant(index).map(drop))?;
        Ok(map)
    }

    /// How many cells it has: all speeds of one torque limit after the other.
    pub fn cells(&self) -> usize {
        self.speeds_mps.len() * self.torques_nm.len()
    }

    fn pair(&self, index: usize) -> (f64, f64) {
        (self.speeds_mps[index % self.speeds_mps.len()], self.torques_nm[index / self.speeds_mps.len()])
    }

    fn variant(&self, index: usize) -> Result<Variant, Error> {
        let (speed, torque) = self.pair(index);
        let [speed, torque] = [speed, torque].map(|value| Change::To(Value::Float(value)));
        self.base.vary([(self.path, &speed), ("controller.limits.torque_nm", &torque)])
    }

    /// Cell `index`; none where `stop` says so before.
    pub fn answer(&self, index: usize, stop: impl Fn() -> bool) -> Option<Pair> {
        let variant = self.variant(index).expect("all were tried in the beginning");
        let rollout = rollout::run(&variant, stop)?;
        let holds = |held: Held| held.failure(&variant, &rollout).is_none();
        let coping = match () {
            () if !holds(Held::OnItsFeet) => Coping::Falls,
            () if !holds(Held::KeepsSpeed(SPEED_SHARE)) => Coping::Survives,
            () if !holds(follows(self.base)) => Coping::KeepsSpeed,
            () => Coping::Follows,
        };
        let (speed_mps, torque_limit_nm) = self.pair(index);
        Some(Pair {
            speed_mps,
            torque_limit_nm,
            coping,
            mean_speed_mps: figure(&rollout, "steady_speed_mps"),
            com_error_m: figure(&rollout, "steady_com_error_m"),
            fell_at_s: rollout.fell_at_s,
            cause: rollout.cause,
            reason: rollout.reason,
            violations: rollout.violations,
        })
    }
}
