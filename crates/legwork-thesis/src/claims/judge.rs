//! What decides the parts of a claim's test. A judge answers for one experiment in one reading. Most judge whatever figure, study or
//! limit `claims.toml` names; those below them are of one claim each, as are the judges of the logs.

use super::Part;
use super::logs::LOG_JUDGES;
use crate::case::{Case, Experiment, Gains, Reading};
use crate::curve::{Curve, falls_at_all, stands_at_all};
use crate::evidence::Evidence;
use crate::sweep::{FEET, Sweep, Tried, definition, figure};
use crate::terms::{Check, DIMINISHED, LITTLE, MET, POOR, UNCHANGED, VISIBLE};
use crate::trial::{
    HARD_FEET_WITH, REPLAN, STACKED_GAINS, STACKED_WEIGHTS, START_OF_STEP, TrialResult, hard_feet, stacked,
};
use crate::words::{digits, list, percent, with_unit};
use legwork::episode::Run;
use legwork::metrics::Figure;
use legwork::momentum::Layout;
use legwork::scenario::QpForm;

/// What a judge is asked.
pub(super) struct Asked<'a> {
    pub(super) part: &'static Part,
    pub(super) evidence: &'a Evidence,
    pub(super) reading: Reading,
    pub(super) experiment: Experiment,
}

/// Answers with one check or some.
pub(super) type Judge = fn(&Asked) -> Vec<Check>;

/// The studies of the parameters that the final design leaves as they are.
const KEPT: [&str; 5] = ["grf-limit", "acceleration-weight", "momentum-weight", "torso-weight", "com-gain"];

/// The judge of that name.
pub(super) fn judge(name: &str) -> Judge {
    let found = judges().find(|(known, _)| *known == name);
    found.unwrap_or_else(|| panic!("no judge of {name:?}")).1
}

/// All judges by their names.
pub(super) fn judges() -> impl Iterator<Item = &'static (&'static str, Judge)> {
    JUDGES.iter().chain(LOG_JUDGES)
}

