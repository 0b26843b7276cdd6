//! Claims that the logs of the final design are asked about (7.1.1, 7.1.3, 7.2.1), and the size of the program (7.4).

use std::ops::RangeInclusive;

use super::{Source, Test, each};
use crate::episode::Run;
use crate::log::{Field, Log};
use crate::metrics::com_error;
use crate::qp::Layout;
use crate::reproduce::case::{Case, Experiment, Gains, Reading};
use crate::reproduce::evidence::Evidence;
use crate::reproduce::sweep::figure;
use crate::reproduce::terms::{Check, MET};
use crate::reproduce::trial::REPLAN;
use crate::reproduce::words::{percent, with_unit};
use crate::scenario::QpForm;

/// From when on a walk counts as steady [s].
const STEADY_FROM_S: f64 = 2.0;
/// The part of a swing that is the top of its arc, as shares of the step time.
const TOP: RangeInclusive<f64> = 1.0 / 3.0..=2.0 / 3.0;
/// How near to its limit a torque is at it, as a share.
const AT_LIMIT: f64 = 0.999;
/// How far the share of single support may be from the published one.
const SUPPORT_MET: f64 = 0.05;

const fn logs(rows: &'static str, columns: &'static [&'static str]) -> Source {
    Source { file: "logs", rows, columns }
}

pub(super) const TESTS: &[Test] = &[
    Test {
        id: "7.1.1-a",
        says: "A step is taken when the XcoM leaves the base of support.",
        test: "at every trigger of a step the XcoM is ahead of both feet or behind both, in walk and push",
        source: logs("walk, push", &["swing_since", "xcom", "foot.right_foot_x", "foot.left_foot_x"]),
        run: |e, r| each(|experiment| steps_follow_the_xcom(e, r, experiment)),
    },
    Test {
        id: "7.1.1-b",
        says: "Disturbances are answered without a new CoM trajectory, and the robot returns to the CoM's constant \
               target.",
        test: "the push's CoM reference does not move, the robot steps, and its last CoM error is below 0.05 m",
        source: logs("push", &["com_reference_x", "com_x", "swing_since"]),
        run: returns,
    },
    Test {
        id: "7.1.1-c",
        says: "A step once begun is not changed, so that the robot cannot answer what happens meanwhile.",
        test: "with re-planning in mid-swing the push is recovered from within a shorter distance",
        source: Source {
            file: "runs",
            rows: "push scenarios, none and reference.step.replan=in-swing",
            columns: &["recovery_distance_m"],
        },
        run: replanning_helps,
    },
    Test {
        id: "7.1.3-e",
        says: "0.4 s is the time in which the error of the start is corrected.",
        test: "from 0.4 s on the walk's CoM error is met at 0.028 m or less until the second step begins",
        source: logs("walk", &["com_x", "com_z", "com_reference_x", "com_reference_z"]),
        run: |e, r| vec![start_is_corrected(e.final_run(r, Experiment::Walk))],
    },
    Test {
        id: "7.1.3-f",
        says: "The feet's largest errors are at the top of their arcs.",
        test: "in at least half of the walk's swings the swing foot's error is largest in the middle third of the \
               step time",
        source: logs("walk", &["swing_since", "foot.right_foot_x", "foot_reference.right_foot_x"]),
        run: |e, r| vec![peaks_are_at_the_top(e.final_run(r, Experiment::Walk))],
    },
    Test {
        id: "7.1.3-g",
        says: "The likely reason is that the torque does not suffice.",
        test: "in at least half of the walk's swings a torque is at its limit between the trigger and the largest \
               error",
        source: logs("walk", &["swing_since", "torque.right_hip"]),
        run: |e, r| vec![torque_is_at_its_limit(e.final_run(r, Experiment::Walk))],
    },
    Test {
        id: "7.2.1-a",
        says: "Single support is about 35 % of the walk.",
        test: "from 30 to 40 % of the ticks lie between trigger and touchdown",
        source: Source { file: "limits", rows: "single support", columns: &["displacement", "base-of-support"] },
        run: |e, r| {
            let share = e.final_run(r, Experiment::Walk).metrics.single_support_fraction;
            vec![Check::new((share - 0.35).abs() <= SUPPORT_MET, percent(share))]
        },
    },
    Test {
        id: "7.2.1-b",
        says: "In single support the CoM deviates from its trajectory, in double support that is made good.",
        test: "from 2 s on the walk's CoM error grows over the ticks of single support together and shrinks over \
               those of double support",
        source: logs("walk", &["swing", "com_x", "com_z", "com_reference_x", "com_reference_z"]),
        run: |e, r| phases(e.final_run(r, Experiment::Walk)),
    },
    Test {
        id: "7.4-b",
        says: "Slack variables make the cost purely quadratic, at the price of more constraints.",
        test: "the slack form has more rows than the direct form",
        source: Source { file: "questions", rows: "slack", columns: &["value"] },
        run: |e, r| vec![slack_has_more_rows(e.final_run(r, Experiment::Walk))],
    },
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

fn steps_follow_the_xcom(evidence: &Evidence, reading: Reading, experiment: Experiment) -> Check {
    let run = evidence.final_run(reading, experiment);
    let dimension = run.model.linear_axes().len();
    let outside = |index: usize, x: f64| {
        let feet = run.log.get(index, Field::Feet);
        (x > feet[0] && x > feet[dimension]) || (x < feet[0] && x < feet[dimension])
    };
    let steps: Vec<usize> = triggers(&run.log).collect();
    let count = |point: fn(&Log, usize) -> f64| steps.iter().filter(|&&i| outside(i, point(&run.log, i))).count();
    let xcom = count(|log, index| log.get(index, Field::Xcom)[0]);
    let com = count(|log, index| log.get(index, Field::Com)[0]);
    let finding = format!(
        "{}: of {} steps {xcom} begin with the XcoM outside, {com} with the CoM itself outside",
        experiment.name(),
        steps.len()
    );
    Check::new(!steps.is_empty() && xcom == steps.len(), finding)
}

fn returns(evidence: &Evidence, reading: Reading) -> Vec<Check> {
    let run = evidence.final_run(reading, Experiment::Push);
    let last = run.log.len() - 1;
    let reference = |index: usize| run.log.get(index, Field::ComReference)[0];
    let moved = (0..=last).map(|index| (reference(index) - reference(0)).abs()).fold(0.0, f64::max);
    let error = com_error(&run.log, last);
    vec![
        Check::new(moved == 0.0, format!("the reference moves by {}", with_unit(moved, "m"))),
        Check::new(run.metrics.steps > 0, format!("{} steps", run.metrics.steps)),
        Check::new(
            run.reason.is_none() && error < run.scenario.metrics.recovered_within_m,
            format!("last CoM error {}", with_unit(error, "m")),
        ),
    ]
}

fn replanning_helps(evidence: &Evidence, reading: Reading) -> Vec<Check> {
    let case = Case::new(reading, Experiment::Push, Gains::Final);
    let distance = |sets: &[String]| {
        let result = evidence.trial(case, sets);
        figure(&result.rollout, "recovery_distance_m").filter(|_| result.stands())
    };
    let (off, on) = (distance(&[]), distance(&[REPLAN.to_owned()]));
    let words = |value: Option<f64>| value.map_or("a fall".to_owned(), |value| with_unit(value, "m"));
    let holds = off.zip(on).is_some_and(|(off, on)| on < off);
    vec![Check::new(holds, format!("{} with re-planning, {} without", words(on), words(off)))]
}

fn start_is_corrected(run: &Run) -> Check {
    let from = run.scenario.metrics.com_error_from_s;
    let second = triggers(&run.log).nth(1).unwrap_or(run.log.len());
    let after = (0..second).filter(|&index| run.log.time(index) >= from);
    let largest = after.map(|index| com_error(&run.log, index)).fold(0.0, f64::max);
    let settled = (0..run.log.len()).rfind(|&index| com_error(&run.log, index) > 0.028);
    let from_then = settled.map_or(0.0, |index| run.log.time(index));
    let finding = format!(
        "largest error after {} and before the second step {}; below 0.028 m for good from {} on",
        with_unit(from, "s"),
        with_unit(largest, "m"),
        with_unit(from_then, "s")
    );
    Check::new(largest <= (1.0 + MET) * 0.028, finding)
}

/// A swing: its records, and the one with the largest error of the swing foot.
struct Swing {
    begin: usize,
    worst: usize,
}

fn swings(run: &Run) -> Vec<Swing> {
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
        Swing { begin, worst: worst.unwrap_or(begin) }
    };
    triggers(&run.log).map(swing).collect()
}

fn peaks_are_at_the_top(run: &Run) -> Check {
    let (swings, duration) = (swings(run), run.scenario.reference.step.duration_s);
    let share = |swing: &Swing| (run.log.time(swing.worst) - run.log.time(swing.begin)) / duration;
    let shares: Vec<f64> = swings.iter().map(share).collect();
    let top = shares.iter().filter(|&share| TOP.contains(share)).count();
    let early = shares.iter().filter(|&share| share < TOP.start()).count();
    let late = shares.len() - top - early;
    let finding = format!(
        "of {} swings the error is largest in the first third in {early}, in the middle third in {top}, in the last \
         in {late}",
        shares.len()
    );
    Check::new(!shares.is_empty() && 2 * top >= shares.len(), finding)
}

fn torque_is_at_its_limit(run: &Run) -> Check {
    let (swings, limit) = (swings(run), run.scenario.controller.limits.torque_nm);
    let at_limit =
        |index: usize| run.log.get(index, Field::Torque).iter().any(|torque| torque.abs() >= AT_LIMIT * limit);
    let limited = swings.iter().filter(|swing| (swing.begin..=swing.worst).any(at_limit)).count();
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

fn slack_has_more_rows(run: &Run) -> Check {
    let [direct, slack] =
        [QpForm::Direct, QpForm::Slack].map(|form| Layout::new(form, &run.scenario.controller, &run.model));
    let size = |layout: &Layout| format!("{} variables and {} rows", layout.variables(), layout.rows());
    let finding = format!("slack form {}, direct form {}", size(&slack), size(&direct));
    Check::new(slack.rows() > direct.rows(), finding)
}
