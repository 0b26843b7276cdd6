//! Walking on feet: the XcoM follows a plan for each step, the centre of pressure corrects it within the foot, and the
//! swinging foot lands where and when the gait can go on (Englsberger et al. 2015, Khadiv et al. 2020).
//!
//! A step begins when a foot touches down, which then is the stance foot; all places in it are measured from that
//! foot's ankle, along the ground. First the rear foot unloads, rolling over its toe; then it swings. Shortly before it lands,
//! the stance foot's heel lifts off.

mod adapt;
mod feet;
mod ground;
mod landing;
mod plan;
mod stand;
mod swing;

use nalgebra::Vector3;

use super::stance::minimum_jerk;
use super::{
    Footing, Generator, ObjectReference, Observation, PointReference, Reference, Surroundings, Swing, TurnReference,
    xcom,
};
use crate::settings::{Adaptation, ReferenceSettings, WalkerSettings};
pub use adapt::GRID_S;
use adapt::{Choice, law};
use feet::{Flat, Roll};
use ground::Trail;
use legwork_contract::feet::Sole;
use legwork_contract::terrain::{Line, Terrain};
use plan::{CopPlan, StepPlan};
pub use swing::Motion;

/// What of the lowering on climbs is due downhill, where the ground is not seen.
const UNSEEN_DOWNHILL: f64 = 0.5;
/// Slower than this is standing [m/s].
const STANDING: f64 = 0.02;
/// Feet that are closer than this stand together [m].
const TOGETHER: f64 = 0.04;
/// The way that is caught up where the centre of mass is not where it should be [m].
const FARTHEST_M: f64 = 0.15;
/// A step begins at most that long after its touchdown [s].
const EARLY_S: f64 = 0.05;
/// Touchdown counts after this share of a swing.
const LATE: f64 = 0.6;

/// What the robot does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Both feet stand.
    Standing,
    /// On `stance` since a time [s].
    Stepping { stance: usize, since: f64 },
}

/// The generator `walker`.
#[derive(Clone, Debug)]
pub struct Walker {
    settings: WalkerSettings,
    ground: Terrain,
    /// Whether it is so; else feet stand as they come to rest.
    ground_known: bool,
    /// The line that the centre of mass follows, through the stance foot.
    grade: Line,
    trail: Trail,
    sole: Sole,
    gravity: f64,
    weight: f64,
    /// Where the torso should be where it does not lean [rad].
    torso_angle: f64,
    omega: f64,
    /// Height of the centre of mass before the step and after it [m].
    height: [f64; 2],
    phase: Phase,
    plan: StepPlan,
    choice: Choice,
    /// Where the swinging foot is to land [m].
    place: f64,
    speed: f64,
    /// Where the centre of mass should be [m].
    way: f64,
    /// Time of the latest update [s].
    time: f64,
    bob: f64,
    /// The share of the step after which the centre of mass is lowest.
    lowest: f64,
    heel_off: f64,
    placed: [Flat; 2],
    /// Whether the stance foot has landed on one end and turns.
    settling: bool,
    /// Where the swinging foot's toe left the ground [m].
    left: Vector3<f64>,
    roll: [Option<Roll>; 2],
    ankle: Motion,
    pitch: Motion,
    swung: bool,
    /// How far the centre of mass is lowered for a long step, and how far it will be when the foot lands [m].
    drop: Motion,
    drop_to: f64,
    /// How far the torso leans to keep the balance [rad], and that shift of the centre of pressure that this stands for [m].
    lean: Motion,
    hip_shift: f64,
    com: f64,
    xcom: f64,
    xcom_reference: f64,
    cop: f64,
    feet: [ObjectReference; 2],
    footing: [Footing; 2],
    max_load: [f64; 2],
}

/// The settings for ground whose height the controller knows or does not know.
fn for_ground(settings: &WalkerSettings, is_known: bool) -> WalkerSettings {
    let mut settings = settings.clone();
    if !is_known {
        settings.landing_speed_mps = settings.unseen_landing_speed_mps;
        let highest = settings.unseen_com_height_m;
        settings.schedule.iter_mut().for_each(|[_, _, height, ..]| *height = height.min(highest));
    }
    settings
}

