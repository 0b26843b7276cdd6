//! The rules: from the log of a run that fell to the first cause. `docs/diagnosis.md` has them in words.
//!
//! What went wrong first, and in which ticks, is found in `failure.rs`. Why is decided here: the causes are tried in
//! the order of [`first_cause`], the first that holds is the first cause.

use std::ops::Range;

use nalgebra::Vector3;

use super::evidence::{Evidence, Saturation, Stretch};
use super::failure::{ASTRAY, Failure, Kind, consequence, failures};
use super::reach::Steps;
use super::{Cause, Diagnosis, Event, Fall, FirstCause, What, words};
use crate::log::{Field, Log};
use crate::momentum::Fallback;
use crate::momentum::tasks::feet;
use crate::momentum::{Limit, Task};
use crate::robot::Robot;
use crate::scenario::{ContactModel, Push, Scenario};

/// What slid or saturated first is looked for from this long before the window on [s]: about a step earlier.
const LEAD: f64 = 0.25;
/// A loaded foot slid this far [m]. In built-in scenarios that stand it is less than 0.01 m a step.
const SLID: f64 = 0.02;
/// Lift that is missing before a foot slides is why the robot sinks from this share of the weight on, in the mean.
const LACKING: f64 = 0.1;
/// A limit was active in this share of the time in which the failure grew.
pub(super) const SATURATED: f64 = 0.3;
/// Limits that were more active by this share than in the steps before come first: healthy steps touch limits, too.
const MORE_THAN_BEFORE: f64 = 0.2;
/// Among limits that account for at least this share of the most that one accounts for, the first to saturate counts.
const AS_GOOD: f64 = 0.95;
/// A friction cone this wide holds the force from a foot to the centre of mass at either end of the longest step
/// (of 1.4 heights of the CoM): it is touched where other limits push the force aside, and more friction saves no fall.
const WIDE_CONE: f64 = 0.7;
/// Ground is lower than believed from here on [m].
const LOWER: f64 = 0.003;
/// The walker lands on ground that is this much lower or higher than believed at the least where that can make it fall [m]: on
/// ground uneven by 1 cm, where it is up to 0.02 m, none of 120 robots fell.
const MISSTEP: f64 = 0.025;
/// Its missteps are looked for in the step that failed and in the two before.
const STEPS_BEFORE: usize = 3;
/// A joint is at the end of its range within this share of the range. One that starts there is a hundredth away.
const AT_ITS_END: f64 = 2e-3;
/// Hard tasks yielded in this share of the time in which the failure grew.
const YIELDED: f64 = 0.3;
/// The balance of energy is broken by this share of m g h. Sound runs stay hundreds of times below.
const ENERGY: f64 = 0.05;
/// On a damped spring, a foot that should stand was off the ground for this share of the time up to the window's end.
const BOUNCED: f64 = 0.1;
/// The program counted on more force than the ground gave by this share of the weight.
const UNMET: f64 = 0.05;
/// It let standing feet accelerate by more than this [m/s²].
const ACCELERATE: f64 = 1.0;
/// A push upward lifted the robot off the ground where nothing touched that for this share of the time in which the failure grew.
const LIFTED: f64 = 0.5;
/// Without a limit to blame, a push is the cause of what begins within this long after it [s]: the time of two steps.
const UPSET: f64 = 1.0;
/// Without a limit to blame, a task was given up if it was missed by this many times as much as in the time before.
const GIVEN_UP: f64 = 2.0;

/// What the rules ask a log for.
const NEEDED: [Field; 9] = [
    Field::GrfSimulated,
    Field::ComReference,
    Field::Xcom,
    Field::TorsoReference,
    Field::FeetReference,
    Field::Swing,
    Field::Slack,
    Field::Program,
    Field::EnergyError,
];

/// A diagnosis looks back at so many seconds before the fall, however long the log is: a run is explained in the same words wherever
/// its records go.
pub const LOOKS_BACK_S: f64 = 10.0;

