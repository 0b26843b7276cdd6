//! The measures of balance of a log's records, whatever the robot's feet.

use legwork_rbd::{Dynamics, Model};

use nalgebra::Vector3;

use super::support::{along, ends, way_out};
use super::{
    Capture, Centroidal, Point, StepLimits, centre_of_pressure, centroidal_moment_pivot, margin, zero_moment_point,
};
use crate::feet::FeetMotion;
use crate::generator::xcom::{eigenfrequency, xcom};
use crate::log::{Field, Log};
use crate::robot::Robot;
use crate::scenario::{GeneratorKind, Push, Scenario};
use crate::sim::push::Timetable;
use crate::terrain::Terrain;

/// The measures of a record [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Centre of pressure; none in flight.
    pub cop: Option<Point>,
    /// Centroidal moment pivot; none in flight.
    pub cmp: Option<Point>,
    /// Zero-moment point of the momentum rate that the planner wants, fictitious where it is outside of the support; none
    /// where the planner wants no force on the ground.
    pub wanted_zmp: Option<Point>,
    /// Extrapolated centre of mass, with the pendulum as long as the centre of mass is high.
    pub xcom: Point,
    /// Support and capturability along the way out of the support; none where no contact point touches the ground.
    pub capture: Option<Capture>,
}

impl Measures {
    /// How far the XcoM is inside of the base of support: the distance to its nearest edge, negative outside [m].
    pub fn margin(&self) -> Option<f64> {
        self.capture.map(|capture| margin(capture.support, capture.along(self.xcom)))
    }

    /// Steps needed to come to a stop; none where no number is enough, or without a support.
    pub fn steps(&self) -> Option<u32> {
        self.capture.and_then(|capture| capture.steps(capture.along(self.xcom)))
    }
}

/// Place and momentum of the robot as a whole at a time [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    time: f64,
    com: Vector3<f64>,
    momentum: Centroidal,
}

impl Moment {
    /// That of `model` at `time` [s] in the state of `dynamics`, with the joint velocities `v`. Allocates nothing.
    pub fn new(time: f64, model: &Model, dynamics: &Dynamics, v: &[f64]) -> Self {
        Self { time, com: dynamics.com, momentum: Centroidal::momentum(model, dynamics, v) }
    }
}

/// Measures the balance of a robot in a scenario.
#[derive(Clone, Debug)]
pub struct Meter {
    ground: Terrain,
    /// The ground that the controller believes in.
    believed: Terrain,
    weight: f64,
    gravity: f64,
    limits: StepLimits,
    pushes: Vec<Push>,
    timetable: Timetable,
    /// The foot of each contact point.
    foot_of: Vec<usize>,
    /// The contact points at the heel, then those at the toe, of each foot; none for a planar robot.
    ends: Vec<[Vec<usize>; 2]>,
}

impl Meter {
    /// A meter for `model` in `scenario`.
    pub fn new(scenario: &Scenario, model: &Robot) -> Self {
        let feet = FeetMotion::new(model);
        let spatial = if model.is_planar() { 0 } else { model.feet.len() };
        Self {
            ends: (0..spatial).map(|foot| feet.ends(foot).clone()).collect(),
            ground: scenario.terrain(model),
            believed: scenario.believed_terrain(model),
            weight: model.total_mass() * model.gravity,
            gravity: model.gravity,
            limits: StepLimits::of(scenario, model),
            pushes: scenario.pushes.clone(),
            timetable: Timetable::new(&scenario.pushes),
            foot_of: model.foot_of.clone(),
        }
    }

    /// The measures of record `index` of `log`. Allocates nothing.
    pub fn at(&self, log: &Log, index: usize) -> Measures {
        self.of(|field| log.get(index, field))
    }

