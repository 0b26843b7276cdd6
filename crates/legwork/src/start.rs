//! The start pose: joint positions that put feet, centre of mass and torso where the scenario wants them.
//!
//! Joints that these leave free begin in the scenario's posture and resist being moved out of it (`RESISTANCE`), so that of all poses
//! one near the posture is found.

use legwork_rbd::{Base, Dynamics, Model};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::error::Error;
use crate::feet::{FeetMotion, Sole, pitched, rotation_error};
use crate::fit::Fit;
use crate::generator::check_feet;
use crate::posture::neutral;
use crate::redundancy::{free_joints, leg};
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::terrain::Terrain;
use crate::wearer::Build;

/// Largest error of the pose that counts as solved [m, rad].
const TOLERANCE: f64 = 1e-12;
/// What the square of a free joint's step weighs against the squares of the pose's errors [1/rad², 1/m²].
const RESISTANCE: f64 = 1e-2;
/// So many guesses bend each joint differently, where none that bends all alike led to a pose.
const MIXED: u32 = 40;

/// Joint positions [rad, m] of the start pose of `scenario`: feet on the `ground` (and flat on it, where they have an
/// orientation), CoM and torso as given, all joints within their limits.
///
/// # Errors
/// The robot has not two feet, or no such pose exists: it names what could not be met.
pub fn start_pose(scenario: &Scenario, model: &Robot, ground: &Terrain) -> Result<DVector<f64>, Error> {
    check_feet(model)?;
    let start = &scenario.start;
    let (stature, shift) = match scenario.fit {
        Fit::None => (scenario.wearer.stature(), Build::beyond(&scenario.wearer, model).com()),
        _ => (1.0, 0.0),
    };
    let on_ground = |x: f64, y: f64| Vector3::new(stature * x, y, ground.height_at(stature * x, y));
    let sole = Sole::of(model);
    let half = 0.5 * (sole.toe - sole.heel);
    let aside = if model.is_planar() { 0.0 } else { 0.5 * start.feet_width_m };
    let places = [(start.right_foot_x_m, -aside), (start.left_foot_x_m, aside)].map(|(x, y)| [stature * x, y]);
    let lies = places.map(|[x, y]| ground.below_a_sole(x, y, [-half, half]));
    let target = Target {
        feet: [0, 1].map(|foot| Vector3::new(places[foot][0], places[foot][1], lies[foot].z)),
        rotation: lies.map(|line| ground.base().inclined(libm::atan(line.steepness)).rotation()),
        com: on_ground(start.com_x_m, 0.0) + Vector3::z() * (stature * start.com_height_m + shift),
        torso: start.torso_angle_deg.to_radians(),
    };
    let posture = Posture::of(scenario, model)?;
    let mut best: Option<(f64, DVector<f64>)> = None;
    let mut beyond = None;
    let mut nearest: Option<(f64, DVector<f64>)> = None;
    // A leg may bend another way where a joint has no limits.
    let any_way = model.dofs.iter().any(|dof| dof.actuated && dof.usual_range().is_none());
    let frees = if any_way { &[0.0, 0.5, -0.5][..] } else { &[0.0] };
    let alike = frees.iter().flat_map(|&free| {
        [0.5, 0.25, 0.75, 0.1, 0.9].map(|bend| first_guess(model, &target, &posture, |_| bend, free))
    });
    let mixed = (1..=MIXED).map(|k| {
        let bend = |joint| 2.0 * (f64::from(k) * libm::sqrt((2 * joint + 3) as f64)).fract();
        first_guess(model, &target, &posture, bend, 0.0)
    });
    let bent = [0.3, 0.6].into_iter().filter_map(|bend| bent_knees(model, &target, &posture, bend));
    let bent: Vec<_> = if any_way && model.base == Base::Floating { bent.collect() } else { Vec::new() };
    let count = bent.len() + 5 * frees.len();
    for (index, guess) in bent.into_iter().chain(alike).chain(mixed).enumerate() {
        if let Some((_, q)) = nearest.take_if(|_| index >= count) {
            return Ok(q);
        }
        let (error, q) = solve(model, &target, &posture, guess);
        if error < TOLERANCE {
            match check_limits(model, &q) {
                Ok(()) if posture.free.is_empty() => return Ok(q),
                Ok(()) => {
                    let distance = posture.distance(model, &q);
                    if nearest.as_ref().is_none_or(|(least, _)| distance < *least) {
                        nearest = Some((distance, q));
                    }
                }
                Err(error) => beyond = beyond.or(Some(error)),
            }
        } else if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, q));
        }
    }
    if let Some((_, q)) = nearest {
        return Ok(q);
    }
    Err(beyond.unwrap_or_else(|| {
        let (_, q) = best.expect("at least one guess was tried");
        unreachable(model, &target, &q)
    }))
}

