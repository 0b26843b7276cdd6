//! Rigid contact with Coulomb friction.
//!
//! Contact points are fixed to feet, and a foot is rigid: contacts act on each other only through the feet's twists. A
//! twist has K coordinates at a point of the foot, the D linear ones along the contact directions (tangents, normal),
//! then the angular ones about the same axes (in the plane the one about y). Impulses on a foot are wrenches in the dual
//! coordinates.
//!
//! All contacts are solved together: `simultaneous.rs`.

use crate::settings::ContactSettings;
use crate::simultaneous::Simultaneous;

/// Outcome of one solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Linear solves for all contacts together.
    pub sweeps: u32,
    /// By how much an impulse's component misses the law at most [Ns].
    pub residual: f64,
}

/// A contact point in a step, where it may touch a piece of ground.
#[derive(Clone, Debug)]
pub(super) struct Point<const D: usize, const K: usize> {
    /// Its foot, in the order of [`ContactSolver::free`].
    pub(super) foot: usize,
    /// Coefficient of friction.
    pub(super) friction: f64,
    /// Cosine and sine of the angle by which its directions are turned against those of the twists, from the first tangent
    /// to the normal; none where they are the same.
    pub(super) turn: Option<[f64; 2]>,
    /// From the foot's point of reference [m].
    pub(super) arm: [f64; D],
    /// The velocity at which it neither slips nor opens [m/s]: the law is that of the velocity above it.
    pub(super) target: [f64; D],
    /// λ [Ns]; also the first guess.
    pub(super) impulse: [f64; D],
    /// Normal velocity for a unit normal impulse [1/kg].
    pub(super) gain: f64,
}

/// A contact problem and its solution, all preallocated.
#[derive(Clone, Debug)]
pub(super) struct ContactSolver<const D: usize, const K: usize> {
    /// The contact points that may touch.
    pub(super) points: Vec<Point<D, K>>,
    /// Twist of foot a for unit wrenches on foot b, block a · feet + b, each symmetric to its mirror.
    pub(super) coupling: Vec<[[f64; K]; K]>,
    /// Twists of the feet without contact impulses.
    pub(super) free: Vec<[f64; K]>,
    /// Twists of the feet with them.
    pub(super) twist: Vec<[f64; K]>,
    /// Wrenches of the impulses on the feet, as of the latest [`ContactSolver::load`].
    pub(super) total: Vec<[f64; K]>,
}

impl<const D: usize, const K: usize> Point<D, K> {
    /// A point at `arm` [m] of `foot`.
    pub(super) fn new(foot: usize, arm: [f64; D], friction: f64) -> Self {
        Self { foot, friction, turn: None, arm, target: [0.0; D], impulse: [0.0; D], gain: 0.0 }
    }

    /// Its velocity where the foot's is `twist`.
    #[inline]
    pub(super) fn velocity(&self, twist: &[f64; K]) -> [f64; D] {
        let mut velocity = velocity_at(twist, &self.arm);
        if let Some([cos, sin]) = self.turn {
            let (tangent, normal) = (velocity[0], velocity[D - 1]);
            (velocity[0], velocity[D - 1]) = (cos * tangent + sin * normal, cos * normal - sin * tangent);
        }
        velocity
    }

    /// Its velocity above the target.
    #[inline]
    pub(super) fn motion(&self, twist: &[f64; K]) -> [f64; D] {
        let velocity = self.velocity(twist);
        std::array::from_fn(|i| velocity[i] - self.target[i])
    }

    /// The wrench of an impulse on it: the transpose of [`Point::velocity`].
    #[inline]
    pub(super) fn wrench(&self, impulse: &[f64; D]) -> [f64; K] {
        let Some([cos, sin]) = self.turn else { return wrench(impulse, &self.arm) };
        let (tangent, normal) = (impulse[0], impulse[D - 1]);
        let mut turned = *impulse;
        (turned[0], turned[D - 1]) = (cos * tangent - sin * normal, cos * normal + sin * tangent);
        wrench(&turned, &self.arm)
    }

