//! Bars with intervals, in groups side by side; lying where their labels would not fit below them.

use maud::{Markup, html};

use super::axis::{Axis, Quantity};
use super::chart::{Chart, Part};
use super::class;
use super::layer::Layer;
use super::numbers::{Px, number};
use super::plot::Plot;
use super::svg::{self, Drawing, Key, Symbol};

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

/// Height of standing bars, thickness of a lying one, between groups [px].
const HEIGHT: f64 = 220.0;
const THICK: f64 = 12.0;
const SPACE: f64 = 9.0;
/// Least thickness of a standing bar, and greatest [px].
const THIN: f64 = 7.0;
const WIDE: f64 = 26.0;

/// Bars that stand or lie.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    bars: Bars,
    lying: bool,
}

impl Bars {
    /// Draws them `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let groups = Axis::of_texts("", self.groups.iter().map(|group| group.label.clone()).collect());
        let (count, bars) = (self.groups.len().max(1) as f64, self.series.len().max(1) as f64);
        let inside = [70.0, width - 14.0];
        let thin = (inside[1] - inside[0]) / count < THIN * bars + SPACE;
        let lying = thin || groups.on(inside, 44.0).is_slanted();
        let placed = Placed { bars: self.clone(), lying };
        let values = placed.values();
        let layers = vec![Layer::Bars(placed)];
        if lying {
            let part = Part { y: groups, height: count * (THICK * bars + SPACE), layers, notes: Vec::new() };
            Chart::of(Axis::around(self.value.clone(), values), part).draw(width)
        } else {
            Chart::of(groups, Part::new(self.value.clone(), HEIGHT, layers)).draw(width)
        }
    }
}

impl Placed {
    fn bars(&self) -> impl Iterator<Item = &Bar> {
        self.bars.groups.iter().flat_map(|group| &group.bars)
    }

    /// All values and ends of intervals, and zero.
    pub(super) fn values(&self) -> Vec<f64> {
        self.bars().flat_map(|bar| bar.interval.into_iter().flatten().chain([bar.value])).chain([0.0]).collect()
    }

    pub(super) fn is_to_be_seen(&self) -> bool {
        self.bars().any(|bar| bar.value.is_finite())
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let named = |(index, label): (usize, &String)| Key::new(Symbol::Area, &format!("bar {}", class(index)), label);
        let mut keys: Vec<Key> = self.bars.series.iter().enumerate().map(named).collect();
        if self.bars().any(|bar| bar.interval.is_some()) {
            keys.push(Key::new(Symbol::Whisker, "", &self.bars.interval));
        }
        keys
    }

    pub(super) fn words(&self) -> Vec<String> {
        let group = |group: &Group| {
            let finite = self.bars.series.iter().zip(&group.bars).filter(|(_, bar)| bar.value.is_finite());
            let values: Vec<String> = finite.map(|(series, bar)| format!("{series} {}", number(bar.value))).collect();
            format!("{}: {}", group.label, values.join(" and "))
        };
        self.bars.groups.iter().map(group).collect()
    }

    pub(super) fn draw(&self, plot: &Plot) -> Markup {
        let (groups, values) = if self.lying { (&plot.y, &plot.x) } else { (&plot.x, &plot.y) };
        let place = |along: f64, value: f64| {
            if self.lying { [values.at(value), along] } else { [along, values.at(value)] }
        };
        let count = self.bars.series.len().max(1) as f64;
        let [start, end] = groups.range();
        let thickness = (0.75 * (end - start) / self.bars.groups.len().max(1) as f64 / count).min(WIDE);
        let middle =
            |group: usize, series: usize| groups.at(group as f64) + thickness * (series as f64 - 0.5 * (count - 1.0));
        html! {
            @for (index, group) in self.bars.groups.iter().enumerate() {
                @for (series, bar) in group.bars.iter().enumerate().filter(|(_, bar)| bar.value.is_finite()) {
                    @let (middle, half) = (middle(index, series), 0.46 * thickness);
                    @let corners = [place(middle - half, 0.0), place(middle + half, bar.value)];
                    @let low = [0, 1].map(|k| corners[0][k].min(corners[1][k]));
                    @let size = [0, 1].map(|k| (corners[0][k] - corners[1][k]).abs());
                    rect class={ "bar " (class(series)) } x=(Px(low[0])) y=(Px(low[1])) width=(Px(size[0])) height=(Px(size[1])) {}
                    @if let Some([from, to]) = bar.interval.filter(|ends| ends.iter().all(|end| end.is_finite())) {
                        @let whisker = svg::whisker(place(middle, from), place(middle, to));
                        path class="whisker under" d=(whisker) {}
                        path class="whisker" d=(whisker) {}
                    }
                }
            }
            path class="zero" d=(svg::path(&[[start, end].map(|along| place(along, 0.0)).to_vec()])) {}
        }
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
