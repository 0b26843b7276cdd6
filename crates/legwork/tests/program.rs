//! The quadratic program: Appendix B to the letter, and both forms with the same optimum, also by another solver.

mod common;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use legwork::Robot;
use legwork::contact::Surface;
use legwork::contract::Sensed;
use legwork::control::{Controller, Fallback};
use legwork::feet::{FeetMotion, Footing};
use legwork::momentum::tasks::Aim;
use legwork::momentum::{self, Condition, Inputs, Layout, LimitKind, Relaxation, Solution};
use legwork::scenario::{JointLimits, QpForm, Scenario, Tracking};
use legwork::{library, scenario_file};
use legwork_qp::{Constraint, Problem, Solver, Status};
use legwork_rbd::Dynamics;

/// A controller's inputs in a state of a run, so that either form can be built from them.
struct State {
    scenario: Scenario,
    model: Robot,
    aims: Vec<Aim>,
    feet: FeetMotion,
    ground: Vec<Surface>,
    dynamics: Dynamics,
    estimate: Sensed,
    stance: Vec<bool>,
}

impl State {
    fn layout(&self, form: QpForm) -> Layout {
        Layout::new(form, &self.scenario.controller, &self.model)
    }

    fn build(&self, layout: &Layout, change: impl FnOnce(&mut Scenario)) -> Problem {
        let mut scenario = self.scenario.clone();
        change(&mut scenario);
        let mut problem = Problem::new(layout.variables(), layout.rows());
        momentum::build(layout, &self.inputs(&scenario), &mut problem);
        problem
    }

    fn inputs<'a>(&'a self, scenario: &'a Scenario) -> Inputs<'a> {
        Inputs {
            model: &self.model,
            dynamics: &self.dynamics,
            feet: &self.feet,
            q: &self.estimate.q,
            v: &self.estimate.v,
            aims: &self.aims,
            stance: &self.stance,
            footing: &[Footing::Stands; 2],
            max_load: &[f64::INFINITY; 2],
            ground: &self.ground,
            weights: &scenario.controller.weights,
            limits: &scenario.controller.limits,
            torque_before: None,
            period: 0.001,
            relaxed: Relaxation::default(),
        }
    }

    fn solve(&self, form: QpForm, change: impl Fn(&mut Scenario)) -> (Status, Solution, Problem, Solver) {
        let mut scenario = self.scenario.clone();
        change(&mut scenario);
        let layout = Layout::new(form, &scenario.controller, &self.model);
        let problem = self.build(&layout, &change);
        let mut solver = Solver::new(layout.variables(), layout.rows());
        let status = solver.solve(&problem);
        let mut solution = Solution::new(&layout);
        momentum::read_solution(&layout, &self.inputs(&scenario), solver.x(), &mut solution);
        (status, solution, problem, solver)
    }
}

/// States along the walk or the push: double support, swing, touchdown, saturation, the push itself.
fn states(name: &str, every: usize) -> Vec<State> {
    let loaded = scenario_file::load(name, &["duration_s=2".to_owned()]).expect("a built-in scenario");
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    let run = common::run(name, &["duration_s=2"]);
    let mut controller = loaded.scenario.momentum_controller(&model, &[], &run.log.truth(0)).expect("the model fits");
    let mut dynamics = Dynamics::new(&model);
    let mut found = Vec::new();
    for i in 0..run.log.len() {
        let estimate = run.log.truth(i);
        dynamics.update(&model, &estimate.q, &estimate.v);
        controller.tick(&estimate, &dynamics);
        if i % every == 0 {
            let swinging = controller.reference().and_then(|reference| reference.swing).map(|swing| swing.foot);
            let touching = |foot: usize| estimate.contacts[foot].touching;
            let stance = (0..2).map(|foot| touching(foot) && Some(foot) != swinging).collect();
            found.push(State {
                scenario: loaded.scenario.clone(),
                model: model.clone(),
                aims: controller.planner().aims().to_vec(),
                feet: controller.feet().clone(),
                ground: controller.ground().to_vec(),
                dynamics: dynamics.clone(),
                estimate,
                stance,
            });
        }
    }
    found
}

