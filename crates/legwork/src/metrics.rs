//! The figures of a run, each defined here and nowhere else. Thesis 5.3, Tables 6.1-6.5
//!
//! Means are over the control ticks from `metrics.from_s` on; see docs/metrics.md.

use legwork_rbd::Model;

use crate::balance::Meter;
use crate::log::{Field, Log};
use crate::scenario::Scenario;

/// A robot that is slower on the mean does not travel, and has no cost of transport [m/s].
const TRAVELS: f64 = 0.05;

/// Mean and peak of a figure over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanPeak {
    /// Mean over the ticks (and over feet or joints, where there are several).
    pub mean: f64,
    /// Largest value.
    pub peak: f64,
}

/// The figures of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Distance of the CoM from its reference, from `metrics.com_error_from_s` on [m]; none
    /// where the run ends before.
    pub com_error_m: Option<MeanPeak>,
    /// Its vertical part over the same ticks [m].
    pub com_error_vertical_m: Option<MeanPeak>,
    /// Distance of a foot from its reference, over both feet [m].
    pub feet_error_m: MeanPeak,
    /// Torso angle from its reference [rad].
    pub torso_deviation_rad: MeanPeak,
    /// Absolute torque, over the actuated joints [Nm].
    pub torque_nm: MeanPeak,
    /// Norm of a foot's force in the program, over both feet [N].
    pub grf_n: MeanPeak,
    /// Norm of a foot's force in the simulator, over both feet [N].
    pub grf_simulated_n: MeanPeak,
    /// Sum of the squared torques of a tick. Thesis (5.1), as a mean [N²m²]
    pub u2_n2m2: MeanPeak,
    /// Share of the ticks in which a foot swings, from trigger to touchdown.
    pub single_support_fraction: f64,
    /// Steps begun.
    pub steps: u32,
    /// From the beginning of the first push until the CoM error stays below `metrics.recovered_within_m` [s]; none
    /// without a push in the time simulated or where it does not.
    pub recovery_time_s: Option<f64>,
    /// Largest horizontal CoM error from the beginning of the first push on [m]; none without a push.
    pub recovery_distance_m: Option<f64>,
    /// Displacement of the CoM along x over time [m/s].
    pub mean_speed_mps: f64,
    /// The same from when a commanded constant speed should have been reached on; none without one, or where the run ends
    /// before.
    pub steady_speed_mps: Option<f64>,
    /// Mean distance of the CoM from its reference over these ticks, as far as they count for the CoM error [m].
    pub steady_com_error_m: Option<f64>,
    /// Distance of the XcoM from its reference along x, over the ticks of the CoM error [m].
    pub xcom_error_m: Option<MeanPeak>,
    /// Smallest margin of the XcoM to the base of support, negative outside [m]; none without a support.
    pub xcom_margin_min_m: Option<f64>,
    /// Share of the ticks with a support in which the XcoM is outside of it; none without.
    pub xcom_outside_fraction: Option<f64>,
    /// Distance of the centroidal moment pivot from the centre of pressure, over the ticks on the ground [m]; none in flight.
    pub cmp_offset_m: Option<MeanPeak>,
    /// Most steps that were needed to come to a stop, over the ticks with a support in which some number was enough; none
    /// without such a tick.
    pub capture_steps: Option<u32>,
    /// Share of the ticks with a support in which no number of steps was enough; none without a support.
    pub uncapturable_fraction: Option<f64>,
    /// Work of the joints, both signs counted, a weight and a metre of the way; none for a robot that does not travel.
    pub cost_of_transport: Option<f64>,
    /// What each actuated joint was used for.
    pub joints: Vec<JointUse>,
}

/// What an actuator had to deliver: of the torque that acted on the joint, and the joint's speed at the same tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointUse {
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
}

/// A figure of a run as a single number.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Its name, as `com_error_m.mean`.
    pub name: &'static str,
    /// It in words, without the mean or peak that its name says.
    pub label: &'static str,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// Its value in the metrics of a run; none where the run has none.
    pub of: fn(&Metrics) -> Option<f64>,
}

const fn figure(
    name: &'static str,
    label: &'static str,
    unit: &'static str,
    of: fn(&Metrics) -> Option<f64>,
) -> Figure {
    Figure { name, label, unit, of }
}

