//! What is impossible (names, numbers, trees, coordinates that move nothing or leave the plane) and what is odd.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use nalgebra::Matrix3;

use crate::base::Base;
use crate::description::{BodyDescription, Description, JointDescription};
use crate::dynamics::Dynamics;
use crate::error::ModelError;
use crate::model::{Dof, Model};
use crate::spatial::Placement;
use crate::words;

impl Description {
    pub(crate) fn check_names(&self) -> Result<(), ModelError> {
        if self.bodies.is_empty() {
            return Err(self.invalid(None, "bodies", "none; a robot has at least one body with mass"));
        }
        let reserved = self.base.coordinates();
        let virtual_bodies = reserved.len().saturating_sub(1);
        let (mut names, mut joint_names) = (HashSet::new(), HashSet::new());
        for body in &self.bodies {
            let (subject, joint) = (format!("body {:?}", body.name), &body.joint);
            if body.name.trim().is_empty() {
                return Err(self.invalid(body.line, "a body's name", "is empty"));
            }
            if body.parent.is_some() && joint.name.trim().is_empty() {
                return Err(self.invalid(joint.line.or(body.line), subject, "the name of its joint is empty"));
            }
            if !names.insert(&body.name) {
                return Err(self.invalid(body.line, subject, "the name is given twice; body names must differ"));
            }
            if body.parent.is_some() && !joint_names.insert(&joint.name) {
                let problem = "the name is given twice; joint names must differ";
                return Err(self.invalid(joint.line, format!("joint {:?}", joint.name), problem));
            }
            if reserved.contains(&joint.name) && body.parent.is_some() {
                let problem = format!("the name belongs to the base's own coordinates ({})", reserved.join(", "));
                return Err(self.invalid(joint.line, format!("joint {:?}", joint.name), problem));
            }
            if self.base == Base::Planar && reserved[..virtual_bodies].contains(&body.name) {
                return Err(self.invalid(body.line, subject, "the name belongs to the planar base's virtual bodies"));
            }
        }
        Ok(())
    }

    /// What can be said of one body and its joint alone. Numbers are known to be finite.
    pub(crate) fn check_body(&self, body: &BodyDescription) -> Result<(), ModelError> {
        let subject = format!("body {:?}", body.name);
        if body.mass < 0.0 {
            return Err(self.invalid(body.line, subject, format!("mass {} kg is negative", body.mass)));
        }
        if body.mass == 0.0 && body.inertia != Matrix3::zeros() {
            return Err(self.invalid(body.line, subject, "inertia without mass; give the mass as well, or neither"));
        }
        let largest = body.inertia.abs().max();
        if largest > 0.0 && !is_semi_definite(&(body.inertia / largest), 1e-9) {
            let problem = format!(
                "the inertia about the centre of mass is not positive definite (diagonal {}, {}, {} kg m²)",
                body.inertia[(0, 0)],
                body.inertia[(1, 1)],
                body.inertia[(2, 2)]
            );
            return Err(self.invalid(body.line, subject, problem));
        }
        // 1 % and 1e-6 kg m² leave room for files with few digits
        if triangle_violation(&body.inertia, 0.01 * body.inertia.trace() + 1e-6) {
            return Err(self.invalid(body.line, subject, TRIANGLE));
        }
        self.check_joint(body)
    }

    fn check_joint(&self, body: &BodyDescription) -> Result<(), ModelError> {
        let joint = &body.joint;
        let (subject, line) = (format!("joint {:?}", joint.name), joint.line.or(body.line));
        joint.check_numbers().map_err(|problem| self.invalid(line, &subject, problem))?;
        if body.parent.is_none() && joint.kind.nv() > 0 {
            let problem = format!("body {:?} has no parent, so its joint is the base's; name a parent", body.name);
            return Err(self.invalid(line, subject, problem));
        }
        if body.parent.is_none() && self.base != Base::Fixed && joint.placement != Placement::identity() {
            let problem = "the root link's origin has a meaning only with base = \"fixed\"; leave it out";
            return Err(self.invalid(line, subject, problem));
        }
        Ok(())
    }

    /// Indices of the bodies, parents first, otherwise in the order of the file.
    pub(crate) fn order(&self) -> Result<Vec<usize>, ModelError> {
        let name = |index: &usize| &self.bodies[*index].name;
        let roots: Vec<_> = (0..self.bodies.len()).filter(|&index| self.bodies[index].parent.is_none()).collect();
        if let [_, second, ..] = roots[..] {
            let names = words::list(roots.iter().map(name));
            let problem = format!("{} bodies have no parent ({names}); a robot has one root", roots.len());
            let second = &self.bodies[second];
            return Err(self.invalid(second.line, format!("body {:?}", second.name), problem));
        }
        let index_of: HashMap<_, _> = self.bodies.iter().enumerate().map(|(index, body)| (&body.name, index)).collect();
        let mut children = vec![Vec::new(); self.bodies.len()];
        for (index, body) in self.bodies.iter().enumerate() {
            let Some(parent) = &body.parent else { continue };
            let Some(&parent) = index_of.get(parent) else {
                let problem = format!("unknown parent {parent:?}; {}", self.known_bodies());
                return Err(self.invalid(body.line, format!("body {:?}", body.name), problem));
            };
            children[parent].push(index);
        }
        let mut order = Vec::with_capacity(self.bodies.len());
        let mut next: BinaryHeap<_> = roots.into_iter().map(Reverse).collect();
        while let Some(Reverse(index)) = next.pop() {
            order.push(index);
            next.extend(children[index].drain(..).map(Reverse));
        }
        if order.len() < self.bodies.len() {
            let placed: HashSet<_> = order.into_iter().collect();
            let stuck: Vec<_> = (0..self.bodies.len()).filter(|index| !placed.contains(index)).collect();
            let names = words::list(stuck.iter().map(name));
            let body = &self.bodies[stuck[0]];
            let problem = format!("is in a loop of parents ({names}); a robot is a tree");
            return Err(self.invalid(body.line, format!("body {:?}", body.name), problem));
        }
        Ok(order)
    }

