//! The ground: an inclined plane, what rises from it, and where it holds better or worse.
//!
//! The plane may incline along x and along y. What rises from it and where it holds otherwise depend on x alone; heights are
//! linear between knots, so that a point touches one straight piece. Controller and simulator each have their own ground: what
//! the controller is not told it does not know.

use std::collections::BTreeSet;

use legwork_rbd::Model;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::contact::Surface;

/// Feet shorter than this meet the ground as a point does [m].
const NARROW: f64 = 1e-3;

/// A straight piece of the ground through the world's point `(x, z)` [m].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// A place on it.
    pub x: f64,
    /// Its height there.
    pub z: f64,
    /// How it rises with x.
    pub steepness: f64,
}

impl Line {
    /// Height at `x` [m].
    #[inline]
    pub fn at(&self, x: f64) -> f64 {
        self.z + self.steepness * (x - self.x)
    }

    /// The line through two points that are apart in x.
    pub fn through([x, z]: [f64; 2], [other_x, other_z]: [f64; 2]) -> Self {
        Self { x, z, steepness: (other_z - z) / (other_x - x) }
    }

    /// The line with the least squares of the heights that it misses `points` by, which are not all at one x.
    pub fn fitted(points: &[[f64; 2]]) -> Self {
        let share = 1.0 / points.len() as f64;
        let [x, z] = points.iter().fold([0.0; 2], |[x, z], point| [x + share * point[0], z + share * point[1]]);
        let (mut across, mut along) = (0.0, 0.0);
        for point in points {
            across += (point[0] - x) * (point[1] - z);
            along += (point[0] - x) * (point[0] - x);
        }
        Self { x, z, steepness: across / along }
    }
}

/// A piece of the ground through the world's point `(x, y, z)` [m], flat along x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane {
    /// A place on it.
    pub place: [f64; 2],
    /// Its height there.
    pub z: f64,
    /// How it rises with x and with y.
    pub steepness: [f64; 2],
}

impl Plane {
    /// Height at a place [m].
    #[inline]
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.z + self.steepness[0] * (x - self.place[0]) + self.steepness[1] * (y - self.place[1])
    }
}

/// A straight piece of the ground between two places along x; straight along y too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where it begins and ends along x [m].
    pub ends: [f64; 2],
    /// Its height along x, at y = 0.
    pub line: Line,
    /// Unit normal, out of the ground.
    pub normal: Vector3<f64>,
}

impl Piece {
    /// Distance of `point` from it or from its continuation, along its normal [m]; negative inside.
    #[inline]
    pub fn gap(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(&Vector3::new(point.x - self.line.x, point.y, point.z - self.line.z))
    }
}

/// Ground: an inclined plane through the origin with Coulomb friction, and what differs from it; see
/// [`Terrain`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Coefficient of friction.
    pub friction: f64,
    /// Slope, upward in x [deg].
    pub slope_deg: f64,
    /// Slope, upward in y [deg]; for robots in space alone.
    pub cross_slope_deg: f64,
    /// Whether the controller is given the true friction and slopes.
    pub known: bool,
    /// Rows `[x_m, z_m]` of heights above the plane, joined by straight lines, level before and after.
    pub profile: Vec<[f64; 2]>,
    /// Random heights on top of it: as much up and down [m].
    pub unevenness_m: f64,
    /// Distance of the points that have them, which straight lines join [m].
    pub unevenness_spacing_m: f64,
    /// Where they begin [m].
    pub unevenness_from_m: f64,
    /// Rows `[from_m, to_m, friction]` where the friction is another; of several the last counts.
    pub patches: Vec<[f64; 3]>,
    /// Whether the controller is given profile, unevenness and patches.
    pub relief_known: bool,
}

impl Ground {
    /// Its slopes upward in x and in y [rad].
    pub fn slopes(&self) -> [f64; 2] {
        [self.slope_deg.to_radians(), self.cross_slope_deg.to_radians()]
    }

