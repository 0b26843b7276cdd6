//! The simulator: the state of one robot, advanced step by step.

use std::sync::Arc;

use legwork_contract::channel::{Channel, Field, Record};
use legwork_contract::contract::{Command, Sensed};
use legwork_contract::error::Error;
use legwork_contract::names;
use legwork_contract::terrain::Terrain;
use legwork_rbd::{Dynamics, Model};

use crate::actuators::Actuators;
use crate::audit::{self, Audit};
use crate::contact_solver::Report;
use crate::elastic::Elastic;
use crate::plant::{Health, Plant};
use crate::push::Pushes;
use crate::settings::{ContactModel, Integrator, Push, SimulationSettings};
use crate::velocity::{Moment, VelocityStep};

/// Most impacts in a step.
const IMPACTS: u32 = 4;

/// Shorter pieces of a step are left out, as a share of it.
const BRIEF: f64 = 1e-3;

/// The simulated robot and its ground.
#[derive(Clone, Debug)]
pub struct Simulator {
    body: Body,
    velocity: Velocity,
    period: Period,
}

/// What was measured in the latest control period.
#[derive(Clone, Debug)]
struct Period {
    /// Mean contact forces along the linear axes [N].
    forces: Vec<f64>,
    /// Torques that acted in its last step [Nm].
    torque: Vec<f64>,
    /// Sweeps of the contact solver in its last step, and its residual [N].
    contact: [f64; 2],
    /// Error of the energy balance before it [J].
    energy_error: f64,
}

impl Period {
    fn begin(&mut self, energy_error: f64) {
        self.forces.fill(0.0);
        self.torque.fill(0.0);
        (self.contact, self.energy_error) = ([0.0; 2], energy_error);
    }
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
    /// What the contact solver said of the latest step: most sweeps, largest residual [Ns].
    report: Report,
    next_q: Vec<f64>,
    next_v: Vec<f64>,
    /// The state at the beginning of the step.
    start_q: Vec<f64>,
    start_v: Vec<f64>,
    audit: Audit,
}

