//! The figures of a run, each defined here and nowhere else. Thesis 5.3, Tables 6.1-6.5
//!
//! Means are over the control ticks; see docs/metrics.md.

use crate::log::{Field, Log};
use crate::scenario::Scenario;

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
}

/// Takes the figures of a `log`.
pub fn measure(scenario: &Scenario, log: &Log) -> Metrics {
    let mut metrics = Metrics::default();
    if log.is_empty() {
        return metrics;
    }
    let dimension = log.range(Field::Com).len();
    let contact =
        |index: usize, field: Field| -> Vec<f64> { log.get(index, field).chunks_exact(dimension).map(norm).collect() };
    let ticks = 0..log.len();
    let from = scenario.metrics.com_error_from_s;
    let late = ticks.clone().filter(|&i| log.time(i) >= from - 1e-9);
    if late.clone().next().is_some() {
        metrics.com_error_m = Some(mean_peak(late.clone().map(|i| com_error(log, i))));
        metrics.com_error_vertical_m = Some(mean_peak(late.map(|i| com_offset(log, i, dimension - 1).abs())));
    }
    metrics.feet_error_m = mean_peak(ticks.clone().flat_map(|i| {
        let feet = log.get(i, Field::Feet).chunks_exact(dimension);
        let references = log.get(i, Field::FeetReference).chunks_exact(3 * dimension);
        feet.zip(references).map(|(foot, reference)| distance(foot, &reference[..dimension])).collect::<Vec<_>>()
    }));
    metrics.torso_deviation_rad =
        mean_peak(ticks.clone().map(|i| (log.get(i, Field::Torso)[0] - log.get(i, Field::TorsoReference)[0]).abs()));
    metrics.torque_nm = mean_peak(ticks.clone().flat_map(|i| log.get(i, Field::Torque).iter().map(|t| t.abs())));
    metrics.grf_n = mean_peak(ticks.clone().flat_map(|i| contact(i, Field::Grf)));
    metrics.grf_simulated_n = mean_peak(ticks.clone().flat_map(|i| contact(i, Field::GrfSimulated)));
    metrics.u2_n2m2 = mean_peak(ticks.clone().map(|i| log.get(i, Field::Torque).iter().map(|t| t * t).sum()));

    let swing = log.range(Field::Swing).start;
    let swinging = log.column(swing).filter(|&foot| foot >= 0.0).count();
    metrics.single_support_fraction = swinging as f64 / log.len() as f64;
    let mut before = -1.0;
    for since in log.column(swing + 1) {
        metrics.steps += u32::from(since > before);
        before = before.max(since);
    }
    let begin = scenario.pushes.iter().map(|push| push.start_s).reduce(f64::min);
    if let Some(begin) = begin.filter(|&begin| begin <= log.time(log.len() - 1)) {
        let after = ticks.filter(|&i| log.time(i) >= begin);
        metrics.recovery_distance_m = Some(after.clone().map(|i| com_offset(log, i, 0).abs()).fold(0.0, f64::max));
        let within = scenario.metrics.recovered_within_m;
        let last_out = after.rev().find(|&i| com_error(log, i) > within);
        metrics.recovery_time_s = match last_out {
            Some(i) if i + 1 == log.len() => None,
            Some(i) => Some(log.time(i + 1) - begin),
            None => Some(0.0),
        };
    }
    let (first, last) = (0, log.len() - 1);
    let time = log.time(last) - log.time(first);
    if time > 0.0 {
        metrics.mean_speed_mps = (log.get(last, Field::Com)[0] - log.get(first, Field::Com)[0]) / time;
    }
    metrics
}

/// Distance of the CoM from its reference in record `index` [m].
pub fn com_error(log: &Log, index: usize) -> f64 {
    let com = log.get(index, Field::Com);
    distance(com, &log.get(index, Field::ComReference)[..com.len()])
}

fn com_offset(log: &Log, index: usize, axis: usize) -> f64 {
    log.get(index, Field::Com)[axis] - log.get(index, Field::ComReference)[axis]
}

fn norm(vector: &[f64]) -> f64 {
    libm::sqrt(vector.iter().map(|value| value * value).sum())
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    libm::sqrt(a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum())
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