const JUDGES: &[(&str, Judge)] = &[
    ("rises", |a| a.curves(Curve::rises)),
    ("sinks", |a| a.curves(Curve::sinks)),
    ("diminishes", |a| a.curves(Curve::diminishes)),
    ("straight", |a| a.curves(Curve::is_straight)),
    ("unchanged", |a| a.curves(|curve| curve.changes_at_most(UNCHANGED))),
    ("little changed", |a| a.curves(|curve| curve.changes_at_most(LITTLE))),
    ("sinks much", |a| a.curves(|curve| curve.moves(-1.0, LITTLE))),
    ("grows", |a| a.curves(|curve| curve.moves(1.0, UNCHANGED))),
    ("poor", |a| a.curves(Curve::is_poor)),
    ("falls", |a| vec![falls_at_all(a.sweep(), a.part.from, a.part.to)]),
    ("stands", |a| vec![stands_at_all(a.sweep(), a.part.from, a.part.to)]),
    ("falls at the lowest level", |a| vec![falls_at(a.sweep(), a.sweep().levels.first())]),
    ("falls at the highest level", |a| vec![falls_at(a.sweep(), a.sweep().levels.last())]),
    ("error is met", |a| a.figures(|figure| error_is_met(a, figure))),
    ("limit is met", limit_is_met),
    ("limit is reached", |a| {
        let (largest, unit) = a.limit(0);
        vec![Check::new(largest >= a.part.published, format!("at least {}", with_unit(largest, unit)))]
    }),
    ("is less in that run", |a| a.figures(|figure| differs(a, figure, -VISIBLE))),
    ("is much less in that run", |a| a.figures(|figure| differs(a, figure, -LITTLE))),
    ("is more in that run", |a| a.figures(|figure| differs(a, figure, VISIBLE))),
    ("is much more in that run", |a| a.figures(|figure| differs(a, figure, LITTLE))),
    ("stands in that run", |a| vec![ending_is(a, true)]),
    ("falls in that run", |a| vec![ending_is(a, false)]),
    ("all programs have a solution", |a| {
        let program = &a.result().program;
        let finding = format!("{} of {} programs have no solution", program.infeasible, program.ticks);
        vec![a.check(program.infeasible == 0 && program.ticks > 0, finding)]
    }),
    ("is less than the baseline's", |a| a.figures(|figure| gain(a, figure)).concat()),
    ("is no less than the baseline's", |a| a.figures(|figure| no_gain(a, figure))),
    ("steps", |a| {
        let steps = a.run().metrics.steps.unwrap_or(0);
        vec![Check::new(f64::from(steps) >= a.part.published, format!("{steps} steps"))]
    }),
    ("share of single support", |a| {
        let share = a.run().metrics.single_support_fraction.unwrap_or(0.0);
        vec![Check::new((share - a.part.published).abs() <= a.part.within, percent(share))]
    }),
    ("recovery ends", |a| {
        let time = a.run().metrics.recovery_time_s;
        let words = time.map_or("none".to_owned(), |time| with_unit(time, "s"));
        vec![Check::new(time.is_some(), format!("recovery time {words}"))]
    }),
    ("much faster", |a| {
        let ((slow, unit), (fast, _)) = (a.limit(0), a.limit(1));
        let finding = format!("{} at 220 Nm, {} at 300 Nm", with_unit(slow, unit), with_unit(fast, unit));
        vec![Check::new(fast > (1.0 + LITTLE) * slow, finding)]
    }),
    ("follows", |a| {
        let run = a.run();
        let error = run.metrics.com_error_m.map_or(f64::INFINITY, |error| error.mean);
        let follows = run.reason.is_none() && error < run.scenario.metrics.followed_within_m;
        vec![a.check(follows, format!("mean CoM error {}", with_unit(error, "m")))]
    }),
    ("recovers", |a| {
        let (run, metrics) = (a.run(), &a.run().metrics);
        let time = metrics.recovery_time_s;
        let after = time.map_or("not".to_owned(), |time| format!("after {}", with_unit(time, "s")));
        let steps = metrics.steps.unwrap_or(0);
        let recovered = run.reason.is_none() && steps > 0 && time.is_some();
        vec![a.check(recovered, format!("recovered {after}, {steps} steps"))]
    }),
    ("poor before falls", |a| vec![a.check_of(poor_before_falls(a))]),
    ("slows", |a| vec![a.check_of(slows(a))]),
    ("momentum rate is limited", |a| vec![momentum_rate_is_limited(a)]),
    ("most pairs fall together", |a| vec![most_pairs_fall(a)]),
    ("levels are near their best", |a| vec![a.check_of(levels_are_near_their_best(a))]),
    ("hard feet fail at the start of a step", |a| vec![a.check_of(hard_feet_fail(a))]),
    ("hard feet cost the momentum at the start of a step", |a| vec![a.check_of(hard_feet_cost(a))]),
    ("hard feet fall", |a| vec![a.check_of(hard_feet_fall(a))]),
    ("soft feet work", |a| {
        let (soft, hard) = (&a.trial(&[]).program, &a.trial(&hard_feet(HARD_FEET_WITH[0])).program);
        let finding = format!(
            "without solution {} of {} programs with feet in the cost, {} of {} with hard feet",
            soft.infeasible, soft.ticks, hard.infeasible, hard.ticks
        );
        vec![a.check(soft.infeasible == 0 && hard.infeasible > 0, finding)]
    }),
    ("re-planning shortens the recovery", |a| {
        let [off, on] = [&[][..], &[REPLAN.to_owned()]]
            .map(|sets| a.evidence.trial(a.case(), sets).standing("recovery_distance_m"));
        let words = |value: Option<f64>| value.map_or("a fall".to_owned(), |value| with_unit(value, "m"));
        let holds = off.zip(on).is_some_and(|(off, on)| on < off);
        vec![Check::new(holds, format!("{} with re-planning, {} without", words(on), words(off)))]
    }),
    ("slack has more rows", |a| {
        let run = a.run();
        let layout = |form| Layout::new(form, &run.scenario.controller, &run.model);
        let (direct, slack) = (layout(QpForm::Direct), layout(QpForm::Slack));
        let size = |layout: &Layout| format!("{} variables and {} rows", layout.variables(), layout.rows());
        let finding = format!("slack form {}, direct form {}", size(&slack), size(&direct));
        vec![Check::new(slack.rows() > direct.rows(), finding)]
    }),
];

