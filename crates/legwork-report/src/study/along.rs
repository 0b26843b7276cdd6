//! Figures over the levels of a study's factors: sweeps, maps of two factors, parts of each factor's range.

use legwork::study::results::{Results, Row, SURVIVED};
use legwork::study::rollout::Column;
use legwork::study::{Ending, Factor, Level};
use maud::{Markup, html};

use super::{FALL_NOTE, axis, quantity};
use crate::charts::survival_map::{Cell, CellOutcome, SurvivalMap};
use crate::charts::sweep::{Panel, Part, Point, Series, Sweep};
use crate::document::{Figures, Section};
use crate::tables::number;

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

/// Scenarios whose figures can share an axis: those without pushes, those with.
fn kinds(results: &Results) -> [(&'static str, Vec<usize>); 2] {
    let pushed = |&base: &usize| !results.study.bases[base].variant().scenario.pushes.is_empty();
    let all = 0..results.study.bases.len();
    [
        ("without a push", all.clone().filter(|base| !pushed(base)).collect()),
        ("with a push", all.filter(pushed).collect()),
    ]
}

/// A section for each factor, with a `figure` for each kind of scenario that there is.
fn for_each_factor(results: &Results, mut figure: impl FnMut(usize, &str, &[usize]) -> Markup) -> Vec<Section> {
    let mut sections = Vec::new();
    for (index, factor) in results.study.factors.iter().enumerate() {
        let body = html! {
            @for (kind, bases) in kinds(results) {
                @if !bases.is_empty() {
                    (figure(index, kind, &bases))
                }
            }
        };
        sections.push(Section { title: factor.title(), body });
    }
    sections
}

pub(super) fn sweeps(results: &Results, figures: &mut Figures) -> Vec<Section> {
    for_each_factor(results, |index, kind, bases| {
        let factor = &results.study.factors[index];
        let chart = sweep(results, index, bases);
        let (kind, file) = if results.study.bases.len() == bases.len() {
            (String::new(), factor.name.clone())
        } else {
            (format!(", {kind}"), format!("{}-{kind}", factor.name))
        };
        let title = format!("The {}{kind}", factor.title());
        figures.add(&file, &title, &marked_note(factor), |width| chart.draw(width))
    })
}

fn marked_note(factor: &Factor) -> String {
    match &factor.marked {
        Some((value, what)) => format!("{FALL_NOTE} The dashed line is at {}: {what}.", number(*value)),
        None => FALL_NOTE.to_owned(),
    }
}

/// A factor's sweep in the scenarios `bases`.
fn sweep(results: &Results, index: usize, bases: &[usize]) -> Sweep {
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

/// Whether a grid is one of two numbers.
pub(super) fn is_map(results: &Results) -> bool {
    let numbers = |factor: &Factor| factor.levels.extremes().iter().all(|level| level.number().is_some());
    results.study.factors.len() == 2 && results.study.factors.iter().all(numbers)
}

pub(super) fn maps(results: &Results, figures: &mut Figures) -> Vec<Section> {
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

/// A list of more numbers than this is a range too: a part for each would hold a run or two.
const MOST_LISTED: usize = 2 * PARTS;

/// Whether each level of a factor is a part of its own.
fn has_own_parts(factor: &Factor) -> bool {
    let levels = factor.levels.extremes();
    let numbers = levels.iter().all(|level| level.number().is_some());
    !numbers || factor.levels.is_list() && levels.len() <= MOST_LISTED
}

/// Survival and medians in parts of each factor's range.
pub(super) fn parts(results: &Results, figures: &mut Figures) -> Vec<Section> {
    for_each_factor(results, |index, kind, bases| {
        let factor = &results.study.factors[index];
        let chart = binned(results, index, bases);
        let title = format!("Along the {}, {kind}", factor.title());
        let note = "Survival, and medians of the runs that did not fall.";
        figures.add(&format!("{}-{kind}", factor.name), &title, note, |width| chart.draw(width))
    })
}

fn binned(results: &Results, index: usize, bases: &[usize]) -> Sweep {
    let factor = &results.study.factors[index];
    let extremes = factor.levels.extremes();
    let texts = has_own_parts(factor);
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

#[cfg(test)]
mod tests {
    use legwork::study::{Levels, Study};

    use super::*;

    /// A study of `seeds` robots, each of which fell but for those of the first half.
    fn chart(seeds: usize) -> Sweep {
        let list: Vec<String> = (0..seeds).map(|seed| seed.to_string()).collect();
        let text = format!(
            "scenarios = [\"stand\"]\ndesign = \"latin-hypercube\"\nsamples = {seeds}\nmetrics = [\"torque_nm.mean\"]\n\
             [[factors]]\npath = \"seed\"\nlist = [{}]\n",
            list.join(", ")
        );
        let study = Study::parse(&text, "t.toml", None, &[]).expect("a study");
        let level = |index: u64| match study.point(index).levels[0] {
            Some(Level::Number(level)) => level,
            _ => panic!("a number"),
        };
        let row = |index: u64| {
            let stood = level(index) < 0.5 * seeds as f64;
            let ending = if stood { Ending::Completed } else { Ending::Fell };
            Row { index, ending, fell_at_s: None, cause: None, metrics: vec![Some(level(index))] }
        };
        assert!(matches!(study.factors[0].levels, Levels::List(_)));
        let columns = study.columns().into_iter().filter(|column| column.name == "torque_nm.mean").collect();
        binned(&Results { study: &study, rows: (0..study.len()).map(row).collect(), columns }, 0, &[0])
    }

    #[test]
    fn a_short_list_has_a_part_for_each_level_and_a_long_one_is_cut_like_a_range() {
        let short = chart(10);
        assert_eq!((short.categories.len(), short.series[0].points.len()), (10, 10));
        let long = chart(200);
        assert_eq!((long.categories.len(), long.series[0].points.len()), (0, PARTS));
        let survival = &long.panels[0].parts[0].values[0];
        assert_eq!(survival[..], [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        // Medians are of the seeds themselves: those of a part lie around its middle.
        for (point, median) in long.series[0].points.iter().zip(&long.panels[1].parts[0].values[0]).take(PARTS / 2) {
            assert!((point.x - median).abs() <= 2.0, "{} {median}", point.x);
        }
    }
}
