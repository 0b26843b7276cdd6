//! The motion reference planner (thesis 4.3.2): from references to goals for momentum rate and accelerations.

use legwork_rbd::{Dynamics, Model};
use nalgebra::{DVector, Vector3};

use crate::generator::Reference;
use crate::settings::{Damping, PlannerSettings};
use legwork_contract::feet::{FeetMotion, FootRows, pitched, rotation_error};

/// What the quadratic program should achieve in this tick.
#[derive(Clone, Debug)]
pub struct MotionGoal {
    /// `h_D`: desired rate of the centroidal momentum, in the rows of the momentum matrix [Nm, N].
    pub momentum_rate: DVector<f64>,
    /// `p_D`: desired accelerations of the feet, in the rows of [`FeetMotion`] [rad/s², m/s²].
    pub foot_acceleration: DVector<f64>,
    /// `alpha_D`: desired angular acceleration of the torso along the model's angular axes [rad/s²].
    pub torso_acceleration: DVector<f64>,
}

/// A turn about −y as a vector.
fn about_y(angle: f64) -> Vector3<f64> {
    Vector3::new(0.0, -angle, 0.0)
}

/// The planner with its gains.
#[derive(Clone, Debug)]
pub struct MotionReferencePlanner {
    settings: PlannerSettings,
    mass: f64,
    com_damping: f64,
    foot_damping: f64,
    foot_rotation_damping: f64,
    torso_damping: f64,
    goal: MotionGoal,
}

impl MotionReferencePlanner {
    /// A planner for `model`.
    pub fn new(settings: &PlannerSettings, model: &Model) -> Self {
        let (angular, linear) = (model.angular_axes().len(), model.linear_axes().len());
        let mass = model.total_mass();
        // Thesis 6.3.7: "D = sqrt(2 m P)" is printed as critical; critical is 2 sqrt(m P).
        let damping = |inertia: f64, gain: f64| match settings.damping {
            Damping::Printed => libm::sqrt(2.0 * inertia * gain),
            Damping::Critical => 2.0 * libm::sqrt(inertia * gain),
        };
        Self {
            settings: settings.clone(),
            mass,
            com_damping: damping(mass, settings.com_gain),
            foot_damping: damping(1.0, settings.foot_gain),
            foot_rotation_damping: damping(1.0, settings.foot_rotation_gain),
            torso_damping: damping(1.0, settings.torso_gain),
            goal: MotionGoal {
                momentum_rate: DVector::zeros(angular + linear),
                foot_acceleration: DVector::zeros(FootRows::count(model)),
                torso_acceleration: DVector::zeros(angular),
            },
        }
    }

    /// The goals for the state in `dynamics` and `feet`; `v` are the joint velocities [rad/s, m/s].
    pub fn plan(
        &mut self,
        model: &Model,
        dynamics: &Dynamics,
        feet: &FeetMotion,
        v: &[f64],
        reference: &Reference,
    ) -> &MotionGoal {
        let (angular, linear) = (model.angular_axes().len(), model.linear_axes());
        let settings = &self.settings;
        let goal = &mut self.goal;

        // Thesis (4.3), as meant: k_D = P_theta (0 - A_k v).
        for (row, axis) in model.angular_axes().iter().enumerate() {
            let momentum: f64 = (0..v.len()).map(|j| dynamics.momentum_matrix[(row, j)] * v[j]).sum();
            goal.momentum_rate[row] = -settings.angular_momentum_gain * momentum;
            if reference.angular_momentum_rate != 0.0 {
                goal.momentum_rate[row] += axis.dot(&about_y(reference.angular_momentum_rate));
            }
        }

        // Thesis (4.4)
        let com = &reference.chest.point;
        let force = settings.com_gain * (com.position - dynamics.com)
            + self.com_damping * (com.velocity - dynamics.com_velocity)
            + self.mass * com.acceleration;
        for (row, axis) in linear.iter().enumerate() {
            let mut rate = axis.dot(&force);
            if let Some(cop) = reference.cop.filter(|_| axis.x != 0.0) {
                // The pendulum whose foot is the centre of pressure, with the vertical force that is asked for
                let arm = dynamics.com.z - reference.ground_height;
                rate = (self.mass * model.gravity + force.z) / arm * (dynamics.com.x - cop);
            }
            let limit = if axis.z == 0.0 { settings.max_horizontal_momentum_rate_n } else { f64::INFINITY };
            goal.momentum_rate[angular + row] = rate.clamp(-limit, limit);
        }

        // Thesis (4.5)
        for (foot, wanted) in reference.feet.iter().enumerate().take(model.feet.len()) {
            let (rows, point, angle) = (feet.rows(foot), &wanted.point, &wanted.angle);
            let acceleration = settings.foot_gain * (point.position - feet.position[foot])
                + self.foot_damping * (point.velocity - feet.velocity[foot])
                + point.acceleration;
            for (row, axis) in rows.linear.clone().zip(linear) {
                goal.foot_acceleration[row] = axis.dot(&acceleration);
            }
            if rows.angular.is_empty() {
                continue;
            }
            let acceleration = settings.foot_rotation_gain
                * rotation_error(&feet.rotation[foot], &pitched(angle.angle))
                + self.foot_rotation_damping * (about_y(angle.velocity) - feet.angular_velocity[foot])
                + about_y(angle.acceleration);
            for (row, axis) in rows.angular.clone().zip(model.angular_axes()) {
                goal.foot_acceleration[row] = axis.dot(&acceleration);
            }
        }

        // Thesis (4.6), as meant: position and velocity of the torso, not its acceleration. In space its rotation vector.
        let torso = &reference.chest.angle;
        let turn = if model.is_planar() {
            about_y(torso.angle - dynamics.torso_angle(model))
        } else {
            rotation_error(&dynamics.world_from_body[model.torso].rotation, &pitched(torso.angle))
        };
        for (row, axis) in model.angular_axes().iter().enumerate() {
            let velocity: f64 = (0..v.len()).map(|j| dynamics.torso_jacobian[(row, j)] * v[j]).sum();
            goal.torso_acceleration[row] = settings.torso_gain * axis.dot(&turn)
                + self.torso_damping * (axis.dot(&about_y(torso.velocity)) - velocity)
                + axis.dot(&about_y(torso.acceleration));
        }
        goal
    }

    /// The latest goals.
    pub fn goal(&self) -> &MotionGoal {
        &self.goal
    }
}
