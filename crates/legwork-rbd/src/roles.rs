//! What a model file says of the robot that the dynamics give no meaning.

use std::collections::BTreeMap;

use crate::geometry::Geometry;

/// The parts that a robot's torso and feet are, in the words of a model file: read and written, but neither judged nor
/// kept in a [`Model`](crate::Model). legwork-contract makes a `Robot` of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roles {
    /// The file that says it, for messages: the model's own, or the one beside a URDF.
    pub file: String,
    /// The key `torso`.
    pub torso: Option<String>,
    /// The key `feet`.
    pub feet: Option<Vec<String>>,
    /// The key `forward`: the direction in which the robot faces, along the axes of its root link at the zero position.
    pub forward: Option<[f64; 3]>,
    /// The key `postures`: positions of joints [rad, m] by the posture's name and theirs.
    pub postures: BTreeMap<String, BTreeMap<String, f64>>,
    /// The key `foot` of each contact point, in the order of [`Model::contacts`](crate::Model::contacts).
    pub foot: Vec<Option<String>>,
    /// The shapes of its bodies, of a URDF or MJCF; they are not written to TOML.
    pub geometry: Vec<Geometry>,
    /// The line of each contact point in the file, where known.
    pub lines: Vec<Option<usize>>,
}
