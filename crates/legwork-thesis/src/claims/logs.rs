//! Judges of what the logs of the final design's runs say.

use std::ops::RangeInclusive;

use super::judge::{Asked, Judge};
use crate::terms::{Check, MET};
use crate::words::with_unit;
use legwork::episode::Run;
use legwork::log::{Field, Log};
use legwork::metrics::com_error;

/// From when on a walk counts as steady [s].
const STEADY_FROM_S: f64 = 2.0;
/// The part of a swing that is the top of its arc, as shares of the step time.
const TOP: RangeInclusive<f64> = 1.0 / 3.0..=2.0 / 3.0;
/// Change of a foot's acceleration from a tick to the next from which on its reference is not smooth [m/s²]: gravity.
const ROUGH: f64 = 9.81;
/// How near to its limit a torque is at it, as a share.
const AT_LIMIT: f64 = 0.999;

pub(super) const LOG_JUDGES: &[(&str, Judge)] = &[
    ("steps follow the XcoM", |a| vec![steps_follow_the_xcom(a)]),
    ("the XcoM does not stay outside", |a| vec![xcom_does_not_stay_outside(a)]),
    ("one foot carries in single support", |a| vec![one_foot_carries(a)]),
    ("references jump", |a| vec![references_jump(a)]),
    ("reference rests", |a| {
        let log = &a.run().log;
        let reference = |index: usize| log.get(index, Field::ComReference)[0];
        let moved = (0..log.len()).map(|index| (reference(index) - reference(0)).abs()).fold(0.0, f64::max);
        vec![Check::new(moved == 0.0, format!("the reference moves by {}", with_unit(moved, "m")))]
    }),
    ("returns", |a| {
        let run = a.run();
        let error = com_error(&run.log, run.log.len() - 1);
        let returned = run.reason.is_none() && error < run.scenario.metrics.recovered_within_m;
        vec![Check::new(returned, format!("last CoM error {}", with_unit(error, "m")))]
    }),
    ("start is corrected", |a| vec![start_is_corrected(a.run(), a.part.published)]),
    ("errors are largest at the top", |a| vec![peaks_are_at_the_top(a.run())]),
    ("torque is at its limit", |a| vec![torque_is_at_its_limit(a.run())]),
    ("error grows and shrinks", |a| phases(a.run())),
];

/// The records in which a step is triggered.
fn triggers(log: &Log) -> impl Iterator<Item = usize> + '_ {
    let since = log.range(Field::Swing).start + 1;
    let mut before = -1.0;
    log.column(since).enumerate().filter_map(move |(index, now)| {
        let begins = now > before;
        before = f64::max(before, now);
        begins.then_some(index)
    })
}

/// How far a place is ahead of both feet and behind both [m].
fn outside(run: &Run, index: usize, x: f64) -> [f64; 2] {
    let feet = run.log.get(index, Field::Feet);
    let (right, left) = (feet[0], feet[run.model.linear_axes().len()]);
    [x - right.max(left), right.min(left) - x]
}

fn steps_follow_the_xcom(a: &Asked) -> Check {
    let run = a.run();
    let steps: Vec<usize> = triggers(&run.log).collect();
    let is_outside =
        |index: usize, field| outside(run, index, run.log.get(index, field)[0]).iter().any(|&out| out > 0.0);
    let count = |field| steps.iter().filter(|&&index| is_outside(index, field)).count();
    let (xcom, com) = (count(Field::Xcom), count(Field::Com));
    let finding =
        format!("of {} steps {xcom} begin with the XcoM outside, {com} with the CoM itself outside", steps.len());
    a.check(!steps.is_empty() && xcom == steps.len(), finding)
}

/// The other direction: in double support the XcoM gets no further out than the delay lets it, on the side that the reference moves to.
fn xcom_does_not_stay_outside(a: &Asked) -> Check {
    let (log, step, dimension) = (&a.run().log, &a.run().scenario.reference.step, a.run().model.linear_axes().len());
    let double = |&index: &usize| log.get(index, Field::Swing)[0] < 0.0;
    let beyond = |index: usize| {
        let speed = log.get(index, Field::ComReference)[dimension];
        let delay = (step.delay_s * speed.abs()).min(step.max_delay_m);
        let [ahead, behind] = outside(a.run(), index, log.get(index, Field::Xcom)[0]);
        (ahead - if speed > 0.0 { delay } else { 0.0 }).max(behind - if speed < 0.0 { delay } else { 0.0 })
    };
    let furthest = (0..log.len()).filter(double).map(beyond).fold(f64::NEG_INFINITY, f64::max);
    let side = if furthest > 0.0 { "beyond" } else { "before" };
    let finding =
        format!("in double support the XcoM gets to {} {side} where a step begins", with_unit(furthest.abs(), "m"));
    a.check(furthest <= 0.0, finding)
}