/// Why the robot of `scenario` fell, by the end of its run's `log`; with the tasks and the limits of its controller.
pub fn diagnose(scenario: &Scenario, model: &Robot, fall: &Fall, log: &Log, told: (&[Task], &[Limit])) -> Diagnosis {
    let latest;
    let log = if log.is_empty() || log.time(0) >= fall.time - LOOKS_BACK_S {
        log
    } else {
        latest = log.since(fall.time - LOOKS_BACK_S);
        &latest
    };
    let the_fall = Event { time: fall.time, what: What::Fell };
    // A controller or a physics of another kind may not tell what the rules ask for.
    if log.is_empty() || NEEDED.iter().any(|field| !log.has(*field)) {
        return Diagnosis { cause: FirstCause::Unexplained, events: vec![the_fall], sentence: super::sentence(fall) };
    }
    let evidence = Evidence::new(scenario, model, log, told);
    let failures = failures(&evidence);
    let first = &failures[0];
    let (cause, because) = first_cause(&evidence, first, fall)
        .map_or((FirstCause::Unexplained, None), |(cause, event)| (cause, Some(event)));
    let effect = consequence(&evidence, first);
    let sentence = words::sentence(&evidence, fall, because.as_ref(), effect.as_ref());

    let mut events: Vec<Event> = failures[1..].iter().filter_map(|later| consequence(&evidence, later)).collect();
    events.extend(because.into_iter().chain(effect));
    let pushes = scenario.pushes.iter().filter(|push| push.start_s < fall.time && impulse(push) > 0.0);
    events.extend(pushes.map(|push| Event { time: push.start_s, what: What::Pushed { impulse: impulse(push) } }));
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    events.push(the_fall);
    Diagnosis { cause, events, sentence }
}

/// Impulse of a push [Ns].
pub(super) fn impulse(push: &Push) -> f64 {
    push.force_n.abs() * push.duration_s
}

/// What the pushes together have delivered by a time [Ns]: opposite ones cancel.
fn delivered<'p>(pushes: impl Iterator<Item = &'p Push>, time: f64) -> f64 {
    let sum = pushes.fold(Vector3::zeros(), |sum: Vector3<f64>, push| {
        sum + push.force_n * (time - push.start_s).clamp(0.0, push.duration_s) * push.direction()
    });
    libm::hypot(libm::hypot(sum.x, sum.y), sum.z)
}

/// The first cause of `failure`: the first rule that holds. Rules on the simulation come before those on the robot,
/// and a rule that names the part which gave way before one that only describes.
fn first_cause(evidence: &Evidence<'_>, failure: &Failure, fall: &Fall) -> Option<(FirstCause, Event)> {
    let walks = matches!(evidence.steps, Steps::Walker(_));
    numerics(evidence, failure, fall)
        .or_else(|| loose(evidence, failure))
        .or_else(|| stubbed(evidence, failure))
        .or_else(|| straddled(evidence, failure, fall))
        .or_else(|| misstep(evidence, failure).filter(|_| walks))
        .or_else(|| slide(evidence, failure).filter(|(_, event)| !sank_before(evidence, failure, event.time)))
        .or_else(|| missed_ground(evidence, failure))
        // The step machine waits for the ground where it believes it to be.
        .or_else(|| misstep(evidence, failure))
        .or_else(|| out_of_reach(evidence, failure))
        .or_else(|| {
            upset(evidence, failure).filter(|(_, event)| matches!(event.what, What::Upset { lifted: true, .. }))
        })
        .or_else(|| yielded(evidence, failure))
        .or_else(|| saturation(evidence, failure))
        .or_else(|| slide(evidence, failure))
        .or_else(|| outweighed(evidence, failure))
        .or_else(|| unmet(evidence, failure))
        .or_else(|| upset(evidence, failure))
        .or_else(|| misled(evidence, failure))
}

