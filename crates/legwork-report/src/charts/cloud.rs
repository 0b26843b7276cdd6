//! Thousands of points as the density of their cells, with curves along which the product of both values is the same.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::axis::Ruler;
use super::numbers::Px;
use super::plot::Plot;
use super::svg::{self, Key, Symbol};

/// Many points of one coordinate system.
#[derive(Clone, Debug)]
pub(crate) struct Cloud {
    /// Those that are not finite are left out.
    pub(crate) points: Vec<[f64; 2]>,
    /// Products of both values whose curves are drawn, in all four quadrants.
    pub(crate) products: Vec<f64>,
    /// What the products are.
    pub(crate) product: String,
    /// How many coordinate systems a drawing has: the more, the fewer cells in each.
    pub(crate) among: usize,
}

/// Most cells of all coordinate systems of a drawing together, and of one.
const CELLS: f64 = 6000.0;
const MOST_CELLS: f64 = 1500.0;
/// Points in a cell from which on it has the next stronger shade.
const LEVELS: [usize; 5] = [1, 3, 10, 30, 100];
/// Steps of a curve of equal products.
const STEPS: usize = 40;

impl Cloud {
    pub(super) fn keys(&self) -> Vec<Key> {
        let level = |(index, &from): (usize, &usize)| {
            let label = match LEVELS.get(index + 1) {
                Some(next) => format!("{from} to {}", next - 1),
                None => format!("{from} and more points"),
            };
            Key::new(Symbol::Area, &format!("cloud level-{index}"), &label)
        };
        let mut keys: Vec<Key> = LEVELS.iter().enumerate().map(level).collect();
        if !self.products.is_empty() {
            keys.push(Key::new(Symbol::Line, "power", &self.product));
        }
        keys
    }

    pub(super) fn draw(&self, plot: &Plot) -> Markup {
        html! {
            (density(&self.points, plot, (CELLS / self.among.max(1) as f64).min(MOST_CELLS)))
            @for &product in self.products.iter().filter(|product| product.is_finite() && **product > 0.0) {
                (power(product, &plot.x, &plot.y, &self.points))
            }
        }
    }
}

/// How far a domain reaches from zero to one side.
fn reach(domain: [f64; 2], sign: f64) -> f64 {
    if sign > 0.0 { domain[1].max(0.0) } else { (-domain[0]).max(0.0) }
}

/// Square cells with points in them, at most `cells`, as a path for each shade.
fn density(points: &[[f64; 2]], plot: &Plot, cells: f64) -> Markup {
    let ([left, right], [top, bottom]) = (plot.x.range(), plot.rows());
    let side = ((right - left) * (bottom - top) / cells).sqrt().max(3.0);
    let mut counts: BTreeMap<[i64; 2], usize> = BTreeMap::new();
    for [x, y] in plot.all(points) {
        let cell = [(x - left) / side, (bottom - y) / side];
        *counts.entry(cell.map(|place| place.floor() as i64)).or_default() += 1;
    }
    let mut paths = [const { String::new() }; LEVELS.len()];
    for ([column, row], count) in counts {
        let level = LEVELS.iter().rposition(|least| count >= *least).unwrap_or(0);
        let (from, to) = (left + side * column as f64, (left + side * (column + 1) as f64).min(right));
        let (low, high) = (bottom - side * row as f64, (bottom - side * (row + 1) as f64).max(top));
        paths[level] += &format!("M{} {}H{}V{}H{}Z", Px(from), Px(low), Px(to), Px(high), Px(from));
    }
    html! {
        @for (level, d) in paths.iter().enumerate().filter(|(_, d)| !d.is_empty()) {
            path class={ "cloud level-" (level) } d=(d) {}
        }
    }
}

