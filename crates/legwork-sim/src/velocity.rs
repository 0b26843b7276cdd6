//! The velocities after a step or an impact: `M (v⁺ - v) = dt (f - h) + Jᵀ λ`, with the contact impulses λ of rigid contact
//! or of the spring-damper ground.
//!
//! With `M = Lᵀ L` and `Y = L⁻ᵀ Jᵀ`, where J are the twists of the feet: contacts act by `Yᵀ Y`, and
//! `v⁺ = v + L⁻¹ (dt L⁻ᵀ (f - h) + Y F)`. A column of Y is nonzero only along its foot's chain.

use legwork_rbd::{Dynamics, Model, Motion};
use nalgebra::Vector3;

use super::audit::Audit;
use super::contact_solver::{ContactSolver, Point, Report};
use super::simultaneous::Simultaneous;
use super::spring_damper;
use super::tree_factor::TreeFactor;
use crate::settings::{ContactModel, SimulationSettings};
use legwork_contract::contact::Surface;
use legwork_contract::terrain::{Piece, Terrain};

/// Contact points are left out of a step that are farther from the ground than this, and than they could move in some steps [m].
const NEAR: f64 = 0.005;

/// A foot whose contact points are deeper in the ground stays there [m].
const DEEP: f64 = 1e-4;

/// A smaller gap is none [m].
const CLOSED: f64 = 1e-5;

/// Contact points that meet the ground more slowly do not divide a step [m/s].
const SLOW: f64 = 1e-5;

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
    /// The foot of each contact point.
    foot_of: Vec<usize>,
    /// What each contact point carried last, and on which pieces of ground.
    memory: Vec<[Option<Memory<D>>; 2]>,
    /// What each of the solver's points is.
    places: Vec<Place>,
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
    rest: Option<Rest>,
}

/// How a foot rests on the ground.
#[derive(Clone, Copy, Debug)]
struct Rest {
    /// The piece of ground that its first contact point rests on, by where that begins.
    begin: f64,
    /// What it carried [Ns].
    load: f64,
    /// The centre of the load that it carried [m].
    centre: Vector3<f64>,
    /// J̇ v there, angular and linear.
    bias: Motion,
    /// It rests on one piece of ground and is not deep in it: gaps are to be closed.
    closes: bool,
}

impl Default for Rest {
    fn default() -> Self {
        Self { begin: 0.0, load: 0.0, centre: Vector3::zeros(), bias: Motion::zero(), closes: true }
    }
}

impl Rest {
    /// J̇ v at `position`, but for what the foot turns about the centre: that is what a rigid foot can do.
    fn bias_at(&self, position: &Vector3<f64>) -> Vector3<f64> {
        self.bias.linear + self.bias.angular.cross(&(position - self.centre))
    }
}

/// What a contact point did on a piece of ground in the step before.
#[derive(Clone, Copy, Debug)]
struct Memory<const D: usize> {
    /// Where the piece begins along x [m]: which piece it is.
    begin: f64,
    impulse: [f64; D],
    /// Whether it rests there: it was carried, and had no gap left to close.
    rests: bool,
}

/// What a contact point did on `piece` in the step before, if it met that.
fn remembered<'a, const D: usize>(memory: &'a [Option<Memory<D>>; 2], piece: &Piece) -> Option<&'a Memory<D>> {
    memory.iter().flatten().find(|memory| memory.begin == piece.ends[0])
}

/// A contact point on a piece of ground.
#[derive(Clone, Copy, Debug)]
struct Place {
    contact: usize,
    /// Which of its pieces.
    slot: usize,
    surface: Surface,
    begin: f64,
    /// Its distance from the piece [m].
    gap: f64,
    /// It rests, or meets the ground now, and has no gap left to close.
    rests: bool,
}

/// Where in time the velocities change, and what of the ground is met there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moment {
    /// Forces act for `period` [s], and the contact points move with the velocity before for `ahead`, then with the one after.
    /// Gaps of what rests are closed in the time of a whole step, `pace` [s].
    Step { period: f64, ahead: f64, pace: f64 },
    /// An impact: contact points whose gap is at most `reach` [m] stop, at once.
    Impact { reach: f64 },
}

impl<const D: usize, const K: usize> VelocityStep<D, K> {
    /// Storage for `model`, with its tree as `dynamics` knows it.
    pub(super) fn new(model: &Model, dynamics: &Dynamics) -> Self {
        let mut feet: Vec<Foot<K>> = Vec::new();
        let mut foot_of = Vec::new();
        for (index, point) in model.contacts.iter().enumerate() {
            let known = feet.iter().position(|foot| foot.body == point.body);
            foot_of.push(known.unwrap_or(feet.len()));
            if known.is_none() {
                let chain = dynamics.chain(point.body);
                let common = |foot: &Foot<K>| foot.chain.iter().zip(&chain).take_while(|(a, b)| a == b).count();
                let shared = feet.iter().map(common).collect();
                let whitened = vec![[0.0; K]; chain.len()];
                feet.push(Foot { body: point.body, reference: index, chain, shared, whitened, rest: None });
            }
        }
        // A point may meet two pieces of ground, in a hollow.
        let points = 2 * foot_of.len();
        Self {
            contacts: ContactSolver::new(points, feet.len()),
            memory: vec![[None; 2]; foot_of.len()],
            places: Vec::with_capacity(points),
            together: Simultaneous::new(points, feet.len()),
            report: Report::default(),
            factor: TreeFactor::new(model, dynamics),
            before: vec![[0.0; K]; feet.len()],
            feet,
            foot_of,
            drive: vec![0.0; model.nv()],
        }
    }

