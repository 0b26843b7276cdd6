//! Standing balance: by the ankles, the hips, and a step (Nashner and McCollum 1985; Stephens 2007).
//!
//! The centre of pressure holds the XcoM above the feet. Where it would have to leave them, the torso turns the way that the
//! body falls: the force's line then meets the ground beyond the foot, by the rate of angular momentum over the weight (the
//! centroidal moment pivot, Popovic et al. 2005). It leans back as soon as the feet have room for that. Where the XcoM
//! leaves the feet by more than that can bear, a step begins.

use super::{Footing, Motion, Observation, STANDING, Walker};

/// What has been lowered for a step rises that fast [s].
const RISE_S: f64 = 0.5;

impl Walker {
    /// Both feet stand.
    pub(super) fn stand(&mut self, step: f64, observation: &Observation) {
        let settings = &self.settings;
        let [right, left] = self.placed;
        let middle = 0.5 * (right.x + left.x) + settings.cop_centre_m;
        let low = right.x.min(left.x) + self.sole.heel + settings.cop_margin_m;
        let high = right.x.max(left.x) + self.sole.toe - settings.cop_margin_m;
        self.xcom_reference = middle;
        let wanted = middle + (1.0 + settings.cop_gain / self.omega) * (self.xcom - middle);
        let most = settings.hip_shift_m;
        let shift = self.hip_return().max(wanted - high).min(wanted - low).clamp(-most, most);
        let outside = self.xcom - self.xcom.clamp(low, high);
        let falls = outside.abs() > settings.stand_margin_m;
        self.lean_by(shift, step);
        self.cop = (wanted - self.hip_shift).clamp(low, high);
        self.drop = self.drop.toward(0.0, self.settings.in_time(RISE_S), step);
        self.footing = [Footing::Stands; 2];
        self.max_load = [f64::INFINITY; 2];
        (0..2).for_each(|foot| self.feet[foot] = self.flat(foot));
        let speed = self.wanted_speed(self.time);
        if speed.abs() > self.settings.in_speed(STANDING) || self.settings.march || falls {
            let forward = if falls { outside } else { speed };
            // The foot ahead stands.
            let stance = usize::from((left.x - right.x) * forward.signum() >= 0.0);
            self.way = observation.com.x;
            self.begin_step(stance, self.time - self.settings.double_support_s);
        }
    }

    /// How fast the torso turns and is turned back [1/s].
    fn hip_rate(&self) -> f64 {
        (self.settings.hip_acceleration_radps2 / self.settings.hip_lean_rad).sqrt()
    }

    /// The acceleration of the torso for a shift of the centre of pressure [rad/s² per m].
    fn hip_acceleration(&self) -> f64 {
        if self.settings.hip_shift_m > 0.0 {
            self.settings.hip_acceleration_radps2 / self.settings.hip_shift_m
        } else {
            0.0
        }
    }

    /// The shift of the centre of pressure that goes with the torso's return, critically damped [m].
    pub(super) fn hip_return(&self) -> f64 {
        let (k, of_shift) = (self.hip_rate(), self.hip_acceleration());
        if of_shift > 0.0 { (k * k * self.lean.value + 2.0 * k * self.lean.rate) / of_shift } else { 0.0 }
    }

    /// Turns the torso for a shift of the centre of pressure [m], forward for one to the front, within its largest lean.
    pub(super) fn lean_by(&mut self, shift: f64, step: f64) {
        let (k, of_shift, most) = (self.hip_rate(), self.hip_acceleration(), self.settings.hip_lean_rad);
        let Motion { value, rate, .. } = self.lean;
        // It comes to its largest lean no faster than critically damped.
        let bound = |limit: f64| k * k * (limit - value) - 2.0 * k * rate;
        let acceleration = (-of_shift * shift).max(bound(-most)).min(bound(most));
        self.hip_shift = if of_shift > 0.0 { -acceleration / of_shift } else { 0.0 };
        self.lean = Motion {
            value: value + step * (rate + 0.5 * step * acceleration),
            rate: rate + step * acceleration,
            acceleration,
        };
    }
}
