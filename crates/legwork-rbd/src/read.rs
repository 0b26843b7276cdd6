//! Reading model files: from the disk, and the checks that every text format shares.

use std::path::Path;

use nalgebra::{Unit, Vector3};
use serde::de::DeserializeOwned;

use crate::base::Base;
use crate::content::Content;
use crate::error::ModelError;
use crate::file::{self, Lines, Unread};
use crate::mjcf::read_mjcf;
use crate::model::Model;
use crate::read_toml::read_toml;
use crate::roles::Roles;
use crate::urdf::read_urdf;
use crate::words::list;

impl Model {
    /// Reads a model from a `.toml`, a `.urdf` or an MJCF file (`.xml`, `.mjcf`). Beside `robot.urdf` or `robot.xml`,
    /// `robot.legwork.toml` is read if it exists ([`Model::from_urdf`] has its keys). A file that ends on `.xml` may hold a
    /// URDF too.
    ///
    /// # Errors
    /// If the file cannot be read ([`ModelError::is_io`]) or does not describe a possible robot.
    pub fn load(path: &Path) -> Result<Model, ModelError> {
        Self::load_with_base(path, None)
    }

    /// As [`Model::load`], with another base than the file names.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_with_base(path: &Path, base: Option<Base>) -> Result<Model, ModelError> {
        Self::load_with_roles(path, base).map(|(model, _)| model)
    }

    /// As [`Model::load_with_base`], with what else the file says.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_with_roles(path: &Path, base: Option<Base>) -> Result<(Model, Roles), ModelError> {
        let file = path.display().to_string();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "toml" => read_toml(&read_text(path)?, &file, base),
            "urdf" | "xml" | "mjcf" => {
                let text = read_as(path, file::read_xml)?;
                let beside = path.with_extension("legwork.toml");
                let side_text = if beside.exists() { Some(read_text(&beside)?) } else { None };
                let side_name = beside.display().to_string();
                let sidecar = side_text.as_deref().map(|text| (text, side_name.as_str()));
                if extension == "urdf" || (extension == "xml" && is_urdf(&text)) {
                    return read_urdf(&text, &file, sidecar, base);
                }
                let folder = path.parent().unwrap_or(Path::new(""));
                read_mjcf(&text, &file, sidecar, base, &|name| file::read(&folder.join(name), file::MESH))
            }
            _ if path.is_dir() => read_text(path).and(Err(ModelError::UnknownKind { file })),
            _ => Err(ModelError::UnknownKind { file }),
        }
    }

    /// Reads a model from TOML; `file_name` is used in messages only.
    ///
    /// # Errors
    /// If the text does not describe a possible robot.
    pub fn from_toml(text: &str, file_name: &str) -> Result<Model, ModelError> {
        Self::from_toml_with_base(text, file_name, None)
    }

    /// As [`Model::from_toml`], with another base than the text names.
    ///
    /// # Errors
    /// As [`Model::from_toml`].
    pub fn from_toml_with_base(text: &str, file_name: &str, base: Option<Base>) -> Result<Model, ModelError> {
        Self::from_toml_with_roles(text, file_name, base).map(|(model, _)| model)
    }

    /// As [`Model::from_toml_with_base`], with what else the text says.
    ///
    /// # Errors
    /// As [`Model::from_toml`].
    pub fn from_toml_with_roles(text: &str, file: &str, base: Option<Base>) -> Result<(Model, Roles), ModelError> {
        read_toml(text, file, base)
    }

    /// Reads a model from URDF, with what URDF cannot say from the TOML text `sidecar` (text, name).
    ///
    /// The side file's keys are all optional: `base` ("floating" if not given; the argument `base` overrides it),
    /// `gravity_mps2` (9.81), `base_pitch` (limits, planar base), `contacts`, `frames` and the [`Roles`] `torso` and `feet` as in
    /// a TOML model, either `actuated` or `passive`, a list of joints (every joint that moves is actuated), and `joints`, a
    /// table for each joint to which it gives limits, a damper, a spring or stops by the keys of a TOML model:
    /// `joints.left_ankle = { spring_nmpr = 200.0, rest_deg = 5.0 }`.
    ///
    /// Fixed joints are kept, as bodies that are rigidly attached. Continuous joints are revolute ones without ends. Meshes
    /// and other shapes, transmissions and Gazebo's elements are not read, nor is what has the prefix of a namespace. A
    /// warning tells of all else that has no meaning, such as a misspelled key, and of Coulomb friction, which is ignored.
    ///
    /// A joint that mimics another one is coupled to it exactly and has no coordinate of its own; `mimic = "free"` makes it a joint
    /// as others are, `mimic = "locked"` a fixed one. A planar joint is two bodies without mass that slide and one that turns,
    /// `JOINT_x`, `JOINT_y` and `JOINT`; a floating joint between a root link without mass and all the rest is the robot's base.
    /// An inertia that no body has stays as it is, with a warning, as long as the mass matrix is positive definite;
    /// `inertias = "repaired"` changes it to the nearest that a body can have.
    ///
    /// Of limits, `effort="0"` is a joint that can give no torque, in TOML too. `velocity="0"`, which tools write where they
    /// know no limit, is none, and so are `lower` and `upper` that are both zero. A warning tells of each, and of one that is
    /// missing.
    ///
    /// # Errors
    /// If a text is malformed or does not describe a possible robot: loops, several roots, numbers that are none. The message names
    /// all that was found, each with its line, link or joint, and key ([`ModelError::Several`]).
    pub fn from_urdf(
        text: &str,
        file_name: &str,
        sidecar: Option<(&str, &str)>,
        base: Option<Base>,
    ) -> Result<Model, ModelError> {
        Self::from_urdf_with_roles(text, file_name, sidecar, base).map(|(model, _)| model)
    }

    /// As [`Model::from_urdf`], with what else the texts say.
    ///
    /// # Errors
    /// As [`Model::from_urdf`].
    pub fn from_urdf_with_roles(
        text: &str,
        file_name: &str,
        sidecar: Option<(&str, &str)>,
        base: Option<Base>,
    ) -> Result<(Model, Roles), ModelError> {
        read_urdf(text, file_name, sidecar, base)
    }

    /// Reads a model from MJCF, the language of MuJoCo, with the side file `sidecar` (text, name) whose keys are those of
    /// [`Model::from_urdf`]. `files` are the included files and the meshes that it names, each with its path from the
    /// model's folder.
    ///
    /// A tree of bodies of the world is the robot, the one with joints; on a free joint its base is floating, otherwise
    /// fixed. Bodies keep their names and frames and joints their coordinates: a body with several joints, or with one beside
    /// its origin, is carried by bodies without mass. Mass and inertia are those of `<inertial>` or of the shapes, as the
    /// compiler's settings say; STL and OBJ files are read where a mesh is to give them. A joint is driven that has an
    /// actuator, all are where the file has no actuators; its effort limit is the least of gear times control range, gear
    /// times force range and the joint's own range of forces. Sites are named frames, shapes are the [`Roles::geometry`].
    ///
    /// A warning tells of what is ignored, such as equality constraints, tendons and friction in joints.
    ///
    /// # Errors
    /// If a text is malformed, a file is missing or the robot is not possible. The message names file, line and key.
    pub fn from_mjcf(
        text: &str,
        file_name: &str,
        sidecar: Option<(&str, &str)>,
        base: Option<Base>,
        files: &[(&str, &[u8])],
    ) -> Result<Model, ModelError> {
        Self::from_mjcf_with_roles(text, file_name, sidecar, base, files).map(|(model, _)| model)
    }

    /// As [`Model::from_mjcf`], with what else the texts say.
    ///
    /// # Errors
    /// As [`Model::from_mjcf`].
    pub fn from_mjcf_with_roles(
        text: &str,
        file_name: &str,
        sidecar: Option<(&str, &str)>,
        base: Option<Base>,
        files: &[(&str, &[u8])],
    ) -> Result<(Model, Roles), ModelError> {
        let find = |name: &str| match files.iter().find(|(other, _)| *other == name) {
            Some((_, bytes)) => Ok(bytes.to_vec()),
            None => Err(file::Unread::Io(std::io::ErrorKind::NotFound.into())),
        };
        read_mjcf(text, file_name, sidecar, base, &find)
    }
}

