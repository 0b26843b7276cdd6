//! The report of runs as one self-contained page, and their figures as SVG files. The same runs give the same bytes, save the
//! times between the comments `timing` and `/timing`.

mod balance;
pub(crate) mod figures;
mod limits;
mod origin;
mod stage;
mod stick;
mod strip;
mod tables;
#[cfg(test)]
pub(crate) mod tests;

use legwork::diagnosis;
use legwork::episode::{Outcome, Run};
use legwork::log::Field;
use legwork::scenario::{GeneratorKind, Push};
use legwork::scenario_file;
use maud::{Markup, PreEscaped, html};

use crate::charts::numbers::number;
use crate::document;
use crate::{NARROW, WIDE, file_name};
use figures::{Figure, plain};

const SCRIPT: &str = include_str!("animation.js");

/// A page with all `runs`: figures beside the thesis's, charts, animation, books, and how to repeat it.
pub fn html(runs: &[Run]) -> String {
    let names: Vec<&str> = runs.iter().map(|run| run.scenario.name.as_str()).collect();
    let title = format!("legwork: {}", names.join(", "));
    let main = html! {
        header.top {
            h1 { "legwork report" }
            p {
                "What was simulated, how it went, and how it compares with the thesis. Made by legwork "
                (env!("CARGO_PKG_VERSION")) "; this page is complete in itself."
            }
            (tables::overview(runs))
        }
        div #runs { @for (index, run) in runs.iter().enumerate() { (article(run, index + 1)) } }
    };
    document::frame(&title, "#runs", &contents(runs), &main, SCRIPT)
}

/// The figures of a run as SVG files: name, such as `walk-tracking-x.svg`, and text.
pub fn plots(run: &Run) -> Vec<(String, String)> {
    let name = &run.scenario.name;
    let file = |figure: &Figure| {
        let drawing = figure.draw(WIDE).standalone(&format!("{name}: {}", figure.title));
        (format!("{}-{}.svg", file_name(name), figure.name), drawing)
    };
    figures::figures(run).iter().map(file).collect()
}

/// With more runs than these, the contents name the runs only.
const RUNS_WITH_SECTIONS: usize = 3;

/// The sections of a run, as anchors and headings, but for those that its log has nothing for.
fn sections(run: &Run) -> impl Iterator<Item = (&'static str, &'static str)> {
    let [no_forces, no_limits] = [stick::forces_of(run).is_none(), !run.log.has(Field::ActiveLimit)];
    let all = [
        ("motion", "Motion"),
        ("figures", if tables::is_published(run) { "Beside the thesis" } else { "Measured" }),
        ("tracking", "Tracking"),
        ("balance", "Balance"),
        ("torques", "Joint torques"),
        ("forces", "Ground reaction forces"),
        ("torso", "Torso"),
        ("limits", "Limits and slack"),
        ("books", "Audit and times"),
        ("repeat", "Repeat this run"),
    ];
    all.into_iter().filter(move |(anchor, _)| !(no_forces && *anchor == "forces" || no_limits && *anchor == "limits"))
}

fn contents(runs: &[Run]) -> Markup {
    html! {
        nav aria-label="Contents" {
            @for (index, run) in runs.iter().enumerate() {
                @let id = format!("#run-{}", index + 1);
                div {
                    a.run href=(id) { (run.scenario.name) }
                    @if let Outcome::Fell(_) = run.outcome { " " span class="badge bad" { "fell" } }
                    @if runs.len() <= RUNS_WITH_SECTIONS {
                        ul { @for (anchor, title) in sections(run) { li { a href={ (id) "-" (anchor) } { (title) } } } }
                    }
                }
            }
        }
    }
}

fn article(run: &Run, number: usize) -> Markup {
    let id = format!("run-{number}");
    let figures = figures::figures(run);
    let shown = |names: &[&str]| html! { @for figure in figures.iter().filter(|f| names.contains(&f.name)) { (drawn(figure)) } };
    html! {
        article id=(id) {
            (head(run))
            @for (anchor, title) in sections(run) {
                section id={ (id) "-" (anchor) } {
                    h3 { (title) }
                    @match anchor {
                        "motion" => { (stage::animation(run, &format!("{id}-animation"))) (shown(&["poses"])) }
                        "figures" => (tables::comparison(run)),
                        "tracking" => (shown(&["tracking-x", "tracking-y", "tracking-z"])),
                        "balance" => (shown(&["balance", "capture"])),
                        "books" => (books(run)),
                        "repeat" => (repeat(run)),
                        _ => (shown(&[anchor])),
                    }
                }
            }
        }
    }
}

