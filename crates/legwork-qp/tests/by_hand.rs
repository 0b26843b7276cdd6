//! Programs that can be solved by hand, every status, and the answers' small print.

mod common;

use common::{conflict_proves, kkt_below};
use legwork_qp::{Active, Constraint, Defect, Problem, Settings, Side, Solver, Status};

/// `H` by rows, `g`, and rows `(a, lower, upper)`.
fn program(h: &[f64], g: &[f64], rows: &[(&[f64], f64, f64)]) -> Problem {
    let mut p = Problem::new(g.len(), rows.len());
    p.hessian_mut().copy_from_slice(h);
    p.gradient_mut().copy_from_slice(g);
    for (i, (row, lower, upper)) in rows.iter().enumerate() {
        p.row_mut(i).copy_from_slice(row);
        p.row_lower_mut()[i] = *lower;
        p.row_upper_mut()[i] = *upper;
    }
    p
}

fn solved(p: &Problem) -> Solver {
    let mut solver = Solver::new(p.n(), p.m());
    assert_eq!(solver.solve(p), Status::Optimal);
    kkt_below(p, &solver, 1e-14).unwrap();
    assert_eq!(solver.defect(), None);
    solver
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= 1e-13 * (1.0 + b.abs()), "{found:?} instead of {expected:?}");
    }
}

const INF: f64 = f64::INFINITY;
const ONE: &[f64] = &[1.0, 0.0, 0.0, 1.0];

#[test]
fn without_constraints() {
    // 2x + y = 3, x + 3y = 4.
    let solver = solved(&program(&[2.0, 1.0, 1.0, 3.0], &[-3.0, -4.0], &[]));
    assert_near(solver.x(), &[1.0, 1.0]);
    assert_eq!(solver.working_set().count(), 0);
    assert_eq!(solver.iterations(), 0);
}

#[test]
fn without_variables() {
    let mut p = Problem::new(0, 1);
    p.row_lower_mut()[0] = -1.0;
    let mut solver = Solver::new(0, 1);
    assert_eq!(solver.solve(&p), Status::Optimal);
    p.row_lower_mut()[0] = 1.0;
    assert_eq!(solver.solve(&p), Status::Infeasible);
}

#[test]
fn bounds_and_the_signs_of_their_multipliers() {
    let mut p = program(ONE, &[-3.0, 5.0], &[]);
    p.upper_mut()[0] = 1.0;
    p.lower_mut()[1] = -2.0;
    let solver = solved(&p);
    // μ = x + g.
    assert_eq!(solver.x(), [1.0, -2.0]);
    assert_near(solver.bound_multipliers(), &[-2.0, 3.0]);
    let set: Vec<Active> = solver.working_set().collect();
    assert!(set.contains(&Active { constraint: Constraint::Bound(0), side: Side::Upper }));
    assert!(set.contains(&Active { constraint: Constraint::Bound(1), side: Side::Lower }));
}

#[test]
fn fixed_variables_and_equality_rows() {
    // x + y = 2 with y = 0.5: x = 1.5; Hx + g = (1.5, 0.5) = λ (1, 1) + (0, μ).
    let mut p = program(ONE, &[0.0, 0.0], &[(&[1.0, 1.0], 2.0, 2.0)]);
    p.lower_mut()[1] = 0.5;
    p.upper_mut()[1] = 0.5;
    let solver = solved(&p);
    assert_near(solver.x(), &[1.5, 0.5]);
    assert_near(solver.row_multipliers(), &[1.5]);
    assert_near(solver.bound_multipliers(), &[0.0, -1.0]);
    assert!(solver.working_set().all(|active| active.side == Side::Equal));
}

#[test]
fn both_sides_of_a_row() {
    for (centre, x, multiplier) in [(5.0, 2.0, -3.0), (0.0, 0.0, 0.0), (-5.0, -1.0, 4.0)] {
        let solver = solved(&program(&[1.0], &[-centre], &[(&[1.0], -1.0, 2.0)]));
        assert_near(solver.x(), &[x]);
        assert_near(solver.row_multipliers(), &[multiplier]);
    }
}

