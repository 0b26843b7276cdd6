//! One contact alone: open, stick, or slip with maximal dissipation. Thesis Appendix A; Hwangbo, Lee and Hutter 2018.
//!
//! A contact's D coordinates are its tangents (one in the plane, two in space), then its normal. Its velocity after an
//! impulse λ is `v⁺ = c + G λ`.

/// The impulse that stops the contact point, `-G⁻¹ c`, is inside of the friction cone.
pub(super) fn in_cone<const D: usize>(impulse: &[f64; D], friction: f64) -> bool {
    let limit = friction * impulse[D - 1];
    let tangent: f64 = impulse[..D - 1].iter().map(|value| value * value).sum();
    limit >= 0.0 && limit * limit >= tangent
}

/// The inverse of a contact's symmetric `G`.
pub(super) fn inverse<const D: usize>(g: &[[f64; D]; D]) -> [[f64; D]; D] {
    let mut out = [[0.0; D]; D];
    if D == 2 {
        let scale = 1.0 / (g[0][0] * g[1][1] - g[0][1] * g[1][0]);
        (out[0][0], out[1][1]) = (g[1][1] * scale, g[0][0] * scale);
        (out[0][1], out[1][0]) = (-g[0][1] * scale, -g[0][1] * scale);
    } else {
        let minor = |i: usize, j: usize| {
            let (a, b, p, q) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            g[a][p] * g[b][q] - g[a][q] * g[b][p]
        };
        let scale = 1.0 / (g[0][0] * minor(0, 0) + g[0][1] * minor(0, 1) + g[0][2] * minor(0, 2));
        for i in 0..3 {
            for j in 0..=i {
                out[i][j] = minor(i, j) * scale;
                out[j][i] = out[i][j];
            }
        }
    }
    out
}

/// The impulse of a slipping contact: on the edge of the cone, no normal velocity, least kinetic energy (maximal
/// dissipation). `stick` is the impulse that would stop the point, outside of the cone; in space the search for the
/// direction begins at that of `guess`, if it has one.
pub(super) fn slip<const D: usize>(
    g: &[[f64; D]; D],
    c: &[f64; D],
    friction: f64,
    stick: &[f64; D],
    guess: &[f64; D],
) -> [f64; D] {
    let mut out = [0.0; D];
    let n = D - 1;
    if D == 2 {
        // On the line of vanishing normal velocity the energy is least at the sticking impulse, so the edge on its side is
        // meant; the other one only where that edge cannot stop the normal motion.
        let edge = |side: f64| {
            let gain = g[n][n] + side * friction * g[n][0];
            (gain > 0.0).then(|| -c[n] / gain)
        };
        let side = if stick[0] >= 0.0 { 1.0 } else { -1.0 };
        match (edge(side), edge(-side)) {
            (Some(normal), _) => (out[0], out[n]) = (side * friction * normal, normal),
            (None, Some(normal)) => (out[0], out[n]) = (-side * friction * normal, normal),
            (None, None) => {}
        }
    } else if c[n] < 0.0 {
        let edge = Edge {
            a: [friction * g[n][0] / g[n][n], friction * g[n][1] / g[n][n]],
            s: -friction * c[n] / g[n][n],
            hessian: [
                [g[0][0] - g[0][n] * g[0][n] / g[n][n], g[0][1] - g[0][n] * g[1][n] / g[n][n]],
                [g[1][0] - g[1][n] * g[0][n] / g[n][n], g[1][1] - g[1][n] * g[1][n] / g[n][n]],
            ],
            gradient: [c[0] - g[0][n] * c[n] / g[n][n], c[1] - g[1][n] * c[n] / g[n][n]],
        };
        let start = if guess[0] != 0.0 || guess[1] != 0.0 { guess } else { stick };
        let direction = unit([start[0], start[1]]);
        let direction = edge.newton(direction).unwrap_or_else(|| edge.search());
        let normal = -c[n] / (g[n][n] * edge.gain(direction));
        (out[0], out[1], out[n]) = (friction * direction[0] * normal, friction * direction[1] * normal, normal);
    }
    out
}

