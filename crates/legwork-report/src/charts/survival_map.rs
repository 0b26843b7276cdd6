//! Where in a plane of two parameters a robot stood and where it fell.

use maud::{Markup, html};

use super::axis::{Quantity, Ruler};
use super::colours::Colours;
use super::frame::{self, GAP};
use super::no_data;
use crate::scale::Px;
use crate::svg::{self, Drawing, Key, Symbol, text_width};

/// Cells at the values of two parameters.
#[derive(Clone, Debug)]
pub(crate) struct SurvivalMap {
    pub(crate) x: Quantity,
    pub(crate) y: Quantity,
    /// What shades the cells where it stood.
    pub(crate) shade: Option<Quantity>,
    pub(crate) cells: Vec<Cell>,
}

/// What came of a pair of values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) outcome: CellOutcome,
}

/// Whether the robot fell.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CellOutcome {
    /// It stood, this well; not a number where that is not known.
    Survived(f64),
    Fell,
}

/// Height of the cells together [px].
const HEIGHT: f64 = 300.0;
/// Between two hatches [px].
const HATCH: f64 = 7.0;

/// The axes, and the edges of the cells along each [px].
struct Plane {
    x: Ruler,
    y: Ruler,
    columns: Vec<[f64; 2]>,
    rows: Vec<[f64; 2]>,
    /// What came of each pair, by columns and then rows.
    outcomes: Vec<Vec<Option<CellOutcome>>>,
}

impl SurvivalMap {
    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        if !self.cells.iter().any(|cell| cell.x.is_finite() && cell.y.is_finite()) {
            return no_data(width);
        }
        let shades: Vec<f64> = self.cells.iter().filter_map(|cell| survived(&cell.outcome)).collect();
        let shade = self.shade.as_ref().filter(|_| shades.iter().any(|value| value.is_finite()));
        let colours = shade.map(|quantity| (quantity, Colours::of(&shades, None)));
        let bar = colours.as_ref().map_or(0.0, |(quantity, colours)| colours.bar_width(quantity) + 20.0);
        let title = colours.as_ref().map_or(0.0, |(quantity, colours)| colours.title_width(quantity));
        let (legend, legend_height) = svg::legend(&self.keys(colours.is_some()), 4.0, width);
        // The title of the bar stands beside that of the vertical axis, or else above it.
        let beside = text_width(&self.y.title(0)) + title + 70.0 < width;
        let top = legend_height + if beside { 30.0 } else { 46.0 };
        let plane = self.plane([top, top + HEIGHT], width - bar - 8.0);
        let [left, right] = plane.x.range();
        let bottom = top + HEIGHT;
        let content = html! {
            (legend)
            (plane.cells(colours.as_ref().map(|(_, colours)| colours)))
            path class="line boundary" d=(plane.boundary()) {}
            (frame::horizontal(&plane.x, [top, bottom], false, true))
            (frame::vertical(&plane.y, [left, right], false))
            text class="label" x="4" y=(Px(top - 11.0)) { (plane.y.title) }
            text class="label" x=(Px(0.5 * (left + right))) y=(Px(bottom + 38.0)) text-anchor="middle" { (plane.x.title) }
            @if let Some((quantity, colours)) = &colours { (colours.bar(quantity, width - 4.0, [top, bottom], legend_height + 19.0)) }
        };
        Drawing { width, height: bottom + 46.0, description: self.describe(), time_axis: None, content }
    }

    fn keys(&self, shaded: bool) -> Vec<Key> {
        let stood = self.cells.iter().any(|cell| survived(&cell.outcome).is_some());
        let fell = self.cells.iter().any(|cell| survived(&cell.outcome).is_none());
        let keys = [
            (stood && !shaded, Key::new(Symbol::Dot, "stood", "survived")),
            (fell, Key::new(Symbol::Cross, "", "fell")),
            (stood && fell, Key::new(Symbol::Line, "boundary", "limit")),
        ];
        keys.into_iter().filter(|(shown, _)| *shown).map(|(_, key)| key).collect()
    }

    fn plane(&self, [top, bottom]: [f64; 2], right: f64) -> Plane {
        let [xs, ys] = [distinct(self.cells.iter().map(|cell| cell.x)), distinct(self.cells.iter().map(|cell| cell.y))];
        let [x_edges, y_edges] = [edges(&xs, self.x.log), edges(&ys, self.y.log)];
        let y = Ruler::of_cells(&self.y, &y_edges, [bottom, top], 34.0);
        let x = Ruler::of_cells(&self.x, &x_edges, [y.widest() + GAP + 6.0, right], 56.0);
        let between = |edges: &[f64], ruler: &Ruler| -> Vec<[f64; 2]> {
            edges.windows(2).map(|pair| [ruler.at(pair[0]), ruler.at(pair[1])]).collect()
        };
        let mut outcomes = vec![vec![None; ys.len()]; xs.len()];
        for cell in &self.cells {
            let place = |all: &[f64], value: f64| all.iter().position(|other| other.total_cmp(&value).is_eq());
            if let (Some(column), Some(row)) = (place(&xs, cell.x), place(&ys, cell.y)) {
                outcomes[column][row] = Some(cell.outcome);
            }
        }
        Plane { columns: between(&x_edges, &x), rows: between(&y_edges, &y), x, y, outcomes }
    }

    fn describe(&self) -> String {
        let fell = self.cells.iter().filter(|cell| survived(&cell.outcome).is_none()).count();
        format!("{} over {}: {fell} of {} fell.", self.y.title(0), self.x.title(0), self.cells.len())
    }
}

