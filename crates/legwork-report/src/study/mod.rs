//! The page of a study: what was asked, how the rollouts ended, and the figures that its design calls for.

mod along;
mod indices;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use legwork::diagnosis::FirstCause;
use legwork::error::Error;
use legwork_study::Factor;
use legwork_study::design::Design;
use legwork_study::results::{Endings, Range, Results};
use legwork_study::rollout::DOUBTFUL;
use legwork_study::sensitivity::Bootstrap;
use maud::{Markup, html};

use crate::charts::axis::Quantity;
use crate::charts::numbers::number;
use crate::document::{Chapter, Figures, Page, Section, page as document};
use along::{is_map, is_replicate, maps, parts, sweeps, varied};
use indices::{morris, sobol};

/// The intervals of the indices: percentile bootstrap of the base samples.
pub const BOOTSTRAP: Bootstrap = Bootstrap { resamples: 1000, level: 0.95, seed: 1 };

/// The page of `results`.
///
/// # Errors
/// The indices cannot be computed from them.
pub fn page(results: &Results) -> Result<Page, Error> {
    let study = results.study;
    let mut figures = Figures::default();
    let mut chapters = vec![Chapter {
        title: "How the rollouts ended".into(),
        lead: html! {},
        sections: vec![
            Section { title: "Survival".into(), body: survival(results) },
            Section { title: "Causes of the falls".into(), body: causes(results) },
            Section { title: "Ranges of the figures".into(), body: ranges(results) },
        ],
    }];
    match study.design {
        Design::OneAtATime => chapters.push(Chapter {
            title: "One factor at a time".into(),
            lead: html! { p { "Each factor alone is varied; all else is as in the scenario. " (FALL_NOTE) } },
            sections: sweeps(results, &mut figures),
        }),
        Design::Saltelli { .. } => {
            for base in 0..study.bases.len() {
                chapters.push(sobol(results, base, &mut figures)?);
            }
        }
        Design::Morris { .. } => {
            for base in 0..study.bases.len() {
                chapters.push(morris(results, base, &mut figures)?);
            }
        }
        Design::Grid if is_map(results) => chapters.push(Chapter {
            title: "Two factors together".into(),
            lead: html! { p { "Each combination of levels is one " (if seeds(results) > 1 { "group of rollouts" } else { "rollout" }) "." (repetitions(results)) } },
            sections: maps(results, &mut figures),
        }),
        Design::Grid | Design::LatinHypercube { .. } | Design::SobolSequence { .. } => chapters.push(Chapter {
            title: "Along each factor".into(),
            lead: html! {
                p {
                    @if varied(results).len() > 1 { "All factors vary at once. " }
                    "Along each factor the rollouts are taken together at its levels or in equal parts of its range: the share of "
                    "them that did not fall, and the spread of each figure over those." (repetitions(results))
                }
            },
            sections: parts(results, &mut figures),
        }),
    }
    chapters.push(Chapter { title: "Repeat this study".into(), lead: repeat(results), sections: Vec::new() });
    let lead = html! {
        @if !study.description.is_empty() { p.description { (study.description) } }
        p.facts {
            span { b { (study.len()) } " rollouts" } " "
            span { "scenarios " b { (study.bases.iter().map(|base| base.name()).collect::<Vec<_>>().join(", ")) } } " "
            span { "factors " b { (study.factors.iter().map(|factor| factor.name.as_str()).collect::<Vec<_>>().join(", ")) } }
        }
    };
    Ok(document(&format!("Study: {}", study.name), &lead, &chapters, figures))
}

/// How many fell, and of what.
pub fn endings(endings: &Endings) -> String {
    let Endings { rollouts, completed, injurious, fell, invalid, failed, doubtful, causes } = endings;
    let mut text = format!("{} of {rollouts} on their feet to the end", completed + injurious);
    if *injurious > 0 {
        let _ = write!(text, ", {injurious} of these with an injurious contact force");
    }
    if *fell > 0 {
        let mut causes: Vec<_> = causes.iter().collect();
        causes.sort_by_key(|(name, count)| (std::cmp::Reverse(**count), (*name).clone()));
        let causes: Vec<String> = causes.iter().map(|(cause, count)| format!("{cause} {count}")).collect();
        let _ = write!(text, ", {fell} fell");
        if !causes.is_empty() {
            let _ = write!(text, " ({})", causes.join(", "));
        }
    }
    let others = [(invalid, "could not be run"), (failed, "failed by a defect of the program"), (doubtful, DOUBTFUL)];
    for (count, what) in others {
        if *count > 0 {
            let _ = write!(text, ", {count} {what}");
        }
    }
    text
}

/// How often each combination of the other factors is run.
fn seeds(results: &Results) -> usize {
    let factors = &results.study.factors;
    let levels = |factor: &Factor| factor.levels.extremes().len();
    if factors.len() > 1 { factors.iter().find(|factor| is_replicate(factor)).map_or(1, levels) } else { 1 }
}

