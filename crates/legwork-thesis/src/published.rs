//! What the thesis publishes, to be held beside what is measured. Thesis Tables 6.1, 6.2, 6.4, 6.5 and Chapter 7

use legwork::metrics::{METRICS, Metric, Metrics};

/// One row of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The figure in words.
    pub label: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Published mean (or single value), where there is one.
    pub published: Option<f64>,
    /// Published peak.
    pub published_peak: Option<f64>,
    /// Measured mean (or single value); none where the run has none, as a recovery time without recovery.
    pub measured: Option<f64>,
    /// Measured peak; none for single values.
    pub measured_peak: Option<f64>,
}

/// The scenarios that a table of the thesis is of: Tables 6.4 (with Section 7.2.1), 6.5 (with 7.1.4), 6.1 and 6.2.
const SCENARIOS: [&[&str]; 4] =
    [&["walk", "walk-support"], &["push", "push-support"], &["walk-baseline"], &["push-baseline"]];

/// What the thesis publishes: metrics by their names, and their values in the order of [`SCENARIOS`]: mean and peak, a single value, or nothing.
const PUBLISHED: [(&str, [&[f64]; 4]); 11] = [
    ("com_error_m", [&[0.013, 0.028], &[0.36, 0.85], &[0.012, 0.027], &[0.40, 0.91]]),
    ("com_error_vertical_m", [&[], &[9.3e-3, 0.028], &[], &[8.3e-3, 0.042]]),
    // The peak of the baseline's push is printed as 0.79, probably 0.079 (docs/thesis.md).
    ("feet_error_m", [&[1.8e-3, 0.034], &[1.5e-3, 0.055], &[2.6e-3, 0.034], &[2.3e-3, 0.079]]),
    ("torso_deviation_rad", [&[0.017, 0.058], &[0.024, 0.058], &[0.015, 0.058], &[0.019, 0.058]]),
    ("torque_nm", [&[69.6, 220.0], &[59.6, 220.0], &[70.4, 220.0], &[60.6, 220.0]]),
    ("grf_n", [&[356.1, 1027.0], &[362.2, 1051.0], &[355.3, 1024.0], &[359.1, 1059.0]]),
    ("u2_n2m2", [&[3.0e4, 1.17e5], &[2.8e4, 1.3e5], &[3.0e4, 1.17e5], &[2.8e4, 1.3e5]]),
    ("single_support_fraction", [&[0.35], &[], &[], &[]]),
    ("recovery_time_s", [&[], &[4.2], &[], &[]]),
    ("recovery_distance_m", [&[], &[0.85], &[], &[0.91]]),
    ("mean_speed_mps", [&[0.5], &[], &[0.5], &[]]),
];

/// Every metric of a run beside what the thesis publishes for the scenario of that name, where it does.
pub fn compare(scenario: &str, metrics: &Metrics) -> Vec<Row> {
    let table = SCENARIOS.iter().position(|scenarios| scenarios.contains(&scenario));
    let row = |metric: &Metric| {
        let known = PUBLISHED.iter().find(|(name, _)| *name == metric.name);
        let published = known.zip(table).map_or(&[][..], |((_, values), table)| values[table]);
        let [measured, measured_peak] = metric.of(metrics);
        Row {
            label: metric.label,
            unit: metric.unit,
            published: published.first().copied(),
            published_peak: published.get(1).copied(),
            measured,
            measured_peak,
        }
    };
    METRICS.iter().map(row).collect()
}
