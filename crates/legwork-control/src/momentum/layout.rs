//! Which variable and which row stands where. Thesis (B.1), (B.2), (B.7), (B.9)

use std::ops::Range;

use legwork_qp::{Constraint, Side};

use crate::settings::{ControllerSettings, QpForm, Tracking};
use legwork_contract::contact::Pyramid;
use legwork_contract::robot::Robot;

use super::limit::{Condition, Limit, LimitKind};
use super::tasks::{Task, laws};

/// The places of variables and rows in the program. Ranges that a form does not have are empty; in the direct form a
/// task has rows only where it is an equality.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The form that this is the layout of.
    pub form: QpForm,
    /// Joint accelerations.
    pub qdd: Range<usize>,
    /// Contact forces, a contact after the other, along the model's linear axes.
    pub rho: Range<usize>,
    /// Torques of the actuated joints (slack form).
    pub tau: Range<usize>,
    /// Slack variables of all tasks (slack form).
    pub slack: Range<usize>,
    /// Rows of the equation of motion (4.8), a joint each.
    pub dynamics_rows: Range<usize>,
    /// Rows of the complementarity (4.10) (slack form).
    pub complementarity_rows: Range<usize>,
    /// Rows of the friction cones (4.16).
    pub friction_rows: Range<usize>,
    /// Degrees of freedom that are actuated, in order.
    pub actuated: Vec<usize>,
    tasks: Vec<Task>,
    /// The limits that can be active, in the order of [`Layout::limit`].
    limits: Vec<Limit>,
    /// For each row, then each variable's bounds, its place in `limits`.
    limit_of: Vec<Option<usize>>,
    dimension: usize,
    pyramid: Pyramid,
}

impl Layout {
    /// The layout of `form` for `model`, with the tasks that `settings` ask for.
    pub fn new(form: QpForm, settings: &ControllerSettings, model: &Robot) -> Self {
        let (nv, contacts, dimension) = (model.nv(), model.contacts.len(), model.linear_axes().len());
        let actuated: Vec<usize> = model.actuated().collect();
        let forces = contacts * dimension;
        let pyramid = Pyramid::new(model, settings.friction_edges);
        let slack = |size: usize| if form == QpForm::Slack { size } else { 0 };

        let mut next = 0;
        let mut take = |size: usize| {
            next += size;
            next - size..next
        };
        let (qdd, rho, tau) = (take(nv), take(forces), take(slack(actuated.len())));
        let mut tasks: Vec<Task> =
            laws(settings, model).iter().map(|law| Task::new(law.as_ref(), settings, model)).collect();
        let mut rows = 0;
        for task in &mut tasks {
            task.rows = rows..rows + task.rows.len();
            task.variables = take(slack(task.rows.len()));
            rows = task.rows.end;
        }
        let slack_variables = tau.end..take(0).end;

        next = 0;
        let mut take = |size: usize| {
            next += size;
            next - size..next
        };
        let dynamics_rows = take(nv);
        for task in &mut tasks {
            let size = task.rows.len();
            task.constraints = take(if task.how == Tracking::Equality { size } else { slack(size) });
        }
        let mut layout = Self {
            form,
            qdd,
            rho,
            tau,
            slack: slack_variables,
            dynamics_rows,
            complementarity_rows: take(slack(forces)),
            friction_rows: take(contacts * pyramid.rows()),
            actuated,
            tasks,
            limits: Vec::new(),
            limit_of: Vec::new(),
            dimension,
            pyramid,
        };
        layout.limits = layout.all_limits();
        layout.limit_of = vec![None; layout.rows() + layout.variables()];
        for index in 0..layout.limits.len() {
            let place = layout.place(layout.limits[index].constraint);
            layout.limit_of[place] = Some(index);
        }
        layout
    }

    /// Number of variables.
    pub fn variables(&self) -> usize {
        self.slack.end
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.friction_rows.end
    }

    /// Directions of a contact force: 2 in the plane, 3 in space.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The cone of friction of each contact.
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
    }

    /// The tasks, in the order of their rows.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// The task `name`, if the program has it.
    pub fn task(&self, name: &str) -> Option<&Task> {
        self.tasks.iter().find(|task| task.name == name)
    }

    /// The limits that can be active: torques, forces, friction, joint accelerations.
    pub fn limits(&self) -> &[Limit] {
        &self.limits
    }

    /// The place in [`Layout::limits`] of a constraint that the solver names, where it is a limit.
    pub fn limit(&self, constraint: Constraint) -> Option<usize> {
        self.limit_of[self.place(constraint)]
    }

    fn place(&self, constraint: Constraint) -> usize {
        match constraint {
            Constraint::Row(row) => row,
            Constraint::Bound(variable) => self.rows() + variable,
        }
    }

    /// What a constraint that the solver names demands; none where it demands nothing (the base's acceleration is free).
    pub fn condition(&self, constraint: Constraint) -> Option<Condition> {
        if let Some(limit) = self.limit(constraint) {
            return Some(Condition::Limit(self.limits[limit].kind));
        }
        let of_task = |own: &dyn Fn(&Task) -> bool| self.tasks.iter().find(|task| own(task));
        let task = match constraint {
            Constraint::Row(row) if self.dynamics_rows.contains(&row) => return Some(Condition::Motion),
            Constraint::Row(row) if self.complementarity_rows.contains(&row) => return Some(Condition::NoContact),
            Constraint::Row(row) => of_task(&|task| task.constraints.contains(&row)),
            Constraint::Bound(variable) => of_task(&|task| task.variables.contains(&variable)),
        };
        task.map(|task| Condition::Task(task.name))
    }

    fn all_limits(&self) -> Vec<Limit> {
        let (forces, rows) = (self.dimension, self.pyramid.rows());
        let contacts = self.rho.len() / forces;
        let limit = |kind, constraint| Limit { kind, constraint };
        let torques = self.actuated.iter().enumerate().map(|(index, &dof)| {
            let constraint = match self.form {
                QpForm::Direct => Constraint::Row(self.dynamics_rows.start + dof),
                QpForm::Slack => Constraint::Bound(self.tau.start + index),
            };
            limit(LimitKind::Torque { dof }, constraint)
        });
        let forces = (0..contacts * forces).map(|k| {
            let kind = LimitKind::Force { contact: k / forces, axis: k % forces };
            limit(kind, Constraint::Bound(self.rho.start + k))
        });
        let friction = (0..contacts * rows).map(|k| {
            let kind = match k % rows {
                0 => LimitKind::Unloading { contact: k / rows },
                row => LimitKind::Friction { contact: k / rows, side: row - 1, sides: rows - 1 },
            };
            limit(kind, Constraint::Row(self.friction_rows.start + k))
        });
        let accelerations = self
            .actuated
            .iter()
            .map(|&dof| limit(LimitKind::Acceleration { dof }, Constraint::Bound(self.qdd.start + dof)));
        torques.chain(forces).chain(friction).chain(accelerations).collect()
    }
}

/// `-1` at the lower side, `1` at the upper.
pub(crate) fn side_sign(side: Side) -> i8 {
    if side == Side::Lower { -1 } else { 1 }
}