struct Target {
    feet: [Vector3<f64>; 2],
    /// Of feet that have one: they lie flat.
    rotation: [Matrix3<f64>; 2],
    com: Vector3<f64>,
    torso: f64,
}

/// What the start pose is to be near to.
struct Posture {
    /// Where each coordinate is [rad, m].
    positions: Vec<f64>,
    /// The coordinates that are free to be there.
    free: Vec<usize>,
}

impl Posture {
    fn of(scenario: &Scenario, model: &Robot) -> Result<Self, Error> {
        let given = scenario.start.posture.positions(model);
        let given = given.map_err(|problem| Error::invalid("start.posture", problem))?;
        let positions =
            given.into_iter().zip(neutral(model)).map(|(given, neutral)| given.unwrap_or(neutral)).collect();
        Ok(Self { positions, free: free_joints(model) })
    }

    /// How far a coordinate of the pose `q` is from it [rad, m].
    fn off_by(&self, model: &Model, q: &DVector<f64>, dof: usize) -> f64 {
        q[model.bodies[model.dofs[dof].body].q_index] - self.positions[dof]
    }

    /// How far the free joints of a pose are from it, a sum of squares.
    fn off(&self, model: &Model, q: &DVector<f64>) -> f64 {
        self.free.iter().map(|&dof| self.off_by(model, q, dof)).map(|off| off * off).sum()
    }

    /// The same of all joints.
    fn distance(&self, model: &Model, q: &DVector<f64>) -> f64 {
        model.actuated().map(|dof| self.off_by(model, q, dof)).map(|off| off * off).sum()
    }
}

/// A pose between the joint limits; `bend` chooses where, for each joint, and joints without limits are at `free` [rad, m]. Joints that
/// are free are in the posture.
fn first_guess(
    model: &Robot,
    target: &Target,
    posture: &Posture,
    bend: impl Fn(usize) -> f64,
    free: f64,
) -> DVector<f64> {
    let mut q = model.neutral();
    for (joint, dof) in model.dofs.iter().filter(|dof| dof.actuated).enumerate() {
        let bend = bend(joint);
        q[model.bodies[dof.body].q_index] = match dof.usual_range() {
            // From the limit that is nearer to zero, which is the straighter leg.
            Some([lower, upper]) if lower.abs() < upper.abs() => lower + bend * 0.5 * (upper - lower),
            Some([lower, upper]) => upper - bend * 0.5 * (upper - lower),
            None => free,
        };
    }
    for &dof in &posture.free {
        q[model.bodies[model.dofs[dof].body].q_index] = posture.positions[dof];
    }
    match model.base {
        Base::Planar => (q[0], q[1]) = (target.com.x, 0.3 * target.com.z),
        Base::Floating => {
            let upright = Rotation3::from_matrix_unchecked(model.facing().transpose());
            let quaternion = UnitQuaternion::from_rotation_matrix(&upright);
            (q[0], q[1], q[2], q[3]) = (quaternion.w, quaternion.i, quaternion.j, quaternion.k);
            (q[4], q[6]) = (target.com.x, target.com.z);
        }
        Base::Fixed => {}
    }
    q
}

