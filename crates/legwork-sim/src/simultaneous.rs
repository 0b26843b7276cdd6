//! All contacts at once, by Newton's method over the twists of the feet.
//!
//! Contacts that yield by ε, a hundred thousandth of what the robot yields, have one solution: with the velocities q above the
//! target, `z = λ̄ - q / ε` and the priors λ̄ = 0, normal impulses are `max(z, 0)`, and tangential ones are z up to the edge of the
//! cone and on it beyond. That is Coulomb's law but for ε, friction opposite to the slip; and of all ways in which the corners
//! of a foot could share its load, which nothing tells apart where they are rigid, it is the one of least norm. In its mode
//! (open, stick, slip along a direction) a contact is linear, λ = S z, so that a step of Newton's method is a linear equation
//! for the twists of the loaded feet, however many contacts they have. The impulses become the priors of a second pass, which
//! leaves ε squared of the error: the method of multipliers (Alart and Curnier 1991).
//!
//! Where the modes do not settle the contacts are made to yield more at first, and less and less after that; where that path
//! ends, they are solved with friction that has an energy, from which the law is tried; and in the end modes are tried one after another.

use super::contact_law::{Friction, Mode};
use super::contact_solver::{ContactSolver, Point, Report, add, norm, unit};
use super::square::Square;
use crate::settings::ContactSettings;

/// ε as a share of the mean gain of the normals. Rounding leaves 1e-16 / ε of the impulses.
const YIELD: f64 = 1e-5;

/// The same where loads are determined: rounding is less where the priors are good.
const DETERMINED_YIELD: f64 = 1e-7;

/// Most steps of Newton's method at one ε, and most trials of how far a step goes.
const STEPS: u32 = 16;
const TRIALS: u32 = 10;

/// Most passes with priors.
const PASSES: u32 = 12;

/// How many times the tolerance is good enough where more passes do not help.
const VAIN: f64 = 1000.0;

/// Most linear solves on the way from a large ε to a small one, the power of ten that it begins with, and the least stride.
const SOLVES: u32 = 100;
const SOFTEST: f64 = 5.0;
const LEAST_STRIDE: f64 = 0.02;

/// Ground that is raised by no more than this stays [m/s].
const LIFTED: f64 = 1e-6;

/// Scratch of the linear equations.
#[derive(Clone, Debug)]
pub(super) struct Simultaneous<const D: usize, const K: usize> {
    /// Of each contact.
    states: Vec<State<D>>,
    /// Those of the latest ε that went well.
    good: Vec<State<D>>,
    /// The modes and the ε that `system` was factorised for, if `factored`.
    factored_modes: Vec<Mode<D>>,
    factored_yield: f64,
    factored: bool,
    /// The feet that bear a load in these modes: their twists are the unknowns.
    loaded: Vec<usize>,
    /// For each foot the sum over its contacts of impulse's wrench times velocity's row.
    shape: Vec<[[f64; K]; K]>,
    system: Square,
    right: Vec<f64>,
    /// The iterate, where Newton's step began, and where it ends.
    at: Iterate<K>,
    start: Iterate<K>,
    end: Iterate<K>,
    /// For each foot the wrenches that the law makes of the iterate above those that made it, and their response.
    miss: Iterate<K>,
    /// A response of this size is none [m/s, rad/s].
    small: f64,
    /// Linear solves so far.
    solves: u32,
    /// The impulses that missed the law least so far, and by how much [Ns].
    best: Best<D>,
    /// By how much the ground is raised under each contact [m/s].
    lifts: Vec<f64>,
}

/// Wrenches on the feet above those of the priors, and the response of the feet's twists, δ.
#[derive(Clone, Debug)]
struct Iterate<const K: usize> {
    wrench: Vec<[f64; K]>,
    change: Vec<[f64; K]>,
}

impl<const K: usize> Iterate<K> {
    fn new(feet: usize) -> Self {
        Self { wrench: vec![[0.0; K]; feet], change: vec![[0.0; K]; feet] }
    }

    fn copy(&mut self, other: &Self) {
        self.wrench.copy_from_slice(&other.wrench);
        self.change.copy_from_slice(&other.change);
    }

    /// Takes the point between two others.
    fn between(&mut self, start: &Self, end: &Self, share: f64) {
        let mix = |out: &mut Vec<[f64; K]>, start: &[[f64; K]], end: &[[f64; K]]| {
            for ((out, start), end) in out.iter_mut().zip(start).zip(end) {
                *out = std::array::from_fn(|i| start[i] + share * (end[i] - start[i]));
            }
        };
        mix(&mut self.wrench, &start.wrench, &end.wrench);
        mix(&mut self.change, &start.change, &end.change);
    }

