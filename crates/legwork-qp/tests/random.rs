//! Random programs: every answer is optimal to 1e-9 or comes with a proof that there is none; other starts find the same.

mod common;

use common::families::{Shape, contradict, general};
use common::{Random, conflict_proves, kkt_below};
use legwork_qp::{Problem, Settings, Solver, Status};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The seed can be set with PROPTEST_RNG_SEED. With some seeds a program in a hundred thousand misses by a hair: thirty
/// constraints through one ill-conditioned vertex, or a contradiction of the size of rounding errors.
fn config(cases: u32) -> ProptestConfig {
    let seed = std::env::var("PROPTEST_RNG_SEED").ok().and_then(|seed| seed.parse().ok());
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed.unwrap_or(20)),
        ..ProptestConfig::default()
    }
}

prop_compose! {
    fn shapes()(
        n in 1usize..=20, m in 0usize..=30, rank in 0usize..=20, ridge in prop_oneof![Just(0.0), -8.0..0.0f64],
        equality in prop_oneof![Just(0.1), Just(0.6)], tight in prop_oneof![Just(0.1), Just(0.8)],
        bounded in prop_oneof![Just(0.2), Just(0.9)], scale in prop_oneof![Just(0.0), 0.0..3.0f64],
    ) -> Shape {
        Shape {
            n, m,
            // Full rank or a ridge.
            rank: if ridge < 0.0 { rank.min(n) } else { n },
            ridge: if ridge < 0.0 { 10f64.powf(ridge) } else { 0.0 },
            equality, repeated: 0.15, two_sided: 0.4, tight, bounded, fixed: 0.08, scale,
        }
    }
}

/// With smaller ridges iterates may be so large that a contradiction drowns in their rounding errors.
fn well_conditioned(mut shape: Shape) -> Shape {
    shape.ridge = if shape.ridge > 0.0 { shape.ridge.max(1e-3) } else { 0.0 };
    shape.scale = shape.scale.min(2.0);
    shape
}

/// Two fifths of the rows repeat others, and each entry has an error of 10 to the power `noise`. The program stays feasible.
fn nearly_equal_rows(mut shape: Shape, seed: u64, noise: f64) -> Problem {
    shape.repeated = 0.4;
    let mut rng = Random(seed);
    let (mut p, inside) = general(&shape, &mut rng);
    for i in 0..p.m() {
        let mut change = 0.0;
        for j in 0..p.n() {
            let entry = p.row(i)[j] * 10f64.powf(noise) * rng.normal();
            p.row_mut(i)[j] += entry;
            change += entry * inside[j];
        }
        p.row_lower_mut()[i] += change;
        p.row_upper_mut()[i] += change;
    }
    p
}

