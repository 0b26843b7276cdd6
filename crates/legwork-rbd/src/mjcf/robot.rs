//! Which bodies of the world are the robot, and what joins it to the world.

use super::bodies::{Body, JointType};
use crate::base::Base;
use crate::error::ModelError;
use crate::read::Source;
use crate::words::list;

pub(super) struct Choice {
    pub(super) base: Base,
    /// Whether a body that stands for the world is the root.
    pub(super) has_world: bool,
    /// For each body of the file whether it is the robot's.
    pub(super) takes: Vec<bool>,
}

/// A body of the world with all that it carries.
struct Top {
    body: usize,
    is_free: bool,
    has_joints: bool,
    /// Whether it has a joint other than a free one.
    is_articulated: bool,
}

impl Choice {
    /// The tree of bodies that has joints is the robot. What stands still is none of it, nor is a single body that moves freely
    /// beside a robot. Trees that are joined to the world are one robot together.
    pub(super) fn of(
        bodies: &[Body],
        base: Option<Base>,
        source: &Source,
        sentences: &mut Vec<String>,
    ) -> Result<Self, ModelError> {
        let tops = tops(bodies);
        let called = |top: &Top| bodies[top.body].name.map_or_else(|| "one without a name".to_owned(), str::to_owned);
        let names = |tops: &[&Top]| list(tops.iter().map(|top| called(top)));
        let moving: Vec<&Top> = tops.iter().filter(|top| top.has_joints).collect();
        let articulated: Vec<&Top> = moving.iter().filter(|top| top.is_articulated).copied().collect();
        let robots = if articulated.is_empty() { moving.clone() } else { articulated };
        let Some(first) = robots.first() else {
            return Err(source.invalid(None, "worldbody", "no body has a joint, so nothing moves"));
        };
        if robots.len() > 1 && robots.iter().any(|top| top.is_free) {
            let problem =
                format!("several bodies of the world move ({}); leave one of them in the file", names(&robots));
            return Err(source.invalid(bodies[robots[1].body].line, "worldbody", problem));
        }
        let left: Vec<&Top> = tops.iter().filter(|top| !robots.iter().any(|robot| robot.body == top.body)).collect();
        if !left.is_empty() {
            sentences.push(format!("bodies of the world beside the robot are ignored: {}", names(&left)));
        }
        if robots.len() > 1 {
            sentences.push(format!("several bodies of the world move and are one robot together: {}", names(&robots)));
        }
        let (is_one, is_jointed) = (robots.len() == 1, !bodies[first.body].joints.is_empty());
        let found = if is_one && first.is_free { Base::Floating } else { Base::Fixed };
        let base = base.unwrap_or(found);
        if base != found && !is_one {
            let problem = format!("several bodies of the world move ({}), so the base is fixed", names(&robots));
            return Err(source.invalid(None, "base", problem));
        }
        // Another base takes the place of the joints that the file joins the root to the world with.
        let replaced = base != found || base == Base::Floating;
        if base != found && is_jointed && !first.is_free {
            let joints = list(bodies[first.body].joints.iter().filter_map(|joint| joint.name));
            sentences.push(format!("the base takes the place of the joints {joints}"));
        }
        if base == found && is_jointed && is_planar(&bodies[first.body]) {
            let sentence = "the root moves in the plane by joints of its own; with base = \"planar\" in a side file they are the base's";
            sentences.push(sentence.to_owned());
        }
        let mut takes: Vec<bool> = Vec::with_capacity(bodies.len());
        for (index, body) in bodies.iter().enumerate() {
            takes.push(body.parent.map_or_else(|| robots.iter().any(|top| top.body == index), |parent| takes[parent]));
        }
        Ok(Self { base, has_world: !replaced && (is_jointed || !is_one), takes })
    }
}

fn tops(bodies: &[Body]) -> Vec<Top> {
    let (mut tops, mut top_of) = (Vec::<Top>::new(), Vec::with_capacity(bodies.len()));
    for (index, body) in bodies.iter().enumerate() {
        let top = match body.parent {
            Some(parent) => top_of[parent],
            None => {
                tops.push(Top { body: index, is_free: false, has_joints: false, is_articulated: false });
                tops.len() - 1
            }
        };
        top_of.push(top);
        for joint in &body.joints {
            tops[top].has_joints = true;
            tops[top].is_free |= joint.kind == JointType::Free;
            tops[top].is_articulated |= joint.kind != JointType::Free;
        }
    }
    tops
}

/// Whether its joints are those of the plane: along x, along z, about y.
fn is_planar(body: &Body) -> bool {
    let has = |kind: JointType, along: usize| {
        let along_only = |axis: &[f64; 3]| (0..3).all(|k| (axis[k] != 0.0) == (k == along));
        body.joints.iter().any(|joint| joint.kind == kind && along_only(&joint.axis))
    };
    body.joints.len() == 3 && has(JointType::Slide, 0) && has(JointType::Slide, 2) && has(JointType::Hinge, 1)
}
