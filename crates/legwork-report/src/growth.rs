//! How what a tick and a step take grows with the robot (`examples/growth`), as a figure.

use serde::Serialize;

use crate::WIDE;
use crate::charts::axis::{Axis, Quantity};
use crate::charts::chart::{Chart, Part, Stack};
use crate::charts::layer::Layer;

/// Growth with degrees of freedom, then with contact points.
#[derive(Clone, Debug, Serialize)]
pub struct Growth {
    /// Rounds in which every size was measured.
    pub rounds: usize,
    /// A table each.
    pub tables: Vec<Table>,
}

/// Growth with one size, the other held.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    /// What grows.
    pub over: &'static str,
    /// What is held, in words.
    pub held: String,
    /// A row a size.
    pub rows: Vec<Row>,
    /// For each column how it grows.
    pub series: Vec<Series>,
}

/// A size and what it takes.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Degrees of freedom, or contact points.
    pub size: usize,
    /// Variables of the program.
    pub variables: usize,
    /// Means over the states of the medians over the rounds [µs], in the order of the series.
    pub times_us: Vec<f64>,
    /// Sweeps of the contact solver a step, mean.
    pub sweeps: f64,
    /// Iterations of the solver a tick, mean.
    pub iterations: f64,
}

/// How a time grows.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    /// What takes it.
    pub name: &'static str,
    /// The exponent fitted over the upper half of the sizes; none of fewer than two.
    pub exponent: Option<f64>,
    /// What theory says of large robots: least and most.
    pub expected: [f64; 2],
}

/// The figure as a file of its own: both axes are logarithmic, so that a power of the size is a straight line.
pub fn svg(growth: &Growth) -> String {
    Chart::new(growth.tables.iter().map(stack).collect(), (300.0, 2))
        .draw(WIDE)
        .standalone("How tick and step grow with the robot")
}

fn stack(table: &Table) -> Stack {
    let points = |index: usize| -> Vec<[f64; 2]> {
        table.rows.iter().map(|row| [row.size as f64, row.times_us[index]]).collect()
    };
    let curve = |(number, series): (usize, &Series)| Layer::Series {
        number,
        label: series.name.into(),
        points: points(number),
        joined: true,
    };
    let note = |(number, series): (usize, &Series)| {
        Some((points(number).last()?[1], format!("{} ~ n^{:.1}", series.name, series.exponent?)))
    };
    let mut part = Part::new(
        Quantity::new("time", "\u{b5}s").logarithmic(true),
        330.0,
        table.series.iter().enumerate().map(curve).collect(),
    );
    part.notes = table.series.iter().enumerate().filter_map(note).collect();
    let sizes = table.rows.iter().map(|row| row.size as f64);
    let x = Axis::around(Quantity::new(table.over, "").logarithmic(true), sizes);
    Stack { title: table.held.clone(), x, parts: vec![part] }
}
