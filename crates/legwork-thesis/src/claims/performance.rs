//! Claims about the final design (7.1, 7.1.3, 7.1.4), about what it gained over the baseline (7.1.5), and about the
//! size of the program (7.4).

use super::{Source, Test, each};
use crate::case::{Experiment, Reading};
use crate::evidence::Evidence;
use crate::limits::{LARGEST_PUSH, TOP_SPEED_220, TOP_SPEED_300};
use crate::sweep::{COM, FEET, TORQUE, TORSO, Tried, U2};
use crate::terms::{Check, LITTLE, MET, UNCHANGED, VISIBLE};
use crate::words::{digits, list, with_unit};
use legwork::metrics::{MeanPeak, Metrics};

/// The studies of the parameters that the final design leaves as they are.
const KEPT: [&str; 5] = ["grf-limit", "acceleration-weight", "momentum-weight", "torso-weight", "com-gain"];

const fn tables(rows: &'static str) -> Source {
    Source { file: "tables", rows, columns: &["displacement", "base-of-support"] }
}

const fn limits(rows: &'static str) -> Source {
    Source { file: "limits", rows, columns: &["displacement", "base-of-support"] }
}

pub(super) const TESTS: &[Test] = &[
    Test {
        id: "7.1-a",
        says: "The final design follows the CoM's trajectory and recovers from the push by stepping.",
        test: "the walk stands, with a mean CoM error below 0.05 m; the push stands, steps, and its CoM error stays \
               below 0.05 m from some time on",
        source: limits("recovery time"),
        run: |e, r| {
            let (walk, push) = (e.final_run(r, Experiment::Walk), e.final_run(r, Experiment::Push));
            let error = walk.metrics.com_error_m.map_or(f64::INFINITY, |error| error.mean);
            let follows = walk.reason.is_none() && error < walk.scenario.metrics.recovered_within_m;
            let time = push.metrics.recovery_time_s;
            let recovered = push.reason.is_none() && push.metrics.steps > 0 && time.is_some();
            let after = time.map_or("not".to_owned(), |time| format!("after {}", with_unit(time, "s")));
            vec![
                Check::new(follows, format!("walk: mean CoM error {}", with_unit(error, "m"))),
                Check::new(recovered, format!("push: recovered {after}, {} steps", push.metrics.steps)),
            ]
        },
    },
    Test {
        id: "7.1.3-a",
        says: "The walk follows the CoM's trajectory with a mean error of 0.013 m and a peak of 0.028 m after 0.4 s.",
        test: "both are met",
        source: tables("Table 6.4, CoM error"),
        run: |e, r| errors(e, r, Experiment::Walk, "CoM error", |m| m.com_error_m, (0.013, 0.028)),
    },
    Test {
        id: "7.1.3-b",
        says: "The feet follow theirs with a mean error of 1.8 mm and a peak of 34 mm.",
        test: "both are met",
        source: tables("Table 6.4, feet error"),
        run: |e, r| errors(e, r, Experiment::Walk, "feet error", |m| Some(m.feet_error_m), (1.8e-3, 0.034)),
    },
    Test {
        id: "7.1.3-c",
        says: "The fastest walk at 220 Nm has 0.60 m/s.",
        test: "the highest speed that is kept to 5 % is met",
        source: limits(TOP_SPEED_220),
        run: |e, r| vec![limit(e, r, TOP_SPEED_220, 0.60, "m/s")],
    },
    Test {
        id: "7.1.3-d",
        says: "At 300 Nm it has 1.25 m/s.",
        test: "the highest speed that is kept to 5 % is met, and is much higher than at 220 Nm",
        source: limits(TOP_SPEED_300),
        run: |e, r| {
            let [slow, fast] = [TOP_SPEED_220, TOP_SPEED_300].map(|quantity| e.limit(quantity, r).value.unwrap_or(0.0));
            let finding = format!("{} at 220 Nm, {} at 300 Nm", with_unit(slow, "m/s"), with_unit(fast, "m/s"));
            vec![limit(e, r, TOP_SPEED_300, 1.25, "m/s"), Check::new(fast > (1.0 + LITTLE) * slow, finding)]
        },
    },
    Test {
        id: "7.1.4-a",
        says: "The push is large enough to need several steps, and the robot recovers from it.",
        test: "at least two steps, and a recovery",
        source: limits("recovery time"),
        run: |e, r| {
            let metrics = &e.final_run(r, Experiment::Push).metrics;
            let recovery = metrics.recovery_time_s.map_or("none".to_owned(), |time| with_unit(time, "s"));
            vec![
                Check::new(metrics.steps >= 2, format!("{} steps", metrics.steps)),
                Check::new(metrics.recovery_time_s.is_some(), format!("recovery time {recovery}")),
            ]
        },
    },
    Test {
        id: "7.1.4-b",
        says: "Pushes up to 140 Ns are survived.",
        test: "the largest push below which all are survived is at least 140 Ns; and it is met",
        source: limits(LARGEST_PUSH),
        run: |e, r| {
            let largest = e.limit(LARGEST_PUSH, r).value.unwrap_or(0.0);
            let at_least = Check::new(largest >= 140.0, format!("at least {}", with_unit(largest, "Ns")));
            vec![at_least, limit(e, r, LARGEST_PUSH, 140.0, "Ns")]
        },
    },
    Test {
        id: "7.1.4-c",
        says: "Balance is recovered within 0.85 m.",
        test: "the largest horizontal CoM error after the push is met",
        source: limits("recovery distance"),
        run: |e, r| vec![limit(e, r, "recovery distance", 0.85, "m")],
    },
    Test {
        id: "7.1.4-d",
        says: "The vertical CoM error is 9.3 mm on average and 28 mm at most (printed 0.28 m).",
        test: "both are met",
        source: tables("Table 6.5, CoM error, vertical"),
        run: |e, r| errors(e, r, Experiment::Push, "vertical CoM error", |m| m.com_error_vertical_m, (9.3e-3, 0.028)),
    },
    Test {
        id: "7.1.4-e",
        says: "The recovery takes 4.2 s.",
        test: "the time until the CoM error stays below 0.05 m is met",
        source: limits("recovery time"),
        run: |e, r| vec![limit(e, r, "recovery time", 4.2, "s")],
    },
    Test {
        id: "7.1.5-a",
        says: "Most parameters were near their best values already.",
        test: "of the five parameters that the final design keeps, at most one has a level that is better than the \
               baseline's: one of mean CoM, feet, torso errors, torque and u² is much lower, and none more than 5 % \
               higher; in walk and push",
        source: Source { file: "sweeps", rows: "com-gain", columns: &[COM, FEET, TORSO, TORQUE, U2] },
        run: |e, r| each(|experiment| near_best(e, r, experiment)),
    },
    Test {
        id: "7.1.5-b",
        says: "In the walk the mean feet error is 31 % less than the baseline's.",
        test: "it is at least 1 % less; and by 31 % give or take 10 points",
        source: tables("Tables 6.1 and 6.4, feet error"),
        run: |e, r| gain(e, r, Experiment::Walk, "mean feet error", |m| Some(m.feet_error_m.mean), (0.31, 0.10)),
    },
    Test {
        id: "7.1.5-c",
        says: "Nothing else improved in the walk.",
        test: "mean CoM and torso errors, mean torque and u² are each no more than 5 % less than the baseline's",
        source: tables("Tables 6.1 and 6.4"),
        run: nothing_else,
    },
    Test {
        id: "7.1.5-d",
        says: "In the push the mean feet error is 35 % less than the baseline's.",
        test: "it is at least 1 % less; and by 35 % give or take 10 points",
        source: tables("Tables 6.2 and 6.5, feet error"),
        run: |e, r| gain(e, r, Experiment::Push, "mean feet error", |m| Some(m.feet_error_m.mean), (0.35, 0.10)),
    },
    Test {
        id: "7.1.5-e",
        says: "In the push the peak vertical CoM error is 33 % less.",
        test: "it is at least 1 % less; and by 33 % give or take 10 points",
        source: tables("Tables 6.2 and 6.5, CoM error, vertical"),
        run: |e, r| {
            let vertical = |m: &Metrics| m.com_error_vertical_m.map(|error| error.peak);
            gain(e, r, Experiment::Push, "peak vertical CoM error", vertical, (0.33, 0.10))
        },
    },
    Test {
        id: "7.1.5-f",
        says: "In the push the distance to recover is 0.06 m less.",
        test: "it is at least 1 % less; and by 0.06 m of 0.91 m give or take half of that",
        source: tables("Tables 6.2 and 6.5, CoM error"),
        run: |e, r| gain(e, r, Experiment::Push, "distance", |m| m.recovery_distance_m, (0.06 / 0.91, 0.03 / 0.91)),
    },
];