proptest! {
    #![proptest_config(config(4000))]

    #[test]
    fn feasible_programs_are_solved(shape in shapes(), seed: u64) {
        let (p, inside) = general(&shape, &mut Random(seed));
        let mut solver = Solver::new(p.n(), p.m());
        prop_assert_eq!(solver.solve(&p), Status::Optimal);
        prop_assert_eq!(kkt_below(&p, &solver, 1e-9), Ok(()));
        // No feasible point is better.
        let (found, other) = (p.objective(solver.x()), p.objective(&inside));
        prop_assert!(found <= other + 1e-9 * (found.abs() + other.abs()));
    }

    /// Units that differ by up to ten to the twelfth, Hessians with a condition number up to ten to the tenth.
    #[test]
    fn badly_scaled_programs_are_solved(mut shape in shapes(), scale in 3.0..6.0f64, seed: u64) {
        shape.scale = scale;
        let (p, _) = general(&shape, &mut Random(seed));
        let mut solver = Solver::new(p.n(), p.m());
        prop_assert_eq!(solver.solve(&p), Status::Optimal);
        prop_assert_eq!(kkt_below(&p, &solver, 1e-9), Ok(()));
    }

    /// Variables without a cost, tied to the others by equality rows, are rows by another name.
    #[test]
    fn variables_without_a_cost(shape in shapes(), free in 1usize..5, seed: u64) {
        let mut rng = Random(seed);
        let (p, inside) = general(&shape, &mut rng);
        let (n, m) = (p.n(), p.m());
        let mut tied = Problem::new(n + free, m + free);
        let mut plain = Problem::new(n, m + free);
        for q in [&mut tied, &mut plain] {
            let width = q.n();
            for j in 0..n {
                q.hessian_mut()[j * width..j * width + n].copy_from_slice(&p.hessian()[j * n..(j + 1) * n]);
            }
            q.gradient_mut()[..n].copy_from_slice(p.gradient());
            q.lower_mut()[..n].copy_from_slice(p.lower());
            q.upper_mut()[..n].copy_from_slice(p.upper());
            for i in 0..m {
                q.row_mut(i)[..n].copy_from_slice(p.row(i));
            }
            q.row_lower_mut()[..m].copy_from_slice(p.row_lower());
            q.row_upper_mut()[..m].copy_from_slice(p.row_upper());
        }
        for k in 0..free {
            // factor · t = row · x + shift, with bounds for t.
            let (factor, shift) = (rng.magnitude(-2.0, 2.0), rng.normal());
            let row: Vec<f64> = inside.iter().map(|x| rng.normal() / (x.abs() + 1e-3)).collect();
            let value: f64 = row.iter().zip(&inside).map(|(a, x)| a * x).sum();
            let (lower, upper) = (value - rng.uniform(0.0, 1.0), value + rng.uniform(0.0, 1.0));
            plain.row_mut(m + k).copy_from_slice(&row);
            plain.row_lower_mut()[m + k] = lower;
            plain.row_upper_mut()[m + k] = upper;
            tied.row_mut(m + k)[..n].copy_from_slice(&row);
            tied.row_mut(m + k)[n + k] = -factor;
            tied.row_lower_mut()[m + k] = -shift;
            tied.row_upper_mut()[m + k] = -shift;
            tied.lower_mut()[n + k] = (lower + shift) / factor;
            tied.upper_mut()[n + k] = (upper + shift) / factor;
        }
        let mut solver = Solver::new(n + free, m + free);
        prop_assert_eq!(solver.solve(&tied), Status::Optimal);
        prop_assert!(solver.convexified());
        prop_assert_eq!(kkt_below(&tied, &solver, 1e-9), Ok(()));
        let mut other = Solver::new(n, m + free);
        prop_assert_eq!(other.solve(&plain), Status::Optimal);
        prop_assert!(!other.convexified());
        let (a, b) = (tied.objective(solver.x()), plain.objective(other.x()));
        prop_assert!((a - b).abs() <= 1e-7 * (a.abs() + b.abs()), "{a} {b}");
    }

    /// A fifth of these are feasible: where nothing could be contradicted.
    #[test]
    fn infeasible_programs_are_refused_with_a_proof(shape in shapes(), seed: u64) {
        let shape = well_conditioned(shape);
        let mut rng = Random(seed);
        let (mut p, inside) = general(&shape, &mut rng);
        let infeasible = rng.chance(0.8) && contradict(&mut p, &mut rng);
        let mut solver = Solver::new(p.n(), p.m());
        let status = solver.solve(&p);
        if infeasible {
            prop_assert_eq!(status, Status::Infeasible);
            let reach: Vec<f64> = inside.iter().map(|x| 1e3 * x.abs()).collect();
            let conflict: Vec<_> = solver.conflict().collect();
            prop_assert_eq!(conflict_proves(&p, &conflict, &reach), Ok(()));
        } else {
            prop_assert_eq!(status, Status::Optimal);
            prop_assert_eq!(solver.conflict().count(), 0);
        }
    }

    /// Rows that repeat others up to rounding errors of their own.
    #[test]
    fn nearly_equal_rows_do_no_harm(shape in shapes(), seed: u64, noise in -16.0..-14.0f64) {
        let p = nearly_equal_rows(well_conditioned(shape), seed, noise);
        let mut solver = Solver::new(p.n(), p.m());
        // One in a hundred thousand is IterationLimit by a hair.
        prop_assert_ne!(solver.solve(&p), Status::Infeasible);
        let residuals = p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
        prop_assert!(residuals.worst_relative() < 1e-8, "{residuals:?}");
    }

    /// Between equal and different the program may be too ill-conditioned to be solved, but infeasible it is not.
    #[test]
    fn nearly_equal_rows_are_no_contradiction(shape in shapes(), seed: u64, noise in -14.0..-8.0f64) {
        let p = nearly_equal_rows(shape, seed, noise);
        let mut solver = Solver::new(p.n(), p.m());
        let status = solver.solve(&p);
        if status == Status::Optimal {
            // Multipliers are in the billions here.
            let residuals = p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
            prop_assert!(residuals.primal.relative < 1e-8 && residuals.stationarity.relative < 1e-8);
        } else {
            prop_assert_eq!(status, Status::IterationLimit);
        }
    }

    /// Stopped too early, the answer is optimal but for the rows and bounds that had not entered yet.
    #[test]
    fn an_interrupted_search_leaves_a_usable_iterate(shape in shapes(), seed: u64, limit in 0u32..8) {
        let (p, _) = general(&well_conditioned(shape), &mut Random(seed));
        let settings = Settings { max_iterations: limit, ..Settings::default() };
        let mut solver = Solver::with_settings(p.n(), p.m(), settings);
        let status = solver.solve(&p);
        let residuals = p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
        prop_assert!(residuals.stationarity.relative < 1e-9 && residuals.complementarity.relative < 1e-9);
        prop_assert!(residuals.dual.absolute <= 0.0);
        let reached = p.objective(solver.x());
        // From there it goes on to the optimum.
        let mut calls = 0;
        let mut last = status;
        while last == Status::IterationLimit && limit > 0 && calls < 200 {
            last = solver.solve(&p);
            calls += 1;
        }
        if limit > 0 {
            prop_assert_eq!(last, Status::Optimal);
            let optimum = p.objective(solver.x());
            prop_assert!(reached <= optimum + 1e-9 * (reached.abs() + optimum.abs()));
        }
    }

    /// A solver that has seen other programs of the same size, feasible or not, finds what a new one finds.
    #[test]
    fn no_history_spoils_a_solve(shape in shapes(), seed: u64) {
        let shape = well_conditioned(shape);
        let mut rng = Random(seed);
        let mut old = Solver::new(shape.n, shape.m);
        for round in 0..4 {
            let (mut p, _) = general(&shape, &mut rng);
            if round == 1 {
                contradict(&mut p, &mut rng);
            }
            let status = old.solve(&p);
            let mut new = Solver::new(p.n(), p.m());
            prop_assert_eq!(new.solve(&p), status);
            if status == Status::Optimal {
                prop_assert_eq!(kkt_below(&p, &old, 1e-9), Ok(()));
                let (a, b) = (p.objective(old.x()), p.objective(new.x()));
                prop_assert!((a - b).abs() <= 1e-7 * (a.abs() + b.abs()), "{a} {b}");
            }
        }
    }
}

