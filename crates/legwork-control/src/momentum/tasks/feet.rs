//! The feet's task. Thesis (4.19): `J q̈ + J̇ q̇ + s_f = p̈_D`, in the rows of [`FeetMotion`]; its goal by (4.5).

use std::ops::Range;

use legwork_rbd::Dynamics;
use nalgebra::{DMatrix, DVector};

use super::super::Inputs;
use super::{Law, Part, Seen, damping};
use crate::settings::{Tracking, TrackingSettings};
use legwork_contract::feet::{FeetMotion, FootRows, Footing, rotated, rotation_error};
use legwork_contract::robot::Robot;

/// The task's name.
pub const NAME: &str = "feet";

/// The accelerations of the feet [rad/s², m/s²].
#[derive(Clone, Copy, Debug)]
pub struct Feet;

impl Law for Feet {
    fn name(&self) -> &'static str {
        NAME
    }

    fn parts(&self, model: &Robot) -> Vec<Part> {
        let mut parts = Vec::new();
        for (foot, rows) in model.feet.iter().zip(FootRows::of(model)) {
            if !rows.angular.is_empty() {
                parts.push(Part::angular(model, "feet, turn", "rad/s2", foot, &format!(".{foot}_angular")));
            }
            parts.push(Part::linear(model, "feet", "m/s2", foot, &format!(".{foot}")));
        }
        parts
    }

    fn how(&self, tracking: &TrackingSettings) -> Tracking {
        tracking.feet
    }

    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]) {
        let Seen { model, feet, reference, settings, .. } = *seen;
        let foot_damping = damping(settings, 1.0, settings.foot_gain);
        let rotation_damping = damping(settings, 1.0, settings.foot_rotation_gain);
        for (foot, wanted) in reference.feet.iter().enumerate().take(model.feet.len()) {
            let (rows, point, turn) = (feet.rows(foot), &wanted.point, &wanted.turn);
            let acceleration = settings.foot_gain * (point.position - feet.position[foot])
                + foot_damping * (point.velocity - feet.velocity[foot])
                + point.acceleration;
            for (row, axis) in rows.linear.clone().zip(model.linear_axes()) {
                goal[row] = axis.dot(&acceleration);
            }
            if rows.angular.is_empty() {
                continue;
            }
            let acceleration = settings.foot_rotation_gain * rotation_error(&feet.rotation[foot], &rotated(&turn.turn))
                + rotation_damping * (turn.velocity - feet.angular_velocity[foot])
                + turn.acceleration;
            for (row, axis) in rows.angular.clone().zip(model.angular_axes()) {
                goal[row] = axis.dot(&acceleration);
            }
        }
    }

    fn motion<'a>(&'a self, _: &'a Dynamics, feet: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>) {
        (&feet.jacobian, &feet.bias)
    }

    fn weigh(&self, inputs: &Inputs<'_>, _: &[f64], add: &mut dyn FnMut(Range<usize>, f64)) {
        let weights = inputs.weights;
        for foot in 0..inputs.model.feet.len() {
            let rows = inputs.feet.rows(foot);
            let (rotation, place) = match inputs.footing.get(foot) {
                Some(Footing::Swings) => (weights.swing_rotation_factor, weights.swing_feet_factor),
                Some(Footing::Rolls) => (weights.rolling_rotation_factor, 1.0),
                Some(Footing::Trails) => (weights.trailing_rotation_factor, 1.0),
                _ => (1.0, 1.0),
            };
            add(rows.angular.clone(), rotation * weights.foot_rotation);
            add(rows.linear.clone(), place * weights.feet);
        }
    }
}
