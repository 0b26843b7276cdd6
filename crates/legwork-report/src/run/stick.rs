//! The stick figure: where its links, marks and forces are at a moment. Thesis Figure 6.3

use legwork::episode::Run;
use legwork::log::Field;
use legwork::terrain::Terrain;
use legwork_rbd::{Dynamics, Model};
use maud::{Markup, html};
use nalgebra::Vector3;

use super::figures::side;
use crate::charts::numbers::Px;
use crate::charts::svg::{self, Key, Symbol};

/// How far before its point a push ends, so that its tip is seen beside the mark of the centre of mass [px].
const SHORT: f64 = 8.0;

/// A point or a force in the x-z plane [m, N].
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
    /// where it carries none (and for the torso) to a tip at twice the distance of its centre of mass.
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
        // A foot with several contact points has a sole.
        for (k, pair) in model.contacts.windows(2).enumerate() {
            if pair[0].body == pair[1].body {
                new.links.push(([new.contacts[k], new.contacts[k + 1]], side(&model.bodies[pair[0].body].name)));
            }
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
    fn ends(&mut self, model: &Model, body: usize, joints: &[usize]) -> Vec<usize> {
        let children = (0..model.bodies.len()).filter(|&child| model.bodies[child].parent == Some(body));
        let children = children.map(|child| (joints[child], model.bodies[child].placement.translation));
        let contacts = model.contacts.iter().zip(&self.contacts).filter(|(contact, _)| contact.body == body);
        let contacts = contacts.map(|(contact, &point)| (point, contact.position));
        let far = |(point, place): (usize, Vector3<f64>)| (place.norm() > 1e-3).then_some(point);
        let mut ends: Vec<usize> = children.chain(contacts).filter_map(far).collect();
        let tip = 2.0 * model.bodies[body].com;
        if (ends.is_empty() || body == model.torso) && tip.norm() > 1e-3 {
            ends.push(self.add(body, tip));
        }
        ends
    }
}

/// Everything that is drawn of a moment.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    /// [s]
    pub(super) time: f64,
    /// The points of the skeleton [m].
    pub(super) points: Vec<Planar>,
    pub(super) com: Planar,
    pub(super) com_reference: Planar,
    /// The extrapolated centre of mass, on the ground.
    pub(super) xcom: Planar,
    /// References of the right and the left foot.
    pub(super) feet: [Planar; 2],
    /// The program's force on each contact point [N].
    pub(super) forces: Vec<Planar>,
    /// Force and place of each push; none while it does not act.
    pub(super) pushes: Vec<Option<[Planar; 2]>>,
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
        // Sideways directions are not drawn.
        let planar = |values: &[f64]| [values[0], values[d - 1]];
        dynamics.update(&run.model, log.get(index, Field::Q), log.get(index, Field::V));
        let points = skeleton.points.iter().map(|(body, place)| {
            let point = dynamics.world_from_body[*body].point(place);
            [point.x, point.z]
        });
        let (points, com, time) = (points.collect::<Vec<_>>(), planar(log.get(index, Field::Com)), log.time(index));
        let feet = log.get(index, Field::FeetReference);
        let xcom = log.get(index, Field::Xcom)[0];
        let pushes = run.scenario.pushes.iter().zip(&skeleton.pushed).map(|(push, place)| {
            let (sin, cos) = push.direction_deg.to_radians().sin_cos();
            let acts = (push.start_s..push.start_s + push.duration_s).contains(&(time + 1e-9));
            acts.then_some([[push.force_n * cos, push.force_n * sin], place.map_or(com, |place| points[place])])
        });
        Pose {
            time,
            com,
            com_reference: planar(log.get(index, Field::ComReference)),
            xcom: [xcom, ground.height_at(xcom)],
            feet: [planar(&feet[..d]), planar(&feet[3 * d..4 * d])],
            forces: log.get(index, Field::Grf).chunks_exact(d).map(planar).collect(),
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
        let height = |point: &Planar| point[1] - self.ground.height_at(point[0]);
        pose.points.iter().map(height).fold(0.01, f64::max)
    }

    /// How long a force is drawn [m/N]: the weight as half of the robot's height.
    pub(super) fn metres_per_newton(&mut self) -> f64 {
        0.5 * self.height() / (self.run.model.total_mass() * self.run.model.gravity).max(1e-9)
    }

    /// Width of a friction cone at its height [1]: as both its tangents.
    pub(super) fn cone(&self) -> [Planar; 2] {
        [-1.0, 1.0].map(|side: f64| {
            let ground = self.ground.base();
            let edge = ground.normal + side * ground.friction.min(5.0) * ground.tangents()[0];
            let unit = edge / edge.norm();
            [unit.x, unit.z]
        })
    }
}

