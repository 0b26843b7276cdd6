//! Certificates of infeasibility (Farkas), believed only after a look at the numbers.

use crate::Side;
use crate::linear::max_abs;
use crate::scale::Scaled;
use crate::working_set::{Member, WorkingSet};

/// A certificate must hold for all `z` up to this times as large as anything seen, unless bounds keep `z` smaller.
const FAR: f64 = 1e6;
/// Rounding errors to expect in the bounds, relative to what cancels.
const ROUNDING: f64 = 1e-12;

/// Is the candidate's violation a proof that no point is feasible?
///
/// The candidate is `n = N r + remainder`, with `r <= 0` where a member is an inequality. Every feasible `z` has
/// `(n − N r)ᵀ z >= b − rᵀ b_N`. The right side, the gap, must exceed what the left side can reach: zero, were it not for the
/// remainder. It must also exceed `tolerance` and the rounding errors of its own sum. On success `conflict` holds the weights.
pub(crate) fn verify(
    program: &Scaled,
    set: &mut WorkingSet,
    candidate: Member,
    negligible: f64,
    tolerance: f64,
    conflict: &mut Vec<(Member, f64)>,
) -> bool {
    let q = set.members.len();
    for (k, r) in set.r[..q].iter_mut().enumerate() {
        // No inequality has a coefficient above `negligible` here: it would have left.
        if r.abs() <= negligible || (k >= set.equalities && *r > 0.0) {
            *r = 0.0;
        }
    }
    set.compute_remainder(program, candidate);
    let mut gap = candidate.bound(program);
    let mut size = gap.abs() + program.times_abs(candidate.c, &set.z);
    let mut far = max_abs(set.z.as_flattened()).max(gap.abs());
    for (member, r) in set.members.iter().zip(&set.r) {
        let bound = member.bound(program);
        gap -= r * bound;
        size += r.abs() * (bound.abs() + program.times_abs(member.c, &set.z));
        far = far.max(bound.abs());
    }
    far *= FAR;
    let mut reached = 0.0;
    for (j, v) in set.remainder.as_flattened()[..program.n].iter().enumerate() {
        let bound = if *v > 0.0 { program.upper[program.m + j] } else { -program.lower[program.m + j] };
        reached += v.abs() * bound.clamp(0.0, far);
    }
    if gap <= reached + tolerance + ROUNDING * size {
        return false;
    }
    conflict.clear();
    conflict.push((candidate, 1.0));
    for (member, r) in set.members.iter().zip(&set.r).filter(|(_, r)| r.abs() > 0.0) {
        let turned = Member { c: member.c, sign: if *r < 0.0 { member.sign } else { -member.sign } };
        conflict.push((turned, r.abs()));
    }
    // In the units of the original program, the largest one 1.
    let mut largest = 0.0_f64;
    for (member, weight) in conflict.iter_mut() {
        *weight *= program.multiplier_factor(member.c);
        // With a row stands the bound of the variable that it defines.
        let with_bound = program.replaced.of(member.c).map_or(1.0, |replaced| replaced.entry.abs().max(1.0));
        largest = largest.max(*weight * with_bound);
    }
    for (_, weight) in conflict.iter_mut() {
        *weight /= largest;
    }
    true
}

/// The side that a member's sign means.
pub(crate) fn side(member: Member) -> Side {
    if member.sign > 0.0 { Side::Lower } else { Side::Upper }
}