    fn respond<const D: usize>(&mut self, contacts: &ContactSolver<D, K>) {
        for (foot, change) in self.change.iter_mut().enumerate() {
            *change = contacts.response(foot, &self.wrench);
        }
    }
}

#[derive(Clone, Debug)]
struct Best<const D: usize> {
    residual: f64,
    impulses: Vec<[f64; D]>,
}

#[derive(Clone, Copy, Debug)]
struct State<const D: usize> {
    mode: Mode<D>,
    friction: Friction,
    /// λ̄ [Ns]
    prior: [f64; D],
    /// q where the impulses are the priors [m/s].
    motion: [f64; D],
    /// λ [Ns]
    impulse: [f64; D],
}

/// z of a contact where the twists change by `change`.
#[inline]
fn z<const D: usize, const K: usize>(
    state: &State<D>,
    point: &Point<D, K>,
    change: &[[f64; K]],
    epsilon: f64,
) -> [f64; D] {
    let after = point.velocity(&change[point.foot]);
    std::array::from_fn(|i| state.prior[i] - (state.motion[i] + after[i]) / epsilon)
}

impl<const D: usize, const K: usize> Simultaneous<D, K> {
    /// Scratch for so many points and feet.
    pub(super) fn new(points: usize, feet: usize) -> Self {
        Self {
            states: Vec::with_capacity(points),
            good: Vec::with_capacity(points),
            factored_modes: Vec::with_capacity(points),
            factored_yield: 0.0,
            factored: false,
            loaded: Vec::with_capacity(feet),
            shape: vec![[[0.0; K]; K]; feet],
            system: Square::new(feet * K),
            right: vec![0.0; feet * K],
            at: Iterate::new(feet),
            start: Iterate::new(feet),
            end: Iterate::new(feet),
            miss: Iterate::new(feet),
            small: 0.0,
            solves: 0,
            best: Best { residual: 0.0, impulses: Vec::with_capacity(points) },
            lifts: Vec::with_capacity(points),
        }
    }

    /// Forgets the factors: another configuration.
    pub(super) fn forget(&mut self) {
        self.factored = false;
    }

    /// Solves `contacts` until no impulse misses the law by more than `tolerance` [Ns]; the impulses that they have tell which of
    /// them stick at first. The report's sweeps are linear solves, and their number is bounded.
    pub(super) fn solve(
        &mut self,
        contacts: &mut ContactSolver<D, K>,
        tolerance: f64,
        settings: &ContactSettings,
    ) -> Report {
        let gain = contacts.points.iter().map(|point| point.gain).sum::<f64>() / contacts.points.len() as f64;
        // Where every foot has a single contact, loads are determined, and those of the step before are the best guess of them.
        let is_determined = contacts.points.windows(2).all(|pair| pair[0].foot != pair[1].foot);
        let least = gain * if is_determined { DETERMINED_YIELD } else { YIELD };
        self.small = 0.1 * tolerance * gain;
        (self.solves, self.best.residual) = (0, f64::INFINITY);
        if !self.factored {
            self.find_modes(contacts);
        }
        // Again in the same configuration: from the solution that was found, with its factors.
        let again = (self.factored || is_determined) && {
            contacts.load();
            self.begin(contacts);
            self.relax(contacts, least) && self.refine(contacts, least, tolerance)
        };
        let least = YIELD * gain;
        let solved = again || {
            self.find_modes(contacts);
            self.start_over(contacts);
            self.relax(contacts, least) && self.refine(contacts, least, tolerance)
                || {
                    self.start_over(contacts);
                    self.harden(contacts, least) && self.refine(contacts, least, tolerance)
                }
                || self.lift(contacts, least, tolerance, settings)
                || self.try_modes(contacts, least, tolerance, settings)
        };
        if !solved {
            self.take_best(contacts);
        }
        Report { sweeps: self.solves, residual: self.best.residual }
    }

