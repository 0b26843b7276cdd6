//! The feet as rigid bodies, whatever the number of their contact points: where each is, how it moves, and its Jacobian.
//!
//! A foot's place is the centre of its contact points; with one point only it has no orientation (a point foot). The
//! rows of a foot are its angular axes, if it has an orientation, then its linear axes; right foot before left.

use std::ops::Range;

use legwork_rbd::{Dynamics, Model};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::orientation;
use crate::robot::{Robot, at_zero};

/// The rows of one foot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FootRows {
    /// Along the model's angular axes; empty for a point foot.
    pub angular: Range<usize>,
    /// Along the model's linear axes.
    pub linear: Range<usize>,
}

impl FootRows {
    /// The rows of each foot of `robot`.
    pub fn of(robot: &Robot) -> Vec<Self> {
        let (axes, linear) = (robot.angular_axes().len(), robot.linear_axes().len());
        let mut next = 0;
        let mut take = |size: usize| {
            next += size;
            next - size..next
        };
        (0..robot.feet.len())
            .map(|foot| {
                let angular = take(if robot.points_of(foot).count() > 1 { axes } else { 0 });
                Self { angular, linear: take(linear) }
            })
            .collect()
    }

    /// How many rows all feet of `robot` have.
    pub fn count(robot: &Robot) -> usize {
        Self::of(robot).last().map_or(0, |rows| rows.linear.end)
    }
}

/// What a foot does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Footing {
    /// It stands on all its contact points.
    #[default]
    Stands,
    /// It stands on its toe, and its heel turns about it.
    Rolls,
    /// As [`Footing::Rolls`], while it hands its load to the other foot.
    Trails,
    /// It has landed on its heel alone, and its toe comes down.
    OnHeel,
    /// It has landed on its toe, and its heel comes down.
    Lands,
    /// It is in the air.
    Swings,
}

impl Footing {
    /// Whether the foot stands on one of its ends alone.
    #[inline]
    pub fn is_on_an_end(self) -> bool {
        matches!(self, Self::Rolls | Self::Trails | Self::Lands | Self::OnHeel)
    }
}

/// Where each contact point is, from its body's joint: along the walking direction, to the left, and up [m].
pub fn from_joints(robot: &Robot) -> Vec<Vector3<f64>> {
    let zero = at_zero(robot);
    let turns: Vec<_> = (0..robot.feet.len()).map(|foot| body_from_foot(robot, &zero, foot)).collect();
    let places = robot.contacts.iter().zip(&robot.foot_of);
    places.map(|(contact, &foot)| turns[foot].tr_mul(&contact.position)).collect()
}

/// The axes of a foot in those of its body: ahead, to the left, and up from its sole where all joints are at zero, in the dynamics at
/// `zero`. Contact points on a line tell no sole: up is the robot's then.
fn body_from_foot(robot: &Robot, zero: &Dynamics, foot: usize) -> Matrix3<f64> {
    let points: Vec<usize> = robot.points_of(foot).collect();
    let facing = robot.facing();
    let normal = if robot.is_planar() { None } else { orientation::normal(robot, zero, &points) };
    let up = normal.unwrap_or_else(|| facing.column(2).into_owned());
    let forward = facing.column(0).into_owned();
    let forward = (forward - up * up.dot(&forward)).try_normalize(1e-9).unwrap_or(forward);
    let axes = Matrix3::from_columns(&[forward, up.cross(&forward), up]);
    let body = points.first().map_or(robot.torso, |&point| robot.contacts[point].body);
    zero.world_from_body[body].rotation.tr_mul(&axes)
}

/// The sole of a foot with several contact points, along the walking direction from below its joint [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sole {
    /// Place of the heel, negative.
    pub heel: f64,
    /// Place of the toe.
    pub toe: f64,
    /// Height of the joint above the sole.
    pub ankle: f64,
}

impl Sole {
    /// The sole of the feet of `robot`, that of its first foot.
    pub fn of(robot: &Robot) -> Self {
        let places = from_joints(robot);
        let points = || robot.points_of(0).map(|point| places[point]);
        Self {
            heel: points().map(|point| point.x).fold(f64::INFINITY, f64::min),
            toe: points().map(|point| point.x).fold(f64::NEG_INFINITY, f64::max),
            ankle: -points().map(|point| point.z).fold(f64::INFINITY, f64::min),
        }
    }

    /// The middle between heel and toe.
    pub fn middle(&self) -> f64 {
        0.5 * (self.heel + self.toe)
    }
}

/// A foot of the model.
#[derive(Clone, Debug)]
struct Foot {
    body: usize,
    contacts: Vec<usize>,
    /// Those at the heel, and those at the toe.
    ends: [Vec<usize>; 2],
    rows: FootRows,
    /// `body_from_foot`; none where the foot's axes are those of its body.
    turn: Option<Matrix3<f64>>,
}

impl Foot {
    #[inline]
    fn points(&self, footing: Footing) -> &[usize] {
        match footing {
            Footing::Stands | Footing::Swings => &self.contacts,
            Footing::OnHeel => &self.ends[0],
            Footing::Rolls | Footing::Trails | Footing::Lands => &self.ends[1],
        }
    }
}

