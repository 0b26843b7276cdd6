//! The reference generator (thesis 4.3.1): where the centre of mass, the torso and the feet should be.
//!
//! The CoM trajectory is given; the feet react to the state through the step state machine of Figure 4.2.

pub mod com_trajectory;
pub mod step;
pub mod swing;
pub mod xcom;

use nalgebra::Vector3;

use crate::contact::GroundPlane;
use crate::scenario::ReferenceSettings;
pub use com_trajectory::ComTrajectory;
pub use step::{Phase, StepMachine};

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
    /// Its orientation. Point feet have none: theirs stays zero.
    pub angle: AngleReference,
    /// Its position.
    pub point: PointReference,
}

/// The whole reference of one tick: 27 variables in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// The torso's angle and the centre of mass.
    pub chest: ObjectReference,
    /// The right and the left foot.
    pub feet: [ObjectReference; 2],
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
    /// Whether they touch the ground.
    pub touching: [bool; 2],
}

/// The reference generator with its state machine.
#[derive(Clone, Debug)]
pub struct ReferenceGenerator {
    com: ComTrajectory,
    torso_angle: f64,
    steps: StepMachine,
    reference: Reference,
}

impl ReferenceGenerator {
    /// A generator that holds the feet where they start.
    ///
    /// `ground_known` says whether `ground` is more than a guess; `gravity` [m/s²], `torso_angle` [rad], `start` the
    /// observation at time zero.
    pub fn new(
        settings: &ReferenceSettings,
        com: ComTrajectory,
        ground: &GroundPlane,
        ground_known: bool,
        gravity: f64,
        torso_angle: f64,
        start: &Observation,
    ) -> Self {
        let steps = StepMachine::new(settings.step.clone(), ground.clone(), ground_known, gravity, start);
        let mut generator = Self { com, torso_angle, steps, reference: Reference::default() };
        generator.update(start);
        generator
    }

    /// The reference at the time of `observation`; moves the step state machine on.
    pub fn update(&mut self, observation: &Observation) -> &Reference {
        let com = self.com.at(observation.time);
        self.steps.update(observation, &com);
        self.reference.chest.point = com;
        self.reference.chest.angle.angle = self.torso_angle;
        for foot in 0..2 {
            self.reference.feet[foot].point = self.steps.foot(foot, observation.time);
        }
        &self.reference
    }

    /// The latest reference.
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// The step state machine.
    pub fn steps(&self) -> &StepMachine {
        &self.steps
    }
}
