//! What a URDF says of links and joints, before any check across them. Defaults are those of the specification:
//! <https://wiki.ros.org/urdf/XML>, and for versions 1.1 and 1.2 that of urdfdom.

use nalgebra::{Matrix3, Vector3};

use crate::description::Leader;
use crate::error::{ModelError, Problems};
use crate::geometry::{Geometry, Shape};
use crate::joints::rotation_from_quaternion;
use crate::read::Source;
use crate::spatial::{Placement, rotation_from_rpy};
use crate::xml::{Element, Ignored, URDF, lenient, mended, parse};

pub(crate) struct Robot {
    pub(crate) name: String,
    /// (major, minor), which is (1, 0) where it is not given.
    version: (u32, u32),
    pub(crate) links: Vec<Link>,
    pub(crate) joints: Vec<Joint>,
    /// Whether all its links and joints could be read, though numbers may be missing.
    pub(crate) is_whole: bool,
    /// What has no meaning in it or was mended, one sentence each.
    pub(crate) warnings: Vec<String>,
}

/// What is found while a robot is read.
#[derive(Default)]
struct Notes {
    ignored: Ignored,
    problems: Problems,
}

pub(crate) struct Link {
    pub(crate) name: String,
    pub(crate) line: Option<usize>,
    pub(crate) inertial: Option<Inertial>,
    /// Of its `<collision>` elements.
    pub(crate) geometry: Vec<Geometry>,
}

pub(crate) struct Inertial {
    /// Of the centre of mass and the axes of the inertia.
    pub(crate) origin: Placement,
    pub(crate) mass: f64,
    pub(crate) inertia: Matrix3<f64>,
}

pub(crate) struct Joint {
    pub(crate) name: String,
    pub(crate) line: Option<usize>,
    /// Its type.
    pub(crate) kind: String,
    pub(crate) parent: String,
    pub(crate) child: String,
    pub(crate) origin: Placement,
    pub(crate) axis: [f64; 3],
    pub(crate) limit: Option<Limit>,
    pub(crate) damping: f64,
    pub(crate) friction: f64,
    /// The joint that it follows.
    pub(crate) mimics: Option<Leader>,
}

impl Joint {
    /// Whether URDF asks for ends of its range.
    pub(crate) fn has_ends(&self) -> bool {
        self.kind != "continuous"
    }
}

/// The limits of a joint. One that is not given is none.
pub(crate) struct Limit {
    /// Lower and upper end; none also where both are zero, as tools leave them.
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) effort: Option<f64>,
    pub(crate) velocity: Option<f64>,
}

impl Robot {
    /// What `text` says; what is wrong with parts of it is added to `problems`, and those parts are left out.
    ///
    /// # Errors
    /// The text is no URDF.
    pub(crate) fn read(text: &str, source: &Source, problems: &mut Problems) -> Result<Self, ModelError> {
        let (text, mut warnings) = mended(&lenient(text));
        let document = parse(&text, source, &URDF)?;
        let root = Element::root(&document, source);
        let mut notes = Notes::default();
        // The others are pictures, simulators and controllers.
        let known = ["link", "joint", "material", "gazebo", "transmission", "ros2_control", "sensor", "mujoco"];
        notes.ignored.note(&root, &known, &["name", "version"]);
        let mut robot = Self {
            name: if root.has("name") { root.text("name")?.to_owned() } else { String::new() },
            version: if root.has("version") { version(root.text("version")?) } else { (1, 0) },
            links: Vec::new(),
            joints: Vec::new(),
            is_whole: true,
            warnings: Vec::new(),
        };
        for element in root.children() {
            match element.name() {
                "link" => {
                    let link = robot.link(element, &mut notes);
                    robot.is_whole &= link.is_ok();
                    robot.links.extend(notes.problems.keep(link));
                }
                "joint" => {
                    let joint = robot.joint(element, &mut notes);
                    robot.is_whole &= joint.is_ok();
                    robot.joints.extend(notes.problems.keep(joint));
                }
                _ => {}
            }
        }
        warnings.extend(notes.ignored.warnings());
        robot.warnings = warnings;
        problems.extend(notes.problems);
        Ok(robot)
    }