/// Thesis (B.1)-(B.10), written out a second time from the dynamics, for the planar humanoid.
#[test]
fn the_slack_form_is_appendix_b() {
    for state in states("walk", 97) {
        let layout = state.layout(QpForm::Slack);
        let problem = state.build(&layout, |_| {});
        let dynamics = &state.dynamics;
        let goal = |task: &str| {
            let aim = state.aims.iter().find(|aim| aim.law.name() == task).expect("a task");
            nalgebra::DVector::from_column_slice(&aim.goal)
        };

        // (B.1), (B.2): 7 + 4 + 4 + 3 + 4 + 1 = 23 variables.
        assert_eq!(layout.variables(), 23);
        assert_eq!(
            [&layout.qdd, &layout.rho, &layout.tau, &layout.slack].map(Clone::clone),
            [0..7, 7..11, 11..15, 15..23]
        );
        let tasks = layout.tasks().iter().map(|task| (task.name, task.variables.clone(), task.constraints.clone()));
        assert_eq!(
            tasks.collect::<Vec<_>>(),
            [("momentum", 15..18, 7..10), ("feet", 18..22, 10..14), ("torso", 22..23, 14..15)]
        );
        // (B.9): 7 + 3 + 4 + 1 + 4 = 19 equality rows; (B.7): 6 inequality rows.
        assert_eq!(layout.rows(), 25);
        let mut a_eq = nalgebra::DMatrix::<f64>::zeros(19, 23);
        let mut b_eq = nalgebra::DVector::<f64>::zeros(19);
        a_eq.view_mut((0, 0), (7, 7)).copy_from(&dynamics.mass_matrix);
        a_eq.view_mut((0, 7), (7, 4)).copy_from(&-dynamics.contact_jacobian.transpose());
        a_eq.view_mut((3, 11), (4, 4)).copy_from(&-nalgebra::Matrix4::identity());
        a_eq.view_mut((7, 0), (3, 7)).copy_from(&dynamics.momentum_matrix);
        a_eq.view_mut((7, 15), (3, 3)).fill_diagonal(1.0);
        a_eq.view_mut((10, 0), (4, 7)).copy_from(&dynamics.contact_jacobian);
        a_eq.view_mut((10, 18), (4, 4)).fill_diagonal(1.0);
        a_eq.view_mut((14, 0), (1, 7))
            .copy_from(&nalgebra::RowDVector::from_row_slice(&[0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0]));
        a_eq[(14, 22)] = 1.0;
        for foot in 0..2 {
            for k in 0..2 {
                a_eq[(15 + 2 * foot + k, 7 + 2 * foot + k)] = if state.stance[foot] { 0.0 } else { 1.0 };
            }
        }
        b_eq.rows_mut(0, 7).copy_from(&-(&dynamics.bias + &dynamics.damping));
        b_eq.rows_mut(7, 3).copy_from(&(goal("momentum") - &dynamics.momentum_bias));
        b_eq.rows_mut(10, 4).copy_from(&(goal("feet") - &dynamics.contact_bias));
        b_eq[14] = goal("torso")[0];
        for row in 0..19 {
            for column in 0..23 {
                let (found, expected) = (problem.row(row)[column], a_eq[(row, column)]);
                assert!((found - expected).abs() < 1e-12, "A_eq({row}, {column}) = {found}, not {expected}");
            }
            assert!((problem.row_lower()[row] - b_eq[row]).abs() < 1e-9, "b_eq({row})");
            assert_eq!(problem.row_lower()[row].to_bits(), problem.row_upper()[row].to_bits());
        }
        // (4.31) on level ground: P_n = (0, 1), P_t = (1, 0), a foot after the other.
        let mu = state.scenario.ground.friction;
        let cone = [[0.0, -1.0], [1.0, -mu], [-1.0, -mu]];
        for row in 0..6 {
            for column in 0..23_usize {
                let foot = row / 3;
                let expected = column.checked_sub(7 + 2 * foot).filter(|k| *k < 2).map_or(0.0, |k| cone[row % 3][k]);
                assert!((problem.row(19 + row)[column] - expected).abs() < 1e-15, "A_ineq({row}, {column})");
            }
            assert_eq!(problem.row_upper()[19 + row], 0.0);
            assert_eq!(problem.row_lower()[19 + row], f64::NEG_INFINITY);
        }
        // (B.5), with the factor 2 of (B.3).
        let weights = &state.scenario.controller.weights;
        let blocks = [
            (0..7, weights.joint_acceleration),
            (7..11, weights.grf),
            (11..15, weights.torque),
            (15..18, weights.momentum),
            (18..22, weights.feet),
            (22..23, weights.torso),
        ];
        for (range, weight) in blocks {
            for i in range {
                for j in 0..23 {
                    let expected = if i == j { 2.0 * weight } else { 0.0 };
                    assert_eq!(problem.hessian()[23 * i + j], expected, "H({i}, {j})");
                }
            }
        }
        assert!(problem.gradient().iter().all(|&value| value == 0.0));
    }
}

