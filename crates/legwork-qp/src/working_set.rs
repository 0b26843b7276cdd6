//! The working set with its factors, and the pair of point and multipliers that belongs to it.
//!
//! Members are rows and bounds that hold as equations `nᵀz = b`, with `n = s a`, `b = s·bound`, `s = +1` at a lower and `−1` at
//! an upper side: all multipliers of inequalities are then positive at an optimum.

use crate::factor::Factor;
use crate::lanes::{self, Lanes, Span, WIDTH, zeros};
use crate::linear::{dot, max_abs};
use crate::scale::Scaled;
use crate::whitening::Whitening;

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
    pub(crate) fn shortfall(self, program: &Scaled, z: &[Lanes]) -> f64 {
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
    whitening: Whitening,
    factor: Factor,
    pub(crate) members: Vec<Member>,
    /// Aligned with the members, of which the first are the equalities.
    pub(crate) multipliers: Vec<f64>,
    pub(crate) equalities: usize,
    pub(crate) place: Vec<Place>,
    /// Equalities that are not in, with what part of each lies outside the span of the members.
    pub(crate) left: Vec<(usize, f64)>,
    pub(crate) z: Vec<Lanes>,
    /// `w (b − aᵀz)` of the equalities whose squares are in the Hessian: of a slack's row the multiplier.
    pub(crate) pulls: Vec<f64>,
    /// `L⁻¹g`, its products with the columns of `Q`, and what is left of it outside their span.
    gradient: Vec<Lanes>,
    along: Vec<f64>,
    across: Vec<Lanes>,
    /// `Qᵀy`; the rest of `y` is `−across`.
    t: Vec<f64>,
    /// Of a candidate's whitened normal the products with the columns of `Q`; and the rest, with its length.
    d: Vec<f64>,
    free: Vec<Lanes>,
    free_span: Span,
    pub(crate) free_length: f64,
    /// How the members make up the candidate: `n = N r + remainder`.
    pub(crate) r: Vec<f64>,
    pub(crate) remainder: Vec<Lanes>,
    scratch: Vec<f64>,
}