/// Mean and peak of an error against the published ones.
fn errors(
    evidence: &Evidence,
    reading: Reading,
    experiment: Experiment,
    label: &str,
    figure: fn(&Metrics) -> Option<MeanPeak>,
    (mean, peak): (f64, f64),
) -> Vec<Check> {
    let measured = figure(&evidence.final_run(reading, experiment).metrics).unwrap_or_default();
    let part = |kind: &str, measured: f64, published: f64| {
        let finding = format!("{kind} {label} {}, published {}", with_unit(measured, "m"), with_unit(published, "m"));
        Check::new(measured <= (1.0 + MET) * published, finding)
    };
    vec![part("mean", measured.mean, mean), part("peak", measured.peak, peak)]
}

/// A limit against the published one.
fn limit(evidence: &Evidence, reading: Reading, quantity: &str, published: f64, unit: &str) -> Check {
    let found = evidence.limit(quantity, reading);
    let Some(value) = found.value else { return Check::new(false, format!("{quantity}: none")) };
    let mut finding = format!("{quantity} {}, published {}", with_unit(value, unit), with_unit(published, unit));
    if let (Some(beyond), Some(reason)) = (found.first_failure, &found.reason) {
        finding += &format!("; at {} {reason}", with_unit(beyond, unit));
    }
    Check::new((value / published - 1.0).abs() <= MET, finding)
}

