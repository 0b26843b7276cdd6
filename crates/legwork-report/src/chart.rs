//! Charts over time: panels one above the other on one time axis.

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::scale::{self, Axis, Px, Scale, round_step, tick_label};
use super::svg::{self, Drawing, Key, Symbol, text_width};

/// A time span that is shaded in all panels.
#[derive(Clone, Debug)]
pub(super) struct Band {
    /// From when to when [s].
    pub(super) span: [f64; 2],
    pub(super) class: &'static str,
    pub(super) label: &'static str,
}

/// A line.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) label: String,
    pub(super) class: String,
    /// A value for each time of the chart.
    pub(super) values: Vec<f64>,
    /// Whether it is read on the right axis.
    pub(super) right: bool,
}

/// An area between two lines over a time span.
#[derive(Clone, Debug)]
pub(super) struct Area {
    pub(super) label: &'static str,
    pub(super) class: &'static str,
    /// Pieces of `[time, low, high]`.
    pub(super) pieces: Vec<Vec<[f64; 3]>>,
}

/// When something was the case.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) label: String,
    /// At the right end, as a share of the time.
    pub(super) note: String,
    /// From when to when [s], at which side: −1 below, 1 above, 0 both.
    pub(super) spans: Vec<([f64; 2], i8)>,
    pub(super) class: &'static str,
}

/// What a panel holds.
#[derive(Clone, Debug)]
pub(super) enum Content {
    /// Lines against one axis or two.
    Lines {
        left: Axis,
        right: Option<Axis>,
        series: Vec<Series>,
        areas: Vec<Area>,
        /// Horizontal lines at limits.
        limits: Vec<f64>,
        /// In the upper right corner.
        note: String,
    },
    /// Rows of marks.
    Rows(Vec<Row>),
}

/// One coordinate system.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    /// Without axes and labels [px].
    pub(super) height: f64,
    pub(super) content: Content,
}

/// Panels over one time axis.
#[derive(Clone, Debug)]
pub(super) struct Chart {
    /// Times of the series' values [s].
    pub(super) times: Vec<f64>,
    /// What the time axis covers [s].
    pub(super) span: [f64; 2],
    pub(super) bands: Vec<Band>,
    /// When the robot fell [s].
    pub(super) fall: Option<f64>,
    pub(super) panels: Vec<Panel>,
}

const ROW: f64 = 17.0;
/// Above a panel: the names of its axes.
const HEAD: f64 = 29.0;
/// Below the last: the time axis.
const FOOT: f64 = 40.0;

impl Chart {
    /// Draws it `width` wide [px].
    pub(super) fn draw(&self, width: f64) -> Drawing {
        let left = self.panels.iter().map(left_margin).fold(30.0, f64::max);
        let right = width - self.panels.iter().map(right_margin).fold(14.0, f64::max);
        let time = Scale { domain: self.span, range: [left, right] };
        let (legend, legend_height) = svg::legend(&self.keys(), 4.0, width);

        let mut top = legend_height;
        let mut placed = Vec::new();
        for panel in &self.panels {
            top += if matches!(panel.content, Content::Rows(_)) { 10.0 } else { HEAD };
            placed.push((panel, [top, top + panel.height]));
            top += panel.height + 8.0;
        }
        let bottom = top - 8.0;
        let first = placed.first().map_or(bottom, |(_, [top, _])| *top);
        let content = html! {
            (legend)
            @for (_, rows) in &placed { (self.bands(&time, *rows)) }
            (time_ticks(&time, &placed.iter().map(|(_, rows)| *rows).collect::<Vec<_>>()))
            @for (panel, rows) in &placed { (self.panel(panel, &time, *rows, width)) }
            @if let Some(fall) = self.fall {
                path class="fall" d=(svg::path(&[vec![[time.within(fall), first], [time.within(fall), bottom]]])) {}
                text class="fall" x=(Px(time.within(fall) - 5.0)) y=(Px(first + 14.0)) text-anchor="end" { "fell" }
            }
        };
        Drawing {
            width,
            height: bottom + FOOT,
            description: self.describe(),
            time_axis: Some([self.span, [left, right], [first, bottom]]),
            content,
        }
    }

