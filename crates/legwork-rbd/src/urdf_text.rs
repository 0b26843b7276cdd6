//! What a URDF says of links and joints, before any check across them. Defaults are those of the specification:
//! <https://wiki.ros.org/urdf/XML>, and for versions 1.1 and 1.2 that of urdfdom.

use nalgebra::{Matrix3, Vector3};

use crate::error::ModelError;
use crate::geometry::{Geometry, Shape};
use crate::joints::rotation_from_quaternion;
use crate::read::Source;
use crate::spatial::{Placement, rotation_from_rpy};
use crate::xml::{Element, Ignored, URDF, lenient, parse};

pub(crate) struct Robot {
    pub(crate) name: String,
    /// (major, minor), which is (1, 0) where it is not given.
    version: (u32, u32),
    pub(crate) links: Vec<Link>,
    pub(crate) joints: Vec<Joint>,
    /// What has no meaning in it, one sentence each.
    pub(crate) ignored: Vec<String>,
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
    pub(crate) mimics: Option<String>,
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
    pub(crate) fn read(text: &str, source: &Source) -> Result<Self, ModelError> {
        let text = lenient(text);
        let document = parse(&text, source, &URDF)?;
        let root = Element::root(&document, source);
        let mut ignored = Ignored::default();
        // The others are pictures, simulators and controllers.
        let known = ["link", "joint", "material", "gazebo", "transmission", "ros2_control", "sensor", "mujoco"];
        ignored.note(&root, &known, &["name", "version"]);
        let mut robot = Self {
            name: if root.has("name") { root.text("name")?.to_owned() } else { String::new() },
            version: if root.has("version") { version(root.text("version")?) } else { (1, 0) },
            links: Vec::new(),
            joints: Vec::new(),
            ignored: Vec::new(),
        };
        for element in root.children() {
            match element.name() {
                "link" => robot.links.push(robot.link(element, &mut ignored)?),
                "joint" => robot.joints.push(robot.joint(element, &mut ignored)?),
                _ => {}
            }
        }
        robot.ignored = ignored.warnings();
        Ok(robot)
    }

    fn link(&self, element: Element, ignored: &mut Ignored) -> Result<Link, ModelError> {
        let name = element.text("name")?;
        let subject = format!("link {name:?}");
        let element = element.of(&subject);
        ignored.note(&element, &["inertial", "visual", "collision", "sensor", "contact"], &["name", "type"]);
        let inertial = element.child("inertial")?.map(|inertial| self.inertial(inertial, ignored)).transpose()?;
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
            placement: self.origin(&element, &mut Ignored::default())?,
            shape: found,
            collides: true,
        }))
    }

    fn inertial(&self, element: Element, ignored: &mut Ignored) -> Result<Inertial, ModelError> {
        ignored.note(&element, &["origin", "mass", "inertia"], &[]);
        let (mass, inertia) = (element.needed("mass")?, element.needed("inertia")?);
        ignored.note(&mass, &[], &["value"]);
        ignored.note(&inertia, &[], &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]);
        let entry = |key: &str| inertia.needed_number(key);
        let (xx, xy, xz) = (entry("ixx")?, entry("ixy")?, entry("ixz")?);
        let (yy, yz, zz) = (entry("iyy")?, entry("iyz")?, entry("izz")?);
        Ok(Inertial {
            origin: self.origin(&element, ignored)?,
            mass: mass.needed_number("value")?,
            inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        })
    }

    fn joint(&self, element: Element, ignored: &mut Ignored) -> Result<Joint, ModelError> {
        let name = element.text("name")?;
        let subject = format!("joint {name:?}");
        let element = element.of(&subject);
        let known = ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration"];
        ignored.note(&element, &known, &["name", "type"]);
        let kind = element.text("type")?;
        let (parent, child) = (element.needed("parent")?, element.needed("child")?);
        let (axis, dynamics) = (element.child("axis")?, element.child("dynamics")?);
        for (child, keys) in [
            (Some(parent), ["link"].as_slice()),
            (Some(child), &["link"]),
            (axis, &["xyz"]),
            (dynamics, &["damping", "friction"]),
        ] {
            child.inspect(|child| ignored.note(child, &[], keys));
        }
        let axis = axis.map(|axis| axis.needed_numbers("xyz")).transpose()?;
        let rate = |key: &str| dynamics.map_or(Ok(None), |dynamics| dynamics.number(key));
        let mimics = element.child("mimic")?.map(|mimic| mimic.text("joint")).transpose()?;
        Ok(Joint {
            name: name.to_owned(),
            line: element.line(),
            kind: kind.to_owned(),
            parent: parent.text("link")?.to_owned(),
            child: child.text("link")?.to_owned(),
            origin: self.origin(&element, ignored)?,
            axis: axis.unwrap_or([1.0, 0.0, 0.0]),
            limit: element.child("limit")?.map(|limit| self.limit(limit, ignored)).transpose()?,
            damping: rate("damping")?.unwrap_or_default(),
            friction: rate("friction")?.unwrap_or_default(),
            mimics: mimics.map(str::to_owned),
        })
    }

    /// The `<origin>` of a joint or inertial.
    fn origin(&self, of: &Element, ignored: &mut Ignored) -> Result<Placement, ModelError> {
        let Some(origin) = of.child("origin")? else { return Ok(Placement::identity()) };
        let keys = ["xyz", "rpy", "quat_xyzw"];
        let quaternions = self.version >= (1, 1);
        ignored.note(&origin, &[], if quaternions { &keys } else { &keys[..2] });
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

    fn limit(&self, limit: Element, ignored: &mut Ignored) -> Result<Limit, ModelError> {
        ignored.note(&limit, &[], &["lower", "upper", "effort", "velocity"]);
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

/// Of `1.2`, (1, 2). As in urdfdom, what is no version is the first one.
fn version(text: &str) -> (u32, u32) {
    let parts = text.trim().split_once('.');
    parts.and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?))).unwrap_or((1, 0))
}