/// What the final design gained over the baseline, as a share of the baseline's figure; the published gain and how far
/// from it is still met.
fn gain(
    evidence: &Evidence,
    reading: Reading,
    experiment: Experiment,
    label: &str,
    figure: impl Fn(&Metrics) -> Option<f64>,
    (published, within): (f64, f64),
) -> Vec<Check> {
    let (before, after) = (evidence.baseline_run(reading, experiment), evidence.final_run(reading, experiment));
    if before.reason.is_some() || after.reason.is_some() {
        return vec![Check::new(false, "the baseline or the final design falls, so that nothing can be compared")];
    }
    let (Some(old), Some(new)) = (figure(&before.metrics), figure(&after.metrics)) else {
        return vec![Check::new(false, format!("{label}: none"))];
    };
    let gain = 1.0 - new / old;
    let finding = format!("{label} {} instead of {}: {:+.1} %", digits(new), digits(old), -100.0 * gain);
    vec![
        Check::new(gain >= VISIBLE, finding.clone()),
        Check::new((gain - published).abs() <= within, format!("{finding}, published {:+.1} %", -100.0 * published)),
    ]
}

fn nothing_else(evidence: &Evidence, reading: Reading) -> Vec<Check> {
    let metrics = |run: &legwork::episode::Run| run.metrics.clone();
    let before = metrics(evidence.baseline_run(reading, Experiment::Walk));
    let after = metrics(evidence.final_run(reading, Experiment::Walk));
    type Figure = (&'static str, fn(&Metrics) -> f64);
    let figures: [Figure; 4] = [
        ("mean CoM error", |m| m.com_error_m.map_or(f64::NAN, |error| error.mean)),
        ("mean torso error", |m| m.torso_deviation_rad.mean),
        ("mean torque", |m| m.torque_nm.mean),
        ("mean u²", |m| m.u2_n2m2.mean),
    ];
    let part = |(label, of): Figure| {
        let (old, new) = (of(&before), of(&after));
        let change = new / old - 1.0;
        let finding = format!("{label} {} instead of {}: {:+.1} %", digits(new), digits(old), 100.0 * change);
        Check::new(change >= -UNCHANGED, finding)
    };
    figures.map(part).to_vec()
}

fn near_best(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let name = experiment.name();
    let mut better = Vec::new();
    for study in KEPT {
        let sweep = evidence.sweep(study, reading, experiment);
        if !sweep.at_marked().rollout.survived() {
            return Check::new(false, format!("{name}: the baseline itself falls"));
        }
        if let Some(level) = sweep.levels.iter().find(|tried| is_better(tried, sweep.at_marked())) {
            better.push(format!("{} {}", sweep.symbol, with_unit(level.level, sweep.unit)));
        }
    }
    let finding = format!("{name}: {} of {} have a better level: {}", better.len(), KEPT.len(), list(&better));
    Check::new(better.len() <= 1, finding)
}

/// Whether one figure is much lower and none higher than the baseline's.
fn is_better(tried: &Tried, baseline: &Tried) -> bool {
    let ratio = |figure: &&str| Some(tried.figure(figure)? / baseline.figure(figure)?);
    let ratios: Option<Vec<f64>> = [COM, FEET, TORSO, TORQUE, U2].iter().map(ratio).collect();
    ratios.is_some_and(|ratios| {
        ratios.iter().all(|&ratio| ratio <= 1.0 + UNCHANGED) && ratios.iter().any(|&ratio| ratio < 1.0 - LITTLE)
    })
}
