//! MJCF, the language of MuJoCo's models: <https://mujoco.readthedocs.io/en/stable/XMLreference.html>.
//!
//! Bodies, joints, shapes and actuators to the description of a robot. What MuJoCo lets a body have and we do not becomes bodies
//! without mass: of several joints of a body all but the last move one of these each, and so does a joint beside its body's
//! origin, to which the body is then fixed. So every body keeps its name and its frame, and every joint its coordinate.

mod actuators;
mod bodies;
mod collada;
mod compiler;
mod defaults;
mod files;
mod inertia;
mod mesh;
mod robot;

pub use mesh::mesh_corners;
use std::collections::{BTreeMap, HashSet};

use nalgebra::{Matrix3, Vector3};

use self::actuators::Actuators;
use self::bodies::{Body, Geom, GeomType, Joint, JointType, Reader, then};
use self::compiler::Compiler;
use self::defaults::Defaults;
pub(crate) use self::files::ReadFile;
use self::files::{Texts, Tree};
use self::inertia::Mass;
use self::mesh::Meshes;
use self::robot::Choice;
use crate::base::Base;
use crate::description::{BodyDescription, Description, FrameDescription, JointDescription};
use crate::error::{ModelError, Problems};
use crate::geometry::{Geometry, Shape};
use crate::joints::{Fixed, Joint as JointKind, Kind};
use crate::model::{Dof, Model};
use crate::read::{Source, unit_axis};
use crate::read_toml::{contacts, frames, pitch_limits};
use crate::roles::Roles;
use crate::spatial::{Placement, rotation_about};
use crate::urdf::{Moving, SideFile, mark_actuated, set_numbers};
use crate::xml::Ignored;

/// A robot from the `text` of the file `name`; `read` gives the files that it names.
pub(crate) fn read_mjcf(
    text: &str,
    name: &str,
    sidecar: Option<(&str, &str)>,
    base: Option<Base>,
    read: ReadFile,
) -> Result<(Model, Roles), ModelError> {
    let (side_text, side_name) = sidecar.unwrap_or(("", name));
    let side_source = Source::new(side_name, side_text);
    let mut side = SideFile::read(sidecar.is_some(), &side_source)?;
    let texts = Texts::gather(text, name, read)?;
    let sources = texts.sources();
    let documents = texts.documents(&sources)?;
    let tree = Tree::new(&texts, &documents, &sources);
    let source = Source::new(name, text);

    let (mut ignored, mut warnings) = (Ignored::default(), Vec::new());
    ignored.note(&tree.root(), SECTIONS, &["model"]);
    let compiler = Compiler::read(&tree, &mut ignored, &mut warnings)?;
    let defaults = Defaults::read(&tree)?;
    let mut reader = Reader {
        tree: &tree,
        compiler: &compiler,
        defaults: &defaults,
        ignored: &mut ignored,
        sentences: &mut warnings,
    };
    let bodies = reader.bodies()?;
    let names: HashSet<&str> = bodies.iter().flat_map(|body| &body.joints).filter_map(|joint| joint.name).collect();
    let actuators = Actuators::read(&tree, &defaults, &names, &mut ignored, &mut warnings)?;
    let meshes = Meshes::new(&tree, &defaults, &compiler, read)?;
    let choice = Choice::of(&bodies, side.base_of(base), &source, &mut warnings)?;
    let mut assembly = Assembly::new(&bodies, &choice, &actuators, &compiler, meshes, &source);
    assembly.masses()?;
    assembly.assemble()?;
    let Assembly { bodies: mut described, geometry, sites, massless, .. } = assembly;
    let moving = Moving::of(&described);
    mark_actuated(&mut described, &moving, &side, &side_source)?;
    let mut problems = Problems::default();
    set_numbers(&mut described, &moving, &side.joints, &side_source, &mut problems);
    problems.none(name)?;
    warnings.extend(unread(&tree));
    if !actuators.any && side.says_no_actuators() {
        warnings.push("the file has no actuators: every joint is driven, without a limit of effort".to_owned());
    }
    let mut all = ignored.warnings();
    all.extend(warnings);
    let mut named_frames = sites;
    named_frames.extend(frames(&side.frames, &side_source)?);
    let roles = side.roles(side_name, geometry);
    let description = Description {
        file: name.to_owned(),
        name: tree.root().get("model").unwrap_or("MuJoCo Model").to_owned(),
        base: choice.base,
        gravity: side.gravity_mps2.unwrap_or(compiler.gravity),
        pitch_limits: pitch_limits(side.base_pitch, choice.base, &side_source)?,
        bodies: described,
        contacts: contacts(&side.contacts, &side_source)?,
        frames: named_frames,
        warnings: all,
        inertias: side.inertias,
        locked: side.locked,
        locks_massless: true,
        roles,
    };
    let (mut model, roles) = description.build()?;
    // They have none by design.
    let no_mass: HashSet<String> = massless.iter().map(|name| format!("body {name:?} has no mass")).collect();
    model.warnings.retain(|warning| !no_mass.contains(warning));
    Ok((model, roles))
}

