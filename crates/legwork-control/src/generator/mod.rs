//! Reference generators (thesis 4.3.1): where the centre of mass, the torso and the feet should be.
//!
//! Three are here. With `steps` the centre of mass has a trajectory that is given, and the feet react to the state through
//! the step state machine of Figure 4.2; with `stance` all is planned beforehand; `walker` walks on feet at a commanded
//! speed. Another one is whatever implements [`Generator`].

pub mod com_trajectory;
mod needs;
pub mod stance;
pub mod step;
pub mod swing;
pub mod walker;
pub mod xcom;

use std::fmt::Debug;

use legwork_contract::contract::{ContactSensed, Sensed};
use legwork_contract::error::Error;
pub use legwork_contract::feet::Footing;
use legwork_contract::feet::{FeetMotion, right_of, rotated, rotation_error};
use legwork_contract::robot::Robot;
use legwork_contract::terrain::Terrain;
use legwork_rbd::Dynamics;
use nalgebra::{Matrix3, Vector3};

use crate::settings::{GeneratorKind, ReferenceSettings};
pub use com_trajectory::ComTrajectory;
pub use needs::{check_feet, check_model};
pub use stance::Stance;
pub use step::{Phase, StepMachine, Steps};
pub use walker::Walker;

/// What decides where centre of mass, torso and feet should be.
pub trait Generator: Debug + Send + Sync {
    /// Writes the reference at the time of what is `seen`, and moves the generator's state on. `reference` is the one that it
    /// wrote before, at first [`Reference::default`]. Allocates nothing.
    fn update(&mut self, seen: &Observation, reference: &mut Reference);

    /// Takes new settings from now on, those that a [`ReferenceSettings`] of its kind may change while it runs.
    fn change(&mut self, _settings: &ReferenceSettings) {}
}

/// Position, velocity and acceleration of a point [m, m/s, m/s²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointReference {
    /// Position [m].
    pub position: Vector3<f64>,
    /// Velocity [m/s].
    pub velocity: Vector3<f64>,
    /// Acceleration [m/s²].
    pub acceleration: Vector3<f64>,
}

/// An orientation with two derivatives, in the world [rad, rad/s, rad/s²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TurnReference {
    /// The rotation vector that turns the world's axes into the object's: its direction is the axis, its length the angle.
    pub turn: Vector3<f64>,
    /// Angular velocity.
    pub velocity: Vector3<f64>,
    /// Angular acceleration.
    pub acceleration: Vector3<f64>,
}

impl TurnReference {
    /// An orientation in the x-z plane: angle, angular velocity and acceleration about −y, counter-clockwise as seen with x to
    /// the right and z up.
    pub fn pitch(angle: f64, velocity: f64, acceleration: f64) -> Self {
        let about = |value: f64| Vector3::new(0.0, -value, 0.0);
        Self { turn: about(angle), velocity: about(velocity), acceleration: about(acceleration) }
    }

    /// An orientation at rest.
    pub fn still(rotation: &Matrix3<f64>) -> Self {
        Self { turn: rotation_error(&Matrix3::identity(), rotation), ..Self::default() }
    }

    /// Its part in the vertical plane through the object's x axis, for a robot in the plane the x-z plane: the elevation of that
    /// axis, angular velocity and acceleration about the horizontal to its right, which is −y where x points ahead.
    pub fn in_plane(&self) -> [f64; 3] {
        if self.turn.x == 0.0 && self.turn.z == 0.0 {
            return [self.turn, self.velocity, self.acceleration].map(|vector| -vector.y);
        }
        let x = rotated(&self.turn).column(0).into_owned();
        let right = right_of(&x);
        [libm::atan2(x.z, libm::hypot(x.x, x.y)), right.dot(&self.velocity), right.dot(&self.acceleration)]
    }
}

/// One object of the reference: in the plane an angle and two coordinates with two derivatives each, the nine
/// trajectory variables of the thesis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectReference {
    /// Its orientation. Point feet have none: theirs stays zero.
    pub turn: TurnReference,
    /// Its position.
    pub point: PointReference,
}

/// The whole reference of one tick: 27 variables in the plane, and what a walk on feet adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// The torso's angle and the centre of mass.
    pub chest: ObjectReference,
    /// The right and the left foot.
    pub feet: [ObjectReference; 2],
    /// What they do.
    pub footing: [Footing; 2],
    /// Largest normal force on each [N].
    pub max_load: [f64; 2],
    /// Where on the ground the centre of pressure should be [m], or with a rate of angular momentum the moment pivot. Where it is
    /// given, the centre of mass accelerates as it asks, and its horizontal place is no goal.
    pub cop: Option<Vector3<f64>>,
    /// Wanted rate of the angular momentum, beside its damping [Nm].
    pub moment: Vector3<f64>,
    /// The foot that swings, if one does.
    pub swing: Option<Swing>,
    /// The extrapolated centre of mass along x and y, as the generator reckons it [m].
    pub xcom: [f64; 2],
    /// Where the extrapolated centre of mass should be along x and y [m].
    pub xcom_reference: [f64; 2],
    /// Where the centre of pressure should be along x and y if the torso did not lean [m].
    pub cop_reference: [f64; 2],
}

/// A swing under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// The foot: 0 right, 1 left.
    pub foot: usize,
    /// When its step was triggered [s].
    pub since: f64,
}

impl Default for Reference {
    fn default() -> Self {
        Self {
            chest: ObjectReference::default(),
            feet: [ObjectReference::default(); 2],
            footing: [Footing::Stands; 2],
            max_load: [f64::INFINITY; 2],
            cop: None,
            moment: Vector3::zeros(),
            swing: None,
            xcom: [0.0; 2],
            xcom_reference: [0.0; 2],
            cop_reference: [0.0; 2],
        }
    }
}