    /// The modes of the impulses that the contacts have.
    fn find_modes(&mut self, contacts: &ContactSolver<D, K>) {
        self.states.clear();
        self.states.extend(contacts.points.iter().map(|point| {
            let friction = Friction { coefficient: point.friction, nearest: false };
            // An impulse on the edge of the cone slips, whatever rounding says.
            let narrow = Friction { coefficient: point.friction * (1.0 - 1e-9), ..friction };
            let mut mode = Mode::of(&point.impulse, narrow);
            if let Mode::Slip { share, .. } = &mut mode {
                *share = 0.0;
            }
            State { mode, friction, prior: [0.0; D], motion: [0.0; D], impulse: [0.0; D] }
        }));
    }

    /// From no impulses: of all solutions the one of least norm, whatever the guess.
    fn start_over(&mut self, contacts: &mut ContactSolver<D, K>) {
        contacts.points.iter_mut().for_each(|point| point.impulse = [0.0; D]);
        contacts.load();
        self.begin(contacts);
    }

    /// The contacts' impulses are the priors.
    fn begin(&mut self, contacts: &ContactSolver<D, K>) {
        for (state, point) in self.states.iter_mut().zip(&contacts.points) {
            (state.prior, state.motion) = (point.impulse, point.motion(&contacts.twist[point.foot]));
        }
    }

    /// Passes with priors, which leave ever less of what contacts yield. Returns whether the law holds.
    fn refine(&mut self, contacts: &mut ContactSolver<D, K>, mut epsilon: f64, tolerance: f64) -> bool {
        let (mut before, mut ended) = (f64::INFINITY, true);
        for pass in 0.. {
            self.hand_over(contacts);
            let residual = contacts.residual();
            if residual <= tolerance {
                self.best.residual = residual;
                return true;
            }
            self.note(residual, contacts);
            // Corners that ask for what no rigid foot can do would be loaded against each other in vain.
            let in_vain = residual > 0.5 * before && (!ended || residual <= VAIN * tolerance);
            if in_vain || pass == PASSES {
                break;
            }
            before = residual;
            self.begin(contacts);
            // What slips slowly turns slowly, and what corners ask for that no rigid foot can do grows until one of them opens.
            if pass >= 2 && pass % 2 == 0 {
                epsilon *= 0.1;
            }
            ended = self.relax(contacts, epsilon);
        }
        self.take_best(contacts);
        self.best.residual <= VAIN * tolerance
    }

    /// Takes impulses as the nearest in the cone, which has a solution and one only, and raises the ground under what slips by so
    /// much as that lifts it, until it lifts nothing: De Saxcé's change of variables (Acary, Cadoux, Lemaréchal and Malick 2011). From
    /// each of those solutions Newton's method tries the law itself.
    fn lift(
        &mut self,
        contacts: &mut ContactSolver<D, K>,
        least: f64,
        tolerance: f64,
        settings: &ContactSettings,
    ) -> bool {
        self.lifts.clear();
        self.lifts.resize(contacts.points.len(), 0.0);
        for round in 1u32.. {
            if self.solves >= settings.max_sweeps {
                break;
            }
            self.start_over(contacts);
            for (state, lift) in self.states.iter_mut().zip(&self.lifts) {
                state.friction.nearest = true;
                state.motion[D - 1] += lift;
            }
            if round == 1 || !self.relax(contacts, least) {
                self.harden(contacts, least);
            }
            let mut moved: f64 = 0.0;
            let states = self.states.iter_mut().zip(&contacts.points).zip(&mut self.lifts);
            for ((state, point), lift) in states {
                let after = point.velocity(&self.at.change[point.foot]);
                let slip: [f64; D] = std::array::from_fn(|i| state.motion[i] + after[i]);
                let change = state.friction.coefficient * norm(&slip[..D - 1]) - *lift;
                moved = moved.max(change.abs());
                *lift += settings.relaxation * change;
                state.friction.nearest = false;
            }
            self.good.clone_from(&self.states);
            self.hand_over(contacts);
            self.note(contacts.residual(), contacts);
            let last = moved < LIFTED;
            if last || round.is_power_of_two() {
                self.start_over(contacts);
                if self.relax(contacts, least) && self.refine(contacts, least, tolerance) {
                    return true;
                }
                self.states.clone_from(&self.good);
            }
            if last {
                break;
            }
        }
        false
    }

