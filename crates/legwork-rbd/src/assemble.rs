//! Puts a [`Model`] together: the base's own joints, indices, contact points, frames.

use std::collections::{HashMap, HashSet};

use nalgebra::{Matrix3, Vector3};

use crate::description::{BodyDescription, Description, FrameDescription, JointDescription};
use crate::error::ModelError;
use crate::frame::Frame;
use crate::model::{Body, ContactPoint, Dof, Model};
use crate::spatial::Placement;

impl Description {
    /// The bodies' indices in the model by name, of bodies in this `order`.
    pub(crate) fn places(&self, order: &[usize]) -> HashMap<&str, usize> {
        let virtual_bodies = self.base.joints().len().saturating_sub(1);
        order.iter().enumerate().map(|(i, &index)| (self.bodies[index].name.as_str(), virtual_bodies + i)).collect()
    }

    pub(crate) fn assemble(&self, order: &[usize], places: &HashMap<&str, usize>) -> Model {
        let mut model = Model {
            name: self.name.clone(),
            base: self.base,
            gravity: self.gravity,
            bodies: Vec::new(),
            dofs: Vec::new(),
            contacts: Vec::new(),
            frames: Vec::new(),
            warnings: Vec::new(),
        };
        let mut base = self.base.joints();
        let own = base.pop();
        for (name, joint) in base {
            let parent = model.bodies.len().checked_sub(1);
            let massless = BodyDescription {
                name: name.to_owned(),
                parent: None,
                mass: 0.0,
                com: Vector3::zeros(),
                inertia: Matrix3::zeros(),
                joint: JointDescription::new(name.to_owned(), joint, Placement::identity()),
                line: None,
            };
            push_body(&mut model, &massless, &massless.joint, parent);
        }
        let carrier = model.bodies.len().checked_sub(1);
        for &index in order {
            let body = &self.bodies[index];
            match (&body.parent, own) {
                (Some(parent), _) => {
                    push_body(&mut model, body, &body.joint, Some(places[parent.as_str()]));
                }
                (None, None) => push_body(&mut model, body, &body.joint, carrier),
                (None, Some((name, joint))) => {
                    let mut joint = JointDescription::new(name.to_owned(), joint, body.joint.placement);
                    (joint.dof.lower, joint.dof.upper) = self.pitch_limits;
                    push_body(&mut model, body, &joint, carrier);
                }
            }
        }
        model
    }

    pub(crate) fn add_contacts(&self, model: &mut Model, places: &HashMap<&str, usize>) -> Result<(), ModelError> {
        let mut names = HashSet::new();
        for contact in &self.contacts {
            let subject = format!("contact {:?}", contact.name);
            if !names.insert(&contact.name) {
                let problem = "the name is given twice; contact names must differ".to_owned();
                return Err(self.invalid_beside(contact.line, subject, problem));
            }
            let body = self.body(places, &contact.body, contact.line, &subject)?;
            model.contacts.push(ContactPoint { name: contact.name.clone(), body, position: contact.position });
        }
        Ok(())
    }

    pub(crate) fn add_frames(&self, model: &mut Model, places: &HashMap<&str, usize>) -> Result<(), ModelError> {
        let mut names: HashSet<_> = model.bodies.iter().map(|body| body.name.clone()).collect();
        for FrameDescription { name, body, placement, line } in &self.frames {
            let subject = format!("frame {name:?}");
            if name.trim().is_empty() {
                return Err(self.invalid_beside(*line, "a frame's name", "is empty".to_owned()));
            }
            if !names.insert(name.clone()) {
                let problem = "the name is given twice; names of frames and bodies must differ".to_owned();
                return Err(self.invalid_beside(*line, subject, problem));
            }
            let body = self.body(places, body, *line, &subject)?;
            model.frames.push(Frame { name: name.clone(), body, placement: *placement });
        }
        Ok(())
    }

    /// The index of a body that the file names.
    fn body(
        &self,
        places: &HashMap<&str, usize>,
        name: &str,
        line: Option<usize>,
        subject: &str,
    ) -> Result<usize, ModelError> {
        places.get(name).copied().ok_or_else(|| {
            let problem = format!("unknown body {name:?}; {}", self.known_bodies());
            self.invalid_beside(line, subject, problem)
        })
    }
}

fn push_body(model: &mut Model, body: &BodyDescription, joint: &JointDescription, parent: Option<usize>) {
    let index = model.bodies.len();
    let (q_index, v_index) = (model.nq(), model.nv());
    model.bodies.push(Body {
        name: body.name.clone(),
        parent,
        joint_name: joint.name.clone(),
        joint: joint.kind,
        placement: joint.placement,
        mass: body.mass,
        com: body.com,
        inertia: body.inertia,
        q_index,
        v_index,
    });
    model.dofs.extend(joint.kind.kind().velocities.iter().map(|(suffix, rotational)| Dof {
        name: format!("{}{suffix}", joint.name),
        rotational: *rotational,
        body: index,
        ..joint.dof.clone()
    }));
}
