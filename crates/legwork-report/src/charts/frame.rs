//! Axes drawn: their lines, grids, marks and numbers.

use maud::{Markup, html};

use super::axis::Ruler;
use crate::scale::Px;
use crate::svg;

/// Between an axis and its numbers [px].
pub(super) const GAP: f64 = 8.0;

/// A horizontal axis below a plot that reaches from `top` to `bottom` [px]: grid, marks and numbers.
pub(super) fn horizontal(ruler: &Ruler, [top, bottom]: [f64; 2], grid: bool, numbers: bool) -> Markup {
    let [left, right] = ruler.range();
    let slant = ruler.slant();
    let numbered = || ruler.ticks.iter().filter(|tick| !tick.label.is_empty());
    html! {
        @if grid {
            path class="grid" d={ @for tick in numbered() { "M" (Px(tick.at)) " " (Px(top)) "V" (Px(bottom)) } } {}
        }
        path class="axis" d={
            (svg::path(&[vec![[left, bottom], [right, bottom]]]))
            @for tick in &ruler.ticks {
                "M" (Px(tick.at)) " " (Px(bottom)) "v" (if tick.label.is_empty() { "2.5" } else { "4.5" })
            }
        } {}
        @if numbers {
            g class="ticks" text-anchor=(if slant > 0.0 { "end" } else { "middle" }) {
                @for tick in numbered() {
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

/// A vertical axis left of a plot that reaches from `left` to `right` [px]: grid, marks and numbers.
pub(super) fn vertical(ruler: &Ruler, [left, right]: [f64; 2], grid: bool) -> Markup {
    let [start, end] = ruler.range();
    let numbered = || ruler.ticks.iter().filter(|tick| !tick.label.is_empty());
    html! {
        @if grid {
            path class="grid" d={ @for tick in numbered() { "M" (Px(left)) " " (Px(tick.at)) "H" (Px(right)) } } {}
        }
        path class="axis" d={
            (svg::path(&[vec![[left, start], [left, end]]]))
            @for tick in &ruler.ticks {
                "M" (Px(left)) " " (Px(tick.at)) "h" (if tick.label.is_empty() { "-2.5" } else { "-4.5" })
            }
        } {}
        g class="ticks" text-anchor="end" {
            @for tick in numbered() { text x=(Px(left - GAP)) y=(Px(tick.at + 4.0)) { (tick.label) } }
        }
    }
}