/// A joint that no task held was at the end of its range before the failure was there; of several, the one that came there first.
fn loose(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let (model, log) = (evidence.model, evidence.log);
    let reached = |dof: &usize| {
        let joint = &model.dofs[*dof];
        let [lower, upper] = joint.usual_range()?;
        let near = AT_ITS_END * (upper - lower);
        let at = |i: &usize| log.get(*i, Field::Q)[model.bodies[joint.body].q_index];
        let is_there = |i: &usize| at(i) > joint.upper - near || at(i) < joint.lower + near;
        let tick = (0..failure.growth.end).find(is_there)?;
        let end = if at(&tick) < 0.5 * (lower + upper) { joint.lower } else { joint.upper };
        Some((tick, joint.name.clone(), end))
    };
    let (tick, joint, end) = evidence.unheld().iter().filter_map(reached).min_by_key(|(tick, ..)| *tick)?;
    let event = Event { time: evidence.time(tick), what: What::RanLoose { joint: joint.clone(), end } };
    Some((FirstCause::LooseJoint { joint }, event))
}

/// The latest steps that began before the failure was there, the last first.
fn latest_steps<'e>(evidence: &'e Evidence<'_>, failure: &Failure) -> Vec<(&'e Stretch, usize)> {
    let end = failure.window.end;
    let begun = evidence.stretches.iter().rev().filter(|stretch| stretch.ticks.start < end);
    begun.filter_map(|stretch| Some((stretch, stretch.foot?))).take(STEPS_BEFORE).collect()
}

/// A swinging foot met ground that rises above where it left, and came off its path.
fn stubbed(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    if evidence.ground.is_plane() {
        return None;
    }
    let met = |&(stretch, foot): &(&Stretch, usize)| {
        let left = evidence.relief(stretch.ticks.start, foot);
        let ticks = stretch.ticks.start..stretch.ticks.end.min(failure.growth.end);
        let at = ticks.clone().find(|&i| evidence.touching(i, foot) && evidence.relief(i, foot) > left + MISSTEP)?;
        let astray = failure.kind == Kind::Sudden || (at..ticks.end).any(|i| evidence.foot_off(i, foot) > ASTRAY);
        astray.then(|| (at, foot, evidence.relief(at, foot) - left))
    };
    let (at, foot, higher) = latest_steps(evidence, failure).iter().find_map(met)?;
    let name = evidence.foot_name(foot);
    let event = Event { time: evidence.time(at), what: What::Stubbed { foot: name.clone(), higher } };
    Some((FirstCause::MissedGround { foot: name }, event))
}

/// All was in order until a foot came down across an edge, which its contact points do not feel and its link does.
fn straddled(evidence: &Evidence<'_>, failure: &Failure, fall: &Fall) -> Option<(FirstCause, Event)> {
    let Cause::BodyTouches { part } = &fall.cause else { return None };
    let (foot, last) = (evidence.foot_of(part)?, evidence.log.len() - 1);
    let (name, higher) = (evidence.foot_name(foot), evidence.above_the_sole(last, foot));
    let event = Event { time: evidence.time(last), what: What::Straddled { foot: name.clone(), higher } };
    let holds = failure.kind == Kind::Sudden && higher > MISSTEP;
    holds.then_some((FirstCause::MissedGround { foot: name }, event))
}

/// Energy came from nothing, or feet that should stand bounced on the damped spring, before anything failed.
fn numerics(evidence: &Evidence<'_>, failure: &Failure, fall: &Fall) -> Option<(FirstCause, Event)> {
    let said = |tick: usize, what| Some((FirstCause::Numerics, Event { time: evidence.time(tick), what }));
    let broken = ENERGY * evidence.weight() * evidence.scenario.start.com_height_m;
    let end = failure.window.end;
    if let Some(tick) = (0..end).find(|&i| evidence.energy_error(i) > broken) {
        return said(tick, What::EnergyFromNothing { joules: evidence.energy_error(tick) });
    }
    if fall.cause == (Cause::OutOfBounds { joint: None }) {
        return said(evidence.log.len() - 1, What::Diverged);
    }
    if evidence.scenario.simulation.contact.model != ContactModel::SpringDamper {
        return None;
    }
    let should_stand = |i: usize, foot: usize| evidence.stretch(i).foot != Some(foot);
    let off: Vec<usize> =
        (0..end).filter(|&i| (0..2).any(|foot| should_stand(i, foot) && !evidence.touching(i, foot))).collect();
    let share = off.len() as f64 / end as f64;
    if share > BOUNCED { said(off[0], What::Bounced { share }) } else { None }
}

