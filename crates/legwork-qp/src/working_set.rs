//! The working set with its factors, and the pair of point and multipliers that belongs to it.
//!
//! Members are rows and bounds that hold as equations `nᵀz = b`, with `n = s a`, `b = s·bound`, `s = +1` at a lower and `−1` at
//! an upper side: all multipliers of inequalities are then positive at an optimum.

use crate::factor::Factor;
use crate::linear::{axpy, dot, max_abs};
use crate::scale::{Kind, Scaled};

/// A normal is dependent if what the members leave of it is below this times what cancelled.
const DEPENDENT: f64 = 1e-11;
/// A constraint and the sign of the side at which it holds.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Member {
    pub(crate) c: usize,
    pub(crate) sign: f64,
}

impl Member {
    /// `b`.
    pub(crate) fn bound(self, program: &Scaled) -> f64 {
        if self.sign > 0.0 { program.lower[self.c] } else { -program.upper[self.c] }
    }

    /// By how much `nᵀz` falls short of `b`.
    pub(crate) fn shortfall(self, program: &Scaled, z: &[f64]) -> f64 {
        self.bound(program) - self.sign * program.times(self.c, z)
    }
}

/// Where a constraint stands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Place {
    Out,
    In,
    /// An equality that follows from others.
    Implied,
    /// Violated, with neither a step nor a proof of infeasibility that rounding errors would not spoil.
    Aside,
}

#[derive(Clone, Debug)]
pub(crate) struct WorkingSet {
    pub(crate) factor: Factor,
    pub(crate) members: Vec<Member>,
    /// Aligned with the members, of which the first are the equalities.
    pub(crate) multipliers: Vec<f64>,
    pub(crate) equalities: usize,
    pub(crate) place: Vec<Place>,
    pub(crate) z: Vec<f64>,
    /// `J⁻¹ z`.
    y: Vec<f64>,
    /// `∑ |a_cj| √(H⁻¹)_jj`, which bounds the length of `Jᵀ a_c`.
    pub(crate) reach: Vec<f64>,
    /// `Jᵀn` of a candidate.
    pub(crate) d: Vec<f64>,
    /// How the members make up the candidate: `n = N r + remainder`.
    pub(crate) r: Vec<f64>,
    pub(crate) remainder: Vec<f64>,
    /// `J2 d2`, and its product with the gradient.
    pub(crate) direction: Vec<f64>,
    scratch: Vec<f64>,
    /// Length of `d2`.
    pub(crate) free_length: f64,
}