#[test]
fn tasks_weigh_what_the_settings_say() {
    let state = states("walk", 700).remove(1);
    let layout = state.layout(QpForm::Slack);
    let set = |scenario: &mut Scenario| {
        let weights = &mut scenario.controller.weights;
        (weights.momentum, weights.torso) = (5.0, 7.0);
        (weights.angular_momentum_factor, weights.vertical_momentum_factor) = (0.5, 3.0);
        weights.torso_urgency_s4 = 0.2;
    };
    let problem = state.build(&layout, set);
    let diagonal = |j: usize| problem.hessian()[24 * j];
    assert_eq!([diagonal(15), diagonal(16), diagonal(17)], [2.0 * 0.5 * 5.0, 2.0 * 5.0, 2.0 * 3.0 * 5.0]);
    let torso = &state.aims.iter().find(|aim| aim.law.name() == "torso").expect("a task").goal;
    assert!(torso[0].abs() > 0.1, "{torso:?}");
    let expected = 2.0 * 7.0 * (1.0 + (0.2 * torso[0] * torso[0]).powi(2));
    assert!((diagonal(22) - expected).abs() < 1e-12 * expected, "{} {expected}", diagonal(22));
}

fn close(what: &str, a: &[f64], b: &[f64], scale: f64, tolerance: f64) {
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        assert!((x - y).abs() <= tolerance * scale, "{what}[{i}]: {x} against {y}");
    }
}

