//! A scenario: everything that one run depends on, as data.
//!
//! A file holds only what differs from the defaults (or from the scenario named by `extends`); see
//! [`crate::scenario_file`] for reading, `--set` and the checks, and [`crate::settings`] for unit, range and
//! source of each value.

use serde::{Deserialize, Serialize};

/// How the centre of mass should move (thesis 4.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrajectoryKind {
    /// Stay where the run started.
    Stationary,
    /// Constant forward velocity, with an optional linear ramp from rest.
    ConstantVelocity,
    /// Minimum-jerk motion between points, at rest in each.
    Waypoints,
    /// Samples from a CSV file, joined by a cubic spline.
    File,
}

/// What the feet and the centre of mass should do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Generator {
    /// The CoM follows its trajectory, and the feet step when the XcoM leaves the base of support (thesis 4.3.1).
    Steps,
    /// The robot stands, sways, squats or lifts a foot, as planned beforehand.
    Stance,
}

/// Which foot is lifted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lift {
    /// None.
    None,
    /// The right one.
    Right,
    /// The left one.
    Left,
}

/// Whether the step length is planned once or again while the foot swings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Replan {
    /// Once, when the step is triggered (thesis).
    Never,
    /// At every tick of the swing.
    InSwing,
}

/// What the least step length is to prevent (thesis 4.3.1 says: a base of support that becomes too small).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LeastStep {
    /// A foot that moves less than that.
    Displacement,
    /// Feet that stand closer together than that after the step.
    BaseOfSupport,
}

/// The damping gain that belongs to a stiffness `P` (thesis 6.3.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Damping {
    /// `D = sqrt(2 m P)` as printed: damping ratio 0.71.
    Printed,
    /// `D = 2 sqrt(m P)`: critical.
    Critical,
}

/// Which of the two equivalent forms of the quadratic program is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum QpForm {
    /// Tracking in the cost, torques eliminated: joint accelerations and forces only.
    Direct,
    /// Appendix B: joint accelerations, forces, torques and slack variables.
    Slack,
}

/// How a tracking goal enters the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tracking {
    /// Weighted in the cost.
    Cost,
    /// As a hard equality.
    Equality,
}

/// How the simulator advances the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// Velocity first, then position with the new velocity; dynamics at the start of the step.
    SemiImplicitEuler,
    /// Moreau's midpoint: configuration half a step ahead, velocity-dependent forces averaged over the step.
    Midpoint,
}

/// The law of the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactModel {
    /// Impulses by the per-contact iteration of Appendix A.
    Rigid,
    /// The spring-damper that the thesis argues against (3.3).
    SpringDamper,
}

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
    /// Seed of the sensor noise.
    pub seed: u64,
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

/// Ground: an inclined plane through the origin with Coulomb friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Coefficient of friction.
    pub friction: f64,
    /// Slope, upward in x [deg].
    pub slope_deg: f64,
    /// Whether the controller is given the true friction and slope.
    pub known: bool,
}

/// The reference generator (thesis 4.3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSettings {
    /// Which generator.
    pub generator: Generator,
    /// The centre of mass.
    pub com: ComSettings,
    /// The steps of the generator `steps`.
    pub step: StepSettings,
    /// The generator `stance`.
    pub stance: StanceSettings,
}

/// The desired motion of the centre of mass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComSettings {
    /// Its kind.
    pub trajectory: TrajectoryKind,
    /// Forward speed of `constant-velocity` [m/s].
    pub speed_mps: f64,
    /// Time to ramp up to that speed [s]; zero is the thesis's velocity step.
    pub ramp_s: f64,
    /// Rows `[t_s, x_m, z_m]` of `waypoints`, in the world.
    pub waypoints: Vec<[f64; 3]>,
    /// CSV file of `file`, with the columns `t_s,x_m,z_m`.
    pub file: String,
}

/// When and where the robot steps (thesis 4.3.1, Figure 4.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepSettings {
    /// `t_T`: time of a step [s].
    pub duration_s: f64,
    /// `h_s`: height of the foot's arc [m].
    pub height_m: f64,
    /// Least step length [m].
    pub min_length_m: f64,
    /// What that is the least of.
    pub min_length_is: LeastStep,
    /// Longest displacement of a foot [m].
    pub max_length_m: f64,
    /// Share of the distance to the predicted XcoM that is added to it.
    pub overshoot: f64,
    /// How far the XcoM may leave the base of support, as time at reference speed [s].
    pub delay_s: f64,
    /// The most that it may leave it [m].
    pub max_delay_m: f64,
    /// Whether the step length is planned again in the swing.
    pub replan: Replan,
}

