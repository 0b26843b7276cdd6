//! Values by direction: a curve a series around a centre.

use legwork_study::rollout::DOUBTFUL;
use maud::{Markup, html};

use super::axis::{Axis, Quantity, Ruler};
use super::numbers::{Px, number};
use super::svg::{self, Drawing, Key, Symbol, text_width};
use super::{class, is_finite, mark, no_data};

/// Curves around a centre.
#[derive(Clone, Debug)]
pub(crate) struct Polar {
    /// How far from the centre.
    pub(crate) radius: Quantity,
    /// Names of the directions at 0°, 90°, 180° and 270°: right, up, left, down on the paper.
    pub(crate) directions: [String; 4],
    pub(crate) curves: Vec<Curve>,
}

/// Values of a series.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) label: String,
    /// Direction [degrees], counter-clockwise from the right, and value; not a number where there is none.
    pub(crate) points: Vec<[f64; 2]>,
    /// Directions whose value broke bounds of the simulation; they have a ring.
    pub(crate) doubtful: Vec<f64>,
}

/// Largest radius [px].
const RADIUS: f64 = 185.0;
impl Polar {
    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let points = self.curves.iter().flat_map(|curve| &curve.points).filter(|point| is_finite(point));
        let values: Vec<f64> = points.map(|point| point[1]).collect();
        if values.is_empty() {
            return no_data(width);
        }
        let keys = self.curves.iter().enumerate().filter(|(_, curve)| !curve.label.is_empty());
        let mut keys: Vec<Key> =
            keys.map(|(k, curve)| Key::new(Symbol::Marked(mark(k)), &class(k), &curve.label)).collect();
        let is_doubtful = |curve: &Curve, point: &[f64; 2]| is_finite(point) && curve.doubtful.contains(&point[0]);
        let any = self.curves.iter().any(|curve| curve.points.iter().any(|point| is_doubtful(curve, point)));
        keys.extend(any.then(|| Key::new(Symbol::Ring, "", DOUBTFUL)));
        let (legend, legend_height) = svg::legend(&keys, 4.0, width);
        let side = text_width(&self.directions[0]).max(text_width(&self.directions[2])) + 18.0;
        let reach = RADIUS.min(0.5 * width - side);
        let centre = [0.5 * width, legend_height + 50.0 + reach];
        let radius = self.radius.clone().logarithmic(false);
        let rings = Axis::around(radius, values.into_iter().chain([0.0])).on([0.0, reach], 28.0);
        let place = |angle: f64, value: f64| at(centre, angle, rings.at(value.max(0.0)));
        let curves: Vec<Vec<Vec<[f64; 2]>>> = self.curves.iter().map(|curve| lines(curve, place)).collect();
        let numbers = emptiest(&rings, centre, &curves.concat().concat());
        let content = html! {
            (legend)
            text class="label" x="4" y=(Px(legend_height + 20.0)) { "radius: " (rings.title) }
            (self.grid(&rings, centre, reach))
            @for (index, lines) in curves.iter().enumerate() {
                path class={ "line " (class(index)) } d=(svg::path(lines)) {}
                path class={ "shape " (class(index)) }
                    d={ @for &[x, y] in marked(lines) { (svg::shape(mark(index), [x, y], 3.6)) } } {}
            }
            @for curve in &self.curves {
                @for point in curve.points.iter().filter(|point| is_doubtful(curve, point)) {
                    path class="doubtful" d=(svg::shape(0, place(point[0], point[1]), svg::RING)) {}
                }
            }
            g class="ticks" text-anchor="middle" {
                @for tick in rings.ticks.iter().filter(|tick| tick.at > 1.0) {
                    @let [x, y] = at(centre, numbers, tick.at);
                    text class="halo" x=(Px(x)) y=(Px(y + 4.0)) { (tick.label) }
                }
            }
        };
        let height = centre[1] + reach + 32.0;
        Drawing { width, height, description: self.describe(), time_axis: None, content }
    }

    /// Rings, rays every 45°, and names of the directions.
    fn grid(&self, rings: &Ruler, centre: [f64; 2], reach: f64) -> Markup {
        let [x, y] = centre;
        let names = [
            (x + reach + 8.0, y + 4.0, "start"),
            (x, y - reach - 10.0, "middle"),
            (x - reach - 8.0, y + 4.0, "end"),
            (x, y + reach + 20.0, "middle"),
        ];
        html! {
            @for tick in rings.ticks.iter().filter(|tick| tick.at > 1.0) {
                circle class="ring" cx=(Px(x)) cy=(Px(y)) r=(Px(tick.at)) {}
            }
            circle class="axis" cx=(Px(x)) cy=(Px(y)) r=(Px(reach)) {}
            path class="grid" d=(svg::path(&[0.0, 45.0, 90.0, 135.0].map(|angle| {
                vec![at(centre, angle, reach), at(centre, angle + 180.0, reach)]
            }))) {}
            @for (name, (x, y, anchor)) in self.directions.iter().zip(names) {
                text class="label" x=(Px(x)) y=(Px(y)) text-anchor=(anchor) { (name) }
            }
            g class="ticks" {
                @for (angle, anchor) in [(45, "start"), (135, "end"), (225, "end"), (315, "start")] {
                    @let [x, y] = at(centre, f64::from(angle), reach + 8.0);
                    text x=(Px(x)) y=(Px(y + 4.0)) text-anchor=(anchor) { (angle) "\u{b0}" }
                }
            }
        }
    }

    /// Each curve with its least value: the direction that matters.
    fn describe(&self) -> String {
        let mut text = format!("{} by direction.", self.radius.title(0));
        for curve in &self.curves {
            let finite = curve.points.iter().filter(|point| is_finite(point));
            if let Some([angle, value]) = finite.min_by(|a, b| a[1].total_cmp(&b[1])) {
                text += &format!(" {}: at least {}, at {}\u{b0}.", curve.label, number(*value), number(*angle));
            }
        }
        text
    }
}

