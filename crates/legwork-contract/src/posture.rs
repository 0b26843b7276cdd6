//! Postures and other numbers of joints, by the joints' names.

use std::collections::BTreeMap;

use legwork_rbd::words::{list, quoted};
use serde::{Deserialize, Serialize};

use crate::robot::Robot;
use legwork_rbd::words::matches;

/// The name of the posture in which every joint is at zero, or at the end of its range that is nearest to it.
pub const NEUTRAL: &str = "neutral";
/// The name of the posture of the first tick.
pub const START: &str = "start";
/// A joint that is put into its range stays so far from the ends, as a share of the range.
const INSIDE: f64 = 0.01;

/// A posture: by its name, or as positions of joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Posture {
    /// [`NEUTRAL`], [`START`] where that is known, or the name of one in the robot's file.
    Named(String),
    /// Positions [rad, m] by names or patterns of joints; the others are as in the posture that is the default.
    Joints(BTreeMap<String, f64>),
}

impl Posture {
    /// The position that it gives to each velocity coordinate of `robot` [rad, m]; none where it gives none.
    ///
    /// # Errors
    /// In words: there is no such posture, or a name is none of a joint.
    pub fn positions(&self, robot: &Robot) -> Result<Vec<Option<f64>>, String> {
        let joints = match self {
            Self::Named(name) if name == NEUTRAL => return Ok(neutral(robot).into_iter().map(Some).collect()),
            Self::Named(name) if name == START => return Ok(vec![None; robot.nv()]),
            Self::Named(name) => robot.postures.get(name).ok_or_else(|| {
                let known = robot.postures.keys().map(String::as_str).chain([NEUTRAL]);
                format!("unknown posture {}; valid are {}, or a table of joints", quoted(name), list(known))
            })?,
            Self::Joints(joints) => joints,
        };
        check_names(robot, joints.keys())?;
        let position = |dof: &legwork_rbd::Dof| entry(joints, &dof.name).filter(|_| dof.actuated);
        Ok(robot.dofs.iter().map(position).collect())
    }
}

/// Where each coordinate of `robot` is in the posture [`NEUTRAL`] [rad, m].
pub fn neutral(robot: &Robot) -> Vec<f64> {
    let nearest = |dof: &legwork_rbd::Dof| {
        let inset = INSIDE * dof.usual_range().map_or(0.0, |[lower, upper]| upper - lower);
        0.0_f64.max(dof.lower + inset).min(dof.upper - inset)
    };
    robot.dofs.iter().map(nearest).collect()
}

/// A number of each joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ByJoint {
    /// One of all joints.
    All(f64),
    /// By names or patterns of joints.
    Each(BTreeMap<String, f64>),
}

impl ByJoint {
    /// The number of the joint `name`; `otherwise` where none is given. Allocates nothing.
    #[inline]
    pub fn of(&self, name: &str, otherwise: f64) -> f64 {
        match self {
            Self::All(number) => *number,
            Self::Each(numbers) => entry(numbers, name).unwrap_or(otherwise),
        }
    }

    /// Whether all names are those of joints of `robot`.
    ///
    /// # Errors
    /// In words: a name is none of a joint.
    pub fn check(&self, robot: &Robot) -> Result<(), String> {
        match self {
            Self::All(_) => Ok(()),
            Self::Each(numbers) => check_names(robot, numbers.keys()),
        }
    }
}

/// The entry of a joint: that of its name, or of the longest pattern that its name matches.
fn entry(entries: &BTreeMap<String, f64>, name: &str) -> Option<f64> {
    let matching =
        || entries.iter().filter(|(pattern, _)| matches(pattern, name)).max_by_key(|(pattern, _)| pattern.len());
    entries.get(name).copied().or_else(|| matching().map(|(_, number)| *number))
}

/// Whether each of `patterns` is the name of a joint of `robot`, or matches one; of joints that are locked, too.
///
/// # Errors
/// In words: which is not, and which joints there are.
pub fn check_names(robot: &Robot, patterns: impl IntoIterator<Item = impl AsRef<str>>) -> Result<(), String> {
    for pattern in patterns {
        if !robot.bodies.iter().any(|body| matches(pattern.as_ref(), &body.joint_name)) {
            let joints = robot.actuated().map(|dof| &robot.dofs[dof].name);
            return Err(format!("no joint is called {}; valid are {}", quoted(pattern.as_ref()), list(joints)));
        }
    }
    Ok(())
}