/// The curve of a product in all quadrants, with its number on a diagonal, in the emptiest quadrant.
fn power(product: f64, x: &Ruler, y: &Ruler, points: &[[f64; 2]]) -> Markup {
    let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let branches = signs.map(|sign| (sign, [reach(x.domain(), sign[0]), reach(y.domain(), sign[1])]));
    let branches: Vec<_> = branches.into_iter().filter(|(_, [far, high])| far * high > product).collect();
    let line = |&([a, b], [far, high]): &([f64; 2], [f64; 2])| -> Vec<[f64; 2]> {
        let near = product / high;
        let places = (0..=STEPS).map(|k| near * (far / near).powf(k as f64 / STEPS as f64));
        places.map(|place| [x.at(a * place), y.at(b * product / place)]).collect()
    };
    let middle = |&([a, b], [far, high]): &([f64; 2], [f64; 2])| {
        let place = (product * far / high).sqrt();
        [x.at(a * place), y.at(b * product / place)]
    };
    let hidden = |number: &[f64; 2]| {
        let near =
            |point: &&[f64; 2]| (x.at(point[0]) - number[0]).abs() < 12.0 && (y.at(point[1]) - number[1]).abs() < 8.0;
        points.iter().filter(near).count()
    };
    html! {
        path class="line power" d=(svg::path(&branches.iter().map(line).collect::<Vec<_>>())) {}
        @if let Some([x, y]) = branches.iter().map(middle).min_by_key(hidden) {
            text class="small halo" x=(Px(x)) y=(Px(y + 4.0)) text-anchor="middle" { (product) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::axis::{Axis, Quantity};

    fn plot() -> Plot {
        let ruler = |values: [f64; 2], range| Axis::around(Quantity::default(), values).on(range, 40.0);
        Plot { x: ruler([-10.0, 10.0], [0.0, 200.0]), y: ruler([-150.0, 150.0], [180.0, 0.0]) }
    }

    #[test]
    fn however_many_points_there_are_few_cells() {
        let points: Vec<[f64; 2]> =
            (0..200_000).map(|k| [10.0 * (f64::from(k) * 0.7).sin(), 150.0 * (f64::from(k) * 1.3).cos()]).collect();
        let text = density(&points, &plot(), MOST_CELLS).into_string();
        assert!((500..=1600).contains(&text.matches('M').count()), "{}", text.matches('M').count());
    }

    #[test]
    fn denser_cells_are_stronger() {
        let mut points = vec![[-5.0, 50.0]];
        points.extend(vec![[5.0, 50.0]; 30]);
        points.extend([[f64::NAN, 1.0], [1.0, f64::INFINITY]]);
        let text = density(&points, &plot(), MOST_CELLS).into_string();
        assert_eq!(text.matches('M').count(), 2);
        assert!(text.contains("level-0") && text.contains("level-3"), "{text}");
    }

    #[test]
    fn the_product_is_the_same_along_its_curve() {
        let Plot { x, y } = plot();
        let text = power(300.0, &x, &y, &[]).into_string();
        let path = text.split(" d=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a path");
        assert_eq!(path.matches('M').count(), 4, "a branch in each quadrant");
        let value = |ruler: &Ruler, at: f64| {
            let ([from, to], [start, end]) = (ruler.domain(), ruler.range());
            from + (at - start) / (end - start) * (to - from)
        };
        let numbers: Vec<f64> = path.split(['M', 'L', ' ']).filter_map(|text| text.parse().ok()).collect();
        for point in numbers.chunks(2) {
            let (a, b) = (value(&x, point[0]), value(&y, point[1]));
            // Half of a tenth of a pixel.
            let rounding = 0.05 * (b.abs() * 22.8 / 200.0 + a.abs() * 342.0 / 180.0) + 0.01;
            assert!(((a * b).abs() - 300.0).abs() < rounding, "{a} times {b}");
        }
        assert!(text.contains(">300<"));
        assert!(!power(1e9, &x, &y, &[]).into_string().contains('M'), "it is nowhere on the paper");
    }
}
