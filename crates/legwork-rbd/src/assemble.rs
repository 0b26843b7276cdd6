//! Puts a [`Model`] together: the base's own joints, indices, contact points, torso.

use nalgebra::{Matrix3, Unit, Vector3};

use crate::description::{BodyDescription, Description, JointDescription};
use crate::error::ModelError;
use crate::joint::{Base, Joint, Placement};
use crate::model::{Body, ContactPoint, Dof, Model};

/// The names that a planar base takes for its joints, and its virtual bodies.
pub(crate) const PLANAR_BASE: [&str; 3] = ["base_x", "base_z", "base_pitch"];
pub(crate) const FLOATING_BASE: [&str; 6] = ["base_wx", "base_wy", "base_wz", "base_vx", "base_vy", "base_vz"];

impl Description {
    pub(crate) fn assemble(&self, order: &[usize]) -> Model {
        let mut model = Model {
            name: self.name.clone(),
            base: self.base,
            gravity: self.gravity,
            bodies: Vec::new(),
            dofs: Vec::new(),
            contacts: Vec::new(),
            feet: Vec::new(),
            torso: 0,
            warnings: Vec::new(),
        };
        if self.base == Base::Planar {
            let massless = BodyDescription::massless;
            push_body(&mut model, &massless(PLANAR_BASE[0], Joint::Prismatic { axis: Vector3::x_axis() }), None);
            push_body(&mut model, &massless(PLANAR_BASE[1], Joint::Prismatic { axis: Vector3::z_axis() }), Some(0));
        }
        let first = model.bodies.len();
        for &index in order {
            let body = &self.bodies[index];
            let parent = body.parent.as_ref().and_then(|parent| model.body_index(parent));
            let parent = parent.or(first.checked_sub(1));
            push_body(&mut model, body, parent);
            if body.parent.is_none() {
                self.join_root(&mut model);
            }
        }
        model
    }

    /// Replaces the root link's joint, as the base has it.
    fn join_root(&self, model: &mut Model) {
        let index = model.bodies.len() - 1;
        let dof = |name: &str, rotational| Dof {
            name: name.to_owned(),
            actuated: false,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity_limit: f64::INFINITY,
            effort_limit: f64::INFINITY,
            damping: 0.0,
            rotational,
            body: index,
        };
        match self.base {
            Base::Fixed => {}
            Base::Planar => {
                let (lower, upper) = self.pitch_limits;
                model.bodies[index].joint_name = PLANAR_BASE[2].to_owned();
                model.bodies[index].joint = Joint::Revolute { axis: Unit::new_unchecked(-Vector3::y()) };
                model.dofs.push(Dof { lower, upper, ..dof(PLANAR_BASE[2], true) });
            }
            Base::Floating => {
                model.bodies[index].joint_name = "base".to_owned();
                model.bodies[index].joint = Joint::Floating;
                for (k, name) in FLOATING_BASE.iter().enumerate() {
                    model.dofs.push(dof(name, k < 3));
                }
            }
        }
    }

    pub(crate) fn add_contacts(&self, model: &mut Model) -> Result<(), ModelError> {
        model.feet = self.feet.clone().unwrap_or_default();
        for (i, foot) in model.feet.iter().enumerate() {
            if model.feet[..i].contains(foot) {
                return Err(self.invalid_beside(None, "feet", format!("{foot:?} is given twice")));
            }
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let subject = format!("contact {:?}", contact.name);
            if self.contacts[..i].iter().any(|other| other.name == contact.name) {
                let problem = "the name is given twice; contact names must differ".to_owned();
                return Err(self.invalid_beside(contact.line, subject, problem));
            }
            let body = self.bodies.iter().any(|body| body.name == contact.body);
            let Some(body) = model.body_index(&contact.body).filter(|_| body) else {
                let problem = format!("unknown body {:?}; {}", contact.body, self.known_bodies());
                return Err(self.invalid_beside(contact.line, subject, problem));
            };
            let foot = model.feet.iter().position(|foot| *foot == contact.foot);
            if foot.is_none() && self.feet.is_some() {
                let problem = format!("unknown foot {:?}; valid are {}", contact.foot, model.feet.join(", "));
                return Err(self.invalid_beside(contact.line, subject, problem));
            }
            let foot = foot.unwrap_or_else(|| {
                model.feet.push(contact.foot.clone());
                model.feet.len() - 1
            });
            model.contacts.push(ContactPoint { name: contact.name.clone(), body, position: contact.position, foot });
        }
        if let Some(foot) = (0..model.feet.len()).find(|&f| model.contacts.iter().all(|c| c.foot != f)) {
            let problem = format!("{:?} has no contact point", model.feet[foot]);
            return Err(self.invalid_beside(None, "feet", problem));
        }
        Ok(())
    }

    pub(crate) fn add_torso(&self, model: &mut Model) -> Result<(), ModelError> {
        model.torso = match &self.torso {
            None => model.root(),
            Some(name) => {
                let known = self.bodies.iter().any(|body| body.name == *name);
                model.body_index(name).filter(|_| known).ok_or_else(|| {
                    let problem = format!("unknown body {name:?}; {}", self.known_bodies());
                    self.invalid_beside(None, "torso", problem)
                })?
            }
        };
        Ok(())
    }
}

impl BodyDescription {
    fn massless(name: &str, kind: Joint) -> Self {
        Self {
            name: name.to_owned(),
            parent: None,
            mass: 0.0,
            com: Vector3::zeros(),
            inertia: Matrix3::zeros(),
            joint: JointDescription::new(name.to_owned(), kind, Placement::identity()),
            line: None,
        }
    }
}

fn push_body(model: &mut Model, body: &BodyDescription, parent: Option<usize>) {
    let joint = &body.joint;
    let index = model.bodies.len();
    model.bodies.push(Body {
        name: body.name.clone(),
        parent,
        joint_name: joint.name.clone(),
        joint: joint.kind,
        placement: joint.placement,
        mass: body.mass,
        com: body.com,
        inertia: body.inertia,
        q_index: model.nq() - usize::from(index == 0 && model.base == Base::Floating),
        v_index: model.nv(),
    });
    if joint.kind.nv() == 1 {
        model.dofs.push(Dof {
            name: joint.name.clone(),
            actuated: joint.actuated,
            lower: joint.lower,
            upper: joint.upper,
            velocity_limit: joint.velocity_limit,
            effort_limit: joint.effort_limit,
            damping: joint.damping,
            rotational: matches!(joint.kind, Joint::Revolute { .. }),
            body: index,
        });
    }
}