/// A program whose numbers move by a little from tick to tick.
fn moving(start: &Problem, seed: u64, time: f64) -> Problem {
    let mut rng = Random(seed);
    let mut p = start.clone();
    for g in p.gradient_mut() {
        *g += rng.normal() * (10.0 * time).sin();
    }
    for i in 0..p.m() {
        let shift = 0.2 * rng.normal() * (7.0 * time).sin();
        // Bounds only widen, so that the program stays feasible.
        if p.row_lower()[i] < p.row_upper()[i] {
            p.row_lower_mut()[i] -= shift.abs();
            p.row_upper_mut()[i] += 0.5 * shift.abs();
        }
    }
    p
}

#[test]
fn a_warm_start_finds_the_same_with_fewer_steps() {
    let (mut warm_steps, mut cold_steps, mut solves) = (0, 0, 0);
    for seed in 0..40 {
        let mut rng = Random(seed);
        let shape = Shape {
            n: 12,
            m: 16,
            rank: 12,
            ridge: 0.1,
            equality: 0.15,
            repeated: 0.1,
            two_sided: 0.4,
            tight: 0.3,
            bounded: 0.6,
            fixed: 0.05,
            scale: 1.0,
        };
        let (start, _) = general(&shape, &mut rng);
        let mut warm = Solver::new(12, 16);
        let cold_settings = Settings { warm_start: false, ..Settings::default() };
        let mut cold = Solver::with_settings(12, 16, cold_settings);
        for tick in 0..50 {
            let p = moving(&start, seed, 0.002 * f64::from(tick));
            assert_eq!(warm.solve(&p), Status::Optimal);
            assert_eq!(cold.solve(&p), Status::Optimal);
            kkt_below(&p, &warm, 1e-10).unwrap();
            kkt_below(&p, &cold, 1e-10).unwrap();
            let size = warm.x().iter().fold(0.0, |l: f64, x| l.max(x.abs()));
            for (a, b) in warm.x().iter().zip(cold.x()) {
                assert!((a - b).abs() < 1e-9 * size, "seed {seed}, tick {tick}: {a} {b}");
            }
            warm_steps += warm.iterations();
            cold_steps += cold.iterations();
            solves += 1;
        }
    }
    assert!(cold_steps > 3 * solves, "{cold_steps} steps in {solves} cold solves are no test");
    assert!(warm_steps < cold_steps / 10, "{warm_steps} against {cold_steps}");
}

