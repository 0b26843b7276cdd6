//! From the entries of a TOML model to SI units, each number checked alone.

use nalgebra::Matrix3;
use toml::Spanned;

use crate::description::{BodyDescription, ContactDescription, Description, JointDescription};
use crate::error::ModelError;
use crate::joint::{Base, Joint, Placement, rotation_from_rpy};
use crate::model::Model;
use crate::model_file::{
    BodyEntry, ContactEntry, GRAVITY, InertiaEntry, JointEntry, JointType, ModelFile, PitchLimits,
};
use crate::read::{Source, unit_axis};

/// Reads a model; `base` overrides the file's own.
pub(crate) fn read_toml(text: &str, file_name: &str, base: Option<Base>) -> Result<Model, ModelError> {
    let source = Source::new(file_name, text);
    let file: ModelFile = source.parse_toml("a model: name, base and bodies")?;
    if file.base_pitch.is_some() && file.base != Base::Planar {
        let problem = "limits of a planar base, but the base is another; leave it out";
        return Err(source.invalid(None, "base_pitch", problem));
    }
    let base = base.unwrap_or(file.base);
    let mut bodies = Vec::with_capacity(file.bodies.len());
    for entry in &file.bodies {
        let line = source.line(entry.span().start);
        bodies.push(entry.get_ref().describe(&source, line, base)?);
    }
    Description {
        file: file_name.to_owned(),
        name: file.name,
        base,
        gravity: file.gravity_mps2.unwrap_or(GRAVITY),
        torso: file.torso,
        pitch_limits: pitch_limits(file.base_pitch, base, &source)?,
        feet: file.feet,
        bodies,
        contacts: contacts(&file.contacts, &source)?,
        warnings: Vec::new(),
        side_file: file_name.to_owned(),
    }
    .build()
}

/// Limits of the root link's angle [rad]. Under another base than a planar one they are without effect, so that a file can
/// be loaded with its base overridden.
pub(crate) fn pitch_limits(limits: Option<PitchLimits>, base: Base, source: &Source) -> Result<(f64, f64), ModelError> {
    let subject = "base_pitch";
    let limits = limits.unwrap_or_default();
    if base != Base::Planar {
        return Ok((f64::NEG_INFINITY, f64::INFINITY));
    }
    let angle = |deg, rad, key| angle(source, None, subject, deg, rad, key);
    let lower = angle(limits.lower_deg, limits.lower_rad, "lower")?.unwrap_or(f64::NEG_INFINITY);
    let upper = angle(limits.upper_deg, limits.upper_rad, "upper")?.unwrap_or(f64::INFINITY);
    if lower > upper {
        let problem = format!("limits are crossed: lower {lower} is above upper {upper} rad");
        return Err(source.invalid(None, subject, problem));
    }
    Ok((lower, upper))
}

pub(crate) fn contacts(
    entries: &[Spanned<ContactEntry>],
    source: &Source,
) -> Result<Vec<ContactDescription>, ModelError> {
    let describe = |entry: &Spanned<ContactEntry>| {
        let (line, contact) = (source.line(entry.span().start), entry.get_ref());
        let subject = format!("contact {:?}", contact.name);
        Ok(ContactDescription {
            name: contact.name.clone(),
            body: contact.body.clone(),
            position: source.vector(line, &subject, "position_m", contact.position_m)?,
            foot: contact.foot.clone().unwrap_or_else(|| contact.name.clone()),
            line,
        })
    };
    entries.iter().map(describe).collect()
}

/// An angle that may be given in degrees or in radians [rad].
fn angle(
    source: &Source,
    line: Option<usize>,
    subject: &str,
    deg: Option<f64>,
    rad: Option<f64>,
    key: &str,
) -> Result<Option<f64>, ModelError> {
    match (deg, rad) {
        (Some(_), Some(_)) => {
            Err(source.invalid(line, subject, format!("{key}_deg and {key}_rad are both given; give one")))
        }
        (Some(deg), None) => Ok(Some(source.finite(line, subject, &format!("{key}_deg"), deg)?.to_radians())),
        (None, Some(rad)) => Ok(Some(source.finite(line, subject, &format!("{key}_rad"), rad)?)),
        (None, None) => Ok(None),
    }
}

