//! From the entries of a TOML model to SI units, each number checked alone.

use nalgebra::{Matrix3, Vector3};
use toml::Spanned;

use crate::base::Base;
use crate::content::Content;
use crate::description::{
    BodyDescription, ContactDescription, Description, FrameDescription, JointDescription, Leader,
};
use crate::error::{ModelError, Problems};
use crate::joints::{Fixed, Form, Joint, Key, Kind, Revolute};
use crate::model::{Dof, Model};
use crate::model_file::{BodyEntry, ContactEntry, FrameEntry, GRAVITY, InertiaEntry, ModelFile};
use crate::read::{Source, unit_axis};
use crate::roles::Roles;
use crate::spatial::{Placement, rotation_from_rpy};
use crate::table::Table;
use crate::words;

/// Reads a model; `base` overrides the file's own.
pub(crate) fn read_toml(text: &str, file_name: &str, base: Option<Base>) -> Result<(Model, Roles), ModelError> {
    let source = Source::new(file_name, text);
    let file: ModelFile = source.parse_toml(Content::Model, "a model: name, base and bodies")?;
    if file.base_pitch.is_some() && file.base != Base::Planar {
        let problem = "limits of a planar base, but the base is another; leave it out";
        return Err(source.invalid(None, "base_pitch", problem));
    }
    let base = base.unwrap_or(file.base);
    let (mut bodies, mut problems) = (Vec::with_capacity(file.bodies.len()), Problems::default());
    for entry in &file.bodies {
        let line = source.line(entry.span().start);
        bodies.extend(problems.keep(entry.get_ref().describe(&source, line, base)));
    }
    problems.none(file_name)?;
    Description {
        file: file_name.to_owned(),
        name: file.name,
        base,
        gravity: file.gravity_mps2.unwrap_or(GRAVITY),
        pitch_limits: pitch_limits(file.base_pitch, base, &source)?,
        bodies,
        contacts: contacts(&file.contacts, &source)?,
        frames: frames(&file.frames, &source)?,
        warnings: Vec::new(),
        inertias: file.inertias,
        locked: file.locked,
        locks_massless: false,
        roles: Roles {
            file: file_name.to_owned(),
            torso: file.torso,
            feet: file.feet,
            forward: file.forward,
            postures: file.postures,
            ..Roles::default()
        },
    }
    .build()
}

/// Limits of the root link's angle. Under another base than a planar one they are without effect, so that a file can be
/// loaded with its base overridden.
pub(crate) fn pitch_limits(limits: Option<Table>, base: Base, source: &Source) -> Result<(f64, f64), ModelError> {
    let joint = Joint::Revolute(Revolute { axis: Vector3::y_axis() });
    let mut pitch = JointDescription::new("base_pitch".to_owned(), joint, Placement::identity());
    if let Some(mut table) = limits.filter(|_| base == Base::Planar) {
        numbers(&mut table, joint.kind(), Revolute::LIMITS, &mut pitch.dof, source, None, &pitch.name)?;
        pitch.check_numbers().map_err(|problem| source.invalid(None, &pitch.name, problem))?;
    }
    Ok((pitch.dof.lower, pitch.dof.upper))
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
            foot: contact.foot.clone(),
            line,
        })
    };
    entries.iter().map(describe).collect()
}