#[test]
fn both_forms_have_the_same_optimum() {
    let mut compared = 0;
    for name in ["walk", "push"] {
        for state in states(name, 7) {
            for torque_weight in [0.0, 1e-3] {
                let set = |scenario: &mut Scenario| scenario.controller.weights.torque = torque_weight;
                let (status_direct, direct, problem, solver) = state.solve(QpForm::Direct, set);
                let (status_slack, slack, ..) = state.solve(QpForm::Slack, set);
                assert_eq!((status_direct, status_slack), (Status::Optimal, Status::Optimal));
                let time = state.estimate.time;
                close(&format!("{name} {time} q̈"), &direct.qdd, &slack.qdd, 1000.0, 1e-8);
                close(&format!("{name} {time} ρ"), &direct.rho, &slack.rho, 1000.0, 1e-7);
                close(&format!("{name} {time} τ"), &direct.tau, &slack.tau, 220.0, 1e-7);
                close(&format!("{name} {time} s"), &direct.slack, &slack.slack, 1000.0, 1e-7);
                let kkt = problem.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
                assert!(kkt.worst_relative() < 1e-9, "{name} {time}: {kkt:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 1000, "{compared} programs");
}

/// Clarabel's optimum with tight tolerances.
fn clarabel(problem: &Problem) -> (SolverStatus, Vec<f64>, f64) {
    let (n, m) = (problem.n(), problem.m());
    let dense = |rows: &[Vec<f64>]| CscMatrix::from(rows);
    // In units that give the Hessian a diagonal of ones: an interior point is too inaccurate in the forces otherwise.
    let unit: Vec<f64> = (0..n).map(|i| 1.0 / problem.hessian()[i * n + i].sqrt()).collect();
    let mut p = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in i..n {
            p[i][j] = problem.hessian()[i * n + j] * unit[i] * unit[j];
        }
    }
    let gradient: Vec<f64> = (0..n).map(|i| problem.gradient()[i] * unit[i]).collect();
    let (mut rows, mut bounds, mut cones) = (Vec::new(), Vec::new(), Vec::new());
    let single = |i: usize| (0..n).map(|j| if i == j { unit[i] } else { 0.0 }).collect::<Vec<_>>();
    let scaled = |row: &[f64]| row.iter().zip(&unit).map(|(value, unit)| value * unit).collect::<Vec<_>>();
    let all = (0..m)
        .map(|i| (scaled(problem.row(i)), problem.row_lower()[i], problem.row_upper()[i]))
        .chain((0..n).map(|i| (single(i), problem.lower()[i], problem.upper()[i])));
    let all: Vec<_> = all.collect();
    for (row, _, upper) in all.iter().filter(|(_, lower, upper)| lower == upper) {
        rows.push(row.clone());
        bounds.push(*upper);
    }
    cones.push(SupportedConeT::ZeroConeT(rows.len()));
    let equalities = rows.len();
    for (row, lower, upper) in all.iter().filter(|(_, lower, upper)| lower != upper) {
        if upper.is_finite() {
            rows.push(row.clone());
            bounds.push(*upper);
        }
        if lower.is_finite() {
            rows.push(row.iter().map(|value| -value).collect());
            bounds.push(-lower);
        }
    }
    cones.push(SupportedConeT::NonnegativeConeT(rows.len() - equalities));
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-12,
        max_iter: 500,
        ..DefaultSettings::default()
    };
    let mut solver =
        DefaultSolver::new(&dense(&p), &gradient, &dense(&rows), &bounds, &cones, settings).expect("well formed");
    solver.solve();
    let x: Vec<f64> = solver.solution.x.iter().zip(&unit).map(|(z, unit)| z * unit).collect();
    let objective = problem.objective(&x);
    (solver.solution.status, x, objective)
}

#[test]
fn another_solver_finds_no_better_optimum() {
    let mut solved = 0;
    for name in ["walk", "push"] {
        for state in states(name, 61) {
            let (status, solution, problem, solver) = state.solve(QpForm::Direct, |_| {});
            assert_eq!(status, Status::Optimal);
            let (their_status, x, objective) = clarabel(&problem);
            if !matches!(their_status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
                continue;
            }
            solved += 1;
            let ours = problem.objective(solver.x());
            let scale = 1.0 + ours.abs();
            assert!(ours <= objective + 1e-7 * scale, "{name} {}: {ours} against {objective}", state.estimate.time);
            close("q̈", &solution.qdd, &x[..7], 1000.0, 1e-5);
            // How the feet share the force has a weight of 1e-4 only: an interior point leaves tens of newtons there, which
            // change the objective in its ninth digit. The sum is what the tracking determines.
            let sum = |rho: &[f64]| [rho[0] + rho[2], rho[1] + rho[3]];
            close("sum of ρ", &sum(&solution.rho), &sum(&x[7..11]), 1000.0, 1e-4);
        }
    }
    assert!(solved > 40, "Clarabel solved {solved} programs only");
}

#[test]
fn a_hard_task_is_met_or_named_infeasible() {
    let (mut met, mut infeasible) = (0, 0);
    for state in states("walk", 11) {
        for form in [QpForm::Direct, QpForm::Slack] {
            let (status, solution, ..) =
                state.solve(form, |scenario| scenario.controller.tracking.feet = Tracking::Equality);
            if status == Status::Optimal {
                met += 1;
                let rows = state.layout(form).task("feet").expect("a task").rows.clone();
                close("foot slack", &solution.slack[rows], &[0.0; 4], 1.0, 1e-6);
            } else {
                infeasible += 1;
                assert_eq!(status, Status::Infeasible);
            }
        }
    }
    // Thesis 6.3.5: a hard foot task cannot be met at the start of a step.
    assert!(met > 100 && infeasible > 0, "{met} met, {infeasible} infeasible");
}

/// Each row and each bound in words, in the order of (B.1) and (B.7); a bound that demands nothing has none.
#[test]
fn every_row_and_every_bound_is_what_it_demands() {
    let state = states("stand", 4000).remove(0);
    let joints = ["right_knee", "right_hip", "left_hip", "left_knee"];
    let of_joints = |what: &str| joints.map(|joint| format!("{what} {joint}")).to_vec();
    let times = |count: usize, word: &str| vec![word.to_owned(); count];
    let feet = ["right_foot", "left_foot"];
    let friction: Vec<String> = feet
        .iter()
        .flat_map(|foot| [format!("unloading {foot}"), format!("friction {foot} +"), format!("friction {foot} -")])
        .collect();
    let forces: Vec<String> =
        feet.iter().flat_map(|foot| ["x", "z"].map(|axis| format!("force {foot} {axis}"))).collect();
    let tasks = [times(3, "task momentum"), times(4, "task feet"), times(1, "task torso")].concat();
    let accelerations = [times(3, ""), of_joints("acceleration")].concat();
    for (form, rows, bounds) in [
        (
            QpForm::Direct,
            [times(3, "equation of motion"), of_joints("torque"), friction.clone()].concat(),
            [accelerations.clone(), forces.clone()].concat(),
        ),
        (
            QpForm::Slack,
            [times(7, "equation of motion"), tasks.clone(), times(4, "no contact"), friction].concat(),
            [accelerations, forces, of_joints("torque"), tasks].concat(),
        ),
    ] {
        let layout = state.layout(form);
        let words = |constraint| layout.condition(constraint).map_or(String::new(), |it| it.in_words(&state.model));
        assert_eq!((0..layout.rows()).map(|row| words(Constraint::Row(row))).collect::<Vec<_>>(), rows);
        assert_eq!((0..layout.variables()).map(|k| words(Constraint::Bound(k))).collect::<Vec<_>>(), bounds);
        let limits: Vec<String> = layout.limits().iter().map(|limit| limit.in_words(&state.model)).collect();
        let named = |constraint| layout.limit(constraint).map(|index| limits[index].clone());
        let of_rows = (0..layout.rows()).filter_map(|row| named(Constraint::Row(row)));
        let mut found: Vec<String> =
            of_rows.chain((0..layout.variables()).filter_map(|k| named(Constraint::Bound(k)))).collect();
        found.sort();
        let mut all = limits.clone();
        all.sort();
        assert_eq!(found, all, "each limit has a constraint of its own");
    }
}

/// (4.32): a joint brakes from where v² / (2 q̈_max) would bring it to the limit that it moves to, and not before.
#[test]
fn a_joint_brakes_where_the_braking_distance_ends_at_its_limit() {
    let mut state = states("stand", 4000).remove(0);
    let layout = state.layout(QpForm::Direct);
    let set = |scenario: &mut Scenario| {
        scenario.controller.limits.joint_limits = JointLimits::BrakingDistance;
        scenario.controller.limits.joint_acceleration_radps2 = 500.0;
    };
    let (free, most) = ([-500.0, 500.0], 500.0);
    for dof in state.model.actuated().collect::<Vec<_>>() {
        let place = state.model.bodies[state.model.dofs[dof].body].q_index;
        let [lower, upper] = [state.model.dofs[dof].lower, state.model.dofs[dof].upper];
        for (speed, distance) in [(1.0, 0.001), (2.0, 0.004), (5.0, 0.025)] {
            for (q, v, expected) in [
                (upper - distance - 1e-9, speed, free),
                (upper - distance + 1e-9, speed, [-most; 2]),
                (upper + 0.01, speed, [-most; 2]),
                (upper - distance + 1e-9, -speed, free),
                (lower + distance + 1e-9, -speed, free),
                (lower + distance - 1e-9, -speed, [most; 2]),
                (lower + distance - 1e-9, speed, free),
                (upper - 1e-9, 0.0, free),
            ] {
                (state.estimate.q[place], state.estimate.v[dof]) = (q, v);
                let problem = state.build(&layout, set);
                let variable = layout.qdd.start + dof;
                let found = [problem.lower()[variable], problem.upper()[variable]];
                assert_eq!(found, expected, "{} at {q} rad, {v} rad/s", state.model.dofs[dof].name);
            }
        }
        (state.estimate.q[place], state.estimate.v[dof]) = (0.5 * (lower + upper), 0.0);
    }
}

/// The rate of a torque, the approach to a limit as a critically damped motion (k = 20/s), and braking as a cost.
#[test]
fn torques_and_joints_come_to_their_limits_as_the_settings_say() {
    let mut state = states("stand", 4000).remove(0);
    let mut scenario = state.scenario.clone();
    let limits = &mut scenario.controller.limits;
    (limits.torque_nm, limits.torque_rate_nmps, limits.approach_rate_1ps) = (100.0, 2000.0, 20.0);
    limits.joint_limits = JointLimits::Approach;
    let layout = state.layout(QpForm::Slack);
    let mut problem = Problem::new(layout.variables(), layout.rows());
    let before = [10.0, -99.0, 0.0, 99.5];
    momentum::build(&layout, &Inputs { torque_before: Some(&before), ..state.inputs(&scenario) }, &mut problem);
    for (index, range) in [[8.0, 12.0], [-100.0, -97.0], [-2.0, 2.0], [97.5, 100.0]].into_iter().enumerate() {
        let torque = layout.tau.start + index;
        assert!((problem.lower()[torque] - range[0]).abs() < 1e-12, "{index}");
        assert!((problem.upper()[torque] - range[1]).abs() < 1e-12, "{index}");
    }

    let knee = state.model.dofs.iter().position(|dof| dof.name == "right_knee").expect("the model has knees");
    let (variable, lower) = (layout.qdd.start + knee, state.model.dofs[knee].lower);
    (state.estimate.q[knee], state.estimate.v[knee]) = (lower + 0.1, -2.0);
    // k² d + 2 k v, of the distance d to the lower limit.
    let approach = 20.0 * 20.0 * -0.1 + 2.0 * 20.0 * 2.0;
    momentum::build(&layout, &state.inputs(&scenario), &mut problem);
    assert!((problem.lower()[variable] - approach).abs() < 1e-9, "{}", problem.lower()[variable]);
    assert_eq!(problem.gradient()[variable], 0.0);
    let weight = scenario.controller.weights.braking;
    let (hessian, relaxed) =
        (problem.hessian()[24 * variable], Relaxation { joint_limits: true, ..Relaxation::default() });
    momentum::build(&layout, &Inputs { relaxed, ..state.inputs(&scenario) }, &mut problem);
    let most = scenario.controller.limits.joint_acceleration_radps2;
    assert_eq!([problem.lower()[variable], problem.upper()[variable]], [-most, most]);
    assert!((problem.gradient()[variable] + 2.0 * weight * approach).abs() < 1e-9 * weight * approach);
    assert!((problem.hessian()[24 * variable] - hessian - 2.0 * weight).abs() < 1e-9 * weight);
}

#[test]
fn joint_limits_yield_where_they_contradict_the_torque_limits() {
    let mut state = states("stand", 4000).remove(0);
    // A knee that turns fast into its limit, with hardly any torque to stop it.
    let knee = state.model.dofs.iter().position(|dof| dof.name == "right_knee").expect("the model has knees");
    state.estimate.q[knee] = state.model.dofs[knee].lower + 1e-3;
    let (limit, largest) = (20.0, 1000.0);
    state.scenario.controller.limits.torque_nm = limit;
    for (speed, fallback) in [(-2.0, Fallback::JointLimitsYield), (-40.0, Fallback::AccelerationsYield)] {
        state.estimate.v[knee] = speed;
        state.dynamics.update(&state.model, &state.estimate.q, &state.estimate.v);
        let mut controller =
            state.scenario.momentum_controller(&state.model, &[], &state.estimate).expect("the model fits");
        controller.tick(&state.estimate, &state.dynamics);
        let tick = controller.latest();
        let program = &tick.program;
        assert_eq!(program.status, Status::Infeasible);
        assert_eq!(program.fallback, fallback, "{speed} rad/s");
        assert!(tick.braking[0] > 0.0, "the knee should brake");
        assert!(tick.solution.qdd[knee] < tick.braking[0], "the braking is missed, and visibly so");
        assert!(tick.solution.tau.iter().all(|torque| torque.abs() <= limit));
        let fastest = tick.solution.qdd[3..].iter().fold(0.0, |most: f64, qdd| most.max(qdd.abs()));
        assert_eq!(fastest > largest, fallback == Fallback::AccelerationsYield, "{fastest} rad/s2");
        assert_eq!(program.solves, fallback as u32 + 1);
        assert!(program.iterations > program.solves, "an infeasible program takes some");
        let words: Vec<String> = program.conflict.iter().map(|condition| condition.in_words(&state.model)).collect();
        assert!(words.iter().any(|words| words == "acceleration right_knee"), "{words:?}");
        let limits: Vec<LimitKind> = program.conflict.iter().filter_map(Condition::limit).collect();
        assert!(limits.contains(&LimitKind::Acceleration { dof: knee }), "{limits:?}");
        assert!(limits.iter().any(|limit| matches!(limit, LimitKind::Torque { .. })), "{limits:?}");
    }
}

/// Where no joint brakes there is no braking to give up, and where no task is hard there is none to soften: the program would be the
/// one that was solved before.
#[test]
fn a_program_that_would_be_the_one_before_is_not_solved_again() {
    let knee = 3;
    // Where forces cost less than nothing there is no minimum, whatever gives way.
    let no_minimum = |scenario: &mut Scenario| scenario.controller.weights.grf = -1e3;
    // Feet that must follow their reference on joints that may hardly accelerate; and a centre of mass as well, with hardly any torque.
    let hard = |scenario: &mut Scenario| scenario.controller.tracking.feet = Tracking::Equality;
    let stiff = |scenario: &mut Scenario| {
        hard(scenario);
        // Braking distances would be long.
        scenario.controller.limits.joint_limits = JointLimits::Approach;
        scenario.controller.limits.joint_acceleration_radps2 = 1e-3;
    };
    let weak = |scenario: &mut Scenario| {
        stiff(scenario);
        scenario.controller.tracking.momentum = Tracking::Equality;
        scenario.controller.limits.torque_nm = 1e-3;
    };
    let hard_without_minimum = |scenario: &mut Scenario| {
        hard(scenario);
        no_minimum(scenario);
    };
    type Change<'a> = &'a dyn Fn(&mut Scenario);
    let cases: [(Change<'_>, bool, Status, Fallback, u32); 7] = [
        (&|_| {}, false, Status::Optimal, Fallback::None, 1),
        (&stiff, false, Status::Infeasible, Fallback::AccelerationsYield, 2),
        (&weak, false, Status::Infeasible, Fallback::TasksYield, 3),
        (&no_minimum, false, Status::NotConvex, Fallback::HoldTorque, 2),
        (&no_minimum, true, Status::NotConvex, Fallback::HoldTorque, 3),
        (&hard_without_minimum, false, Status::NotConvex, Fallback::HoldTorque, 3),
        (&hard_without_minimum, true, Status::NotConvex, Fallback::HoldTorque, 4),
    ];
    for (index, (change, brakes, status, fallback, solves)) in cases.into_iter().enumerate() {
        let mut state = states("stand", 4000).remove(0);
        // The knee moves, into the end of its range or in the midst of it.
        state.estimate.v[knee] = 0.1;
        if brakes {
            (state.estimate.q[knee], state.estimate.v[knee]) = (state.model.dofs[knee].lower + 1e-3, -2.0);
        }
        state.dynamics.update(&state.model, &state.estimate.q, &state.estimate.v);
        change(&mut state.scenario);
        let mut controller =
            state.scenario.momentum_controller(&state.model, &[], &state.estimate).expect("the model fits");
        controller.tick(&state.estimate, &state.dynamics);
        let tick = controller.latest();
        assert_eq!(tick.braking[0] != 0.0, brakes, "case {index}");
        let found = (tick.program.status, tick.program.fallback, tick.program.solves);
        assert_eq!(found, (status, fallback, solves), "case {index}");
    }
}

/// Neither a state that is none nor dynamics that are none change the torques; nothing else is told of that tick.
#[test]
fn the_torques_are_held_while_what_is_sensed_is_no_state() {
    let state = states("stand", 4000).remove(0);
    let mut controller =
        state.scenario.momentum_controller(&state.model, &[], &state.estimate).expect("the model fits");
    assert!(controller.command().torque.iter().all(|&torque| torque == 0.0), "before the first tick");
    let mut no_state = state.estimate.clone();
    no_state.q[1] = f64::NAN;
    let [mut no_place, mut no_velocity] = [state.dynamics.clone(), state.dynamics.clone()];
    (no_place.com.z, no_velocity.com_velocity.x) = (f64::NAN, f64::INFINITY);
    for (sensed, dynamics) in
        [(&no_state, &state.dynamics), (&state.estimate, &no_place), (&state.estimate, &no_velocity)]
    {
        let sound = controller.tick(&state.estimate, &state.dynamics).clone();
        assert!(sound.torque.iter().any(|torque| torque.abs() > 1.0), "{sound:?}");
        let program = controller.program().expect("it solves one");
        assert_eq!((program.status, program.solves), (Status::Optimal, 1));
        assert!(controller.latest().solution.rho[1] > 100.0);
        for _ in 0..2 {
            assert_eq!(*controller.tick(sensed, dynamics), sound);
            let tick = controller.latest();
            let (program, solution) = (&tick.program, &tick.solution);
            assert_eq!((program.status, program.fallback), (Status::InvalidInput, Fallback::HoldTorque));
            assert_eq!((program.solves, program.iterations, program.conflict.len()), (0, 0, 0));
            let rest = [&solution.qdd, &solution.rho, &solution.slack];
            assert!(rest.into_iter().flatten().all(|&value| value == 0.0), "{solution:?}");
            assert!(tick.active.iter().all(|&side| side == 0));
        }
    }
}

/// Nothing was before the first tick, whose torques are free; then the rate holds, of what is held over a bad sample too.
#[test]
fn after_a_bad_sample_the_torques_were_free_to_jump() {
    let mut state = states("stand", 4000).remove(0);
    // In 1 ms: 0.5 Nm.
    state.scenario.controller.limits.torque_rate_nmps = 500.0;
    let mut controller =
        state.scenario.momentum_controller(&state.model, &[], &state.estimate).expect("the model fits");
    let mut no_state = state.estimate.clone();
    no_state.v[3] = f64::NAN;
    assert_eq!(*controller.tick(&no_state, &state.dynamics).torque, [0.0; 4]);
    let mut before = controller.tick(&state.estimate, &state.dynamics).torque.clone();
    assert!(before.iter().any(|torque| torque.abs() > 2.0), "the first torques are free: {before:?}");
    // Pushed over, it wants other torques, and gets as far as it may.
    state.estimate.v[0] = 1.0;
    state.dynamics.update(&state.model, &state.estimate.q, &state.estimate.v);
    for _ in 0..3 {
        let torque = controller.tick(&state.estimate, &state.dynamics).torque.clone();
        let change = torque.iter().zip(&before).map(|(now, before)| (now - before).abs()).fold(0.0, f64::max);
        assert!((change - 0.5).abs() < 1e-9, "{torque:?} after {before:?}");
        before = torque;
        assert_eq!(controller.tick(&no_state, &state.dynamics).torque, before);
    }
}

/// A slippery patch below the left foot: in its rows of (4.16) and in no others.
#[test]
fn each_foot_has_the_friction_of_the_ground_below_it() {
    let mut state = states("stand", 4000).remove(0);
    state.estimate.q[5] += 0.4;
    state.dynamics.update(&state.model, &state.estimate.q, &state.estimate.v);
    let [right, left] = [0, 1].map(|foot| state.dynamics.contact_positions[foot].x);
    assert!((right - left).abs() > 0.1, "{right} m and {left} m");
    state.scenario.ground.friction = 0.8;
    (state.scenario.ground.patches, state.scenario.ground.relief_known) = (vec![[left - 0.05, left + 0.05, 0.3]], true);
    let mut controller =
        state.scenario.momentum_controller(&state.model, &[], &state.estimate).expect("the model fits");
    controller.tick(&state.estimate, &state.dynamics);
    assert_eq!([0, 1].map(|foot| controller.ground()[foot].friction), [0.8, 0.3]);
    let (layout, problem) = (controller.layout(), controller.problem());
    for (contact, friction) in [0.8, 0.3].into_iter().enumerate() {
        for (side, along) in [1.0, -1.0].into_iter().enumerate() {
            let row = problem.row(layout.friction_rows.start + 3 * contact + 1 + side);
            let force = layout.rho.start + 2 * contact;
            assert_eq!(row[force..force + 2], [along, -friction]);
            assert_eq!(row.iter().filter(|&&entry| entry != 0.0).count(), 2);
        }
    }
}
