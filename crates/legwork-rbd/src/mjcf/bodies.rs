//! The bodies of `<worldbody>` with their joints, shapes and sites, each placed in its body's frame.

use nalgebra::{Matrix3, Vector3};

use super::compiler::{Compiler, named};
use super::defaults::{Defaults, Item, direction, rotation_to};
use super::files::Tree;
use crate::error::ModelError;
use crate::spatial::Placement;
use crate::words::{list, quoted};
use crate::xml::{Element, Ignored};

pub(super) struct Body<'a> {
    pub(super) name: Option<&'a str>,
    pub(super) line: Option<usize>,
    /// `None`: the world.
    pub(super) parent: Option<usize>,
    /// In its parent, where all its joints are at their references.
    pub(super) placement: Placement,
    pub(super) inertial: Option<Inertial>,
    pub(super) joints: Vec<Joint<'a>>,
    pub(super) geoms: Vec<Geom<'a>>,
    pub(super) sites: Vec<Site<'a>>,
}

pub(super) struct Inertial {
    pub(super) placement: Placement,
    pub(super) mass: f64,
    /// About the centre of mass, along the placement's axes.
    pub(super) inertia: Matrix3<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointType {
    Free,
    Ball,
    Slide,
    Hinge,
}

/// A joint; angles in radians.
pub(super) struct Joint<'a> {
    pub(super) name: Option<&'a str>,
    pub(super) line: Option<usize>,
    pub(super) kind: JointType,
    pub(super) position: Vector3<f64>,
    pub(super) axis: [f64; 3],
    /// Its coordinate where the body is where `Body::placement` says.
    pub(super) reference: f64,
    pub(super) range: Option<[f64; 2]>,
    pub(super) stiffness: f64,
    pub(super) rest: f64,
    pub(super) damping: f64,
    pub(super) armature: f64,
    /// What its actuators may give together.
    pub(super) effort: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GeomType {
    Plane,
    HeightField,
    Sphere,
    Capsule,
    Ellipsoid,
    Cylinder,
    Box,
    Mesh,
    Sdf,
}

const GEOM_TYPES: [(&str, GeomType); 9] = [
    ("plane", GeomType::Plane),
    ("hfield", GeomType::HeightField),
    ("sphere", GeomType::Sphere),
    ("capsule", GeomType::Capsule),
    ("ellipsoid", GeomType::Ellipsoid),
    ("cylinder", GeomType::Cylinder),
    ("box", GeomType::Box),
    ("mesh", GeomType::Mesh),
    ("sdf", GeomType::Sdf),
];

pub(super) struct Geom<'a> {
    pub(super) item: Item<'a>,
    pub(super) kind: GeomType,
    pub(super) placement: Placement,
    /// Radius and half the length, or half the sizes.
    pub(super) size: [f64; 3],
    pub(super) mesh: Option<&'a str>,
    pub(super) mass: Option<f64>,
    pub(super) density: f64,
    pub(super) is_shell: bool,
    pub(super) group: f64,
    pub(super) collides: bool,
}

impl<'a> Geom<'a> {
    pub(super) fn element(&self) -> Element<'a> {
        self.item.element()
    }
}

pub(super) struct Site<'a> {
    pub(super) name: &'a str,
    pub(super) line: Option<usize>,
    pub(super) placement: Placement,
}

/// Where an element stands.
#[derive(Clone, Copy)]
struct Place<'a> {
    /// `None`: the world.
    body: Option<usize>,
    /// What messages call what has no name of its own.
    subject: &'a str,
    /// Of the frames around it, in that body.
    frame: Placement,
    class: usize,
}

pub(super) struct Reader<'a, 'b> {
    pub(super) tree: &'b Tree<'a>,
    pub(super) compiler: &'b Compiler,
    pub(super) defaults: &'b Defaults<'a>,
    pub(super) ignored: &'b mut Ignored,
    pub(super) sentences: &'b mut Vec<String>,
}

const ORIENTATION: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

