//! The controller: gains, weights, limits (thesis 4.3.2, 4.4).

use legwork_contract::posture::{ByJoint, Posture, START};
use serde::{Deserialize, Serialize};

/// The controller: motion reference planner (4.3.2) and quadratic program (4.4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings {
    /// Which controller.
    pub kind: ControllerKind,
    /// Time between two ticks [s].
    pub period_s: f64,
    /// Which form of the program is solved.
    pub form: QpForm,
    /// Friction that it assumes where the ground is not known.
    pub assumed_friction: f64,
    /// Edges of the pyramid that stands for the cone of friction, in space.
    pub friction_edges: usize,
    /// Slope that it assumes where the ground is not known [deg].
    pub assumed_slope_deg: f64,
    /// A contact point that is not felt stands up to that far from the height at which it was felt last, where its foot should [m].
    pub lift_height_m: f64,
    /// How late torques act behind what is sensed, as far as it knows: it works for the state that will be then [s].
    pub known_delay_s: f64,
    /// The motion reference planner.
    pub planner: PlannerSettings,
    /// The cost's weights.
    pub weights: Weights,
    /// Which tasks the program has, and how each is tracked.
    pub tracking: TrackingSettings,
    /// The bounds.
    pub limits: Limits,
    /// The controller `hold`.
    pub hold: HoldSettings,
}

/// Which controller drives the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerKind {
    /// The quadratic program over momentum rate, feet and torso, after a reference generator (thesis 4.3, 4.4).
    Momentum,
    /// A spring and a damper at each joint, which hold the start pose.
    Hold,
}

/// The joint-space hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoldSettings {
    /// Joint angle error to torque [Nm/rad].
    pub stiffness_nmprad: f64,
    /// Joint velocity to torque [Nms/rad].
    pub damping_nmsprad: f64,
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
    /// Joint position error to acceleration, of the posture [1/s²].
    pub posture_gain: ByJoint,
    /// The posture that joints are held in.
    pub posture: Posture,
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
    /// What its vertical row weighs against the horizontal ones.
    pub vertical_momentum_factor: f64,
    /// `C_f`.
    pub feet: f64,
    /// What a swinging foot's place weighs against a standing one's.
    pub swing_feet_factor: f64,
    /// Weight of the angular acceleration of feet with several contact points.
    pub foot_rotation: f64,
    /// What a swinging foot's turn weighs against a standing one's.
    pub swing_rotation_factor: f64,
    /// What the turn of a foot that rolls over its toe weighs against a standing one's.
    pub rolling_rotation_factor: f64,
    /// The same while it hands its load to the other foot.
    pub trailing_rotation_factor: f64,
    /// `C_a`.
    pub torso: f64,
    /// What the square of the wanted acceleration raises that by: to `1 + (this · α_D²)²` times [s⁴].
    pub torso_urgency_s4: f64,
    /// Weight of the joint accelerations toward the posture.
    pub posture: ByJoint,
    /// Weight of a braking joint's acceleration error where the hard bound (4.32) had to yield.
    pub braking: f64,
}

/// Which tasks the program has, and how each is tracked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackingSettings {
    /// Momentum rate (4.17).
    pub momentum: Tracking,
    /// Feet (4.19).
    pub feet: Tracking,
    /// Torso (4.20).
    pub torso: Tracking,
    /// Posture of the actuated joints.
    pub posture: PostureTracking,
}

/// The bounds of the program (4.4.4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Joint torque [Nm].
    pub torque_nm: f64,
    /// Change of a joint's torque [Nm/s].
    pub torque_rate_nmps: f64,
    /// Each component of a contact's force [N].
    pub grf_n: f64,
    /// Acceleration of an actuated joint [rad/s²].
    pub joint_acceleration_radps2: f64,
    /// How a joint is kept within its limits.
    pub joint_limits: JointLimits,
    /// Rate of `approach` [1/s].
    pub approach_rate_1ps: f64,
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

/// How a joint is kept within its limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JointLimits {
    /// It brakes as hard as it can when it must (4.32).
    BrakingDistance,
    /// It comes to its limit no faster than critically damped (an exponential barrier; Nguyen and Sreenath 2016).
    Approach,
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

/// How a task enters the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tracking {
    /// Not at all.
    Off,
    /// Weighted in the cost.
    Cost,
    /// As a hard equality.
    Equality,
}

/// How the posture enters the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PostureTracking {
    /// Not at all.
    Off,
    /// Weighted in the cost, for the joints that torso, feet and centre of mass leave free.
    Free,
    /// Weighted in the cost, for all actuated joints.
    Cost,
    /// As a hard equality, for all actuated joints.
    Equality,
}

impl ControllerSettings {
    /// The settings for a robot of `mass` and `length` times those that they are for: what they are in forces and torques
    /// follows, so that accelerations are traded as before. Joint torque limits are the actuators' and stay.
    #[must_use]
    pub fn for_size(&self, mass: f64, length: f64) -> Self {
        let mut scaled = self.clone();
        scaled.planner.com_gain *= mass;
        scaled.planner.max_horizontal_momentum_rate_n *= mass;
        scaled.limits.grf_n *= mass;
        let (force, torque) = (mass * mass, mass * mass * length * length);
        scaled.weights.momentum /= force;
        scaled.weights.grf /= force;
        scaled.weights.angular_momentum_factor /= length * length;
        scaled.weights.torque /= torque;
        scaled
    }
}

impl Default for ControllerSettings {
    fn default() -> Self {
        Self {
            kind: ControllerKind::Momentum,
            period_s: 0.001,
            form: QpForm::Direct,
            assumed_friction: 0.85,
            friction_edges: 4,
            assumed_slope_deg: 0.0,
            lift_height_m: 0.002,
            known_delay_s: 0.0,
            planner: PlannerSettings {
                angular_momentum_gain: 200.0,
                com_gain: 1500.0,
                foot_gain: 1500.0,
                foot_rotation_gain: 400.0,
                torso_gain: 45.0,
                posture_gain: ByJoint::All(45.0),
                posture: Posture::Named(START.to_owned()),
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
                vertical_momentum_factor: 1.0,
                feet: 5e5,
                swing_feet_factor: 1.0,
                foot_rotation: 5e5,
                swing_rotation_factor: 1.0,
                rolling_rotation_factor: 1.0,
                trailing_rotation_factor: 1.0,
                torso: 1e5,
                torso_urgency_s4: 0.0,
                posture: ByJoint::All(1.0),
                braking: 1e4,
            },
            tracking: TrackingSettings {
                momentum: Tracking::Cost,
                feet: Tracking::Cost,
                torso: Tracking::Cost,
                posture: PostureTracking::Free,
            },
            limits: Limits {
                torque_nm: 220.0,
                torque_rate_nmps: 1e9,
                grf_n: 1000.0,
                joint_acceleration_radps2: 1000.0,
                joint_limits: JointLimits::BrakingDistance,
                approach_rate_1ps: 30.0,
            },
            hold: HoldSettings { stiffness_nmprad: 2000.0, damping_nmsprad: 100.0 },
        }
    }
}
