//! Many robots of one model on one ground, stepped together on the calling thread.

use std::sync::Arc;

use legwork_rbd::Model;

use crate::Simulator;
use crate::settings::{Push, SimulationSettings};
use legwork_contract::error::Error;
use legwork_contract::terrain::Terrain;

/// Robots that share settings, ground and model, each with its own state. They do not touch each other.
#[derive(Clone, Debug)]
pub struct Batch {
    robots: Vec<Simulator>,
    actuated: usize,
}

impl Batch {
    /// A robot at rest in each of `starts` (nq each) [rad, m].
    ///
    /// # Errors
    /// A start of a wrong length or that is not finite, or a push that names an unknown body.
    pub fn new(
        settings: &SimulationSettings,
        pushes: &[Push],
        ground: &Terrain,
        model: &Model,
        starts: &[Vec<f64>],
    ) -> Result<Self, Error> {
        let shared = Arc::new(model.clone());
        let robot = |(index, q): (usize, &Vec<f64>)| {
            let place = || format!("starts.{index}");
            if q.len() != model.nq() {
                return Err(Error::invalid(place(), format!("found {} values; expected {}", q.len(), model.nq())));
            }
            if let Some(value) = q.iter().find(|value| !value.is_finite()) {
                return Err(Error::invalid(place(), format!("found {value}; expected finite numbers")));
            }
            Simulator::new(settings, pushes, ground.clone(), Arc::clone(&shared), q)
        };
        let robots = starts.iter().enumerate().map(robot).collect::<Result<_, Error>>()?;
        Ok(Self { robots, actuated: model.actuated().count() })
    }

    /// Number of actuated joints of a robot.
    pub fn actuated(&self) -> usize {
        self.actuated
    }

    /// The robots, in the order of their starts.
    pub fn robots(&self) -> &[Simulator] {
        &self.robots
    }

    /// The robots, to be stepped by the caller in chunks, on threads of its own.
    pub fn robots_mut(&mut self) -> &mut [Simulator] {
        &mut self.robots
    }

    /// One step of each robot with the wanted torques (robots × actuated, row by row) [Nm], to the same bits as alone.
    /// Returns how many of them are sound; the others keep their states, see [`Simulator::step`]. Allocates nothing.
    ///
    /// # Panics
    /// If `torques` has a wrong length.
    pub fn step(&mut self, torques: &[f64]) -> usize {
        assert_eq!(torques.len(), self.robots.len() * self.actuated, "torques of all robots");
        let actuated = self.actuated;
        let of = |index: usize| &torques[index * actuated..(index + 1) * actuated];
        self.robots.iter_mut().enumerate().map(|(index, robot)| usize::from(robot.step(of(index)))).sum()
    }
}
