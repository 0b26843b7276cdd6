//! What `<compiler>` and `<option>` say of a whole file.

use nalgebra::{Matrix3, Vector3};

use super::files::Tree;
use crate::error::ModelError;
use crate::model_file::GRAVITY;
use crate::spatial::rotation_about;
use crate::words::quoted;
use crate::xml::{Element, Ignored};

/// How a file is to be read. Where several elements say it, the last one does.
pub(super) struct Compiler {
    degrees: bool,
    /// The axes of three turns, and whether they stand still.
    sequence: [(usize, bool); 3],
    /// None: where no inertia is given.
    pub(super) inertia_from_geoms: Option<bool>,
    pub(super) inertia_groups: [f64; 2],
    pub(super) bound_mass: f64,
    pub(super) bound_inertia: f64,
    pub(super) balance_inertia: bool,
    pub(super) total_mass: Option<f64>,
    pub(super) mesh_folder: String,
    pub(super) strip_path: bool,
    /// Along z [m/s²].
    pub(super) gravity: f64,
}

const KEYS: &[&str] = &[
    "autolimits",
    "boundmass",
    "boundinertia",
    "settotalmass",
    "balanceinertia",
    "strippath",
    "coordinate",
    "angle",
    "fitaabb",
    "eulerseq",
    "meshdir",
    "texturedir",
    "discardvisual",
    "convexhull",
    "exactmeshinertia",
    "fusestatic",
    "inertiafromgeom",
    "inertiagrouprange",
    "saveinertial",
    "assetdir",
    "alignfree",
    "conflict",
];

impl Compiler {
    pub(super) fn read(tree: &Tree, ignored: &mut Ignored, sentences: &mut Vec<String>) -> Result<Self, ModelError> {
        let mut compiler = Self {
            degrees: true,
            sequence: [(0, false), (1, false), (2, false)],
            inertia_from_geoms: None,
            inertia_groups: [0.0, 5.0],
            bound_mass: 0.0,
            bound_inertia: 0.0,
            balance_inertia: false,
            total_mass: None,
            mesh_folder: String::new(),
            strip_path: false,
            gravity: GRAVITY,
        };
        for element in tree.sections("compiler") {
            let element = element.of("compiler");
            ignored.note(&element, &["lengthrange"], KEYS);
            compiler.update(element)?;
        }
        for element in tree.sections("option") {
            compiler.options(tree, element.of("option"), sentences)?;
        }
        Ok(compiler)
    }

    fn update(&mut self, element: Element) -> Result<(), ModelError> {
        let chosen = |key: &str, valid: &[&str]| match element.get(key).map(str::trim) {
            None => Ok(None),
            Some(text) => match valid.iter().position(|known| *known == text) {
                Some(index) => Ok(Some(index)),
                None => Err(element.refused_at(key, &format!("valid are {}", valid.join(", ")))),
            },
        };
        if let Some(angle) = chosen("angle", &["degree", "radian"])? {
            self.degrees = angle == 0;
        }
        if chosen("coordinate", &["local", "global"])? == Some(1) {
            let needed =
                "global coordinates are no longer read by anyone; save the file with local ones by MuJoCo 2.3.3";
            return Err(element.refused_at("coordinate", needed));
        }
        if let Some(chosen) = chosen("inertiafromgeom", &["false", "true", "auto"])? {
            self.inertia_from_geoms = [Some(false), Some(true), None][chosen];
        }
        self.balance_inertia = chosen("balanceinertia", &["false", "true"])?.map_or(self.balance_inertia, |on| on == 1);
        self.strip_path = chosen("strippath", &["false", "true"])?.map_or(self.strip_path, |on| on == 1);
        chosen("autolimits", &["false", "true"])?;
        if let Some(text) = element.get("eulerseq") {
            self.sequence = sequence(text).ok_or_else(|| {
                element.refused_at("eulerseq", "three of x, y, z, X, Y, Z are needed, such as \"xyz\"")
            })?;
        }
        self.inertia_groups = element.numbers("inertiagrouprange")?.unwrap_or(self.inertia_groups);
        self.bound_mass = element.number("boundmass")?.unwrap_or(self.bound_mass);
        self.bound_inertia = element.number("boundinertia")?.unwrap_or(self.bound_inertia);
        if let Some(mass) = element.number("settotalmass")? {
            self.total_mass = (mass > 0.0).then_some(mass);
        }
        if let Some(folder) = element.get("meshdir").or(element.get("assetdir")) {
            self.mesh_folder = folder.to_owned();
        }
        Ok(())
    }

    fn options(&mut self, tree: &Tree, element: Element, sentences: &mut Vec<String>) -> Result<(), ModelError> {
        if let Some([x, y, z]) = element.numbers::<3>("gravity")? {
            // A nudge lets a pendulum fall that stands upright.
            if z > 0.0 || x.abs().max(y.abs()) > -1e-4 * z {
                return Err(element.refused_at("gravity", "gravity along -z is needed, such as \"0 0 -9.81\""));
            }
            if x != 0.0 || y != 0.0 {
                sentences
                    .push(format!("{}of gravity the parts along x and y, {x} and {y}, are ignored", tree.at(element)));
            }
            self.gravity = -z;
        }
        let off = |flag: &Element| flag.get("gravity") == Some("disable");
        if tree.children(element).iter().filter(|child| child.name() == "flag").any(off) {
            self.gravity = 0.0;
        }
        for key in ["density", "viscosity"] {
            if element.number(key)?.is_some_and(|value| value != 0.0) {
                sentences
                    .push(format!("{}the {key} of a medium is ignored: bodies move in a vacuum", tree.at(element)));
            }
        }
        Ok(())
    }

    /// An angle of the file [rad].
    pub(super) fn angle(&self, value: f64) -> f64 {
        if self.degrees { value / 180.0 * std::f64::consts::PI } else { value }
    }

    /// Three turns, each about an axis that moves with the turns before it or stands still.
    pub(super) fn euler(&self, angles: [f64; 3]) -> Matrix3<f64> {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        self.sequence.iter().zip(angles).fold(Matrix3::identity(), |rotation, (&(axis, still), angle)| {
            let turn = rotation_about(&axes[axis], self.angle(angle));
            if still { turn * rotation } else { rotation * turn }
        })
    }

    /// The path of a mesh from the folder of the model's own file.
    pub(super) fn mesh_path(&self, file: &str) -> String {
        let file = if self.strip_path { file.rsplit(['/', '\\']).next().unwrap_or(file) } else { file };
        if self.mesh_folder.is_empty() || file.starts_with('/') {
            return file.to_owned();
        }
        let between = if self.mesh_folder.ends_with(['/', '\\']) { "" } else { "/" };
        format!("{}{between}{file}", self.mesh_folder)
    }
}

fn sequence(text: &str) -> Option<[(usize, bool); 3]> {
    let axis = |letter: char| {
        let axis = "xyz".find(letter.to_ascii_lowercase())?;
        Some((axis, letter.is_ascii_uppercase()))
    };
    let axes: Option<Vec<_>> = text.trim().chars().map(axis).collect();
    axes?.try_into().ok()
}

/// What a file names, for messages.
pub(super) fn named(what: &str, name: &str) -> String {
    format!("{what} {}", quoted(name))
}
