//! The motion reference planner (thesis 4.3.2): from references to a goal for each task, by the task's own law.

use legwork_contract::robot::Robot;

use crate::momentum::tasks::{Aim, Seen, laws};
use crate::settings::ControllerSettings;

/// The planner with its latest goals.
#[derive(Clone, Debug)]
pub struct MotionReferencePlanner {
    aims: Vec<Aim>,
}

impl MotionReferencePlanner {
    /// A planner for `model`, of the tasks that `settings` ask for.
    pub fn new(settings: &ControllerSettings, model: &Robot) -> Self {
        Self { aims: laws(settings, model).into_iter().map(|law| Aim::new(law, model)).collect() }
    }

    /// The goals for what is seen. Allocates nothing.
    pub fn plan(&mut self, seen: &Seen<'_>) -> &[Aim] {
        for aim in &mut self.aims {
            aim.law.plan(seen, &mut aim.goal);
        }
        &self.aims
    }

    /// The latest goals, in the order of the tasks.
    pub fn aims(&self) -> &[Aim] {
        &self.aims
    }

    /// The latest goal of the task `name`, in its rows; empty where there is no such task.
    pub fn goal(&self, name: &str) -> &[f64] {
        self.aims.iter().find(|aim| aim.law.name() == name).map_or(&[], |aim| &aim.goal)
    }
}