/// Where the feet are and how they move; preallocated. Valid after [`FeetMotion::update`].
#[derive(Clone, Debug)]
pub struct FeetMotion {
    is_planar: bool,
    feet: Vec<Foot>,
    /// Centre of each foot's contact points [m].
    pub position: Vec<Vector3<f64>>,
    /// Its velocity [m/s].
    pub velocity: Vec<Vector3<f64>>,
    /// Orientation of each foot: `world_from_foot`, whose x axis is the walking direction.
    pub rotation: Vec<Matrix3<f64>>,
    /// Its angular velocity [rad/s].
    pub angular_velocity: Vec<Vector3<f64>>,
    /// Jacobian of all rows (rows × nv).
    pub jacobian: DMatrix<f64>,
    /// Its `J̇ v` (rows) [rad/s², m/s²].
    pub bias: DVector<f64>,
    angular: DMatrix<f64>,
}

impl FeetMotion {
    /// Storage for `robot`.
    pub fn new(robot: &Robot) -> Self {
        let (zero, places) = (at_zero(robot), from_joints(robot));
        let foot = |(index, rows): (usize, FootRows)| {
            let contacts: Vec<usize> = robot.points_of(index).collect();
            let body = contacts.first().map_or(0, |&contact| robot.contacts[contact].body);
            let turn = body_from_foot(robot, &zero, index);
            let place = |&contact: &usize| places[contact].x;
            let ends = [-1.0, 1.0].map(|side| {
                let far = contacts.iter().map(|contact| side * place(contact)).fold(f64::NEG_INFINITY, f64::max);
                contacts.iter().copied().filter(|contact| side * place(contact) > far - 1e-3).collect()
            });
            let turn = (turn != Matrix3::identity()).then_some(turn);
            Foot { body, contacts, ends, rows, turn }
        };
        let feet: Vec<Foot> = FootRows::of(robot).into_iter().enumerate().map(foot).collect();
        let (count, rows) = (feet.len(), FootRows::count(robot));
        Self {
            is_planar: robot.is_planar(),
            feet,
            position: vec![Vector3::zeros(); count],
            velocity: vec![Vector3::zeros(); count],
            rotation: vec![Matrix3::identity(); count],
            angular_velocity: vec![Vector3::zeros(); count],
            jacobian: DMatrix::zeros(rows, robot.nv()),
            bias: DVector::zeros(rows),
            angular: DMatrix::zeros(robot.angular_axes().len(), robot.nv()),
        }
    }

    /// The rows of a foot.
    #[inline]
    pub fn rows(&self, foot: usize) -> &FootRows {
        &self.feet[foot].rows
    }

    /// The contact points of a foot, by their place in the model.
    #[inline]
    pub fn contacts(&self, foot: usize) -> &[usize] {
        &self.feet[foot].contacts
    }

    /// The contact points that a foot stands on.
    pub fn points(&self, foot: usize, footing: Footing) -> &[usize] {
        self.feet[foot].points(footing)
    }

    /// The contact points at the heel and those at the toe of a foot.
    #[inline]
    pub fn ends(&self, foot: usize) -> &[Vec<usize>; 2] {
        &self.feet[foot].ends
    }

    /// The walking direction of a foot, a horizontal unit vector: that of x in the plane.
    #[inline]
    pub fn ahead(&self, foot: usize) -> Vector3<f64> {
        if self.is_planar { Vector3::x() } else { level(&self.rotation[foot].column(0).into_owned()) }
    }

    /// Takes the feet from the `dynamics` of `model`. Allocates nothing.
    pub fn update(&mut self, model: &Model, dynamics: &Dynamics) {
        for index in 0..self.feet.len() {
            self.place(model, dynamics, index, Footing::Stands);
            let foot = &self.feet[index];
            let rotation = dynamics.world_from_body[foot.body].rotation;
            self.rotation[index] = foot.turn.map_or(rotation, |turn| rotation * turn);
            self.angular_velocity[index] = dynamics.body_velocity[foot.body].angular;
            if foot.rows.angular.is_empty() {
                continue;
            }
            dynamics.angular_jacobian(model, foot.body, &mut self.angular);
            let bias = dynamics.angular_bias(foot.body);
            for (axis, row) in foot.rows.angular.clone().enumerate() {
                self.bias[row] = model.angular_axes()[axis].dot(&bias);
                for j in 0..model.nv() {
                    self.jacobian[(row, j)] = self.angular[(axis, j)];
                }
            }
        }
    }

