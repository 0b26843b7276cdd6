//! All contacts at once, as they stick or slip now: visits to one contact after another go on for long where a foot has
//! several.
//!
//! A foot's corners act on one rigid body, so that visits pass its load around among them slowly, and nothing tells how
//! it is shared. The equations "sticking: no velocity; slipping: no normal velocity, impulse on its edge" are linear. A
//! proximal step solves them: Δλ = -ε⁻¹ (velocity after it), which takes from all solutions the one that is nearest, and
//! leaves ε / σ of the error, where σ is the least gain of G that is not zero; a second one with the same factors leaves
//! the square of that.
//!
//! A step goes only as far as all impulses are possible. The contact that stops it opens, or slips, and the next step
//! goes on without it: the walk of an active-set method. Its end is a guess that visits must confirm.

use super::contact_law::in_cone;
use super::contact_solver::{ContactSolver, wrench};
use super::square::Square;

/// ε as a share of the mean gain of the normals. Rounding leaves 1e-16 / ε of the impulses.
const PROXIMITY: f64 = 1e-6;

/// How far a step goes that meets no resistance.
const FAR: f64 = 1e9;

/// Most steps of a walk.
const STEPS: usize = 8;

/// Scratch of the linear equations.
#[derive(Clone, Debug)]
pub(super) struct Simultaneous<const D: usize, const K: usize> {
    mode: Vec<Mode<D>>,
    /// Those that `system` was factorised for, if `factored`.
    factored_mode: Vec<Mode<D>>,
    factored: bool,
    proximity: f64,
    /// For each foot the sum over its contacts of impulse's wrench times velocity's row.
    shape: Vec<[[f64; K]; K]>,
    /// For each foot the wrench of its contacts' velocities.
    load: Vec<[f64; K]>,
    system: Square,
    /// The change of the twists.
    change: Vec<f64>,
    /// The velocities of the contacts that are to vanish.
    velocity: Vec<[f64; D]>,
    /// The changes of the impulses.
    impulse: Vec<[f64; D]>,
    /// What stops each on its way.
    stop: Vec<Option<(f64, Mode<D>)>>,
}

/// How a contact moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode<const D: usize> {
    Open,
    Stick,
    /// With the impulse per normal impulse.
    Slip([f64; D]),
}

/// The edge of the cone above the tangential impulse.
fn edge<const D: usize>(impulse: &[f64; D], friction: f64) -> Mode<D> {
    let norm = impulse[..D - 1].iter().map(|value| value * value).sum::<f64>().sqrt();
    let scale = if norm > 0.0 { friction / norm } else { 0.0 };
    // In the plane without rounding, so that the edge stays the same.
    let mut along = impulse.map(|value| if D == 2 { friction.copysign(value) } else { scale * value });
    along[D - 1] = 1.0;
    Mode::Slip(along)
}

fn unit<const D: usize>(index: usize) -> [f64; D] {
    std::array::from_fn(|i| if i == index { 1.0 } else { 0.0 })
}

/// How far along `change` an impulse in the cone stays there, and what the contact does at the end; None where it stays all
/// the way.
fn limit<const D: usize>(
    mode: &Mode<D>,
    impulse: &[f64; D],
    change: &[f64; D],
    friction: f64,
) -> Option<(f64, Mode<D>)> {
    let n = D - 1;
    let next: [f64; D] = std::array::from_fn(|i| impulse[i] + change[i]);
    let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    if next[n] <= 0.0 {
        return Some((share(impulse[n], -change[n]), Mode::Open));
    }
    if *mode != Mode::Stick || in_cone(&next, friction) {
        return None;
    }
    // |tangent|² = (friction · normal)² along the way: a t² + 2 b t + c = 0, where c ≤ 0.
    let product =
        |x: &[f64; D], y: &[f64; D]| (0..n).map(|i| x[i] * y[i]).sum::<f64>() - friction * friction * x[n] * y[n];
    let (a, b, c) = (product(change, change), product(impulse, change), product(impulse, impulse));
    let share = share(-c, b + (b * b - a * c).max(0.0).sqrt());
    let reached: [f64; D] = std::array::from_fn(|i| impulse[i] + share * change[i]);
    Some((share, edge(&reached, friction)))
}

