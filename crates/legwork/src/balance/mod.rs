//! Measures of balance, each a pure function: centre of pressure, zero-moment point, centroidal moment pivot,
//! margin of the extrapolated centre of mass; [`support`] has the base of support, [`capture`] the number of steps to a stop, [`Meter`] reads all of them
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
pub mod support;

use legwork_rbd::{Dynamics, Model};
use nalgebra::Vector3;

use crate::scenario::Push;
use crate::terrain::Plane;
pub use capture::{Capture, StepLimits};
pub use meter::{Measures, Meter, Moment};

/// A ground that carries less than this share of the robot's weight carries nothing: a point on it means nothing then.
const LOADED: f64 = 0.01;

/// A place on the ground, or a direction along it: along x and y. In the plane y is zero.
pub type Point = [f64; 2];

/// By how much a force presses on the ground: its normal component over the cosine of the slope [N].
fn pressing(ground: &Plane, force: &Vector3<f64>) -> f64 {
    force.z - ground.steepness[0] * force.x - ground.steepness[1] * force.y
}

/// A force and its moment about the centre of mass [N, Nm], or a momentum about it [Ns, Nms].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Centroidal {
    /// The force or linear momentum.
    pub linear: Vector3<f64>,
    /// The moment or angular momentum.
    pub angular: Vector3<f64>,
}

impl Centroidal {
    /// From rows along a model's angular, then its linear axes: three in the plane, six in space.
    pub fn of_rows(rows: &[f64]) -> Self {
        match *rows {
            [angular, x, z] => Self { linear: Vector3::new(x, 0.0, z), angular: Vector3::new(0.0, -angular, 0.0) },
            [a, b, c, x, y, z] => Self { linear: Vector3::new(x, y, z), angular: Vector3::new(a, b, c) },
            _ => unreachable!("a model has three momentum rows or six"),
        }
    }

    /// The momentum of `model` in the state of `dynamics`, with the joint velocities `v`. Allocates nothing.
    pub fn momentum(model: &Model, dynamics: &Dynamics, v: &[f64]) -> Self {
        let mut angular = Vector3::zeros();
        for (row, axis) in model.angular_axes().iter().enumerate() {
            angular += axis * v.iter().enumerate().map(|(j, v)| dynamics.momentum_matrix[(row, j)] * v).sum::<f64>();
        }
        Self { linear: model.total_mass() * dynamics.com_velocity, angular }
    }

    /// The mean of `pushes` over the time `[from, to]` [s], in the pose of `dynamics`. Allocates nothing.
    pub fn of_pushes<'a>(
        pushes: impl IntoIterator<Item = &'a Push>,
        model: &Model,
        dynamics: &Dynamics,
        [from, to]: [f64; 2],
    ) -> Self {
        let mut sum = Self::default();
        for push in pushes {
            let share = (to.min(push.start_s + push.duration_s) - from.max(push.start_s)) / (to - from);
            if share.is_nan() || share <= 0.0 {
                continue;
            }
            let force = share * push.force_n * push.direction();
            sum.linear += force;
            if let Some(body) = model.body_index(&push.at) {
                let place = model.bodies[body].com + Vector3::from(push.point_m);
                sum.angular += (dynamics.world_from_body[body].point(&place) - dynamics.com).cross(&force);
            }
        }
        sum
    }

    /// What the ground must do, that the momentum changes at the rate `self` under gravity and a `push`. Newton, Euler
    pub fn of_ground(&self, weight: f64, push: &Self) -> Self {
        let mut linear = self.linear - push.linear;
        linear.z += weight;
        Self { linear, angular: self.angular - push.angular }
    }
}

/// The centre of pressure [m] of contacts, each its point and the force on it; none where they do not carry the robot of
/// `weight` [N]. Sardain & Bessonnet 2004
pub fn centre_of_pressure(
    ground: &Plane,
    weight: f64,
    contacts: impl IntoIterator<Item = (Vector3<f64>, Vector3<f64>)>,
) -> Option<Point> {
    let (mut pressing, mut moment) = (0.0, [0.0; 2]);
    for (point, force) in contacts {
        let part = self::pressing(ground, &force).max(0.0);
        pressing += part;
        moment = [moment[0] + part * point.x, moment[1] + part * point.y];
    }
    (pressing > LOADED * weight).then(|| moment.map(|moment| moment / pressing))
}

/// Where on the ground [m] a force acts that is `wrench` about the centre of mass: the zero-moment point of that wrench. None
/// where it does not press on the ground. Vukobratović & Borovac 2004; for slopes Sardain & Bessonnet 2004
pub fn zero_moment_point(ground: &Plane, weight: f64, com: &Vector3<f64>, wrench: &Centroidal) -> Option<Point> {
    let Centroidal { linear: force, angular } = wrench;
    let pressing = pressing(ground, force);
    // (p − o) N·f = N × m, with the moment m about the ground's point o at x = y = 0 and N = (−s_x, −s_y, 1)
    let arm = com.z - ground.at([0.0; 2]);
    let moment = [-angular.y + com.x * force.z - arm * force.x, angular.x + com.y * force.z - arm * force.y];
    let twist = angular.z + com.x * force.y - com.y * force.x;
    let [along, across] = ground.steepness;
    let place = || [(moment[0] - across * twist) / pressing, (moment[1] + along * twist) / pressing];
    (pressing > LOADED * weight).then(place)
}