impl WorkingSet {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Self {
            whitening: Whitening::new(n),
            factor: Factor::new(n),
            members: Vec::with_capacity(n),
            multipliers: Vec::with_capacity(n),
            equalities: 0,
            place: vec![Place::Out; m + n],
            left: Vec::with_capacity(m + n),
            z: zeros(n),
            pulls: Vec::with_capacity(m + n),
            gradient: zeros(n),
            along: vec![0.0; n],
            across: zeros(n),
            t: vec![0.0; n],
            d: vec![0.0; n],
            free: zeros(n),
            free_span: Span::EMPTY,
            free_length: 0.0,
            r: vec![0.0; n],
            remainder: zeros(n),
            scratch: vec![0.0; n],
        }
    }

    /// Factorises the program's Hessian and empties the set. False if it is not positive definite.
    pub(crate) fn factorise(&mut self, program: &Scaled) -> bool {
        self.members.clear();
        self.multipliers.clear();
        self.equalities = 0;
        self.place.fill(Place::Out);
        self.left.clear();
        self.factor.clear();
        if !self.whitening.factorise(program) {
            return false;
        }
        // With the squares, −∑ w b a over the equalities aᵀz = b stands beside the gradient.
        self.remainder.copy_from_slice(&program.gradient);
        for &(c, weight) in &program.squared {
            program.add_to(c, -weight * program.lower[c], &mut self.remainder);
        }
        self.whitening.times(&self.remainder, all(program), 1.0, &mut self.gradient);
        self.across.copy_from_slice(&self.gradient);
        true
    }

    /// Bounds the length of a constraint's whitened normal.
    pub(crate) fn reach(&self, program: &Scaled, c: usize) -> f64 {
        program.times_abs(c, self.whitening.norms())
    }

    /// Computes the candidate's whitened normal and its parts, and what part of it, at least, lies outside the span of the
    /// members.
    pub(crate) fn project(&mut self, program: &Scaled, candidate: Member) -> f64 {
        let Self { whitening, factor, free, d, .. } = self;
        let span = whitening.normal(program, candidate.c, candidate.sign, free);
        (self.free_span, self.free_length) = factor.project(free, span, d);
        self.free_length / self.reach(program, candidate.c)
    }

    /// `R r = d`: how the members make up the part of the candidate in their span.
    pub(crate) fn solve_coefficients(&mut self) {
        let q = self.factor.q();
        self.r[..q].copy_from_slice(&self.d[..q]);
        self.factor.solve(&mut self.r[..q]);
    }

    /// Looks closely at a candidate that is not clearly independent, whose `d` and `r` are known. Sharpens `r` and what is
    /// outside of the span.
    pub(crate) fn is_dependent(&mut self, program: &Scaled, candidate: Member) -> bool {
        let q = self.factor.q();
        for last in [false, true] {
            self.compute_remainder(program, candidate);
            // What is outside of the span is so of the remainder too, with less to cancel.
            let span = self.whitening.times(&self.remainder, all(program), 1.0, &mut self.free);
            (self.free_span, self.free_length) = self.factor.project(&mut self.free, span, &mut self.scratch);
            if last {
                break;
            }
            self.factor.solve(&mut self.scratch[..q]);
            for (r, correction) in self.r[..q].iter_mut().zip(&self.scratch) {
                *r += correction;
            }
        }
        // Normals have norms between 1 and 2.
        let size = 1.0 + self.r[..q].iter().map(|r| r.abs()).sum::<f64>();
        q == program.n || max_abs(self.remainder.as_flattened()) <= DEPENDENT * size
    }

    /// `n − N r`.
    pub(crate) fn compute_remainder(&mut self, program: &Scaled, candidate: Member) {
        self.remainder.fill([0.0; WIDTH]);
        program.add_to(candidate.c, candidate.sign, &mut self.remainder);
        for (member, r) in self.members.iter().zip(&self.r) {
            program.add_to(member.c, -r * member.sign, &mut self.remainder);
        }
    }

    /// Moves the point in the direction in which the candidate's shortfall shrinks while the members keep holding.
    pub(crate) fn step(&mut self, length: f64) {
        self.remainder.fill([0.0; WIDTH]);
        lanes::axpy(-length, &self.free, &mut self.remainder);
        self.whitening.subtract_unwhitened(&self.remainder, &mut self.z);
    }

    /// Adds the candidate that has been projected.
    pub(crate) fn add(&mut self, candidate: Member) {
        let q = self.factor.q();
        self.factor.add(&self.d, &self.free, self.free_span, self.free_length);
        self.split_gradient(q);
        self.members.push(candidate);
        self.multipliers.push(0.0);
        self.place[candidate.c] = Place::In;
    }

    /// Splits what is left of the gradient along column `k` of `Q` and the rest.
    fn split_gradient(&mut self, k: usize) {
        let (column, lanes) = self.factor.column(k);
        let across = &mut self.across[lanes];
        self.along[k] = lanes::dot(column, across);
        lanes::axpy(-self.along[k], column, across);
        if k + 1 == self.along.len() {
            self.across.fill([0.0; WIDTH]);
        }
    }

    pub(crate) fn drop(&mut self, k: usize) {
        self.factor.drop(k);
        self.multipliers.remove(k);
        let member = self.members.remove(k);
        self.place[member.c] = Place::Out;
        self.across.copy_from_slice(&self.gradient);
        (0..self.factor.q()).for_each(|k| self.split_gradient(k));
    }

    /// Point and multipliers of the working set, from the factors alone: no error of earlier steps survives.
    ///
    /// `z = L⁻ᵀy` with `y = Q t − (1 − QQᵀ) L⁻¹g`, `Rᵀ t = b`, and `R λ = t + Qᵀ L⁻¹g`.
    pub(crate) fn refresh(&mut self, program: &Scaled) {
        let q = self.factor.q();
        for (t, member) in self.t.iter_mut().zip(&self.members) {
            *t = member.bound(program);
        }
        self.factor.solve_transposed(&mut self.t[..q]);
        for k in 0..q {
            self.multipliers[k] = self.t[k] + self.along[k];
        }
        self.factor.solve(&mut self.multipliers);
        let y = &mut self.free;
        // −y, and its sign turned in the end.
        y.copy_from_slice(&self.across);
        self.factor.subtract_times(&self.t[..q], y);
        self.z.fill([0.0; WIDTH]);
        self.whitening.subtract_unwhitened(y, &mut self.z);
        let pull = |&(c, weight): &(usize, f64)| weight * (program.lower[c] - program.times(c, &self.z));
        self.pulls.clear();
        self.pulls.extend(program.squared.iter().map(pull));
    }

    /// Objective at the refreshed point, up to a constant: `½ yᵀy + (L⁻¹g)ᵀ y`; and the size of what cancels in it.
    pub(crate) fn value(&self) -> (f64, f64) {
        let outside = 0.5 * lanes::dot(&self.across, &self.across);
        let (mut value, mut size) = (-outside, outside);
        for (t, along) in self.t[..self.factor.q()].iter().zip(&self.along) {
            let term = t * (0.5 * t + along);
            value += term;
            size += term.abs();
        }
        (value, size)
    }

    /// Bounds, with `reach`, what rounding errors do to the rows: `|a_cᵀz| <= reach_c |y|`.
    pub(crate) fn y_length(&self) -> f64 {
        let t = &self.t[..self.factor.q()];
        (dot(t, t) + lanes::dot(&self.across, &self.across)).sqrt()
    }

    /// Length of `L⁻¹g`: that of `y` without constraints.
    pub(crate) fn gradient_length(&self) -> f64 {
        lanes::dot(&self.gradient, &self.gradient).sqrt()
    }

    /// One step of iterative refinement of point and multipliers on the optimality conditions of the working set,
    /// `H z − N λ = −g` and `Nᵀ z = b`, with the residuals of the program itself.
    ///
    /// The multiplier `u` of a slack's row is refined as an unknown of its own: a small difference `b − aᵀz` times a large
    /// weight would have lost digits. As `u = w (b − aᵀz)`, its change is `−w aᵀΔz`.
    pub(crate) fn refine(&mut self, program: &Scaled) {
        let q = self.factor.q();
        let residual = &mut self.remainder;
        for (i, (residual, gradient)) in residual.iter_mut().zip(&program.gradient).enumerate() {
            let product = program.hessian_times(i, &self.z);
            *residual = std::array::from_fn(|k| -gradient[k] - product[k]);
        }
        for (k, member) in self.members.iter().enumerate() {
            program.add_to(member.c, self.multipliers[k] * member.sign, residual);
            self.r[k] = member.shortfall(program, &self.z);
        }
        // The factors belong to H + ∑ w a aᵀ.
        for (&(c, _), pull) in program.squared.iter().zip(&self.pulls) {
            program.add_to(c, *pull, residual);
        }
        // The step of y with its sign turned, as in refresh.
        let span = self.whitening.times(residual, all(program), -1.0, &mut self.free);
        self.factor.project(&mut self.free, span, &mut self.scratch);
        self.factor.solve_transposed(&mut self.r[..q]);
        self.factor.subtract_times(&self.r[..q], &mut self.free);
        self.move_point(program);
        for (r, along) in self.r[..q].iter_mut().zip(&self.scratch) {
            *r += along;
        }
        self.factor.solve(&mut self.r[..q]);
        for (multiplier, correction) in self.multipliers.iter_mut().zip(&self.r) {
            *multiplier += correction;
        }
    }

    /// `z −= L⁻ᵀ free`, and the pulls with it.
    fn move_point(&mut self, program: &Scaled) {
        if program.squared.is_empty() {
            self.whitening.subtract_unwhitened(&self.free, &mut self.z);
            return;
        }
        let step = &mut self.remainder;
        step.fill([0.0; WIDTH]);
        self.whitening.subtract_unwhitened(&self.free, step);
        lanes::axpy(1.0, step, &mut self.z);
        for (&(c, weight), pull) in program.squared.iter().zip(&mut self.pulls) {
            *pull -= weight * program.times(c, step);
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

fn all(program: &Scaled) -> Span {
    Span { first: 0, end: program.n }
}