/// The controller did not know the ground's height, and a foot landed where that was not believed to be, before anything failed. Of
/// the latest steps the worst counts; a push among them that carries the XcoM out of reach comes first.
fn misstep(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    if evidence.scenario.ground.height_is_known() {
        return None;
    }
    let (end, steps) = (failure.window.end, latest_steps(evidence, failure));
    let times = evidence.time(steps.last()?.0.ticks.start)..evidence.time(end - 1);
    let pushed = evidence.scenario.pushes.iter().any(|push| impulse(push) > 0.0 && times.contains(&push.start_s));
    if failure.kind == Kind::OutOfReach && pushed {
        return None;
    }
    let landings = steps.iter().map(|(stretch, foot)| (stretch.ticks.end, *foot));
    let landings = landings.filter(|&(landed, foot)| landed < evidence.log.len() && evidence.touching(landed, foot));
    // The walker takes the ground to be where it stands; the step machine, where it was told.
    let lower = |landed: usize, foot: usize| match &evidence.steps {
        Steps::Machine(_) if evidence.scenario.ground.known => evidence.lower(landed, foot),
        _ => evidence.lower_than_the_other(landed, foot),
    };
    let (landed, foot, lower) = landings
        .map(|(landed, foot)| (landed, foot, lower(landed, foot)))
        // A foot that hangs above ground that is lower lets the XcoM run away before it lands.
        .filter(|&(landed, _, lower)| landed < end || lower > 0.0)
        .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
    let name = evidence.foot_name(foot);
    let event = Event { time: evidence.time(landed), what: What::Misstepped { foot: name.clone(), lower } };
    (lower.abs() > MISSTEP).then_some((FirstCause::MissedGround { foot: name }, event))
}

/// A loaded foot slid on ground that is more slippery than the controller was told. Where it knows the ground, it
/// stops at the friction cone, and [`saturation`] judges that.
fn slide(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let begin = failure.window.start.saturating_sub(evidence.ticks_in(LEAD));
    let (foot, by) = (0..2)
        .map(|foot| (foot, evidence.slide(begin..failure.window.end, foot)))
        .fold((0, 0.0), |most, next| if next.1 > most.1 { next } else { most });
    if by <= SLID {
        return None;
    }
    // It began where nine tenths of it were still to come.
    let mut rest = 0.0;
    let started = (begin..failure.window.end).rev().find(|&i| {
        rest += evidence.slide(i..i + 1, foot);
        rest > 0.9 * by
    });
    let name = evidence.foot_name(foot);
    let start = started.unwrap_or(begin);
    let [friction, believed] = evidence.friction_below(start, foot);
    let what = What::Slid { foot: name.clone(), by, friction, believed };
    Some((FirstCause::Friction { foot: name }, Event { time: evidence.time(start), what }))
}

/// Whether a robot that sinks lacked lift already before a foot slid at `time`, which then is not why.
fn sank_before(evidence: &Evidence<'_>, failure: &Failure, time: f64) -> bool {
    let begin = failure.window.start.saturating_sub(evidence.ticks_in(LEAD));
    let before: Vec<usize> = (begin..failure.window.end).take_while(|&i| evidence.time(i) < time).collect();
    let missed: f64 = before.iter().map(|&i| evidence.missed_force(i)).sum();
    failure.kind == Kind::Sinking && missed > LACKING * evidence.weight() * before.len() as f64
}

/// The controller did not know the ground's height, and a swinging foot of the step machine found no ground at the end of its
/// path.
fn missed_ground(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let stretch = evidence.stretch(failure.window.end - 1);
    let (foot, begin) = (stretch.foot?, stretch.ticks.start);
    // Where the ground is much lower, a foot hangs as soon as it is due.
    let [due, late] = evidence.due_and_late(stretch)?;
    let hangs = |&(tick, least): &(usize, f64)| {
        let there = stretch.ticks.contains(&tick) && !evidence.touching(tick, foot);
        there && evidence.lower(tick, foot) >= least && evidence.foot_off(tick, foot) <= ASTRAY
    };
    let (late, _) = [(late, LOWER), (due, MISSTEP)].into_iter().find(hangs)?;
    let lower = evidence.lower(late.min(failure.window.end - 1), foot);
    let name = evidence.foot_name(foot);
    let lasted = evidence.time(stretch.ticks.end - 1) - evidence.time(begin);
    let what = What::MissedGround { foot: name.clone(), lasted, lower };
    Some((FirstCause::MissedGround { foot: name }, Event { time: evidence.time(late), what }))
}

