//! What the log says of the feet on the ground: how far they slid, and how the ground differs from what the controller believes.

use std::ops::Range;

use super::evidence::{Evidence, below};
use crate::log::Field;

/// A foot carries load from this share of the robot's weight on; less than that drags without effect.
const LOADED: f64 = 0.1;

impl Evidence<'_> {
    /// How far a standing foot slid under load in `ticks` [m], where the ground holds less than the controller believes;
    /// one that swings drags at most.
    pub(super) fn slide(&self, ticks: Range<usize>, foot: usize) -> f64 {
        let loaded = |i: usize| {
            let stands = self.log.get(i, Field::Swing)[0] != foot as f64;
            let load: f64 = self.model.points_of(foot).map(|point| self.load(i, point)).sum();
            let [friction, believed] = self.friction_below(i, foot);
            stands && load > LOADED * self.weight() && believed > friction
        };
        let ticks = ticks.start..ticks.end.min(self.log.len().saturating_sub(1));
        let cos = libm::cos(self.ground.base().slope);
        let moved = |i: usize| {
            let point = self.bearing(i, foot);
            let (before, after) = (self.point(i, point), self.point(i + 1, point));
            match self.axes {
                2 => (after[0] - before[0]).abs() / cos,
                _ => libm::sqrt(after.iter().zip(before).map(|(after, before)| (after - before).powi(2)).sum()),
            }
        };
        ticks.filter(|&i| loaded(i)).map(moved).sum()
    }

    /// A contact point [m].
    fn point(&self, i: usize, point: usize) -> &[f64] {
        &self.log.get(i, Field::Feet)[point * self.axes..][..self.axes]
    }

    /// What a contact point carries [N].
    fn load(&self, i: usize, point: usize) -> f64 {
        self.log.get(i, Field::GrfSimulated)[point * self.axes + self.axes - 1]
    }

    /// The contact point of a foot that carries most: where a foot rolls, the others move without sliding.
    fn bearing(&self, i: usize, foot: usize) -> usize {
        let most = self.model.points_of(foot).max_by(|&a, &b| self.load(i, a).total_cmp(&self.load(i, b)));
        most.expect("a foot has a contact point")
    }

    /// The friction below a foot in tick `i`, and the one that the controller counts on there.
    pub(super) fn friction_below(&self, i: usize, foot: usize) -> [f64; 2] {
        let [x, y] = below(self.point(i, self.bearing(i, foot)));
        [&self.ground, &self.believed].map(|ground| ground.friction_at(x, y))
    }

    /// How much lower the ground below a foot is in tick `i` than the controller believes [m].
    pub(super) fn lower(&self, i: usize, foot: usize) -> f64 {
        let [x, y] = self.foot_at(i, foot);
        self.believed.height_at(x, y) - self.ground.height_at(x, y)
    }

    /// How much lower the ground below a foot is in tick `i` than the slope has it that the controller believes in, from the other
    /// foot on [m]: where it does not know the ground, it knows where its feet stand.
    pub(super) fn lower_than_the_other(&self, i: usize, foot: usize) -> f64 {
        self.relief(i, 1 - foot) - self.relief(i, foot)
    }

    /// How far the ground stands above the sole of a foot in tick `i`, between two of its contact points [m]; 0 where it nowhere does.
    pub(super) fn above_the_sole(&self, i: usize, foot: usize) -> f64 {
        let points: Vec<&[f64]> = self.model.points_of(foot).map(|point| self.point(i, point)).collect();
        let above = |back: &[f64], front: &[f64]| -> f64 {
            let knots = self.ground.knots([back[0], front[0]]).into_iter();
            let at = |x: f64| {
                let share = (x - back[0]) / (front[0] - back[0]);
                let between = |axis: usize| back[axis] + share * (front[axis] - back[axis]);
                let y = if self.axes == 3 { between(1) } else { 0.0 };
                self.ground.height_at(x, y) - between(self.axes - 1)
            };
            knots.map(at).fold(0.0, f64::max)
        };
        let pairs = points.iter().flat_map(|back| points.iter().map(move |front| (back, front)));
        pairs.filter(|(back, front)| back[0] < front[0]).map(|(back, front)| above(back, front)).fold(0.0, f64::max)
    }

    /// The foot that a part of the body belongs to: its joint or its link.
    pub(super) fn foot_of(&self, part: &str) -> Option<usize> {
        let of = |point: usize| &self.model.bodies[self.model.contacts[point].body];
        (0..2).find(|&foot| self.model.points_of(foot).map(of).any(|body| body.name == part || body.joint_name == part))
    }

    /// How high the ground is below the lowest point of a foot in tick `i`, over the slope that the controller believes in [m].
    pub(super) fn relief(&self, i: usize, foot: usize) -> f64 {
        let lowest = |a: &usize, b: &usize| {
            let [a, b] = [*a, *b].map(|point| self.point(i, point)[self.axes - 1]);
            a.total_cmp(&b)
        };
        let point = self.model.points_of(foot).min_by(lowest).expect("a foot has a contact point");
        let [x, y] = below(self.point(i, point));
        self.ground.height_at(x, y) - self.believed.base().height_at(x, y)
    }
}
