//! The tables of a run: its figures beside the thesis's, the simulator's books, the programs, the times.

use legwork::episode::{Outcome, Run};
use legwork_thesis::published;
use maud::{Markup, html};

use super::origin;
use crate::charts::numbers::{number, tick_label};

/// Whether the thesis publishes figures of a scenario of this name.
pub(super) fn is_published(run: &Run) -> bool {
    published::compare(&run.scenario.name, &run.metrics).iter().any(|row| row.published.is_some())
}

/// Every figure beside the published one; without published ones only what was measured.
pub(super) fn comparison(run: &Run) -> Markup {
    let rows = published::compare(&run.scenario.name, &run.metrics);
    let known = is_published(run);
    let changed = origin::differences_from_built_in(&run.scenario).map_or(0, |differences| differences.len());
    html! {
        @if known && changed > 0 {
            p.note {
                "This run differs from the thesis's experiment in " (changed) " setting" @if changed > 1 { "s" } "; see "
                "its settings below."
            }
        }
        div.scroll tabindex="0" role="region" aria-label={ "Figures of " (run.scenario.name) } {
            table class=(if known { "comparison published" } else { "comparison" }) {
                thead {
                    tr {
                        th rowspan="2" scope="col" { "figure" }
                        th colspan=(if known { "3" } else { "1" }) scope="colgroup" { "mean" }
                        th colspan=(if known { "3" } else { "1" }) scope="colgroup" { "peak" }
                    }
                    tr {
                        @for _ in 0..2 {
                            @if known { th scope="col" { "thesis" } }
                            th scope="col" { "measured" }
                            @if known { th scope="col" { "difference" } }
                        }
                    }
                }
                tbody {
                    @for row in rows.iter().filter(|row| row.published.is_some() || row.measured.is_some()) {
                        tr {
                            th scope="row" { (row.label) @if !row.unit.is_empty() { span.unit { " [" (row.unit) "]" } } }
                            @for (published, measured) in [(row.published, row.measured), (row.published_peak, row.measured_peak)] {
                                @if published.is_none() && measured.is_none() {
                                    td colspan=(if known { "3" } else { "1" }) {}
                                } @else {
                                    @if known { td { (published.map_or("\u{2013}".to_owned(), as_published)) } }
                                    td.measured { (optional(measured)) }
                                    @if known { td { (difference(published, measured)) } }
                                }
                            }
                        }
                    }
                }
            }
        }
        p.note { "Counted: " (run.scenario.metrics.counted()) "." }
    }
}

/// One line for each run, with links to them.
pub(super) fn overview(runs: &[Run]) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Overview" {
            table.overview {
                thead { tr {
                    th scope="col" { "scenario" }
                    th scope="col" { "outcome" }
                    th scope="col" { "mean CoM error" span.unit { " [m]" } }
                    th scope="col" { "mean feet error" span.unit { " [m]" } }
                    th scope="col" { "mean torque" span.unit { " [Nm]" } }
                    th scope="col" { "steps" }
                    th scope="col" { "recovery" span.unit { " [s]" } }
                    th scope="col" { "mean speed" span.unit { " [m/s]" } }
                } }
                tbody {
                    @for (index, run) in runs.iter().enumerate() {
                        @let m = &run.metrics;
                        tr {
                            th scope="row" { a href={ "#run-" (index + 1) } { (run.scenario.name) } }
                            td.left { (badge(run)) }
                            td { (optional(m.com_error_m.map(|error| error.mean))) }
                            td { (optional(m.feet_error_m.map(|error| error.mean))) }
                            td { (optional(m.torque_nm.map(|torque| torque.mean))) }
                            td { (optional(m.steps.map(f64::from))) }
                            td { (optional(m.recovery_time_s)) }
                            td { (tick_label(m.mean_speed_mps, 0.01)) }
                        }
                    }
                }
            }
        }
    }
}

/// The outcome in a word, coloured.
pub(super) fn badge(run: &Run) -> Markup {
    match &run.outcome {
        Outcome::Completed => match run.injurious_force_n() {
            Some(force) => {
                html! { span class="badge bad" { "stood, injurious force of " (format!("{:.1}", 1e-3 * force)) " kN" } }
            }
            None => html! { span class="badge good" { "completed" } },
        },
        Outcome::Fell(fall) => html! { span class="badge bad" { "fell at " (format!("{:.2}", fall.time)) " s" } },
        Outcome::Stopped => html! { span class="badge" { "stopped" } },
    }
}

