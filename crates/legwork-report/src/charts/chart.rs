//! A chart: coordinate systems one above the other in stacks, stacks side by side, one legend for all.

use maud::{Markup, html};

use super::axis::{Axis, Quantity, Ruler};
use super::colours::Colours;
use super::layer::Layer;
use super::no_data;
use super::numbers::{Px, extent, number};
use super::plot::{GAP, Plot};
use super::svg::{self, Drawing, Key, Symbol, text_width};

/// Stacks of coordinate systems.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    pub(crate) stacks: Vec<Stack>,
    /// Least width of a stack [px], and the most stacks side by side.
    pub(crate) columns: (f64, usize),
    /// What the colours of cells mean.
    pub(crate) colours: Option<(Quantity, Colours)>,
    /// Whether the horizontal axis is the time of a run, which the animation's cursor follows.
    pub(crate) over_time: bool,
}

/// Coordinate systems one above the other, over one horizontal axis.
#[derive(Clone, Debug)]
pub(crate) struct Stack {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) parts: Vec<Part>,
}

/// A coordinate system.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) y: Axis,
    /// Without numbers and names [px].
    pub(crate) height: f64,
    /// From the back to the front.
    pub(crate) layers: Vec<Layer>,
    /// Words right of it, each beside a value of the vertical axis.
    pub(crate) notes: Vec<(f64, String)>,
}

/// Between stacks side by side [px].
const GUTTER: f64 = 20.0;
/// Below a coordinate system [px].
const BELOW: f64 = 12.0;
/// Widest column of cells under a text, and least height of the bar of colours [px].
const WIDEST: f64 = 92.0;
const BAR: f64 = 112.0;
/// From baseline to baseline of notes [px].
const LINE: f64 = 15.0;

/// What all stacks of a drawing share [px].
struct Layout {
    width: f64,
    /// From the left edge of a stack to its coordinate systems, and to their right end.
    across: [f64; 2],
    /// Below the last coordinate system: numbers and the name of the axis.
    foot: f64,
}

impl Part {
    /// A coordinate system around what its layers show.
    pub(crate) fn new(y: Quantity, height: f64, layers: Vec<Layer>) -> Self {
        let values: Vec<f64> = layers.iter().flat_map(Layer::heights).collect();
        Self { y: Axis::near_zero(y, values), height, layers, notes: Vec::new() }
    }

    /// What is above it for the name of its axis [px].
    fn head(&self) -> f64 {
        if self.y.title().is_empty() { 6.0 } else { 25.0 }
    }

    fn ruler(&self, top: f64, width: f64) -> Ruler {
        let bottom = top + self.height;
        // Texts are read downwards.
        let range = if self.y.texts().is_some() { [top, bottom] } else { [bottom, top] };
        self.y.shortened(0.42 * width).on(range, (0.2 * self.height).clamp(22.0, 42.0))
    }
}

impl Stack {
    fn head(&self) -> f64 {
        if self.title.is_empty() { 0.0 } else { 20.0 }
    }

    fn height(&self) -> f64 {
        self.head() + self.parts.iter().map(|part| part.head() + part.height + BELOW).sum::<f64>()
    }

    fn ruler(&self, range: [f64; 2]) -> Ruler {
        self.x.shortened(150.0).on(range, ((range[1] - range[0]) / 8.0).clamp(36.0, 62.0))
    }
}

impl Chart {
    /// A chart of one coordinate system.
    pub(crate) fn of(x: Axis, part: Part) -> Self {
        Self::new(vec![Stack { title: String::new(), x, parts: vec![part] }], (0.0, 1))
    }

    /// A chart of stacks.
    pub(crate) fn new(stacks: Vec<Stack>, columns: (f64, usize)) -> Self {
        Self { stacks, columns, colours: None, over_time: false }
    }

    fn layers(&self) -> impl Iterator<Item = &Layer> {
        self.parts().flat_map(|part| &part.layers)
    }

