//! The velocities after a step: `M (v⁺ - v) = dt (f - h) + Jᵀ λ`, with the contact impulses λ of Appendix A or of the
//! spring-damper ground.
//!
//! With `M = Lᵀ L` and `Y = L⁻ᵀ Jᵀ`, where J are the twists of the feet: contacts act by `Yᵀ Y`, and
//! `v⁺ = v + L⁻¹ (dt L⁻ᵀ (f - h) + Y F)`. A column of Y is nonzero only along its foot's chain.

use legwork_rbd::{Dynamics, Model, Motion};
use nalgebra::Vector3;

use super::audit::Audit;
use super::contact_solver::{ContactSolver, Report};
use super::simultaneous::Simultaneous;
use super::spring_damper;
use super::tree_factor::TreeFactor;
use crate::settings::{ContactModel, SimulationSettings};
use legwork_contract::contact::Surface;
use legwork_contract::terrain::Terrain;

/// The equation of one step, set up in one configuration and solved for one or more biases; all preallocated. For D and K
/// see [`ContactSolver`].
#[derive(Clone, Debug)]
pub(super) struct VelocityStep<const D: usize, const K: usize> {
    contacts: ContactSolver<D, K>,
    together: Simultaneous<D, K>,
    /// What the contact solver said last.
    pub(super) report: Report,
    factor: TreeFactor,
    feet: Vec<Foot<K>>,
    /// The ground below each contact point.
    ground: Vec<Surface>,
    /// Twists of the feet with the velocities before.
    before: Vec<[f64; K]>,
    /// `L⁻ᵀ (f - h)`
    drive: Vec<f64>,
}

/// A body with contact points.
#[derive(Clone, Debug)]
struct Foot<const K: usize> {
    body: usize,
    /// Its first contact point: where its twist is taken.
    reference: usize,
    /// The velocity coordinates that move it, from the base outward.
    chain: Vec<usize>,
    /// For each foot before it the number of coordinates that move both.
    shared: Vec<usize>,
    /// Rows of Y along the chain.
    whitened: Vec<[f64; K]>,
}

impl<const D: usize, const K: usize> VelocityStep<D, K> {
    /// Storage for `model`, with its tree as `dynamics` knows it, on `terrain`.
    pub(super) fn new(model: &Model, dynamics: &Dynamics, terrain: &Terrain) -> Self {
        let mut feet: Vec<Foot<K>> = Vec::new();
        let mut foot_of_point = Vec::new();
        for (index, point) in model.contacts.iter().enumerate() {
            let known = feet.iter().position(|foot| foot.body == point.body);
            foot_of_point.push(known.unwrap_or(feet.len()));
            if known.is_none() {
                let chain = dynamics.chain(point.body);
                let common = |foot: &Foot<K>| foot.chain.iter().zip(&chain).take_while(|(a, b)| a == b).count();
                let shared = feet.iter().map(common).collect();
                let whitened = vec![[0.0; K]; chain.len()];
                feet.push(Foot { body: point.body, reference: index, chain, shared, whitened });
            }
        }
        let contacts = ContactSolver::new(&foot_of_point, feet.len());
        let mut step = Self {
            contacts,
            ground: vec![*terrain.base(); foot_of_point.len()],
            together: Simultaneous::new(foot_of_point.len(), feet.len()),
            report: Report::default(),
            factor: TreeFactor::new(model, dynamics),
            before: vec![[0.0; K]; feet.len()],
            feet,
            drive: vec![0.0; model.nv()],
        };
        step.stand_on(terrain);
        step
    }

    /// From now on the feet are on `terrain`.
    pub(super) fn stand_on(&mut self, terrain: &Terrain) {
        self.ground.fill(*terrain.base());
        for point in &mut self.contacts.points {
            (point.friction, point.turn) = (terrain.base().friction, None);
        }
    }