    /// Tries the modes that no step led to: first those that differ from the best ones at one contact, then at two, and so on. In the plane
    /// these are all modes that there are. In space a contact slips against the best motion or along it, from where Newton's method goes on.
    fn try_modes(
        &mut self,
        contacts: &mut ContactSolver<D, K>,
        least: f64,
        tolerance: f64,
        settings: &ContactSettings,
    ) -> bool {
        self.take_best(contacts);
        self.good.clear();
        self.good.extend(self.states.iter().zip(&contacts.points).map(|(state, point)| {
            let motion = point.motion(&contacts.twist[point.foot]);
            State { mode: Mode::of(&point.impulse, state.friction), motion, ..*state }
        }));
        let (count, last) = (self.states.len(), self.solves + settings.max_sweeps);
        // A digit to the base of four for each contact.
        let codes = 4u32.saturating_pow(count as u32);
        let digit = |code: u32, contact: usize| code >> (2 * contact) & 3;
        for others in 0..=count {
            for code in (0..codes).filter(|&code| (0..count).filter(|&k| digit(code, k) > 0).count() == others) {
                if self.solves >= last {
                    return false;
                }
                self.start_over(contacts);
                for (k, (state, best)) in self.states.iter_mut().zip(&self.good).enumerate() {
                    state.mode = best.mode.other(digit(code, k), &best.motion, best.friction.coefficient);
                }
                let ended = if D == 2 { self.holds(contacts, least) } else { self.relax(contacts, least) };
                if ended && self.refine(contacts, least, tolerance) {
                    return true;
                }
            }
        }
        false
    }

    /// Whether the modes that the contacts have are those of the solution in them.
    fn holds(&mut self, contacts: &ContactSolver<D, K>, epsilon: f64) -> bool {
        let solved = self.predict(contacts, epsilon);
        self.at.copy(&self.end);
        solved && self.evaluate(contacts, epsilon, true) <= self.small
    }

    /// Notes the impulses that the contacts have if they miss the law by less than all before.
    fn note(&mut self, residual: f64, contacts: &ContactSolver<D, K>) {
        if residual < self.best.residual {
            self.best.residual = residual;
            self.best.impulses.clear();
            self.best.impulses.extend(contacts.points.iter().map(|point| point.impulse));
        }
    }

    /// Gives the contacts the impulses that missed the law least.
    fn take_best(&self, contacts: &mut ContactSolver<D, K>) {
        for (point, impulse) in contacts.points.iter_mut().zip(&self.best.impulses) {
            point.impulse = *impulse;
        }
        contacts.load();
    }

    /// From a large ε to `least`, in strides that are longer as long as all goes well.
    fn harden(&mut self, contacts: &ContactSolver<D, K>, least: f64) -> bool {
        let last = self.solves + SOLVES;
        let (mut power, mut stride, mut good) = (SOFTEST, 1.0, SOFTEST);
        self.good.clear();
        while self.solves < last {
            if self.relax(contacts, least * libm::exp10(power)) {
                if power == 0.0 {
                    return true;
                }
                (good, power, stride) = (power, (power - stride).max(0.0), 2.0 * stride);
                self.good.clone_from(&self.states);
            } else {
                stride = 0.25 * (good - power);
                if self.good.is_empty() || stride < LEAST_STRIDE {
                    return false;
                }
                power = good - stride;
                self.states.clone_from(&self.good);
            }
            // The speed of slip stays: the share of z that friction keeps is as ε.
            let scale = libm::exp10(power - good);
            for state in &mut self.states {
                if let Mode::Slip { share, .. } = &mut state.mode {
                    *share *= scale;
                }
            }
        }
        false
    }

    /// Newton's method at one ε, from the modes that the contacts have. Returns whether it ends.
    fn relax(&mut self, contacts: &ContactSolver<D, K>, epsilon: f64) -> bool {
        if !self.predict(contacts, epsilon) {
            return false;
        }
        self.at.copy(&self.end);
        let mut miss = self.evaluate(contacts, epsilon, true);
        if miss <= self.small {
            return true;
        }
        // Rounding of the velocities, as impulses, moves the feet.
        let fastest = self.states.iter().flat_map(|state| state.motion).map(f64::abs).fold(0.0, f64::max);
        let most = contacts.coupling.iter().flatten().flatten().copied().fold(0.0, f64::max);
        let loose = self.small + 20.0 * f64::EPSILON * fastest * most / epsilon;
        for _ in 0..STEPS {
            if !self.predict(contacts, epsilon) {
                return false;
            }
            self.start.copy(&self.at);
            let before = miss;
            // Without slip the miss is the gradient of a convex energy: along the step to where that is least.
            let first = self.slope();
            miss = self.go(1.0, contacts, epsilon);
            let mut last = self.slope();
            if last < -0.1 * first && first > 0.0 {
                let (mut low, mut high, mut rise) = (0.0, 1.0, first);
                for _ in 0..TRIALS {
                    let share = low + (high - low) * (rise / (rise - last)).clamp(0.05, 0.95);
                    miss = self.go(share, contacts, epsilon);
                    let slope = self.slope();
                    if slope.abs() <= 0.1 * first {
                        break;
                    }
                    if slope > 0.0 { (low, rise) = (share, slope) } else { (high, last) = (share, slope) }
                }
            }
            if miss <= self.small || (miss >= before && before <= loose) {
                return true;
            }
        }
        miss <= loose
    }

