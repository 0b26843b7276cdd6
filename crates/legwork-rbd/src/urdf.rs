//! A URDF, and the file beside it that says what URDF cannot, to the description of a robot.

use std::collections::{BTreeMap, HashMap, HashSet};

use nalgebra::{Matrix3, Unit, Vector3};
use serde::Deserialize;
use toml::Spanned;

use crate::base::Base;
use crate::content::Content;
use crate::description::{BodyDescription, Description, Inertias, JointDescription};
use crate::error::{ModelError, Problems};
use crate::geometry::Geometry;
use crate::joints::{Fixed, Joint, Kind, Prismatic, Revolute};
use crate::model::Model;
use crate::model_file::{ContactEntry, FrameEntry, GRAVITY};
use crate::read::{Source, unit_axis};
use crate::read_toml::{contacts, frames, numbers, pitch_limits};
use crate::roles::Roles;
use crate::spatial::{Motion, Placement};
use crate::table::Table;
use crate::urdf_text::{self, Link, Robot};
use crate::words;

/// `robot.legwork.toml` beside `robot.urdf`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SideFile {
    pub(crate) base: Option<Base>,
    pub(crate) torso: Option<String>,
    pub(crate) gravity_mps2: Option<f64>,
    pub(crate) base_pitch: Option<Table>,
    pub(crate) feet: Option<Vec<String>>,
    pub(crate) forward: Option<[f64; 3]>,
    #[serde(default)]
    pub(crate) postures: BTreeMap<String, BTreeMap<String, f64>>,
    pub(crate) actuated: Option<Vec<String>>,
    pub(crate) passive: Option<Vec<String>>,
    #[serde(default)]
    pub(crate) mimic: Mimic,
    #[serde(default)]
    pub(crate) locked: Vec<String>,
    #[serde(default)]
    pub(crate) inertias: Inertias,
    #[serde(default)]
    pub(crate) contacts: Vec<Spanned<ContactEntry>>,
    #[serde(default)]
    pub(crate) frames: Vec<Spanned<FrameEntry>>,
    /// By the joint's name: the numbers that a joint may have in TOML, in place of those of the URDF.
    #[serde(default)]
    pub(crate) joints: BTreeMap<String, Spanned<Table>>,
}

impl SideFile {
    /// What `source` says, or all defaults where there is no such file.
    pub(crate) fn read(is_there: bool, source: &Source) -> Result<Self, ModelError> {
        if !is_there {
            return Ok(Self::default());
        }
        source.parse_toml(Content::SideFile, "base, torso, contacts, actuated or passive")
    }

    /// Takes out of it what the dynamics give no meaning; `file` is its name, `geometry` the robot's shapes.
    pub(crate) fn roles(&mut self, file: &str, geometry: Vec<Geometry>) -> Roles {
        Roles {
            file: file.to_owned(),
            torso: self.torso.take(),
            feet: self.feet.take(),
            forward: self.forward,
            postures: std::mem::take(&mut self.postures),
            geometry,
            ..Roles::default()
        }
    }

    /// The base that it names, unless another one is asked for.
    pub(crate) fn base_of(&self, asked: Option<Base>) -> Option<Base> {
        asked.or(self.base)
    }

    /// Whether it leaves open which joints are driven.
    pub(crate) fn says_no_actuators(&self) -> bool {
        self.actuated.is_none() && self.passive.is_none()
    }
}

/// What becomes of joints that mimic others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mimic {
    /// They follow exactly and have no coordinate of their own.
    #[default]
    Coupled,
    /// They are fixed where they are as the other joint is at zero.
    Locked,
    /// They move as joints of their own.
    Free,
}