    /// Whether every coordinate moves mass, and a planar robot stays in its plane.
    pub(crate) fn check_motion(&self, model: &Model) -> Result<(), ModelError> {
        if model.total_mass() <= 0.0 {
            return Err(self.invalid(None, "bodies", "no body has mass"));
        }
        // Without the mass matrix, of which the diagonal is enough: S_jᵀ I^c S_j.
        let mut dynamics = Dynamics::without_mass_matrix(model);
        dynamics.poses(model, model.neutral().as_slice());
        dynamics.inertias(model);
        for (j, dof) in model.dofs.iter().enumerate() {
            let body = &model.bodies[dof.body];
            let invalid = |problem: String| {
                Err(self.invalid(self.joint_line(&body.name), format!("joint {:?}", body.joint_name), problem))
            };
            let (s, composite) = (&dynamics.subspace[j], &dynamics.composite[dof.body]);
            let inertia = s.dot(&composite.momentum(s)) + dof.armature;
            if !(inertia > 0.0 && inertia.is_finite()) {
                let problem = if !inertia.is_finite() {
                    "moves more than numbers can hold; a mass or a length beyond it is too large".to_owned()
                } else if composite.mass > 0.0 {
                    format!("moves no inertia about its axis; give body {:?} an inertia", body.name)
                } else {
                    format!("moves no mass; give body {:?} a mass, or fix the joint", body.name)
                };
                return invalid(problem);
            }
            if !model.is_planar() || dof.body <= model.root() {
                continue;
            }
            // The tolerance admits π/2 given as 1.5708
            if dof.rotational && (s.angular.x.abs() > 1e-4 || s.angular.z.abs() > 1e-4) {
                return invalid(leaves_plane("parallel to y"));
            }
            if !dof.rotational && s.linear.y.abs() > 1e-4 {
                return invalid(leaves_plane("perpendicular to y"));
            }
        }
        Ok(())
    }
}

impl JointDescription {
    /// What is impossible about the numbers of its coordinate, which are known to be finite.
    pub(crate) fn check_numbers(&self) -> Result<(), String> {
        let Dof { lower, upper, stiffness, rest, stop_stiffness, stop_damping, .. } = self.dof;
        if lower > upper {
            let limit = |value: f64| match self.kind.kind().velocities {
                [(_, true)] => format!("{value:.6} rad ({:.2} deg)", value.to_degrees()),
                _ => format!("{value} m"),
            };
            return Err(format!("limits are crossed: lower {} is above upper {}", limit(lower), limit(upper)));
        }
        for (what, limit) in [("velocity", self.dof.velocity_limit), ("effort", self.dof.effort_limit)] {
            if limit < 0.0 {
                return Err(format!("{what} limit {limit} is negative; leave it out for no limit"));
            }
        }
        for (what, value) in [
            ("damping", self.dof.damping),
            ("armature", self.dof.armature),
            ("the spring's stiffness", stiffness),
            ("the stop's stiffness", stop_stiffness),
            ("the stop's damping", stop_damping),
        ] {
            if value < 0.0 {
                return Err(format!("{what} {value} is negative"));
            }
        }
        if rest != 0.0 && stiffness == 0.0 {
            return Err("a rest position without a spring; give the spring's stiffness as well, or neither".to_owned());
        }
        if stop_damping != 0.0 && stop_stiffness == 0.0 {
            return Err("a stop's damping without its stiffness; give the stiffness as well, or neither".to_owned());
        }
        if stop_stiffness != 0.0 && lower.is_infinite() && upper.is_infinite() {
            return Err("a stop without an end of the range; give lower or upper as well".to_owned());
        }
        Ok(())
    }
}

/// What is odd about a model without being impossible, one sentence each.
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
        if dof.actuated && dof.effort_limit == 0.0 {
            let name = &dof.name;
            odd.push(format!("joint {name:?} can give no effort: its effort limit is 0; leave it out for no limit"));
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
    odd
}

fn leaves_plane(direction: &str) -> String {
    format!("its axis is not {direction}, so the robot leaves the plane; use base = \"floating\", or fix the joint")
}

const TRIANGLE: &str = "no body has this inertia: a principal moment is larger than the sum of the other two";

/// Whether a principal moment exceeds the sum of the other two by more than `slack` [kg m²].
///
/// With the second moments of mass Σ = ½ tr(I) 1 − I this is λ_min(Σ) < −slack/2 (Wensing, Kim, Slotine 2018).
fn triangle_violation(inertia: &Matrix3<f64>, slack: f64) -> bool {
    let trace = inertia.trace();
    if trace <= 0.0 {
        return false;
    }
    let second_moments = Matrix3::identity() * 0.5 - inertia / trace;
    !is_semi_definite(&second_moments, 0.5 * slack / trace)
}

/// Whether a symmetric matrix of order one has no eigenvalue below −`tolerance`: all principal minors, Sylvester.
fn is_semi_definite(matrix: &Matrix3<f64>, tolerance: f64) -> bool {
    let m = matrix + Matrix3::identity() * tolerance;
    let minor = |i: usize, j: usize| m[(i, i)] * m[(j, j)] - m[(i, j)] * m[(j, i)];
    let rounding = -1e-15;
    (0..3).all(|i| m[(i, i)] >= rounding)
        && minor(0, 1) >= rounding
        && minor(0, 2) >= rounding
        && minor(1, 2) >= rounding
        && m.determinant() >= rounding
}