#[test]
fn the_same_history_gives_the_same_bits() {
    let run = || {
        let mut bits = Vec::new();
        let mut solver = Solver::new(9, 14);
        for seed in 0..200 {
            let mut rng = Random(seed);
            let shape = Shape { n: 9, m: 14, rank: 9, ..Shape::random(&mut rng) };
            let (p, _) = general(&shape, &mut rng);
            solver.solve(&p);
            let numbers = solver.x().iter().chain(solver.row_multipliers());
            bits.extend(numbers.chain(solver.bound_multipliers()).map(|x| x.to_bits()));
        }
        bits
    };
    assert_eq!(run(), run());
}

/// Thirty rows and bounds through one point of fifteen variables. These three (of a hundred thousand) were not solved when
/// equalities entered in the order of their indices, without regard to how independent they are.
#[test]
fn many_equalities_at_one_point() {
    for seed in [19890, 34781, 97205] {
        let mut rng = Random(seed * 7919 + 13);
        let mut shape = Shape::random(&mut rng);
        let ridge = rng.magnitude(-10.0, 0.0);
        shape = Shape { n: 15, m: 30, rank: 0, ridge, tight: 0.95, equality: 0.05, ..shape };
        let (p, _) = general(&shape, &mut rng);
        let mut solver = Solver::new(15, 30);
        assert_eq!(solver.solve(&p), Status::Optimal, "seed {seed}");
        kkt_below(&p, &solver, 1e-9).unwrap();
    }
}

/// Infeasible programs in units so unfit that the contradiction drowns. Two of these (of a hundred thousand) used to be
/// called optimal, with multipliers so large that the errors of the rows cost more than the objective.
#[test]
fn nothing_is_optimal_that_is_not() {
    for seed in [7005, 12891, 19413, 37494, 42698, 42978] {
        let mut rng = Random(seed * 7919 + 13);
        let mut shape = Shape::random(&mut rng);
        shape.scale = rng.uniform(0.0, 6.0);
        shape.ridge = if shape.ridge > 0.0 { rng.magnitude(-12.0, 0.0) } else { 0.0 };
        let (mut p, _) = general(&shape, &mut rng);
        assert!(contradict(&mut p, &mut rng));
        let mut solver = Solver::new(p.n(), p.m());
        if solver.solve(&p) == Status::Optimal {
            kkt_below(&p, &solver, 1e-8).unwrap();
        }
    }
}
