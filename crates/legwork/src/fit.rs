//! Settings that are stated for one robot, scaled to another by dynamic similarity (Alexander and Jayes 1983; Hof 1996).
//!
//! Two robots of one shape move alike in times that are as the square root of their length over gravity: speeds are as √(L g), forces as
//! M g, moments as M g L. L is the length of the leg, M the mass. How a setting scales follows from its unit; those that have none, and
//! those that are the world's or the computer's, are listed here (`STATED`, `SCALED`, `KEPT`). Robots of other shapes differ in two
//! things that no single length tells: how far apart their hips are, and how high their centre of mass is above them.

use legwork_rbd::Dynamics;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use toml::Value;

use crate::error::Error;
use crate::feet::FootRows;
use crate::library::{load_model, model_names};
use crate::posture::neutral;
use crate::redundancy::leg;
use crate::robot::Robot;
use crate::scenario::{Scenario, Start};
use crate::settings::{self, SETTINGS, Valid, at};

/// The robot that a scenario's settings are stated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// The scenario's own, or the person of its wearer: nothing is scaled here.
    None,
    /// The scenario's own, for which they have been scaled.
    Done,
    /// The thesis's biped.
    PlanarHumanoid,
    /// The humanoid that walks on feet.
    PlanarHumanoidFeet,
    /// The exoskeleton with its wearer.
    Exo18,
}

/// Settings, and tables of settings, that are the robot's.
const SCALED: [&str; 7] = [
    "start",
    "reference",
    "controller",
    "pushes",
    "fall.max_joint_speed_radps",
    "simulation.contact.flag_height_m",
    "simulation.sensors.flag_force_n",
];

/// Those of them that are the computer's.
const KEPT: [&str; 2] = ["controller.period_s", "controller.known_delay_s"];

/// How weights scale, as powers of mass, length and time, so that tasks are traded as before: each term of the cost stays the square of an
/// angular acceleration.
const STATED: [(&str, [i32; 3]); 5] = [
    ("controller.weights.momentum", [-2, -2, 0]),
    ("controller.weights.angular_momentum_factor", [0, -2, 0]),
    ("controller.weights.grf", [-2, -2, 0]),
    ("controller.weights.torque", [-2, -4, 0]),
    ("controller.weights.feet", [0, -2, 0]),
];

/// How far a leg bends where nothing says how high the centre of mass is: height of the hip as a share of the leg's length.
const STANDING: f64 = 0.95;

/// What of a robot its settings follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Mass [kg].
    pub mass: f64,
    /// Length of the stretched leg, from the hip to the sole [m].
    pub leg: f64,
    /// [m/s²]
    pub gravity: f64,
    /// Distance of the hips [m]; zero in the plane.
    pub hips: f64,
    /// Height of the centre of mass above the hips in the neutral posture [m].
    pub com_above_hips: f64,
}

impl Size {
    /// That of `robot`; none where it does not have two feet on legs.
    pub fn of(robot: &Robot) -> Option<Self> {
        if robot.feet.len() != 2 {
            return None;
        }
        let mut q = robot.neutral();
        for (dof, position) in robot.dofs.iter().zip(neutral(robot)).filter(|(dof, _)| dof.actuated) {
            q[robot.bodies[dof.body].q_index] = position;
        }
        let [mut zero, mut standing] = [Dynamics::new(robot), Dynamics::new(robot)];
        zero.update(robot, robot.neutral().as_slice(), &vec![0.0; robot.nv()]);
        standing.update(robot, q.as_slice(), &vec![0.0; robot.nv()]);
        // Feet are level in the zero position, and knees may not be as straight as that.
        let length = 0.5 * (Leg::of(robot, &zero, 0)?.length + Leg::of(robot, &zero, 1)?.length);
        let [right, left] = [Leg::of(robot, &standing, 0)?.hip, Leg::of(robot, &standing, 1)?.hip];
        let axes = robot.facing();
        let up = axes.column(2);
        Some(Self {
            mass: robot.total_mass(),
            leg: length,
            gravity: robot.gravity,
            hips: axes.column(1).dot(&(left - right)).abs(),
            com_above_hips: up.dot(&(standing.com - 0.5 * (right + left))),
        })
    }

    /// Height of the centre of mass of a robot that stands with its knees bent a little, its feet as far from below the hips as `start`
    /// has them [m].
    fn standing(&self, start: &Start) -> f64 {
        let aside = [start.right_foot_x_m, start.left_foot_x_m].map(|foot| (foot - start.com_x_m).abs());
        let (leg, aside) = (STANDING * self.leg, aside[0].max(aside[1]));
        libm::sqrt((leg * leg - aside * aside).max(0.25 * leg * leg)) + self.com_above_hips
    }
}

/// A leg of the zero position.
struct Leg {
    /// Where the thigh begins.
    hip: Vector3<f64>,
    /// From there to the sole, link by link, as seen from the side.
    length: f64,
}

