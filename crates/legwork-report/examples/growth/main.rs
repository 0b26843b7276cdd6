//! How what a tick and a step take grows with degrees of freedom and with contact points.
//!
//! `cargo run --release -p legwork-report --example growth -- [SECONDS] [FILE.svg]` prints a table each, and draws them.

mod robot;

use std::error::Error;
use std::io::{self, Write};
use std::time::Instant;

use legwork::control::{Controller, MomentumController};
use legwork::scenario::Scenario;
use legwork::scenario_file;
use legwork::sim::Simulator;
use legwork_rbd::Dynamics;
use legwork_report::growth::{Growth, Row, Series, Table, svg};
use robot::{Size, Standing};

/// Sizes that are measured. Seven joints are the thesis's robot; 40 a humanoid with hands.
const DOFS: [usize; 7] = [7, 9, 12, 16, 22, 30, 40];
const CONTACTS_PER_FOOT: [usize; 6] = [1, 2, 3, 4, 6, 8];
/// Fewest and most rounds: a median of fewer says little, one of more says no more.
const ROUNDS: [usize; 2] = [3, 300];
/// States of each robot, a simulation step apart.
const STATES: usize = 100;

/// What is measured, in the order of [`Row::times_us`].
const SERIES: [&str; 5] = ["dynamics", "assembly", "solve", "tick", "step"];

/// The exponents that the algorithms would have by themselves on large robots: least and most.
const BY_DOFS: [[f64; 2]; 5] = [[1.0, 2.0], [2.0, 2.0], [2.0, 3.0], [2.0, 3.0], [2.0, 3.0]];
const BY_CONTACTS: [[f64; 2]; 5] = [[1.0, 1.0], [1.0, 2.0], [2.0, 3.0], [2.0, 3.0], [2.0, 3.0]];

/// A robot that is being measured.
struct Subject {
    size: usize,
    scenario: Scenario,
    standing: Standing,
    simulator: Simulator,
    /// Durations of each of [`SERIES`] at each state [s], a round each.
    rounds: Vec<[Vec<f64>; 5]>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seconds = arguments.next().map_or(Ok(5.0), |text| text.parse())?;
    let growth = measure(seconds)?;
    writeln!(io::stdout(), "{}", text(&growth))?;
    if let Some(path) = arguments.next() {
        std::fs::write(path, svg(&growth))?;
    }
    Ok(())
}

