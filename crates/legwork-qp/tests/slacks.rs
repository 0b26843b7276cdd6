//! Slack variables that the solver replaces: the same answers as where they stay. A finite bound, too far away to matter, keeps
//! a slack from being replaced.

mod common;

use common::families::{Shape, contradict, general, whole_body_slack, with_slacks};
use common::{Random, conflict_proves, kkt_below};
use legwork_qp::{Active, Constraint, Problem, Side, Solver, Status};

const FAR: f64 = 1e12;

/// A program with slacks, the slacks' indices, and a feasible point of the part without them.
fn program(seed: u64, decades: f64) -> (Problem, Vec<usize>, Vec<f64>) {
    let mut rng = Random(seed);
    let mut shape = Shape::random(&mut rng);
    (shape.ridge, shape.scale) = (shape.ridge.max(1e-3), 0.0);
    let (mut base, inside) = general(&shape, &mut rng);
    if seed.is_multiple_of(4) {
        contradict(&mut base, &mut rng);
    }
    let count = 1 + rng.below(12);
    let (p, slacks) = with_slacks(&base, count, decades, &mut rng);
    (p, slacks, inside)
}

fn keep_slacks(p: &Problem, slacks: &[usize]) -> Problem {
    let mut kept = p.clone();
    slacks.iter().for_each(|&j| kept.upper_mut()[j] = FAR);
    kept
}

fn active(solver: &Solver) -> Vec<Active> {
    let mut set: Vec<Active> = solver.working_set().collect();
    set.sort_by_key(|active| active.constraint);
    set
}

#[test]
fn replaced_slacks_give_the_same_answers_as_kept_ones() {
    let (mut optimal, mut infeasible) = (0, 0);
    for seed in 0..4000 {
        let (p, slacks, inside) = program(seed, 3.0);
        let kept = keep_slacks(&p, &slacks);
        let (n, m) = (p.n(), p.m());
        let (mut of_replaced, mut of_kept) = (Solver::new(n, m), Solver::new(n, m));
        let status = of_replaced.solve(&p);
        assert_eq!(status, of_kept.solve(&kept), "seed {seed}");
        if status == Status::Infeasible {
            let conflict: Vec<_> = of_replaced.conflict().collect();
            let reach: Vec<f64> = (0..n).map(|_| 1e3 * inside.iter().fold(1.0, |l: f64, x| l.max(x.abs()))).collect();
            conflict_proves(&p, &conflict, &reach).unwrap();
            // A row with a slack contradicts nothing.
            let first = m - slacks.len();
            assert!(conflict.iter().all(|c| !matches!(c.constraint, Constraint::Row(i) if i >= first)), "seed {seed}");
            infeasible += 1;
            continue;
        }
        assert_eq!(status, Status::Optimal, "seed {seed}");
        kkt_below(&p, &of_replaced, 1e-11).unwrap_or_else(|message| panic!("seed {seed}: {message}"));
        let size = of_kept.x().iter().fold(1.0, |l: f64, x| l.max(x.abs()));
        for (a, b) in of_replaced.x().iter().zip(of_kept.x()) {
            assert!((a - b).abs() < 1e-7 * size, "seed {seed}: {a} {b}");
        }
        let set = active(&of_replaced);
        for i in m - slacks.len()..m {
            assert!(set.contains(&Active { constraint: Constraint::Row(i), side: Side::Equal }), "seed {seed}: {i}");
        }
        optimal += 1;
    }
    assert!(optimal > 2500 && infeasible > 500, "{optimal} optimal, {infeasible} infeasible");
}

/// The weights of one program differ by up to twelve orders of magnitude; nothing is lost beside slacks that are kept.
#[test]
fn weights_of_twelve_decades_keep_the_residuals_small() {
    let worst = |p: &Problem, solver: &Solver| {
        p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers()).worst_relative()
    };
    let mut solved = 0;
    for seed in (0..3000).filter(|seed| seed % 4 != 0) {
        let (p, slacks, _) = program(seed, 6.0);
        let (n, m) = (p.n(), p.m());
        let (mut of_replaced, mut of_kept) = (Solver::new(n, m), Solver::new(n, m));
        let status = of_replaced.solve(&p);
        assert_eq!(status, of_kept.solve(&keep_slacks(&p, &slacks)), "seed {seed}");
        assert_eq!(status, Status::Optimal, "seed {seed}");
        let (replaced, kept) = (worst(&p, &of_replaced), worst(&p, &of_kept));
        assert!(replaced < 1e-9, "seed {seed}: {replaced:e}, {kept:e} if slacks are kept");
        solved += 1;
    }
    assert!(solved > 2000);
}