    /// Where Newton's step ends, which is where the contacts' modes would be right: of the loaded feet
    /// `(ε 1 + B C) δ = -B Jᵀ (S q - ε r)`, with the contacts' wrenches Jᵀ and what their modes change of the priors at once, r.
    /// Returns false where the equations are singular.
    fn predict(&mut self, contacts: &ContactSolver<D, K>, epsilon: f64) -> bool {
        self.solves += 1;
        if !self.factor(contacts, epsilon) {
            return false;
        }
        self.miss.wrench.fill([0.0; K]);
        for (state, point) in self.states.iter().zip(&contacts.points) {
            let (pull, kept) =
                (state.mode.times(&state.motion, state.friction), state.mode.times(&state.prior, state.friction));
            let force = std::array::from_fn(|i| epsilon * (kept[i] - state.prior[i]) - pull[i]);
            add(&mut self.miss.wrench[point.foot], &point.wrench(&force));
        }
        for (right, &foot) in self.right.chunks_exact_mut(K).zip(&self.loaded) {
            right.copy_from_slice(&contacts.response(foot, &self.miss.wrench));
        }
        self.system.solve(&mut self.right[..self.loaded.len() * K]);
        for (right, &foot) in self.right.chunks_exact(K).zip(&self.loaded) {
            self.end.change[foot].copy_from_slice(right);
        }
        self.end.wrench.fill([0.0; K]);
        for (state, point) in self.states.iter().zip(&contacts.points) {
            let impulse = state.mode.times(&z(state, point, &self.end.change, epsilon), state.friction);
            let more = std::array::from_fn(|i| impulse[i] - state.prior[i]);
            add(&mut self.end.wrench[point.foot], &point.wrench(&more));
        }
        for foot in (0..self.shape.len()).filter(|foot| !self.loaded.contains(foot)) {
            self.end.change[foot] = contacts.response(foot, &self.end.wrench);
        }
        true
    }

    /// Goes a share of Newton's step; returns by how much the law is missed there.
    fn go(&mut self, share: f64, contacts: &ContactSolver<D, K>, epsilon: f64) -> f64 {
        self.at.between(&self.start, &self.end, share);
        self.evaluate(contacts, epsilon, share == 1.0)
    }

    /// Modes and impulses of the iterate, and by how much their wrenches miss those that made it; returns the largest component of
    /// the response to that [m/s, rad/s].
    fn evaluate(&mut self, contacts: &ContactSolver<D, K>, epsilon: f64, is_end: bool) -> f64 {
        let mut same = true;
        for (out, wrench) in self.miss.wrench.iter_mut().zip(&self.at.wrench) {
            *out = wrench.map(|value| -value);
        }
        for ((state, factored), point) in self.states.iter_mut().zip(&self.factored_modes).zip(&contacts.points) {
            let z = z(state, point, &self.at.change, epsilon);
            state.mode = Mode::of(&z, state.friction);
            same &= state.mode == *factored;
            state.impulse = state.mode.times(&z, state.friction);
            let more = std::array::from_fn(|i| state.impulse[i] - state.prior[i]);
            add(&mut self.miss.wrench[point.foot], &point.wrench(&more));
        }
        if same && is_end {
            // The law is as linear there as it was taken to be.
            return 0.0;
        }
        self.miss.respond(contacts);
        self.miss.change.as_flattened().iter().map(|value| value.abs()).fold(0.0, f64::max)
    }

    /// How much the energy falls along Newton's step, at the iterate.
    fn slope(&self) -> f64 {
        let steps = self.end.change.iter().zip(&self.start.change).zip(&self.miss.wrench);
        steps.map(|((end, start), miss)| (0..K).map(|i| (end[i] - start[i]) * miss[i]).sum::<f64>()).sum()
    }

