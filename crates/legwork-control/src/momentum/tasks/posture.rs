//! The posture task: `S q̈ + s = q̈_D`, which draws actuated joints to a posture. It is ours; by default it has the joints that
//! the other tasks leave free ([`free_joints`]), and is not there where they leave none.
//!
//! What is asked for are accelerations: a joint is as stiff as what it moves is inert.

use std::ops::Range;

use legwork_contract::feet::FeetMotion;
use legwork_contract::redundancy::free_joints;
use legwork_contract::robot::Robot;
use legwork_rbd::Dynamics;
use nalgebra::{DMatrix, DVector};

use super::super::Inputs;
use super::{Law, Part, Seen, damping};
use crate::settings::{ControllerSettings, PostureTracking, Tracking, TrackingSettings};

/// The task's name.
pub const NAME: &str = "posture";
/// Gain [1/s²] and weight of joints that are given none.
const OF_OTHERS: [f64; 2] = [45.0, 1.0];

/// The accelerations of actuated joints [rad/s², m/s²].
#[derive(Clone, Debug)]
pub struct Posture {
    /// For each row, the joint's place in q and in v.
    places: Vec<[usize; 2]>,
    /// Where each is to be [rad, m]; none where that is the position of the first tick.
    given: Vec<Option<f64>>,
    /// Where each is to be [rad, m]; nothing before the first tick.
    nominal: Vec<f64>,
    /// `S`: a one in each row.
    jacobian: DMatrix<f64>,
    bias: DVector<f64>,
}

impl Posture {
    /// The task of `model`. A posture that the robot does not have is that of the first tick.
    pub fn new(settings: &ControllerSettings, model: &Robot) -> Self {
        let joints = match settings.tracking.posture {
            PostureTracking::Free => free_joints(model),
            _ => model.actuated().collect(),
        };
        let places: Vec<_> = joints.iter().map(|&dof| [model.bodies[model.dofs[dof].body].q_index, dof]).collect();
        let mut jacobian = DMatrix::zeros(places.len(), model.nv());
        for (row, &[_, dof]) in places.iter().enumerate() {
            jacobian[(row, dof)] = 1.0;
        }
        let given = settings.planner.posture.positions(model).unwrap_or_else(|_| vec![None; model.nv()]);
        let given = joints.iter().map(|&dof| given[dof]).collect();
        let (nominal, bias) = (Vec::with_capacity(places.len()), DVector::zeros(places.len()));
        Self { places, given, nominal, jacobian, bias }
    }
}

impl Law for Posture {
    fn name(&self) -> &'static str {
        NAME
    }

    fn parts(&self, model: &Robot) -> Vec<Part> {
        let part = |&[_, dof]: &[usize; 2]| {
            let joint = &model.dofs[dof];
            let (quantity, unit) = if joint.rotational { ("posture", "rad/s2") } else { ("posture", "m/s2") };
            Part { quantity, unit, of: joint.name.clone(), suffixes: vec![format!(".{}", joint.name)] }
        };
        self.places.iter().map(part).collect()
    }

    fn how(&self, tracking: &TrackingSettings) -> Tracking {
        match tracking.posture {
            PostureTracking::Off => Tracking::Off,
            PostureTracking::Free if self.places.is_empty() => Tracking::Off,
            PostureTracking::Free | PostureTracking::Cost => Tracking::Cost,
            PostureTracking::Equality => Tracking::Equality,
        }
    }

    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]) {
        if self.nominal.is_empty() {
            let places = self.given.iter().zip(&self.places);
            self.nominal.extend(places.map(|(given, &[position, _])| given.unwrap_or(seen.q[position])));
        }
        for ((goal, nominal), &[position, dof]) in goal.iter_mut().zip(&self.nominal).zip(&self.places) {
            let gain = seen.settings.posture_gain.of(&seen.model.dofs[dof].name, OF_OTHERS[0]);
            let damping = damping(seen.settings, 1.0, gain);
            *goal = gain * (nominal - seen.q[position]) - damping * seen.v[dof];
        }
    }

    fn motion<'a>(&'a self, _: &'a Dynamics, _: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>) {
        (&self.jacobian, &self.bias)
    }

    fn weigh(&self, inputs: &Inputs<'_>, _: &[f64], add: &mut dyn FnMut(Range<usize>, f64)) {
        for (row, &[_, dof]) in self.places.iter().enumerate() {
            add(row..row + 1, inputs.weights.posture.of(&inputs.model.dofs[dof].name, OF_OTHERS[1]));
        }
    }
}
