//! What a robot of one's own is taken to be: which links are its feet and its torso, where its soles touch, and why. From its tree and its
//! shapes alone; what a file says of it goes before.
//!
//! A foot is a last link that moves, with all that is fixed to it; of those the two lowest with as many joints above them are the feet.
//! Its contact points are the corners of what its collision shapes have within a centimetre of their lowest point. The torso is the
//! heaviest of the links between the legs and above them.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use legwork_rbd::words::{list, quoted};
use legwork_rbd::{Dynamics, Geometry, Model, Placement, Roles, Shape, mesh_corners};
use nalgebra::Vector3;

use crate::error::Error;

/// What of a sole is no more than this above its lowest point touches the ground [m].
const LAYER: f64 = 0.01;
/// A sole that is shorter and narrower than this is a point [m].
const POINT: f64 = 0.03;
/// Shapes whose corners are those of a sole.
const EXACT: [&str; 3] = ["boxes", "spheres", "capsules"];
/// Feet that differ in height by a larger share of the robot's height than this are no pair.
const LEVEL: f64 = 0.05;

/// What a user says of a robot, where it is to be something else than would be found.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// The links that are its feet.
    pub feet: Vec<String>,
    /// The link that is its torso.
    pub torso: Option<String>,
}

/// What a robot is taken to be.
#[derive(Clone, Debug)]
pub struct Understanding {
    /// The link whose orientation is the robot's posture.
    pub torso: String,
    /// Why it is.
    pub torso_because: String,
    /// The right foot and the left one.
    pub feet: [Foot; 2],
    /// Joints that would take the robot out of the x-z plane.
    pub sideways: Vec<String>,
}

/// A foot and where it touches.
#[derive(Clone, Debug)]
pub struct Foot {
    /// `right` or `left`.
    pub name: &'static str,
    /// The link.
    pub link: String,
    /// Why it is a foot.
    pub because: String,
    /// Its contact points in the link's frame [m].
    pub points: Vec<Vector3<f64>>,
    /// What they were found from.
    pub points_from: String,
}

/// Why a robot cannot be taken for one that stands.
#[derive(Debug)]
pub struct Lacking {
    /// What is missing.
    pub error: Error,
    /// Lines for its side file that would say it, where there are such.
    pub lines: String,
}

impl From<Error> for Lacking {
    fn from(error: Error) -> Self {
        Self { error, lines: String::new() }
    }
}

/// Reads the file of a mesh by the name that the robot's file has for it.
pub type ReadMesh<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// Takes `model` for a robot that stands on two feet.
///
/// # Errors
/// It has no two feet, or their soles cannot be found: says what is missing, with the lines to write into `side_file`.
pub fn understand(
    model: &Model,
    roles: &Roles,
    wanted: &Wanted,
    read_mesh: ReadMesh<'_>,
    side_file: &str,
) -> Result<Understanding, Lacking> {
    let links = Links::of(model, roles, read_mesh);
    let (mut feet, because) = links.feet(wanted)?;
    links.right_before_left(&mut feet);
    let (torso, torso_because) = links.torso(wanted, roles, feet)?;
    let mut found = Vec::new();
    for (foot, name) in feet.into_iter().zip(["right", "left"]) {
        let (points, points_from) = links.sole(feet, foot, side_file)?;
        let link = model.bodies[foot].name.clone();
        found.push(Foot { name, link, because: because.clone(), points, points_from });
    }
    let feet = <[Foot; 2]>::try_from(found).expect("two feet");
    Ok(Understanding { torso: model.bodies[torso].name.clone(), torso_because, feet, sideways: links.sideways() })
}

impl Understanding {
    /// The file beside the robot's own that says all of it; `planar` holds the robot in the x-z plane.
    #[must_use]
    pub fn side_file(&self, robot_file: &str, planar: bool) -> String {
        let mut text = format!(
            "# What {robot_file} does not say of its robot. Found by `legwork adopt`; change what is otherwise.\n"
        );
        let base = if planar { "planar" } else { "floating" };
        let _ = writeln!(text, "base = \"{base}\"\n\n# {}.\ntorso = {:?}", self.torso_because, self.torso);
        if planar && !self.sideways.is_empty() {
            let _ = writeln!(text, "\n# They would take the robot out of its plane.\nlocked = {:?}", self.sideways);
        }
        let _ = writeln!(text, "\nfeet = [\"right\", \"left\"]\ncontacts = [");
        for foot in &self.feet {
            let _ = writeln!(text, "  # {}; {}.", foot.because, foot.points_from);
            for (index, point) in foot.points.iter().enumerate() {
                let [x, y, z] = [point.x, point.y, point.z].map(|value| (value * 1e6).round() / 1e6 + 0.0);
                let _ = writeln!(
                    text,
                    "  {{ name = \"{name}_{}\", foot = \"{name}\", body = {:?}, position_m = [{x:?}, {y:?}, {z:?}] }},",
                    index + 1,
                    foot.link,
                    name = foot.name
                );
            }
        }
        text + "]\n"
    }