#[test]
fn the_example_of_the_package_quadprog() {
    // min ½ xᵀx − 5 y under −4x − 3y >= −8, 2x + y >= 2, −2y + z >= 0; the first row is not active.
    let h = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let rows: [(&[f64], f64, f64); 3] =
        [(&[-4.0, -3.0, 0.0], -8.0, INF), (&[2.0, 1.0, 0.0], 2.0, INF), (&[0.0, -2.0, 1.0], 0.0, INF)];
    let p = program(&h, &[0.0, -5.0, 0.0], &rows);
    let solver = solved(&p);
    assert_near(solver.x(), &[10.0 / 21.0, 22.0 / 21.0, 44.0 / 21.0]);
    assert_near(solver.row_multipliers(), &[0.0, 5.0 / 21.0, 44.0 / 21.0]);
    assert!((p.objective(solver.x()) + 50.0 / 21.0).abs() < 1e-14);
}

#[test]
fn equality_rows_that_follow_from_others_have_no_multiplier() {
    let rows: [(&[f64], f64, f64); 4] =
        [(&[1.0, 1.0], 2.0, 2.0), (&[-3.0, -3.0], -6.0, -6.0), (&[0.0, 0.0], 0.0, 0.0), (&[1e-7, 1e-7], 2e-7, 2e-7)];
    let solver = solved(&program(ONE, &[0.0, 0.0], &rows));
    assert_near(solver.x(), &[1.0, 1.0]);
    assert_near(solver.row_multipliers(), &[1.0, 0.0, 0.0, 0.0]);
    assert_eq!(solver.working_set().count(), 1);
}

#[test]
fn contradictory_equality_rows() {
    let rows: [(&[f64], f64, f64); 3] = [
        (&[1.0, 1.0], 2.0, 2.0),
        (&[1.0, -1.0], 0.0, 0.0),
        // Twice the first, less the second, would be 4.
        (&[1.0, 3.0], 4.001, 4.001),
    ];
    let p = program(ONE, &[0.0, 0.0], &rows);
    let mut solver = Solver::new(2, 3);
    assert_eq!(solver.solve(&p), Status::Infeasible);
    let mut conflict: Vec<_> = solver.conflict().collect();
    conflict_proves(&p, &conflict, &[100.0, 100.0]).unwrap();
    // Two of the first (upper side), one of the second (lower side) and of the third (lower side): 0 >= 0.001.
    conflict.sort_by_key(|c| c.constraint);
    let found: Vec<_> = conflict.iter().map(|c| (c.constraint, c.side)).collect();
    let expected = [(0, Side::Upper), (1, Side::Lower), (2, Side::Lower)];
    assert_eq!(found, expected.map(|(i, side)| (Constraint::Row(i), side)));
    assert_near(&conflict.iter().map(|c| c.weight).collect::<Vec<_>>(), &[1.0, 0.5, 0.5]);
}

#[test]
fn equality_rows_may_disagree_by_rounding_errors() {
    for (error, expected) in [(1e-12, Status::Optimal), (5e-10, Status::Optimal), (2e-9, Status::Infeasible)] {
        let second = 4.0 * (1.0 + error);
        let rows: [(&[f64], f64, f64); 2] = [(&[1.0, 1.0], 2.0, 2.0), (&[2.0, 2.0], second, second)];
        let p = program(ONE, &[0.0, 0.0], &rows);
        assert_eq!(Solver::new(2, 2).solve(&p), expected, "{error:e}");
    }
}

/// Rows that differ by ε = 1e-13 in one entry meet far away, at y = 2 − x = ±1e6: a contradiction only where bounds keep them nearer.
#[test]
fn nearly_equal_rows_contradict_each_other_where_a_bound_says_so() {
    let (epsilon, far) = (1e-13, 1e6);
    for away in [1.0, -1.0] {
        for first_row in [[1.0, 1.0], [-1.0, -1.0]] {
            let second: &[f64] = &[1.0, 1.0 + epsilon];
            let rows: [(&[f64], f64, f64); 2] = [
                (&first_row, 2.0 * first_row[0], 2.0 * first_row[0]),
                (second, 2.0 + away * far * epsilon, 2.0 + away * far * epsilon),
            ];
            let mut p = program(ONE, &[0.0, 0.0], &rows);
            // What lies on the other side of zero decides nothing.
            for (near_side, far_side) in [(1e4, 1.05e6), (INF, 0.6e6), (1e4, INF), (1e8, 1e4)] {
                let [lower, upper] = if away > 0.0 { [-near_side, far_side] } else { [-far_side, near_side] };
                p.lower_mut().copy_from_slice(&[2.0 - upper, lower]);
                p.upper_mut().copy_from_slice(&[2.0 - lower, upper]);
                let mut solver = Solver::new(2, 2);
                let infeasible = solver.solve(&p) == Status::Infeasible;
                assert_eq!(infeasible, far_side < far, "{away} {first_row:?} y in {lower} to {upper}");
            }
        }
    }
}

