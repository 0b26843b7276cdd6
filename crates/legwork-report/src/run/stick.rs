//! The stick figure: where its links, marks and forces are at a moment, seen from a side. Thesis Figure 6.3

use legwork::Robot;
use legwork::episode::Run;
use legwork::log::Field;
use legwork::terrain::Terrain;
use legwork_rbd::{Body, Dynamics, Model};
use maud::{Markup, html};
use nalgebra::Vector3;

use super::figures::side;
use crate::charts::numbers::Px;
use crate::charts::svg::{self, Key, Symbol};

/// How far before its point a push ends, so that its tip is seen beside the mark of the centre of mass [px].
const SHORT: f64 = 8.0;

/// A point or a force in space [m, N].
pub(super) type Spatial = [f64; 3];
/// A point or a force as seen from a side: across and up [m, N], or on paper: across and down [px].
pub(super) type Planar = [f64; 2];

/// Points of the robot, and which of them are joined.
#[derive(Debug)]
pub(super) struct Skeleton {
    /// Body and place in its frame.
    points: Vec<(usize, Vector3<f64>)>,
    /// Two points each, and `right`, `left` or nothing.
    pub(super) links: Vec<([usize; 2], &'static str)>,
    /// Joints between links.
    pub(super) joints: Vec<usize>,
    /// The contact points, in the model's order.
    pub(super) contacts: Vec<usize>,
    /// Where each push acts: a point, or the centre of mass of all.
    pushed: Vec<Option<usize>>,
}

impl Skeleton {
    /// The bodies of `run`'s model as lines: from a body's joint to the joints and contact points that it carries, and
    /// where it carries none (and for the torso) to the end of the rod that has its mass, centre of mass and inertia.
    pub(super) fn new(run: &Run) -> Self {
        let model = &run.model;
        let mut new = Self { points: vec![], links: vec![], joints: vec![], contacts: vec![], pushed: vec![] };
        let joints: Vec<usize> = (0..model.bodies.len()).map(|body| new.add(body, Vector3::zeros())).collect();
        for contact in &model.contacts {
            let point = new.add(contact.body, contact.position);
            new.contacts.push(point);
        }
        for body in model.root()..model.bodies.len() {
            let ends = new.ends(model, body, &joints);
            let side = side(&model.bodies[body].name);
            new.links.extend(ends.into_iter().map(|end| ([joints[body], end], side)));
        }
        new.joints = joints[(model.root() + 1).min(joints.len())..].to_vec();
        for body in 0..model.bodies.len() {
            let sole = sole(model, body).into_iter().map(|ends| ends.map(|contact| new.contacts[contact]));
            new.links.extend(sole.map(|ends| (ends, side(&model.bodies[body].name))));
        }
        // The viewer stands on the right of the robot.
        new.links.sort_by_key(|(_, side)| ["left", "", "right"].iter().position(|known| known == side));
        for push in &run.scenario.pushes {
            let body = model.body_index(&push.at);
            let place = body.map(|body| new.add(body, model.bodies[body].com + Vector3::from(push.point_m)));
            new.pushed.push(place);
        }
        new
    }

    fn add(&mut self, body: usize, place: Vector3<f64>) -> usize {
        self.points.push((body, place));
        self.points.len() - 1
    }

