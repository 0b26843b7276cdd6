//! The tree of the columns of the motion subspace, and joints that follow others.
//!
//! There is a column for each velocity coordinate, and behind those one for each joint that follows another one. What such a
//! column contributes is folded into that of the coordinate it follows, times the ratio: with v_tree = G v and a constant G the equation of
//! motion is that of the tree times Gᵀ, hence `M = Gᵀ M_tree G`.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::dynamics::Dynamics;
use crate::model::{Body, Model};
use crate::spatial::{Force, Motion};

/// The end of a chain of columns.
pub(crate) const NONE: usize = usize::MAX;

/// What carries what.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// For each column the next one toward the base.
    pub(crate) parent: Vec<usize>,
    /// For each body the outermost column that moves it.
    pub(crate) last: Vec<usize>,
    /// For each body the first column of its joint.
    pub(crate) first: Vec<usize>,
    /// The joints of the columns behind those of the velocity coordinates.
    pub(crate) followers: Vec<Follower>,
    /// For each body that such a joint carries the coordinates that move it; nothing for all others, and none where nothing is coupled.
    folded: Vec<Vec<Folded>>,
    /// For each coordinate the next one toward the base that it shares a body with, where joints follow others: the elimination tree
    /// of the mass matrix.
    elimination: Vec<usize>,
}

/// A velocity coordinate with the columns that it stands for, and their ratios.
type Folded = (usize, Vec<(usize, f64)>);

/// A joint that follows another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Follower {
    /// The body that the joint carries.
    pub(crate) body: usize,
    /// The velocity coordinate that it follows.
    pub(crate) coordinate: usize,
    /// Its speed for unit speed of that.
    pub(crate) ratio: f64,
}

impl Tree {
    /// Featherstone 2008, Section 6.6, with several columns to a joint.
    pub(crate) fn of(model: &Model) -> Self {
        let (nv, nb) = (model.nv(), model.bodies.len());
        let follower = |(body, joint): (usize, &Body)| {
            joint.follows.map(|follows| Follower { body, coordinate: joint.v_index, ratio: follows.ratio })
        };
        let followers: Vec<Follower> = model.bodies.iter().enumerate().filter_map(follower).collect();
        let mut tree = Self {
            parent: vec![NONE; nv + followers.len()],
            last: vec![NONE; nb],
            first: vec![0; nb],
            followers,
            folded: Vec::new(),
            elimination: Vec::new(),
        };
        let mut next = nv;
        for (i, body) in model.bodies.iter().enumerate() {
            tree.first[i] = if body.follows.is_some() { next } else { body.v_index };
            let mut last = body.parent.map_or(NONE, |parent| tree.last[parent]);
            for j in tree.first[i]..tree.first[i] + body.joint.nv() {
                tree.parent[j] = last;
                last = j;
            }
            tree.last[i] = last;
            next += usize::from(body.follows.is_some());
        }
        if tree.is_coupled() {
            tree.fold(nv);
        }
        tree
    }

    /// Whether any joint follows another one.
    pub(crate) fn is_coupled(&self) -> bool {
        !self.followers.is_empty()
    }

    fn fold(&mut self, nv: usize) {
        self.folded = vec![Vec::new(); self.last.len()];
        let mut shares = vec![BTreeSet::new(); nv];
        for body in 0..self.last.len() {
            let mut folded: Vec<Folded> = Vec::new();
            for j in self.chain_of_columns(body) {
                let (coordinate, ratio) = self.coordinate(j);
                match folded.iter_mut().find(|(other, _)| *other == coordinate) {
                    Some((_, terms)) => terms.push((j, ratio)),
                    None => folded.push((coordinate, vec![(j, ratio)])),
                }
            }
            folded.sort_by_key(|(coordinate, _)| *coordinate);
            for (outer, (k, _)) in folded.iter().enumerate() {
                shares[*k].extend(folded[..outer].iter().map(|(j, _)| *j));
            }
            if self.chain_of_columns(body).any(|j| j >= nv) {
                self.folded[body] = folded;
            }
        }
        self.elimination = vec![NONE; nv];
        for k in (0..nv).rev() {
            let carriers = std::mem::take(&mut shares[k]);
            if let Some(&parent) = carriers.last() {
                self.elimination[k] = parent;
                shares[parent].extend(carriers.into_iter().filter(|&j| j != parent));
            }
        }
    }

    /// The velocity coordinate of column `j` and the column's ratio.
    pub(crate) fn coordinate(&self, j: usize) -> (usize, f64) {
        let nv = self.parent.len() - self.followers.len();
        j.checked_sub(nv).map_or((j, 1.0), |k| (self.followers[k].coordinate, self.followers[k].ratio))
    }