impl<'a> Asked<'a> {
    /// The final design's run.
    pub(super) fn run(&self) -> &'a Run {
        self.evidence.final_run(self.reading, self.experiment)
    }

    fn case(&self) -> Case {
        Case::new(self.reading, self.experiment, Gains::Final)
    }

    /// The run that the part names.
    fn result(&self) -> &'a TrialResult {
        self.evidence.result(&self.part.trial(self.case()))
    }

    fn sweep(&self) -> &'a Sweep {
        self.evidence.sweep(&self.part.over, self.reading, self.experiment)
    }

    /// A variant of the baseline.
    fn trial(&self, sets: &[String]) -> &'a TrialResult {
        self.evidence.trial(Case::new(self.reading, self.experiment, Gains::Baseline), sets)
    }

    /// The limit that the part names in this place, or zero, with its unit.
    fn limit(&self, place: usize) -> (f64, &'static str) {
        let (row, measured) = self.evidence.limit_row(&self.part.of[place], self.reading);
        (measured.value.unwrap_or(0.0), row.unit)
    }

    fn figures<T>(&self, of: impl Fn(&'static Figure) -> T) -> Vec<T> {
        self.part.of.iter().map(|name| of(definition(name))).collect()
    }

    fn curves(&self, test: impl Fn(&Curve<'a>) -> Check) -> Vec<Check> {
        self.figures(|figure| test(&Curve::new(self.sweep(), figure, self.part.from, self.part.to)))
    }

    /// A check whose finding begins with the experiment.
    pub(super) fn check(&self, holds: bool, finding: impl Into<String>) -> Check {
        Check::new(holds, format!("{}: {}", self.experiment.name(), finding.into()))
    }

    fn check_of(&self, (holds, finding): (bool, String)) -> Check {
        self.check(holds, finding)
    }
}

fn falls_at(sweep: &Sweep, level: Option<&Tried>) -> Check {
    let level = level.expect("a sweep has levels").level;
    falls_at_all(sweep, level, level)
}

/// An error against the published one, which it may be less than.
fn error_is_met(a: &Asked, figure: &Figure) -> Check {
    let (measured, published) = (figure.of(&a.run().metrics).unwrap_or(0.0), a.part.published);
    let [ours, theirs] = [measured, published].map(|value| with_unit(value, figure.unit));
    let finding = format!("{} {ours}, published {theirs}", figure.label);
    Check::new(measured <= (1.0 + MET) * published, finding)
}

fn limit_is_met(a: &Asked) -> Vec<Check> {
    let (quantity, published) = (&a.part.of[0], a.part.published);
    let (row, found) = a.evidence.limit_row(quantity, a.reading);
    let words = |value| with_unit(value, row.unit);
    let Some(value) = found.value else { return vec![Check::new(false, format!("{quantity}: none"))] };
    let mut finding = format!("{quantity} {}, published {}", words(value), words(published));
    if let (Some(beyond), Some(reason)) = (found.first_failure, &found.reason) {
        finding += &format!("; at {} {reason}", words(beyond));
    }
    vec![Check::new((value / published - 1.0).abs() <= MET, finding)]
}

/// A figure of the baseline and of the final design, and what these say.
fn change(a: &Asked, figure: &Figure) -> Option<(f64, String)> {
    let runs = [a.evidence.baseline_run(a.reading, a.experiment), a.run()];
    let [old, new] = runs.map(|run| figure.of(&run.metrics));
    let (old, new) = (old?, new?);
    let words = format!("{} {} instead of {}", figure.label, digits(new), digits(old));
    Some((new / old, words))
}

/// How the run that the part names ends.
fn ending_is(a: &Asked, stands: bool) -> Check {
    let result = a.result();
    let ending = result.rollout.reason.as_deref().unwrap_or("stands");
    Check::new(result.stands() == stands, format!("{}: {ending}", result.trial.command()))
}

/// A figure of the run that the part names, by at least `share` of the final design's above it, or below it for a negative one.
fn differs(a: &Asked, figure: &Figure, share: f64) -> Check {
    let (own, other) = (figure.of(&a.run().metrics), a.result().standing(&figure.name));
    let words = |value: Option<f64>| value.map_or("none".to_owned(), |value| with_unit(value, figure.unit));
    let finding = format!("{} {} instead of {}", figure.label, words(other), words(own));
    let holds = |(own, other): (f64, f64)| (other / own - 1.0 - share) * share.signum() >= 0.0;
    a.check(own.zip(other).is_some_and(holds), finding)
}

/// What the final design gained over the baseline, as a share of the baseline's figure.
fn gain(a: &Asked, figure: &Figure) -> Vec<Check> {
    if a.evidence.baseline_run(a.reading, a.experiment).reason.is_some() || a.run().reason.is_some() {
        return vec![Check::new(false, "the baseline or the final design falls, so that nothing can be compared")];
    }
    let Some((ratio, words)) = change(a, figure) else {
        return vec![Check::new(false, format!("{}: none", figure.label))];
    };
    let (gain, published) = (1.0 - ratio, a.part.published);
    let finding = format!("{words}: {:+.1} %", -100.0 * gain);
    vec![
        Check::new(gain >= VISIBLE, finding.clone()),
        Check::new(
            (gain - published).abs() <= a.part.within,
            format!("{finding}, published {:+.1} %", -100.0 * published),
        ),
    ]
}

fn no_gain(a: &Asked, figure: &Figure) -> Check {
    let (ratio, words) = change(a, figure).unwrap_or((f64::NAN, String::new()));
    let change = ratio - 1.0;
    Check::new(change >= -UNCHANGED, format!("{words}: {:+.1} %", 100.0 * change))
}

fn poor_before_falls(a: &Asked) -> (bool, String) {
    let sweep = a.sweep();
    let Some(full) = sweep.at(500.0).and_then(|tried| tried.figure(FEET)) else {
        return (false, "falls at 500 Nm".to_owned());
    };
    let falls = sweep.between(a.part.from, a.part.to).filter(|tried| !tried.rollout.survived());
    let errors: Vec<f64> = falls.filter_map(|tried| figure(&tried.rollout, FEET)).collect();
    if errors.is_empty() {
        return (false, "no fall below 200 Nm".to_owned());
    }
    let poor = errors.iter().filter(|&&error| error >= POOR * full).count();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let finding = format!(
        "poor in {poor} of {} falls; least mean feet error before a fall {}, at 500 Nm {}",
        errors.len(),
        with_unit(least, "m"),
        with_unit(full, "m")
    );
    (poor == errors.len(), finding)
}

/// Over the same way on both sides: over a longer one above, any gain that ever ends would do.
fn slows(a: &Asked) -> (bool, String) {
    let at = |level: f64| a.sweep().at(level).and_then(|tried| tried.figure(FEET));
    let (Some(low), Some(knee), Some(high)) = (at(200.0), at(220.0), at(240.0)) else {
        return (false, "falls at 200, 220 or 240 Nm".to_owned());
    };
    let (below, above) = (low - knee, knee - high);
    let finding = format!(
        "sinks by {} from 200 to 220 Nm, by {} from 220 to 240 Nm",
        with_unit(below, "m"),
        with_unit(above, "m")
    );
    (below > 0.0 && above < DIMINISHED * below, finding)
}

fn momentum_rate_is_limited(a: &Asked) -> Check {
    let shares: Vec<f64> = a.sweep().levels.iter().map(|tried| tried.momentum_rate_limited_fraction).collect();
    let limited = shares.iter().filter(|&&share| share > 0.0).count();
    let (least, most) = shares.iter().fold((1.0_f64, 0.0_f64), |(least, most), &s| (least.min(s), most.max(s)));
    let percents = format!("{:.0} to {:.0} %", 100.0 * least, 100.0 * most);
    let finding = format!("at the limit at {limited} of {} levels, in {percents} of the ticks", shares.len());
    a.check(2 * limited > shares.len(), finding)
}

fn most_pairs_fall(a: &Asked) -> Check {
    let stands = |weight, gain| a.trial(&stacked(weight, gain)).stands();
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
    let finding =
        format!("of {pairs} pairs each of which stands alone {} fall together: {}", fallen.len(), list(&fallen));
    a.check(pairs > 0 && 2 * fallen.len() >= pairs, finding)
}

fn levels_are_near_their_best(a: &Asked) -> (bool, String) {
    let mut better = Vec::new();
    for study in KEPT {
        let sweep = a.evidence.sweep(study, a.reading, a.experiment);
        let own = sweep.at_marked();
        if !own.rollout.survived() {
            return (false, "the baseline itself falls".to_owned());
        }
        // One figure is much lower than the baseline's, and none is higher.
        let is_better = |tried: &&Tried| {
            let ratio = |name: &String| Some(tried.figure(name)? / own.figure(name)?);
            let ratios: Option<Vec<f64>> = a.part.of.iter().map(ratio).collect();
            ratios.is_some_and(|all| {
                all.iter().all(|&ratio| ratio <= 1.0 + UNCHANGED) && all.iter().any(|&ratio| ratio < 1.0 - LITTLE)
            })
        };
        let found = sweep.levels.iter().find(is_better);
        better.extend(found.map(|level| format!("{} {}", sweep.symbol, with_unit(level.level, sweep.unit))));
    }
    let finding = format!("{} of {} have a better level: {}", better.len(), KEPT.len(), list(&better));
    (better.len() <= 1, finding)
}

fn hard_feet_fail(a: &Asked) -> (bool, String) {
    let program = &a.trial(&hard_feet(HARD_FEET_WITH[0])).program;
    let step = a.evidence.baseline_run(a.reading, a.experiment).scenario.reference.step.duration_s;
    let Some(first) = program.first_infeasible_s else { return (false, "all programs have a solution".to_owned()) };
    let since = program.since_trigger_s;
    let place = since.map_or("in double support".to_owned(), |s| format!("{} after the trigger", with_unit(s, "s")));
    let finding = format!(
        "{} of {} programs have no solution, the first at {}, {place}: {}",
        program.infeasible,
        program.ticks,
        with_unit(first, "s"),
        program.conflict.join(", ")
    );
    (since.is_some_and(|since| since <= START_OF_STEP * step), finding)
}

fn hard_feet_cost(a: &Asked) -> (bool, String) {
    let missed = |sets: &[String]| a.trial(sets).program.missed_at_start_n;
    let (Some(soft), Some(hard)) = (missed(&[]), missed(&hard_feet(HARD_FEET_WITH[0]))) else {
        return (false, "no steps".to_owned());
    };
    let [soft_n, hard_n] = [soft, hard].map(|missed| with_unit(missed, "N"));
    let finding = format!(
        "linear momentum rate missed at the start of steps {hard_n} with hard feet, {soft_n} with them in the cost"
    );
    (hard >= POOR * soft, finding)
}

fn hard_feet_fall(a: &Asked) -> (bool, String) {
    let hard = a.trial(&hard_feet(HARD_FEET_WITH[0]));
    let yielded = hard.program.tasks_yielded;
    match (&hard.rollout.reason, a.trial(&[]).stands()) {
        (Some(reason), true) => (true, reason.clone()),
        (Some(_), false) => (false, "falls, and so it does with feet in the cost".to_owned()),
        (None, _) => (false, format!("stands, as the hard task yields in the {yielded} ticks without solution")),
    }
}
