//! The metrics of a run: each is defined here and nowhere else, and from here come tables, JSON, the columns of a study and
//! `legwork list metrics`. Thesis 5.3, Tables 6.1-6.5
//!
//! `crate::measuring` takes them.

use std::sync::LazyLock;

use crate::channel::Field;
use crate::log::Log;
pub use crate::measuring::{Measuring, measure};

/// Mean and peak of a quantity over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanPeak {
    /// Mean over the ticks (and over feet or joints, where there are several).
    pub mean: f64,
    /// Largest value.
    pub peak: f64,
}

/// How a metric is called, and where its value stands in the metrics of a run, or of a joint.
#[derive(Debug)]
pub struct Metric<Of = Metrics> {
    /// Its name, as `com_error_m`.
    pub name: &'static str,
    /// It in words, without mean or peak.
    pub label: &'static str,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// What it is, and when a run has none, in a sentence.
    pub help: &'static str,
    /// Its value.
    pub value: Value<Of>,
}

/// What a metric is, and what gives it; none where the run has none.
#[derive(Debug)]
pub enum Value<Of> {
    /// Mean and peak.
    Pair(fn(&Of) -> Option<MeanPeak>),
    /// A number.
    Number(fn(&Of) -> Option<f64>),
    /// A whole number.
    Count(fn(&Of) -> Option<u32>),
}

impl<Of> Metric<Of> {
    /// The number, or mean and peak; none where there is none.
    pub fn of(&self, metrics: &Of) -> [Option<f64>; 2] {
        match self.value {
            Value::Pair(pair) => pair(metrics).map_or([None; 2], |pair| [Some(pair.mean), Some(pair.peak)]),
            Value::Number(number) => [number(metrics), None],
            Value::Count(count) => [count(metrics).map(f64::from), None],
        }
    }

    /// What it is, in words: `mean and peak`, `number` or `count`.
    pub fn kind(&self) -> &'static str {
        match self.value {
            Value::Pair(_) => "mean and peak",
            Value::Number(_) => "number",
            Value::Count(_) => "count",
        }
    }
}