const SECTIONS: &[&str] = &[
    "compiler",
    "option",
    "size",
    "visual",
    "statistic",
    "default",
    "custom",
    "extension",
    "asset",
    "worldbody",
    "deformable",
    "contact",
    "equality",
    "tendon",
    "actuator",
    "sensor",
    "keyframe",
    "include",
];

/// What acts on a robot and is not read, one sentence a section.
fn unread(tree: &Tree) -> Vec<String> {
    let mut sentences = Vec::new();
    for (section, what) in [
        ("equality", "constraints between bodies or joints are not read"),
        ("tendon", "tendons are not read, nor their springs and dampers"),
        ("deformable", "what deforms is not read"),
        ("contact", "pairs and exclusions of contact are not read"),
        ("extension", "plugins are not read"),
    ] {
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        for element in tree.sections(section).into_iter().flat_map(|section| tree.children(section)) {
            *kinds.entry(element.name()).or_default() += 1;
        }
        if !kinds.is_empty() {
            let kinds: Vec<_> = kinds.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            sentences.push(format!("<{section}> ({}) is ignored: {what}", kinds.join(", ")));
        }
    }
    sentences
}

/// The bodies of the file on their way to those of a description.
struct Assembly<'a, 'b> {
    given: &'b [Body<'a>],
    choice: &'b Choice,
    actuators: &'b Actuators<'a>,
    compiler: &'b Compiler,
    meshes: Meshes<'a, 'b>,
    source: &'b Source<'b>,
    masses: Vec<Mass>,
    /// The names of the file's bodies, also of those without one there.
    names: Vec<String>,
    own_names: HashSet<&'a str>,
    body_names: HashSet<String>,
    joint_names: HashSet<String>,
    bodies: Vec<BodyDescription>,
    geometry: Vec<Geometry>,
    sites: Vec<FrameDescription>,
    /// Bodies that stand for no body of the file.
    massless: Vec<String>,
}