impl Walker {
    /// A walker that stands as at the `start`.
    pub fn new(settings: &WalkerSettings, around: &Surroundings<'_>, start: &Observation) -> Self {
        let (gravity, ground, ground_known) = (around.model.gravity, around.terrain.clone(), around.height_is_known);
        let settings = for_ground(settings, ground_known);
        let choice = Choice::of(&settings);
        let height = settings.schedule[0][2];
        let mut walker = Self {
            omega: xcom::eigenfrequency(gravity, height),
            height: [height; 2],
            gravity,
            weight: around.model.total_mass() * gravity,
            torso_angle: around.torso_angle,
            settings,
            grade: Line { x: 0.0, z: 0.0, steepness: ground.base().steepness()[0] },
            trail: Trail::default(),
            ground,
            ground_known,
            sole: Sole::of(around.model),
            phase: Phase::Standing,
            plan: StepPlan::default(),
            choice,
            place: 0.0,
            speed: 0.0,
            way: start.com.x,
            time: start.time,
            bob: 0.0,
            lowest: 0.0,
            heel_off: 0.0,
            placed: [Flat::default(); 2],
            settling: false,
            left: Vector3::zeros(),
            roll: [None; 2],
            ankle: Motion::default(),
            pitch: Motion::default(),
            swung: false,
            drop: Motion::default(),
            drop_to: 0.0,
            lean: Motion::default(),
            hip_shift: 0.0,
            com: start.com.x,
            xcom: start.com.x,
            xcom_reference: start.com.x,
            cop: start.com.x,
            feet: [ObjectReference::default(); 2],
            footing: [Footing::Stands; 2],
            max_load: [f64::INFINITY; 2],
        };
        for foot in 0..2 {
            walker.place_foot(foot, start);
        }
        walker.look_around();
        walker
    }

    /// The speed that is asked for at `time` [s].
    fn wanted_speed(&self, time: f64) -> f64 {
        let rows = &self.settings.speeds;
        let after = rows.partition_point(|row| row[0] <= time);
        if after == rows.len() {
            return rows.last().map_or(self.settings.speed_mps, |row| row[1]);
        }
        if after == 0 {
            return rows[0][1];
        }
        let ([t0, v0], [t1, v1]) = (rows[after - 1], rows[after]);
        v0 + (v1 - v0) * (time - t0) / (t1 - t0)
    }

    /// Stands or walks, `step` [s] after the tick before; once more, with none, in a tick in which a step begins.
    fn act(&mut self, step: f64, observation: &Observation) {
        match self.phase {
            Phase::Standing => self.stand(step, observation),
            Phase::Stepping { stance, since } => self.walk(stance, self.time - since, step, observation),
        }
    }

    /// A step begins on the foot `stance`, which touched down at `since` [s].
    fn begin_step(&mut self, stance: usize, since: f64) {
        let settings = &self.settings;
        let most = settings.speed_change_mps;
        self.speed += (self.wanted_speed(self.time) - self.speed).clamp(-most, most);
        let [duration, height, bob, lowest, heel_off] = self.settings.scheduled(self.speed);
        let before = self.grade;
        self.follow_the_ground(stance);
        // Uphill the rear leg would come to its end. On ground that is not seen it is lower already; downhill the leg that lands would.
        let uphill = self.grade.steepness * self.speed.signum();
        let steep = if self.ground_known { uphill } else { -UNSEEN_DOWNHILL * uphill };
        let height = height - self.settings.climb_lowering_m * steep.max(0.0);
        self.height = [self.height[1] + before.at(self.com) - self.grade.at(self.com), height];
        self.omega = xcom::eigenfrequency(self.gravity, height);
        let settings = &self.settings;
        // What a push has cost is not to be caught up.
        let farthest = self.settings.in_length(FARTHEST_M);
        self.way = self.way.max(self.com - farthest).min(self.com + farthest);
        let behind = settings.way_gain * (self.way - self.com);
        let length = ((self.speed + behind) * duration).clamp(-settings.longest_back_m, settings.longest_m);
        (self.bob, self.lowest, self.heel_off) = (bob, lowest, heel_off);
        let span = (settings.cop_span_share * length).clamp(-settings.cop_span_m, settings.cop_span_m);
        let clip = |cop: f64| cop.clamp(self.sole.heel + settings.cop_margin_m, self.sole.toe - settings.cop_margin_m);
        let first = clip(settings.cop_centre_m - 0.5 * span);
        let rolls = settings.heel_off_share(length);
        let flat = clip(settings.cop_centre_m + 0.5 * span);
        let last = flat + rolls * (self.sole.toe - flat);
        let time = [0.0, settings.double_support_s, duration - rolls * heel_off, duration];
        // The next step begins with the rear foot `u` behind and ends as a nominal step does.
        let next = |u: f64| CopPlan { time, cop: [last - u, first, last, last] };
        let nominal = length + next(length).offset(self.omega, length);
        let of_length = |u: f64| next(u).back(self.omega, nominal, duration, 0.0);
        let at_zero = of_length(0.0);
        self.choice.offset = [at_zero, of_length(1.0) - at_zero];
        (self.choice.length, self.choice.duration, self.place) = (length, duration, length);
        self.choice.earliest = settings.double_support_s + settings.shortest_swing_s;
        let rear = self.placed[1 - stance].x - self.placed[stance].x;
        let rear = if self.phase == Phase::Standing { first } else { rear + self.plan.cop.cop[3] };
        self.plan = StepPlan {
            cop: CopPlan { time, cop: [rear, first, last, last] },
            omega: self.omega,
            end: self.end(length),
        };
        self.phase = Phase::Stepping { stance, since };
        self.swung = false;
    }