/// Squares of such entries underflow or overflow.
#[test]
fn rows_may_be_of_any_size() {
    // x + 2 y >= 5 from the origin: (1, 2), multiplier 1.
    for size in [1e-250, 1e-180, 1.0, 1e180, 1e250] {
        for (upper, offset) in [(INF, 0.0), (5.0 * size, 0.0), (INF, 1.0)] {
            let row: &[f64] = &[size, 2.0 * size];
            // A gradient that brings the optimum without the row elsewhere on the line through the origin.
            let p = program(ONE, &[-offset * 0.5, -offset], &[(row, 5.0 * size, upper)]);
            let mut solver = Solver::new(2, 1);
            assert_eq!(solver.solve(&p), Status::Optimal, "{size:e}");
            assert_near(solver.x(), &[1.0, 2.0]);
            assert_near(&[solver.row_multipliers()[0] * size], &[1.0 - 0.5 * offset]);
        }
    }
}

#[test]
fn a_zero_row_is_true_or_false() {
    let zero: &[f64] = &[0.0, 0.0];
    solved(&program(ONE, &[1.0, 1.0], &[(zero, -1.0, 0.0)]));
    let p = program(ONE, &[1.0, 1.0], &[(zero, -INF, -0.5)]);
    let mut solver = Solver::new(2, 1);
    assert_eq!(solver.solve(&p), Status::Infeasible);
    let conflict: Vec<_> = solver.conflict().collect();
    assert_eq!((conflict[0].constraint, conflict[0].side), (Constraint::Row(0), Side::Upper));
    conflict_proves(&p, &conflict, &[1e9, 1e9]).unwrap();
}

#[test]
fn a_conflict_names_who_takes_part_and_nobody_else() {
    // x + y >= 3 against x <= 1 and y <= 1, with a row that has nothing to do with it.
    let mut p = program(ONE, &[-9.0, 0.0], &[(&[1.0, 0.0], -5.0, 5.0), (&[2.0, 2.0], 6.0, INF)]);
    p.upper_mut().fill(1.0);
    let mut solver = Solver::new(2, 2);
    assert_eq!(solver.solve(&p), Status::Infeasible);
    let mut conflict: Vec<_> = solver.conflict().collect();
    conflict.sort_by_key(|c| c.constraint);
    let names: Vec<_> = conflict.iter().map(|c| c.constraint).collect();
    assert_eq!(names, [Constraint::Row(1), Constraint::Bound(0), Constraint::Bound(1)]);
    assert_near(&conflict.iter().map(|c| c.weight).collect::<Vec<_>>(), &[0.5, 1.0, 1.0]);
    // Its solver is as good as new.
    p.row_lower_mut()[1] = 3.0;
    assert_eq!(solver.solve(&p), Status::Optimal);
    assert_eq!(solver.conflict().count(), 0);
    kkt_below(&p, &solver, 1e-14).unwrap();
}

#[test]
fn a_semidefinite_hessian_that_an_equality_row_makes_definite() {
    // ½ x² with y = 3 x − 6, y without cost: at x >= 1 the optimum is x = 1, y = −3.
    let mut p = program(&[1.0, 0.0, 0.0, 0.0], &[0.0, 0.0], &[(&[3.0, -1.0], 6.0, 6.0)]);
    p.lower_mut()[0] = 1.0;
    let solver = solved(&p);
    assert!(solver.convexified());
    assert_near(solver.x(), &[1.0, -3.0]);
    // Hx + g = (1, 0) = λ (3, −1) + μ.
    assert_near(solver.row_multipliers(), &[0.0]);
    assert_near(solver.bound_multipliers(), &[1.0, 0.0]);
    // Now y <= −4 holds as well: x = 2/3 contradicts, so y alone.
    p.lower_mut()[0] = -INF;
    p.upper_mut()[1] = -4.5;
    p.lower_mut()[1] = -5.0;
    let solver = solved(&p);
    // (0.5, 0) = λ (3, −1) + (0, μ): λ = 1/6, μ = 1/6.
    p.lower_mut()[1] = -4.5;
    assert_near(solver.x(), &[1.0 / 3.0, -5.0]);
    let fixed = solved(&p);
    assert_near(fixed.x(), &[0.5, -4.5]);
    assert_near(fixed.row_multipliers(), &[1.0 / 6.0]);
    assert_near(fixed.bound_multipliers(), &[0.0, 1.0 / 6.0]);
}