/// The edge of the cone in space, cut by the plane of vanishing normal velocity: a conic of tangential impulses x, in
/// polar coordinates `|x| = s / (1 + a·d)` along the direction d; and the energy `½ xᵀ hessian x + gradient · x` on that
/// plane. The inside of the conic is convex, so a stationary point is the least if the energy falls outward there.
struct Edge {
    a: [f64; 2],
    s: f64,
    hessian: [[f64; 2]; 2],
    gradient: [f64; 2],
}

fn unit(x: [f64; 2]) -> [f64; 2] {
    let norm = (x[0] * x[0] + x[1] * x[1]).sqrt();
    if norm > 0.0 { [x[0] / norm, x[1] / norm] } else { [1.0, 0.0] }
}

fn dot(x: [f64; 2], y: [f64; 2]) -> f64 {
    x[0] * y[0] + x[1] * y[1]
}

impl Edge {
    fn gain(&self, d: [f64; 2]) -> f64 {
        1.0 + dot(self.a, d)
    }

    /// The energy's slope along the edge and its derivative, by the angle of `d`; and whether it falls outward. None
    /// where the edge cannot stop the normal motion.
    fn slope(&self, d: [f64; 2]) -> Option<(f64, f64, bool)> {
        let (w, across) = (self.gain(d), [-d[1], d[0]]);
        if w <= 1e-9 {
            return None;
        }
        let radius = self.s / w;
        let turn = dot(self.a, across) / w;
        // The radius' first and second derivatives by the angle.
        let first = -radius * turn;
        let second = radius * (2.0 * turn * turn - (1.0 - w) / w);
        let h = &self.hessian;
        let times = |x: [f64; 2]| [dot(h[0], x), dot(h[1], x)];
        let hx = times([radius * d[0], radius * d[1]]);
        let g = [hx[0] + self.gradient[0], hx[1] + self.gradient[1]];
        let dx = [first * d[0] + radius * across[0], first * d[1] + radius * across[1]];
        let ddx =
            [(second - radius) * d[0] + 2.0 * first * across[0], (second - radius) * d[1] + 2.0 * first * across[1]];
        Some((dot(g, dx), dot(dx, times(dx)) + dot(g, ddx), dot(g, [d[0] + self.a[0], d[1] + self.a[1]]) <= 0.0))
    }

    /// Newton's method for the direction of least energy from `d`. None where it does not get there.
    fn newton(&self, mut d: [f64; 2]) -> Option<[f64; 2]> {
        for _ in 0..30 {
            let (slope, derivative, outward) = self.slope(d)?;
            // Downhill where the energy is not convex.
            let step = if derivative > 0.0 { (-slope / derivative).clamp(-0.5, 0.5) } else { -0.5 * slope.signum() };
            d = unit([d[0] - step * d[1], d[1] + step * d[0]]);
            if step.abs() < 1e-9 {
                return (outward && derivative > 0.0).then_some(d);
            }
        }
        None
    }