impl<const D: usize, const K: usize> Simultaneous<D, K> {
    /// Scratch for so many points and feet.
    pub(super) fn new(points: usize, feet: usize) -> Self {
        Self {
            mode: vec![Mode::Open; points],
            factored_mode: vec![Mode::Open; points],
            factored: false,
            proximity: 0.0,
            shape: vec![[[0.0; K]; K]; feet],
            load: vec![[0.0; K]; feet],
            system: Square::new(feet * K),
            change: vec![0.0; feet * K],
            velocity: vec![[0.0; D]; points],
            impulse: vec![[0.0; D]; points],
            stop: vec![None; points],
        }
    }

    /// Forgets the factors: another configuration.
    pub(super) fn forget(&mut self) {
        self.factored = false;
    }

    /// Walks from the impulses of `contacts` toward the common solution, whose velocities vanish up to what impulses of
    /// `tolerance` [Ns] would cause.
    pub(super) fn walk(&mut self, contacts: &mut ContactSolver<D, K>, tolerance: f64) {
        let gains: f64 = contacts.points.iter().map(|point| point.normal_gain()).sum();
        let gain = gains / contacts.points.len() as f64;
        self.proximity = PROXIMITY * gain;
        let small = 0.1 * gain * tolerance;
        let (mut whole, mut before) = (true, f64::INFINITY);
        for step in 0..STEPS {
            let largest = self.survey(contacts, step == 0, whole, small);
            let stays = whole && largest > 0.5 * before;
            if largest <= small || (stays && largest <= gain * tolerance) {
                return;
            }
            if !self.factored || self.mode != self.factored_mode {
                self.assemble(contacts);
                self.factored_mode.copy_from_slice(&self.mode);
                self.factored = self.system.factor();
                if !self.factored {
                    return;
                }
            }
            self.solve(contacts);
            if stays {
                // What remains cannot vanish: the impulses that the step would add up act against each other and move
                // nothing, until one of them ends.
                self.impulse.iter_mut().flatten().for_each(|value| *value *= FAR);
            }
            before = largest;
            whole = self.advance(contacts);
            contacts.load();
        }
    }

    /// Finds the velocities that are to vanish, and returns the largest; enters modes at the `first` step, and contacts
    /// that close after a `whole` one.
    fn survey(&mut self, contacts: &ContactSolver<D, K>, first: bool, whole: bool, small: f64) -> f64 {
        let mut largest: f64 = 0.0;
        for ((mode, velocity), point) in self.mode.iter_mut().zip(&mut self.velocity).zip(&contacts.points) {
            *velocity = point.velocity(&contacts.twist[point.foot]);
            velocity[D - 1] -= point.approach;
            let friction = point.friction;
            if first {
                *mode = if point.impulse[D - 1] <= 0.0 {
                    Mode::Open
                } else if in_cone(&point.impulse, friction * (1.0 - 1e-9)) && friction > 0.0 {
                    Mode::Stick
                } else {
                    edge(&point.impulse, friction)
                };
            }
            if whole && *mode == Mode::Open && velocity[D - 1] < -small {
                *mode = Mode::Stick;
            }
            match mode {
                Mode::Open => {}
                Mode::Stick => velocity.iter().for_each(|value| largest = largest.max(value.abs())),
                Mode::Slip(_) => largest = largest.max(velocity[D - 1].abs()),
            }
        }
        largest
    }

