//! The figure of `legwork bench --growth`.

use serde::Serialize;

use super::WIDE;
use super::charts::axis::Quantity;
use super::charts::powers::{Curve, Panel, Powers};

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

/// The figure as a file of its own.
pub fn svg(growth: &Growth) -> String {
    let chart = Powers { y: quantity("time", "µs"), panels: growth.tables.iter().map(panel).collect() };
    chart.draw(WIDE).standalone("How tick and step grow with the robot")
}

fn quantity(name: &str, unit: &str) -> Quantity {
    Quantity { name: name.into(), unit: unit.into(), log: true }
}

fn panel(table: &Table) -> Panel {
    let curve = |(index, series): (usize, &Series)| Curve {
        label: series.name.into(),
        exponent: series.exponent,
        points: table.rows.iter().map(|row| [row.size as f64, row.times_us[index]]).collect(),
    };
    Panel {
        title: table.held.clone(),
        x: quantity(table.over, ""),
        curves: table.series.iter().enumerate().map(curve).collect(),
    }
}
