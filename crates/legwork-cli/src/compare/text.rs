//! The tables of `compare` for people.

use legwork_report::comparison::{Report, Robot, impulse, phase_label, phases, rows, speeds};

use crate::limits::text::{doubt, map, sizing, starred};
use crate::output::folded;

/// All of it.
pub(crate) fn text(report: &Report) -> String {
    let mut parts = vec![gaits(report)];
    parts.extend(pushes(&report.robots));
    let sized = report.robots.iter().filter(|robot| !robot.sizing.uses.is_empty());
    parts.extend(sized.map(|robot| sizing(&format!("Actuators of {}", robot.scenario), &robot.sizing)));
    let mapped = report.robots.iter().filter(|robot| !robot.map.is_empty());
    parts.extend(mapped.map(|robot| map(&robot.scenario, &robot.map)));
    parts.join("\n\n")
}

fn gaits(report: &Report) -> String {
    let names: Vec<&str> = report.robots.iter().map(|robot| robot.scenario.as_str()).chain(["person"]).collect();
    let mut text = format!("{}\n  {:<28}", report.title(), "");
    names.iter().for_each(|name| text += &format!("{name:>16}"));
    for speed in speeds(report) {
        text += &format!("\n  at {speed} m/s");
        let gaits: Vec<_> =
            report.robots.iter().map(|robot| robot.gaits.iter().find(|gait| gait.speed_mps == speed)).collect();
        let walks: Vec<_> = gaits.iter().map(|gait| gait.and_then(|gait| gait.figures.as_ref())).collect();
        if walks.iter().any(Option::is_some) {
            for (name, values) in rows(&walks, &report.person) {
                text += &format!("\n    {name:<26}");
                values.iter().for_each(|value| text += &format!("{value:>16}"));
            }
        }
        for (robot, gait) in report.robots.iter().zip(gaits) {
            if let Some(reason) = gait.and_then(|gait| gait.failure.as_ref()) {
                let line = format!("    {} does not walk at {speed} m/s: {reason}", robot.scenario);
                text += &format!("\n{}", folded(&line, 6));
            }
            let violations = gait.and_then(|gait| gait.violations.as_ref());
            text += &doubt(&format!("    {} ", robot.scenario), violations);
        }
    }
    let person = &report.person;
    text + &format!("\n  person: {} kg at {} m/s, {}", person.mass_kg, person.speed_mps, person.source)
}

fn pushes(robots: &[Robot]) -> Option<String> {
    let speed = robots.iter().find_map(|robot| robot.pushes.as_ref())?.speed_mps;
    let title = "and the largest force\n  on a contact point of what was survived [kN]";
    let mut text = format!("Largest impulse survived at {speed} m/s [Ns], {title}\n  {:<14}", "");
    robots.iter().for_each(|robot| text += &format!("{:>28}", robot.scenario));
    text += &format!("\n  {:<14}", "");
    robots.iter().for_each(|_| text += &format!("{:>14}{:>14}", "forward", "backward"));
    for phase in phases(robots) {
        text += &format!("\n  {:<14}", phase_label(phase));
        for (robot, direction) in robots.iter().flat_map(|robot| [(robot, 0.0), (robot, 180.0)]) {
            text += &format!("{:>14}", impulse(robot, phase, direction));
        }
    }
    Some(starred(text))
}