    /// When a contact point first meets the ground within `time` [s], where all move on as they do in `dynamics`.
    pub(super) fn landing(&self, terrain: &Terrain, dynamics: &Dynamics, time: f64) -> Option<f64> {
        let mut first = None;
        for ((position, &foot), memory) in dynamics.contact_positions.iter().zip(&self.foot_of).zip(&self.memory) {
            let rests = |piece: &Piece| remembered(memory, piece).is_some_and(|memory| memory.rests);
            let velocity = dynamics.motion_at(self.feet[foot].body, position).linear;
            let at = terrain.landing(position, &velocity, first.unwrap_or(time), SLOW, rests);
            first = at.or(first);
        }
        first
    }

    /// Sets the change of velocity at a `moment` up in the configuration of `dynamics`, which knows the velocities before.
    /// Returns false where the mass matrix is not positive definite.
    pub(super) fn prepare(
        &mut self,
        settings: &SimulationSettings,
        terrain: &Terrain,
        dynamics: &Dynamics,
        moment: Moment,
    ) -> bool {
        if !self.factor(dynamics) {
            return false;
        }
        let axes = axes::<D>(terrain.base());
        for (index, foot) in self.feet.iter_mut().enumerate() {
            let at = &dynamics.contact_positions[foot.reference];
            self.before[index] = along(&dynamics.motion_at(foot.body, at), &axes);
            for (row, &j) in foot.whitened.iter_mut().zip(&foot.chain) {
                *row = along(&dynamics.unit_motion(foot.body, j, at), &axes);
            }
            self.factor.whiten(&foot.chain, &mut foot.whitened);
        }
        self.couple();
        self.find_rest(terrain, dynamics);
        self.contacts.points.clear();
        self.places.clear();
        for (contact, position) in dynamics.contact_positions.iter().enumerate() {
            for (slot, piece) in terrain.pieces_near(position).iter().enumerate() {
                if let Some(piece) = piece {
                    self.meet(terrain, dynamics, &axes, moment, Met { contact, position, slot, piece });
                }
            }
        }
        match settings.contact.model {
            ContactModel::Rigid => {
                self.contacts.prepare();
                self.together.forget();
            }
            ContactModel::SpringDamper => self.spring(settings),
        }
        true
    }

    /// Finds how each foot rests on the ground.
    fn find_rest(&mut self, terrain: &Terrain, dynamics: &Dynamics) {
        self.feet.iter_mut().for_each(|foot| foot.rest = None);
        for ((memory, &foot), position) in self.memory.iter().zip(&self.foot_of).zip(&dynamics.contact_positions) {
            for memory in memory.iter().flatten().filter(|memory| memory.rests) {
                let load = memory.impulse[D - 1];
                let rest = self.feet[foot].rest.get_or_insert(Rest { begin: memory.begin, ..Rest::default() });
                rest.load += load;
                rest.centre += position * load;
                // Ground that gave way deeper than steps do would give energy if it came back.
                rest.closes &= rest.begin == memory.begin && terrain.gap(position) > -DEEP;
            }
        }
        for foot in &mut self.feet {
            if let Some(rest) = &mut foot.rest {
                rest.centre /= rest.load;
                let angular = dynamics.angular_bias(foot.body);
                rest.bias = Motion { angular, linear: dynamics.point_bias(foot.body, &rest.centre) };
            }
        }
    }

