//! The same answers as Clarabel, an interior-point solver of other people, at tolerances as tight as it reaches.

mod common;

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{NonnegativeConeT, ZeroConeT};
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus};
use common::families::{Shape, contradict, general, whole_body_direct, whole_body_slack};
use common::{Random, kkt_below};
use legwork_qp::{Problem, Solver, Status};

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
