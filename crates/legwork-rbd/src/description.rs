//! The description that a file gives of a robot, and its way to a checked [`Model`].

use nalgebra::{Matrix3, Vector3};

use crate::base::Base;
use crate::check::oddities;
use crate::error::ModelError;
use crate::joints::Joint;
use crate::model::{Dof, Model};
use crate::roles::Roles;
use crate::spatial::Placement;

/// What a file says, in SI units, before any check across entries.
pub(crate) struct Description {
    pub(crate) file: String,
    pub(crate) name: String,
    pub(crate) base: Base,
    pub(crate) gravity: f64,
    /// Of a planar base.
    pub(crate) pitch_limits: (f64, f64),
    pub(crate) bodies: Vec<BodyDescription>,
    pub(crate) contacts: Vec<ContactDescription>,
    pub(crate) frames: Vec<FrameDescription>,
    pub(crate) warnings: Vec<String>,
    /// Those of the contact points are not in it yet. Its file is the one that contacts and frames come from.
    pub(crate) roles: Roles,
}

pub(crate) struct BodyDescription {
    pub(crate) name: String,
    pub(crate) parent: Option<String>,
    pub(crate) mass: f64,
    pub(crate) com: Vector3<f64>,
    pub(crate) inertia: Matrix3<f64>,
    pub(crate) joint: JointDescription,
    pub(crate) line: Option<usize>,
}

pub(crate) struct JointDescription {
    pub(crate) name: String,
    pub(crate) kind: Joint,
    pub(crate) placement: Placement,
    /// Limits, damping and motor of its coordinate.
    pub(crate) dof: Dof,
    pub(crate) line: Option<usize>,
}

pub(crate) struct ContactDescription {
    pub(crate) name: String,
    pub(crate) body: String,
    pub(crate) position: Vector3<f64>,
    pub(crate) foot: Option<String>,
    pub(crate) line: Option<usize>,
}

pub(crate) struct FrameDescription {
    pub(crate) name: String,
    pub(crate) body: String,
    pub(crate) placement: Placement,
    pub(crate) line: Option<usize>,
}

impl Description {
    pub(crate) fn invalid(
        &self,
        line: Option<usize>,
        subject: impl Into<String>,
        problem: impl Into<String>,
    ) -> ModelError {
        ModelError::Invalid { file: self.file.clone(), line, subject: subject.into(), problem: problem.into() }
    }

    pub(crate) fn invalid_beside(
        &self,
        line: Option<usize>,
        subject: impl Into<String>,
        problem: String,
    ) -> ModelError {
        ModelError::Invalid { file: self.roles.file.clone(), line, subject: subject.into(), problem }
    }

    /// Checks everything and assembles the model.
    pub(crate) fn build(mut self) -> Result<(Model, Roles), ModelError> {
        if !(self.gravity.is_finite() && self.gravity >= 0.0) {
            let problem = format!("{}; it must be finite and not negative (9.81 on Earth)", self.gravity);
            return Err(self.invalid_beside(None, "gravity_mps2", problem));
        }
        self.check_names()?;
        for body in &self.bodies {
            self.check_body(body)?;
        }
        let order = self.order()?;
        let mut model = self.assemble(&order);
        self.check_motion(&model)?;
        self.add_contacts(&mut model)?;
        self.add_frames(&mut model)?;
        let mut warnings = std::mem::take(&mut self.warnings);
        warnings.extend(oddities(&model));
        model.warnings = warnings;
        (self.roles.foot, self.roles.lines) = self.contacts.into_iter().map(|point| (point.foot, point.line)).unzip();
        Ok((model, self.roles))
    }

    pub(crate) fn known_bodies(&self) -> String {
        let names: Vec<_> = self.bodies.iter().map(|body| body.name.as_str()).collect();
        let rest = if names.len() > 30 { ", …" } else { "" };
        format!("valid are {}{rest}", names[..names.len().min(30)].join(", "))
    }

    pub(crate) fn joint_line(&self, body: &str) -> Option<usize> {
        let body = self.bodies.iter().find(|other| other.name == body)?;
        body.joint.line.or(body.line)
    }
}

impl JointDescription {
    /// A joint without limits, damping or motor.
    pub(crate) fn new(name: String, kind: Joint, placement: Placement) -> Self {
        Self { name, kind, placement, dof: Dof::free(), line: None }
    }
}