    /// Whether the controller knows the ground's height everywhere.
    pub fn height_is_known(&self) -> bool {
        self.known && (self.relief_known || (self.profile.is_empty() && self.unevenness_m == 0.0))
    }
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            friction: 0.85,
            slope_deg: 0.0,
            cross_slope_deg: 0.0,
            known: true,
            profile: Vec::new(),
            unevenness_m: 0.0,
            unevenness_spacing_m: 0.3,
            unevenness_from_m: 0.7,
            patches: Vec::new(),
            relief_known: false,
        }
    }
}

/// The ground below a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    plane: Surface,
    relief: Relief,
    /// Where the friction becomes another, by place; none for the plane's.
    patches: Vec<(f64, Option<f64>)>,
}

/// Heights above the plane [m].
#[derive(Clone, Debug, Default, PartialEq)]
struct Relief {
    /// `[x, z]`, by x; level before and after.
    profile: Vec<[f64; 2]>,
    /// Largest random height, the distance of its knots, and where it begins [m].
    unevenness: f64,
    spacing: f64,
    from: f64,
    seed: u64,
}

impl Terrain {
    /// A plane through the world's origin as `model` meets it; `slopes` upward in x and in y [rad].
    pub fn plane(model: &Model, friction: f64, slopes: [f64; 2]) -> Self {
        Self { plane: Surface::new(model, friction, slopes), relief: Relief::default(), patches: Vec::new() }
    }

    /// The true ground, as `model` meets it; `seed` is that of its unevenness.
    pub fn of(ground: &Ground, seed: u64, model: &Model) -> Self {
        Self {
            relief: Relief {
                profile: ground.profile.clone(),
                unevenness: ground.unevenness_m,
                spacing: ground.unevenness_spacing_m,
                from: ground.unevenness_from_m,
                seed,
            },
            patches: side_by_side(&ground.patches),
            ..Self::plane(model, ground.friction, ground.slopes())
        }
    }

    /// What the controller is told of it; for the rest it has what it assumes: a friction, and a slope upward in x
    /// [deg], with none across.
    pub fn believed(ground: &Ground, seed: u64, assumed: [f64; 2], model: &Model) -> Self {
        let (friction, slopes) = if ground.known {
            (ground.friction, ground.slopes())
        } else {
            (assumed[0], [assumed[1].to_radians(), 0.0])
        };
        let plane = Self::plane(model, friction, slopes);
        if !ground.relief_known {
            return plane;
        }
        Self { plane: plane.plane, ..Self::of(ground, seed, model) }
    }

    /// Its plane.
    #[inline]
    pub fn base(&self) -> &Surface {
        &self.plane
    }

    /// Whether it is its plane everywhere.
    #[inline]
    pub fn is_plane(&self) -> bool {
        self.is_even() && self.patches.is_empty()
    }

    /// Whether nothing rises from its plane.
    #[inline]
    pub fn is_even(&self) -> bool {
        self.relief.profile.is_empty() && self.relief.unevenness == 0.0
    }

    /// Height at `(x, y)` [m].
    #[inline]
    pub fn height_at(&self, x: f64, y: f64) -> f64 {
        let plane = self.plane.height_at(x, y);
        if self.is_even() { plane } else { plane + self.relief.at(x)[0] }
    }

    /// Unit normal, out of the ground, at `(x, y)` [m]; it is the same along y.
    pub fn normal_at(&self, x: f64, _y: f64) -> Vector3<f64> {
        self.piece_at(x).normal
    }

    /// Coefficient of friction at `(x, y)` [m]; it is the same along y.
    pub fn friction_at(&self, x: f64, _y: f64) -> f64 {
        let begun = self.patches.partition_point(|patch| patch.0 <= x);
        self.patches[..begun].last().and_then(|patch| patch.1).unwrap_or(self.plane.friction)
    }

    /// What contact points at `points` [m] meet. Those of one foot (`foot_of` has it for each) share a slope upward in x, that
    /// of the line through the ground below the foot's ends along x: a rigid foot that stands on both could not move along two normals.
    pub fn below(&self, points: &[Vector3<f64>], foot_of: impl Fn(usize) -> usize, surfaces: &mut [Surface]) {
        for (index, surface) in surfaces.iter_mut().enumerate() {
            surface.friction = self.friction_at(points[index].x, points[index].y);
            if self.is_even() {
                continue;
            }
            let places =
                (0..points.len()).filter(|&other| foot_of(other) == foot_of(index)).map(|other| points[other].x);
            let ends = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
            *surface = surface.inclined(libm::atan(self.steepness_between(ends)));
        }
    }