pub(crate) fn read_urdf(
    text: &str,
    file_name: &str,
    sidecar: Option<(&str, &str)>,
    base: Option<Base>,
) -> Result<(Model, Roles), ModelError> {
    let source = Source::new(file_name, text);
    let mut problems = Problems::default();
    let robot = Robot::read(text, &source, &mut problems)?;
    let (side_text, side_name) = sidecar.unwrap_or(("", file_name));
    let side_source = Source::new(side_name, side_text);
    let mut side = SideFile::read(sidecar.is_some(), &side_source)?;
    let wanted = base.or(side.base);
    let mut tree = Tree { bodies: Vec::new(), warnings: robot.warnings.clone(), mimic: side.mimic, mimics: Vec::new() };
    let floating = if wanted == Some(Base::Fixed) { None } else { carrier(&robot) };
    tree.describe(&robot, floating, &source, &mut problems);
    let moving = Moving::of(&tree.bodies);
    problems.keep(mark_actuated(&mut tree.bodies, &moving, &side, &side_source));
    set_numbers(&mut tree.bodies, &moving, &side.joints, &side_source, &mut problems);
    for joint in &robot.joints {
        let described = moving.0.get(&joint.name).map(|&index| &tree.bodies[index].joint);
        tree.warnings.extend(described.into_iter().flat_map(|described| unmodelled(joint, described)));
    }
    tree.tell_of_mimics();
    let base = wanted.unwrap_or(Base::Floating);
    let pitch_limits = problems.keep(pitch_limits(side.base_pitch.take(), base, &side_source));
    let contacts = problems.keep(contacts(&side.contacts, &side_source));
    let frames = problems.keep(frames(&side.frames, &side_source));
    let roles = side.roles(side_name, robot.links.into_iter().flat_map(|link| link.geometry).collect());
    let description = Description {
        file: file_name.to_owned(),
        name: robot.name,
        base,
        gravity: side.gravity_mps2.unwrap_or(GRAVITY),
        pitch_limits: pitch_limits.unwrap_or_default(),
        bodies: tree.bodies,
        contacts: contacts.unwrap_or_default(),
        frames: frames.unwrap_or_default(),
        warnings: tree.warnings,
        inertias: side.inertias,
        locked: side.locked,
        locks_massless: true,
        roles,
    };
    problems.none(file_name)?;
    description.build()
}

/// The floating joint that joins a root link without mass to all the others: what tools write for a robot that is free in space.
fn carrier(robot: &Robot) -> Option<&urdf_text::Joint> {
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child == name);
    let root = robot.links.iter().find(|link| !is_child(&link.name))?;
    let mut carried = robot.joints.iter().filter(|joint| joint.parent == root.name);
    let joint = carried.next().filter(|joint| joint.kind == "floating" && root.inertial.is_none())?;
    carried.next().is_none().then_some(joint)
}

/// The bodies of a robot's links, as they come to be known.
struct Tree {
    bodies: Vec<BodyDescription>,
    warnings: Vec<String>,
    mimic: Mimic,
    /// The joints that mimic others, each in words.
    mimics: Vec<String>,
}

impl Tree {
    /// The root link, then the children in the order of the file's joints. Without the joint `floating` and the root link, where the
    /// base takes their place.
    fn describe(
        &mut self,
        robot: &Robot,
        floating: Option<&urdf_text::Joint>,
        source: &Source,
        problems: &mut Problems,
    ) {
        let links = links(robot, source, problems);
        if !robot.is_whole {
            return;
        }
        let carried = carried(robot, &links, source, problems);
        if let Some(joint) = floating {
            self.warnings.push(format!(
                "joint {:?} of type floating is taken as the robot's base, without its origin; link {:?} is left out",
                joint.name, joint.parent
            ));
        }
        let left_out = |link: &Link| floating.is_some_and(|joint| joint.parent == link.name);
        let is_root = |link: &Link| match floating {
            Some(joint) => joint.child == link.name,
            None => !carried.contains_key(link.name.as_str()),
        };
        for link in robot.links.iter().filter(|link| is_root(link) && !left_out(link)) {
            let joint = JointDescription::new("base".to_owned(), Joint::Fixed(Fixed), Placement::identity());
            self.bodies.push(body(link, None, joint));
        }
        if self.bodies.is_empty() && !robot.links.is_empty() {
            let problem = "every link is a child of another: a loop; a robot has one root";
            problems.add(source.invalid(None, "robot", problem));
        }
        for joint in &robot.joints {
            let is_base = floating.is_some_and(|base| base.name == joint.name);
            let (Some(&link), false) = (links.get(joint.child.as_str()), is_base) else { continue };
            if let Some(described) = problems.keep(self.describe_joint(joint, source)) {
                let parent = self.carry(joint, &described);
                self.bodies.push(body(link, Some(parent), described));
            }
        }
    }