/// The XcoM is past what the longest steps can catch: a push did it, or the steps are too short.
fn out_of_reach(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    if failure.kind != Kind::OutOfReach {
        return None;
    }
    let out = failure.window.end - 1;
    // Told where the next step begins after the push: what it has to reach.
    let pushes = || evidence.scenario.pushes.iter().filter(|push| push.start_s <= evidence.time(out));
    let over = pushes().map(|push| push.start_s + push.duration_s).fold(evidence.time(out), f64::max);
    let tick = evidence.told_at(out, over);
    let (time, wanted) = (evidence.time(tick), evidence.wanted(tick)?);
    let impulse = delivered(pushes(), time.max(evidence.time(out)));
    let cause = if impulse > 0.0 && wanted.beyond_legs { FirstCause::Push } else { FirstCause::StepTooShort };
    let pushed = (cause == FirstCause::Push).then_some(impulse);
    (wanted.short > 0.0).then_some((cause, Event { time, what: wanted.missed(pushed) }))
}

/// Hard tasks gave way, or no program had a solution.
fn yielded(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let did = |i: usize| evidence.fallback(i) >= f64::from(Fallback::TasksYield as u8);
    let (ticks, of) = (failure.growth.clone().filter(|&i| did(i)).count(), failure.growth.len());
    let first = failure.growth.clone().find(|&i| did(i))?;
    let event = Event { time: evidence.time(first), what: What::TasksYielded { ticks, of } };
    (ticks as f64 > YIELDED * of as f64).then_some((FirstCause::InfeasibleProgram, event))
}

/// The limit that accounts for most of what the task missed whose figure failed: while the failure grew, or else in the
/// time that led to it.
fn saturation(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let lead = failure.window.start.saturating_sub(evidence.ticks_in(LEAD));
    let times = [failure.growth.clone(), lead..failure.window.end];
    let found = |ticks: &Range<usize>| Some((saturated(evidence, failure, ticks)?, ticks.clone()));
    let (limit, ticks) = times.iter().find_map(found)?;
    Some((limit.cause.clone(), told(evidence, limit, &ticks)))
}

/// The program was free, and missed the task whose figure failed for the sake of the others.
fn outweighed(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let task = failure.task()?;
    if evidence.is_hard(task) {
        return None;
    }
    let mean = |ticks: Range<usize>| {
        let count = ticks.len().max(1) as f64;
        ticks.map(|i| failure.missed(evidence, i)).sum::<f64>() / count
    };
    let (before, then) = (mean(0..failure.window.start), mean(failure.growth.clone()));
    let event =
        Event { time: evidence.time(failure.window.start), what: What::Outweighed { task, times: then / before } };
    let something = failure.something(evidence.weight());
    (before > 0.0 && then >= something && then >= GIVEN_UP * before).then_some((FirstCause::Outweighed { task }, event))
}

/// The program let feet that stand accelerate, which the ground does not: so it counted on forces that did not come.
fn unmet(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    if failure.kind != Kind::Sinking || evidence.is_hard(feet::NAME) {
        return None;
    }
    let force = failure.mean(|i| evidence.unmet_force(i));
    let given_up = failure.mean(|i| (0..2).map(|foot| evidence.missed_foot(i, foot)).fold(0.0, f64::max));
    let event = Event { time: evidence.time(failure.window.start), what: What::Unmet { force, given_up } };
    let is_much = force > UNMET * evidence.weight() && given_up > ACCELERATE;
    is_much.then_some((FirstCause::Outweighed { task: feet::NAME }, event))
}

/// Whether `push` was upward with more than the robot's weight, and it was in the air for most of the time in which the failure grew.
fn lifted(evidence: &Evidence<'_>, failure: &Failure, push: &Push) -> bool {
    if push.force_n * push.direction().z < evidence.weight() {
        return false;
    }
    let flies = |i: &usize| (0..2).all(|foot| !evidence.touching(*i, foot));
    failure.growth.clone().filter(flies).count() as f64 > LIFTED * failure.growth.len() as f64
}

