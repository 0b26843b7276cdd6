//! The tables of `limits` for people.

use legwork_study::limits::Answer;
use legwork_study::rollout::DOUBTFUL;
use legwork_study::search::Found;
use legwork_study::sizing::{Coping, Demand, Pair, Sizing};

use legwork_report::comparison::shorter;
use legwork_report::envelope::{Report, RobustnessMap};

use crate::output::folded;

/// All parts that were asked for.
pub(crate) fn text(report: &Report) -> String {
    let parts = [
        report.limits.as_deref().map(limits),
        report.robustness.as_ref().map(robustness),
        report.sizing.as_ref().map(|table| sizing("Actuators", table)),
        report.map.as_deref().map(|pairs| map(&report.walk, pairs)),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join("\n\n")
}

fn limits(answers: &[Answer]) -> String {
    let mut text = "Limits\n  force: largest on a contact point of what held up to the limit [kN]".to_owned();
    let mut scenario = "";
    for answer in answers {
        if answer.scenario != scenario {
            scenario = &answer.scenario;
            text += &format!("\n  {scenario:<38}{:>9}{:>7}{:>10}{:>14}", "limit", "force", "fails at", "furthest held");
        }
        let found = &answer.found;
        let shown = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let further = found.furthest_held.filter(|_| found.furthest_held != found.value);
        let label = format!("{} [{}]", answer.question, answer.unit).replace(" []", "");
        let line = format!(
            "\n    {label:<36}{:>9}{:>7}{:>10}{:>14}",
            limit(found),
            kilonewtons(found.force_n),
            shown(found.first_failure),
            shown(further)
        );
        text += line.trim_end();
        if let Some(reason) = &found.reason_beyond {
            text += &format!("\n{}", folded(&format!("      beyond: {reason}"), 8));
        }
        text += &doubt("      rests on rollouts that ", found.violations.as_ref());
    }
    text
}

/// A force in kN; nothing where there is none.
fn kilonewtons(force_n: Option<f64>) -> String {
    force_n.map_or(String::new(), |force| format!("{:.1}", 1e-3 * force))
}

/// That something broke bounds of the simulation, and which, on a line of its own.
pub(crate) fn doubt(what: &str, violations: Option<&String>) -> String {
    let line = |violations| format!("\n{}", folded(&format!("{what}{DOUBTFUL}: {violations}"), 8));
    violations.map_or(String::new(), line)
}

/// A table with what its stars mean, where it has any.
pub(crate) fn starred(table: String) -> String {
    if table.contains('*') { table + &format!("\n  * rests on rollouts that {DOUBTFUL}") } else { table }
}

/// The star of what broke bounds of the simulation.
pub(crate) fn star(violations: Option<&String>) -> &'static str {
    if violations.is_some() { "*" } else { "" }
}

/// The limit in words: at least (or at most) the range's end where all held, none where the start failed.
fn limit(found: &Found) -> String {
    let upward = found.tried.first().zip(found.tried.last()).is_some_and(|(first, last)| first.value < last.value);
    match (found.value, found.first_failure) {
        (Some(value), Some(_)) => value.to_string(),
        (Some(value), None) => format!("{} {value}", if upward { '≥' } else { '≤' }),
        (None, _) => "none".to_owned(),
    }
}

