//! Rigid contact with Coulomb friction by a per-contact iteration. Thesis Appendix A; Hwangbo, Lee and Hutter 2018.
//!
//! Contacts are visited in turn; each is solved exactly, given the impulses of the others, until no impulse changes
//! any more. The iteration begins with the impulses of the step before.
//!
//! Contact points are fixed to feet, and a foot is rigid: contacts act on each other only through the feet's twists. A
//! twist has K coordinates at a point of the foot, the D linear ones along the contact directions (tangents, normal),
//! then the angular ones about the same axes (in the plane the one about y). Impulses on a foot are wrenches in the dual
//! coordinates.

use crate::contact_law::{in_cone, inverse, slip};
use crate::settings::ContactSettings;
use crate::simultaneous::Simultaneous;

/// After this sweep, and after twice as many and so on, all contacts are solved together where that is not done first.
const FIRST_WALK: u32 = 3;

/// Outcome of one solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Sweeps over all contacts.
    pub sweeps: u32,
    /// Largest change of an impulse's component in the last sweep [Ns].
    pub residual: f64,
}

/// A contact point in a step.
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
    /// Lowest normal velocity allowed [m/s]: negative while there is a gap left.
    pub(super) approach: f64,
    /// λ [Ns]; also the first guess.
    pub(super) impulse: [f64; D],
    /// Twist of the foot for unit impulses, by columns.
    response: [[f64; K]; D],
    /// Velocity of the point for unit impulses, G of the contact [1/kg], and its inverse.
    block: [[f64; D]; D],
    inverse: [[f64; D]; D],
}

/// A contact problem and its solution, all preallocated.
#[derive(Clone, Debug)]
pub(super) struct ContactSolver<const D: usize, const K: usize> {
    /// The contact points.
    pub(super) points: Vec<Point<D, K>>,
    /// Twist of foot a for unit wrenches on foot b, block a · feet + b, each symmetric to its mirror.
    pub(super) coupling: Vec<[[f64; K]; K]>,
    /// Twists of the feet without contact impulses.
    pub(super) free: Vec<[f64; K]>,
    /// Twists of the feet with them.
    pub(super) twist: Vec<[f64; K]>,
    /// Wrenches of the impulses on the feet, as of the latest [`ContactSolver::load`] or [`ContactSolver::sum`].
    pub(super) total: Vec<[f64; K]>,
}

