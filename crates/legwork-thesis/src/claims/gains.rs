//! Claims about the gains of the motion reference planner (6.3.7, 6.3.8) and about feet weight and foot gain together
//! (6.4).

use super::{Source, Test, curves, each, sweep_source};
use crate::case::{Case, Experiment, Gains, Reading};
use crate::curve::Curve;
use crate::evidence::Evidence;
use crate::sweep::{COM, COST, FEET, TORQUE, TORSO, U2};
use crate::terms::{Check, LITTLE};
use crate::trial::{STACKED_GAINS, STACKED_WEIGHTS, stacked};
use crate::words::{digits, list};

const COM_GAIN: &str = "com-gain";
const FOOT_GAIN: &str = "foot-gain";
const ANY: (f64, f64) = (0.0, f64::INFINITY);
const WALK: &[Experiment] = &[Experiment::Walk];
const PUSH: &[Experiment] = &[Experiment::Push];

pub(super) const TESTS: &[Test] = &[
    Test {
        id: "6.3.7-a",
        says: "A higher CoM gain lowers the CoM error of the walk.",
        test: "mean CoM error of the walk sinks with the gain",
        source: sweep_source(COM_GAIN, &[COM]),
        run: |e, r| curves((e, COM_GAIN, r), WALK, &[COM], ANY, |c| c.sinks()),
    },
    Test {
        id: "6.3.7-b",
        says: "It does so with diminishing returns.",
        test: "mean CoM error of the walk sinks with diminishing returns",
        source: sweep_source(COM_GAIN, &[COM]),
        run: |e, r| curves((e, COM_GAIN, r), WALK, &[COM], ANY, |c| c.diminishes()),
    },
    Test {
        id: "6.3.7-c",
        says: "The feet error grows with it, about linearly.",
        test: "mean feet error of the walk rises with the gain, and straight",
        source: sweep_source(COM_GAIN, &[FEET]),
        run: |e, r| {
            let mut parts = curves((e, COM_GAIN, r), WALK, &[FEET], ANY, |c| c.rises());
            parts.extend(curves((e, COM_GAIN, r), WALK, &[FEET], ANY, |c| c.is_straight()));
            parts
        },
    },
    Test {
        id: "6.3.7-d",
        says: "On the push it has no large effect.",
        test: "mean CoM, feet and torso errors and mean torque of the push are little changed at all levels",
        source: sweep_source(COM_GAIN, &[COM, FEET, TORSO, TORQUE]),
        run: |e, r| {
            let little = |curve: Curve| curve.changes_at_most(LITTLE);
            curves((e, COM_GAIN, r), PUSH, &[COM, FEET, TORSO, TORQUE], ANY, little)
        },
    },
    Test {
        id: "6.3.7-e",
        says: "After the push the limit of the momentum rate is reached with most gains.",
        test: "the horizontal momentum rate asked for is at its limit in some ticks at more than half of the levels",
        source: sweep_source(COM_GAIN, &["momentum_rate_limited_fraction"]),
        run: |e, r| vec![momentum_rate_is_limited(e, r)],
    },
    Test {
        id: "6.3.7-f",
        says: "A higher CoM gain costs more in the walk.",
        test: "mean torque and u² of the walk rise with the gain",
        source: sweep_source(COM_GAIN, &COST),
        run: |e, r| curves((e, COM_GAIN, r), WALK, &COST, ANY, |c| c.rises()),
    },
    Test {
        id: "6.3.7-g",
        says: "It costs slightly less in the push.",
        test: "mean torque and u² of the push sink with the gain, and are little changed",
        source: sweep_source(COM_GAIN, &COST),
        run: |e, r| {
            let mut parts = curves((e, COM_GAIN, r), PUSH, &COST, ANY, |c| c.sinks());
            parts.extend(curves((e, COM_GAIN, r), PUSH, &COST, ANY, |c| c.changes_at_most(LITTLE)));
            parts
        },
    },
    Test {
        id: "6.3.8-a",
        says: "A higher foot gain lowers the feet error.",
        test: "mean feet error sinks with the gain, in walk and push",
        source: sweep_source(FOOT_GAIN, &[FEET]),
        run: |e, r| curves((e, FOOT_GAIN, r), &Experiment::ALL, &[FEET], ANY, |c| c.sinks()),
    },
    Test {
        id: "6.3.8-b",
        says: "It does so most at low values.",
        test: "mean feet error sinks with diminishing returns, in walk and push",
        source: sweep_source(FOOT_GAIN, &[FEET]),
        run: |e, r| curves((e, FOOT_GAIN, r), &Experiment::ALL, &[FEET], ANY, |c| c.diminishes()),
    },
    Test {
        id: "6.3.8-c",
        says: "In the walk it raises the CoM error.",
        test: "mean CoM error of the walk rises with the gain",
        source: sweep_source(FOOT_GAIN, &[COM]),
        run: |e, r| curves((e, FOOT_GAIN, r), WALK, &[COM], ANY, |c| c.rises()),
    },
    Test {
        id: "6.3.8-d",
        says: "It lowers the operating cost.",
        test: "mean torque and u² sink with the gain, in walk and push",
        source: sweep_source(FOOT_GAIN, &[TORQUE, U2]),
        run: |e, r| curves((e, FOOT_GAIN, r), &Experiment::ALL, &COST, ANY, |c| c.sinks()),
    },
    Test {
        id: "6.4-a",
        says: "High feet weight and high foot gain are each good, but together make the gait unstable.",
        test: "of the pairs of a feet weight and a foot gain above the baseline's at which each alone stands, at \
               least half fall together, in walk and push",
        source: Source {
            file: "runs",
            rows: "baseline scenarios with controller.weights.feet and controller.planner.foot_gain",
            columns: &["ending"],
        },
        run: |e, r| each(|experiment| stacking(e, r, experiment)),
    },
];

fn momentum_rate_is_limited(evidence: &Evidence, reading: Reading) -> Check {
    let levels = &evidence.sweep(COM_GAIN, reading, Experiment::Push).levels;
    let limited = levels.iter().filter(|tried| tried.momentum_rate_limited_fraction > 0.0).count();
    let shares = levels.iter().map(|tried| tried.momentum_rate_limited_fraction);
    let (least, most) = shares.fold((1.0_f64, 0.0_f64), |(least, most), share| (least.min(share), most.max(share)));
    let finding = format!(
        "push: at the limit at {limited} of {} levels, in {:.0} to {:.0} % of the ticks",
        levels.len(),
        100.0 * least,
        100.0 * most
    );
    Check::new(2 * limited > levels.len(), finding)
}

fn stacking(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let case = Case::new(reading, experiment, Gains::Baseline);
    let stands = |weight, gain| evidence.trial(case, &stacked(weight, gain)).stands();
    let (mut pairs, mut fallen) = (0, Vec::new());
    for &weight in &STACKED_WEIGHTS[1..] {
        for &gain in &STACKED_GAINS[1..] {
            if stands(weight, STACKED_GAINS[0]) && stands(STACKED_WEIGHTS[0], gain) {
                pairs += 1;
                if !stands(weight, gain) {
                    fallen.push(format!("C_f {} with P_f {}", digits(weight), digits(gain)));
                }
            }
        }
    }
    let finding = format!(
        "{}: of {pairs} pairs each of which stands alone {} fall together: {}",
        experiment.name(),
        fallen.len(),
        list(&fallen)
    );
    Check::new(pairs > 0 && 2 * fallen.len() >= pairs, finding)
}
