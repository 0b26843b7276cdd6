//! What the controller takes its contact points to feel: flags and loads as they are sensed, held against where feet should stand.
//!
//! Flags are made of gaps or of forces, with somebody's threshold; loads are late, or nobody measures them. So a point that is no
//! longer felt stands on while it is about as high as where it was felt last; where its foot should stand and comes back to that
//! height it is loaded, to find out, and given up where it bears nothing.

use legwork_contract::contract::{ContactSensed, Sensed};
use legwork_contract::feet::{FeetMotion, Footing};
use legwork_contract::robot::Robot;
use legwork_contract::terrain::Terrain;
use legwork_rbd::Dynamics;

/// Flags that are up for this long without a load say that nobody measures the loads [s].
const UNMEASURED_S: f64 = 0.05;

/// A contact point that comes down faster bears no load yet [m/s].
const LANDING_MPS: f64 = 0.05;

/// The program asks a point for a force where that is more than this [N].
const ASKED_N: f64 = 30.0;
/// For this long a point that is not felt is asked [s]: flags that are later than that give up feet that stand.
const PATIENCE_S: f64 = 0.005;
/// So much later it is asked again [s].
const RETRY_S: f64 = 0.1;

/// What is remembered of a contact point.
#[derive(Clone, Copy, Debug, Default)]
struct Memory {
    /// Whether it stood.
    stood: bool,
    /// How long the program has asked it for a force, and it was not felt [s].
    asked: f64,
    /// The height above the ground that the controller believes in at which it was felt last [m].
    height: f64,
}

/// All contact points.
#[derive(Clone, Debug)]
pub struct Contacts {
    points: Vec<ContactSensed>,
    memory: Vec<Memory>,
    /// Of the robot [N].
    weight: f64,
    /// Of the latest update [s].
    time: Option<f64>,
    /// How long flags have been up without a load [s].
    unloaded: f64,
}

impl Contacts {
    /// Those of `model`, of which nothing was sensed yet.
    pub fn new(model: &Robot) -> Self {
        Self {
            points: vec![ContactSensed::default(); model.contacts.len()],
            memory: vec![Memory::default(); model.contacts.len()],
            weight: model.total_mass() * model.gravity,
            time: None,
            unloaded: 0.0,
        }
    }

    /// What each point is taken to feel, in the order of the model's.
    pub fn points(&self) -> &[ContactSensed] {
        &self.points
    }

    /// Takes in what was `sensed` of `model` in the state of `dynamics` and `feet`, which should do what `footing` says, on the
    /// `ground` that the controller believes in; `lift` is how far a point that stands may be from where it was felt [m]. Allocates
    /// nothing.
    pub fn update(
        &mut self,
        lift: f64,
        (model, ground): (&Robot, &Terrain),
        sensed: &Sensed,
        (dynamics, feet): (&Dynamics, &FeetMotion),
        (footing, forces): (&[Footing], &[f64]),
    ) {
        let before = self.time.replace(sensed.time);
        let period = sensed.time - before.unwrap_or(sensed.time);
        let axes = model.linear_axes().len();
        self.points.copy_from_slice(&sensed.contacts);
        for (index, (point, memory)) in self.points.iter_mut().zip(&mut self.memory).enumerate() {
            let height = ground.gap(&dynamics.contact_positions[index]);
            let foot = model.foot_of[index];
            let should = || match footing.get(foot) {
                Some(Footing::Swings) => false,
                Some(&footing) => feet.points(foot, footing).contains(&index),
                None => true,
            };
            // Nothing is measured before the first tick.
            if point.touching || before.is_none() {
                memory.height = height;
            }
            // A point that bears nothing for a while of what it is asked for is not there; later it is asked again.
            let is_asked = forces[index * axes + axes - 1] > ASKED_N || memory.asked > PATIENCE_S;
            if is_asked {
                memory.asked += period;
            }
            if point.touching || memory.asked > PATIENCE_S + RETRY_S {
                memory.asked = 0.0;
            }
            let is_there = (height - memory.height).abs() <= lift && memory.asked <= PATIENCE_S;
            point.touching |= is_there && (memory.stood || should());
            memory.stood = point.touching;
        }
        let is_flagged = sensed.contacts.iter().any(|felt| felt.touching);
        let is_loaded = sensed.contacts.iter().any(|felt| felt.load != 0.0);
        self.unloaded = if is_loaded || !is_flagged { 0.0 } else { self.unloaded + period };
        if self.unloaded > UNMEASURED_S {
            self.share(sensed, dynamics);
        }
    }