    /// How the ground rises with x between two places along x [m].
    fn steepness_between(&self, [from, to]: [f64; 2]) -> f64 {
        if to - from < NARROW {
            return self.plane.steepness()[0] + self.relief.at(from)[1];
        }
        (self.height_at(to, 0.0) - self.height_at(from, 0.0)) / (to - from)
    }

    /// Distance of `point` from the straight piece of ground below it, along the normal of that piece [m]; negative inside.
    #[inline]
    pub fn gap(&self, point: &Vector3<f64>) -> f64 {
        if self.is_even() { self.plane.normal.dot(point) } else { self.piece_at(point.x).gap(point) }
    }

    /// The straight piece of ground below or above `x` [m].
    fn piece_at(&self, x: f64) -> Piece {
        if self.is_even() {
            let line = Line { steepness: self.plane.steepness()[0], ..Line::default() };
            return Piece { ends: [f64::NEG_INFINITY, f64::INFINITY], line, normal: self.plane.normal };
        }
        let stretch = self.relief.stretch(x);
        let [along, across] = self.plane.steepness();
        let slope = [along + stretch.steepness, across];
        let line = Line { x, z: self.height_at(x, 0.0), steepness: slope[0] };
        let length = libm::sqrt(1.0 + slope[0] * slope[0] + slope[1] * slope[1]);
        Piece { ends: stretch.ends, line, normal: Vector3::new(-slope[0], -slope[1], 1.0) / length }
    }

    /// The pieces of ground that `point` may meet [m]: the one below it, and where the ground rises from that to a neighbour
    /// that has the point beside it, the nearer such neighbour.
    pub fn pieces_near(&self, point: &Vector3<f64>) -> [Option<Piece>; 2] {
        let below = self.piece_at(point.x);
        let beside = |end: usize| {
            let other = self.beside(&below, end)?;
            // In a hollow both pieces bound the point; beyond the far end of its neighbour it passes over that.
            let bend = other.line.steepness - below.line.steepness;
            let hollow = if end == 0 { bend < 0.0 } else { bend > 0.0 };
            let foot = point.x - other.gap(point) * other.normal.x;
            let reached = if end == 0 { foot >= other.ends[0] } else { foot <= other.ends[1] };
            (hollow && reached).then_some(other)
        };
        let nearer = |a: &Piece, b: &Piece| a.gap(point).total_cmp(&b.gap(point));
        [Some(below), [beside(0), beside(1)].into_iter().flatten().min_by(nearer)]
    }

    /// When a point that is at `point` [m] and moves with `velocity` [m/s] first goes through a piece of ground that is not
    /// among `known`, within `time` [s] and faster than `slow` across it [m/s]. Zero where it is inside already.
    pub fn landing(
        &self,
        point: &Vector3<f64>,
        velocity: &Vector3<f64>,
        time: f64,
        slow: f64,
        known: impl Fn(&Piece) -> bool,
    ) -> Option<f64> {
        let meets = |piece: &Piece| {
            let speed = -piece.normal.dot(velocity);
            if speed <= slow {
                return None;
            }
            let at = piece.gap(point).max(0.0) / speed;
            (at < time && !known(piece)).then_some(at)
        };
        // From piece to piece along the way.
        let mut piece = self.piece_at(point.x);
        loop {
            let end = usize::from(velocity.x > 0.0);
            let leaves = if velocity.x == 0.0 { f64::INFINITY } else { (piece.ends[end] - point.x) / velocity.x };
            if let Some(at) = meets(&piece).filter(|&at| at <= leaves) {
                return Some(at);
            }
            piece = (leaves < time).then(|| self.beside(&piece, end)).flatten()?;
        }
    }

    /// The piece that begins or ends where `piece` has its `end`: 0 for the one before it, 1 for the one after it.
    fn beside(&self, piece: &Piece, end: usize) -> Option<Piece> {
        let knot = piece.ends[end];
        knot.is_finite().then(|| self.piece_at(if end == 0 { knot.next_down() } else { knot }))
    }

