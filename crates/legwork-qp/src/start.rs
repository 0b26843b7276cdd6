//! The start of the search: the equalities, which stay in the working set, and the guess.

use crate::dual::{CLEARLY, Entry, Search};
use crate::scale::Kind;
use crate::working_set::{Member, Place};

impl Search<'_> {
    /// A row without a nonzero entry whose bounds exclude zero.
    pub(crate) fn contradictory_empty_row(&mut self) -> bool {
        let tolerance = self.settings.feasibility_tolerance;
        let program = self.program;
        for c in (0..program.m).filter(|&c| program.kind[c] == Kind::Empty) {
            let sign = if program.lower[c] > 0.0 { 1.0 } else { -1.0 };
            let member = Member { c, sign };
            if member.bound(program) > tolerance {
                self.conflict.push((member, 1.0));
                return true;
            }
        }
        false
    }

    /// Fixed variables, then equality rows, those of one entry first, which leave zeros. The clearly independent ones come first, so that of nearly dependent ones the
    /// best conditioned stay; those that follow from others are left out.
    pub(crate) fn take_equalities(&mut self) {
        let (m, all) = (self.program.m, self.program.constraints());
        self.set.left.clear();
        for (range, single) in [(m..all, true), (0..m, true), (0..m, false)] {
            for (c, _) in range.clone().zip(&self.program.kind[range]).filter(|(_, kind)| **kind == Kind::Equality) {
                let span = self.program.span[c];
                if (span.end == span.first + 1) == single {
                    self.set.left.push((c, f64::INFINITY));
                }
            }
        }
        for clear in [1e-2, 1e-4, CLEARLY] {
            let mut left = 0;
            for i in 0..self.set.left.len() {
                // What lies outside of the span only shrinks.
                let (c, mut outside) = self.set.left[i];
                let member = Member { c, sign: 1.0 };
                if outside > clear {
                    outside = self.set.project(self.program, member);
                    if outside > clear {
                        self.take(member);
                        self.set.equalities += 1;
                        continue;
                    }
                }
                self.set.left[left] = (c, outside);
                left += 1;
            }
            self.set.left.truncate(left);
        }
        for i in 0..self.set.left.len() {
            let c = self.set.left[i].0;
            let member = Member { c, sign: 1.0 };
            if self.look(member) {
                self.set.place[c] = Place::Implied;
            } else {
                self.take(member);
                self.set.equalities += 1;
            }
        }
    }

    /// Is an equality that was left out violated, and by more than rounding errors can explain?
    pub(crate) fn contradictory_equalities(&mut self) -> bool {
        for i in 0..self.set.left.len() {
            let c = self.set.left[i].0;
            if self.set.place[c] != Place::Implied {
                continue;
            }
            if !self.refined {
                self.refine();
            }
            let above = Member { c, sign: 1.0 };
            let shortfall = above.shortfall(self.program, &self.set.z);
            let member = if shortfall > 0.0 { above } else { Member { c, sign: -1.0 } };
            if shortfall.abs() > self.tolerance(member, self.set.y_length()) {
                self.look(member);
                if let Entry::Infeasible = self.no_way_out(member) {
                    return true;
                }
            }
        }
        false
    }

    /// As much of the guess as can hold together.
    pub(crate) fn take_guess(&mut self, previous: &[Member]) {
        for &member in previous {
            let member = self.program.translated(member);
            let possible = self.program.kind[member.c] == Kind::Inequality && member.bound(self.program).is_finite();
            if possible && self.set.project(self.program, member) > CLEARLY {
                self.take(member);
            }
        }
    }
}
