//! Measures of balance along x, each a pure function: centre of pressure, zero-moment point, centroidal moment pivot,
//! margin of the extrapolated centre of mass; [`capture`] has the number of steps to a stop, [`Meter`] reads all of them
//! from a log.
//!
//! Three points on the ground must not be confused (Vukobratović & Borovac 2004):
//! - the *centre of pressure* ([`centre_of_pressure`]) is where the forces of the ground act, from contact forces alone;
//! - the *zero-moment point* ([`zero_moment_point`] of the momentum's rate) is where one force of the ground would have to
//!   act for the robot to move as it did, from masses and velocities alone. It is the centre of pressure by another way;
//! - the same function of the rate that the *planner wants* may give a point outside of the base of support. Then it is the
//!   *fictitious* zero-moment point: no ground can do that, and its distance from the support says how much is missing.

pub mod capture;
mod meter;

use legwork_rbd::{Dynamics, Model};

use crate::scenario::Push;
use crate::terrain::Line;
pub use capture::{Capture, StepLimits};
pub use meter::{Measures, Meter, Moment};

/// A ground that carries less than this share of the robot's weight carries nothing: a point on it means nothing then.
const LOADED: f64 = 0.01;

/// A vector along x and z.
pub type Planar = [f64; 2];

/// By how much a force presses on the ground: its normal component over the cosine of the slope [N].
fn pressing(ground: &Line, [x, z]: Planar) -> f64 {
    z - ground.steepness * x
}

/// A force and its moment about the centre of mass [N, Nm], or a momentum about it [Ns, Nms]; angles count about −y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Centroidal {
    /// Along x and z.
    pub linear: Planar,
    /// About −y.
    pub angular: f64,
}

impl Centroidal {
    /// From rows along a model's angular, then its linear axes: three in the plane, six in space.
    pub fn of_rows(rows: &[f64]) -> Self {
        match *rows {
            [angular, x, z] => Self { linear: [x, z], angular },
            [_, y, _, force_x, _, force_z] => Self { linear: [force_x, force_z], angular: -y },
            _ => unreachable!("a model has three momentum rows or six"),
        }
    }

    /// The momentum of `model` in the state of `dynamics`, with the joint velocities `v`. Allocates nothing.
    pub fn momentum(model: &Model, dynamics: &Dynamics, v: &[f64]) -> Self {
        let (row, sign) = if model.is_planar() { (0, 1.0) } else { (1, -1.0) };
        let angular: f64 = v.iter().enumerate().map(|(j, v)| dynamics.momentum_matrix[(row, j)] * v).sum();
        let (mass, velocity) = (model.total_mass(), &dynamics.com_velocity);
        Self { linear: [mass * velocity.x, mass * velocity.z], angular: sign * angular }
    }

    /// The mean of `pushes` over the time `[from, to]` [s], in the pose of `dynamics`. Allocates nothing.
    pub fn of_pushes(pushes: &[Push], model: &Model, dynamics: &Dynamics, [from, to]: [f64; 2]) -> Self {
        let mut sum = Self::default();
        for push in pushes {
            let share = (to.min(push.start_s + push.duration_s) - from.max(push.start_s)) / (to - from);
            if share.is_nan() || share <= 0.0 {
                continue;
            }
            let direction = push.direction();
            let force = [direction.x, direction.z].map(|part| share * push.force_n * part);
            let arm = model.body_index(&push.at).map_or([0.0; 2], |body| {
                let place = model.bodies[body].com + nalgebra::Vector3::from(push.point_m);
                let arm = dynamics.world_from_body[body].point(&place) - dynamics.com;
                [arm.x, arm.z]
            });
            sum.linear = [sum.linear[0] + force[0], sum.linear[1] + force[1]];
            sum.angular += arm[0] * force[1] - arm[1] * force[0];
        }
        sum
    }

    /// What the ground must do, that the momentum changes at the rate `self` under gravity and a `push`. Newton, Euler
    pub fn of_ground(&self, weight: f64, push: &Self) -> Self {
        let [x, z] = self.linear;
        Self { linear: [x - push.linear[0], z - push.linear[1] + weight], angular: self.angular - push.angular }
    }
}

/// The centre of pressure [m] of contacts, each its point and the force on it; none where they do not carry the robot of
/// `weight` [N]. Sardain & Bessonnet 2004
pub fn centre_of_pressure(
    ground: &Line,
    weight: f64,
    contacts: impl IntoIterator<Item = (Planar, Planar)>,
) -> Option<f64> {
    let (mut pressing, mut moment) = (0.0, 0.0);
    for (point, force) in contacts {
        let part = self::pressing(ground, force).max(0.0);
        pressing += part;
        moment += part * point[0];
    }
    (pressing > LOADED * weight).then(|| moment / pressing)
}

