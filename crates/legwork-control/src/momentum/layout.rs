//! Which variable and which row stands where. Thesis (B.1), (B.2), (B.7), (B.9)

use std::ops::Range;

use legwork_qp::{Constraint, Side};
use legwork_rbd::Model;

use crate::settings::{QpForm, Tracking, TrackingSettings};
use legwork_contract::contact::friction_rows;
use legwork_contract::feet::FootRows;

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
    /// Slack of the momentum rate: angular, linear (slack form).
    pub s_m: Range<usize>,
    /// Slack of the foot accelerations (slack form).
    pub s_f: Range<usize>,
    /// Slack of the torso's angular acceleration (slack form).
    pub s_a: Range<usize>,
    /// Rows of the equation of motion (4.8), a joint each.
    pub dynamics_rows: Range<usize>,
    /// Rows of the momentum rate (4.17).
    pub momentum_rows: Range<usize>,
    /// Rows of the foot accelerations (4.19).
    pub feet_rows: Range<usize>,
    /// Rows of the torso's angular acceleration (4.20).
    pub torso_rows: Range<usize>,
    /// Rows of the complementarity (4.10) (slack form).
    pub complementarity_rows: Range<usize>,
    /// Rows of the friction cones (4.16).
    pub friction_rows: Range<usize>,
    /// Degrees of freedom that are actuated, in order.
    pub actuated: Vec<usize>,
    /// The limits that can be active, in the order of [`Layout::limit`].
    limits: Vec<Limit>,
    /// For each row, then each variable's bounds, its place in `limits`.
    limit_of: Vec<Option<usize>>,
    dimension: usize,
    friction_rows_per_contact: usize,
}

/// A limit of the program that can be active.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limit {
    /// Its name, as in `torque right_knee`.
    pub name: String,
    /// The contact whose force it limits, if it limits one.
    pub contact: Option<usize>,
    constraint: Constraint,
}

impl Layout {
    /// The layout of `form` for `model`, with tasks as costs or equalities as in `tracking`.
    pub fn new(form: QpForm, tracking: &TrackingSettings, model: &Model) -> Self {
        let (nv, contacts, dimension) = (model.nv(), model.contacts.len(), model.linear_axes().len());
        let actuated: Vec<usize> = model.actuated().collect();
        let (forces, momenta) = (contacts * dimension, model.angular_axes().len() + dimension);
        let (feet, torso) = (FootRows::count(model), model.angular_axes().len());
        let slack = |size: usize| if form == QpForm::Slack { size } else { 0 };
        let task = |size: usize, task: Tracking| if task == Tracking::Equality { size } else { slack(size) };

        let mut next = 0;
        let mut take = |size: usize| {
            next += size;
            next - size..next
        };
        let (qdd, rho, tau) = (take(nv), take(forces), take(slack(actuated.len())));
        let (s_m, s_f, s_a) = (take(slack(momenta)), take(slack(feet)), take(slack(torso)));

        next = 0;
        let mut take = |size: usize| {
            next += size;
            next - size..next
        };
        let mut layout = Self {
            form,
            qdd,
            rho,
            tau,
            s_m,
            s_f,
            s_a,
            dynamics_rows: take(nv),
            momentum_rows: take(task(momenta, tracking.momentum)),
            feet_rows: take(task(feet, tracking.feet)),
            torso_rows: take(task(torso, tracking.torso)),
            complementarity_rows: take(slack(forces)),
            friction_rows: take(contacts * friction_rows(model)),
            actuated,
            limits: Vec::new(),
            limit_of: Vec::new(),
            dimension,
            friction_rows_per_contact: friction_rows(model),
        };
        layout.limits = layout.all_limits(model);
        layout.limit_of = vec![None; layout.rows() + layout.variables()];
        for index in 0..layout.limits.len() {
            let place = layout.place(layout.limits[index].constraint);
            layout.limit_of[place] = Some(index);
        }
        layout
    }

    /// Number of variables.
    pub fn variables(&self) -> usize {
        self.rho.end.max(self.s_a.end)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.friction_rows.end
    }

    /// Directions of a contact force: 2 in the plane, 3 in space.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Friction rows a contact.
    pub fn friction_rows_per_contact(&self) -> usize {
        self.friction_rows_per_contact
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

    /// What a constraint that the solver names means, as in `torque right_knee` or `task feet`.
    pub fn name(&self, constraint: Constraint) -> &str {
        if let Some(limit) = self.limit(constraint) {
            return &self.limits[limit].name;
        }
        let (groups, index) = match constraint {
            Constraint::Row(row) => (
                [
                    (&self.dynamics_rows, "equation of motion"),
                    (&self.momentum_rows, "task momentum"),
                    (&self.feet_rows, "task feet"),
                    (&self.torso_rows, "task torso"),
                    (&self.complementarity_rows, "no contact"),
                ],
                row,
            ),
            Constraint::Bound(variable) => (
                [
                    (&self.qdd, "acceleration of the base"),
                    (&self.rho, "no contact"),
                    (&self.s_m, "task momentum"),
                    (&self.s_f, "task feet"),
                    (&self.s_a, "task torso"),
                ],
                variable,
            ),
        };
        groups.iter().find(|(range, _)| range.contains(&index)).map_or("", |(_, name)| name)
    }

    fn all_limits(&self, model: &Model) -> Vec<Limit> {
        let mut limits = Vec::new();
        let mut add = |name: String, contact, constraint| limits.push(Limit { name, contact, constraint });
        for (index, &dof) in self.actuated.iter().enumerate() {
            let constraint = match self.form {
                QpForm::Direct => Constraint::Row(self.dynamics_rows.start + dof),
                QpForm::Slack => Constraint::Bound(self.tau.start + index),
            };
            add(format!("torque {}", model.dofs[dof].name), None, constraint);
        }
        for (index, contact) in model.contacts.iter().enumerate() {
            for row in 0..self.dimension {
                let axis = axis_name(model, row);
                let constraint = Constraint::Bound(self.rho.start + index * self.dimension + row);
                add(format!("force {} {axis}", contact.name), Some(index), constraint);
            }
        }
        for (index, contact) in model.contacts.iter().enumerate() {
            for row in 0..self.friction_rows_per_contact {
                let what = if row == 0 { "unloading" } else { "friction" };
                let constraint =
                    Constraint::Row(self.friction_rows.start + index * self.friction_rows_per_contact + row);
                let side = match (row, model.is_planar()) {
                    (0, _) => String::new(),
                    (_, true) => format!(" {}", ["+", "-"][row - 1]),
                    (_, false) => format!(" {}", ["+x", "-x", "+y", "-y"][row - 1]),
                };
                add(format!("{what} {}{side}", contact.name), Some(index), constraint);
            }
        }
        for &dof in &self.actuated {
            add(format!("acceleration {}", model.dofs[dof].name), None, Constraint::Bound(self.qdd.start + dof));
        }
        limits
    }
}

/// `x`, `y` or `z`: the name of a linear axis.
pub(crate) fn axis_name(model: &Model, row: usize) -> char {
    ['x', 'y', 'z'][model.linear_axes()[row].imax()]
}

/// `-1` at the lower side, `1` at the upper.
pub(crate) fn side_sign(side: Side) -> i8 {
    if side == Side::Lower { -1 } else { 1 }
}
