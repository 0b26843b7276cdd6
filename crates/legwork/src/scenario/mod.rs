//! A scenario: everything that one run depends on, as data.
//!
//! A file holds only what differs from the defaults (or from the scenario named by `extends`); see
//! [`crate::scenario_file`] for reading, `--set` and the checks, and [`crate::settings`] for unit, range and
//! source of each value.

mod controller;
mod reference;
mod simulation;

use serde::{Deserialize, Serialize};

use crate::wearer::PERSON;

pub use controller::{
    ControllerSettings, Damping, JointLimits, Limits, PlannerSettings, QpForm, Tracking, TrackingSettings, Weights,
};
pub use reference::{
    Adaptation, ComSettings, CommandedSpeed, Generator, LeastStep, Lift, ReferenceSettings, Replan, StanceSettings,
    StepSettings, TrajectoryKind, WalkerSettings,
};
pub use simulation::{
    ActuatorSettings, ContactModel, ContactSettings, Integrator, Push, SensorSettings, SimulationSettings,
};

/// Everything that one run depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// What it shows, in a sentence.
    pub description: String,
    /// A built-in model's name, or a TOML or URDF file.
    pub model: String,
    /// Simulated time [s].
    pub duration_s: f64,
    /// Seed of the sensor noise and of the ground's unevenness.
    pub seed: u64,
    /// The person whose segments the robot has.
    pub wearer: Wearer,
    /// What is worn on them.
    pub exoskeleton: Exoskeleton,
    /// The start pose.
    pub start: Start,
    /// The ground.
    pub ground: Ground,
    /// The reference generator.
    pub reference: ReferenceSettings,
    /// The controller.
    pub controller: ControllerSettings,
    /// The simulator.
    pub simulation: SimulationSettings,
    /// When the robot counts as fallen.
    pub fall: FallSettings,
    /// How the metrics are taken.
    pub metrics: MetricsSettings,
    /// Forces that act on the robot for a time.
    pub pushes: Vec<Push>,
}

/// A person. A taller one stands and walks with all lengths of the start pose and of the generator `walker` in proportion; for
/// a heavier one the controller's gains and weights of forces follow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wearer {
    /// Mass [kg].
    pub mass_kg: f64,
    /// Height [m].
    pub height_m: f64,
}

impl Wearer {
    /// Height against that of the models' person.
    pub fn stature(&self) -> f64 {
        self.height_m / PERSON.height_m
    }
}

/// Masses that an exoskeleton adds to the segments, each at its segment's centre of mass [kg].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exoskeleton {
    /// On the torso.
    pub torso_kg: f64,
    /// On each thigh.
    pub thigh_kg: f64,
    /// On each shank.
    pub shank_kg: f64,
    /// On each foot.
    pub foot_kg: f64,
}

impl Exoskeleton {
    /// The masses with the ends of the names of the bodies that carry them.
    pub fn masses(&self) -> [(&'static str, f64); 4] {
        [("torso", self.torso_kg), ("thigh", self.thigh_kg), ("shank", self.shank_kg), ("foot", self.foot_kg)]
    }
}

/// The start pose, at rest: both feet on the ground, centre of mass and torso as given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Place of the right foot [m].
    pub right_foot_x_m: f64,
    /// Place of the left foot [m].
    pub left_foot_x_m: f64,
    /// Distance of the feet along y [m]; robots in space only.
    pub feet_width_m: f64,
    /// Place of the centre of mass [m].
    pub com_x_m: f64,
    /// Height of the centre of mass above the ground below it [m].
    pub com_height_m: f64,
    /// Torso angle, counter-clockwise from upright [deg].
    pub torso_angle_deg: f64,
}

/// Ground: an inclined plane through the origin with Coulomb friction, and what differs from it; see
/// [`crate::terrain::Terrain`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Coefficient of friction.
    pub friction: f64,
    /// Slope, upward in x [deg].
    pub slope_deg: f64,
    /// Whether the controller is given the true friction and slope.
    pub known: bool,
    /// Rows `[x_m, z_m]` of heights above the plane, joined by straight lines, level before and after.
    pub profile: Vec<[f64; 2]>,
    /// Random heights on top of it: as much up and down [m].
    pub unevenness_m: f64,
    /// Distance of the points that have them, which straight lines join [m].
    pub unevenness_spacing_m: f64,
    /// Where they begin [m].
    pub unevenness_from_m: f64,
    /// Rows `[from_m, to_m, friction]` where the friction is another; of several the last counts.
    pub patches: Vec<[f64; 3]>,
    /// Whether the controller is given profile, unevenness and patches.
    pub relief_known: bool,
}

impl Ground {
    /// Whether the controller knows the ground's height everywhere.
    pub fn height_is_known(&self) -> bool {
        self.known && (self.relief_known || (self.profile.is_empty() && self.unevenness_m == 0.0))
    }
}

/// When the robot counts as fallen; see [`crate::diagnosis`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FallSettings {
    /// Lowest CoM height, as a share of the start's.
    pub min_com_height_fraction: f64,
    /// Largest torso angle from its reference [deg].
    pub max_torso_angle_deg: f64,
    /// Largest joint speed [rad/s]; above it the numbers are out of bounds.
    pub max_joint_speed_radps: f64,
}

/// How metrics are taken; see [`crate::metrics`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MetricsSettings {
    /// All figures but those of recovery count from this time [s].
    pub from_s: f64,
    /// The CoM error counts from this time [s].
    pub com_error_from_s: f64,
    /// Recovered means: the CoM error stays below this [m].
    pub recovered_within_m: f64,
}

impl Default for Scenario {
    /// Standing still with the thesis's final design (Table 6.3); what the thesis does not give is from the
    /// fitted parameter set (docs/thesis.md).
    fn default() -> Self {
        Self {
            name: "stand".into(),
            description: String::new(),
            model: "planar_humanoid".into(),
            duration_s: 4.0,
            seed: 0,
            wearer: PERSON,
            exoskeleton: Exoskeleton::default(),
            start: Start {
                right_foot_x_m: 0.0,
                left_foot_x_m: 0.575,
                feet_width_m: 0.22,
                com_x_m: 0.27025,
                com_height_m: 0.885,
                torso_angle_deg: -1.676873,
            },
            ground: Ground {
                friction: 0.85,
                slope_deg: 0.0,
                known: true,
                profile: Vec::new(),
                unevenness_m: 0.0,
                unevenness_spacing_m: 0.3,
                unevenness_from_m: 0.7,
                patches: Vec::new(),
                relief_known: false,
            },
            reference: ReferenceSettings::default(),
            controller: ControllerSettings::default(),
            simulation: SimulationSettings::default(),
            fall: FallSettings {
                min_com_height_fraction: 0.5,
                max_torso_angle_deg: 60.0,
                max_joint_speed_radps: 200.0,
            },
            metrics: MetricsSettings { from_s: 0.0, com_error_from_s: 0.4, recovered_within_m: 0.05 },
            pushes: Vec::new(),
        }
    }
}
