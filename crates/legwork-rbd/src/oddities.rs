//! What is odd about a model without being impossible.

use nalgebra::Matrix3;

use crate::base::Base;
use crate::check::{TRIANGLE, triangle_violation};
use crate::model::Model;

/// One sentence each.
pub(crate) fn oddities(model: &Model) -> Vec<String> {
    let mut odd = Vec::new();
    for (i, body) in model.bodies.iter().enumerate().skip(model.root()) {
        let bolted = i == 0 && model.base == Base::Fixed;
        if body.mass == 0.0 && !bolted {
            odd.push(format!("body {:?} has no mass", body.name));
        }
        if body.mass > 0.0 && body.inertia == Matrix3::zeros() {
            odd.push(format!("body {:?} has mass but no inertia: a point mass", body.name));
        }
        if triangle_violation(&body.inertia, 1e-9 * body.inertia.trace()) {
            odd.push(format!("body {:?}: {TRIANGLE}, slightly", body.name));
        }
    }
    for dof in &model.dofs {
        if dof.lower >= dof.upper {
            odd.push(format!("joint {:?} is locked: lower and upper limit are both {}", dof.name, dof.lower));
        }
        let turn = 2.0 * std::f64::consts::PI;
        if dof.rotational && (dof.lower > turn || dof.upper < -turn) {
            odd.push(format!(
                "joint {:?} can be nowhere near zero: its limits are {} and {} rad; are they degrees?",
                dof.name, dof.lower, dof.upper
            ));
        } else if dof.rotational && dof.upper.is_finite() && dof.lower.is_finite() && dof.upper - dof.lower > 4.0 * turn
        {
            odd.push(format!(
                "joint {:?} may turn more than four times: its limits are {} and {} rad; are they degrees?",
                dof.name, dof.lower, dof.upper
            ));
        }
    }
    for (index, foot) in model.feet.iter().enumerate() {
        let mut bodies = model.contacts.iter().filter(|c| c.foot == index).map(|c| c.body);
        let first = bodies.next();
        if bodies.any(|body| Some(body) != first) {
            odd.push(format!("the contact points of {foot:?} are on different bodies"));
        }
    }
    odd
}
