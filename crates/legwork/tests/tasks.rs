//! The tasks and limits of the program as data, for every built-in model.

mod common;

use std::collections::HashSet;

use legwork::control::{Controller, MomentumController};
use legwork::library;
use legwork::log::Field;
use legwork::momentum::{Layout, LimitKind};
use legwork::scenario::{QpForm, Scenario};
use legwork_rbd::Dynamics;

/// A scenario of each built-in model.
const SCENARIOS: [&str; 3] = ["walk", "feet-walk", "exo-lift"];

#[test]
fn every_limit_has_words_and_a_column_of_its_own() {
    let settings = Scenario::default().controller;
    let models = library::model_names().map(|name| library::load_model(name, None).expect("a built-in model"));
    for model in models {
        for form in [QpForm::Direct, QpForm::Slack] {
            let layout = Layout::new(form, &settings, &model);
            let limits = layout.limits();
            assert_eq!(limits.len(), 2 * layout.actuated.len() + layout.rho.len() + layout.friction_rows.len());
            let different = |texts: Vec<String>| texts.iter().collect::<HashSet<_>>().len();
            assert_eq!(different(limits.iter().map(|limit| limit.in_words(&model)).collect()), limits.len());
            assert_eq!(different(limits.iter().map(|limit| limit.column(&model)).collect()), limits.len());
            assert_eq!(limits.iter().map(|limit| limit.kind).collect::<HashSet<_>>().len(), limits.len());
        }
    }
}

/// `J q̈ + J̇ q̇ + s = goal`, in the program, in its solution and in the log.
#[test]
fn rows_jacobian_goal_and_slack_of_every_task_agree() {
    let mut models = HashSet::new();
    // With all tasks that there are.
    for (name, form) in SCENARIOS.iter().flat_map(|name| ["direct", "slack"].map(|form| (name, form))) {
        let form_set = format!("controller.form={form}");
        let run = common::run(name, &["duration_s=0.4", "controller.tracking.posture=cost", &form_set]);
        assert_eq!(
            run.tasks.iter().map(|task| task.name).collect::<Vec<_>>(),
            ["momentum", "feet", "torso", "posture"]
        );
        models.insert(run.scenario.model.clone());
        let mut controller =
            run.scenario.momentum_controller(&run.model, &[], &run.log.truth(0)).expect("the model fits");
        let mut dynamics = Dynamics::new(&run.model);
        for index in 0..run.log.len() {
            let estimate = run.log.truth(index);
            dynamics.update(&run.model, &estimate.q, &estimate.v);
            controller.tick(&estimate, &dynamics);
            let active: Vec<f64> = controller.active().iter().copied().map(f64::from).collect();
            assert_eq!(active, run.log.get(index, Field::ActiveLimit), "{name}, {form}, tick {index}");
            check(&controller, &dynamics, run.log.get(index, Field::Slack), &format!("{name}, {form}, tick {index}"));
        }
    }
    assert_eq!(models, library::model_names().map(str::to_owned).collect());
}

fn check(controller: &MomentumController, dynamics: &Dynamics, logged: &[f64], what: &str) {
    let (tasks, aims, problem) = (controller.tasks(), controller.planner().aims(), controller.problem());
    let layout = controller.layout();
    assert_eq!((tasks.len(), tasks.last().expect("a task").rows.end), (aims.len(), logged.len()), "{what}");
    let mut next = 0;
    for (task, aim) in tasks.iter().zip(aims) {
        let what = format!("{what}, {}", task.name);
        let (slack, (jacobian, bias)) = (controller.slack(task.name), aim.law.motion(dynamics, controller.feet()));
        assert_eq!(task.name, aim.law.name());
        assert_eq!(task.rows, next..next + aim.goal.len(), "{what}");
        assert_eq!(task.parts().map(|(_, rows)| rows.len()).sum::<usize>(), aim.goal.len(), "{what}");
        assert_eq!((jacobian.nrows(), bias.len()), (aim.goal.len(), aim.goal.len()), "{what}");
        assert_eq!(slack, &logged[task.rows.clone()], "{what}");
        next = task.rows.end;
        let achieved = jacobian * nalgebra::DVector::from_column_slice(&controller.latest().solution.qdd) + bias;
        for row in 0..aim.goal.len() {
            let (sum, goal) = (achieved[row] + slack[row], aim.goal[row]);
            assert!((sum - goal).abs() < 1e-9 * (1.0 + goal.abs() + achieved[row].abs()), "{what}: {sum} for {goal}");
        }
        // The slack form has all tasks as rows, the direct form none that is a cost.
        let rows = if layout.form == QpForm::Slack { aim.goal.len() } else { 0 };
        assert_eq!((task.constraints.len(), task.variables.len()), (rows, rows), "{what}");
        for (row, (constraint, variable)) in task.constraints.clone().zip(task.variables.clone()).enumerate() {
            let coefficients = problem.row(constraint);
            assert!(layout.qdd.clone().all(|j| coefficients[j] == jacobian[(row, j)]), "{what}");
            assert!(layout.slack.clone().all(|j| coefficients[j] == f64::from(u8::from(j == variable))), "{what}");
            assert_eq!(
                [problem.row_lower()[constraint], problem.row_upper()[constraint]],
                [aim.goal[row] - bias[row]; 2]
            );
        }
    }
}