/// Whether a text that ends on `.xml` is a URDF.
fn is_urdf(text: &str) -> bool {
    text.contains("<robot") && !text.contains("<mujoco")
}

/// A whole text file.
fn read_text(path: &Path) -> Result<String, ModelError> {
    read_as(path, file::read_text)
}

/// A whole text file, by the `reader` of its kind.
fn read_as(path: &Path, reader: fn(&Path, u64) -> Result<String, Unread>) -> Result<String, ModelError> {
    let name = path.display().to_string();
    if path.is_dir() {
        let mut names: Vec<String> = std::fs::read_dir(path)
            .into_iter()
            .flatten()
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| [".toml", ".urdf", ".xml", ".mjcf"].iter().any(|ending| name.ends_with(ending)))
            .collect();
        names.sort();
        let files = if names.is_empty() { String::new() } else { format!(": {}", list(names)) };
        return Err(ModelError::Folder { file: name, files });
    }
    reader(path, file::TEXT).map_err(|source| ModelError::Unread { file: name, source })
}

/// A text with its name, for messages with a place.
pub(crate) struct Source<'a> {
    file: &'a str,
    text: &'a str,
    lines: Lines,
}

impl<'a> Source<'a> {
    pub(crate) fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, lines: Lines::of(text) }
    }

    pub(crate) fn file(&self) -> &'a str {
        self.file
    }

    /// The line, from one, of a byte offset.
    pub(crate) fn line(&self, offset: usize) -> Option<usize> {
        (offset <= self.text.len()).then(|| self.lines.line(offset))
    }

    pub(crate) fn syntax(&self, line: Option<usize>, message: impl Into<String>) -> ModelError {
        ModelError::syntax(self.file, line, message)
    }

    pub(crate) fn invalid(
        &self,
        line: Option<usize>,
        subject: impl Into<String>,
        problem: impl Into<String>,
    ) -> ModelError {
        ModelError::invalid(self.file, line, subject, problem)
    }

    /// Parses TOML into `T`, which is `wanted`; `keys` says what the file should hold.
    pub(crate) fn parse_toml<T: DeserializeOwned>(&self, wanted: Content, keys: &str) -> Result<T, ModelError> {
        if self.text.trim().is_empty() {
            return Err(self.syntax(None, format!("is empty; it should hold {keys}")));
        }
        toml::from_str(self.text).map_err(|error| {
            if let Some(content) = Content::other_than(wanted, self.file, self.text) {
                return self.syntax(None, content.instead_of(wanted, self.file));
            }
            let line = error.span().and_then(|span| self.line(span.start));
            self.syntax(line, error.message())
        })
    }

    pub(crate) fn finite(&self, line: Option<usize>, subject: &str, key: &str, value: f64) -> Result<f64, ModelError> {
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.invalid(line, subject, format!("{key} is {value}; a finite number is needed")))
    }

    pub(crate) fn vector(
        &self,
        line: Option<usize>,
        subject: &str,
        key: &str,
        value: [f64; 3],
    ) -> Result<Vector3<f64>, ModelError> {
        for entry in value {
            self.finite(line, subject, key, entry)?;
        }
        Ok(Vector3::from(value))
    }
}