    fn link(&self, element: Element, notes: &mut Notes) -> Result<Link, ModelError> {
        let name = element.text("name")?;
        let subject = format!("link {name:?}");
        let element = element.of(&subject);
        notes.ignored.note(&element, &["inertial", "visual", "collision", "sensor", "contact"], &["name", "type"]);
        let inertial = notes.problems.keep(element.child("inertial")).flatten();
        let inertial = inertial.and_then(|inertial| {
            let inertial = self.inertial(inertial, notes);
            notes.problems.keep(inertial)
        });
        let collisions = element.children().filter(|child| child.name() == "collision");
        // What dynamics need not is no reason to refuse a robot.
        let geometry = collisions.filter_map(|collision| self.collision(name, collision).ok().flatten()).collect();
        Ok(Link { name: name.to_owned(), line: element.line(), inertial, geometry })
    }

    /// The shape of a `<collision>`, of one that is known.
    fn collision(&self, link: &str, element: Element) -> Result<Option<Geometry>, ModelError> {
        let geometry = element.needed("geometry")?;
        let Some(shape) = geometry.children().next() else { return Ok(None) };
        let half = |key: &str| Ok::<_, ModelError>(shape.needed_number(key)? / 2.0);
        let found = match shape.name() {
            "box" => Shape::Box { half_sizes: Vector3::from(shape.needed_numbers("size")?) / 2.0 },
            "sphere" => Shape::Sphere { radius: shape.needed_number("radius")? },
            "cylinder" => Shape::Cylinder { radius: shape.needed_number("radius")?, half_length: half("length")? },
            "capsule" => Shape::Capsule { radius: shape.needed_number("radius")?, half_length: half("length")? },
            "mesh" => {
                let scale = Vector3::from(shape.numbers("scale")?.unwrap_or([1.0; 3]));
                Shape::Mesh { file: shape.text("filename")?.to_owned(), scale }
            }
            _ => return Ok(None),
        };
        Ok(Some(Geometry {
            name: element.get("name").unwrap_or_default().to_owned(),
            body: link.to_owned(),
            placement: self.origin(&element, &mut Notes::default())?,
            shape: found,
            collides: true,
        }))
    }

    fn inertial(&self, element: Element, notes: &mut Notes) -> Result<Inertial, ModelError> {
        notes.ignored.note(&element, &["origin", "mass", "inertia"], &[]);
        let mut part = |name: &str, keys: &[&str]| {
            let part = notes.problems.keep(element.needed(name));
            part.inspect(|part| notes.ignored.note(part, &[], keys))
        };
        let keys = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        let (mass, inertia) = (part("mass", &["value"]), part("inertia", &keys));
        let mut number = |element: Option<Element>, key: &str| {
            let number = element.map(|element| element.needed_number(key));
            number.and_then(|number| notes.problems.keep(number)).unwrap_or_default()
        };
        let [xx, xy, xz, yy, yz, zz] = keys.map(|key| number(inertia, key));
        let mass = number(mass, "value");
        Ok(Inertial {
            origin: self.origin(&element, notes)?,
            mass,
            inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        })
    }

