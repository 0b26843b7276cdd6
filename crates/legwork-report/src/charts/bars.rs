//! Bars with intervals, in groups side by side; lying where their labels would not fit below them.

use maud::{Markup, html};

use super::axis::{Quantity, Ruler, shortened};
use super::frame::{self, GAP};
use super::{class, no_data};
use crate::scale::Px;
use crate::svg::{self, Drawing, Key, Symbol, text_width};
use crate::tables::number;

/// Groups of bars.
#[derive(Clone, Debug)]
pub(crate) struct Bars {
    /// How long the bars are.
    pub(crate) value: Quantity,
    /// What the bars of a group are.
    pub(crate) series: Vec<String>,
    /// What the intervals are, such as `95 % interval`.
    pub(crate) interval: String,
    pub(crate) groups: Vec<Group>,
}

/// A bar for each series.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) label: String,
    pub(crate) bars: Vec<Bar>,
}

/// A value and how sure it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bar {
    /// Not a number where there is none.
    pub(crate) value: f64,
    pub(crate) interval: Option<[f64; 2]>,
}

/// Height of standing bars, thickness of a lying one, between lying groups [px].
const HEIGHT: f64 = 220.0;
const THICK: f64 = 12.0;
const SPACE: f64 = 9.0;
/// Least thickness of a standing bar, and greatest [px].
const THIN: f64 = 7.0;
const WIDE: f64 = 26.0;

/// The axes of the values and of the groups, and which lies.
struct Axes {
    value: Ruler,
    group: Ruler,
    standing: bool,
    /// Of a bar [px].
    thickness: f64,
}

impl Axes {
    /// The place of a value, so far across the groups [px].
    fn place(&self, across: f64, value: f64) -> [f64; 2] {
        if self.standing { [across, self.value.at(value)] } else { [self.value.at(value), across] }
    }
}