    /// The place of a foot: the centre of the contact points that it stands on. After
    /// [`FeetMotion::update`], which takes all of them. Allocates nothing.
    pub fn place(&mut self, model: &Model, dynamics: &Dynamics, index: usize, footing: Footing) {
        let d = model.linear_axes().len();
        let foot = &self.feet[index];
        let points = foot.points(footing);
        let share = 1.0 / points.len() as f64;
        let centre = |of: &[Vector3<f64>]| share * points.iter().map(|&k| of[k]).sum::<Vector3<f64>>();
        self.position[index] = centre(&dynamics.contact_positions);
        self.velocity[index] = centre(&dynamics.contact_velocities);
        for (axis, row) in foot.rows.linear.clone().enumerate() {
            self.bias[row] = share * points.iter().map(|&k| dynamics.contact_bias[k * d + axis]).sum::<f64>();
            for j in 0..model.nv() {
                let of = |&k: &usize| dynamics.contact_jacobian[(k * d + axis, j)];
                self.jacobian[(row, j)] = share * points.iter().map(of).sum::<f64>();
            }
        }
    }
}

/// The horizontal unit vector along `forward`; x where that is vertical.
pub fn level(forward: &Vector3<f64>) -> Vector3<f64> {
    let length = libm::hypot(forward.x, forward.y);
    if length > 1e-9 { Vector3::new(forward.x / length, forward.y / length, 0.0) } else { Vector3::x() }
}

/// The horizontal unit vector to which a rotation turns x about z, however much it tilts besides: the twist about z. It is x where
/// there is none, after half a turn about a horizontal axis.
pub fn heading(rotation: &Matrix3<f64>) -> Vector3<f64> {
    level(&Vector3::new(rotation[(0, 0)] + rotation[(1, 1)], rotation[(1, 0)] - rotation[(0, 1)], 0.0))
}

/// The horizontal to the right of `forward`, a unit vector.
pub fn right_of(forward: &Vector3<f64>) -> Vector3<f64> {
    headed(&level(forward)) * -Vector3::y()
}

/// The rotation that takes x to the horizontal unit vector `ahead`, about z.
pub fn headed(ahead: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(ahead.x, -ahead.y, 0.0, ahead.y, ahead.x, 0.0, 0.0, 0.0, 1.0)
}

/// The rotation vector, in the world [rad], that turns `from` into `to`.
#[inline]
pub fn rotation_error(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Vector3<f64> {
    let turn = to * from.transpose();
    let axis =
        0.5 * Vector3::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)]);
    let (sine, cosine) = (axis.norm(), 0.5 * (turn.trace() - 1.0));
    if sine > 1e-12 {
        axis * (libm::atan2(sine, cosine) / sine)
    } else if cosine > 0.0 {
        axis
    } else {
        // Half a turn, R = 2 a aᵀ − 1, about an axis that the antisymmetric part does not tell.
        let twice = turn + Matrix3::identity();
        twice.column(twice.diagonal().imax()).normalize() * std::f64::consts::PI
    }
}

/// The rotation of a rotation vector [rad]. Rodrigues
pub fn rotated(turn: &Vector3<f64>) -> Matrix3<f64> {
    let angle = turn.norm();
    if turn.x == 0.0 && turn.z == 0.0 {
        return pitched(-turn.y);
    }
    let (sine, cosine) = libm::sincos(angle);
    let axis = turn / angle;
    let cross = axis.cross_matrix();
    Matrix3::identity() + cross * sine + cross * cross * (1.0 - cosine)
}

/// The rotation by `angle` [rad] about −y, counter-clockwise as seen with x to the right and z up.
#[inline]
pub fn pitched(angle: f64) -> Matrix3<f64> {
    let (sin, cos) = libm::sincos(angle);
    Matrix3::new(cos, 0.0, -sin, 0.0, 1.0, 0.0, sin, 0.0, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rotation_error_is_what_turns_one_into_the_other() {
        for (from, to) in [(0.2, 0.5), (-1.0, 2.0), (0.3, 0.3)] {
            let error = rotation_error(&pitched(from), &pitched(to));
            assert!((error - Vector3::new(0.0, -(to - from), 0.0)).norm() < 1e-14, "{from} to {to}: {error}");
        }
    }

    #[test]
    fn a_heading_stays_whatever_way_a_body_tilts() {
        for (yaw, pitch, roll) in [(0.0, 2.5, 0.0), (1.2, -2.0, 0.0), (-2.8, 0.0, 1.9), (3.1, 1.6, 0.0)] {
            let ahead = Vector3::new(libm::cos(yaw), libm::sin(yaw), 0.0);
            let rotation = headed(&ahead) * pitched(pitch) * rotated(&Vector3::new(roll, 0.0, 0.0));
            assert!((heading(&rotation) - ahead).norm() < 1e-12, "{yaw} {pitch} {roll}: {}", heading(&rotation));
        }
    }

    #[test]
    fn half_a_turn_is_an_error_of_half_a_turn() {
        for axis in [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(1.0, -2.0, 0.5).normalize()] {
            let half = 2.0 * axis * axis.transpose() - Matrix3::identity();
            let error = rotation_error(&Matrix3::identity(), &half);
            assert!((rotated(&error) - half).norm() < 1e-14, "{axis}: {error}");
        }
    }

    #[test]
    fn a_pitched_axis_turns_upward() {
        let x = pitched(0.1) * Vector3::x();
        assert!((x.z - libm::sin(0.1)).abs() < 1e-15 && x.y == 0.0);
    }
}
