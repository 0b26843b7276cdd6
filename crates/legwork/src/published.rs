//! What the thesis publishes, to be held beside what is measured. Thesis Tables 6.1, 6.2, 6.4, 6.5 and Chapter 7

use crate::metrics::{MeanPeak, Metrics};

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

/// The published figures of one experiment.
#[derive(Clone, Copy, Debug)]
struct Published {
    scenarios: &'static [&'static str],
    com_error_m: (f64, f64),
    com_error_vertical_m: Option<(f64, f64)>,
    feet_error_m: (f64, f64),
    torso_deviation_rad: (f64, f64),
    torque_nm: (f64, f64),
    grf_n: (f64, f64),
    u2_n2m2: (f64, f64),
    single_support_fraction: Option<f64>,
    recovery_time_s: Option<f64>,
    recovery_distance_m: Option<f64>,
    mean_speed_mps: Option<f64>,
}

const PUBLISHED: [Published; 4] = [
    // Table 6.4; single support from Section 7.2.1
    Published {
        scenarios: &["walk", "walk-support"],
        com_error_m: (0.013, 0.028),
        com_error_vertical_m: None,
        feet_error_m: (1.8e-3, 0.034),
        torso_deviation_rad: (0.017, 0.058),
        torque_nm: (69.6, 220.0),
        grf_n: (356.1, 1027.0),
        u2_n2m2: (3.0e4, 1.17e5),
        single_support_fraction: Some(0.35),
        recovery_time_s: None,
        recovery_distance_m: None,
        mean_speed_mps: Some(0.5),
    },
    // Table 6.5; recovery from Section 7.1.4
    Published {
        scenarios: &["push", "push-support"],
        com_error_m: (0.36, 0.85),
        com_error_vertical_m: Some((9.3e-3, 0.028)),
        feet_error_m: (1.5e-3, 0.055),
        torso_deviation_rad: (0.024, 0.058),
        torque_nm: (59.6, 220.0),
        grf_n: (362.2, 1051.0),
        u2_n2m2: (2.8e4, 1.3e5),
        single_support_fraction: None,
        recovery_time_s: Some(4.2),
        recovery_distance_m: Some(0.85),
        mean_speed_mps: None,
    },
    // Table 6.1
    Published {
        scenarios: &["walk-baseline"],
        com_error_m: (0.012, 0.027),
        com_error_vertical_m: None,
        feet_error_m: (2.6e-3, 0.034),
        torso_deviation_rad: (0.015, 0.058),
        torque_nm: (70.4, 220.0),
        grf_n: (355.3, 1024.0),
        u2_n2m2: (3.0e4, 1.17e5),
        single_support_fraction: None,
        recovery_time_s: None,
        recovery_distance_m: None,
        mean_speed_mps: Some(0.5),
    },
    // Table 6.2; the peak of the feet's error is printed as 0.79, probably 0.079 (docs/thesis.md)
    Published {
        scenarios: &["push-baseline"],
        com_error_m: (0.40, 0.91),
        com_error_vertical_m: Some((8.3e-3, 0.042)),
        feet_error_m: (2.3e-3, 0.079),
        torso_deviation_rad: (0.019, 0.058),
        torque_nm: (60.6, 220.0),
        grf_n: (359.1, 1059.0),
        u2_n2m2: (2.8e4, 1.3e5),
        single_support_fraction: None,
        recovery_time_s: None,
        recovery_distance_m: Some(0.91),
        mean_speed_mps: None,
    },
];

/// Every figure of `metrics` beside what the thesis publishes for the scenario of that name, where it does.
pub fn compare(scenario: &str, metrics: &Metrics) -> Vec<Row> {
    let published = PUBLISHED.iter().find(|published| published.scenarios.contains(&scenario));
    let either = |label, unit, published: Option<(f64, f64)>, measured: Option<MeanPeak>| Row {
        label,
        unit,
        published: published.map(|(mean, _)| mean),
        published_peak: published.map(|(_, peak)| peak),
        measured: measured.map(|figure| figure.mean),
        measured_peak: measured.map(|figure| figure.peak),
    };
    let both = |label, unit, published, measured| either(label, unit, published, Some(measured));
    let single = |label, unit, published: Option<f64>, measured: Option<f64>| Row {
        label,
        unit,
        published,
        published_peak: None,
        measured,
        measured_peak: None,
    };
    let pair = |get: fn(&Published) -> (f64, f64)| published.map(get);
    let one = |get: fn(&Published) -> Option<f64>| published.and_then(get);
    let m = metrics;
    vec![
        either("CoM error", "m", pair(|p| p.com_error_m), m.com_error_m),
        either("CoM error, vertical", "m", published.and_then(|p| p.com_error_vertical_m), m.com_error_vertical_m),
        both("feet error", "m", pair(|p| p.feet_error_m), m.feet_error_m),
        both("torso deviation", "rad", pair(|p| p.torso_deviation_rad), m.torso_deviation_rad),
        both("joint torque", "Nm", pair(|p| p.torque_nm), m.torque_nm),
        both("force on a contact point", "N", pair(|p| p.grf_n), m.grf_n),
        both("force on a contact point, simulated", "N", None, m.grf_simulated_n),
        both("u²", "N²m²", pair(|p| p.u2_n2m2), m.u2_n2m2),
        single("single support", "", one(|p| p.single_support_fraction), Some(m.single_support_fraction)),
        single("steps", "", None, Some(f64::from(m.steps))),
        single("recovery time", "s", one(|p| p.recovery_time_s), m.recovery_time_s),
        single("recovery distance", "m", one(|p| p.recovery_distance_m), m.recovery_distance_m),
        single("mean speed", "m/s", one(|p| p.mean_speed_mps), Some(m.mean_speed_mps)),
        either("XcoM error", "m", None, m.xcom_error_m),
        single("smallest XcoM margin", "m", None, m.xcom_margin_min_m),
        single("XcoM outside of the support", "", None, m.xcom_outside_fraction),
        either("distance of CMP and CoP", "m", None, m.cmp_offset_m),
        single("most steps to a stop", "", None, m.capture_steps.map(f64::from)),
        single("no number of steps to a stop", "", None, m.uncapturable_fraction),
        single("cost of transport", "", None, m.cost_of_transport),
    ]
}
