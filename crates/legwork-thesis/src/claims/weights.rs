//! Claims about the weights of the cost (6.3.2 to 6.3.6).

use super::{Source, Test, curves, each, sweep_source, sweeps};
use crate::case::{Case, Experiment, Gains, Reading};
use crate::curve::{Curve, falls_at_all};
use crate::evidence::Evidence;
use crate::sweep::{COM, COST, FEET, Sweep, TORQUE, TORSO, U2};
use crate::terms::{Check, UNCHANGED};
use crate::trial::{HARD_FEET_WITH, hard_feet};
use crate::words::with_unit;

const FORCES: &str = "grf-weight";
const ACCELERATIONS: &str = "acceleration-weight";
const MOMENTUM: &str = "momentum-weight";
const FEET_WEIGHT: &str = "feet-weight";
const TORSO_WEIGHT: &str = "torso-weight";
const ANY: (f64, f64) = (0.0, f64::INFINITY);
const FELT: [&str; 4] = [COM, FEET, TORSO, TORQUE];
/// How far into a step its start reaches, as a share of the step time.
const START_OF_STEP: f64 = 0.1;

fn unchanged(curve: Curve) -> Check {
    curve.changes_at_most(UNCHANGED)
}

pub(super) const TESTS: &[Test] = &[
    Test {
        id: "6.3.2-a",
        says: "Below 0.1 the force weight has no effect.",
        test: "mean CoM, feet and torso errors and mean torque are unchanged at all levels below 0.1, in walk and push",
        source: sweep_source(FORCES, &FELT),
        run: |e, r| curves((e, FORCES, r), &Experiment::ALL, &FELT, (0.0, 0.09), unchanged),
    },
    Test {
        id: "6.3.2-b",
        says: "Above 0.1 the controller becomes unstable.",
        test: "walk and push fall at every level above 0.1",
        source: sweep_source(FORCES, &["ending"]),
        run: |e, r| sweeps(e, FORCES, r, |sweep| falls_at_all(sweep, 0.11, f64::INFINITY)),
    },
    Test {
        id: "6.3.2-c",
        says: "The robot then moves too late, and the feet are tracked too weakly.",
        test: "mean CoM and mean feet error are poor at every level above 0.1, in walk and push",
        source: sweep_source(FORCES, &[COM, FEET]),
        run: |e, r| {
            // A fall alone says nothing of its mechanism: the levels where the robot stands decide.
            let standing = |curve: Curve| curve.standing().is_poor();
            curves((e, FORCES, r), &Experiment::ALL, &[COM, FEET], (0.11, f64::INFINITY), standing)
        },
    },
    Test {
        id: "6.3.3-a",
        says: "Up to 10 the acceleration weight has no noticeable effect.",
        test: "mean CoM, feet and torso errors and mean torque are unchanged at all levels up to 10, in walk and push",
        source: sweep_source(ACCELERATIONS, &FELT),
        run: |e, r| curves((e, ACCELERATIONS, r), &Experiment::ALL, &FELT, (0.0, 10.0), unchanged),
    },
    Test {
        id: "6.3.3-b",
        says: "Above 10 the tracking of the feet gets weaker.",
        test: "mean feet error grows by more than 5 % from the last level below 10 to the highest at which the robot \
               stands, in walk and push",
        source: sweep_source(ACCELERATIONS, &[FEET]),
        run: |e, r| {
            let grows = |curve: Curve| curve.moves(1.0, UNCHANGED);
            curves((e, ACCELERATIONS, r), &Experiment::ALL, &[FEET], (4.6, f64::INFINITY), grows)
        },
    },
    Test {
        id: "6.3.3-c",
        says: "Above 10 the mean torque and so the energy are higher.",
        test: "mean torque and u² grow by more than 5 % over the same levels, in walk and push",
        source: sweep_source(ACCELERATIONS, &COST),
        run: |e, r| {
            let grows = |curve: Curve| curve.moves(1.0, UNCHANGED);
            curves((e, ACCELERATIONS, r), &Experiment::ALL, &COST, (4.6, f64::INFINITY), grows)
        },
    },
    Test {
        id: "6.3.4-a",
        says: "With a momentum weight under 10 the momentum is tracked poorly.",
        test: "mean CoM error is poor at every level below 10, in walk and push",
        source: sweep_source(MOMENTUM, &[COM]),
        run: |e, r| curves((e, MOMENTUM, r), &Experiment::ALL, &[COM], (0.0, 9.0), |c| c.is_poor()),
    },
    Test {
        id: "6.3.4-b",
        says: "That leads to instability.",
        test: "walk and push fall at every level below 10",
        source: sweep_source(MOMENTUM, &["ending"]),
        run: |e, r| sweeps(e, MOMENTUM, r, |sweep| falls_at_all(sweep, 0.0, 9.0)),
    },
    Test {
        id: "6.3.4-c",
        says: "Above 1000 the feet are tracked poorly and the gait is unstable.",
        test: "mean feet error is poor at every level above 1000, and walk and push fall there",
        source: sweep_source(MOMENTUM, &["ending", FEET]),
        run: |e, r| {
            let above = (1001.0, f64::INFINITY);
            let mut parts = curves((e, MOMENTUM, r), &Experiment::ALL, &[FEET], above, |c| c.is_poor());
            parts.extend(sweeps(e, MOMENTUM, r, |sweep| falls_at_all(sweep, above.0, above.1)));
            parts
        },
    },
    Test {
        id: "6.3.5-a",
        says: "At a feet weight of 1000 and less the feet are tracked too weakly.",
        test: "mean feet error is poor at every level up to 1000, in walk and push",
        source: sweep_source(FEET_WEIGHT, &["ending", FEET]),
        run: |e, r| curves((e, FEET_WEIGHT, r), &Experiment::ALL, &[FEET], (0.0, 1001.0), |c| c.is_poor()),
    },
    Test {
        id: "6.3.5-b",
        says: "A higher feet weight improves the tracking of the feet.",
        test: "mean feet error sinks with the weight, in walk and push",
        source: sweep_source(FEET_WEIGHT, &[FEET]),
        run: |e, r| curves((e, FEET_WEIGHT, r), &Experiment::ALL, &[FEET], ANY, |c| c.sinks()),
    },
    Test {
        id: "6.3.5-c",
        says: "It lowers the mean torque and so the energy.",
        test: "mean torque and u² sink with the weight, in walk and push",
        source: sweep_source(FEET_WEIGHT, &COST),
        run: |e, r| curves((e, FEET_WEIGHT, r), &Experiment::ALL, &COST, ANY, |c| c.sinks()),
    },
    Test {
        id: "6.3.5-d",
        says: "High feet weights worsen the tracking of the torso.",
        test: "mean torso error rises with the weight from the baseline's 1e5 up, in walk and push",
        source: sweep_source(FEET_WEIGHT, &[TORSO]),
        run: |e, r| curves((e, FEET_WEIGHT, r), &Experiment::ALL, &[TORSO], (1e5, f64::INFINITY), |c| c.rises()),
    },
    Test {
        id: "6.3.5-e",
        says: "Feet tracking as hard equality cannot be met at the start of a step.",
        test: "in walk and push of the baseline at 220 Nm the program has no solution at some tick, the first within a \
               tenth of the step time after a trigger",
        source: HARD,
        run: |e, r| each(|experiment| hard_feet_fail(e, r, experiment)),
    },
    Test {
        id: "6.3.5-f",
        says: "Feet tracking as hard equality makes the robot highly unstable.",
        test: "walk and push of the baseline at 220 Nm fall with it",
        source: HARD,
        run: |e, r| each(|experiment| hard_feet_fall(e, r, experiment)),
    },
    Test {
        id: "6.3.6-a",
        says: "Up to 1e4 a higher torso weight lowers the torso's error.",
        test: "mean torso error sinks with the weight up to 1e4, in walk and push",
        source: sweep_source(TORSO_WEIGHT, &[TORSO]),
        run: |e, r| curves((e, TORSO_WEIGHT, r), &Experiment::ALL, &[TORSO], (0.0, 1e4), |c| c.sinks()),
    },
    Test {
        id: "6.3.6-b",
        says: "Up to 1e4 it does not change the errors of feet and CoM.",
        test: "mean feet and CoM errors are unchanged at all levels up to 1e4, in walk and push",
        source: sweep_source(TORSO_WEIGHT, &[FEET, COM]),
        run: |e, r| curves((e, TORSO_WEIGHT, r), &Experiment::ALL, &[FEET, COM], (0.0, 1e4), unchanged),
    },
    Test {
        id: "6.3.6-c",
        says: "Above 1e4 it improves the torso slightly more.",
        test: "mean torso error sinks over all levels with diminishing returns, in walk and push",
        source: sweep_source(TORSO_WEIGHT, &[TORSO]),
        run: |e, r| curves((e, TORSO_WEIGHT, r), &Experiment::ALL, &[TORSO], ANY, |c| c.diminishes()),
    },
    Test {
        id: "6.3.6-d",
        says: "Above 1e4 it worsens the feet and costs more to operate.",
        test: "mean feet error, mean torque and u² rise from 1e4 up, in walk and push",
        source: sweep_source(TORSO_WEIGHT, &[FEET, TORQUE, U2]),
        run: |e, r| {
            let figures = [FEET, TORQUE, U2];
            curves((e, TORSO_WEIGHT, r), &Experiment::ALL, &figures, (1e4, f64::INFINITY), |c| c.rises())
        },
    },
    Test {
        id: "7.1.2-a",
        says: "High weights of the operating costs lead to instability.",
        test: "walk and push fall at the highest level of the force weight and of the acceleration weight",
        source: sweep_source(FORCES, &["ending"]),
        run: |e, r| {
            let highest = |study| {
                sweeps(e, study, r, |sweep| {
                    let level = sweep.levels[sweep.levels.len() - 1].level;
                    falls_at_all(sweep, level, level)
                })
            };
            [FORCES, ACCELERATIONS].into_iter().flat_map(highest).collect()
        },
    },
    Test {
        id: "8.1.2-a",
        says: "With a low torso weight the robot makes momentum by leaning, and often topples.",
        test: "mean torso error is poor at every level up to 1000, and walk and push fall at the lowest level",
        source: sweep_source(TORSO_WEIGHT, &["ending", TORSO]),
        run: |e, r| {
            let mut parts = curves((e, TORSO_WEIGHT, r), &Experiment::ALL, &[TORSO], (0.0, 1001.0), |c| c.is_poor());
            parts.extend(sweeps(e, TORSO_WEIGHT, r, falls_at_lowest));
            parts
        },
    },
    Test {
        id: "8.1.2-b",
        says: "With a low feet weight the program uses the legs for the momentum, which leads to instability.",
        test: "walk and push fall at the lowest level of the feet weight",
        source: sweep_source(FEET_WEIGHT, &["ending"]),
        run: |e, r| sweeps(e, FEET_WEIGHT, r, falls_at_lowest),
    },
    Test {
        id: "7.4-a",
        says: "Tracking in the cost works; feet tracking as hard equality is not always feasible.",
        test: "the baseline's programs all have a solution with feet in the cost, and some have none with hard feet, \
               in walk and push",
        source: HARD,
        run: |e, r| each(|experiment| soft_works(e, r, experiment)),
    },
];