/// A struct of metrics, which may hold something else besides, and the table of their definitions.
macro_rules! metrics {
    (
        $(#[$doc:meta])* pub struct $Of:ident { $(#[$other_doc:meta] $other:ident: $Other:ty,)* }
        $(#[$table_doc:meta])* pub const $TABLE:ident;
        $($name:ident: $Type:ty = $Value:ident, $label:literal, $unit:literal, $help:literal;)*
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $Of {
            $(#[doc = $help] pub $name: $Type,)*
            $(#[$other_doc] pub $other: $Other,)*
        }

        $(#[$table_doc])*
        pub const $TABLE: &[Metric<$Of>] = &[$(Metric {
            name: stringify!($name),
            label: $label,
            unit: $unit,
            help: $help,
            value: Value::$Value(|metrics| metrics.$name.into()),
        }),*];
    };
}

metrics! {
    /// The metrics of a run.
    pub struct Metrics {
        /// What each actuated joint was used for.
        joints: Vec<JointUse>,
    }

    /// Every metric that is not one of a joint.
    pub const METRICS;

    com_error_m: Option<MeanPeak> = Pair, "CoM error", "m",
        "Euclidean distance of the centre of mass from its reference, from `metrics.com_error_from_s` (thesis 7.1.3) on; none where \
         the run ends before.";
    com_error_vertical_m: Option<MeanPeak> = Pair, "vertical CoM error", "m",
        "Absolute vertical distance of the centre of mass from its reference, over the ticks of `com_error_m`.";
    feet_error_m: Option<MeanPeak> = Pair, "feet error", "m",
        "Euclidean distance of a foot from its reference, over both feet, standing or swinging.";
    torso_deviation_rad: Option<MeanPeak> = Pair, "torso deviation", "rad",
        "Absolute difference of the torso's angle from its reference.";
    torque_nm: Option<MeanPeak> = Pair, "joint torque", "Nm",
        "Absolute torque that the controller asks for, over the actuated joints.";
    grf_n: Option<MeanPeak> = Pair, "force on a contact point", "N",
        "Euclidean norm of the force on a contact point in the controller's program (ρ), over all contact points, zero included.";
    grf_simulated_n: Option<MeanPeak> = Pair, "simulated force on a contact point", "N",
        "Euclidean norm of the physics' force on a contact point, averaged over the control period, over all contact points; impacts \
         are peaks here.";
    u2_n2m2: Option<MeanPeak> = Pair, "u²", "N²m²",
        "Sum over the actuated joints of the squared torque that the controller asks for (thesis 5.1).";
    single_support_fraction: Option<f64> = Number, "single support", "",
        "Share of the ticks in which a foot swings, from trigger to touchdown.";
    steps: Option<u32> = Count, "steps", "",
        "Number of steps that were triggered.";
    recovery_time_s: Option<f64> = Number, "recovery time", "s",
        "Time from the beginning of the first push until the CoM error is at most `metrics.recovered_within_m` and stays so; none \
         without a push, or where the run ends before.";
    recovery_distance_m: Option<f64> = Number, "recovery distance", "m",
        "Largest horizontal CoM error from the beginning of the first push on; none without a push.";
    mean_speed_mps: f64 = Number, "mean speed", "m/s",
        "Displacement of the centre of mass along x over the time of the log.";
    steady_speed_mps: Option<f64> = Number, "steady speed", "m/s",
        "Mean speed from when on a constant commanded speed should have been reached; none without a constant commanded speed.";
    steady_com_error_m: Option<f64> = Number, "steady CoM error", "m",
        "Mean of the CoM error over the ticks of `com_error_m` in which a constant commanded speed should have been reached; none \
         without a constant commanded speed.";
    xcom_error_m: Option<MeanPeak> = Pair, "XcoM error", "m",
        "Distance of the XcoM from its reference, over the ticks of `com_error_m`; the reference is the walker's, else x + ẋ/ω \
         of the CoM's reference.";
    xcom_margin_min_m: Option<f64> = Number, "smallest XcoM margin", "m",
        "Smallest margin of the XcoM to the base of support, negative outside (Hof 2008); none where no contact point ever touches.";
    xcom_outside_fraction: Option<f64> = Number, "XcoM outside of the support", "",
        "Share of the ticks with a base of support in which the XcoM is outside of it.";
    cmp_offset_m: Option<MeanPeak> = Pair, "distance of CMP and CoP", "m",
        "Distance of the centroidal moment pivot from the centre of pressure (Popovic et al. 2005), over the ticks on the ground: the \
         moment that turns the robot over the force of the ground.";
    capture_steps: Option<u32> = Count, "most steps to a stop", "",
        "Most steps that were needed to come to a stop, over the ticks in which some number was enough.";
    uncapturable_fraction: Option<f64> = Number, "no number of steps to a stop", "",
        "Share of the ticks with a base of support in which no number of steps was enough to come to a stop.";
    cost_of_transport: Option<f64> = Number, "cost of transport", "",
        "∫Σ abs(τω) dt / (m g d), of the torques that acted, d the way along x (Gabrielli & von Kármán 1950); none below a mean speed \
         of 0.05 m/s.";
}

metrics! {
    /// What an actuator had to deliver: of the torque that acted on the joint, and the joint's speed at the same tick.
    pub struct JointUse {
        /// The joint's name.
        joint: String,
    }

    /// The metrics of each joint; in a table of runs the first is called `joint.right_hip.torque_peak_nm`.
    pub const JOINT_METRICS;

    torque_peak_nm: f64 = Number, "peak torque", "Nm", "Largest absolute torque that acted on the joint.";
    torque_rms_nm: f64 = Number, "RMS torque", "Nm", "Root of the mean squared torque that acted on the joint.";
    speed_peak_radps: f64 = Number, "peak speed", "rad/s", "Largest absolute speed of the joint.";
    power_peak_w: f64 = Number, "peak power", "W", "Largest absolute power of the torque that acted on the joint.";
    power_mean_w: f64 = Number, "mean power", "W", "Mean absolute power of the torque that acted on the joint.";
}

/// A single number of a metric, as a column of a table of runs has it.
#[derive(Debug)]
pub struct Figure {
    /// Its name, as `com_error_m.mean`.
    pub name: String,
    /// It in words, as `mean CoM error`.
    pub label: String,
    /// Its unit, or nothing.
    pub unit: &'static str,
    metric: &'static Metric,
    part: usize,
}

impl Figure {
    /// Its value in the metrics of a run; none where the run has none.
    pub fn of(&self, metrics: &Metrics) -> Option<f64> {
        self.metric.of(metrics)[self.part]
    }
}

/// Every number of [`METRICS`].
pub static FIGURES: LazyLock<Vec<Figure>> = LazyLock::new(|| {
    let figure = |metric: &'static Metric, part: usize, name: String, label: String| Figure {
        name,
        label,
        unit: metric.unit,
        metric,
        part,
    };
    let figures = METRICS.iter().flat_map(|metric| match metric.value {
        Value::Pair(_) => ["mean", "peak"]
            .iter()
            .enumerate()
            .map(|(part, kind)| {
                figure(metric, part, format!("{}.{kind}", metric.name), format!("{kind} {}", metric.label))
            })
            .collect(),
        Value::Number(_) | Value::Count(_) => vec![figure(metric, 0, metric.name.to_owned(), metric.label.to_owned())],
    });
    figures.collect()
});

/// Distance of the CoM from its reference in record `index` [m]; not a number without a reference.
pub fn com_error(log: &Log, index: usize) -> f64 {
    crate::measuring::com_error(log.get(index, Field::Com), log.get(index, Field::ComReference)).unwrap_or(f64::NAN)
}