/// No limit explains it, and a push came shortly before it began.
fn upset(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let (begin, end) = (evidence.time(failure.window.start) - UPSET, evidence.time(failure.window.end - 1));
    let pushes = evidence.scenario.pushes.iter().filter(|push| impulse(push) > 0.0);
    let push = pushes.rev().find(|push| push.start_s < end && push.start_s + push.duration_s > begin)?;
    let what = What::Upset { impulse: impulse(push), since: push.start_s, lifted: lifted(evidence, failure, push) };
    Some((FirstCause::Push, Event { time: push.start_s.max(evidence.time(0)), what }))
}

/// No limit explains it, and the controller was told of the state late or with noise.
fn misled(evidence: &Evidence<'_>, failure: &Failure) -> Option<(FirstCause, Event)> {
    let sensors = &evidence.scenario.simulation.sensors;
    let what = What::Misled { delay: sensors.delay_s, noise: [sensors.position_noise, sensors.velocity_noise] };
    let event = Event { time: evidence.time(failure.window.start), what };
    (!sensors.are_ideal()).then_some((FirstCause::Sensing, event))
}

/// The limit that accounts for most of what was missed in `ticks`.
fn saturated<'e>(evidence: &'e Evidence<'_>, failure: &Failure, ticks: &Range<usize>) -> Option<&'e Saturation> {
    let healthy = 0..evidence.stretch(ticks.start).ticks.start;
    let share = |limit: &Saturation| evidence.share(limit, ticks.clone());
    let more = |limit: &Saturation| share(limit) >= MORE_THAN_BEFORE + evidence.share(limit, healthy.clone());
    let wide = evidence.assumed_friction() >= WIDE_CONE;
    let excused = |limit: &Saturation| wide && matches!(limit.cause, FirstCause::Friction { .. });
    let accounts = |limit: &Saturation| -> f64 {
        ticks.clone().filter(|&i| evidence.is_saturated(limit, i)).map(|i| failure.missed(evidence, i)).sum()
    };
    let lead = ticks.start.saturating_sub(evidence.ticks_in(LEAD));
    let first = |limit: &Saturation| (lead..ticks.end).find(|&i| evidence.is_saturated(limit, i));

    let mut candidates: Vec<&Saturation> =
        evidence.saturations.iter().filter(|limit| share(limit) >= SATURATED && !excused(limit)).collect();
    if candidates.iter().any(|limit| more(limit)) {
        candidates.retain(|limit| more(limit));
    }
    let most = candidates.iter().map(|limit| accounts(limit)).fold(0.0, f64::max);
    // Where nothing was missed, nothing is to blame.
    candidates.retain(|_| most >= failure.something(evidence.weight()) * ticks.len() as f64);
    candidates.into_iter().filter(|limit| accounts(limit) >= AS_GOOD * most).min_by_key(|limit| first(limit))
}

/// A limit's share of the step or double support in which it was active for most of `ticks`.
fn told(evidence: &Evidence<'_>, limit: &Saturation, ticks: &Range<usize>) -> Event {
    let active = |stretch: &Stretch| {
        let both = stretch.ticks.start.max(ticks.start)..stretch.ticks.end.min(ticks.end);
        both.filter(|&i| evidence.is_saturated(limit, i)).count()
    };
    let stretch = evidence.stretches.iter().max_by_key(|stretch| active(stretch)).unwrap_or(&evidence.stretches[0]);
    let begin = stretch.ticks.clone().find(|&i| evidence.is_saturated(limit, i)).unwrap_or(stretch.ticks.start);
    let what = What::Saturated {
        cause: limit.cause.clone(),
        value: evidence.limit_value(limit, begin),
        share: evidence.share(limit, stretch.ticks.clone()),
        lasted: active(stretch) as f64 * evidence.scenario.controller.period_s,
        swing: stretch.foot.map(|foot| evidence.foot_name(foot)),
    };
    Event { time: evidence.time(begin), what }
}
