//! Which limits of the program were active, and what each task was missed by.

use legwork::control::Fallback;
use legwork::episode::Run;
use legwork::log::Field;
use legwork::qp::{Limit, LimitKind};

use super::chart::{Panel, Row, Series, rows_panel};
use super::figures::{line, panel, plain, side, spans};

/// Rows of active limits and fallbacks, then a panel of slack for each task.
pub(super) fn panels(run: &Run, times: &[f64]) -> Vec<Panel> {
    let mut panels = vec![rows_panel(rows(run, times))];
    panels.extend(slack(run));
    panels
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
            .is_some_and(|contact| forces[contact * d..].iter().take(d).all(|component| component.abs() < 1e-6))
    };
    let sides = run.log.get(index, Field::ActiveLimit).iter().enumerate();
    let sides = sides.filter(|(_, side)| **side != 0.0).map(|(limit, side)| (limit, *side as i8));
    sides.filter(move |(limit, _)| !idle(&run.layout.limits()[*limit]))
}

/// A row for each limit that was ever active, then for each fallback that was ever used.
fn rows(run: &Run, times: &[f64]) -> Vec<Row> {
    let period = run.scenario.controller.period_s;
    let mut sides = vec![vec![0_i8; times.len()]; run.layout.limits().len()];
    for index in 0..times.len() {
        active(run, index).for_each(|(limit, side)| sides[limit][index] = side);
    }
    let share = |ticks: usize| format!("{:.1} %", 100.0 * ticks as f64 / times.len().max(1) as f64);
    let mut rows = Vec::new();
    for (limit, sides) in run.layout.limits().iter().zip(&sides) {
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
        let used = |index: usize| run.log.get(index, Field::Program)[1] as u8 == fallback as u8;
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

/// The size of each task's slack: a panel for each quantity, with a line for each foot where it is about feet.
fn slack(run: &Run) -> Vec<Panel> {
    let norm = |range: std::ops::Range<usize>| -> Vec<f64> {
        let values = run.log.records().map(|record| &record[run.log.range(Field::Slack)][range.clone()]);
        values.map(|values| values.iter().map(|value| value * value).sum::<f64>().sqrt()).collect()
    };
    let mut lines: Vec<(String, Vec<Series>)> = Vec::new();
    for (part, rows) in run.layout.tasks().iter().flat_map(|task| task.parts()) {
        let line = match part.of.as_str() {
            "" => line("slack", "", norm(rows)),
            of => line(&plain(of), if side(of) == "left" { "left dashed" } else { side(of) }, norm(rows)),
        };
        let title = format!("{} [{}]", part.quantity, part.unit.replace("s2", "s²"));
        match lines.iter_mut().find(|(known, _)| *known == title) {
            Some((_, lines)) => lines.push(line),
            None => lines.push((title, vec![line])),
        }
    }
    lines.into_iter().map(|(title, lines)| panel(&title, 86.0, 1.0, lines)).collect()
}