    /// Factorises `ε 1 + B C` for the modes, of the feet that are loaded in them. Returns false where it is singular.
    fn factor(&mut self, contacts: &ContactSolver<D, K>, epsilon: f64) -> bool {
        let same = |(mode, state): (&Mode<D>, &State<D>)| *mode == state.mode;
        let fits = self.factored && self.factored_yield == epsilon && self.factored_modes.len() == self.states.len();
        if !(fits && self.factored_modes.iter().zip(&self.states).all(same)) {
            self.assemble(contacts, epsilon);
            self.factored_modes.clear();
            self.factored_modes.extend(self.states.iter().map(|state| state.mode));
            self.factored_yield = epsilon;
            self.factored = self.system.factor();
        }
        self.factored
    }

    /// `ε 1 + B C`, with B of the loaded feet and C their shapes.
    fn assemble(&mut self, contacts: &ContactSolver<D, K>, epsilon: f64) {
        self.shape.fill([[0.0; K]; K]);
        self.loaded.clear();
        for (state, point) in self.states.iter().zip(&contacts.points) {
            if state.mode == Mode::Open {
                continue;
            }
            if !self.loaded.contains(&point.foot) {
                self.loaded.push(point.foot);
            }
            let shape = &mut self.shape[point.foot];
            for axis in 0..D {
                // Row `axis` of J: the velocity along it for a twist. Column `axis` of Jᵀ S: the wrench for z along it.
                let row = point.wrench(&unit(axis));
                let force = match state.mode {
                    Mode::Stick => row,
                    _ => point.wrench(&state.mode.times(&unit(axis), state.friction)),
                };
                for i in 0..K {
                    for j in 0..K {
                        shape[i][j] += force[i] * row[j];
                    }
                }
            }
        }
        let feet = self.shape.len();
        let width = self.loaded.len() * K;
        self.system.resize(width);
        for (a, rows) in self.system.entry.chunks_exact_mut((width * K).max(1)).enumerate() {
            for (b, &other) in self.loaded.iter().enumerate() {
                let (shape, block) = (&self.shape[other], &contacts.coupling[self.loaded[a] * feet + other]);
                for (row, gains) in rows.chunks_exact_mut(width).zip(block) {
                    let mut sum = [0.0; K];
                    for (gain, shape) in gains.iter().zip(shape) {
                        for j in 0..K {
                            sum[j] += gain * shape[j];
                        }
                    }
                    row[b * K..(b + 1) * K].copy_from_slice(&sum);
                }
            }
        }
        self.system.entry.iter_mut().step_by(width + 1).for_each(|entry| *entry += epsilon);
    }