    /// Where the lines of `body` lead from its joint.
    fn ends(&mut self, model: &Robot, body: usize, joints: &[usize]) -> Vec<usize> {
        let children = (0..model.bodies.len()).filter(|&child| model.bodies[child].parent == Some(body));
        let children = children.map(|child| (joints[child], model.bodies[child].placement.translation));
        let contacts = model.contacts.iter().zip(&self.contacts).filter(|(contact, _)| contact.body == body);
        let contacts = contacts.map(|(contact, &point)| (point, contact.position));
        let carried: Vec<(usize, Vector3<f64>)> = children.chain(contacts).collect();
        let far = |(point, place): &(usize, Vector3<f64>)| (place.norm() > 1e-3).then_some(*point);
        let mut ends: Vec<usize> = carried.iter().filter_map(far).collect();
        let tip = tip(&model.bodies[body]);
        if (carried.is_empty() || body == model.torso) && tip.norm() > 1e-3 {
            ends.push(self.add(body, tip));
        }
        ends
    }
}

/// The far end of the uniform rod from near a body's joint that has the body's mass, centre of mass and inertia about a
/// line across: a rod of the length l has m l²/12.
fn tip(body: &Body) -> Vector3<f64> {
    let distance = body.com.norm();
    if distance < 1e-3 || body.mass <= 0.0 {
        return body.com;
    }
    let along = body.com / distance;
    let across = 0.5 * (body.inertia.trace() - along.dot(&(body.inertia * along)));
    body.com + (3.0 * across.max(0.0) / body.mass).sqrt() * along
}

/// The outline of a body's contact points, from point to point around their middle: two contact points each.
fn sole(model: &Model, body: usize) -> Vec<[usize; 2]> {
    let mut points: Vec<usize> = (0..model.contacts.len()).filter(|&k| model.contacts[k].body == body).collect();
    let place = |k: usize| model.contacts[k].position;
    let middle = points.iter().map(|&k| place(k)).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let angle = |k: usize| (place(k).y - middle.y).atan2(place(k).x - middle.x);
    if points.len() > 2 {
        points.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    }
    match points[..] {
        [] | [_] => Vec::new(),
        [a, b] => vec![[a, b]],
        _ => (0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]).collect(),
    }
}

/// What is marked: its field, after how many vectors of it, its class and its name.
type Mark = (Field, usize, &'static str, &'static str);

/// What is marked of a run whose log has it, the last above the others.
const MARKS: [Mark; 4] = [
    (Field::FeetReference, 3, "left", "left foot reference"),
    (Field::FeetReference, 0, "right", "right foot reference"),
    (Field::Xcom, 0, "xcom", "XcoM"),
    (Field::ComReference, 0, "reference", "CoM reference"),
];

/// What is marked of `run`.
fn marks_of(run: &Run) -> impl DoubleEndedIterator<Item = &'static Mark> {
    MARKS.iter().filter(|(field, first, ..)| run.log.range(*field).len() > first * run.model.linear_axes().len())
}

/// The forces on contact points that the log of `run` has, and whose they are: those of the controller's program, else those of
/// the physics.
pub(super) fn forces_of(run: &Run) -> Option<(Field, &'static str)> {
    let known = [(Field::Grf, "program"), (Field::GrfSimulated, "physics")];
    known.into_iter().find(|(field, _)| run.log.has(*field))
}

/// Everything that is drawn of a moment.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    /// [s]
    pub(super) time: f64,
    /// The points of the skeleton [m].
    pub(super) points: Vec<Spatial>,
    pub(super) com: Spatial,
    /// What is marked besides, and its class.
    pub(super) marks: Vec<(Spatial, &'static str)>,
    /// The force on each contact point [N], of those that [`forces_of`] tells.
    pub(super) forces: Vec<Spatial>,
    /// Force and place of each push; none while it does not act.
    pub(super) pushes: Vec<Option<[Spatial; 2]>>,
}

/// Reads poses from a run's log.
#[derive(Debug)]
pub(super) struct Poses<'a> {
    pub(super) run: &'a Run,
    pub(super) skeleton: Skeleton,
    pub(super) ground: Terrain,
    dynamics: Dynamics,
}

impl<'a> Poses<'a> {
    pub(super) fn new(run: &'a Run) -> Self {
        Self {
            run,
            skeleton: Skeleton::new(run),
            ground: run.scenario.terrain(&run.model),
            dynamics: Dynamics::new(&run.model),
        }
    }

