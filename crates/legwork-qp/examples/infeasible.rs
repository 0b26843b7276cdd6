//! A program without a solution: who contradicts whom, and the point that violates least.
//!
//! Two hands shall lift 300 N together, 200 N at least with the left one, but neither can carry more than 120 N.
//! `cargo run --release -p legwork-qp --example infeasible`

use std::io::{self, Write};

use legwork_qp::{Constraint, Elastic, Problem, Solver, Status};

fn main() -> io::Result<()> {
    let mut problem = Problem::new(2, 2);
    problem.hessian_mut().copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
    problem.row_mut(0).copy_from_slice(&[1.0, 1.0]);
    (problem.row_lower_mut()[0], problem.row_upper_mut()[0]) = (300.0, 300.0);
    problem.row_mut(1).copy_from_slice(&[1.0, 0.0]);
    problem.row_lower_mut()[1] = 200.0;
    problem.upper_mut().fill(120.0);

    let mut out = io::stdout().lock();
    let mut solver = Solver::new(2, 2);
    assert_eq!(solver.solve(&problem), Status::Infeasible);
    writeln!(out, "no solution; the sum of these, by their weights, says that 0 is positive:")?;
    for conflict in solver.conflict() {
        writeln!(out, "  {} ({:?} side), weight {:.3}", conflict.constraint, conflict.side, conflict.weight)?;
    }

    // The hands are what they are; the tasks may yield, the sum less than the share of the left hand.
    let mut elastic = Elastic::new(2, 2);
    elastic.set_yielding(Constraint::Bound(0), false);
    elastic.set_yielding(Constraint::Bound(1), false);
    elastic.set_weight(Constraint::Row(0), 100.0);
    assert_eq!(elastic.solve(&problem), Status::Optimal);
    writeln!(out, "least infeasible: x = {:.3?}", elastic.x())?;
    for given in elastic.given_up() {
        writeln!(out, "  given up: {} ({:?} side), by {:.3}", given.constraint, given.side, given.violation)?;
    }
    Ok(())
}
