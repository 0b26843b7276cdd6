//! Writing a model in its canonical form.

use nalgebra::Matrix3;
use toml::Spanned;

use crate::base::Base;
use crate::description::Inertias;
use crate::frame::Frame;
use crate::joints::{Form, Key, Revolute};
use crate::model::{Body, Dof, Follows, Model};
use crate::model_file::{BodyEntry, ContactEntry, FrameEntry, FullInertia, InertiaEntry, ModelFile};
use crate::roles::Roles;
use crate::table::Table;

impl Model {
    /// The complete model in the TOML format, every number to its last bit: reading it back gives the same model.
    ///
    /// Angles are in radians and rotations are matrices, which degrees could not promise. Two models with the same text
    /// move alike, so the text may serve for hashing.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.to_toml_with_roles(&Roles::default())
    }

    /// As [`Model::to_toml`], with `roles`: reading the text back gives them too.
    #[must_use]
    pub fn to_toml_with_roles(&self, roles: &Roles) -> String {
        let root = self.root();
        let pitch = &self.dofs.get(2).filter(|_| self.is_planar());
        let file = ModelFile {
            name: self.name.clone(),
            base: self.base,
            gravity_mps2: Some(self.gravity),
            torso: roles.torso.clone(),
            base_pitch: pitch.map(|pitch| numbers(pitch, Revolute::LIMITS)),
            feet: roles.feet.clone(),
            locked: Vec::new(),
            inertias: Inertias::Kept,
            forward: roles.forward,
            bodies: self.bodies[root..].iter().map(|body| spanned(self.body_entry(body))).collect(),
            contacts: self
                .contacts
                .iter()
                .enumerate()
                .map(|(index, contact)| {
                    spanned(ContactEntry {
                        name: contact.name.clone(),
                        body: self.bodies[contact.body].name.clone(),
                        position_m: contact.position.into(),
                        foot: roles.foot.get(index).cloned().flatten(),
                    })
                })
                .collect(),
            frames: self
                .frames
                .iter()
                .map(|Frame { name, body, placement }| {
                    spanned(FrameEntry {
                        name: name.clone(),
                        body: self.bodies[*body].name.clone(),
                        position_m: Some(placement.translation.into()),
                        rpy_deg: None,
                        rotation: rows(&placement.rotation),
                    })
                })
                .collect(),
            postures: roles.postures.clone(),
        };
        toml::to_string(&file).expect("strings, numbers and lists can be written as TOML")
    }

    fn body_entry(&self, body: &Body) -> BodyEntry {
        let i = &body.inertia;
        let full =
            FullInertia { xx: i[(0, 0)], yy: i[(1, 1)], zz: i[(2, 2)], xy: i[(0, 1)], xz: i[(0, 2)], yz: i[(1, 2)] };
        let one_number = self.is_planar() && *i == Matrix3::identity() * full.yy;
        let inertia = if one_number { InertiaEntry::Planar(full.yy) } else { InertiaEntry::Full(full) };
        let parent = body.parent.filter(|&parent| parent >= self.root());
        let has_joint = parent.is_some() || self.base == Base::Fixed;
        BodyEntry {
            name: body.name.clone(),
            parent: parent.map(|parent| self.bodies[parent].name.clone()),
            mass_kg: Some(body.mass),
            com_m: Some(body.com.into()),
            inertia_kgm2: Some(inertia),
            joint: has_joint.then(|| spanned(self.joint_table(body))),
        }
    }

    fn joint_table(&self, body: &Body) -> Table {
        let list = |numbers: [f64; 3]| numbers.to_vec();
        let mut table = Table::default();
        table.push("name", body.joint_name.clone());
        table.push("type", body.joint.type_name());
        if let Some(axis) = body.joint.axis() {
            table.push("axis", list(axis.into_inner().into()));
        }
        table.push("origin_m", list(body.placement.translation.into()));
        if let Some(rows) = rows(&body.placement.rotation) {
            table.push("origin_rotation", rows.map(list).to_vec());
        }
        if let Some(Follows { ratio, offset }) = body.follows {
            let mut leaders =
                self.bodies.iter().filter(|other| other.follows.is_none() && other.v_index == body.v_index);
            table.push(
                "follows",
                leaders.find(|other| other.nv() == 1).map_or("", |leader| &leader.joint_name).to_owned(),
            );
            table.push("ratio", ratio);
            table.push("offset", offset);
        }
        if body.nv() == 1 {
            let index = body.v_index;
            let dof = &self.dofs[index];
            table.append(numbers(dof, body.joint.kind().keys));
            table.push("actuated", dof.actuated);
        }
        table
    }
}

/// The rows of a rotation, where it is one.
fn rows(rotation: &Matrix3<f64>) -> Option<[[f64; 3]; 3]> {
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)]));
    (*rotation != Matrix3::identity()).then_some(rows)
}

/// The numbers of a coordinate under `keys`: without infinite limits, which are none, and springs that there are not.
fn numbers(dof: &Dof, keys: &[Key]) -> Table {
    let (mut dof, mut table) = (dof.clone(), Table::default());
    for key in keys {
        let value = *(key.of)(&mut dof);
        let written = match key.form {
            Form::Degrees => false,
            Form::Finite => value.is_finite(),
            Form::NonZero => value != 0.0,
        };
        if written {
            table.push(key.name, value);
        }
    }
    table
}

fn spanned<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}
