//! The page of `legwork compare`: two robots beside each other and a person.

use legwork_study::comparison::{Figures as Walk, Gait, Person};
use legwork_study::robustness::Stride;
use legwork_study::sizing::{Pair, Sizing};
use maud::{Markup, html};
use serde::Serialize;

use super::envelope::{demands, doubt, doubts, speed_torque_figure, torque_speed_figure};
use crate::charts::axis::Quantity;
use crate::charts::bars::{Bar, Bars, Group};
use crate::charts::numbers::number;
use crate::charts::sweep::{Panel, Part, Point, Series, Sweep};
use crate::document::{Chapter, Figures, Page, Section, page as document};

/// All that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The robots.
    pub robots: Vec<Robot>,
    /// Whom they are held beside.
    pub person: Person,
    /// Whether the pushes were sought quickly, in coarse steps.
    pub quick: bool,
    /// Whether it was interrupted, so that something is missing.
    pub interrupted: bool,
}

/// A robot and what was found of it.
#[derive(Clone, Debug, Serialize)]
pub struct Robot {
    /// The scenario.
    pub scenario: String,
    /// The robot's mass [kg].
    pub mass_kg: f64,
    /// Whether each foot is a point.
    pub point_feet: bool,
    /// How it walks at each speed.
    pub gaits: Vec<Gait>,
    /// The pushes that it survives; none where the robots have no speed in common.
    pub pushes: Option<Pushes>,
    /// What its actuators must deliver over all speeds.
    pub sizing: Sizing,
    /// Which speeds it walks at which torque limit.
    pub map: Vec<Pair>,
}

/// The largest impulses that a robot survives.
#[derive(Clone, Debug, Serialize)]
pub struct Pushes {
    /// The speed at which they strike [m/s].
    pub speed_mps: f64,
    /// The stride whose phases are struck.
    pub stride: Option<Stride>,
    /// One for each phase and direction.
    pub strikes: Vec<Strike>,
}

/// The largest impulse of one phase and direction.
#[derive(Clone, Debug, Serialize)]
pub struct Strike {
    /// Phase of the stride; none standing.
    pub phase: Option<f64>,
    /// Direction of the push: 0 forward, 180 backward [deg].
    pub direction_deg: f64,
    /// The impulse [Ns]; none where the robot falls without one.
    pub impulse_ns: Option<f64>,
    /// Largest force on a contact point on the way to it [N].
    pub force_n: Option<f64>,
    /// Why a larger one is not survived.
    pub reason_beyond: Option<String>,
    /// Bounds of the simulator's audit that were broken on the way to it, in words.
    pub violations: Option<String>,
}

impl Report {
    /// How many answers rest on rollouts that broke bounds of the simulation, in words; none where there are none.
    pub fn doubts(&self) -> Option<String> {
        let robots = || self.robots.iter();
        let gaits = robots().flat_map(|robot| &robot.gaits).map(|gait| gait.violations.is_some());
        let strikes = robots().flat_map(|robot| &robot.pushes).flat_map(|pushes| &pushes.strikes);
        let strikes = strikes.map(|strike| strike.violations.is_some());
        let pairs = robots().flat_map(|robot| &robot.map).map(|pair| pair.violations.is_some());
        doubts([("walks", gaits.collect()), ("impulses", strikes.collect()), ("pairs", pairs.collect())])
    }

    /// What the comparison is called.
    pub fn title(&self) -> String {
        let [first, second] = &self.robots[..] else { unreachable!("two robots are compared") };
        match (first.point_feet, second.point_feet) {
            (true, false) => "Point feet against feet".to_owned(),
            (false, true) => "Feet against point feet".to_owned(),
            _ => format!("{} against {}", first.scenario, second.scenario),
        }
    }
}

