//! A coordinate system on paper: its axes, grid, marks and numbers.

use maud::{Markup, html};

use super::axis::{Ruler, Tick};
use super::numbers::Px;
use super::svg;

/// Between an axis and its numbers [px].
pub(super) const GAP: f64 = 8.0;

/// Two axes in their places.
#[derive(Clone, Debug)]
pub(super) struct Plot {
    pub(super) x: Ruler,
    pub(super) y: Ruler,
}

impl Plot {
    /// A point [px]; not a number where one of its coordinates is none.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x.at(x), self.y.at(y)]
    }

    /// Its upper and its lower edge [px].
    pub(super) fn rows(&self) -> [f64; 2] {
        let [start, end] = self.y.range();
        [start.min(end), start.max(end)]
    }

    /// Points, each with both coordinates [px].
    pub(super) fn all<'p>(&'p self, points: &'p [[f64; 2]]) -> impl Iterator<Item = [f64; 2]> + 'p {
        points.iter().map(|point| self.at(*point)).filter(super::is_finite)
    }

    /// Grid, axes, marks and numbers; upright lines of the grid, and numbers below it, where they are wanted.
    pub(super) fn axes(&self, upright: bool, numbers: bool) -> Markup {
        let ([left, right], [top, bottom]) = (self.x.range(), self.rows());
        let slant = self.x.slant();
        let numbered =
            |ticks: &[Tick]| -> Vec<Tick> { ticks.iter().filter(|tick| !tick.label.is_empty()).cloned().collect() };
        let (across, up) = (numbered(&self.x.ticks), numbered(&self.y.ticks));
        let long = |tick: &Tick| if tick.label.is_empty() { 2.5 } else { 4.5 };
        html! {
            path class="grid" d={
                @for tick in &up { "M" (Px(left)) " " (Px(tick.at)) "H" (Px(right)) }
                @if upright { @for tick in &across { "M" (Px(tick.at)) " " (Px(top)) "V" (Px(bottom)) } }
            } {}
            @if self.y.crosses_zero() {
                @let zero = self.y.at(0.0);
                path class="zero" d=(svg::path(&[vec![[left, zero], [right, zero]]])) {}
            }
            path class="axis" d={
                (svg::path(&[vec![[left, top], [left, bottom], [right, bottom]]]))
                @for tick in &self.x.ticks { "M" (Px(tick.at)) " " (Px(bottom)) "v" (Px(long(tick))) }
                @for tick in &self.y.ticks { "M" (Px(left)) " " (Px(tick.at)) "h" (Px(-long(tick))) }
            } {}
            g class="ticks" text-anchor="end" {
                @for tick in &up { text x=(Px(left - GAP)) y=(Px(tick.at + 4.0)) { (tick.label) } }
            }
            @if numbers {
                g class="ticks" text-anchor=(if slant > 0.0 { "end" } else { "middle" }) {
                    @for tick in &across {
                        @if slant > 0.0 {
                            @let (x, y) = (Px(tick.at + 4.0), Px(bottom + 15.0));
                            text x=(x) y=(y) transform={ "rotate(-" (slant) " " (x) " " (y) ")" } { (tick.label) }
                        } @else {
                            text x=(Px(tick.at)) y=(Px(bottom + 18.0)) { (tick.label) }
                        }
                    }
                }
            }
        }
    }
}
