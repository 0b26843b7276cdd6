//! Falling: its one definition here, and why it happened ([`diagnose`], whose rules are in `rules.rs`).
//!
//! The robot has fallen when, after a control tick,
//! - the numbers are out of bounds: the state is not finite, or a joint is faster than `fall.max_joint_speed_radps`,
//! - a part of the body that is no foot touches the ground (knees, hips, the centre of mass of the torso),
//! - the CoM is lower over the ground than `fall.min_com_height_fraction` of its height at the start, or
//! - the torso is further from its reference than `fall.max_torso_angle_deg`.

mod cause;
mod evidence;
mod failure;
mod ground;
mod landing;
mod reach;
mod rules;
mod words;

use legwork_rbd::Dynamics;

use crate::contract::Sensed;
use crate::feet::{headed, heading, pitched};
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::terrain::Terrain;
pub use cause::{Diagnosis, Event, FirstCause, What};
pub use rules::{LOOKS_BACK_S, diagnose};

/// Which part of the definition was met.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The state is not finite or a joint is too fast.
    OutOfBounds {
        /// The fastest joint and its speed [rad/s], where the state is finite.
        joint: Option<(String, f64)>,
    },
    /// A part of the body touches the ground.
    BodyTouches {
        /// Which part.
        part: String,
    },
    /// The centre of mass is too low.
    ComTooLow {
        /// Its height [m].
        height: f64,
        /// The lowest allowed [m].
        lowest: f64,
    },
    /// The torso leans too far.
    TorsoLeans {
        /// Its angle from the reference [rad], without a sign.
        angle: f64,
        /// Which way: `forward`, `backward`, `to the left` or `to the right`.
        way: &'static str,
    },
}

/// A fall.
#[derive(Clone, Debug, PartialEq)]
pub struct Fall {
    /// When [s].
    pub time: f64,
    /// Which part of the definition was met first.
    pub cause: Cause,
}

/// Whether the robot, of which there are model and dynamics, has fallen in the state `truth`; `sound` is false where the physics'
/// numbers went out of bounds.
pub fn fall(
    scenario: &Scenario,
    (model, dynamics): (&Robot, &Dynamics),
    ground: &Terrain,
    truth: &Sensed,
    sound: bool,
) -> Option<Fall> {
    let settings = &scenario.fall;
    let at = |cause| Some(Fall { time: truth.time, cause });
    if !sound || !truth.fits(model) {
        return at(Cause::OutOfBounds { joint: None });
    }
    for (dof, &speed) in model.dofs.iter().zip(&truth.v) {
        if dof.rotational && speed.abs() > settings.max_joint_speed_radps {
            return at(Cause::OutOfBounds { joint: Some((dof.name.clone(), speed)) });
        }
    }
    for (index, body) in model.bodies.iter().enumerate().filter(|(_, body)| body.mass > 0.0) {
        if model.is_fixed_to_a_foot(index) {
            continue;
        }
        let pose = &dynamics.world_from_body[index];
        // Joints are the ends of the links; the root has none that anybody knows.
        let part = if index != model.root() && ground.gap(&pose.translation) < 0.0 {
            &body.joint_name
        } else if ground.gap(&pose.point(&body.com)) < 0.0 && !model.is_low_foot(index) {
            &body.name
        } else {
            continue;
        };
        return at(Cause::BodyTouches { part: part.clone() });
    }
    let height = dynamics.com.z - ground.height_at(dynamics.com.x, dynamics.com.y);
    let lowest = settings.min_com_height_fraction * scenario.start.com_height_m;
    if height < lowest {
        return at(Cause::ComTooLow { height, lowest });
    }
    let reference = scenario.controller.planner.torso_angle_deg.to_radians();
    let (angle, way) = if model.is_planar() {
        let angle = model.torso_angle(dynamics, &truth.q) - reference;
        (angle.abs(), if angle > 0.0 { "backward" } else { "forward" })
    } else {
        // Of the torso's upward axis, as seen from the torso's heading.
        let torso = model.torso_rotation(dynamics);
        let up = headed(&heading(&torso)).transpose() * torso.column(2);
        let wanted = pitched(reference).column(2).into_owned();
        let off = up - wanted;
        let way = match off.x.abs() > off.y.abs() {
            true if off.x > 0.0 => "forward",
            true => "backward",
            false if off.y > 0.0 => "to the left",
            false => "to the right",
        };
        (libm::atan2(wanted.cross(&up).norm(), wanted.dot(&up)), way)
    };
    if angle > settings.max_torso_angle_deg.to_radians() {
        return at(Cause::TorsoLeans { angle, way });
    }
    None
}

/// The fall in words: when, and which part of the definition was met.
pub fn sentence(fall: &Fall) -> String {
    format!("fell at {:.2} s: {}", fall.time, definition(fall))
}

/// The part of the definition that was met, in words.
pub(crate) fn definition(fall: &Fall) -> String {
    match &fall.cause {
        Cause::OutOfBounds { joint: Some((joint, speed)) } => {
            format!("{} turned at {:.0} rad/s, out of all bounds", joint.replace('_', " "), speed.abs())
        }
        Cause::OutOfBounds { joint: None } => "the numbers went out of bounds".to_owned(),
        Cause::BodyTouches { part } => format!("{} touched the ground", part.replace('_', " ")),
        Cause::ComTooLow { height, lowest } => {
            format!("the centre of mass sank to {height:.3} m, below {lowest:.3} m")
        }
        Cause::TorsoLeans { angle, way } => {
            format!("the torso leaned {:.0} deg {way} of its reference", angle.to_degrees())
        }
    }
}
