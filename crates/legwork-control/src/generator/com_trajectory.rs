//! The desired motion of the centre of mass (thesis 4.3.1): given beforehand, independent of the state.

use nalgebra::Vector3;

use super::{PointReference, xcom};
use crate::settings::{ComSettings, TrajectoryKind};
use legwork_contract::error::Error;
use legwork_contract::terrain::Terrain;

/// A CoM trajectory in the x-z plane.
#[derive(Clone, Debug)]
pub enum ComTrajectory {
    /// Stays at a point.
    Stationary(Vector3<f64>),
    /// Constant forward velocity (its horizontal part is given) along the ground, from rest within a linear ramp.
    ConstantVelocity {
        /// Where it starts [m].
        start: Vector3<f64>,
        /// Velocity after the ramp [m/s].
        velocity: Vector3<f64>,
        /// Length of the ramp [s].
        ramp: f64,
    },
    /// Minimum-jerk motion between points, at rest in each.
    Waypoints(Vec<Waypoint>),
    /// Cubic splines in x and z.
    Sampled(Box<[Spline; 2]>),
}

/// A point of a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct Waypoint {
    /// When [s].
    pub time: f64,
    /// Where [m].
    pub position: Vector3<f64>,
}

impl ComTrajectory {
    /// The trajectory that `settings` ask for, from the robot's CoM at the `start` [m].
    ///
    /// `samples` are the rows `[t, x, z]` of the file, where one is asked for.
    ///
    /// # Errors
    /// Too few samples or way-points, one that is not above the ground, or times that do not increase.
    pub fn new(
        settings: &ComSettings,
        samples: &[[f64; 3]],
        start: Vector3<f64>,
        ground: &Terrain,
    ) -> Result<Self, Error> {
        Ok(match settings.trajectory {
            TrajectoryKind::Stationary => Self::Stationary(start),
            TrajectoryKind::ConstantVelocity => {
                let speed = settings.speed_mps;
                let velocity = Vector3::new(speed, 0.0, ground.base().steepness()[0] * speed);
                Self::ConstantVelocity { start, velocity, ramp: settings.ramp_s }
            }
            TrajectoryKind::Waypoints => {
                let key = "reference.com.waypoints";
                check_rows(key, &settings.waypoints, 1, ground)?;
                let points =
                    settings.waypoints.iter().map(|&[time, x, z]| Waypoint { time, position: Vector3::new(x, 0.0, z) });
                let first = Waypoint { time: 0.0, position: start };
                let lead_in = (settings.waypoints[0][0] > 0.0).then_some(first);
                Self::Waypoints(lead_in.into_iter().chain(points).collect())
            }
            TrajectoryKind::File => {
                check_rows(&settings.file, samples, 3, ground)?;
                let spline = |column: usize| Spline::natural(samples.iter().map(|row| (row[0], row[column])).collect());
                Self::Sampled(Box::new([spline(1), spline(2)]))
            }
        })
    }

    /// Position, velocity and acceleration at `time` [s]; before the first and after the last sample it rests.
    pub fn at(&self, time: f64) -> PointReference {
        match self {
            Self::Stationary(position) => PointReference { position: *position, ..PointReference::default() },
            Self::ConstantVelocity { start, velocity, ramp } if time < *ramp => PointReference {
                position: start + velocity * (0.5 * time * time / ramp),
                velocity: velocity * (time / ramp),
                acceleration: velocity / *ramp,
            },
            Self::ConstantVelocity { start, velocity, ramp } => PointReference {
                position: start + velocity * (time - 0.5 * ramp),
                velocity: *velocity,
                acceleration: Vector3::zeros(),
            },
            Self::Waypoints(points) => between(points, time),
            Self::Sampled(splines) => {
                let [x, z] = [splines[0].at(time), splines[1].at(time)];
                let vector = |i: usize| Vector3::new(x[i], 0.0, z[i]);
                PointReference { position: vector(0), velocity: vector(1), acceleration: vector(2) }
            }
        }
    }
}

/// At least `least` rows, above the ground, whose times increase.
fn check_rows(place: &str, rows: &[[f64; 3]], least: usize, ground: &Terrain) -> Result<(), Error> {
    if rows.len() < least {
        return Err(Error::invalid(
            place,
            format!("found {} rows [t_s, x_m, z_m]; at least {least} are needed", rows.len()),
        ));
    }
    for (index, &[_, x, z]) in rows.iter().enumerate() {
        let height = z - ground.height_at(x, 0.0);
        if height < xcom::SHORTEST {
            let problem = format!(
                "row {}: found z = {z} m at x = {x} m, {height} m over the ground; valid is {} m or more",
                index + 1,
                xcom::SHORTEST
            );
            return Err(Error::invalid(place, problem));
        }
    }
    for (index, pair) in rows.windows(2).enumerate() {
        if pair[1][0] <= pair[0][0] {
            return Err(Error::invalid(
                place,
                format!("row {}: time {} s comes after {} s; times must increase", index + 2, pair[1][0], pair[0][0]),
            ));
        }
    }
    Ok(())
}