    /// The best of directions all around, made exact by halving.
    fn search(&self) -> [f64; 2] {
        const SAMPLES: u32 = 48;
        let width = std::f64::consts::TAU / f64::from(SAMPLES);
        let direction = |theta: f64| {
            let (sin, cos) = libm::sincos(theta);
            [cos, sin]
        };
        let energy = |theta: f64| {
            let d = direction(theta);
            let w = self.gain(d);
            if w <= 1e-9 {
                return f64::INFINITY;
            }
            let x = [d[0] * self.s / w, d[1] * self.s / w];
            0.5 * dot(x, [dot(self.hessian[0], x), dot(self.hessian[1], x)]) + dot(self.gradient, x)
        };
        let best = (0..SAMPLES)
            .map(|k| f64::from(k) * width)
            .map(|theta| (energy(theta), theta))
            .fold((f64::INFINITY, 0.0), |best, next| if next.0 < best.0 { next } else { best });
        let (mut low, mut high) = (best.1 - width, best.1 + width);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match self.slope(direction(middle)) {
                Some((slope, ..)) if slope > 0.0 => high = middle,
                Some(_) => low = middle,
                // Away from where the edge ends.
                None if middle > best.1 => high = middle,
                None => low = middle,
            }
        }
        direction(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The law as a whole.
    fn solve<const D: usize>(g: &[[f64; D]; D], c: &[f64; D], friction: f64, guess: &[f64; D]) -> [f64; D] {
        if c[D - 1] > 0.0 {
            return [0.0; D];
        }
        let h = inverse(g);
        let stick = std::array::from_fn(|i| -(0..D).map(|j| h[i][j] * c[j]).sum::<f64>());
        if in_cone(&stick, friction) { stick } else { slip(g, c, friction, &stick, guess) }
    }

    /// `B Bᵀ + 0.1 I` from nine numbers.
    fn positive_definite<const D: usize>(b: &[f64; 9]) -> [[f64; D]; D] {
        let entry = |i: usize, j: usize| (0..D).map(|k| b[3 * i + k] * b[3 * j + k]).sum::<f64>();
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j) + if i == j { 0.1 } else { 0.0 }))
    }

    fn velocity<const D: usize>(g: &[[f64; D]; D], c: &[f64; D], lambda: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|i| c[i] + (0..D).map(|j| g[i][j] * lambda[j]).sum::<f64>())
    }

    fn energy<const D: usize>(g: &[[f64; D]; D], c: &[f64; D], lambda: &[f64; D]) -> f64 {
        let v = velocity(g, c, lambda);
        (0..D).map(|i| 0.5 * lambda[i] * (v[i] + c[i])).sum()
    }

    proptest! {
        #[test]
        fn planar_law_holds(b in prop::array::uniform9(-1.0..1.0f64), c in prop::array::uniform2(-2.0..2.0f64), mu in 0.0..1.5f64) {
            let g = positive_definite::<2>(&b);
            let lambda = solve(&g, &c, mu, &[0.0; 2]);
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
            let flat = positive_definite::<2>(&b);
            let space = [[flat[0][0], 0.0, flat[0][1]], [0.0, 1.0, 0.0], [flat[1][0], 0.0, flat[1][1]]];
            let lambda = solve(&space, &[c[0], 0.0, c[1]], mu, &[0.0; 3]);
            let planar = solve(&flat, &c, mu, &[0.0; 2]);
            // Where only one edge can stop the normal motion the problem in space has more freedom.
            let both_edges = flat[1][1] > mu * flat[0][1].abs();
            if both_edges {
                let difference = energy(&space, &[c[0], 0.0, c[1]], &lambda) - energy(&flat, &c, &planar);
                prop_assert!(difference <= 1e-9, "space must not do worse than the plane: {difference}");
                prop_assert!(lambda[1].abs() < 1e-6 || difference < -1e-12);
            }
        }

        #[test]
        fn spatial_slip_is_the_least_energy_on_the_cone(
            b in prop::array::uniform9(-1.0..1.0f64), c in prop::array::uniform3(-2.0..2.0f64), mu in 0.05..0.8f64, turn in 0.0..6.3f64
        ) {
            let g = positive_definite::<3>(&b);
            let lambda = solve(&g, &c, mu, &[libm::cos(turn), libm::sin(turn), 0.0]);
            let v = velocity(&g, &c, &lambda);
            prop_assert!(lambda[2] >= 0.0 && v[2] >= -1e-9);
            prop_assert!(libm::hypot(lambda[0], lambda[1]) <= mu * lambda[2] + 1e-9);
            // Wherever the search begins, it ends at the same impulse.
            let other = solve(&g, &c, mu, &[0.0; 3]);
            prop_assert!((0..3).all(|i| (lambda[i] - other[i]).abs() < 1e-6 * (1.0 + lambda[2])), "{lambda:?} {other:?}");
            if lambda[2] > 0.0 && libm::hypot(v[0], v[1]) > 1e-6 {
                let least = energy(&g, &c, &lambda);
                for k in 0..2000 {
                    let (sin, cos) = libm::sincos(f64::from(k) * std::f64::consts::TAU / 2000.0);
                    let gain = g[2][2] + mu * (g[2][0] * cos + g[2][1] * sin);
                    if gain > 0.0 {
                        let normal = -c[2] / gain;
                        let other = energy(&g, &c, &[mu * cos * normal, mu * sin * normal, normal]);
                        prop_assert!(other >= least - 1e-9 * (1.0 + least.abs()), "{other} < {least}");
                    }
                }
            }
        }
    }
}
