//! What the thesis publishes, to be held beside what is measured. Thesis Tables 6.1, 6.2, 6.4, 6.5 and Chapter 7

use legwork::metrics::{FIGURES, Figure, Metrics};

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

/// The figures by their names in [`FIGURES`], without mean and peak; how they are called beside the thesis's; and what it publishes in the
/// order of [`SCENARIOS`]: mean and peak, a single value, or nothing.
const ROWS: [(&str, &str, [&[f64]; 4]); 20] = [
    ("com_error_m", "CoM error", [&[0.013, 0.028], &[0.36, 0.85], &[0.012, 0.027], &[0.40, 0.91]]),
    ("com_error_vertical_m", "CoM error, vertical", [&[], &[9.3e-3, 0.028], &[], &[8.3e-3, 0.042]]),
    // The peak of the baseline's push is printed as 0.79, probably 0.079 (docs/thesis.md).
    ("feet_error_m", "feet error", [&[1.8e-3, 0.034], &[1.5e-3, 0.055], &[2.6e-3, 0.034], &[2.3e-3, 0.079]]),
    ("torso_deviation_rad", "torso deviation", [&[0.017, 0.058], &[0.024, 0.058], &[0.015, 0.058], &[0.019, 0.058]]),
    ("torque_nm", "joint torque", [&[69.6, 220.0], &[59.6, 220.0], &[70.4, 220.0], &[60.6, 220.0]]),
    ("grf_n", "ground reaction force", [&[356.1, 1027.0], &[362.2, 1051.0], &[355.3, 1024.0], &[359.1, 1059.0]]),
    ("grf_simulated_n", "ground reaction force, simulated", [&[]; 4]),
    ("u2_n2m2", "u²", [&[3.0e4, 1.17e5], &[2.8e4, 1.3e5], &[3.0e4, 1.17e5], &[2.8e4, 1.3e5]]),
    ("single_support_fraction", "single support", [&[0.35], &[], &[], &[]]),
    ("steps", "steps", [&[]; 4]),
    ("recovery_time_s", "recovery time", [&[], &[4.2], &[], &[]]),
    ("recovery_distance_m", "recovery distance", [&[], &[0.85], &[], &[0.91]]),
    ("mean_speed_mps", "mean speed", [&[0.5], &[], &[0.5], &[]]),
    ("xcom_error_m", "XcoM error", [&[]; 4]),
    ("xcom_margin_min_m", "smallest XcoM margin", [&[]; 4]),
    ("xcom_outside_fraction", "XcoM outside of the support", [&[]; 4]),
    ("cmp_offset_m", "distance of CMP and CoP", [&[]; 4]),
    ("capture_steps", "most steps to a stop", [&[]; 4]),
    ("uncapturable_fraction", "no number of steps to a stop", [&[]; 4]),
    ("cost_of_transport", "cost of transport", [&[]; 4]),
];

/// Every figure of `metrics` beside what the thesis publishes for the scenario of that name, where it does.
pub fn compare(scenario: &str, metrics: &Metrics) -> Vec<Row> {
    let table = SCENARIOS.iter().position(|scenarios| scenarios.contains(&scenario));
    let row = |(name, label, published): &(&str, &'static str, [&[f64]; 4])| {
        let published = table.map_or(&[][..], |table| published[table]);
        // The mean and the peak of the figure, or itself.
        let is_of = |figure: &&Figure| figure.name.split('.').next() == Some(name);
        let figures: Vec<&Figure> = FIGURES.iter().filter(is_of).collect();
        let measured = |place: usize| figures.get(place).and_then(|figure| (figure.of)(metrics));
        Row {
            label,
            unit: figures[0].unit,
            published: published.first().copied(),
            published_peak: published.get(1).copied(),
            measured: measured(0),
            measured_peak: measured(1),
        }
    };
    ROWS.iter().map(row).collect()
}
