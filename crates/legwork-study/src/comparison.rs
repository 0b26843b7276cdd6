//! How a robot walks at a speed, beside a person: torques of hip, knee and ankle, effort, energy, forces on the ground.
//!
//! All of it is of the steady walk, so that a start from standing counts for no robot. docs/comparison.md has the definitions.

use serde::Serialize;

use crate::Base;
use crate::limits::{Held, SPEED_SHARE};
use crate::robustness::STEADY_FROM_S;
use crate::rollout::{self, Rollout};
use crate::sizing::Use;
use legwork::episode::{Outcome, Run};
use legwork::log::Field;
use legwork::metrics::{self, MeanPeak};
use legwork::scenario::CommandedSpeed;

/// Peak torques of a walking person.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Person {
    /// Mass [kg].
    pub mass_kg: f64,
    /// Speed [m/s].
    pub speed_mps: f64,
    /// Where the figures are from.
    pub source: &'static str,
    /// Names of joints with their peak torques [Nm].
    pub peaks_nm: [(&'static str, f64); 3],
}

/// The person that robots are held beside.
pub const PERSON: Person = Person {
    mass_kg: 71.0,
    speed_mps: 1.1,
    source: "Di Lallo et al. 2024",
    peaks_nm: [("hip", 64.0), ("knee", 35.0), ("ankle", 92.0)],
};

/// A robot at a speed.
#[derive(Clone, Debug, Serialize)]
pub struct Gait {
    /// The speed asked for [m/s].
    pub speed_mps: f64,
    /// Why it does not walk at it; none where it does.
    pub failure: Option<String>,
    /// Bounds of the simulator's audit that the run broke, in words.
    pub violations: Option<String>,
    /// How it walks; none where it does not.
    pub figures: Option<Figures>,
    /// What that asks of the actuators, under the scenario's name with the speed; none where it does not walk.
    #[serde(skip)]
    pub used: Option<Use>,
}

/// The figures of a steady walk.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Mean speed [m/s].
    pub mean_speed_mps: f64,
    /// Way of the torso's angle from its least to its largest [rad].
    pub torso_range_rad: f64,
    /// Torques by the kind of joint, right and left together.
    pub joints: Vec<JointTorque>,
    /// Mean of the sum of the squared torques [N²m²].
    pub u2_n2m2: Option<f64>,
    /// Share of the time in which a foot swings.
    pub single_support_fraction: Option<f64>,
    /// Work of the joints, both signs counted, a weight and a metre of the way.
    pub cost_of_transport: Option<f64>,
    /// Mean distance of the XcoM from its reference [m].
    pub xcom_error_mean_m: Option<f64>,
    /// The largest.
    pub xcom_error_peak_m: Option<f64>,
    /// Largest force on the ground, all contact points together [N].
    pub ground_force_peak_n: f64,
}

/// Torque of the joints of a kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointTorque {
    /// The joint's name without its side: `hip`.
    pub joint: String,
    /// Largest absolute torque [Nm].
    pub peak_nm: f64,
    /// Mean absolute torque [Nm].
    pub mean_nm: f64,
}

impl Gait {
    /// Runs `base`, which walks as `commanded`, at another speed [m/s]; none where `stop` says so before the end. That the
    /// speed cannot be set, or the run not be started, is a result.
    pub fn of(base: &Base, commanded: CommandedSpeed, speed_mps: f64, stop: impl Fn() -> bool) -> Option<Self> {
        let failed =
            |reason, violations| Some(Self { speed_mps, failure: Some(reason), violations, figures: None, used: None });
        let tried = base.at_speed(commanded, speed_mps).and_then(|base| {
            let run = rollout::simulate(base.variant(), stop)?;
            Ok((base, run))
        });
        let (base, mut run) = match tried {
            Ok((_, run)) if run.outcome == Outcome::Stopped => return None,
            Ok(walked) => walked,
            Err(error) => return failed(error.to_string(), None),
        };
        let rollout = Rollout::of(&run);
        if let Some(reason) = Held::KeepsSpeed(SPEED_SHARE).failure(base.variant(), &rollout) {
            return failed(reason, rollout.violations);
        }
        let steady_from = run.scenario.reference.commanded_speed().map_or(0.0, |commanded| commanded.steady_from_s);
        run.log = run.log.since(steady_from.max(STEADY_FROM_S));
        if run.log.is_empty() {
            return failed("the run is too short for a steady walk".to_owned(), rollout.violations);
        }
        run.metrics = metrics::measure(&run.scenario, &run.model, &run.log);
        let mut used = Use::of(&run);
        used.scenario = format!("{} at {speed_mps} m/s", base.name());
        let figures = Some(figures(&run, &used));
        Some(Self { speed_mps, failure: None, violations: rollout.violations, figures, used: Some(used) })
    }
}

fn figures(run: &Run, used: &Use) -> Figures {
    let metrics = &run.metrics;
    let xcom = |of: fn(MeanPeak) -> f64| metrics.xcom_error_m.map(of);
    Figures {
        mean_speed_mps: metrics.mean_speed_mps,
        torso_range_rad: torso_range(run),
        joints: joints(used),
        u2_n2m2: metrics.u2_n2m2.map(|u2| u2.mean),
        single_support_fraction: metrics.single_support_fraction,
        cost_of_transport: metrics.cost_of_transport,
        xcom_error_mean_m: xcom(|error| error.mean),
        xcom_error_peak_m: xcom(|error| error.peak),
        ground_force_peak_n: ground_force_peak(run),
    }
}

/// The torques by kinds of joints, a person's in their order first.
fn joints(used: &Use) -> Vec<JointTorque> {
    let kind = |joint: &str| joint.trim_start_matches("right_").trim_start_matches("left_").to_owned();
    let mut kinds: Vec<String> = used.joints.iter().map(|demand| kind(&demand.joint)).collect();
    let of_a_person = |kind: &String| PERSON.peaks_nm.iter().position(|(name, _)| name == kind);
    kinds.sort_by_key(|kind| (of_a_person(kind).unwrap_or(PERSON.peaks_nm.len()), kind.clone()));
    kinds.dedup();
    let torques = |joint: String| {
        let members = used.joints.iter().zip(&used.points).filter(|(demand, _)| kind(&demand.joint) == joint);
        let torques: Vec<f64> = members.flat_map(|(_, points)| points).map(|[_, torque]| torque.abs()).collect();
        let mean_nm = torques.iter().sum::<f64>() / torques.len().max(1) as f64;
        JointTorque { joint, peak_nm: torques.iter().copied().fold(0.0, f64::max), mean_nm }
    };
    kinds.into_iter().map(torques).collect()
}

/// The way of the torso's angle from its least to its largest [rad]; the largest of its three in space.
fn torso_range(run: &Run) -> f64 {
    let angles = run.log.range(Field::TorsoReference).len() / 3;
    let range = |column: usize| {
        let [least, most] = [f64::min, f64::max].map(|of| run.log.column(column).reduce(of).unwrap_or(0.0));
        most - least
    };
    let first = run.log.range(Field::Torso).start;
    (first..first + angles).map(range).fold(0.0, f64::max)
}

/// The largest norm of the sum of the simulator's contact forces [N].
fn ground_force_peak(run: &Run) -> f64 {
    let axes = run.log.range(Field::Com).len();
    let squared = (0..run.log.len()).map(|index| {
        let forces = run.log.get(index, Field::GrfSimulated);
        let sum = (0..axes).map(|axis| forces.iter().skip(axis).step_by(axes).sum::<f64>());
        sum.map(|component| component * component).sum::<f64>()
    });
    libm::sqrt(squared.fold(0.0, f64::max))
}