const BODY_KEYS: &[&str] = &["name", "childclass", "pos", "mocap", "gravcomp", "sleep", "simple", "user"];
const CHILDREN: &[&str] = &[
    "include",
    "body",
    "frame",
    "inertial",
    "joint",
    "freejoint",
    "geom",
    "site",
    "camera",
    "light",
    "replicate",
    "attach",
    "composite",
    "flexcomp",
    "plugin",
];
const JOINT_KEYS: &[&str] = &[
    "name",
    "class",
    "type",
    "group",
    "pos",
    "axis",
    "springdamper",
    "limited",
    "actuatorfrclimited",
    "solreflimit",
    "solimplimit",
    "solreffriction",
    "solimpfriction",
    "stiffness",
    "range",
    "actuatorfrcrange",
    "actuatorgravcomp",
    "margin",
    "ref",
    "springref",
    "armature",
    "damping",
    "frictionloss",
    "user",
];
const GEOM_KEYS: &[&str] = &[
    "name",
    "class",
    "type",
    "contype",
    "conaffinity",
    "condim",
    "group",
    "priority",
    "size",
    "material",
    "friction",
    "mass",
    "density",
    "shellinertia",
    "solmix",
    "solref",
    "solimp",
    "margin",
    "gap",
    "surfacevel",
    "adhesion",
    "fromto",
    "pos",
    "hfield",
    "mesh",
    "fitscale",
    "rgba",
    "fluidshape",
    "fluidcoef",
    "user",
];