impl Bars {
    /// Draws them `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        if !self.groups.iter().flat_map(|group| &group.bars).any(|bar| bar.value.is_finite()) {
            return no_data(width);
        }
        let (legend, legend_height) = svg::legend(&self.keys(), 4.0, width);
        let top = legend_height + 30.0;
        let (axes, height) = self.axes(width, top);
        let (value, group) = (axes.value.range(), axes.group.range());
        let content = html! {
            (legend)
            @if axes.standing {
                (frame::vertical(&axes.value, group, true))
                text class="label" x="4" y=(Px(top - 11.0)) { (axes.value.title) }
            } @else {
                (frame::horizontal(&axes.value, group, true, true))
                text class="label" x=(Px(0.5 * (value[0] + value[1]))) y=(Px(height - 6.0)) text-anchor="middle" {
                    (axes.value.title)
                }
            }
            @for (index, group) in self.groups.iter().enumerate() {
                @for (series, bar) in group.bars.iter().enumerate().filter(|(_, bar)| bar.value.is_finite()) {
                    (self.bar(&axes, bar, index, series))
                }
            }
            path class="zero" d=(svg::path(&[group.map(|end| axes.place(end, 0.0)).to_vec()])) {}
            @if axes.standing {
                (frame::horizontal(&axes.group, [top, value[0]], false, true))
            } @else {
                g class="ticks" text-anchor="end" {
                    @for tick in &axes.group.ticks { text x=(Px(value[0] - GAP)) y=(Px(tick.at + 4.0)) { (tick.label) } }
                }
            }
        };
        Drawing { width, height, description: self.describe(), time_axis: None, content }
    }

    fn keys(&self) -> Vec<Key> {
        let named = |(index, label): (usize, &String)| Key::new(Symbol::Area, &format!("bar {}", class(index)), label);
        let mut keys: Vec<Key> = self.series.iter().enumerate().map(named).collect();
        if self.groups.iter().flat_map(|group| &group.bars).any(|bar| bar.interval.is_some()) {
            keys.push(Key::new(Symbol::Whisker, "", &self.interval));
        }
        keys
    }

    /// The axes, for bars below `top`, and the height of all [px].
    fn axes(&self, width: f64, top: f64) -> (Axes, f64) {
        let ends = |bar: &Bar| bar.interval.into_iter().flatten().chain([bar.value]);
        let values: Vec<f64> = self.groups.iter().flat_map(|group| &group.bars).flat_map(ends).chain([0.0]).collect();
        let labels: Vec<String> = self.groups.iter().map(|group| group.label.clone()).collect();
        let bars = self.series.len().max(1) as f64;

        let value = Ruler::of(&self.value, &values, [top + HEIGHT, top], 34.0);
        let left = value.widest() + GAP + 6.0;
        let slot = (width - left - 6.0) / labels.len() as f64;
        let group = Ruler::of_texts("", &labels, [left, width - 6.0]);
        if !group.is_slanted() && slot > THIN * bars + SPACE {
            let thickness = (0.75 * slot / bars).min(WIDE);
            return (Axes { value, group, standing: true, thickness }, top + HEIGHT + 28.0);
        }
        let top = top - 22.0;
        let labels: Vec<String> = labels.iter().map(|label| shortened(label, 0.42 * width)).collect();
        let left = labels.iter().map(|label| text_width(label)).fold(0.0, f64::max) + GAP + 4.0;
        let bottom = top + labels.len() as f64 * (THICK * bars + SPACE);
        let value = Ruler::of(&self.value, &values, [left, width - 14.0], 40.0);
        let group = Ruler::of_texts("", &labels, [top, bottom]);
        (Axes { value, group, standing: false, thickness: THICK }, bottom + 44.0)
    }

    fn bar(&self, axes: &Axes, bar: &Bar, group: usize, series: usize) -> Markup {
        let offset = series as f64 - 0.5 * (self.series.len().max(1) - 1) as f64;
        let middle = axes.group.at(group as f64) + axes.thickness * offset;
        let half = 0.46 * axes.thickness;
        let corners = [axes.place(middle - half, 0.0), axes.place(middle + half, bar.value)];
        let low = [0, 1].map(|k| corners[0][k].min(corners[1][k]));
        let size = [0, 1].map(|k| (corners[0][k] - corners[1][k]).abs());
        let interval = bar.interval.filter(|ends| ends.iter().all(|end| end.is_finite()));
        html! {
            rect class={ "bar " (class(series)) } x=(Px(low[0])) y=(Px(low[1])) width=(Px(size[0])) height=(Px(size[1])) {}
            @if let Some([from, to]) = interval {
                @let whisker = svg::whisker(axes.place(middle, from), axes.place(middle, to));
                path class="whisker under" d=(whisker) {}
                path class="whisker" d=(whisker) {}
            }
        }
    }

    fn describe(&self) -> String {
        let mut text = format!("Bars of {}.", self.value.title(0));
        for group in &self.groups {
            let finite = self.series.iter().zip(&group.bars).filter(|(_, bar)| bar.value.is_finite());
            let values: Vec<String> = finite.map(|(series, bar)| format!("{series} {}", number(bar.value))).collect();
            text += &format!(" {}: {}.", group.label, values.join(", "));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(label: &str) -> Bars {
        let bar = |value: f64| Bar { value, interval: Some([value - 0.1, value + 0.1]) };
        let group = |k: u32| Group { label: format!("{label} {k}"), bars: vec![bar(0.2), bar(0.4), bar(f64::NAN)] };
        Bars {
            value: Quantity::default(),
            series: vec!["first".into(), "total".into(), "none".into()],
            interval: "95 % interval".into(),
            groups: (0..5).map(group).collect(),
        }
    }

    /// Widths and heights of the bars.
    fn sizes(text: &str) -> Vec<[f64; 2]> {
        let number = |bar: &str, name: &str| -> f64 {
            let rest = bar.split_once(&format!(" {name}=\"")).expect("it has one").1;
            rest.split('"').next().and_then(|text| text.parse().ok()).expect("a number")
        };
        let bars = text.split("<rect class=\"bar ").skip(1).filter(|bar| !bar.contains("height=\"12\""));
        bars.map(|bar| [number(bar, "width"), number(bar, "height")]).collect()
    }

    #[test]
    fn bars_lie_where_their_labels_need_the_room() {
        let standing = sizes(&example("a").draw(860.0).content.into_string());
        let lying = sizes(&example("a name that is far too long to stand below").draw(860.0).content.into_string());
        assert_eq!((standing.len(), lying.len()), (10, 10));
        assert!((standing[1][1] / standing[0][1] - 2.0).abs() < 0.02 && (standing[1][0] - standing[0][0]).abs() < 0.11);
        assert!((lying[1][0] / lying[0][0] - 2.0).abs() < 0.02 && (lying[1][1] - lying[0][1]).abs() < 0.11);
    }

    #[test]
    fn every_interval_has_a_whisker() {
        let text = example("a").draw(860.0).content.into_string();
        assert_eq!(text.matches("class=\"whisker\"").count(), 10 + 1, "with that of the legend");
        let mut bars = example("a");
        bars.groups.iter_mut().flat_map(|group| &mut group.bars).for_each(|bar| bar.interval = None);
        assert!(!bars.draw(860.0).content.into_string().contains("whisker"));
    }
}