/// On level ground: the torque is at that end of its range, the foot unloaded, its force on that edge of the cone.
#[test]
fn what_is_at_a_limit_is_there_on_the_side_that_the_log_says() {
    for (form, set) in [(QpForm::Direct, "controller.form=direct"), (QpForm::Slack, "controller.form=slack")] {
        let run = common::run("walk", &["duration_s=1.5", "controller.limits.torque_nm=60", set]);
        let (log, model, most) = (&run.log, &run.model, run.scenario.controller.limits.torque_nm);
        let (layout, friction) = (Layout::new(form, &run.scenario.controller, model), run.scenario.ground.friction);
        let mut seen = [0; 4];
        for i in (0..log.len()).filter(|&i| log.get(i, Field::Program)[1] == 0.0) {
            let force = |contact: usize| [0, 1].map(|axis| log.get(i, Field::Grf)[2 * contact + axis]);
            for (limit, &side) in layout.limits().iter().zip(log.get(i, Field::ActiveLimit)) {
                let (off, what) = match limit.kind {
                    _ if side == 0.0 => continue,
                    LimitKind::Torque { dof } => {
                        let index = model.actuated().position(|other| other == dof).expect("an actuated joint");
                        let end = side * most.min(model.dofs[dof].effort_limit);
                        (log.get(i, Field::Torque)[index] - end, usize::from(side > 0.0))
                    }
                    LimitKind::Unloading { contact } => (side * force(contact)[1], 2),
                    LimitKind::Friction { contact, side: edge, .. } => {
                        let [along, up] = force(contact);
                        (side * [along, -along][edge] - friction * up, 3)
                    }
                    LimitKind::Force { .. } | LimitKind::Acceleration { .. } => continue,
                };
                assert!(off.abs() < 1e-6, "{set}, tick {i}: {} is off by {off}", limit.in_words(model));
                seen[what] += 1;
            }
        }
        assert!(seen[..2].iter().all(|count| *count > 10), "{seen:?}");
    }
}

/// The task that is off by default is nowhere then; otherwise it draws the joints to where they were.
#[test]
fn the_posture_is_a_task_where_it_is_tracked() {
    let deviation = |tracking: &str| {
        let sets = ["duration_s=1", &format!("controller.tracking.posture={tracking}")];
        let weight = (tracking == "cost").then_some("controller.weights.posture=1e4");
        let run = common::run("exo-sway", &sets.into_iter().chain(weight).collect::<Vec<_>>());
        let begin = run.log.get(0, Field::Q).to_vec();
        let moved = |index: usize| -> f64 {
            let joints = run.log.get(index, Field::Q).iter().zip(&begin).skip(7);
            joints.map(|(q, begin)| (q - begin).abs()).fold(0.0, f64::max)
        };
        let columns = run.log.columns().iter().filter(|column| column.name.starts_with("slack.posture.")).count();
        (run.tasks.len(), columns, (0..run.log.len()).map(moved).fold(0.0, f64::max))
    };
    let ((tasks, columns, free), (more_tasks, joints, held)) = (deviation("off"), deviation("cost"));
    assert_eq!((tasks, columns, more_tasks, joints), (3, 0, 4, 12));
    assert!(free > 0.05 && held < 0.5 * free, "{held} rad of {free} rad");
}
