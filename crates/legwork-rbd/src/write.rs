//! Writing a model in its canonical form.

use toml::Spanned;

use crate::joint::{Base, Joint};
use crate::model::{Body, Model};
use crate::model_file::{
    BodyEntry, ContactEntry, FullInertia, InertiaEntry, JointEntry, JointType, ModelFile, PitchLimits,
};

impl Model {
    /// The complete model in the TOML format, every number to its last bit: reading it back gives the same model.
    ///
    /// Angles are in radians and rotations are matrices, which degrees could not promise. Two models with the same text
    /// move alike, so the text may serve for hashing.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let root = self.root();
        let pitch = &self.dofs.get(2).filter(|_| self.is_planar());
        let file = ModelFile {
            name: self.name.clone(),
            base: self.base,
            gravity_mps2: Some(self.gravity),
            torso: Some(self.bodies[self.torso].name.clone()),
            base_pitch: pitch.map(|pitch| PitchLimits {
                lower_rad: finite(pitch.lower),
                upper_rad: finite(pitch.upper),
                ..PitchLimits::default()
            }),
            feet: Some(self.feet.clone()),
            bodies: self.bodies[root..].iter().map(|body| spanned(self.body_entry(body))).collect(),
            contacts: self
                .contacts
                .iter()
                .map(|contact| {
                    spanned(ContactEntry {
                        name: contact.name.clone(),
                        body: self.bodies[contact.body].name.clone(),
                        position_m: contact.position.into(),
                        foot: Some(self.feet[contact.foot].clone()),
                    })
                })
                .collect(),
        };
        toml::to_string(&file).expect("strings, numbers and lists can be written as TOML")
    }

    fn body_entry(&self, body: &Body) -> BodyEntry {
        let i = &body.inertia;
        let full =
            FullInertia { xx: i[(0, 0)], yy: i[(1, 1)], zz: i[(2, 2)], xy: i[(0, 1)], xz: i[(0, 2)], yz: i[(1, 2)] };
        let one_number = self.is_planar() && *i == nalgebra::Matrix3::identity() * full.yy;
        let inertia = if one_number { InertiaEntry::Planar(full.yy) } else { InertiaEntry::Full(full) };
        let parent = body.parent.filter(|&parent| parent >= self.root());
        let has_joint = parent.is_some() || self.base == Base::Fixed;
        BodyEntry {
            name: body.name.clone(),
            parent: parent.map(|parent| self.bodies[parent].name.clone()),
            mass_kg: Some(body.mass),
            com_m: Some(body.com.into()),
            inertia_kgm2: Some(inertia),
            joint: has_joint.then(|| spanned(self.joint_entry(body))),
        }
    }

    fn joint_entry(&self, body: &Body) -> JointEntry {
        let rotation = &body.placement.rotation;
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)]));
        let (kind, axis) = match &body.joint {
            Joint::Revolute { axis } => (JointType::Revolute, Some(axis)),
            Joint::Prismatic { axis } => (JointType::Prismatic, Some(axis)),
            Joint::Fixed | Joint::Floating => (JointType::Fixed, None),
        };
        let dof = axis.map(|_| &self.dofs[body.v_index]);
        let turning = dof.filter(|_| kind == JointType::Revolute);
        let sliding = dof.filter(|_| kind == JointType::Prismatic);
        JointEntry {
            name: body.joint_name.clone(),
            r#type: kind,
            axis: axis.map(|axis| axis.into_inner().into()),
            origin_m: Some(body.placement.translation.into()),
            origin_rpy_deg: None,
            origin_rotation: (*rotation != nalgebra::Matrix3::identity()).then_some(rows),
            lower_deg: None,
            upper_deg: None,
            lower_rad: turning.and_then(|dof| finite(dof.lower)),
            upper_rad: turning.and_then(|dof| finite(dof.upper)),
            lower_m: sliding.and_then(|dof| finite(dof.lower)),
            upper_m: sliding.and_then(|dof| finite(dof.upper)),
            max_velocity_radps: turning.and_then(|dof| finite(dof.velocity_limit)),
            max_velocity_mps: sliding.and_then(|dof| finite(dof.velocity_limit)),
            max_torque_nm: turning.and_then(|dof| finite(dof.effort_limit)),
            max_force_n: sliding.and_then(|dof| finite(dof.effort_limit)),
            damping_nmspr: turning.map(|dof| dof.damping),
            damping_nspm: sliding.map(|dof| dof.damping),
            actuated: dof.map(|dof| dof.actuated),
        }
    }
}

/// An infinite limit is none.
fn finite(limit: f64) -> Option<f64> {
    limit.is_finite().then_some(limit)
}

fn spanned<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}
