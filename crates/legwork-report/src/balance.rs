//! Balance over time: where the forces act and would have to act, the XcoM and its margin, and from where a stop is possible
//! in how many steps. All places are drawn from the centre of mass, which moves on while they do not go far from it.

use legwork::balance::{Measures, Meter};
use legwork::episode::Run;
use legwork::log::Field;

use super::chart::{Area, Content, Panel, Series};
use super::figures::{line, panel};
use super::scale::{self, Axis};

/// The regions that are drawn, the widest first: steps, in words, class. One covers the other.
const REGIONS: [(Option<u32>, &str, &str); 4] = [
    (None, "any number of steps", "capture-any"),
    (Some(2), "two steps", "capture-2"),
    (Some(1), "one step", "capture-1"),
    (Some(0), "no step: base of support", "capture-0"),
];

/// The measures of a run's records, and what is drawn of them.
#[derive(Debug)]
pub(super) struct Balance<'a> {
    times: &'a [f64],
    /// Place of the centre of mass [m].
    com: Vec<f64>,
    measures: Vec<Measures>,
    zmps: Vec<Option<f64>>,
}

impl<'a> Balance<'a> {
    pub(super) fn new(run: &Run, times: &'a [f64]) -> Self {
        let meter = Meter::new(&run.scenario, &run.model);
        Self {
            times,
            com: (0..times.len()).map(|index| run.log.get(index, Field::Com)[0]).collect(),
            measures: (0..times.len()).map(|index| meter.at(&run.log, index)).collect(),
            zmps: meter.zmps(&run.model, &run.log),
        }
    }

    /// Centre of pressure, zero-moment points, pivot and XcoM around the base of support; then the XcoM's margin to it.
    pub(super) fn points(&self) -> Vec<Panel> {
        let support = self.region(Some(0), "base of support", "support");
        let xcom = || self.line("XcoM", "xcom", |m| Some(m.xcom));
        let cop = || self.line("CoP", "cop", |m| m.cop);
        let zmp = line("ZMP", "zmp dashed", self.relative(|index| self.zmps[index]));
        let wanted = self.line("ZMP that the planner wants", "wanted", |m| m.wanted_zmp);
        let cmp = self.line("CMP", "cmp", |m| m.cmp);
        let near = around("CoP, ZMP and XcoM from CoM [m]", [all(&xcom()), all(&cop())], &support);
        let far = around("CMP and wanted ZMP from CoM [m]", [most(&cmp), most(&wanted)], &support);
        let margin = self.measures.iter().map(|m| m.margin().unwrap_or(f64::NAN)).collect();
        vec![
            lines(near, 210.0, vec![cop(), zmp, xcom()], vec![support.clone()]),
            lines(far, 210.0, vec![cop(), wanted, cmp], vec![support]),
            panel("margin of the XcoM [m]", 120.0, 0.1, vec![line("XcoM", "xcom", margin)]),
        ]
    }

    /// The XcoM in the regions from which a stop is possible.
    pub(super) fn capture(&self) -> Vec<Panel> {
        let regions: Vec<Area> =
            REGIONS.iter().map(|&(steps, label, class)| self.region(steps, label, class)).collect();
        let xcom = self.line("XcoM", "xcom bold", |m| Some(m.xcom));
        let axis = around("XcoM from CoM [m]", [all(&xcom)], &regions[2]);
        vec![lines(axis, 260.0, vec![xcom], regions)]
    }

    fn line(&self, label: &str, class: &str, place: impl Fn(&Measures) -> Option<f64>) -> Series {
        line(label, class, self.relative(|index| place(&self.measures[index])))
    }

    /// A place in each record, from the centre of mass; a gap where there is none.
    fn relative(&self, place: impl Fn(usize) -> Option<f64>) -> Vec<f64> {
        (0..self.times.len()).map(|index| place(index).map_or(f64::NAN, |x| x - self.com[index])).collect()
    }

    /// The places of the XcoM from which `steps` are enough, while there is a support.
    fn region(&self, steps: Option<u32>, label: &'static str, class: &'static str) -> Area {
        let mut pieces = vec![Vec::new()];
        for (index, measures) in self.measures.iter().enumerate() {
            match measures.capture.map(|capture| capture.region(steps)) {
                Some([low, high]) => {
                    let place = [self.times[index], low - self.com[index], high - self.com[index]];
                    pieces.last_mut().expect("there is always one").push(place);
                }
                None => pieces.push(Vec::new()),
            }
        }
        pieces.retain(|piece| piece.len() > 1);
        Area { label, class, pieces }
    }
}

/// What all values of a line cover.
fn all(series: &Series) -> Option<(f64, f64)> {
    scale::extent(series.values.iter().copied())
}

/// What nine tenths of the values of a line cover: impacts throw some far out.
fn most(series: &Series) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = series.values.iter().copied().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let rest = values.len() / 20;
    Some((*values.get(rest)?, *values.get(values.len() - 1 - rest)?))
}

/// An axis around what lines cover, and an area.
fn around<const N: usize>(label: &str, covered: [Option<(f64, f64)>; N], area: &Area) -> Axis {
    let ends = area.pieces.iter().flatten().flat_map(|[_, low, high]| [*low, *high]);
    Axis::around(label, covered.into_iter().flatten().flat_map(|(low, high)| [low, high]).chain(ends), 0.1, 5)
}

fn lines(left: Axis, height: f64, series: Vec<Series>, areas: Vec<Area>) -> Panel {
    Panel {
        height,
        content: Content::Lines { left, right: None, series, areas, limits: Vec::new(), note: String::new() },
    }
}