/// What the reference generator sees of the robot.
#[derive(Clone, Copy, Debug)]
pub struct Observation {
    /// Time [s].
    pub time: f64,
    /// Centre of mass [m].
    pub com: Vector3<f64>,
    /// Its velocity [m/s].
    pub com_velocity: Vector3<f64>,
    /// Right and left foot [m].
    pub feet: [Vector3<f64>; 2],
    /// Their orientation: `world_from_foot`.
    pub rotation: [Matrix3<f64>; 2],
    /// Where they point, horizontal unit vectors: that of x in the plane.
    pub ahead: [Vector3<f64>; 2],
    /// How their toes are raised, and how fast they rise [rad, rad/s].
    pub pitch: [[f64; 2]; 2],
    /// Whether they touch the ground.
    pub touching: [bool; 2],
    /// Vertical forces on them [N].
    pub load: [f64; 2],
    /// The shares of their heels and their toes [N].
    pub end_load: [[f64; 2]; 2],
}

impl Observation {
    /// What a generator sees at `time` [s] of a robot in the state of `dynamics` and `feet`, whose contact points are taken to feel
    /// `contacts`; a foot touches the ground if one of its contact points does. Allocates nothing.
    pub fn new(time: f64, dynamics: &Dynamics, feet: &FeetMotion, contacts: &[ContactSensed]) -> Self {
        let sum = |points: &[usize]| points.iter().map(|&point| contacts[point].load).sum();
        Self {
            time,
            com: dynamics.com,
            com_velocity: dynamics.com_velocity,
            feet: [0, 1].map(|foot| feet.position[foot]),
            rotation: [0, 1].map(|foot| feet.rotation[foot]),
            ahead: [0, 1].map(|foot| feet.ahead(foot)),
            pitch: [0, 1].map(|foot| {
                let (forward, ahead) = (feet.rotation[foot].column(0).into_owned(), feet.ahead(foot));
                let turning = &feet.angular_velocity[foot];
                [libm::atan2(forward.z, forward.dot(&ahead)), ahead.y * turning.x - ahead.x * turning.y]
            }),
            touching: [0, 1].map(|foot| feet.contacts(foot).iter().any(|&point| contacts[point].touching)),
            load: [0, 1].map(|foot| sum(feet.contacts(foot))),
            end_load: [0, 1].map(|foot| feet.ends(foot).each_ref().map(|end| sum(end))),
        }
    }

    /// The same of a robot in the state that was `sensed`, with its dynamics reckoned anew.
    pub fn of(model: &Robot, sensed: &Sensed) -> Self {
        let mut dynamics = Dynamics::new(model);
        dynamics.update(model, &sensed.q, &sensed.v);
        let mut feet = FeetMotion::new(model);
        feet.update(model, &dynamics);
        Self::new(sensed.time, &dynamics, &feet, &sensed.contacts)
    }
}

/// What a generator is made for.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// The robot.
    pub model: &'a Robot,
    /// The ground that the controller believes in.
    pub terrain: &'a Terrain,
    /// Whether that is how high the ground is; else feet stand as they come to rest.
    pub height_is_known: bool,
    /// Angle at which the torso should be, counter-clockwise from upright [rad].
    pub torso_angle: f64,
}

/// The generator that `settings` ask for, with the feet where they are at the `start`; `samples` are the rows of the CoM file,
/// where it has one.
///
/// # Errors
/// The robot is none that the generator can move, or the CoM trajectory is not valid.
pub fn make(
    settings: &ReferenceSettings,
    around: &Surroundings<'_>,
    samples: &[[f64; 3]],
    start: &Observation,
) -> Result<Box<dyn Generator>, Error> {
    check_model(around.model, settings.generator)?;
    let com = || ComTrajectory::new(&settings.com, samples, start.com, around.terrain);
    let mut generator: Box<dyn Generator> = match settings.generator {
        GeneratorKind::Steps => Box::new(Steps::new(&settings.step, com()?, around, start)),
        GeneratorKind::Stance => Box::new(Stance::new(&settings.stance, com()?, around, start)),
        GeneratorKind::Walker => {
            needs::check_reach(&settings.walker, around.model)?;
            Box::new(Walker::new(&settings.walker, around, start))
        }
    };
    // A robot that is to step at once does so in the first tick.
    generator.update(start, &mut Reference::default());
    Ok(generator)
}

impl Reference {
    /// Takes the motion of the centre of mass, and the places of centre of pressure and XcoM that go with it on the linear
    /// inverted pendulum: `ẍ = ω² (x - p)`, `ξ = x + ẋ/ω`.
    fn follow(&mut self, com: PointReference, gravity: f64, ground: &Terrain) {
        self.chest.point = com;
        let omega = xcom::eigenfrequency(gravity, com.position.z - ground.height_at(com.position.x, com.position.y));
        let PointReference { position: place, velocity, acceleration } = com;
        self.cop_reference = [0, 1].map(|axis| place[axis] - acceleration[axis] / (omega * omega));
        self.xcom_reference = [0, 1].map(|axis| place[axis] + velocity[axis] / omega);
    }

    /// The foot that swings, if one does; the others stand.
    fn swing(&mut self, swing: Option<Swing>) {
        self.swing = swing;
        let footing =
            |foot| if swing.is_some_and(|swing| swing.foot == foot) { Footing::Swings } else { Footing::Stands };
        self.footing = [0, 1].map(footing);
    }
}