    /// The legend: each label once.
    fn keys(&self) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        let mut add = |symbol, class: &str, label: &str| {
            if !keys.iter().any(|key| key.label == label) {
                keys.push(Key::new(symbol, class, label));
            }
        };
        for panel in &self.panels {
            if let Content::Lines { series, areas, limits, .. } = &panel.content {
                series.iter().for_each(|series| add(Symbol::Line, &series.class, &series.label));
                areas.iter().for_each(|area| add(Symbol::Area, area.class, area.label));
                limits.iter().for_each(|_| add(Symbol::Line, "limit", "limit"));
            }
        }
        self.bands.iter().for_each(|band| add(Symbol::Area, band.class, band.label));
        keys
    }

    fn bands(&self, time: &Scale, [top, bottom]: [f64; 2]) -> Markup {
        let mut paths: Vec<(&str, String)> = Vec::new();
        for band in &self.bands {
            let [from, to] = band.span.map(|t| time.within(t));
            let path = format!("M{} {}H{}V{}H{}Z", Px(from), Px(top), Px(to), Px(bottom), Px(from));
            match paths.iter_mut().find(|(class, _)| *class == band.class) {
                Some((_, all)) => all.push_str(&path),
                None => paths.push((band.class, path)),
            }
        }
        html! { @for (class, d) in paths { path class=(class) d=(d) {} } }
    }

    fn panel(&self, panel: &Panel, time: &Scale, [top, bottom]: [f64; 2], width: f64) -> Markup {
        match &panel.content {
            Content::Rows(rows) => rows_of_marks(rows, time, top, width),
            Content::Lines { left, right, series, areas, limits, note } => {
                let scale = |axis: &Axis| Scale { domain: axis.domain, range: [bottom, top] };
                let (own, other) = (scale(left), right.as_ref().map(scale));
                html! {
                    (value_axis(left, &own, time.range, false))
                    @if let (Some(axis), Some(scale)) = (right, &other) { (value_axis(axis, scale, time.range, true)) }
                    @for area in areas { (drawn_area(area, time, &own)) }
                    @for &limit in limits {
                        path class="line limit" d=(svg::path(&[time.range.map(|x| [x, own.within(limit)]).to_vec()])) {}
                    }
                    @for line in series {
                        @let scale = other.filter(|_| line.right).unwrap_or(own);
                        path class={ "line " (line.class) } d=(svg::path(&self.thinned(&line.values, time, &scale))) {}
                    }
                    @if !note.is_empty() {
                        text class="note" x=(Px(time.range[1])) y=(Px(top - 11.0)) text-anchor="end" { (note) }
                    }
                }
            }
        }
    }

    fn thinned(&self, values: &[f64], time: &Scale, scale: &Scale) -> Vec<Vec<[f64; 2]>> {
        let pixel =
            |(&t, &value): (&f64, &f64)| [time.at(t), if value.is_finite() { scale.within(value) } else { value }];
        scale::thin(self.times.iter().zip(values).map(pixel))
    }

    /// What the lines and rows say, in words.
    fn describe(&self) -> String {
        let mut text = format!("Chart over time from {} to {} s.", short(self.span[0]), short(self.span[1]));
        for panel in &self.panels {
            match &panel.content {
                Content::Lines { left, right, series, .. } => {
                    for line in series {
                        let axis = right.as_ref().filter(|_| line.right).unwrap_or(left);
                        if let Some((low, high)) = scale::extent(line.values.iter().copied()) {
                            text += &format!(" {}, {}: {} to {}.", axis.label, line.label, short(low), short(high));
                        }
                    }
                }
                Content::Rows(rows) => rows.iter().for_each(|row| text += &format!(" {}: {}.", row.label, row.note)),
            }
        }
        text
    }
}

/// A panel of `rows`.
pub(super) fn rows_panel(rows: Vec<Row>) -> Panel {
    Panel { height: ROW * rows.len() as f64, content: Content::Rows(rows) }
}

/// A number with three significant digits at the most.
fn short(value: f64) -> String {
    let magnitude = value.abs().max(1e-3).log10().floor();
    let decimals = (2.0 - magnitude).clamp(0.0, 4.0) as usize;
    tick_label(value, 10.0_f64.powi(-(decimals as i32)))
}

fn left_margin(panel: &Panel) -> f64 {
    match &panel.content {
        Content::Lines { left, .. } => 12.0 + widest_tick(left),
        Content::Rows(rows) => 12.0 + rows.iter().map(|row| text_width(&row.label)).fold(0.0, f64::max),
    }
}

fn right_margin(panel: &Panel) -> f64 {
    match &panel.content {
        Content::Lines { right, .. } => right.as_ref().map_or(0.0, |axis| 12.0 + widest_tick(axis)),
        Content::Rows(rows) => 10.0 + rows.iter().map(|row| text_width(&row.note)).fold(0.0, f64::max),
    }
}

fn widest_tick(axis: &Axis) -> f64 {
    axis.ticks().into_iter().map(|tick| text_width(&tick_label(tick, axis.step))).fold(0.0, f64::max)
}