    /// Gives the contacts their impulses, in the cone.
    fn hand_over(&self, contacts: &mut ContactSolver<D, K>) {
        for (state, point) in self.states.iter().zip(&mut contacts.points) {
            let normal = state.impulse[D - 1].max(0.0);
            point.impulse = match state.mode {
                Mode::Open => [0.0; D],
                Mode::Slip { along, .. } => along.map(|value| value * normal),
                Mode::Stick => {
                    let (limit, tangent) = (point.friction * normal, norm(&state.impulse[..D - 1]));
                    let share = if tangent > limit { limit / tangent } else { 1.0 };
                    let mut impulse = state.impulse.map(|value| value * share);
                    impulse[D - 1] = normal;
                    impulse
                }
            };
        }
        contacts.load();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SimulationSettings;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    /// Two feet with up to four points each, on a robot of some ten kilograms that moves and is held somehow.
    fn problem<const D: usize, const K: usize>(random: &mut Pcg64, most_friction: f64) -> ContactSolver<D, K> {
        let mut draw = |low: f64, high: f64| random.random_range(low..high);
        // B = Y Yᵀ, twists in m/s and rad/s: light feet on a heavy body.
        let rows = 2 * K + 2;
        let scale = |i: usize| if i % K < D { 0.2 } else { 2.0 };
        let y: Vec<Vec<f64>> = (0..2 * K).map(|i| (0..rows).map(|_| scale(i) * draw(-1.0, 1.0)).collect()).collect();
        let mut solver = ContactSolver::<D, K>::new(8, 2);
        for a in 0..2 {
            for b in 0..2 {
                let entry = |i: usize, j: usize| (0..rows).map(|r| y[a * K + i][r] * y[b * K + j][r]).sum::<f64>();
                solver.coupling[2 * a + b] = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
            }
        }
        for foot in 0..2 {
            solver.free[foot] = std::array::from_fn(|i| if i == D - 1 { draw(-1.0, 0.2) } else { draw(-0.5, 0.5) });
            let friction = draw(0.0, most_friction);
            let count = draw(1.0, if D == 2 { 3.0 } else { 5.0 }) as usize;
            for corner in 0..count {
                let mut arm = [0.0; D];
                arm[0] = if corner % 2 == 0 { -0.08 } else { 0.17 };
                if D == 3 {
                    arm[1] = if corner < 2 { -0.05 } else { 0.05 };
                }
                solver.points.push(Point::new(foot, arm, friction));
            }
        }
        solver.prepare();
        solver
    }

    /// Coulomb's law, as it is written: no pull, no approach, no push while opening, friction in the cone, on its edge and opposite to
    /// the slip where it slips. In Ns and m/s.
    fn check<const D: usize, const K: usize>(solver: &ContactSolver<D, K>, what: &str) {
        for point in &solver.points {
            let (motion, n) = (point.motion(&solver.twist[point.foot]), D - 1);
            let (normal, friction) = (point.impulse[n], norm(&point.impulse[..n]));
            assert!(
                normal >= 0.0 && motion[n] > -1e-6 && normal * motion[n] < 1e-6 * (1.0 + normal),
                "{what}: {point:?}"
            );
            assert!(friction <= point.friction * normal * (1.0 + 1e-12) + 1e-15, "{what}: {point:?}");
            let slip = norm(&motion[..n]);
            if slip > 1e-4 && normal > 1e-4 && point.friction > 0.0 {
                assert!(friction >= point.friction * normal * (1.0 - 1e-9), "{what}: slips inside the cone, {point:?}");
                let along: f64 = (0..n).map(|i| -point.impulse[i] * motion[i]).sum();
                let degrees = libm::acos((along / (friction * slip)).min(1.0)).to_degrees();
                assert!(degrees < 0.1, "{what}: {degrees} deg off the slip");
            }
        }
    }

    fn solve_many<const D: usize, const K: usize>(most_friction: f64, unsolved: u32) {
        let mut random = Pcg64::seed_from_u64(1);
        let settings = SimulationSettings::default().contact;
        let (mut failed, mut most) = (0, 0);
        for index in 0..3000 {
            let mut solver = problem::<D, K>(&mut random, most_friction);
            let report = Simultaneous::new(8, 2).solve(&mut solver, 1e-9, &settings);
            let held = solver.residual();
            assert!((held - report.residual).abs() <= 1e-6 * held, "{held} and {report:?}");
            most = report.sweeps.max(most);
            if report.residual > 1e-6 {
                failed += 1;
            } else {
                check(&solver, &format!("problem {index} in {D} dimensions"));
            }
        }
        assert!(failed <= unsolved && most < 1000, "{failed} unsolved, {most} solves");
    }

    /// A step of `stand-push` on ice, from which no path led to the modes; the right impulses are those of the one set of modes of all 64
    /// that keeps the law, found by another program.
    #[test]
    fn modes_that_no_path_led_to_are_found() {
        let mut solver = ContactSolver::<2, 3>::new(3, 2);
        solver.coupling = vec![
            [
                [0.3071748327805556, -0.2525456106480646, -0.7924662358075081],
                [-0.2525456106480646, 1.1224067678092977, 8.440881072198188],
                [-0.7924662358075081, 8.440881072198188, 91.99517080415337],
            ],
            [
                [6.596068704747956e-5, 0.006696313651165591, 0.031724037723648645],
                [-0.0002612125323911598, 0.005395946878180267, 0.02472424220403567],
                [-0.0003364219110051868, 0.04565673241287531, 0.21420168817857038],
            ],
            [
                [6.596068704747956e-5, -0.0002612125323911598, -0.0003364219110051868],
                [0.006696313651165591, 0.005395946878180267, 0.04565673241287531],
                [0.031724037723648645, 0.02472424220403567, 0.21420168817857038],
            ],
            [
                [0.7682781845693816, -0.389796177871856, -4.883123823580031],
                [-0.389796177871856, 0.5356061740987168, 6.337753035774466],
                [-4.883123823580031, 6.337753035774466, 91.51485892339485],
            ],
        ];
        solver.free = vec![
            [0.4582922490790241, 0.8407227731437819, 6.210814504230251],
            [0.13170615502125238, -0.17583671758375258, -1.9560054826386932],
        ];
        for (foot, arm, target) in [
            (0, [0.20977022296076608, -0.13600166748606624], [0.0003641426043748454, -0.0010326102050764018]),
            (1, [0.0, 0.0], [-4.7015871429153816e-5, -0.000755834595951415]),
            (1, [0.2499999999999999, -2.731148640577885e-14], [-4.7015871429153816e-5, -0.0007558345686399286]),
        ] {
            solver.points.push(Point { target, ..Point::new(foot, arm, 0.028) });
        }
        solver.prepare();
        let settings = SimulationSettings::default().contact;
        let report = Simultaneous::new(3, 2).solve(&mut solver, 1e-9, &settings);
        assert!(report.residual <= 1e-9 && report.sweeps < settings.max_sweeps, "{report:?}");
        check(&solver, "on ice");
        let of = |foot: usize, axis: usize| {
            solver.points.iter().filter(|point| point.foot == foot).map(|point| point.impulse[axis]).sum::<f64>()
        };
        let expected = [[-0.007918, 0.2907], [-0.011303, 0.41212]];
        for (foot, expected) in expected.iter().enumerate() {
            assert!((0..2).all(|axis| (of(foot, axis) / expected[axis] - 1.0).abs() < 3e-4), "{:?}", solver.points);
        }
    }

    #[test]
    fn impulses_keep_the_law_in_the_plane_and_in_space() {
        solve_many::<2, 3>(1.5, 0);
        solve_many::<3, 6>(1.5, 0);
        // Where friction is high, many modes keep the law, or few that no path leads to.
        solve_many::<2, 3>(6.0, 0);
        solve_many::<3, 6>(6.0, 0);
    }

    /// The guess on the edge of the cone slips, be it a rounding error inside.
    #[test]
    fn a_guess_tells_which_contacts_are_open_stick_or_slip() {
        let mut contacts = ContactSolver::<2, 3>::new(5, 1);
        for impulse in [[0.0, 0.0], [0.9, 2.0], [1.0, 2.0], [-1.0 + 1e-12, 2.0], [3.0, 2.0]] {
            contacts.points.push(Point { impulse, ..Point::new(0, [0.0; 2], 0.5) });
        }
        let mut together = Simultaneous::new(5, 1);
        together.find_modes(&contacts);
        let found = together.states.iter().map(|state| match state.mode {
            Mode::Open => "open",
            Mode::Stick => "stick",
            Mode::Slip { along: [tangent, 1.0], share: 0.0 } if (tangent - 0.5).abs() < 1e-8 => "slip",
            Mode::Slip { along: [tangent, 1.0], share: 0.0 } if (tangent + 0.5).abs() < 1e-8 => "slip back",
            Mode::Slip { .. } => "another",
        });
        assert_eq!(found.collect::<Vec<_>>(), ["open", "stick", "slip", "slip back", "slip"]);
    }

    /// With a friction of 0.5.
    #[test]
    fn impulses_that_are_handed_over_are_in_the_cone() {
        let mut contacts = ContactSolver::<3, 6>::new(5, 1);
        let mut together = Simultaneous::new(5, 1);
        let slip = Mode::Slip { along: [0.3, 0.4, 1.0], share: 0.7 };
        let cases = [
            (Mode::Open, [1.0, 2.0, 3.0], [0.0, 0.0, 0.0]),
            (slip, [9.0, 9.0, 2.0], [0.6, 0.8, 2.0]),
            (slip, [9.0, 9.0, -2.0], [0.0, 0.0, 0.0]),
            (Mode::Stick, [0.3, 0.4, 2.0], [0.3, 0.4, 2.0]),
            // 5 of 1 that friction holds.
            (Mode::Stick, [3.0, -4.0, 2.0], [0.6, -0.8, 2.0]),
        ];
        for (mode, impulse, _) in cases {
            contacts.points.push(Point::new(0, [0.0; 3], 0.5));
            let friction = Friction { coefficient: 0.5, nearest: false };
            together.states.push(State { mode, friction, prior: [0.0; 3], motion: [0.0; 3], impulse });
        }
        together.hand_over(&mut contacts);
        for (point, (mode, _, expected)) in contacts.points.iter().zip(cases) {
            let off = (0..3).map(|i| (point.impulse[i] - expected[i]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-15, "{mode:?}: {:?} instead of {expected:?}", point.impulse);
        }
        // And so are the wrenches.
        assert!((contacts.total[0][0] - 1.5).abs() < 1e-15 && (contacts.total[0][2] - 6.0).abs() < 1e-15);
    }
}
