//! All quantities of one state, computed together.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::model::Model;
use crate::spatial::{Force, Inertia, Motion, Placement};
use crate::tree::Tree;

/// Every dynamic quantity of one state (q, v), and all scratch. Valid after [`Dynamics::update`].
///
/// nv: velocity coordinates; nc: contact points; d: linear axes (2 in the plane, 3 in space); r: angular and linear axes
/// (3 or 6). The equation of motion reads `M v̇ + bias + damping + elastic = Sᵀ τ + Jᵀ ρ`.
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// M (nv × nv), symmetric, SI units.
    pub mass_matrix: DMatrix<f64>,
    /// h = C v + G (nv) [Nm or N], without damping.
    pub bias: DVector<f64>,
    /// G (nv) [Nm or N]: what holds the robot at rest.
    pub gravity: DVector<f64>,
    /// B v (nv) [Nm or N], with the dampers of stops that a joint is at: it opposes the motion, on the side of `bias`.
    pub damping: DVector<f64>,
    /// K (q − rest), and what stops push with (nv) [Nm or N]: the gradient of `elastic_energy`, on the side of `bias`.
    pub elastic: DVector<f64>,
    /// The centre of mass [m].
    pub com: Vector3<f64>,
    /// Its velocity [m/s].
    pub com_velocity: Vector3<f64>,
    /// Its Jacobian (d × nv).
    pub com_jacobian: DMatrix<f64>,
    /// The centroidal momentum matrix A (r × nv): rows along the angular axes, about the centre of mass, then along the
    /// linear axes.
    pub momentum_matrix: DMatrix<f64>,
    /// Ȧ v (r) [Nm, N].
    pub momentum_bias: DVector<f64>,
    /// Contact points (nc) [m].
    pub contact_positions: Vec<Vector3<f64>>,
    /// Their velocities (nc) [m/s].
    pub contact_velocities: Vec<Vector3<f64>>,
    /// Their Jacobians, stacked (d nc × nv).
    pub contact_jacobian: DMatrix<f64>,
    /// J̇ v (d nc) [m/s²].
    pub contact_bias: DVector<f64>,
    /// Poses of the bodies' frames in the world.
    pub world_from_body: Vec<Placement>,
    /// Velocities of the bodies: angular, and linear at the body's origin.
    pub body_velocity: Vec<Motion>,
    /// [J]
    pub kinetic_energy: f64,
    /// [J], zero with the centre of mass at z = 0.
    pub potential_energy: f64,
    /// [J], in the springs and stops of the joints.
    pub elastic_energy: f64,

    /// The point all that follows refers to: the root link's origin in the world.
    pub(crate) reference: Vector3<f64>,
    pub(crate) relative: Vec<Placement>,
    pub(crate) velocity: Vec<Motion>,
    pub(crate) acceleration: Vec<Motion>,
    pub(crate) subspace: Vec<Motion>,
    pub(crate) subspace_momentum: Vec<Force>,
    /// Of single bodies.
    pub(crate) inertia: Vec<Inertia>,
    /// Of bodies with all that they carry.
    pub(crate) composite: Vec<Inertia>,
    pub(crate) force: Vec<Force>,
    pub(crate) momentum: Force,
    /// Whether any joint has a spring or a stop.
    pub(crate) is_elastic: bool,
    /// The elastic force of each coordinate's stop.
    pub(crate) stop_force: Vec<f64>,
    /// What carries what.
    pub(crate) tree: Tree,
}

