//! Programs that are made to be difficult, and solvers that have been through all sorts of things: whatever the answer, it
//! must be right. Seeds are fixed; FUZZ_SEED sets another first one and FUZZ_COUNT their number.

mod common;

use common::{Random, conflict_proves, kkt_below};
use legwork_qp::{Active, Constraint, Elastic, Problem, Settings, Side, Solver, Status};

/// Small integers, so that rows repeat, vertices are degenerate and bounds touch; or such numbers in wild units.
fn program(n: usize, m: usize, rng: &mut Random) -> Problem {
    let mut p = Problem::new(n, m);
    let integer = |rng: &mut Random| rng.below(7) as f64 - 3.0;
    let wild = rng.chance(0.2);
    let unit = |rng: &mut Random| if wild { rng.magnitude(-3.0, 3.0) } else { 1.0 };
    let units: Vec<f64> = (0..n).map(|_| unit(rng)).collect();
    let squares = if rng.chance(0.2) { rng.below(n + 1) } else { n + 2 };
    for _ in 0..squares {
        let b: Vec<f64> = (0..n).map(|j| integer(rng) / units[j]).collect();
        common::families::add_square(&mut p, &b, 1.0);
    }
    for j in 0..n {
        if rng.chance(0.8) {
            p.hessian_mut()[j * (n + 1)] += 1.0 / (units[j] * units[j]);
        }
        p.gradient_mut()[j] = integer(rng) / units[j];
    }
    let inside: Vec<f64> = (0..n).map(|_| integer(rng)).collect();
    let feasible = rng.chance(0.7);
    for c in 0..m + n {
        let factor = unit(rng);
        let mut value = 0.0;
        if c < m {
            let density = rng.uniform(0.0, 1.0);
            for j in 0..n {
                if rng.chance(density) {
                    let entry = integer(rng);
                    p.row_mut(c)[j] = entry * factor / units[j];
                    value += entry * inside[j];
                }
            }
        } else {
            value = inside[c - m];
        }
        let offset = if feasible { 0.0 } else { integer(rng) };
        let (below, above) = (rng.below(3) as f64, rng.below(3) as f64);
        let scale = if c < m { factor } else { units[c - m] };
        let (mut lower, mut upper) = ((value + offset - below) * scale, (value + offset + above) * scale);
        if rng.chance(if c < m { 0.3 } else { 0.5 }) {
            lower = f64::NEG_INFINITY;
        }
        if rng.chance(if c < m { 0.3 } else { 0.5 }) {
            upper = f64::INFINITY;
        }
        if c < m {
            (p.row_lower_mut()[c], p.row_upper_mut()[c]) = (lower, upper);
        } else {
            (p.lower_mut()[c - m], p.upper_mut()[c - m]) = (lower, upper);
        }
    }
    p
}

/// Moves some numbers a little or a lot.
fn mutate(p: &mut Problem, rng: &mut Random) {
    let n = p.n();
    match rng.below(4) {
        0 => p.gradient_mut()[rng.below(n)] += rng.normal(),
        1 if p.m() > 0 => {
            let i = rng.below(p.m());
            p.row_mut(i)[rng.below(n)] = rng.normal();
        }
        2 if p.m() > 0 => {
            let i = rng.below(p.m());
            p.row_lower_mut()[i] -= rng.uniform(0.0, 1.0);
        }
        _ => p.upper_mut()[rng.below(n)] += rng.uniform(0.0, 1.0),
    }
}

fn guess(n: usize, m: usize, rng: &mut Random) -> Vec<Active> {
    (0..rng.below(n + m + 1))
        .map(|_| {
            let k = rng.below(n + m);
            let constraint = if k < m { Constraint::Row(k) } else { Constraint::Bound(k - m) };
            Active { constraint, side: if rng.chance(0.5) { Side::Lower } else { Side::Upper } }
        })
        .collect()
}

