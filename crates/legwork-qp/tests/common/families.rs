//! Random programs. Each generator makes a point that is feasible, and the rows and bounds around it.

use super::Random;
use legwork_qp::Problem;

/// What [`general`] shall make.
#[derive(Clone, Debug)]
pub struct Shape {
    pub n: usize,
    pub m: usize,
    /// Of the Hessian before the ridge; below n only with `ridge`.
    pub rank: usize,
    pub ridge: f64,
    /// Probabilities for a row.
    pub equality: f64,
    pub repeated: f64,
    pub two_sided: f64,
    /// Probability for a row or bound to touch the feasible point.
    pub tight: f64,
    /// Probability for a variable to have bounds, and for bounds to be one number.
    pub bounded: f64,
    pub fixed: f64,
    /// Variables, rows and objective are scaled by up to ten to plus or minus this.
    pub scale: f64,
}

impl Shape {
    pub fn random(rng: &mut Random) -> Self {
        let n = 1 + rng.below(20);
        let ridge = if rng.chance(0.5) { rng.magnitude(-8.0, 0.0) } else { 0.0 };
        Self {
            n,
            m: rng.below(31),
            rank: if ridge > 0.0 { rng.below(n + 1) } else { n },
            ridge,
            equality: if rng.chance(0.3) { 0.6 } else { 0.1 },
            repeated: 0.15,
            two_sided: 0.4,
            tight: if rng.chance(0.3) { 0.8 } else { 0.1 },
            bounded: if rng.chance(0.5) { 0.9 } else { 0.2 },
            fixed: 0.08,
            scale: if rng.chance(0.5) { 0.0 } else { rng.uniform(0.0, 3.0) },
        }
    }
}

/// A program with the feasible point that it was built around.
pub fn general(shape: &Shape, rng: &mut Random) -> (Problem, Vec<f64>) {
    let Shape { n, m, .. } = *shape;
    let mut p = Problem::new(n, m);
    let inside: Vec<f64> = (0..n).map(|_| rng.normal()).collect();
    for _ in 0..shape.rank {
        let b: Vec<f64> = (0..n).map(|_| rng.normal()).collect();
        add_square(&mut p, &b, 1.0);
    }
    for j in 0..n {
        p.hessian_mut()[j * n + j] += shape.ridge;
        p.gradient_mut()[j] = 3.0 * rng.normal();
    }
    for i in 0..m {
        if i > 0 && rng.chance(shape.repeated) {
            // A copy of an earlier row, or a sum of two.
            let (a, b) = (rng.below(i), rng.below(i));
            let (f, g) = (rng.normal(), if rng.chance(0.5) { rng.normal() } else { 0.0 });
            for j in 0..n {
                let entry = f * p.row(a)[j] + g * p.row(b)[j];
                p.row_mut(i)[j] = entry;
            }
        } else {
            let dense = rng.uniform(0.1, 1.0);
            for j in 0..n {
                if rng.chance(dense) {
                    p.row_mut(i)[j] = rng.normal();
                }
            }
        }
        let value: f64 = p.row(i).iter().zip(&inside).map(|(a, x)| a * x).sum();
        let (lower, upper) = interval(value, shape, rng, shape.equality);
        p.row_lower_mut()[i] = lower;
        p.row_upper_mut()[i] = upper;
    }
    for j in 0..n {
        if rng.chance(shape.bounded) {
            let (lower, upper) = interval(inside[j], shape, rng, shape.fixed);
            p.lower_mut()[j] = lower;
            p.upper_mut()[j] = upper;
        }
    }
    rescale(p, inside, shape.scale, rng)
}

fn interval(value: f64, shape: &Shape, rng: &mut Random, equality: f64) -> (f64, f64) {
    if rng.chance(equality) {
        return (value, value);
    }
    let mut room = || {
        if rng.chance(shape.tight) { 0.0 } else { rng.uniform(0.0, 2.0) }
    };
    let (below, above) = (room(), room());
    if rng.chance(shape.two_sided) {
        (value - below, value + above)
    } else if rng.chance(0.5) {
        (value - below, f64::INFINITY)
    } else {
        (f64::NEG_INFINITY, value + above)
    }
}

