//! Labelled points, such as the factors of a screening after Morris: mean of the absolute elementary effects (μ*) and
//! their standard deviation (σ).

use maud::{Markup, html};

use super::axis::{Quantity, Ruler};
use super::frame::{self, GAP};
use super::{is_finite, no_data};
use crate::scale::Px;
use crate::svg::{self, Drawing, text_width};
use crate::tables::number;

/// Labelled points.
#[derive(Clone, Debug)]
pub(crate) struct Scatter {
    pub(crate) x: Quantity,
    pub(crate) y: Quantity,
    pub(crate) points: Vec<Labelled>,
    /// Lines through the origin: y over x, and a label.
    pub(crate) rays: Vec<(f64, String)>,
}

/// A point with its name.
#[derive(Clone, Debug)]
pub(crate) struct Labelled {
    pub(crate) label: String,
    /// x and y; left out where one is not finite.
    pub(crate) at: [f64; 2],
}

/// A label's place: left, top, right, bottom [px].
type Frame = [f64; 4];

const HEIGHT: f64 = 330.0;
/// Radius of a point [px].
const DOT: f64 = 4.0;

impl Scatter {
    /// Draws them `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let points: Vec<&Labelled> = self.points.iter().filter(|point| is_finite(&point.at)).collect();
        if points.is_empty() {
            return no_data(width);
        }
        let (top, bottom) = (30.0, 30.0 + HEIGHT);
        let values = |k: usize| -> Vec<f64> { points.iter().map(|point| point.at[k]).chain([0.0]).collect() };
        let y = Ruler::of(&Quantity { log: false, ..self.y.clone() }, &values(1), [bottom, top], 40.0);
        let [left, right] = [y.widest() + GAP + 6.0, width - 8.0];
        let x = Ruler::of(&Quantity { log: false, ..self.x.clone() }, &values(0), [left, right], 62.0);
        let centres: Vec<[f64; 2]> = points.iter().map(|point| [x.at(point.at[0]), y.at(point.at[1])]).collect();
        let (rays, mut taken) = self.rays(&x, &y);
        taken.extend(centres.iter().map(|[x, y]| [x - DOT, y - DOT, x + DOT, y + DOT]));
        let paper = [left + 2.0, top, right, bottom - 2.0];
        let labels: Vec<Frame> = points
            .iter()
            .zip(&centres)
            .map(|(point, &centre)| {
                let frame = free_place(text_width(&point.label) + 2.0, centre, paper, &taken);
                taken.push(frame);
                frame
            })
            .collect();
        let leaders: Vec<_> =
            centres.iter().zip(&labels).filter_map(|(&centre, &frame)| leader(centre, frame)).collect();
        let content = html! {
            (frame::vertical(&y, [left, right], true))
            (frame::horizontal(&x, [top, bottom], true, true))
            text class="label" x="4" y=(Px(top - 12.0)) { (y.title) }
            text class="label" x=(Px(0.5 * (left + right))) y=(Px(bottom + 38.0)) text-anchor="middle" { (x.title) }
            (rays)
            path class="leader" d=(svg::path(&leaders)) {}
            @for &centre in &centres { path class="shape s0" d=(svg::shape(0, centre, DOT)) {} }
            @for (point, [left, _, _, bottom]) in points.iter().zip(&labels) {
                text class="halo" x=(Px(left + 1.0)) y=(Px(bottom - 3.5)) { (point.label) }
            }
        };
        Drawing { width, height: bottom + 46.0, description: self.describe(), time_axis: None, content }
    }

    /// The lines through the origin, and where their labels are.
    fn rays(&self, x: &Ruler, y: &Ruler) -> (Markup, Vec<Frame>) {
        let [far, high] = [x.domain()[1], y.domain()[1]];
        let (mut frames, mut drawn) = (Vec::new(), Vec::new());
        for (slope, text) in self.rays.iter().filter(|(slope, _)| slope.is_finite() && *slope > 0.0) {
            let tip = [x.at(far.min(high / slope)), y.at(high.min(far * slope))];
            let origin = [x.at(0.0), y.at(0.0)];
            // A line that ends at the top has its label left of it, one that ends at the right above it.
            let rise = (origin[1] - tip[1]) / (tip[0] - origin[0]).max(1.0);
            let (right, baseline) = if far * slope > high {
                (tip[0] - 16.0 / rise - 4.0, tip[1] + 13.0)
            } else {
                (tip[0] - 2.0, tip[1] - 5.0)
            };
            frames.push([right - text_width(text), baseline - 11.0, right, baseline + 3.0]);
            drawn.push((vec![origin, tip], text, right, baseline));
        }
        let markup = html! {
            @for (line, text, x, y) in &drawn {
                path class="line marked" d=(svg::path(std::slice::from_ref(line))) {}
                text class="note halo" x=(Px(*x)) y=(Px(*y)) text-anchor="end" { (text) }
            }
        };
        (markup, frames)
    }

    fn describe(&self) -> String {
        let mut text = format!("{} over {}.", self.y.title(0), self.x.title(0));
        for point in self.points.iter().filter(|point| is_finite(&point.at)) {
            text += &format!(" {}: {}, {}.", point.label, number(point.at[0]), number(point.at[1]));
        }
        text
    }
}

