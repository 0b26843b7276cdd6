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
/// How near to its limit a torque is at it, as a share.
const AT_LIMIT: f64 = 0.999;

pub(super) const LOG_JUDGES: &[(&str, Judge)] = &[
    ("steps follow the XcoM", |a| vec![steps_follow_the_xcom(a)]),
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

fn steps_follow_the_xcom(a: &Asked) -> Check {
    let run = a.run();
    let dimension = run.model.linear_axes().len();
    let outside = |index: usize, x: f64| {
        let feet = run.log.get(index, Field::Feet);
        (x > feet[0] && x > feet[dimension]) || (x < feet[0] && x < feet[dimension])
    };
    let steps: Vec<usize> = triggers(&run.log).collect();
    let count = |field| steps.iter().filter(|&&i| outside(i, run.log.get(i, field)[0])).count();
    let (xcom, com) = (count(Field::Xcom), count(Field::Com));
    let finding =
        format!("of {} steps {xcom} begin with the XcoM outside, {com} with the CoM itself outside", steps.len());
    a.check(!steps.is_empty() && xcom == steps.len(), finding)
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