#[test]
fn a_variable_that_a_row_defines() {
    // ½ x² + ½ t with t = 3x − 6: x = −1.5 were it not for t >= −4, which is x = 2/3.
    let mut p = program(&[1.0, 0.0, 0.0, 0.0], &[0.0, 0.5], &[(&[3.0, -1.0], 6.0, 6.0)]);
    p.lower_mut()[1] = -4.0;
    p.upper_mut()[1] = 10.0;
    let mut solver = solved(&p);
    assert!(solver.convexified());
    assert_near(solver.x(), &[2.0 / 3.0, -4.0]);
    // Hx + g = (2/3, 1/2) = λ (3, −1) + (0, μ).
    assert_near(solver.row_multipliers(), &[2.0 / 9.0]);
    assert_near(solver.bound_multipliers(), &[0.0, 13.0 / 18.0]);
    let set: Vec<Active> = solver.working_set().collect();
    let expected = [(Constraint::Row(0), Side::Equal), (Constraint::Bound(1), Side::Lower)];
    assert_eq!(set, expected.map(|(constraint, side)| Active { constraint, side }));
    solver.forget();
    solver.start_from(set);
    assert_eq!(solver.solve(&p), Status::Optimal);
    assert_eq!(solver.iterations(), 0);
    // The other side, and none.
    p.gradient_mut()[1] = -9.0;
    let solver = solved(&p);
    assert_near(solver.x(), &[16.0 / 3.0, 10.0]);
    p.gradient_mut()[1] = -1.0;
    let solver = solved(&p);
    assert_near(solver.x(), &[3.0, 3.0]);
    assert_near(solver.row_multipliers(), &[1.0]);
    // A t beyond all numbers.
    let mut wild = program(&[1.0, 0.0, 0.0, 0.0], &[0.0, 0.0], &[(&[3.0, 1e-300], 1e200, 1e200)]);
    wild.upper_mut()[0] = 1.0;
    let mut solver = Solver::new(2, 1);
    assert_eq!(solver.solve(&wild), Status::InvalidInput);
    assert_eq!((solver.defect(), solver.working_set().count()), (Some(Defect::Overflow), 0));
    // x >= 5.5 asks for t >= 10.5.
    p.lower_mut()[0] = 5.5;
    let mut solver = Solver::new(2, 1);
    assert_eq!(solver.solve(&p), Status::Infeasible);
    let mut conflict: Vec<_> = solver.conflict().collect();
    conflict_proves(&p, &conflict, &[100.0, 100.0]).unwrap();
    conflict.sort_by_key(|c| c.constraint);
    let found: Vec<_> = conflict.iter().map(|c| (c.constraint, c.side)).collect();
    let expected =
        [(Constraint::Row(0), Side::Upper), (Constraint::Bound(0), Side::Lower), (Constraint::Bound(1), Side::Upper)];
    assert_eq!(found, expected);
    assert_near(&conflict.iter().map(|c| c.weight).collect::<Vec<_>>(), &[1.0 / 3.0, 1.0, 1.0 / 3.0]);
}

#[test]
fn not_convex() {
    let mut solver = Solver::new(2, 0);
    for h in [[1.0, 0.0, 0.0, -1.0], [1.0, 0.0, 0.0, 0.0], [1.0, 2.0, 2.0, 1.0]] {
        assert_eq!(solver.solve(&program(&h, &[1.0, 1.0], &[])), Status::NotConvex);
    }
    // An inequality does not help, nor an equality of something else.
    let mut p = program(&[1.0, 0.0, 0.0, 0.0], &[0.0, 1.0], &[(&[1.0, 0.0], 1.0, 1.0)]);
    p.lower_mut()[1] = 0.0;
    assert_eq!(Solver::new(2, 1).solve(&p), Status::NotConvex);
    p.upper_mut()[1] = 0.0;
    assert_eq!(Solver::new(2, 1).solve(&p), Status::Optimal);
}