    /// The measures of a record whose values are those that `get` gives. Allocates nothing.
    pub fn of<'a>(&self, get: impl Fn(Field) -> &'a [f64]) -> Measures {
        let axes = get(Field::Com).len();
        let com = vector(get(Field::Com));
        let ground = self.ground.plane_at(com.x, com.y);
        let points = get(Field::Feet).chunks_exact(axes).map(vector);
        let forces = get(Field::GrfSimulated).chunks_exact(axes).map(vector);
        let force = forces.clone().fold(Vector3::zeros(), |sum, force| sum + force);
        let wanted = Some(get(Field::MomentumRateGoal)).filter(|rows| !rows.is_empty()).map(Centroidal::of_rows);
        let wanted = wanted.map(|rate| rate.of_ground(self.weight, &Centroidal::default()));
        let omega = eigenfrequency(self.gravity, com.z - ground.z);
        let velocity = vector(get(Field::ComVelocity));
        let xcom = [xcom(com.x, velocity.x, omega), xcom(com.y, velocity.y, omega)];
        Measures {
            cop: centre_of_pressure(&ground, self.weight, points.zip(forces)),
            cmp: centroidal_moment_pivot(&ground, self.weight, &com, force),
            wanted_zmp: wanted.and_then(|wanted| zero_moment_point(&ground, self.weight, &com, &wanted)),
            xcom,
            capture: self.capture(&get, omega, self.way_out(&get, xcom)),
        }
    }

    /// The direction in which the XcoM is nearest to leaving the base of support, or has left it: that of x in the plane.
    fn way_out<'a>(&self, get: impl Fn(Field) -> &'a [f64], xcom: Point) -> Point {
        if get(Field::Com).len() == 2 {
            return [1.0, 0.0];
        }
        let touching = get(Field::Touching).iter().zip(get(Field::Feet).chunks_exact(3));
        let support = touching.filter(|(flag, _)| **flag > 0.5).map(|(_, point)| [point[0], point[1]]);
        way_out(support, xcom).unwrap_or_else(|| self.ahead(get))
    }

    /// The walking direction in a record whose values are those that `get` gives, a horizontal unit vector: the feet's, from their
    /// heels to their toes; that of x in the plane, and where feet have no length. Allocates nothing.
    pub fn ahead<'a>(&self, get: impl Fn(Field) -> &'a [f64]) -> Point {
        let middle = |points: &Vec<usize>| -> Vector3<f64> {
            points.iter().map(|&point| vector(&get(Field::Feet)[3 * point..][..3])).sum::<Vector3<f64>>()
                / points.len() as f64
        };
        let way: Vector3<f64> = self.ends.iter().map(|[heel, toe]| middle(toe) - middle(heel)).sum();
        let length = libm::hypot(way.x, way.y);
        if length > 1e-6 { [way.x / length, way.y / length] } else { [1.0, 0.0] }
    }

    /// Support and capturability along the unit direction `way` in a record whose values are those that `get` gives; none where no
    /// contact point touches the ground. Allocates nothing.
    pub fn capture_along<'a>(&self, get: impl Fn(Field) -> &'a [f64], way: Point) -> Option<Capture> {
        let com = vector(get(Field::Com));
        self.capture(&get, eigenfrequency(self.gravity, com.z - self.ground.height_at(com.x, com.y)), way)
    }

    fn capture<'a>(&self, get: impl Fn(Field) -> &'a [f64], omega: f64, way: Point) -> Option<Capture> {
        let axes = get(Field::Com).len();
        let touching = get(Field::Touching);
        let stands = |foot: usize| self.foot_of.iter().zip(touching).any(|(of, flag)| *of == foot && *flag > 0.5);
        let place = |point: &[f64]| if axes == 2 { point[0] } else { along(way, [point[0], point[1]]) };
        let points = || get(Field::Feet).chunks_exact(axes).map(place).enumerate();
        let support = ends(points().filter(|(k, _)| touching[*k] > 0.5).map(|(_, x)| x))?;
        let feet = ends(points().filter(|(k, _)| stands(self.foot_of[*k])).map(|(_, x)| x))?;
        let limits = if axes == 2 { self.limits } else { self.limits.seen_along(along(way, self.ahead(&get))) };
        let landing_s = match *get(Field::Swing) {
            [foot, since] if foot >= 0.0 => (self.limits.swing_s - (get(Field::Time)[0] - since)).max(0.0),
            _ => self.limits.double_support_s + self.limits.swing_s,
        };
        Some(Capture { way, omega, support, feet, limits, landing_s })
    }

    /// The zero-moment point [m] of how the robot moved from one moment to another, `dynamics` being those of the second;
    /// none in flight. Allocates nothing.
    pub fn zmp(&mut self, model: &Model, dynamics: &Dynamics, before: &Moment, after: &Moment) -> Option<Point> {
        let period = after.time - before.time;
        if period <= 0.0 {
            return None;
        }
        let com = 0.5 * (before.com + after.com);
        let (from, to) = (&before.momentum, &after.momentum);
        let rate =
            Centroidal { linear: (to.linear - from.linear) / period, angular: (to.angular - from.angular) / period };
        let times = [before.time, after.time];
        let pushes = self.timetable.acting(times).iter().map(|&push| &self.pushes[push]);
        let push = Centroidal::of_pushes(pushes, model, dynamics, times);
        let ground = self.ground.plane_at(com.x, com.y);
        zero_moment_point(&ground, self.weight, &com, &rate.of_ground(self.weight, &push))
    }

    /// The zero-moment point of each record of `log` up to the next [m]; none in flight and for the last.
    pub fn zmps(&mut self, model: &Model, log: &Log) -> Vec<Option<Point>> {
        let mut dynamics = Dynamics::new(model);
        let mut before = None;
        let mut zmps = Vec::with_capacity(log.len());
        for index in 0..log.len() {
            let v = log.get(index, Field::V);
            dynamics.update(model, log.get(index, Field::Q), v);
            let moment = Moment::new(log.time(index), model, &dynamics, v);
            if let Some(before) = before.replace(moment) {
                zmps.push(self.zmp(model, &dynamics, &before, &moment));
            }
        }
        zmps.resize(log.len(), None);
        zmps
    }

    /// Where the XcoM should be in a record whose values are those that `get` gives [m]: as the walker plans it, else as the CoM's
    /// reference has it; none without a reference. Allocates nothing.
    pub fn xcom_reference<'a>(&self, get: impl Fn(Field) -> &'a [f64]) -> Option<Point> {
        if let Some(reference) = get(Field::Balance).get(1) {
            return Some([*reference, *get(Field::Balance).get(9).unwrap_or(&0.0)]);
        }
        let (axes, com) = (get(Field::Com).len(), get(Field::ComReference));
        let [place, velocity] = [vector(com.get(..axes)?), vector(com.get(axes..2 * axes)?)];
        let omega = eigenfrequency(self.gravity, place.z - self.believed.height_at(place.x, place.y));
        Some([xcom(place.x, velocity.x, omega), xcom(place.y, velocity.y, omega)])
    }
}

impl StepLimits {
    /// What the steps of `scenario` may be at the most: one that stands, sways or lifts a foot takes none.
    pub fn of(scenario: &Scenario, model: &Robot) -> Self {
        let reference = scenario.fitted_reference(model);
        match reference.generator {
            // A foot comes no further than that from where it was, hence from the other one.
            GeneratorKind::Steps => Self {
                longest: [reference.step.max_length_m; 2],
                swing_s: reference.step.duration_s,
                double_support_s: 0.0,
            },
            GeneratorKind::Walker => {
                let walker = reference.walker;
                Self {
                    longest: [walker.longest_back_m, walker.longest_m],
                    swing_s: walker.shortest_swing_s,
                    double_support_s: walker.double_support_s,
                }
            }
            GeneratorKind::Stance => Self { longest: [0.0; 2], swing_s: f64::INFINITY, double_support_s: 0.0 },
        }
    }
}

/// The vector of components along a model's linear axes: two in the plane, three in space.
fn vector(parts: &[f64]) -> Vector3<f64> {
    Vector3::new(parts[0], if parts.len() == 3 { parts[1] } else { 0.0 }, parts[parts.len() - 1])
}
