//! The solvers that are written in Rust: ours, and Clarabel.
//!
//! An answer is the point x, and from us the largest relative residual of the optimality conditions.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use ::clarabel::algebra::CscMatrix;
use ::clarabel::solver::SupportedConeT::{NonnegativeConeT, ZeroConeT};
use ::clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use legwork_qp::{Problem, Solver, Status};

use crate::files::{Table, answer};
use crate::programs::problem;

/// Times `legwork_qp`, warm-started from the program before, from a problem in memory to its solution.
pub(crate) fn legwork(programs: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    let problems: Vec<Problem> = Table::read(programs)?.rows().map(problem).collect();
    let (n, m) = problems.first().map(|p| (p.n(), p.m())).ok_or("no programs")?;
    let mut solver = Solver::new(n, m);
    let mut answers = Table::new(3 + n + 1);
    for p in problems.iter().take(200) {
        solver.solve(p);
    }
    let mut solver = Solver::new(n, m);
    for p in &problems {
        let begin = Instant::now();
        let status = solver.solve(p);
        let seconds = begin.elapsed().as_secs_f64();
        let residual = p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers()).worst_relative();
        let values = solver.x().iter().copied().chain([residual]);
        answers.push(answer(seconds, status == Status::Optimal, solver.iterations(), values));
    }
    Ok(answers.write(out)?)
}

/// Times Clarabel at its default tolerances, which has no warm start: from the matrices in its own form to the solution.
pub(crate) fn clarabel(programs: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    let problems: Vec<Problem> = Table::read(programs)?.rows().map(problem).collect();
    let mut answers = Table::new(3 + problems.first().ok_or("no programs")?.n());
    for p in problems.iter().take(20).chain(&problems) {
        let form = Form::of(p);
        let begin = Instant::now();
        let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
        let mut solver =
            DefaultSolver::new(&form.hessian, p.gradient(), &form.rows, &form.bounds, &form.cones, settings)?;
        solver.solve();
        let seconds = begin.elapsed().as_secs_f64();
        let solved = solver.solution.status == SolverStatus::Solved;
        answers.push(answer(seconds, solved, solver.solution.iterations, solver.solution.x.iter().copied()));
    }
    answers.values.drain(..20 * answers.columns);
    Ok(answers.write(out)?)
}

/// Clarabel's form: `A x + s = b`, `s` zero for equalities and positive for inequalities.
struct Form {
    hessian: CscMatrix,
    rows: CscMatrix,
    bounds: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

impl Form {
    fn of(p: &Problem) -> Self {
        let (n, m) = (p.n(), p.m());
        let unit = |j: usize| (0..n).map(|k| f64::from(u8::from(k == j))).collect::<Vec<f64>>();
        let rows = (0..m).map(|i| (p.row(i).to_vec(), p.row_lower()[i], p.row_upper()[i]));
        let (mut equal, mut above) = (Vec::new(), Vec::new());
        for (row, lower, upper) in rows.chain((0..n).map(|j| (unit(j), p.lower()[j], p.upper()[j]))) {
            if lower >= upper {
                equal.push((row, upper));
                continue;
            }
            if lower.is_finite() {
                above.push((row.iter().map(|a| -a).collect(), -lower));
            }
            if upper.is_finite() {
                above.push((row, upper));
            }
        }
        let cones = vec![ZeroConeT(equal.len()), NonnegativeConeT(above.len())];
        let (rows, bounds): (Vec<Vec<f64>>, Vec<f64>) = equal.into_iter().chain(above).unzip();
        let mut hessian: Vec<Vec<f64>> = p.hessian().chunks(n).map(<[f64]>::to_vec).collect();
        for (i, row) in hessian.iter_mut().enumerate() {
            // The upper triangle.
            row[..i].fill(0.0);
        }
        Self { hessian: CscMatrix::from(&hessian), rows: CscMatrix::from(&rows), bounds, cones }
    }
}