/// The ticks of the time axis: short in every panel, with numbers below the last.
fn time_ticks(time: &Scale, panels: &[[f64; 2]]) -> Markup {
    let [left, right] = time.range;
    let step = round_step(time.domain[1] - time.domain[0], ((right - left) / 62.0) as usize);
    let ticks = scale::multiples(time.domain[0], time.domain[1], step);
    let bottom = panels.last().map_or(0.0, |panel| panel[1]);
    html! {
        @for &[_, bottom] in panels {
            path class="axis" d={
                (svg::path(&[vec![[left, bottom], [right, bottom]]]))
                @for &tick in &ticks { "M" (Px(time.at(tick))) " " (Px(bottom)) "v4" }
            } {}
        }
        g class="ticks" text-anchor="middle" {
            @for &tick in &ticks {
                text x=(Px(time.at(tick))) y=(Px(bottom + 18.0)) { (tick_label(tick, step)) }
            }
        }
        text class="label" x=(Px(right)) y=(Px(bottom + 35.0)) text-anchor="end" { "time [s]" }
    }
}

/// Grid, numbers and name of a value axis.
fn value_axis(axis: &Axis, scale: &Scale, [left, right]: [f64; 2], on_right: bool) -> Markup {
    let top = scale.range[1];
    let (x, gap, anchor) = if on_right { (right, 8.0, "start") } else { (left, -8.0, "end") };
    let (name_x, name_anchor) =
        if on_right { (right + gap + widest_tick(axis), "end") } else { ((left - 40.0).max(4.0), "start") };
    html! {
        @if !on_right {
            path class="grid" d={
                @for tick in axis.ticks() { "M" (Px(left)) " " (Px(scale.at(tick))) "H" (Px(right)) }
            } {}
            @if axis.domain[0] < 0.0 && axis.domain[1] > 0.0 {
                path class="zero" d=(svg::path(&[vec![[left, scale.at(0.0)], [right, scale.at(0.0)]]])) {}
            }
        }
        g class="ticks" text-anchor=(anchor) {
            @for tick in axis.ticks() {
                text x=(Px(x + gap)) y=(Px(scale.at(tick) + 4.0)) { (tick_label(tick, axis.step)) }
            }
        }
        text class="label" x=(Px(name_x)) y=(Px(top - 11.0)) text-anchor=(name_anchor) {
            (axis.label)
        }
    }
}

fn drawn_area(area: &Area, time: &Scale, scale: &Scale) -> Markup {
    let mut d = String::new();
    for piece in &area.pieces {
        let edge = |k: usize| scale::thin(piece.iter().map(|point| [time.at(point[0]), scale.within(point[k])]));
        for (low, high) in edge(1).into_iter().zip(edge(2)) {
            let around = high.into_iter().chain(low.into_iter().rev()).collect();
            d += &format!("{}Z", svg::path(&[around]));
        }
    }
    html! { path class=(area.class) d=(d) {} }
}

/// A row each: its name, its marks (above or below the middle, as the limit is an upper or lower one), its note.
fn rows_of_marks(rows: &[Row], time: &Scale, top: f64, width: f64) -> Markup {
    let [left, right] = time.range;
    html! {
        @for (index, row) in rows.iter().enumerate() {
            @let y = top + ROW * (index as f64 + 0.5);
            path class="grid" d=(svg::path(&[vec![[left, y], [right, y]]])) {}
            path class={ "span " (row.class) } d=(marks(row, time, y)) {}
            text class="ticks" x=(Px(left - 8.0)) y=(Px(y + 4.0)) text-anchor="end" { (row.label) }
            text class="ticks" x=(Px(width - 4.0)) y=(Px(y + 4.0)) text-anchor="end" { (row.note) }
        }
    }
}

/// The marks of a row, half a pixel apart at the least, so that a path stays short however often a limit is hit.
fn marks(row: &Row, time: &Scale, y: f64) -> String {
    let mut drawn = BTreeSet::new();
    let mut d = String::new();
    for &([from, to], side) in &row.spans {
        let [from, to] = [from, to].map(|t| (2.0 * time.within(t)).floor() / 2.0);
        let to = to.max(from + 0.5);
        if !drawn.insert(((2.0 * from) as i64, (2.0 * to) as i64, side)) {
            continue;
        }
        let (above, below) = (if side < 0 { 0.0 } else { 6.0 }, if side > 0 { 0.0 } else { 6.0 });
        d += &format!("M{} {}H{}V{}H{}Z", Px(from), Px(y - above), Px(to), Px(y + below), Px(from));
    }
    d
}