/// What is to be said of seeds.
fn repetitions(results: &Results) -> String {
    match seeds(results) {
        1 => String::new(),
        count => format!(" Each combination is run with {count} seeds, which are repetitions and no factor."),
    }
}

const FALL_NOTE: &str = "A cross marks a fall; the figures of a run that fell are not drawn; a ring marks a rollout that broke bounds of the simulation.";

fn survival(results: &Results) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th.left { "scenario" } th { "rollouts" } th { "stood" } th { "fell" } th { "could not be run" } th { "defects" } th { "bounds broken" } th { "share that stood" } } }
            tbody {
                @for (number, base) in results.study.bases.iter().enumerate() {
                    @let e = results.endings(number);
                    tr {
                        th scope="row" { (base.name()) }
                        td { (e.rollouts) } td { (e.completed) } td { (e.fell) } td { (e.invalid) } td { (e.failed) } td { (e.doubtful) }
                        td { (format!("{:.1} %", 100.0 * e.completed as f64 / e.rollouts.max(1) as f64)) }
                    }
                }
            }
        } }
    }
}

fn causes(results: &Results) -> Markup {
    let all: Vec<_> = (0..results.study.bases.len()).map(|base| results.endings(base)).collect();
    let names: BTreeSet<&String> = all.iter().flat_map(|endings| endings.causes.keys()).collect();
    if names.is_empty() {
        return html! { p { "Nobody fell." } };
    }
    html! {
        p { "The first cause of each fall, by the rules of the diagnosis; the sentences are in the table of rollouts." }
        div.scroll { table {
            thead { tr { th.left { "first cause" } @for base in &results.study.bases { th { (base.name()) } } } }
            tbody {
                @for name in names {
                    tr {
                        th scope="row" { (cause_title(name)) }
                        @for endings in &all { td { (endings.causes.get(name).map_or("\u{2013}".to_owned(), usize::to_string)) } }
                    }
                }
            }
        } }
    }
}

fn ranges(results: &Results) -> Markup {
    let bases = 0..results.study.bases.len();
    let shown = |base, metric: &str| results.range(base, metric).map_or("\u{2013}".to_owned(), |found| range(&found));
    html! {
        p { "From the least to the greatest of the rollouts that stood; one number where they differ by no more than rounding." }
        div.scroll { table {
            thead { tr { th.left { "figure" } @for base in &results.study.bases { th { (base.name()) } } } }
            tbody {
                @for column in &results.columns {
                    tr {
                        th scope="row" { (column.label) @if !column.unit.is_empty() { " " span.unit { "[" (column.unit) "]" } } }
                        @for base in bases.clone() { td { (shown(base, &column.name)) } }
                    }
                }
            }
        } }
    }
}

/// From the least to the greatest, with the digits that tell them apart; one number where they are equal but for rounding.
pub fn range(range: &Range) -> String {
    let Range { least, greatest, .. } = *range;
    if range.is_one_value() {
        return number(least);
    }
    let apart = (greatest - least).abs() / least.abs().max(greatest.abs());
    // Two digits of the difference, three at the least.
    let digits = (1 - apart.log10().floor() as i32).clamp(2, 15) as usize;
    if digits == 2 {
        return format!("{} to {}", number(least), number(greatest));
    }
    let decimals = |value: f64| (digits as i32 - value.abs().max(1e-300).log10().floor() as i32).clamp(0, 15) as usize;
    let decimals = decimals(if least.abs() > greatest.abs() { least } else { greatest });
    let text = |value: f64| match value.abs() {
        size if size != 0.0 && !(1e-3..1e6).contains(&size) => format!("{value:.digits$e}"),
        _ => format!("{value:.decimals$}"),
    };
    format!("{} to {}", text(least), text(greatest)).replace('-', "\u{2212}")
}

/// A first cause in words.
fn cause_title(label: &str) -> &str {
    FirstCause::LABELS.iter().find(|(known, _)| *known == label).map_or(label, |(_, title)| title)
}

/// The axis of a factor.
fn axis(factor: &Factor) -> Quantity {
    let unit = if factor.relative { "times the base" } else { factor.unit() };
    Quantity::new(factor.title(), unit).logarithmic(factor.levels.is_logarithmic())
}

fn repeat(results: &Results) -> Markup {
    let study = results.study;
    html! {
        p { "The whole study is the file " code { "study.toml" } " beside this page; " code { "rollouts.csv" } " and "
            code { "rollouts.parquet" } " hold a row for each rollout with all its figures, " code { "results.json" }
            " what this page shows." }
        pre tabindex="0" { code { "legwork study study.toml --out again" } }
        p.note { "Identity of the study and all that it names: " code { (format!("{:032x}", study.identity())) } "." }
        details {
            summary { "The study" }
            pre tabindex="0" { code { (study.to_toml()) } }
        }
    }
}