    /// The pose of record `index`.
    pub(super) fn at(&mut self, index: usize) -> Pose {
        let Self { run, skeleton, ground, dynamics } = self;
        let (log, d) = (&run.log, run.model.linear_axes().len());
        let spatial = |values: &[f64]| [values[0], if d == 3 { values[1] } else { 0.0 }, values[d - 1]];
        dynamics.update(&run.model, log.get(index, Field::Q), log.get(index, Field::V));
        let points = skeleton.points.iter().map(|(body, place)| {
            let point = dynamics.world_from_body[*body].point(place);
            [point.x, point.y, point.z]
        });
        let (points, com, time) = (points.collect::<Vec<_>>(), spatial(log.get(index, Field::Com)), log.time(index));
        let mark = |&(field, first, class, _): &Mark| {
            let values = &log.get(index, field)[first * d..];
            // The extrapolated centre of mass is on the ground.
            let on_ground = |x: f64, y: f64| [x, y, ground.height_at(x, y)];
            let place = match *values {
                [x] => on_ground(x, 0.0),
                [x, y] => on_ground(x, y),
                _ => spatial(values),
            };
            (place, class)
        };
        let force = |contact: usize| {
            forces_of(run).map_or([0.0; 3], |(field, _)| spatial(&log.get(index, field)[contact * d..]))
        };
        let pushes = run.scenario.pushes.iter().zip(&skeleton.pushed).map(|(push, place)| {
            let force: Spatial = (push.force_n * push.direction()).into();
            let acts = (push.start_s..push.start_s + push.duration_s).contains(&(time + 1e-9));
            acts.then_some([force, place.map_or(com, |place| points[place])])
        });
        Pose {
            time,
            com,
            marks: marks_of(run).map(mark).collect(),
            forces: (0..run.model.nc()).map(force).collect(),
            pushes: pushes.collect(),
            points,
        }
    }

    /// The robot's height at the start over the ground, at least 1 cm [m].
    pub(super) fn height(&mut self) -> f64 {
        if self.run.log.is_empty() {
            return 1.0;
        }
        let pose = self.at(0);
        let height = |point: &Spatial| point[2] - self.ground.height_at(point[0], point[1]);
        pose.points.iter().map(height).fold(0.01, f64::max)
    }

    /// How long a force is drawn [m/N]: the weight as half of the robot's height.
    pub(super) fn metres_per_newton(&mut self) -> f64 {
        0.5 * self.height() / (self.run.model.total_mass() * self.run.model.gravity).max(1e-9)
    }

    /// From where the robot is looked at: from its right, and in space from the front besides.
    pub(super) fn sides(&self) -> &'static [Side] {
        if self.run.model.is_planar() { &[Side::Right] } else { &[Side::Right, Side::Front] }
    }

    /// The edges of a friction cone as seen from a side, of length one.
    fn cone(&self, from: Side) -> [Planar; 2] {
        let ground = self.ground.base();
        [-1.0, 1.0].map(|side: f64| {
            let edge = ground.normal + side * ground.friction.min(5.0) * ground.tangents()[from as usize];
            let unit = edge / edge.norm();
            [unit[from as usize], unit.z]
        })
    }
}

/// From where the robot is looked at; its number is that of the axis that runs across the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// x runs to the right.
    Right = 0,
    /// From ahead of the robot: y, which is the robot's left, runs to the right.
    Front = 1,
}

impl Side {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Right => "from its right",
            Self::Front => "from the front",
        }
    }
}

/// How a pose is put on paper: pixels are `scale` times metres, with z up.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) side: Side,
    /// [px/m]
    pub(super) scale: f64,
    /// Width of a link [m].
    pub(super) thickness: f64,
    /// [m/N]
    pub(super) metres_per_newton: f64,
    /// The edges of a friction cone, of length one.
    pub(super) cone: [Planar; 2],
    /// Length of the cone's edges [m].
    pub(super) cone_length: f64,
}

impl View {
    pub(super) fn new(poses: &mut Poses<'_>, side: Side, scale: f64) -> Self {
        let (metres_per_newton, cone) = (poses.metres_per_newton(), poses.cone(side));
        let height = poses.height();
        Self { side, scale, thickness: 0.02 * height, metres_per_newton, cone, cone_length: 0.2 * height }
    }

    /// A point [px].
    pub(super) fn pixel(&self, point: Spatial) -> Planar {
        [self.scale * point[self.side as usize], -self.scale * point[2]]
    }

    /// Where a force of `newtons` at `point` ends [px].
    fn tip(&self, point: Spatial, newtons: Spatial) -> Planar {
        self.pixel([0, 1, 2].map(|k| point[k] + self.metres_per_newton * newtons[k]))
    }

