//! What moves the robot, whatever it is: [`Plant`]. It is given torques, and says what became of the robot.

use std::fmt::Debug;

use legwork_contract::channel::{Channel, Record};
use legwork_contract::contract::{Command, Sensed};
use legwork_contract::error::Error;
use legwork_contract::terrain::Terrain;
use legwork_rbd::Dynamics;

use crate::audit::Audit;
use crate::settings::{Push, SimulationSettings};

/// Whether a robot's state is one that physics could have made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// It is.
    Sound,
    /// Its numbers went out of bounds: the run ends.
    OutOfBounds,
}

/// A physics: our simulator, somebody else's, a recording, a robot. Only [`Plant::read`] and [`Plant::apply`] must be there; the
/// rest is what a log, an audit and a report can show of it.
pub trait Plant: Debug + Send + Sync {
    /// Writes the true state into `sensed`: time, positions, velocities, and of each contact point whether it touches the ground
    /// and the vertical force on it, as a mean of the latest period. Sensors come after it. Allocates nothing.
    fn read(&self, sensed: &mut Sensed);

    /// Lets a command act for a `period` [s], in however many steps.
    fn apply(&mut self, command: &Command, period: f64) -> Health;

    /// Dynamics of the true robot in the present state, where the physics has them; else they are reckoned from what is read.
    fn dynamics(&self) -> Option<&Dynamics> {
        None
    }

    /// Whether the physics obeyed its own laws; none where nothing watches that.
    fn audit(&self) -> Option<&Audit> {
        None
    }

    /// What it writes into each record, beside the state, which every record has.
    fn channels(&self) -> Vec<Channel> {
        Vec::new()
    }

    /// Writes its channels' values of the latest period, field by field. Allocates nothing.
    fn record(&self, _record: &mut Record<'_>) {}

    /// Takes another ground, other pushes and other values of those settings that may change while it runs.
    ///
    /// # Errors
    /// A push on a body that the robot does not have; then nothing changes.
    fn change(&mut self, _settings: &SimulationSettings, _pushes: &[Push], _ground: &Terrain) -> Result<(), Error> {
        Ok(())
    }
}