    /// What a contact point at `point` [m] meets on `piece`.
    pub fn surface(&self, piece: &Piece, point: &Vector3<f64>) -> Surface {
        let mut surface = self.plane;
        if !self.is_even() {
            surface = surface.inclined(libm::atan(piece.line.steepness));
        }
        surface.friction = self.friction_at(point.x, point.y);
        surface
    }

    /// The plane through the ground at `(x, y)` [m], inclined as the ground's plane is.
    pub fn plane_at(&self, x: f64, y: f64) -> Plane {
        Plane { place: [x, y], z: self.height_at(x, y), steepness: self.plane.steepness() }
    }

    /// What a sole along x lies on whose ends are `back` and `front` of `(x, y)` along it [m]: the line through the ground below
    /// both.
    pub fn below_a_sole(&self, x: f64, y: f64, [back, front]: [f64; 2]) -> Line {
        if self.is_even() || front <= back {
            return Line { x, z: self.height_at(x, y), steepness: self.steepness_between([x, x]) };
        }
        let mut line = Line { x, z: self.height_at(x, y), steepness: self.plane.steepness()[0] };
        // The ends come closer as the sole is inclined.
        for _ in 0..3 {
            let across = 1.0 / libm::sqrt(1.0 + line.steepness * line.steepness);
            let end = |way: f64| [x + way * across, self.height_at(x + way * across, y)];
            line = Line::through(end(back), end(front));
        }
        Line { x, z: line.at(x), ..line }
    }

    /// Where its pieces begin and end between two places [m], the places themselves included.
    pub fn knots(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let mut knots = vec![from, to];
        if !self.is_even() {
            knots.extend(self.relief.profile.iter().map(|knot| knot[0]));
            if self.relief.unevenness > 0.0 {
                let spacing = self.relief.spacing;
                let index = |x: f64| ((x - self.relief.from) / spacing).floor().max(0.0) as i64;
                knots.extend((index(from)..=index(to)).map(|index| self.relief.from + index as f64 * spacing));
            }
        }
        knots.retain(|knot| (from..=to).contains(knot));
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        knots
    }
}

/// Where the friction becomes another, of rows `[from, to, friction]` of which the last counts.
fn side_by_side(patches: &[[f64; 3]]) -> Vec<(f64, Option<f64>)> {
    let ends = |(row, &[from, to, _]): (usize, &[f64; 3])| [(from, row, true), (to, row, false)];
    let mut ends: Vec<_> = patches.iter().enumerate().flat_map(ends).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut covering = BTreeSet::new();
    let mut changes: Vec<(f64, Option<f64>)> = Vec::with_capacity(ends.len());
    for (place, row, begins) in ends {
        if begins {
            covering.insert(row);
        } else {
            covering.remove(&row);
        }
        if changes.last().is_some_and(|change| change.0 == place) {
            changes.pop();
        }
        changes.push((place, covering.last().map(|&row| patches[row][2])));
    }
    changes
}

/// Heights above the plane between two places along x.
struct Stretch {
    ends: [f64; 2],
    /// At the place that was asked for [m].
    height: f64,
    steepness: f64,
}

impl Stretch {
    /// Adds heights that are linear between two points.
    fn add(&mut self, x: f64, [from, low]: [f64; 2], [to, high]: [f64; 2]) {
        let steepness = (high - low) / (to - from);
        self.height += low + steepness * (x - from);
        self.steepness += steepness;
        self.ends = [self.ends[0].max(from), self.ends[1].min(to)];
    }
}

impl Relief {
    /// Height and steepness at `x`.
    fn at(&self, x: f64) -> [f64; 2] {
        let Stretch { height, steepness, .. } = self.stretch(x);
        [height, steepness]
    }