fn robustness(map: &RobustnessMap) -> String {
    let mut text = "Largest impulse survived [Ns/kg], and the largest force on a contact point of\n  \
                    what was survived [kN]; 0° is forward, 90° up"
        .to_owned();
    if let Some(stride) = map.stride {
        text += &format!("\n  stride of {:.3} s from {:.3} s on", stride.period_s, stride.start_s);
    }
    let mut columns: Vec<Option<f64>> = map.cells.iter().map(|cell| cell.phase).collect();
    columns.dedup();
    let name = |phase: &Option<f64>| phase.map_or("standing".to_owned(), |phase| format!("phase {}", shorter(phase)));
    text += &format!("\n  {:>9}", "");
    columns.iter().for_each(|phase| text += &format!("{:>12}", name(phase)));
    let mut directions: Vec<f64> = map.cells.iter().map(|cell| cell.direction_deg).collect();
    directions.sort_by(f64::total_cmp);
    directions.dedup();
    for direction in directions {
        let mut line = format!("\n  {:>8}°", shorter(direction));
        for phase in &columns {
            let cell = map.cells.iter().find(|cell| cell.phase == *phase && cell.direction_deg == direction);
            let shown = |found: &Found| {
                format!("{}{} {:>4}", limit(found), star(found.violations.as_ref()), kilonewtons(found.force_n))
            };
            line += &format!("{:>12}", cell.map_or(String::new(), |cell| shown(&cell.found)));
        }
        text += line.trim_end();
    }
    starred(text)
}

/// Of the columns of the table of actuators.
const WIDTHS: [usize; 5] = [11, 11, 14, 11, 11];

/// The table of actuators.
pub(crate) fn sizing(title: &str, sizing: &Sizing) -> String {
    let mut text = format!("{title}\n{:16}", "");
    for (what, width) in ["peak [Nm]", "RMS [Nm]", "peak [rad/s]", "peak [W]", "mean [W]"].iter().zip(WIDTHS) {
        text += &format!("{what:>width$}");
    }
    let rows = |name: &str, demands: &[Demand]| {
        let mut rows = format!("\n  {name}");
        for d in demands {
            rows += &format!("\n    {:<12}", d.joint.replace('_', " "));
            let values = [d.torque_peak_nm, d.torque_rms_nm, d.speed_peak_radps, d.power_peak_w, d.power_mean_w];
            values.iter().zip(WIDTHS).for_each(|(value, width)| rows += &format!("{value:>width$.1}"));
        }
        rows
    };
    for used in &sizing.uses {
        text += &rows(&used.scenario, &used.joints);
        let limited: Vec<String> = used
            .joints
            .iter()
            .filter(|joint| joint.at_limit > 0.0)
            .map(|joint| format!("{} {:.1} %", joint.joint.replace('_', " "), 100.0 * joint.at_limit))
            .collect();
        if !limited.is_empty() {
            text += &format!("\n{}", folded(&format!("    at the torque limit: {}", limited.join(", ")), 6));
        }
        if let Some(reason) = &used.reason {
            text += &format!("\n{}", folded(&format!("    {reason}"), 6));
        }
        text += &doubt("    ", used.violations.as_ref());
    }
    text += &rows("largest", &sizing.envelope);
    text + &rows(&format!("with a margin of {:.0} %", 100.0 * sizing.margin), &sizing.required)
}

/// The map over speed and torque limit.
pub(crate) fn map(walk: &str, pairs: &[Pair]) -> String {
    let mut text = format!("{walk} by speed [m/s] and torque limit [Nm]\n  {:>8}", "");
    let mut speeds: Vec<f64> = pairs.iter().map(|pair| pair.speed_mps).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds.iter().for_each(|&speed| text += &format!("{:>5}", shorter(speed)));
    let mut torques: Vec<f64> = pairs.iter().map(|pair| pair.torque_limit_nm).collect();
    torques.sort_by(|a, b| b.total_cmp(a));
    torques.dedup();
    for torque in torques {
        let mut line = format!("\n  {:>8}", shorter(torque));
        for speed in &speeds {
            let pair = pairs.iter().find(|pair| pair.torque_limit_nm == torque && pair.speed_mps == *speed);
            let shown = |pair: &Pair| symbol(pair.coping).to_owned() + star(pair.violations.as_ref());
            line += &format!("{:>5}", pair.map_or(String::new(), shown));
        }
        text += line.trim_end();
    }
    starred(text) + "\n  # keeps to its reference, + keeps its speed, - another speed, . falls"
}

fn symbol(coping: Coping) -> &'static str {
    match coping {
        Coping::Follows => "#",
        Coping::KeepsSpeed => "+",
        Coping::Survives => "-",
        Coping::Falls => ".",
    }
}
