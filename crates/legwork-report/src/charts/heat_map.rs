//! A matrix in colours, with its numbers.

use maud::{Markup, html};

use super::axis::{Quantity, Ruler, shortened};
use super::colours::Colours;
use super::frame::{self, GAP};
use super::no_data;
use crate::scale::Px;
use crate::svg::{Drawing, text_width};

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
}

/// Height and greatest width of a cell [px].
const ROW: f64 = 28.0;
const WIDEST: f64 = 92.0;
/// Least height of the bar of colours [px].
const BAR: f64 = 112.0;

impl HeatMap {
    /// Draws it `width` wide [px]. Numbers are left out where they do not fit.
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        let values: Vec<f64> = self.cells.iter().flatten().copied().filter(|value| value.is_finite()).collect();
        if values.is_empty() {
            return no_data(width);
        }
        let colours = Colours::of(&values, self.centre);
        let bar = colours.bar_width(&self.value) + 4.0;
        let rows: Vec<String> = self.rows.iter().map(|row| shortened(row, 0.34 * width)).collect();
        let labels = rows.iter().map(|row| text_width(row)).fold(text_width(&self.row_title), f64::max) + GAP + 4.0;
        let ruler = |left: f64| {
            let right = (width - bar - 24.0).min(left + WIDEST * self.columns.len() as f64);
            let columns: Vec<String> = self.columns.iter().map(|column| shortened(column, 150.0)).collect();
            Ruler::of_texts(&self.column_title, &columns, [left, right])
        };
        let left = labels.max(ruler(labels).needs()[1]);
        let columns = ruler(left);
        let [_, right] = columns.range();
        let end = right + 16.0 + colours.bar_width(&self.value);
        // The title of the bar stands beside that of the rows, or else above it.
        let end = end.max(colours.title_width(&self.value) + 4.0);
        let top = if left + colours.title_width(&self.value) > end { 42.0 } else { 26.0 };
        let bottom = top + ROW * rows.len() as f64;
        let foot = columns.needs()[0];
        let title = if self.column_title.is_empty() { 0.0 } else { 20.0 };
        let content = html! {
            text class="label" x=(Px(left - GAP)) y=(Px(top - 9.0)) text-anchor="end" { (self.row_title) }
            g class="ticks" text-anchor="end" {
                @for (index, row) in rows.iter().enumerate() {
                    text x=(Px(left - GAP)) y=(Px(top + ROW * (index as f64 + 0.5) + 4.0)) { (row) }
                }
            }
            (self.cells(&colours, &columns, top))
            (frame::horizontal(&columns, [top, bottom], false, true))
            text class="label" x=(Px(0.5 * (left + right))) y=(Px(bottom + foot + 14.0)) text-anchor="middle" {
                (self.column_title)
            }
            (colours.bar(&self.value, end, [top, bottom.max(top + BAR)], 17.0))
        };
        let height = (bottom + foot + title + 4.0).max(top + BAR + 8.0);
        Drawing { width, height, description: self.describe(&colours), time_axis: None, content }
    }

    fn cells(&self, colours: &Colours, columns: &Ruler, top: f64) -> Markup {
        let [left, right] = columns.range();
        let wide = (right - left) / self.columns.len().max(1) as f64;
        let finite = self.cells.iter().flatten().filter(|value| value.is_finite());
        let numbers = finite.map(|value| text_width(&colours.number(*value))).fold(0.0, f64::max);
        let cell = |row: usize, column: usize| self.cells.get(row).and_then(|cells| cells.get(column)).copied();
        html! {
            @for row in 0..self.rows.len() {
                @let y = top + ROW * row as f64;
                @for column in 0..self.columns.len() {
                    @let x = left + wide * column as f64;
                    @if let Some(value) = cell(row, column).filter(|value| value.is_finite()) {
                        @let (colour, class) = colours.at(value);
                        rect class="cell" x=(Px(x)) y=(Px(y)) width=(Px(wide)) height=(Px(ROW)) fill=(colour) {}
                        @if numbers + 4.0 < wide {
                            text class={ "small " (class) } x=(Px(x + 0.5 * wide)) y=(Px(y + 0.5 * ROW + 4.0))
                                text-anchor="middle" { (colours.number(value)) }
                        }
                    } @else {
                        rect class="missing" x=(Px(x)) y=(Px(y)) width=(Px(wide)) height=(Px(ROW)) {}
                    }
                }
            }
        }
    }

    /// Its rows with their greatest values.
    fn describe(&self, colours: &Colours) -> String {
        let mut text = format!(
            "{} as a matrix of {} rows and {} columns.",
            self.value.title(0),
            self.rows.len(),
            self.columns.len()
        );
        for (row, cells) in self.rows.iter().zip(&self.cells) {
            let finite = cells.iter().zip(&self.columns).filter(|(value, _)| value.is_finite());
            if let Some((value, column)) = finite.max_by(|a, b| a.0.total_cmp(b.0)) {
                text += &format!(" {row}: at most {}, at {column}.", colours.number(*value));
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> HeatMap {
        HeatMap {
            row_title: String::new(),
            column_title: String::new(),
            rows: vec!["a".into(), "b".into(), "c".into()],
            columns: vec!["a".into(), "b".into(), "c".into()],
            value: Quantity { name: "index".into(), ..Quantity::default() },
            cells: vec![vec![f64::NAN, 0.25, 0.5], vec![f64::NAN, f64::NAN, 1.0], vec![f64::NAN; 2]],
            centre: None,
        }
    }

    #[test]
    fn every_cell_has_its_number_or_none() {
        let text = example().draw(860.0).content.into_string();
        assert_eq!(text.matches("class=\"cell\"").count(), 3);
        assert_eq!(text.matches("class=\"missing\"").count(), 6, "one was not even given");
        for number in [">0.25<", ">0.50<", ">1.00<"] {
            assert_eq!(text.matches(number).count(), 1, "{number}");
        }
    }

    #[test]
    fn numbers_that_do_not_fit_are_left_out() {
        let mut map = example();
        map.columns = (0..12).map(|k| k.to_string()).collect();
        map.cells = vec![vec![0.25; 12], vec![1.0; 12], vec![0.0; 12]];
        assert_eq!(map.draw(860.0).content.into_string().matches(">0.25<").count(), 12);
        let narrow = map.draw(380.0).content.into_string();
        assert!(!narrow.contains(">0.25<") && narrow.matches("class=\"cell\"").count() == 36);
    }
}