/// Is the answer what its status says? Counts those that stopped early.
fn check(p: &Problem, solver: &Solver, status: Status, stopped: &mut u32) -> Result<(), String> {
    match status {
        Status::Optimal => kkt_below(p, solver, 1e-8),
        Status::Infeasible => {
            let conflict: Vec<_> = solver.conflict().collect();
            let reach: Vec<f64> = (0..p.n()).map(|j| 1e3 / p.hessian()[j * (p.n() + 1)].sqrt().max(1e-6)).collect();
            conflict_proves(p, &conflict, &reach)
        }
        Status::IterationLimit => {
            *stopped += 1;
            solver.x().iter().all(|x| x.is_finite()).then_some(()).ok_or("not finite".into())
        }
        Status::NotConvex => Ok(()),
        Status::InvalidInput => Err(format!("{:?}", solver.defect())),
    }
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn whatever_the_answer_it_is_right() {
    let (first, count) = (number("FUZZ_SEED", 0), number("FUZZ_COUNT", 4000));
    let (mut stopped, mut seen) = (0, [0; 3]);
    for seed in first..first + count {
        let mut rng = Random(seed);
        let (n, m) = (1 + rng.below(14), rng.below(20));
        let mut p = program(n, m, &mut rng);
        let mut solver = Solver::new(n, m);
        let mut twin = solver.clone();
        let mut cold = Solver::with_settings(n, m, Settings { warm_start: false, ..Settings::default() });
        for round in 0..6 {
            if rng.chance(0.3) {
                let set = guess(n, m, &mut rng);
                solver.start_from(set.iter().copied());
                twin.start_from(set);
            }
            let key = rng.below(3) as u64;
            solver.select_mode(key);
            twin.select_mode(key);
            let status = solver.solve(&p);
            let place = format!("seed {seed}, round {round}, {status:?}");
            check(&p, &solver, status, &mut stopped).unwrap_or_else(|error| panic!("{place}: {error}"));
            assert_eq!(twin.solve(&p), status, "{place}");
            let bits = |solver: &Solver| solver.x().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&twin), bits(&solver), "{place}");
            let other = cold.solve(&p);
            if [status, other].iter().all(|s| *s != Status::IterationLimit) {
                assert_eq!(other, status, "{place}");
            }
            if (status, other) == (Status::Optimal, Status::Optimal) {
                let (a, b) = (p.objective(solver.x()), p.objective(cold.x()));
                assert!((a - b).abs() <= 1e-7 * (1.0 + a.abs() + b.abs()), "{place}: {a} {b}");
            }
            let which = [Status::Optimal, Status::Infeasible, Status::NotConvex].iter().position(|s| *s == status);
            which.into_iter().for_each(|k| seen[k] += 1);
            mutate(&mut p, &mut rng);
        }
    }
    assert!(seen.iter().all(|&times| times > count / 20), "{seen:?}");
    assert!(u64::from(stopped) <= count / 1000, "{stopped} stopped");
}

/// The fallback gives up nothing where there is a solution, and then finds that; else it gives up something.
#[test]
fn the_fallback_gives_up_what_it_must() {
    for seed in 0..number("FUZZ_COUNT", 4000) / 4 {
        let mut rng = Random(seed);
        let (n, m) = (1 + rng.below(8), rng.below(12));
        let p = program(n, m, &mut rng);
        let (mut solver, mut elastic) = (Solver::new(n, m), Elastic::new(n, m));
        let status = solver.solve(&p);
        let found = elastic.solve(&p);
        match status {
            Status::Optimal => {
                assert_eq!(found, Status::Optimal, "seed {seed}");
                assert_eq!(elastic.given_up().count(), 0, "seed {seed}");
                let (a, b) = (p.objective(solver.x()), p.objective(elastic.x()));
                assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs() + b.abs()), "seed {seed}: {a} {b}");
            }
            Status::Infeasible if found == Status::Optimal => assert!(elastic.given_up().count() > 0, "seed {seed}"),
            _ => {}
        }
        // Where nothing may yield it is the solver, certificates and all.
        (0..m).for_each(|i| elastic.set_yielding(Constraint::Row(i), false));
        (0..n).for_each(|j| elastic.set_yielding(Constraint::Bound(j), false));
        assert_eq!(elastic.solve(&p), status, "seed {seed}");
        if status == Status::Infeasible {
            let conflict: Vec<_> = elastic.conflict().collect();
            conflict_proves(&p, &conflict, &vec![1e6; n]).unwrap();
        }
    }
}