/// A pose with knees that are bent by twice `bend` [rad] and torso and soles upright, of legs with three joints or more across the way that
/// the robot faces: where joints have no limits, nothing else tells a knee's way to bend.
fn bent_knees(model: &Robot, target: &Target, posture: &Posture, bend: f64) -> Option<DVector<f64>> {
    let mut q = first_guess(model, target, posture, |_| 0.5, 0.0);
    let mut zero = Dynamics::new(model);
    zero.update(model, model.neutral().as_slice(), &vec![0.0; model.nv()]);
    let left = model.facing().column(1).into_owned();
    for foot in 0..2 {
        let across = leg(model, foot).into_iter().filter_map(|body| {
            let turn = left.dot(&(zero.world_from_body[body].rotation * model.bodies[body].joint.axis()?.into_inner()));
            (turn.abs() > 0.9).then_some((model.bodies[body].q_index, turn.signum()))
        });
        let across: Vec<_> = across.collect();
        let [(hip, a), (knee, b), .., (ankle, c)] = across[..] else { return None };
        (q[hip], q[knee], q[ankle]) = (-a * bend, 2.0 * b * bend, -c * bend);
    }
    Some(q)
}

/// Levenberg-Marquardt on the pose's errors; returns the largest error left and the pose. Where joints are free they are drawn to the
/// posture first; if no pose was found so, they are let go and only resist.
fn solve(model: &Robot, target: &Target, posture: &Posture, mut q: DVector<f64>) -> (f64, DVector<f64>) {
    let (mut dynamics, mut feet) = (Dynamics::new(model), FeetMotion::new(model));
    let (mut error, mut jacobian) = residual(model, target, &mut dynamics, &mut feet, &q);
    let passes: &[f64] = if posture.free.is_empty() { &[0.0] } else { &[RESISTANCE, 0.0] };
    for pull in passes {
        let cost = |error: &DVector<f64>, q: &DVector<f64>| error.norm_squared() + pull * posture.off(model, q);
        let mut damping = 1e-3;
        for _ in 0..300 {
            if error.amax() < TOLERANCE {
                break;
            }
            let (mut normal, mut slope) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&error));
            for i in 0..normal.nrows() {
                normal[(i, i)] += damping;
            }
            for &dof in &posture.free {
                normal[(dof, dof)] += RESISTANCE;
                slope[dof] -= pull * posture.off_by(model, &q, dof);
            }
            let Some(cholesky) = normal.cholesky() else { break };
            let step = cholesky.solve(&slope);
            let mut next = q.clone();
            model.integrate(q.as_slice(), step.as_slice(), 1.0, next.as_mut_slice());
            let (next_error, next_jacobian) = residual(model, target, &mut dynamics, &mut feet, &next);
            if cost(&next_error, &next) < cost(&error, &q) {
                (q, error, jacobian) = (next, next_error, next_jacobian);
                damping = (damping * 0.1).max(1e-15);
            } else {
                damping *= 10.0;
            }
        }
    }
    let mut q = wrap(model, q);
    if model.is_planar() {
        // So many joints turned so often: the base turns back.
        dynamics.update(model, q.as_slice(), &vec![0.0; model.nv()]);
        q[2] -= whole_turns(model.torso_angle(&dynamics, q.as_slice()) - target.torso);
    }
    (error.amax(), q)
}

