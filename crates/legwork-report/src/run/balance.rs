//! Balance over time: where the forces act and would have to act, the XcoM and its margin, and from where a stop is possible
//! in how many steps, along the walking direction, and the XcoM's margin to the nearest edge of the base of support. All places are drawn from the centre of mass, which moves on while they do not go far from it.

use legwork::balance::support::along;
use legwork::balance::{Capture, Measures, Meter, Point};
use legwork::episode::Run;
use legwork::log::Field;

use super::figures::{line, part};
use crate::charts::axis::{Axis, Quantity};
use crate::charts::chart::Part;
use crate::charts::layer::Layer;
use crate::charts::numbers::extent;

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
    /// The walking direction at the begin, a horizontal unit vector.
    ahead: Point,
    /// Place of the centre of mass along it [m].
    com: Vec<f64>,
    measures: Vec<Measures>,
    /// Support and capturability along it.
    captures: Vec<Option<Capture>>,
    zmps: Vec<Option<Point>>,
}

impl<'a> Balance<'a> {
    pub(super) fn new(run: &Run, times: &'a [f64]) -> Self {
        let mut meter = Meter::new(&run.scenario, &run.model);
        let zmps = meter.zmps(&run.model, &run.log);
        let ahead = if times.is_empty() { [1.0, 0.0] } else { meter.ahead(|field| run.log.get(0, field)) };
        let com = |index: usize| run.log.get(index, Field::Com);
        let capture = |index: usize| meter.capture_along(|field| run.log.get(index, field), ahead);
        Self {
            times,
            ahead,
            com: (0..times.len()).map(|index| along(ahead, [com(index)[0], com(index)[1]])).collect(),
            captures: (0..times.len()).map(capture).collect(),
            measures: (0..times.len()).map(|index| meter.at(&run.log, index)).collect(),
            zmps,
        }
    }

    /// Centre of pressure, zero-moment points, pivot and XcoM around the base of support; then the XcoM's margin to it.
    pub(super) fn points(&self) -> Vec<Part> {
        let support = || self.region(Some(0), "base of support", "support");
        let xcom = || self.line("XcoM", "xcom", |m| Some(m.xcom));
        let cop = || self.line("CoP", "cop", |m| m.cop);
        let zmp = line("ZMP", "zmp dashed", self.times, self.relative(|index| self.zmps[index]));
        let wanted = self.line("ZMP that the planner wants", "wanted", |m| m.wanted_zmp);
        let cmp = self.line("CMP", "cmp dotted", |m| m.cmp);
        let near = around("CoP, ZMP and XcoM from CoM", [all(&xcom()), all(&cop())], &support());
        let far = around("CMP and wanted ZMP from CoM", [most(&cmp), most(&wanted)], &support());
        let margin = self.measures.iter().map(|m| m.margin().unwrap_or(f64::NAN));
        // A controller without a plan has none of its points.
        let lines = |y: Axis, mut layers: Vec<Layer>| {
            layers.retain(|layer| all(layer).is_some());
            Part { y, height: 210.0, layers, notes: Vec::new() }
        };
        vec![
            lines(near, vec![support(), cop(), zmp, xcom()]),
            lines(far, vec![support(), cop(), wanted, cmp]),
            part("margin of the XcoM", "m", 120.0, 0.1, vec![line("XcoM", "xcom", self.times, margin)]),
        ]
    }

    /// The XcoM in the regions from which a stop is possible.
    pub(super) fn capture(&self) -> Vec<Part> {
        let mut layers: Vec<Layer> =
            REGIONS.iter().map(|&(steps, label, class)| self.region(steps, label, class)).collect();
        let xcom = self.line("XcoM", "xcom bold", |m| Some(m.xcom));
        let y = around("XcoM from CoM", [all(&xcom)], &layers[2]);
        layers.push(xcom);
        vec![Part { y, height: 260.0, layers, notes: Vec::new() }]
    }

    fn line(&self, label: &str, class: &str, place: impl Fn(&Measures) -> Option<Point>) -> Layer {
        line(label, class, self.times, self.relative(|index| place(&self.measures[index])))
    }

    /// A place in each record, from the centre of mass; a gap where there is none.
    fn relative(&self, place: impl Fn(usize) -> Option<Point>) -> Vec<f64> {
        (0..self.times.len())
            .map(|index| place(index).map_or(f64::NAN, |place| along(self.ahead, place) - self.com[index]))
            .collect()
    }

    /// The places of the XcoM from which `steps` are enough, while there is a support.
    fn region(&self, steps: Option<u32>, label: &str, class: &str) -> Layer {
        let point = |(index, capture): (usize, &Option<Capture>)| {
            let region = capture.map_or([f64::NAN; 2], |capture| capture.region(steps));
            let [low, high] = region.map(|end| end - self.com[index]);
            [self.times[index], low, high]
        };
        let points = self.captures.iter().enumerate().map(point).collect();
        Layer::Area { class: class.to_owned(), label: label.to_owned(), points }
    }
}

/// What all values of a layer cover.
fn all(layer: &Layer) -> Option<(f64, f64)> {
    extent(layer.heights())
}

/// What nine tenths of the values of a line cover: impacts throw some far out.
fn most(line: &Layer) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = line.heights().into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let rest = values.len() / 20;
    Some((*values.get(rest)?, *values.get(values.len() - 1 - rest)?))
}

/// An axis around what lines cover, and an area.
fn around<const N: usize>(name: &str, covered: [Option<(f64, f64)>; N], area: &Layer) -> Axis {
    let ends = covered.into_iter().flatten().flat_map(|(low, high)| [low, high]);
    Axis::around(Quantity::new(name, "m"), ends.chain(area.heights())).at_least(0.1)
}