/// Where the line through the centre of mass along the ground's `force` meets the ground [m]: the zero-moment point if the
/// angular momentum did not change. Popovic, Goswami & Herr 2005
pub fn centroidal_moment_pivot(ground: &Plane, weight: f64, com: &Vector3<f64>, force: Vector3<f64>) -> Option<Point> {
    zero_moment_point(ground, weight, com, &Centroidal { linear: force, angular: Vector3::zeros() })
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

    fn com() -> Vector3<f64> {
        Vector3::new(0.3, -0.1, 0.95)
    }

    /// A point of contact and the force on it.
    type Contact = (Vector3<f64>, Vector3<f64>);

    /// Contacts on a slope, and what they do about the centre of mass.
    fn contacts(ground: &Plane) -> ([Contact; 3], Centroidal) {
        let forces = [
            ([0.1, -0.2], [20.0, -30.0, 150.0]),
            ([0.32, 0.15], [-35.0, 15.0, 420.0]),
            ([0.7, -0.15], [60.0, 40.0, 90.0]),
        ];
        let contact = |(place, force): ([f64; 2], [f64; 3])| {
            (Vector3::new(place[0], place[1], ground.at(place)), Vector3::from(force))
        };
        let contacts = forces.map(contact);
        let mut sum = Centroidal::default();
        for (point, force) in &contacts {
            sum.linear += force;
            sum.angular += (point - com()).cross(force);
        }
        (contacts, sum)
    }

    fn slopes() -> [Plane; 4] {
        [[0.0, 0.0], [-0.2, 0.0], [0.15, 0.0], [0.1, -0.2]].map(|steepness| Plane {
            place: [0.2, 0.1],
            z: 0.1,
            steepness,
        })
    }

    #[test]
    fn the_moment_about_the_ground_vanishes_where_the_pressure_has_its_centre() {
        for ground in slopes() {
            let (contacts, sum) = contacts(&ground);
            let cop = centre_of_pressure(&ground, WEIGHT, contacts.iter().copied()).expect("it stands");
            let zmp = zero_moment_point(&ground, WEIGHT, &com(), &sum).expect("it stands");
            // The moment about it is along the normal alone.
            let at = Vector3::new(zmp[0], zmp[1], ground.at(zmp));
            let moment: Vector3<f64> = contacts.iter().map(|(point, force)| (point - at).cross(force)).sum();
            let normal = Vector3::new(-ground.steepness[0], -ground.steepness[1], 1.0);
            assert!(moment.cross(&normal).norm() < 1e-10, "{moment} on {ground:?}");
            // It is the centre of pressure where no force along the ground has an arm across it: all points are on the plane.
            assert!((0..2).all(|axis| (cop[axis] - zmp[axis]).abs() < 1e-12), "{cop:?} and {zmp:?} on {ground:?}");
        }
    }

    #[test]
    fn the_force_at_the_pivot_turns_nothing_and_the_rest_is_the_angular_momentum() {
        for ground in slopes() {
            let (contacts, sum) = contacts(&ground);
            let pivot = centroidal_moment_pivot(&ground, WEIGHT, &com(), sum.linear).expect("it stands");
            let arm = Vector3::new(pivot[0], pivot[1], ground.at(pivot)) - com();
            assert!(arm.cross(&sum.linear).norm() < 1e-10);
            let cop = centre_of_pressure(&ground, WEIGHT, contacts).expect("it stands");
            let rest = Vector3::new(cop[0] - pivot[0], cop[1] - pivot[1], ground.at(cop) - ground.at(pivot));
            let normal = Vector3::new(-ground.steepness[0], -ground.steepness[1], 1.0);
            assert!((rest.cross(&sum.linear) - sum.angular).cross(&normal).norm() < 1e-10);
        }
    }

    #[test]
    fn what_the_ground_does_is_the_rate_without_gravity_and_push() {
        let of = |rows: [f64; 6]| Centroidal::of_rows(&rows);
        let (rate, push) = (of([1.0, 3.0, 0.0, 50.0, 5.0, -100.0]), of([0.5, -4.0, 2.0, 200.0, 20.0, 10.0]));
        assert_eq!(rate.of_ground(WEIGHT, &push), of([0.5, 7.0, -2.0, -150.0, -15.0, 590.0]));
    }

    #[test]
    fn in_flight_there_is_no_such_point() {
        let ground = Plane::default();
        let falling = Centroidal::of_rows(&[2.0, 0.0, -WEIGHT]);
        let wrench = falling.of_ground(WEIGHT, &Centroidal::default());
        assert_eq!(zero_moment_point(&ground, WEIGHT, &com(), &wrench), None);
        // A load of less than a share of the weight is none.
        for (share, carries) in [(0.0, false), (0.9, false), (1.1, true)] {
            let force = Vector3::z() * (share * LOADED * WEIGHT);
            assert_eq!(centre_of_pressure(&ground, WEIGHT, [(com(), force)]).is_some(), carries, "{share}");
            assert_eq!(centroidal_moment_pivot(&ground, WEIGHT, &com(), force).is_some(), carries, "{share}");
        }
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