    /// The columns that move `body`, from the body toward the base.
    fn chain_of_columns(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        upward(self.last[body], &self.parent)
    }

    /// Calls `with` for each velocity coordinate that moves `body`, with its motion at unit speed out of `subspace`.
    #[inline]
    pub(crate) fn columns(&self, subspace: &[Motion], body: usize, mut with: impl FnMut(usize, &Motion)) {
        match self.folded.get(body) {
            Some(folded) if !folded.is_empty() => {
                for (coordinate, terms) in folded {
                    with(*coordinate, &sum(subspace, terms));
                }
            }
            _ => {
                let mut j = self.last[body];
                while j != NONE {
                    with(j, &subspace[j]);
                    j = self.parent[j];
                }
            }
        }
    }

    /// The joints that follow others, each with its own of the `columns`.
    pub(crate) fn followers<'a, T>(&'a self, columns: &'a [T]) -> impl Iterator<Item = (&'a Follower, &'a T)> {
        self.followers.iter().zip(&columns[columns.len() - self.followers.len()..])
    }
}

/// From `first` on, each time the `next` one, to the end.
fn upward(first: usize, next: &[usize]) -> impl Iterator<Item = usize> + '_ {
    let known = |j: usize| (j != NONE).then_some(j);
    std::iter::successors(known(first), move |&j| known(next[j]))
}

/// The motion of columns together, each times its ratio.
fn sum(subspace: &[Motion], terms: &[(usize, f64)]) -> Motion {
    let mut motion = Motion::zero();
    terms.iter().for_each(|&(j, ratio)| motion.add_scaled(&subspace[j], ratio));
    motion
}

impl Dynamics {
    /// The velocity coordinates that move `body`, from the base outward. Where joints follow others there may be some between them that do
    /// not, so that the mass matrix has a factor that is nonzero only along such chains.
    #[must_use]
    pub fn chain(&self, body: usize) -> Vec<usize> {
        let mut chain: Vec<usize> = if self.tree.is_coupled() {
            let outermost = self.tree.chain_of_columns(body).map(|j| self.tree.coordinate(j).0).max();
            upward(outermost.unwrap_or(NONE), &self.tree.elimination).collect()
        } else {
            self.tree.chain_of_columns(body).collect()
        };
        chain.reverse();
        chain
    }

    /// The velocity coordinates that carry `j` by [`Dynamics::chain`], from the base outward, and `j` itself.
    #[must_use]
    pub fn chain_to(&self, model: &Model, j: usize) -> Vec<usize> {
        if self.tree.is_coupled() {
            let mut chain: Vec<_> = upward(j, &self.tree.elimination).collect();
            chain.reverse();
            return chain;
        }
        let mut chain = self.chain(model.dofs[j].body);
        // A joint of several coordinates: they carry one another.
        chain.retain(|&other| other <= j);
        chain
    }

    /// How a point moves that is fixed to `body` and now at `world_point` [m], at unit speed of the velocity coordinate `j` of its
    /// chain: angular, and linear at the point. Of the latest position.
    #[inline]
    #[must_use]
    pub fn unit_motion(&self, body: usize, j: usize, world_point: &Vector3<f64>) -> Motion {
        let at = world_point - self.reference;
        let s = match self.tree.folded.get(body) {
            Some(folded) if !folded.is_empty() => {
                let terms = folded.iter().find(|(coordinate, _)| *coordinate == j);
                terms.map_or(Motion::zero(), |(_, terms)| sum(&self.subspace, terms))
            }
            _ => self.subspace[j],
        };
        Motion { angular: s.angular, linear: s.linear_at(&at) }
    }

    /// The mass matrix where joints follow others: each pair of columns that share bodies, at the place of their coordinates.
    pub(crate) fn coupled_mass_matrix(&mut self, model: &Model) {
        self.mass_matrix.fill(0.0);
        for j in 0..self.subspace.len() {
            let body = model.dofs.get(j).map_or_else(|| self.tree.followers[j - model.nv()].body, |dof| dof.body);
            let momentum: Force = self.composite[body].momentum(&self.subspace[j]);
            self.subspace_momentum[j] = momentum;
            if self.mass_matrix.is_empty() {
                continue;
            }
            let (column, ratio) = self.tree.coordinate(j);
            self.mass_matrix[(column, column)] += model.dofs.get(j).map_or(0.0, |dof| dof.armature);
            let mut i = j;
            while i != NONE {
                let (row, other) = self.tree.coordinate(i);
                let value = ratio * other * self.subspace[i].dot(&momentum);
                self.mass_matrix[(row, column)] += value;
                if i != j {
                    self.mass_matrix[(column, row)] += value;
                }
                i = self.tree.parent[i];
            }
        }
    }
}
