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