/// The point in a direction [degrees] at a radius [px].
fn at([x, y]: [f64; 2], angle: f64, radius: f64) -> [f64; 2] {
    let (sin, cos) = angle.to_radians().sin_cos();
    [x + radius * cos, y - radius * sin]
}

/// The direction [degrees] between two rays in which the numbers at the rings are farthest from the points of curves.
fn emptiest(rings: &Ruler, centre: [f64; 2], points: &[[f64; 2]]) -> f64 {
    let nearest = |angle: f64| {
        let numbers = rings.ticks.iter().filter(|tick| tick.at > 1.0).map(|tick| at(centre, angle, tick.at));
        let distances = numbers.flat_map(|[x, y]| points.iter().map(move |point| (point[0] - x).hypot(point[1] - y)));
        distances.fold(f64::INFINITY, f64::min)
    };
    let angles = (0..16).map(|k| 11.25 + 22.5 * f64::from(k));
    angles.max_by(|a, b| nearest(*a).total_cmp(&nearest(*b))).unwrap_or(0.0)
}

/// A curve's points in order as lines that end where it has no value; closed if it goes all around.
fn lines(curve: &Curve, place: impl Fn(f64, f64) -> [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut points: Vec<[f64; 2]> = curve.points.iter().filter(|point| point[0].is_finite()).copied().collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let pieces = points.chunk_by(|a, b| a[1].is_finite() && b[1].is_finite());
    let pieces = pieces.filter(|piece| piece.iter().all(|point| point[1].is_finite()));
    let mut lines: Vec<Vec<[f64; 2]>> =
        pieces.map(|piece| piece.iter().map(|&[angle, value]| place(angle, value)).collect()).collect();
    let widest = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).fold(0.0, f64::max);
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        let around = first[0] + 360.0 - last[0];
        let ends = [first, last].iter().all(|point| point[1].is_finite());
        if ends && points.len() > 2 && around > 1e-9 && around < 1.01 * widest + 1e-9 {
            let start = place(first[0], first[1]);
            lines.last_mut().expect("the last point is on a line").push(start);
        }
    }
    lines
}

/// The points to be marked, each once.
fn marked(lines: &[Vec<[f64; 2]>]) -> Vec<&[f64; 2]> {
    let mut points: Vec<&[f64; 2]> = lines.iter().flatten().collect();
    if points.len() > 1 && points[0].iter().zip(points[points.len() - 1]).all(|(a, b)| a.total_cmp(b).is_eq()) {
        points.pop();
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[[f64; 2]]) -> Curve {
        Curve { label: String::new(), points: points.to_vec(), doubtful: Vec::new() }
    }

    #[test]
    fn directions_run_counter_clockwise_from_the_right() {
        for (angle, expected) in [(0.0, [15.0, 7.0]), (90.0, [5.0, -3.0]), (180.0, [-5.0, 7.0]), (-90.0, [5.0, 17.0])] {
            let point = at([5.0, 7.0], angle, 10.0);
            assert!((point[0] - expected[0]).abs() < 1e-9 && (point[1] - expected[1]).abs() < 1e-9, "{angle}");
        }
    }

    #[test]
    fn a_curve_is_closed_if_it_goes_all_around() {
        let raw = |angle: f64, value: f64| [angle, value];
        let whole = curve(&[[0.0, 1.0], [270.0, 4.0], [90.0, 2.0], [180.0, 3.0]]);
        assert_eq!(lines(&whole, raw), [[[0.0, 1.0], [90.0, 2.0], [180.0, 3.0], [270.0, 4.0], [0.0, 1.0]]]);
        assert_eq!(marked(&lines(&whole, raw)).len(), 4);
        let half = curve(&[[0.0, 1.0], [90.0, 2.0], [180.0, 3.0]]);
        assert_eq!(lines(&half, raw)[0].len(), 3);
        let gap = curve(&[[0.0, 1.0], [90.0, f64::NAN], [180.0, 3.0], [270.0, 4.0]]);
        assert_eq!(lines(&gap, raw), [vec![[0.0, 1.0]], vec![[180.0, 3.0], [270.0, 4.0], [0.0, 1.0]]]);
        assert_eq!(marked(&lines(&gap, raw)).len(), 3);
    }
}