    fn parts(&self) -> impl Iterator<Item = &Part> {
        self.stacks.iter().flat_map(|stack| &stack.parts)
    }

    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        if !self.over_time && !self.layers().any(Layer::is_to_be_seen) {
            return no_data(width);
        }
        let bar = self.colours.as_ref().map_or(0.0, |(quantity, colours)| colours.bar_width(quantity) + 20.0);
        let columns =
            ((width / self.columns.0.max(1.0)) as usize).clamp(1, self.columns.1.min(self.stacks.len()).max(1));
        let layout = self.layout((width - bar - GUTTER * (columns - 1) as f64) / columns as f64);
        let (legend, legend_height) = svg::legend(&self.keys(), 4.0, width);
        let start = legend_height + if self.colours.is_some() { 26.0 } else { 6.0 };
        let mut bottom = start;
        let mut placed = Vec::new();
        for row in self.stacks.chunks(columns) {
            let height = row.iter().map(Stack::height).fold(0.0, f64::max);
            for (column, stack) in row.iter().enumerate() {
                let lower = height - stack.height();
                placed.push((stack, [(layout.width + GUTTER) * column as f64, bottom + lower]));
            }
            bottom += height + layout.foot;
        }
        let first = self.stacks.first().map(|stack| {
            let above = stack.head() + stack.parts.first().map_or(0.0, Part::head);
            [start + above, start + stack.height() - BELOW]
        });
        let rows = first.unwrap_or([start; 2]);
        let content = html! {
            (legend)
            @for (stack, corner) in placed { (self.stack(stack, &layout, corner)) }
            @if let Some((quantity, colours)) = &self.colours {
                @let end = (layout.across[1] + bar).max(colours.title_width(quantity) + 4.0);
                (colours.bar(quantity, end, [rows[0], rows[1].max(rows[0] + BAR)], legend_height + 16.0))
            }
        };
        let least = if self.colours.is_some() { rows[0] + BAR + 8.0 } else { 0.0 };
        let time_axis = self.stacks.first().filter(|_| self.over_time).map(|stack| {
            let x = stack.ruler(layout.across);
            [x.domain(), x.range(), rows]
        });
        Drawing { width, height: bottom.max(least), description: self.describe(), time_axis, content }
    }

    fn layout(&self, width: f64) -> Layout {
        let numbers = self.parts().map(|part| part.ruler(0.0, width).widest());
        let notes = self.parts().flat_map(|part| &part.notes).map(|(_, note)| 10.0 + text_width(note));
        let (left, right) = (numbers.fold(0.0, f64::max) + GAP + 4.0, width - notes.fold(14.0, f64::max));
        let needs = |left: f64, right: f64| {
            let all = self.stacks.iter().map(|stack| stack.ruler([left, self.right(stack, left, right)]).needs());
            all.fold([0.0; 3], |most: [f64; 3], needs| [0, 1, 2].map(|k| most[k].max(needs[k])))
        };
        let [_, before, after] = needs(left, right);
        let (left, right) = (left.max(before), right.min(width - after));
        let right = self.stacks.iter().map(|stack| self.right(stack, left, right)).fold(right, f64::min);
        let named = self.stacks.iter().any(|stack| !stack.x.title().is_empty());
        Layout { width, across: [left, right], foot: needs(left, right)[0] + if named { 26.0 } else { 6.0 } }
    }

    /// Where a stack ends that begins at `left`: columns of cells under texts are not stretched [px].
    fn right(&self, stack: &Stack, left: f64, right: f64) -> f64 {
        let cells = stack.x.texts().filter(|_| self.colours.is_some());
        cells.map_or(right, |texts| right.min(left + WIDEST * texts.len() as f64))
    }

    fn stack(&self, stack: &Stack, layout: &Layout, [left, top]: [f64; 2]) -> Markup {
        let x = stack.ruler(layout.across.map(|edge| left + edge));
        let grid = !self.over_time && stack.x.texts().is_none();
        let mut upper = top + stack.head();
        let mut placed = Vec::new();
        for (index, part) in stack.parts.iter().enumerate() {
            upper += part.head();
            let plot = Plot { x: x.clone(), y: part.ruler(upper, layout.width) };
            placed.push((part, plot, index + 1 == stack.parts.len()));
            upper += part.height + BELOW;
        }
        let middle = 0.5 * (x.range()[0] + x.range()[1]);
        html! {
            @if !stack.title.is_empty() { text class="title" x=(Px(left + 2.0)) y=(Px(top + 12.0)) { (stack.title) } }
            @for (part, plot, last) in &placed {
                @let top = plot.rows()[0];
                @if !plot.y.title.is_empty() { text class="label" x=(Px(left + 2.0)) y=(Px(top - 10.0)) { (plot.y.title) } }
                // Spans are behind the grid, all else before it.
                @let is_span = |layer: &&Layer| matches!(layer, Layer::Spans { .. });
                @for layer in part.layers.iter().filter(is_span) { (layer.draw(plot)) }
                (plot.axes(grid, *last))
                @for layer in part.layers.iter().filter(|layer| !is_span(layer)) { (layer.draw(plot)) }
                @for (note, y) in notes(part, plot) {
                    text class="note" x=(Px(plot.x.range()[1] + 8.0)) y=(Px(y + 4.0)) { (note) }
                }
            }
            @if !x.title.is_empty() {
                text class="label" x=(Px(middle)) y=(Px(upper - BELOW + layout.foot - 10.0)) text-anchor="middle" { (x.title) }
            }
        }
    }

    /// The legend: each label once, areas last.
    fn keys(&self) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        for key in self.layers().flat_map(Layer::keys) {
            if !keys.iter().any(|known| known.label == key.label) {
                keys.push(key);
            }
        }
        keys.sort_by_key(|key| key.symbol == Symbol::Area);
        keys
    }

    /// What it says, in words.
    fn describe(&self) -> String {
        let mut text = String::new();
        for stack in &self.stacks {
            let title = if stack.title.is_empty() { String::new() } else { format!("{}: ", stack.title) };
            for part in &stack.parts {
                let mut said: Vec<String> = part.layers.iter().flat_map(Layer::words).collect();
                let texts = part.y.texts().unwrap_or_default();
                said.extend(texts.iter().zip(&part.notes).map(|(text, (_, note))| format!("{text} {note}")));
                let names = [part.y.title(), stack.x.title()].into_iter().filter(|name| !name.is_empty());
                let names = names.collect::<Vec<_>>().join(" over ");
                let between = if names.is_empty() || said.is_empty() { "" } else { ": " };
                text += &format!("{title}{names}{between}{}. ", said.join(", "));
            }
        }
        text.trim_end().to_owned()
    }
}

/// From the least to the greatest of `values`, in words.
pub(super) fn reach(values: impl IntoIterator<Item = f64>) -> Option<String> {
    extent(values).map(|(low, high)| format!("{} to {}", number(low), number(high)))
}

/// The notes of a part, each as near to its value as the others leave it, from the lowest upwards.
fn notes<'p>(part: &'p Part, plot: &Plot) -> Vec<(&'p str, f64)> {
    let at = |(value, note): &'p (f64, String)| (note.as_str(), plot.y.at(*value));
    let mut notes: Vec<_> = part.notes.iter().map(at).filter(|(_, y)| y.is_finite()).collect();
    notes.sort_by(|a, b| b.1.total_cmp(&a.1));
    for index in 1..notes.len() {
        notes[index].1 = notes[index].1.min(notes[index - 1].1 - LINE);
    }
    notes
}
