//! What is impossible (names, numbers, trees, coordinates that move nothing or leave the plane) and what is odd.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use nalgebra::Matrix3;

use crate::base::Base;
use crate::description::{BodyDescription, Description, Inertias, JointDescription};
use crate::dynamics::Dynamics;
use crate::error::{ModelError, Problems};
use crate::forward_dynamics::ForwardDynamics;
use crate::model::{Dof, Model};
use crate::spatial::{Motion, Placement};
use crate::words;

impl Description {
    pub(crate) fn check_names(&self, problems: &mut Problems) {
        if self.bodies.is_empty() {
            problems.add(self.invalid(None, "bodies", "none; a robot has at least one body with mass"));
        }
        let reserved = self.base.coordinates();
        let virtual_bodies = reserved.len().saturating_sub(1);
        let (mut names, mut joint_names) = (HashSet::new(), HashSet::new());
        for body in &self.bodies {
            let (subject, joint) = (format!("body {:?}", body.name), &body.joint);
            let mut tell = |line, subject: &str, problem: &str| problems.add(self.invalid(line, subject, problem));
            if body.name.trim().is_empty() {
                tell(body.line, "a body's name", "is empty");
            } else if !names.insert(&body.name) {
                tell(body.line, &subject, "the name is given twice; body names must differ");
            } else if self.base == Base::Planar && reserved[..virtual_bodies].contains(&body.name) {
                tell(body.line, &subject, "the name belongs to the planar base's virtual bodies");
            }
            if body.parent.is_none() {
                continue;
            }
            let named = format!("joint {:?}", joint.name);
            if joint.name.trim().is_empty() {
                tell(joint.line.or(body.line), &subject, "the name of its joint is empty");
            } else if !joint_names.insert(&joint.name) {
                tell(joint.line, &named, "the name is given twice; joint names must differ");
            } else if reserved.contains(&joint.name) {
                let problem = format!("the name belongs to the base's own coordinates ({})", reserved.join(", "));
                tell(joint.line, &named, &problem);
            }
        }
    }

    /// What can be said of one body and its joint alone. Numbers are known to be finite.
    pub(crate) fn check_body(&self, body: &BodyDescription) -> Result<(), ModelError> {
        let subject = format!("body {:?}", body.name);
        if body.mass < 0.0 {
            return Err(self.invalid(body.line, subject, format!("mass {} kg is negative", body.mass)));
        }
        self.check_joint(body)
    }

    /// Says of each inertia that no body has by how much, and repairs it where that is asked for.
    pub(crate) fn mend_inertias(&mut self) {
        for body in &mut self.bodies {
            let inertia = body.inertia;
            let odd = if body.mass == 0.0 && inertia != Matrix3::zeros() {
                "has an inertia but no mass".to_owned()
            } else if let Some(violation) = violation(&inertia).filter(|violation| violation.is_more_than_rounding()) {
                violation.to_string()
            } else {
                continue;
            };
            let done = match self.inertias {
                Inertias::Kept => {
                    "it is kept as it is (inertias = \"repaired\" changes it to the nearest that a body can have)"
                }
                Inertias::Repaired => {
                    body.inertia = if body.mass == 0.0 { Matrix3::zeros() } else { nearest(&inertia) };
                    "it is changed to the nearest that a body can have"
                }
            };
            self.warnings.push(format!("body {:?}: {odd}; {done}", body.name));
        }
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
        let (dynamics, inertias) = model.own_inertias();
        for (j, dof) in model.dofs.iter().enumerate() {
            let body = &model.bodies[dof.body];
            let invalid = |problem: String| {
                Err(self.invalid(self.joint_line(&body.name), format!("joint {:?}", body.joint_name), problem))
            };
            let (s, composite) = (&dynamics.subspace[j], &dynamics.composite[dof.body]);
            let inertia = inertias[j];
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
        self.check_inertias(model)
    }

    /// Whether inertias that no body has leave the robot a positive definite mass matrix, at zero and at other positions.
    fn check_inertias(&self, model: &Model) -> Result<(), ModelError> {
        let odd = |body: &&BodyDescription| {
            violation(&body.inertia).is_some() || body.mass == 0.0 && body.inertia != Matrix3::zeros()
        };
        let Some(first) = self.bodies.iter().find(odd) else { return Ok(()) };
        let (mut dynamics, mut forward) = (Dynamics::new(model), ForwardDynamics::new(model));
        let (none, mut vdot) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        let rho = vec![0.0; model.linear_axes().len() * model.nc()];
        for pose in 0..20 {
            let mut q = model.neutral();
            for (k, dof) in model.dofs.iter().enumerate().filter(|(_, dof)| model.bodies[dof.body].joint.nv() == 1) {
                // Evenly over the range, each coordinate in its own order.
                let share = (f64::from(pose) * libm::sqrt((2 * k + 3) as f64)).fract();
                let [lower, upper] = dof.usual_range().unwrap_or([-1.0, 1.0]);
                if pose > 0 {
                    q[model.bodies[dof.body].q_index] = lower + share * (upper - lower);
                }
            }
            dynamics.update(model, q.as_slice(), &none);
            if !forward.solve(model, &dynamics, &none, &rho, &mut vdot) {
                let names = words::list(self.bodies.iter().filter(odd).map(|body| &body.name));
                let problem = format!(
                    "with inertias that no body has (of {names}) the mass matrix is not positive definite, so that accelerations have \
                     no meaning; correct them, or set inertias = \"repaired\""
                );
                return Err(self.invalid(first.line, format!("body {:?}", first.name), problem));
            }
        }
        Ok(())
    }
}

impl Model {
    /// The diagonal of the mass matrix at the zero position, with the dynamics of that position.
    fn own_inertias(&self) -> (Dynamics, Vec<f64>) {
        let mut dynamics = Dynamics::without_mass_matrix(self);
        dynamics.poses(self, self.neutral().as_slice());
        dynamics.inertias(self);
        let of = |s: &Motion, body: usize| s.dot(&dynamics.composite[body].momentum(s));
        let dofs = self.dofs.iter().zip(&dynamics.subspace);
        let mut inertias: Vec<f64> = dofs.map(|(dof, s)| of(s, dof.body) + dof.armature).collect();
        for (follower, s) in dynamics.tree.followers(&dynamics.subspace) {
            inertias[follower.coordinate] += follower.ratio * follower.ratio * of(s, follower.body);
        }
        (dynamics, inertias)
    }