/// What is a slack in one call may not be one in the next: a solver that has seen the one solves the other.
#[test]
fn a_solver_notices_when_a_slack_is_none_any_more() {
    for seed in (0..400).filter(|seed| seed % 4 != 0) {
        let (p, slacks, _) = program(seed, 2.0);
        let (n, m) = (p.n(), p.m());
        let (slack, row, width) = (slacks[0], m - slacks.len(), n + 1);
        let other = if slack == 0 { n - 1 } else { 0 };
        let mut old = Solver::new(n, m);
        for change in 0..7 {
            let mut q = p.clone();
            match change {
                0 => q.row_upper_mut()[row] = f64::INFINITY,
                1 => q.lower_mut()[slack] = 0.1,
                2 => (q.lower_mut()[slack], q.upper_mut()[slack]) = (0.1, 0.1),
                3 => q.row_mut(row)[slack] = 0.0,
                4 if m > slacks.len() => q.row_mut(0)[slack] = 0.3,
                5 => {
                    let weight = 0.3 * (q.hessian()[slack * width] * q.hessian()[other * width]).sqrt().min(1e-3);
                    q.hessian_mut()[slack * n + other] = weight;
                    q.hessian_mut()[other * n + slack] = weight;
                }
                6 => q.hessian_mut()[slack * width] = 0.0,
                _ => {}
            }
            assert_eq!(old.solve(&p), Status::Optimal, "seed {seed}");
            let mut new = Solver::new(n, m);
            let status = new.solve(&q);
            assert_eq!(old.solve(&q), status, "seed {seed}, change {change}");
            if status == Status::Optimal {
                kkt_below(&q, &old, 1e-9).unwrap_or_else(|message| panic!("seed {seed}, {change}: {message}"));
            }
        }
    }
}

/// Entries and costs at the ends of what numbers can hold, and such that are none.
#[test]
fn slacks_beyond_all_measure_are_left_where_they_are() {
    for (entry, cost) in [(1e-200, 1.0), (1e200, 1.0), (1.0, 1e-290), (1.0, 1e290), (1e-160, 1e-300), (1e160, 1e300)] {
        let mut p = whole_body_slack(0, 0.0);
        p.row_mut(7)[15] = entry;
        p.hessian_mut()[15 * 24] = cost;
        let kept = keep_slacks(&p, &(15..23).collect::<Vec<_>>());
        let status = Solver::new(23, 25).solve(&kept);
        let mut solver = Solver::new(23, 25);
        assert_eq!(solver.solve(&p), status, "{entry:e}, {cost:e}");
        if status == Status::Optimal {
            kkt_below(&p, &solver, 1e-9).unwrap_or_else(|message| panic!("{entry:e}, {cost:e}: {message}"));
        }
    }
    // The others' entries may be as small: then the row's factor is beyond what squares can hold.
    let mut p = whole_body_slack(0, 0.0);
    p.row_mut(7)[..7].iter_mut().for_each(|a| *a *= 1e-250);
    let mut solver = Solver::new(23, 25);
    assert_eq!(solver.solve(&p), Status::Optimal);
    kkt_below(&p, &solver, 1e-9).unwrap();
    for place in 0..4 {
        let mut p = whole_body_slack(0, 0.0);
        match place {
            0 => p.row_mut(7)[15] = f64::NAN,
            1 => p.hessian_mut()[15 * 24] = f64::INFINITY,
            2 => p.gradient_mut()[15] = f64::NAN,
            _ => p.row_mut(7)[2] = f64::INFINITY,
        }
        let (mut of_replaced, mut of_kept) = (Solver::new(23, 25), Solver::new(23, 25));
        assert_eq!(of_replaced.solve(&p), Status::InvalidInput, "{place}");
        of_kept.solve(&keep_slacks(&p, &(15..23).collect::<Vec<_>>()));
        assert_eq!(of_replaced.defect(), of_kept.defect(), "{place}");
    }
}