#[test]
fn the_iteration_limit_leaves_the_optimum_of_the_working_set() {
    let mut p = program(ONE, &[-4.0, -6.0], &[(&[1.0, 1.0], -INF, 3.0)]);
    p.upper_mut()[0] = 0.25;
    let settings = Settings { max_iterations: 1, ..Settings::default() };
    let mut solver = Solver::with_settings(2, 1, settings);
    assert_eq!(solver.solve(&p), Status::IterationLimit);
    assert_eq!(solver.iterations(), 1);
    let residuals = p.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
    assert!(residuals.stationarity.relative < 1e-14 && residuals.complementarity.relative < 1e-14);
    assert!(residuals.dual.relative < 1e-14 && residuals.primal.relative > 0.1, "{residuals:?}");
    let optimum = solved(&p);
    assert_near(optimum.x(), &[0.25, 2.75]);
    assert_near(optimum.row_multipliers(), &[-3.25]);
    assert_near(optimum.bound_multipliers(), &[-0.5, 0.0]);
    assert_eq!(optimum.iterations(), 2);
    assert!(p.objective(solver.x()) < p.objective(optimum.x()));
    // The next solve goes on from there.
    assert_eq!(solver.solve(&p), Status::Optimal);
    assert_near(solver.x(), optimum.x());
}

#[test]
fn invalid_input_says_where() {
    let good = || {
        let mut p = program(ONE, &[0.0, 0.0], &[(&[1.0, 1.0], 0.0, 1.0)]);
        p.lower_mut()[1] = -1.0;
        p
    };
    let mut solver = Solver::new(2, 1);
    let mut said = Vec::new();
    let mut defect = |change: &dyn Fn(&mut Problem)| {
        let mut p = good();
        change(&mut p);
        assert_eq!(solver.solve(&p), Status::InvalidInput);
        let defect = solver.defect().unwrap();
        said.push(defect.to_string());
        assert_eq!(solver.solve(&good()), Status::Optimal);
        assert_eq!(solver.defect(), None);
        defect
    };
    let nan = f64::NAN;
    assert_eq!(defect(&|p| p.hessian_mut()[2] = nan), Defect::Hessian { row: 1, column: 0 });
    assert_eq!(defect(&|p| p.hessian_mut()[1] = 0.1), Defect::Asymmetric { row: 1, column: 0 });
    assert_eq!(defect(&|p| p.gradient_mut()[1] = INF), Defect::Gradient { index: 1 });
    assert_eq!(defect(&|p| p.row_mut(0)[1] = nan), Defect::Row { row: 0, column: 1 });
    assert_eq!(defect(&|p| p.row_lower_mut()[0] = nan), Defect::Bound(Constraint::Row(0)));
    assert_eq!(defect(&|p| p.upper_mut()[1] = nan), Defect::Bound(Constraint::Bound(1)));
    assert_eq!(defect(&|p| p.lower_mut()[0] = INF), Defect::Bound(Constraint::Bound(0)));
    assert_eq!(defect(&|p| p.row_upper_mut()[0] = -INF), Defect::Bound(Constraint::Row(0)));
    assert_eq!(defect(&|p| p.row_upper_mut()[0] = -0.1), Defect::Crossed(Constraint::Row(0)));
    assert_eq!(defect(&|p| p.upper_mut()[1] = -1.5), Defect::Crossed(Constraint::Bound(1)));
    let tiny_and_huge = |p: &mut Problem, h, g| {
        p.hessian_mut()[0] = h;
        p.gradient_mut()[0] = g;
    };
    let row_of_infinities = |p: &mut Problem| {
        p.hessian_mut()[0] = 1e-30;
        p.row_mut(0)[0] = 1e300;
    };
    // In the scaled program, and in its solution.
    assert_eq!(defect(&|p| row_of_infinities(p)), Defect::Overflow);
    assert_eq!(defect(&|p| tiny_and_huge(p, 1e-30, 1e300)), Defect::Overflow);
    assert_eq!(defect(&|p| tiny_and_huge(p, 1e-200, 1e200)), Defect::Overflow);
    said.dedup();
    let expected = [
        "entry (1, 0) of the Hessian is not a finite number",
        "entries (1, 0) and (0, 1) of the Hessian differ",
        "entry 1 of the gradient is not a finite number",
        "entry 1 of row 0 is not a finite number",
        "row 0: NaN, or an infinity of the wrong sign",
        "bounds of variable 1: NaN, or an infinity of the wrong sign",
        "bounds of variable 0: NaN, or an infinity of the wrong sign",
        "row 0: NaN, or an infinity of the wrong sign",
        "row 0: the lower bound is above the upper one",
        "bounds of variable 1: the lower bound is above the upper one",
        "the numbers are so large that their products overflow",
    ];
    assert_eq!(said, expected);
    let size = Defect::WrongSize { expected: (2, 1), found: (3, 1) };
    assert_eq!(solver.solve(&Problem::new(3, 1)), Status::InvalidInput);
    assert_eq!(solver.defect(), Some(size));
    assert_eq!(size.to_string(), "the solver was made for 2 variables and 1 rows, the problem has 3 and 1");
}