    /// By how much its impulse misses the law where the foot's twist is `twist` [Ns]: how far a step against the velocity that
    /// stays in the cone moves it.
    fn residual(&self, twist: &[f64; K]) -> f64 {
        let (motion, n) = (self.motion(twist), D - 1);
        let mut next: [f64; D] = std::array::from_fn(|i| self.impulse[i] - motion[i] / self.gain);
        next[n] = next[n].max(0.0);
        let limit = self.friction * self.impulse[n].max(0.0);
        let tangent = norm(&next[..n]);
        if tangent > limit {
            next[..n].iter_mut().for_each(|value| *value *= limit / tangent);
        }
        (0..D).map(|i| (next[i] - self.impulse[i]).abs()).fold(0.0, f64::max)
    }
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|value| value * value).sum::<f64>().sqrt()
}

pub(super) fn unit<const D: usize>(index: usize) -> [f64; D] {
    std::array::from_fn(|i| if i == index { 1.0 } else { 0.0 })
}

/// `sum += more`
#[inline]
pub(super) fn add<const K: usize>(sum: &mut [f64; K], more: &[f64; K]) {
    for i in 0..K {
        sum[i] += more[i];
    }
}

/// Velocity of a point that is `arm` away from where `twist` is taken.
#[inline]
pub(super) fn velocity_at<const D: usize, const K: usize>(twist: &[f64; K], arm: &[f64; D]) -> [f64; D] {
    let mut out = [0.0; D];
    if D == 2 {
        // ω ŷ × r, where ŷ × t = -n and ŷ × n = t
        out[0] = twist[0] + twist[2] * arm[1];
        out[1] = twist[1] - twist[2] * arm[0];
    } else {
        let (w, r) = (&twist[3..], arm);
        out[0] = twist[0] + w[1] * r[2] - w[2] * r[1];
        out[1] = twist[1] + w[2] * r[0] - w[0] * r[2];
        out[2] = twist[2] + w[0] * r[1] - w[1] * r[0];
    }
    out
}

/// The wrench of an impulse that acts `arm` away from where wrenches are taken: the transpose of [`velocity_at`].
#[inline]
pub(super) fn wrench<const D: usize, const K: usize>(impulse: &[f64; D], arm: &[f64; D]) -> [f64; K] {
    let mut out = [0.0; K];
    out[..D].copy_from_slice(impulse);
    if D == 2 {
        out[2] = arm[1] * impulse[0] - arm[0] * impulse[1];
    } else {
        let (f, r) = (impulse, arm);
        out[3] = r[1] * f[2] - r[2] * f[1];
        out[4] = r[2] * f[0] - r[0] * f[2];
        out[5] = r[0] * f[1] - r[1] * f[0];
    }
    out
}

/// `out += B x` for a symmetric B.
#[inline]
fn add_product<const K: usize>(b: &[[f64; K]; K], x: &[f64; K], out: &mut [f64; K]) {
    for (row, factor) in b.iter().zip(x) {
        for i in 0..K {
            out[i] += row[i] * factor;
        }
    }
}

impl<const D: usize, const K: usize> ContactSolver<D, K> {
    /// Storage for so many points on `feet` feet.
    pub(super) fn new(points: usize, feet: usize) -> Self {
        Self {
            points: Vec::with_capacity(points),
            coupling: vec![[[0.0; K]; K]; feet * feet],
            free: vec![[0.0; K]; feet],
            twist: vec![[0.0; K]; feet],
            total: vec![[0.0; K]; feet],
        }
    }

    /// Sets up what the solves of a step share, after `coupling` and the points' arms are.
    pub(super) fn prepare(&mut self) {
        let feet = self.free.len();
        for point in &mut self.points {
            let mut twist = [0.0; K];
            add_product(&self.coupling[point.foot * (feet + 1)], &point.wrench(&unit(D - 1)), &mut twist);
            point.gain = point.velocity(&twist)[D - 1];
        }
    }

    /// `total` of the impulses, and `twist = free + B total`.
    pub(super) fn load(&mut self) {
        self.total.fill([0.0; K]);
        for point in &self.points {
            add(&mut self.total[point.foot], &point.wrench(&point.impulse));
        }
        for foot in 0..self.free.len() {
            let response = self.response(foot, &self.total);
            self.twist[foot] = std::array::from_fn(|i| self.free[foot][i] + response[i]);
        }
    }