/// Where on the ground [m] a force acts that is `wrench` about the centre of mass: the zero-moment point of that wrench. None
/// where it does not press on the ground. Vukobratović & Borovac 2004; for slopes Sardain & Bessonnet 2004
pub fn zero_moment_point(ground: &Line, weight: f64, com: Planar, wrench: &Centroidal) -> Option<f64> {
    let [x, z] = wrench.linear;
    let pressing = pressing(ground, wrench.linear);
    // (p − c) × f = k̇ with p on the ground: (p_x − c_x) f_z − (h + s p_x − c_z) f_x = k̇
    let moment = wrench.angular + com[0] * z - (com[1] - ground.at(0.0)) * x;
    (pressing > LOADED * weight).then(|| moment / pressing)
}

/// Where the line through the centre of mass along the ground's `force` meets the ground [m]: the zero-moment point if the
/// angular momentum did not change. Popovic, Goswami & Herr 2005
pub fn centroidal_moment_pivot(ground: &Line, weight: f64, com: Planar, force: Planar) -> Option<f64> {
    zero_moment_point(ground, weight, com, &Centroidal { linear: force, angular: 0.0 })
}

/// How far `x` is inside of a support, negative outside [m]. With the extrapolated centre of mass (Hof et al. 2005), which is
/// the instantaneous capture point (Pratt et al. 2006), the margin of stability (Hof 2008).
pub fn margin([low, high]: [f64; 2], x: f64) -> f64 {
    (x - low).min(high - x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEIGHT: f64 = 700.0;
    const COM: Planar = [0.3, 0.95];

    /// Contacts on a slope, and what they do about the centre of mass.
    fn contacts(ground: &Line) -> (Vec<(Planar, Planar)>, Centroidal) {
        let forces = [(0.1, [20.0, 150.0]), (0.32, [-35.0, 420.0]), (0.7, [60.0, 90.0])];
        let contacts: Vec<_> = forces.into_iter().map(|(x, force)| ([x, ground.at(x)], force)).collect();
        let mut sum = Centroidal::default();
        for (point, force) in &contacts {
            sum.linear = [sum.linear[0] + force[0], sum.linear[1] + force[1]];
            sum.angular += (point[0] - COM[0]) * force[1] - (point[1] - COM[1]) * force[0];
        }
        (contacts, sum)
    }

    #[test]
    fn the_moment_about_the_ground_vanishes_where_the_pressure_has_its_centre() {
        for slope in [-0.2, 0.0, 0.15] {
            let ground = Line { x: 0.0, z: 0.1, steepness: slope };
            let (contacts, sum) = contacts(&ground);
            let cop = centre_of_pressure(&ground, WEIGHT, contacts).expect("it stands");
            let zmp = zero_moment_point(&ground, WEIGHT, COM, &sum).expect("it stands");
            assert!((cop - zmp).abs() < 1e-12, "{cop} and {zmp} at {slope}");
        }
    }

    #[test]
    fn the_force_at_the_pivot_turns_nothing_and_the_rest_is_the_angular_momentum() {
        let ground = Line { x: 0.0, z: -0.05, steepness: 0.1 };
        let (contacts, sum) = contacts(&ground);
        let pivot = centroidal_moment_pivot(&ground, WEIGHT, COM, sum.linear).expect("it stands");
        let arm = [pivot - COM[0], ground.at(pivot) - COM[1]];
        assert!((arm[0] * sum.linear[1] - arm[1] * sum.linear[0]).abs() < 1e-10);
        let cop = centre_of_pressure(&ground, WEIGHT, contacts).expect("it stands");
        let pressing = sum.linear[1] - ground.steepness * sum.linear[0];
        assert!(((cop - pivot) * pressing - sum.angular).abs() < 1e-10);
    }

    #[test]
    fn what_the_ground_does_is_the_rate_without_gravity_and_push() {
        let rate = Centroidal { linear: [50.0, -100.0], angular: 3.0 };
        let push = Centroidal { linear: [200.0, 10.0], angular: -4.0 };
        let ground = rate.of_ground(WEIGHT, &push);
        assert_eq!(ground, Centroidal { linear: [-150.0, 590.0], angular: 7.0 });
    }

    #[test]
    fn in_flight_there_is_no_such_point() {
        let ground = Line::default();
        let falling = Centroidal { linear: [0.0, -WEIGHT], angular: 2.0 };
        let wrench = falling.of_ground(WEIGHT, &Centroidal::default());
        assert_eq!(zero_moment_point(&ground, WEIGHT, COM, &wrench), None);
        assert_eq!(centre_of_pressure(&ground, WEIGHT, [([0.0; 2], [0.0; 2])]), None);
    }

    #[test]
    fn a_margin_is_positive_inside_and_negative_outside() {
        let support = [-0.1, 0.2];
        assert!(
            [0.0, 0.15, 0.2, 0.5, -0.3].map(|x| (1e3 * margin(support, x)).round())
                == [100.0, 50.0, 0.0, -300.0, -200.0]
        );
    }
}