/// How well it stood, if it stood.
fn survived(outcome: &CellOutcome) -> Option<f64> {
    match outcome {
        CellOutcome::Survived(value) => Some(*value),
        CellOutcome::Fell => None,
    }
}

/// The finite ones of `values` in order, each once.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    // Adding zero makes one of the two zeros.
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).map(|value| value + 0.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The edges of cells around `values`: halfway between two, and as far beyond the first and the last.
fn edges(values: &[f64], log: bool) -> Vec<f64> {
    let log = log && values.iter().all(|value| *value > 0.0);
    let places: Vec<f64> = values.iter().map(|value| if log { value.ln() } else { *value }).collect();
    let last = places.len() - 1;
    let halves: Vec<f64> = places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let alone = if places[0] == 0.0 || log { 0.5 } else { 0.1 * places[0].abs() };
    let first = halves.first().map_or(places[0] - alone, |half| 2.0 * places[0] - half);
    let end = halves.last().map_or(places[last] + alone, |half| 2.0 * places[last] - half);
    let all = [first].into_iter().chain(halves).chain([end]);
    all.map(|place| if log { place.exp() } else { place }).collect()
}

impl Plane {
    fn cells(&self, colours: Option<&Colours>) -> Markup {
        html! {
            @for (column, &[left, right]) in self.columns.iter().enumerate() {
                @for (row, &[bottom, top]) in self.rows.iter().enumerate() {
                    @let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
                    @let size = [right - left, bottom - top];
                    @let (x, y, wide, high) = (Px(left), Px(top), Px(size[0]), Px(size[1]));
                    @match (self.outcomes[column][row], colours) {
                        (None, _) => {}
                        (Some(CellOutcome::Fell), _) => {
                            rect class="fell-band" x=(x) y=(y) width=(wide) height=(high) {}
                            path class="hatch" d=(hatch([left, right], [top, bottom])) {}
                            path class="cross" d=(svg::cross(middle, radius(size))) {}
                        }
                        (Some(CellOutcome::Survived(value)), Some(colours)) if value.is_finite() => {
                            @let (colour, class) = colours.at(value);
                            rect class="cell" x=(x) y=(y) width=(wide) height=(high) fill=(colour) {}
                            @if text_width(&colours.number(value)) + 4.0 < size[0] && size[1] > 15.0 {
                                text class={ "small " (class) } x=(Px(middle[0])) y=(Px(middle[1] + 4.0)) text-anchor="middle" {
                                    (colours.number(value))
                                }
                            }
                        }
                        (Some(CellOutcome::Survived(_)), _) => {
                            rect class="cell survived" x=(x) y=(y) width=(wide) height=(high) {}
                            circle class="stood" cx=(Px(middle[0])) cy=(Px(middle[1])) r=(Px(radius(size).min(3.0))) {}
                        }
                    }
                }
            }
        }
    }

    /// The edges between cells of which one stood and the other fell.
    fn boundary(&self) -> String {
        let fell = |column: usize, row: usize| self.outcomes[column][row].map(|outcome| survived(&outcome).is_none());
        let differ = |a: Option<bool>, b: Option<bool>| a.is_some() && b.is_some() && a != b;
        let mut pieces = Vec::new();
        for (column, &[left, right]) in self.columns.iter().enumerate() {
            for (row, &[bottom, top]) in self.rows.iter().enumerate() {
                if column + 1 < self.columns.len() && differ(fell(column, row), fell(column + 1, row)) {
                    pieces.push(vec![[right, bottom], [right, top]]);
                }
                if row + 1 < self.rows.len() && differ(fell(column, row), fell(column, row + 1)) {
                    pieces.push(vec![[left, top], [right, top]]);
                }
            }
        }
        svg::path(&pieces)
    }
}

/// How large a mark a cell of a size has [px].
fn radius(size: [f64; 2]) -> f64 {
    (0.3 * size[0].min(size[1])).clamp(1.5, 4.5)
}

/// Lines that rise by one in one through a rectangle, continued from one rectangle to the next.
fn hatch([left, right]: [f64; 2], [top, bottom]: [f64; 2]) -> String {
    // On each line x + y is the same.
    let (first, last) = (((left + top) / HATCH).ceil() as i64, ((right + bottom) / HATCH).floor() as i64);
    let lines = (first..=last).map(|line| {
        let sum = line as f64 * HATCH;
        let (from, to) = (left.max(sum - bottom), right.min(sum - top));
        vec![[from, sum - from], [to, sum - to]]
    });
    svg::path(&lines.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It stands where y is not below x.
    fn example() -> SurvivalMap {
        let cell = |k: u32| {
            let (x, y) = (f64::from(k % 4), f64::from(k / 4));
            Cell { x, y, outcome: if y < x { CellOutcome::Fell } else { CellOutcome::Survived(y - x) } }
        };
        SurvivalMap { x: Quantity::default(), y: Quantity::default(), shade: None, cells: (0..16).map(cell).collect() }
    }

    #[test]
    fn falls_have_crosses_and_hatches_and_the_others_dots() {
        let text = example().draw(860.0).content.into_string();
        assert_eq!(text.matches("class=\"cross\"").count(), 6);
        assert_eq!(text.matches("class=\"hatch\"").count(), 6);
        assert_eq!(text.matches("<circle class=\"stood\"").count(), 10 + 1, "with that of the legend");
        let shaded = SurvivalMap { shade: Some(Quantity::default()), ..example() }.draw(860.0).content.into_string();
        assert_eq!(shaded.matches("class=\"cross\"").count(), 6);
        assert_eq!(shaded.matches("class=\"cell\"").count(), 10);
        assert!(shaded.contains(">limit<") && shaded.contains(">fell<") && !shaded.contains(">survived<"));
    }

    #[test]
    fn the_limit_runs_between_standing_and_falling() {
        // A staircase of three steps has three treads and three risers.
        let plane = example().plane([0.0, 400.0], 400.0);
        assert_eq!(plane.boundary().matches('M').count(), 6);
        let stood: Vec<Cell> = example().cells.into_iter().filter(|cell| survived(&cell.outcome).is_some()).collect();
        assert_eq!(
            SurvivalMap { cells: stood, ..example() }.plane([0.0, 400.0], 400.0).boundary(),
            "",
            "nothing is known beyond"
        );
    }

    #[test]
    fn edges_lie_halfway() {
        assert_eq!(edges(&[1.0, 2.0, 4.0], false), [0.5, 1.5, 3.0, 5.0]);
        let ratios = edges(&[1.0, 4.0, 16.0], true);
        for (edge, expected) in ratios.iter().zip([0.5, 2.0, 8.0, 32.0]) {
            assert!((edge / expected - 1.0).abs() < 1e-12, "{ratios:?}");
        }
        for alone in [0.0, 3.0, -3.0] {
            let ends = edges(&[alone], false);
            assert!(ends[0] < alone && alone < ends[1]);
        }
    }

    #[test]
    fn hatches_stay_in_their_cell() {
        let path = hatch([10.0, 40.0], [20.0, 30.0]);
        let numbers: Vec<f64> = path.split(['M', 'L', ' ']).filter_map(|text| text.parse().ok()).collect();
        assert_eq!(numbers.len(), 4 * 6, "x + y is 35, 42, … 70");
        assert!(numbers.chunks(2).all(|p| (10.0..=40.0).contains(&p[0]) && (20.0..=30.0).contains(&p[1])), "{path}");
    }
}