impl<'a, 'b> Assembly<'a, 'b> {
    fn new(
        given: &'b [Body<'a>],
        choice: &'b Choice,
        actuators: &'b Actuators<'a>,
        compiler: &'b Compiler,
        meshes: Meshes<'a, 'b>,
        source: &'b Source<'b>,
    ) -> Self {
        // Bodies and frames share their names, and sites are frames.
        let sites = given.iter().flat_map(|body| &body.sites).map(|site| site.name);
        let mut body_names: HashSet<String> =
            given.iter().filter_map(|body| body.name).chain(sites).map(str::to_owned).collect();
        let joints = given.iter().flat_map(|body| &body.joints);
        let joint_names = joints.filter_map(|joint| joint.name).map(str::to_owned).collect();
        // The world is body 0.
        let number = |(index, body): (usize, &Body)| match body.name {
            Some(name) => name.to_owned(),
            None => unique(&format!("body_{}", index + 1), &mut body_names),
        };
        let names = given.iter().enumerate().map(number).collect();
        Self {
            given,
            choice,
            actuators,
            compiler,
            meshes,
            source,
            masses: Vec::new(),
            names,
            own_names: given.iter().filter_map(|body| body.name).collect(),
            body_names,
            joint_names,
            bodies: Vec::new(),
            geometry: Vec::new(),
            sites: Vec::new(),
            massless: Vec::new(),
        }
    }

    /// Those of the robot; of all bodies where the file asks for a total mass, which is theirs.
    fn masses(&mut self) -> Result<(), ModelError> {
        let mut total = 0.0;
        for (index, body) in self.given.iter().enumerate() {
            let counts = self.choice.takes[index] || self.compiler.total_mass.is_some();
            let mass = if counts { Mass::of(body, self.compiler, &mut self.meshes)? } else { Mass::none() };
            total += mass.mass;
            self.masses.push(mass);
        }
        if let Some(wanted) = self.compiler.total_mass.filter(|_| total > 0.0) {
            self.masses.iter_mut().for_each(|mass| mass.scale(wanted / total));
        }
        Ok(())
    }

    fn assemble(&mut self) -> Result<(), ModelError> {
        let world = self.choice.has_world.then(|| {
            let name = unique("world", &mut self.body_names);
            let fixed = JointDescription::new("base".to_owned(), JointKind::Fixed(Fixed), Placement::identity());
            self.push(name.clone(), None, Mass::none(), fixed, None);
            name
        });
        let mut number = 0;
        for index in 0..self.given.len() {
            let body = &self.given[index];
            let first = number;
            number += body.joints.len();
            if !self.choice.takes[index] {
                continue;
            }
            let parent = match body.parent {
                Some(parent) => Some(self.names[parent].clone()),
                None => world.clone(),
            };
            match parent {
                Some(parent) => self.chain(index, parent, first)?,
                None => {
                    let placement =
                        if self.choice.base == Base::Fixed { body.placement } else { Placement::identity() };
                    let fixed = JointDescription::new("base".to_owned(), JointKind::Fixed(Fixed), placement);
                    self.push(self.names[index].clone(), None, self.masses[index], fixed, body.line);
                }
            }
            self.shapes(index)?;
            self.sites(index);
        }
        Ok(())
    }

    /// A body with the joints that move it, the first of which is the file's joint number `first`.
    fn chain(&mut self, index: usize, mut parent: String, first: usize) -> Result<(), ModelError> {
        let body = &self.given[index];
        let mut from_parent = body.placement;
        for (k, joint) in body.joints.iter().enumerate() {
            let (at_joint, back) = around(joint);
            let name = match joint.name {
                Some(name) => name.to_owned(),
                None => unique(&format!("joint_{}", first + k), &mut self.joint_names),
            };
            let described = self.joint(joint, name, then(&from_parent, &at_joint))?;
            from_parent = back;
            if k + 1 == body.joints.len() && back == Placement::identity() {
                self.push(self.names[index].clone(), Some(parent), self.masses[index], described, body.line);
                return Ok(());
            }
            let virtual_body = unique(&described.name, &mut self.body_names);
            self.massless.push(virtual_body.clone());
            self.push(virtual_body.clone(), Some(parent), Mass::none(), described, body.line);
            parent = virtual_body;
        }
        let name = unique(&format!("{}_fixed", self.names[index]), &mut self.joint_names);
        let fixed = JointDescription::new(name, JointKind::Fixed(Fixed), from_parent);
        self.push(self.names[index].clone(), Some(parent), self.masses[index], fixed, body.line);
        Ok(())
    }

    fn joint(&self, joint: &Joint, name: String, placement: Placement) -> Result<JointDescription, ModelError> {
        let subject = format!("joint {name:?}");
        let kind = match joint.kind {
            JointType::Hinge => "revolute",
            JointType::Slide => "prismatic",
            JointType::Ball => "ball",
            JointType::Free => "floating",
        };
        let Some(read) = Kind::ALL.iter().find(|known| known.name == kind).and_then(|known| known.read) else {
            let problem = match joint.kind {
                JointType::Free => "a free joint moves a body of the world and is its only joint",
                _ => "is of a type that is not supported",
            };
            return Err(self.source.invalid(joint.line, subject, problem));
        };
        let kind = read(&|| unit_axis(self.source, joint.line, &subject, joint.axis))?;
        let is_single = kind.nv() == 1;
        let effort = joint.name.and_then(|name| self.actuators.efforts.get(name).copied());
        let most = joint.effort.map_or(f64::INFINITY, |[lower, upper]| lower.abs().max(upper.abs()));
        let range = joint.range.filter(|_| is_single).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let stiffness = if is_single { joint.stiffness } else { 0.0 };
        let dof = Dof {
            actuated: effort.is_some() || !self.actuators.any,
            lower: range[0],
            upper: range[1],
            effort_limit: effort.unwrap_or(f64::INFINITY).min(most),
            damping: joint.damping,
            armature: joint.armature,
            stiffness,
            rest: if stiffness == 0.0 { 0.0 } else { joint.rest },
            ..Dof::free()
        };
        Ok(JointDescription { dof, line: joint.line, ..JointDescription::new(name, kind, placement) })
    }

    fn push(&mut self, name: String, parent: Option<String>, mass: Mass, joint: JointDescription, line: Option<usize>) {
        let Mass { mass, com, inertia } = mass;
        self.bodies.push(BodyDescription { name, parent, mass, com, inertia, joint, line });
    }

    fn shapes(&mut self, index: usize) -> Result<(), ModelError> {
        for geom in &self.given[index].geoms {
            let Some(shape) = shape(geom, &self.meshes)? else { continue };
            self.geometry.push(Geometry {
                name: geom.item.text("name").unwrap_or_default().to_owned(),
                body: self.names[index].clone(),
                placement: geom.placement,
                shape,
                collides: geom.collides,
            });
        }
        Ok(())
    }

    /// Named places, but for those with the name of a body, by which the body is found.
    fn sites(&mut self, index: usize) {
        for site in self.given[index].sites.iter().filter(|site| !self.own_names.contains(site.name)) {
            self.sites.push(FrameDescription {
                name: site.name.to_owned(),
                body: self.names[index].clone(),
                placement: site.placement,
                line: site.line,
            });
        }
    }
}

