//! The tables of `compare` for people.

use legwork_study::comparison::{Figures, Person};

use super::{Report, Robot};
use crate::limits::text::{map, shorter, sizing};
use crate::output::folded;

/// A figure of a walk in words, with its decimals and its value.
pub(crate) type Row = (&'static str, usize, fn(&Figures) -> Option<f64>);

/// The figures that are no joint's.
pub(crate) const ROWS: [Row; 7] = [
    ("mean speed [m/s]", 3, |f| Some(f.mean_speed_mps)),
    ("u\u{b2}, mean [N\u{b2}m\u{b2}]", 0, |f| Some(f.u2_n2m2)),
    ("single support", 2, |f| Some(f.single_support_fraction)),
    ("cost of transport", 2, |f| f.cost_of_transport),
    ("XcoM error, mean [mm]", 1, |f| f.xcom_error_mean_m.map(|error| 1e3 * error)),
    ("XcoM error, peak [mm]", 1, |f| f.xcom_error_peak_m.map(|error| 1e3 * error)),
    ("peak ground force [N]", 0, |f| Some(f.ground_force_peak_n)),
];

/// Where there is no value.
pub(crate) const NONE: &str = "\u{2013}";

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

/// A row of the table: its name, the robots' values, the person's.
pub(crate) fn rows(walks: &[Option<&Figures>], person: &Person) -> Vec<(String, Vec<String>)> {
    let shown = |value: Option<f64>, digits: usize| value.map_or(NONE.to_owned(), |value| format!("{value:.digits$}"));
    let mut rows = Vec::new();
    let mut joints: Vec<&str> = person.peaks_nm.iter().map(|(joint, _)| *joint).collect();
    let others = walks.iter().flatten().flat_map(|walk| &walk.joints).map(|joint| joint.joint.as_str());
    let others: Vec<&str> = others.filter(|joint| !joints.contains(joint)).collect();
    joints.extend(others);
    for joint in joints {
        let of = |walk: &Option<&Figures>| {
            walk.and_then(|walk| walk.joints.iter().find(|found| found.joint == joint).cloned())
        };
        let found: Vec<_> = walks.iter().map(of).collect();
        let peak = person.peaks_nm.iter().find(|(name, _)| *name == joint).map(|(_, peak)| *peak);
        let peaks = found.iter().map(|torque| torque.as_ref().map(|torque| torque.peak_nm)).chain([peak]);
        let means = found.iter().map(|torque| torque.as_ref().map(|torque| torque.mean_nm)).chain([None]);
        rows.push((format!("{joint} torque, peak [Nm]"), peaks.map(|value| shown(value, 1)).collect()));
        rows.push((format!("{joint} torque, mean [Nm]"), means.map(|value| shown(value, 1)).collect()));
    }
    rows.extend(ROWS.iter().map(|(name, digits, of)| {
        let values = walks.iter().map(|walk| walk.and_then(of)).chain([None]);
        ((*name).to_owned(), values.map(|value| shown(value, *digits)).collect())
    }));
    rows
}

/// The speeds that were tried, in their order.
pub(crate) fn speeds(report: &Report) -> Vec<f64> {
    let mut speeds: Vec<f64> = Vec::new();
    for gait in report.robots.iter().flat_map(|robot| &robot.gaits) {
        if !speeds.contains(&gait.speed_mps) {
            speeds.push(gait.speed_mps);
        }
    }
    speeds
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
        }
    }
    let person = &report.person;
    text + &format!("\n  person: {} kg at {} m/s, {}", person.mass_kg, person.speed_mps, person.source)
}

/// The largest impulse that a robot survives at a phase from a direction [Ns]; none where it was not found.
pub(crate) fn impulse(robot: &Robot, phase: Option<f64>, direction_deg: f64) -> Option<f64> {
    let strikes = &robot.pushes.as_ref()?.strikes;
    strikes.iter().find(|strike| strike.phase == phase && strike.direction_deg == direction_deg)?.impulse_ns
}

/// The phases that were struck, in their order.
pub(crate) fn phases(robots: &[Robot]) -> Vec<Option<f64>> {
    let mut phases: Vec<Option<f64>> = Vec::new();
    for strike in robots.iter().filter_map(|robot| robot.pushes.as_ref()).flat_map(|pushes| &pushes.strikes) {
        if !phases.contains(&strike.phase) {
            phases.push(strike.phase);
        }
    }
    phases
}

/// A phase in words.
pub(crate) fn phase_label(phase: Option<f64>) -> String {
    phase.map_or("standing".to_owned(), |phase| format!("phase {}", shorter(phase)))
}

fn pushes(robots: &[Robot]) -> Option<String> {
    let speed = robots.iter().find_map(|robot| robot.pushes.as_ref())?.speed_mps;
    let mut text = format!("Largest impulse survived at {speed} m/s [Ns]\n  {:<14}", "");
    robots.iter().for_each(|robot| text += &format!("{:>24}", robot.scenario));
    text += &format!("\n  {:<14}", "");
    robots.iter().for_each(|_| text += &format!("{:>12}{:>12}", "forward", "backward"));
    for phase in phases(robots) {
        text += &format!("\n  {:<14}", phase_label(phase));
        for (robot, direction) in robots.iter().flat_map(|robot| [(robot, 0.0), (robot, 180.0)]) {
            let shown = impulse(robot, phase, direction).map_or(NONE.to_owned(), |impulse| format!("{impulse:.0}"));
            text += &format!("{shown:>12}");
        }
    }
    Some(text)
}
