//! A URDF, and the file beside it that says what URDF cannot, to the description of a robot.

use std::collections::{BTreeMap, HashMap, HashSet};

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use toml::Spanned;

use crate::base::Base;
use crate::content::Content;
use crate::description::{BodyDescription, Description, JointDescription};
use crate::error::ModelError;
use crate::joints::{Fixed, Joint, Kind};
use crate::model::Model;
use crate::model_file::{ContactEntry, FrameEntry, GRAVITY};
use crate::read::{Source, unit_axis};
use crate::read_toml::{contacts, frames, numbers, pitch_limits};
use crate::roles::Roles;
use crate::spatial::Placement;
use crate::table::Table;
use crate::urdf_text::{self, Link, Robot};
use crate::words;

/// `robot.legwork.toml` beside `robot.urdf`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SideFile {
    base: Option<Base>,
    torso: Option<String>,
    gravity_mps2: Option<f64>,
    base_pitch: Option<Table>,
    feet: Option<Vec<String>>,
    forward: Option<[f64; 3]>,
    #[serde(default)]
    postures: BTreeMap<String, BTreeMap<String, f64>>,
    actuated: Option<Vec<String>>,
    passive: Option<Vec<String>>,
    #[serde(default)]
    contacts: Vec<Spanned<ContactEntry>>,
    #[serde(default)]
    frames: Vec<Spanned<FrameEntry>>,
    /// By the joint's name: the numbers that a joint may have in TOML, in place of those of the URDF.
    #[serde(default)]
    joints: BTreeMap<String, Spanned<Table>>,
}

pub(crate) fn read_urdf(
    text: &str,
    file_name: &str,
    sidecar: Option<(&str, &str)>,
    base: Option<Base>,
) -> Result<(Model, Roles), ModelError> {
    let source = Source::new(file_name, text);
    let robot = Robot::read(text, &source)?;
    let (side_text, side_name) = sidecar.unwrap_or(("", file_name));
    let side_source = Source::new(side_name, side_text);
    let side: SideFile = match sidecar {
        Some(_) => side_source.parse_toml(Content::SideFile, "base, torso, contacts, actuated or passive")?,
        None => SideFile::default(),
    };
    let mut bodies = bodies(&robot, &source)?;
    let moving = Moving::of(&bodies);
    mark_actuated(&mut bodies, &moving, &side, &side_source)?;
    set_numbers(&mut bodies, &moving, &side.joints, &side_source)?;
    let mut warnings = robot.ignored;
    // Each joint's child comes in the order of the joints, behind the root link.
    let described = &bodies[robot.links.len() - robot.joints.len()..];
    for (joint, body) in robot.joints.iter().zip(described).filter(|(_, body)| body.joint.kind.nv() > 0) {
        warnings.extend(unmodelled(joint, &body.joint));
    }
    let base = base.or(side.base).unwrap_or(Base::Floating);
    Description {
        file: file_name.to_owned(),
        name: robot.name,
        base,
        gravity: side.gravity_mps2.unwrap_or(GRAVITY),
        pitch_limits: pitch_limits(side.base_pitch, base, &side_source)?,
        bodies,
        contacts: contacts(&side.contacts, &side_source)?,
        frames: frames(&side.frames, &side_source)?,
        warnings,
        roles: Roles {
            file: side_name.to_owned(),
            torso: side.torso,
            feet: side.feet,
            forward: side.forward,
            postures: side.postures,
            ..Roles::default()
        },
    }
    .build()
}

/// The root link, then the children in the order of the file's joints.
fn bodies(robot: &Robot, source: &Source) -> Result<Vec<BodyDescription>, ModelError> {
    let links = links(robot, source)?;
    let carried = carried(robot, &links, source)?;
    let mut bodies = Vec::with_capacity(robot.links.len());
    for link in robot.links.iter().filter(|link| !carried.contains_key(link.name.as_str())) {
        let joint = JointDescription::new("base".to_owned(), Joint::Fixed(Fixed), Placement::identity());
        bodies.push(body(link, None, joint));
    }
    if bodies.is_empty() {
        return Err(source.invalid(None, "robot", "every link is a child of another: a loop; a robot has one root"));
    }
    for joint in &robot.joints {
        bodies.push(body(links[joint.child.as_str()], Some(joint.parent.clone()), describe_joint(joint, source)?));
    }
    Ok(bodies)
}

