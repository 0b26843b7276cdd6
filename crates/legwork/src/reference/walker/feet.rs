//! The walker's feet: standing flat, rolling over the toe, leaving the ground, swinging.

use nalgebra::Vector3;

use super::{Footing, Motion, Observation, Walker, swing};
use crate::reference::stance::minimum_jerk;
use crate::reference::{AngleReference, ObjectReference, PointReference};

/// The share of a heel's roll that is done when the foot lifts off: it still turns then.
const ROLLED: f64 = 0.8;

/// A foot that rolls over its toe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Roll {
    pub(super) since: f64,
    pub(super) duration: f64,
    /// At its end [rad].
    pub(super) angle: f64,
}

/// Where a foot is, by the ground below its ankle when it is flat.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flat {
    pub(super) x: f64,
    pub(super) z: f64,
}

impl Walker {
    /// A foot stands where it is now.
    pub(super) fn place_foot(&mut self, foot: usize, observation: &Observation) {
        let below = observation.feet[foot] - self.along_the_sole(self.sole.middle());
        let z = if self.ground_known { self.ground.height_at(below.x) } else { below.z };
        let x = below.x;
        self.placed[foot] = Flat { x, z };
        self.roll[foot] = None;
    }

    /// A way along the sole of a foot that stands flat [m].
    fn along_the_sole(&self, way: f64) -> Vector3<f64> {
        way * self.ground.tangents[0]
    }

    /// The point of the ground below the ankle of a foot that stands flat.
    fn below_the_ankle(&self, foot: usize) -> Vector3<f64> {
        let Flat { x, z } = self.placed[foot];
        Vector3::new(x, 0.0, z)
    }

    /// The roll of a foot that begins now and lifts off after `duration` [s].
    pub(super) fn roll_of(&self, duration: f64) -> Roll {
        let angle = (self.settings.heel_off_turn * self.place).min(self.settings.heel_off_max_rad);
        Roll { since: self.time, duration: duration / ROLLED, angle }
    }

    /// Turns a standing foot over its toe, if it rolls.
    pub(super) fn roll_over(&mut self, foot: usize, footing: Footing) {
        let Some(roll) = self.roll[foot] else { return };
        let turn = Motion::from(minimum_jerk(self.time, roll.since, roll.duration));
        self.footing[foot] = footing;
        let angle = AngleReference {
            angle: self.ground.slope - roll.angle * turn.value,
            velocity: -roll.angle * turn.rate,
            acceleration: -roll.angle * turn.acceleration,
        };
        let toe = self.below_the_ankle(foot) + self.along_the_sole(self.sole.toe);
        self.feet[foot] =
            ObjectReference { angle, point: PointReference { position: toe, ..PointReference::default() } };
    }

    /// The rear foot leaves the ground as it stands or rolls.
    pub(super) fn lift_off(&mut self, stance: usize, observation: &Observation) {
        let other = 1 - stance;
        let [angle, rate] = observation.pitch[other];
        self.pitch = Motion { value: angle, rate, acceleration: 0.0 };
        // The ankle moves about the toe.
        let [place, rate, acceleration] = turned([-self.sole.toe, self.sole.ankle], self.pitch).map(|point| point[0]);
        let toe = self.placed[other].x + self.along_the_sole(self.sole.toe).x - self.placed[stance].x;
        self.ankle = Motion { value: toe + place, rate, acceleration };
        self.roll[other] = None;
        self.swung = true;
    }

    /// The swinging foot `time` [s] after the step's begin.
    pub(super) fn swing(&mut self, origin: f64, time: f64, end: f64, phase: f64, step: f64) -> ObjectReference {
        // Above its place a little before it lands, so that only the descent is left.
        let left = end - self.settings.settling_s - time + step;
        let duration = end - self.settings.double_support_s;
        // The ankle is above its place along the ground's normal.
        let above = self.place + self.sole.ankle * self.ground.normal.x;
        self.ankle = self.ankle.toward(above, left, step);
        self.pitch = self.pitch.toward(self.ground.slope, left, step);
        let mut toe = swing::height(phase, duration, self.settings.clearance_m, self.settings.landing_speed_mps);
        if time > end {
            // Late: it descends until it finds the ground.
            let (late, speed) = (time - end, self.settings.landing_speed_mps);
            let change = self.settings.landing_acceleration_mps2;
            toe = Motion {
                value: -late * (speed + 0.5 * change * late),
                rate: -speed - change * late,
                acceleration: -change,
            };
        }
        let ankle = turned([self.sole.toe, -self.sole.ankle], self.pitch);
        let middle = turned([self.sole.middle(), -self.sole.ankle], self.pitch);
        let x = self.ankle;
        // The ankle's height follows from the toe's, which is above the ground below it.
        let steepness = self.ground.height_at(1.0);
        let height = |k: usize, toe: f64, x: f64| toe + steepness * (x + ankle[k][0]) - ankle[k][1];
        let z = [
            height(0, toe.value, origin + x.value),
            height(1, toe.rate, x.rate),
            height(2, toe.acceleration, x.acceleration),
        ];
        let point = |k: usize, x: f64| Vector3::new(x + middle[k][0], 0.0, z[k] + middle[k][1]);
        ObjectReference {
            angle: AngleReference {
                angle: self.pitch.value,
                velocity: self.pitch.rate,
                acceleration: self.pitch.acceleration,
            },
            point: PointReference {
                position: point(0, origin + x.value),
                velocity: point(1, x.rate),
                acceleration: point(2, x.acceleration),
            },
        }
    }

    /// A foot that stands flat.
    pub(super) fn flat(&self, foot: usize) -> ObjectReference {
        let position = self.below_the_ankle(foot) + self.along_the_sole(self.sole.middle());
        ObjectReference {
            angle: AngleReference { angle: self.ground.slope, ..AngleReference::default() },
            point: PointReference { position, ..PointReference::default() },
        }
    }
}

/// A point of a body that turns by `angle`, with velocity and acceleration, from where it is at no angle [m].
fn turned([x, z]: [f64; 2], angle: Motion) -> [[f64; 2]; 3] {
    let (sin, cos) = libm::sincos(angle.value);
    let at = [x * cos - z * sin, x * sin + z * cos];
    let (rate, change) = (angle.rate, angle.acceleration);
    [at, [-rate * at[1], rate * at[0]], [-change * at[1] - rate * rate * at[0], change * at[0] - rate * rate * at[1]]]
}