impl<const D: usize, const K: usize> Point<D, K> {
    /// Normal velocity for a unit normal impulse [1/kg].
    pub(super) fn normal_gain(&self) -> f64 {
        self.block[D - 1][D - 1]
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

    /// The wrench of an impulse on it: the transpose of [`Point::velocity`].
    #[inline]
    pub(super) fn wrench(&self, impulse: &[f64; D]) -> [f64; K] {
        let Some([cos, sin]) = self.turn else { return wrench(impulse, &self.arm) };
        let (tangent, normal) = (impulse[0], impulse[D - 1]);
        let mut turned = *impulse;
        (turned[0], turned[D - 1]) = (cos * tangent - sin * normal, cos * normal + sin * tangent);
        wrench(&turned, &self.arm)
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
    /// Storage for contact points, each with its foot, on `feet` feet.
    pub(super) fn new(foot_of_point: &[usize], feet: usize) -> Self {
        let point = |&foot: &usize| Point {
            foot,
            friction: 0.0,
            turn: None,
            arm: [0.0; D],
            approach: 0.0,
            impulse: [0.0; D],
            response: [[0.0; K]; D],
            block: [[0.0; D]; D],
            inverse: [[0.0; D]; D],
        };
        Self {
            points: foot_of_point.iter().map(point).collect(),
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
            let own = &self.coupling[point.foot * (feet + 1)];
            for k in 0..D {
                let mut direction = [0.0; D];
                direction[k] = 1.0;
                let force = point.wrench(&direction);
                let mut twist = [0.0; K];
                if point.turn.is_some() {
                    add_product(own, &force, &mut twist);
                } else {
                    twist = own[k];
                    for j in D..K {
                        for i in 0..K {
                            twist[i] += own[j][i] * force[j];
                        }
                    }
                }
                point.response[k] = twist;
                point.block[k] = point.velocity(&twist);
            }
            point.inverse = inverse(&point.block);
        }
    }

    /// Adds the impulses up to the wrenches on the feet.
    pub(super) fn sum(&mut self) {
        self.total.fill([0.0; K]);
        for point in &self.points {
            let wrench = point.wrench(&point.impulse);
            let total = &mut self.total[point.foot];
            for i in 0..K {
                total[i] += wrench[i];
            }
        }
    }

    /// `twist = free + B total`
    pub(super) fn load(&mut self) {
        self.sum();
        self.twist.copy_from_slice(&self.free);
        let feet = self.free.len();
        for (total, blocks) in self.total.iter().zip(self.coupling.chunks_exact(feet.max(1))) {
            for (twist, block) in self.twist.iter_mut().zip(blocks) {
                add_product(block, total, twist);
            }
        }
    }

    /// Solves for the points' impulses, beginning with those that they have;
    /// stops when no impulse changes by more than `tolerance` [Ns] in a sweep over all contacts.
    pub(super) fn solve(
        &mut self,
        together: &mut Simultaneous<D, K>,
        tolerance: f64,
        settings: &ContactSettings,
    ) -> Report {
        self.load();
        // Where each foot has one contact visits converge fast; without a first guess they are even-handed.
        let several = self.points.len() > self.free.len();
        let guessed = self.points.iter().any(|point| point.impulse[D - 1] > 0.0);
        let mut walk = if several && guessed { 0 } else { FIRST_WALK };
        let alpha = if self.points.len() == 1 { 1.0 } else { settings.relaxation };
        let mut report = Report::default();
        for sweep in 1..=settings.max_sweeps {
            // Ever more seldom, so that guesses that lead nowhere cannot keep the visits from converging.
            if sweep > walk {
                together.walk(self, tolerance);
                walk = (2 * walk).max(1);
            }
            report = Report { sweeps: sweep, residual: 0.0 };
            for index in 0..self.points.len() {
                report.residual = report.residual.max(self.visit(index, alpha));
            }
            if report.residual <= tolerance {
                break;
            }
        }
        report
    }

    /// Solves one contact given the others; returns the largest change.
    #[inline]
    fn visit(&mut self, index: usize, alpha: f64) -> f64 {
        let feet = self.free.len();
        let point = &mut self.points[index];
        let (old, friction) = (point.impulse, point.friction);
        let mut velocity = point.velocity(&self.twist[point.foot]);
        velocity[D - 1] -= point.approach;
        // The point's velocity without its own impulse.
        let c: [f64; D] =
            std::array::from_fn(|i| velocity[i] - (0..D).map(|j| point.block[i][j] * old[j]).sum::<f64>());
        let mut solved = [0.0; D];
        if c[D - 1] <= 0.0 {
            solved = std::array::from_fn(|i| old[i] - (0..D).map(|j| point.inverse[i][j] * velocity[j]).sum::<f64>());
            if !in_cone(&solved, friction) {
                solved = slip(&point.block, &c, friction, &solved, &old);
            }
        }
        let step: [f64; D] = std::array::from_fn(|i| alpha * (solved[i] - old[i]));
        let change = step.iter().fold(0.0, |largest: f64, value| value.abs().max(largest));
        if change == 0.0 {
            return 0.0;
        }
        for i in 0..D {
            point.impulse[i] += step[i];
        }
        let wrench = point.wrench(&step);
        let foot = point.foot;
        for (other, twist) in self.twist.iter_mut().enumerate() {
            if other == foot {
                for (response, step) in point.response.iter().zip(&step) {
                    for i in 0..K {
                        twist[i] += response[i] * step;
                    }
                }
            } else {
                add_product(&self.coupling[foot * feet + other], &wrench, twist);
            }
        }
        change
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
        let mut solver = ContactSolver::<2, 3>::new(&[0, 0], 1);
        solver.coupling[0] = [[1.0 / mass, 0.0, 0.0], [0.0, 1.0 / mass, 0.0], [0.0, 0.0, 1.0 / inertia]];
        solver.free[0] = [0.3, -1.0, 0.0];
        (solver.points[0].arm, solver.points[1].arm) = ([-half, -0.1], [half, -0.1]);
        solver.points.iter_mut().for_each(|point| point.friction = 0.05);
        solver.prepare();
        let settings = SimulationSettings::default().contact;
        let report = solver.solve(&mut Simultaneous::new(2, 1), 1e-12, &settings);
        assert!(report.residual <= 1e-12 && report.sweeps > 1, "{report:?}");
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
        let mut solver = ContactSolver::<3, 6>::new(&[0; 4], 1);
        for (i, gain) in [0.5, 0.5, 0.02, 40.0, 25.0, 50.0].into_iter().enumerate() {
            solver.coupling[0][i][i] = gain;
        }
        solver.coupling[0][0][4] = 2.0;
        solver.coupling[0][4][0] = 2.0;
        solver.free[0] = [0.02, -0.01, -0.03, 0.05, -0.04, 0.01];
        let corners = [[-0.1, -0.06], [-0.1, 0.06], [0.2, -0.06], [0.2, 0.06]];
        for (point, [x, y]) in solver.points.iter_mut().zip(corners) {
            (point.arm, point.friction) = ([x, y, 0.0], 0.7);
        }
        solver.prepare();
        solver
    }

    #[test]
    fn a_foot_on_four_corners_moves_as_one_whatever_the_visits_began_with() {
        let settings = SimulationSettings::default().contact;
        let mut twists = Vec::new();
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
        }
        for other in &twists[1..] {
            assert!((0..6).all(|i| (other[i] - twists[0][i]).abs() < 1e-9), "{twists:?}");
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
            (solver.points[0].approach, solver.points[3].approach) = (difference, difference);
            let report = solver.solve(&mut Simultaneous::new(4, 1), 1e-12, &settings);
            assert!(report.residual <= 1e-12 && report.sweeps <= 10, "{difference}: {report:?}");
            for point in &solver.points {
                let opening = velocity_at(&solver.twist[0], &point.arm)[2] - point.approach;
                assert!(
                    opening > -1e-10 && (opening * point.impulse[2]).abs() < 1e-10,
                    "{opening} {:?}",
                    point.impulse
                );
            }
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
        let mut solver = ContactSolver::<2, 3>::new(&[0], 1);
        let point = &mut solver.points[0];
        (point.arm, point.turn) = (arm, Some([0.8, 0.6]));
        let power: f64 = point.velocity(&twist).iter().zip(&impulse).map(|(v, f)| v * f).sum();
        let same: f64 = point.wrench(&impulse).iter().zip(&twist).map(|(f, v)| f * v).sum();
        assert!((power - same).abs() < 1e-14);
    }
}