/// `H += weight b bᵀ`.
pub fn add_square(p: &mut Problem, b: &[f64], weight: f64) {
    let n = p.n();
    for i in 0..n {
        for j in 0..n {
            // Products in one order for both triangles.
            p.hessian_mut()[i * n + j] += weight * (b[i.max(j)] * b[i.min(j)]);
        }
    }
}

/// Other units for everything: `x_j → x_j s_j`, rows and objective times factors.
fn rescale(p: Problem, inside: Vec<f64>, scale: f64, rng: &mut Random) -> (Problem, Vec<f64>) {
    let (n, m) = (p.n(), p.m());
    let s: Vec<f64> = (0..n).map(|_| rng.magnitude(-scale, scale)).collect();
    let objective = rng.magnitude(-scale, scale);
    let mut q = p.clone();
    for i in 0..n {
        for j in 0..n {
            q.hessian_mut()[i * n + j] = objective * (p.hessian()[i * n + j] / (s[i.max(j)] * s[i.min(j)]));
        }
        q.gradient_mut()[i] = objective * p.gradient()[i] / s[i];
        q.lower_mut()[i] = p.lower()[i] * s[i];
        q.upper_mut()[i] = p.upper()[i] * s[i];
    }
    for i in 0..m {
        let factor = rng.magnitude(-scale, scale);
        for j in 0..n {
            q.row_mut(i)[j] = factor * p.row(i)[j] / s[j];
        }
        q.row_lower_mut()[i] = factor * p.row_lower()[i];
        q.row_upper_mut()[i] = factor * p.row_upper()[i];
    }
    (q, inside.iter().zip(&s).map(|(x, s)| x * s).collect())
}

/// Makes the last row contradict a combination of some others, by a fraction of its terms. False if no row or bound can be
/// used for it.
pub fn contradict(p: &mut Problem, rng: &mut Random) -> bool {
    let (n, m) = (p.n(), p.m());
    if m == 0 {
        return false;
    }
    let last = m - 1;
    let mut row = vec![0.0; n];
    let (mut bound, mut size) = (0.0, 0.0);
    let mut used = 0;
    for i in 0..last {
        if rng.chance(0.4) && p.row_lower()[i].is_finite() && p.row(i).iter().any(|a| a.abs() > 0.0) {
            let weight = rng.uniform(0.2, 2.0) / p.row(i).iter().fold(0.0, |l: f64, a| l.max(a.abs()));
            for j in 0..n {
                row[j] += weight * p.row(i)[j];
            }
            bound += weight * p.row_lower()[i];
            size += (weight * p.row_lower()[i]).abs();
            used += 1;
        }
    }
    for j in 0..n {
        if rng.chance(0.3) && p.lower()[j].is_finite() {
            let weight = rng.uniform(0.2, 2.0) * row.iter().fold(1e-3, |l: f64, a| l.max(a.abs()));
            row[j] += weight;
            bound += weight * p.lower()[j];
            size += (weight * p.lower()[j]).abs();
            used += 1;
        }
    }
    if used == 0 || row.iter().all(|a| a.abs() < 1e-300) {
        return false;
    }
    // Every feasible point has row·x >= bound.
    p.row_mut(last).copy_from_slice(&row);
    p.row_lower_mut()[last] = f64::NEG_INFINITY;
    p.row_upper_mut()[last] = bound - rng.magnitude(-4.0, 0.0) * (size + 1e-3);
    true
}