    /// Whether the step is long enough for the stance foot to roll over its toe.
    fn heel_lifts(&self) -> bool {
        self.settings.heel_off_share(self.place) > 0.0
    }

    /// How long before the landing the stance foot's heel lifts off [s].
    fn heel_off_s(&self) -> f64 {
        self.settings.heel_off_share(self.place) * self.heel_off
    }

    /// XcoM at the end of a step that lands at `place` [m].
    fn end(&self, place: f64) -> f64 {
        place + self.choice.offset[0] + self.choice.offset[1] * place
    }

    /// Ends of the support at `time` [s] of the step; in double support it shrinks as the rear foot unloads.
    fn support(&self, stance: usize, time: f64) -> [f64; 2] {
        let margin = self.settings.cop_margin_m;
        let rolls = time >= self.plan.cop.time[2] && self.heel_lifts();
        let mut low = if rolls { self.sole.toe } else { self.sole.heel + margin };
        let mut high = if rolls { self.sole.toe } else { self.sole.toe - margin };
        let loaded = (1.0 - time / self.settings.double_support_s).min(1.0);
        if loaded > 0.0 {
            let rear = self.placed[1 - stance].x - self.placed[stance].x;
            let rear = if self.roll[1 - stance].is_some() {
                [rear + self.sole.toe; 2]
            } else {
                [rear + self.sole.heel + margin, rear + self.sole.toe - margin]
            };
            low = low.min(loaded * rear[0] + (1.0 - loaded) * low);
            high = high.max(loaded * rear[1] + (1.0 - loaded) * high);
        }
        [low, high]
    }

    fn walk(&mut self, stance: usize, time: f64, step: f64, observation: &Observation) {
        let origin = self.placed[stance].x;
        let other = 1 - stance;
        let lift_off = self.settings.double_support_s;
        if time >= lift_off && !self.swung {
            self.lift_off(stance, observation);
        }
        if time >= lift_off {
            self.adapt(stance, time, step);
        }
        let end = self.plan.cop.time[3];
        self.drop = self.drop.toward(self.drop_to, end - time, step);
        self.lean_by(self.hip_return(), step);
        let phase = (time - lift_off) / (end - lift_off);
        if self.swung && phase > LATE && observation.load[other] > self.settings.touchdown_force_n {
            self.touch_down(stance, time, observation);
            return self.act(0.0, observation);
        }

        self.xcom_reference = origin + self.plan.xcom(time);
        let gain = self.settings.cop_gain;
        let reference = self.xcom_reference - origin;
        self.cop = origin + law(&self.plan, gain, self.xcom - origin, reference, time, self.support(stance, time));

        // The stance foot
        let begins = time >= self.plan.cop.time[2] || self.waits_too_long(stance, time, observation);
        if self.heel_lifts() && self.roll[stance].is_none() && begins {
            self.plan.cop.time[2] = self.plan.cop.time[2].min(time);
            self.roll[stance] = Some(self.roll_of(self.heel_off_s() + lift_off));
        }
        self.feet[stance] = self.flat(stance);
        self.footing[stance] = Footing::Stands;
        self.max_load[stance] = f64::INFINITY;
        if self.ground_known {
            self.set_down(stance, observation);
        } else if self.settling {
            self.settle(stance, observation);
        }
        self.roll_over(stance, Footing::Rolls);

        // The other one
        if self.swung {
            self.footing[other] = Footing::Swings;
            self.max_load[other] = 0.0;
            self.feet[other] = self.swing(origin, time, end, phase, step);
        } else {
            self.footing[other] = Footing::Stands;
            self.feet[other] = self.flat(other);
            self.roll_over(other, Footing::Trails);
            self.max_load[other] = self.settings.unloading * self.weight * (1.0 - time / lift_off).clamp(0.0, 1.0);
        }
    }

