//! What is drawn in a coordinate system: lines, marks, areas, spans, bars, cells.

use std::collections::BTreeSet;

use legwork_study::rollout::DOUBTFUL;
use maud::{Markup, html};

use super::bars::Placed;
use super::chart::reach;
use super::cloud::Cloud;
use super::labels::Labelled;
use super::map::Cells;
use super::numbers::{Px, number};
use super::plot::Plot;
use super::svg::{self, Key, Symbol};
use super::thin::thin;
use super::{class, is_finite, mark};

/// One thing that is drawn. A label stands in the legend; what has none is not there.
#[derive(Clone, Debug)]
pub(crate) enum Layer {
    /// Points joined by lines, from left to right; a gap where one is not finite.
    Line { class: String, label: String, points: Vec<[f64; 2]> },
    /// Points with the mark of the series of that number; joined, as a line is, if `joined`.
    Series { number: usize, label: String, points: Vec<[f64; 2]>, joined: bool },
    /// Between two lines: place, lower and upper end; a gap where one is not finite.
    Area { class: String, label: String, points: Vec<[f64; 3]> },
    /// From here to there, over the whole height.
    Spans { class: &'static str, label: &'static str, spans: Vec<[f64; 2]> },
    /// A level line all across.
    Level { class: &'static str, label: String, y: f64 },
    /// An upright line all over the height.
    Upright { class: &'static str, label: String, x: f64 },
    /// Crosses at falls.
    Falls { class: String, points: Vec<[f64; 2]> },
    /// Rings around what broke bounds of the simulation.
    Rings(Vec<[f64; 2]>),
    /// Marks on the row of that number: from when to when, at which side of the row: −1 below, 1 above, 0 both.
    Row { class: &'static str, row: usize, spans: Vec<([f64; 2], i8)> },
    /// Groups of bars.
    Bars(Placed),
    /// Cells of a map.
    Cells(Cells),
    /// The density of many points, and curves of equal products.
    Cloud(Cloud),
    /// Points with their names.
    Labelled(Vec<Labelled>),
}

impl Layer {
    pub(crate) fn line(label: &str, class: &str, points: Vec<[f64; 2]>) -> Self {
        Self::Line { class: class.to_owned(), label: label.to_owned(), points }
    }

    /// The values on the vertical axis that are to be seen.
    pub(crate) fn heights(&self) -> Vec<f64> {
        match self {
            Self::Line { points, .. } | Self::Series { points, .. } => points.iter().map(|point| point[1]).collect(),
            Self::Area { points, .. } => points.iter().flat_map(|point| [point[1], point[2]]).collect(),
            Self::Level { y, .. } => vec![*y],
            Self::Bars(bars) => bars.values(),
            Self::Cloud(cloud) => cloud.points.iter().map(|point| point[1]).collect(),
            Self::Labelled(points) => points.iter().map(|point| point.at[1]).chain([0.0]).collect(),
            Self::Spans { .. }
            | Self::Upright { .. }
            | Self::Falls { .. }
            | Self::Rings(_)
            | Self::Row { .. }
            | Self::Cells(_) => Vec::new(),
        }
    }

    /// Whether there is something in it.
    pub(super) fn is_to_be_seen(&self) -> bool {
        match self {
            Self::Line { points, .. } | Self::Series { points, .. } | Self::Falls { points, .. } => {
                points.iter().any(is_finite)
            }
            Self::Area { points, .. } => points.iter().any(|point| point.iter().all(|value| value.is_finite())),
            Self::Rings(points) => points.iter().any(is_finite),
            Self::Row { spans, .. } => !spans.is_empty(),
            Self::Bars(bars) => bars.is_to_be_seen(),
            Self::Cells(cells) => cells.is_to_be_seen(),
            Self::Cloud(cloud) => cloud.points.iter().any(is_finite),
            Self::Labelled(points) => points.iter().any(|point| is_finite(&point.at)),
            Self::Spans { .. } | Self::Level { .. } | Self::Upright { .. } => false,
        }
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let key = |symbol, class: &str, label: &str| {
            if label.is_empty() { Vec::new() } else { vec![Key::new(symbol, class, label)] }
        };
        match self {
            Self::Line { class, label, .. } => key(Symbol::Line, class, label),
            Self::Series { number, label, .. } => key(Symbol::Marked(mark(*number)), &class(*number), label),
            Self::Area { class, label, .. } => key(Symbol::Area, class, label),
            Self::Spans { class, label, .. } => key(Symbol::Area, class, label),
            Self::Level { class, label, .. } | Self::Upright { class, label, .. } => key(Symbol::Line, class, label),
            Self::Falls { points, .. } if !points.is_empty() => key(Symbol::Cross, "", "fell"),
            Self::Rings(points) if points.iter().any(is_finite) => key(Symbol::Ring, "", DOUBTFUL),
            Self::Bars(bars) => bars.keys(),
            Self::Cells(cells) => cells.keys(),
            Self::Cloud(cloud) => cloud.keys(),
            Self::Falls { .. } | Self::Rings(_) | Self::Row { .. } | Self::Labelled(_) => Vec::new(),
        }
    }

    /// What it says, in words.
    pub(super) fn words(&self) -> Vec<String> {
        match self {
            Self::Line { label, .. } | Self::Series { label, .. } | Self::Area { label, .. } => {
                let between = if label.is_empty() { "" } else { " " };
                reach(self.heights()).map(|reach| format!("{label}{between}{reach}")).into_iter().collect()
            }
            Self::Level { label, y, .. } => vec![format!("{label} at {}", number(*y))],
            Self::Upright { label, x, .. } => vec![format!("{label} at {}", number(*x))],
            Self::Falls { points, .. } if !points.is_empty() => vec![format!("{} fell", points.len())],
            Self::Rings(points) if !points.is_empty() => vec![format!("{} {DOUBTFUL}", points.len())],
            Self::Bars(bars) => bars.words(),
            Self::Cells(cells) => cells.words(),
            Self::Cloud(cloud) => reach(cloud.points.iter().map(|point| point[1])).into_iter().collect(),
            Self::Labelled(points) => points.iter().map(Labelled::words).collect(),
            Self::Falls { .. } | Self::Rings(_) | Self::Spans { .. } | Self::Row { .. } => Vec::new(),
        }
    }

    pub(super) fn draw(&self, plot: &Plot) -> Markup {
        let ([left, right], [top, bottom]) = (plot.x.range(), plot.rows());
        let thinned = |points: &[[f64; 2]]| svg::path(&thin(points.iter().map(|point| plot.at(*point))));
        match self {
            Self::Line { class, points, .. } => html! { path class={ "line " (class) } d=(thinned(points)) {} },
            Self::Series { number, points, joined, .. } => html! {
                @if *joined { path class={ "line " (class(*number)) } d=(thinned(points)) {} }
                path class={ "shape " (class(*number)) }
                    d={ @for centre in plot.all(points) { (svg::shape(mark(*number), centre, 3.4)) } } {}
            },
            Self::Area { class, points, .. } => html! { path class=(class) d=(area(points, plot)) {} },
            Self::Spans { class, spans, .. } => html! {
                path class=(class) d={
                    @for span in spans {
                        @let [from, to] = span.map(|x| Px(plot.x.at(x)));
                        "M" (from) " " (Px(top)) "H" (to) "V" (Px(bottom)) "H" (from) "Z"
                    }
                } {}
            },
            Self::Level { class, y, .. } if y.is_finite() => html! {
                path class={ "line " (class) } d=(svg::path(&[[left, right].map(|x| [x, plot.y.at(*y)]).to_vec()])) {}
            },
            Self::Upright { class, x, .. } if x.is_finite() => html! {
                path class={ "line " (class) } d=(svg::path(&[[top, bottom].map(|y| [plot.x.at(*x), y]).to_vec()])) {}
            },
            Self::Level { .. } | Self::Upright { .. } => html! {},
            Self::Falls { class, points } => html! {
                @for centre in plot.all(points) { path class={ "cross " (class) } d=(svg::cross(centre, 3.8)) {} }
            },
            Self::Rings(points) => html! {
                @for centre in plot.all(points) { path class="doubtful" d=(svg::shape(0, centre, svg::RING)) {} }
            },
            Self::Row { class, row, spans } => html! { path class={ "span " (class) } d=(marks(*row, spans, plot)) {} },
            Self::Bars(bars) => bars.draw(plot),
            Self::Cells(cells) => cells.draw(plot),
            Self::Cloud(cloud) => cloud.draw(plot),
            Self::Labelled(points) => super::labels::draw(points, plot),
        }
    }
}

fn area(points: &[[f64; 3]], plot: &Plot) -> String {
    let edge = |k: usize| {
        let whole = |point: &[f64; 3]| point.iter().all(|value| value.is_finite());
        thin(points.iter().map(|point| if whole(point) { plot.at([point[0], point[k]]) } else { [f64::NAN; 2] }))
    };
    let mut d = String::new();
    for (low, high) in edge(1).into_iter().zip(edge(2)) {
        d += &format!("{}Z", svg::path(&[high.into_iter().chain(low.into_iter().rev()).collect()]));
    }
    d
}

/// The marks of a row, half a pixel apart at the least, so that a path stays short however often a limit is hit.
fn marks(row: usize, spans: &[([f64; 2], i8)], plot: &Plot) -> String {
    let y = plot.y.at(row as f64);
    let mut drawn = BTreeSet::new();
    let mut d = String::new();
    for &(span, side) in spans {
        let [from, to] = span.map(|x| (2.0 * plot.x.at(x)).floor() / 2.0);
        let to = to.max(from + 0.5);
        if !drawn.insert(((2.0 * from) as i64, (2.0 * to) as i64, side)) {
            continue;
        }
        let (above, below) = (if side < 0 { 0.0 } else { 6.0 }, if side > 0 { 0.0 } else { 6.0 });
        d += &format!("M{} {}H{}V{}H{}Z", Px(from), Px(y - above), Px(to), Px(y + below), Px(from));
    }
    d
}