    /// The straight piece at `x`: that after a knot, at the knot.
    fn stretch(&self, x: f64) -> Stretch {
        let mut stretch = Stretch { ends: [f64::NEG_INFINITY, f64::INFINITY], height: 0.0, steepness: 0.0 };
        if let (Some(first), Some(last)) = (self.profile.first(), self.profile.last()) {
            match self.profile.partition_point(|knot| knot[0] <= x) {
                0 => (stretch.height, stretch.ends[1]) = (first[1], first[0]),
                after if after == self.profile.len() => (stretch.height, stretch.ends[0]) = (last[1], last[0]),
                after => stretch.add(x, self.profile[after - 1], self.profile[after]),
            }
        }
        if self.unevenness > 0.0 {
            if x < self.from {
                stretch.ends[1] = stretch.ends[1].min(self.from);
            } else {
                let index = ((x - self.from) / self.spacing).floor();
                let place = |index: f64| self.from + index * self.spacing;
                // Rounding may put a knot on either side of itself.
                let index = if x < place(index) {
                    index - 1.0
                } else if x >= place(index + 1.0) {
                    index + 1.0
                } else {
                    index
                };
                let knot = |index: f64| [place(index), self.random(index)];
                stretch.add(x, knot(index), knot(index + 1.0));
            }
        }
        stretch
    }

    /// Height of a knot, none of the first: evenly distributed, a pure function of seed and index.
    fn random(&self, index: f64) -> f64 {
        if index == 0.0 {
            return 0.0;
        }
        let bits = xxhash_rust::xxh3::xxh3_64_with_seed(&(index as i64).to_le_bytes(), self.seed);
        // The upper 53 bits are a share of 1.
        self.unevenness * (2.0 * ((bits >> 11) as f64 / (1u64 << 53) as f64) - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Model {
        Model::from_toml(include_str!("../../../models/planar_humanoid_feet.toml"), "feet").expect("a sound model")
    }

    #[test]
    fn a_fitted_line_goes_through_points_on_a_line_and_between_others() {
        let line = Line { x: 1.0, z: 0.2, steepness: -0.3 };
        let on_it = [-0.7, 0.4, 2.0, 2.1].map(|x| [x, line.at(x)]);
        let found = Line::fitted(&on_it);
        assert!((found.steepness - line.steepness).abs() < 1e-15 && (found.at(5.0) - line.at(5.0)).abs() < 1e-14);
        // Lines beside the fitted one miss by more.
        let points = [[0.0, 0.01], [0.5, -0.02], [1.1, 0.04], [1.4, 0.0]];
        let best = Line::fitted(&points);
        let missed = |line: &Line| points.iter().map(|[x, z]| (z - line.at(*x)).powi(2)).sum::<f64>();
        for (dz, turn) in [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3), (1e-3, -1e-3)] {
            let beside = Line { z: best.z + dz, steepness: best.steepness + turn, ..best };
            assert!(missed(&beside) > missed(&best));
        }
    }

    fn terrain(seed: u64, change: impl FnOnce(&mut Ground)) -> Terrain {
        let mut ground = Ground::default();
        change(&mut ground);
        Terrain::of(&ground, seed, &robot())
    }

    fn uneven(seed: u64) -> Terrain {
        terrain(seed, |ground| ground.unevenness_m = 0.02)
    }

    #[test]
    fn uneven_ground_has_no_jumps_keeps_its_bounds_and_begins_where_it_is_told_to() {
        let ground = uneven(3);
        let at = |k: i32| f64::from(k) * 1e-3;
        let heights: Vec<f64> = (-2000..20_000).map(|k| ground.height_at(at(k), 0.0)).collect();
        assert!(heights[..2700].iter().all(|&height| height == 0.0), "level up to 0.7 m");
        assert!(heights.iter().all(|height| height.abs() <= 0.02));
        // Knots 0.3 m apart differ by 0.04 m at most.
        assert!(heights.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 1e-3 * 0.04 / 0.3 + 1e-12));
        let mean = heights[2700..].iter().sum::<f64>() / heights[2700..].len() as f64;
        let spread = heights[2700..].iter().map(|height| height * height).sum::<f64>() / heights[2700..].len() as f64;
        // Even distribution at 64 knots: its variance is a third, between knots two thirds of that.
        assert!(mean.abs() < 0.005 && (0.5..1.5).contains(&(spread / (0.0004 * 2.0 / 9.0))), "{mean} {spread}");
        assert_ne!(uneven(4).height_at(2.0, 0.0), ground.height_at(2.0, 0.0));
        assert_eq!(uneven(3).height_at(2.0, 0.0), ground.height_at(2.0, 0.0));
    }

