//! How what a tick and a step take grows with degrees of freedom and with contact points.

use legwork::control::{Controller, MomentumController};
use legwork::error::Error;
use legwork::scenario::Scenario;
use legwork::scenario_file;
use legwork::sim::Simulator;
use legwork_rbd::Dynamics;
use legwork_report::growth::{Growth, Row, Series, Table};

use super::machine::Clock;
use super::replay;
use super::robot::{Size, Standing};
use super::rounds::Rounds;
use super::samples::Samples;

/// Sizes that are measured. Seven joints are the thesis's robot; 40 a humanoid with hands.
const DOFS: [usize; 7] = [7, 9, 12, 16, 22, 30, 40];
const CONTACTS_PER_FOOT: [usize; 6] = [1, 2, 3, 4, 6, 8];
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
    samples: [Samples; 5],
}

/// Measures everything for about `seconds`. A round is one of all sizes, so that a machine that slows down or speeds up
/// meanwhile does so for all of them. None where Ctrl-C was pressed before a round was whole.
pub(super) fn measure(clock: Clock, seconds: f64) -> Result<Option<Growth>, Error> {
    let scenario = scenario_file::load("stand", &["reference.generator=stance".to_owned()])?.scenario;
    let by_dofs = DOFS.map(|dofs| (dofs, Size { dofs, contacts_per_foot: 1, ankles: false }));
    let by_contacts =
        CONTACTS_PER_FOOT.map(|count| (2 * count, Size { dofs: 9, contacts_per_foot: count, ankles: true }));
    let subjects = |sizes: &[(usize, Size)]| -> Result<Vec<Subject>, Error> {
        sizes.iter().map(|&(size, robot)| Subject::new(&scenario, size, robot)).collect()
    };
    let mut groups = [subjects(&by_dofs)?, subjects(&by_contacts)?];
    let rounds = Rounds::new("growth", seconds);
    let mut done = 0;
    while rounds.go_on(done) {
        groups.iter_mut().flatten().try_for_each(|subject| subject.round(clock))?;
        done += 1;
    }
    rounds.finish();
    if done == 0 {
        return Ok(None);
    }
    let rows = |subjects: Vec<Subject>| subjects.into_iter().map(Subject::row).collect::<Result<Vec<Row>, Error>>();
    let [by_dofs, by_contacts] = groups.map(rows);
    let (by_dofs, by_contacts) = (by_dofs?, by_contacts?);
    let tables = vec![
        table("degrees of freedom", "2 contact points".to_owned(), by_dofs, BY_DOFS),
        table("contact points", "9 degrees of freedom".to_owned(), by_contacts, BY_CONTACTS),
    ];
    Ok(Some(Growth { rounds: done, tables }))
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
    fn new(scenario: &Scenario, size: usize, robot: Size) -> Result<Self, Error> {
        let standing = robot.stand(scenario, STATES)?;
        let start = &standing.estimates[0];
        Ok(Self {
            size,
            simulator: scenario.simulator(&standing.model, &start.q)?,
            scenario: scenario.clone(),
            samples: Default::default(),
            standing,
        })
    }

    /// A controller as it was before the first tick.
    fn controller(&self) -> Result<MomentumController, Error> {
        self.scenario.momentum_controller(&self.standing.model, &[], &self.standing.estimates[0])
    }

    fn round(&mut self, clock: Clock) -> Result<(), Error> {
        let Standing { model, estimates, torques } = &self.standing;
        let [dynamics, _, assembly, solve, _] = replay::parts(clock, model, self.controller()?, estimates);
        let tick = replay::ticks(clock, model, self.controller()?, estimates);
        let step = replay::steps(clock, self.simulator.clone(), torques, 1);
        let round = [dynamics, assembly, solve, tick, step];
        self.samples.iter_mut().zip(round).for_each(|(samples, round)| samples.push(round));
        Ok(())
    }

    fn row(mut self) -> Result<Row, Error> {
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
            times_us: self.samples.iter().map(|samples| samples.statistics().mean_us).collect(),
            sweeps: mean(sweeps),
            iterations: mean(iterations),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::exponent;

    #[test]
    fn the_exponent_of_a_power_is_found_where_it_holds() {
        let x: Vec<f64> = (1..=8).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| if *x < 5.0 { 100.0 } else { 3.0 * x.powf(2.5) }).collect();
        assert!((exponent(&x, &y).expect("there are two") - 2.5).abs() < 1e-12);
        assert_eq!(exponent(&x[..1], &y[..1]), None);
        assert_eq!(exponent(&[], &[]), None);
    }
}