/// Target minus pose, and the pose's Jacobian: feet, CoM, torso.
fn residual(
    model: &Robot,
    target: &Target,
    dynamics: &mut Dynamics,
    feet: &mut FeetMotion,
    q: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    dynamics.update(model, q.as_slice(), &vec![0.0; model.nv()]);
    feet.update(model, dynamics);
    let (linear, angular) = (model.linear_axes(), model.angular_axes());
    let (com, torso) = (feet.bias.len(), feet.bias.len() + linear.len());
    let rows = torso + angular.len();
    let (mut error, mut jacobian) = (DVector::zeros(rows), DMatrix::zeros(rows, model.nv()));
    for (foot, place) in target.feet.iter().enumerate() {
        let rows = feet.rows(foot);
        for (row, axis) in rows.linear.clone().zip(linear) {
            error[row] = axis.dot(&(place - feet.position[foot]));
        }
        let turn = rotation_error(&feet.rotation[foot], &target.rotation[foot]);
        for (row, axis) in rows.angular.clone().zip(angular) {
            error[row] = axis.dot(&turn);
        }
    }
    for (row, axis) in linear.iter().enumerate() {
        error[com + row] = axis.dot(&(target.com - dynamics.com));
    }
    if model.is_planar() {
        error[torso] = target.torso - model.torso_angle(dynamics, q.as_slice());
    } else {
        let turn = rotation_error(&model.torso_rotation(dynamics), &pitched(target.torso));
        error.rows_mut(torso, angular.len()).copy_from(&turn);
    }
    jacobian.rows_mut(0, com).copy_from(&feet.jacobian);
    jacobian.rows_mut(com, linear.len()).copy_from(&dynamics.com_jacobian);
    let mut turning = DMatrix::zeros(angular.len(), model.nv());
    dynamics.angular_jacobian(model, model.torso, &mut turning);
    jacobian.rows_mut(torso, angular.len()).copy_from(&turning);
    (error, jacobian)
}

/// Turns each joint by whole revolutions towards the middle of its range, or towards zero.
fn wrap(model: &Model, mut q: DVector<f64>) -> DVector<f64> {
    for dof in model.dofs.iter().filter(|dof| dof.rotational && dof.actuated) {
        let index = model.bodies[dof.body].q_index;
        let half_a_turn = std::f64::consts::PI;
        let middle = match (dof.lower.is_finite(), dof.upper.is_finite()) {
            (true, true) => 0.5 * (dof.lower + dof.upper),
            (true, false) => dof.lower + half_a_turn,
            (false, true) => dof.upper - half_a_turn,
            (false, false) => 0.0,
        };
        q[index] -= whole_turns(q[index] - middle);
    }
    q
}

/// The whole revolutions that are nearest to an angle [rad].
fn whole_turns(angle: f64) -> f64 {
    (angle / std::f64::consts::TAU).round() * std::f64::consts::TAU
}

fn check_limits(model: &Model, q: &DVector<f64>) -> Result<(), Error> {
    for dof in &model.dofs {
        let angle = q[model.bodies[dof.body].q_index];
        if dof.actuated && !(dof.lower..=dof.upper).contains(&angle) {
            let (limit, words) =
                if angle < dof.lower { (dof.lower, "below its lower") } else { (dof.upper, "above its upper") };
            let position = |value: f64| {
                if dof.rotational { format!("{:.1} deg", value.to_degrees()) } else { format!("{value:.3} m") }
            };
            return Err(Error::invalid(
                "start",
                format!(
                    "the start pose puts {} at {}, {words} limit of {}; lower or raise start.com_height_m or move the feet",
                    dof.name,
                    position(angle),
                    position(limit)
                ),
            ));
        }
    }
    Ok(())
}

fn unreachable(model: &Robot, target: &Target, q: &DVector<f64>) -> Error {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q.as_slice(), &vec![0.0; model.nv()]);
    let mut motion = FeetMotion::new(model);
    motion.update(model, &dynamics);
    let feet = &motion.position;
    Error::invalid(
        "start",
        format!(
            "no pose has the feet at x = {} and {} m and the centre of mass at ({}, {}) m: the legs do not reach that far \
             (nearest found: feet at ({:.3}, {:.3}) and ({:.3}, {:.3}) m, centre of mass at ({:.3}, {:.3}) m); \
             change start.com_height_m, start.com_x_m or the feet{}",
            target.feet[0].x,
            target.feet[1].x,
            target.com.x,
            target.com.z,
            feet[0].x,
            feet[0].z,
            feet[1].x,
            feet[1].z,
            dynamics.com.x,
            dynamics.com.z,
            if *model.facing() == Matrix3::identity() { String::new() } else { format!("; {}", model.faces()) }
        ),
    )
}
