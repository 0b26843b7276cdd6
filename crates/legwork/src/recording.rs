//! What a run gave to its controller and to its simulator, kept so that both can be given it again: for measuring them.
//!
//! The loop is open: estimates and torques are those of the run, bit by bit, so that the same work is done each time.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::contract::{Command, Sensed};
use crate::episode::Run;
use crate::error::Error;
use crate::log::{Field, Log};
use crate::momentum::MomentumController;
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::sim::sensors::Sensors;
use crate::sim::{Health, Plant, Simulator};

/// The inputs of controller and simulator in each tick of a run.
#[derive(Clone, Debug)]
pub struct Recording {
    scenario: Scenario,
    /// The robot as it is, and as the controller knows it.
    model: Robot,
    known: Robot,
    samples: Vec<[f64; 3]>,
    start: Sensed,
    /// What the controller was told, a tick each.
    pub estimates: Vec<Sensed>,
    /// The torques that the simulator was given [Nm], a tick each: those of the actuated joints.
    pub torques: Vec<Vec<f64>>,
    /// Steps of the simulator a tick.
    pub steps_per_tick: usize,
}

impl Recording {
    /// The inputs of `run`, which read the rows `samples` from its CoM file, where it has one.
    ///
    /// # Panics
    /// If the run has no tick.
    pub fn of(run: &Run, samples: &[[f64; 3]]) -> Self {
        let (scenario, log) = (&run.scenario, &run.log);
        let start = log.truth(0);
        let period = scenario.controller.period_s;
        let mut sensors = Sensors::new(&scenario.simulation.sensors, &run.model, period, scenario.seed, &start);
        let mut told = |index: usize| {
            let mut estimate = start.clone();
            sensors.read(&log.truth(index), &mut estimate);
            estimate
        };
        Self {
            estimates: (0..log.len()).map(&mut told).collect(),
            torques: (0..log.len()).map(|index| log.get(index, Field::Torque).to_vec()).collect(),
            steps_per_tick: (period / scenario.simulation.period_s).round() as usize,
            scenario: scenario.clone(),
            model: run.model.clone(),
            known: run.known.clone(),
            samples: samples.to_vec(),
            start,
        }
    }

    /// A controller as it was before the first tick.
    ///
    /// # Errors
    /// None for the controller that made the run; else those of [`Scenario::generator`].
    pub fn controller(&self) -> Result<MomentumController, Error> {
        self.scenario.momentum_controller(&self.known, &self.samples, &self.start)
    }

    /// A simulator as it was before the first step.
    ///
    /// # Errors
    /// None for the simulator that made the run; else those of [`Simulator::new`].
    pub fn simulator(&self) -> Result<Simulator, Error> {
        self.scenario.simulator(&self.model, &self.start.q)
    }

    /// The same with torques drawn evenly from −`limit` to `limit` [Nm] in place of the controller's, always the same ones: the robot
    /// falls, slides and rolls on its edges, which is the hardest work for the contact solver.
    #[must_use]
    pub fn with_random_torques(mut self, limit: f64) -> Self {
        let mut random = Pcg64Mcg::seed_from_u64(0);
        self.torques.iter_mut().flatten().for_each(|torque| *torque = random.random_range(-limit..=limit));
        self
    }

    /// The robot as the controller knows it: whose dynamics its ticks want.
    pub fn known(&self) -> &Robot {
        &self.known
    }
}

/// The true states of a run, given once more: a physics that does not care what it is asked for. What another controller would have
/// asked for in those states is in its log.
#[derive(Clone, Debug)]
pub struct Replay {
    states: Vec<Sensed>,
    tick: usize,
}

impl Replay {
    /// The states of the records of `log`.
    ///
    /// # Errors
    /// The log has no record.
    pub fn of(log: &Log) -> Result<Self, Error> {
        if log.is_empty() {
            return Err(Error::invalid("log", "found no record; a replay needs at least one"));
        }
        Ok(Self { states: (0..log.len()).map(|index| log.truth(index)).collect(), tick: 0 })
    }
}

impl Plant for Replay {
    fn read(&self, sensed: &mut Sensed) {
        sensed.clone_from(&self.states[self.tick]);
    }

    fn apply(&mut self, _command: &Command, _period: f64) -> Health {
        // After its last state it stays there.
        self.tick = (self.tick + 1).min(self.states.len() - 1);
        Health::Sound
    }
}

#[cfg(test)]
mod tests {
    use legwork_rbd::Dynamics;

    use super::*;
    use crate::control::Controller;
    use crate::{episode, scenario_file};

    #[test]
    fn controller_and_simulator_do_again_what_they_did() {
        let noisy = ["simulation.sensors.delay_s=0.004", "simulation.sensors.velocity_noise=0.001", "duration_s=1"];
        let other = ["simulation.model_error=0.05", "seed=3", "duration_s=1"];
        for sets in [&noisy[2..], &noisy, &other] {
            let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
            let loaded = scenario_file::load("push", &sets).expect("it is built in");
            let model = loaded.model().expect("it is built in");
            let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can be run");
            let recording = Recording::of(&run, &[]);
            let (mut controller, mut simulator) = (recording.controller().unwrap(), recording.simulator().unwrap());
            let mut dynamics = Dynamics::new(recording.known());
            assert!(recording.estimates.len() > 400 && recording.steps_per_tick > 0);
            for (index, (estimate, torques)) in recording.estimates.iter().zip(&recording.torques).enumerate() {
                assert_eq!(simulator.q(), run.log.get(index, Field::Q), "tick {index}");
                dynamics.update(recording.known(), &estimate.q, &estimate.v);
                assert_eq!(controller.tick(estimate, &dynamics).torque, *torques, "tick {index}");
                assert!((0..recording.steps_per_tick).all(|_| simulator.step(torques)));
            }
        }
    }
}