/// The program with `count` more equality rows, each with a slack of its own, and the slacks' indices. Costs are of ten to plus
/// or minus `decades`; some rows repeat others; the slacks stand behind the variables or before them.
pub fn with_slacks(base: &Problem, count: usize, decades: f64, rng: &mut Random) -> (Problem, Vec<usize>) {
    let (n, m) = (base.n(), base.m());
    let (offset, first) = if rng.chance(0.7) { (0, n) } else { (count, 0) };
    let mut p = Problem::new(n + count, m + count);
    let width = p.n();
    for j in 0..n {
        let row = &base.hessian()[j * n..(j + 1) * n];
        p.hessian_mut()[(offset + j) * width + offset..][..n].copy_from_slice(row);
        p.gradient_mut()[offset + j] = base.gradient()[j];
        p.lower_mut()[offset + j] = base.lower()[j];
        p.upper_mut()[offset + j] = base.upper()[j];
    }
    for i in 0..m {
        p.row_mut(i)[offset..][..n].copy_from_slice(base.row(i));
        p.row_lower_mut()[i] = base.row_lower()[i];
        p.row_upper_mut()[i] = base.row_upper()[i];
    }
    for k in 0..count {
        let (row, slack) = (m + k, first + k);
        for j in offset..offset + n {
            let entry = if k > 0 && rng.chance(0.2) { p.row(row - 1)[j] } else { rng.normal() };
            p.row_mut(row)[j] = entry;
        }
        p.row_mut(row)[slack] = if rng.chance(0.3) { 1.0 } else { rng.normal() };
        let wanted = 3.0 * rng.normal();
        (p.row_lower_mut()[row], p.row_upper_mut()[row]) = (wanted, wanted);
        p.hessian_mut()[slack * (width + 1)] = rng.magnitude(-decades, decades);
        p.gradient_mut()[slack] = if rng.chance(0.5) { rng.normal() } else { 0.0 };
    }
    (p, (first..first + count).collect())
}

/// One of the matrices of a robot, slowly moving with `time`.
struct Robot {
    mass: [[f64; 7]; 7],
    bias: [f64; 7],
    feet: [[f64; 7]; 4],
    tasks: [[f64; 7]; 8],
    wanted: [f64; 8],
}

const TORQUES: usize = 4;

fn robot(seed: u64, time: f64) -> Robot {
    let mut rng = Random(seed);
    let mut wave = |amplitude: f64| {
        let (phase, rate) = (rng.uniform(0.0, 6.0), rng.uniform(0.5, 2.0));
        amplitude * (phase + rate * time).sin()
    };
    let mut mass = [[0.0; 7]; 7];
    for _ in 0..9 {
        let column: [f64; 7] = std::array::from_fn(|_| wave(2.0));
        for i in 0..7 {
            for j in 0..7 {
                mass[i][j] += column[i.max(j)] * column[i.min(j)];
            }
        }
    }
    for (i, row) in mass.iter_mut().enumerate() {
        row[i] += 0.3;
    }
    let bias = std::array::from_fn(|_| wave(300.0));
    let feet = std::array::from_fn(|_| std::array::from_fn(|_| wave(1.0)));
    let tasks = std::array::from_fn(|_| std::array::from_fn(|_| wave(1.5)));
    let wanted = std::array::from_fn(|_| wave(8.0));
    Robot { mass, bias, feet, tasks, wanted }
}

/// Weights of the eight tasks, from 1e-6 to 5e5.
const WEIGHTS: [f64; 8] = [5e5, 2e4, 1e3, 10.0, 1.0, 0.1, 1e-3, 1e-6];

/// Six rows of two friction cones with the forces at `force`, the first foot loaded, the second loaded or not.
fn friction(p: &mut Problem, first_row: usize, force: usize, second_loaded: bool) {
    for foot in 0..2 {
        let (fx, fz) = (force + 2 * foot, force + 2 * foot + 1);
        let row = first_row + 3 * foot;
        for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
            p.row_mut(row + k)[fx] = sign;
            p.row_mut(row + k)[fz] = -0.6;
            p.row_upper_mut()[row + k] = 0.0;
        }
        p.row_mut(row + 2)[fz] = 1.0;
        p.row_lower_mut()[row + 2] = 0.0;
        p.row_upper_mut()[row + 2] = if foot == 0 || second_loaded { 1000.0 } else { 0.0 };
        for f in [fx, fz] {
            p.lower_mut()[f] = -2000.0;
            p.upper_mut()[f] = 2000.0;
        }
    }
}

