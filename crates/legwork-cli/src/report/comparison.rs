//! The page of `legwork compare`: two robots beside each other and a person.

use legwork_study::comparison::Figures as Walk;
use maud::{Markup, html};

use super::charts::axis::Quantity;
use super::charts::bars::{Bar, Bars, Group};
use super::charts::sweep::{Panel, Part, Point, Series, Sweep};
use super::document::{Chapter, Figures, Page, Section, page as document};
use super::envelope::{demands, speed_torque_figure, torque_speed_figure};
use super::tables::number;
use crate::compare::text::{impulse, phase_label, phases, rows, speeds};
use crate::compare::{Report, Robot};

/// The page of `report`.
pub(crate) fn page(report: &Report) -> Page {
    let mut figures = Figures::default();
    let mut sections: Vec<Section> = speeds(report).iter().map(|&speed| walk(report, speed, &mut figures)).collect();
    sections.extend(pushes(&report.robots, report.quick, &mut figures));
    let first = Chapter { title: report.title(), lead: lead(report), sections };
    let mut chapters = vec![first];
    chapters.extend(report.robots.iter().map(|robot| actuators(robot, &mut figures)));
    let lead = html! {
        p { "Two robots at the same speeds and under the same pushes, beside a person." }
        @if report.interrupted { p class="banner warning" { "The work was interrupted: some of it is missing." } }
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

fn quantity(name: &str, unit: &str) -> Quantity {
    Quantity { name: name.into(), unit: unit.into(), log: false }
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
        value: quantity("peak torque", "Nm"),
        series: report.robots.iter().map(|robot| robot.scenario.clone()).chain(["person".to_owned()]).collect(),
        interval: String::new(),
        groups: groups.collect(),
    }
}

fn pushes(robots: &[Robot], quick: bool, figures: &mut Figures) -> Option<Section> {
    let speed = robots.iter().find_map(|robot| robot.pushes.as_ref())?.speed_mps;
    let struck: Vec<f64> = phases(robots).into_iter().flatten().collect();
    let panel = |title: &str, direction: f64| {
        let of =
            |robot| struck.iter().map(|&phase| impulse(robot, Some(phase), direction).unwrap_or(f64::NAN)).collect();
        let values = robots.iter().map(of).collect();
        Panel { title: title.to_owned(), parts: vec![Part { y: quantity("largest impulse", "Ns"), values }] }
    };
    let series = |robot: &Robot| Series {
        label: robot.scenario.clone(),
        points: struck.iter().map(|&x| Point { x, fell: false }).collect(),
    };
    let sweep = Sweep {
        x: quantity("phase of the stride", ""),
        categories: Vec::new(),
        marked: None,
        series: robots.iter().map(series).collect(),
        panels: vec![panel("forward", 0.0), panel("backward", 180.0)],
    };
    let shown = |robot: &Robot, phase, direction| {
        impulse(robot, phase, direction).map_or("\u{2013}".to_owned(), |impulse| format!("{impulse:.0}"))
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
                th.left { "largest impulse " span.unit { "[Ns]" } }
                @for robot in robots { th { (robot.scenario) ", forward" } th { (robot.scenario) ", backward" } }
            } }
            tbody {
                @for phase in phases(robots) {
                    tr {
                        th scope="row" { (phase_label(phase)) }
                        @for robot in robots { td { (shown(robot, phase, 0.0)) } td { (shown(robot, phase, 180.0)) } }
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
        p { "The largest figures of the speeds that it walks at, with a margin of " (format!("{:.0} %", 100.0 * sizing.margin)) ". Where a joint is at its torque limit for a share of the time, its peak torque says nothing of the need: the limit does." }
        @if sizing.uses.is_empty() { p class="banner bad" { "It walks at none of the speeds." } } @else { (demands(&sizing.required)) }
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