/// Name, description, outcome, and what a reader must not miss.
fn head(run: &Run) -> Markup {
    let (scenario, model) = (&run.scenario, &run.model);
    let simulated = run.log.len() as f64 * scenario.controller.period_s;
    let violations = run.violations();
    html! {
        header {
            h2 { (scenario.name) " " (tables::badge(run)) }
            @if !scenario.description.is_empty() { p.description { (scenario.description) } }
            @if let Outcome::Fell(fall) = &run.outcome {
                p class="banner bad" role="alert" {
                    strong { "The robot " } (run.reason.clone().unwrap_or_else(|| diagnosis::sentence(fall))) "."
                }
            }
            @if !violations.is_empty() {
                div class="banner warning" role="alert" {
                    strong { "The simulation broke its own bounds; read the figures with care." }
                    ul { @for violation in violations { li { (violation) } } }
                }
            }
            @if !run.limits_passed.is_empty() {
                div class="banner warning" role="alert" {
                    strong { "Joints passed limits that the model gives them." }
                    ul { @for passed in &run.limits_passed { li { (passed) } } }
                }
            }
            p.facts {
                span {
                    b { (number(simulated)) " s" }
                    @if run.outcome != Outcome::Completed { " of " (number(scenario.duration_s)) " s" }
                } " "
                span { "model " b { (scenario.model) } } " "
                span { b { (number(model.total_mass())) " kg" } } " "
                @if let Some(steps) = run.metrics.steps.filter(|_| scenario.reference.generator != GeneratorKind::Stance) {
                    span { b { (steps) } " steps" } " "
                }
                span { "friction " b { (scenario.ground.friction) } } " "
                span { "slope " b { (scenario.ground.slope_deg) "\u{b0}" } } " "
                @if scenario.ground.cross_slope_deg != 0.0 {
                    span { "slope across " b { (scenario.ground.cross_slope_deg) "\u{b0}" } } " "
                }
                @for push in &scenario.pushes {
                    span {
                        "push " b { (push.in_words()) } " on " (pushed(push)) " at "
                        (push.start_s) " s for " (push.duration_s) " s"
                    } " "
                }
            }
        }
    }
}

/// Where a push acts, in words.
fn pushed(push: &Push) -> String {
    if push.at == "com" { "the centre of mass".into() } else { plain(&push.at) }
}

fn drawn(figure: &Figure) -> Markup {
    html! {
        figure {
            (figure.draw(WIDE).inline("wide"))
            (figure.draw(NARROW).inline("narrow"))
            figcaption { b { (figure.title) "." } " " (figure.caption) }
        }
    }
}

fn books(run: &Run) -> Markup {
    html! {
        div.columns {
            div { h4 { "Simulator" } (tables::audit(run)) }
            @if run.program.solves > 0 { div { h4 { "Quadratic programs" } (tables::program(run)) } }
            (PreEscaped("<!-- timing -->"))
            div { h4 { "Time on this computer" } (tables::timing(run)) }
            (PreEscaped("<!-- /timing -->"))
        }
    }
}

fn repeat(run: &Run) -> Markup {
    let command = origin::command(&run.scenario);
    html! {
        @if command.needs_file { p { "Save the scenario below as a file, then:" } }
        pre tabindex="0" { code { (command.line) } }
        h4 { "Settings that are not the defaults" }
        (tables::settings(run))
        (tables::definitions(&[
            ("hash of the inputs", format!("{:032x}", run.input_hash)),
            ("hash of the result", format!("{:032x}", run.result_hash)),
        ]))
        details {
            summary { "The whole scenario" }
            pre tabindex="0" { code { (scenario_file::to_toml(&run.scenario)) } }
        }
    }
}