impl Simulator {
    /// A robot at rest in `q` [rad, m] on the `ground`; many robots may share a model.
    ///
    /// # Errors
    /// A push that names an unknown body; a spring or stop at a joint that is too stiff for the time step.
    pub fn new(
        settings: &SimulationSettings,
        pushes: &[Push],
        ground: Terrain,
        model: Arc<Model>,
        q: &[f64],
    ) -> Result<Self, Error> {
        let settings = settings.clone();
        let (nv, d, contacts) = (model.nv(), model.linear_axes().len(), model.contacts.len());
        let actuated: Vec<usize> = model.actuated().collect();
        let state = Dynamics::new(&model);
        let mut velocity = if model.is_planar() {
            Velocity::Planar(VelocityStep::new(&model, &state))
        } else {
            Velocity::Spatial(VelocityStep::new(&model, &state))
        };
        let mut body = Body {
            ground,
            pushes: Pushes::new(pushes, &model)?,
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
            report: Report::default(),
            next_q: q.to_vec(),
            next_v: vec![0.0; nv],
            start_q: q.to_vec(),
            start_v: vec![0.0; nv],
            audit: Audit::default(),
            settings,
            model,
        };
        body.state.update(&body.model, &body.q, &body.v);
        body.audit.begin(&body.model, &body.state);
        match &mut velocity {
            Velocity::Planar(velocity) => body.check_springs(velocity)?,
            Velocity::Spatial(velocity) => body.check_springs(velocity)?,
        }
        let (forces, torque) = (body.forces.clone(), body.applied.clone());
        Ok(Self { body, velocity, period: Period { forces, torque, contact: [0.0; 2], energy_error: 0.0 } })
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
        self.body.report
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

impl Plant for Simulator {
    fn read(&self, sensed: &mut Sensed) {
        let axes = self.body.model.linear_axes().len();
        sensed.time = self.time();
        sensed.q.copy_from_slice(&self.body.q);
        sensed.v.copy_from_slice(&self.body.v);
        for (index, contact) in sensed.contacts.iter_mut().enumerate() {
            contact.touching = self.touching(index);
            contact.load = self.period.forces[index * axes + axes - 1];
        }
    }

    fn apply(&mut self, command: &Command, period: f64) -> Health {
        self.period.begin(self.body.audit.energy_error_j);
        let step = self.body.settings.period_s;
        let steps = (period / step).round() as u64;
        let share = 1.0 / steps as f64;
        for _ in 0..steps {
            if !self.step(&command.torque) {
                return Health::OutOfBounds;
            }
            for (mean, force) in self.period.forces.iter_mut().zip(&self.body.forces) {
                *mean += share * force;
            }
            self.period.torque.copy_from_slice(&self.body.applied);
            let report = self.contact_report();
            self.period.contact = [f64::from(report.sweeps), report.residual / step];
        }
        Health::Sound
    }

    fn dynamics(&self) -> Option<&Dynamics> {
        Some(&self.body.state)
    }

    fn audit(&self) -> Option<&Audit> {
        Some(&self.body.audit)
    }

    fn channels(&self) -> Vec<Channel> {
        let model = &self.body.model;
        [
            Channel::all(Field::TorqueApplied, names::joints(model, "torque_applied", "Nm")),
            Channel::all(Field::GrfSimulated, names::contacts(model, "grf_simulated", "N")),
            Channel::all(Field::Contact, [("contact.sweeps", ""), ("contact.residual", "N")]),
            Channel::all(Field::EnergyError, [("energy.error", "J")]),
        ]
        .concat()
    }

    fn record(&self, record: &mut Record<'_>) {
        record.set(Field::TorqueApplied, self.period.torque.iter().copied());
        record.set(Field::GrfSimulated, self.period.forces.iter().copied());
        record.set(Field::Contact, self.period.contact);
        record.set(Field::EnergyError, [self.period.energy_error]);
    }

    fn change(&mut self, settings: &SimulationSettings, pushes: &[Push], ground: &Terrain) -> Result<(), Error> {
        self.body.pushes = Pushes::new(pushes, &self.body.model)?;
        self.body.settings.contact = settings.contact.clone();
        self.body.ground = ground.clone();
        match &mut self.velocity {
            Velocity::Planar(velocity) => velocity.forget(),
            Velocity::Spatial(velocity) => velocity.forget(),
        }
        Ok(())
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

    /// One step, divided where contact points meet the ground: forces act until then, the impact changes the velocities at
    /// once, and forces act for the rest.
    fn step<const D: usize, const K: usize>(&mut self, velocity: &mut VelocityStep<D, K>, wanted: &[f64]) -> bool {
        self.applied.copy_from_slice(self.actuators.apply(wanted));
        self.start_q.copy_from_slice(&self.q);
        self.start_v.copy_from_slice(&self.v);
        self.forces.fill(0.0);
        self.report = Report::default();
        let sound = self.divide(velocity);
        if sound {
            self.step += 1;
        } else {
            self.q.copy_from_slice(&self.start_q);
            self.v.copy_from_slice(&self.start_v);
            velocity.forget();
        }
        self.state.update(&self.model, &self.q, &self.v);
        if sound {
            self.audit.close(&self.state, &self.ground);
        }
        sound
    }

    /// Advances by a step, from impact to impact. Returns false where the numbers are out of bounds.
    fn divide<const D: usize, const K: usize>(&mut self, velocity: &mut VelocityStep<D, K>) -> bool {
        let dt = self.settings.period_s;
        let mut gone = 0.0;
        let divides =
            self.settings.integrator == Integrator::Midpoint && self.settings.contact.model == ContactModel::Rigid;
        for _ in 0..if divides { IMPACTS } else { 0 } {
            let Some(at) = velocity.landing(&self.ground, &self.state, dt - gone) else { break };
            if gone + at > (1.0 - BRIEF) * dt {
                break;
            }
            if at > BRIEF * dt {
                if !self.advance(velocity, gone, at) {
                    return false;
                }
                gone += at;
                self.state.update_position(&self.model, &self.q);
                self.state.update_bias(&self.model, &self.v);
            }
            if !self.impact(velocity) {
                return false;
            }
            self.state.update_bias(&self.model, &self.v);
        }
        self.advance(velocity, gone, dt - gone)
    }

    /// Stops the contact points that are at the ground at once.
    fn impact<const D: usize, const K: usize>(&mut self, velocity: &mut VelocityStep<D, K>) -> bool {
        let Self { settings, model, ground, state, .. } = self;
        // What free fall leaves of a gap that was to close.
        let reach = 2.0 * model.gravity.abs() * settings.period_s * settings.period_s + 1e-9;
        let moment = Moment::Impact { reach };
        if !velocity.prepare(settings, ground, state, moment) {
            return false;
        }
        self.force.fill(0.0);
        velocity.solve(settings, 0.0, &self.v, &self.force, &mut self.next_v);
        if !in_bounds(&self.next_v) {
            return false;
        }
        self.enter(velocity, moment);
        true
    }

    /// Enters what the contacts did in a change of velocity, and makes it.
    fn enter<const D: usize, const K: usize>(&mut self, velocity: &mut VelocityStep<D, K>, moment: Moment) {
        let (report, so_far) = (velocity.report, self.report);
        self.report =
            Report { sweeps: so_far.sweeps.max(report.sweeps), residual: so_far.residual.max(report.residual) };
        self.audit.solve(report, self.settings.period_s);
        velocity.account(&self.model, &self.settings, moment, &mut self.audit, &mut self.forces);
        self.v.copy_from_slice(&self.next_v);
    }

    /// Advances the state from the time `gone` [s] after the step's begin by `dt` [s].
    fn advance<const D: usize, const K: usize>(
        &mut self,
        velocity: &mut VelocityStep<D, K>,
        gone: f64,
        dt: f64,
    ) -> bool {
        let time = self.time() + gone;
        let Self { settings, model, ground, state, midpoint, .. } = self;
        let is_midpoint = settings.integrator == Integrator::Midpoint;

        // Moreau 1988: forces and contacts are those of the configuration half a step ahead.
        let ahead = if is_midpoint { 0.5 * dt } else { 0.0 };
        model.integrate(&self.q, &self.v, ahead, &mut self.next_q);
        if is_midpoint {
            midpoint.update_position(model, &self.next_q);
            midpoint.update_bias(model, &self.v);
        }
        let dynamics = if is_midpoint { &*midpoint } else { &*state };
        let moment = Moment::Step { period: dt, ahead, pace: settings.period_s };
        if !velocity.prepare(settings, ground, dynamics, moment) {
            return false;
        }
        if !self.elastic.is_empty() {
            let q = if is_midpoint { &self.next_q } else { &self.q };
            self.audit.springs(self.elastic.share(model, q, dt, velocity));
        }
        self.push_force.fill(0.0);
        let push = self.pushes.add(dynamics, time, dt, &mut self.push_force);
        self.damping.copy_from_slice(dynamics.damping.as_slice());
        let passive = dynamics.bias.as_slice().iter().zip(dynamics.damping.as_slice());
        for ((force, push), (bias, damping)) in self.force.iter_mut().zip(&self.push_force).zip(passive) {
            *force = push - bias - damping;
        }
        if !self.elastic.is_empty() {
            self.force.iter_mut().zip(dynamics.elastic.as_slice()).for_each(|(force, elastic)| *force -= elastic);
        }
        for (&dof, torque) in self.actuated.iter().zip(&self.applied) {
            self.force[dof] += torque;
        }
        velocity.solve(settings, dt, &self.v, &self.force, &mut self.next_v);

        if is_midpoint && in_bounds(&self.next_v) {
            // Velocity-dependent forces are the mean of those before and after the step. Without it every change of the
            // velocities by contacts would leave an error of first order in the momentum.
            for j in 0..self.v.len() {
                self.force[j] += 0.5 * (midpoint.bias[j] + midpoint.damping[j]);
                self.damping[j] *= 0.5;
            }
            midpoint.update_bias(model, &self.next_v);
            for j in 0..self.v.len() {
                self.force[j] -= 0.5 * (midpoint.bias[j] + midpoint.damping[j]);
                self.damping[j] += 0.5 * midpoint.damping[j];
            }
            self.audit.contact_sweeps = self.audit.contact_sweeps.max(velocity.report.sweeps);
            velocity.solve(settings, dt, &self.v, &self.force, &mut self.next_v);
        }
        if !in_bounds(&self.next_v) {
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
        });
        self.model.integrate(&self.next_q, &self.next_v, dt - ahead, &mut self.q);
        self.enter(velocity, moment);
        true
    }
}

/// Whether velocities are numbers that physics could have made, and numbers at all.
fn in_bounds(v: &[f64]) -> bool {
    v.iter().all(|value| value.abs() < 1e6)
}
