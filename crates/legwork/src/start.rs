//! The start pose: joint positions that put feet, centre of mass and torso where the scenario wants them.

use legwork_rbd::{Dynamics, Model};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::contact::GroundPlane;
use crate::error::Error;
use crate::scenario::Scenario;

/// Largest error of the pose that counts as solved [m, rad].
const TOLERANCE: f64 = 1e-12;

/// Joint positions [rad, m] of the start pose of `scenario`: feet on the `ground`, CoM and torso as given, all joints
/// within their limits.
///
/// # Errors
/// No such pose exists: it names what could not be met.
pub fn start_pose(scenario: &Scenario, model: &Model, ground: &GroundPlane) -> Result<DVector<f64>, Error> {
    let start = &scenario.start;
    let on_ground = |x: f64| Vector3::new(x, 0.0, ground.height_at(x));
    let target = Target {
        feet: vec![on_ground(start.right_foot_x_m), on_ground(start.left_foot_x_m)],
        com: on_ground(start.com_x_m) + Vector3::z() * start.com_height_m,
        torso: start.torso_angle_deg.to_radians(),
    };
    let mut best: Option<(f64, DVector<f64>)> = None;
    for bend in [0.5, 0.25, 0.75, 0.1, 0.9] {
        let (error, q) = solve(model, &target, first_guess(model, &target, bend));
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, q));
        }
        if error < TOLERANCE {
            break;
        }
    }
    let (error, q) = best.expect("at least one guess was tried");
    if error < TOLERANCE {
        return check_limits(model, q);
    }
    Err(unreachable(model, &target, &q))
}

struct Target {
    feet: Vec<Vector3<f64>>,
    com: Vector3<f64>,
    torso: f64,
}

/// A pose between the joint limits; `bend` chooses where.
fn first_guess(model: &Model, target: &Target, bend: f64) -> DVector<f64> {
    let mut q = model.neutral();
    for dof in &model.dofs {
        let (lower, upper) = (dof.lower, dof.upper);
        if dof.actuated && lower.is_finite() && upper.is_finite() {
            // From the limit that is nearer to zero, which is the straighter leg.
            let (near, far) = if lower.abs() < upper.abs() { (lower, upper) } else { (upper, lower) };
            q[model.bodies[dof.body].q_index] = near + bend * 0.5 * (far - near);
        }
    }
    if q.len() >= 2 {
        (q[0], q[1]) = (target.com.x, 0.3 * target.com.z);
    }
    q
}

/// Levenberg-Marquardt on the pose's errors; returns the largest error left and the pose.
fn solve(model: &Model, target: &Target, mut q: DVector<f64>) -> (f64, DVector<f64>) {
    let mut dynamics = Dynamics::new(model);
    let mut damping = 1e-3;
    let (mut error, mut jacobian) = residual(model, target, &mut dynamics, &q);
    for _ in 0..300 {
        if error.amax() < TOLERANCE {
            break;
        }
        let mut normal = jacobian.tr_mul(&jacobian);
        for i in 0..normal.nrows() {
            normal[(i, i)] += damping;
        }
        let Some(cholesky) = normal.cholesky() else { break };
        let step = cholesky.solve(&jacobian.tr_mul(&error));
        let mut next = q.clone();
        model.integrate(q.as_slice(), step.as_slice(), 1.0, next.as_mut_slice());
        let (next_error, next_jacobian) = residual(model, target, &mut dynamics, &next);
        if next_error.norm_squared() < error.norm_squared() {
            (q, error, jacobian) = (next, next_error, next_jacobian);
            damping = (damping * 0.1).max(1e-15);
        } else {
            damping *= 10.0;
        }
    }
    (error.amax(), wrap(model, q))
}

/// Target minus pose, and the pose's Jacobian: feet, CoM, torso.
fn residual(model: &Model, target: &Target, dynamics: &mut Dynamics, q: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    dynamics.update(model, q.as_slice(), &vec![0.0; model.nv()]);
    let (axes, nv) = (model.linear_axes(), model.nv());
    let d = axes.len();
    let rows = d * (target.feet.len() + 1) + 1;
    let (mut error, mut jacobian) = (DVector::zeros(rows), DMatrix::zeros(rows, nv));
    for (i, axis) in axes.iter().enumerate() {
        for (foot, place) in target.feet.iter().enumerate() {
            error[foot * d + i] = axis.dot(&(place - dynamics.contact_positions[foot]));
        }
        error[target.feet.len() * d + i] = axis.dot(&(target.com - dynamics.com));
    }
    error[rows - 1] = target.torso - dynamics.torso_angle(model);
    jacobian.rows_mut(0, d * target.feet.len()).copy_from(&dynamics.contact_jacobian);
    jacobian.rows_mut(d * target.feet.len(), d).copy_from(&dynamics.com_jacobian);
    jacobian.row_mut(rows - 1).copy_from(&dynamics.torso_jacobian.row(0));
    (error, jacobian)
}

/// Turns each joint by whole revolutions towards the middle of its range.
fn wrap(model: &Model, mut q: DVector<f64>) -> DVector<f64> {
    for dof in model.dofs.iter().filter(|dof| dof.rotational && dof.actuated && dof.lower.is_finite()) {
        let index = model.bodies[dof.body].q_index;
        let middle = 0.5 * (dof.lower + dof.upper);
        q[index] -= ((q[index] - middle) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    }
    q
}

fn check_limits(model: &Model, q: DVector<f64>) -> Result<DVector<f64>, Error> {
    for dof in &model.dofs {
        let angle = q[model.bodies[dof.body].q_index];
        if dof.actuated && !(dof.lower..=dof.upper).contains(&angle) {
            return Err(Error::invalid(
                "start",
                format!(
                    "the start pose puts {} at {:.1} deg, outside of its limits [{:.1}, {:.1}] deg; \
                     lower or raise start.com_height_m or move the feet",
                    dof.name,
                    angle.to_degrees(),
                    dof.lower.to_degrees(),
                    dof.upper.to_degrees()
                ),
            ));
        }
    }
    Ok(q)
}

fn unreachable(model: &Model, target: &Target, q: &DVector<f64>) -> Error {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q.as_slice(), &vec![0.0; model.nv()]);
    let feet = [&dynamics.contact_positions[0], &dynamics.contact_positions[1]];
    Error::invalid(
        "start",
        format!(
            "no pose has the feet at x = {} and {} m and the centre of mass at ({}, {}) m: the legs do not reach that far \
             (nearest found: feet at ({:.3}, {:.3}) and ({:.3}, {:.3}) m, centre of mass at ({:.3}, {:.3}) m); \
             change start.com_height_m, start.com_x_m or the feet",
            target.feet[0].x,
            target.feet[1].x,
            target.com.x,
            target.com.z,
            feet[0].x,
            feet[0].z,
            feet[1].x,
            feet[1].z,
            dynamics.com.x,
            dynamics.com.z
        ),
    )
}
