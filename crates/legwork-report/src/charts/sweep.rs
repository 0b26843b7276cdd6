//! Values over a parameter: small panels side by side, each with one curve a series, and crosses where it fell.

use maud::{Markup, html};

use super::axis::{Quantity, Ruler, with_near_zero};
use super::frame::{self, GAP};
use super::{class, mark, no_data};
use crate::scale::Px;
use crate::svg::{self, Drawing, Key, Symbol, text_width};

/// Panels over one parameter.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// The parameter.
    pub(crate) x: Quantity,
    /// Where the parameter is a text: its values. A point's `x` counts them from zero.
    pub(crate) categories: Vec<String>,
    /// A value of the parameter to be marked, and what it is.
    pub(crate) marked: Option<(f64, String)>,
    pub(crate) series: Vec<Series>,
    pub(crate) panels: Vec<Panel>,
}

/// What was computed under the same circumstances, save the parameter.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub(crate) label: String,
    pub(crate) points: Vec<Point>,
}

/// A value of the parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) x: f64,
    /// Whether it ended in a fall; it then has a cross, and its values are not drawn.
    pub(crate) fell: bool,
}

/// Coordinate systems one above the other.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) parts: Vec<Part>,
}

/// A coordinate system.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) y: Quantity,
    /// For each series a value for each of its points; not a number where there is none.
    pub(crate) values: Vec<Vec<f64>>,
}

/// Least width of a panel [px], and the most panels side by side.
const NARROWEST: f64 = 240.0;
const MOST: usize = 3;
/// Between panels [px].
const GUTTER: f64 = 20.0;
/// Height of a panel's coordinate systems together [px], and what is above each for its name.
const HEIGHT: f64 = 236.0;
const HEAD: f64 = 25.0;
/// Height of a row of crosses [px].
const ROW: f64 = 13.0;

/// Where things are in each panel, from the panel's upper left corner [px].
struct Layout {
    width: f64,
    left: f64,
    /// Height of the crosses' rows.
    band: f64,
    /// The series that have such a row.
    fallen: Vec<usize>,
    /// Below the coordinate systems: numbers.
    foot: f64,
}

