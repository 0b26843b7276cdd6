//! What the walker makes of the ground: the line that the centre of mass follows, how a sole will lie, and what the toe
//! has to swing over.

use nalgebra::Vector3;

use super::Walker;
use super::feet::Flat;
use legwork_contract::terrain::Line;

/// A step as long as this tells how the ground is inclined [m].
const LONG_ENOUGH: f64 = 0.15;
/// The share of a step's incline in the line that the centre of mass follows over known ground.
const GRADE_SHARE: f64 = 0.1;
/// Unknown ground is taken to go on as under that many footsteps.
const FOOTSTEPS: usize = 4;
/// How far apart those from before the start are taken to be [m].
const PACE_M: f64 = 0.4;
/// A toe's way shorter than this goes straight up and down [m].
const CLOSE: f64 = 0.05;
/// Into so many parts a toe's way is divided to look for what is higher.
const LOOKS: u32 = 16;

/// Where the last footsteps met the ground, the latest first [m].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Trail([[f64; 2]; FOOTSTEPS]);

impl Trail {
    /// The robot has come along `line`.
    fn along(line: &Line, pace: f64) -> Self {
        Self(std::array::from_fn(|k| {
            let x = line.x - pace * k as f64;
            [x, line.at(x)]
        }))
    }

    /// A foot met the ground, if that was `far` from where one met it before.
    fn add(&mut self, point: [f64; 2], far: f64) {
        if (self.0[0][0] - point[0]).abs() > far {
            self.0.rotate_right(1);
            self.0[0] = point;
        }
    }

    fn steepness(&self) -> f64 {
        Line::fitted(&self.0).steepness
    }
}

impl Walker {
    /// Unknown ground is taken to go on as it is below the feet at the start.
    pub(super) fn look_around(&mut self) {
        if self.ground_known {
            return;
        }
        let [a, b] = self.placed;
        let steepness = 0.5 * (libm::tan(a.pitch) + libm::tan(b.pitch));
        self.grade = Line { x: 0.5 * (a.x + b.x), z: 0.5 * (a.z + b.z), steepness };
        self.trail = Trail::along(&self.grade, self.settings.in_length(PACE_M));
    }

    /// The centre of mass goes along a line through the foot `stance`, inclined as the ground ahead where it is known, else
    /// as it was below the last footsteps.
    pub(super) fn follow_the_ground(&mut self, stance: usize) {
        if self.ground_known && self.ground.is_even() {
            return;
        }
        let stance = &self.placed[stance];
        if !self.ground_known {
            let met = stance.point(stance.meets);
            self.trail.add([met.x, met.z], self.settings.in_length(LONG_ENOUGH));
            self.grade = Line { x: met.x, z: met.z, steepness: self.trail.steepness() };
            return;
        }
        let ahead = stance.x + self.choice.length;
        let mut steepness = self.grade.steepness;
        if (ahead - stance.x).abs() > self.settings.in_length(LONG_ENOUGH) {
            let seen = Line::through([stance.x, stance.z], [ahead, self.ground.height_at(ahead, 0.0)]).steepness;
            steepness += GRADE_SHARE * (seen - steepness);
        }
        self.grade = Line { x: stance.x, z: stance.z, steepness };
    }

    /// How the controller believes that a sole lies with its ankle above `x` [m].
    pub(super) fn below_a_sole(&self, x: f64) -> Flat {
        if !self.ground_known {
            return Flat::new(x, self.grade.at(x), libm::atan(self.grade.steepness));
        }
        let line = self.ground.below_a_sole(x, 0.0, [self.sole.heel, self.sole.toe]);
        Flat::new(x, line.z, if self.ground.is_even() { self.ground.base().slope } else { libm::atan(line.steepness) })
    }

    /// The line above which the toe swings, from where it left the ground to `landing`.
    pub(super) fn way_of_the_toe(&self, landing: Vector3<f64>) -> Line {
        let left = self.left;
        if self.ground_known && self.ground.is_even() {
            return self.grade;
        }
        if (landing.x - left.x).abs() < self.settings.in_length(CLOSE) {
            return Line { x: landing.x, z: landing.z.max(left.z), steepness: self.grade.steepness };
        }
        Line::through([landing.x, landing.z], [left.x, left.z])
    }

    /// How much the ground that the controller knows rises above the toe's way [m].
    pub(super) fn obstacle(&self, way: &Line) -> f64 {
        if self.ground.is_even() {
            return 0.0;
        }
        let (from, to) = (self.left.x, way.x);
        let over = |share: f64| {
            let x = from + share * (to - from);
            self.ground.height_at(x, 0.0) - way.at(x)
        };
        (1..LOOKS).map(|look| over(f64::from(look) / f64::from(LOOKS))).fold(0.0, f64::max)
    }
}
