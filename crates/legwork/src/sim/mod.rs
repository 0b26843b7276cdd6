//! The simulator: from torques to the next state, with rigid contacts (Appendix A) or a spring-damper ground.
//!
//! It knows nothing of the controller.

pub mod actuators;
pub mod audit;
pub mod contact_solver;
pub mod linear;
pub mod push;
pub mod sensors;
pub mod spring_damper;
mod velocity;

use legwork_rbd::{Dynamics, Model};

use crate::contact::GroundPlane;
use crate::error::Error;
use crate::scenario::{Integrator, Scenario, SimulationSettings};
use actuators::Actuators;
use audit::Audit;
use contact_solver::Report;
use push::Pushes;
use velocity::VelocityStep;

/// The simulated robot and its ground.
#[derive(Clone, Debug)]
pub struct Simulator {
    settings: SimulationSettings,
    model: Model,
    ground: GroundPlane,
    pushes: Pushes,
    actuators: Actuators,
    step: u64,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Dynamics in the present state.
    state: Dynamics,
    /// Dynamics where the step's forces are evaluated, for the midpoint rule.
    midpoint: Dynamics,
    velocity: VelocityStep,
    forces: Vec<f64>,
    applied: Vec<f64>,
    force: Vec<f64>,
    push_force: Vec<f64>,
    damping: Vec<f64>,
    next_q: Vec<f64>,
    next_v: Vec<f64>,
    audit: Audit,
}

impl Simulator {
    /// A robot at rest in `q` [rad, m] on the ground of `scenario`.
    ///
    /// # Errors
    /// A push that names an unknown body.
    pub fn new(scenario: &Scenario, model: &Model, q: &[f64]) -> Result<Self, Error> {
        let settings = scenario.simulation.clone();
        let (nv, d, contacts) = (model.nv(), model.linear_axes().len(), model.contacts.len());
        let ground = GroundPlane::of(&scenario.ground, model);
        let mut simulator = Self {
            pushes: Pushes::new(&scenario.pushes, model)?,
            actuators: Actuators::new(&settings.actuators, model, settings.period_s),
            step: 0,
            q: q.to_vec(),
            v: vec![0.0; nv],
            state: Dynamics::new(model),
            midpoint: Dynamics::new(model),
            velocity: VelocityStep::new(model),
            forces: vec![0.0; contacts * d],
            applied: vec![0.0; model.actuated().count()],
            force: vec![0.0; nv],
            push_force: vec![0.0; nv],
            damping: vec![0.0; nv],
            next_q: q.to_vec(),
            next_v: vec![0.0; nv],
            audit: Audit::new(),
            settings,
            model: model.clone(),
            ground,
        };
        simulator.state.update(model, &simulator.q, &simulator.v);
        simulator.audit.begin(&simulator.state, model.total_mass());
        Ok(simulator)
    }

    /// Time [s], to the nanosecond: 0.695 and not 0.6950000000000001.
    pub fn time(&self) -> f64 {
        (self.step as f64 * self.settings.period_s * 1e9).round() / 1e9
    }

    /// Joint positions [rad, m].
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Joint velocities [rad/s, m/s].
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// Dynamics in the present state.
    pub fn dynamics(&self) -> &Dynamics {
        &self.state
    }

    /// The ground.
    pub fn ground(&self) -> &GroundPlane {
        &self.ground
    }

    /// Whether a contact point counts as touching the ground.
    pub fn touching(&self, contact: usize) -> bool {
        self.ground.gap(&self.state.contact_positions[contact]) <= self.settings.contact.flag_height_m
    }

    /// Contact forces of the latest step along the model's linear axes, averaged over it [N].
    pub fn contact_forces(&self) -> &[f64] {
        &self.forces
    }

    /// Torques of the actuated joints in the latest step [Nm].
    pub fn applied_torques(&self) -> &[f64] {
        &self.applied
    }

    /// Sweeps and residual of the latest contact solve.
    pub fn contact_report(&self) -> Report {
        self.velocity.report
    }

    /// The books of the run so far.
    pub fn audit(&self) -> &Audit {
        &self.audit
    }

    /// One step with the wanted torques of the actuated joints [Nm]. Returns false, and leaves the state as it was,
    /// where the numbers are out of bounds.
    pub fn step(&mut self, wanted: &[f64]) -> bool {
        let time = self.time();
        let Self { settings, model, ground, state, midpoint, velocity, .. } = self;
        let dt = settings.period_s;
        let is_midpoint = settings.integrator == Integrator::Midpoint;
        self.applied.copy_from_slice(self.actuators.apply(wanted));

        // Moreau 1988: forces and contacts are those of the configuration half a step ahead.
        let ahead = if is_midpoint { 0.5 * dt } else { 0.0 };
        let rest = dt - ahead;
        model.integrate(&self.q, &self.v, ahead, &mut self.next_q);
        if is_midpoint {
            midpoint.update(model, &self.next_q, &self.v);
        }
        let dynamics = if is_midpoint { &*midpoint } else { &*state };
        if !velocity.prepare(settings, model, ground, dynamics, &self.v, rest) {
            return false;
        }
        self.push_force.fill(0.0);
        let push = self.pushes.add(model, dynamics, time, dt, &mut self.push_force);
        self.damping.copy_from_slice(dynamics.damping.as_slice());
        for j in 0..self.v.len() {
            self.force[j] = self.push_force[j] - dynamics.bias[j] - dynamics.damping[j];
        }
        for (dof, torque) in model.actuated().zip(&self.applied) {
            self.force[dof] += torque;
        }
        velocity.solve(settings, ground.friction, &self.v, &self.force, &mut self.next_v);

        if is_midpoint && in_bounds(&self.next_v) {
            // Velocity-dependent forces are the mean of those before and after the step. Without it every impact would
            // leave an error of first order in the momentum.
            for j in 0..self.v.len() {
                self.force[j] += 0.5 * (midpoint.bias[j] + midpoint.damping[j]);
                self.damping[j] *= 0.5;
            }
            midpoint.update(model, &self.next_q, &self.next_v);
            for j in 0..self.v.len() {
                self.force[j] -= 0.5 * (midpoint.bias[j] + midpoint.damping[j]);
                self.damping[j] += 0.5 * midpoint.damping[j];
            }
            velocity.solve(settings, ground.friction, &self.v, &self.force, &mut self.next_v);
        }
        if !in_bounds(&self.next_v) {
            return false;
        }

        velocity.world_forces(model, ground, dt, &mut self.forces);
        self.audit.account(&audit::Step {
            model,
            ground,
            period: dt,
            v: [&self.v, &self.next_v],
            torque: &self.applied,
            damping: &self.damping,
            push,
            push_force: &self.push_force,
            rows: &velocity.rows,
            impulse: &velocity.contacts.impulse,
            report: velocity.report,
        });
        model.integrate(&self.next_q, &self.next_v, rest, &mut self.q);
        self.v.copy_from_slice(&self.next_v);
        self.step += 1;
        state.update(model, &self.q, &self.v);
        self.audit.close(state, ground);
        true
    }
}

/// Whether velocities are numbers that physics could have made.
fn in_bounds(v: &[f64]) -> bool {
    v.iter().all(|value| value.is_finite() && value.abs() < 1e6)
}