/// Minimum-jerk interpolation (Flash and Hogan 1985): `10 s³ - 15 s⁴ + 6 s⁵`.
fn between(points: &[Waypoint], time: f64) -> PointReference {
    let after = points.partition_point(|point| point.time <= time);
    let rest = |position| PointReference { position, ..PointReference::default() };
    if after == 0 {
        return rest(points[0].position);
    }
    if after == points.len() {
        return rest(points[after - 1].position);
    }
    let (from, to) = (points[after - 1], points[after]);
    let duration = to.time - from.time;
    let s = (time - from.time) / duration;
    let way = to.position - from.position;
    PointReference {
        position: from.position + way * (s * s * s * (10.0 + s * (-15.0 + 6.0 * s))),
        velocity: way * (30.0 * s * s * (1.0 - s) * (1.0 - s) / duration),
        acceleration: way * (60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration)),
    }
}

/// Natural cubic spline through samples.
#[derive(Clone, Debug)]
pub struct Spline {
    knots: Vec<(f64, f64)>,
    curvature: Vec<f64>,
}

impl Spline {
    /// Through `knots` (time, value), whose times increase; no curvature at the ends.
    pub fn natural(knots: Vec<(f64, f64)>) -> Self {
        let n = knots.len();
        let mut curvature = vec![0.0; n];
        // Tridiagonal system for the second derivatives (Thomas algorithm).
        let mut upper = vec![0.0; n];
        for i in 1..n.saturating_sub(1) {
            let (before, after) = (knots[i].0 - knots[i - 1].0, knots[i + 1].0 - knots[i].0);
            let jump = (knots[i + 1].1 - knots[i].1) / after - (knots[i].1 - knots[i - 1].1) / before;
            let pivot = 2.0 * (before + after) - before * upper[i - 1];
            upper[i] = after / pivot;
            curvature[i] = (6.0 * jump - before * curvature[i - 1]) / pivot;
        }
        for i in (1..n.saturating_sub(1)).rev() {
            curvature[i] -= upper[i] * curvature[i + 1];
        }
        Self { knots, curvature }
    }

    /// Value, first and second derivative at `time`; constant outside the samples.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        if time < first.0 {
            return [first.1, 0.0, 0.0];
        }
        if time >= last.0 {
            return [last.1, 0.0, 0.0];
        }
        let right = self.knots.partition_point(|knot| knot.0 <= time);
        let left = right - 1;
        let ((t0, y0), (t1, y1)) = (self.knots[left], self.knots[right]);
        let (m0, m1) = (self.curvature[left], self.curvature[right]);
        let h = t1 - t0;
        let (a, b) = ((t1 - time) / h, (time - t0) / h);
        [
            a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0,
            (y1 - y0) / h + ((1.0 - 3.0 * a * a) * m0 + (3.0 * b * b - 1.0) * m1) * h / 6.0,
            a * m0 + b * m1,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn derivatives_agree(trajectory: &ComTrajectory, times: &[f64]) {
        let e = 1e-5;
        for &t in times {
            let (before, here, after) = (trajectory.at(t - e), trajectory.at(t), trajectory.at(t + e));
            let velocity = (after.position - before.position) / (2.0 * e);
            let acceleration = (after.velocity - before.velocity) / (2.0 * e);
            assert!((velocity - here.velocity).norm() < 1e-6, "velocity at {t}");
            assert!((acceleration - here.acceleration).norm() < 1e-6, "acceleration at {t}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let start = Vector3::new(0.2, 0.0, 0.9);
        let point = |time, x, z| Waypoint { time, position: Vector3::new(x, 0.0, z) };
        derivatives_agree(
            &ComTrajectory::ConstantVelocity { start, velocity: Vector3::new(0.5, 0.0, 0.02), ramp: 0.4 },
            &[0.1, 0.3, 0.7],
        );
        derivatives_agree(
            &ComTrajectory::Waypoints(vec![point(0.0, 0.2, 0.9), point(1.0, 0.4, 0.85), point(3.0, 0.1, 0.9)]),
            &[0.2, 0.9, 1.7, 3.5],
        );
        let samples: Vec<_> = (0..50).map(|i| f64::from(i) * 0.1).map(|t| (t, libm::sin(t))).collect();
        let splines = [Spline::natural(samples.clone()), Spline::natural(samples)];
        derivatives_agree(&ComTrajectory::Sampled(Box::new(splines)), &[0.05, 1.23, 4.0]);
    }

    #[test]
    fn spline_reproduces_a_sine() {
        let spline = Spline::natural((0..=40).map(|i| f64::from(i) * 0.1).map(|t| (t, libm::sin(t))).collect());
        for t in [1.05, 2.0, 2.51] {
            let [value, rate, second] = spline.at(t);
            assert!((value - libm::sin(t)).abs() < 1e-5);
            assert!((rate - libm::cos(t)).abs() < 1e-4);
            assert!((second + libm::sin(t)).abs() < 2e-3);
        }
    }

    #[test]
    fn waypoints_are_met_at_rest() {
        let point = |time, x| Waypoint { time, position: Vector3::new(x, 0.0, 0.9) };
        let trajectory = ComTrajectory::Waypoints(vec![point(0.0, 0.0), point(1.0, 0.3), point(2.0, -0.1)]);
        let met = trajectory.at(1.0);
        assert!((met.position.x - 0.3).abs() < 1e-12 && met.velocity.norm() < 1e-12);
        assert!((trajectory.at(9.0).position.x + 0.1).abs() < 1e-12);
    }
}