    /// The velocity coordinates, but those of the base, that move nothing.
    pub(crate) fn coordinates_without_inertia(&self) -> Vec<usize> {
        let (_, inertias) = self.own_inertias();
        (0..self.nv()).filter(|&dof| inertias[dof] == 0.0 && self.dofs[dof].body > self.root()).collect()
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

/// In which way no body has an inertia.
#[derive(Clone, Copy)]
enum Violation {
    /// A principal moment is negative: the largest moment, and the least.
    Negative { largest: f64, least: f64 },
    /// A principal moment is larger than the sum of the other two: that moment, and the sum.
    Triangle { largest: f64, others: f64 },
}

impl Violation {
    /// Whether it is more than the last digits of a file leave.
    fn is_more_than_rounding(self) -> bool {
        match self {
            Self::Negative { .. } => true,
            Self::Triangle { largest, others } => largest - others > 1e-9 * (largest + others),
        }
    }
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Negative { largest, least } => write!(
                f,
                "no body has this inertia: a principal moment is {least:.3e} kg m², beside one of {largest:.3e}"
            ),
            Self::Triangle { largest, others } => write!(
                f,
                "no body has this inertia: a principal moment of {largest:.3e} kg m² is larger than the sum of the other two, {others:.3e}"
            ),
        }
    }
}

/// The way in which no body has `inertia` [kg m²], if there is one.
fn violation(inertia: &Matrix3<f64>) -> Option<Violation> {
    if *inertia == Matrix3::zeros() {
        return None;
    }
    let moments = inertia.symmetric_eigenvalues();
    let (largest, least) = (moments.max(), moments.min());
    let others = moments.sum() - largest;
    // The eigenvalues' own rounding
    if least < -1e-14 * largest.abs().max(-least) {
        Some(Violation::Negative { largest, least })
    } else if largest - others > 1e-14 * largest {
        Some(Violation::Triangle { largest, others })
    } else {
        None
    }
}

/// The inertia that a body can have which is nearest to `inertia`: the second moments of mass Σ = ½ tr(I) 1 − I have no negative
/// eigenvalue (Wensing, Kim, Slotine 2018), and I = tr(Σ) 1 − Σ.
fn nearest(inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let mut eigen = (Matrix3::identity() * (0.5 * inertia.trace()) - inertia).symmetric_eigen();
    eigen.eigenvalues.iter_mut().for_each(|moment| *moment = moment.max(0.0));
    let moments = eigen.recompose();
    let repaired = Matrix3::identity() * moments.trace() - moments;
    (repaired + repaired.transpose()) * 0.5
}
