//! Charts: data to drawings. They know numbers, labels and units, and nothing of what was simulated or studied.
//!
//! A [`chart::Chart`] is made of coordinate systems, each with an [`axis::Axis`] either way and [`layer::Layer`]s; the other
//! charts are ways to make one. Only [`polar`] has a geometry of its own. Each is drawn at any width, as part of a page in its
//! colours or as a file of its own. The same data give the same text. Numbers that are not finite are missing; where nothing is
//! left the drawing says so.

pub(crate) mod axis;
pub(crate) mod bars;
pub(crate) mod chart;
pub(crate) mod cloud;
mod colours;
#[cfg(test)]
mod gallery;
pub(crate) mod labels;
pub(crate) mod layer;
pub(crate) mod map;
pub(crate) mod numbers;
mod plot;
pub(crate) mod polar;
pub(crate) mod svg;
pub(crate) mod sweep;
#[cfg(test)]
pub(crate) mod tests;
mod thin;

use maud::html;

use numbers::Px;
use svg::Drawing;

/// How many series differ in colour.
const COLOURS: usize = 6;

/// The class of the `index`-th series.
fn class(index: usize) -> String {
    format!("s{}", index % COLOURS)
}

/// The mark of the `index`-th series: another one where the colours start again.
fn mark(index: usize) -> usize {
    index + index / COLOURS
}

/// Whether a point can be drawn.
fn is_finite(point: &[f64; 2]) -> bool {
    point.iter().all(|value| value.is_finite())
}

/// What is drawn where there is nothing to draw.
fn no_data(width: f64) -> Drawing {
    const HEIGHT: f64 = 80.0;
    Drawing {
        width,
        height: HEIGHT,
        description: "No data.".to_owned(),
        time_axis: None,
        content: html! {
            rect class="missing" x="0.5" y="0.5" width=(Px(width - 1.0)) height=(Px(HEIGHT - 1.0)) {}
            text class="note" x=(Px(0.5 * width)) y=(Px(0.5 * HEIGHT + 4.0)) text-anchor="middle" { "no data" }
        },
    }
}