impl Dynamics {
    /// Allocates everything for `model`; the values are those of no state yet.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let nv = model.nv();
        Self { mass_matrix: DMatrix::zeros(nv, nv), ..Self::without_mass_matrix(model) }
    }

    /// With an empty mass matrix, so that the size grows with that of the model and not with its square.
    pub(crate) fn without_mass_matrix(model: &Model) -> Self {
        let (nv, nc, nb) = (model.nv(), model.nc(), model.bodies.len());
        let (d, angular) = (model.linear_axes().len(), model.angular_axes().len());
        let tree = Tree::of(model);
        let columns = tree.parent.len();
        Self {
            mass_matrix: DMatrix::zeros(0, 0),
            bias: DVector::zeros(nv),
            gravity: DVector::zeros(nv),
            damping: DVector::zeros(nv),
            elastic: DVector::zeros(nv),
            com: Vector3::zeros(),
            com_velocity: Vector3::zeros(),
            com_jacobian: DMatrix::zeros(d, nv),
            momentum_matrix: DMatrix::zeros(angular + d, nv),
            momentum_bias: DVector::zeros(angular + d),
            contact_positions: vec![Vector3::zeros(); nc],
            contact_velocities: vec![Vector3::zeros(); nc],
            contact_jacobian: DMatrix::zeros(d * nc, nv),
            contact_bias: DVector::zeros(d * nc),
            world_from_body: vec![Placement::identity(); nb],
            body_velocity: vec![Motion::zero(); nb],
            kinetic_energy: 0.0,
            potential_energy: 0.0,
            elastic_energy: 0.0,
            reference: Vector3::zeros(),
            relative: vec![Placement::identity(); nb],
            velocity: vec![Motion::zero(); nb],
            acceleration: vec![Motion::zero(); nb],
            subspace: vec![Motion::zero(); columns],
            subspace_momentum: vec![Force::zero(); columns],
            inertia: vec![Inertia::zero(); nb],
            composite: vec![Inertia::zero(); nb],
            force: vec![Force::zero(); nb],
            momentum: Force::zero(),
            is_elastic: false,
            stop_force: vec![0.0; nv],
            tree,
        }
    }

    /// Computes everything at the position `q` (nq) and velocity `v` (nv). Allocates nothing.
    /// The quaternion of a floating base need not have unit length, but must not be zero.
    ///
    /// # Panics
    /// If a slice has a wrong length, or if `self` was made for another model.
    pub fn update(&mut self, model: &Model, q: &[f64], v: &[f64]) {
        self.update_position(model, q);
        self.update_bias(model, v);
        self.centroidal(model);
        self.contacts(model);
    }

    /// The first stage of [`Dynamics::update`]: only what the position `q` (nq) decides and an equation of motion needs,
    /// that is `mass_matrix`, `gravity`, `elastic` and its energy, `world_from_body`, `contact_positions` and the motion subspaces.
    ///
    /// # Panics
    /// As [`Dynamics::update`].
    pub fn update_position(&mut self, model: &Model, q: &[f64]) {
        assert_eq!(q.len(), model.nq(), "length of q");
        assert_eq!(
            (self.bias.len(), self.force.len(), self.contact_positions.len()),
            (model.nv(), model.bodies.len(), model.nc()),
            "this Dynamics was made for another model"
        );
        self.poses(model, q);
        self.inertias(model);
        self.mass_matrix(model);
        self.gravity(model);
        self.springs(model, q);
    }

    /// The second stage: what the velocity `v` (nv) adds at the latest position, that is `bias`, `damping`,
    /// `kinetic_energy` and the velocities and accelerations of points of bodies. It may be repeated with other
    /// velocities.
    ///
    /// # Panics
    /// As [`Dynamics::update`].
    pub fn update_bias(&mut self, model: &Model, v: &[f64]) {
        assert_eq!(v.len(), model.nv(), "length of v");
        self.velocities(model, v);
        self.forces(model);
        self.generalised_forces(model, v);
    }

    /// What the joints bear by themselves at coordinate `j` [Nm or N]: bias, damping and elastic force.
    #[inline]
    #[must_use]
    pub fn passive(&self, j: usize) -> f64 {
        self.bias[j] + self.damping[j] + self.elastic[j]
    }

    /// The generalised force of `force` [N] on a point that is fixed to `body` and now at `world_point` [m], added to
    /// `out` (nv). Of the latest position.
    pub fn add_point_force(&self, body: usize, world_point: &Vector3<f64>, force: &Vector3<f64>, out: &mut [f64]) {
        let at = world_point - self.reference;
        self.tree.columns(&self.subspace, body, |j, s| out[j] += s.linear_at(&at).dot(force));
    }

    /// The generalised force of `force` [N] on the centre of mass, added to `out` (nv). Of the latest position.
    pub fn add_com_force(&self, force: &Vector3<f64>, out: &mut [f64]) {
        let mass = self.composite[0].mass;
        for (value, momentum) in out.iter_mut().zip(&self.subspace_momentum) {
            *value += momentum.linear.dot(force) / mass;
        }
        for (follower, momentum) in self.tree.followers(&self.subspace_momentum) {
            out[follower.coordinate] += follower.ratio * momentum.linear.dot(force) / mass;
        }
    }

    fn contacts(&mut self, model: &Model) {
        for ((out, velocity), placement) in self.body_velocity.iter_mut().zip(&self.velocity).zip(&self.relative) {
            *out = Motion { angular: velocity.angular, linear: velocity.linear_at(&placement.translation) };
        }
        let d = model.linear_axes().len();
        let rows = d * model.nc();
        for (k, contact) in model.contacts.iter().enumerate() {
            let at = self.relative[contact.body].point(&contact.position);
            let velocity = &self.velocity[contact.body];
            self.contact_velocities[k] = velocity.linear_at(&at);
            let bias =
                self.acceleration[contact.body].linear_at(&at) + velocity.angular.cross(&self.contact_velocities[k]);
            let first = d * k;
            self.contact_bias.as_mut_slice()[first..first + d].copy_from_slice(&model.linear_components(&bias)[..d]);
            let J = self.contact_jacobian.as_mut_slice();
            self.tree.columns(&self.subspace, contact.body, |j, s| {
                let column = model.linear_components(&s.linear_at(&at));
                for (entry, value) in J[j * rows + first..j * rows + first + d].iter_mut().zip(column) {
                    *entry = value;
                }
            });
        }
    }
}
