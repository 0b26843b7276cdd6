//! Which limits of the program were active, and what each task was missed by.

use legwork::control::Fallback;
use legwork::episode::Run;
use legwork::log::Field;
use legwork::momentum::{Limit, LimitKind};

use super::figures::{dashed, foot_name, line, part, plain, side, spans};
use crate::charts::axis::Axis;
use crate::charts::chart::Part;
use crate::charts::layer::Layer;

/// When something was the case.
struct Row {
    label: String,
    /// As a share of the time.
    note: String,
    /// From when to when [s], at which side: −1 below, 1 above, 0 both.
    spans: Vec<([f64; 2], i8)>,
    class: &'static str,
}

/// Height of a row [px].
const ROW: f64 = 17.0;

/// Rows of active limits and fallbacks, then a part of slack for each task.
pub(super) fn parts(run: &Run, times: &[f64]) -> Vec<Part> {
    let rows = rows(run, times);
    let names = rows.iter().map(|row| row.label.clone()).collect();
    let notes = rows.iter().enumerate().map(|(row, Row { note, .. })| (row as f64, note.clone())).collect();
    let height = ROW * rows.len() as f64;
    let layers = rows.into_iter().enumerate().map(|(row, Row { spans, class, .. })| Layer::Row { class, row, spans });
    let mut parts = vec![Part { y: Axis::of_texts("", names), height, layers: layers.collect(), notes }];
    parts.extend(slack(run, times));
    parts
}

/// The limits that are active in record `index`, with their side. Those of a contact whose force the program holds at
/// zero are left out: they say no more than that the foot swings.
pub(super) fn active(run: &Run, index: usize) -> impl Iterator<Item = (usize, i8)> + '_ {
    let d = run.model.linear_axes().len();
    let forces = run.log.get(index, Field::Grf);
    let idle = move |limit: &Limit| {
        limit
            .kind
            .contact()
            .and_then(|contact| forces.get(contact * d..(contact + 1) * d))
            .is_some_and(|force| force.iter().all(|component| component.abs() < 1e-6))
    };
    let sides = run.log.get(index, Field::ActiveLimit).iter().enumerate();
    let sides = sides.filter(|(_, side)| **side != 0.0).map(|(limit, side)| (limit, *side as i8));
    sides.filter(move |(limit, _)| !idle(&run.limits[*limit]))
}

/// A row for each limit that was ever active, then for each fallback that was ever used.
fn rows(run: &Run, times: &[f64]) -> Vec<Row> {
    let period = run.scenario.controller.period_s;
    let mut sides = vec![vec![0_i8; times.len()]; run.limits.len()];
    for index in 0..times.len() {
        active(run, index).for_each(|(limit, side)| sides[limit][index] = side);
    }
    let share = |ticks: usize| format!("{:.1} %", 100.0 * ticks as f64 / times.len().max(1) as f64);
    let mut rows = Vec::new();
    for (limit, sides) in run.limits.iter().zip(&sides) {
        let ticks = sides.iter().filter(|side| **side != 0).count();
        if ticks > 0 {
            let class = match limit.kind {
                LimitKind::Unloading { .. } => "force",
                kind => kind.quantity(),
            };
            let at = |side: i8| spans(times, period, |index| sides[index] == side).into_iter().map(move |s| (s, side));
            let spans = at(-1).chain(at(1)).collect();
            let label = plain(&limit.in_words(&run.model)).replace(" -", " \u{2212}");
            rows.push(Row { label, note: share(ticks), spans, class });
        }
    }
    for fallback in Fallback::ALL.into_iter().filter(|&fallback| fallback != Fallback::None) {
        let used = |index: usize| run.log.get(index, Field::Program).get(1) == Some(&f64::from(fallback as u8));
        let ticks = (0..times.len()).filter(|&index| used(index)).count();
        if ticks > 0 {
            let spans = spans(times, period, used).into_iter().map(|span| (span, 0)).collect();
            rows.push(Row { label: fallback.describe().into(), note: share(ticks), spans, class: "fallback" });
        }
    }
    if rows.is_empty() {
        rows.push(Row { label: "no limit".into(), note: share(0), spans: Vec::new(), class: "force" });
    }
    rows
}

/// The size of each task's slack: a part for each quantity, with a line for each foot where it is about feet.
fn slack(run: &Run, times: &[f64]) -> Vec<Part> {
    let norm = |label: &str, class: &str, rows: std::ops::Range<usize>| {
        let size = |index: usize| {
            let values = &run.log.get(index, Field::Slack)[rows.clone()];
            values.iter().map(|value| value * value).sum::<f64>().sqrt()
        };
        line(label, class, times, (0..run.log.len()).map(size))
    };
    let mut parts: Vec<((&str, String), Vec<Layer>)> = Vec::new();
    let tasks = run.tasks.iter().filter(|_| run.log.has(Field::Slack));
    for (part, rows) in tasks.flat_map(|task| task.parts()) {
        let line = match part.of.as_str() {
            "" => norm("slack", "", rows),
            of => norm(&foot_name(of), dashed(side(of)), rows),
        };
        let title = (part.quantity, part.unit.replace("s2", "s\u{b2}"));
        match parts.iter_mut().find(|(known, _)| *known == title) {
            Some((_, lines)) => lines.push(line),
            None => parts.push((title, vec![line])),
        }
    }
    parts.into_iter().map(|((name, unit), lines)| part(name, &unit, 86.0, 1.0, lines)).collect()
}