    /// The foot that swung stands from now on.
    fn touch_down(&mut self, stance: usize, elapsed: f64, observation: &Observation) {
        let other = 1 - stance;
        self.place_foot(other, observation);
        self.settling = !self.ground_known;
        if self.roll[stance].is_none() && self.heel_lifts() {
            self.roll[stance] = Some(self.roll_of(self.settings.double_support_s));
        }
        let apart = (self.placed[other].x - self.placed[stance].x).abs();
        let stops = self.wanted_speed(self.time).abs() <= self.settings.in_speed(STANDING) && !self.settings.march;
        let ahead = self.xcom - self.placed[other].x;
        let holds = (self.sole.heel..self.sole.toe).contains(&ahead);
        if stops
            && self.speed.abs() <= self.settings.in_speed(STANDING)
            && apart < self.settings.in_length(TOGETHER)
            && holds
            && self.roll[stance].is_none()
        {
            (self.phase, self.speed) = (Phase::Standing, 0.0);
        } else {
            // A foot that lands a little early waits for its step to begin, so that the plan goes on without a jump.
            let early = (self.plan.cop.time[3] - elapsed).clamp(0.0, self.settings.in_time(EARLY_S));
            self.begin_step(other, self.time + early);
        }
    }

    /// The centre of mass: along x as far as it has been commanded, its height follows the step.
    fn com(&self) -> PointReference {
        let ground = self.grade.at(self.com);
        let mut com = PointReference {
            position: Vector3::new(self.way, 0.0, self.height[1] + ground),
            velocity: Vector3::new(self.speed, 0.0, 0.0),
            acceleration: Vector3::zeros(),
        };
        // Parallel to the ground, so that the pendulum's frequency stays (Kajita et al. 2001).
        let steepness = self.grade.steepness;
        com.velocity.z = steepness * self.speed;
        com.acceleration.z = steepness * self.omega * self.omega * (self.com - self.cop);
        com.position.z -= self.drop.value;
        com.velocity.z -= self.drop.rate;
        com.acceleration.z -= self.drop.acceleration;
        if let Phase::Stepping { since, .. } = self.phase {
            let rate = std::f64::consts::TAU / self.plan.cop.time[3];
            let (sin, cos) = libm::sincos(rate * (self.time - since) - std::f64::consts::TAU * self.lowest);
            let half = 0.5 * self.bob;
            let (left, duration) = (self.height[0] - self.height[1], self.choice.duration);
            let change = Motion::from(minimum_jerk(self.time, since, duration));
            com.position.z += left * (1.0 - change.value);
            com.velocity.z -= left * change.rate;
            com.acceleration.z -= left * change.acceleration;
            com.position.z -= half * cos;
            com.velocity.z += half * rate * sin;
            com.acceleration.z += half * rate * rate * cos;
        }
        com
    }

    /// The foot that swings and since when, if one does.
    fn swinging(&self) -> Option<Swing> {
        match self.phase {
            Phase::Stepping { stance, since } if self.swung => {
                Some(Swing { foot: 1 - stance, since: since + self.settings.double_support_s })
            }
            _ => None,
        }
    }
}

impl Generator for Walker {
    fn update(&mut self, seen: &Observation, reference: &mut Reference) {
        let step = seen.time - self.time;
        self.time = seen.time;
        self.way += self.speed * step;
        self.com = seen.com.x;
        self.xcom = xcom::xcom(seen.com.x, seen.com_velocity.x, self.omega);
        self.act(step, seen);

        let Motion { value, rate, acceleration } = self.lean;
        reference.chest.turn = TurnReference::pitch(value + self.torso_angle, rate, acceleration);
        reference.chest.point = self.com();
        reference.feet = self.feet;
        reference.footing = self.footing;
        reference.max_load = self.max_load;
        reference.cop = Some(Vector3::new(self.cop + self.hip_shift, 0.0, self.grade.at(self.cop)));
        reference.moment = Vector3::new(0.0, self.weight * self.hip_shift, 0.0);
        reference.swing = self.swinging();
        reference.xcom = [self.xcom, 0.0];
        reference.xcom_reference = [self.xcom_reference, 0.0];
        reference.cop_reference = [self.cop, 0.0];
    }

    fn change(&mut self, settings: &ReferenceSettings) {
        self.settings = for_ground(&settings.walker, self.ground_known);
        let Choice { time_weight, offset_weight, latest, time_is_free, .. } = Choice::of(&self.settings);
        self.choice = Choice { time_weight, offset_weight, latest, time_is_free, ..self.choice };
    }
}
