//! The posture task: `S q̈ + s = q̈_D`, which draws the actuated joints to the posture of the first tick. It is ours, and there
//! only where `controller.tracking.posture` says so: for robots whose other tasks leave joints free.

use std::ops::Range;

use legwork_contract::feet::FeetMotion;
use legwork_contract::robot::Robot;
use legwork_rbd::{Dynamics, Model};
use nalgebra::{DMatrix, DVector};

use super::super::Inputs;
use super::{Law, Part, Seen, damping};
use crate::settings::{Tracking, TrackingSettings};

/// The task's name.
pub const NAME: &str = "posture";

/// The accelerations of the actuated joints [rad/s², m/s²].
#[derive(Clone, Debug)]
pub struct Posture {
    /// For each row, the joint's place in q and in v.
    places: Vec<[usize; 2]>,
    /// The joints' positions in the first tick [rad, m]; none before it.
    nominal: Vec<f64>,
    /// `S`: a one in each row.
    jacobian: DMatrix<f64>,
    bias: DVector<f64>,
}

impl Posture {
    /// The task of `model`.
    pub fn new(model: &Model) -> Self {
        let places: Vec<_> = model.actuated().map(|dof| [model.bodies[model.dofs[dof].body].q_index, dof]).collect();
        let mut jacobian = DMatrix::zeros(places.len(), model.nv());
        for (row, &[_, dof]) in places.iter().enumerate() {
            jacobian[(row, dof)] = 1.0;
        }
        let (nominal, bias) = (Vec::with_capacity(places.len()), DVector::zeros(places.len()));
        Self { places, nominal, jacobian, bias }
    }
}

impl Law for Posture {
    fn name(&self) -> &'static str {
        NAME
    }

    fn parts(&self, model: &Robot) -> Vec<Part> {
        let part = |dof: usize| {
            let joint = &model.dofs[dof];
            let (quantity, unit) = if joint.rotational { ("posture", "rad/s2") } else { ("posture", "m/s2") };
            Part { quantity, unit, of: joint.name.clone(), suffixes: vec![format!(".{}", joint.name)] }
        };
        model.actuated().map(part).collect()
    }

    fn how(&self, tracking: &TrackingSettings) -> Tracking {
        tracking.posture
    }

    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]) {
        if self.nominal.is_empty() {
            self.nominal.extend(self.places.iter().map(|&[position, _]| seen.q[position]));
        }
        let gain = seen.settings.posture_gain;
        let damping = damping(seen.settings, 1.0, gain);
        for ((goal, nominal), &[position, dof]) in goal.iter_mut().zip(&self.nominal).zip(&self.places) {
            *goal = gain * (nominal - seen.q[position]) - damping * seen.v[dof];
        }
    }

    fn motion<'a>(&'a self, _: &'a Dynamics, _: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>) {
        (&self.jacobian, &self.bias)
    }

    fn weigh(&self, inputs: &Inputs<'_>, goal: &[f64], add: &mut dyn FnMut(Range<usize>, f64)) {
        add(0..goal.len(), inputs.weights.posture);
    }
}
