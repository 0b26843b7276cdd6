//! Claims about the torque limit (6.1) and the force limit (6.3.1).

use super::{Source, Test, curves, each, sweep_source, sweeps};
use crate::case::{Experiment, Reading};
use crate::curve::{Curve, falls_at_all, stands_at_all};
use crate::evidence::Evidence;
use crate::sweep::{COM, COST, FEET, GRF_PEAK, TORQUE, TORSO, TRACKING, U2, figure};
use crate::terms::{Check, LITTLE, POOR, UNCHANGED};
use crate::words::{digits, with_unit};

const TORQUE_LIMIT: &str = "torque-limit";
const GRF_LIMIT: &str = "grf-limit";
const TRACKED: Source = sweep_source(TORQUE_LIMIT, &[COM, FEET, TORSO]);
const ENDINGS: Source = sweep_source(TORQUE_LIMIT, &["ending"]);
/// The levels that are tried next to the thesis's 200 Nm on the side that it calls infeasible.
const BELOW_200: (f64, f64) = (0.0, 199.0);

pub(super) const TESTS: &[Test] = &[
    Test {
        id: "6.1-a",
        says: "With a torque limit under 200 Nm the robot topples.",
        test: "walk and push fall at every level below 200 Nm",
        source: ENDINGS,
        run: |e, r| sweeps(e, TORQUE_LIMIT, r, |sweep| falls_at_all(sweep, BELOW_200.0, BELOW_200.1)),
    },
    Test {
        id: "6.1-b",
        says: "From 200 Nm on the design goals are met.",
        test: "walk and push stand at every level from 200 Nm up",
        source: ENDINGS,
        run: |e, r| sweeps(e, TORQUE_LIMIT, r, |sweep| stands_at_all(sweep, 200.0, 500.0)),
    },
    Test {
        id: "6.1-c",
        says: "What fails under 200 Nm is the tracking of the feet.",
        test: "in every fall below 200 Nm the mean feet error up to the fall is poor: twice that at 500 Nm",
        source: sweep_source(TORQUE_LIMIT, &["ending", FEET]),
        run: |e, r| each(|experiment| feet_before_falls(e, r, experiment)),
    },
    Test {
        id: "6.1-d",
        says: "A higher torque limit makes the tracking of all trajectories more accurate.",
        test: "mean CoM, feet and torso errors sink with the limit from 200 Nm up, in walk and push",
        source: TRACKED,
        run: |e, r| curves((e, TORQUE_LIMIT, r), &Experiment::ALL, &TRACKING, (200.0, 500.0), |c| c.sinks()),
    },
    Test {
        id: "6.1-e",
        says: "A higher torque limit costs more to operate.",
        test: "mean torque and u² rise with the limit from 200 Nm up, in walk and push",
        source: sweep_source(TORQUE_LIMIT, &[TORQUE, U2]),
        run: |e, r| curves((e, TORQUE_LIMIT, r), &Experiment::ALL, &COST, (200.0, 500.0), |c| c.rises()),
    },
    Test {
        id: "6.1-f",
        says: "The gain slows above 220 Nm, as the mean feet error shows (Figure 6.1).",
        test: "mean feet error sinks per Nm from 220 to 500 Nm less than half as fast as from 200 to 220 Nm, in walk \
               and push",
        source: sweep_source(TORQUE_LIMIT, &[FEET]),
        run: |e, r| each(|experiment| slows(e, r, experiment)),
    },
    Test {
        id: "6.1-g",
        says: "Above 220 Nm the torque limit has no large effect.",
        test: "mean CoM, feet and torso errors are little changed from 220 to 500 Nm, in walk and push",
        source: TRACKED,
        run: |e, r| {
            let little = |curve: Curve| curve.changes_at_most(LITTLE);
            curves((e, TORQUE_LIMIT, r), &Experiment::ALL, &TRACKING, (220.0, 500.0), little)
        },
    },
    Test {
        id: "6.3.1-a",
        says: "Walking gets much better as the force limit is raised to 750 N.",
        test: "mean CoM, feet and torso errors of the walk sink much from the lowest level at which it stands to 750 N",
        source: sweep_source(GRF_LIMIT, &[COM, FEET, TORSO]),
        run: |e, r| {
            let gains = |curve: Curve| curve.moves(-1.0, LITTLE);
            curves((e, GRF_LIMIT, r), &[Experiment::Walk], &TRACKING, (0.0, 750.0), gains)
        },
    },
    Test {
        id: "6.3.1-b",
        says: "The push needs a force limit of 750 N.",
        test: "the push falls at every level below 750 N, and stands at every level from 750 N up",
        source: sweep_source(GRF_LIMIT, &["ending"]),
        run: |e, r| {
            let sweep = e.sweep(GRF_LIMIT, r, Experiment::Push);
            vec![falls_at_all(sweep, 0.0, 749.0), stands_at_all(sweep, 750.0, f64::INFINITY)]
        },
    },
    Test {
        id: "6.3.1-c",
        says: "Above 750 N only the peak force grows.",
        test: "peak force rises from 750 N up, in walk and push",
        source: sweep_source(GRF_LIMIT, &[GRF_PEAK]),
        run: |e, r| curves((e, GRF_LIMIT, r), &Experiment::ALL, &[GRF_PEAK], (750.0, 1500.0), |c| c.rises()),
    },
    Test {
        id: "6.3.1-d",
        says: "Above 750 N tracking gets no better.",
        test: "mean CoM, feet and torso errors are unchanged from 750 to 1500 N, in walk and push",
        source: sweep_source(GRF_LIMIT, &[COM, FEET, TORSO]),
        run: |e, r| {
            let same = |curve: Curve| curve.changes_at_most(UNCHANGED);
            curves((e, GRF_LIMIT, r), &Experiment::ALL, &TRACKING, (750.0, 1500.0), same)
        },
    },
];

fn feet_before_falls(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let (name, sweep) = (experiment.name(), evidence.sweep(TORQUE_LIMIT, reading, experiment));
    let full = sweep.at(500.0).and_then(|tried| tried.figure(FEET));
    let falls = sweep.between(BELOW_200.0, BELOW_200.1).filter(|tried| !tried.rollout.survived());
    let errors: Vec<f64> = falls.filter_map(|tried| figure(&tried.rollout, FEET)).collect();
    match (full, errors.is_empty()) {
        (Some(full), false) => {
            let poor = errors.iter().filter(|&&error| error >= POOR * full).count();
            let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
            let finding = format!(
                "{name}: poor in {poor} of {} falls; least mean feet error before a fall {}, at 500 Nm {}",
                errors.len(),
                with_unit(least, "m"),
                with_unit(full, "m")
            );
            Check::new(poor == errors.len(), finding)
        }
        (_, true) => Check::new(false, format!("{name}: no fall below 200 Nm")),
        (None, _) => Check::new(false, format!("{name}: falls at 500 Nm")),
    }
}

fn slows(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let (name, sweep) = (experiment.name(), evidence.sweep(TORQUE_LIMIT, reading, experiment));
    let at = |level: f64| sweep.at(level).and_then(|tried| tried.figure(FEET));
    let (Some(low), Some(knee), Some(high)) = (at(200.0), at(220.0), at(500.0)) else {
        return Check::new(false, format!("{name}: falls at 200, 220 or 500 Nm"));
    };
    let (below, above) = ((low - knee) / 20.0, (knee - high) / 280.0);
    let finding = format!("{name}: sinks by {} m/Nm up to 220 Nm, by {} m/Nm above", digits(below), digits(above));
    Check::new(below > 0.0 && above < 0.5 * below, finding)
}
