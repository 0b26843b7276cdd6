//! The torso's task. Thesis (4.20): `S_c q̈ + s_a = α_D`, along the angular axes; its goal by (4.6).

use std::ops::Range;

use legwork_rbd::Dynamics;
use nalgebra::{DMatrix, DVector};

use super::super::Inputs;
use super::{Law, Part, Seen, damping};
use crate::generator::TurnReference;
use crate::settings::{Tracking, TrackingSettings};
use legwork_contract::feet::{FeetMotion, rotated, rotation_error};
use legwork_contract::robot::Robot;

/// The task's name.
pub const NAME: &str = "torso";

/// The angular acceleration of the torso [rad/s²].
#[derive(Clone, Debug)]
pub struct Torso {
    /// `S_c`, and `Ṡ_c q̇`.
    jacobian: DMatrix<f64>,
    bias: DVector<f64>,
}

impl Torso {
    /// The task of `robot`.
    pub fn new(robot: &Robot) -> Self {
        let rows = robot.angular_axes().len();
        Self { jacobian: DMatrix::zeros(rows, robot.nv()), bias: DVector::zeros(rows) }
    }
}

impl Law for Torso {
    fn name(&self) -> &'static str {
        NAME
    }

    fn parts(&self, model: &Robot) -> Vec<Part> {
        vec![Part::angular(model, "torso", "rad/s2", "", "")]
    }

    fn how(&self, tracking: &TrackingSettings) -> Tracking {
        tracking.torso
    }

    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]) {
        let Seen { model, dynamics, q, v, settings, .. } = *seen;
        dynamics.angular_jacobian(model, model.torso, &mut self.jacobian);
        let bias = dynamics.angular_bias(model.torso);
        // Thesis (4.6), as meant: position and velocity of the torso, not its acceleration. In space its rotation vector.
        let torso = &seen.reference.chest.turn;
        let turn = if model.is_planar() {
            TurnReference::pitch(torso.in_plane()[0] - model.torso_angle(dynamics, q), 0.0, 0.0).turn
        } else {
            rotation_error(&model.torso_rotation(dynamics), &rotated(&torso.turn))
        };
        let torso_damping = damping(settings, 1.0, settings.torso_gain);
        for (row, axis) in model.angular_axes().iter().enumerate() {
            self.bias[row] = axis.dot(&bias);
            let velocity: f64 = (0..v.len()).map(|j| self.jacobian[(row, j)] * v[j]).sum();
            goal[row] = settings.torso_gain * axis.dot(&turn)
                + torso_damping * (axis.dot(&torso.velocity) - velocity)
                + axis.dot(&torso.acceleration);
        }
    }

    fn motion<'a>(&'a self, _: &'a Dynamics, _: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>) {
        (&self.jacobian, &self.bias)
    }

    fn weigh(&self, inputs: &Inputs<'_>, goal: &[f64], add: &mut dyn FnMut(Range<usize>, f64)) {
        let weights = inputs.weights;
        // A torso that leans far or turns fast is righted first.
        let urgency = weights.torso_urgency_s4 * goal.iter().map(|goal| goal * goal).sum::<f64>();
        add(0..goal.len(), (1.0 + urgency * urgency) * weights.torso);
    }
}