/// What reading the clock takes [s]: the median over many intervals with nothing in them.
fn clock_s() -> f64 {
    median((0..10_001).map(|_| Instant::now().elapsed().as_secs_f64()).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Measures everything for about `seconds`. A round is one of all sizes, so that a machine that slows down or speeds up
/// meanwhile does so for all of them.
fn measure(seconds: f64) -> Result<Growth, Box<dyn Error>> {
    let (begin, clock_s) = (Instant::now(), clock_s());
    let scenario = scenario_file::load("stand", &["reference.generator=stance".to_owned()])?.scenario;
    let by_dofs = DOFS.map(|dofs| (dofs, Size { dofs, contacts_per_foot: 1, ankles: false }));
    let by_contacts =
        CONTACTS_PER_FOOT.map(|count| (2 * count, Size { dofs: 9, contacts_per_foot: count, ankles: true }));
    let subjects = |sizes: &[(usize, Size)]| -> Result<Vec<Subject>, Box<dyn Error>> {
        sizes.iter().map(|&(size, robot)| Subject::new(&scenario, size, robot)).collect()
    };
    let mut groups = [subjects(&by_dofs)?, subjects(&by_contacts)?];
    let mut done = 0;
    while done < ROUNDS[0] || (done < ROUNDS[1] && begin.elapsed().as_secs_f64() < seconds) {
        groups.iter_mut().flatten().try_for_each(|subject| subject.round(clock_s))?;
        done += 1;
    }
    let rows = |subjects: Vec<Subject>| subjects.into_iter().map(Subject::row).collect::<Result<Vec<_>, _>>();
    let [by_dofs, by_contacts] = groups.map(rows);
    let tables = vec![
        table("degrees of freedom", "2 contact points".to_owned(), by_dofs?, BY_DOFS),
        table("contact points", "9 degrees of freedom".to_owned(), by_contacts?, BY_CONTACTS),
    ];
    Ok(Growth { rounds: done, tables })
}

fn table(over: &'static str, held: String, rows: Vec<Row>, expected: [[f64; 2]; 5]) -> Table {
    let sizes: Vec<f64> = rows.iter().map(|row| row.size as f64).collect();
    let series = SERIES.iter().zip(expected).enumerate().map(|(index, (name, expected))| {
        let times: Vec<f64> = rows.iter().map(|row| row.times_us[index]).collect();
        Series { name, exponent: exponent(&sizes, &times), expected }
    });
    Table { over, held, series: series.collect(), rows }
}

/// The slope of `log y` over `log x` by least squares over the upper half of the sizes.
fn exponent(x: &[f64], y: &[f64]) -> Option<f64> {
    let upper = x.len() / 2..;
    let points: Vec<[f64; 2]> = x[upper.clone()].iter().zip(&y[upper]).map(|(x, y)| [x.ln(), y.ln()]).collect();
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let spread: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let slope = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>() / spread;
    slope.is_finite().then_some(slope)
}

impl Subject {
    fn new(scenario: &Scenario, size: usize, robot: Size) -> Result<Self, Box<dyn Error>> {
        let standing = robot.stand(scenario, STATES)?;
        let start = &standing.estimates[0];
        Ok(Self {
            size,
            simulator: scenario.simulator(&standing.model, &start.q)?,
            scenario: scenario.clone(),
            rounds: Vec::new(),
            standing,
        })
    }

    /// A controller as it was before the first tick.
    fn controller(&self) -> Result<MomentumController, Box<dyn Error>> {
        Ok(self.scenario.momentum_controller(&self.standing.model, &[], &self.standing.estimates[0])?)
    }

    /// Whole ticks and their parts in passes of their own, so that the clock read between the parts is not in the whole.
    fn round(&mut self, clock_s: f64) -> Result<(), Box<dyn Error>> {
        let Standing { model, estimates, torques } = &self.standing;
        let since = |begin: Instant| (begin.elapsed().as_secs_f64() - clock_s).max(0.0);
        let mut round: [Vec<f64>; 5] = Default::default();
        let (mut controller, mut dynamics) = (self.controller()?, Dynamics::new(model));
        for estimate in estimates {
            let mut begin = Instant::now();
            dynamics.update(model, &estimate.q, &estimate.v);
            round[0].push(since(begin));
            let mut parts = [0.0; 4];
            begin = Instant::now();
            controller.tick_in_parts(estimate, &dynamics, |part| {
                // Parts of several attempts add up.
                parts[part as usize] += since(begin);
                begin = Instant::now();
            });
            let [_, assembly, solve, _] = parts;
            round[1].push(assembly);
            round[2].push(solve);
        }
        let mut controller = self.controller()?;
        for estimate in estimates {
            let begin = Instant::now();
            dynamics.update(model, &estimate.q, &estimate.v);
            controller.tick(estimate, &dynamics);
            round[3].push(since(begin));
        }
        let mut simulator = self.simulator.clone();
        for torques in torques {
            let begin = Instant::now();
            simulator.step(torques);
            round[4].push(since(begin));
        }
        self.rounds.push(round);
        Ok(())
    }

    fn row(mut self) -> Result<Row, Box<dyn Error>> {
        let mut controller = self.controller()?;
        let (mut iterations, mut sweeps) = (0, 0);
        let model = &self.standing.model;
        let mut dynamics = Dynamics::new(model);
        for (estimate, torques) in self.standing.estimates.iter().zip(&self.standing.torques) {
            dynamics.update(model, &estimate.q, &estimate.v);
            controller.tick(estimate, &dynamics);
            iterations += controller.latest().program.iterations;
            self.simulator.step(torques);
            sweeps += self.simulator.contact_report().sweeps;
        }
        let mean = |total: u32| f64::from(total) / self.standing.estimates.len() as f64;
        Ok(Row {
            size: self.size,
            variables: controller.layout().variables(),
            times_us: (0..SERIES.len()).map(|series| self.time_us(series)).collect(),
            sweeps: mean(sweeps),
            iterations: mean(iterations),
        })
    }

    /// Mean over the states of the medians over the rounds [µs].
    fn time_us(&self, series: usize) -> f64 {
        let of = |state: usize| median(self.rounds.iter().map(|round| round[series][state]).collect());
        1e6 * (0..STATES).map(of).sum::<f64>() / STATES as f64
    }
}

fn text(growth: &Growth) -> String {
    let tables: Vec<String> = growth.tables.iter().map(table_text).collect();
    format!("Robots that stand in the plane; medians of {} rounds\n\n{}", growth.rounds, tables.join("\n\n"))
}

fn table_text(table: &Table) -> String {
    let mut text = format!("Over {}, with {} [µs]\n  {:>9}{:>10}", table.over, table.held, "", "variables");
    table.series.iter().for_each(|series| text += &format!("{:>10}", series.name));
    text += &format!("{:>7}", "sweeps");
    for row in &table.rows {
        text += &format!("\n  {:>9}{:>10}", row.size, row.variables);
        row.times_us.iter().for_each(|&time| text += &format!("{time:>10.3}"));
        text += &format!("{:>7.1}", row.sweeps);
    }
    text += &format!("\n  {:<19}", "exponent, measured");
    for series in &table.series {
        text += &format!("{:>10}", series.exponent.map_or("–".to_owned(), |exponent| format!("{exponent:.2}")));
    }
    text += &format!("\n  {:<19}", "of the algorithm");
    for series in &table.series {
        let [least, most] = series.expected;
        text += &format!("{:>10}", if least < most { format!("{least} to {most}") } else { least.to_string() });
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{exponent, measure, svg, text};

    #[test]
    fn the_exponent_of_a_power_is_found_where_it_holds() {
        let x: Vec<f64> = (1..=8).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| if *x < 5.0 { 100.0 } else { 3.0 * x.powf(2.5) }).collect();
        assert!((exponent(&x, &y).expect("there are two") - 2.5).abs() < 1e-12);
        assert_eq!(exponent(&x[..1], &y[..1]), None);
        assert_eq!(exponent(&[], &[]), None);
    }

    #[test]
    fn growth_has_a_row_a_size_and_a_figure() {
        let growth = measure(0.1).expect("the robots can stand");
        let names: Vec<&str> = growth.tables.iter().map(|table| table.over).collect();
        assert_eq!(names, ["degrees of freedom", "contact points"]);
        for table in &growth.tables {
            assert!(table.rows.len() >= 6 && table.series.len() == 5);
            assert!(table.rows.iter().flat_map(|row| &row.times_us).all(|&time| time > 0.0), "{:?}", table.rows);
            assert!(table.series.iter().all(|series| series.exponent.is_some()), "{:?}", table.series);
        }
        let figure = svg(&growth);
        for word in ["degrees of freedom", "contact points", "time [µs]", "n^"] {
            assert!(figure.contains(word), "{word}");
        }
        for line in text(&growth).lines() {
            assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?}");
        }
    }
}