#[test]
fn triangles_may_differ_by_rounding_errors_of_their_diagonals() {
    for (size, error, expected) in [
        (1.0, 9e-9, Status::Optimal),
        (1.0, 1.1e-8, Status::InvalidInput),
        (100.0, 9e-7, Status::Optimal),
        (100.0, 1.1e-6, Status::InvalidInput),
        (0.01, 1.1e-10, Status::InvalidInput),
    ] {
        let p = program(&[size, 0.0, error, size], &[-size, -size], &[]);
        let mut solver = Solver::new(2, 0);
        assert_eq!(solver.solve(&p), expected, "{error} of {size}");
        if expected == Status::Optimal {
            // The mean of both triangles.
            let x = 1.0 / (1.0 + 0.5 * error / size);
            assert_near(solver.x(), &[x, x]);
        }
    }
}

#[test]
fn nothing_changes_with_the_units() {
    // Powers of ten, so that rounding differs; in the units of the first program the answer is the same.
    let rows: [(&[f64], f64, f64); 2] = [(&[1.0, 1.0], -INF, 1.0), (&[1.0, -2.0], 0.5, 4.0)];
    let reference = solved(&program(&[2.0, 0.5, 0.5, 1.0], &[-3.0, -2.0], &rows));
    let (s, row, objective) = ([1e-3, 1e4], [1e5, 1e-6], 1e-4);
    let mut p = program(
        &[2.0 / (s[0] * s[0]), 0.5 / (s[0] * s[1]), 0.5 / (s[0] * s[1]), 1.0 / (s[1] * s[1])],
        &[-3.0 / s[0], -2.0 / s[1]],
        &[
            (&[row[0] / s[0], row[0] / s[1]], -INF, row[0]),
            (&[row[1] / s[0], -2.0 * row[1] / s[1]], 0.5 * row[1], 4.0 * row[1]),
        ],
    );
    p.hessian_mut().iter_mut().for_each(|h| *h *= objective);
    p.gradient_mut().iter_mut().for_each(|g| *g *= objective);
    let solver = solved(&p);
    assert_near(&[solver.x()[0] / s[0], solver.x()[1] / s[1]], reference.x());
    let multipliers: Vec<f64> = (0..2).map(|i| solver.row_multipliers()[i] * row[i] / objective).collect();
    assert_near(&multipliers, reference.row_multipliers());
    assert_eq!(solver.iterations(), reference.iterations());
}

#[test]
fn forgetting_is_being_new() {
    let mut p = program(ONE, &[-4.0, -6.0], &[(&[1.0, 1.0], -INF, 3.0)]);
    p.upper_mut()[0] = 1.0;
    let mut solver = solved(&p);
    let cold = (solver.iterations(), solver.x().to_vec());
    assert_eq!(solver.solve(&p), Status::Optimal);
    assert_eq!(solver.iterations(), 0);
    solver.forget();
    assert_eq!(solver.solve(&p), Status::Optimal);
    assert_eq!((solver.iterations(), solver.x().to_vec()), cold);
}

