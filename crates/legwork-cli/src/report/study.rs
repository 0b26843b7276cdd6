//! The page of a study: what was asked, how the rollouts ended, and the figures that its design calls for.

use std::collections::BTreeSet;

use legwork::diagnosis::FirstCause;
use legwork::error::Error;
use legwork::study::design::Design;
use legwork::study::results::{Results, Row, SURVIVED, Sensitivity};
use legwork::study::rollout::Column;
use legwork::study::sensitivity::Estimate;
use legwork::study::{Ending, Factor, Level};
use maud::{Markup, html};

use super::charts::axis::Quantity;
use super::charts::bars::{Bar, Bars, Group};
use super::charts::heat_map::HeatMap;
use super::charts::scatter::{Labelled, Scatter};
use super::charts::survival_map::{Cell, CellOutcome, SurvivalMap};
use super::charts::sweep::{Panel, Part, Point, Series, Sweep};
use super::document::{Chapter, Figures, Page, Section, page as document};
use super::tables::number;
use crate::study_summary::{BOOTSTRAP, endings};

/// The page of `results`.
///
/// # Errors
/// The indices cannot be computed from them.
pub(crate) fn page(results: &Results) -> Result<Page, Error> {
    let study = results.study;
    let mut figures = Figures::default();
    let mut chapters = vec![Chapter {
        title: "How the rollouts ended".into(),
        lead: html! {},
        sections: vec![
            Section { title: "Survival".into(), body: survival(results) },
            Section { title: "Causes of the falls".into(), body: causes(results) },
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
            lead: html! { p { "Each combination of levels is one rollout." } },
            sections: maps(results, &mut figures),
        }),
        Design::Grid | Design::LatinHypercube { .. } | Design::SobolSequence { .. } => chapters.push(Chapter {
            title: "Along each factor".into(),
            lead: html! {
                p { "All factors vary at once. Along each one the rollouts are taken together in equal parts of its "
                    "range: the share of them that did not fall, and the median of each figure over those." }
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

const FALL_NOTE: &str = "A cross marks a fall; the figures of a run that fell are not drawn.";

fn survival(results: &Results) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th.left { "scenario" } th { "rollouts" } th { "stood" } th { "fell" } th { "could not be run" } th { "defects" } th { "share that stood" } } }
            tbody {
                @for (number, base) in results.study.bases.iter().enumerate() {
                    @let e = results.endings(number);
                    tr {
                        th scope="row" { (base.name()) }
                        td { (e.rollouts) } td { (e.completed) } td { (e.fell) } td { (e.invalid) } td { (e.failed) }
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

/// A first cause in words.
fn cause_title(label: &str) -> &str {
    FirstCause::LABELS.iter().find(|(known, _)| *known == label).map_or(label, |(_, title)| title)
}

/// A figure with its mean and peak, or a single one.
struct Family {
    label: String,
    unit: &'static str,
    /// Metrics of the study, each with what it is of the figure, or nothing.
    members: Vec<(usize, &'static str)>,
}

/// The study's metrics, mean and peak of the same figure together.
fn families(columns: &[Column]) -> Vec<Family> {
    let mut families: Vec<Family> = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let kind = ["mean", "peak"].into_iter().find(|kind| column.name.ends_with(&format!(".{kind}"))).unwrap_or("");
        let label = column.label.strip_prefix(kind).unwrap_or(&column.label).trim().to_owned();
        match families.iter_mut().find(|family| family.label == label && !kind.is_empty()) {
            Some(family) => family.members.push((index, kind)),
            None => families.push(Family { label, unit: column.unit, members: vec![(index, kind)] }),
        }
    }
    families
}

fn quantity(name: impl Into<String>, unit: &str) -> Quantity {
    Quantity { name: name.into(), unit: unit.into(), log: false }
}

/// The axis of a factor.
fn axis(factor: &Factor) -> Quantity {
    let unit = if factor.relative { "times the base" } else { factor.unit() };
    Quantity { name: factor.title(), unit: unit.into(), log: factor.levels.is_logarithmic() }
}

/// Scenarios whose figures can share an axis: those without pushes, those with.
fn kinds(results: &Results) -> [(&'static str, Vec<usize>); 2] {
    let pushed = |&base: &usize| !results.study.bases[base].variant().scenario.pushes.is_empty();
    let all = 0..results.study.bases.len();
    [
        ("without a push", all.clone().filter(|base| !pushed(base)).collect()),
        ("with a push", all.filter(pushed).collect()),
    ]
}

fn sweeps(results: &Results, figures: &mut Figures) -> Vec<Section> {
    let study = results.study;
    let mut sections = Vec::new();
    for (index, factor) in study.factors.iter().enumerate() {
        let body = html! {
            @for (kind, bases) in kinds(results) {
                @if !bases.is_empty() {
                    @let chart = sweep(results, index, &bases);
                    @let (kind, file) = if study.bases.len() == bases.len() {
                        (String::new(), factor.name.clone())
                    } else {
                        (format!(", {kind}"), format!("{}-{kind}", factor.name))
                    };
                    (figures.add(
                        &file,
                        &format!("The {}{kind}", factor.title()),
                        &marked_note(factor),
                        |width| chart.draw(width),
                    ))
                }
            }
        };
        sections.push(Section { title: factor.title(), body });
    }
    sections
}

fn marked_note(factor: &Factor) -> String {
    match &factor.marked {
        Some((value, what)) => format!("{FALL_NOTE} The dashed line is at {}: {what}.", number(*value)),
        None => FALL_NOTE.to_owned(),
    }
}

/// A factor's sweep in the scenarios `bases`.
pub(super) fn sweep(results: &Results, index: usize, bases: &[usize]) -> Sweep {
    let factor = &results.study.factors[index];
    let rows: Vec<Vec<(Level, &Row)>> = bases.iter().map(|&base| results.sweep(base, index)).collect();
    let texts = rows.iter().flatten().any(|(level, _)| level.number().is_none());
    let categories: Vec<String> =
        if texts { rows[0].iter().map(|(level, _)| level.to_string()).collect() } else { Vec::new() };
    let place = |position: usize, level: &Level| level.number().filter(|_| !texts).unwrap_or(position as f64);
    let series = bases.iter().zip(&rows).map(|(&base, rows)| Series {
        label: results.study.bases[base].name().to_owned(),
        points: rows
            .iter()
            .enumerate()
            .map(|(position, (level, row))| Point { x: place(position, level), fell: row.ending == Ending::Fell })
            .collect(),
    });
    let values = |metric: usize| -> Vec<Vec<f64>> {
        rows.iter().map(|rows| rows.iter().map(|(_, row)| row.metrics[metric].unwrap_or(f64::NAN)).collect()).collect()
    };
    let panels = families(&results.columns).into_iter().map(|Family { label, unit, members }| Panel {
        parts: members
            .into_iter()
            .map(|(metric, kind)| Part {
                y: quantity(if kind.is_empty() { label.as_str() } else { kind }, unit),
                values: values(metric),
            })
            .collect(),
        title: label,
    });
    Sweep {
        x: axis(factor),
        categories,
        marked: factor.marked.clone().filter(|_| !texts),
        series: series.collect(),
        panels: panels.collect(),
    }
}

/// The name of a metric as a figure's label.
fn metric_label(results: &Results, name: &str) -> String {
    match results.columns.iter().find(|column| column.name == name) {
        Some(column) => column.label.clone(),
        None => name.to_owned(),
    }
}

fn sobol(results: &Results, base: usize, figures: &mut Figures) -> Result<Chapter, Error> {
    let study = results.study;
    let name = study.bases[base].name();
    let factors: Vec<String> = study.factors.iter().map(Factor::title).collect();
    let all = results.sobol(base, &BOOTSTRAP)?;
    let with: Vec<&Sensitivity> = all.iter().filter(|s| s.indices.shares.is_some()).collect();
    let total =
        |row: usize| with.iter().map(move |s| s.indices.shares.as_ref().map_or(f64::NAN, |s| s.total[row].value));
    let overview = HeatMap {
        row_title: String::new(),
        column_title: String::new(),
        rows: factors.clone(),
        columns: with.iter().map(|s| metric_label(results, &s.metric)).collect(),
        value: quantity("total index", ""),
        cells: (0..factors.len()).map(|row| total(row).collect()).collect(),
        centre: None,
    };
    let mut sections = vec![Section {
        title: "What matters".into(),
        body: figures.add(
            &format!("{name}-total"),
            &format!("Total Sobol' indices, {name}"),
            "The share of a figure's variance that would remain if all other factors were known: the factor's own \
             effect with all its interactions. Of survival itself, and of a figure's rank among all rollouts; falls share \
             the last rank.",
            |width| overview.draw(width),
        ),
    }];
    for sensitivity in with {
        let Some(shares) = &sensitivity.indices.shares else { continue };
        let label = metric_label(results, &sensitivity.metric);
        let bars = Bars {
            value: quantity("Sobol' index", ""),
            series: vec!["first order".into(), "total".into()],
            interval: format!("{:.0} % interval", 100.0 * BOOTSTRAP.level),
            groups: (factors.iter().zip(&shares.first).zip(&shares.total))
                .map(|((factor, first), total)| Group { label: factor.clone(), bars: vec![bar(first), bar(total)] })
                .collect(),
        };
        let mut cells = vec![vec![f64::NAN; factors.len()]; factors.len()];
        for pair in &shares.second {
            let [a, b] = pair.factors;
            cells[b][a] = pair.index.value;
        }
        let pairs = HeatMap {
            row_title: String::new(),
            column_title: String::new(),
            rows: factors.clone(),
            columns: factors.clone(),
            value: quantity("second-order index", ""),
            cells,
            centre: None,
        };
        let file = format!("{name}-{}", sensitivity.metric);
        let caption = format!(
            "Alone (first order) and with all interactions (total), with bootstrap intervals over {} base samples.",
            sensitivity.indices.used
        );
        let body = html! {
            (figures.add(&file, &format!("Shares of the variance of {label}, {name}"), &caption, |width| bars.draw(width)))
            @if !shares.second.is_empty() {
                (figures.add(
                    &format!("{file}-pairs"),
                    &format!("Pairs of factors in {label}, {name}"),
                    "The share that two factors have together beyond what each has alone; a value below the width of \
                     the intervals is none.",
                    |width| pairs.draw(width),
                ))
            }
        };
        sections.push(Section { title: label, body });
    }
    let flat: Vec<&str> = all.iter().filter(|s| s.indices.shares.is_none()).map(|s| s.metric.as_str()).collect();
    let lead = html! {
        p { (endings(&results.endings(base))) "." }
        @if !flat.is_empty() { p.note { "The same in all rollouts: " (flat.join(", ")) "." } }
    };
    Ok(Chapter { title: name.to_owned(), lead, sections })
}

fn bar(estimate: &Estimate) -> Bar {
    Bar { value: estimate.value, interval: Some([estimate.low, estimate.high]) }
}

fn morris(results: &Results, base: usize, figures: &mut Figures) -> Result<Chapter, Error> {
    let study = results.study;
    let name = study.bases[base].name();
    let mut sections = Vec::new();
    for (metric, effects) in results.morris(base, &BOOTSTRAP)? {
        let label = metric_label(results, &metric);
        let points = study.factors.iter().zip(&effects);
        let chart = Scatter {
            x: quantity("mean absolute effect \u{3bc}*", ""),
            y: quantity("deviation \u{3c3}", ""),
            points: points
                .map(|(factor, effect)| Labelled { label: factor.title(), at: [effect.mu_star.value, effect.sigma] })
                .collect(),
            rays: vec![(1.0, "\u{3c3} = \u{3bc}*".into())],
        };
        let body = figures.add(
            &format!("{name}-{metric}"),
            &format!("Elementary effects on {label}, {name}"),
            "To the right: factors that matter. Above the line: those that do so in curves or together with others. \
             The effects are those of a factor's whole range on survival, or on the figure's rank from 0 to 1 (falls last).",
            |width| chart.draw(width),
        );
        sections.push(Section { title: label, body });
    }
    Ok(Chapter { title: name.to_owned(), lead: html! { p { (endings(&results.endings(base))) "." } }, sections })
}

/// Whether a grid is one of two numbers.
fn is_map(results: &Results) -> bool {
    let numbers = |factor: &Factor| factor.levels.extremes().iter().all(|level| level.number().is_some());
    results.study.factors.len() == 2 && results.study.factors.iter().all(numbers)
}

fn maps(results: &Results, figures: &mut Figures) -> Vec<Section> {
    let study = results.study;
    let mut sections = Vec::new();
    for (number, base) in study.bases.iter().enumerate() {
        let cell = |row: &Row, metric: usize| {
            let levels = study.point(row.index).levels;
            let at = |factor: usize| levels[factor].as_ref().and_then(Level::number).unwrap_or(f64::NAN);
            let outcome = match row.ending {
                Ending::Completed => CellOutcome::Survived(row.metrics[metric].unwrap_or(f64::NAN)),
                _ => CellOutcome::Fell,
            };
            Cell { x: at(0), y: at(1), outcome }
        };
        let body = html! {
            @for (metric, column) in results.columns.iter().enumerate() {
                @let map = SurvivalMap {
                    x: axis(&study.factors[0]),
                    y: axis(&study.factors[1]),
                    shade: Some(quantity(column.label.clone(), column.unit)),
                    cells: results.of(number).iter().filter(|row| could_run(row)).map(|row| cell(row, metric)).collect(),
                };
                (figures.add(
                    &format!("{}-{}", base.name(), column.name),
                    &format!("{}: {}", base.name(), column.label),
                    "Hatched: the robot fell. A dot: it stood, and has no such figure. Nothing: the pair cannot be run.",
                    |width| map.draw(width),
                ))
            }
        };
        sections.push(Section { title: base.name().to_owned(), body });
    }
    sections
}

fn could_run(row: &Row) -> bool {
    matches!(row.ending, Ending::Completed | Ending::Fell)
}

/// Parts that a factor's range is cut into.
const PARTS: usize = 8;

/// Survival and medians in parts of each factor's range.
fn parts(results: &Results, figures: &mut Figures) -> Vec<Section> {
    let study = results.study;
    let mut sections = Vec::new();
    for (index, factor) in study.factors.iter().enumerate() {
        let body = html! {
            @for (kind, bases) in kinds(results) {
                @if !bases.is_empty() {
                    @let chart = binned(results, index, &bases);
                    (figures.add(
                        &format!("{}-{kind}", factor.name),
                        &format!("Along the {}, {kind}", factor.title()),
                        "Survival, and medians of the runs that did not fall.",
                        |width| chart.draw(width),
                    ))
                }
            }
        };
        sections.push(Section { title: factor.title(), body });
    }
    sections
}

fn binned(results: &Results, index: usize, bases: &[usize]) -> Sweep {
    let factor = &results.study.factors[index];
    let extremes = factor.levels.extremes();
    let texts = extremes.iter().any(|level| level.number().is_none()) || factor.levels.is_list();
    let count = if texts { extremes.len() } else { PARTS };
    let middle = |part: usize| factor.levels.at((part as f64 + 0.5) / count as f64);
    let part_of = |level: &Level| {
        (0..count).min_by(|&a, &b| {
            let far = |part: usize| match (middle(part).number(), level.number()) {
                (Some(x), Some(y)) if factor.levels.is_logarithmic() => (x / y).ln().abs(),
                (Some(x), Some(y)) => (x - y).abs(),
                _ => f64::from(u8::from(middle(part) != *level)),
            };
            far(a).total_cmp(&far(b))
        })
    };
    let bins: Vec<Vec<Vec<&Row>>> = bases
        .iter()
        .map(|&base| {
            let mut bins = vec![Vec::new(); count];
            for (level, row) in results.sweep(base, index) {
                bins[part_of(&level).unwrap_or(0)].push(row);
            }
            bins
        })
        .collect();
    let median = |rows: &[&Row], metric: usize| {
        let whole = rows.iter().filter(|row| row.ending == Ending::Completed);
        let mut values: Vec<f64> = whole.filter_map(|row| row.metrics[metric]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let share = |rows: &[&Row]| {
        let stood = rows.iter().filter(|row| row.ending == Ending::Completed).count();
        if rows.is_empty() { f64::NAN } else { stood as f64 / rows.len() as f64 }
    };
    let x = |part: usize| middle(part).number().filter(|_| !texts).unwrap_or(part as f64);
    let mut panels = vec![Panel {
        title: SURVIVED.into(),
        parts: vec![Part {
            y: quantity("share", ""),
            values: bins.iter().map(|bins| bins.iter().map(|rows| share(rows)).collect()).collect(),
        }],
    }];
    panels.extend(results.columns.iter().enumerate().map(|(metric, column)| Panel {
        title: column.label.clone(),
        parts: vec![Part {
            y: quantity("median", column.unit),
            values: bins.iter().map(|bins| bins.iter().map(|rows| median(rows, metric)).collect()).collect(),
        }],
    }));
    Sweep {
        x: axis(factor),
        categories: if texts { extremes.iter().map(Level::to_string).collect() } else { Vec::new() },
        marked: factor.marked.clone().filter(|_| !texts),
        series: bases
            .iter()
            .map(|&base| Series {
                label: results.study.bases[base].name().to_owned(),
                points: (0..count).map(|part| Point { x: x(part), fell: false }).collect(),
            })
            .collect(),
        panels,
    }
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
