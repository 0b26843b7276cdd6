//! Where and when the swinging foot lands, as far as foot and leg reach.

use super::adapt::{self, Landing};
use super::{Adaptation, Observation, Walker};

/// A foot's place is settled that long before it is above it [s].
const HELD_S: f64 = 0.02;
/// A step's time is settled that long before the foot lands [s]: it comes down with no more speed than planned.
const SETTLED_S: f64 = 0.08;
/// The most that a step's time changes [s/s].
const TIME_RATE: f64 = 2.0;
/// Reach is reckoned for at least that long [s].
const LEAST_S: f64 = 0.02;

impl Walker {
    /// Chooses place and time of landing.
    pub(super) fn adapt(&mut self, stance: usize, time: f64, step: f64) {
        let settings = &self.settings;
        let settled = self.plan.cop.time[3] - settings.settling_s - time < settings.in_time(HELD_S);
        if settings.adaptation == Adaptation::None || step == 0.0 || settled {
            return;
        }
        let origin = self.placed[stance].x;
        let end = self.plan.cop.time[3];
        let mut choice = self.choice;
        let settled = settings.settling_s + settings.in_time(SETTLED_S);
        choice.time_is_free &= end - time > settled;
        choice.earliest = choice.earliest.max(time + settled);
        let (longest, back) = (settings.longest_m, settings.longest_back_m);
        let reach = |landing: f64, com: f64| {
            let left = (landing - settings.settling_s - time).max(settings.in_time(LEAST_S));
            let foot = self.ankle.reach(settings.swing_acceleration_mps2, left);
            let leg = self.leg_reach(landing - time);
            let low = foot[0].max(com + leg[0]).clamp(-back, longest);
            [low, foot[1].min(com + leg[1]).min(longest).max(low)]
        };
        let landing = adapt::best_landing(
            &self.plan,
            settings.cop_gain,
            &choice,
            time.min(end),
            [self.com - origin, self.xcom - origin],
            |at| self.support(stance, at),
            reach,
        );
        self.go_for(landing, stance, time, if choice.time_is_free { TIME_RATE * step } else { 0.0 });
    }

    /// Goes for a landing; its time changes by no more than `most` [s] now.
    fn go_for(&mut self, landing: Landing, stance: usize, time: f64, most: f64) {
        self.place = landing.place;
        self.drop_to = self.drop_for(landing.place - landing.com);
        let heel_off = self.heel_off_s();
        let times = &mut self.plan.cop.time;
        times[3] += (landing.time - times[3]).clamp(-most, most);
        if self.roll[stance].is_none() {
            times[2] = (times[3] - heel_off).max(time);
        }
        self.plan.end = self.end(self.place);
    }

    /// Whether the heel would have lifted by now in the step as planned, and the leg of the standing foot comes to its end: a
    /// step that a push prolongs waits no longer.
    pub(super) fn waits_too_long(&self, stance: usize, time: f64, observation: &Observation) -> bool {
        let ankle = &self.placed[stance];
        let across = observation.com.x - ankle.x;
        let high = self.settings.hip_above_ankle(observation.com.z, self.sole.ankle) - ankle.z;
        let leg = (across * across + high * high).sqrt();
        self.swung && time > self.choice.duration - self.heel_off_s() && leg > self.settings.stretched_leg_m
    }

    /// Height of the hip above the ankle of a foot below it, where nothing lowers it [m].
    fn hip_height(&self) -> f64 {
        self.settings.hip_above_ankle(self.height[1] - 0.5 * self.bob, self.sole.ankle)
    }

    /// Places of the foot that the leg reaches in `left` [s], from the centre of mass, which is lowered until then [m].
    fn leg_reach(&self, left: f64) -> [f64; 2] {
        let settings = &self.settings;
        let [_, drop] = self.drop.reach(settings.drop_acceleration_mps2, left.max(settings.in_time(LEAST_S)));
        let height = self.hip_height() - drop.clamp(0.0, settings.longest_drop_m);
        // d² + (h - s d)² = l² on ground of the steepness s
        let steepness = self.grade.steepness;
        let (a, b) = (1.0 + steepness * steepness, steepness * height);
        let root = (b * b - a * (height * height - settings.leg_m * settings.leg_m)).max(0.0).sqrt();
        [(b - root) / a, (b + root) / a]
    }

    /// How far the centre of mass has to be lowered for a foot to land that far before it [m].
    fn drop_for(&self, ahead: f64) -> f64 {
        let leg = self.settings.leg_m;
        let height = self.grade.steepness * ahead + (leg * leg - ahead * ahead).max(0.0).sqrt();
        (self.hip_height() - height).clamp(0.0, self.settings.longest_drop_m)
    }
}

#[cfg(test)]
mod tests {
    use legwork_contract::robot::Robot;
    use legwork_contract::terrain::Terrain;
    use nalgebra::{Matrix3, Vector3};

    use super::super::{Surroundings, Walker};
    use super::*;
    use crate::settings::ReferenceSettings;

    fn on_slope(slope: f64) -> Walker {
        let text = include_str!("../../../../../models/planar_humanoid_feet.toml");
        let model = Robot::from_toml(text, "feet.toml").expect("a sound model");
        let terrain = Terrain::plane(&model, 0.8, [slope, 0.0]);
        let around = Surroundings { model: &model, terrain: &terrain, height_is_known: true, torso_angle: 0.0 };
        let start = Observation {
            rotation: [Matrix3::identity(); 2],
            ahead: [Vector3::x(); 2],
            time: 0.0,
            com: Vector3::new(0.0, 0.0, 0.9),
            com_velocity: Vector3::zeros(),
            feet: [Vector3::zeros(); 2],
            pitch: [[0.0; 2]; 2],
            touching: [true; 2],
            load: [350.0; 2],
            end_load: [[175.0; 2]; 2],
        };
        Walker::new(&ReferenceSettings::default().walker, &around, &start)
    }

    /// Distance of the ankle from the hip above the origin, where the one lands `ahead` and the other is lowered by `drop` [m].
    fn leg(walker: &Walker, slope: f64, ahead: f64, drop: f64) -> f64 {
        (walker.hip_height() - drop - libm::tan(slope) * ahead).hypot(ahead)
    }

    #[test]
    fn lowered_the_leg_is_as_long_as_it_may_be_on_any_slope() {
        for slope in [-0.14, -0.05, 0.0, 0.05, 0.14] {
            let walker = on_slope(slope);
            let (length, longest) = (walker.settings.leg_m, walker.settings.longest_drop_m);
            let mut lowered = 0;
            for ahead in (-60..=60).map(|cm| 0.01 * f64::from(cm)) {
                let drop = walker.drop_for(ahead);
                let found = leg(&walker, slope, ahead, drop);
                if drop == 0.0 {
                    assert!(found <= length + 1e-12, "{slope}, {ahead}: {found}");
                } else if drop < longest {
                    lowered += 1;
                    assert!((found - length).abs() < 1e-12, "{slope}, {ahead}: {found}");
                } else {
                    assert!(drop == longest && found >= length - 1e-12, "{slope}, {ahead}: {found}");
                }
            }
            assert!(lowered > 20, "{lowered} on {slope}");
            // With time enough the leg reaches where it is as long when lowered by all that it may be.
            for ahead in walker.leg_reach(10.0) {
                assert!((leg(&walker, slope, ahead, longest) - length).abs() < 1e-12, "{slope}, {ahead}");
            }
        }
    }
}
