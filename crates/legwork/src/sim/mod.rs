//! The simulator: from torques to the next state, with rigid contacts (Appendix A) or a spring-damper ground.
//!
//! It knows nothing of the controller.

pub mod actuators;
pub mod audit;
pub mod batch;
mod contact_law;
pub mod contact_solver;
mod elastic;
pub mod model_error;
pub mod push;
pub mod sensors;
mod simultaneous;
pub mod spring_damper;
mod square;
mod tree_factor;
mod velocity;

use std::sync::Arc;

use legwork_rbd::{Dynamics, Model};

use crate::error::Error;
use crate::scenario::{Integrator, Scenario, SimulationSettings};
use crate::terrain::Terrain;
use actuators::Actuators;
use audit::Audit;
use contact_solver::Report;
use elastic::Elastic;
use push::Pushes;
use velocity::VelocityStep;

/// The simulated robot and its ground.
#[derive(Clone, Debug)]
pub struct Simulator {
    body: Body,
    velocity: Velocity,
}

/// The step's equation in the plane or in space.
#[derive(Clone, Debug)]
enum Velocity {
    Planar(VelocityStep<2, 3>),
    Spatial(VelocityStep<3, 6>),
}

/// All but the step's equation.
#[derive(Clone, Debug)]
struct Body {
    settings: SimulationSettings,
    model: Arc<Model>,
    actuated: Vec<usize>,
    ground: Terrain,
    pushes: Pushes,
    elastic: Elastic,
    actuators: Actuators,
    step: u64,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Dynamics in the present state.
    state: Dynamics,
    /// Dynamics where the step's forces are evaluated, for the midpoint rule; its first two stages only.
    midpoint: Dynamics,
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
    /// A push that names an unknown body; a spring or stop at a joint that is too stiff for the time step.
    pub fn new(scenario: &Scenario, model: &Model, q: &[f64]) -> Result<Self, Error> {
        Self::shared(scenario, Arc::new(model.clone()), q)
    }

    /// As [`Simulator::new`], with a model that many robots share.
    ///
    /// # Errors
    /// Those of [`Simulator::new`].
    pub fn shared(scenario: &Scenario, model: Arc<Model>, q: &[f64]) -> Result<Self, Error> {
        let settings = scenario.simulation.clone();
        let (nv, d, contacts) = (model.nv(), model.linear_axes().len(), model.contacts.len());
        let actuated: Vec<usize> = model.actuated().collect();
        let state = Dynamics::new(&model);
        let ground = Terrain::of(scenario, &model);
        let mut velocity = if model.is_planar() {
            Velocity::Planar(VelocityStep::new(&model, &state, &ground))
        } else {
            Velocity::Spatial(VelocityStep::new(&model, &state, &ground))
        };
        let mut body = Body {
            ground,
            pushes: Pushes::new(&scenario.pushes, &model)?,
            elastic: Elastic::new(&model),
            actuators: Actuators::new(&settings.actuators, &model, settings.period_s),
            step: 0,
            q: q.to_vec(),
            v: vec![0.0; nv],
            midpoint: state.clone(),
            state,
            forces: vec![0.0; contacts * d],
            applied: vec![0.0; actuated.len()],
            actuated,
            force: vec![0.0; nv],
            push_force: vec![0.0; nv],
            damping: vec![0.0; nv],
            next_q: q.to_vec(),
            next_v: vec![0.0; nv],
            audit: Audit::new(),
            settings,
            model,
        };
        body.state.update(&body.model, &body.q, &body.v);
        body.audit.begin(&body.state, body.model.total_mass());
        match &mut velocity {
            Velocity::Planar(velocity) => body.check_springs(velocity)?,
            Velocity::Spatial(velocity) => body.check_springs(velocity)?,
        }
        Ok(Self { body, velocity })
    }

    /// Time [s], to the nanosecond: 0.695 and not 0.6950000000000001.
    pub fn time(&self) -> f64 {
        self.body.time()
    }

    /// Joint positions [rad, m].
    pub fn q(&self) -> &[f64] {
        &self.body.q
    }

    /// Joint velocities [rad/s, m/s].
    pub fn v(&self) -> &[f64] {
        &self.body.v
    }

    /// Dynamics in the present state.
    pub fn dynamics(&self) -> &Dynamics {
        &self.body.state
    }

    /// The ground.
    pub fn ground(&self) -> &Terrain {
        &self.body.ground
    }

    /// Whether a contact point counts as touching the ground.
    pub fn touching(&self, contact: usize) -> bool {
        self.body.ground.gap(&self.body.state.contact_positions[contact]) <= self.body.settings.contact.flag_height_m
    }