impl BodyEntry {
    fn describe(&self, source: &Source, line: Option<usize>, base: Base) -> Result<BodyDescription, ModelError> {
        let subject = format!("body {:?}", self.name);
        let inertia = match self.inertia_kgm2 {
            None => Matrix3::zeros(),
            Some(InertiaEntry::Planar(about_y)) if base == Base::Planar => {
                Matrix3::identity() * source.finite(line, &subject, "inertia_kgm2", about_y)?
            }
            Some(InertiaEntry::Planar(about_y)) => {
                let problem = format!(
                    "inertia_kgm2 = {about_y} is a single number, which only a planar model may have; \
                     valid is {{ xx, yy, zz }}, and xy, xz, yz where they are not zero"
                );
                return Err(source.invalid(line, subject, problem));
            }
            Some(InertiaEntry::Full(i)) => {
                let entries = [i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz];
                for entry in entries {
                    source.finite(line, &subject, "inertia_kgm2", entry)?;
                }
                Matrix3::from_row_slice(&entries)
            }
        };
        let joint = match (&self.joint, &self.parent) {
            (Some(joint), _) => {
                let line = source.line(joint.span().start);
                joint.get_ref().describe(source, line)?
            }
            (None, None) => JointDescription::new("base".to_owned(), Joint::Fixed, Placement::identity()),
            (None, Some(_)) => {
                let problem = "has a parent but no joint; add joint = { name = …, type = \"revolute\", axis = … }";
                return Err(source.invalid(line, subject, problem));
            }
        };
        Ok(BodyDescription {
            name: self.name.clone(),
            parent: self.parent.clone(),
            mass: source.finite(line, &subject, "mass_kg", self.mass_kg.unwrap_or(0.0))?,
            com: source.vector(line, &subject, "com_m", self.com_m.unwrap_or_default())?,
            inertia,
            joint,
            line,
        })
    }
}