    fn joint(&self, element: Element, notes: &mut Notes) -> Result<Joint, ModelError> {
        let name = element.text("name")?;
        let subject = format!("joint {name:?}");
        let element = element.of(&subject);
        let known = ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration"];
        notes.ignored.note(&element, &known, &["name", "type"]);
        let kind = element.text("type")?;
        let (parent, child) = (element.needed("parent")?, element.needed("child")?);
        let (axis, dynamics) = (element.child("axis")?, element.child("dynamics")?);
        for (child, keys) in [
            (Some(parent), ["link"].as_slice()),
            (Some(child), &["link"]),
            (axis, &["xyz"]),
            (dynamics, &["damping", "friction"]),
        ] {
            child.inspect(|child| notes.ignored.note(child, &[], keys));
        }
        let axis = axis.and_then(|axis| notes.problems.keep(axis.needed_numbers("xyz")));
        let mut rate = |key: &str| {
            let number = dynamics.map_or(Ok(None), |dynamics| dynamics.number(key));
            notes.problems.keep(number).flatten().unwrap_or_default()
        };
        let (damping, friction) = (rate("damping"), rate("friction"));
        let origin = self.origin(&element, notes);
        let origin = notes.problems.keep(origin).unwrap_or(Placement::identity());
        let limit = element.child("limit")?.map(|limit| self.limit(limit, notes));
        let limit = limit.and_then(|limit| notes.problems.keep(limit));
        let mimics = element.child("mimic")?.map(|mimic| mimics(mimic, notes)).transpose()?;
        Ok(Joint {
            name: name.to_owned(),
            line: element.line(),
            kind: kind.to_owned(),
            parent: parent.text("link")?.to_owned(),
            child: child.text("link")?.to_owned(),
            origin,
            axis: axis.unwrap_or([1.0, 0.0, 0.0]),
            limit,
            damping,
            friction,
            mimics,
        })
    }

    /// The `<origin>` of a joint or inertial.
    fn origin(&self, of: &Element, notes: &mut Notes) -> Result<Placement, ModelError> {
        let Some(origin) = of.child("origin")? else { return Ok(Placement::identity()) };
        let keys = ["xyz", "rpy", "quat_xyzw"];
        let quaternions = self.version >= (1, 1);
        notes.ignored.note(&origin, &[], if quaternions { &keys } else { &keys[..2] });
        let quaternion = if quaternions { origin.numbers::<4>("quat_xyzw")? } else { None };
        let rotation = match (origin.numbers("rpy")?, quaternion) {
            (Some(_), Some(_)) => return Err(origin.invalid("origin rpy and quat_xyzw are both given; give one")),
            (rpy, None) => rotation_from_rpy(rpy.unwrap_or_default()),
            (None, Some(quaternion)) => {
                let largest = quaternion.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
                if largest == 0.0 {
                    return Err(origin.invalid("origin quat_xyzw is zero; give a rotation, such as \"0 0 0 1\""));
                }
                let [x, y, z, w] = quaternion.map(|entry| entry / largest);
                rotation_from_quaternion(&[w, x, y, z])
            }
        };
        Ok(Placement { rotation, translation: Vector3::from(origin.numbers("xyz")?.unwrap_or_default()) })
    }

    fn limit(&self, limit: Element, notes: &mut Notes) -> Result<Limit, ModelError> {
        notes.ignored.note(&limit, &[], &["lower", "upper", "effort", "velocity"]);
        let missing = if self.version >= (1, 2) { [f64::NEG_INFINITY, f64::INFINITY] } else { [0.0, 0.0] };
        let ends = [limit.extended("lower")?, limit.extended("upper")?];
        let range = [ends[0].unwrap_or(missing[0]), ends[1].unwrap_or(missing[1])];
        let is_given = range != [0.0, 0.0] && ends != [None, None];
        Ok(Limit {
            range: is_given.then_some(range),
            effort: limit.extended("effort")?,
            velocity: limit.extended("velocity")?,
        })
    }
}

/// The joint that a joint follows.
fn mimics(element: Element, notes: &mut Notes) -> Result<Leader, ModelError> {
    notes.ignored.note(&element, &[], &["joint", "multiplier", "offset"]);
    Ok(Leader {
        joint: element.text("joint")?.to_owned(),
        ratio: element.number("multiplier")?.unwrap_or(1.0),
        offset: element.number("offset")?.unwrap_or_default(),
    })
}

/// Of `1.2`, (1, 2). As in urdfdom, what is no version is the first one.
fn version(text: &str) -> (u32, u32) {
    let parts = text.trim().split_once('.');
    parts.and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?))).unwrap_or((1, 0))
}