    /// Contact forces of the latest step along the model's linear axes, averaged over it [N].
    pub fn contact_forces(&self) -> &[f64] {
        &self.body.forces
    }

    /// Torques of the actuated joints in the latest step [Nm].
    pub fn applied_torques(&self) -> &[f64] {
        &self.body.applied
    }

    /// Sweeps and residual of the latest contact solve.
    pub fn contact_report(&self) -> Report {
        match &self.velocity {
            Velocity::Planar(velocity) => velocity.report,
            Velocity::Spatial(velocity) => velocity.report,
        }
    }

    /// The books of the run so far.
    pub fn audit(&self) -> &Audit {
        &self.body.audit
    }

    /// One step with the wanted torques of the actuated joints [Nm]. Returns false, and leaves the state as it was,
    /// where the numbers are out of bounds.
    pub fn step(&mut self, wanted: &[f64]) -> bool {
        match &mut self.velocity {
            Velocity::Planar(velocity) => self.body.step(velocity, wanted),
            Velocity::Spatial(velocity) => self.body.step(velocity, wanted),
        }
    }
}

impl Body {
    fn time(&self) -> f64 {
        (self.step as f64 * self.settings.period_s * 1e9).round() / 1e9
    }

    fn check_springs<const D: usize, const K: usize>(&self, velocity: &mut VelocityStep<D, K>) -> Result<(), Error> {
        if self.elastic.is_empty() || !velocity.factor(&self.state) {
            return Ok(());
        }
        self.elastic.check(&self.model, self.settings.period_s, velocity)
    }

    fn step<const D: usize, const K: usize>(&mut self, velocity: &mut VelocityStep<D, K>, wanted: &[f64]) -> bool {
        let time = self.time();
        let Self { settings, model, ground, state, midpoint, .. } = self;
        let dt = settings.period_s;
        let is_midpoint = settings.integrator == Integrator::Midpoint;
        self.applied.copy_from_slice(self.actuators.apply(wanted));

        // Moreau 1988: forces and contacts are those of the configuration half a step ahead.
        let ahead = if is_midpoint { 0.5 * dt } else { 0.0 };
        let rest = dt - ahead;
        model.integrate(&self.q, &self.v, ahead, &mut self.next_q);
        if is_midpoint {
            midpoint.update_position(model, &self.next_q);
            midpoint.update_bias(model, &self.v);
        }
        let dynamics = if is_midpoint { &*midpoint } else { &*state };
        if !velocity.prepare(settings, ground, dynamics, rest) {
            return false;
        }
        if !self.elastic.is_empty() {
            let q = if is_midpoint { &self.next_q } else { &self.q };
            self.audit.springs(self.elastic.share(model, q, dt, velocity));
        }
        self.push_force.fill(0.0);
        let push = self.pushes.add(dynamics, time, dt, &mut self.push_force);
        self.damping.copy_from_slice(dynamics.damping.as_slice());
        for j in 0..self.v.len() {
            self.force[j] = self.push_force[j] - dynamics.bias[j] - dynamics.damping[j] - dynamics.elastic[j];
        }
        for (&dof, torque) in self.actuated.iter().zip(&self.applied) {
            self.force[dof] += torque;
        }
        velocity.solve(settings, &self.v, &self.force, &mut self.next_v);

        if is_midpoint && in_bounds(&self.next_v) {
            // Velocity-dependent forces are the mean of those before and after the step. Without it every impact would
            // leave an error of first order in the momentum.
            for j in 0..self.v.len() {
                self.force[j] += 0.5 * (midpoint.bias[j] + midpoint.damping[j]);
                self.damping[j] *= 0.5;
            }
            midpoint.update_bias(model, &self.next_v);
            for j in 0..self.v.len() {
                self.force[j] -= 0.5 * (midpoint.bias[j] + midpoint.damping[j]);
                self.damping[j] += 0.5 * midpoint.damping[j];
            }
            velocity.solve(settings, &self.v, &self.force, &mut self.next_v);
        }
        if !in_bounds(&self.next_v) {
            velocity.forget();
            return false;
        }

        self.audit.account(&audit::Step {
            period: dt,
            v: [&self.v, &self.next_v],
            actuated: &self.actuated,
            torque: &self.applied,
            damping: &self.damping,
            push,
            push_force: &self.push_force,
            gravity: model.gravity,
            report: velocity.report,
        });
        velocity.account(model, dt, &mut self.audit, &mut self.forces);
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