impl Sweep {
    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        if self.panels.is_empty() || self.series.iter().all(|series| series.points.is_empty()) {
            return no_data(width);
        }
        let columns = ((width / NARROWEST) as usize).clamp(1, MOST.min(self.panels.len()));
        let layout = self.layout((width - GUTTER * (columns - 1) as f64) / columns as f64);
        let (legend, legend_height) = svg::legend(&self.keys(), 4.0, width);
        let start = legend_height + 8.0;
        let height = 26.0 + layout.band + HEIGHT + layout.foot + 10.0;
        let rows = self.panels.len().div_ceil(columns);
        let content = html! {
            (legend)
            @for (index, panel) in self.panels.iter().enumerate() {
                @let corner = [(layout.width + GUTTER) * (index % columns) as f64, start + height * (index / columns) as f64];
                @let last = index + columns >= self.panels.len();
                (self.panel(panel, &layout, corner, last))
            }
        };
        Drawing {
            width,
            height: start + height * rows as f64 + 14.0,
            description: self.describe(),
            time_axis: None,
            content,
        }
    }

    fn keys(&self) -> Vec<Key> {
        let named =
            |(index, series): (usize, &Series)| Key::new(Symbol::Marked(mark(index)), &class(index), &series.label);
        let mut keys: Vec<Key> =
            self.series.iter().enumerate().filter(|(_, series)| !series.label.is_empty()).map(named).collect();
        if self.falls() > 0 {
            keys.push(Key::new(Symbol::Cross, "", "fell"));
        }
        if let Some((_, label)) = &self.marked {
            keys.push(Key::new(Symbol::Line, "marked", label));
        }
        keys
    }

    fn falls(&self) -> usize {
        self.series.iter().flat_map(|series| &series.points).filter(|point| point.fell).count()
    }

    fn layout(&self, width: f64) -> Layout {
        let numbers = self.panels.iter().flat_map(|panel| {
            let [top, bottom] = rows(panel, 0);
            panel.parts.iter().map(move |part| self.vertical(part, [bottom, top]).widest())
        });
        let fallen: Vec<usize> =
            (0..self.series.len()).filter(|&index| self.series[index].points.iter().any(|point| point.fell)).collect();
        let fell = if fallen.is_empty() { 0.0 } else { text_width("fell") };
        let left = numbers.fold(fell, f64::max) + GAP + 2.0;
        let [foot, overhang] = self.horizontal([left, width - 6.0]).needs();
        let band = if fallen.is_empty() { 0.0 } else { ROW * fallen.len() as f64 + 4.0 };
        Layout { width, left: left.max(overhang), band, fallen, foot }
    }

    fn horizontal(&self, range: [f64; 2]) -> Ruler {
        if self.categories.is_empty() {
            let marked = self.marked.iter().map(|(value, _)| *value);
            let values: Vec<f64> =
                self.series.iter().flat_map(|s| &s.points).map(|point| point.x).chain(marked).collect();
            Ruler::of(&self.x, &values, range, 36.0)
        } else {
            Ruler::of_texts(&self.x.title(0), &self.categories, range)
        }
    }

    fn vertical(&self, part: &Part, range: [f64; 2]) -> Ruler {
        let values = self.series.iter().zip(&part.values).flat_map(|(series, values)| {
            series.points.iter().zip(values).filter(|(point, _)| !point.fell).map(|(_, value)| *value)
        });
        Ruler::of(&part.y, &with_near_zero(values), range, 22.0)
    }

    fn panel(&self, panel: &Panel, layout: &Layout, [left, top]: [f64; 2], last: bool) -> Markup {
        let columns = [left + layout.left, left + layout.width - 6.0];
        let x = self.horizontal(columns);
        let first = top + 20.0 + layout.band;
        html! {
            text class="title" x=(Px(left + 2.0)) y=(Px(top + 12.0)) { (panel.title) }
            (self.crosses(layout, &x, top + 20.0))
            @for (index, part) in panel.parts.iter().enumerate() {
                @let rows = rows(panel, index).map(|y| first + y);
                (self.part(part, layout, &x, rows, index + 1 == panel.parts.len()))
            }
            @if last {
                text class="label" x=(Px(0.5 * (columns[0] + columns[1]))) y=(Px(first + HEIGHT + layout.foot + 10.0))
                    text-anchor="middle" { (x.title) }
            }
        }
    }

    /// The rows of crosses, from `top` on.
    fn crosses(&self, layout: &Layout, x: &Ruler, top: f64) -> Markup {
        let [left, right] = x.range();
        html! {
            @if !layout.fallen.is_empty() {
                rect class="fell-band" x=(Px(left)) y=(Px(top)) width=(Px(right - left)) height=(Px(layout.band)) {}
                text class="fell" x=(Px(left - GAP)) y=(Px(top + 0.5 * layout.band + 4.0)) text-anchor="end" { "fell" }
            }
            @for (row, &index) in layout.fallen.iter().enumerate() {
                @let y = top + 2.0 + ROW * (row as f64 + 0.5);
                @for point in self.series[index].points.iter().filter(|point| point.fell) {
                    path class={ "cross " (class(index)) } d=(svg::cross([self.place(x, index, point.x), y], 3.8)) {}
                }
            }
        }
    }

    fn part(&self, part: &Part, layout: &Layout, x: &Ruler, [top, bottom]: [f64; 2], numbers: bool) -> Markup {
        let y = self.vertical(part, [bottom, top]);
        let [left, right] = x.range();
        html! {
            (frame::vertical(&y, [left, right], true))
            (frame::horizontal(x, [top, bottom], false, numbers))
            text class="label" x=(Px(x.range()[0] - layout.left + 2.0)) y=(Px(top - 10.0)) { (y.title) }
            @if let Some((value, _)) = &self.marked {
                path class="line marked" d=(svg::path(&[vec![[x.at(*value), top], [x.at(*value), bottom]]])) {}
            }
            @for (index, (series, values)) in self.series.iter().zip(&part.values).enumerate() {
                @let lines = self.lines(series, values, |point, value| [self.place(x, index, point.x), y.at(value)]);
                @if self.categories.is_empty() {
                    path class={ "line " (class(index)) } d=(svg::path(&lines)) {}
                }
                path class={ "shape " (class(index)) }
                    d={ @for &centre in lines.iter().flatten() { (svg::shape(mark(index), centre, 3.4)) } } {}
            }
        }
    }

    /// A series' points in order, as lines that end where it fell or has no value.
    fn lines(&self, series: &Series, values: &[f64], at: impl Fn(&Point, f64) -> [f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let mut points: Vec<(&Point, f64)> = series.points.iter().zip(values.iter().copied()).collect();
        points.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        let shown = |(point, value): &(&Point, f64)| !point.fell && value.is_finite() && point.x.is_finite();
        let pieces = points.chunk_by(|a, b| shown(a) && shown(b)).filter(|piece| piece.iter().all(shown));
        pieces.map(|piece| piece.iter().map(|(point, value)| at(point, *value)).collect()).collect()
    }

    /// Where a series' value of the parameter is drawn [px]; beside those of the others, if the parameter is a text.
    fn place(&self, x: &Ruler, series: usize, value: f64) -> f64 {
        if self.categories.is_empty() {
            return x.at(value);
        }
        let slot = (x.range()[1] - x.range()[0]) / self.categories.len() as f64;
        let step = (0.7 * slot / self.series.len() as f64).min(10.0);
        x.at(value) + step * (series as f64 - 0.5 * (self.series.len() - 1) as f64)
    }

    fn describe(&self) -> String {
        let titles: Vec<&str> = self.panels.iter().map(|panel| panel.title.as_str()).collect();
        let all: usize = self.series.iter().map(|series| series.points.len()).sum();
        format!("{} over {}. {} of {all} fell.", titles.join(", "), self.x.title(0), self.falls())
    }
}

