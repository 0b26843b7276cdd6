//! The dual active-set method of Goldfarb & Idnani (1983): from the optimum over the equalities and a guess of the active
//! inequalities, violated constraints enter one at a time, and the dual objective rises with each.
//!
//! Between two entries the iterate is what the paper calls an S-pair: the optimum of the program that keeps only the
//! constraints of the working set, with multipliers of the right signs.

use crate::certificate;
use crate::scale::{Kind, Scaled};
use crate::working_set::{Member, Place, WorkingSet};
use crate::{Settings, Status};

/// Weight of the size of a row's terms, beside that of its bound, in the tolerance for its violation.
const TERMS: f64 = 1e-3;
/// A violation is clear beyond this times the tolerance.
const CLEAR_VIOLATION: f64 = 1e3;
/// Where rounding errors stop the search, violations are accepted up to this times the tolerance, with the full size of the
/// terms.
const ACCEPTED: f64 = 10.0;
/// The rounding error that the factors leave in `a_cᵀz`, relative to `|L⁻¹a_c| |y|`.
const NOISE: f64 = 4.0 * f64::EPSILON;
/// As many times this are accepted where rounding errors stop the search.
const ACCEPTED_NOISE: f64 = 32.0;
/// A point is zero where `y` is shorter than this times the `y` without constraints: it then is a sum of which rounding
/// errors have left a rest.
const VANISHING: f64 = 1e-13;
/// Largest product of multipliers and errors of the members' equations, relative to the terms of the objective.
const DUALITY_GAP: f64 = 1e-8;
/// The value must rise by this times the size of its terms, or the step counts as stalled.
const PROGRESS: f64 = 1e-14;
/// A normal is independent without further questions if this part of it, or more, lies outside the span of the working
/// set.
pub(crate) const CLEARLY: f64 = 1e-6;
/// A coefficient below this times the largest one (and one) does not block a step.
const NEGLIGIBLE: f64 = 1e-12;

/// What became of a candidate.
pub(crate) enum Entry {
    Entered,
    /// See [`Place::Aside`].
    SetAside,
    Infeasible,
}

/// A violated inequality, and whether it is so beyond what refinement may change.
struct Violated {
    member: Member,
    clearly: bool,
}

/// One search for the optimal working set.
pub(crate) struct Search<'a> {
    pub(crate) program: &'a Scaled,
    pub(crate) set: &'a mut WorkingSet,
    pub(crate) settings: &'a Settings,
    /// Members with Farkas weights, of the scaled program.
    pub(crate) conflict: &'a mut Vec<(Member, f64)>,
    /// The guess, be it empty, is what someone expects at the optimum.
    pub(crate) informed: bool,
    pub(crate) iterations: u32,
    /// The iterate has been refined since the working set last changed.
    pub(crate) refined: bool,
}

