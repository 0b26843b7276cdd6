//! Forward dynamics: the articulated-body algorithm. Featherstone 2008, Table 7.1.
//!
//! In one frame for all bodies nothing is carried from body to body, and a joint of several coordinates is as many joints
//! of one coordinate, one after the other.

use nalgebra::{DMatrix, Matrix3};

use crate::dynamics::Dynamics;
use crate::inverse_dynamics::take_contact_forces;
use crate::model::Model;
use crate::spatial::{Force, Inertia, Motion};

/// From forces to the accelerations that they cause, in time that grows with the number of bodies. It holds the scratch.
#[derive(Clone, Debug)]
pub struct ForwardDynamics {
    /// I^A of each body with all that it carries.
    articulated: Vec<ArticulatedInertia>,
    /// p^A of each body.
    force: Vec<Force>,
    acceleration: Vec<Motion>,
    /// U = I^A S of each coordinate.
    momentum: Vec<Force>,
    /// D = Sᵀ U.
    inertia: Vec<f64>,
    /// u = τ − Sᵀ p^A.
    drive: Vec<f64>,
    /// The factor of the mass matrix, where joints follow others.
    factor: DMatrix<f64>,
}

impl ForwardDynamics {
    /// Allocates the scratch for `model`.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let (bodies, nv) = (model.bodies.len(), model.nv());
        Self {
            articulated: vec![ArticulatedInertia::of(&Inertia::zero()); bodies],
            force: vec![Force::zero(); bodies],
            acceleration: vec![Motion::zero(); bodies],
            momentum: vec![Force::zero(); nv],
            inertia: vec![0.0; nv],
            drive: vec![0.0; nv],
            factor: if bodies_follow(model) { DMatrix::zeros(nv, nv) } else { DMatrix::zeros(0, 0) },
        }
    }

    /// Writes the accelerations `vdot` (nv) [rad/s² or m/s²] that the generalised forces `tau` (nv) [Nm or N] and the contact
    /// forces `rho` (d nc) [N], along the linear axes, cause in the state of `dynamics`:
    /// `M v̇ = tau + Jᵀ ρ − bias − damping − elastic`. Allocates nothing.
    ///
    /// Returns false where a coordinate moves no inertia, so that its acceleration is not determined; `vdot` then
    /// has no meaning. Where joints follow others, the mass matrix is factorised instead: the articulated bodies' tree has no such
    /// couplings.
    ///
    /// # Panics
    /// If a slice has a wrong length, or if `self` was made for another model.
    #[must_use]
    pub fn solve(&mut self, model: &Model, dynamics: &Dynamics, tau: &[f64], rho: &[f64], vdot: &mut [f64]) -> bool {
        assert_eq!((tau.len(), vdot.len()), (model.nv(), model.nv()), "lengths of tau, vdot");
        assert_eq!(self.force.len(), model.bodies.len(), "this ForwardDynamics was made for another model");
        take_contact_forces(model, dynamics, rho, &mut self.force);
        if !self.factor.is_empty() {
            return self.solve_coupled(model, dynamics, tau, vdot);
        }
        for (articulated, inertia) in self.articulated.iter_mut().zip(&dynamics.inertia) {
            *articulated = ArticulatedInertia::of(inertia);
        }
        for (i, body) in model.bodies.iter().enumerate().rev() {
            let (mut articulated, mut force) = (self.articulated[i], self.force[i]);
            for j in (body.v_index..body.v_index + body.joint.nv()).rev() {
                let s = &dynamics.subspace[j];
                let U = articulated.momentum(s);
                // Featherstone 2008, Section 9.6: a rotor's inertia stands beside that of the bodies.
                let D = s.dot(&U) + model.dofs[j].armature;
                if D.is_nan() || D <= 0.0 {
                    return false;
                }
                let u = tau[j] - dynamics.passive(j) - s.dot(&force);
                articulated.release(&U, D);
                force.add_scaled(&U, u / D);
                (self.momentum[j], self.inertia[j], self.drive[j]) = (U, D, u);
            }
            if let Some(parent) = body.parent {
                self.articulated[parent] += articulated;
                self.force[parent] += force;
            }
        }
        for (i, body) in model.bodies.iter().enumerate() {
            let mut acceleration = body.parent.map_or(Motion::zero(), |parent| self.acceleration[parent]);
            for j in body.v_index..body.v_index + body.joint.nv() {
                vdot[j] = (self.drive[j] - acceleration.dot(&self.momentum[j])) / self.inertia[j];
                acceleration.add_scaled(&dynamics.subspace[j], vdot[j]);
            }
            self.acceleration[i] = acceleration;
        }
        true
    }
}