/// Standing, swaying, squatting, lifting a foot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StanceSettings {
    /// Amplitude of the CoM's sway along x, y, z [m].
    pub sway_m: [f64; 3],
    /// Depth of a squat [m].
    pub squat_m: f64,
    /// Time of one sway and one squat [s].
    pub period_s: f64,
    /// Which foot is lifted.
    pub lift: Lift,
    /// When the CoM begins to move above the other foot [s].
    pub lift_start_s: f64,
    /// How long the foot is off the ground [s].
    pub lift_duration_s: f64,
    /// How high it is lifted [m].
    pub lift_height_m: f64,
    /// How far it swings forward and back [m].
    pub swing_m: f64,
}

/// The controller: motion reference planner (4.3.2) and quadratic program (4.4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings {
    /// Time between two ticks [s].
    pub period_s: f64,
    /// Which form of the program is solved.
    pub form: QpForm,
    /// Friction that it assumes where the ground is not known.
    pub assumed_friction: f64,
    /// Slope that it assumes where the ground is not known [deg].
    pub assumed_slope_deg: f64,
    /// The motion reference planner.
    pub planner: PlannerSettings,
    /// The cost's weights.
    pub weights: Weights,
    /// Cost or equality, a task.
    pub tracking: TrackingSettings,
    /// The bounds.
    pub limits: Limits,
}

/// The motion reference planner's gains (4.3)-(4.6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannerSettings {
    /// `P_theta`: angular momentum to its rate [1/s].
    pub angular_momentum_gain: f64,
    /// `P_C`: CoM error to force [N/m].
    pub com_gain: f64,
    /// `P_f`: foot error to acceleration [1/s²].
    pub foot_gain: f64,
    /// Foot orientation error to angular acceleration [1/s²]; feet with several contact points.
    pub foot_rotation_gain: f64,
    /// `P_a`: torso angle error to angular acceleration [1/s²].
    pub torso_gain: f64,
    /// Which damping gains belong to them.
    pub damping: Damping,
    /// Largest horizontal momentum rate asked for [N].
    pub max_horizontal_momentum_rate_n: f64,
    /// Torso reference angle [deg].
    pub torso_angle_deg: f64,
}

/// The weights of the cost (4.23), (4.28).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// `C_v`.
    pub joint_acceleration: f64,
    /// `C_rho`.
    pub grf: f64,
    /// `C_tau`.
    pub torque: f64,
    /// `C_m`.
    pub momentum: f64,
    /// What the angular rows of the momentum weigh against the linear ones.
    pub angular_momentum_factor: f64,
    /// `C_f`.
    pub feet: f64,
    /// Weight of the angular acceleration of feet with several contact points.
    pub foot_rotation: f64,
    /// `C_a`.
    pub torso: f64,
    /// Weight of a braking joint's acceleration error where the hard bound (4.32) had to yield.
    pub braking: f64,
}

/// Cost or equality, a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackingSettings {
    /// Momentum rate (4.17).
    pub momentum: Tracking,
    /// Feet (4.19).
    pub feet: Tracking,
    /// Torso (4.20).
    pub torso: Tracking,
}

/// The bounds of the program (4.4.4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Joint torque [Nm].
    pub torque_nm: f64,
    /// Each component of a contact's force [N].
    pub grf_n: f64,
    /// Acceleration of an actuated joint [rad/s²].
    pub joint_acceleration_radps2: f64,
}

/// The simulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationSettings {
    /// Time step of the physics [s]; the control period is a whole multiple of it.
    pub period_s: f64,
    /// How the state is advanced.
    pub integrator: Integrator,
    /// The contact with the ground.
    pub contact: ContactSettings,
    /// What the controller is told of the state.
    pub sensors: SensorSettings,
    /// What becomes of the torque asked for.
    pub actuators: ActuatorSettings,
}

/// Contact with the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSettings {
    /// Rigid or spring-damper.
    pub model: ContactModel,
    /// A contact point below this height counts as touching for the controller [m].
    pub flag_height_m: f64,
    /// Share of a penetration that is undone in a step (rigid).
    pub penetration_recovery: f64,
    /// `alpha` of Appendix A (rigid).
    pub relaxation: f64,
    /// Sweeps end when no impulse changes by more than this, as force [N] (rigid).
    pub tolerance_n: f64,
    /// Most sweeps a step (rigid).
    pub max_sweeps: u32,
    /// Normal stiffness [N/m] (spring-damper).
    pub stiffness_npm: f64,
    /// Normal damping [Ns/m] (spring-damper).
    pub damping_nspm: f64,
    /// Slip speed at which friction is fully developed [m/s] (spring-damper).
    pub slip_speed_mps: f64,
}

/// Sensors: off by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// Standard deviation of each position [rad or m].
    pub position_noise: f64,
    /// Standard deviation of each velocity [rad/s or m/s].
    pub velocity_noise: f64,
    /// Delay of the state [s].
    pub delay_s: f64,
}

impl SensorSettings {
    /// Whether the controller is told the true state.
    pub fn are_ideal(&self) -> bool {
        self.position_noise == 0.0 && self.velocity_noise == 0.0 && self.delay_s == 0.0
    }
}

