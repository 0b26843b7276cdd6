//! Standing: the centre of mass sways and squats, and a foot may be lifted once, all planned beforehand.
//!
//! The sway begins smoothly within its first period. Before a foot is lifted, the centre of mass moves above the other
//! one; after it has come down, back.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::{
    ComTrajectory, Generator, Observation, PointReference, Reference, Surroundings, Swing, TurnReference, xcom,
};
use crate::settings::{Lift, StanceSettings};
use legwork_contract::feet::{headed, level, pitched};
use legwork_contract::terrain::Terrain;

/// Share of the time off the ground in which a foot is lifted, and in which it is lowered.
const RISE: f64 = 0.3;

/// The plan of the generator `stance`.
#[derive(Clone, Debug)]
pub struct Stance {
    com: ComTrajectory,
    torso: TurnReference,
    settings: StanceSettings,
    ground: Terrain,
    gravity: f64,
    /// Where the feet stand [m].
    standing: [Vector3<f64>; 2],
    /// How they lie.
    lying: [TurnReference; 2],
    /// The rotation about z to where they point in the mean.
    heading: Matrix3<f64>,
    /// The foot that is lifted, and from the centre of mass to above the other one [m].
    lifted: Option<(usize, Vector3<f64>)>,
    swinging: Option<usize>,
    xcom: [f64; 2],
}

impl Stance {
    /// A plan for a robot that stands as at the `start`, around the trajectory `com`.
    pub fn new(settings: &StanceSettings, com: ComTrajectory, around: &Surroundings<'_>, start: &Observation) -> Self {
        let lifted = match settings.lift {
            Lift::None => None,
            Lift::Right => Some(0),
            Lift::Left => Some(1),
        };
        let above = |foot: usize| {
            let way: Vector3<f64> = start.feet[1 - foot] - start.com;
            (foot, Vector3::new(way.x, way.y, 0.0))
        };
        let heading = headed(&level(&(start.ahead[0] + start.ahead[1])));
        let (torso, lying) = if around.model.is_planar() {
            let [torso, right, left] = [around.torso_angle, start.pitch[0][0], start.pitch[1][0]]
                .map(|angle| TurnReference::pitch(angle, 0.0, 0.0));
            (torso, [right, left])
        } else {
            let torso = TurnReference::still(&(heading * pitched(around.torso_angle)));
            (torso, start.rotation.each_ref().map(TurnReference::still))
        };
        Self {
            com,
            torso,
            settings: settings.clone(),
            ground: around.terrain.clone(),
            gravity: around.model.gravity,
            standing: start.feet,
            lying,
            heading,
            lifted: lifted.map(above),
            swinging: None,
            xcom: [start.com.x, start.com.y],
        }
    }

    /// Moves on to the time of `observation`; `com` is the centre of mass's reference.
    fn move_on(&mut self, observation: &Observation, com: &PointReference) {
        let height = com.position.z - self.ground.height_at(com.position.x, com.position.y);
        let omega = xcom::eigenfrequency(self.gravity, height);
        self.xcom = [0, 1].map(|axis| xcom::xcom(observation.com[axis], observation.com_velocity[axis], omega));
        let begin = self.lift_off();
        let off = (begin..begin + self.settings.lift_duration_s).contains(&observation.time);
        self.swinging = self.lifted.map(|(foot, _)| foot).filter(|_| off);
    }

    /// When the foot leaves the ground [s].
    fn lift_off(&self) -> f64 {
        self.settings.lift_start_s + self.settings.shift_s
    }

    /// What sway, squat and the shift above a foot add to the centre of mass at `time` [s].
    pub fn com_offset(&self, time: f64) -> PointReference {
        let settings = &self.settings;
        let rate = TAU / settings.period_s;
        let (sin, cos) = libm::sincos(rate * time);
        let wave = [sin, rate * cos, -rate * rate * sin];
        let squat = [0.5 * (1.0 - cos), 0.5 * rate * sin, 0.5 * rate * rate * cos];
        let begin = minimum_jerk(time, 0.0, settings.period_s);
        let sway = along(product(begin, wave), self.heading * Vector3::from(settings.sway_m));
        let squat = along(product(begin, squat), -settings.squat_m * Vector3::z());
        let shift = self.lifted.map_or_else(PointReference::default, |(_, above)| {
            let there = minimum_jerk(time, settings.lift_start_s, self.settings.shift_s);
            let back = minimum_jerk(time, self.lift_off() + settings.lift_duration_s, self.settings.shift_s);
            along(std::array::from_fn(|k| there[k] - back[k]), above)
        });
        sum(sum(sway, squat), shift)
    }

    /// Reference of a foot (0 right, 1 left) at `time` [s].
    pub fn foot(&self, foot: usize, time: f64) -> PointReference {
        let stands = PointReference { position: self.standing[foot], ..PointReference::default() };
        if self.swinging != Some(foot) {
            return stands;
        }
        let (begin, duration) = (self.lift_off(), self.settings.lift_duration_s);
        let rise = RISE * duration;
        let up = minimum_jerk(time, begin, rise);
        let down = minimum_jerk(time, begin + duration - rise, rise);
        let lifted = std::array::from_fn(|k| up[k] - down[k]);
        // Once forward and back, while it is up.
        let [turn, rate, change] = minimum_jerk(time, begin + rise, duration - 2.0 * rise).map(|x| TAU * x);
        let (sin, cos) = libm::sincos(turn);
        let swing = [sin, rate * cos, change * cos - rate * rate * sin];
        let height = along(lifted, self.settings.lift_height_m * Vector3::z());
        sum(stands, sum(height, along(swing, self.heading * (self.settings.swing_m * Vector3::x()))))
    }
}