    /// The pose. `animation.js` relies on the order of the elements: cones, links, joints, net force, forces, pushes,
    /// marks, CoM.
    pub(super) fn draw(&self, pose: &Pose, skeleton: &Skeleton, model: &Robot) -> Markup {
        let contacts: Vec<Spatial> = skeleton.contacts.iter().map(|&point| pose.points[point]).collect();
        let (centre, net) = net_force(&contacts, &pose.forces);
        let thickness = self.thickness * self.scale;
        html! {
            @for (point, force) in contacts.iter().zip(&pose.forces) {
                path class="cone" d=(if is_loaded(*force) { self.cone(*point) } else { String::new() }) {}
            }
            @for (ends, side) in &skeleton.links {
                path class={ "link " (side) } stroke-width=(Px(thickness))
                    d=(svg::path(&[ends.map(|end| self.pixel(pose.points[end])).to_vec()])) {}
            }
            @for &joint in &skeleton.joints {
                circle class="joint" transform=(translate(self.pixel(pose.points[joint]))) r=(Px(0.55 * thickness)) {}
            }
            path class="arrow net" d=(svg::arrow(self.pixel(centre), self.tip(centre, net))) {}
            @for ((point, force), &foot) in contacts.iter().zip(&pose.forces).zip(&model.foot_of) {
                path class={ "arrow " (side(&model.feet[foot])) }
                    d=(svg::arrow(self.pixel(*point), self.tip(*point, *force))) {}
            }
            @for push in &pose.pushes {
                path class="arrow push" d=(push.map_or(String::new(), |[force, at]| self.push(force, at))) {}
            }
            @for &(point, class) in &pose.marks { (self.mark(point, class)) }
            (self.dot(pose.com))
        }
    }

    /// An arrow that ends a little before the point at which it pushes.
    fn push(&self, force: Spatial, at: Spatial) -> String {
        let end = self.pixel(at);
        let [across, up] = [force[self.side as usize], force[2]];
        // What comes towards the viewer, or goes away, is no longer than what rounding leaves.
        let size = across.hypot(up);
        if size < 1e-6 * length(force) {
            return String::new();
        }
        let before = |distance: f64| [end[0] - distance * across / size, end[1] + distance * up / size];
        svg::arrow(before(SHORT + self.scale * self.metres_per_newton * size), before(SHORT))
    }

    fn mark(&self, point: Spatial, class: &str) -> Markup {
        html! { path class={ "mark " (class) } transform=(translate(self.pixel(point))) d=(svg::asterisk([0.0; 2], 7.0)) {} }
    }

    fn dot(&self, point: Spatial) -> Markup {
        html! { circle class="dot" transform=(translate(self.pixel(point))) r="6" {} }
    }

    fn cone(&self, point: Spatial) -> String {
        let [x, y] = self.pixel(point);
        let length = self.scale * self.cone_length;
        let edge = |[across, up]: Planar| [x + length * across, y - length * up];
        svg::path(&[vec![edge(self.cone[0]), [x, y], edge(self.cone[1])]]) + "Z"
    }

    /// The ground from `from` to `to` [m] with a tick and a number at each multiple of `step`, `deep` pixels deep. From the
    /// front it is that below a robot at `x` [m], from the right that at y = 0.
    pub(super) fn ground(&self, ground: &Terrain, x: f64, [from, to]: Planar, step: f64, deep: f64) -> Markup {
        let at = |across: f64| match self.side {
            Side::Right => self.pixel([across, 0.0, ground.height_at(across, 0.0)]),
            Side::Front => self.pixel([x, across, ground.height_at(x, across)]),
        };
        let knots = if self.side == Side::Right { ground.knots([from, to]) } else { vec![from, to] };
        let surface: Vec<Planar> = knots.into_iter().map(at).collect();
        let below = |[x, y]: Planar| [x, y + deep];
        let ends = [surface[surface.len() - 1], surface[0]].map(below);
        let ticks = crate::charts::numbers::multiples(from, to, step);
        html! {
            path class="ground" d={ (svg::path(&[surface.iter().copied().chain(ends).collect()])) "Z" } {}
            path class="surface" d={
                (svg::path(std::slice::from_ref(&surface)))
                @for &tick in &ticks { "M" (Px(at(tick)[0])) " " (Px(at(tick)[1])) "v5" }
            } {}
            g class="ticks" text-anchor="middle" {
                // A number that the edge would cut is left out.
                @for &tick in ticks.iter().filter(|tick| (**tick - from).min(to - **tick) * self.scale > 13.0) {
                    text x=(Px(at(tick)[0])) y=(Px(at(tick)[1] + 18.0)) { (crate::charts::numbers::tick_label(tick, step)) }
                }
            }
        }
    }
}

/// An SVG translation.
pub(super) fn translate([x, y]: Planar) -> String {
    format!("translate({} {})", Px(x), Px(y))
}