    /// A scenario in which the robot of `robot_file` stands and sways, with the settings of a built-in robot scaled to it.
    #[must_use]
    pub fn stand(robot_file: &str, name: &str, planar: bool) -> String {
        let (from, fit) = if planar { ("stand-push", "planar_humanoid_feet") } else { ("exo-sway", "exo18") };
        format!(
            "description = \"{name} stands and sways.\"\nextends = \"{from}\"\nmodel = {robot_file:?}\n\
             # The settings of {from} are those of {fit}: they are scaled by length of leg, mass and gravity.\nfit = \"{fit}\"\n\
             duration_s = 10.0\npushes = []\n"
        )
    }

    /// A scenario in which the robot, held in the plane, walks.
    #[must_use]
    pub fn walk(robot_file: &str, name: &str) -> String {
        format!(
            "description = \"{name} walks.\"\nextends = \"feet-walk\"\nmodel = {robot_file:?}\n\
             # The settings of feet-walk are those of a person of 1.75 m who walks at 1 m/s: they are scaled by length of leg, mass\n\
             # and gravity, the speed too.\nfit = \"planar_humanoid_feet\"\nduration_s = 10.0\n"
        )
    }
}

/// A model at its zero position, with what is fixed to what.
struct Links<'a> {
    model: &'a Model,
    dynamics: Dynamics,
    /// For each body the one whose joint moves it: its own, or that of what it is fixed to.
    mover: Vec<usize>,
    /// Points of the shapes of each body: place in the world and radius [m].
    points: Vec<Vec<(Vector3<f64>, f64)>>,
    /// For each body the kinds of its shapes, and those that could not be read.
    shapes: Vec<(BTreeSet<&'static str>, Vec<String>)>,
}

impl<'a> Links<'a> {
    fn of(model: &'a Model, roles: &Roles, read_mesh: ReadMesh<'_>) -> Self {
        let mut dynamics = Dynamics::new(model);
        dynamics.update(model, model.neutral().as_slice(), &vec![0.0; model.nv()]);
        let mut links = Self {
            model,
            dynamics,
            mover: (0..model.bodies.len()).map(|body| model.mover(body)).collect(),
            points: vec![Vec::new(); model.bodies.len()],
            shapes: vec![(BTreeSet::new(), Vec::new()); model.bodies.len()],
        };
        for collides in [true, false] {
            // Pictures are of use only where nothing else tells a link's shape.
            let told: BTreeSet<usize> = (0..model.bodies.len())
                .filter(|&body| !links.points[body].is_empty())
                .map(|body| links.mover[body])
                .collect();
            for geometry in roles.geometry.iter().filter(|geometry| geometry.collides == collides) {
                let body = model.body_index(&geometry.body).filter(|&body| !told.contains(&links.mover[body]));
                let Some(body) = body else { continue };
                let Some((points, radius)) = hull(geometry, read_mesh) else {
                    links.shapes[body].1.push(match &geometry.shape {
                        Shape::Mesh { file, .. } => format!("the mesh {}", quoted(file)),
                        _ => "a shape".to_owned(),
                    });
                    continue;
                };
                let placement = links.dynamics.world_from_body[body];
                links.points[body].extend(points.iter().map(|point| (placement.point(point), radius)));
                links.shapes[body].0.insert(kind(&geometry.shape, collides));
            }
        }
        links
    }