/// A figure of a walk in words, with its decimals and its value.
type Row = (&'static str, usize, fn(&Walk) -> Option<f64>);

/// The figures that are no joint's.
const ROWS: [Row; 8] = [
    ("mean speed [m/s]", 3, |f| Some(f.mean_speed_mps)),
    ("torso, range [deg]", 1, |f| Some(f.torso_range_rad.to_degrees())),
    ("u\u{b2}, mean [N\u{b2}m\u{b2}]", 0, |f| f.u2_n2m2),
    ("single support", 2, |f| f.single_support_fraction),
    ("cost of transport", 2, |f| f.cost_of_transport),
    ("XcoM error, mean [mm]", 1, |f| f.xcom_error_mean_m.map(|error| 1e3 * error)),
    ("XcoM error, peak [mm]", 1, |f| f.xcom_error_peak_m.map(|error| 1e3 * error)),
    ("peak force, whole robot [N]", 0, |f| Some(f.ground_force_peak_n)),
];

/// Where there is no value.
pub const NONE: &str = "\u{2013}";

/// A row of the table: its name, the robots' values, the person's.
pub fn rows(walks: &[Option<&Walk>], person: &Person) -> Vec<(String, Vec<String>)> {
    let shown = |value: Option<f64>, digits: usize| value.map_or(NONE.to_owned(), |value| format!("{value:.digits$}"));
    let mut rows = Vec::new();
    let mut joints: Vec<&str> = person.peaks_nm.iter().map(|(joint, _)| *joint).collect();
    let others = walks.iter().flatten().flat_map(|walk| &walk.joints).map(|joint| joint.joint.as_str());
    let others: Vec<&str> = others.filter(|joint| !joints.contains(joint)).collect();
    joints.extend(others);
    for joint in joints {
        let of =
            |walk: &Option<&Walk>| walk.and_then(|walk| walk.joints.iter().find(|found| found.joint == joint).cloned());
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
pub fn speeds(report: &Report) -> Vec<f64> {
    let mut speeds: Vec<f64> = Vec::new();
    for gait in report.robots.iter().flat_map(|robot| &robot.gaits) {
        if !speeds.contains(&gait.speed_mps) {
            speeds.push(gait.speed_mps);
        }
    }
    speeds
}

/// The largest impulse that a robot survives at a phase from a direction; none where it was not sought.
pub fn strike(robot: &Robot, phase: Option<f64>, direction_deg: f64) -> Option<&Strike> {
    let strikes = &robot.pushes.as_ref()?.strikes;
    strikes.iter().find(|strike| strike.phase == phase && strike.direction_deg == direction_deg)
}

/// The impulse of [`strike`] as a table shows it, with the largest force in kN, and with a star where it rests on rollouts that broke bounds of the simulation.
pub fn impulse(robot: &Robot, phase: Option<f64>, direction_deg: f64) -> String {
    let Some(strike) = strike(robot, phase, direction_deg) else { return NONE.to_owned() };
    let star = if strike.violations.is_some() { "*" } else { "" };
    let force = strike.force_n.map_or(String::new(), |force| format!(" {:>4.1}", 1e-3 * force));
    strike.impulse_ns.map_or(NONE.to_owned(), |impulse| format!("{impulse:.0}{star}{force}"))
}

/// The phases that were struck, in their order.
pub fn phases(robots: &[Robot]) -> Vec<Option<f64>> {
    let mut phases: Vec<Option<f64>> = Vec::new();
    for strike in robots.iter().filter_map(|robot| robot.pushes.as_ref()).flat_map(|pushes| &pushes.strikes) {
        if !phases.contains(&strike.phase) {
            phases.push(strike.phase);
        }
    }
    phases
}

/// A phase in words.
pub fn phase_label(phase: Option<f64>) -> String {
    phase.map_or("standing".to_owned(), |phase| format!("phase {}", shorter(phase)))
}

/// Without digits that only computing leaves.
pub fn shorter(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// The page of `report`.
pub fn page(report: &Report) -> Page {
    let mut figures = Figures::default();
    let mut sections: Vec<Section> = speeds(report).iter().map(|&speed| walk(report, speed, &mut figures)).collect();
    sections.extend(pushes(&report.robots, report.quick, &mut figures));
    let first = Chapter { title: report.title(), lead: lead(report), sections };
    let mut chapters = vec![first];
    chapters.extend(report.robots.iter().map(|robot| actuators(robot, &mut figures)));
    let lead = html! {
        p { "Two robots at the same speeds and under the same pushes, beside a person." }
        @if report.interrupted { p class="banner warning" { "The work was interrupted: some of it is missing." } }
        @if let Some(doubts) = report.doubts() { p class="banner warning" { (doubts) "." } }
    };
    let title = format!("{} and {}", report.robots[0].scenario, report.robots[1].scenario);
    document(&title, &lead, &chapters, figures)
}

fn lead(report: &Report) -> Markup {
    let person = &report.person;
    html! {
        p {
            "The figures are those of the steady walk, without the start. Right and left joints count together. Beside the robots ("
            @for (index, robot) in report.robots.iter().enumerate() {
                @if index > 0 { ", " } (robot.scenario) " " (number(robot.mass_kg)) " kg"
            }
            ") stand the peak torques of a person of " (number(person.mass_kg)) " kg at " (number(person.speed_mps)) " m/s ("
            (person.source) "), at whatever speed the robots walk."
        }
    }
}

/// All robots at one speed.
fn walk(report: &Report, speed: f64, figures: &mut Figures) -> Section {
    let gaits: Vec<_> =
        report.robots.iter().map(|robot| robot.gaits.iter().find(|gait| gait.speed_mps == speed)).collect();
    let walks: Vec<Option<&Walk>> = gaits.iter().map(|gait| gait.and_then(|gait| gait.figures.as_ref())).collect();
    let names = || report.robots.iter().map(|robot| robot.scenario.clone()).chain(["person".to_owned()]);
    let body = html! {
        @for (robot, gait) in report.robots.iter().zip(&gaits) {
            @if let Some(reason) = gait.and_then(|gait| gait.failure.as_ref()) {
                p class="banner bad" { strong { (robot.scenario) " does not walk at " (speed) " m/s: " } (reason) "." }
            }
            (doubt(&robot.scenario, gait.and_then(|gait| gait.violations.as_ref())))
        }
        @if walks.iter().any(Option::is_some) {
            (figures.add(&format!("torques-{speed}"), &format!("Peak torques at {speed} m/s"),
                "The largest of right and left; no bar where there is no such joint.",
                |width| torques(report, &walks).draw(width)))
            div.scroll { table {
                thead { tr { th.left { "" } @for name in names() { th { (name) } } } }
                tbody {
                    @for (name, values) in rows(&walks, &report.person) {
                        tr { th scope="row" { (name) } @for value in values { td { (value) } } }
                    }
                }
            } }
        }
    };
    Section { title: format!("Walking at {speed} m/s"), body }
}

fn torques(report: &Report, walks: &[Option<&Walk>]) -> Bars {
    let bar = |value: Option<f64>| Bar { value: value.unwrap_or(f64::NAN), interval: None };
    let peak = |walk: &Option<&Walk>, joint: &str| {
        walk.and_then(|walk| walk.joints.iter().find(|found| found.joint == joint)).map(|found| found.peak_nm)
    };
    let groups = report.person.peaks_nm.iter().map(|(joint, of_person)| Group {
        label: (*joint).to_owned(),
        bars: walks.iter().map(|walk| peak(walk, joint)).chain([Some(*of_person)]).map(bar).collect(),
    });
    Bars {
        value: Quantity::new("peak torque", "Nm"),
        series: report.robots.iter().map(|robot| robot.scenario.clone()).chain(["person".to_owned()]).collect(),
        interval: String::new(),
        groups: groups.collect(),
    }
}

fn pushes(robots: &[Robot], quick: bool, figures: &mut Figures) -> Option<Section> {
    let speed = robots.iter().find_map(|robot| robot.pushes.as_ref())?.speed_mps;
    let struck: Vec<f64> = phases(robots).into_iter().flatten().collect();
    let panel = |title: &str, direction: f64| {
        let of = |robot| {
            let value = |phase| strike(robot, Some(phase), direction).and_then(|strike| strike.impulse_ns);
            struck.iter().map(|&phase| value(phase).unwrap_or(f64::NAN)).collect()
        };
        let values = robots.iter().map(of).collect();
        Panel { title: title.to_owned(), parts: vec![Part::new(Quantity::new("largest impulse", "Ns"), values)] }
    };
    // A phase has a mark in both directions or in none.
    let is_doubtful = |robot: &Robot, phase: f64| {
        let strikes = [0.0, 180.0].map(|direction| strike(robot, Some(phase), direction));
        strikes.into_iter().flatten().any(|strike| strike.violations.is_some())
    };
    let series = |robot: &Robot| Series {
        label: robot.scenario.clone(),
        points: struck.iter().map(|&x| Point { x, fell: false, doubtful: is_doubtful(robot, x) }).collect(),
    };
    let sweep = Sweep {
        x: Quantity::new("phase of the stride", ""),
        categories: Vec::new(),
        marked: None,
        series: robots.iter().map(series).collect(),
        panels: vec![panel("forward", 0.0), panel("backward", 180.0)],
    };
    let body = html! {
        p {
            "A push at the centre of mass for 0.2 s; survived means on its feet 4 s after its end, and so do all smaller impulses that were tried."
            @if quick { " They were sought quickly, in coarse steps." }
        }
        @if !struck.is_empty() {
            (figures.add("pushes", &format!("Largest impulse that is survived at {speed} m/s"),
                "By the phase of the stride at which it strikes, from a foot's step to the same foot's next.", |width| sweep.draw(width)))
        }
        div.scroll { table {
            thead { tr {
                th.left { "largest impulse " span.unit { "[Ns]" } ", force on a contact point on the way to it " span.unit { "[kN]" } }
                @for robot in robots { th { (robot.scenario) ", forward" } th { (robot.scenario) ", backward" } }
            } }
            tbody {
                @for phase in phases(robots) {
                    tr {
                        th scope="row" { (phase_label(phase)) }
                        @for robot in robots { td { (impulse(robot, phase, 0.0)) } td { (impulse(robot, phase, 180.0)) } }
                    }
                }
            }
        } }
    };
    Some(Section { title: "Pushes".into(), body })
}

fn actuators(robot: &Robot, figures: &mut Figures) -> Chapter {
    let sizing = &robot.sizing;
    let table = html! {
        p { "The largest figures of the speeds that the robot walks at, with a margin of " (format!("{:.0} %", 100.0 * sizing.margin)) ". Where a joint is at its torque limit for a share of the time, its peak torque says nothing of the need: the limit does." }
        @if sizing.uses.is_empty() { p class="banner bad" { "The robot walks at none of the speeds." } } @else { (demands(&sizing.required)) }
        @for used in &sizing.uses { (torque_speed_figure(used, figures)) }
    };
    let map = Section {
        title: "Speed and torque limit".into(),
        body: speed_torque_figure(&format!("{}-map", robot.scenario), &robot.map, figures),
    };
    Chapter {
        title: format!("Actuators of {}", robot.scenario),
        lead: html! {},
        sections: vec![Section { title: "What they must deliver".into(), body: table }, map],
    }
}