/// Every figure that is not one of a joint.
pub const FIGURES: &[Figure] = &[
    figure("com_error_m.mean", "CoM error", "m", |m| m.com_error_m.map(|f| f.mean)),
    figure("com_error_m.peak", "CoM error", "m", |m| m.com_error_m.map(|f| f.peak)),
    figure("com_error_vertical_m.mean", "vertical CoM error", "m", |m| m.com_error_vertical_m.map(|f| f.mean)),
    figure("com_error_vertical_m.peak", "vertical CoM error", "m", |m| m.com_error_vertical_m.map(|f| f.peak)),
    figure("feet_error_m.mean", "feet error", "m", |m| Some(m.feet_error_m.mean)),
    figure("feet_error_m.peak", "feet error", "m", |m| Some(m.feet_error_m.peak)),
    figure("torso_deviation_rad.mean", "torso deviation", "rad", |m| Some(m.torso_deviation_rad.mean)),
    figure("torso_deviation_rad.peak", "torso deviation", "rad", |m| Some(m.torso_deviation_rad.peak)),
    figure("torque_nm.mean", "joint torque", "Nm", |m| Some(m.torque_nm.mean)),
    figure("torque_nm.peak", "joint torque", "Nm", |m| Some(m.torque_nm.peak)),
    figure("grf_n.mean", "force on a contact point", "N", |m| Some(m.grf_n.mean)),
    figure("grf_n.peak", "force on a contact point", "N", |m| Some(m.grf_n.peak)),
    figure("grf_simulated_n.mean", "simulated force on a contact point", "N", |m| Some(m.grf_simulated_n.mean)),
    figure("grf_simulated_n.peak", "simulated force on a contact point", "N", |m| Some(m.grf_simulated_n.peak)),
    figure("u2_n2m2.mean", "u²", "N²m²", |m| Some(m.u2_n2m2.mean)),
    figure("u2_n2m2.peak", "u²", "N²m²", |m| Some(m.u2_n2m2.peak)),
    figure("single_support_fraction", "single support", "", |m| Some(m.single_support_fraction)),
    figure("steps", "steps", "", |m| Some(f64::from(m.steps))),
    figure("recovery_time_s", "recovery time", "s", |m| m.recovery_time_s),
    figure("recovery_distance_m", "recovery distance", "m", |m| m.recovery_distance_m),
    figure("mean_speed_mps", "mean speed", "m/s", |m| Some(m.mean_speed_mps)),
    figure("steady_speed_mps", "steady speed", "m/s", |m| m.steady_speed_mps),
    figure("steady_com_error_m", "steady CoM error", "m", |m| m.steady_com_error_m),
    figure("xcom_error_m.mean", "XcoM error", "m", |m| m.xcom_error_m.map(|f| f.mean)),
    figure("xcom_error_m.peak", "XcoM error", "m", |m| m.xcom_error_m.map(|f| f.peak)),
    figure("xcom_margin_min_m", "smallest XcoM margin", "m", |m| m.xcom_margin_min_m),
    figure("xcom_outside_fraction", "XcoM outside of the support", "", |m| m.xcom_outside_fraction),
    figure("cmp_offset_m.mean", "distance of CMP and CoP", "m", |m| m.cmp_offset_m.map(|f| f.mean)),
    figure("cmp_offset_m.peak", "distance of CMP and CoP", "m", |m| m.cmp_offset_m.map(|f| f.peak)),
    figure("capture_steps", "most steps to a stop", "", |m| m.capture_steps.map(f64::from)),
    figure("uncapturable_fraction", "no number of steps to a stop", "", |m| m.uncapturable_fraction),
    figure("cost_of_transport", "cost of transport", "", |m| m.cost_of_transport),
];