    /// Sets the step up in the configuration of `dynamics`, which knows the velocities before; the contact points move on
    /// for `rest` [s] with the new velocity. Returns false where the mass matrix is not positive definite.
    pub(super) fn prepare(
        &mut self,
        settings: &SimulationSettings,
        terrain: &Terrain,
        dynamics: &Dynamics,
        rest: f64,
    ) -> bool {
        if !self.factor(dynamics) {
            return false;
        }
        let axes = axes::<D>(terrain.base());
        for (index, foot) in self.feet.iter_mut().enumerate() {
            let at = &dynamics.contact_positions[foot.reference];
            self.before[index] = along(&dynamics.motion_at(foot.body, at), &axes);
            for (row, &j) in foot.whitened.iter_mut().zip(&foot.chain) {
                *row = along(&dynamics.unit_motion(j, at), &axes);
            }
            self.factor.whiten(&foot.chain, &mut foot.whitened);
        }
        self.couple();
        if !terrain.is_plane() {
            let points = &self.contacts.points;
            terrain.below(&dynamics.contact_positions, |point| points[point].foot, &mut self.ground);
        }
        let places = self.contacts.points.iter_mut().zip(&self.ground).zip(&dynamics.contact_positions);
        for ((point, ground), position) in places {
            if !terrain.is_plane() {
                point.friction = ground.friction;
                let (sin, cos) = libm::sincos(ground.turn - terrain.base().turn);
                point.turn = (sin != 0.0).then_some([cos, sin]);
            }
            let arm = position - dynamics.contact_positions[self.feet[point.foot].reference];
            for (value, direction) in point.arm.iter_mut().zip(&axes.linear) {
                *value = direction.dot(&arm);
            }
            let gap = terrain.gap(position);
            // A point may close its gap within the step, and recovers from a share of its penetration.
            let share = if gap > 0.0 { 1.0 / rest } else { settings.contact.penetration_recovery / settings.period_s };
            point.approach = -share * gap;
        }
        match settings.contact.model {
            ContactModel::Rigid => {
                self.contacts.prepare();
                self.together.forget();
            }
            ContactModel::SpringDamper => self.spring(settings, terrain, dynamics),
        }
        true
    }

    /// Factorises the mass matrix. Returns false where it is not positive definite.
    pub(super) fn factor(&mut self, dynamics: &Dynamics) -> bool {
        self.factor.factor(&dynamics.mass_matrix)
    }

    /// By how much the coordinate `j` accelerates a unit of force on it, without contacts: `(M⁻¹)_jj`.
    pub(super) fn mobility(&mut self, j: usize) -> f64 {
        self.drive.fill(0.0);
        self.drive[j] = 1.0;
        self.factor.solve_transposed(&mut self.drive);
        self.drive.iter().map(|value| value * value).sum()
    }

