//! Charts of studies: data to drawings. They know numbers, labels and units, and nothing of what was studied.
//!
//! Each chart is drawn at any width, as part of a page in its colours or as a file of its own. The same data give the
//! same text. Numbers that are not finite are missing; where nothing is left the drawing says so.

pub(crate) mod axis;
pub(crate) mod bars;
pub(crate) mod cloud;
mod colours;
mod frame;
#[cfg(test)]
mod gallery;
pub(crate) mod heat_map;
pub(crate) mod polar;
pub(crate) mod powers;
pub(crate) mod scatter;
pub(crate) mod survival_map;
pub(crate) mod sweep;
#[cfg(test)]
mod tests;

use maud::html;

use super::scale::Px;
use super::svg::Drawing;

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
