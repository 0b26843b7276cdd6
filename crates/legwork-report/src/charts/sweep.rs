//! Values over a parameter: a stack for each figure, in it a curve for each series, and crosses where the robot fell.

use super::axis::{Axis, Quantity};
use super::chart::{self, Chart, Stack};
use super::class;
use super::layer::Layer;
use super::no_data;
use super::svg::Drawing;

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
    /// Whether it broke bounds of the simulation; it then has a ring.
    pub(crate) doubtful: bool,
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
    /// For each series, of what a value is the median: the least, both quartiles and the greatest. May be empty.
    pub(crate) spreads: Vec<Vec<[f64; 4]>>,
    /// What its axis covers, where that does not follow from the values.
    pub(crate) covers: Option<[f64; 2]>,
}

impl Part {
    /// Shares, from none to all.
    pub(crate) fn of_shares(values: Vec<Vec<f64>>) -> Self {
        Self { covers: Some([0.0, 1.0]), ..Self::new(Quantity::new("share", ""), values) }
    }

    pub(crate) fn new(y: Quantity, values: Vec<Vec<f64>>) -> Self {
        Self { y, values, spreads: Vec::new(), covers: None }
    }
}

/// Least width of a panel [px], and the most panels side by side.
const COLUMNS: (f64, usize) = (240.0, 3);
/// Height of a panel's coordinate systems together with their heads, and of a row of crosses [px].
const HEIGHT: f64 = 244.0;
const ROW: f64 = 14.0;