impl WorkingSet {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Self {
            factor: Factor::new(n),
            members: Vec::with_capacity(n),
            multipliers: Vec::with_capacity(n),
            equalities: 0,
            place: vec![Place::Out; m + n],
            z: vec![0.0; n],
            y: vec![0.0; n],
            reach: vec![0.0; m + n],
            d: vec![0.0; n],
            r: vec![0.0; n],
            remainder: vec![0.0; n],
            direction: vec![0.0; n + 1],
            scratch: vec![0.0; n],
            free_length: 0.0,
        }
    }

    /// Empties the set after [`Factor::factorise`].
    pub(crate) fn clear(&mut self, program: &Scaled) {
        self.members.clear();
        self.multipliers.clear();
        self.equalities = 0;
        self.place.fill(Place::Out);
        for c in 0..program.constraints() {
            if program.kind[c] != Kind::Free {
                self.reach[c] = program.times_abs(c, self.factor.row_norms());
            }
        }
    }

    /// Computes `d`, and what part of the candidate, at least, lies outside the span of the members.
    pub(crate) fn project(&mut self, program: &Scaled, candidate: Member) -> f64 {
        let Member { c, sign } = candidate;
        if c < program.m {
            self.factor.transpose_times(program.row(c), &mut self.d);
            for d in &mut self.d {
                *d *= sign;
            }
        } else {
            self.factor.transpose_times_unit(c - program.m, sign, &mut self.d);
        }
        let free = &self.d[self.factor.q()..];
        self.free_length = dot(free, free).sqrt();
        self.free_length / self.reach[c]
    }

    /// `R r = d1`: how the members make up the part of the candidate in their span.
    pub(crate) fn solve_coefficients(&mut self) {
        let q = self.factor.q();
        self.r[..q].copy_from_slice(&self.d[..q]);
        self.factor.solve(&mut self.r[..q]);
    }

    /// Looks closely at a candidate that is not clearly independent, whose `d` and `r` are known. Sharpens `r` and `d2`.
    pub(crate) fn is_dependent(&mut self, program: &Scaled, candidate: Member) -> bool {
        let q = self.factor.q();
        self.compute_remainder(program, candidate);
        self.factor.transpose_times(&self.remainder, &mut self.scratch);
        self.factor.solve(&mut self.scratch[..q]);
        for (r, correction) in self.r[..q].iter_mut().zip(&self.scratch) {
            *r += correction;
        }
        self.compute_remainder(program, candidate);
        // J2ᵀ n = J2ᵀ remainder, but with less to cancel.
        for k in q..self.d.len() {
            self.d[k] = dot(self.factor.column(k), &self.remainder);
        }
        let free = &self.d[q..];
        self.free_length = dot(free, free).sqrt();
        // Normals have norms between 1 and 2.
        let size = 1.0 + self.r[..q].iter().map(|r| r.abs()).sum::<f64>();
        free.is_empty() || max_abs(&self.remainder) <= DEPENDENT * size
    }

    /// `n − N r`.
    pub(crate) fn compute_remainder(&mut self, program: &Scaled, candidate: Member) {
        self.remainder.fill(0.0);
        program.add_to(candidate.c, candidate.sign, &mut self.remainder);
        for (member, r) in self.members.iter().zip(&self.r) {
            program.add_to(member.c, -r * member.sign, &mut self.remainder);
        }
    }

    /// `J2 d2`, the direction in which the candidate's shortfall shrinks while the members keep holding.
    pub(crate) fn compute_direction(&mut self) {
        self.factor.free_direction(&self.d, &mut self.direction);
    }

    /// Adds the candidate of which `d` and the direction have been computed.
    pub(crate) fn add(&mut self, candidate: Member) {
        self.factor.add(&self.d, &mut self.direction);
        self.members.push(candidate);
        self.multipliers.push(0.0);
        self.place[candidate.c] = Place::In;
    }

    pub(crate) fn drop(&mut self, k: usize) {
        self.factor.drop(k);
        self.multipliers.remove(k);
        let member = self.members.remove(k);
        self.place[member.c] = Place::Out;
    }

    /// Point and multipliers of the working set, from the factors alone: no error of earlier steps survives.
    ///
    /// `z = J y` with `Rᵀ y1 = b`, `y2 = −J2ᵀg`, and `R λ = y1 + J1ᵀg`.
    pub(crate) fn refresh(&mut self, program: &Scaled) {
        let q = self.factor.q();
        for (y, member) in self.y.iter_mut().zip(&self.members) {
            *y = member.bound(program);
        }
        self.factor.solve_transposed(&mut self.y[..q]);
        for k in 0..q {
            self.multipliers[k] = self.y[k] + self.factor.gradient(k);
        }
        self.factor.solve(&mut self.multipliers);
        for k in q..self.y.len() {
            self.y[k] = -self.factor.gradient(k);
        }
        self.factor.times(&self.y, &mut self.z);
    }

    /// Objective at the refreshed point, up to a constant: `½ yᵀy + (Jᵀg)ᵀ y`; and the size of what cancels in it.
    pub(crate) fn value(&self) -> (f64, f64) {
        let (mut value, mut size) = (0.0, 0.0);
        for (k, y) in self.y.iter().enumerate() {
            let term = y * (0.5 * y + self.factor.gradient(k));
            value += term;
            size += term.abs();
        }
        (value, size)
    }

    /// Bounds, with `reach`, what rounding errors do to the rows: `|a_cᵀz| <= reach_c |y|`.
    pub(crate) fn y_length(&self) -> f64 {
        dot(&self.y, &self.y).sqrt()
    }

    /// Length of `Jᵀg`: that of `y` without constraints.
    pub(crate) fn gradient_length(&self) -> f64 {
        let squares = (0..self.y.len()).map(|k| self.factor.gradient(k) * self.factor.gradient(k));
        squares.sum::<f64>().sqrt()
    }

    /// One step of iterative refinement of point and multipliers on the optimality conditions of the working set,
    /// `H z − N λ = −g` and `Nᵀ z = b`, with the residuals of the program itself.
    pub(crate) fn refine(&mut self, program: &Scaled, convexified: bool) {
        let (n, q) = (program.n, self.factor.q());
        let residual = &mut self.remainder;
        for (i, residual) in residual.iter_mut().enumerate() {
            *residual = -program.gradient[i] - dot(&program.hessian[i * n..(i + 1) * n], &self.z);
        }
        for (k, member) in self.members.iter().enumerate() {
            program.add_to(member.c, self.multipliers[k] * member.sign, residual);
            self.r[k] = member.shortfall(program, &self.z);
        }
        if convexified {
            // The factors belong to H + ∑ a aᵀ over the equalities.
            for c in (0..program.constraints()).filter(|&c| program.kind[c] == Kind::Equality) {
                program.add_to(c, program.lower[c] - program.times(c, &self.z), residual);
            }
        }
        self.factor.transpose_times(residual, &mut self.scratch);
        self.factor.solve_transposed(&mut self.r[..q]);
        // Corrections: of y in scratch, of the multipliers in r.
        for k in 0..q {
            let y = self.r[k];
            self.r[k] = y - self.scratch[k];
            self.scratch[k] = y;
        }
        self.factor.solve(&mut self.r[..q]);
        for (multiplier, correction) in self.multipliers.iter_mut().zip(&self.r) {
            *multiplier += correction;
        }
        for (k, y) in self.scratch.iter().enumerate() {
            axpy(*y, self.factor.column(k), &mut self.z);
        }
    }

    /// The inequality with the most negative multiplier, if any is negative.
    pub(crate) fn most_negative(&self) -> Option<usize> {
        let mut worst = 0.0;
        let mut position = None;
        for (k, &multiplier) in self.multipliers.iter().enumerate().skip(self.equalities) {
            if multiplier < worst {
                worst = multiplier;
                position = Some(k);
            }
        }
        position
    }
}