impl Generator for Stance {
    fn update(&mut self, seen: &Observation, reference: &mut Reference) {
        let com = sum(self.com.at(seen.time), self.com_offset(seen.time));
        reference.chest.turn = self.torso;
        self.move_on(seen, &com);
        for (foot, goal) in reference.feet.iter_mut().enumerate() {
            goal.point = self.foot(foot, seen.time);
            goal.turn = self.lying[foot];
        }
        reference.swing(self.swinging.map(|foot| Swing { foot, since: self.lift_off() }));
        reference.xcom = self.xcom;
        reference.follow(com, self.gravity, &self.ground);
    }
}

/// From 0 to 1 within `duration` [s] from `begin` [s], with two derivatives. Flash and Hogan 1985
pub(super) fn minimum_jerk(time: f64, begin: f64, duration: f64) -> [f64; 3] {
    let s = ((time - begin) / duration).clamp(0.0, 1.0);
    [
        s * s * s * (10.0 + s * (-15.0 + 6.0 * s)),
        30.0 * s * s * (1.0 - s) * (1.0 - s) / duration,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration),
    ]
}

/// The product of two functions with their derivatives.
fn product(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]]
}

fn along(value: [f64; 3], way: Vector3<f64>) -> PointReference {
    PointReference { position: way * value[0], velocity: way * value[1], acceleration: way * value[2] }
}

/// Adds two motions.
pub(super) fn sum(a: PointReference, b: PointReference) -> PointReference {
    PointReference {
        position: a.position + b.position,
        velocity: a.velocity + b.velocity,
        acceleration: a.acceleration + b.acceleration,
    }
}

#[cfg(test)]
mod tests {
    use legwork_contract::robot::Robot;

    use super::*;
    use crate::settings::ReferenceSettings;

    fn plan() -> (Stance, Observation) {
        let settings = StanceSettings {
            sway_m: [0.02, 0.03, 0.01],
            squat_m: 0.1,
            lift: Lift::Left,
            swing_m: 0.1,
            ..ReferenceSettings::default().stance
        };
        let text = include_str!("../../../../models/planar_humanoid.toml");
        let model = Robot::from_toml(text, "humanoid").expect("a sound model");
        let terrain = Terrain::plane(&model, 0.8, [0.0; 2]);
        let around = Surroundings { model: &model, terrain: &terrain, height_is_known: true, torso_angle: 0.0 };
        let start = Observation {
            rotation: [Matrix3::identity(); 2],
            ahead: [Vector3::x(); 2],
            time: 0.0,
            com: Vector3::new(0.04, 0.0, 0.9),
            com_velocity: Vector3::zeros(),
            feet: [Vector3::new(0.0, -0.1, 0.0), Vector3::new(0.0, 0.1, 0.0)],
            pitch: [[0.0; 2]; 2],
            touching: [true, true],
            load: [0.0; 2],
            end_load: [[0.0; 2]; 2],
        };
        (Stance::new(&settings, ComTrajectory::Stationary(start.com), &around, &start), start)
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (mut stance, mut observation) = plan();
        let e = 1e-5;
        for time in [0.1, 0.9, 1.7, 2.3, 2.7, 3.4, 4.2, 4.6, 7.0] {
            observation.time = time;
            stance.move_on(&observation, &PointReference { position: Vector3::z(), ..PointReference::default() });
            let motions: [&dyn Fn(f64) -> PointReference; 2] = [&|t| stance.com_offset(t), &|t| stance.foot(1, t)];
            for motion in motions {
                let (before, here, after) = (motion(time - e), motion(time), motion(time + e));
                let velocity = (after.position - before.position) / (2.0 * e);
                let acceleration = (after.velocity - before.velocity) / (2.0 * e);
                assert!((velocity - here.velocity).norm() < 1e-6, "velocity at {time}");
                assert!((acceleration - here.acceleration).norm() < 1e-5, "acceleration at {time}");
            }
        }
    }

    #[test]
    fn the_centre_of_mass_is_above_the_standing_foot_while_the_other_is_lifted() {
        let (mut stance, mut observation) = plan();
        stance.settings.sway_m = [0.0; 3];
        for time in [2.6, 3.5, 4.4] {
            observation.time = time;
            stance.move_on(&observation, &PointReference::default());
            assert_eq!((stance.swinging, stance.lift_off()), (Some(1), 2.5));
            let com = observation.com + stance.com_offset(time).position;
            assert!((com.xy() - observation.feet[0].xy()).norm() < 1e-12, "{com}");
            assert!(stance.foot(1, time).position.z > 0.0 && stance.foot(0, time).position == observation.feet[0]);
        }
        observation.time = 4.6;
        stance.move_on(&observation, &PointReference::default());
        assert_eq!(stance.swinging, None);
        assert!(stance.com_offset(6.1).position.xy().norm() < 1e-12, "back again");
    }
}
