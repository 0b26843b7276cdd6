//! The reference generator (thesis 4.3.1): where the centre of mass, the torso and the feet should be.
//!
//! The CoM trajectory is given. With the generator `steps` the feet react to the state through the step state machine of
//! Figure 4.2; with `stance` all is planned beforehand.

pub mod com_trajectory;
pub mod stance;
pub mod step;
pub mod swing;
pub mod walker;
pub mod xcom;

use legwork_rbd::Model;
use nalgebra::Vector3;

pub use crate::feet::Footing;
use crate::feet::Sole;
use crate::scenario::{Generator, Scenario};
use crate::terrain::Terrain;
pub use com_trajectory::ComTrajectory;
pub use stance::Stance;
pub use step::{Phase, StepMachine};
pub use walker::Walker;

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

/// Angle, angular velocity and acceleration, counter-clockwise [rad, rad/s, rad/s²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleReference {
    /// Angle [rad].
    pub angle: f64,
    /// Angular velocity [rad/s].
    pub velocity: f64,
    /// Angular acceleration [rad/s²].
    pub acceleration: f64,
}

/// One object of the reference: in the plane an angle and two coordinates with two derivatives each, the nine
/// trajectory variables of the thesis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectReference {
    /// Its orientation about −y. Point feet have none: theirs stays zero.
    pub angle: AngleReference,
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
    /// Where the centre of pressure should be along x [m], or with a rate of angular momentum the moment pivot. Where it is
    /// given, the centre of mass accelerates as it asks, and the place of the CoM along x is no goal.
    pub cop: Option<f64>,
    /// Wanted rate of the angular momentum about −y, beside its damping [Nm].
    pub angular_momentum_rate: f64,
    /// Height of the ground below it [m].
    pub ground_height: f64,
}

impl Default for Reference {
    fn default() -> Self {
        Self {
            chest: ObjectReference::default(),
            feet: [ObjectReference::default(); 2],
            footing: [Footing::Stands; 2],
            max_load: [f64::INFINITY; 2],
            cop: None,
            angular_momentum_rate: 0.0,
            ground_height: 0.0,
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
    /// How they are turned about −y, and how fast they turn [rad, rad/s].
    pub pitch: [[f64; 2]; 2],
    /// Whether they touch the ground.
    pub touching: [bool; 2],
    /// Vertical forces on them [N].
    pub load: [f64; 2],
    /// The shares of their heels and their toes [N].
    pub end_load: [[f64; 2]; 2],
}

/// What moves the feet.
#[derive(Clone, Debug)]
enum Feet {
    Steps(StepMachine),
    Stance(Stance),
    Walker(Box<Walker>),
}

/// The reference generator with its state.
#[derive(Clone, Debug)]
pub struct ReferenceGenerator {
    com: ComTrajectory,
    torso_angle: f64,
    ground: Terrain,
    gravity: f64,
    feet: Feet,
    reference: Reference,
}

impl ReferenceGenerator {
    /// A generator that begins with the feet where they start.
    ///
    /// `ground` is the one that the controller believes in; `start` the observation at time zero.
    pub fn new(scenario: &Scenario, model: &Model, com: ComTrajectory, ground: &Terrain, start: &Observation) -> Self {
        let (settings, ground_known) = (&scenario.reference, scenario.ground.height_is_known());
        let torso_angle = scenario.controller.planner.torso_angle_deg.to_radians();
        let gravity = model.gravity;
        let feet = match settings.generator {
            Generator::Steps => {
                Feet::Steps(StepMachine::new(settings.step.clone(), ground.clone(), ground_known, gravity, start))
            }
            Generator::Stance => Feet::Stance(Stance::new(settings.stance.clone(), ground.clone(), gravity, start)),
            Generator::Walker => Feet::Walker(Box::new(Walker::new(
                settings.walker.for_stature(scenario.wearer.stature()),
                Sole::of(model),
                ground.clone(),
                ground_known,
                model.total_mass(),
                gravity,
                start,
            ))),
        };
        let mut generator =
            Self { com, torso_angle, ground: ground.clone(), gravity, feet, reference: Reference::default() };
        generator.update(start);
        generator
    }

    /// The reference at the time of `observation`; moves the state on.
    pub fn update(&mut self, observation: &Observation) -> &Reference {
        let time = observation.time;
        let mut com = self.com.at(time);
        let reference = &mut self.reference;
        reference.chest.angle.angle = self.torso_angle;
        match &mut self.feet {
            Feet::Steps(steps) => {
                steps.update(observation, &com);
                reference.feet.iter_mut().enumerate().for_each(|(foot, goal)| goal.point = steps.foot(foot, time));
            }
            Feet::Stance(stance) => {
                com = stance::sum(com, stance.com_offset(time));
                stance.update(observation, &com);
                for (foot, goal) in reference.feet.iter_mut().enumerate() {
                    goal.point = stance.foot(foot, time);
                    goal.angle.angle = stance.pitch(foot);
                }
            }
            Feet::Walker(walker) => {
                walker.update(observation);
                com = walker.com();
                reference.feet = *walker.feet();
                reference.footing = walker.footing();
                reference.max_load = walker.max_load();
                reference.cop = Some(walker.moment_pivot());
                reference.angular_momentum_rate = walker.angular_momentum_rate();
                reference.chest.angle = walker.lean();
                reference.chest.angle.angle += self.torso_angle;
                reference.ground_height = walker.ground_height();
            }
        }
        reference.chest.point = com;
        let swinging = self.swing().map(|(foot, _)| foot);
        if !matches!(self.feet, Feet::Walker(_)) {
            let footing = |foot| if Some(foot) == swinging { Footing::Swings } else { Footing::Stands };
            self.reference.footing = [0, 1].map(footing);
        }
        &self.reference
    }

    /// Asks a walker for another speed from now on [m/s]; other generators have none that could change under way.
    pub fn command_speed(&mut self, speed: f64) {
        if let Feet::Walker(walker) = &mut self.feet {
            walker.command_speed(speed);
        }
    }

    /// The latest reference.
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// The foot that swings (0 right, 1 left) and since when [s], if one does.
    pub fn swing(&self) -> Option<(usize, f64)> {
        match &self.feet {
            Feet::Steps(steps) => match steps.phase() {
                Phase::DoubleSupport => None,
                Phase::Step { foot, since, .. } => Some((foot, since)),
            },
            Feet::Stance(stance) => stance.swing(),
            Feet::Walker(walker) => walker.swing_foot(),
        }
    }

    /// Where the centre of pressure and the extrapolated centre of mass should be along x [m].
    pub fn balance(&self) -> [f64; 2] {
        match &self.feet {
            Feet::Walker(walker) => [walker.cop(), walker.xcom_reference()],
            Feet::Steps(_) | Feet::Stance(_) => {
                let com = &self.reference.chest.point;
                // The linear inverted pendulum: ẍ = ω² (x - p), ξ = x + ẋ/ω
                let omega = xcom::eigenfrequency(self.gravity, com.position.z - self.ground.height_at(com.position.x));
                let cop = com.position.x - com.acceleration.x / (omega * omega);
                [cop, com.position.x + com.velocity.x / omega]
            }
        }
    }

    /// The extrapolated centre of mass along x as of the latest update [m].
    pub fn xcom(&self) -> f64 {
        match &self.feet {
            Feet::Steps(steps) => steps.xcom(),
            Feet::Stance(stance) => stance.xcom(),
            Feet::Walker(walker) => walker.xcom(),
        }
    }
}
