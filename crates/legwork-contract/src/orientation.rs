//! Which way a robot faces: forward, left and up of its zero position, whatever the axes of its links.
//!
//! Up is the axis of the root link that the soles' normals are nearest to. Left is from the first foot, the right one, to the second;
//! forward is at right angles to both. What is within a degree of an axis of the root link is that axis. A robot in the plane, or with
//! fewer than two feet, faces along x.

use legwork_rbd::{Base, Dynamics, Model};
use nalgebra::{Matrix3, Unit, Vector3};

/// What is nearer to an axis than this is that axis [rad].
const NEAR: f64 = 0.02;
/// Places nearer to each other than this say nothing of a direction [m].
const APART: f64 = 5e-3;

/// Forward, left and up as columns, along the axes that `model` has in the dynamics at its `zero` position; `feet` are the contact points
/// of each foot, `forward` is what its file says.
pub(crate) fn facing(
    model: &Model,
    zero: &Dynamics,
    feet: &[Vec<usize>],
    forward: Option<Unit<Vector3<f64>>>,
) -> Matrix3<f64> {
    let [right, left] = feet else { return Matrix3::identity() };
    if model.base != Base::Floating {
        return Matrix3::identity();
    }
    let normals = [right, left].map(|points| normal(model, zero, points).unwrap_or_else(Vector3::zeros));
    let up = nearest_axis(&(normals[0] + normals[1])).unwrap_or_else(Vector3::z);
    let aside = centre(zero, left) - centre(zero, right);
    let level = |v: Vector3<f64>| (v - up * up.dot(&v)).try_normalize(APART);
    let Some(forward) = forward.and_then(|forward| level(*forward)).or_else(|| level(aside.cross(&up))) else {
        return Matrix3::identity();
    };
    let forward = nearest_axis(&forward).filter(|axis| axis.cross(&forward).norm() < NEAR).unwrap_or(forward);
    Matrix3::from_columns(&[forward, up.cross(&forward), up])
}

/// Whether the feet point against `facing`: their heels are farther from the ankles than their toes.
pub(crate) fn heels_first(model: &Model, zero: &Dynamics, feet: &[Vec<usize>], facing: &Matrix3<f64>) -> bool {
    let forward = facing.column(0).into_owned();
    let backward = |points: &Vec<usize>| {
        let [first, _, _, ..] = points[..] else { return false };
        let ankle = ankle(model, zero, model.contacts[first].body);
        let ahead = |&point: &usize| forward.dot(&(zero.contact_positions[point] - ankle));
        let toe = points.iter().map(ahead).fold(f64::NEG_INFINITY, f64::max);
        let heel = -points.iter().map(ahead).fold(f64::INFINITY, f64::min);
        heel > toe + APART
    };
    model.base == Base::Floating && feet.len() == 2 && feet.iter().all(backward)
}

/// The normal of the plane of a foot's contact points, toward its ankle; none where they are on a line.
pub(crate) fn normal(model: &Model, zero: &Dynamics, points: &[usize]) -> Option<Vector3<f64>> {
    let place = |k: usize| zero.contact_positions[points[k]];
    let pairs = (1..points.len()).flat_map(|j| (1..j).map(move |k| (k, j)));
    let area = |(j, k): (usize, usize)| (place(j) - place(0)).cross(&(place(k) - place(0)));
    let largest = pairs.map(area).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let normal = largest.try_normalize(APART * APART)?;
    // Above a sole's link, which may lie in the plane, something of the leg does not.
    let mut at = Some(model.contacts[points[0]].body);
    while let Some(body) = at {
        let height = normal.dot(&(zero.world_from_body[body].translation - centre(zero, points)));
        if height.abs() > APART {
            return Some(normal * height.signum());
        }
        at = model.bodies[body].parent;
    }
    None
}

/// Where the joint is that moves `body`, or what it is fixed to.
fn ankle(model: &Model, zero: &Dynamics, body: usize) -> Vector3<f64> {
    zero.world_from_body[model.mover(body)].translation
}

/// The middle of contact points.
fn centre(zero: &Dynamics, points: &[usize]) -> Vector3<f64> {
    points.iter().map(|&point| zero.contact_positions[point]).sum::<Vector3<f64>>() / points.len() as f64
}

/// The axis, or its opposite, that is nearest to `direction`; none of nothing.
fn nearest_axis(direction: &Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = direction.iamax();
    let component = direction[largest];
    (component.abs() > 1e-9).then(|| Vector3::ith(largest, component.signum()))
}
