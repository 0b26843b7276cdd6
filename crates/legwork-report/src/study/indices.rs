//! Figures of a study's indices: Sobol' shares of the variance, elementary effects.

use legwork::error::Error;
use legwork_study::Factor;
use legwork_study::results::{Results, Sensitivity};
use legwork_study::sensitivity::{Effects, Estimate, Indices};
use maud::{Markup, html};

use super::{BOOTSTRAP, endings, range};
use crate::charts::axis::{Axis, Quantity};
use crate::charts::bars::{Bar, Bars, Group};
use crate::charts::chart::{Chart, Part};
use crate::charts::labels::Labelled;
use crate::charts::layer::Layer;
use crate::charts::map::HeatMap;
use crate::document::{Chapter, Figures, Section};

/// The name of a metric as a figure's label.
fn metric_label(results: &Results, name: &str) -> String {
    match results.columns.iter().find(|column| column.name == name) {
        Some(column) => column.label.clone(),
        None => name.to_owned(),
    }
}

pub(super) fn sobol(results: &Results, base: usize, figures: &mut Figures) -> Result<Chapter, Error> {
    let study = results.study;
    let name = study.bases[base].name();
    let factors: Vec<String> = study.factors.iter().map(Factor::title).collect();
    let all = results.sobol(base, &BOOTSTRAP)?;
    let with: Vec<&Sensitivity<Indices>> = all.iter().filter(|s| s.found.shares.is_some()).collect();
    let total = |row: usize| with.iter().map(move |s| s.found.shares.as_ref().map_or(f64::NAN, |s| s.total[row].value));
    let overview = HeatMap {
        row_title: String::new(),
        column_title: String::new(),
        rows: factors.clone(),
        columns: with.iter().map(|s| metric_label(results, &s.metric)).collect(),
        value: Quantity::new("total index", ""),
        cells: (0..factors.len()).map(|row| total(row).collect()).collect(),
        centre: None,
        doubtful: Vec::new(),
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
        let Some(shares) = &sensitivity.found.shares else { continue };
        let label = metric_label(results, &sensitivity.metric);
        let bars = Bars {
            value: Quantity::new("Sobol' index", ""),
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
            value: Quantity::new("second-order index", ""),
            cells,
            centre: None,
            doubtful: Vec::new(),
        };
        let file = format!("{name}-{}", sensitivity.metric);
        let caption = format!(
            "Alone (first order) and with all interactions (total), with bootstrap intervals over {} base samples.{}",
            sensitivity.found.used,
            range_of(results, base, &sensitivity.metric)
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
    let flat = all.iter().filter(|s| s.found.shares.is_none()).map(|s| s.metric.as_str());
    Ok(Chapter { title: name.to_owned(), lead: lead(results, base, flat.collect()), sections })
}

/// How the rollouts ended, and the figures that are the same in all of them.
fn lead(results: &Results, base: usize, flat: Vec<&str>) -> Markup {
    html! {
        p { (endings(&results.endings(base))) "." }
        @if !flat.is_empty() { p.note { "The same in all rollouts: " (flat.join(", ")) "." } }
    }
}

/// The range of a metric as a sentence; nothing for survival.
fn range_of(results: &Results, base: usize, metric: &str) -> String {
    let found = results.range(base, metric);
    found.map_or(String::new(), |found| format!(" The figure: {} {}.", range(&found), found.column.unit))
}

fn bar(estimate: &Estimate) -> Bar {
    Bar { value: estimate.value, interval: Some([estimate.low, estimate.high]) }
}

pub(super) fn morris(results: &Results, base: usize, figures: &mut Figures) -> Result<Chapter, Error> {
    let study = results.study;
    let name = study.bases[base].name();
    let mut sections = Vec::new();
    let all = results.morris(base, &BOOTSTRAP)?;
    for sensitivity in &all {
        let (metric, Some(effects)) = (&sensitivity.metric, &sensitivity.found) else { continue };
        let label = metric_label(results, metric);
        let at = |effect: &Effects| [effect.mu_star.value, effect.sigma];
        let points = study.factors.iter().zip(effects);
        let points = points.map(|(factor, effect)| Labelled { label: factor.title(), at: at(effect) }).collect();
        let [far, high] = [0, 1].map(|k| effects.iter().map(|effect| at(effect)[k]).fold(0.0, f64::max));
        let ray = vec![[0.0, 0.0], [far.min(high), far.min(high)]];
        let layers = vec![Layer::line("\u{3c3} = \u{3bc}*", "marked", ray), Layer::Labelled(points)];
        let x = Axis::near_zero(Quantity::new("mean absolute effect \u{3bc}*", ""), [0.0, far]);
        let chart = Chart::of(x, Part::new(Quantity::new("deviation \u{3c3}", ""), 330.0, layers));
        let caption = "To the right: factors that matter. Above the line: those that do so in curves or together with others. \
             The effects are those of a factor's whole range on survival, or on the figure's rank from 0 to 1 (falls last).";
        let caption = format!("{caption}{}", range_of(results, base, metric));
        let title = format!("Elementary effects on {label}, {name}");
        let body = figures.add(&format!("{name}-{metric}"), &title, &caption, |width| chart.draw(width));
        sections.push(Section { title: label, body });
    }
    let flat = all.iter().filter(|s| s.found.is_none()).map(|s| s.metric.as_str());
    Ok(Chapter { title: name.to_owned(), lead: lead(results, base, flat.collect()), sections })
}
