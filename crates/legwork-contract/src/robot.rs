//! The robot: a model of its dynamics, and which parts of it are torso and feet.

use std::collections::{BTreeMap, HashMap};
use std::ops::{Deref, DerefMut};
use std::path::Path;

use legwork_rbd::words::{list, quoted};
use legwork_rbd::{Base, Dynamics, Joint, Model, ModelError, Revolute, Roles};
use nalgebra::{Matrix3, Unit, Vector3};

use crate::{orientation, posture};

/// A [`Model`] whose parts have roles. It dereferences to the model, so that `&robot` serves wherever a `&Model` is wanted.
///
/// Through the mutable dereference the model's numbers may be changed (a mass, a limit, a contact's place), as those of any
/// [`Model`]; bodies and contact points may neither come nor go, for the roles are told by their indices.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    model: Model,
    /// The body whose orientation is the robot's posture, in [`Model::bodies`].
    pub torso: usize,
    /// The feet's names, right before left in the project's own models.
    pub feet: Vec<String>,
    /// The foot that each contact point belongs to, in `feet`; in the order of [`Model::contacts`].
    pub foot_of: Vec<usize>,
    /// Postures that its file names: positions [rad, m] by names or patterns of joints.
    pub postures: BTreeMap<String, BTreeMap<String, f64>>,
    /// The direction in which its file says that it faces, along the axes of the root link at the zero position.
    pub forward: Option<[f64; 3]>,
    /// Forward, left and up as columns, along the axes of the root link at the zero position.
    facing: Matrix3<f64>,
    /// Bodies of feet whose centre of mass is below the sole, as some files have it.
    low_feet: Vec<usize>,
    /// `body_from_torso`: the torso's own axes are forward, left and up where all joints are at zero. None where they are its body's.
    torso_turn: Option<Matrix3<f64>>,
}

impl Deref for Robot {
    type Target = Model;
    fn deref(&self) -> &Model {
        &self.model
    }
}

impl DerefMut for Robot {
    fn deref_mut(&mut self) -> &mut Model {
        &mut self.model
    }
}

impl Robot {
    /// Gives the parts of `model` their `roles`. Without a torso the root link is the torso; a contact point without a foot
    /// is one; without `feet` their order is that of the contact points.
    ///
    /// # Errors
    /// If a role names a part that there is not, or a foot has no contact point or is named twice.
    pub fn new(model: Model, roles: &Roles) -> Result<Self, ModelError> {
        let invalid = |line: Option<usize>, subject: &str, problem: String| {
            Err(ModelError::Invalid { file: roles.file.clone(), line, subject: subject.to_owned(), problem })
        };
        let mut feet = roles.feet.clone().unwrap_or_default();
        let mut index_of = HashMap::new();
        for (index, foot) in feet.iter().enumerate() {
            if index_of.insert(foot.clone(), index).is_some() {
                return invalid(None, "feet", format!("{foot:?} is given twice"));
            }
        }
        let mut foot_of = Vec::with_capacity(model.nc());
        for (index, contact) in model.contacts.iter().enumerate() {
            let name = roles.foot.get(index).and_then(Option::as_ref).unwrap_or(&contact.name);
            let foot = index_of.get(name).copied().unwrap_or(feet.len());
            if foot == feet.len() {
                if roles.feet.is_some() {
                    let problem = format!("unknown foot {}; valid are {}", quoted(name), list(&feet));
                    let line = roles.lines.get(index).copied().flatten();
                    return invalid(line, &format!("contact {:?}", contact.name), problem);
                }
                index_of.insert(name.clone(), foot);
                feet.push(name.clone());
            }
            foot_of.push(foot);
        }
        let mut stands = vec![false; feet.len()];
        foot_of.iter().for_each(|&foot| stands[foot] = true);
        if let Some(idle) = stands.iter().position(|stands| !stands) {
            return invalid(None, "feet", format!("{:?} has no contact point", feet[idle]));
        }
        let links = || model.bodies.iter().skip(model.root()).map(|body| body.name.as_str());
        let name = roles.torso.as_deref();
        let Some(torso) = links().position(|link| name.is_none_or(|name| link == name)) else {
            let problem = format!("unknown body {}; valid are {}", quoted(name.unwrap_or_default()), list(links()));
            return invalid(None, "torso", problem);
        };
        let torso = model.root() + torso;
        let forward = roles.forward.and_then(|forward| Unit::try_new(Vector3::from(forward), 1e-9));
        if roles.forward.is_some() && forward.is_none() {
            return invalid(
                None,
                "forward",
                "found no direction; valid are three numbers that are not all zero".into(),
            );
        }
        let zero = at_zero(&model);
        let points: Vec<Vec<usize>> = (0..feet.len()).map(|foot| places(&foot_of, foot).collect()).collect();
        let facing = orientation::facing(&model, &zero, &points, forward);
        let torso_turn = zero.world_from_body[torso].rotation.tr_mul(&facing);
        let torso_turn = (!model.is_planar() && torso_turn != Matrix3::identity()).then_some(torso_turn);
        let postures = roles.postures.clone();
        let low_feet = low_feet(&model, &zero, &facing.column(2).into_owned());
        let forward = roles.forward;
        let robot = Self { torso, model, feet, foot_of, postures, forward, facing, low_feet, torso_turn };
        for (name, joints) in &robot.postures {
            if let Err(problem) = posture::check_names(&robot, joints.keys()) {
                return invalid(None, &format!("posture {name:?}"), problem);
            }
        }
        Ok(robot)
    }