/// How a pose is put on paper: pixels are `scale` times metres, with z up.
#[derive(Clone, Debug)]
pub(super) struct View {
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
    pub(super) fn new(poses: &mut Poses<'_>, scale: f64) -> Self {
        let (metres_per_newton, cone) = (poses.metres_per_newton(), poses.cone());
        let height = poses.height();
        Self { scale, thickness: 0.02 * height, metres_per_newton, cone, cone_length: 0.2 * height }
    }

    /// A point [px].
    pub(super) fn pixel(&self, [x, z]: Planar) -> Planar {
        [self.scale * x, -self.scale * z]
    }

    /// Where a force of `newtons` at `point` ends [px].
    fn tip(&self, point: Planar, newtons: Planar) -> Planar {
        let k = self.metres_per_newton;
        self.pixel([point[0] + k * newtons[0], point[1] + k * newtons[1]])
    }

    /// The pose. `animation.js` relies on the order of the elements: cones, links, joints, net force, forces, pushes, then
    /// marks of the feet's references, XcoM, CoM reference, CoM.
    pub(super) fn draw(&self, pose: &Pose, skeleton: &Skeleton, model: &Model) -> Markup {
        let contacts: Vec<Planar> = skeleton.contacts.iter().map(|&point| pose.points[point]).collect();
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
            @for ((point, force), contact) in contacts.iter().zip(&pose.forces).zip(&model.contacts) {
                path class={ "arrow " (side(&model.feet[contact.foot])) }
                    d=(svg::arrow(self.pixel(*point), self.tip(*point, *force))) {}
            }
            @for push in &pose.pushes {
                path class="arrow push" d=(push.map_or(String::new(), |[force, at]| self.push(force, at))) {}
            }
            @for (foot, class) in pose.feet.iter().zip(["right", "left"]) { (self.mark(*foot, class)) }
            (self.mark(pose.xcom, "xcom"))
            (self.mark(pose.com_reference, "reference"))
            (self.dot(pose.com))
        }
    }

    /// An arrow that ends a little before the point at which it pushes.
    fn push(&self, force: Planar, at: Planar) -> String {
        let (end, size) = (self.pixel(at), force[0].hypot(force[1]).max(1e-9));
        let before = |distance: f64| [end[0] - distance * force[0] / size, end[1] + distance * force[1] / size];
        svg::arrow(before(SHORT + self.scale * self.metres_per_newton * size), before(SHORT))
    }

    fn mark(&self, point: Planar, class: &str) -> Markup {
        html! { path class={ "mark " (class) } transform=(translate(self.pixel(point))) d=(svg::asterisk([0.0; 2], 7.0)) {} }
    }

    fn dot(&self, point: Planar) -> Markup {
        html! { circle class="dot" transform=(translate(self.pixel(point))) r="6" {} }
    }

    fn cone(&self, point: Planar) -> String {
        let edge = |[x, z]: Planar| self.pixel([point[0] + self.cone_length * x, point[1] + self.cone_length * z]);
        svg::path(&[vec![edge(self.cone[0]), self.pixel(point), edge(self.cone[1])]]) + "Z"
    }

    /// The ground from `from` to `to` [m] with a tick and a number at each multiple of `step`, `deep` pixels deep.
    pub(super) fn ground(&self, ground: &Terrain, [from, to]: Planar, step: f64, deep: f64) -> Markup {
        let at = |x: f64| self.pixel([x, ground.height_at(x)]);
        let surface: Vec<Planar> = ground.knots([from, to]).into_iter().map(at).collect();
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
fn is_loaded(force: Planar) -> bool {
    force[0].hypot(force[1]) > 1.0
}

/// The sum of the forces, and the contact points' mean as weighted with their sizes.
fn net_force(contacts: &[Planar], forces: &[Planar]) -> (Planar, Planar) {
    let (mut centre, mut net, mut weight) = ([0.0; 2], [0.0; 2], 0.0);
    for (point, force) in contacts.iter().zip(forces) {
        let size = force[0].hypot(force[1]);
        weight += size;
        for k in 0..2 {
            centre[k] += size * point[k];
            net[k] += force[k];
        }
    }
    (centre.map(|sum| sum / weight.max(1e-9)), net)
}

/// The legend of all stick figures.
pub(super) fn keys(run: &Run) -> Vec<Key> {
    let mut keys = vec![
        Key::new(Symbol::Dot, "dot", "CoM"),
        Key::new(Symbol::Asterisk, "reference", "CoM reference"),
        Key::new(Symbol::Asterisk, "xcom", "XcoM"),
        Key::new(Symbol::Asterisk, "right", "right foot reference"),
        Key::new(Symbol::Asterisk, "left", "left foot reference"),
        Key::new(Symbol::Arrow, "right", "force, right"),
        Key::new(Symbol::Arrow, "left", "force, left"),
        Key::new(Symbol::Arrow, "net", "net force"),
        Key::new(Symbol::Area, "cone", "friction cone"),
    ];
    if !run.scenario.pushes.is_empty() {
        keys.push(Key::new(Symbol::Arrow, "push", "push"));
    }
    keys
}
