//! The walker's feet: standing flat, rolling over the toe, leaving the ground, swinging.

use nalgebra::Vector3;

use super::{Footing, Motion, Observation, Walker, swing};
use crate::generator::stance::minimum_jerk;
use crate::generator::{ObjectReference, PointReference, TurnReference};

/// The share of a heel's roll that is done when the foot lifts off: it still turns then.
const ROLLED: f64 = 0.8;

/// How fast a foot that has landed on one end turns until the other is down [rad/s].
const SETTLING_RATE: f64 = 1.0;

/// How fast it goes on down where it has lost the ground again [m/s].
const SINKING: f64 = 0.2;
/// A heel is up where its foot is turned by more than this [rad].
const HEEL_UP_RAD: f64 = 0.005;
/// How fast a heel comes down about its toe at the end [rad/s].
const HEEL_DOWN_RADPS: f64 = 0.4;

/// A foot that rolls over its toe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Roll {
    pub(super) since: f64,
    pub(super) duration: f64,
    /// At its end [rad].
    pub(super) angle: f64,
}

/// Where a foot is that stands on its sole.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flat {
    /// The point of the sole below the ankle [m].
    pub(super) x: f64,
    pub(super) z: f64,
    /// Its slope [rad].
    pub(super) pitch: f64,
    /// The direction along it.
    pub(super) along: Vector3<f64>,
    /// The point that surely is on the ground, before the one below the ankle [m].
    pub(super) meets: f64,
}

impl Flat {
    /// The sole that lies at `pitch` with its point below the ankle at `(x, z)`.
    pub(super) fn new(x: f64, z: f64, pitch: f64) -> Self {
        let (sin, cos) = libm::sincos(pitch);
        Self { x, z, pitch, along: Vector3::new(cos, 0.0, sin), meets: 0.0 }
    }

    /// The point of the sole that is `way` before the one below the ankle.
    pub(super) fn point(&self, way: f64) -> Vector3<f64> {
        Vector3::new(self.x, 0.0, self.z) + way * self.along
    }
}

impl Walker {
    /// A foot stands where it is now: as the ground below it lies, where that is known, else as it has come to rest.
    pub(super) fn place_foot(&mut self, foot: usize, observation: &Observation) {
        let at = |pitch: f64| {
            let lies = Flat::new(0.0, 0.0, pitch);
            let below = observation.feet[foot] - lies.point(self.sole.middle());
            Flat { x: below.x, z: below.z, ..lies }
        };
        self.placed[foot] = if self.ground_known {
            let line = self.below_a_sole(observation.feet[foot].x - self.sole.middle());
            let flat = at(line.pitch);
            Flat { z: line.z + libm::tan(line.pitch) * (flat.x - line.x), ..flat }
        } else {
            let meets = match observation.end_load[foot].map(|load| load > 0.0) {
                [true, false] => self.sole.heel,
                [false, true] => self.sole.toe,
                _ => 0.0,
            };
            Flat { meets, ..at(observation.pitch[foot][0]) }
        };
        self.roll[foot] = None;
    }

    /// The roll of a foot that begins now and lifts off after `duration` [s].
    pub(super) fn roll_of(&self, duration: f64) -> Roll {
        let turn = self.settings.heel_off_turn * self.settings.heel_off_share(self.place);
        let angle = (turn * self.place).min(self.settings.heel_off_max_rad);
        Roll { since: self.time, duration: duration / ROLLED, angle }
    }

    /// Turns a standing foot over its toe, if it rolls.
    pub(super) fn roll_over(&mut self, foot: usize, footing: Footing) {
        let Some(roll) = self.roll[foot] else { return };
        let turn = Motion::from(minimum_jerk(self.time, roll.since, roll.duration));
        self.footing[foot] = footing;
        let turn = TurnReference::pitch(
            self.placed[foot].pitch - roll.angle * turn.value,
            -roll.angle * turn.rate,
            -roll.angle * turn.acceleration,
        );
        let toe = self.placed[foot].point(self.sole.toe);
        self.feet[foot] =
            ObjectReference { turn, point: PointReference { position: toe, ..PointReference::default() } };
    }

