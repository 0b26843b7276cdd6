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

#[cfg(test)]
mod tests {
    use legwork_contract::robot::Robot;

    use super::*;

    #[test]
    fn each_robot_goes_its_own_way_with_its_own_torques() {
        let text = include_str!("../../../models/planar_humanoid.toml");
        let model = Robot::from_toml(text, "humanoid").expect("a sound model");
        let (settings, ground) = (SimulationSettings::default(), Terrain::plane(&model, 0.8, [0.0; 2]));
        // Above the ground, where they fall and turn their joints.
        let starts: Vec<Vec<f64>> = (0..3).map(|k| vec![f64::from(k), 2.0, 0.0, 0.1, -0.1, 0.0, 0.0]).collect();
        let torques: Vec<f64> = (0..12).map(f64::from).collect();
        let mut batch = Batch::new(&settings, &[], &ground, &model, &starts).expect("sound starts");
        assert_eq!((batch.actuated(), batch.robots().len(), batch.robots_mut().len()), (4, 3, 3));
        for _ in 0..5 {
            assert_eq!(batch.step(&torques), 3);
        }
        let shared = Arc::new(Model::clone(&model));
        for (index, (robot, start)) in batch.robots().iter().zip(&starts).enumerate() {
            let alone = Simulator::new(&settings, &[], ground.clone(), Arc::clone(&shared), start);
            let mut alone = alone.expect("a sound start");
            for _ in 0..5 {
                assert!(alone.step(&torques[4 * index..][..4]));
            }
            assert_eq!((robot.q(), robot.v()), (alone.q(), alone.v()), "robot {index}");
            assert_ne!(robot.v(), [0.0; 7]);
            // Motors without delay and lag give what is wanted.
            assert_eq!(robot.applied_torques(), &torques[4 * index..][..4]);
        }
    }

    #[test]
    fn a_start_that_is_none_is_named() {
        let text = include_str!("../../../models/planar_humanoid.toml");
        let model = Robot::from_toml(text, "humanoid").expect("a sound model");
        let (settings, ground) = (SimulationSettings::default(), Terrain::plane(&model, 0.8, [0.0; 2]));
        let refused = |start: Vec<f64>| {
            let starts = [vec![0.0; 7], start];
            Batch::new(&settings, &[], &ground, &model, &starts).expect_err("no start").to_string()
        };
        for (start, problem) in [(vec![0.0; 6], "found 6 values; expected 7"), (vec![f64::NAN; 7], "found NaN")] {
            let told = refused(start);
            assert!(told.contains("starts.1") && told.contains(problem), "{told}");
        }
    }
}
