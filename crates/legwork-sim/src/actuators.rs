//! What becomes of the torques that the controller asks for: delay, then a first-order lag, then the motor's limit.

use std::collections::VecDeque;

use legwork_rbd::Model;

use crate::settings::ActuatorSettings;

/// Actuators with their delay line and lag.
#[derive(Clone, Debug)]
pub struct Actuators {
    line: VecDeque<Vec<f64>>,
    /// Share of the way to the delayed torque that is gone in one physics step.
    share: f64,
    limits: Vec<f64>,
    torque: Vec<f64>,
    started: bool,
}

impl Actuators {
    /// Actuators of `model` in physics steps of `period` [s].
    pub fn new(settings: &ActuatorSettings, model: &Model, period: f64) -> Self {
        let limits: Vec<f64> = model.actuated().map(|dof| model.dofs[dof].effort_limit).collect();
        let steps = (settings.delay_s / period).round() as usize;
        Self {
            line: std::iter::repeat_n(vec![0.0; limits.len()], steps + 1).collect(),
            share: if settings.lag_s > 0.0 { 1.0 - libm::exp(-period / settings.lag_s) } else { 1.0 },
            torque: vec![0.0; limits.len()],
            started: false,
            limits,
        }
    }

    /// The torques that act during the next physics step [Nm], where `wanted` is asked for now.
    ///
    /// The first call fills delay and lag with its torques: the motors hold the start pose before the run begins.
    pub fn apply(&mut self, wanted: &[f64]) -> &[f64] {
        if !self.started {
            self.line.iter_mut().for_each(|slot| slot.copy_from_slice(wanted));
            self.torque.copy_from_slice(wanted);
            self.started = true;
        }
        let mut slot = self.line.pop_front().expect("the delay line is never empty");
        slot.copy_from_slice(wanted);
        self.line.push_back(slot);
        for (index, value) in self.torque.iter_mut().enumerate() {
            let delayed = self.line[0][index];
            *value = if self.share < 1.0 { *value + self.share * (delayed - *value) } else { delayed };
            *value = value.clamp(-self.limits[index], self.limits[index]);
        }
        &self.torque
    }
}