const HARD: Source = Source {
    file: "runs",
    rows: "baseline scenarios, none and controller.tracking.feet=equality at 220 Nm",
    columns: &["ending", "infeasible", "first_infeasible_s", "since_trigger_s", "conflict"],
};

fn falls_at_lowest(sweep: &Sweep) -> Check {
    let level = sweep.levels[0].level;
    falls_at_all(sweep, level, level)
}

fn baseline(reading: Reading, experiment: Experiment) -> Case {
    Case::new(reading, experiment, Gains::Baseline)
}

fn hard_feet_fail(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let case = baseline(reading, experiment);
    let (name, program) = (experiment.name(), &evidence.trial(case, &hard_feet(HARD_FEET_WITH[0])).program);
    let step = evidence.run(case).scenario.reference.step.duration_s;
    let Some(first) = program.first_infeasible_s else {
        return Check::new(false, format!("{name}: all programs have a solution"));
    };
    let since = program.since_trigger_s;
    let place = since.map_or("in double support".to_owned(), |s| format!("{} after the trigger", with_unit(s, "s")));
    let finding = format!(
        "{name}: {} of {} programs have no solution, the first at {}, {place}: {}",
        program.infeasible,
        program.ticks,
        with_unit(first, "s"),
        program.conflict.join(", ")
    );
    Check::new(since.is_some_and(|since| since <= START_OF_STEP * step), finding)
}

fn hard_feet_fall(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let case = baseline(reading, experiment);
    let (name, result) = (experiment.name(), evidence.trial(case, &hard_feet(HARD_FEET_WITH[0])));
    let soft = evidence.trial(case, &[]);
    let yielded = result.program.tasks_yielded;
    match (&result.rollout.reason, soft.stands()) {
        (Some(reason), true) => Check::new(true, format!("{name}: {reason}")),
        (Some(_), false) => Check::new(false, format!("{name}: falls, and so it does with feet in the cost")),
        (None, _) => Check::new(
            false,
            format!("{name}: stands, as the hard task yields in the {yielded} ticks without solution"),
        ),
    }
}

fn soft_works(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let case = baseline(reading, experiment);
    let (soft, hard) =
        (&evidence.trial(case, &[]).program, &evidence.trial(case, &hard_feet(HARD_FEET_WITH[0])).program);
    let finding = format!(
        "{}: without solution {} of {} programs with feet in the cost, {} of {} with hard feet",
        experiment.name(),
        soft.infeasible,
        soft.ticks,
        hard.infeasible,
        hard.ticks
    );
    Check::new(soft.infeasible == 0 && hard.infeasible > 0, finding)
}