/// The direction of a joint's axis. One that has unit length already is kept to the last bit, so that a model that was
/// written is read back the same.
pub(crate) fn unit_axis(
    source: &Source,
    line: Option<usize>,
    subject: &str,
    axis: [f64; 3],
) -> Result<Unit<Vector3<f64>>, ModelError> {
    let axis = source.vector(line, subject, "axis", axis)?;
    // Scaled first: the squares of very large and very small entries leave the range of numbers
    let largest = axis.amax();
    if largest == 0.0 {
        return Err(source.invalid(line, subject, "axis is zero; give a direction, such as [0, -1, 0]"));
    }
    if (axis.norm_squared() - 1.0).abs() < 1e-15 {
        return Ok(Unit::new_unchecked(axis));
    }
    let scaled = axis / largest;
    Ok(Unit::new_unchecked(scaled / libm::sqrt(scaled.norm_squared())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_of_any_length_gives_its_direction() {
        let source = Source::new("robot.toml", "");
        let direction = |axis| unit_axis(&source, None, "joint \"a\"", axis);
        // Squares of these sizes are no numbers, or zero.
        for size in [1.0, 5.0, 1e-3, 1e200, 1e-200] {
            let found = direction([0.0, -3.0 * size, 4.0 * size]).expect("a direction");
            assert!((*found - Vector3::new(0.0, -0.6, 0.8)).norm() < 1e-15, "{size}: {found:?}");
        }
        // One of unit length is kept to the last bit.
        let third = 1.0 / 3.0_f64.sqrt();
        assert_eq!(direction([third; 3]).expect("a direction").as_slice(), [third; 3]);
        assert!(direction([0.0; 3]).expect_err("none").to_string().contains("axis is zero"));
    }
}