impl Leg {
    fn of(robot: &Robot, dynamics: &Dynamics, foot: usize) -> Option<Self> {
        let axes = robot.facing();
        let seen = |way: Vector3<f64>| way - axes.column(1) * axes.column(1).dot(&way);
        let joints = leg(robot, foot);
        let place = |body: usize| dynamics.world_from_body[body].translation;
        let points: Vec<Vector3<f64>> = robot.points_of(foot).map(|point| dynamics.contact_positions[point]).collect();
        let sole = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        // The sole is below the ankle wherever on it the contact points are.
        let last = place(*joints.last()?);
        let has_sole = !FootRows::of(robot)[foot].angular.is_empty();
        let down = |way: Vector3<f64>| axes.column(2) * axes.column(2).dot(&way);
        let end = if has_sole { last + down(sole - last) } else { sole };
        let places: Vec<Vector3<f64>> = joints.iter().map(|&body| place(body)).chain([end]).collect();
        let links: Vec<f64> = places.windows(2).map(|pair| seen(pair[1] - pair[0]).norm()).collect();
        // Thigh and shank are the two longest links.
        let mut order: Vec<usize> = (0..links.len()).collect();
        order.sort_by(|&a, &b| links[b].total_cmp(&links[a]));
        let thigh = order.into_iter().take(2).min()?;
        let length = links[thigh..].iter().sum();
        (length > 0.0).then(|| Self { hip: places[thigh], length })
    }
}

/// The settings of `scenario` for `model`: where they are stated for another robot, scaled; where no height of the centre of mass is given,
/// with one that follows from the legs.
///
/// # Errors
/// The robot has no two legs to scale by.
pub fn fitted(scenario: &Scenario, model: &Robot) -> Result<Scenario, Error> {
    let mut fitted = scenario.clone();
    let from = match scenario.fit {
        Fit::None | Fit::Done => None,
        Fit::PlanarHumanoid => Some("planar_humanoid"),
        Fit::PlanarHumanoidFeet => Some("planar_humanoid_feet"),
        Fit::Exo18 => Some("exo18"),
    };
    let own = Size::of(model);
    if let Some(from) = from {
        let size = |robot: &Robot| {
            let problem = format!("the model '{}' has no two legs with feet to scale by", robot.name);
            Size::of(robot).ok_or_else(|| Error::invalid("fit", problem))
        };
        fitted = scale(scenario, &size(&load_model(from, None)?)?, &size(model)?)?;
    }
    if fitted.start.com_height_m == 0.0 {
        let is_shipped =
            model_names().any(|name| load_model(name, None).is_ok_and(|shipped| shipped.name == model.name));
        // The legs of a robot on points need not hang down in the neutral posture, which then tells no height.
        let has_soles = (0..model.feet.len()).all(|foot| model.points_of(foot).count() > 1);
        let height = own
            .filter(|_| !is_shipped && has_soles)
            .map_or(Scenario::default().start.com_height_m, |size| size.standing(&fitted.start));
        fitted.start.com_height_m = height;
    }
    Ok(fitted)
}

/// The settings of `scenario`, which are stated for a robot of the size `from`, for one of the size `to`.
fn scale(scenario: &Scenario, from: &Size, to: &Size) -> Result<Scenario, Error> {
    let (mass, length) = (to.mass / from.mass, to.leg / from.leg);
    let time = libm::sqrt(length * from.gravity / to.gravity);
    let factor = |[m, l, t]: [i32; 3]| power(mass, m) * power(length, l) * power(time, t);
    let mut tree = settings::tree(scenario);
    let pushes = scenario.pushes.len();
    for setting in SETTINGS {
        let holds = |paths: &[&str]| paths.iter().any(|outer| settings::holds(outer, setting.path));
        if !holds(&SCALED) || holds(&KEPT) {
            continue;
        }
        let of_list = if setting.path.starts_with("pushes.") { pushes } else { 1 };
        for index in 0..of_list {
            let Some(value) = at(&mut tree, &setting.path.replace('N', &index.to_string())) else { continue };
            let stated = STATED.iter().find(|(path, _)| *path == setting.path).map(|(_, dimension)| *dimension);
            let own = factor(stated.unwrap_or_else(|| dimension(setting.unit)));
            match setting.valid {
                // A limit at the end of its range is none.
                Valid::Number { max, .. } if value.as_float() == Some(max) => {}
                Valid::Number { .. } => times(value, own),
                Valid::ByJoint { .. } => each(value, |_, value| times(value, own)),
                Valid::Row(_) => each(value, |_, value| times(value, own)),
                Valid::Rows(columns) => each(value, |_, row| {
                    each(row, |column, value| times(value, factor(dimension(unit_of(columns[column].name)))));
                }),
                _ => {}
            }
        }
    }
    let mut scaled: Scenario =
        tree.try_into().map_err(|error: toml::de::Error| Error::invalid("fit", error.message().to_owned()))?;
    scaled.fit = Fit::Done;
    // Other shapes: feet stand below the hips, and knees bend as they did.
    if from.hips > 0.0 && to.hips > 0.0 {
        scaled.start.feet_width_m = scenario.start.feet_width_m * (to.hips / from.hips);
    }
    let higher = to.com_above_hips - length * from.com_above_hips;
    if higher.abs() > 1e-9 {
        if scaled.start.com_height_m > 0.0 {
            scaled.start.com_height_m += higher;
        }
        scaled.reference.walker = scaled.reference.walker.for_build(0.0, higher);
    }
    Ok(scaled)
}

