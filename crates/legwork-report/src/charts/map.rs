//! Maps: cells in colours with their numbers, as a matrix of texts or over two quantities; where a robot fell and stood.

use legwork_study::rollout::DOUBTFUL;
use maud::{Markup, html};

use super::axis::{Axis, Quantity};
use super::chart::{Chart, Part, reach};
use super::colours::Colours;
use super::layer::Layer;
use super::numbers::Px;
use super::plot::Plot;
use super::svg::{self, Drawing, Key, Symbol, text_width};

/// Cells of one coordinate system.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    cells: Vec<Cell>,
    colours: Option<Colours>,
}

/// A rectangle and what it holds.
#[derive(Clone, Copy, Debug)]
struct Cell {
    x: [f64; 2],
    y: [f64; 2],
    holds: Holds,
    /// Whether it broke bounds of the simulation; it then has a ring.
    doubtful: bool,
}

/// What came of a pair of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Holds {
    /// The robot stood, with this figure; not a number where there is none.
    Value(f64),
    Fell,
    /// Nothing is known.
    Nothing,
}

/// A matrix.
#[derive(Clone, Debug)]
pub(crate) struct HeatMap {
    /// What the rows are; may be empty.
    pub(crate) row_title: String,
    /// What the columns are; may be empty.
    pub(crate) column_title: String,
    pub(crate) rows: Vec<String>,
    pub(crate) columns: Vec<String>,
    /// What the cells hold.
    pub(crate) value: Quantity,
    /// Row by row; not a number where there is nothing to show.
    pub(crate) cells: Vec<Vec<f64>>,
    /// The value in the middle of the colours, where less than it and more than it are to be told apart.
    pub(crate) centre: Option<f64>,
    /// Row and column of what broke bounds of the simulation.
    pub(crate) doubtful: Vec<[usize; 2]>,
}

/// Where in a plane of two parameters a robot stood and where it fell.
#[derive(Clone, Debug)]
pub(crate) struct SurvivalMap {
    pub(crate) x: Quantity,
    pub(crate) y: Quantity,
    /// What shades the cells where it stood.
    pub(crate) shade: Option<Quantity>,
    /// What came of each pair of x and y.
    pub(crate) cells: Vec<([f64; 2], Holds)>,
    /// The pairs that broke bounds of the simulation.
    pub(crate) doubtful: Vec<[f64; 2]>,
}

/// Height of a row of a matrix, and of all cells of a plane [px].
const ROW: f64 = 28.0;
const HEIGHT: f64 = 300.0;
/// Between two hatches [px].
const HATCH: f64 = 7.0;

impl HeatMap {
    /// Draws it `width` wide [px]. Numbers are left out where they do not fit.
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let values: Vec<f64> = self.cells.iter().flatten().copied().collect();
        let colours = Colours::of(&values, self.centre);
        let around = |index: usize| [index as f64 - 0.5, index as f64 + 0.5];
        let cell = |row: usize, column: usize| {
            let value = self.cells.get(row).and_then(|cells| cells.get(column)).copied().unwrap_or(f64::NAN);
            let holds = if value.is_finite() { Holds::Value(value) } else { Holds::Nothing };
            Cell { x: around(column), y: around(row), holds, doubtful: self.doubtful.contains(&[row, column]) }
        };
        let cells = (0..self.rows.len()).flat_map(|row| (0..self.columns.len()).map(move |column| cell(row, column)));
        let layer = Layer::Cells(Cells { cells: cells.collect(), colours: Some(colours.clone()) });
        let part = Part {
            y: Axis::of_texts(&self.row_title, self.rows.clone()),
            height: ROW * self.rows.len() as f64,
            layers: vec![layer],
            notes: Vec::new(),
        };
        let chart = Chart::of(Axis::of_texts(&self.column_title, self.columns.clone()), part);
        Chart { colours: Some((self.value.clone(), colours)), ..chart }.draw(width)
    }
}

