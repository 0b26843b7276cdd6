//! Programs of walks and pushes as the controller posed them, and what working sets of modes are good for.

mod common;

use common::families::whole_body_spatial;
use common::{kkt_below, recorded};
use legwork_qp::{Active, Constraint, Problem, Settings, Side, Solver, Status};

fn recordings() -> [(&'static str, Vec<Problem>); 4] {
    [
        ("walk-direct", recorded::decode(include_bytes!("data/walk-direct.bin"))),
        ("walk-slack", recorded::decode(include_bytes!("data/walk-slack.bin"))),
        ("push-direct", recorded::decode(include_bytes!("data/push-direct.bin"))),
        ("push-slack", recorded::decode(include_bytes!("data/push-slack.bin"))),
    ]
}

/// Which variables are fixed: the contacts without force.
fn mode(p: &Problem) -> u64 {
    p.lower().iter().zip(p.upper()).fold(1, |key, (lower, upper)| key << 1 | u64::from(lower >= upper))
}

#[test]
fn every_recorded_program_is_solved_and_warm_is_cold() {
    for (name, programs) in recordings() {
        let (n, m) = (programs[0].n(), programs[0].m());
        let mut warm = Solver::new(n, m);
        let mut cold = Solver::with_settings(n, m, Settings { warm_start: false, ..Settings::default() });
        let (mut warm_steps, mut cold_steps) = (0, 0);
        for (k, p) in programs.iter().enumerate() {
            assert_eq!(warm.solve(p), Status::Optimal, "{name} {k}");
            assert_eq!(cold.solve(p), Status::Optimal, "{name} {k}");
            kkt_below(p, &warm, 1e-11).unwrap();
            kkt_below(p, &cold, 1e-11).unwrap();
            let size = cold.x().iter().fold(0.0, |l: f64, x| l.max(x.abs()));
            for (a, b) in warm.x().iter().zip(cold.x()) {
                assert!((a - b).abs() < 1e-9 * size, "{name} {k}: {a} {b}");
            }
            warm_steps += warm.iterations();
            cold_steps += cold.iterations();
        }
        assert!(warm_steps < cold_steps, "{name}: {warm_steps} warm, {cold_steps} cold");
    }
}

/// The direct form is the slack form with torques and slack variables eliminated: the first 11 variables agree.
#[test]
fn the_recorded_forms_agree() {
    for (slack, direct) in [
        (&include_bytes!("data/walk-slack.bin")[..], &include_bytes!("data/walk-direct.bin")[..]),
        (include_bytes!("data/push-slack.bin"), include_bytes!("data/push-direct.bin")),
    ] {
        let (slack, direct) = (recorded::decode(slack), recorded::decode(direct));
        let (mut of_slack, mut of_direct) = (Solver::new(23, 25), Solver::new(11, 21));
        for (k, (slack, direct)) in slack.iter().zip(&direct).take(40).enumerate() {
            assert_eq!((of_slack.solve(slack), of_direct.solve(direct)), (Status::Optimal, Status::Optimal));
            let size = of_direct.x().iter().fold(0.0, |l: f64, x| l.max(x.abs()));
            for (a, b) in of_slack.x().iter().zip(of_direct.x()) {
                assert!((a - b).abs() < 1e-6 * size, "{k}: {a} {b}");
            }
        }
    }
}

/// Steps at changes of the mode, without and with the working sets of modes.
fn steps_at_switches(programs: &[Problem]) -> [u32; 2] {
    let (n, m) = (programs[0].n(), programs[0].m());
    let (mut plain, mut modal) = (Solver::new(n, m), Solver::new(n, m));
    let mut steps = [0; 2];
    let mut previous = 0;
    for p in programs {
        modal.select_mode(mode(p));
        assert_eq!((plain.solve(p), modal.solve(p)), (Status::Optimal, Status::Optimal));
        let (a, b) = (p.objective(plain.x()), p.objective(modal.x()));
        assert!((a - b).abs() <= 1e-9 * (a.abs() + b.abs()));
        if mode(p) != previous {
            steps[0] += plain.iterations();
            steps[1] += modal.iterations();
        }
        previous = mode(p);
    }
    steps
}

#[test]
fn working_sets_of_modes_save_steps_at_contact_switches() {
    let ticks: Vec<Problem> = (0..800).map(|k| whole_body_spatial(2, 0.005 * f64::from(k))).collect();
    let [plain, modal] = steps_at_switches(&ticks);
    assert!(modal < plain, "{modal} steps instead of {plain}");
    for (name, programs) in recordings() {
        let [plain, modal] = steps_at_switches(&programs);
        assert!(modal <= plain, "{name}: {modal} steps instead of {plain}");
        // Where modes come and go with each tick.
        assert!(name != "push-direct" || 2 * modal < plain, "{name}: {modal} steps instead of {plain}");
    }
}

#[test]
fn a_working_set_can_be_given() {
    let programs = recorded::decode(include_bytes!("data/push-direct.bin"));
    let (n, m) = (programs[0].n(), programs[0].m());
    let mut first = Solver::new(n, m);
    let mut second = Solver::with_settings(n, m, Settings { warm_start: false, ..Settings::default() });
    let mut helped = 0;
    for p in &programs {
        first.solve(p);
        second.solve(p);
        let cold = second.iterations();
        let set: Vec<Active> = first.working_set().collect();
        second.start_from(set);
        assert_eq!(second.solve(p), Status::Optimal);
        assert_eq!(second.iterations(), 0);
        helped += cold;
        // Once only.
        second.solve(p);
        assert_eq!(second.iterations(), cold);
    }
    assert!(helped > 20, "{helped}");
    // Nonsense does no harm: what is not there, what is infinite, all at once, twice.
    let bounds = (0..2 * n).map(|j| Active { constraint: Constraint::Bound(j % (n + 1)), side: Side::Upper });
    let rows = (0..2 * m).map(|i| Active { constraint: Constraint::Row(i), side: Side::Lower });
    for nonsense in [bounds.clone().chain(rows.clone()).collect(), rows.chain(bounds).collect::<Vec<_>>()] {
        for p in &programs {
            second.start_from(nonsense.iter().copied());
            assert_eq!(second.solve(p), Status::Optimal);
            kkt_below(p, &second, 1e-10).unwrap();
        }
    }
}