    /// Nobody measures the loads: the points that are felt share the weight, but for those that still come down.
    fn share(&mut self, sensed: &Sensed, dynamics: &Dynamics) {
        let bears =
            |index: usize| sensed.contacts[index].touching && dynamics.contact_velocities[index].z > -LANDING_MPS;
        let share = self.weight / (0..self.points.len()).filter(|&index| bears(index)).count() as f64;
        for (index, point) in self.points.iter_mut().enumerate() {
            point.load = if bears(index) { share } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot with point feet on level ground, in what it is told.
    struct Told {
        model: Robot,
        ground: Terrain,
        dynamics: Dynamics,
        feet: FeetMotion,
        sensed: Sensed,
        contacts: Contacts,
        footing: [Footing; 2],
        /// Along x and z, of the right point and of the left.
        forces: [f64; 4],
    }

    impl Told {
        fn new() -> Self {
            let text = include_str!("../../../models/planar_humanoid.toml");
            let model = Robot::from_toml(text, "humanoid").expect("a sound model");
            let mut told = Self {
                ground: Terrain::plane(&model, 0.8, [0.0; 2]),
                dynamics: Dynamics::new(&model),
                feet: FeetMotion::new(&model),
                sensed: Sensed::new(&model),
                contacts: Contacts::new(&model),
                footing: [Footing::Stands; 2],
                forces: [0.0; 4],
                model,
            };
            told.raise(0.0, 0.0);
            told
        }

        /// Puts the robot so high above where it began, with this speed upward.
        fn raise(&mut self, height: f64, speed: f64) {
            (self.sensed.q[1], self.sensed.v[1]) = (height, speed);
            self.dynamics.update(&self.model, &self.sensed.q, &self.sensed.v);
            self.feet.update(&self.model, &self.dynamics);
        }

        /// A tick later by `period` with these flags: whether the points are taken to stand. They may be 2 mm from where they were felt.
        fn tick(&mut self, period: f64, flags: [bool; 2]) -> [bool; 2] {
            self.sensed.time += period;
            for (point, flag) in self.sensed.contacts.iter_mut().zip(flags) {
                point.touching = flag;
            }
            let seen = (&self.dynamics, &self.feet);
            let world = (&self.model, &self.ground);
            self.contacts.update(0.002, world, &self.sensed, seen, (&self.footing, &self.forces));
            [0, 1].map(|index| self.contacts.points()[index].touching)
        }
    }

    #[test]
    fn a_point_that_bears_nothing_of_what_it_is_asked_for_is_given_up_and_asked_again() {
        let mut told = Told::new();
        assert_eq!(told.tick(0.0, [true, true]), [true, true]);
        // The left point is asked for more than 30 N, the right one for less. Its patience of 5 ms ends in the third tick of 2 ms, and
        // 100 ms later, in the 53rd, it is asked anew.
        told.forces = [500.0, 29.0, 0.0, 31.0];
        for tick in 1..=55 {
            let is_left = !(3..53).contains(&tick);
            assert_eq!(told.tick(0.002, [false, false]), [true, is_left], "tick {tick}");
        }
        // Once it is felt its patience begins anew.
        assert_eq!(told.tick(0.002, [false, true]), [true, true]);
        let stands: Vec<bool> = (0..3).map(|_| told.tick(0.002, [false, false])[1]).collect();
        assert_eq!(stands, [true, true, false]);
    }

    #[test]
    fn a_point_stands_while_it_is_about_as_high_as_where_it_was_felt() {
        for (height, stands) in [(0.0019, true), (-0.0019, true), (0.0021, false), (-0.0021, false)] {
            let mut told = Told::new();
            assert_eq!(told.tick(0.001, [true, true]), [true, true]);
            told.raise(height, 0.0);
            assert_eq!(told.tick(0.001, [false, false]), [stands; 2], "{height} m");
            // Back at that height stands what did and what should.
            told.raise(0.0, 0.0);
            told.footing = [Footing::Stands, Footing::Swings];
            assert_eq!(told.tick(0.001, [false, false]), [true, stands], "{height} m");
        }
        // Felt higher up it is held against that height.
        let mut told = Told::new();
        told.tick(0.001, [true, true]);
        told.raise(0.1, 0.0);
        assert_eq!(told.tick(0.001, [true, false]), [true, false]);
        told.raise(0.101, 0.0);
        assert_eq!(told.tick(0.001, [false, false]), [true, false]);
    }

    #[test]
    fn points_share_the_weight_where_nobody_measures_loads() {
        let mut told = Told::new();
        let weight = told.model.total_mass() * told.model.gravity;
        let loads = |told: &Told| [0, 1].map(|index| told.contacts.points()[index].load);
        told.tick(0.0, [true, true]);
        // Nothing is measured for 40 ms, and then for 60.
        for (period, expected) in [(0.02, 0.0), (0.02, 0.0), (0.02, 0.5 * weight)] {
            told.tick(period, [true, true]);
            assert_eq!(loads(&told), [expected; 2]);
        }
        told.tick(0.02, [false, true]);
        assert_eq!(loads(&told), [0.0, weight]);
        // What comes down at 6 cm/s bears nothing yet, at 4 cm/s it does.
        for (speed, expected) in [(-0.06, 0.0), (-0.04, 0.5 * weight)] {
            told.raise(0.0, speed);
            told.tick(0.02, [true, true]);
            assert_eq!(loads(&told), [expected; 2]);
        }
        // A load that is measured ends it, and so does being off the ground.
        told.sensed.contacts[0].load = 300.0;
        told.tick(0.02, [true, true]);
        assert_eq!(loads(&told), [300.0, 0.0]);
        told.sensed.contacts[0].load = 0.0;
        for flags in [[true, true], [true, true], [false, false], [true, true], [true, true]] {
            told.tick(0.02, flags);
            assert_eq!(loads(&told), [0.0; 2]);
        }
    }
}