/// A figure of a [`JointUse`]: its key, it in words, its unit, its value.
pub type JointFigure = (&'static str, &'static str, &'static str, fn(&JointUse) -> f64);

/// The figures of each joint; in a table of runs the first is called `joint.right_hip.torque_peak_nm`.
pub const JOINT_FIGURES: [JointFigure; 5] = [
    ("torque_peak_nm", "peak torque", "Nm", |j| j.torque_peak_nm),
    ("torque_rms_nm", "RMS torque", "Nm", |j| j.torque_rms_nm),
    ("speed_peak_radps", "peak speed", "rad/s", |j| j.speed_peak_radps),
    ("power_peak_w", "peak power", "W", |j| j.power_peak_w),
    ("power_mean_w", "mean power", "W", |j| j.power_mean_w),
];

/// Takes the figures of a `log` of `model`.
pub fn measure(scenario: &Scenario, model: &Model, log: &Log) -> Metrics {
    let mut metrics = Metrics::default();
    if log.is_empty() {
        return metrics;
    }
    let dimension = log.range(Field::Com).len();
    let contact =
        |index: usize, field: Field| -> Vec<f64> { log.get(index, field).chunks_exact(dimension).map(norm).collect() };
    let first = first_tick(scenario, log);
    let ticks = first..log.len();
    let from = scenario.metrics.com_error_from_s;
    let late = ticks.clone().filter(|&i| log.time(i) >= from - 1e-9);
    if late.clone().next().is_some() {
        metrics.com_error_m = Some(mean_peak(late.clone().map(|i| com_error(log, i))));
        metrics.com_error_vertical_m = Some(mean_peak(late.map(|i| com_offset(log, i, dimension - 1).abs())));
    }
    metrics.feet_error_m = mean_peak(ticks.clone().flat_map(|i| {
        let references = log.get(i, Field::FeetReference).chunks_exact(3 * dimension).enumerate();
        references.map(move |(foot, reference)| distance(log.foot(i, foot), reference[..dimension].iter().copied()))
    }));
    metrics.torso_deviation_rad =
        mean_peak(ticks.clone().map(|i| (log.get(i, Field::Torso)[0] - log.get(i, Field::TorsoReference)[0]).abs()));
    metrics.torque_nm = mean_peak(ticks.clone().flat_map(|i| log.get(i, Field::Torque).iter().map(|t| t.abs())));
    metrics.grf_n = mean_peak(ticks.clone().flat_map(|i| contact(i, Field::Grf)));
    metrics.grf_simulated_n = mean_peak(ticks.clone().flat_map(|i| contact(i, Field::GrfSimulated)));
    metrics.u2_n2m2 = mean_peak(ticks.clone().map(|i| log.get(i, Field::Torque).iter().map(|t| t * t).sum()));

    metrics.joints = joints(log, first);

    let swing = log.range(Field::Swing).start;
    let swinging = log.column(swing).skip(first).filter(|&foot| foot >= 0.0).count();
    metrics.single_support_fraction = swinging as f64 / ticks.len() as f64;
    let mut before = -1.0;
    for (index, since) in log.column(swing + 1).enumerate() {
        metrics.steps += u32::from(since > before && index >= first);
        before = before.max(since);
    }
    let begin = scenario.pushes.iter().map(|push| push.start_s).reduce(f64::min);
    if let Some(begin) = begin.filter(|&begin| begin <= log.time(log.len() - 1)) {
        let after = (0..log.len()).filter(|&i| log.time(i) >= begin);
        metrics.recovery_distance_m = Some(after.clone().map(|i| com_offset(log, i, 0).abs()).fold(0.0, f64::max));
        let within = scenario.metrics.recovered_within_m;
        let last_out = after.rev().find(|&i| com_error(log, i) > within);
        metrics.recovery_time_s = match last_out {
            Some(i) if i + 1 == log.len() => None,
            Some(i) => Some(log.time(i + 1) - begin),
            None => Some(0.0),
        };
    }
    metrics.mean_speed_mps = speed_since(log, first).unwrap_or(0.0);
    steady(&mut metrics, scenario, log);
    balance(&mut metrics, scenario, model, log, first);
    // ∫ Σ|τω| dt / (m g d), after Gabrielli & von Kármán 1950: both integrals over the time are means.
    let power: f64 = metrics.joints.iter().map(|joint| joint.power_mean_w).sum();
    let (weight, speed) = (model.total_mass() * model.gravity, metrics.mean_speed_mps.abs());
    metrics.cost_of_transport = (speed >= TRAVELS).then(|| power / (weight * speed));
    metrics
}

/// Displacement of the CoM along x over time from record `first` on [m/s]; none without time.
fn speed_since(log: &Log, first: usize) -> Option<f64> {
    let last = log.len() - 1;
    let time = log.time(last) - log.time(first);
    (time > 0.0).then(|| (log.get(last, Field::Com)[0] - log.get(first, Field::Com)[0]) / time)
}

/// The figures of a walk at a constant speed, once it should be steady.
fn steady(metrics: &mut Metrics, scenario: &Scenario, log: &Log) {
    let Some(commanded) = scenario.reference.commanded_speed().filter(|commanded| commanded.speed_mps != 0.0) else {
        return;
    };
    let from = |time: f64| (0..log.len()).find(|&i| log.time(i) >= time - 1e-9);
    metrics.steady_speed_mps = from(commanded.steady_from_s).and_then(|first| speed_since(log, first));
    let counts = from(commanded.steady_from_s.max(scenario.metrics.com_error_from_s));
    metrics.steady_com_error_m = counts.map(|first| mean_peak((first..log.len()).map(|i| com_error(log, i))).mean);
}

/// The first tick that counts: from `metrics.from_s` on, or all of them where the run ends before.
fn first_tick(scenario: &Scenario, log: &Log) -> usize {
    (0..log.len()).find(|&index| log.time(index) >= scenario.metrics.from_s - 1e-9).unwrap_or(0)
}

/// The figures of balance from the tick `first` on, as `crate::balance` measures it.
fn balance(metrics: &mut Metrics, scenario: &Scenario, model: &Model, log: &Log, first: usize) {
    let meter = Meter::new(scenario, model);
    let from = scenario.metrics.com_error_from_s - 1e-9;
    let (mut errors, mut margins, mut offsets, mut steps) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for index in first..log.len() {
        let measures = meter.at(log, index);
        if log.time(index) >= from {
            errors.push((log.get(index, Field::Xcom)[0] - meter.xcom_reference(log, index)).abs());
        }
        if let Some(margin) = measures.margin() {
            margins.push(margin);
            steps.push(measures.steps());
        }
        offsets.extend(measures.cmp.zip(measures.cop).map(|(cmp, cop)| (cmp - cop).abs()));
    }
    let pair = |values: &[f64]| (!values.is_empty()).then(|| mean_peak(values.iter().copied()));
    let share = |count: usize| (!margins.is_empty()).then(|| count as f64 / margins.len() as f64);
    metrics.xcom_error_m = pair(&errors);
    metrics.cmp_offset_m = pair(&offsets);
    metrics.xcom_margin_min_m = margins.iter().copied().reduce(f64::min);
    metrics.xcom_outside_fraction = share(margins.iter().filter(|margin| **margin < 0.0).count());
    metrics.capture_steps = steps.iter().copied().flatten().max();
    metrics.uncapturable_fraction = share(steps.iter().filter(|steps| steps.is_none()).count());
}

/// What each actuated joint was used for from the tick `first` on, after Thesis 5.3; the names are those of the torques'
/// columns.
fn joints(log: &Log, first: usize) -> Vec<JointUse> {
    let name = |column: usize| log.columns()[column].name.split_once('.').map_or("", |(_, name)| name);
    let torques = log.range(Field::TorqueApplied);
    torques
        .map(|torque| {
            let joint = name(torque).to_owned();
            let speed = log.range(Field::V).find(|&column| name(column) == joint).expect("an actuated joint moves");
            let used = log.column(torque).zip(log.column(speed)).skip(first);
            let of = |figure: fn(f64, f64) -> f64| mean_peak(used.clone().map(|(t, v)| figure(t, v)));
            let (squared, power) = (of(|t, _| t * t), of(|t, v| (t * v).abs()));
            JointUse {
                joint,
                torque_peak_nm: libm::sqrt(squared.peak),
                torque_rms_nm: libm::sqrt(squared.mean),
                speed_peak_radps: of(|_, v| v.abs()).peak,
                power_peak_w: power.peak,
                power_mean_w: power.mean,
            }
        })
        .collect()
}

/// Distance of the CoM from its reference in record `index` [m].
pub fn com_error(log: &Log, index: usize) -> f64 {
    let com = log.get(index, Field::Com);
    distance(com.iter().copied(), log.get(index, Field::ComReference)[..com.len()].iter().copied())
}

fn com_offset(log: &Log, index: usize, axis: usize) -> f64 {
    log.get(index, Field::Com)[axis] - log.get(index, Field::ComReference)[axis]
}

fn norm(vector: &[f64]) -> f64 {
    libm::sqrt(vector.iter().map(|value| value * value).sum())
}

fn distance(a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) -> f64 {
    libm::sqrt(a.zip(b).map(|(x, y)| (x - y) * (x - y)).sum())
}

fn mean_peak(values: impl Iterator<Item = f64>) -> MeanPeak {
    let (mut sum, mut count, mut peak) = (0.0, 0u64, 0.0_f64);
    for value in values {
        sum += value;
        count += 1;
        peak = peak.max(value);
    }
    MeanPeak { mean: if count > 0 { sum / count as f64 } else { 0.0 }, peak }
}