    /// The bodies that are fixed to the one that `mover` moves, itself first.
    fn fixed_to(&self, mover: usize) -> impl Iterator<Item = usize> + '_ {
        (mover..self.mover.len()).filter(move |&body| self.mover[body] == mover)
    }

    /// Height of the lowest point of what moves with `mover` [m].
    fn lowest(&self, mover: usize) -> f64 {
        let points = self.fixed_to(mover).flat_map(|body| &self.points[body]);
        let lowest = points.map(|(point, radius)| point.z - radius).fold(f64::INFINITY, f64::min);
        if lowest.is_finite() { lowest } else { self.dynamics.world_from_body[mover].translation.z }
    }

    /// From the root to `body`.
    fn way(&self, body: usize) -> Vec<usize> {
        let mut way: Vec<usize> = std::iter::successors(Some(body), |&at| self.model.bodies[at].parent).collect();
        way.reverse();
        way
    }

    /// Driven joints between the root and `body`.
    fn driven(&self, body: usize) -> usize {
        let is_driven = |&at: &usize| {
            let body = &self.model.bodies[at];
            body.nv() == 1 && self.model.dofs[body.v_index].actuated
        };
        self.way(body).iter().filter(|at| is_driven(at)).count()
    }

    /// The two feet, and why they are.
    fn feet(&self, wanted: &Wanted) -> Result<([usize; 2], String), Error> {
        let name = |body: usize| self.model.bodies[body].name.as_str();
        if !wanted.feet.is_empty() {
            let [first, second] = &wanted.feet[..] else {
                let problem = format!("found {} links; name two, as in --feet right_foot,left_foot", wanted.feet.len());
                return Err(Error::invalid("--feet", problem));
            };
            let index = |link: &str| {
                let known = || list(self.model.bodies.iter().map(|body| &body.name));
                let unknown =
                    || Error::invalid("--feet", format!("unknown link {}; valid are {}", quoted(link), known()));
                self.model.body_index(link).map(|body| self.mover[body]).ok_or_else(unknown)
            };
            let feet = [index(first)?, index(second)?];
            if feet[0] == feet[1] {
                let problem =
                    format!("{} and {} move together; name a link of each leg", quoted(first), quoted(second));
                return Err(Error::invalid("--feet", problem));
            }
            return Ok((feet, "named by --feet".to_owned()));
        }
        let moves_others = |mover: usize| {
            let carried =
                |body: usize| self.model.bodies[body].parent.is_some_and(|parent| self.mover[parent] == mover);
            (0..self.mover.len()).any(|body| self.mover[body] == body && body != mover && carried(body))
        };
        let root = self.model.root();
        let mut last: Vec<(usize, f64)> = (root + 1..self.mover.len())
            .filter(|&body| self.mover[body] == body && self.driven(body) >= 2 && !moves_others(body))
            .map(|body| (body, self.lowest(body)))
            .collect();
        last.sort_by(|a, b| a.1.total_cmp(&b.1));
        let heights = self.points.iter().flatten().map(|(point, _)| point.z).chain(last.iter().map(|foot| foot.1));
        let top = heights.chain([self.dynamics.com.z]).fold(f64::NEG_INFINITY, f64::max);
        let Some(&(first, lowest)) = last.first() else {
            let problem = "no last link has two driven joints above it, so that the robot has no legs; legwork adopts robots with two";
            return Err(Error::invalid("feet", problem));
        };
        let reach = LEVEL * (top - lowest);
        let pairs =
            |&&(body, height): &&(usize, f64)| height - lowest <= reach && self.driven(body) == self.driven(first);
        let level: Vec<usize> = last.iter().filter(pairs).map(|(body, _)| *body).collect();
        match level[..] {
            [first, second] => {
                let joints = self.driven(first);
                Ok(([first, second], format!("one of the two lowest last links, with {joints} driven joints above it")))
            }
            [only] => Err(Error::invalid(
                "feet",
                format!(
                    "{} is the lowest last link, and no other one of {} driven joints is level with it; name the feet: --feet {0},LINK",
                    name(only),
                    self.driven(only)
                ),
            )),
            _ => {
                let names = list(level.iter().map(|&body| name(body)));
                let problem = format!(
                    "{} last links are level and the lowest: {names}; legwork's controllers stand on two, name them: --feet A,B",
                    level.len()
                );
                Err(Error::invalid("feet", problem))
            }
        }
    }

    /// Puts the right foot first: by the names where they tell, else by the place.
    fn right_before_left(&self, feet: &mut [usize; 2]) {
        let side = |body: usize| {
            let name = self.model.bodies[body].name.to_ascii_lowercase();
            let starts = |word: &str, letter: &str| {
                name.contains(word) || name.split(|c: char| !c.is_ascii_alphabetic()).any(|part| part == letter)
            };
            (starts("right", "r"), starts("left", "l"))
        };
        let y = |body: usize| self.dynamics.world_from_body[body].translation.y;
        let swap = match feet.map(side) {
            [(true, false), (false, true)] => false,
            [(false, true), (true, false)] => true,
            _ => y(feet[0]) > y(feet[1]),
        };
        if swap {
            feet.swap(0, 1);
        }
    }

    /// The torso, and why it is.
    fn torso(&self, wanted: &Wanted, roles: &Roles, feet: [usize; 2]) -> Result<(usize, String), Error> {
        if let Some(link) = wanted.torso.as_ref().or(roles.torso.as_ref()) {
            let known = || list(self.model.bodies.iter().skip(self.model.root()).map(|body| &body.name));
            let unknown = || Error::invalid("torso", format!("unknown link {}; valid are {}", quoted(link), known()));
            let because =
                if wanted.torso.is_some() { "The torso that was named" } else { "The torso that the file names" };
            return self.model.body_index(link).map(|body| (body, because.to_owned())).ok_or_else(unknown);
        }
        let ways = feet.map(|foot| self.way(foot));
        let shared = ways[0].iter().zip(&ways[1]).take_while(|(a, b)| a == b).map(|(body, _)| *body);
        let hips = shared.last().map_or(self.model.root(), |body| self.mover[body]);
        let own: Vec<usize> = ways
            .iter()
            .flatten()
            .copied()
            .filter(|body| ways.iter().filter(|way| way.contains(body)).count() == 1)
            .collect();
        // What moves with the hips may be on the way to one foot only.
        let on_leg = |body: usize| self.way(body).iter().any(|at| own.contains(at) && self.mover[*at] != hips);
        let mass = |mover: usize| self.fixed_to(mover).map(|body| self.model.bodies[body].mass).sum::<f64>();
        let candidates =
            (self.model.root()..self.mover.len()).filter(|&body| self.mover[body] == body && !on_leg(body));
        let heaviest = candidates.max_by(|&a, &b| mass(a).total_cmp(&mass(b)).then(b.cmp(&a))).unwrap_or(hips);
        let because = format!("The heaviest link between the legs and above them, {:.3} kg", mass(heaviest));
        Ok((heaviest, because))
    }

    /// The contact points of a foot in its link's frame, and what they were found from.
    fn sole(&self, feet: [usize; 2], foot: usize, side_file: &str) -> Result<(Vec<Vector3<f64>>, String), Lacking> {
        let points: Vec<_> = self.fixed_to(foot).flat_map(|body| self.points[body].iter().copied()).collect();
        if points.is_empty() {
            let unread: Vec<_> = self.fixed_to(foot).flat_map(|body| &self.shapes[body].1).collect();
            let link = &self.model.bodies[foot].name;
            let why = match unread.len() {
                0 => "has no collision shape".to_owned(),
                _ => format!("has no collision shape that can be read ({})", list(unread)),
            };
            let problem = format!(
                "{why}, so that nothing tells where its sole is; write the corners of both soles into {side_file}"
            );
            return Err(Lacking {
                error: Error::invalid(format!("foot {}", quoted(link)), problem),
                lines: self.lines(feet),
            });
        }
        let bottom = points.iter().map(|(point, radius)| point.z - radius).fold(f64::INFINITY, f64::min);
        let touching: Vec<Vector3<f64>> = points
            .iter()
            .map(|(point, radius)| point - Vector3::z() * *radius)
            .filter(|point| point.z - bottom <= LAYER)
            .collect();
        let mut corners: Vec<Vector3<f64>> = Vec::new();
        for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let along = |point: &Vector3<f64>| x * point.x + y * point.y;
            let corner = touching.iter().copied().max_by(|a, b| along(a).total_cmp(&along(b)));
            // What is nearer to another corner than a point is wide is that corner.
            corners.extend(corner.filter(|corner| corners.iter().all(|other| (other - corner).norm() > POINT)));
        }
        let kinds: BTreeSet<&str> = self.fixed_to(foot).flat_map(|body| self.shapes[body].0.iter().copied()).collect();
        if let ([a, b, c, d], true) = (&corners[..], kinds.iter().any(|kind| !EXACT.contains(kind))) {
            // Four of the many corners of a mesh lie neither level nor square: the level rectangle within them does.
            let (back, front) = (a.x.max(b.x), c.x.min(d.x));
            let (right, left) = (a.y.max(c.y), b.y.min(d.y));
            let corner = |x, y| Vector3::new(x, y, bottom);
            corners = vec![corner(back, right), corner(back, left), corner(front, right), corner(front, left)];
        }
        let pose: &Placement = &self.dynamics.world_from_body[foot];
        let local = |point: &Vector3<f64>| pose.rotation.transpose() * (point - pose.translation);
        let from = format!("contact points are the lowest of its {}", list(kinds));
        Ok((corners.iter().map(local).collect(), from))
    }

    /// What a side file may say of two soles, with numbers to change.
    fn lines(&self, feet: [usize; 2]) -> String {
        let mut lines = "feet = [\"right\", \"left\"]\ncontacts = [\n".to_owned();
        for (foot, name) in feet.into_iter().zip(["right", "left"]) {
            for (index, [x, y]) in [[-0.05, -0.04], [-0.05, 0.04], [0.15, -0.04], [0.15, 0.04]].into_iter().enumerate()
            {
                let (number, link) = (index + 1, &self.model.bodies[foot].name);
                let _ = writeln!(
                    lines,
                    "  {{ name = \"{name}_{number}\", foot = \"{name}\", body = {link:?}, position_m = [{x:?}, {y:?}, -0.08] }},"
                );
            }
        }
        lines + "]\n"
    }

    /// Joints that move out of the x-z plane.
    fn sideways(&self) -> Vec<String> {
        let moving =
            self.model.bodies.iter().enumerate().skip(self.model.root() + 1).filter(|(_, body)| body.nv() == 1);
        let leaves = moving.filter(|(index, body)| {
            let axis = self.dynamics.world_from_body[*index].rotation
                * body.joint.axis().map_or(Vector3::y(), |axis| axis.into_inner());
            if self.model.dofs[body.v_index].rotational {
                libm::hypot(axis.x, axis.z) > 1e-4
            } else {
                axis.y.abs() > 1e-4
            }
        });
        leaves.map(|(_, body)| body.joint_name.clone()).collect()
    }
}

