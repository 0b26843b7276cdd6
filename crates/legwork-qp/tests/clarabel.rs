//! The same answers as Clarabel, an interior-point solver of other people, at tolerances as tight as it reaches.

mod common;

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{NonnegativeConeT, ZeroConeT};
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus};
use common::families::{
    Shape, contradict, general, whole_body_direct, whole_body_slack, whole_body_spatial, with_slacks,
};
use common::{Random, conflict_proves, kkt_below};
use legwork_qp::{Constraint, Elastic, Problem, Side, Solver, Status};

/// Clarabel's form: `A x + s = b`, `s` zero for equalities and positive for inequalities.
fn reference(p: &Problem) -> (SolverStatus, Vec<f64>) {
    let (n, m) = (p.n(), p.m());
    let unit = |j: usize| (0..n).map(|k| f64::from(u8::from(k == j))).collect::<Vec<f64>>();
    let all: Vec<(Vec<f64>, f64, f64)> = (0..m)
        .map(|i| (p.row(i).to_vec(), p.row_lower()[i], p.row_upper()[i]))
        .chain((0..n).map(|j| (unit(j), p.lower()[j], p.upper()[j])))
        .collect();
    let (mut equal, mut above) = (Vec::new(), Vec::new());
    for (row, lower, upper) in all {
        let negative: Vec<f64> = row.iter().map(|a| -a).collect();
        if lower >= upper {
            equal.push((row, upper));
            continue;
        }
        if lower.is_finite() {
            above.push((negative, -lower));
        }
        if upper.is_finite() {
            above.push((row, upper));
        }
    }
    let cones = [ZeroConeT(equal.len()), NonnegativeConeT(above.len())];
    let rows: Vec<_> = equal.into_iter().chain(above).collect();
    let b: Vec<f64> = rows.iter().map(|row| row.1).collect();
    let a: Vec<Vec<f64>> = rows.into_iter().map(|row| row.0).collect();
    let a = if a.is_empty() { CscMatrix::zeros((0, n)) } else { CscMatrix::from(&a) };
    let mut h = p.hessian().to_vec();
    for i in 0..n {
        // The upper triangle.
        h[i * n..i * n + i].fill(0.0);
    }
    let h: Vec<Vec<f64>> = h.chunks(n).map(<[f64]>::to_vec).collect();
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-12)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .tol_infeas_abs(1e-9)
        .tol_infeas_rel(1e-9)
        .max_iter(200)
        .build()
        .unwrap();
    let mut solver = DefaultSolver::new(&CscMatrix::from(&h), p.gradient(), &a, &b, &cones, settings).unwrap();
    solver.solve();
    (solver.solution.status, solver.solution.x.clone())
}

/// Which of the two statuses Clarabel's means, if it is sure.
fn meaning(status: SolverStatus) -> Option<Status> {
    match status {
        SolverStatus::Solved => Some(Status::Optimal),
        SolverStatus::PrimalInfeasible => Some(Status::Infeasible),
        _ => None,
    }
}

/// Compares, and says whether there was anything to compare.
fn agree(p: &Problem, tolerance: f64, name: &str) -> bool {
    let (status, x) = reference(p);
    let Some(expected) = meaning(status) else {
        return false;
    };
    let mut solver = Solver::new(p.n(), p.m());
    assert_eq!(solver.solve(p), expected, "{name}");
    if expected == Status::Optimal {
        kkt_below(p, &solver, 1e-9).unwrap();
        let (found, other) = (p.objective(solver.x()), p.objective(&x));
        assert!((found - other).abs() < tolerance * (1.0 + other.abs()), "{name}: {found} {other}");
        let size = x.iter().fold(1.0, |l: f64, x| l.max(x.abs()));
        for (a, b) in solver.x().iter().zip(&x) {
            assert!((a - b).abs() < tolerance.sqrt() * size, "{name}: {:?} {x:?}", solver.x());
        }
    }
    true
}

