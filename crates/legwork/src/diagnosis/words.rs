//! The sentence of a diagnosis.

use super::evidence::Evidence;
use super::rules::SATURATED;
use super::{Event, Fall, FirstCause, What, definition};
use crate::scenario::{Scenario, Tracking};

/// "fell at 1.06 s: what went wrong because of what; how the fall was noticed".
pub(super) fn sentence(
    evidence: &Evidence<'_>,
    fall: &Fall,
    because: Option<&Event>,
    consequence: Option<&Event>,
) -> String {
    let cause = because.and_then(|event| reason(evidence, event, consequence));
    let effect = match because {
        // The story of the reach is a whole one.
        Some(Event { what: What::OutOfReach { .. }, .. }) => None,
        _ => consequence.and_then(effect),
    };
    let missed = match (because, consequence) {
        (Some(Event { what: What::Saturated { .. } | What::Outweighed { .. }, .. }), Some(event)) => {
            missed(evidence, event)
        }
        _ => String::new(),
    };
    let story = match (effect, cause) {
        (Some(effect), Some(cause)) => format!("{effect} because {cause}{missed}"),
        (None, Some(cause)) => format!("{cause}{missed}"),
        (Some(effect), None) => format!("{effect} with no limit to blame"),
        (None, None) => "no rule explains it".to_owned(),
    };
    format!("fell at {:.2} s: {story}; {}", fall.time, definition(fall))
}

/// A name as words.
fn plain(name: &str) -> String {
    name.replace('_', " ")
}

/// The name of a foot as words that say that it is one.
fn foot_in_words(name: &str) -> String {
    let plain = plain(name);
    if plain.contains("foot") { plain } else { format!("{plain} foot") }
}

