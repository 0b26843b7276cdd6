//! The velocities after a step: `M (v⁺ - v) = dt (f - h) + Jᵀ λ`, with the contact impulses λ of Appendix A or of the
//! spring-damper ground.

use legwork_rbd::{Dynamics, Model};
use nalgebra::{DMatrix, Vector3};

use super::contact_solver::{ContactSolver, Report};
use super::{linear, spring_damper};
use crate::contact::GroundPlane;
use crate::scenario::{ContactModel, SimulationSettings};

/// The equation of one step, set up in one configuration and solved for one or more biases; all preallocated.
#[derive(Clone, Debug)]
pub(super) struct VelocityStep {
    /// Contact Jacobian in contact coordinates: for each contact its tangents, then its normal.
    pub(super) rows: DMatrix<f64>,
    /// Contact impulses in contact coordinates [Ns].
    pub(super) contacts: ContactSolver,
    /// What the contact solver said last.
    pub(super) report: Report,
    /// Cholesky factor of the mass matrix.
    factor: DMatrix<f64>,
    /// `L⁻¹ Jᵀ`, a column a row of the contact Jacobian.
    whitened: DMatrix<f64>,
    change: Vec<f64>,
}

impl VelocityStep {
    /// Storage for `model`.
    pub(super) fn new(model: &Model) -> Self {
        let (nv, contacts, d) = (model.nv(), model.contacts.len(), model.linear_axes().len());
        Self {
            rows: DMatrix::zeros(contacts * d, nv),
            contacts: ContactSolver::new(contacts, d),
            report: Report::default(),
            factor: DMatrix::zeros(nv, nv),
            whitened: DMatrix::zeros(nv, contacts * d),
            change: vec![0.0; nv],
        }
    }

    /// Sets the step up in the configuration of `dynamics`; the contact points move on for `rest` [s] with the new
    /// velocity. `v` are the velocities before. Returns false where the mass matrix is not positive definite.
    pub(super) fn prepare(
        &mut self,
        settings: &SimulationSettings,
        model: &Model,
        ground: &GroundPlane,
        dynamics: &Dynamics,
        v: &[f64],
        rest: f64,
    ) -> bool {
        self.factor.copy_from(&dynamics.mass_matrix);
        if !linear::factor(&mut self.factor) {
            return false;
        }
        self.contact_rows(model, ground, dynamics);
        match settings.contact.model {
            ContactModel::Rigid => self.rigid(settings, ground, dynamics, rest),
            ContactModel::SpringDamper => self.spring(settings, ground, dynamics, v),
        }
        true
    }

    /// `J` in contact coordinates.
    fn contact_rows(&mut self, model: &Model, ground: &GroundPlane, dynamics: &Dynamics) {
        let axes = model.linear_axes();
        let d = axes.len();
        for contact in 0..model.contacts.len() {
            for (k, direction) in ground.directions().enumerate() {
                for j in 0..self.rows.ncols() {
                    self.rows[(contact * d + k, j)] = axes
                        .iter()
                        .enumerate()
                        .map(|(i, axis)| axis.dot(direction) * dynamics.contact_jacobian[(contact * d + i, j)])
                        .sum();
                }
            }
        }
    }

    /// Sets up `G = J M⁻¹ Jᵀ` and how fast each point may approach the ground.
    fn rigid(&mut self, settings: &SimulationSettings, ground: &GroundPlane, dynamics: &Dynamics, rest: f64) {
        let (size, nv) = (self.rows.nrows(), self.rows.ncols());
        for k in 0..size {
            for j in 0..nv {
                self.whitened[(j, k)] = self.rows[(k, j)];
            }
            linear::solve_lower(&self.factor, &mut self.whitened.as_mut_slice()[k * nv..(k + 1) * nv]);
        }
        for a in 0..size {
            for b in 0..=a {
                let value = self.whitened.column(a).dot(&self.whitened.column(b));
                self.contacts.delassus[a * size + b] = value;
                self.contacts.delassus[b * size + a] = value;
            }
        }
        for (contact, position) in dynamics.contact_positions.iter().enumerate() {
            let gap = ground.gap(position);
            // A point may close its gap within the step, and recovers from a share of its penetration.
            let share = if gap > 0.0 { 1.0 / rest } else { settings.contact.penetration_recovery / settings.period_s };
            self.contacts.approach[contact] = -share * gap;
        }
    }

    /// Impulses of the spring-damper ground over the step (thesis 3.3).
    fn spring(&mut self, settings: &SimulationSettings, ground: &GroundPlane, dynamics: &Dynamics, v: &[f64]) {
        let d = ground.dimension();
        self.report = Report::default();
        for (contact, position) in dynamics.contact_positions.iter().enumerate() {
            let mut velocity = [0.0; 3];
            for (k, value) in velocity[..d].iter_mut().enumerate() {
                *value = (0..v.len()).map(|j| self.rows[(contact * d + k, j)] * v[j]).sum();
            }
            let impulse = &mut self.contacts.impulse[contact * d..(contact + 1) * d];
            spring_damper::force(&settings.contact, ground.friction, ground.gap(position), &velocity[..d], impulse);
            impulse.iter_mut().for_each(|value| *value *= settings.period_s);
        }
    }

    /// Writes `v⁺` into `next`, where `force` are all generalized forces but those of the contacts.
    pub(super) fn solve(
        &mut self,
        settings: &SimulationSettings,
        friction: f64,
        v: &[f64],
        force: &[f64],
        next: &mut [f64],
    ) {
        let (dt, nv) = (settings.period_s, v.len());
        next.copy_from_slice(force);
        self.solve_mass(next);
        for j in 0..nv {
            next[j] = v[j] + dt * next[j];
        }
        if settings.contact.model == ContactModel::Rigid {
            for k in 0..self.rows.nrows() {
                self.contacts.free[k] = (0..nv).map(|j| self.rows[(k, j)] * next[j]).sum();
            }
            self.report = self.contacts.solve(friction, settings.contact.tolerance_n * dt, &settings.contact);
        }
        let mut change = std::mem::take(&mut self.change);
        for (j, value) in change.iter_mut().enumerate() {
            *value = (0..self.rows.nrows()).map(|k| self.rows[(k, j)] * self.contacts.impulse[k]).sum();
        }
        self.solve_mass(&mut change);
        for (value, change) in next.iter_mut().zip(&change) {
            *value += change;
        }
        self.change = change;
    }

    /// `x := M⁻¹ x`
    fn solve_mass(&self, x: &mut [f64]) {
        linear::solve_lower(&self.factor, x);
        linear::solve_upper(&self.factor, x);
    }

    /// Mean contact forces of the step along the model's linear axes [N].
    pub(super) fn world_forces(&self, model: &Model, ground: &GroundPlane, dt: f64, forces: &mut [f64]) {
        let axes = model.linear_axes();
        let d = axes.len();
        for contact in 0..model.contacts.len() {
            let mut force = Vector3::zeros();
            for (k, direction) in ground.directions().enumerate() {
                force += *direction * (self.contacts.impulse[contact * d + k] / dt);
            }
            for (i, axis) in axes.iter().enumerate() {
                forces[contact * d + i] = axis.dot(&force);
            }
        }
    }
}
