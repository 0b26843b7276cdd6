//! What limits the program and what an infeasible program is short of, as data; all words and column names for them are made here.

use legwork_contract::names;
use legwork_qp::Constraint;
use legwork_rbd::Model;

/// What a limit limits. The ends of a joint's range and its largest speed have no limits of their own in this program: they
/// bound the joint's acceleration (4.32).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LimitKind {
    /// The torque of an actuated joint.
    Torque {
        /// The joint, in [`Model::dofs`].
        dof: usize,
    },
    /// The force on a contact point along an axis.
    Force {
        /// The point, in [`Model::contacts`].
        contact: usize,
        /// The axis, in [`Model::linear_axes`].
        axis: usize,
    },
    /// The force on a contact point, which pushes and cannot pull.
    Unloading {
        /// The point, in [`Model::contacts`].
        contact: usize,
    },
    /// The friction of a contact point: a side of its cone.
    Friction {
        /// The point, in [`Model::contacts`].
        contact: usize,
        /// The side: in the plane forward and backward, in space in turn to the left from the first tangent.
        side: usize,
        /// Of so many.
        sides: usize,
    },
    /// The acceleration of an actuated joint.
    Acceleration {
        /// The joint, in [`Model::dofs`].
        dof: usize,
    },
}

impl LimitKind {
    /// What is limited, as in `torque`.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Torque { .. } => "torque",
            Self::Force { .. } => "force",
            Self::Unloading { .. } => "unloading",
            Self::Friction { .. } => "friction",
            Self::Acceleration { .. } => "acceleration",
        }
    }

    /// The contact point whose force is limited, in [`Model::contacts`], if one is.
    pub fn contact(self) -> Option<usize> {
        match self {
            Self::Force { contact, .. } | Self::Unloading { contact } | Self::Friction { contact, .. } => Some(contact),
            Self::Torque { .. } | Self::Acceleration { .. } => None,
        }
    }

    /// The limit in words, as in `torque right_knee` or `force left_foot z`.
    pub fn in_words(self, model: &Model) -> String {
        let quantity = self.quantity();
        match self {
            Self::Torque { dof } | Self::Acceleration { dof } => format!("{quantity} {}", model.dofs[dof].name),
            Self::Force { contact, axis } => {
                let axis = names::linear(model).nth(axis).expect("an axis of the model");
                format!("{quantity} {} {axis}", model.contacts[contact].name)
            }
            Self::Unloading { contact } => format!("{quantity} {}", model.contacts[contact].name),
            Self::Friction { contact, side, sides } => {
                let way = match (model.is_planar(), side) {
                    (true, 0) => "+".to_owned(),
                    (true, _) => "-".to_owned(),
                    // The middle of the side, to the left of the first tangent.
                    (false, _) => format!("{:.0}deg", (2 * side + 1) as f64 * 180.0 / sides as f64),
                };
                format!("{quantity} {} {way}", model.contacts[contact].name)
            }
        }
    }
}

/// A limit of the program that can be active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// What it limits.
    pub kind: LimitKind,
    pub(super) constraint: Constraint,
}

impl Limit {
    /// The limit in words: [`LimitKind::in_words`].
    pub fn in_words(&self, model: &Model) -> String {
        self.kind.in_words(model)
    }

    /// The name of the limit's column in the log, as in `limit.torque_right_knee`.
    pub fn column(&self, model: &Model) -> String {
        format!("limit.{}", self.in_words(model).replace(' ', "_"))
    }
}

/// What the program demands: what contradicts each other where it has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Condition {
    /// The equation of motion of a joint that no motor drives, or of any joint in the slack form (4.8).
    Motion,
    /// The task of this name: an equality, or in the slack form the definition of its slack variables.
    Task(&'static str),
    /// No force without contact (4.10), in the slack form.
    NoContact,
    /// A limit.
    Limit(LimitKind),
}

impl Condition {
    /// What is limited, if it is a limit.
    pub fn limit(&self) -> Option<LimitKind> {
        if let Self::Limit(kind) = self { Some(*kind) } else { None }
    }

    /// The condition in words, as in `torque right_knee` or `task feet`.
    pub fn in_words(self, model: &Model) -> String {
        match self {
            Self::Motion => "equation of motion".to_owned(),
            Self::Task(name) => format!("task {name}"),
            Self::NoContact => "no contact".to_owned(),
            Self::Limit(kind) => kind.in_words(model),
        }
    }
}