    /// The body that carries the last coordinate of `joint`: its parent, or of a planar joint the second of two bodies without mass that
    /// slide along the plane.
    fn carry(&mut self, joint: &urdf_text::Joint, described: &JointDescription) -> String {
        let (Joint::Revolute(Revolute { axis }), "planar") = (&described.kind, joint.kind.as_str()) else {
            return joint.parent.clone();
        };
        let across = if axis.x.abs() < 0.9 { Vector3::x_axis() } else { Vector3::y_axis() };
        let first = Unit::new_normalize(across.into_inner() - axis.into_inner() * axis.dot(&across));
        let second = Unit::new_normalize(axis.cross(&first));
        let mut parent = joint.parent.clone();
        for (suffix, axis, placement) in [("x", first, joint.origin), ("y", second, Placement::identity())] {
            let name = format!("{}_{suffix}", joint.name);
            let mut slide = JointDescription::new(name.clone(), Joint::Prismatic(Prismatic { axis }), placement);
            slide.line = joint.line;
            let (com, inertia) = (Vector3::zeros(), Matrix3::zeros());
            let carried = name.clone();
            self.bodies.push(BodyDescription {
                name,
                parent: Some(parent),
                mass: 0.0,
                com,
                inertia,
                joint: slide,
                line: joint.line,
            });
            parent = carried;
        }
        parent
    }

    fn tell_of_mimics(&mut self) {
        let count = match self.mimics.len() {
            0 => return,
            1 => "a joint mimics another one".to_owned(),
            several => format!("{several} joints mimic others"),
        };
        let done = match self.mimic {
            Mimic::Coupled => {
                "coupled exactly, without a coordinate of its own (mimic = \"free\" or \"locked\" in the side file changes that)"
            }
            Mimic::Locked => "locked (mimic = \"locked\")",
            Mimic::Free => "free, as if it did not (mimic = \"free\")",
        };
        self.warnings.push(format!("{count}, and each is {done}: {}", words::list(&self.mimics)));
    }
}

/// The links by name.
fn links<'a>(robot: &'a Robot, source: &Source, problems: &mut Problems) -> HashMap<&'a str, &'a Link> {
    if robot.links.is_empty() {
        problems.add(source.invalid(None, "robot", "has no links"));
    }
    let mut links = HashMap::new();
    for link in &robot.links {
        if links.insert(link.name.as_str(), link).is_some() {
            let problem = "the name is given twice; link names must differ";
            problems.add(source.invalid(link.line, format!("link {:?}", link.name), problem));
        }
    }
    links
}

