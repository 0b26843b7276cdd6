//! Rigid contact with Coulomb friction by a per-contact iteration. Thesis Appendix A; Hwangbo, Lee and Hutter 2018.
//!
//! Contacts are visited in turn; each is solved exactly, given the impulses of the others, until no impulse changes
//! any more. A contact's coordinates are its tangents (one in the plane, two in space), then its normal.

use crate::scenario::ContactSettings;

/// Outcome of one solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Sweeps over all contacts.
    pub sweeps: u32,
    /// Largest change of an impulse's component in the last sweep [Ns].
    pub residual: f64,
}

/// A contact problem `v⁺ = free + G λ` and its solution, all preallocated.
#[derive(Clone, Debug)]
pub struct ContactSolver {
    dimension: usize,
    size: usize,
    /// `G = J M⁻¹ Jᵀ`, size × size, row by row [1/kg].
    pub delassus: Vec<f64>,
    /// Contact velocities without contact impulses [m/s].
    pub free: Vec<f64>,
    /// Lowest normal velocity allowed at each contact [m/s]: negative while there is a gap left.
    pub approach: Vec<f64>,
    /// Impulses λ [Ns]; also the first guess.
    pub impulse: Vec<f64>,
}

impl ContactSolver {
    /// Storage for `contacts` contacts with `dimension` directions each (2 or 3).
    pub fn new(contacts: usize, dimension: usize) -> Self {
        let size = contacts * dimension;
        Self {
            dimension,
            size,
            delassus: vec![0.0; size * size],
            free: vec![0.0; size],
            approach: vec![0.0; contacts],
            impulse: vec![0.0; size],
        }
    }

    /// Solves for [`ContactSolver::impulse`], starting from zero, with friction coefficient `friction`; stops when no
    /// impulse changes by more than `tolerance` [Ns].
    pub fn solve(&mut self, friction: f64, tolerance: f64, settings: &ContactSettings) -> Report {
        self.impulse.fill(0.0);
        let contacts = self.approach.len();
        let alpha = if contacts == 1 { 1.0 } else { settings.relaxation };
        let mut report = Report::default();
        for sweep in 1..=settings.max_sweeps {
            report = Report { sweeps: sweep, residual: 0.0 };
            for contact in 0..contacts {
                report.residual = report.residual.max(self.visit(contact, friction, alpha));
            }
            if report.residual <= tolerance {
                break;
            }
        }
        report
    }

    /// Solves one contact given the others; returns the largest change.
    fn visit(&mut self, contact: usize, friction: f64, alpha: f64) -> f64 {
        let d = self.dimension;
        let first = contact * d;
        let mut block = [[0.0; 3]; 3];
        let mut c = [0.0; 3];
        for i in 0..d {
            let row = &self.delassus[(first + i) * self.size..(first + i + 1) * self.size];
            c[i] = self.free[first + i];
            for (k, &g) in row.iter().enumerate() {
                if (first..first + d).contains(&k) {
                    block[i][k - first] = g;
                } else {
                    c[i] += g * self.impulse[k];
                }
            }
        }
        c[d - 1] -= self.approach[contact];
        let solved = if d == 2 { solve_planar(&block, &c, friction) } else { solve_spatial(&block, &c, friction) };
        let mut change: f64 = 0.0;
        for i in 0..d {
            let step = alpha * (solved[i] - self.impulse[first + i]);
            self.impulse[first + i] += step;
            change = change.max(step.abs());
        }
        change
    }
}

/// Impulse of one contact in the plane, coordinates (tangent, normal), for `v⁺ = c + G λ`.
pub fn solve_planar(g: &[[f64; 3]; 3], c: &[f64; 3], friction: f64) -> [f64; 3] {
    const T: usize = 0;
    const N: usize = 1;
    if c[N] > 0.0 {
        return [0.0; 3]; // opening
    }
    // λ_v0: the impulse that stops the contact point.
    let determinant = g[T][T] * g[N][N] - g[T][N] * g[N][T];
    let stick = [(g[T][N] * c[N] - g[N][N] * c[T]) / determinant, (g[N][T] * c[T] - g[T][T] * c[N]) / determinant];
    if friction * stick[N] >= stick[T].abs() {
        return [stick[T], stick[N], 0.0];
    }
    // Slipping: on the edge of the cone, no normal velocity, least kinetic energy (maximal dissipation). On the line
    // of vanishing normal velocity the energy is least at λ_v0, so the edge on its side is meant; the other one only
    // where that edge cannot stop the normal motion.
    let edge = |side: f64| {
        let gain = g[N][N] + side * friction * g[N][T];
        (gain > 0.0).then(|| -c[N] / gain)
    };
    let side = if stick[T] >= 0.0 { 1.0 } else { -1.0 };
    match (edge(side), edge(-side)) {
        (Some(normal), _) => [side * friction * normal, normal, 0.0],
        (None, Some(normal)) => [-side * friction * normal, normal, 0.0],
        (None, None) => unreachable!("G is positive definite, so one of its two edges has a positive gain"),
    }
}