    /// A standing foot whose heel is up turns down about its toe; were its middle held at the same time, the toe would be
    /// pressed into the ground. It brakes evenly where its heel would strike: the leg above it is straight in a step backward, and
    /// stops with it.
    pub(super) fn set_down(&mut self, foot: usize, observation: &Observation) {
        let [pitch, rate] = observation.pitch[foot];
        let left = self.placed[foot].pitch - pitch;
        if left <= HEEL_UP_RAD {
            return;
        }
        self.footing[foot] = Footing::Lands;
        self.feet[foot].point.position = self.placed[foot].point(self.sole.toe);
        let end = HEEL_DOWN_RADPS / self.settings.unit_s;
        if rate > end {
            let braking = (rate * rate - end * end) / (2.0 * left);
            self.feet[foot].turn = TurnReference::pitch(pitch, rate, -braking);
        }
    }

    /// The rear foot leaves the ground as it stands or rolls.
    pub(super) fn lift_off(&mut self, stance: usize, observation: &Observation) {
        let other = 1 - stance;
        let [angle, rate] = observation.pitch[other];
        self.pitch = Motion { value: angle, rate, acceleration: 0.0 };
        // The ankle moves about the toe.
        let [place, rate, acceleration] = turned([-self.sole.toe, self.sole.ankle], self.pitch).map(|point| point[0]);
        self.left = self.placed[other].point(self.sole.toe);
        let toe = self.left.x - self.placed[stance].x;
        self.ankle = Motion { value: toe + place, rate, acceleration };
        self.roll[other] = None;
        self.swung = true;
    }

    /// The swinging foot `time` [s] after the step's begin.
    pub(super) fn swing(&mut self, origin: f64, time: f64, end: f64, phase: f64, step: f64) -> ObjectReference {
        // Above its place a little before it lands, so that only the descent is left.
        let left = end - self.settings.settling_s - time + step;
        let duration = end - self.settings.double_support_s;
        let lies = self.below_a_sole(origin + self.place);
        // The ankle is above its place along the sole's normal.
        let above = self.place - self.sole.ankle * lies.along.z;
        self.ankle = self.ankle.toward(above, left, step);
        self.pitch = self.pitch.toward(lies.pitch, left, step);
        let below = self.way_of_the_toe(lies.point(self.sole.toe));
        let clearance = self.settings.clearance_m + self.obstacle(&below);
        let mut toe = swing::height(phase, duration, clearance, self.settings.landing_speed_mps);
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
        // The ankle's height follows from the toe's, which is above its way along the ground.
        let height = |k: usize, toe: f64, x: f64| toe + below.steepness * (x + ankle[k][0]) - ankle[k][1];
        let z = [
            toe.value + below.at(origin + x.value + ankle[0][0]) - ankle[0][1],
            height(1, toe.rate, x.rate),
            height(2, toe.acceleration, x.acceleration),
        ];
        let point = |k: usize, x: f64| Vector3::new(x + middle[k][0], 0.0, z[k] + middle[k][1]);
        ObjectReference {
            turn: TurnReference::pitch(self.pitch.value, self.pitch.rate, self.pitch.acceleration),
            point: PointReference {
                position: point(0, origin + x.value),
                velocity: point(1, x.rate),
                acceleration: point(2, x.acceleration),
            },
        }
    }

    /// A foot that has landed on one end alone on ground that the controller does not know turns to where it believes the
    /// ground to be, and on until the other end is down.
    pub(super) fn settle(&mut self, foot: usize, observation: &Observation) {
        let [heel, toe] = observation.end_load[foot].map(|load| load > 0.0);
        self.place_foot(foot, observation);
        self.feet[foot] = self.flat(foot);
        self.settling = !(heel && toe);
        let turning = SETTLING_RATE / self.settings.unit_s;
        let (now, believed) = (self.placed[foot].pitch, libm::atan(self.grade.steepness));
        let (end, footing, angle, rate) = match (heel, toe) {
            (true, true) => return,
            (true, false) => (self.sole.heel, Footing::OnHeel, now.min(believed), -turning),
            (false, true) => (self.sole.toe, Footing::Lands, now.max(believed), turning),
            (false, false) => {
                // It has bounced.
                self.feet[foot].point.velocity.z = -self.settings.in_speed(SINKING);
                return;
            }
        };
        self.footing[foot] = footing;
        self.feet[foot].point.position = self.placed[foot].point(end);
        self.feet[foot].turn = TurnReference::pitch(angle, rate, 0.0);
    }

    /// A foot that stands flat.
    pub(super) fn flat(&self, foot: usize) -> ObjectReference {
        let position = self.placed[foot].point(self.sole.middle());
        ObjectReference {
            turn: TurnReference::pitch(self.placed[foot].pitch, 0.0, 0.0),
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