/// The links by name.
fn links<'a>(robot: &'a Robot, source: &Source) -> Result<HashMap<&'a str, &'a Link>, ModelError> {
    if robot.links.is_empty() {
        return Err(source.invalid(None, "robot", "has no links"));
    }
    let mut links = HashMap::new();
    for link in &robot.links {
        if links.insert(link.name.as_str(), link).is_some() {
            let problem = "the name is given twice; link names must differ";
            return Err(source.invalid(link.line, format!("link {:?}", link.name), problem));
        }
    }
    Ok(links)
}

/// The joint that carries each link but the root, by the link's name. [`Description::build`] would misname what is
/// refused here: it knows bodies with one parent each.
fn carried<'a>(
    robot: &'a Robot,
    links: &HashMap<&str, &Link>,
    source: &Source,
) -> Result<HashMap<&'a str, &'a urdf_text::Joint>, ModelError> {
    let mut carried: HashMap<&str, &urdf_text::Joint> = HashMap::new();
    for joint in &robot.joints {
        let invalid = |problem| Err(source.invalid(joint.line, format!("joint {:?}", joint.name), problem));
        for (role, link) in [("parent", &joint.parent), ("child", &joint.child)] {
            if !links.contains_key(link.as_str()) {
                let valid = words::list(robot.links.iter().map(|link| &link.name));
                return invalid(format!("unknown {role} link {link:?}; valid are {valid}"));
            }
        }
        if let Some(other) = carried.insert(&joint.child, joint) {
            return invalid(format!(
                "link {:?} has two parents, by this joint and by {:?}: a loop; a robot is a tree",
                joint.child, other.name
            ));
        }
    }
    Ok(carried)
}

fn body(link: &Link, parent: Option<String>, joint: JointDescription) -> BodyDescription {
    let (mut mass, mut com, mut inertia) = (0.0, Vector3::zeros(), Matrix3::zeros());
    if let Some(inertial) = &link.inertial {
        (mass, com, inertia) = (inertial.mass, inertial.origin.translation, inertial.inertia);
        // The file's axes may be turned against the link's
        let rotation = &inertial.origin.rotation;
        if *rotation != Matrix3::identity() {
            let turned = rotation * inertia * rotation.transpose();
            inertia = (turned + turned.transpose()) * 0.5;
        }
    }
    BodyDescription { name: link.name.clone(), parent, mass, com, inertia, joint, line: link.line }
}

fn describe_joint(joint: &urdf_text::Joint, source: &Source) -> Result<JointDescription, ModelError> {
    let subject = format!("joint {:?}", joint.name);
    if let Some(leader) = &joint.mimics {
        let problem = format!("mimics {leader:?}, which is not supported; make the joint free or fixed");
        return Err(source.invalid(joint.line, subject, problem));
    }
    let known = Kind::ALL.iter().find(|kind| kind.urdf.contains(&joint.kind.as_str()));
    let Some(read) = known.and_then(|kind| kind.read) else {
        let valid = words::list(Kind::ALL.iter().flat_map(|kind| kind.urdf));
        let problem = format!(
            "is of type {}, which is not supported within the tree; valid are {valid} (what joins the root link to the \
             world is the model's base)",
            words::quoted(&joint.kind)
        );
        return Err(source.invalid(joint.line, subject, problem));
    };
    let kind = read(&|| unit_axis(source, joint.line, &subject, joint.axis))?;
    let mut described = JointDescription::new(joint.name.clone(), kind, joint.origin);
    described.line = joint.line;
    if kind.nv() == 0 {
        return Ok(described);
    }
    let dof = &mut described.dof;
    dof.actuated = true;
    dof.damping = joint.damping;
    if let Some(limit) = &joint.limit {
        if let Some([lower, upper]) = limit.range.filter(|_| joint.has_ends()) {
            (dof.lower, dof.upper) = (lower, upper);
        }
        dof.effort_limit = limit.effort.unwrap_or(dof.effort_limit);
        dof.velocity_limit = limit.velocity.unwrap_or(dof.velocity_limit);
    }
    Ok(described)
}