/// Top and bottom of a panel's coordinate system, below the crosses [px].
fn rows(panel: &Panel, index: usize) -> [f64; 2] {
    let share = HEIGHT / panel.parts.len().max(1) as f64;
    [share * index as f64 + HEAD, share * (index + 1) as f64 - 4.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A series that fell at 2 of 5 values, and has none at another.
    fn example(categories: &[&str]) -> Sweep {
        let point = |k: u32| Point { x: f64::from(k), fell: k == 0 || k == 3 };
        let values = vec![vec![9.0, 1.0, 2.0, 9.0, f64::NAN, 3.0, 4.0]];
        let part =
            |name: &str| Part { y: Quantity { name: name.into(), ..Quantity::default() }, values: values.clone() };
        Sweep {
            x: Quantity::default(),
            categories: categories.iter().map(|text| (*text).to_owned()).collect(),
            marked: Some((2.0, "as published".into())),
            series: vec![Series { label: "walk".into(), points: (0..7).map(point).collect() }],
            panels: vec![
                Panel { title: "error".into(), parts: vec![part("mean"), part("peak")] },
                Panel { title: "torque".into(), parts: vec![part("mean")] },
            ],
        }
    }

    fn count(text: &str, what: &str) -> usize {
        text.matches(what).count()
    }

    #[test]
    fn every_fall_has_a_cross_in_every_panel() {
        let text = example(&[]).draw(860.0).content.into_string();
        assert_eq!(count(&text, "class=\"cross s0\""), 2 * 2);
        assert_eq!(count(&text, "class=\"cross \""), 1, "in the legend");
        assert_eq!(count(&text, "class=\"fell-band\""), 2);
        assert_eq!(count(&text, ">fell<"), 2 + 1);
    }

    #[test]
    fn a_line_ends_where_it_fell_and_where_it_has_no_value() {
        let sweep = example(&[]);
        let lines = sweep.lines(&sweep.series[0], &sweep.panels[0].parts[0].values[0], |point, value| [point.x, value]);
        assert_eq!(lines, [vec![[1.0, 1.0], [2.0, 2.0]], vec![[5.0, 3.0], [6.0, 4.0]]]);
    }

    #[test]
    fn the_values_of_a_fall_do_not_count() {
        let sweep = example(&[]);
        let axis = sweep.vertical(&sweep.panels[0].parts[0], [100.0, 0.0]);
        assert!(axis.domain()[1] < 5.0, "9 was the value of falls");
    }

    #[test]
    fn there_is_room_for_the_numbers_that_are_drawn() {
        // On a short axis the ticks are 0.9, 1.0, 1.1, on the one that is drawn 0.90, 0.95, ...
        let mut sweep = example(&[]);
        sweep.panels.truncate(1);
        sweep.panels[0].parts.truncate(1);
        sweep.panels[0].parts[0].values[0].fill(1.0);
        let layout = sweep.layout(280.0);
        let [top, bottom] = rows(&sweep.panels[0], 0);
        let drawn = sweep.vertical(&sweep.panels[0].parts[0], [bottom, top]);
        assert!(drawn.ticks.iter().any(|tick| tick.label == "0.95"), "{drawn:?}");
        assert!(layout.left >= drawn.widest() + GAP);
    }

    #[test]
    fn without_falls_there_is_no_band() {
        let mut sweep = example(&[]);
        sweep.series[0].points.iter_mut().for_each(|point| point.fell = false);
        let text = sweep.draw(860.0).content.into_string();
        assert!(!text.contains("fell") && !text.contains("cross"));
    }

    #[test]
    fn texts_are_not_joined_by_lines_and_series_stand_side_by_side() {
        let mut sweep = example(&["a", "b", "c", "d", "e", "f", "g"]);
        sweep.series.push(sweep.series[0].clone());
        let text = sweep.draw(860.0).content.into_string();
        assert_eq!(count(&text, "class=\"line s0\""), 1, "in the legend");
        let x = sweep.horizontal([0.0, 280.0]);
        let [first, second] = [0, 1].map(|series| sweep.place(&x, series, 3.0));
        assert!((second - first - 10.0).abs() < 1e-9 && (0.5 * (first + second) - 140.0).abs() < 1e-9);
    }

    #[test]
    fn the_marked_value_is_in_every_coordinate_system() {
        let text = example(&[]).draw(860.0).content.into_string();
        assert_eq!(count(&text, "class=\"line marked\""), 3 + 1);
    }
}
