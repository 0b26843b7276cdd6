//! The momentum task. Thesis (4.17): `A q̈ + Ȧ q̇ + s_m = ḣ_D`, angular then linear; its goal by (4.3), (4.4).

use std::ops::Range;

use legwork_rbd::Dynamics;
use nalgebra::{DMatrix, DVector, Vector3};

use super::super::Inputs;
use super::{Law, Part, Seen, damping};
use crate::settings::{Tracking, TrackingSettings};
use legwork_contract::feet::FeetMotion;
use legwork_contract::robot::Robot;

/// The task's name.
pub const NAME: &str = "momentum";

/// The rate of the centroidal momentum [Nm, N].
#[derive(Clone, Copy, Debug)]
pub struct Momentum;

impl Law for Momentum {
    fn name(&self) -> &'static str {
        NAME
    }

    fn parts(&self, model: &Robot) -> Vec<Part> {
        vec![
            Part::angular(model, "momentum rate, angular", "Nm", "", ".angular"),
            Part::linear(model, "momentum rate, linear", "N", "", ".linear"),
        ]
    }

    fn how(&self, tracking: &TrackingSettings) -> Tracking {
        tracking.momentum
    }

    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]) {
        let Seen { model, dynamics, v, reference, settings, .. } = *seen;
        let (angular, mass) = (model.angular_axes().len(), model.total_mass());

        // Thesis (4.3), as meant: k_D = P_theta (0 - A_k v).
        for (row, axis) in model.angular_axes().iter().enumerate() {
            let momentum: f64 = (0..v.len()).map(|j| dynamics.momentum_matrix[(row, j)] * v[j]).sum();
            goal[row] = -settings.angular_momentum_gain * momentum;
            if reference.moment != Vector3::zeros() {
                goal[row] += axis.dot(&reference.moment);
            }
        }

        // Thesis (4.4)
        let com = &reference.chest.point;
        let force = settings.com_gain * (com.position - dynamics.com)
            + damping(settings, mass, settings.com_gain) * (com.velocity - dynamics.com_velocity)
            + mass * com.acceleration;
        for (row, axis) in model.linear_axes().iter().enumerate() {
            let mut rate = axis.dot(&force);
            if let Some(cop) = reference.cop.filter(|_| axis.z == 0.0) {
                // The pendulum whose foot is the centre of pressure, with the vertical force that is asked for
                let arm = dynamics.com.z - cop.z;
                rate = (mass * model.gravity + force.z) / arm * axis.dot(&(dynamics.com - cop));
            }
            let limit = if axis.z == 0.0 { settings.max_horizontal_momentum_rate_n } else { f64::INFINITY };
            goal[angular + row] = rate.clamp(-limit, limit);
        }
    }

    fn motion<'a>(&'a self, dynamics: &'a Dynamics, _: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>) {
        (&dynamics.momentum_matrix, &dynamics.momentum_bias)
    }

    fn weigh(&self, inputs: &Inputs<'_>, goal: &[f64], add: &mut dyn FnMut(Range<usize>, f64)) {
        let (weights, angular) = (inputs.weights, inputs.model.angular_axes().len());
        add(0..angular, weights.angular_momentum_factor * weights.momentum);
        let vertical = weights.vertical_momentum_factor;
        // Together where they weigh the same, which is faster.
        let horizontal = if vertical == 1.0 { angular..goal.len() } else { angular..goal.len() - 1 };
        add(horizontal.clone(), weights.momentum);
        add(horizontal.end..goal.len(), vertical * weights.momentum);
    }
}