#[test]
fn resetting_a_problem_makes_it_new() {
    let mut p = program(ONE, &[-4.0, -6.0], &[(&[1.0, 1.0], 1.0, 3.0)]);
    p.lower_mut()[1] = 0.0;
    p.upper_mut()[0] = 0.0;
    p.reset();
    let new = Problem::new(2, 1);
    assert_eq!(format!("{p:?}"), format!("{new:?}"));
}

/// Found by search: all rows pass through the solution, which is zero, so that every violation is one of rounding errors.
/// Without the guard against steps that make no progress the working sets repeat until the iteration limit.
#[test]
fn rounding_errors_at_a_degenerate_zero_do_not_cycle() {
    let h = [
        [6.0, -1.0, 3.0, 1.0, 1.0],
        [-1.0, 4.0, -2.0, -3.0, 1.0],
        [3.0, -2.0, 4.0, 2.0, 1.0],
        [1.0, -3.0, 2.0, 4.0, -1.0],
        [1.0, 1.0, 1.0, -1.0, 4.0],
    ];
    let rows: [(&[f64], f64, f64); 8] = [
        (&[1.0, 1.0, -1.0, 1.0, -1.0], 0.0, INF),
        (&[0.0, 1.0, -1.0, 0.0, -1.0], 0.0, INF),
        (&[1.0, 0.0, -1.0, 0.0, 0.0], -1.0, INF),
        (&[-1.0, 1.0, -1.0, -1.0, 0.0], 0.0, INF),
        (&[0.0, 1.0, 1.0, 1.0, -1.0], 0.0, INF),
        (&[1.0, 0.0, 0.0, 0.0, -1.0], 0.0, INF),
        (&[0.0, 1.0, 0.0, 0.0, 0.0], 0.0, 0.0),
        (&[-1.0, 1.0, 0.0, 0.0, -1.0], 0.0, INF),
    ];
    let mut p = program(h.as_flattened(), &[-1.0, -3.0, 3.0, -1.0, 0.0], &rows);
    p.lower_mut().copy_from_slice(&[-1.0, -1.0, 0.0, 0.0, -2.0]);
    p.upper_mut()[1] = 0.0;
    let mut solver = Solver::new(5, 8);
    assert_eq!(solver.solve(&p), Status::Optimal);
    assert!(solver.iterations() < 60, "{}", solver.iterations());
    kkt_below(&p, &solver, 1e-12).unwrap();
}

#[test]
fn kkt_residuals_see_each_kind_of_error() {
    let mut p = program(ONE, &[-4.0, -6.0], &[(&[1.0, 1.0], -INF, 3.0)]);
    p.upper_mut()[0] = 1.0;
    // x = (1, 2), λ = −4, μ = (1 − 4 + 4, 0) = (1, 0): of the wrong sign, so the bound is not active: x = (0.5, 2.5).
    let (x, row, bound) = ([0.5, 2.5], [-3.5], [0.0, 0.0]);
    assert!(p.kkt(&x, &row, &bound).worst_relative() < 1e-15);
    let wrong = p.kkt(&[0.5, 2.6], &row, &bound);
    assert!((wrong.stationarity.absolute - 0.1).abs() < 1e-12 && wrong.stationarity.relative > 1e-3);
    assert!((wrong.primal.absolute - 0.1).abs() < 1e-12 && wrong.primal.relative > 1e-3);
    let wrong = p.kkt(&x, &row, &[-0.1, 0.0]);
    assert!((wrong.complementarity.absolute - 0.05).abs() < 1e-12);
    let wrong = p.kkt(&x, &[3.5], &bound);
    assert!((wrong.dual.absolute - 3.5).abs() < 1e-12 && wrong.dual.relative > 0.1);
    let wrong = p.kkt(&[1.5, 1.5], &row, &bound);
    assert!((wrong.primal.absolute - 0.5).abs() < 1e-12);
    for wrong in [p.kkt(&[f64::NAN, 0.0], &row, &bound), p.kkt(&x, &[f64::NAN], &bound)] {
        assert!(wrong.worst_relative() > 1e300);
    }
}

