//! A first program: the point next to (2, 1) with x + y <= 2 and y >= 0.8.
//!
//! `cargo run --release -p legwork-qp --example first_program`

use std::io::{self, Write};

use legwork_qp::{Problem, Solver, Status};

fn main() -> io::Result<()> {
    let mut problem = Problem::new(2, 1);
    problem.hessian_mut().copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
    problem.gradient_mut().copy_from_slice(&[-2.0, -1.0]);
    problem.row_mut(0).copy_from_slice(&[1.0, 1.0]);
    problem.row_upper_mut()[0] = 2.0;
    problem.lower_mut()[1] = 0.8;

    let mut solver = Solver::new(2, 1);
    let status = solver.solve(&problem);
    assert_eq!(status, Status::Optimal);

    let mut out = io::stdout().lock();
    writeln!(out, "x = {:?} after {} iterations", solver.x(), solver.iterations())?;
    for active in solver.working_set() {
        writeln!(out, "{} holds, at its {:?} side", active.constraint, active.side)?;
    }
    writeln!(out, "multipliers: rows {:?}, bounds {:?}", solver.row_multipliers(), solver.bound_multipliers())?;
    let residuals = problem.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
    writeln!(out, "residuals of the optimality conditions: {:.0e}", residuals.worst_relative())
}