/// What the file of a joint that moves leaves out though URDF asks for it, and neither does the side file give it; and what
/// it says in vain.
fn unmodelled(joint: &urdf_text::Joint, described: &JointDescription) -> Vec<String> {
    let (dof, limit) = (&described.dof, joint.limit.as_ref());
    let mut missing = Vec::new();
    if joint.has_ends() && limit.is_none_or(|limit| limit.range.is_none()) && dof.usual_range().is_none() {
        missing.push("position");
    }
    // URDF lets a continuous joint be without any.
    if dof.actuated && (joint.has_ends() || limit.is_some()) {
        if limit.is_none_or(|limit| limit.effort.is_none()) && dof.effort_limit.is_infinite() {
            missing.push("effort");
        }
        if limit.is_none_or(|limit| limit.velocity.is_none()) && dof.velocity_limit.is_infinite() {
            missing.push("velocity");
        }
    }
    let mut sentences = Vec::new();
    if let [first @ .., last] = missing.as_slice() {
        let and = if first.is_empty() { "" } else { " and " };
        sentences.push(format!("joint {:?} has no {}{and}{last} limits", joint.name, first.join(", ")));
    }
    if joint.friction != 0.0 {
        sentences.push(format!("joint {:?}: Coulomb friction {} is ignored", joint.name, joint.friction));
    }
    sentences
}

/// The joints that move, as indices of their bodies, by name.
struct Moving(HashMap<String, usize>);

impl Moving {
    fn of(bodies: &[BodyDescription]) -> Self {
        let mut moving = HashMap::new();
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| body.joint.kind.nv() > 0) {
            moving.entry(body.joint.name.clone()).or_insert(index);
        }
        Self(moving)
    }

    fn index(&self, name: &str, bodies: &[BodyDescription]) -> Result<usize, String> {
        let moving = || bodies.iter().map(|body| &body.joint).filter(|joint| joint.kind.nv() > 0);
        let unknown =
            || format!("unknown joint {name:?}; valid are {}", words::list(moving().map(|joint| &joint.name)));
        self.0.get(name).copied().ok_or_else(unknown)
    }
}

fn mark_actuated(
    bodies: &mut [BodyDescription],
    moving: &Moving,
    side: &SideFile,
    source: &Source,
) -> Result<(), ModelError> {
    let (key, list, listed_is) = match (&side.actuated, &side.passive) {
        (None, None) => return Ok(()),
        (Some(list), None) => ("actuated", list, true),
        (None, Some(list)) => ("passive", list, false),
        (Some(_), Some(_)) => {
            return Err(source.invalid(None, "actuated, passive", "both are given; give one, the other follows"));
        }
    };
    for name in list {
        moving.index(name, bodies).map_err(|problem| source.invalid(None, key, problem))?;
    }
    let listed: HashSet<&String> = list.iter().collect();
    for body in bodies.iter_mut().filter(|body| body.joint.kind.nv() > 0) {
        body.joint.dof.actuated = listed.contains(&body.joint.name) == listed_is;
    }
    Ok(())
}

fn set_numbers(
    bodies: &mut [BodyDescription],
    moving: &Moving,
    joints: &BTreeMap<String, Spanned<Table>>,
    source: &Source,
) -> Result<(), ModelError> {
    for (name, table) in joints {
        let (line, subject) = (source.line(table.span().start), format!("joint {name:?}"));
        let index = moving.index(name, bodies).map_err(|problem| source.invalid(line, "joints", problem))?;
        let joint = &mut bodies[index].joint;
        let mut table = table.get_ref().clone();
        let kind = joint.kind.kind();
        numbers(&mut table, kind, kind.keys, &mut joint.dof, source, line, &subject)?;
        joint.check_numbers().map_err(|problem| source.invalid(line, subject, problem))?;
    }
    Ok(())
}
