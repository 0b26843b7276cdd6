//! The description that a file gives of a robot, and its way to a checked [`Model`].

use std::collections::{HashMap, HashSet};

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use crate::base::Base;
use crate::check::oddities;
use crate::error::{ModelError, Problems};
use crate::joints::{Fixed, Joint};
use crate::model::{Dof, Model};
use crate::roles::Roles;
use crate::spatial::{Motion, Placement};
use crate::words::{self, PROBLEM, one_line};

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
    /// What becomes of inertias that no body has.
    pub(crate) inertias: Inertias,
    /// Joints that are fixed at zero, by names or patterns.
    pub(crate) locked: Vec<String>,
    /// Whether joints that move no mass are fixed too, as files of other tools have them.
    pub(crate) locks_massless: bool,
    /// Those of the contact points are not in it yet. Its file is the one that contacts and frames come from.
    pub(crate) roles: Roles,
}

/// What becomes of inertias that no body has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Inertias {
    /// They stay as the file has them.
    #[default]
    Kept,
    /// The nearest that a body can have takes their place.
    Repaired,
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
    /// The joint that it follows.
    pub(crate) follows: Option<Leader>,
    pub(crate) line: Option<usize>,
}

/// The joint that another one follows: by that ratio, and so far from it where it is at zero.
#[derive(Clone)]
pub(crate) struct Leader {
    pub(crate) joint: String,
    pub(crate) ratio: f64,
    pub(crate) offset: f64,
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
        ModelError::invalid(&self.file, line, subject, problem)
    }

    pub(crate) fn invalid_beside(
        &self,
        line: Option<usize>,
        subject: impl Into<String>,
        problem: String,
    ) -> ModelError {
        ModelError::invalid(&self.roles.file, line, subject, problem)
    }

    /// Checks everything and assembles the model.
    pub(crate) fn build(mut self) -> Result<(Model, Roles), ModelError> {
        let mut problems = Problems::default();
        if !(self.gravity.is_finite() && self.gravity >= 0.0) {
            let problem = format!("{}; it must be finite and not negative (9.81 on Earth)", self.gravity);
            problems.add(self.invalid_beside(None, "gravity_mps2", problem));
        }
        self.check_names(&mut problems);
        for body in &self.bodies {
            problems.keep(self.check_body(body));
        }
        self.mend_inertias();
        self.drop_zero_velocity_limits();
        let order = problems.keep(self.order());
        problems.none(&self.file)?;
        let order = order.expect("no problem was found with it");
        problems.keep(self.lock_named());
        problems.none(&self.file)?;
        self.lock_massless(&order)?;
        let places = self.places(&order);
        let mut model = self.assemble(&order, &places)?;
        problems.keep(self.check_motion(&model));
        self.add_contacts(&mut model, &places, &mut problems);
        self.add_frames(&mut model, &places, &mut problems);
        problems.none(&self.file)?;
        let mut warnings = std::mem::take(&mut self.warnings);
        warnings.extend(oddities(&model));
        model.warnings = warnings.iter().map(|warning| one_line(warning, PROBLEM)).collect();
        (self.roles.foot, self.roles.lines) = self.contacts.into_iter().map(|point| (point.foot, point.line)).unzip();
        Ok((model, self.roles))
    }

    /// A joint that may not move would be a fixed one: tools leave a zero where they know no limit.
    fn drop_zero_velocity_limits(&mut self) {
        for joint in self.bodies.iter_mut().map(|body| &mut body.joint).filter(|joint| joint.dof.velocity_limit == 0.0)
        {
            joint.dof.velocity_limit = f64::INFINITY;
            self.warnings.push(format!("joint {:?}: a velocity limit of 0 is taken as none", joint.name));
        }
    }

    /// Fixes the joints that `locked` names.
    fn lock_named(&mut self) -> Result<(), ModelError> {
        let joints = || self.bodies.iter().map(|body| &body.joint.name);
        for pattern in &self.locked {
            if !joints().any(|name| words::matches(pattern, name)) {
                let problem = format!("no joint is called {pattern:?}; valid are {}", words::list(joints()));
                return Err(self.invalid_beside(None, "locked", problem));
            }
        }
        let names = joints().filter(|name| self.locked.iter().any(|pattern| words::matches(pattern, name)));
        let names: HashSet<String> = names.cloned().collect();
        self.lock(&names);
        Ok(())
    }

    /// Fixes the joints that move no mass, where that is asked for.
    fn lock_massless(&mut self, order: &[usize]) -> Result<(), ModelError> {
        if !self.locks_massless {
            return Ok(());
        }
        let model = self.assemble(order, &self.places(order))?;
        let massless = model.coordinates_without_inertia();
        let names: HashSet<String> =
            massless.iter().map(|&dof| model.bodies[model.dofs[dof].body].joint_name.clone()).collect();
        for name in self.bodies.iter().map(|body| &body.joint.name).filter(|name| names.contains(*name)) {
            let warning = format!("joint {name:?} moves no mass and is locked; give what it carries a mass to free it");
            self.warnings.push(warning);
        }
        self.lock(&names);
        Ok(())
    }

    /// Fixes joints at zero, and those that follow them where they are led to.
    fn lock(&mut self, names: &HashSet<String>) {
        let leaders: HashMap<String, Leader> = self
            .bodies
            .iter()
            .filter_map(|body| Some((body.joint.name.clone(), body.joint.follows.clone()?)))
            .collect();
        for joint in self.bodies.iter_mut().map(|body| &mut body.joint).filter(|joint| joint.kind.nv() == 1) {
            let (mut at, mut ratio, mut offset) = (joint.name.clone(), 1.0, 0.0);
            // Each leader once: joints that follow themselves are refused later.
            for _ in 0..leaders.len() {
                let Some(leader) = leaders.get(&at).filter(|_| !names.contains(&at)) else { break };
                (at, offset, ratio) = (leader.joint.clone(), ratio * leader.offset + offset, ratio * leader.ratio);
            }
            if names.contains(&at) {
                joint.kind.pose(&[offset], &mut joint.placement, &mut [Motion::zero()]);
                (joint.kind, joint.follows, joint.dof) = (Joint::Fixed(Fixed), None, Dof::free());
            }
        }
    }

    pub(crate) fn known_bodies(&self) -> String {
        format!("valid are {}", words::list(self.bodies.iter().map(|body| &body.name)))
    }

    pub(crate) fn joint_line(&self, body: &str) -> Option<usize> {
        let body = self.bodies.iter().find(|other| other.name == body)?;
        body.joint.line.or(body.line)
    }
}

impl JointDescription {
    /// Whether it has a single coordinate, of its own.
    pub(crate) fn has_a_coordinate(&self) -> bool {
        self.kind.nv() == 1 && self.follows.is_none()
    }

    /// A joint without limits, damping or motor.
    pub(crate) fn new(name: String, kind: Joint, placement: Placement) -> Self {
        Self { name, kind, placement, dof: Dof::free(), follows: None, line: None }
    }
}
