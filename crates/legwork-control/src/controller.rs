//! What every controller is: [`Controller`]. It is given what is sensed, and answers with torques.

use std::fmt::Debug;

use legwork_contract::channel::{Channel, Record};
use legwork_contract::contract::{Command, Sensed};
use legwork_contract::terrain::Terrain;
use legwork_qp::Status;
use legwork_rbd::Dynamics;

use crate::generator::Reference;
use crate::momentum::{Condition, Fallback, Limit, Task};
use crate::settings::{ControllerSettings, ReferenceSettings};

/// A controller, whatever is in it. Only [`Controller::tick`] and [`Controller::command`] must be there; the rest is what a log,
/// a diagnosis and a report can show of it.
pub trait Controller: Debug + Send + Sync {
    /// One control tick: torques for what was `sensed`; `dynamics` are those of the robot as the controller knows it, in that
    /// state. Allocates nothing. Where what was sensed is no state of the robot, the torques of the tick before are held.
    fn tick(&mut self, sensed: &Sensed, dynamics: &Dynamics) -> &Command;

    /// The torques of the latest tick; zero before the first.
    fn command(&self) -> &Command;

    /// What the robot should do as of the latest tick; none for a controller without such a reference.
    fn reference(&self) -> Option<&Reference> {
        None
    }

    /// How the latest tick's program went; none for a controller that solves none.
    fn program(&self) -> Option<&Program> {
        None
    }

    /// The tasks that it weighs, in the order of their rows; none for a controller without tasks.
    fn tasks(&self) -> &[Task] {
        &[]
    }

    /// The limits that can be active; none for a controller that tells none.
    fn limits(&self) -> &[Limit] {
        &[]
    }

    /// For each of its limits: -1 or 1 where the lower or upper side was active in the latest tick, else 0.
    fn active(&self) -> &[i8] {
        &[]
    }

    /// What it writes into each record, beside the torques and the reference, which every record has.
    fn channels(&self) -> Vec<Channel> {
        Vec::new()
    }

    /// Writes its channels' values of the latest tick, field by field. Allocates nothing.
    fn record(&self, _record: &mut Record<'_>) {}

    /// Takes other values of those settings that may change while it runs, and the ground that it is told of; they act from
    /// the next tick on.
    fn change(&mut self, _settings: &ControllerSettings, _reference: &ReferenceSettings, _terrain: &Terrain) {}
}

/// How the program of a tick went.
#[derive(Clone, Debug)]
pub struct Program {
    /// Its variables and its rows.
    pub size: [usize; 2],
    /// Status of the program as it stood, before any fallback.
    pub status: Status,
    /// Where that is infeasible: the constraints that contradict each other.
    pub conflict: Vec<Condition>,
    /// What was done where that had no solution.
    pub fallback: Fallback,
    /// Iterations of the solver, all attempts together.
    pub iterations: u32,
    /// Programs solved: one, or more with a fallback; none where what was sensed is no state of the robot.
    pub solves: u32,
}

impl Program {
    /// Of a program of this many variables and rows, before the first tick.
    pub(crate) fn new(size: [usize; 2]) -> Self {
        let conflict = Vec::with_capacity(size[0] + size[1]);
        Self { size, status: Status::Optimal, conflict, fallback: Fallback::None, iterations: 0, solves: 0 }
    }

    /// Nothing is solved yet in this tick.
    pub(crate) fn begin(&mut self) {
        self.conflict.clear();
        (self.status, self.fallback, self.iterations, self.solves) = (Status::Optimal, Fallback::None, 0, 0);
    }
}
