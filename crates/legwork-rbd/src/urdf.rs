//! URDF, through `urdf-rs`, and the file beside it that says what URDF cannot.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use toml::Spanned;
use urdf_rs::JointType;

use crate::base::Base;
use crate::description::{BodyDescription, Description, JointDescription};
use crate::error::ModelError;
use crate::joints::{Fixed, Joint, Kind};
use crate::model::Model;
use crate::model_file::{ContactEntry, FrameEntry, GRAVITY};
use crate::read::{Source, unit_axis};
use crate::read_toml::{contacts, frames, numbers, pitch_limits};
use crate::roles::Roles;
use crate::spatial::{Placement, rotation_from_rpy};
use crate::table::Table;
use crate::urdf_text::{element_line, parse};

/// `robot.legwork.toml` beside `robot.urdf`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SideFile {
    base: Option<Base>,
    torso: Option<String>,
    gravity_mps2: Option<f64>,
    base_pitch: Option<Table>,
    feet: Option<Vec<String>>,
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
    let robot = parse(text, &source)?;
    let (side_text, side_name) = sidecar.unwrap_or(("", file_name));
    let side_source = Source::new(side_name, side_text);
    let side: SideFile = match sidecar {
        Some(_) => side_source.parse_toml("base, torso, contacts, actuated or passive")?,
        None => SideFile::default(),
    };
    let mut warnings = Vec::new();
    let mut bodies = bodies(&robot, text, &source, &mut warnings)?;
    mark_actuated(&mut bodies, &side, &side_source)?;
    set_numbers(&mut bodies, &side.joints, &side_source)?;
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
        roles: Roles { file: side_name.to_owned(), torso: side.torso, feet: side.feet, ..Roles::default() },
    }
    .build()
}

/// The root link, then the children in the order of the file's joints.
fn bodies(
    robot: &urdf_rs::Robot,
    text: &str,
    source: &Source,
    warnings: &mut Vec<String>,
) -> Result<Vec<BodyDescription>, ModelError> {
    check_tree(robot, text, source)?;
    let mut bodies = Vec::with_capacity(robot.links.len());
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
    for link in robot.links.iter().filter(|link| !is_child(&link.name)) {
        let joint = JointDescription::new("base".to_owned(), Joint::Fixed(Fixed), Placement::identity());
        bodies.push(body(link, None, joint, text, source)?);
    }
    for joint in &robot.joints {
        let link = robot.links.iter().find(|link| link.name == joint.child.link).expect("checked above");
        let described = describe_joint(joint, text, source, warnings)?;
        bodies.push(body(link, Some(joint.parent.link.clone()), described, text, source)?);
    }
    Ok(bodies)
}

/// What [`Description::build`] would misname: it knows bodies with one parent each.
fn check_tree(robot: &urdf_rs::Robot, text: &str, source: &Source) -> Result<(), ModelError> {
    let names: Vec<_> = robot.links.iter().map(|link| link.name.as_str()).collect();
    if names.is_empty() {
        return Err(source.invalid(None, "robot", "has no links"));
    }
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            let problem = "the name is given twice; link names must differ";
            return Err(source.invalid(element_line(text, "link", name), format!("link {name:?}"), problem));
        }
    }
    for (i, joint) in robot.joints.iter().enumerate() {
        let subject = format!("joint {:?}", joint.name);
        let line = element_line(text, "joint", &joint.name);
        for (role, link) in [("parent", &joint.parent.link), ("child", &joint.child.link)] {
            if !names.contains(&link.as_str()) {
                let problem = format!("unknown {role} link {link:?}; valid are {}", names.join(", "));
                return Err(source.invalid(line, subject, problem));
            }
        }
        if let Some(other) = robot.joints[..i].iter().find(|other| other.child.link == joint.child.link) {
            let problem = format!(
                "link {:?} has two parents, by this joint and by {:?}: a loop; a robot is a tree",
                joint.child.link, other.name
            );
            return Err(source.invalid(line, subject, problem));
        }
    }
    if names.iter().all(|name| robot.joints.iter().any(|joint| joint.child.link == *name)) {
        return Err(source.invalid(None, "robot", "every link is a child of another: a loop; a robot has one root"));
    }
    Ok(())
}

fn body(
    link: &urdf_rs::Link,
    parent: Option<String>,
    joint: JointDescription,
    text: &str,
    source: &Source,
) -> Result<BodyDescription, ModelError> {
    let line = element_line(text, "link", &link.name);
    let subject = format!("link {:?}", link.name);
    let finite = |key: &str, value| source.finite(line, &subject, key, value);
    let i = &link.inertial.inertia;
    let entries = [i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz];
    for entry in entries {
        finite("inertia", entry)?;
    }
    let rpy = source.vector(line, &subject, "rpy of the inertial", *link.inertial.origin.rpy)?;
    let about_com = Matrix3::from_row_slice(&entries);
    // The file's axes may be turned against the link's
    let rotation = rotation_from_rpy(rpy.into());
    let turned = rotation * about_com * rotation.transpose();
    let turned = if rpy == Vector3::zeros() { about_com } else { (turned + turned.transpose()) * 0.5 };
    Ok(BodyDescription {
        name: link.name.clone(),
        parent,
        mass: finite("mass", link.inertial.mass.value)?,
        com: source.vector(line, &subject, "xyz of the inertial", *link.inertial.origin.xyz)?,
        inertia: turned,
        joint,
        line,
    })
}