pub(crate) fn frames(entries: &[Spanned<FrameEntry>], source: &Source) -> Result<Vec<FrameDescription>, ModelError> {
    let describe = |entry: &Spanned<FrameEntry>| {
        let (line, frame) = (source.line(entry.span().start), entry.get_ref());
        let subject = format!("frame {:?}", frame.name);
        let rotation = rotation(["rpy_deg", "rotation"], frame.rpy_deg, frame.rotation, source, line, &subject)?;
        let translation = source.vector(line, &subject, "position_m", frame.position_m.unwrap_or_default())?;
        let placement = Placement { rotation, translation };
        Ok(FrameDescription { name: frame.name.clone(), body: frame.body.clone(), placement, line })
    };
    entries.iter().map(describe).collect()
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
            (Some(table), _) => joint(table, source)?,
            (None, None) => JointDescription::new("base".to_owned(), Joint::Fixed(Fixed), Placement::identity()),
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

/// A joint from its table.
fn joint(table: &Spanned<Table>, source: &Source) -> Result<JointDescription, ModelError> {
    let line = source.line(table.span().start);
    let mut table = table.get_ref().clone();
    let missing = |key: &str| source.syntax(line, format!("missing field `{key}`"));
    let name: String = table.take(source, "name")?.ok_or_else(|| missing("name"))?;
    let subject = format!("joint {name:?}");
    let type_line = table.keys(source).find(|(key, _)| *key == "type").and_then(|(_, line)| line);
    let kind: String = table.take(source, "type")?.ok_or_else(|| missing("type"))?;
    let types = || Kind::ALL.iter().filter(|kind| kind.read.is_some());
    let Some(kind) = types().find(|known| known.name == kind) else {
        let names: Vec<_> = types().map(|kind| format!("`{}`", kind.name)).collect();
        let message = format!("unknown variant `{kind}`, expected one of {}", words::list(names));
        return Err(source.syntax(type_line, message));
    };
    let axis: Option<[f64; 3]> = table.take(source, "axis")?;
    let axis = || match axis {
        Some(axis) => unit_axis(source, line, &subject, axis),
        None => Err(source.invalid(line, &subject, "axis is missing, such as axis = [0, -1, 0]")),
    };
    let read = kind.read.expect("found among those that can be read");
    let origin: [f64; 3] = table.take(source, "origin_m")?.unwrap_or_default();
    let translation = source.vector(line, &subject, "origin_m", origin)?;
    let keys = ["origin_rpy_deg", "origin_rotation"];
    let (rpy, rows) = (table.take(source, keys[0])?, table.take(source, keys[1])?);
    let placement = Placement { rotation: rotation(keys, rpy, rows, source, line, &subject)?, translation };
    let mut joint = JointDescription::new(name.clone(), read(&axis)?, placement);
    if let Some(leader) = table.take(source, "follows")? {
        if kind.velocities.len() != 1 {
            let problem =
                format!("follows has no meaning for a {} joint; valid for revolute and prismatic ones", kind.name);
            return Err(source.invalid(line, subject, problem));
        }
        let mut number = |key: &str, default: f64| {
            let value = table.take(source, key)?.unwrap_or(default);
            source.finite(line, &subject, key, value)
        };
        joint.follows = Some(Leader { joint: leader, ratio: number("ratio", 1.0)?, offset: number("offset", 0.0)? });
        joint.line = line;
        numbers(&mut table, kind, &[], &mut joint.dof, source, line, &subject)?;
        return Ok(joint);
    }
    let actuated = table.take(source, "actuated")?.unwrap_or(true);
    joint.dof.actuated = actuated && joint.kind.nv() == 1;
    joint.line = line;
    numbers(&mut table, kind, kind.keys, &mut joint.dof, source, line, &subject)?;
    Ok(joint)
}

/// The numbers under `keys` of a joint's coordinate, which is all that is left of its table.
pub(crate) fn numbers(
    table: &mut Table,
    kind: &Kind,
    keys: &[Key],
    dof: &mut Dof,
    source: &Source,
    line: Option<usize>,
    subject: &str,
) -> Result<(), ModelError> {
    let given = |table: &Table, name: &str| table.keys(source).any(|(key, _)| key == name);
    for key in keys {
        if let Some(stem) = key.name.strip_suffix("_deg").filter(|_| given(table, key.name))
            && given(table, &format!("{stem}_rad"))
        {
            let problem = format!("{stem}_deg and {stem}_rad are both given; give one");
            return Err(source.invalid(line, subject, problem));
        }
        if let Some(value) = table.take(source, key.name)? {
            let value = source.finite(line, subject, key.name, value)?;
            *(key.of)(dof) = if key.form == Form::Degrees { value.to_radians() } else { value };
        }
    }
    // A limit of an angle on a sliding joint and the like would silently be without effect.
    let Some((foreign, at)) = table.keys(source).next() else { return Ok(()) };
    let valid: Vec<_> = match keys {
        [] => vec!["origin_m", "origin_rpy_deg"],
        _ => keys.iter().map(|key| key.name).collect(),
    };
    if Kind::ALL.iter().flat_map(|kind| kind.keys).any(|key| key.name == foreign) {
        let problem = format!("{foreign} has no meaning for a {} joint; valid are {}", kind.name, words::list(valid));
        return Err(source.invalid(line, subject, problem));
    }
    Err(source.syntax(at, format!("unknown field `{foreign}`, expected one of {}", words::list(valid))))
}

/// A rotation that is given by fixed-axis roll, pitch, yaw, by its rows (under one of two `keys`) or not at all.
fn rotation(
    keys: [&str; 2],
    rpy_deg: Option<[f64; 3]>,
    rows: Option<[[f64; 3]; 3]>,
    source: &Source,
    line: Option<usize>,
    subject: &str,
) -> Result<Matrix3<f64>, ModelError> {
    match (rpy_deg, rows) {
        (None, None) => Ok(Matrix3::identity()),
        (Some(_), Some(_)) => {
            Err(source.invalid(line, subject, format!("{} and {} are both given; give one", keys[0], keys[1])))
        }
        (Some(rpy), None) => {
            let rpy = source.vector(line, subject, keys[0], rpy)?;
            Ok(rotation_from_rpy([rpy.x.to_radians(), rpy.y.to_radians(), rpy.z.to_radians()]))
        }
        (None, Some(rows)) => {
            let rotation = Matrix3::from_fn(|i, j| rows[i][j]);
            let error = (rotation * rotation.transpose() - Matrix3::identity()).abs().max();
            // Written so that NaN fails
            if !(error < 1e-9 && rotation.determinant() > 0.0) {
                let problem = format!("{} is no rotation matrix (rows orthonormal, determinant 1)", keys[1]);
                return Err(source.invalid(line, subject, problem));
            }
            Ok(rotation)
        }
    }
}
