//! The page of `legwork limits`: how far things can go, from where a push may come, and what the actuators deliver.

use legwork_study::limits::Answer;
use legwork_study::robustness::{Cell as Struck, Stride};
use legwork_study::rollout::{DOUBT, DOUBTFUL};
use legwork_study::sizing::{Coping, Demand, Pair, Sizing, Use};
use maud::{Markup, html};
use serde::Serialize;

use crate::charts::axis::{Axis, Quantity};
use crate::charts::chart::{Chart, Part, Stack};
use crate::charts::cloud::Cloud;
use crate::charts::layer::Layer;
use crate::charts::map::{HeatMap, Holds, SurvivalMap};
use crate::charts::numbers::number;
use crate::charts::polar::{Curve, Polar};
use crate::document::{Chapter, Figures, Page, Section, page as document};

/// All that was found; none in parts that were not asked for.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The scenario that walks.
    pub walk: String,
    /// The scenario that is pushed.
    pub push: String,
    /// Whether it was sought quickly: in coarse steps, not confirmed as well.
    pub quick: bool,
    /// Whether it was interrupted, so that something is missing.
    pub interrupted: bool,
    /// The limits.
    pub limits: Option<Vec<Answer>>,
    /// The robustness map.
    pub robustness: Option<RobustnessMap>,
    /// The actuator-sizing table.
    pub sizing: Option<Sizing>,
    /// The map over speed and torque limit.
    pub map: Option<Vec<Pair>>,
}

/// The robustness map.
#[derive(Clone, Debug, Serialize)]
pub struct RobustnessMap {
    /// The stride whose phases are struck; none where the robot does not walk.
    pub stride: Option<Stride>,
    /// Its cells.
    pub cells: Vec<Struck>,
}

impl Report {
    /// How many answers rest on rollouts that broke bounds of the simulation, in words; none where there are none.
    pub fn doubts(&self) -> Option<String> {
        let limits = self.limits.iter().flatten().map(|answer| answer.found.violations.is_some());
        let cells = self.robustness.iter().flat_map(|map| &map.cells).map(|cell| cell.found.violations.is_some());
        let uses = self.sizing.iter().flat_map(|sizing| &sizing.uses).map(|used| used.violations.is_some());
        let pairs = self.map.iter().flatten().map(|pair| pair.violations.is_some());
        doubts([
            ("limits", limits.collect()),
            ("impulses", cells.collect()),
            ("runs", uses.collect()),
            ("pairs", pairs.collect()),
        ])
    }
}

/// Of several kinds of answers, each with whether it is doubtful: how many are.
pub(super) fn doubts<const N: usize>(kinds: [(&str, Vec<bool>); N]) -> Option<String> {
    let count = |all: &[bool]| all.iter().filter(|is_doubtful| **is_doubtful).count();
    let said = kinds.iter().filter(|(_, all)| count(all) > 0);
    let said: Vec<String> = said.map(|(what, all)| format!("{} of {} {what}", count(all), all.len())).collect();
    (!said.is_empty()).then(|| format!("{} rest on rollouts that {DOUBT}", said.join(", ")))
}

/// That a run broke bounds of the simulation, and which.
pub(super) fn doubt(what: &str, violations: Option<&String>) -> Markup {
    html! {
        @if let Some(violations) = violations {
            p class="banner warning" { strong { (what) " " (DOUBTFUL) ": " } (violations) "." }
        }
    }
}

/// The page of `report`.
pub fn page(report: &Report) -> Page {
    let mut figures = Figures::default();
    let mut chapters = Vec::new();
    chapters.extend(report.limits.as_deref().map(|answers| limits(answers, report.quick)));
    chapters.extend(report.robustness.as_ref().map(|map| robustness(map, &mut figures)));
    chapters.extend(report.sizing.as_ref().map(|sizing| actuators(sizing, &mut figures)));
    chapters.extend(report.map.as_deref().map(|pairs| speed_torque(pairs, &mut figures)));
    let lead = html! {
        p { "How far " b { (report.walk) } " and " b { (report.push) } " can be taken until the robot falls, and what its actuators must deliver." }
        @if report.interrupted { p class="banner warning" { "The work was interrupted: some of it is missing." } }
        @if let Some(doubts) = report.doubts() { p class="banner warning" { (doubts) "." } }
    };
    document("Limits and sizing", &lead, &chapters, figures)
}

