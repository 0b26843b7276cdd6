//! What the controller is told: the state and the contacts, late, noisy or in part where the scenario says so.

use std::collections::VecDeque;

use legwork_rbd::Model;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

use crate::settings::{ContactFlag, Loads, SensorSettings};
use legwork_contract::contract::Sensed;

/// Sensors with their delay line and noise.
#[derive(Clone, Debug)]
pub struct Sensors {
    settings: SensorSettings,
    model: Model,
    /// What was read, the oldest first: that old are the forces that are told.
    line: VecDeque<Sensed>,
    /// The one of them that the state is told of.
    state: usize,
    noise: Vec<f64>,
    measured: Vec<f64>,
    random: Pcg64Mcg,
}

impl Sensors {
    /// Sensors that are read every `period` [s], beginning with `start`.
    pub fn new(settings: &SensorSettings, model: &Model, period: f64, seed: u64, start: &Sensed) -> Self {
        let [all, loads] = [settings.delay_s, settings.load_delay_s].map(|delay| (delay / period).round() as usize);
        Self {
            settings: settings.clone(),
            model: model.clone(),
            line: std::iter::repeat_n(start.clone(), all + loads + 1).collect(),
            state: loads,
            noise: vec![0.0; model.nv()],
            measured: vec![0.0; model.nq()],
            random: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// Takes in the true state and writes what the controller is told into `estimate`, whose time is the present.
    pub fn read(&mut self, truth: &Sensed, estimate: &mut Sensed) {
        let mut slot = self.line.pop_front().expect("the delay line is never empty");
        copy(truth, &mut slot);
        self.line.push_back(slot);
        copy(&self.line[self.state], estimate);
        estimate.time = truth.time;
        for (told, then) in estimate.contacts.iter_mut().zip(&self.line[0].contacts) {
            told.load = if self.settings.loads == Loads::Measured { then.load } else { 0.0 };
            if self.settings.flag == ContactFlag::Force {
                told.touching = then.load > self.settings.flag_force_n;
            }
        }
        if self.settings.position_noise > 0.0 {
            self.draw(self.settings.position_noise);
            self.model.integrate(&estimate.q, &self.noise, 1.0, &mut self.measured);
            estimate.q.copy_from_slice(&self.measured);
        }
        if self.settings.velocity_noise > 0.0 {
            self.draw(self.settings.velocity_noise);
            for (value, noise) in estimate.v.iter_mut().zip(&self.noise) {
                *value += noise;
            }
        }
    }

    fn draw(&mut self, deviation: f64) {
        for value in &mut self.noise {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            *value = deviation * normal;
        }
    }
}

fn copy(from: &Sensed, to: &mut Sensed) {
    to.time = from.time;
    to.q.copy_from_slice(&from.q);
    to.v.copy_from_slice(&from.v);
    to.contacts.copy_from_slice(&from.contacts);
}