/// The books of the simulator.
pub(super) fn audit(run: &Run) -> Markup {
    let Some(audit) = &run.audit else {
        return html! { p { "The physics of this run keeps no books." } };
    };
    definitions(&[
        ("energy error", quantity(audit.energy_error_j, "J")),
        ("work, absolute", quantity(audit.work_j, "J")),
        ("lost in contacts", quantity(audit.contact_loss_j, "J")),
        ("given by contacts at most", quantity(audit.contact_gain_j, "J")),
        ("momentum error", quantity(audit.momentum_error_mps, "m/s")),
        ("deepest penetration", quantity(audit.penetration_m, "m")),
        ("over the friction cone", quantity(audit.friction_excess_n, "N")),
        ("friction off the slip", quantity(audit.friction_angle_deg, "deg")),
        ("pull of the ground", quantity(audit.pull_n, "N")),
        ("slip of loaded feet", quantity(audit.slip_m, "m")),
        ("contact residual", quantity(audit.contact_residual_n, "N")),
        ("most solves for contacts in a step", audit.contact_sweeps.to_string()),
    ])
}

/// How the quadratic programs went.
pub(super) fn program(run: &Run) -> Markup {
    let program = &run.program;
    let [variables, rows] = program.size;
    definitions(&[
        ("variables", variables.to_string()),
        ("rows", rows.to_string()),
        ("programs solved", program.solves.to_string()),
        ("ticks without a solution", program.infeasible.to_string()),
        ("ticks with a fallback", program.fallbacks.to_string()),
        ("iterations a tick, mean", number(program.iterations_mean)),
        ("iterations a tick, most", program.iterations_max.to_string()),
    ])
}

/// How long things took: the only part of the page that differs between two runs of the same.
pub(super) fn timing(run: &Run) -> Markup {
    let simulated = run.log.len() as f64 * run.scenario.controller.period_s;
    let microseconds = |share| quantity(run.timing.tick_quantile_us(share), "\u{b5}s");
    definitions(&[
        ("control tick, median", microseconds(0.5)),
        ("control tick, 99 %", microseconds(0.99)),
        ("control tick, longest", microseconds(1.0)),
        ("whole run", quantity(run.timing.wall_s, "s")),
        ("times real time", format!("{:.0}", simulated / run.timing.wall_s.max(1e-9))),
    ])
}

/// The settings that are not the defaults.
pub(super) fn settings(run: &Run) -> Markup {
    let differences = origin::differences_from_defaults(&run.scenario);
    if differences.is_empty() {
        return html! { p { "All settings are the defaults." } };
    }
    html! {
        div.scroll tabindex="0" role="region" aria-label={ "Settings of " (run.scenario.name) } {
            table.settings {
                thead { tr { th scope="col" { "setting" } th scope="col" { "value" } th scope="col" { "default" } th scope="col" { "meaning" } } }
                tbody {
                    @for set in differences {
                        tr {
                            th scope="row" { code { (set.path) } }
                            td { (set.value) @if !set.setting.unit.is_empty() { span.unit { " " (set.setting.unit) } } }
                            td.soft { (set.other) }
                            td.left { (set.setting.help) }
                        }
                    }
                }
            }
        }
    }
}

pub(super) fn definitions(entries: &[(&str, String)]) -> Markup {
    html! { dl { @for (name, value) in entries { div { dt { (name) } dd { (value) } } } } }
}

fn quantity(value: f64, unit: &str) -> String {
    format!("{} {unit}", number(value))
}

fn optional(value: Option<f64>) -> String {
    value.map_or("\u{2013}".to_owned(), number)
}

/// Measured against published, as a share of the published.
fn difference(published: Option<f64>, measured: Option<f64>) -> Markup {
    let (Some(published), Some(measured)) = (published, measured) else { return html! { "\u{2013}" } };
    let percent = 100.0 * (measured - published) / published;
    let rounded = if percent.abs() < 10.0 { format!("{percent:+.1}") } else { format!("{percent:+.0}") };
    let zero = rounded.bytes().all(|byte| matches!(byte, b'+' | b'-' | b'0' | b'.'));
    let text = if zero { "0".to_owned() } else { rounded.replace('-', "\u{2212}") };
    html! { (text) " %" }
}

/// A published number with the digits that were published.
fn as_published(value: f64) -> String {
    if value.abs() < 1e4 {
        return value.to_string();
    }
    number(value).replacen("0\u{b7}", "\u{b7}", 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_a_sign() {
        let shown = |published, measured| difference(Some(published), Some(measured)).into_string();
        assert_eq!(shown(0.5, 0.55), "+10 %");
        assert_eq!(shown(220.0, 220.0), "0 %");
        assert_eq!(shown(356.0, 350.0), "\u{2212}1.7 %");
        assert_eq!(difference(None, Some(1.0)).into_string(), "\u{2013}");
    }
}