impl<'a> Reader<'a, '_> {
    /// The bodies, each behind its parent, in the order of the file.
    pub(super) fn bodies(&mut self) -> Result<Vec<Body<'a>>, ModelError> {
        let mut bodies: Vec<Body<'a>> = Vec::new();
        let world = Place { body: None, subject: "worldbody", frame: Placement::identity(), class: 0 };
        let mut open: Vec<_> =
            self.tree.sections("worldbody").into_iter().map(|world_body| (world_body, world)).collect();
        open.reverse();
        while let Some((element, place)) = open.pop() {
            let subject = element.get("name").filter(|name| !name.is_empty()).unwrap_or(place.subject);
            let element = element.of(subject);
            let inner = match element.name() {
                "worldbody" => place,
                "body" => {
                    let body = self.body(element, place)?;
                    bodies.push(body);
                    Place { body: Some(bodies.len() - 1), subject, frame: Placement::identity(), ..place }
                }
                "frame" => {
                    let pose = self.pose(&self.defaults.item(element, place.class)?)?;
                    Place { frame: then(&place.frame, &pose), ..place }
                }
                _ => {
                    if let Some(body) = place.body {
                        self.part(element, place, &mut bodies[body])?;
                    }
                    continue;
                }
            };
            let class = element.get("childclass").map_or(Ok(place.class), |name| self.defaults.class(name, element))?;
            let place = Place { class, ..inner };
            let children = self.tree.children(element);
            open.extend(children.into_iter().rev().map(|child| (child, place)));
        }
        Ok(bodies)
    }

    fn body(&mut self, element: Element<'a>, place: Place<'a>) -> Result<Body<'a>, ModelError> {
        self.ignored.note(&element, CHILDREN, &[BODY_KEYS, &ORIENTATION].concat());
        let placement = then(&place.frame, &self.pose(&self.defaults.item(element, place.class)?)?);
        if element.number("gravcomp")?.is_some_and(|share| share != 0.0) {
            let body = named("body", element.get("name").unwrap_or_default());
            self.sentences.push(format!("{}{body}: gravcomp is ignored, it has its weight", self.tree.at(element)));
        }
        Ok(Body {
            name: element.get("name").filter(|name| !name.is_empty()),
            line: self.tree.own_line(element),
            parent: place.body,
            placement,
            inertial: None,
            joints: Vec::new(),
            geoms: Vec::new(),
            sites: Vec::new(),
        })
    }

    /// Something that is fixed to a body, or that moves it.
    fn part(&mut self, element: Element<'a>, place: Place<'a>, body: &mut Body<'a>) -> Result<(), ModelError> {
        match element.name() {
            "inertial" if body.inertial.is_some() => Err(element.invalid("a second <inertial> of its body; give one")),
            "inertial" => {
                body.inertial = Some(self.inertial(element, place)?);
                Ok(())
            }
            "joint" | "freejoint" => {
                body.joints.push(self.joint(element, place)?);
                Ok(())
            }
            "geom" => {
                body.geoms.push(self.geom(element, place)?);
                Ok(())
            }
            "site" => {
                let Some(name) = element.get("name") else { return Ok(()) };
                let item = self.defaults.item(element, place.class)?;
                let pose = if item.text("fromto").is_some() { self.span(&item)?.0 } else { self.pose(&item)? };
                body.sites.push(Site { name, line: self.tree.own_line(element), placement: then(&place.frame, &pose) });
                Ok(())
            }
            "replicate" | "attach" | "composite" | "flexcomp" => {
                let name = element.name();
                Err(element.invalid(format!("<{name}> within a body is not supported; write out what it stands for")))
            }
            // Cameras, lights and plugins move nothing.
            _ => Ok(()),
        }
    }

    /// `pos` and one of the rotations.
    fn pose(&self, item: &Item) -> Result<Placement, ModelError> {
        Ok(Placement { rotation: item.rotation(self.compiler)?, translation: item.vector("pos")? })
    }

    fn inertial(&mut self, element: Element<'a>, place: Place<'a>) -> Result<Inertial, ModelError> {
        let keys = ["pos", "mass", "diaginertia", "fullinertia"];
        self.ignored.note(&element, &[], &[&keys[..], &ORIENTATION].concat());
        let item = self.defaults.item(element, place.class)?;
        let pose = self.pose(&item)?;
        element.text("pos")?;
        let inertia = match (item.row::<3>("diaginertia")?, item.row::<6>("fullinertia")?) {
            (Some(_), Some(_)) => {
                return Err(element.invalid("diaginertia and fullinertia are both given; give one"));
            }
            (diagonal, None) => Matrix3::from_diagonal(&Vector3::from(diagonal.unwrap_or_default())),
            (None, Some([xx, yy, zz, xy, xz, yz])) => {
                if let Some(key) = ORIENTATION.iter().find(|key| element.has(key)) {
                    return Err(element.invalid(format!("fullinertia and {key} are both given; give one")));
                }
                Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
            }
        };
        let mass = element.needed_number("mass")?;
        Ok(Inertial { placement: then(&place.frame, &pose), mass, inertia })
    }

    fn joint(&mut self, element: Element<'a>, place: Place<'a>) -> Result<Joint<'a>, ModelError> {
        let (name, line) = (element.get("name").filter(|name| !name.is_empty()), self.tree.own_line(element));
        if element.name() == "freejoint" {
            self.ignored.note(&element, &[], &["name", "group", "align"]);
            return Ok(Joint { name, line, ..Joint::free() });
        }
        self.ignored.note(&element, &[], JOINT_KEYS);
        let item = self.defaults.item(element, place.class)?;
        let kind = match item.text("type").unwrap_or("hinge") {
            "free" => JointType::Free,
            "ball" => JointType::Ball,
            "slide" => JointType::Slide,
            "hinge" => JointType::Hinge,
            _ => return Err(item.element().refused_at("type", "valid are free, ball, slide and hinge")),
        };
        let angle = |value: f64| if kind == JointType::Slide { value } else { self.compiler.angle(value) };
        let is_single = matches!(kind, JointType::Slide | JointType::Hinge);
        let range = item.range("range", "limited")?.filter(|_| kind != JointType::Free);
        let axis = Vector3::from(item.row("axis")?.unwrap_or([0.0, 0.0, 1.0]));
        let joint = Joint {
            name,
            line,
            kind,
            position: place.frame.point(&item.vector("pos")?),
            axis: (place.frame.rotation * axis).into(),
            reference: if is_single { angle(item.number("ref")?.unwrap_or(0.0)) } else { 0.0 },
            range: range.map(|range| range.map(angle)),
            stiffness: self.first(&item, "stiffness")?,
            rest: angle(item.number("springref")?.unwrap_or(0.0)),
            damping: self.first(&item, "damping")?,
            armature: item.number("armature")?.unwrap_or(0.0),
            effort: item.range("actuatorfrcrange", "actuatorfrclimited")?.filter(|_| is_single),
        };
        self.joint_ignores(&item, kind)?;
        Ok(joint)
    }

    /// The factor of the first power; a spring or damper that is no line is told of.
    fn first(&mut self, item: &Item, key: &str) -> Result<f64, ModelError> {
        let ([first, second, third], _) = item.part::<3>(key)?;
        if second != 0.0 || third != 0.0 {
            let joint = named("joint", item.text("name").unwrap_or_default());
            let place = self.tree.at(item.element());
            self.sentences.push(format!("{place}{joint}: of its {key} only the linear part is read"));
        }
        Ok(first)
    }

    fn joint_ignores(&mut self, item: &Item, kind: JointType) -> Result<(), ModelError> {
        let (place, joint) = (self.tree.at(item.element()), named("joint", item.text("name").unwrap_or_default()));
        if let Some(friction) = item.number("frictionloss")?.filter(|friction| *friction != 0.0) {
            self.sentences.push(format!("{place}{joint}: Coulomb friction {friction} is ignored"));
        }
        if item.row::<2>("springdamper")?.is_some_and(|pair| pair != [0.0, 0.0]) {
            self.sentences.push(format!("{place}{joint}: springdamper is ignored; give stiffness and damping"));
        }
        if kind == JointType::Ball {
            let given =
                [("stiffness", item.part::<3>("stiffness")?.0[0] != 0.0), ("range", item.text("range").is_some())];
            for (key, _) in given.into_iter().filter(|(_, is_given)| *is_given) {
                self.sentences.push(format!("{place}{joint}: {key} of a ball joint is ignored"));
            }
        }
        if kind == JointType::Free {
            for key in ["armature", "damping", "stiffness"] {
                if item.part::<3>(key)?.0[0] != 0.0 {
                    self.sentences.push(format!("{place}{joint}: {key} of a free joint is ignored"));
                }
            }
        }
        Ok(())
    }

    fn geom(&mut self, element: Element<'a>, place: Place<'a>) -> Result<Geom<'a>, ModelError> {
        self.ignored.note(&element, &["plugin"], &[GEOM_KEYS, &ORIENTATION].concat());
        let item = self.defaults.item(element, place.class)?;
        let kind = item.text("type").unwrap_or("sphere");
        let Some(&(_, kind)) = GEOM_TYPES.iter().find(|(name, _)| *name == kind) else {
            let valid = list(GEOM_TYPES.iter().map(|(name, _)| *name));
            return Err(element.invalid(format!("geom type is {}; valid are {valid}", quoted(kind))));
        };
        let mesh = item.text("mesh");
        let (mut size, _) = item.part::<3>("size")?;
        let pose = if item.text("fromto").is_none() {
            self.pose(&item)?
        } else {
            let (pose, half_length) = self.span(&item)?;
            size = match kind {
                GeomType::Capsule | GeomType::Cylinder => [size[0], half_length, 0.0],
                GeomType::Ellipsoid | GeomType::Box => [size[0], size[0], half_length],
                _ => return Err(element.invalid("fromto is for a capsule, cylinder, ellipsoid or box")),
            };
            pose
        };
        let sizes = match kind {
            GeomType::Sphere => 1,
            GeomType::Capsule | GeomType::Cylinder => 2,
            GeomType::Ellipsoid | GeomType::Box => 3,
            GeomType::Plane | GeomType::HeightField | GeomType::Mesh | GeomType::Sdf => 0,
        };
        if mesh.is_none() && size[..sizes].iter().any(|size| *size <= 0.0) {
            return Err(
                element.invalid(format!("geom size is too short or not positive; {sizes} positive numbers are needed"))
            );
        }
        let touches = |key: &str| Ok::<_, ModelError>(item.number(key)?.unwrap_or(1.0) != 0.0);
        let collides = touches("contype")? || touches("conaffinity")?;
        Ok(Geom {
            kind,
            placement: then(&place.frame, &pose),
            size,
            mesh,
            mass: item.number("mass")?,
            density: item.number("density")?.unwrap_or(1000.0),
            is_shell: item.switch("shellinertia")?.unwrap_or(false),
            group: item.number("group")?.unwrap_or(0.0),
            collides,
            item,
        })
    }

    /// The frame of a shape between two points, with its z axis from the second to the first, and half their distance.
    fn span(&self, item: &Item) -> Result<(Placement, f64), ModelError> {
        let ends: [f64; 6] = item.row("fromto")?.unwrap_or_default();
        let [from, to] = [&ends[..3], &ends[3..]].map(Vector3::from_column_slice);
        let along = from - to;
        let z = direction(along).ok_or_else(|| item.element().invalid("fromto: both points are the same"))?;
        let placement = Placement { rotation: rotation_to(&z), translation: (from + to) / 2.0 };
        Ok((placement, libm::sqrt(along.norm_squared()) / 2.0))
    }
}

impl Joint<'_> {
    fn free() -> Self {
        Self {
            name: None,
            line: None,
            kind: JointType::Free,
            position: Vector3::zeros(),
            axis: [0.0, 0.0, 1.0],
            reference: 0.0,
            range: None,
            stiffness: 0.0,
            rest: 0.0,
            damping: 0.0,
            armature: 0.0,
            effort: None,
        }
    }
}

/// `a_from_c`, of `a_from_b` and `b_from_c`.
pub(super) fn then(outer: &Placement, inner: &Placement) -> Placement {
    // To the last bit where one of them does not turn.
    if outer.rotation == Matrix3::identity() {
        return Placement { rotation: inner.rotation, translation: outer.translation + inner.translation };
    }
    Placement { rotation: outer.rotation * inner.rotation, translation: outer.point(&inner.translation) }
}