#[test]
fn random_programs() {
    let (mut compared, mut refused) = (0, 0);
    for seed in 0..400 {
        let mut rng = Random(seed);
        let mut shape = Shape::random(&mut rng);
        shape.ridge = shape.ridge.max(1e-3);
        shape.scale = 0.0;
        let (mut p, _) = general(&shape, &mut rng);
        let infeasible = seed % 5 == 0 && contradict(&mut p, &mut rng);
        let sure = agree(&p, 1e-8, &format!("seed {seed}"));
        compared += usize::from(sure);
        refused += usize::from(sure && infeasible);
    }
    assert!(compared > 350 && refused > 40, "{compared} compared, {refused} infeasible");
}

#[test]
fn whole_body_programs() {
    let mut compared = 0;
    for seed in 0..40 {
        let (slack, direct) = (whole_body_slack(seed, 0.0), whole_body_direct(seed, 0.0));
        compared += usize::from(agree(&direct, 1e-6, &format!("direct form, seed {seed}")));
        compared += usize::from(agree(&slack, 1e-6, &format!("slack form, seed {seed}")));
    }
    assert!(compared > 40, "{compared}");
}

/// Of `count` programs from `first` on, a fifth made infeasible: every certificate is a proof, every optimum the other
/// solver's. Programs where the other is unsure are still held to the optimality conditions.
fn random_family(first: u64, count: u64, change: impl Fn(&mut Shape, &mut Random)) {
    let (mut compared, mut refused) = (0, 0);
    for seed in first..first + count {
        let mut rng = Random(seed);
        let mut shape = Shape::random(&mut rng);
        shape.ridge = shape.ridge.max(1e-3);
        shape.scale = 0.0;
        change(&mut shape, &mut rng);
        let (mut p, inside) = general(&shape, &mut rng);
        if seed % 5 == 0 && contradict(&mut p, &mut rng) {
            let mut solver = Solver::new(p.n(), p.m());
            assert_eq!(solver.solve(&p), Status::Infeasible, "seed {seed}");
            let conflict: Vec<_> = solver.conflict().collect();
            let reach: Vec<f64> = inside.iter().map(|x| 1e3 * x.abs()).collect();
            conflict_proves(&p, &conflict, &reach).unwrap();
            refused += 1;
        } else if agree(&p, 1e-7, &format!("seed {seed}")) {
            compared += 1;
        } else {
            let mut solver = Solver::new(p.n(), p.m());
            assert_eq!(solver.solve(&p), Status::Optimal, "seed {seed}");
            kkt_below(&p, &solver, 1e-9).unwrap();
        }
    }
    assert!(10 * compared > 7 * count && 10 * refused > count, "{compared} compared, {refused} infeasible");
}

#[test]
fn five_thousand_general_programs() {
    random_family(10_000, 5000, |_, _| {});
}

/// Hessians of few squares and a ridge.
#[test]
fn five_thousand_rank_deficient_programs() {
    random_family(20_000, 5000, |shape, rng| {
        shape.rank = rng.below(shape.n);
        shape.ridge = 10f64.powf(rng.uniform(-3.0, 0.0));
    });
}

/// Half of the rows are copies of others or sums of two.
#[test]
fn five_thousand_programs_with_repeated_rows() {
    random_family(30_000, 5000, |shape, rng| {
        (shape.repeated, shape.m) = (0.5, 5 + rng.below(26));
        shape.equality = rng.uniform(0.1, 0.5);
    });
}

/// All variables have bounds, most of them tight.
#[test]
fn five_thousand_boxes() {
    random_family(40_000, 5000, |shape, rng| {
        (shape.bounded, shape.tight) = (1.0, rng.uniform(0.0, 0.9));
        shape.m = rng.below(12);
    });
}

/// Equality rows with slacks, which the solver replaces and the other does not.
#[test]
fn two_thousand_programs_with_slacks() {
    let (mut compared, mut refused) = (0, 0);
    for seed in 50_000..52_000 {
        let mut rng = Random(seed);
        let mut shape = Shape::random(&mut rng);
        shape.ridge = shape.ridge.max(1e-3);
        shape.scale = 0.0;
        let (mut base, _) = general(&shape, &mut rng);
        let infeasible = seed % 5 == 0 && contradict(&mut base, &mut rng);
        let count = 1 + rng.below(12);
        let (p, _) = with_slacks(&base, count, 2.0, &mut rng);
        let sure = agree(&p, 1e-7, &format!("seed {seed}"));
        compared += usize::from(sure);
        refused += usize::from(sure && infeasible);
    }
    assert!(compared > 1600 && refused > 200, "{compared} compared, {refused} infeasible");
}