    /// `ε 1 + B C`, with B of the feet and C their shapes.
    fn assemble(&mut self, contacts: &ContactSolver<D, K>) {
        self.shape.fill([[0.0; K]; K]);
        for (mode, point) in self.mode.iter().zip(&contacts.points) {
            let shape = &mut self.shape[point.foot];
            match mode {
                Mode::Open => {}
                Mode::Stick => {
                    // Σ of wrench times row over the axes: the linear parts are the unit vectors. Turned axes have the same sum.
                    let turns: [[f64; K]; D] = std::array::from_fn(|axis| wrench(&unit(axis), &point.arm));
                    for (axis, turn) in turns.iter().enumerate() {
                        shape[axis][axis] += 1.0;
                        for i in D..K {
                            shape[axis][i] += turn[i];
                            shape[i][axis] += turn[i];
                            for j in D..K {
                                shape[i][j] += turn[i] * turn[j];
                            }
                        }
                    }
                }
                Mode::Slip(along) => {
                    let (force, row) = (point.wrench(along), point.wrench(&unit(D - 1)));
                    for i in 0..K {
                        for j in 0..K {
                            shape[i][j] += force[i] * row[j];
                        }
                    }
                }
            }
        }
        let feet = self.shape.len();
        let mut blocks = contacts.coupling.iter();
        for rows in self.system.entry.chunks_exact_mut(feet * K * K) {
            for (b, (shape, block)) in self.shape.iter().zip(&mut blocks).enumerate() {
                for (row, gains) in rows.chunks_exact_mut(feet * K).zip(block) {
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
        self.system.entry.iter_mut().step_by(feet * K + 1).for_each(|entry| *entry += self.proximity);
    }

    /// `(ε 1 + B C) δ = -B q` for the change δ of the twists, with the contacts' velocities q; then `Δλ`.
    fn solve(&mut self, contacts: &ContactSolver<D, K>) {
        self.load.fill([0.0; K]);
        for ((mode, velocity), point) in self.mode.iter().zip(&self.velocity).zip(&contacts.points) {
            let force = match mode {
                Mode::Open => continue,
                Mode::Stick => point.wrench(velocity),
                Mode::Slip(along) => point.wrench(&along.map(|value| value * velocity[D - 1])),
            };
            let load = &mut self.load[point.foot];
            for i in 0..K {
                load[i] += force[i];
            }
        }
        let feet = self.load.len();
        for (change, blocks) in self.change.chunks_exact_mut(K).zip(contacts.coupling.chunks_exact(feet)) {
            let mut sum = [0.0; K];
            for (block, load) in blocks.iter().zip(&self.load) {
                for (value, gains) in sum.iter_mut().zip(block) {
                    *value -= (0..K).map(|j| gains[j] * load[j]).sum::<f64>();
                }
            }
            change.copy_from_slice(&sum);
        }
        self.system.solve(&mut self.change);
        for (((impulse, mode), velocity), point) in
            self.impulse.iter_mut().zip(&self.mode).zip(&self.velocity).zip(&contacts.points)
        {
            let change: &[f64; K] = self.change[point.foot * K..].first_chunk().expect("a twist for each foot");
            let after = point.velocity(change);
            let wanted = |i: usize| -(velocity[i] + after[i]) / self.proximity;
            *impulse = match mode {
                Mode::Open => [0.0; D],
                Mode::Stick => std::array::from_fn(wanted),
                Mode::Slip(along) => along.map(|value| value * wanted(D - 1)),
            };
        }
    }

    /// Goes as far as all impulses are possible; returns whether that is the whole way.
    fn advance(&mut self, contacts: &mut ContactSolver<D, K>) -> bool {
        let mut share = 1.0;
        let moves = self.impulse.iter().zip(&mut self.stop).zip(&self.mode).zip(&contacts.points);
        for (((change, stop), mode), point) in moves {
            *stop = if *mode == Mode::Open { None } else { limit(mode, &point.impulse, change, point.friction) };
            if let Some((reached, _)) = stop {
                share = reached.min(share);
            }
        }
        let mut whole = true;
        for (((change, stop), mode), point) in
            self.impulse.iter().zip(&self.stop).zip(&mut self.mode).zip(&mut contacts.points)
        {
            for i in 0..D {
                point.impulse[i] += share * change[i];
            }
            // Contacts that nothing tells apart stop together.
            let Some((_, next)) = stop.filter(|(reached, _)| *reached <= share + 1e-9) else { continue };
            (*mode, whole) = (next, false);
            match next {
                Mode::Open => point.impulse = [0.0; D],
                Mode::Stick => {}
                Mode::Slip(along) => point.impulse = along.map(|value| value * point.impulse[D - 1]),
            }
        }
        whole
    }
}