fn limits(answers: &[Answer], quick: bool) -> Chapter {
    let shown = |value: Option<f64>| value.map_or("\u{2013}".to_owned(), number);
    let body = html! {
        div.scroll { table {
            thead { tr { th.left { "scenario" } th.left { "question" } th { "limit" } th { "largest force " span.unit { "[N]" } } th { "first failure" } th { "furthest that held" } th { "rollouts" } th.left { "bounds broken" } } }
            tbody {
                @for answer in answers {
                    tr {
                        th scope="row" { (answer.scenario) }
                        td.left { (answer.question) @if !answer.unit.is_empty() { " " span.unit { "[" (answer.unit) "]" } } }
                        td.measured { (shown(answer.found.value)) }
                        td { (shown(answer.found.force_n)) }
                        td { (shown(answer.found.first_failure)) }
                        td { (shown(answer.found.furthest_held)) }
                        td.soft { (answer.found.rollouts) }
                        td.left { (answer.found.violations.as_deref().unwrap_or("\u{2013}")) }
                    }
                }
            }
        } }
        h4 { "What happens beyond" }
        ul.note {
            @for answer in answers {
                @if let (Some(value), Some(reason)) = (answer.found.first_failure, &answer.found.reason_beyond) {
                    li { (answer.scenario) ", " (answer.question) ", " (number(value)) @if !answer.unit.is_empty() { " " (answer.unit) } ": " (reason) }
                }
            }
        }
    };
    Chapter {
        title: "Limits".into(),
        lead: html! {
            p {
                "A limit is the last value before the first failure"
                @if quick { ". It was sought quickly, in coarse steps and without trying the start pose a little off. " }
                @else { "; its neighbours were tried, also with the start pose a little off. " }
                "Beyond it single values may still hold: the furthest of them is in the table."
            }
        },
        sections: vec![Section { title: "Answers".into(), body }],
    }
}

fn robustness(map: &RobustnessMap, figures: &mut Figures) -> Chapter {
    let label = |phase: Option<f64>| phase.map_or("standing".to_owned(), |phase| format!("phase {phase:.2}"));
    let mut phases: Vec<Option<f64>> = Vec::new();
    let mut directions: Vec<f64> = Vec::new();
    for cell in &map.cells {
        if !phases.contains(&cell.phase) {
            phases.push(cell.phase);
        }
        if !directions.contains(&cell.direction_deg) {
            directions.push(cell.direction_deg);
        }
    }
    let cell = |phase: Option<f64>, direction: f64| {
        map.cells.iter().find(|cell| cell.phase == phase && cell.direction_deg == direction)
    };
    let value = |phase, direction| cell(phase, direction).and_then(|cell| cell.found.value).unwrap_or(f64::NAN);
    let is_doubtful = |phase, direction| cell(phase, direction).is_some_and(|cell| cell.found.violations.is_some());
    let polar = Polar {
        radius: Quantity::new("largest impulse", "Ns/kg"),
        directions: ["forward", "up", "backward", "down"].map(str::to_owned),
        curves: phases
            .iter()
            .map(|&phase| Curve {
                label: label(phase),
                points: directions.iter().map(|&direction| [direction, value(phase, direction)]).collect(),
                doubtful: directions.iter().copied().filter(|&direction| is_doubtful(phase, direction)).collect(),
            })
            .collect(),
    };
    let all = || (0..phases.len()).flat_map(|row| (0..directions.len()).map(move |column| [row, column]));
    let force =
        |phase, direction| cell(phase, direction).and_then(|cell| cell.found.force_n).map_or(f64::NAN, |n| 1e-3 * n);
    let heat = |quantity, value: &dyn Fn(Option<f64>, f64) -> f64| HeatMap {
        row_title: "phase of the stride".into(),
        column_title: "direction of the push".into(),
        rows: phases.iter().map(|&phase| label(phase)).collect(),
        columns: directions.iter().map(|direction| format!("{direction:.0}\u{b0}")).collect(),
        value: quantity,
        cells: phases
            .iter()
            .map(|&phase| directions.iter().map(|&direction| value(phase, direction)).collect())
            .collect(),
        centre: None,
        doubtful: all().filter(|&[row, column]| is_doubtful(phases[row], directions[column])).collect(),
    };
    let impulses = heat(Quantity::new("largest impulse", "Ns/kg"), &value);
    let forces = heat(Quantity::new("largest force on a contact point", "kN"), &force);
    let body = html! {
        (figures.add("robustness-polar", "Largest impulse that is survived, by direction",
            "Per kilogram of the robot, for a push at its centre of mass; a curve for each phase of the stride at which it strikes, and one for standing.",
            |width| polar.draw(width)))
        (figures.add("robustness-phase", "The same by direction and phase",
            "Directions: 0\u{b0} forward, 90\u{b0} up, 180\u{b0} backward, 270\u{b0} down.", |width| impulses.draw(width)))
        (figures.add("robustness-force", "What these cost: the largest force on a contact point",
            "Of the pushes from none up to the largest that is survived.", |width| forces.draw(width)))
    };
    let lead = html! {
        @if let Some(stride) = map.stride {
            p { "The stride begins with a step's trigger at " (number(stride.start_s)) " s and lasts " (number(stride.period_s)) " s, until the same foot's next." }
        } @else {
            p { "The robot does not walk for long enough to have a stride; it is pushed standing." }
        }
    };
    Chapter {
        title: "Robustness".into(),
        lead,
        sections: vec![Section { title: "Impulse by direction and phase".into(), body }],
    }
}