#[test]
fn spatial_programs() {
    let compared = (0..40).filter(|&k| agree(&whole_body_spatial(k, 0.02 * k as f64), 1e-5, &format!("{k}"))).count();
    assert!(compared > 20, "{compared}");
}

/// The sum of squared violations is the least there is, and no other point with the same violations has a lower objective.
#[test]
fn the_least_infeasible_point() {
    let mut compared = 0;
    for seed in 0..600 {
        let mut rng = Random(seed);
        let mut shape = Shape::random(&mut rng);
        shape.ridge = shape.ridge.max(1e-2);
        shape.scale = 0.0;
        let (mut p, _) = general(&shape, &mut rng);
        if !contradict(&mut p, &mut rng) || Solver::new(p.n(), p.m()).solve(&p) != Status::Infeasible {
            continue;
        }
        let (n, m) = (p.n(), p.m());
        let unit = |j: usize| (-p.hessian()[j * (n + 1)].log2().floor() / 2.0).ceil().exp2();
        let mut elastic = Elastic::new(n, m);
        // Weights that undo the units: all violations count by their squares.
        for i in 0..m {
            let squares: f64 = p.row(i).iter().enumerate().map(|(j, a)| (a * unit(j)).powi(2)).sum();
            elastic.set_weight(Constraint::Row(i), if squares > 0.0 { squares } else { 1.0 });
        }
        (0..n).for_each(|j| elastic.set_weight(Constraint::Bound(j), unit(j).powi(2)));
        assert_eq!(elastic.solve(&p), Status::Optimal, "seed {seed}");
        let given_up: Vec<_> = elastic.given_up().collect();
        let found: f64 = given_up.iter().map(|given| given.violation.powi(2)).sum();

        let mut sum = Problem::new(n + m + n, m + n);
        let width = sum.n();
        for c in 0..m + n {
            sum.hessian_mut()[(n + c) * (width + 1)] = 2.0;
            let (row, lower, upper) = if c < m {
                (p.row(c).to_vec(), p.row_lower()[c], p.row_upper()[c])
            } else {
                let row = (0..n).map(|k| f64::from(u8::from(k == c - m))).collect();
                (row, p.lower()[c - m], p.upper()[c - m])
            };
            sum.row_mut(c)[..n].copy_from_slice(&row);
            sum.row_mut(c)[n + c] = 1.0;
            sum.row_lower_mut()[c] = lower;
            sum.row_upper_mut()[c] = upper;
        }
        let (status, x) = reference(&sum);
        if status != SolverStatus::Solved {
            continue;
        }
        let least: f64 = x[n..].iter().map(|v| v * v).sum();
        assert!((found - least).abs() < 1e-6 * least + 1e-10, "seed {seed}: {found} instead of {least}");

        // The bounds moved to where they hold, and a little further.
        for given in given_up {
            let moved = given.violation * (1.0 + 1e-8) + 1e-10;
            match (given.constraint, given.side) {
                (Constraint::Row(i), Side::Lower) => p.row_lower_mut()[i] -= moved,
                (Constraint::Row(i), _) => p.row_upper_mut()[i] += moved,
                (Constraint::Bound(j), Side::Lower) => p.lower_mut()[j] -= moved,
                (Constraint::Bound(j), _) => p.upper_mut()[j] += moved,
            }
        }
        let mut solver = Solver::new(n, m);
        assert_eq!(solver.solve(&p), Status::Optimal, "seed {seed}");
        let (found, best) = (p.objective(elastic.x()), p.objective(solver.x()));
        assert!(found - best < 1e-4 * (1.0 + best.abs()), "seed {seed}: {found} instead of {best}");
        compared += 1;
    }
    assert!(compared > 150, "{compared}");
}
