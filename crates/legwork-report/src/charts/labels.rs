//! Points with their names, which hide neither points nor each other.

use maud::{Markup, html};

use super::is_finite;
use super::numbers::{Px, number};
use super::plot::Plot;
use super::svg::{self, text_width};

/// A point with its name.
#[derive(Clone, Debug)]
pub(crate) struct Labelled {
    pub(crate) label: String,
    /// x and y; left out where one is not finite.
    pub(crate) at: [f64; 2],
}

/// A label's place: left, top, right, bottom [px].
type Frame = [f64; 4];

/// Radius of a point [px].
const DOT: f64 = 4.0;

impl Labelled {
    pub(super) fn words(&self) -> String {
        format!("{} {} and {}", self.label, number(self.at[0]), number(self.at[1]))
    }
}

pub(super) fn draw(points: &[Labelled], plot: &Plot) -> Markup {
    let points: Vec<&Labelled> = points.iter().filter(|point| is_finite(&point.at)).collect();
    let centres: Vec<[f64; 2]> = points.iter().map(|point| plot.at(point.at)).collect();
    let mut taken: Vec<Frame> = centres.iter().map(|[x, y]| [x - DOT, y - DOT, x + DOT, y + DOT]).collect();
    let ([left, right], [top, bottom]) = (plot.x.range(), plot.rows());
    let paper = [left + 2.0, top, right, bottom - 2.0];
    for (point, &centre) in points.iter().zip(&centres) {
        taken.push(free_place(text_width(&point.label) + 2.0, centre, paper, &taken));
    }
    let labels = &taken[points.len()..];
    let leaders: Vec<_> = centres.iter().zip(labels).filter_map(|(&centre, &frame)| leader(centre, frame)).collect();
    html! {
        path class="leader" d=(svg::path(&leaders)) {}
        @for &centre in &centres { path class="shape s0" d=(svg::shape(0, centre, DOT)) {} }
        @for (point, [left, _, _, bottom]) in points.iter().zip(labels) {
            text class="halo" x=(Px(left + 1.0)) y=(Px(bottom - 3.5)) { (point.label) }
        }
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