/// Whether a contact carries enough for its cone to be drawn.
fn is_loaded(force: Spatial) -> bool {
    length(force) > 1.0
}

fn length(vector: Spatial) -> f64 {
    Vector3::from(vector).norm()
}

/// The sum of the forces, and the contact points' mean as weighted with their sizes.
fn net_force(contacts: &[Spatial], forces: &[Spatial]) -> (Spatial, Spatial) {
    let (mut centre, mut net, mut weight) = ([0.0; 3], [0.0; 3], 0.0);
    for (point, force) in contacts.iter().zip(forces) {
        let size = length(*force);
        weight += size;
        for k in 0..3 {
            centre[k] += size * point[k];
            net[k] += force[k];
        }
    }
    (centre.map(|sum| sum / weight.max(1e-9)), net)
}

/// The legend of all stick figures.
pub(super) fn keys(run: &Run) -> Vec<Key> {
    let mut keys = vec![Key::new(Symbol::Dot, "dot", "CoM")];
    keys.extend(marks_of(run).rev().map(|(_, _, class, name)| Key::new(Symbol::Asterisk, class, name)));
    if forces_of(run).is_some() {
        keys.extend([
            Key::new(Symbol::Arrow, "right", "force on a right contact point"),
            Key::new(Symbol::Arrow, "left", "force on a left contact point"),
            Key::new(Symbol::Arrow, "net", "force on the robot"),
            Key::new(Symbol::Area, "cone", "friction cone"),
        ]);
    }
    if !run.scenario.pushes.is_empty() {
        keys.push(Key::new(Symbol::Arrow, "push", "push"));
    }
    keys
}

#[cfg(test)]
mod tests {
    use legwork::library;
    use nalgebra::Matrix3;

    use super::*;

    #[test]
    fn a_body_is_drawn_as_long_as_the_rod_that_it_is() {
        let model = library::load_model("planar_humanoid", None).expect("a built-in model");
        let mut body = model.bodies[model.torso].clone();
        // A rod of 0.8 m and 10 kg along a line off the axes.
        let along = Vector3::new(0.6, 0.0, 0.8);
        body.mass = 10.0;
        body.com = 0.4 * along;
        body.inertia = (Matrix3::identity() - along * along.transpose()) * (10.0 * 0.8 * 0.8 / 12.0);
        assert!((tip(&body) - 0.8 * along).norm() < 1e-12);
        // A heavier head moves the end up, though the centre of mass stays.
        let longer = Body { inertia: 2.0 * body.inertia, ..body.clone() };
        assert!(tip(&longer).norm() > 0.9);
        let point = Body { inertia: Matrix3::zeros(), ..body.clone() };
        assert!((tip(&point) - body.com).norm() < 1e-12);
    }

    #[test]
    fn only_bodies_that_carry_nothing_and_the_torso_have_ends_of_their_own() {
        let loaded = legwork::scenario_file::load("exo-sway", &["duration_s=0.002".to_owned()]).expect("built in");
        let (model, samples) = (loaded.model().expect("a model"), loaded.samples().expect("none"));
        let run = legwork::episode::run(&loaded.scenario, &model, &samples, |_| false).expect("it runs");
        let skeleton = Skeleton::new(&run);
        // The bodies' joints and the contact points come first: what is more is an end.
        let ends = &skeleton.points[model.bodies.len() + model.contacts.len()..];
        assert_eq!(ends.iter().map(|(body, _)| *body).collect::<Vec<_>>(), [model.torso]);
    }

    #[test]
    fn a_sole_is_outlined_from_corner_to_corner() {
        let model = library::load_model("exo18", None).expect("a built-in model");
        let body = model.contacts[0].body;
        let edges = sole(&model, body);
        let length = |[a, b]: [usize; 2]| (model.contacts[a].position - model.contacts[b].position).norm();
        let mut lengths: Vec<f64> = edges.into_iter().map(length).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths.iter().map(|length| (100.0 * length).round()).collect::<Vec<_>>(), [12.0, 12.0, 28.0, 28.0]);
        let feet = library::load_model("planar_humanoid_feet", None).expect("a built-in model");
        assert_eq!(sole(&feet, feet.contacts[0].body), [[0, 1]]);
        assert!(sole(&feet, feet.torso).is_empty());
    }
}