    /// The change of a foot's twist for `wrenches` on the feet: its row of B.
    #[inline]
    pub(super) fn response(&self, foot: usize, wrenches: &[[f64; K]]) -> [f64; K] {
        let mut out = [0.0; K];
        for (wrench, blocks) in wrenches.iter().zip(self.coupling.chunks_exact(wrenches.len())) {
            add_product(&blocks[foot], wrench, &mut out);
        }
        out
    }

    /// By how much an impulse's component misses the law at most [Ns], as of the latest twists.
    pub(super) fn residual(&self) -> f64 {
        self.points.iter().map(|point| point.residual(&self.twist[point.foot])).fold(0.0, f64::max)
    }

    /// Solves for the points' impulses until none misses the law by more than `tolerance` [Ns], with those that they have as a
    /// first guess of which slip and which stick.
    pub(super) fn solve(
        &mut self,
        together: &mut Simultaneous<D, K>,
        tolerance: f64,
        settings: &ContactSettings,
    ) -> Report {
        if self.points.is_empty() {
            self.load();
            return Report::default();
        }
        together.solve(self, tolerance, settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SimulationSettings;

    /// A bar of mass 2 and inertia 0.5 that lands flat on two points half a metre from its centre, moving sideways.
    #[test]
    fn two_coupled_contacts_converge_to_the_law() {
        let (mass, inertia, half) = (2.0, 0.5, 0.5);
        let mut solver = ContactSolver::<2, 3>::new(2, 1);
        solver.points = vec![Point::new(0, [-half, -0.1], 0.05), Point::new(0, [half, -0.1], 0.05)];
        solver.coupling[0] = [[1.0 / mass, 0.0, 0.0], [0.0, 1.0 / mass, 0.0], [0.0, 0.0, 1.0 / inertia]];
        solver.free[0] = [0.3, -1.0, 0.0];
        solver.prepare();
        let settings = SimulationSettings::default().contact;
        let report = solver.solve(&mut Simultaneous::new(2, 1), 1e-12, &settings);
        assert!(report.residual <= 1e-12 && report.sweeps >= 1, "{report:?}");
        for point in &solver.points {
            let velocity = velocity_at(&solver.twist[0], &point.arm);
            assert!(velocity[1].abs() < 1e-10, "normal velocity {}", velocity[1]);
            let [tangent, normal] = point.impulse;
            assert!((tangent + 0.05 * normal).abs() < 1e-10, "slips forward on the edge of the cone");
        }
        let total: f64 = solver.points.iter().map(|point| point.impulse[1]).sum();
        assert!((total - mass).abs() < 1e-10, "the normal impulses stop the fall");
    }

    /// A box foot of 2 kg under a load that leans: four corners, of which nothing tells how they share it.
    fn loaded_foot() -> ContactSolver<3, 6> {
        let mut solver = ContactSolver::<3, 6>::new(4, 1);
        for (i, gain) in [0.5, 0.5, 0.02, 40.0, 25.0, 50.0].into_iter().enumerate() {
            solver.coupling[0][i][i] = gain;
        }
        solver.coupling[0][0][4] = 2.0;
        solver.coupling[0][4][0] = 2.0;
        solver.free[0] = [0.02, -0.01, -0.03, 0.05, -0.04, 0.01];
        let corners = [[-0.1, -0.06], [-0.1, 0.06], [0.2, -0.06], [0.2, 0.06]];
        solver.points = corners.map(|[x, y]| Point::new(0, [x, y, 0.0], 0.7)).to_vec();
        solver.prepare();
        solver
    }

    #[test]
    fn a_foot_on_four_corners_moves_as_one_whatever_the_visits_began_with() {
        let settings = SimulationSettings::default().contact;
        let (mut twists, mut loads) = (Vec::new(), Vec::new());
        for first in [0.0, 0.3, 2.0] {
            let mut solver = loaded_foot();
            solver.points[0].impulse = [0.0, 0.0, first];
            let report = solver.solve(&mut Simultaneous::new(4, 1), 1e-12, &settings);
            assert!(report.residual <= 1e-12, "{report:?}");
            for point in &solver.points {
                let velocity = velocity_at(&solver.twist[0], &point.arm);
                assert!(velocity[2] > -1e-10 && point.impulse[2] >= 0.0);
                assert!((velocity[2] * point.impulse[2]).abs() < 1e-10, "pushes while opening");
            }
            // The twist is that of the impulses, not of what the visits added up.
            let twist = solver.twist[0];
            solver.load();
            assert!((0..6).all(|i| (twist[i] - solver.twist[0][i]).abs() < 1e-13));
            twists.push(twist);
            loads.push(solver.points.iter().map(|point| point.impulse[2]).collect::<Vec<_>>());
        }
        for (other, shared) in twists.iter().zip(&loads) {
            assert!((0..6).all(|i| (other[i] - twists[0][i]).abs() < 1e-9), "{twists:?}");
            // Of all ways to share the load that of least norm, not that of the guess.
            assert!((0..4).all(|k| (shared[k] - loads[0][k]).abs() < 1e-9), "{loads:?}");
        }
    }

    /// Two corners on a diagonal have a gap left, as small as rounding: no twist closes it and keeps the others' height. The
    /// visits unloaded a corner by the same little in each sweep, and the solve of all contacts was refused because its
    /// impulse would have been negative.
    #[test]
    fn corners_that_ask_for_more_than_a_rigid_foot_can_do_were_unloaded_forever() {
        let settings = SimulationSettings::default().contact;
        for difference in [1e-9, 1e-7, 1e-5] {
            let mut solver = loaded_foot();
            solver.points.iter_mut().for_each(|point| point.impulse = [0.0, 0.0, 0.1]);
            (solver.points[0].target[2], solver.points[3].target[2]) = (difference, difference);
            let report = solver.solve(&mut Simultaneous::new(4, 1), 1e-12, &settings);
            assert!(report.residual <= 1e-12 && report.sweeps <= 20, "{difference}: {report:?}");
            for point in &solver.points {
                let opening = velocity_at(&solver.twist[0], &point.arm)[2] - point.target[2];
                assert!(
                    opening > -1e-10 && (opening * point.impulse[2]).abs() < 1e-10,
                    "{opening} {:?}",
                    point.impulse
                );
            }
        }
    }

    #[test]
    fn the_residual_that_is_told_was_that_of_other_impulses() {
        let settings = SimulationSettings::default().contact;
        for k in 0..200 {
            let mut solver = loaded_foot();
            solver.points.iter_mut().for_each(|point| point.impulse = [0.0, 0.0, 0.1]);
            let warp = 1e-10 * libm::pow(1e5, f64::from(k) / 200.0);
            (solver.points[0].target[0], solver.points[3].target[1]) = (warp, -warp);
            (solver.points[0].target[2], solver.points[3].target[2]) = (warp, 0.3 * warp);
            let report = solver.solve(&mut Simultaneous::new(4, 1), 1e-9, &settings);
            let held = solver.residual();
            assert!((held - report.residual).abs() <= 1e-9 * held, "{warp}: {held} and {report:?}");
        }
    }

    #[test]
    fn arms_carry_velocities_and_impulses_alike() {
        // Power is the same at the point and at the foot: λ · v = wrench · twist.
        let (twist, arm, impulse) = ([0.1, -0.2, 0.3, 0.4, -0.5, 0.6], [0.7, -0.8, 0.9], [1.0, 2.0, -3.0]);
        let power: f64 = velocity_at(&twist, &arm).iter().zip(&impulse).map(|(v, f)| v * f).sum();
        let same: f64 = wrench::<3, 6>(&impulse, &arm).iter().zip(&twist).map(|(f, v)| f * v).sum();
        assert!((power - same).abs() < 1e-14);
        let (twist, arm, impulse) = ([0.1, -0.2, 0.3], [0.7, -0.8], [1.0, 2.0]);
        let power: f64 = velocity_at(&twist, &arm).iter().zip(&impulse).map(|(v, f)| v * f).sum();
        let same: f64 = wrench::<2, 3>(&impulse, &arm).iter().zip(&twist).map(|(f, v)| f * v).sum();
        assert!((power - same).abs() < 1e-14);
        // So it is along directions that are turned.
        let mut point = Point::<2, 3>::new(0, arm, 0.5);
        point.turn = Some([0.8, 0.6]);
        let power: f64 = point.velocity(&twist).iter().zip(&impulse).map(|(v, f)| v * f).sum();
        let same: f64 = point.wrench(&impulse).iter().zip(&twist).map(|(f, v)| f * v).sum();
        assert!((power - same).abs() < 1e-14);
    }
}