/// The joint's frame in the body's as it stands at the coordinate zero, and the body's in what the joint moves.
fn around(joint: &Joint) -> (Placement, Placement) {
    let axis = defaults::direction(Vector3::from(joint.axis)).unwrap_or_else(Vector3::z);
    let shift = |translation| Placement { rotation: Matrix3::identity(), translation };
    match joint.kind {
        JointType::Free => (Placement::identity(), Placement::identity()),
        JointType::Slide => (shift(axis * -joint.reference), Placement::identity()),
        JointType::Ball => (shift(joint.position), shift(-joint.position)),
        JointType::Hinge => {
            let rotation =
                if joint.reference == 0.0 { Matrix3::identity() } else { rotation_about(&axis, -joint.reference) };
            (Placement { rotation, translation: joint.position }, shift(-joint.position))
        }
    }
}

/// None of what is endless.
fn shape(geom: &Geom, meshes: &Meshes) -> Result<Option<Shape>, ModelError> {
    let [a, b, c] = geom.size;
    if let Some(mesh) = geom.mesh {
        let (file, scale) = meshes.file(mesh, &geom.item)?;
        return Ok(Some(Shape::Mesh { file, scale }));
    }
    Ok(match geom.kind {
        GeomType::Sphere => Some(Shape::Sphere { radius: a }),
        GeomType::Capsule => Some(Shape::Capsule { radius: a, half_length: b }),
        GeomType::Cylinder => Some(Shape::Cylinder { radius: a, half_length: b }),
        GeomType::Box => Some(Shape::Box { half_sizes: Vector3::new(a, b, c) }),
        GeomType::Ellipsoid => Some(Shape::Ellipsoid { semi_axes: Vector3::new(a, b, c) }),
        GeomType::Plane | GeomType::HeightField | GeomType::Mesh | GeomType::Sdf => None,
    })
}

/// The name, or with a number where it is taken; it is taken then.
fn unique(name: &str, taken: &mut HashSet<String>) -> String {
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    let free = std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken.contains(name));
    let free = free.unwrap_or_default();
    taken.insert(free.clone());
    free
}