/// A setting as it is written, without more digits than a sentence bears.
fn rounded(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// The slopes that the controller was not told and assumed to be others.
fn slope(scenario: &Scenario) -> Option<String> {
    let (slope, assumed) = (rounded(scenario.ground.slope_deg), rounded(scenario.controller.assumed_slope_deg));
    let across = rounded(scenario.ground.cross_slope_deg);
    let along = (slope != assumed).then(|| format!("slope {slope} deg, assumed to be {assumed}"));
    let across = (across != 0.0).then(|| format!("slope across {across} deg, assumed to be 0"));
    let both: Vec<String> = [along, across].into_iter().flatten().collect();
    (!scenario.ground.known && !both.is_empty()).then(|| both.join(", "))
}

/// What went wrong.
fn effect(event: &Event) -> Option<String> {
    let time = event.time;
    let text = match &event.what {
        What::Sank { by, .. } => format!("the centre of mass had sunk {by:.2} m by {time:.2} s"),
        What::Leaned { by, .. } => {
            let way = if *by > 0.0 { "backward" } else { "forward" };
            format!("the torso leaned {:.0} deg {way} at {time:.2} s", by.abs().to_degrees())
        }
        What::FootAstray { foot, short: Some(short), .. } if short.abs() >= 0.02 => {
            let way = if *short > 0.0 { "short" } else { "too far" };
            format!("the {} landed {:.2} m {way} at {time:.2} s", foot_in_words(foot), short.abs())
        }
        What::FootAstray { foot, off, .. } => {
            format!("the {} was up to {off:.2} m off its path by {time:.2} s", foot_in_words(foot))
        }
        What::OutOfReach { past, edge, longest, .. } => {
            let longest = rounded(*longest);
            format!("the XcoM, {past:.2} m past the {edge} at {time:.2} s, was out of reach of steps of {longest} m")
        }
        _ => return None,
    };
    Some(text)
}

/// Which task was given up meanwhile, and by how much, where that is something.
fn missed(evidence: &Evidence<'_>, event: &Event) -> String {
    let (missed, of) = match event.what {
        // More than its weight is none that held the robot up: the goal grows with the error of a robot that falls.
        What::Sank { missed, .. } if missed > evidence.weight() => return String::new(),
        What::Sank { missed, .. } => (missed, "N of lift"),
        What::Leaned { missed, .. } => (missed, "rad/s2 of the torso's task"),
        What::FootAstray { missed, .. } => (missed, "m/s2 of the foot's task"),
        _ => return String::new(),
    };
    if missed >= 0.5 { format!(", {missed:.0} {of} given up") } else { String::new() }
}

/// The first cause.
fn reason(evidence: &Evidence<'_>, event: &Event, consequence: Option<&Event>) -> Option<String> {
    let scenario = evidence.scenario;
    let text = match &event.what {
        What::Saturated { cause, value, share, lasted, swing } => {
            let told = match consequence {
                Some(Event { what: What::FootAstray { foot, .. }, .. }) => Some(foot),
                _ => None,
            };
            let during = match swing {
                Some(foot) if told == Some(foot) => "of the swing".to_owned(),
                Some(foot) => format!("of the {}'s swing", foot_in_words(foot)),
                None => "of the double support".to_owned(),
            };
            // Of a long time in which little happened, a share says little.
            let long = match *share < SATURATED {
                true => format!("{lasted:.2} s"),
                false => format!("{:.0} %", 100.0 * share),
            };
            format!("{} for {long} {during}", at_limit(evidence, cause, *value)?)
        }
        What::RanLoose { joint, end } => {
            let slides = evidence.joint(joint).is_some_and(|joint| !joint.rotational);
            let end =
                if slides { format!("{} m", rounded(*end)) } else { format!("{} deg", rounded(end.to_degrees())) };
            format!("no task held the {}, which came to its stop at {end} at {:.2} s", plain(joint), event.time)
        }
        What::Slid { foot, by, friction, believed } => {
            let (friction, assumed) = (rounded(*friction), rounded(*believed));
            let belief = if assumed == friction { String::new() } else { format!(", assumed to be {assumed}") };
            let time = event.time;
            format!("the {} slid {by:.2} m from {time:.2} s on (friction {friction}{belief})", foot_in_words(foot))
        }
        What::OutOfReach { past, edge, longest, lasts, short, pushed } => {
            let longest = rounded(*longest);
            let who =
                pushed.map_or("the XcoM got".to_owned(), |push| format!("the push of {push:.0} Ns carried the XcoM"));
            let time = event.time;
            // The XcoM runs away within a long step: how far it would is no place that anything reached.
            let misses = if *short <= 2.0 * longest {
                format!("the longest step of {longest} m fell {short:.2} m short of it")
            } else {
                let lasting = lasts.map_or(String::new(), |lasts| format!(" that lasts {} s", rounded(lasts)));
                format!("no step of {longest} m{lasting} catches it")
            };
            format!("{who} {past:.2} m past the {edge} by {time:.2} s, and {misses}")
        }
        What::MissedGround { foot, lasted, lower } => {
            let why = slope(scenario)
                .unwrap_or_else(|| format!("{:.0} cm lower than the controller believed", 100.0 * lower));
            format!("the {} found no ground for {lasted:.2} s ({why})", foot_in_words(foot))
        }
        What::Misstepped { foot, lower } => {
            let way = if *lower > 0.0 { "lower" } else { "higher" };
            let (by, slope) = match slope(scenario) {
                Some(slope) => (String::new(), format!(" ({slope})")),
                None => (format!("{:.0} cm ", 100.0 * lower.abs()), String::new()),
            };
            format!(
                "the {} found the ground {by}{way} than the controller believed at {:.2} s{slope}",
                foot_in_words(foot),
                event.time
            )
        }
        What::TasksYielded { ticks, of } => {
            let tasks = evidence.tasks.iter();
            let hard: Vec<&str> = tasks.filter(|task| task.how == Tracking::Equality).map(|task| task.name).collect();
            let what = if hard.is_empty() {
                "the program".into()
            } else {
                format!("the program with hard {}", hard.join(", "))
            };
            format!("{what} had no solution in {ticks} of {of} ticks from {:.2} s on", event.time)
        }
        What::Stubbed { foot, higher } => {
            format!(
                "the {} met ground {:.0} cm higher on its way at {:.2} s",
                foot_in_words(foot),
                100.0 * higher,
                event.time
            )
        }
        What::Straddled { foot, higher } => {
            format!("the {} came down across an edge {:.0} cm above its sole", foot_in_words(foot), 100.0 * higher)
        }
        What::Unmet { force, given_up } => format!(
            "the program let standing feet accelerate by {given_up:.0} m/s2 and so counted on {force:.0} N more than the ground gave"
        ),
        What::Upset { impulse, since, lifted } => {
            let done = if *lifted { "lifted it off the ground" } else { "upset it" };
            format!("the push of {impulse:.0} Ns at {since:.2} s had {done}")
        }
        What::Misled { delay, noise: [position, velocity] } => {
            let told = [
                (*delay > 0.0).then(|| format!("{} s late", rounded(*delay))),
                (*position > 0.0).then(|| format!("with noise of {position:.1e} rad")),
                (*velocity > 0.0).then(|| format!("with noise of {velocity:.1e} rad/s")),
            ];
            let told: Vec<String> = told.into_iter().flatten().collect();
            format!("the controller was told of the state {}", told.join(" and "))
        }
        What::Outweighed { task, .. } => format!("the cost's weights put other tasks before the {task}'s"),
        What::EnergyFromNothing { joules } => {
            format!("the simulation's energy was wrong by {joules:.1e} J at {:.2} s", event.time)
        }
        What::Diverged => "the simulation diverged".to_owned(),
        What::Bounced { share } => {
            let stiffness = scenario.simulation.contact.stiffness_npm;
            format!(
                "standing feet bounced off the ground of {stiffness:.0e} N/m for {:.0} % of the time",
                100.0 * share
            )
        }
        _ => return None,
    };
    Some(text)
}

/// A part at its limit.
fn at_limit(evidence: &Evidence<'_>, cause: &FirstCause, value: f64) -> Option<String> {
    let (name, number) = (cause.part()?, rounded(value));
    let part = plain(name);
    let slides = evidence.joint(name).is_some_and(|joint| !joint.rotational);
    let (force, what, length) = if slides { ("N", "force", "m") } else { ("Nm", "torque", "rad") };
    let text = match cause {
        FirstCause::TorqueLimit { .. } => format!("the {part} was at its {number} {force} {what} limit"),
        FirstCause::TorqueRate { .. } => {
            format!("the {part}'s {what} changed as fast as it may, {number} {force}/s,")
        }
        FirstCause::AccelerationLimit { .. } => format!("the {part} was at its limit of {number} {length}/s2"),
        FirstCause::SpeedLimit { .. } => format!("the {part} was held to its speed limit of {number} {length}/s"),
        FirstCause::JointLimit { .. } if slides => format!("the {part} was held back by its end at {number} m"),
        FirstCause::JointLimit { .. } => {
            format!("the {part} was held back by its end at {} deg", rounded(value.to_degrees()))
        }
        FirstCause::ForceLimit { .. } => format!("the {part} was at its {number} N force limit"),
        FirstCause::Friction { .. } => format!("the {part} was at the edge of its friction cone ({number})"),
        _ => return None,
    };
    Some(text)
}
