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

    /// Fixed variables, then equality rows. The clearly independent ones come first, so that of nearly dependent ones the
    /// best conditioned stay; those that follow from others are left out.
    pub(crate) fn take_equalities(&mut self) {
        let (m, all) = (self.program.m, self.program.constraints());
        for clear in [1e-2, 1e-4, CLEARLY] {
            let mut left = false;
            for c in (m..all).chain(0..m) {
                if self.program.kind[c] != Kind::Equality || self.set.place[c] == Place::In {
                    continue;
                }
                let member = Member { c, sign: 1.0 };
                if self.set.project(self.program, member) > clear {
                    self.take(member);
                    self.set.equalities += 1;
                } else {
                    left = true;
                }
            }
            if !left {
                return;
            }
        }
        for c in (m..all).chain(0..m) {
            if self.program.kind[c] != Kind::Equality || self.set.place[c] == Place::In {
                continue;
            }
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
        for c in 0..self.program.constraints() {
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
            let possible = self.program.kind[member.c] == Kind::Inequality && member.bound(self.program).is_finite();
            if possible && self.set.project(self.program, member) > CLEARLY {
                self.take(member);
            }
        }
    }
}
