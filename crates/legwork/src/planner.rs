//! The motion reference planner (thesis 4.3.2): from references to goals for momentum rate and accelerations.

use legwork_rbd::{Dynamics, Model};
use nalgebra::DVector;

use crate::reference::Reference;
use crate::scenario::{Damping, PlannerSettings};

/// What the quadratic program should achieve in this tick.
#[derive(Clone, Debug)]
pub struct MotionGoal {
    /// `h_D`: desired rate of the centroidal momentum, in the rows of the momentum matrix [Nm, N].
    pub momentum_rate: DVector<f64>,
    /// `p_D`: desired accelerations of the contact points, stacked along the model's linear axes [m/s²].
    pub foot_acceleration: DVector<f64>,
    /// `alpha_D`: desired angular acceleration of the torso [rad/s²].
    pub torso_acceleration: f64,
}

/// The planner with its gains.
#[derive(Clone, Debug)]
pub struct MotionReferencePlanner {
    settings: PlannerSettings,
    mass: f64,
    com_damping: f64,
    foot_damping: f64,
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
            torso_damping: damping(1.0, settings.torso_gain),
            goal: MotionGoal {
                momentum_rate: DVector::zeros(angular + linear),
                foot_acceleration: DVector::zeros(linear * model.contacts.len()),
                torso_acceleration: 0.0,
            },
        }
    }

    /// The goals for the state in `dynamics`; `v` are the joint velocities [rad/s, m/s].
    pub fn plan(&mut self, model: &Model, dynamics: &Dynamics, v: &[f64], reference: &Reference) -> &MotionGoal {
        let (angular, linear) = (model.angular_axes().len(), model.linear_axes());
        let settings = &self.settings;
        let goal = &mut self.goal;

        // Thesis (4.3), as meant: k_D = P_theta (0 - A_k v).
        for row in 0..angular {
            let momentum: f64 = (0..v.len()).map(|j| dynamics.momentum_matrix[(row, j)] * v[j]).sum();
            goal.momentum_rate[row] = -settings.angular_momentum_gain * momentum;
        }

        // Thesis (4.4)
        let com = &reference.chest.point;
        let force = settings.com_gain * (com.position - dynamics.com)
            + self.com_damping * (com.velocity - dynamics.com_velocity)
            + self.mass * com.acceleration;
        for (row, axis) in linear.iter().enumerate() {
            let rate = axis.dot(&force);
            let limit = if axis.z == 0.0 { settings.max_horizontal_momentum_rate_n } else { f64::INFINITY };
            goal.momentum_rate[angular + row] = rate.clamp(-limit, limit);
        }

        // Thesis (4.5)
        for (contact, point) in model.contacts.iter().enumerate() {
            let foot = &reference.feet[point.foot].point;
            let acceleration = settings.foot_gain * (foot.position - dynamics.contact_positions[contact])
                + self.foot_damping * (foot.velocity - dynamics.contact_velocities[contact])
                + foot.acceleration;
            for (row, axis) in linear.iter().enumerate() {
                goal.foot_acceleration[contact * linear.len() + row] = axis.dot(&acceleration);
            }
        }

        // Thesis (4.6), as meant: position and velocity of the torso, not its acceleration.
        let torso = &reference.chest.angle;
        let velocity: f64 = (0..v.len()).map(|j| dynamics.torso_jacobian[(0, j)] * v[j]).sum();
        goal.torso_acceleration = settings.torso_gain * (torso.angle - dynamics.torso_angle(model))
            + self.torso_damping * (torso.velocity - velocity)
            + torso.acceleration;
        goal
    }

    /// The latest goals.
    pub fn goal(&self) -> &MotionGoal {
        &self.goal
    }
}
