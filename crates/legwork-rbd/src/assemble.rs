//! Puts a [`Model`] together: the base's own joints, indices, contact points, frames.

use std::collections::{HashMap, HashSet};

use nalgebra::{Matrix3, Vector3};

use crate::description::{BodyDescription, Description, FrameDescription, JointDescription};
use crate::error::{ModelError, Problems};
use crate::frame::Frame;
use crate::model::{Body, ContactPoint, Dof, Follows, Model};
use crate::spatial::Placement;
use crate::words;

impl Description {
    /// The bodies' indices in the model by name, of bodies in this `order`.
    pub(crate) fn places(&self, order: &[usize]) -> HashMap<&str, usize> {
        let virtual_bodies = self.base.joints().len().saturating_sub(1);
        order.iter().enumerate().map(|(i, &index)| (self.bodies[index].name.as_str(), virtual_bodies + i)).collect()
    }

    pub(crate) fn assemble(&self, order: &[usize], places: &HashMap<&str, usize>) -> Result<Model, ModelError> {
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
        self.couple(&mut model)?;
        Ok(model)
    }

    /// Gives the joints that follow others the coordinates of those, and adds to them what damping they have.
    fn couple(&self, model: &mut Model) -> Result<(), ModelError> {
        let joints: HashMap<_, _> = self.bodies.iter().map(|body| (&body.joint.name, &body.joint)).collect();
        let places: HashMap<_, _> =
            model.bodies.iter().enumerate().map(|(index, body)| (body.joint_name.clone(), index)).collect();
        for index in 0..model.bodies.len() {
            let Some(joint) = joints.get(&model.bodies[index].joint_name).filter(|joint| joint.follows.is_some())
            else {
                continue;
            };
            let invalid = |problem: String| self.invalid(joint.line, format!("joint {:?}", joint.name), problem);
            let (mut ratio, mut offset, mut at, mut seen) = (1.0, 0.0, *joint, HashSet::new());
            while let Some(leader) = &at.follows {
                (ratio, offset) = (ratio * leader.ratio, ratio * leader.offset + offset);
                if !seen.insert(&leader.joint) {
                    return Err(invalid(format!(
                        "follows itself, by way of {:?}; name a joint that moves freely",
                        leader.joint
                    )));
                }
                at = *joints.get(&leader.joint).ok_or_else(|| {
                    let valid = words::list(self.bodies.iter().map(|body| &body.joint.name));
                    invalid(format!("follows the unknown joint {:?}; valid are {valid}", leader.joint))
                })?;
            }
            let leader = places.get(&at.name).map(|&leader| &model.bodies[leader]).filter(|leader| leader.nv() == 1);
            let Some(&Body { q_index, v_index, .. }) = leader else {
                return Err(invalid(format!(
                    "follows {:?}, which has no coordinate; name a revolute or a prismatic joint",
                    at.name
                )));
            };
            let body = &mut model.bodies[index];
            (body.q_index, body.v_index, body.follows) = (q_index, v_index, Some(Follows { ratio, offset }));
            model.dofs[v_index].damping += ratio * ratio * joint.dof.damping;
        }
        Ok(())
    }

    pub(crate) fn add_contacts(&self, model: &mut Model, places: &HashMap<&str, usize>, problems: &mut Problems) {
        let mut names = HashSet::new();
        for contact in &self.contacts {
            let subject = format!("contact {:?}", contact.name);
            if !names.insert(&contact.name) {
                let problem = "the name is given twice; contact names must differ".to_owned();
                problems.add(self.invalid_beside(contact.line, subject, problem));
            } else if let Some(body) = problems.keep(self.body(places, &contact.body, contact.line, &subject)) {
                model.contacts.push(ContactPoint { name: contact.name.clone(), body, position: contact.position });
            }
        }
    }

    pub(crate) fn add_frames(&self, model: &mut Model, places: &HashMap<&str, usize>, problems: &mut Problems) {
        let mut names: HashSet<_> = model.bodies.iter().map(|body| body.name.clone()).collect();
        for FrameDescription { name, body, placement, line } in &self.frames {
            let subject = format!("frame {name:?}");
            if name.trim().is_empty() {
                problems.add(self.invalid_beside(*line, "a frame's name", "is empty".to_owned()));
            } else if !names.insert(name.clone()) {
                let problem = "the name is given twice; names of frames and bodies must differ".to_owned();
                problems.add(self.invalid_beside(*line, subject, problem));
            } else if let Some(body) = problems.keep(self.body(places, body, *line, &subject)) {
                model.frames.push(Frame { name: name.clone(), body, placement: *placement });
            }
        }
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
        follows: joint.follows.as_ref().map(|leader| Follows { ratio: leader.ratio, offset: leader.offset }),
    });
    if joint.follows.is_some() {
        return;
    }
    model.dofs.extend(joint.kind.kind().velocities.iter().map(|(suffix, rotational)| Dof {
        name: format!("{}{suffix}", joint.name),
        rotational: *rotational,
        body: index,
        ..joint.dof.clone()
    }));
}