/// The slack form of a planar biped's control: 7 accelerations, 4 contact forces, 4 torques without a cost, 8 task slacks;
/// 15 equality rows (dynamics, tasks), 4 more that follow from them or are zero, 6 friction rows.
pub fn whole_body_slack(seed: u64, time: f64) -> Problem {
    let Robot { mass, bias, feet, tasks, wanted } = robot(seed, time);
    let mut p = Problem::new(23, 25);
    let (force, torque, slack) = (7, 11, 15);
    for j in 0..7 {
        p.hessian_mut()[j * 24] = 1e-4;
        p.lower_mut()[j] = -400.0;
        p.upper_mut()[j] = 400.0;
    }
    for j in force..torque {
        p.hessian_mut()[j * 24] = 1e-6;
    }
    for j in torque..slack {
        p.lower_mut()[j] = -220.0;
        p.upper_mut()[j] = 220.0;
    }
    for k in 0..8 {
        p.hessian_mut()[(slack + k) * 24] = WEIGHTS[k];
    }
    for i in 0..7 {
        let row = p.row_mut(i);
        row[..7].copy_from_slice(&mass[i]);
        for k in 0..4 {
            row[force + k] = -feet[k][i];
        }
        if i >= 7 - TORQUES {
            row[torque + i - (7 - TORQUES)] = -1.0;
        }
        p.row_lower_mut()[i] = -bias[i];
        p.row_upper_mut()[i] = -bias[i];
    }
    for k in 0..8 {
        let row = p.row_mut(7 + k);
        row[..7].copy_from_slice(&tasks[k]);
        row[slack + k] = 1.0;
        p.row_lower_mut()[7 + k] = wanted[k];
        p.row_upper_mut()[7 + k] = wanted[k];
    }
    // Foot 1: the sum of rows that stand already. Foot 2: zero, as in the air.
    for (k, (a, b)) in [(0, 7), (3, 9)].into_iter().enumerate() {
        let sum: Vec<f64> = p.row(a).iter().zip(p.row(b)).map(|(x, y)| x + 0.5 * y).collect();
        p.row_mut(15 + k).copy_from_slice(&sum);
        let bound = p.row_lower()[a] + 0.5 * p.row_lower()[b];
        p.row_lower_mut()[15 + k] = bound;
        p.row_upper_mut()[15 + k] = bound;
    }
    for k in 17..19 {
        p.row_lower_mut()[k] = 0.0;
        p.row_upper_mut()[k] = 0.0;
    }
    friction(&mut p, 19, force, seed.is_multiple_of(2));
    p
}

/// The same program in its direct form: 7 accelerations and 4 forces; 3 equality rows, 4 torque rows, 6 friction rows.
pub fn whole_body_direct(seed: u64, time: f64) -> Problem {
    let Robot { mass, bias, feet, tasks, wanted } = robot(seed, time);
    let mut p = Problem::new(11, 13);
    for k in 0..8 {
        let mut task = [0.0; 11];
        task[..7].copy_from_slice(&tasks[k]);
        add_square(&mut p, &task, WEIGHTS[k]);
        for j in 0..7 {
            p.gradient_mut()[j] -= WEIGHTS[k] * wanted[k] * tasks[k][j];
        }
    }
    for j in 0..7 {
        p.hessian_mut()[j * 12] += 1e-4;
        p.lower_mut()[j] = -400.0;
        p.upper_mut()[j] = 400.0;
    }
    for j in 7..11 {
        p.hessian_mut()[j * 12] += 1e-6;
    }
    for i in 0..7 {
        let row = p.row_mut(i);
        row[..7].copy_from_slice(&mass[i]);
        for k in 0..4 {
            row[7 + k] = -feet[k][i];
        }
        let limit = if i >= 7 - TORQUES { 220.0 } else { 0.0 };
        p.row_lower_mut()[i] = -bias[i] - limit;
        p.row_upper_mut()[i] = -bias[i] + limit;
    }
    friction(&mut p, 7, 7, seed.is_multiple_of(2));
    p
}

