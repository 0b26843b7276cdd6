//! A scenario: everything that one run depends on, as data.
//!
//! A file holds only what differs from the defaults (or from the scenario named by `extends`); see
//! [`crate::scenario_file`] for reading, `--set` and the checks, and [`crate::settings`] for unit, range and
//! source of each value.

use std::sync::Arc;

use legwork_rbd::Model;
use serde::{Deserialize, Serialize};

use crate::contract::Sensed;
use crate::error::Error;
use crate::fit::Fit;
use crate::generator::{self, Generator, Observation, Surroundings};
use crate::momentum::MomentumController;
use crate::posture;
use crate::robot::Robot;
use crate::sim::Simulator;
use crate::terrain::Terrain;
use crate::wearer::{self, Build, PERSON};

pub use legwork_contract::terrain::Ground;
pub use legwork_control::settings::*;
pub use legwork_sim::settings::*;

/// Everything that one run depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// What it shows, in a sentence.
    pub description: String,
    /// A built-in model's name, or a TOML, URDF or MJCF file.
    pub model: String,
    /// The robot that the settings are stated for, where it is another.
    pub fit: Fit,
    /// Joints of the model that are fixed where the start's posture has them, by names or patterns.
    pub locked: Vec<String>,
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
    /// Strength of the joints against that of a person of this mass and height.
    pub strength: f64,
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
    /// Height of the centre of mass above the ground below it [m]; zero for one that follows from the legs.
    pub com_height_m: f64,
    /// Torso angle, counter-clockwise from upright [deg].
    pub torso_angle_deg: f64,
    /// Near which it is.
    pub posture: Posture,
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
    /// Followed means: the mean CoM error of a walk, while it is steady, is at most this [m].
    pub followed_within_m: f64,
    /// Force on a contact point above which it injures [N].
    pub injurious_force_n: f64,
}

impl MetricsSettings {
    /// From when on means and peaks are taken, and whether the start is among them.
    pub fn counted(&self) -> String {
        let start = if self.from_s > 0.0 { "without the start" } else { "the start included" };
        let com = self.from_s.max(self.com_error_from_s);
        format!("means and peaks from {} s on, {start}; CoM and XcoM errors from {com} s on", self.from_s)
    }
}

impl Scenario {
    /// The true ground, as `model` meets it.
    pub fn terrain(&self, model: &Model) -> Terrain {
        Terrain::of(&self.ground, self.seed, model)
    }

    /// The ground that the controller believes in, as `model` meets it.
    pub fn believed_terrain(&self, model: &Model) -> Terrain {
        let assumed = [self.controller.assumed_friction, self.controller.assumed_slope_deg];
        Terrain::believed(&self.ground, self.seed, assumed, model)
    }

    /// The reference generator's settings for the wearer's size and for the build of `model`.
    pub fn fitted_reference(&self, model: &Model) -> ReferenceSettings {
        if self.fit != Fit::None {
            return self.reference.clone();
        }
        let walker = self.reference.walker.for_stature(self.wearer.stature());
        let beyond = Build::beyond(&self.wearer, model);
        let walker = walker.for_build(beyond.leg, beyond.com_above_hip);
        ReferenceSettings { walker, ..self.reference.clone() }
    }

    /// The generator for the robot `model`, which starts at `start`; `samples` are the rows of the CoM file, where there is one.
    ///
    /// # Errors
    /// The robot is none that the generator can move, or the CoM trajectory is not valid.
    pub fn generator(&self, model: &Robot, samples: &[[f64; 3]], start: &Sensed) -> Result<Box<dyn Generator>, Error> {
        let around = Surroundings {
            model,
            terrain: &self.believed_terrain(model),
            height_is_known: self.ground.height_is_known(),
            torso_angle: self.controller.planner.torso_angle_deg.to_radians(),
        };
        generator::make(&self.fitted_reference(model), &around, samples, &Observation::of(model, start))
    }

    /// The momentum controller for the robot `model`, with the scenario's generator; see [`Scenario::generator`].
    ///
    /// # Errors
    /// Those of [`Scenario::generator`].
    pub fn momentum_controller(
        &self,
        model: &Robot,
        samples: &[[f64; 3]],
        start: &Sensed,
    ) -> Result<MomentumController, Error> {
        Ok(self.momentum_controller_after(model, self.generator(model, samples, start)?))
    }

    /// The momentum controller for the robot `model`, which follows a `generator`.
    pub fn momentum_controller_after(&self, model: &Robot, generator: Box<dyn Generator>) -> MomentumController {
        MomentumController::new(&wearer::controller(self, model), model, &self.believed_terrain(model), generator)
    }

    /// The simulator with the robot `model` at rest in `q` [rad, m].
    ///
    /// # Errors
    /// A push that names an unknown body.
    pub fn simulator(&self, model: &Model, q: &[f64]) -> Result<Simulator, Error> {
        Simulator::new(&self.simulation, &self.pushes, self.terrain(model), Arc::new(model.clone()), q)
    }
}

impl Default for Scenario {
    /// Standing still with the thesis's final design (Table 6.3); what the thesis does not give is from the
    /// fitted parameter set (docs/thesis.md).
    fn default() -> Self {
        Self {
            name: "stand".into(),
            description: String::new(),
            model: "planar_humanoid".into(),
            fit: Fit::None,
            locked: Vec::new(),
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
                posture: Posture::Named(posture::NEUTRAL.to_owned()),
            },
            ground: Ground::default(),
            reference: ReferenceSettings::default(),
            controller: ControllerSettings::default(),
            simulation: SimulationSettings::default(),
            fall: FallSettings {
                min_com_height_fraction: 0.5,
                max_torso_angle_deg: 60.0,
                max_joint_speed_radps: 200.0,
            },
            metrics: MetricsSettings {
                from_s: 0.0,
                com_error_from_s: 0.4,
                recovered_within_m: 0.05,
                followed_within_m: 0.05,
                injurious_force_n: 5400.0,
            },
            pushes: Vec::new(),
        }
    }
}
