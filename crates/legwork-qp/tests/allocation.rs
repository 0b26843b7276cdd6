//! `solve` allocates nothing, whatever the outcome. In a binary of its own, for the sake of the counting allocator.

mod common;

use common::Random;
use common::families::{Shape, contradict, general, whole_body_slack};
use legwork_qp::{Active, Constraint, Elastic, Problem, Side, Solver, Status};

fn allocations(solver: &mut Solver, problem: &Problem) -> (u64, Status) {
    let mut status = Status::InvalidInput;
    let info = allocation_counter::measure(|| status = solver.solve(problem));
    (info.count_total, status)
}

#[test]
fn the_counter_counts() {
    let info = allocation_counter::measure(|| drop(std::hint::black_box(vec![1.0; 8])));
    assert_eq!(info.count_total, 1);
}

#[test]
fn solving_does_not_allocate() {
    let mut seen = Vec::new();
    for seed in 0..300 {
        let mut rng = Random(seed);
        let shape = Shape::random(&mut rng);
        let (mut p, _) = general(&shape, &mut rng);
        let mut solver = Solver::new(p.n(), p.m());
        // The first solve, one with a guess, and one that ends otherwise.
        for change in 0..4 {
            match change {
                2 => drop(contradict(&mut p, &mut rng)),
                3 if seed % 2 == 0 => p.hessian_mut()[0] = -1.0,
                3 => p.gradient_mut()[0] = f64::NAN,
                _ => {}
            }
            let (count, status) = allocations(&mut solver, &p);
            assert_eq!(count, 0, "seed {seed}, {status:?}");
            seen.push(status);
        }
    }
    for status in [Status::Optimal, Status::Infeasible, Status::NotConvex, Status::InvalidInput] {
        assert!(seen.contains(&status), "{status:?}");
    }
    let p = whole_body_slack(0, 0.0);
    assert_eq!(allocations(&mut Solver::new(23, 25), &p), (0, Status::Optimal));
}

#[test]
fn reading_the_answer_does_not_allocate() {
    let mut p = whole_body_slack(0, 0.0);
    let mut solver = Solver::new(23, 25);
    solver.solve(&p);
    let info = allocation_counter::measure(|| {
        let residuals = p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
        assert!(residuals.worst_relative() < 1e-9 && solver.working_set().count() > 0);
        p.reset();
    });
    assert_eq!(info.count_total, 0);
}

#[test]
fn neither_modes_nor_guesses_nor_the_fallback_allocate() {
    let mut solver = Solver::new(23, 25);
    let mut elastic = Elastic::new(23, 25);
    let programs: Vec<Problem> = (0..40).map(|k| whole_body_slack(k, 0.0)).collect();
    let info = allocation_counter::measure(|| {
        for (k, p) in programs.iter().enumerate() {
            solver.select_mode(k as u64 % 11);
            solver.solve(p);
            let guess = (0..30).map(|j| Active { constraint: Constraint::Bound(j), side: Side::Upper });
            solver.start_from(guess);
            solver.solve(p);
            elastic.set_yielding(Constraint::Row(k % 25), k % 2 == 0);
            elastic.solve(p);
            assert!(elastic.given_up().count() + elastic.conflict().count() < 100);
        }
        solver.forget();
    });
    assert_eq!(info.count_total, 0);
}