fn one_foot_carries(a: &Asked) -> Check {
    let (run, dimension) = (a.run(), a.run().model.linear_axes().len());
    let swing = |&index: &usize| run.log.get(index, Field::Swing)[0] >= 0.0;
    let carries = |&index: &usize| {
        let up = |foot: usize| run.log.get(index, Field::Grf)[(foot + 1) * dimension - 1];
        up(run.log.get(index, Field::Swing)[0] as usize) > 0.0
    };
    let ticks: Vec<usize> = (0..run.log.len()).filter(swing).collect();
    let both = ticks.iter().filter(|index| carries(index)).count();
    let finding = format!("in {both} of {} ticks of single support the program has force on both feet", ticks.len());
    a.check(!ticks.is_empty() && both == 0, finding)
}

fn references_jump(a: &Asked) -> Check {
    let (run, dimension) = (a.run(), a.run().model.linear_axes().len());
    let accelerations = |index: usize| {
        let reference = run.log.get(index, Field::FeetReference);
        [2, 5].map(|block| reference[block * dimension])
    };
    let jump = |index: usize| {
        let (now, before) = (accelerations(index), accelerations(index - 1));
        now.iter().zip(before).map(|(now, before)| (now - before).abs()).fold(0.0, f64::max)
    };
    let largest = (1..run.log.len()).map(jump).fold(0.0, f64::max);
    let finding = format!(
        "the acceleration asked of a foot jumps by up to {}, and {} programs have no solution",
        with_unit(largest, "m/s²"),
        run.program.infeasible
    );
    a.check(largest > ROUGH && run.program.infeasible == 0, finding)
}

fn start_is_corrected(run: &Run, published: f64) -> Check {
    let from = run.scenario.metrics.com_error_from_s;
    let second = triggers(&run.log).nth(1).unwrap_or(run.log.len());
    let after = (0..second).filter(|&index| run.log.time(index) >= from);
    let largest = after.map(|index| com_error(&run.log, index)).fold(0.0, f64::max);
    let settled = (0..run.log.len()).rfind(|&index| com_error(&run.log, index) > published);
    let finding = format!(
        "largest error after {} and before the second step {}; below {} for good from {} on",
        with_unit(from, "s"),
        with_unit(largest, "m"),
        with_unit(published, "m"),
        with_unit(settled.map_or(0.0, |index| run.log.time(index)), "s")
    );
    Check::new(largest <= (1.0 + MET) * published, finding)
}

/// The first record of each swing, and that with the largest error of the swing foot.
fn swings(run: &Run) -> Vec<(usize, usize)> {
    let dimension = run.model.linear_axes().len();
    let error = |index: usize, foot: usize| {
        let position = &run.log.get(index, Field::Feet)[foot * dimension..][..dimension];
        let reference = &run.log.get(index, Field::FeetReference)[3 * foot * dimension..][..dimension];
        position.iter().zip(reference).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
    };
    let swing = |begin: usize| {
        let [foot, since] = [0, 1].map(|place| run.log.get(begin, Field::Swing)[place]);
        let same = |&index: &usize| run.log.get(index, Field::Swing) == [foot, since];
        let records = (begin..run.log.len()).take_while(same);
        let worst = records.max_by(|&a, &b| error(a, foot as usize).total_cmp(&error(b, foot as usize)));
        (begin, worst.unwrap_or(begin))
    };
    triggers(&run.log).map(swing).collect()
}

fn peaks_are_at_the_top(run: &Run) -> Check {
    let (swings, duration) = (swings(run), run.scenario.reference.step.duration_s);
    let shares = || swings.iter().map(|&(begin, worst)| (run.log.time(worst) - run.log.time(begin)) / duration);
    let top = shares().filter(|share| TOP.contains(share)).count();
    let early = shares().filter(|share| share < TOP.start()).count();
    let late = swings.len() - top - early;
    let finding = format!(
        "of {} swings the error is largest in the first third in {early}, in the middle third in {top}, in the last \
         in {late}",
        swings.len()
    );
    Check::new(!swings.is_empty() && 2 * top >= swings.len(), finding)
}

fn torque_is_at_its_limit(run: &Run) -> Check {
    let (swings, limit) = (swings(run), AT_LIMIT * run.scenario.controller.limits.torque_nm);
    let at_limit = |index: usize| run.log.get(index, Field::Torque).iter().any(|torque| torque.abs() >= limit);
    let limited = swings.iter().filter(|&&(begin, worst)| (begin..=worst).any(at_limit)).count();
    let finding = format!("a torque is at its limit before the largest error in {limited} of {} swings", swings.len());
    Check::new(!swings.is_empty() && 2 * limited >= swings.len(), finding)
}

fn phases(run: &Run) -> Vec<Check> {
    let (mut single, mut double) = (0.0, 0.0);
    for index in 1..run.log.len() {
        if run.log.time(index) >= STEADY_FROM_S {
            let change = com_error(&run.log, index) - com_error(&run.log, index - 1);
            let swings = run.log.get(index - 1, Field::Swing)[0] >= 0.0;
            *(if swings { &mut single } else { &mut double }) += change;
        }
    }
    let words = |phase: &str, change: f64| format!("{phase} support: {change:+.3} m in all");
    vec![Check::new(single > 0.0, words("single", single)), Check::new(double < 0.0, words("double", double))]
}