/// The joint that carries each link but the root, by the link's name. [`Description::build`] would misname what is
/// refused here: it knows bodies with one parent each.
fn carried<'a>(
    robot: &'a Robot,
    links: &HashMap<&str, &Link>,
    source: &Source,
    problems: &mut Problems,
) -> HashMap<&'a str, &'a urdf_text::Joint> {
    let mut carried: HashMap<&str, &urdf_text::Joint> = HashMap::new();
    for joint in &robot.joints {
        let mut tell = |problem| problems.add(source.invalid(joint.line, format!("joint {:?}", joint.name), problem));
        for (role, link) in [("parent", &joint.parent), ("child", &joint.child)] {
            if !links.contains_key(link.as_str()) {
                let valid = words::list(robot.links.iter().map(|link| &link.name));
                tell(format!("unknown {role} link {link:?}; valid are {valid}"));
            }
        }
        if let Some(other) = carried.insert(&joint.child, joint) {
            tell(format!(
                "link {:?} has two parents, by this joint and by {:?}: a loop; a robot is a tree",
                joint.child, other.name
            ));
        }
    }
    carried
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

impl Tree {
    fn describe_joint(&mut self, joint: &urdf_text::Joint, source: &Source) -> Result<JointDescription, ModelError> {
        let subject = format!("joint {:?}", joint.name);
        let known = Kind::ALL.iter().find(|kind| kind.urdf.contains(&joint.kind.as_str()));
        let Some(read) = known.and_then(|kind| kind.read) else {
            let valid = words::list(Kind::ALL.iter().flat_map(|kind| kind.urdf));
            let problem = format!("is of type {}; valid are {valid}", words::quoted(&joint.kind));
            return Err(source.invalid(joint.line, subject, problem));
        };
        let kind = read(&|| unit_axis(source, joint.line, &subject, joint.axis))?;
        let mut described = JointDescription::new(joint.name.clone(), kind, joint.origin);
        described.line = joint.line;
        if joint.kind == "planar" {
            described.placement = Placement::identity();
        }
        if kind.nv() != 1 || joint.kind == "planar" {
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
        if let Some(leader) = &joint.mimics {
            self.mimics.push(format!("{:?} follows {:?} by {}", joint.name, leader.joint, leader.ratio));
            match self.mimic {
                Mimic::Coupled => described.follows = Some(leader.clone()),
                Mimic::Locked => {
                    let mut placement = described.placement;
                    kind.pose(&[leader.offset], &mut placement, &mut [Motion::zero()]);
                    described = JointDescription::new(joint.name.clone(), Joint::Fixed(Fixed), placement);
                    described.line = joint.line;
                }
                Mimic::Free => {}
            }
        }
        Ok(described)
    }
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
pub(crate) struct Moving(HashMap<String, usize>);

impl Moving {
    pub(crate) fn of(bodies: &[BodyDescription]) -> Self {
        let mut moving = HashMap::new();
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| body.joint.has_a_coordinate()) {
            moving.entry(body.joint.name.clone()).or_insert(index);
        }
        Self(moving)
    }

    fn index(&self, name: &str, bodies: &[BodyDescription]) -> Result<usize, String> {
        let moving = || bodies.iter().map(|body| &body.joint).filter(|joint| joint.has_a_coordinate());
        let unknown =
            || format!("unknown joint {name:?}; valid are {}", words::list(moving().map(|joint| &joint.name)));
        self.0.get(name).copied().ok_or_else(unknown)
    }
}

pub(crate) fn mark_actuated(
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
    for body in bodies.iter_mut().filter(|body| body.joint.has_a_coordinate()) {
        body.joint.dof.actuated = listed.contains(&body.joint.name) == listed_is;
    }
    Ok(())
}

pub(crate) fn set_numbers(
    bodies: &mut [BodyDescription],
    moving: &Moving,
    joints: &BTreeMap<String, Spanned<Table>>,
    source: &Source,
    problems: &mut Problems,
) {
    let mut set = |name: &String, table: &Spanned<Table>| {
        let (line, subject) = (source.line(table.span().start), format!("joint {name:?}"));
        let index = moving.index(name, bodies).map_err(|problem| source.invalid(line, "joints", problem))?;
        let joint = &mut bodies[index].joint;
        let mut table = table.get_ref().clone();
        let kind = joint.kind.kind();
        numbers(&mut table, kind, kind.keys, &mut joint.dof, source, line, &subject)?;
        joint.check_numbers().map_err(|problem| source.invalid(line, subject, problem))
    };
    for (name, table) in joints {
        problems.keep(set(name, table));
    }
}
