//! The torso's task. Thesis (4.20): `S_c q̈ + s_a = α_D`, along the angular axes; its goal by (4.6).

use std::ops::Range;

use legwork_rbd::{Dynamics, Model};
use nalgebra::{DMatrix, DVector};

use super::super::Inputs;
use super::{Law, Part, Seen, damping};
use crate::generator::TurnReference;
use crate::settings::{Tracking, TrackingSettings};
use legwork_contract::feet::{FeetMotion, rotated, rotation_error};

/// The task's name.
pub const NAME: &str = "torso";

/// The angular acceleration of the torso [rad/s²].
#[derive(Clone, Copy, Debug)]
pub struct Torso;

impl Law for Torso {
    fn name(&self) -> &'static str {
        NAME
    }

    fn parts(&self, model: &Model) -> Vec<Part> {
        vec![Part::angular(model, "torso", "rad/s2", "", "")]
    }

    fn how(&self, tracking: &TrackingSettings) -> Tracking {
        tracking.torso
    }

    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]) {
        let Seen { model, dynamics, v, settings, .. } = *seen;
        // Thesis (4.6), as meant: position and velocity of the torso, not its acceleration. In space its rotation vector.
        let torso = &seen.reference.chest.turn;
        let turn = if model.is_planar() {
            TurnReference::pitch(torso.in_plane()[0] - dynamics.torso_angle(model), 0.0, 0.0).turn
        } else {
            rotation_error(&dynamics.world_from_body[model.torso].rotation, &rotated(&torso.turn))
        };
        let torso_damping = damping(settings, 1.0, settings.torso_gain);
        for (row, axis) in model.angular_axes().iter().enumerate() {
            let velocity: f64 = (0..v.len()).map(|j| dynamics.torso_jacobian[(row, j)] * v[j]).sum();
            goal[row] = settings.torso_gain * axis.dot(&turn)
                + torso_damping * (axis.dot(&torso.velocity) - velocity)
                + axis.dot(&torso.acceleration);
        }
    }

    fn motion<'a>(&'a self, dynamics: &'a Dynamics, _: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>) {
        (&dynamics.torso_jacobian, &dynamics.torso_bias)
    }

    fn weigh(&self, inputs: &Inputs<'_>, goal: &[f64], add: &mut dyn FnMut(Range<usize>, f64)) {
        let weights = inputs.weights;
        // A torso that leans far or turns fast is righted first.
        let urgency = weights.torso_urgency_s4 * goal.iter().map(|goal| goal * goal).sum::<f64>();
        add(0..goal.len(), (1.0 + urgency * urgency) * weights.torso);
    }
}