/// A whole power of a number.
fn power(base: f64, exponent: i32) -> f64 {
    let power = (0..exponent.abs()).fold(1.0, |product, _| product * base);
    if exponent < 0 { 1.0 / power } else { power }
}

fn times(value: &mut Value, factor: f64) {
    if let Value::Float(number) = value {
        *number *= factor;
    }
}

/// Calls `change` with each element of a list or table and its place in it, or with a single value.
fn each(value: &mut Value, mut change: impl FnMut(usize, &mut Value)) {
    match value {
        Value::Array(list) => list.iter_mut().enumerate().for_each(|(index, value)| change(index, value)),
        Value::Table(table) => table.iter_mut().enumerate().for_each(|(index, (_, value))| change(index, value)),
        single => change(0, single),
    }
}

/// The unit that the name of a column ends in.
fn unit_of(column: &str) -> &'static str {
    match column.rsplit_once('_').map_or("", |(_, suffix)| suffix) {
        "s" => "s",
        "m" => "m",
        "mps" => "m/s",
        _ => "",
    }
}

/// The powers of mass, length and time in a unit: `N/m` is of a mass over a time squared. Angles have none.
fn dimension(unit: &str) -> [i32; 3] {
    let mut sum = [0; 3];
    for (part, sign) in unit.split('/').zip([1, -1]) {
        let mut rest = part;
        while !rest.is_empty() {
            let atoms: [(&str, [i32; 3]); 7] = [
                ("kg", [1, 0, 0]),
                ("rad", [0, 0, 0]),
                ("deg", [0, 0, 0]),
                ("N", [1, 1, -2]),
                ("m", [0, 1, 0]),
                ("s", [0, 0, 1]),
                ("1", [0, 0, 0]),
            ];
            let Some((atom, powers)) = atoms.into_iter().find(|(atom, _)| rest.starts_with(atom)) else {
                return [0; 3];
            };
            rest = &rest[atom.len()..];
            let exponents = [("²", 2), ("2", 2), ("4", 4)];
            let exponent = exponents.into_iter().find(|(text, _)| rest.starts_with(text));
            let exponent = exponent.map_or(1, |(text, exponent)| {
                rest = &rest[text.len()..];
                exponent
            });
            (0..3).for_each(|k| sum[k] += sign * exponent * powers[k]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_their_dimensions() {
        for (unit, powers) in [
            ("", [0, 0, 0]),
            ("deg", [0, 0, 0]),
            ("1/s²", [0, 0, -2]),
            ("rad/s²", [0, 0, -2]),
            ("N/m", [1, 0, -2]),
            ("Nms/rad", [1, 2, -1]),
            ("Nm/s", [1, 2, -3]),
            ("m/s2", [0, 1, -2]),
            ("m²/s²", [0, 2, -2]),
            ("rad/m", [0, -1, 0]),
            ("s4", [0, 0, 4]),
        ] {
            assert_eq!(dimension(unit), powers, "{unit}");
        }
    }

    /// A unit that is not understood would silently not scale.
    #[test]
    fn every_unit_of_a_setting_that_scales_is_understood() {
        let known = ["", "deg", "rad"];
        for setting in SETTINGS {
            if SCALED.iter().any(|outer| settings::holds(outer, setting.path)) && !known.contains(&setting.unit) {
                assert_ne!(dimension(setting.unit), [0; 3], "{} [{}]", setting.path, setting.unit);
            }
        }
        let listed = |path: &str| SETTINGS.iter().any(|setting| settings::holds(path, setting.path));
        assert!(STATED.iter().all(|(path, _)| listed(path)) && SCALED.iter().chain(&KEPT).all(|path| listed(path)));
    }

    #[test]
    fn a_robot_is_as_large_as_its_links() {
        // Winter's person of 1.75 m: 0.245 and 0.246 of the height are thigh and shank, 0.039 is the ankle's height.
        let size = |name: &str| Size::of(&load_model(name, None).expect("built in")).expect("it has legs");
        let person = size("planar_humanoid_feet");
        assert!((person.leg - 0.53 * 1.75).abs() < 1e-3 && (person.mass - 72.5).abs() < 1e-9, "{person:?}");
        let points = size("planar_humanoid");
        assert!((0.45..0.54).contains(&(points.leg / 1.75)), "{points:?}");
        let exo = size("exo18");
        assert!((0.1..0.3).contains(&exo.hips) && (0.7..1.1).contains(&exo.leg), "{exo:?}");
    }
}
