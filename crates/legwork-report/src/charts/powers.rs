//! Curves over a size, both axes logarithmic, so that a power of the size is a straight line; its exponent stands at the
//! curve's end.

use maud::{Markup, html};

use super::axis::{Quantity, Ruler};
use super::frame::{self, GAP};
use super::{class, is_finite, mark, no_data};
use crate::scale::Px;
use crate::svg::{self, Drawing, Key, Symbol, text_width};

/// Panels side by side over different sizes, with one axis of values.
#[derive(Clone, Debug)]
pub(crate) struct Powers {
    pub(crate) y: Quantity,
    pub(crate) panels: Vec<Panel>,
}

/// Curves over one size; those of the same place in each panel are of the same thing.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) x: Quantity,
    pub(crate) curves: Vec<Curve>,
}

/// A curve.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) label: String,
    /// Of the power that its upper part follows.
    pub(crate) exponent: Option<f64>,
    /// Size and value; left out where one is not finite.
    pub(crate) points: Vec<[f64; 2]>,
}

const HEIGHT: f64 = 330.0;
const GUTTER: f64 = 24.0;
/// Least distance of labels at the right, from baseline to baseline [px].
const LINE: f64 = 15.0;

impl Powers {
    /// Draws them `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let curves = || self.panels.iter().flat_map(|panel| &panel.curves);
        let values: Vec<f64> =
            curves().flat_map(|curve| &curve.points).filter(|point| is_finite(point)).map(|point| point[1]).collect();
        if values.is_empty() {
            return no_data(width);
        }
        let keys: Vec<Key> = self.panels[0].curves.iter().enumerate().map(key).collect();
        let (legend, legend_height) = svg::legend(&keys, 4.0, width);
        let (top, bottom) = (legend_height + 46.0, legend_height + 46.0 + HEIGHT);
        let y = Ruler::of(&self.y, &values, [bottom, top], 40.0);
        let share = (width - GUTTER * (self.panels.len() - 1) as f64) / self.panels.len() as f64;
        let content = html! {
            (legend)
            @for (index, panel) in self.panels.iter().enumerate() {
                @let left = index as f64 * (share + GUTTER) + y.widest() + GAP + 6.0;
                @let right = index as f64 * (share + GUTTER) + share - exponents(panel);
                (panel.draw(&y, [left, right], [top, bottom], &self.y.title(0)))
            }
        };
        Drawing { width, height: bottom + 46.0, description: self.describe(), time_axis: None, content }
    }

    fn describe(&self) -> String {
        let mut text = String::new();
        for panel in &self.panels {
            text += &format!("{} over {}, {}.", self.y.title(0), panel.x.title(0), panel.title);
            for curve in &panel.curves {
                let exponent = curve.exponent.map_or("unknown".to_owned(), |exponent| format!("{exponent:.1}"));
                text += &format!(" {}: exponent {exponent}.", curve.label);
            }
            text.push(' ');
        }
        text.trim_end().to_owned()
    }
}

fn key((index, curve): (usize, &Curve)) -> Key {
    Key::new(Symbol::Marked(mark(index)), &class(index), &curve.label)
}

/// What the exponents at the right need [px].
fn exponents(panel: &Panel) -> f64 {
    panel.curves.iter().filter_map(label).map(|text| text_width(&text)).fold(0.0, f64::max) + 12.0
}

fn label(curve: &Curve) -> Option<String> {
    curve.exponent.map(|exponent| format!("~ n^{exponent:.1}"))
}

impl Panel {
    fn draw(&self, y: &Ruler, [left, right]: [f64; 2], [top, bottom]: [f64; 2], y_title: &str) -> Markup {
        let sizes: Vec<f64> = self.curves.iter().flat_map(|curve| &curve.points).map(|point| point[0]).collect();
        let x = Ruler::of(&self.x, &sizes, [left, right], 40.0);
        let line = |curve: &Curve| -> Vec<[f64; 2]> {
            let points = curve.points.iter().filter(|point| is_finite(point));
            points.map(|point| [x.at(point[0]), y.at(point[1])]).collect()
        };
        html! {
            text class="title" x=(Px(left)) y=(Px(top - 30.0)) { (self.title) }
            text class="label" x=(Px(left - y.widest() - GAP - 2.0)) y=(Px(top - 10.0)) { (y_title) }
            (frame::vertical(y, [left, right], true))
            (frame::horizontal(&x, [top, bottom], true, true))
            text class="label" x=(Px(0.5 * (left + right))) y=(Px(bottom + 38.0)) text-anchor="middle" { (x.title) }
            @for (index, curve) in self.curves.iter().enumerate() {
                @let points = line(curve);
                path class={ "line " (class(index)) } d=(svg::path(std::slice::from_ref(&points))) {}
                path class={ "shape " (class(index)) } d={ @for &centre in &points { (svg::shape(mark(index), centre, 3.8)) } } {}
            }
            @for (text, y) in self.ends(line) {
                text class="note" x=(Px(right + 6.0)) y=(Px(y + 4.0)) { (text) }
            }
        }
    }

    /// The exponents, each as near to its curve's end as the others leave it.
    fn ends(&self, line: impl Fn(&Curve) -> Vec<[f64; 2]>) -> Vec<(String, f64)> {
        let end = |curve: &Curve| Some((label(curve)?, line(curve).last()?[1]));
        let mut ends: Vec<(String, f64)> = self.curves.iter().filter_map(end).collect();
        ends.sort_by(|a, b| b.1.total_cmp(&a.1));
        // From the lowest upwards
        for index in 1..ends.len() {
            ends[index].1 = ends[index].1.min(ends[index - 1].1 - LINE);
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(exponent: f64, factor: f64) -> Curve {
        let points = (1..=5).map(|k| [f64::from(2 * k), factor * f64::from(2 * k).powf(exponent)]).collect();
        Curve { label: format!("of {exponent}"), exponent: Some(exponent), points }
    }

    fn chart() -> Powers {
        let quantity = |name: &str| Quantity { name: name.into(), unit: String::new(), log: true };
        let curves = vec![curve(2.0, 1.0), curve(1.0, 10.0), curve(1.5, 3.0)];
        Powers { y: quantity("time"), panels: vec![Panel { title: "held".into(), x: quantity("size"), curves }] }
    }

    #[test]
    fn exponents_do_not_touch() {
        // All three curves end near a hundred.
        let chart = chart();
        let ends = chart.panels[0].ends(|curve| vec![[0.0, curve.points[4][1]]]);
        assert_eq!(ends.len(), 3);
        assert!(ends.windows(2).all(|pair| pair[0].1 - pair[1].1 >= LINE), "{ends:?}");
        assert!(chart.draw(800.0).content.into_string().contains("~ n^1.5"));
    }

    #[test]
    fn nothing_is_said_to_be_nothing() {
        let mut chart = chart();
        chart.panels[0].curves.iter_mut().for_each(|curve| curve.points.clear());
        assert_eq!(chart.draw(400.0).content.into_string(), no_data(400.0).content.into_string());
    }
}