/// A humanoid's control: 18 accelerations, of which the first six are the base's, and the forces of eight contact points;
/// 6 equality rows (the base's dynamics), 12 torque rows, 40 friction rows. Feet are lifted in turn, for 0.3 s of each 0.8 s.
pub fn whole_body_spatial(seed: u64, time: f64) -> Problem {
    const NV: usize = 18;
    const N: usize = NV + 24;
    let mut rng = Random(seed);
    let mut wave = |amplitude: f64| {
        let (phase, rate) = (rng.uniform(0.0, 6.0), rng.uniform(0.5, 2.0));
        amplitude * (phase + rate * time).sin()
    };
    let mut p = Problem::new(N, 58);
    for weight in [1e3, 1e3, 1e3, 1e2, 1e2, 1e2, 1e3, 1e3, 1e3, 10.0, 10.0, 10.0] {
        let mut task = vec![0.0; N];
        task[..NV].fill_with(|| wave(1.0));
        let wanted = wave(4.0);
        add_square(&mut p, &task, weight);
        (0..NV).for_each(|j| p.gradient_mut()[j] -= weight * wanted * task[j]);
    }
    for j in 0..N {
        p.hessian_mut()[j * (N + 1)] += if j < NV { 1e-2 } else { 1e-4 };
        p.lower_mut()[j] = if j < NV { -300.0 } else { -2000.0 };
        p.upper_mut()[j] = -p.lower()[j];
    }
    let factor: Vec<f64> = (0..NV * 20).map(|_| wave(0.6)).collect();
    for i in 0..NV {
        for j in 0..NV {
            let product = (0..20).map(|k| factor[i * 20 + k] * factor[j * 20 + k]);
            p.row_mut(i)[j] = product.sum::<f64>() + if i == j { 0.3 } else { 0.0 };
        }
        for k in 0..24 {
            // Point k / 3 at corners of a foot, the base's dynamics with the force itself and its moment.
            let own = f64::from(u8::from(i < 3 && k % 3 == i));
            let arm = if (3..6).contains(&i) { wave(0.5) } else { 0.0 };
            let leg = if i >= 6 && (i - 6) / 6 == k / 12 { wave(0.5) } else { 0.0 };
            p.row_mut(i)[NV + k] = -(own + arm + leg);
        }
        let weight = if i == 2 { 600.0 } else { 0.0 };
        let (bias, limit) = (weight + wave(20.0), if i < 6 { 0.0 } else { 150.0 });
        p.row_lower_mut()[i] = -bias - limit;
        p.row_upper_mut()[i] = -bias + limit;
    }
    let phase = time % 0.8;
    let lifted = [(0.1..0.4).contains(&phase), (0.5..0.8).contains(&phase)];
    for point in 0..8 {
        let (row, force) = (NV + 5 * point, NV + 3 * point);
        for (k, (axis, sign)) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)].into_iter().enumerate() {
            p.row_mut(row + k)[force + axis] = sign;
            p.row_mut(row + k)[force + 2] = -0.5;
            p.row_upper_mut()[row + k] = 0.0;
        }
        p.row_mut(row + 4)[force + 2] = 1.0;
        p.row_lower_mut()[row + 4] = 0.0;
        if lifted[point / 4] {
            p.lower_mut()[force..force + 3].fill(0.0);
            p.upper_mut()[force..force + 3].fill(0.0);
        }
    }
    p
}