/// Impulse of one contact in space, coordinates (tangent, tangent, normal), for `v⁺ = c + G λ`.
pub fn solve_spatial(g: &[[f64; 3]; 3], c: &[f64; 3], friction: f64) -> [f64; 3] {
    const N: usize = 2;
    if c[N] > 0.0 {
        return [0.0; 3]; // opening
    }
    let matrix = nalgebra::Matrix3::from_fn(|i, j| g[i][j]);
    if let Some(inverse) = matrix.try_inverse() {
        let stick = -(inverse * nalgebra::Vector3::from_column_slice(c));
        if friction * stick[N] >= libm::hypot(stick[0], stick[1]) {
            return [stick[0], stick[1], stick[N]];
        }
    }
    // Slipping in direction θ fixes the impulse; the direction is the one of least energy (Hwangbo 2018, III-C).
    let impulse = |theta: f64| {
        let (sin, cos) = libm::sincos(theta);
        let gain = g[N][N] + friction * (g[N][0] * cos + g[N][1] * sin);
        let normal = -c[N] / gain;
        (gain > 0.0).then_some([friction * cos * normal, friction * sin * normal, normal])
    };
    let energy = |theta: f64| {
        impulse(theta).map_or(f64::INFINITY, |lambda| {
            let mut sum = 0.0;
            for i in 0..3 {
                let gi: f64 = (0..3).map(|j| g[i][j] * lambda[j]).sum();
                sum += lambda[i] * (0.5 * gi + c[i]);
            }
            sum
        })
    };
    const SAMPLES: u32 = 24;
    let width = std::f64::consts::TAU / f64::from(SAMPLES);
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..SAMPLES {
        let theta = f64::from(k) * width;
        let value = energy(theta);
        if value < best.0 {
            best = (value, theta);
        }
    }
    // Golden section around the best sample.
    let ratio = 0.5 * (libm::sqrt(5.0) - 1.0);
    let (mut low, mut high) = (best.1 - width, best.1 + width);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut energy_a, mut energy_b) = (energy(a), energy(b));
    for _ in 0..40 {
        if energy_a < energy_b {
            (high, b, energy_b) = (b, a, energy_a);
            a = high - ratio * (high - low);
            energy_a = energy(a);
        } else {
            (low, a, energy_a) = (a, b, energy_b);
            b = low + ratio * (high - low);
            energy_b = energy(b);
        }
    }
    impulse(0.5 * (low + high)).or_else(|| impulse(best.1)).unwrap_or([0.0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SETTINGS: ContactSettings = ContactSettings {
        model: crate::scenario::ContactModel::Rigid,
        flag_height_m: 1e-3,
        penetration_recovery: 0.2,
        relaxation: 1.0,
        tolerance_n: 1e-6,
        max_sweeps: 200,
        stiffness_npm: 1e5,
        damping_nspm: 1e3,
        slip_speed_mps: 0.01,
    };

    /// `B Bᵀ + 0.1 I` from nine numbers.
    fn positive_definite(b: &[f64; 9], d: usize) -> [[f64; 3]; 3] {
        let mut g = [[0.0; 3]; 3];
        for i in 0..d {
            for j in 0..d {
                g[i][j] = (0..d).map(|k| b[3 * i + k] * b[3 * j + k]).sum::<f64>() + if i == j { 0.1 } else { 0.0 };
            }
        }
        g
    }

    fn velocity(g: &[[f64; 3]; 3], c: &[f64; 3], lambda: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| c[i] + (0..3).map(|j| g[i][j] * lambda[j]).sum::<f64>())
    }

    fn energy(g: &[[f64; 3]; 3], c: &[f64; 3], lambda: &[f64; 3]) -> f64 {
        let v = velocity(g, c, lambda);
        (0..3).map(|i| 0.5 * lambda[i] * (v[i] + c[i])).sum()
    }

    proptest! {
        #[test]
        fn planar_law_holds(b in prop::array::uniform9(-1.0..1.0f64), c in prop::array::uniform2(-2.0..2.0f64), mu in 0.0..1.5f64) {
            let (g, c) = (positive_definite(&b, 2), [c[0], c[1], 0.0]);
            let lambda = solve_planar(&g, &c, mu);
            let v = velocity(&g, &c, &lambda);
            prop_assert!(lambda[1] >= 0.0, "pulls");
            prop_assert!(lambda[0].abs() <= mu * lambda[1] + 1e-9, "outside of the cone");
            prop_assert!(v[1] >= -1e-9, "penetrates");
            prop_assert!((lambda[1] * v[1]).abs() < 1e-7, "pushes while opening");
            // Sticks or is on the cone's edge.
            let slips = v[0].abs() > 1e-9;
            if slips && lambda[1] > 0.0 {
                prop_assert!((lambda[0].abs() - mu * lambda[1]).abs() < 1e-9);
            }
        }

        #[test]
        fn spatial_agrees_with_planar_where_the_plane_decouples(b in prop::array::uniform9(-1.0..1.0f64), c in prop::array::uniform2(-2.0..2.0f64), mu in 0.0..1.5f64) {
            let flat = positive_definite(&b, 2);
            let c2 = [c[0], c[1], 0.0];
            let space = [[flat[0][0], 0.0, flat[0][1]], [0.0, 1.0, 0.0], [flat[1][0], 0.0, flat[1][1]]];
            let lambda = solve_spatial(&space, &[c[0], 0.0, c[1]], mu);
            let planar = solve_planar(&flat, &c2, mu);
            // Where only one edge can stop the normal motion the problem in space has more freedom.
            let both_edges = flat[1][1] > mu * flat[0][1].abs();
            if both_edges {
                let difference = energy(&space, &[c[0], 0.0, c[1]], &lambda) - energy(&flat, &c2, &planar);
                prop_assert!(difference <= 1e-9, "space must not do worse than the plane: {difference}");
                prop_assert!(lambda[1].abs() < 1e-6 || difference < -1e-12);
            }
        }

        #[test]
        fn spatial_slip_is_the_least_energy_on_the_cone(b in prop::array::uniform9(-1.0..1.0f64), c in prop::array::uniform3(-2.0..2.0f64), mu in 0.05..0.8f64) {
            let g = positive_definite(&b, 3);
            let lambda = solve_spatial(&g, &c, mu);
            let v = velocity(&g, &c, &lambda);
            prop_assert!(lambda[2] >= 0.0 && v[2] >= -1e-7);
            prop_assert!(libm::hypot(lambda[0], lambda[1]) <= mu * lambda[2] + 1e-9);
            if lambda[2] > 0.0 && libm::hypot(v[0], v[1]) > 1e-6 {
                let least = energy(&g, &c, &lambda);
                for k in 0..2000 {
                    let (sin, cos) = libm::sincos(f64::from(k) * std::f64::consts::TAU / 2000.0);
                    let gain = g[2][2] + mu * (g[2][0] * cos + g[2][1] * sin);
                    if gain > 0.0 {
                        let normal = -c[2] / gain;
                        let other = energy(&g, &c, &[mu * cos * normal, mu * sin * normal, normal]);
                        prop_assert!(other >= least - 1e-6 * (1.0 + least.abs()), "{other} < {least}");
                    }
                }
            }
        }
    }

    #[test]
    fn two_coupled_contacts_converge_to_the_law() {
        // A bar of mass 2 and inertia 0.5 that lands flat on two points half a metre from its centre, moving sideways.
        let (mass, inertia, half) = (2.0, 0.5, 0.5);
        let points = [(-half, -0.1), (half, -0.1)]; // contact points from the centre
        let rows: Vec<[f64; 3]> = points.iter().flat_map(|&(x, z)| [[1.0, 0.0, -z], [0.0, 1.0, x]]).collect();
        let inverse = [1.0 / mass, 1.0 / mass, 1.0 / inertia];
        let mut solver = ContactSolver::new(2, 2);
        for (i, a) in rows.iter().enumerate() {
            solver.free[i] = 0.3 * a[0] - a[1];
            for (j, b) in rows.iter().enumerate() {
                solver.delassus[4 * i + j] = (0..3).map(|k| a[k] * inverse[k] * b[k]).sum();
            }
        }
        let report = solver.solve(0.05, 1e-12, &SETTINGS);
        assert!(report.residual <= 1e-12 && report.sweeps > 2, "{report:?}");
        for contact in 0..2 {
            let velocity: f64 = solver.free[2 * contact + 1]
                + (0..4).map(|j| solver.delassus[4 * (2 * contact + 1) + j] * solver.impulse[j]).sum::<f64>();
            assert!(velocity.abs() < 1e-10, "normal velocity {velocity}");
            let (tangent, normal) = (solver.impulse[2 * contact], solver.impulse[2 * contact + 1]);
            assert!((tangent + 0.05 * normal).abs() < 1e-10, "slips forward on the edge of the cone");
        }
        let total: f64 = solver.impulse[1] + solver.impulse[3];
        assert!((total - mass).abs() < 1e-10, "the normal impulses stop the fall");
    }
}