/// The line from a point to the frame of its label, if that is far away.
fn leader(centre: [f64; 2], [left, top, right, bottom]: Frame) -> Option<Vec<[f64; 2]>> {
    let near = [centre[0].clamp(left, right), centre[1].clamp(top, bottom)];
    ((near[0] - centre[0]).hypot(near[1] - centre[1]) > 3.0 * DOT).then(|| vec![centre, near])
}

/// The first free place in growing rings around a point; the one to the right where none is free.
fn free_place(width: f64, [x, y]: [f64; 2], paper: Frame, taken: &[Frame]) -> Frame {
    const TALL: f64 = 14.0;
    let around = |radius: f64, angle: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        let middle = [x + radius * cos + 0.5 * width * cos.signum() * f64::from(cos.abs() > 0.01), y - radius * sin];
        [middle[0] - 0.5 * width, middle[1] - 0.5 * TALL, middle[0] + 0.5 * width, middle[1] + 0.5 * TALL]
    };
    let angles =
        [0.0, 45.0, -45.0, 180.0, 135.0, -135.0, 90.0, -90.0, 22.0, -22.0, 158.0, -158.0, 68.0, -68.0, 112.0, -112.0];
    let radii = [9.0, 14.0, 22.0, 32.0, 44.0, 58.0, 75.0, 95.0, 120.0, 150.0, 185.0, 225.0];
    let inside =
        |place: &Frame| place[0] >= paper[0] && place[1] >= paper[1] && place[2] <= paper[2] && place[3] <= paper[3];
    let free = |place: &Frame| inside(place) && !taken.iter().any(|other| overlap(place, other));
    let places = radii.into_iter().flat_map(|radius| angles.map(|angle| around(radius, angle)));
    places.into_iter().find(free).unwrap_or_else(|| around(radii[0], 0.0))
}

fn overlap(a: &Frame, b: &Frame) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_a_crowd_hide_nothing() {
        let centres: Vec<[f64; 2]> =
            (0..25).map(|k| [300.0 + 4.0 * f64::from(k % 5), 150.0 + 4.0 * f64::from(k / 5)]).collect();
        let mut taken: Vec<Frame> = centres.iter().map(|[x, y]| [x - DOT, y - DOT, x + DOT, y + DOT]).collect();
        let paper = [40.0, 30.0, 850.0, 360.0];
        for centre in &centres {
            let place = free_place(70.0, *centre, paper, &taken);
            assert!(!taken.iter().any(|other| overlap(other, &place)), "{place:?}");
            assert!(place[0] >= paper[0] && place[1] >= paper[1] && place[2] <= paper[2] && place[3] <= paper[3]);
            taken.push(place);
        }
        assert!(leader(centres[12], taken[25 + 12]).is_some(), "those in the middle need a line to their label");
    }

    #[test]
    fn a_label_alone_is_right_of_its_point() {
        let place = free_place(50.0, [100.0, 100.0], [0.0, 0.0, 500.0, 500.0], &[]);
        assert!(place[0] > 100.0 && place[0] < 112.0 && place[1] < 100.0 && place[3] > 100.0);
        assert_eq!(leader([100.0, 100.0], place), None);
        let place = free_place(50.0, [480.0, 100.0], [0.0, 0.0, 500.0, 500.0], &[]);
        assert!(place[2] < 480.0, "there is no room on the right");
    }
}