    /// Adds a contact point on a piece of ground to those that may touch, if it is near enough.
    fn meet(&mut self, terrain: &Terrain, dynamics: &Dynamics, axes: &Axes<D>, moment: Moment, met: Met<'_>) {
        let Met { contact, position, slot, piece } = met;
        let gap = piece.gap(position);
        let foot = self.foot_of[contact];
        let body = self.feet[foot].body;
        let near = match moment {
            Moment::Impact { reach } => gap <= reach,
            Moment::Step { period, .. } => {
                gap <= NEAR || gap <= NEAR + 4.0 * period * dynamics.motion_at(body, position).linear.norm()
            }
        };
        if !near {
            return;
        }
        let surface = terrain.surface(piece, position);
        let arm = position - dynamics.contact_positions[self.feet[foot].reference];
        let arm = std::array::from_fn(|i| axes.linear[i].dot(&arm));
        let mut point = Point::new(foot, arm, surface.friction);
        if !terrain.is_even() {
            let (sin, cos) = libm::sincos(surface.turn - terrain.base().turn);
            point.turn = (sin != 0.0).then_some([cos, sin]);
        }
        let known = remembered(&self.memory[contact], piece);
        let closes = self.feet[foot].rest.is_some_and(|rest| rest.closes);
        let rests = match moment {
            Moment::Impact { .. } => true,
            Moment::Step { .. } => known.is_some_and(|memory| memory.rests) || gap <= CLOSED,
        };
        if let Some(memory) = known {
            point.impulse = memory.impulse;
        }
        if let Moment::Step { period, ahead, pace } = moment {
            if let Some(rest) = &self.feet[foot].rest {
                // At the end of the step it shall not move. On the way there it turns by J̇ v.
                let bias = rest.bias_at(position);
                for (target, direction) in point.target.iter_mut().zip(surface.directions()) {
                    *target = -0.5 * period * direction.dot(&bias);
                }
            }
            let normal = &mut point.target[D - 1];
            if !rests {
                // It arrives: what it meets on the way does not hold it yet.
                *normal = -gap / (period - ahead);
                point.friction = 0.0;
            } else if closes {
                // Nor shall it have a gap.
                *normal -= (gap + *normal * ahead * ahead / period) / pace;
            }
        }
        self.places.push(Place { contact, slot, surface, begin: piece.ends[0], gap, rests });
        self.contacts.points.push(point);
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
    fn spring(&mut self, settings: &SimulationSettings) {
        self.report = Report::default();
        for (point, place) in self.contacts.points.iter_mut().zip(&self.places) {
            let velocity = point.velocity(&self.before[point.foot]);
            // Its friction is against the velocity before.
            point.target = [0.0; D];
            // It pushes out of the piece below alone.
            let gap = if place.slot == 0 { place.gap } else { 0.0 };
            spring_damper::force(&settings.contact, point.friction, gap, &velocity, &mut point.impulse);
            point.impulse.iter_mut().for_each(|value| *value *= settings.period_s);
        }
    }

    /// Writes `v⁺` into `next`, where `force` are all generalized forces but those of the contacts, which act for `period` [s].
    pub(super) fn solve(
        &mut self,
        settings: &SimulationSettings,
        period: f64,
        v: &[f64],
        force: &[f64],
        next: &mut [f64],
    ) {
        for (drive, force) in self.drive.iter_mut().zip(force) {
            *drive = period * force;
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
                let tolerance = settings.contact.tolerance_n * settings.period_s;
                self.report = self.contacts.solve(&mut self.together, tolerance, &settings.contact);
            }
            ContactModel::SpringDamper => self.contacts.load(),
        }
        next.copy_from_slice(&self.drive);
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

    /// Forgets what the contacts carried.
    pub(super) fn forget(&mut self) {
        self.memory.fill([None; 2]);
    }

    /// Enters the contacts of a change of velocity into the books, adds their forces along the model's linear axes, as means over
    /// a step, to `forces` [N], and remembers what they carried.
    pub(super) fn account(
        &mut self,
        model: &Model,
        settings: &SimulationSettings,
        moment: Moment,
        audit: &mut Audit,
        forces: &mut [f64],
    ) {
        let (dt, is_rigid) = (settings.period_s, settings.contact.model == ContactModel::Rigid);
        let (is_impact, time) = match moment {
            Moment::Impact { .. } => (true, 0.0),
            Moment::Step { period, .. } => (false, period),
        };
        if !is_impact {
            self.memory.fill([None; 2]);
        }
        let mut work = 0.0;
        for (point, place) in self.contacts.points.iter().zip(&self.places) {
            let before = point.velocity(&self.before[point.foot]);
            let after = point.velocity(&self.contacts.twist[point.foot]);
            let motion = if is_rigid { std::array::from_fn(|i| after[i] - point.target[i]) } else { before };
            work += audit.contact(&place.surface, [dt, time], &point.impulse, [&before, &after], &motion);
            let mut force = Vector3::zeros();
            for (direction, impulse) in place.surface.directions().zip(&point.impulse) {
                force += *direction * (*impulse / dt);
            }
            for (value, axis) in forces[place.contact * D..].iter_mut().zip(model.linear_axes()) {
                *value += axis.dot(&force);
            }
            if is_impact && point.impulse[D - 1] == 0.0 {
                // Whatever it rested on it still rests on.
                continue;
            }
            let rests = place.rests && point.impulse[D - 1] > 0.0;
            let memory = Memory { begin: place.begin, impulse: point.impulse, rests };
            self.memory[place.contact][place.slot] = Some(memory);
        }
        audit.contact_work(work);
    }
}

/// A contact point at a piece of ground.
struct Met<'a> {
    contact: usize,
    position: &'a Vector3<f64>,
    slot: usize,
    piece: &'a Piece,
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
