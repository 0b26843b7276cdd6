//! The figure of `legwork bench --growth`.

use super::WIDE;
use super::charts::axis::Quantity;
use super::charts::powers::{Curve, Panel, Powers};
use crate::bench::{Growth, Table};

/// The figure as a file of its own.
pub(crate) fn svg(growth: &Growth) -> String {
    let chart = Powers { y: quantity("time", "µs"), panels: growth.tables.iter().map(panel).collect() };
    chart.draw(WIDE).standalone("How tick and step grow with the robot")
}

fn quantity(name: &str, unit: &str) -> Quantity {
    Quantity { name: name.into(), unit: unit.into(), log: true }
}

fn panel(table: &Table) -> Panel {
    let curve = |(index, series): (usize, &crate::bench::Series)| Curve {
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
