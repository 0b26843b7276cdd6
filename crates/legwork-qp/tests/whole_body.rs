//! The programs that the crate is made for, in the two forms of a planar biped's control.

mod common;

use common::families::{whole_body_direct, whole_body_slack};
use common::{conflict_proves, kkt_below};
use legwork_qp::{Solver, Status};

/// Both forms of the same control, solved independently, give the same accelerations and forces.
#[test]
fn slack_form_and_direct_form_agree() {
    let mut infeasible = 0;
    for seed in 0..300 {
        let (slack, direct) = (whole_body_slack(seed, 0.0), whole_body_direct(seed, 0.0));
        let mut slack_solver = Solver::new(slack.n(), slack.m());
        let mut direct_solver = Solver::new(direct.n(), direct.m());
        let status = slack_solver.solve(&slack);
        assert_eq!(direct_solver.solve(&direct), status, "seed {seed}");
        assert!(slack_solver.convexified() && !direct_solver.convexified());
        if status == Status::Infeasible {
            infeasible += 1;
            let conflict: Vec<_> = slack_solver.conflict().collect();
            conflict_proves(&slack, &conflict, &[1e5; 23]).unwrap();
            let conflict: Vec<_> = direct_solver.conflict().collect();
            conflict_proves(&direct, &conflict, &[1e5; 11]).unwrap();
            continue;
        }
        assert_eq!(status, Status::Optimal, "seed {seed}");
        kkt_below(&slack, &slack_solver, 1e-11).unwrap();
        kkt_below(&direct, &direct_solver, 1e-11).unwrap();
        let (a, b) = (slack_solver.x(), direct_solver.x());
        let size = b.iter().fold(0.0, |l: f64, x| l.max(x.abs()));
        for j in 0..11 {
            // Rounding errors of the direct form's H, about 1e-10, stand against its smallest weight of 1e-4.
            assert!((a[j] - b[j]).abs() < 1e-5 * size, "seed {seed}: {a:?} {b:?}");
        }
        // The direct form leaves out a constant of the cost: half the weighted squares of what is wanted.
        let constant = (0..8).map(|k| 0.5 * slack.hessian()[(15 + k) * 24] * slack.row_lower()[7 + k].powi(2));
        let (slack_cost, direct_cost) = (slack.objective(a), direct.objective(b) + constant.sum::<f64>());
        let entry = |i: usize, j: usize| (b[i] * direct.hessian()[i * 11 + j] * b[j]).abs();
        let scale: f64 = (0..11).map(|i| (0..11).map(|j| entry(i, j)).sum::<f64>()).sum();
        assert!((slack_cost - direct_cost).abs() < 1e-12 * scale, "seed {seed}: {slack_cost} {direct_cost}");
    }
    assert!(infeasible < 10);
}

/// From tick to tick the working set most often stays, and the answer is that of a cold start.
#[test]
fn a_walk_of_ticks() {
    for make in [whole_body_slack, whole_body_direct] {
        let (mut steps, mut entered) = (0, 0);
        for seed in 0..10 {
            let first = make(seed, 0.0);
            let mut warm = Solver::new(first.n(), first.m());
            let mut cold = warm.clone();
            for tick in 0..200 {
                let p = make(seed, 0.001 * f64::from(tick));
                let status = warm.solve(&p);
                cold.forget();
                assert_eq!(cold.solve(&p), status, "seed {seed}, tick {tick}");
                if status == Status::Optimal {
                    kkt_below(&p, &warm, 1e-11).unwrap();
                    let (a, b) = (p.objective(warm.x()), p.objective(cold.x()));
                    assert!((a - b).abs() <= 1e-9 * (a.abs() + b.abs()), "seed {seed}, tick {tick}: {a} {b}");
                }
                if tick > 0 {
                    steps += warm.iterations();
                    entered += cold.iterations();
                }
            }
        }
        assert!(entered > 10 * steps, "{steps} warm, {entered} cold");
    }
}