/// Actuators: ideal by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorSettings {
    /// Delay of the torque [s].
    pub delay_s: f64,
    /// Time constant of a first-order lag behind the delay [s].
    pub lag_s: f64,
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
    /// The CoM error counts from this time [s].
    pub com_error_from_s: f64,
    /// Recovered means: the CoM error stays below this [m].
    pub recovered_within_m: f64,
}

/// A force that acts for a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Its size [N].
    pub force_n: f64,
    /// Its direction: 0 forward, 90 up, 180 backward [deg].
    pub direction_deg: f64,
    /// How far it is turned to the left about z [deg]; robots in space only.
    pub heading_deg: f64,
    /// When it begins [s].
    pub start_s: f64,
    /// How long it lasts [s].
    pub duration_s: f64,
    /// `com`, or the name of a body.
    pub at: String,
    /// Where on that body, in the body's frame from its centre of mass [m].
    pub point_m: [f64; 3],
}

impl Default for Push {
    fn default() -> Self {
        Self {
            force_n: 0.0,
            direction_deg: 0.0,
            heading_deg: 0.0,
            start_s: 0.0,
            duration_s: 0.0,
            at: "com".into(),
            point_m: [0.0; 3],
        }
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
            duration_s: 4.0,
            seed: 0,
            start: Start {
                right_foot_x_m: 0.0,
                left_foot_x_m: 0.575,
                feet_width_m: 0.22,
                com_x_m: 0.27025,
                com_height_m: 0.885,
                torso_angle_deg: -1.676873,
            },
            ground: Ground { friction: 0.85, slope_deg: 0.0, known: true },
            reference: ReferenceSettings {
                generator: Generator::Steps,
                com: ComSettings {
                    trajectory: TrajectoryKind::Stationary,
                    speed_mps: 0.0,
                    ramp_s: 0.0,
                    waypoints: Vec::new(),
                    file: String::new(),
                },
                step: StepSettings {
                    duration_s: 0.225,
                    height_m: 0.062,
                    min_length_m: 0.59,
                    min_length_is: LeastStep::Displacement,
                    max_length_m: 1.05,
                    overshoot: 0.1,
                    delay_s: 0.2,
                    max_delay_m: 0.15,
                    replan: Replan::Never,
                },
                stance: StanceSettings {
                    sway_m: [0.0; 3],
                    squat_m: 0.0,
                    period_s: 2.0,
                    lift: Lift::None,
                    lift_start_s: 1.0,
                    lift_duration_s: 2.0,
                    lift_height_m: 0.05,
                    swing_m: 0.0,
                },
            },
            controller: ControllerSettings {
                period_s: 0.001,
                form: QpForm::Direct,
                assumed_friction: 0.85,
                assumed_slope_deg: 0.0,
                planner: PlannerSettings {
                    angular_momentum_gain: 200.0,
                    com_gain: 1500.0,
                    foot_gain: 1500.0,
                    foot_rotation_gain: 400.0,
                    torso_gain: 45.0,
                    damping: Damping::Printed,
                    max_horizontal_momentum_rate_n: 520.0,
                    torso_angle_deg: -5.0,
                },
                weights: Weights {
                    joint_acceleration: 1e-2,
                    grf: 1e-4,
                    torque: 0.0,
                    momentum: 10.0,
                    angular_momentum_factor: 1.0,
                    feet: 5e5,
                    foot_rotation: 5e5,
                    torso: 1e5,
                    braking: 1e4,
                },
                tracking: TrackingSettings { momentum: Tracking::Cost, feet: Tracking::Cost, torso: Tracking::Cost },
                limits: Limits { torque_nm: 220.0, grf_n: 1000.0, joint_acceleration_radps2: 1000.0 },
            },
            simulation: SimulationSettings {
                period_s: 0.001,
                integrator: Integrator::Midpoint,
                contact: ContactSettings {
                    model: ContactModel::Rigid,
                    flag_height_m: 0.001,
                    penetration_recovery: 0.2,
                    relaxation: 1.0,
                    tolerance_n: 1e-6,
                    max_sweeps: 100,
                    stiffness_npm: 1e5,
                    damping_nspm: 1e3,
                    slip_speed_mps: 0.01,
                },
                sensors: SensorSettings { position_noise: 0.0, velocity_noise: 0.0, delay_s: 0.0 },
                actuators: ActuatorSettings { delay_s: 0.0, lag_s: 0.0 },
            },
            fall: FallSettings {
                min_com_height_fraction: 0.5,
                max_torso_angle_deg: 60.0,
                max_joint_speed_radps: 200.0,
            },
            metrics: MetricsSettings { com_error_from_s: 0.4, recovered_within_m: 0.05 },
            pushes: Vec::new(),
        }
    }
}
