//! The simulator: integration, contact, sensors, actuators; pushes.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The simulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationSettings {
    /// Time step of the physics [s]; the control period is a whole multiple of it.
    pub period_s: f64,
    /// How the state is advanced.
    pub integrator: Integrator,
    /// The simulated robot's masses, centres of mass and inertias differ from those that the controller knows by up to this share.
    pub model_error: f64,
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
    /// Share by which the ground is raised each time under a contact that slips, where the solver has to do that (rigid).
    pub relaxation: f64,
    /// By how much an impulse, as force, may miss the law [N] (rigid).
    pub tolerance_n: f64,
    /// Linear solves after which the impulses are taken that miss the law least (rigid).
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
    /// Delay of all that is sensed [s].
    pub delay_s: f64,
    /// What raises the flag of a contact point.
    pub flag: ContactFlag,
    /// The vertical force above which a flag made of forces is up [N].
    pub flag_force_n: f64,
    /// Whether the forces on contact points are measured.
    pub loads: Loads,
    /// Delay of the measured forces, and of flags that are made of them, beside that of the state [s].
    pub load_delay_s: f64,
}

impl SensorSettings {
    /// Whether the controller is told the true positions and velocities.
    pub fn are_ideal(&self) -> bool {
        self.position_noise == 0.0 && self.velocity_noise == 0.0 && self.delay_s == 0.0
    }
}

/// What raises the flag that says that a contact point touches the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactFlag {
    /// Its height above the ground is at most `simulation.contact.flag_height_m`.
    Gap,
    /// The vertical force on it is more than `simulation.sensors.flag_force_n`.
    Force,
}

/// Whether the forces on contact points are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loads {
    /// The controller is told them.
    Measured,
    /// It is not.
    None,
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

impl Push {
    /// The unit vector along which a positive force acts, in the world frame.
    pub fn direction(&self) -> Vector3<f64> {
        let (up, along) = libm::sincos(self.direction_deg.to_radians());
        let (left, ahead) = libm::sincos(self.heading_deg.to_radians());
        Vector3::new(along * ahead, along * left, up)
    }

    /// Size and direction of the force, such as `200 N to the left` or `90 N backward, 30\u{b0} upward`.
    pub fn in_words(&self) -> String {
        let way = if self.force_n < 0.0 { -self.direction() } else { self.direction() };
        let along = libm::hypot(way.x, way.y);
        let whole = |radians: f64| (radians.to_degrees() * 10.0).round() / 10.0;
        let (heading, rise) = (whole(libm::atan2(way.y, way.x)), whole(libm::atan2(way.z, along)));
        let size = self.force_n.abs();
        let horizontal = match heading {
            0.0 => "forward".to_owned(),
            90.0 => "to the left".to_owned(),
            -90.0 => "to the right".to_owned(),
            heading if heading.abs() == 180.0 => "backward".to_owned(),
            heading => {
                format!("{}\u{b0} to the {} of forward", heading.abs(), if heading > 0.0 { "left" } else { "right" })
            }
        };
        match rise {
            0.0 => format!("{size} N {horizontal}"),
            90.0 => format!("{size} N up"),
            -90.0 => format!("{size} N down"),
            rise => format!(
                "{size} N {horizontal}, {}\u{b0} {}",
                rise.abs(),
                if rise > 0.0 { "upward" } else { "downward" }
            ),
        }
    }
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
    /// Impulses by the laws of Signorini and Coulomb.
    Rigid,
    /// The spring-damper that the thesis argues against (3.3).
    SpringDamper,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self {
            period_s: 0.001,
            integrator: Integrator::Midpoint,
            model_error: 0.0,
            contact: ContactSettings {
                model: ContactModel::Rigid,
                flag_height_m: 0.001,
                relaxation: 1.0,
                tolerance_n: 1e-6,
                max_sweeps: 500,
                stiffness_npm: 1e5,
                damping_nspm: 1e3,
                slip_speed_mps: 0.01,
            },
            sensors: SensorSettings {
                position_noise: 0.0,
                velocity_noise: 0.0,
                delay_s: 0.0,
                flag: ContactFlag::Gap,
                flag_force_n: 20.0,
                loads: Loads::Measured,
                load_delay_s: 0.0,
            },
            actuators: ActuatorSettings { delay_s: 0.0, lag_s: 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Push;

    #[test]
    fn a_push_is_called_after_where_it_goes() {
        for (force_n, direction_deg, heading_deg, words) in [
            (200.0, 0.0, 0.0, "200 N forward"),
            (200.0, 0.0, 90.0, "200 N to the left"),
            (200.0, 0.0, -90.0, "200 N to the right"),
            (200.0, 180.0, 90.0, "200 N to the right"),
            (-234.0, 0.0, 0.0, "234 N backward"),
            (50.0, 180.0, 0.0, "50 N backward"),
            (50.0, 90.0, 30.0, "50 N up"),
            (50.0, 270.0, 0.0, "50 N down"),
            (12.5, 150.0, 0.0, "12.5 N backward, 30\u{b0} upward"),
            (90.0, -60.0, 45.0, "90 N 45\u{b0} to the left of forward, 60\u{b0} downward"),
        ] {
            let push = Push { force_n, direction_deg, heading_deg, ..Push::default() };
            assert_eq!(push.in_words(), words);
            assert!((push.direction().norm() - 1.0).abs() < 1e-15);
        }
    }
}