impl JointEntry {
    fn describe(&self, source: &Source, line: Option<usize>) -> Result<JointDescription, ModelError> {
        let subject = format!("joint {:?}", self.name);
        self.refuse_foreign_keys(source, line, &subject)?;
        let kind = match (self.r#type, self.axis) {
            (JointType::Fixed, _) => Joint::Fixed,
            (_, None) => {
                return Err(source.invalid(line, subject, "axis is missing, such as axis = [0, -1, 0]"));
            }
            (JointType::Revolute, Some(axis)) => Joint::Revolute { axis: unit_axis(source, line, &subject, axis)? },
            (JointType::Prismatic, Some(axis)) => Joint::Prismatic { axis: unit_axis(source, line, &subject, axis)? },
        };
        let translation = source.vector(line, &subject, "origin_m", self.origin_m.unwrap_or_default())?;
        let placement = Placement { rotation: self.rotation(source, line, &subject)?, translation };
        let mut joint = JointDescription::new(self.name.clone(), kind, placement);
        let finite = |value: Option<f64>, key: &str, otherwise: f64| match value {
            Some(value) => source.finite(line, &subject, key, value),
            None => Ok(otherwise),
        };
        let infinite = f64::INFINITY;
        if self.r#type == JointType::Prismatic {
            joint.lower = finite(self.lower_m, "lower_m", -infinite)?;
            joint.upper = finite(self.upper_m, "upper_m", infinite)?;
            joint.velocity_limit = finite(self.max_velocity_mps, "max_velocity_mps", infinite)?;
            joint.effort_limit = finite(self.max_force_n, "max_force_n", infinite)?;
            joint.damping = finite(self.damping_nspm, "damping_nspm", 0.0)?;
        } else {
            let angle = |deg, rad, key| angle(source, line, &subject, deg, rad, key);
            joint.lower = angle(self.lower_deg, self.lower_rad, "lower")?.unwrap_or(-infinite);
            joint.upper = angle(self.upper_deg, self.upper_rad, "upper")?.unwrap_or(infinite);
            joint.velocity_limit = finite(self.max_velocity_radps, "max_velocity_radps", infinite)?;
            joint.effort_limit = finite(self.max_torque_nm, "max_torque_nm", infinite)?;
            joint.damping = finite(self.damping_nmspr, "damping_nmspr", 0.0)?;
        }
        joint.actuated = self.r#type != JointType::Fixed && self.actuated.unwrap_or(true);
        joint.line = line;
        Ok(joint)
    }

    /// A limit of an angle on a sliding joint and the like: silently without effect if it were let through.
    fn refuse_foreign_keys(&self, source: &Source, line: Option<usize>, subject: &str) -> Result<(), ModelError> {
        let revolute = [
            ("lower_deg", self.lower_deg),
            ("upper_deg", self.upper_deg),
            ("lower_rad", self.lower_rad),
            ("upper_rad", self.upper_rad),
            ("max_velocity_radps", self.max_velocity_radps),
            ("max_torque_nm", self.max_torque_nm),
            ("damping_nmspr", self.damping_nmspr),
        ];
        let prismatic = [
            ("lower_m", self.lower_m),
            ("upper_m", self.upper_m),
            ("max_velocity_mps", self.max_velocity_mps),
            ("max_force_n", self.max_force_n),
            ("damping_nspm", self.damping_nspm),
        ];
        let list = |keys: &[(&str, Option<f64>)]| keys.iter().map(|key| key.0).collect::<Vec<_>>().join(", ");
        let given = |keys: &[(&str, Option<f64>)]| keys.iter().find(|key| key.1.is_some()).map(|key| key.0.to_owned());
        let (foreign, valid) = match self.r#type {
            JointType::Revolute => (given(&prismatic), list(&revolute)),
            JointType::Prismatic => (given(&revolute), list(&prismatic)),
            JointType::Fixed => (given(&revolute).or_else(|| given(&prismatic)), "origin_m, origin_rpy_deg".to_owned()),
        };
        match foreign {
            Some(key) => {
                let kind = match self.r#type {
                    JointType::Fixed => "fixed",
                    JointType::Revolute => "revolute",
                    JointType::Prismatic => "prismatic",
                };
                Err(source.invalid(
                    line,
                    subject,
                    format!("{key} has no meaning for a {kind} joint; valid are {valid}"),
                ))
            }
            None => Ok(()),
        }
    }

    fn rotation(&self, source: &Source, line: Option<usize>, subject: &str) -> Result<Matrix3<f64>, ModelError> {
        match (self.origin_rpy_deg, self.origin_rotation) {
            (None, None) => Ok(Matrix3::identity()),
            (Some(_), Some(_)) => {
                Err(source.invalid(line, subject, "origin_rpy_deg and origin_rotation are both given; give one"))
            }
            (Some(rpy), None) => {
                let rpy = source.vector(line, subject, "origin_rpy_deg", rpy)?;
                Ok(rotation_from_rpy([rpy.x.to_radians(), rpy.y.to_radians(), rpy.z.to_radians()]))
            }
            (None, Some(rows)) => {
                let rotation = Matrix3::from_fn(|i, j| rows[i][j]);
                let error = (rotation * rotation.transpose() - Matrix3::identity()).abs().max();
                // Written so that NaN fails
                if !(error < 1e-9 && rotation.determinant() > 0.0) {
                    let problem = "origin_rotation is no rotation matrix (rows orthonormal, determinant 1)";
                    return Err(source.invalid(line, subject, problem));
                }
                Ok(rotation)
            }
        }
    }
}