/// The unit of a variable without a cost is that of the equality row, whatever an inequality would say.
#[test]
fn relative_residuals_have_the_units_of_costs_and_equality_rows() {
    // Units 1/√4 of x, and (2 · ½) / 16 of y.
    let (x, y) = (1.0, -1e-6);
    let value = 2.0 * x + 16.0 * y;
    let rows: [(&[f64], f64, f64); 2] = [(&[2.0, 16.0], value, value), (&[1.0, 64.0], -9.0, 9.0)];
    let mut p = program(&[4.0, 0.0, 0.0, 0.0], &[0.0, 0.0], &rows);
    p.lower_mut()[1] = 0.0;
    // The violation 1e-6 of y >= 0 is held against 1e-4 of the largest |x| / u, which is 2, in the unit of y.
    let found = p.kkt(&[x, y], &[0.0, 0.0], &[0.0, 0.0]).primal;
    assert_eq!(found.absolute, 1e-6);
    assert!((found.relative - 1e-6 / (1e-4 * 2.0 / 16.0)).abs() < 1e-12, "{found:?}");
}

fn assert_residual(found: legwork_qp::Residual, absolute: f64, relative: f64) {
    assert_near(&[found.absolute, found.relative], &[absolute, relative]);
}

/// Of a point with multipliers that miss each condition, every sum written out.
#[test]
fn relative_residuals_are_held_against_the_sums_of_all_terms() {
    let mut p = program(&[4.0, 1.0, 1.0, 1.0], &[-4.0, -6.0], &[(&[1.0, 2.0], -INF, 3.0)]);
    (p.upper_mut()[0], p.lower_mut()[1]) = (1.0, -5.0);
    // The units of the variables are 1/2 and 1.
    let found = p.kkt(&[0.5, 2.5], &[-3.5], &[-0.5, 0.25]);
    // 2 + 2.5 − 4 + 0.5 + 3.5 = 4.5 and 0.5 + 2.5 − 6 − 0.25 + 7 = 3.75, of terms of 12.5 and 16.25 in all.
    assert_residual(found.stationarity, 4.5, 4.5 / 12.5);
    // 0.5 + 5 is above 3.
    assert_residual(found.primal, 2.5, 2.5 / (3.0 + 5.5));
    assert_residual(found.dual, 0.0, 0.0);
    // The objective's terms are 0.5 (2 + 2.5 + 4) and 2.5 (0.5 + 2.5 + 6); those of the three multipliers follow.
    let objective = 4.25 + 22.5;
    let terms = objective + 3.5 * (3.0 + 5.5) + 0.5 * (1.0 + 0.5) + 0.25 * (5.0 + 2.5);
    assert_residual(found.complementarity, 3.5 * 2.5, 3.5 * 2.5 / terms);

    // Signs of sides that are infinite: of the row, whose largest term is 2 · 1, and of the second variable.
    let found = p.kkt(&[0.5, 2.5], &[3.5], &[-0.5, -0.25]);
    assert_residual(found.dual, 3.5, 3.5 / (16.25 / 2.0));
    assert_residual(found.complementarity, 0.5 * 0.5, 0.25 / (objective + 0.75));
    let found = p.kkt(&[0.5, 2.5], &[0.0], &[0.125, 0.0]);
    // Without the row's terms: 2 + 2.5 + 4 + 0.125 half as much, and 0.5 + 2.5 + 6.
    assert_residual(found.dual, 0.125, 0.125 / (9.0 / 0.5));
}

/// Where all terms nearly vanish residuals are held against 1e-4 of the largest ones, in the units of the variables.
#[test]
fn relative_residuals_of_terms_that_vanish_are_held_against_the_largest() {
    let mut p = program(&[4.0, 0.0, 0.0, 1.0], &[1e-6, -2.5], &[]);
    // The second component is 2.5 − 2.5, of terms of 5; the unit of the first variable is 1/2.
    assert_residual(p.kkt(&[0.0, 2.5], &[], &[0.0, 0.0]).stationarity, 1e-6, 1e-6 / (1e-4 * 5.0 / 0.5));
    p.lower_mut()[0] = -1e-9;
    // The objective vanishes; the largest |x| / u or |g| u is 2.5.
    let found = p.kkt(&[0.0, 0.0], &[], &[1.0, 0.0]).complementarity;
    assert_residual(found, 1e-9, 1e-9 / (1e-4 * 2.5 * 2.5));
}
