//! All contacts at once, as they stick or slip now: where the visits to one contact after another go on too long.
//!
//! A foot's corners act on one rigid body, so that visits pass its load around among them slowly, and nothing tells how
//! it is shared. The equations "sticking: no velocity; slipping: no normal velocity, impulse on its edge" are linear. A
//! proximal step solves them: Δλ = -ε⁻¹ (velocity after it), which takes from all solutions the one that is nearest, and
//! leaves ε / σ of the error, where σ is the least gain of G that is not zero. It is a guess that is taken only if all
//! impulses are possible, and that the visits after it must confirm.

use super::contact_law::in_cone;
use super::contact_solver::{ContactSolver, velocity_at, wrench};

/// ε as a share of the mean gain of the normals. Rounding leaves 1e-16 / ε of the impulses.
const PROXIMITY: f64 = 1e-6;

/// Scratch of the linear equations.
#[derive(Clone, Debug)]
pub(super) struct Simultaneous<const D: usize, const K: usize> {
    /// For each foot the sum over its contacts of impulse's wrench times velocity's row.
    shape: Vec<[[f64; K]; K]>,
    /// For each foot the wrench of its contacts' velocities.
    load: Vec<[f64; K]>,
    /// The equations for the change of twists, row by row with the right side last.
    system: Vec<f64>,
    /// The next impulses.
    impulse: Vec<[f64; D]>,
}

/// How a contact moves.
enum Mode<const D: usize> {
    Open,
    Stick,
    /// With the impulse per normal impulse.
    Slip([f64; D]),
}

fn mode<const D: usize>(impulse: &[f64; D], friction: f64) -> Mode<D> {
    let normal = impulse[D - 1];
    if normal <= 0.0 {
        Mode::Open
    } else if in_cone(impulse, friction * (1.0 - 1e-9)) && friction > 0.0 {
        Mode::Stick
    } else {
        Mode::Slip(impulse.map(|value| value / normal))
    }
}

fn unit<const D: usize>(index: usize) -> [f64; D] {
    std::array::from_fn(|i| if i == index { 1.0 } else { 0.0 })
}

impl<const D: usize, const K: usize> Simultaneous<D, K> {
    /// Scratch for so many points and feet.
    pub(super) fn new(points: usize, feet: usize) -> Self {
        let n = feet * K;
        Self {
            shape: vec![[[0.0; K]; K]; feet],
            load: vec![[0.0; K]; feet],
            system: vec![0.0; n * (n + 1)],
            impulse: vec![[0.0; D]; points],
        }
    }

    /// Replaces the impulses and twists of `contacts` by the common solution, if that is possible.
    pub(super) fn step(&mut self, contacts: &mut ContactSolver<D, K>, friction: f64) {
        let gains: f64 = contacts.points.iter().map(|point| point.normal_gain()).sum();
        let proximity = PROXIMITY * gains / contacts.points.len() as f64;
        self.assemble(contacts, friction);
        self.equations(contacts, proximity);
        if self.eliminate() && self.next_impulses(contacts, friction, proximity) {
            for (point, impulse) in contacts.points.iter_mut().zip(&self.impulse) {
                point.impulse = *impulse;
            }
            contacts.load();
        }
    }

    fn assemble(&mut self, contacts: &ContactSolver<D, K>, friction: f64) {
        self.shape.fill([[0.0; K]; K]);
        self.load.fill([0.0; K]);
        for point in &contacts.points {
            let mut velocity = velocity_at(&contacts.twist[point.foot], &point.arm);
            velocity[D - 1] -= point.approach;
            let (shape, load) = (&mut self.shape[point.foot], &mut self.load[point.foot]);
            let mut add = |impulse: &[f64; D], axis: usize| {
                let force: [f64; K] = wrench(impulse, &point.arm);
                let row: [f64; K] = wrench(&unit::<D>(axis), &point.arm);
                for i in 0..K {
                    for j in 0..K {
                        shape[i][j] += force[i] * row[j];
                    }
                    load[i] += force[i] * velocity[axis];
                }
            };
            match mode(&point.impulse, friction) {
                Mode::Open => {}
                Mode::Stick => (0..D).for_each(|axis| add(&unit(axis), axis)),
                Mode::Slip(along) => add(&along, D - 1),
            }
        }
    }

    /// `(ε 1 + B C) δ = -B q`, with B of the feet, C their shapes and q their loads, for the change δ of the twists.
    fn equations(&mut self, contacts: &ContactSolver<D, K>, proximity: f64) {
        let feet = self.shape.len();
        let width = feet * K + 1;
        for a in 0..feet {
            for i in 0..K {
                let row = &mut self.system[(a * K + i) * width..(a * K + i + 1) * width];
                row.fill(0.0);
                for b in 0..feet {
                    let gains = &contacts.coupling[a * feet + b][i];
                    for ((gain, shape), load) in gains.iter().zip(&self.shape[b]).zip(&self.load[b]) {
                        for j in 0..K {
                            row[b * K + j] += gain * shape[j];
                        }
                        row[width - 1] -= gain * load;
                    }
                }
                row[a * K + i] += proximity;
            }
        }
    }

    /// Gauss's elimination with the largest pivot; the solution is left in the last column. False where there is none.
    fn eliminate(&mut self) -> bool {
        let n = self.shape.len() * K;
        let width = n + 1;
        for k in 0..n {
            let size = |row: &usize| self.system[row * width + k].abs();
            let pivot = (k..n).fold(k, |best, row| if size(&row) > size(&best) { row } else { best });
            if self.system[pivot * width + k].is_nan() || self.system[pivot * width + k] == 0.0 {
                return false;
            }
            let (upper, lower) = self.system.split_at_mut((k + 1) * width);
            let own = &mut upper[k * width..];
            if pivot != k {
                own.swap_with_slice(&mut lower[(pivot - k - 1) * width..(pivot - k) * width]);
            }
            let inverse = 1.0 / own[k];
            for row in lower.chunks_exact_mut(width) {
                let factor = row[k] * inverse;
                if factor != 0.0 {
                    for (value, own) in row[k + 1..].iter_mut().zip(&own[k + 1..]) {
                        *value -= factor * own;
                    }
                }
            }
        }
        for k in (0..n).rev() {
            let mut value = self.system[k * width + n];
            for j in k + 1..n {
                value -= self.system[k * width + j] * self.system[j * width + n];
            }
            self.system[k * width + n] = value / self.system[k * width + k];
        }
        true
    }

    /// Whether all impulses that follow from the twists' change are possible.
    fn next_impulses(&mut self, contacts: &ContactSolver<D, K>, friction: f64, proximity: f64) -> bool {
        let width = self.shape.len() * K + 1;
        for (next, point) in self.impulse.iter_mut().zip(&contacts.points) {
            let twist: [f64; K] = std::array::from_fn(|i| {
                contacts.twist[point.foot][i] + self.system[(point.foot * K + i) * width + width - 1]
            });
            let mut velocity = velocity_at(&twist, &point.arm);
            velocity[D - 1] -= point.approach;
            let normal = -velocity[D - 1] / proximity;
            *next = point.impulse;
            let possible = match mode(&point.impulse, friction) {
                Mode::Open => true,
                Mode::Stick => {
                    (0..D).for_each(|i| next[i] -= velocity[i] / proximity);
                    next[D - 1] > 0.0 && in_cone(next, friction)
                }
                Mode::Slip(along) => {
                    (0..D).for_each(|i| next[i] += along[i] * normal);
                    next[D - 1] > 0.0
                }
            };
            // A NaN is not possible either: it compares with nothing.
            if !possible {
                return false;
            }
        }
        true
    }
}