impl Search<'_> {
    /// From the factorised program to the result; `previous` is the guess.
    pub(crate) fn run(&mut self, previous: &[Member]) -> Status {
        self.take_equalities();
        let empty = self.contradictory_empty_row();
        if empty || !self.set.left.is_empty() {
            self.refresh();
            if empty || self.contradictory_equalities() {
                return Status::Infeasible;
            }
        }
        self.take_guess(previous);
        self.refresh();
        if self.informed {
            // Most often the guess is right, and this the last step.
            self.refine();
        }
        self.ascend()
    }

    fn ascend(&mut self) -> Status {
        let patience = self.program.constraints();
        let mut highest = f64::NEG_INFINITY;
        let mut stalled = 0;
        loop {
            self.drop_negative();
            let candidate = self.most_violated();
            let Some(Violated { member: candidate, .. }) = candidate.filter(|found| found.clearly || self.refined)
            else {
                if self.refined {
                    return self.conclude(true);
                }
                self.refine();
                continue;
            };
            let (value, size) = self.set.value();
            if value > highest + PROGRESS * size {
                highest = value;
                stalled = 0;
            } else {
                stalled += 1;
            }
            if stalled > patience || self.iterations >= self.settings.max_iterations {
                if !self.refined {
                    self.refine();
                }
                if self.set.most_negative().is_some() {
                    self.refresh();
                }
                return self.conclude(false);
            }
            if let Entry::Infeasible = self.enter(candidate) {
                return Status::Infeasible;
            }
        }
    }

    /// Optimal if all that is left violated is so within [`ACCEPTED`], and the members hold well enough for their
    /// multipliers.
    ///
    /// After a complete search only those can be violated that were set aside or left out.
    fn conclude(&self, complete: bool) -> Status {
        let accepted =
            |c: usize| self.is_acceptable(Member { c, sign: 1.0 }) && self.is_acceptable(Member { c, sign: -1.0 });
        let open = self.set.place.iter().zip(&self.program.kind).enumerate().filter(|(_, (place, kind))| {
            **place != Place::In
                && !(complete && **place == Place::Out)
                && matches!(kind, Kind::Inequality | Kind::Equality)
        });
        let program = self.program;
        let (_, mut size) = self.set.value();
        let mut gap = 0.0;
        for (member, multiplier) in self.set.members.iter().zip(&self.set.multipliers) {
            gap += (multiplier * member.shortfall(program, &self.set.z)).abs();
            size += (multiplier * member.bound(program)).abs();
        }
        let free = self.set.gradient_length();
        size = size.max(VANISHING * free * free);
        if gap <= DUALITY_GAP * size && open.map(|(c, _)| c).all(accepted) {
            Status::Optimal
        } else {
            Status::IterationLimit
        }
    }

    /// Up to this a shortfall is none.
    pub(crate) fn tolerance(&self, member: Member, y_length: f64) -> f64 {
        let terms = self.program.times_abs(member.c, &self.set.z);
        let size = member.bound(self.program).abs() + TERMS * terms;
        self.settings.feasibility_tolerance * size + NOISE * self.set.reach(self.program, member.c) * y_length
    }

    /// Is it at least one that may be left where rounding errors stop the search?
    fn is_acceptable(&self, member: Member) -> bool {
        let shortfall = member.shortfall(self.program, &self.set.z);
        if shortfall <= 0.0 {
            return true;
        }
        let terms = self.program.times_abs(member.c, &self.set.z);
        let size = member.bound(self.program).abs() + terms;
        let (y_length, free) = (self.set.y_length(), self.set.gradient_length());
        let length = if y_length < VANISHING * free { free } else { ACCEPTED_NOISE * y_length };
        let noise = NOISE * self.set.reach(self.program, member.c) * length;
        shortfall <= ACCEPTED * self.settings.feasibility_tolerance * size + noise
    }

    /// The inequality with the largest shortfall in the scaled program.
    fn most_violated(&self) -> Option<Violated> {
        let y_length = self.set.y_length();
        let mut worst = 0.0;
        let mut found = None;
        self.program.for_each_inequality(&self.set.z, |c, below, above| {
            if (below <= worst && above <= worst) || self.set.place[c] != Place::Out {
                return;
            }
            let (sign, shortfall) = if below > above { (1.0, below) } else { (-1.0, above) };
            let member = Member { c, sign };
            let tolerance = self.tolerance(member, y_length);
            if shortfall > tolerance {
                worst = shortfall;
                found = Some(Violated { member, clearly: shortfall > CLEAR_VIOLATION * tolerance });
            }
        });
        found
    }

    pub(crate) fn refresh(&mut self) {
        self.set.refresh(self.program);
        self.refined = false;
    }

    pub(crate) fn refine(&mut self) {
        self.set.refine(self.program);
        self.refined = true;
    }

    /// Makes the multipliers of inequalities positive, by dropping.
    fn drop_negative(&mut self) {
        while let Some(k) = self.set.most_negative() {
            if !self.refined {
                self.refine();
                continue;
            }
            self.set.drop(k);
            self.iterations += 1;
            self.refresh();
        }
    }

    /// Computes `d` and `r` of the candidate: is it a combination of the members?
    pub(crate) fn look(&mut self, candidate: Member) -> bool {
        let clear = self.set.project(self.program, candidate) > CLEARLY;
        self.set.solve_coefficients();
        !clear && self.set.is_dependent(self.program, candidate)
    }

    /// Adds a projected candidate without a step: a refresh must follow.
    pub(crate) fn take(&mut self, candidate: Member) {
        self.set.add(candidate);
    }

    /// Brings a violated constraint into the working set. Members whose multiplier reaches zero on the way leave it.
    /// Goldfarb & Idnani 1983, Algorithm, steps 1 and 2.
    fn enter(&mut self, candidate: Member) -> Entry {
        loop {
            let dependent = self.look(candidate);
            let blocking = self.blocking();
            if dependent {
                let Some((k, step)) = blocking else {
                    return self.no_way_out(candidate);
                };
                self.leave(k, step);
                continue;
            }
            let shortfall = candidate.shortfall(self.program, &self.set.z).max(0.0);
            let full_step = shortfall / (self.set.free_length * self.set.free_length);
            match blocking {
                Some((k, step)) if step < full_step => {
                    self.set.step(step);
                    self.leave(k, step);
                }
                _ => {
                    self.set.add(candidate);
                    self.iterations += 1;
                    self.refresh();
                    return Entry::Entered;
                }
            }
        }
    }

    /// The inequality whose multiplier reaches zero first when the candidate's grows, and when.
    fn blocking(&self) -> Option<(usize, f64)> {
        let set = &*self.set;
        let q = set.members.len();
        let threshold = negligible(&set.r[..q]);
        let mut found: Option<(usize, f64)> = None;
        for k in set.equalities..q {
            if set.r[k] <= threshold {
                continue;
            }
            let step = set.multipliers[k].max(0.0) / set.r[k];
            if found.is_none_or(|(_, first)| step < first) {
                found = Some((k, step));
            }
        }
        found
    }

    /// Multipliers after a step, at which member `k` leaves.
    fn leave(&mut self, k: usize, step: f64) {
        let set = &mut *self.set;
        for (multiplier, r) in set.multipliers.iter_mut().zip(&set.r) {
            *multiplier -= step * r;
        }
        set.drop(k);
        self.iterations += 1;
    }

    /// The candidate is violated, depends on the members, and none of them can leave: the program is infeasible, unless
    /// rounding errors only make it look so.
    pub(crate) fn no_way_out(&mut self, candidate: Member) -> Entry {
        let q = self.set.members.len();
        let threshold = negligible(&self.set.r[..q]);
        let tolerance = ACCEPTED * self.settings.feasibility_tolerance * candidate.bound(self.program).abs();
        if certificate::verify(self.program, self.set, candidate, threshold, tolerance, self.conflict) {
            self.refresh();
            return Entry::Infeasible;
        }
        self.set.place[candidate.c] = Place::Aside;
        self.refresh();
        Entry::SetAside
    }
}

fn negligible(r: &[f64]) -> f64 {
    NEGLIGIBLE * r.iter().fold(1.0, |largest: f64, r| largest.max(r.abs()))
}