fn bodies_follow(model: &Model) -> bool {
    model.bodies.iter().any(|body| body.follows.is_some())
}

impl ForwardDynamics {
    /// `M v̇ = tau − passive − Sᵀ f`, by M = Lᵀ L. Featherstone 2008, Section 6.5.
    fn solve_coupled(&mut self, model: &Model, dynamics: &Dynamics, tau: &[f64], vdot: &mut [f64]) -> bool {
        for (i, body) in model.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                let force = self.force[i];
                self.force[parent] += force;
            }
        }
        for (j, dof) in model.dofs.iter().enumerate() {
            vdot[j] = tau[j] - dynamics.passive(j) - dynamics.subspace[j].dot(&self.force[dof.body]);
        }
        for (follower, s) in dynamics.tree.followers(&dynamics.subspace) {
            vdot[follower.coordinate] -= follower.ratio * s.dot(&self.force[follower.body]);
        }
        let L = &mut self.factor;
        L.copy_from(&dynamics.mass_matrix);
        for k in (0..vdot.len()).rev() {
            let pivot = L[(k, k)];
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            let root = libm::sqrt(pivot);
            (0..=k).for_each(|j| L[(k, j)] /= root);
            for i in 0..k {
                for j in 0..=i {
                    L[(i, j)] -= L[(k, i)] * L[(k, j)];
                }
            }
            vdot[k] /= root;
            (0..k).for_each(|j| vdot[j] -= L[(k, j)] * vdot[k]);
        }
        for k in 0..vdot.len() {
            let carried: f64 = (0..k).map(|j| L[(k, j)] * vdot[j]).sum();
            vdot[k] = (vdot[k] - carried) / L[(k, k)];
        }
        true
    }
}

/// The inertia that a body with moving parts shows to its joint: symmetric, but without a centre of mass.
#[derive(Clone, Copy, Debug)]
struct ArticulatedInertia {
    rotational: Matrix3<f64>,
    /// From linear motion to angular momentum.
    coupling: Matrix3<f64>,
    linear: Matrix3<f64>,
}

impl ArticulatedInertia {
    fn of(inertia: &Inertia) -> Self {
        Self {
            rotational: inertia.rotational,
            coupling: inertia.first_moment.cross_matrix(),
            linear: Matrix3::from_diagonal_element(inertia.mass),
        }
    }

    fn momentum(&self, v: &Motion) -> Force {
        Force {
            angular: self.rotational * v.angular + self.coupling * v.linear,
            linear: self.coupling.tr_mul(&v.angular) + self.linear * v.linear,
        }
    }

    /// Lets the motion free whose momentum is U and whose inertia is D: I^A − U D⁻¹ Uᵀ.
    fn release(&mut self, U: &Force, D: f64) {
        let (angular, linear) = (U.angular / D, U.linear / D);
        self.rotational -= angular * U.angular.transpose();
        self.coupling -= angular * U.linear.transpose();
        self.linear -= linear * U.linear.transpose();
    }
}

impl std::ops::AddAssign for ArticulatedInertia {
    fn add_assign(&mut self, other: Self) {
        self.rotational += other.rotational;
        self.coupling += other.coupling;
        self.linear += other.linear;
    }
}
