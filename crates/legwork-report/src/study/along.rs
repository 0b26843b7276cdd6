//! Figures over the levels of a study's factors: sweeps, maps of two factors, parts of each factor's range.

use legwork_study::results::{Results, Row, SURVIVED};
use legwork_study::rollout::Column;
use legwork_study::{Ending, Factor, Level};
use maud::{Markup, html};

use super::{FALL_NOTE, axis};
use crate::charts::axis::Quantity;
use crate::charts::map::{Holds, SurvivalMap};
use crate::charts::numbers::number;
use crate::charts::sweep::{Panel, Part, Point, Series, Sweep};
use crate::document::{Figures, Section};

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

/// A section for each varied factor, with a `figure` for each kind of scenario that there is.
fn for_each_factor(results: &Results, mut figure: impl FnMut(usize, &str, &[usize]) -> Markup) -> Vec<Section> {
    let mut sections = Vec::new();
    for (index, factor) in varied(results) {
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
            .map(|(position, (level, row))| Point {
                x: place(position, level),
                fell: row.ending == Ending::Fell,
                doubtful: row.is_doubtful,
            })
            .collect(),
    });
    let values = |metric: usize| -> Vec<Vec<f64>> {
        rows.iter().map(|rows| rows.iter().map(|(_, row)| row.metrics[metric].unwrap_or(f64::NAN)).collect()).collect()
    };
    let panels = families(&results.columns).into_iter().map(|Family { label, unit, members }| Panel {
        parts: members
            .into_iter()
            .map(|(metric, kind)| {
                Part::new(Quantity::new(if kind.is_empty() { label.as_str() } else { kind }, unit), values(metric))
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

/// Whether the levels of a factor repeat a run with other chance, so that they are taken together.
pub(super) fn is_replicate(factor: &Factor) -> bool {
    factor.paths == ["seed"]
}

/// The factors that are not replicates, by number; all of them where nothing else is varied.
pub(super) fn varied<'s>(results: &Results<'s>) -> Vec<(usize, &'s Factor)> {
    let all = || results.study.factors.iter().enumerate();
    let varied: Vec<_> = all().filter(|(_, factor)| !is_replicate(factor)).collect();
    if varied.is_empty() { all().collect() } else { varied }
}

/// Whether a grid is one of two numbers, replicates aside.
pub(super) fn is_map(results: &Results) -> bool {
    let numbers = |factor: &Factor| factor.levels.extremes().iter().all(|level| level.number().is_some());
    let varied = varied(results);
    varied.len() == 2 && varied.iter().all(|(_, factor)| numbers(factor))
}

/// A map of survival where there are replicates, and one of each figure's median over those that stood.
pub(super) fn maps(results: &Results, figures: &mut Figures) -> Vec<Section> {
    let study = results.study;
    let factors = varied(results);
    let repeated = factors.len() < study.factors.len();
    let mut sections = Vec::new();
    for (number, base) in study.bases.iter().enumerate() {
        let mut pairs: Vec<([f64; 2], Vec<&Row>)> = Vec::new();
        for row in results.of(number).iter().filter(|row| could_run(row)) {
            let levels = study.point(row.index).levels;
            let at = [0, 1].map(|k| levels[factors[k].0].as_ref().and_then(Level::number).unwrap_or(f64::NAN));
            match pairs.iter_mut().find(|(known, _)| *known == at) {
                Some((_, rows)) => rows.push(row),
                None => pairs.push((at, vec![row])),
            }
        }
        let map = |shade: Quantity, of: &dyn Fn(&[&Row]) -> f64| SurvivalMap {
            x: axis(factors[0].1),
            y: axis(factors[1].1),
            shade: Some(shade),
            cells: pairs
                .iter()
                .map(|(at, rows)| (*at, if survival(rows) > 0.0 { Holds::Value(of(rows)) } else { Holds::Fell }))
                .collect(),
            doubtful: pairs.iter().filter(|(_, rows)| any_doubtful(rows)).map(|(at, _)| *at).collect(),
        };
        let mut maps = Vec::new();
        if repeated {
            let all = "Hatched: the robot fell in all repetitions.";
            maps.push((
                SURVIVED.to_owned(),
                "share that stood".to_owned(),
                all,
                map(Quantity::new("share that stood", ""), &survival),
            ));
        }
        for (metric, column) in results.columns.iter().enumerate() {
            let (label, note) = if repeated {
                (
                    format!("{}, median", column.label),
                    "The median of the repetitions in which the robot stood. Hatched: it fell in all of them.",
                )
            } else {
                (
                    column.label.clone(),
                    "Hatched: the robot fell. A dot: it stood, and has no such figure. Nothing: the pair cannot be run.",
                )
            };
            let of = |rows: &[&Row]| quantile(&values(rows, metric), 0.5);
            maps.push((column.name.clone(), label.clone(), note, map(Quantity::new(label, column.unit), &of)));
        }
        let drawn = maps.into_iter().map(|(name, label, note, map)| {
            figures.add(&format!("{}-{name}", base.name()), &format!("{}: {label}", base.name()), note, |width| {
                map.draw(width)
            })
        });
        let drawn: Vec<Markup> = drawn.collect();
        sections.push(Section { title: base.name().to_owned(), body: html! { @for figure in drawn { (figure) } } });
    }
    sections
}

/// Whether one of them broke bounds of the simulation.
fn any_doubtful(rows: &[&Row]) -> bool {
    rows.iter().any(|row| row.is_doubtful)
}

fn could_run(row: &Row) -> bool {
    row.ending.stood() || row.ending == Ending::Fell
}

/// The share of `rows` in which the robot stood.
fn survival(rows: &[&Row]) -> f64 {
    let stood = rows.iter().filter(|row| row.ending.stood()).count();
    if rows.is_empty() { f64::NAN } else { stood as f64 / rows.len() as f64 }
}

/// The values of a metric of the rows in which the robot stood, in order.
fn values(rows: &[&Row], metric: usize) -> Vec<f64> {
    let whole = rows.iter().filter(|row| row.ending.stood());
    let mut values: Vec<f64> = whole.filter_map(|row| row.metrics[metric]).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The value below which a share of `sorted` lies; not a number where there are none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1) as f64;
    sorted.get((share * last).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Parts that a factor's range is cut into.
const PARTS: usize = 8;

/// A list of more numbers than this is a range too: a part for each would hold a run or two.
const MOST_LISTED: usize = 2 * PARTS;

/// Survival, medians, quartiles and extremes at the levels of each factor, or in parts of its range.
pub(super) fn parts(results: &Results, figures: &mut Figures) -> Vec<Section> {
    for_each_factor(results, |index, kind, bases| {
        let factor = &results.study.factors[index];
        let chart = binned(results, index, bases);
        let title = format!("Along the {}, {kind}", factor.title());
        let note = "The share of the runs that did not fall; of those the median of each figure, the middle half, and from the \
                    least to the greatest.";
        figures.add(&format!("{}-{kind}", factor.name), &title, note, |width| chart.draw(width))
    })
}

fn binned(results: &Results, index: usize, bases: &[usize]) -> Sweep {
    let factor = &results.study.factors[index];
    let extremes = factor.levels.extremes();
    let texts = extremes.iter().any(|level| level.number().is_none());
    let own_parts = texts || factor.levels.is_list() && extremes.len() <= MOST_LISTED;
    let count = if own_parts { extremes.len() } else { PARTS };
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
    let shares = bins.iter().map(|bins| bins.iter().map(|rows| survival(rows)).collect()).collect();
    let mut panels = vec![Panel { title: SURVIVED.into(), parts: vec![Part::of_shares(shares)] }];
    panels.extend(results.columns.iter().enumerate().map(|(metric, column)| {
        let sorted: Vec<Vec<Vec<f64>>> =
            bins.iter().map(|bins| bins.iter().map(|rows| values(rows, metric)).collect()).collect();
        let part = Part {
            covers: None,
            y: Quantity::new("median", column.unit),
            values: sorted.iter().map(|bins| bins.iter().map(|values| quantile(values, 0.5)).collect()).collect(),
            spreads: sorted
                .iter()
                .map(|bins| {
                    bins.iter().map(|values| [0.0, 0.25, 0.75, 1.0].map(|share| quantile(values, share))).collect()
                })
                .collect(),
        };
        Panel { title: column.label.clone(), parts: vec![part] }
    }));
    let x = |part: usize| middle(part).number().filter(|_| !texts).unwrap_or(part as f64);
    Sweep {
        x: axis(factor),
        categories: if texts { extremes.iter().map(Level::to_string).collect() } else { Vec::new() },
        marked: factor.marked.clone().filter(|_| !texts),
        series: bases
            .iter()
            .zip(&bins)
            .map(|(&base, bins)| Series {
                label: results.study.bases[base].name().to_owned(),
                points: (0..count)
                    .map(|part| Point { x: x(part), fell: false, doubtful: any_doubtful(&bins[part]) })
                    .collect(),
            })
            .collect(),
        panels,
    }
}

#[cfg(test)]
mod tests {
    use legwork_study::{Levels, Study};

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
            Row { index, ending, fell_at_s: None, cause: None, is_doubtful: false, metrics: vec![Some(level(index))] }
        };
        assert!(matches!(study.factors[0].levels, Levels::List(_)));
        let columns = study.columns().into_iter().filter(|column| column.name == "torque_nm.mean").collect();
        binned(&Results { study: &study, rows: (0..study.len()).map(row).collect(), columns }, 0, &[0])
    }

    #[test]
    fn a_short_list_has_a_part_for_each_level_and_a_long_one_is_cut_like_a_range() {
        let short = chart(10);
        assert_eq!((short.categories.len(), short.series[0].points.len()), (0, 10));
        let long = chart(200);
        assert_eq!((long.categories.len(), long.series[0].points.len()), (0, PARTS));
        let survival = &long.panels[0].parts[0].values[0];
        assert_eq!(survival[..], [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        // Medians are of the seeds themselves: those of a part lie around its middle.
        for (point, median) in long.series[0].points.iter().zip(&long.panels[1].parts[0].values[0]).take(PARTS / 2) {
            assert!((point.x - median).abs() <= 2.0, "{} {median}", point.x);
        }
    }

    #[test]
    fn seeds_are_repetitions_along_the_speed() {
        let text = "scenarios = [\"feet-walk\"]\ndesign = \"grid\"\nmetrics = [\"torque_nm.mean\"]\n\
                    [[factors]]\nname = \"speed\"\npath = \"reference.walker.speed_mps\"\nlist = [0.0, 0.5, 1.0]\n\
                    [[factors]]\npath = \"seed\"\nlist = [0, 1, 2, 3, 4]\n";
        let study = Study::parse(text, "t.toml", None, &[]).expect("a study");
        let row = |index: u64| {
            let levels = study.point(index).levels;
            let [speed, seed] = [0, 1].map(|k| levels[k].as_ref().and_then(Level::number).expect("a number"));
            let ending = if speed > 0.9 && seed > 2.5 { Ending::Fell } else { Ending::Completed };
            Row {
                index,
                ending,
                fell_at_s: None,
                cause: None,
                is_doubtful: false,
                metrics: vec![Some(10.0 * speed + seed)],
            }
        };
        let columns = study.columns().into_iter().filter(|column| column.name == "torque_nm.mean").collect();
        let results = Results { study: &study, rows: (0..study.len()).map(row).collect(), columns };
        assert!(!is_map(&results), "speed alone is a factor");
        let sweep = binned(&results, 0, &[0]);
        let [survival, torque] = &sweep.panels[..] else { panic!("one figure, and survival") };
        assert_eq!(sweep.series[0].points.iter().map(|point| point.x).collect::<Vec<_>>(), [0.0, 0.5, 1.0]);
        assert_eq!(survival.parts[0].values, [[1.0, 1.0, 0.6]]);
        assert_eq!(torque.parts[0].values, [[2.0, 7.0, 11.0]]);
        assert_eq!(torque.parts[0].spreads, [[[0.0, 1.0, 3.0, 4.0], [5.0, 6.0, 8.0, 9.0], [10.0, 11.0, 12.0, 12.0]]]);
        let page = super::super::page(&results).expect("a page").html;
        assert!(page.contains("area s0 quartiles") && page.contains("speed [m/s]"));
        assert!(page.contains("run with 5 seeds") && !page.contains("<h3>seed"));
    }
}