    /// `Yᵀ Y`, foot by foot; two feet share only the coordinates that move both.
    fn couple(&mut self) {
        let feet = self.feet.len();
        for a in 0..feet {
            for b in 0..=a {
                let shared = if a == b { self.feet[a].chain.len() } else { self.feet[a].shared[b] };
                let mut block = [[0.0; K]; K];
                for (x, y) in self.feet[a].whitened[..shared].iter().zip(&self.feet[b].whitened) {
                    for i in 0..K {
                        for j in 0..K {
                            block[i][j] += x[i] * y[j];
                        }
                    }
                }
                self.contacts.coupling[a * feet + b] = block;
                self.contacts.coupling[b * feet + a] = std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]));
            }
        }
    }

    /// Impulses of the spring-damper ground over the step (thesis 3.3).
    fn spring(&mut self, settings: &SimulationSettings, terrain: &Terrain, dynamics: &Dynamics) {
        self.report = Report::default();
        for (point, position) in self.contacts.points.iter_mut().zip(&dynamics.contact_positions) {
            let velocity = point.velocity(&self.before[point.foot]);
            let gap = terrain.gap(position);
            spring_damper::force(&settings.contact, point.friction, gap, &velocity, &mut point.impulse);
            point.impulse.iter_mut().for_each(|value| *value *= settings.period_s);
        }
    }

    /// Writes `v⁺` into `next`, where `force` are all generalized forces but those of the contacts.
    pub(super) fn solve(&mut self, settings: &SimulationSettings, v: &[f64], force: &[f64], next: &mut [f64]) {
        let dt = settings.period_s;
        for (drive, force) in self.drive.iter_mut().zip(force) {
            *drive = dt * force;
        }
        self.factor.solve_transposed(&mut self.drive);
        for ((foot, before), free) in self.feet.iter().zip(&self.before).zip(&mut self.contacts.free) {
            *free = *before;
            for (row, &j) in foot.whitened.iter().zip(&foot.chain) {
                for i in 0..K {
                    free[i] += row[i] * self.drive[j];
                }
            }
        }
        match settings.contact.model {
            ContactModel::Rigid => {
                let tolerance = settings.contact.tolerance_n * dt;
                self.report = self.contacts.solve(&mut self.together, tolerance, &settings.contact);
            }
            ContactModel::SpringDamper => self.contacts.load(),
        }
        next.copy_from_slice(&self.drive);
        self.contacts.sum();
        for (foot, total) in self.feet.iter().zip(&self.contacts.total) {
            for (row, &j) in foot.whitened.iter().zip(&foot.chain) {
                next[j] += (0..K).map(|i| row[i] * total[i]).sum::<f64>();
            }
        }
        self.factor.solve(next);
        for (next, v) in next.iter_mut().zip(v) {
            *next += v;
        }
    }

    /// Lets the next solve begin with no impulses.
    pub(super) fn forget(&mut self) {
        self.contacts.points.iter_mut().for_each(|point| point.impulse = [0.0; D]);
    }

    /// Enters the contacts of the step into the books, and writes their mean forces along the model's linear axes [N].
    pub(super) fn account(&self, model: &Model, dt: f64, audit: &mut Audit, forces: &mut [f64]) {
        let mut work = 0.0;
        let points = self.contacts.points.iter().zip(&self.ground);
        for ((point, ground), forces) in points.zip(forces.chunks_exact_mut(D)) {
            let before = point.velocity(&self.before[point.foot]);
            let after = point.velocity(&self.contacts.twist[point.foot]);
            work += audit.contact(ground, dt, &point.impulse, [&before, &after]);
            let mut force = Vector3::zeros();
            for (direction, impulse) in ground.directions().zip(&point.impulse) {
                force += *direction * (*impulse / dt);
            }
            for (value, axis) in forces.iter_mut().zip(model.linear_axes()) {
                *value = axis.dot(&force);
            }
        }
        audit.contact_work(work);
    }
}

/// The axes of a twist.
struct Axes<const D: usize> {
    linear: [Vector3<f64>; D],
    angular: [Vector3<f64>; 3],
}

fn axes<const D: usize>(ground: &Surface) -> Axes<D> {
    let mut directions = ground.directions();
    let linear = std::array::from_fn(|_| *directions.next().expect("a direction for each contact coordinate"));
    let tangents = ground.tangents();
    Axes { linear, angular: [tangents[0], *tangents.get(1).unwrap_or(&Vector3::y()), ground.normal] }
}

/// The coordinates of a motion along `axes`.
#[inline]
fn along<const D: usize, const K: usize>(motion: &Motion, axes: &Axes<D>) -> [f64; K] {
    let mut out = [0.0; K];
    for (value, axis) in out.iter_mut().zip(&axes.linear) {
        *value = axis.dot(&motion.linear);
    }
    if D == 2 {
        out[2] = motion.angular.y;
    } else {
        for (value, axis) in out[D..].iter_mut().zip(&axes.angular) {
            *value = axis.dot(&motion.angular);
        }
    }
    out
}