fn describe_joint(
    joint: &urdf_rs::Joint,
    text: &str,
    source: &Source,
    warnings: &mut Vec<String>,
) -> Result<JointDescription, ModelError> {
    let subject = format!("joint {:?}", joint.name);
    let line = element_line(text, "joint", &joint.name);
    if let Some(mimic) = &joint.mimic {
        let problem = format!("mimics {:?}, which is not supported; make the joint free or fixed", mimic.joint);
        return Err(source.invalid(line, subject, problem));
    }
    let axis = || unit_axis(source, line, &subject, *joint.axis.xyz);
    let known = Kind::ALL.iter().find(|kind| kind.urdf.contains(&joint.joint_type));
    let Some(read) = known.and_then(|kind| kind.read) else {
        let kind = format!("{:?}", joint.joint_type).to_lowercase();
        let valid: Vec<String> =
            Kind::ALL.iter().flat_map(|kind| kind.urdf).map(|kind| format!("{kind:?}").to_lowercase()).collect();
        let problem = format!(
            "is of type {kind}, which is not supported within the tree; valid are {} (what joins the root link to the \
             world is the model's base)",
            valid.join(", ")
        );
        return Err(source.invalid(line, subject, problem));
    };
    let kind = read(&axis)?;
    let rpy = source.vector(line, &subject, "rpy of the origin", *joint.origin.rpy)?;
    let translation = source.vector(line, &subject, "xyz of the origin", *joint.origin.xyz)?;
    let placement = Placement { rotation: rotation_from_rpy(rpy.into()), translation };
    let mut described = JointDescription::new(joint.name.clone(), kind, placement);
    described.line = line;
    if kind.nv() == 0 {
        return Ok(described);
    }
    described.dof.actuated = true;
    limits(joint, &mut described, source, warnings)?;
    if let Some(dynamics) = &joint.dynamics {
        described.dof.damping = source.finite(line, &subject, "damping", dynamics.damping)?;
        if dynamics.friction != 0.0 {
            warnings.push(format!("{subject}: Coulomb friction {} is ignored", dynamics.friction));
        }
    }
    Ok(described)
}

/// Limits, where the parser makes a missing one zero (before URDF 1.2) or infinite (since).
fn limits(
    joint: &urdf_rs::Joint,
    described: &mut JointDescription,
    source: &Source,
    warnings: &mut Vec<String>,
) -> Result<(), ModelError> {
    let subject = format!("joint {:?}", joint.name);
    let limit = &joint.limit;
    for (key, value) in
        [("lower", limit.lower), ("upper", limit.upper), ("effort", limit.effort), ("velocity", limit.velocity)]
    {
        if value.is_nan() {
            return Err(source.invalid(described.line, subject, format!("limit {key} is NaN; a number is needed")));
        }
    }
    if joint.joint_type != JointType::Continuous {
        if limit.lower == 0.0 && limit.upper == 0.0 {
            warnings.push(format!("{subject} has no position limits"));
        } else {
            (described.dof.lower, described.dof.upper) = (limit.lower, limit.upper);
        }
    }
    if limit.effort != 0.0 {
        described.dof.effort_limit = limit.effort;
    }
    if limit.velocity != 0.0 {
        described.dof.velocity_limit = limit.velocity;
    }
    Ok(())
}

fn mark_actuated(bodies: &mut [BodyDescription], side: &SideFile, source: &Source) -> Result<(), ModelError> {
    let (key, list, listed_is) = match (&side.actuated, &side.passive) {
        (None, None) => return Ok(()),
        (Some(list), None) => ("actuated", list, true),
        (None, Some(list)) => ("passive", list, false),
        (Some(_), Some(_)) => {
            return Err(source.invalid(None, "actuated, passive", "both are given; give one, the other follows"));
        }
    };
    for name in list {
        moving_joint(bodies, name).map_err(|problem| source.invalid(None, key, problem))?;
    }
    for body in bodies.iter_mut().filter(|body| body.joint.kind.nv() > 0) {
        body.joint.dof.actuated = list.contains(&body.joint.name) == listed_is;
    }
    Ok(())
}

fn set_numbers(
    bodies: &mut [BodyDescription],
    joints: &BTreeMap<String, Spanned<Table>>,
    source: &Source,
) -> Result<(), ModelError> {
    for (name, table) in joints {
        let (line, subject) = (source.line(table.span().start), format!("joint {name:?}"));
        let joint = moving_joint(bodies, name).map_err(|problem| source.invalid(line, "joints", problem))?;
        let mut table = table.get_ref().clone();
        let kind = joint.kind.kind();
        numbers(&mut table, kind, kind.keys, &mut joint.dof, source, line, &subject)?;
        joint.check_numbers().map_err(|problem| source.invalid(line, subject, problem))?;
    }
    Ok(())
}

/// The joint of this name among those that move.
fn moving_joint<'a>(bodies: &'a mut [BodyDescription], name: &str) -> Result<&'a mut JointDescription, String> {
    let moving = || bodies.iter().filter(|body| body.joint.kind.nv() > 0);
    if moving().all(|body| body.joint.name != name) {
        let names: Vec<_> = moving().map(|body| body.joint.name.as_str()).collect();
        return Err(format!("unknown joint {name:?}; valid are {}", names.join(", ")));
    }
    let found = bodies.iter_mut().map(|body| &mut body.joint).find(|joint| joint.name == name && joint.kind.nv() > 0);
    Ok(found.expect("looked for above"))
}