impl SurvivalMap {
    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let values = self
            .cells
            .iter()
            .filter_map(|(_, holds)| if let Holds::Value(value) = holds { Some(*value) } else { None });
        let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let shade = self.shade.clone().filter(|_| !values.is_empty());
        let colours = shade.map(|quantity| (quantity, Colours::of(&values, None)));
        let [xs, ys] = [0, 1].map(|k| distinct(self.cells.iter().map(|(at, _)| at[k])));
        if xs.is_empty() || ys.is_empty() {
            return super::no_data(width);
        }
        let [x, y] = [edges(&xs, self.x.log), edges(&ys, self.y.log)];
        let grid = self.grid(&xs, &ys);
        let mut cells = Vec::new();
        for (column, x) in x.windows(2).enumerate() {
            for (row, y) in y.windows(2).enumerate() {
                let doubtful = self.doubtful.contains(&[xs[column], ys[row]]);
                cells.push(Cell { x: [x[0], x[1]], y: [y[0], y[1]], holds: grid[column][row], doubtful });
            }
        }
        let limit = boundary(&grid, &x, &y);
        let label = if limit.is_empty() { "" } else { "limit" };
        let layers = vec![
            Layer::Cells(Cells { cells, colours: colours.as_ref().map(|(_, colours)| colours.clone()) }),
            Layer::line(label, "boundary", limit),
        ];
        let ends = |edges: &[f64]| [edges[0], edges[edges.len() - 1]];
        let part = Part { y: Axis::exactly(self.y.clone(), ends(&y)), height: HEIGHT, layers, notes: Vec::new() };
        Chart { colours, ..Chart::of(Axis::exactly(self.x.clone(), ends(&x)), part) }.draw(width)
    }

    /// What came of each pair, by columns and then rows.
    fn grid(&self, xs: &[f64], ys: &[f64]) -> Vec<Vec<Holds>> {
        let mut grid = vec![vec![Holds::Nothing; ys.len()]; xs.len()];
        let place = |all: &[f64], value: f64| all.iter().position(|other| other.total_cmp(&(value + 0.0)).is_eq());
        for ([x, y], holds) in &self.cells {
            if let (Some(column), Some(row)) = (place(xs, *x), place(ys, *y)) {
                grid[column][row] = *holds;
            }
        }
        grid
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

/// The edges between cells of which one stood and the other fell, as pieces of a line.
fn boundary(grid: &[Vec<Holds>], x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
    let at = |column: usize, row: usize| {
        grid.get(column).and_then(|cells| cells.get(row)).copied().unwrap_or(Holds::Nothing)
    };
    let differ =
        |a: Holds, b: Holds| a != Holds::Nothing && b != Holds::Nothing && (a == Holds::Fell) != (b == Holds::Fell);
    let mut line = Vec::new();
    for column in 0..grid.len() {
        for row in 0..y.len() - 1 {
            if differ(at(column, row), at(column + 1, row)) {
                line.extend([[x[column + 1], y[row]], [x[column + 1], y[row + 1]], [f64::NAN; 2]]);
            }
            if differ(at(column, row), at(column, row + 1)) {
                line.extend([[x[column], y[row + 1]], [x[column + 1], y[row + 1]], [f64::NAN; 2]]);
            }
        }
    }
    line
}

impl Cells {
    fn values(&self) -> impl Iterator<Item = f64> {
        self.cells.iter().filter_map(|cell| if let Holds::Value(value) = cell.holds { Some(value) } else { None })
    }

    fn falls(&self) -> usize {
        self.cells.iter().filter(|cell| cell.holds == Holds::Fell).count()
    }

    fn doubtful(&self) -> usize {
        self.cells.iter().filter(|cell| cell.doubtful).count()
    }

    pub(super) fn is_to_be_seen(&self) -> bool {
        self.falls() > 0 || self.values().next().is_some()
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let dots = self.values().any(|value| !value.is_finite() || self.colours.is_none());
        let keys = [
            (dots, Key::new(Symbol::Dot, "stood", "survived")),
            (self.falls() > 0, Key::new(Symbol::Cross, "", "fell")),
            (self.doubtful() > 0, Key::new(Symbol::Ring, "", DOUBTFUL)),
        ];
        keys.into_iter().filter(|(shown, _)| *shown).map(|(_, key)| key).collect()
    }

    pub(super) fn words(&self) -> Vec<String> {
        let fell = format!("{} of {} fell", self.falls(), self.cells.len());
        let doubtful = format!("{} {DOUBTFUL}", self.doubtful());
        let counts = [(self.falls() > 0, fell), (self.doubtful() > 0, doubtful)];
        let counts = counts.into_iter().filter(|(any, _)| *any).map(|(_, words)| words);
        reach(self.values()).into_iter().chain(counts).collect()
    }

    pub(super) fn draw(&self, plot: &Plot) -> Markup {
        let places: Vec<[[f64; 2]; 2]> = self
            .cells
            .iter()
            .map(|cell| {
                let ([left, right], mut rows) = (cell.x.map(|x| plot.x.at(x)), cell.y.map(|y| plot.y.at(y)));
                rows.sort_by(f64::total_cmp);
                [[left, right], rows]
            })
            .collect();
        let number = |value: f64| self.colours.as_ref().map_or(String::new(), |colours| colours.number(value));
        let finite = self.values().filter(|value| value.is_finite());
        let widest = finite.map(|value| text_width(&number(value))).fold(0.0, f64::max);
        let room = |[[left, right], [top, bottom]]: &[[f64; 2]; 2]| right - left > widest + 4.0 && bottom - top > 15.0;
        let numbered = places.iter().all(room);
        html! {
            @for (cell, [[left, right], [top, bottom]]) in self.cells.iter().zip(&places) {
                @let (middle, size) = ([0.5 * (left + right), 0.5 * (top + bottom)], [right - left, bottom - top]);
                @let (x, y, wide, high) = (Px(*left), Px(*top), Px(size[0]), Px(size[1]));
                @match (cell.holds, &self.colours) {
                    (Holds::Nothing, _) => rect class="missing" x=(x) y=(y) width=(wide) height=(high) {},
                    (Holds::Fell, _) => {
                        rect class="fell-band" x=(x) y=(y) width=(wide) height=(high) {}
                        path class="hatch" d=(hatch([*left, *right], [*top, *bottom])) {}
                        path class="cross" d=(svg::cross(middle, radius(size))) {}
                    }
                    (Holds::Value(value), Some(colours)) if value.is_finite() => {
                        @let (colour, class) = colours.at(value);
                        rect class="cell" x=(x) y=(y) width=(wide) height=(high) fill=(colour) {}
                        @if numbered {
                            text class={ "small " (class) } x=(Px(middle[0])) y=(Px(middle[1] + 4.0)) text-anchor="middle" {
                                (number(value))
                            }
                        }
                    }
                    (Holds::Value(_), _) => {
                        rect class="cell survived" x=(x) y=(y) width=(wide) height=(high) {}
                        circle class="stood" cx=(Px(middle[0])) cy=(Px(middle[1])) r=(Px(radius(size).min(3.0))) {}
                    }
                }
                // In the corner, where it hides no number.
                @if cell.doubtful {
                    path class="doubtful" d=(svg::shape(0, [*right - radius(size) - 2.0, *top + radius(size) + 2.0], radius(size))) {}
                }
            }
        }
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
    fn plane(shade: Option<Quantity>) -> SurvivalMap {
        let cell = |k: u32| {
            let (x, y) = (f64::from(k % 4), f64::from(k / 4));
            ([x, y], if y < x { Holds::Fell } else { Holds::Value(y - x) })
        };
        SurvivalMap {
            x: Quantity::default(),
            y: Quantity::default(),
            shade,
            cells: (0..16).map(cell).collect(),
            doubtful: Vec::new(),
        }
    }

    fn matrix() -> HeatMap {
        HeatMap {
            row_title: String::new(),
            column_title: String::new(),
            rows: vec!["a".into(), "b".into(), "c".into()],
            columns: vec!["a".into(), "b".into(), "c".into()],
            value: Quantity::new("index", ""),
            cells: vec![vec![f64::NAN, 0.25, 0.5], vec![f64::NAN, f64::NAN, 1.0], vec![f64::NAN; 2]],
            centre: None,
            doubtful: Vec::new(),
        }
    }

    #[test]
    fn every_cell_has_its_number_or_none() {
        let text = matrix().draw(860.0).content.into_string();
        assert_eq!(text.matches("class=\"cell\"").count(), 3);
        assert_eq!(text.matches("class=\"missing\"").count(), 6, "one was not even given");
        for number in [">0.25<", ">0.50<", ">1.00<"] {
            assert_eq!(text.matches(number).count(), 1, "{number}");
        }
    }

    #[test]
    fn the_first_row_is_the_uppermost() {
        let text = matrix().draw(860.0).content.into_string();
        let height = |number: &str| -> f64 {
            let before = text.split(number).next().expect("it is there");
            let tag = before.rsplit("<text").next().expect("a tag");
            tag.split(" y=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse().ok()).expect("a number")
        };
        assert!(height(">0.25<") < height(">1.00<"));
    }

    #[test]
    fn numbers_that_do_not_fit_are_left_out() {
        let mut map = matrix();
        map.columns = (0..12).map(|k| k.to_string()).collect();
        map.cells = vec![vec![0.25; 12], vec![1.0; 12], vec![0.0; 12]];
        assert_eq!(map.draw(860.0).content.into_string().matches(">0.25<").count(), 12);
        let narrow = map.draw(380.0).content.into_string();
        assert!(!narrow.contains(">0.25<") && narrow.matches("class=\"cell\"").count() == 36);
    }

    #[test]
    fn falls_have_crosses_and_hatches_and_the_others_dots() {
        let text = plane(None).draw(860.0).content.into_string();
        assert_eq!(text.matches("class=\"cross\"").count(), 6);
        assert_eq!(text.matches("class=\"hatch\"").count(), 6);
        assert_eq!(text.matches("<circle class=\"stood\"").count(), 10 + 1, "with that of the legend");
        let shaded = plane(Some(Quantity::default())).draw(860.0).content.into_string();
        assert_eq!(shaded.matches("class=\"cross\"").count(), 6);
        assert_eq!(shaded.matches("class=\"cell\"").count(), 10);
        assert!(shaded.contains(">limit<") && shaded.contains(">fell<") && !shaded.contains(">survived<"));
    }

    #[test]
    fn what_broke_bounds_has_a_ring_and_an_entry_in_the_legend() {
        let rings = |drawing: Drawing| {
            (drawing.content.into_string().matches("class=\"doubtful\"").count(), drawing.description)
        };
        let doubtful = SurvivalMap { doubtful: vec![[0.0, 0.0], [3.0, 3.0]], ..plane(None) };
        let (count, words) = rings(doubtful.draw(860.0));
        assert!(count == 2 + 1 && words.contains("2 broke bounds of the simulation"), "{count}: {words}");
        assert_eq!(rings(HeatMap { doubtful: vec![[0, 1]], ..matrix() }.draw(860.0)).0, 1 + 1);
        assert_eq!(rings(plane(None).draw(860.0)).0, 0);
    }

    #[test]
    fn the_limit_runs_between_standing_and_falling() {
        let levels = [0.0, 1.0, 2.0, 3.0];
        let line = |map: &SurvivalMap| {
            boundary(&map.grid(&levels, &levels), &edges(&levels, false), &edges(&levels, false)).len() / 3
        };
        assert_eq!(line(&plane(None)), 6, "a staircase of three steps has three treads and three risers");
        let mut stood = plane(None);
        stood.cells.retain(|(_, holds)| *holds != Holds::Fell);
        assert_eq!(line(&stood), 0, "nothing is known beyond");
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