impl Sweep {
    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        if self.series.iter().all(|series| series.points.is_empty()) {
            return no_data(width);
        }
        let stack = |panel: &Panel| {
            let parts = panel.parts.iter().map(|part| self.part(part, panel.parts.len()));
            Stack { title: panel.title.clone(), x: self.axis(), parts: self.falls().into_iter().chain(parts).collect() }
        };
        Chart::new(self.panels.iter().map(stack).collect(), COLUMNS).draw(width)
    }

    fn axis(&self) -> Axis {
        if self.categories.is_empty() {
            let marked = self.marked.iter().map(|(value, _)| *value);
            Axis::around(self.x.clone(), self.series.iter().flat_map(|s| &s.points).map(|point| point.x).chain(marked))
        } else {
            Axis::of_texts(&self.x.title(0), self.categories.clone())
        }
    }

    /// A row of crosses for each series in which the robot fell.
    fn falls(&self) -> Option<chart::Part> {
        let all = 0..self.series.len();
        let fallen: Vec<usize> =
            all.filter(|&index| self.series[index].points.iter().any(|point| point.fell)).collect();
        let crosses = |(row, &index): (usize, &usize)| {
            let fell = self.series[index].points.iter().filter(|point| point.fell);
            let points = fell.map(|point| [self.place(index, point.x), row as f64]).collect();
            Layer::Falls { class: class(index), points }
        };
        let rings = |(row, &index): (usize, &usize)| {
            let doubtful = self.series[index].points.iter().filter(|point| point.fell && point.doubtful);
            Layer::Rings(doubtful.map(|point| [self.place(index, point.x), row as f64]).collect())
        };
        let band = Layer::Spans { class: "fell-band", label: "", spans: vec![[-1e300, 1e300]] };
        let rows = || fallen.iter().enumerate();
        let layers: Vec<Layer> = [band].into_iter().chain(rows().map(crosses)).chain(rows().map(rings)).collect();
        let names = (0..fallen.len()).map(|row| if row == 0 { "fell".to_owned() } else { String::new() });
        (!fallen.is_empty()).then(|| chart::Part {
            y: Axis::of_texts("", names.collect()),
            height: ROW * fallen.len() as f64,
            layers,
            notes: Vec::new(),
        })
    }

    fn part(&self, part: &Part, among: usize) -> chart::Part {
        let mut layers = Vec::new();
        if let Some((x, what)) = &self.marked {
            layers.push(Layer::Upright { class: "marked", label: what.clone(), x: *x });
        }
        for (number, spreads) in part.spreads.iter().enumerate() {
            layers.extend(self.spread(number, spreads));
        }
        for (number, values) in part.values.iter().enumerate() {
            let points = self.points(number, |k| values[k]);
            layers.push(Layer::Series {
                number,
                label: self.series[number].label.clone(),
                points,
                joined: self.categories.is_empty(),
            });
            layers.push(Layer::Rings(self.rings(number, values)));
        }
        let drawn = chart::Part::new(part.y.clone(), HEIGHT / among as f64 - 37.0, layers);
        let exactly = part.covers.map(|domain| Axis::exactly(part.y.clone(), domain));
        chart::Part { y: exactly.unwrap_or(drawn.y), ..drawn }
    }

    /// Extremes and quartiles of a series: bands along numbers, bars at texts.
    fn spread(&self, number: usize, spreads: &[[f64; 4]]) -> Vec<Layer> {
        let ends = [("from least to greatest", "extremes", [0, 3]), ("middle half", "quartiles", [1, 2])];
        let layer = |(label, name, [low, high]): (&str, &str, [usize; 2])| {
            let (low, high) = (self.points(number, |k| spreads[k][low]), self.points(number, |k| spreads[k][high]));
            let pairs = low.into_iter().zip(high);
            let label = if number == 0 { label.to_owned() } else { String::new() };
            if self.categories.is_empty() {
                let points = pairs.map(|([x, low], [_, high])| [x, low, high]).collect();
                Layer::Area { class: format!("area {} {name}", class(number)), label, points }
            } else {
                let points = pairs.flat_map(|(low, high)| [low, high, [f64::NAN; 2]]).collect();
                Layer::Line { class: format!("{} {name}", class(number)), label, points }
            }
        };
        ends.map(layer).into()
    }

    /// The points of a series that broke bounds of the simulation and did not fall.
    fn rings(&self, number: usize, values: &[f64]) -> Vec<[f64; 2]> {
        let points = self.series[number].points.iter().zip(values);
        let doubtful = points.filter(|(point, value)| point.doubtful && !point.fell && value.is_finite());
        doubtful.map(|(point, value)| [self.place(number, point.x), *value]).collect()
    }

    /// The points of a series in the order of the parameter; without a value where the robot fell.
    fn points(&self, number: usize, value: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
        let points = self.series[number].points.iter().enumerate();
        let mut points: Vec<[f64; 2]> = points
            .map(|(k, point)| [self.place(number, point.x), if point.fell { f64::NAN } else { value(k) }])
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points
    }

    /// A series' value of the parameter; beside those of the others, if the parameter is a text.
    fn place(&self, series: usize, x: f64) -> f64 {
        if self.categories.is_empty() {
            return x;
        }
        let step = (0.7 / self.series.len() as f64).min(0.12);
        x + step * (series as f64 - 0.5 * (self.series.len() - 1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A series that fell at 2 of 5 values, and has none at another.
    fn example(categories: &[&str]) -> Sweep {
        let point = |k: u32| Point { x: f64::from(k), fell: k == 0 || k == 3, doubtful: k == 3 || k == 5 };
        let values = vec![vec![9.0, 1.0, 2.0, 9.0, f64::NAN, 3.0, 4.0]];
        let part = |name: &str| Part::new(Quantity::new(name, ""), values.clone());
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
    fn what_broke_bounds_has_a_ring_and_an_entry_in_the_legend() {
        let drawing = example(&[]).draw(860.0);
        // In two panels a fall, in three coordinate systems a value, and the legend.
        assert_eq!(count(&drawing.content.into_string(), "class=\"doubtful\""), 2 + 3 + 1);
        assert!(drawing.description.contains("1 broke bounds of the simulation"), "{}", drawing.description);
        let mut kept = example(&[]);
        kept.series[0].points.iter_mut().for_each(|point| point.doubtful = false);
        assert_eq!(count(&kept.draw(860.0).content.into_string(), "doubtful"), 0);
    }

    #[test]
    fn a_line_ends_where_it_fell_and_where_it_has_no_value() {
        let sweep = example(&[]);
        let points = sweep.points(0, |k| sweep.panels[0].parts[0].values[0][k]);
        let drawn: Vec<f64> = points.iter().filter(|point| point[1].is_finite()).map(|point| point[0]).collect();
        assert_eq!(drawn, [1.0, 2.0, 5.0, 6.0], "between 2 and 5 the line is broken");
    }

    #[test]
    fn the_values_of_a_fall_do_not_count() {
        let sweep = example(&[]);
        let text = sweep.draw(860.0).description;
        assert!(text.contains("walk 1 to 4"), "9 was the value of falls: {text}");
    }

    #[test]
    fn medians_have_bands_along_numbers_and_bars_at_texts() {
        for (categories, what) in
            [(vec![], "class=\"area s0 quartiles\""), (vec!["a"; 7], "class=\"line s0 quartiles\"")]
        {
            let mut sweep = example(&categories);
            sweep.panels[1].parts[0].spreads = vec![vec![[0.5, 0.8, 1.5, 5.0]; 7]];
            let drawing = sweep.draw(860.0);
            let text = drawing.content.into_string();
            assert_eq!(count(&text, what), 2, "with that of the legend");
            assert!(drawing.description.contains("from least to greatest 0.500 to 5"), "{}", drawing.description);
        }
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
        let [first, second] = [0, 1].map(|series| sweep.place(series, 3.0));
        assert!(second - first > 0.1 && (0.5 * (first + second) - 3.0).abs() < 1e-9);
    }

    #[test]
    fn the_marked_value_is_in_every_coordinate_system() {
        let text = example(&[]).draw(860.0).content.into_string();
        assert_eq!(count(&text, "class=\"line marked\""), 3 + 1);
    }
}