/// Points that a shape is the hull of, in the body's frame [m], once it has grown by the radius [m].
fn hull(geometry: &Geometry, read_mesh: ReadMesh<'_>) -> Option<(Vec<Vector3<f64>>, f64)> {
    if let Some(hull) = geometry.hull() {
        return Some(hull);
    }
    let points: Vec<Vector3<f64>> = match &geometry.shape {
        Shape::Mesh { file, scale } => {
            mesh_corners(file, &read_mesh(file)?).ok()?.iter().map(|corner| corner.component_mul(scale)).collect()
        }
        Shape::Cylinder { radius, half_length } => {
            let rim = |k: usize| libm::sincos(std::f64::consts::TAU * k as f64 / 32.0);
            let end = |k: usize| if k.is_multiple_of(2) { -half_length } else { *half_length };
            (0..64).map(|k| Vector3::new(radius * rim(k / 2).1, radius * rim(k / 2).0, end(k))).collect()
        }
        Shape::Ellipsoid { semi_axes } => {
            // Where planes of 26 directions touch it.
            let directions = (0..27)
                .map(|k| Vector3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)).add_scalar(-1.0));
            let touched = directions.filter(|direction| direction.norm() > 0.0).map(|direction| {
                let stretched = direction.component_mul(semi_axes);
                stretched.component_mul(semi_axes) / libm::sqrt(stretched.norm_squared())
            });
            touched.collect()
        }
        _ => return None,
    };
    (!points.is_empty()).then(|| (points.iter().map(|point| geometry.placement.point(point)).collect(), 0.0))
}

fn kind(shape: &Shape, collides: bool) -> &'static str {
    match shape {
        _ if !collides => "pictures, for it has no collision shapes",
        Shape::Sphere { .. } => "spheres",
        Shape::Capsule { .. } => "capsules",
        Shape::Cylinder { .. } => "cylinders",
        Shape::Box { .. } => "boxes",
        Shape::Ellipsoid { .. } => "ellipsoids",
        Shape::Mesh { .. } => "meshes",
    }
}
