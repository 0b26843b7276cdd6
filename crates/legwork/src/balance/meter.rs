//! The measures of balance of a log's records, whatever the robot's feet.

use legwork_rbd::{Dynamics, Model};

use super::{
    Capture, Centroidal, Planar, StepLimits, centre_of_pressure, centroidal_moment_pivot, margin, zero_moment_point,
};
use crate::generator::xcom::{eigenfrequency, xcom};
use crate::log::{Field, Log};
use crate::robot::Robot;
use crate::scenario::{GeneratorKind, Push, Scenario};
use crate::terrain::Terrain;

/// The measures of a record, along x [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Centre of pressure; none in flight.
    pub cop: Option<f64>,
    /// Centroidal moment pivot; none in flight.
    pub cmp: Option<f64>,
    /// Zero-moment point of the momentum rate that the planner wants, fictitious where it is outside of the support; none
    /// where the planner wants no force on the ground.
    pub wanted_zmp: Option<f64>,
    /// Extrapolated centre of mass, with the pendulum as long as the centre of mass is high.
    pub xcom: f64,
    /// Support and capturability; none where no contact point touches the ground.
    pub capture: Option<Capture>,
}

impl Measures {
    /// How far the XcoM is inside of the base of support [m].
    pub fn margin(&self) -> Option<f64> {
        self.capture.map(|capture| margin(capture.support, self.xcom))
    }

    /// Steps needed to come to a stop; none where no number is enough, or without a support.
    pub fn steps(&self) -> Option<u32> {
        self.capture.and_then(|capture| capture.steps(self.xcom))
    }
}

/// Place and momentum of the robot as a whole at a time [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    time: f64,
    com: Planar,
    momentum: Centroidal,
}

impl Moment {
    /// That of `model` at `time` [s] in the state of `dynamics`, with the joint velocities `v`. Allocates nothing.
    pub fn new(time: f64, model: &Model, dynamics: &Dynamics, v: &[f64]) -> Self {
        let com = [dynamics.com.x, dynamics.com.z];
        Self { time, com, momentum: Centroidal::momentum(model, dynamics, v) }
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
    /// The foot of each contact point.
    foot_of: Vec<usize>,
}

impl Meter {
    /// A meter for `model` in `scenario`.
    pub fn new(scenario: &Scenario, model: &Robot) -> Self {
        Self {
            ground: scenario.terrain(model),
            believed: scenario.believed_terrain(model),
            weight: model.total_mass() * model.gravity,
            gravity: model.gravity,
            limits: StepLimits::of(scenario),
            pushes: scenario.pushes.clone(),
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
        let planar = move |values: &[f64]| [values[0], values[axes - 1]];
        let com = planar(get(Field::Com));
        let ground = self.ground.line_at(com[0]);
        let points = get(Field::Feet).chunks_exact(axes).map(planar);
        let forces = get(Field::GrfSimulated).chunks_exact(axes).map(planar);
        let force = forces.clone().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]);
        let wanted = Some(get(Field::MomentumRateGoal)).filter(|rows| !rows.is_empty()).map(Centroidal::of_rows);
        let wanted = wanted.map(|rate| rate.of_ground(self.weight, &Centroidal::default()));
        let omega = eigenfrequency(self.gravity, com[1] - ground.at(com[0]));
        Measures {
            cop: centre_of_pressure(&ground, self.weight, points.zip(forces)),
            cmp: centroidal_moment_pivot(&ground, self.weight, com, force),
            wanted_zmp: wanted.and_then(|wanted| zero_moment_point(&ground, self.weight, com, &wanted)),
            xcom: xcom(com[0], get(Field::ComVelocity)[0], omega),
            capture: self.capture(get, omega),
        }
    }

    fn capture<'a>(&self, get: impl Fn(Field) -> &'a [f64], omega: f64) -> Option<Capture> {
        let axes = get(Field::Com).len();
        let touching = get(Field::Touching);
        let stands = |foot: usize| self.foot_of.iter().zip(touching).any(|(of, flag)| *of == foot && *flag > 0.5);
        let points = || get(Field::Feet).chunks_exact(axes).map(|point| point[0]).enumerate();
        let support = ends(points().filter(|(k, _)| touching[*k] > 0.5).map(|(_, x)| x))?;
        let feet = ends(points().filter(|(k, _)| stands(self.foot_of[*k])).map(|(_, x)| x))?;
        let landing_s = match *get(Field::Swing) {
            [foot, since] if foot >= 0.0 => (self.limits.swing_s - (get(Field::Time)[0] - since)).max(0.0),
            _ => self.limits.double_support_s + self.limits.swing_s,
        };
        Some(Capture { omega, support, feet, limits: self.limits, landing_s })
    }

    /// The zero-moment point [m] of how the robot moved from one moment to another, `dynamics` being those of the second;
    /// none in flight. Allocates nothing.
    pub fn zmp(&self, model: &Model, dynamics: &Dynamics, before: &Moment, after: &Moment) -> Option<f64> {
        let period = after.time - before.time;
        if period <= 0.0 {
            return None;
        }
        let com = std::array::from_fn(|axis| 0.5 * (before.com[axis] + after.com[axis]));
        let rate = |from: f64, to: f64| (to - from) / period;
        let (from, to) = (&before.momentum, &after.momentum);
        let rate = Centroidal {
            linear: std::array::from_fn(|axis| rate(from.linear[axis], to.linear[axis])),
            angular: rate(from.angular, to.angular),
        };
        let push = Centroidal::of_pushes(&self.pushes, model, dynamics, [before.time, after.time]);
        let ground = self.ground.line_at(com[0]);
        zero_moment_point(&ground, self.weight, com, &rate.of_ground(self.weight, &push))
    }

    /// The zero-moment point of each record of `log` up to the next [m]; none in flight and for the last.
    pub fn zmps(&self, model: &Model, log: &Log) -> Vec<Option<f64>> {
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
    pub fn xcom_reference<'a>(&self, get: impl Fn(Field) -> &'a [f64]) -> Option<f64> {
        if let Some(reference) = get(Field::Balance).get(1) {
            return Some(*reference);
        }
        let (axes, com) = (get(Field::Com).len(), get(Field::ComReference));
        let place = com.get(..=axes)?;
        let omega = eigenfrequency(self.gravity, place[axes - 1] - self.believed.height_at(place[0]));
        Some(xcom(place[0], place[axes], omega))
    }
}

impl StepLimits {
    /// What the steps of `scenario` may be at the most: one that stands, sways or lifts a foot takes none.
    pub fn of(scenario: &Scenario) -> Self {
        let reference = scenario.fitted_reference();
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

/// Smallest and largest of `places`.
fn ends(places: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    places.fold(None, |ends, x| Some(ends.map_or([x, x], |[low, high]: [f64; 2]| [low.min(x), high.max(x)])))
}