    /// Reads a robot from a `.toml`, `.urdf` or MJCF file, as [`Model::load`] does.
    ///
    /// # Errors
    /// Those of [`Model::load`] and [`Robot::new`].
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        Self::load_with_base(path, None)
    }

    /// As [`Robot::load`], with another base than the file names.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn load_with_base(path: &Path, base: Option<Base>) -> Result<Self, ModelError> {
        let (model, roles) = Model::load_with_roles(path, base)?;
        Self::new(model, &roles)
    }

    /// Reads a robot from TOML; `file_name` is used in messages only.
    ///
    /// # Errors
    /// Those of [`Model::from_toml`] and [`Robot::new`].
    pub fn from_toml(text: &str, file_name: &str) -> Result<Self, ModelError> {
        Self::from_toml_with_base(text, file_name, None)
    }

    /// As [`Robot::from_toml`], with another base than the text names.
    ///
    /// # Errors
    /// As [`Robot::from_toml`].
    pub fn from_toml_with_base(text: &str, file_name: &str, base: Option<Base>) -> Result<Self, ModelError> {
        let (model, roles) = Model::from_toml_with_roles(text, file_name, base)?;
        Self::new(model, &roles)
    }

    /// Reads a robot from URDF and the text beside it, as [`Model::from_urdf`] does.
    ///
    /// # Errors
    /// Those of [`Model::from_urdf`] and [`Robot::new`].
    pub fn from_urdf(
        text: &str,
        file_name: &str,
        sidecar: Option<(&str, &str)>,
        base: Option<Base>,
    ) -> Result<Self, ModelError> {
        let (model, roles) = Model::from_urdf_with_roles(text, file_name, sidecar, base)?;
        Self::new(model, &roles)
    }

    /// Reads a robot from MJCF, the text beside it and the files that it names, as [`Model::from_mjcf`] does.
    ///
    /// # Errors
    /// Those of [`Model::from_mjcf`] and [`Robot::new`].
    pub fn from_mjcf(
        text: &str,
        file_name: &str,
        sidecar: Option<(&str, &str)>,
        base: Option<Base>,
        files: &[(&str, &[u8])],
    ) -> Result<Self, ModelError> {
        let (model, roles) = Model::from_mjcf_with_roles(text, file_name, sidecar, base, files)?;
        Self::new(model, &roles)
    }

    /// The complete robot in the TOML format, as [`Model::to_toml`] has its model.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.model.to_toml_with_roles(&Roles {
            torso: Some(self.bodies[self.torso].name.clone()),
            feet: Some(self.feet.clone()),
            postures: self.postures.clone(),
            forward: self.forward,
            foot: self.foot_of.iter().map(|&foot| Some(self.feet[foot].clone())).collect(),
            ..Roles::default()
        })
    }

    /// What is odd about the robot without being impossible, one sentence each: [`Model::warnings`], and about its feet.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let scattered = |foot: usize| {
            let bodies: Vec<usize> = self.points_of(foot).map(|point| self.contacts[point].body).collect();
            bodies.windows(2).any(|pair| pair[0] != pair[1])
        };
        let feet = (0..self.feet.len()).filter(|&foot| scattered(foot));
        let odd = feet.map(|foot| format!("the contact points of {:?} are on different bodies", self.feet[foot]));
        let points: Vec<Vec<usize>> = (0..self.feet.len()).map(|foot| self.points_of(foot).collect()).collect();
        let backward = orientation::heels_first(self, &at_zero(self), &points, &self.facing).then(|| {
            format!(
                "{}, for its right foot is the first of its feet; but its heels are before its toes then. Name the right foot first, \
                 or say forward = [x, y, z]",
                self.faces()
            )
        });
        self.model.warnings().into_iter().chain(odd).chain(backward).collect()
    }

    /// Whether `body` is fixed to a foot, and so is part of it: a sole's link, a sensor's.
    #[must_use]
    pub fn is_fixed_to_a_foot(&self, body: usize) -> bool {
        matches!(self.bodies[body].joint, Joint::Fixed(_))
            && self.contacts.iter().any(|contact| self.mover(contact.body) == self.mover(body))
    }

    /// Whether `body` is a foot whose centre of mass its file has below the sole, so that it is below the ground where the foot stands.
    #[must_use]
    pub fn is_low_foot(&self, body: usize) -> bool {
        self.low_feet.contains(&body)
    }

    /// Forward, left and up as columns, along the axes of the root link at the zero position.
    #[must_use]
    pub fn facing(&self) -> &Matrix3<f64> {
        &self.facing
    }

    /// Which way the robot faces, as a clause.
    #[must_use]
    pub fn faces(&self) -> String {
        let forward = self.facing.column(0);
        let along = ["x", "y", "z"].into_iter().zip(forward.iter()).find(|(_, part)| part.abs() == 1.0);
        let along = along.map_or_else(
            || format!("[{:.3}, {:.3}, {:.3}]", forward[0], forward[1], forward[2]),
            |(axis, part)| format!("{}{axis}", if *part < 0.0 { "-" } else { "+" }),
        );
        format!("the robot faces along {along} of its root link {:?}", self.bodies[self.root()].name)
    }

    /// `world_from_torso` in the state of `dynamics`: the torso's x axis points ahead, its z axis up, where it is upright.
    #[inline]
    #[must_use]
    pub fn torso_rotation(&self, dynamics: &Dynamics) -> Matrix3<f64> {
        let rotation = dynamics.world_from_body[self.torso].rotation;
        self.torso_turn.map_or(rotation, |turn| rotation * turn)
    }

    /// The contact points of a foot, by their place in [`Model::contacts`].
    pub fn points_of(&self, foot: usize) -> impl Iterator<Item = usize> + '_ {
        places(&self.foot_of, foot)
    }

    /// The torso's posture [rad] at the position `q` (nq), which is that of `dynamics`: by how much it is turned from its
    /// orientation at the zero position.
    ///
    /// In the plane the angle about −y, as the sum of the joint angles that lead to the torso, hence without jumps at
    /// ±π. Otherwise the elevation of the torso's x axis above the horizontal, from −π/2 to π/2.
    #[must_use]
    pub fn torso_angle(&self, dynamics: &Dynamics, q: &[f64]) -> f64 {
        if self.is_planar() {
            return self.turn(self.torso, dynamics, q);
        }
        let x = self.torso_rotation(dynamics).column(0).into_owned();
        libm::atan2(x.z, libm::hypot(x.x, x.y))
    }

    /// The sum of the angles about −y from the base to `body`.
    fn turn(&self, body: usize, dynamics: &Dynamics, q: &[f64]) -> f64 {
        let before = self.bodies[body].parent.map_or(0.0, |parent| self.turn(parent, dynamics, q));
        let Joint::Revolute(Revolute { axis }) = &self.bodies[body].joint else { return before };
        let about_y = (dynamics.world_from_body[body].rotation * axis.as_ref()).y.signum();
        before - about_y * self.bodies[body].position(q)
    }
}

/// The contact points of a foot, where each has its own in `foot_of`.
fn places(foot_of: &[usize], foot: usize) -> impl Iterator<Item = usize> + '_ {
    (0..foot_of.len()).filter(move |&point| foot_of[point] == foot)
}

/// The bodies that have contact points, all of them above the body's centre of mass.
fn low_feet(model: &Model, zero: &Dynamics, up: &Vector3<f64>) -> Vec<usize> {
    let height = |point: &Vector3<f64>| up.dot(point);
    let is_low = |&body: &usize| {
        let com = height(&zero.world_from_body[body].point(&model.bodies[body].com));
        let mut points =
            model.contacts.iter().zip(&zero.contact_positions).filter(|(contact, _)| contact.body == body).peekable();
        points.peek().is_some() && points.all(|(_, place)| height(place) > com)
    };
    (0..model.bodies.len()).filter(is_low).collect()
}

/// The dynamics of `model` with all joints at zero.
pub(crate) fn at_zero(model: &Model) -> Dynamics {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, model.neutral().as_slice(), &vec![0.0; model.nv()]);
    dynamics
}