/// The table of the joints' demands.
pub(super) fn demands(rows: &[Demand]) -> Markup {
    html! {
        div.scroll { table {
            thead { tr {
                th.left { "joint" } th { "peak torque " span.unit { "[Nm]" } } th { "RMS torque " span.unit { "[Nm]" } }
                th { "peak speed " span.unit { "[rad/s]" } } th { "peak power " span.unit { "[W]" } } th { "mean power " span.unit { "[W]" } }
                th { "at its torque limit" }
            } }
            tbody {
                @for demand in rows {
                    tr {
                        th scope="row" { (demand.joint.replace('_', " ")) }
                        td { (number(demand.torque_peak_nm)) } td { (number(demand.torque_rms_nm)) } td { (number(demand.speed_peak_radps)) }
                        td { (number(demand.power_peak_w)) } td { (number(demand.power_mean_w)) }
                        td { (format!("{:.1} %", 100.0 * demand.at_limit)) }
                    }
                }
            }
        } }
    }
}

fn actuators(sizing: &Sizing, figures: &mut Figures) -> Chapter {
    let mut sections = vec![Section {
        title: "What the actuators must deliver".into(),
        body: html! {
            p { "The largest figures of all scenarios, with a margin of " (format!("{:.0} %", 100.0 * sizing.margin)) ". Where a joint is at its torque limit for a share of the time, its peak torque says nothing of the need: the limit does." }
            (demands(&sizing.required))
        },
    }];
    for used in &sizing.uses {
        let body = html! {
            @if !used.ending.stood() {
                p class="banner bad" { strong { "The robot fell: " } (used.reason.clone().unwrap_or_default()) ". The figures are those up to the fall." }
            }
            (doubt("The run", used.violations.as_ref()))
            (demands(&used.joints))
            (torque_speed_figure(used, figures))
        };
        sections.push(Section { title: used.scenario.clone(), body });
    }
    Chapter { title: "Actuators".into(), lead: html! {}, sections }
}

/// The torque-speed clouds of a scenario's joints.
pub(super) fn torque_speed_figure(used: &Use, figures: &mut Figures) -> Markup {
    let chart = torque_speed(used);
    figures.add(
        &format!("{}-torque-speed", used.scenario),
        &format!("Torque over speed, {}", used.scenario),
        "Each tick is a point; darker where there are more. Curves of constant power, and the torque limits.",
        |width| chart.draw(width),
    )
}

fn torque_speed(used: &Use) -> Chart {
    let largest = used.joints.iter().map(|joint| joint.power_peak_w).fold(0.0, f64::max);
    let products: Vec<f64> = [100.0, 300.0, 1000.0, 3000.0].into_iter().filter(|power| *power < largest).collect();
    let axis = |name: &str, unit: &str, k: usize| {
        Axis::around(Quantity::new(name, unit), used.points.iter().flatten().map(|point| point[k]))
    };
    let stack = |(joint, points): (&Demand, &Vec<[f64; 2]>)| {
        let cloud = Cloud {
            points: points.clone(),
            products: products.clone(),
            product: Quantity::new("power", "W").title(0),
            among: used.joints.len(),
        };
        let limits = [joint.torque_peak_nm, -joint.torque_peak_nm].into_iter().filter(|_| joint.at_limit > 0.0);
        let limits = limits.map(|y| Layer::Level { class: "bound", label: "torque limit".into(), y });
        let layers = [Layer::Cloud(cloud)].into_iter().chain(limits).collect();
        let part = Part { y: axis("torque", "Nm", 1), height: 190.0, layers, notes: Vec::new() };
        Stack { title: joint.joint.replace('_', " "), x: axis("speed", "rad/s", 0), parts: vec![part] }
    };
    Chart::new(used.joints.iter().zip(&used.points).map(stack).collect(), (185.0, 4))
}

fn speed_torque(pairs: &[Pair], figures: &mut Figures) -> Chapter {
    let body = speed_torque_figure("speed-torque-map", pairs, figures);
    Chapter {
        title: "Speed and torque".into(),
        lead: html! {},
        sections: vec![Section { title: "Pairs that are survived".into(), body }],
    }
}

/// The map over speed and torque limit; its file is called after `name`.
pub(super) fn speed_torque_figure(name: &str, pairs: &[Pair], figures: &mut Figures) -> Markup {
    let holds = |pair: &Pair| match pair.coping {
        Coping::Falls => Holds::Fell,
        _ => Holds::Value(pair.mean_speed_mps.unwrap_or(f64::NAN) / pair.speed_mps),
    };
    let map = SurvivalMap {
        x: Quantity::new("speed asked for", "m/s"),
        y: Quantity::new("torque limit", "Nm"),
        shade: Some(Quantity::new("speed reached, as a share", "")),
        cells: pairs.iter().map(|pair| ([pair.speed_mps, pair.torque_limit_nm], holds(pair))).collect(),
        doubtful: pairs
            .iter()
            .filter(|pair| pair.violations.is_some())
            .map(|pair| [pair.speed_mps, pair.torque_limit_nm])
            .collect(),
    };
    figures.add(
        name,
        "Which speeds can be walked with which torque limit",
        "Hatched: the robot falls. The numbers are the mean speed as a share of the one asked for: where it is far from one, the robot stays on its feet but does not walk as it should.",
        |width| map.draw(width),
    )
}