    #[test]
    fn a_profile_lies_on_the_slope() {
        let ground = terrain(0, |ground| {
            ground.slope_deg = 5.0;
            ground.profile = vec![[1.0, 0.1], [2.0, 0.3]];
        });
        let slope = 5f64.to_radians().tan();
        for (x, rise) in [(0.0, 0.1), (1.0, 0.1), (1.5, 0.2), (2.0, 0.3), (7.0, 0.3)] {
            assert!(
                (ground.height_at(x, 0.0) - slope * x - rise).abs() < 1e-14,
                "at {x}: {}",
                ground.height_at(x, 0.0)
            );
        }
        assert_eq!(ground.knots([0.5, 1.5]), [0.5, 1.0, 1.5]);
    }

    #[test]
    fn a_sole_lies_on_the_ground_below_its_ends() {
        let ground = uneven(1);
        for k in 0..100 {
            let x = 1.0 + 0.05 * f64::from(k);
            let line = ground.below_a_sole(x, 0.0, [-0.065, 0.185]);
            let across = 1.0 / (1.0 + line.steepness * line.steepness).sqrt();
            for end in [-0.065, 0.185] {
                let place = x + across * end;
                assert!((line.at(place) - ground.height_at(place, 0.0)).abs() < 1e-5, "{end} at {x}");
            }
        }
    }

    #[test]
    fn points_of_a_foot_share_a_slope_and_have_their_own_friction() {
        let ground = terrain(0, |ground| {
            ground.profile = vec![[0.0, 0.0], [1.0, 0.5]];
            ground.patches = vec![[0.0, 1.0, 0.3], [0.4, 0.6, 0.1]];
        });
        let points = [-0.1, 0.3, 0.5, 0.9].map(|x| Vector3::new(x, 0.0, 0.0));
        let mut surfaces = [*ground.base(); 4];
        ground.below(&points, |point| point / 2, &mut surfaces);
        assert_eq!(surfaces.map(|surface| surface.friction), [ground.base().friction, 0.3, 0.1, 0.3]);
        // From -0.1 m, still level, to 0.15 m of height at 0.3 m.
        for (surface, steepness) in surfaces.iter().zip([0.375, 0.375, 0.5, 0.5]) {
            assert!((libm::tan(surface.slope) - steepness).abs() < 1e-12, "{}", libm::tan(surface.slope));
        }
    }

    #[test]
    fn of_patches_that_overlap_the_last_counts() {
        let patches: Vec<[f64; 3]> = (0..60)
            .map(|k| (f64::from(k * 37 % 50) * 0.1, f64::from(1 + k * 13 % 9) * 0.1, 0.01 * f64::from(k)))
            .map(|(from, length, friction)| [from, from + length, friction])
            .collect();
        let ground = terrain(0, |ground| ground.patches = patches.clone());
        let ends = patches.iter().flat_map(|[from, to, _]| [*from, *to]);
        for x in ends.flat_map(|end| [end.next_down(), end, end.next_up()]).chain([-1.0, 9.0, f64::NAN]) {
            let last = patches.iter().rev().find(|[from, to, _]| (*from..*to).contains(&x));
            assert_eq!(ground.friction_at(x, 0.0), last.map_or(ground.base().friction, |patch| patch[2]), "at {x}");
        }
    }

    #[test]
    fn the_controller_is_told_what_it_is_meant_to_know() {
        let (model, mut ground) = (robot(), Ground::default());
        (ground.unevenness_m, ground.slope_deg) = (0.02, 4.0);
        ground.patches = vec![[1.0, 2.0, 0.1]];
        let believed = Terrain::believed(&ground, 0, [0.85, 0.0], &model);
        assert!(believed.is_plane() && believed.base().slope > 0.06 && !ground.height_is_known());
        ground.relief_known = true;
        assert_eq!(Terrain::believed(&ground, 0, [0.85, 0.0], &model), Terrain::of(&ground, 0, &model));
        ground.known = false;
        let believed = Terrain::believed(&ground, 0, [0.85, 0.0], &model);
        assert!(!believed.is_even() && believed.base().slope == 0.0 && believed.friction_at(1.5, 0.0) == 0.1);
    }
}
