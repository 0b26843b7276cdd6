//! What the log says: steps, limits, errors, slip, and how far the XcoM is out of reach.

use std::ops::Range;

use legwork_rbd::{Dof, Model};

use super::FirstCause;
use super::reach::Steps;
use crate::balance::support::along;
use crate::balance::{Meter, Point};
use crate::feet::FootRows;
use crate::generator::xcom;
use crate::log::{Field, Log};
use crate::momentum::tasks::{feet, momentum, torso};
use crate::momentum::{Fallback, Limit, LimitKind, Task, bounds};
use crate::redundancy::free_joints;
use crate::robot::Robot;
use crate::scenario::{ControllerKind, JointLimits, PostureTracking, Scenario, Tracking};
use crate::terrain::Terrain;

/// A force or torque is at its limit from this share of it on.
const FULL: f64 = 0.999;

/// Ticks of one double support or of one step.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    pub(super) ticks: Range<usize>,
    /// The foot that swings.
    pub(super) foot: Option<usize>,
}

/// A limit that can be a first cause, with the columns that say when it is active.
#[derive(Clone, Debug)]
pub(super) struct Saturation {
    pub(super) cause: FirstCause,
    /// Indices in [`Layout::limits`].
    limits: Vec<usize>,
    /// Index among the actuated joints, or of the foot.
    index: usize,
}

/// What holds a joint's acceleration at its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hold {
    /// An end of its range.
    Range,
    /// Its largest speed.
    Speed,
    /// Its largest acceleration.
    Acceleration,
}

/// A log with what is needed to read it.
pub(super) struct Evidence<'a> {
    pub(super) scenario: &'a Scenario,
    pub(super) model: &'a Robot,
    pub(super) log: &'a Log,
    pub(super) stretches: Vec<Stretch>,
    pub(super) saturations: Vec<Saturation>,
    pub(super) steps: Steps<'a>,
    pub(super) ground: Terrain,
    pub(super) believed: Terrain,
    /// Number of linear axes.
    pub(super) axes: usize,
    /// The walking direction, a horizontal unit vector: that at the begin of the log.
    pub(super) ahead: Point,
    feet: Vec<FootRows>,
    pub(super) tasks: &'a [Task],
    actuated: Vec<usize>,
}

impl<'a> Evidence<'a> {
    pub(super) fn new(
        scenario: &'a Scenario,
        model: &'a Robot,
        log: &'a Log,
        (tasks, limits): (&'a [Task], &[Limit]),
    ) -> Self {
        let axes = model.linear_axes().len();
        let (ground, believed) = (scenario.terrain(model), scenario.believed_terrain(model));
        let (stretches, saturations) = (stretches(log), saturations(model, limits));
        let (feet, steps) = (FootRows::of(model), Steps::of(scenario, model));
        let actuated = model.actuated().collect();
        let ahead =
            if log.is_empty() { [1.0, 0.0] } else { Meter::new(scenario, model).ahead(|field| log.get(0, field)) };
        Self {
            scenario,
            model,
            log,
            stretches,
            saturations,
            steps,
            ground,
            believed,
            axes,
            ahead,
            feet,
            tasks,
            actuated,
        }
    }

    pub(super) fn time(&self, i: usize) -> f64 {
        self.log.time(i)
    }

    /// Number of ticks in `seconds`.
    pub(super) fn ticks_in(&self, seconds: f64) -> usize {
        (seconds / self.scenario.controller.period_s).round() as usize
    }

    /// The step or double support of tick `i`.
    pub(super) fn stretch(&self, i: usize) -> &Stretch {
        self.stretches.iter().find(|stretch| stretch.ticks.contains(&i)).unwrap_or(&self.stretches[0])
    }

    pub(super) fn foot_name(&self, foot: usize) -> String {
        self.model.feet[foot].clone()
    }

    /// The joints that feet, torso and centre of mass leave free and that the posture task does not hold either.
    pub(super) fn unheld(&self) -> Vec<usize> {
        let controller = &self.scenario.controller;
        if controller.kind != ControllerKind::Momentum {
            return Vec::new();
        }
        let is_held = |dof: usize| {
            let name = &self.model.dofs[dof].name;
            controller.tracking.posture != PostureTracking::Off
                && controller.weights.posture.of(name, 1.0) > 0.0
                && controller.planner.posture_gain.of(name, 1.0) > 0.0
        };
        free_joints(self.model).into_iter().filter(|&dof| !is_held(dof)).collect()
    }

    pub(super) fn weight(&self) -> f64 {
        self.model.total_mass() * self.model.gravity
    }

    /// How far the centre of mass is below its reference [m].
    pub(super) fn sunk(&self, i: usize) -> f64 {
        self.log.get(i, Field::ComReference)[self.axes - 1] - self.log.get(i, Field::Com)[self.axes - 1]
    }

    /// How far the torso is from its reference [rad], backward positive.
    pub(super) fn lean(&self, i: usize) -> f64 {
        self.log.get(i, Field::Torso)[0] - self.log.get(i, Field::TorsoReference)[0]
    }

    /// Place of a foot along x and y [m].
    pub(super) fn foot_at(&self, i: usize, foot: usize) -> [f64; 2] {
        let mut place = self.log.foot(i, foot);
        let mut next = || place.next().expect("a foot has a place");
        let x = next();
        [x, if self.axes == 3 { next() } else { 0.0 }]
    }

    /// Place of a foot along the walking direction [m].
    pub(super) fn foot_ahead(&self, i: usize, foot: usize) -> f64 {
        along(self.ahead, self.foot_at(i, foot))
    }

    /// Part of a foot's goal along the walking direction: 0 where it should be, 1 how fast it should move, 2 accelerate [m, m/s, m/s²].
    pub(super) fn goal_ahead(&self, i: usize, foot: usize, part: usize) -> f64 {
        along(self.ahead, below(&self.foot_goal(i, foot)[part * self.axes..][..self.axes]))
    }

    /// Where a foot should be, then how fast it should move and accelerate [m, m/s, m/s²].
    pub(super) fn foot_goal(&self, i: usize, foot: usize) -> &[f64] {
        &self.log.get(i, Field::FeetReference)[foot * 3 * self.axes..]
    }

    /// How far a foot is off its path [m].
    pub(super) fn foot_off(&self, i: usize, foot: usize) -> f64 {
        let squares = self.log.foot(i, foot).zip(self.foot_goal(i, foot)).map(|(place, goal)| (place - goal).powi(2));
        squares.sum::<f64>().sqrt()
    }

    pub(super) fn touching(&self, i: usize, foot: usize) -> bool {
        let flags = self.log.get(i, Field::Touching);
        self.model.points_of(foot).any(|point| flags[point] > 0.5)
    }

    /// Whether a task is a hard equality of the program.
    pub(super) fn is_hard(&self, task: &str) -> bool {
        self.tasks.iter().any(|known| known.name == task && known.how == Tracking::Equality)
    }

    /// What a task misses, in its rows; empty where the controller has no such task.
    fn slack(&self, i: usize, task: &str) -> &[f64] {
        self.tasks
            .iter()
            .find(|known| known.name == task)
            .map_or(&[], |task| &self.log.get(i, Field::Slack)[task.rows.clone()])
    }

    /// Upward force that the momentum task misses [N].
    pub(super) fn missed_force(&self, i: usize) -> f64 {
        self.slack(i, momentum::NAME).last().map_or(0.0, |force| force.max(0.0))
    }

    /// Acceleration that the task of a foot misses [m/s²].
    pub(super) fn missed_foot(&self, i: usize, foot: usize) -> f64 {
        let slack = self.slack(i, feet::NAME).get(self.feet[foot].linear.clone()).unwrap_or(&[]);
        slack.iter().map(|value| value * value).sum::<f64>().sqrt()
    }

    /// Angular acceleration that the torso task misses [rad/s²].
    pub(super) fn missed_torso(&self, i: usize) -> f64 {
        self.slack(i, torso::NAME).iter().map(|value| value * value).sum::<f64>().sqrt()
    }

    /// By how much the vertical forces that the program counted on exceed those that came [N].
    pub(super) fn unmet_force(&self, i: usize) -> f64 {
        let vertical = |field: Field| self.log.get(i, field).iter().skip(self.axes - 1).step_by(self.axes).sum::<f64>();
        vertical(Field::Grf) - vertical(Field::GrfSimulated)
    }

    pub(super) fn fallback(&self, i: usize) -> f64 {
        self.log.get(i, Field::Program)[1]
    }

    pub(super) fn energy_error(&self, i: usize) -> f64 {
        self.log.get(i, Field::EnergyError)[0].abs()
    }

    /// Whether a limit is active.
    pub(super) fn is_saturated(&self, saturation: &Saturation, i: usize) -> bool {
        let limits = self.log.get(i, Field::ActiveLimit);
        let active = saturation.limits.iter().filter(|&&limit| limits[limit] != 0.0).count();
        let index = saturation.index;
        match saturation.cause {
            FirstCause::AccelerationLimit { .. } => self.holds(saturation, i, Hold::Acceleration),
            FirstCause::JointLimit { .. } => self.holds(saturation, i, Hold::Range),
            FirstCause::SpeedLimit { .. } => self.holds(saturation, i, Hold::Speed),
            FirstCause::TorqueLimit { .. } => active > 0 && !self.is_slewing(index, i),
            FirstCause::TorqueRate { .. } => active > 0 && self.is_slewing(index, i),
            // Less than the limit is what the foot is to carry while it is unloaded.
            FirstCause::ForceLimit { .. } => {
                active > 0 && self.largest_force(index, i) > FULL * self.scenario.controller.limits.grf_n
            }
            // At both sides of the cone, in space at more than two of the pyramid, is at its tip: no force at all.
            FirstCause::Friction { .. } => (1..=self.model.linear_axes().len() - 1).contains(&active),
            _ => active > 0,
        }
    }

    fn holds(&self, saturation: &Saturation, i: usize, hold: Hold) -> bool {
        self.held(saturation, i).is_some_and(|(what, _)| what == hold)
    }

    /// What holds the acceleration of an actuated joint at its bound, and at which: 1 the upper, -1 the lower. A braking joint's bound that
    /// became a cost holds it too.
    fn held(&self, saturation: &Saturation, i: usize) -> Option<(Hold, f64)> {
        let (index, dof) = (saturation.index, self.actuated[saturation.index]);
        let yielded = |fallback: Fallback| self.fallback(i) >= f64::from(fallback as u8);
        let braking = self.log.get(i, Field::Braking)[index];
        let active = self.log.get(i, Field::ActiveLimit)[saturation.limits[0]];
        let at = self.log.get(i, Field::Acceleration)[dof];
        // Braking as hard as it may, a joint has one acceleration left: both of its bounds.
        let brakes =
            yielded(Fallback::JointLimitsYield) || active != 0.0 && (at - braking).abs() < 1e-6 * braking.abs();
        let (side, at) = match braking != 0.0 && brakes {
            true => (-braking.signum(), braking),
            false if active != 0.0 => (active, at),
            false => return None,
        };
        let (limits, joint) = (&self.scenario.controller.limits, &self.model.dofs[dof]);
        let largest =
            if yielded(Fallback::AccelerationsYield) { f64::INFINITY } else { limits.joint_acceleration_radps2 };
        if at * side >= FULL * largest {
            return Some((Hold::Acceleration, side));
        }
        let (q, v) = (self.log.get(i, Field::Q)[self.model.bodies[joint.body].q_index], self.log.get(i, Field::V)[dof]);
        let off = |bound: f64| (bound.clamp(-largest, largest) - at).abs();
        let speed = bounds::speed(limits, joint, v).map(off);
        let range = match limits.joint_limits {
            JointLimits::BrakingDistance => off(-side * limits.joint_acceleration_radps2),
            JointLimits::Approach => off(bounds::range(limits, joint, q, v)[usize::from(side > 0.0)]),
        };
        let is_speed = joint.velocity_limit.is_finite() && speed[0].min(speed[1]) <= range;
        // On its way to its end a joint that need not brake is not held back.
        let hold = if is_speed { Some(Hold::Speed) } else { (braking != 0.0).then_some(Hold::Range) };
        hold.map(|hold| (hold, side))
    }

    /// Whether the torque of an actuated joint, where a bound holds it, is within its limit.
    fn is_slewing(&self, index: usize, i: usize) -> bool {
        self.log.get(i, Field::Torque)[index].abs() < FULL * self.torque_limit(self.actuated[index])
    }

    /// Largest torque of a joint [Nm].
    fn torque_limit(&self, dof: usize) -> f64 {
        self.scenario.controller.limits.torque_nm.min(self.model.dofs[dof].effort_limit)
    }

    /// Largest component of the program's force on a contact point [N].
    fn largest_force(&self, contact: usize, i: usize) -> f64 {
        let forces = self.log.get(i, Field::Grf)[contact * self.axes..].iter().take(self.axes);
        forces.fold(0.0, |most, force| most.max(force.abs()))
    }

    /// Share of `ticks` in which a limit is active.
    pub(super) fn share(&self, saturation: &Saturation, ticks: Range<usize>) -> f64 {
        let count = ticks.len().max(1) as f64;
        ticks.filter(|&i| self.is_saturated(saturation, i)).count() as f64 / count
    }

    /// Eigenfrequency of the pendulum [1/s], as the reference generator has it.
    pub(super) fn omega(&self, i: usize) -> f64 {
        let com = &self.log.get(i, Field::ComReference)[..self.axes];
        let [x, y] = below(com);
        xcom::eigenfrequency(self.model.gravity, com[self.axes - 1] - self.ground.height_at(x, y))
    }

    /// The joint of this name.
    pub(super) fn joint(&self, name: &str) -> Option<&Dof> {
        self.model.dofs.iter().find(|dof| dof.name == name)
    }

    /// The value of a limit that is active in tick `i`: [`What::Saturated`](super::What::Saturated).
    pub(super) fn limit_value(&self, saturation: &Saturation, i: usize) -> f64 {
        let limits = &self.scenario.controller.limits;
        let joint = || &self.model.dofs[self.actuated[saturation.index]];
        match saturation.cause {
            FirstCause::TorqueLimit { .. } => self.torque_limit(self.actuated[saturation.index]),
            FirstCause::TorqueRate { .. } => limits.torque_rate_nmps,
            FirstCause::ForceLimit { .. } => limits.grf_n,
            FirstCause::AccelerationLimit { .. } => limits.joint_acceleration_radps2,
            FirstCause::SpeedLimit { .. } => joint().velocity_limit,
            FirstCause::JointLimit { .. } => match self.held(saturation, i) {
                Some((_, side)) if side > 0.0 => joint().upper,
                _ => joint().lower,
            },
            _ => self.assumed_friction(),
        }
    }

    /// The friction that the controller counts on, where nothing tells it better.
    pub(super) fn assumed_friction(&self) -> f64 {
        self.believed.base().friction
    }
}

/// The place on the ground below a point, of which there are the components along the linear axes [m].
pub(super) fn below(point: &[f64]) -> Point {
    [point[0], if point.len() == 3 { point[1] } else { 0.0 }]
}

/// The steps and double supports of a log.
fn stretches(log: &Log) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for i in 0..log.len() {
        let swing = log.get(i, Field::Swing);
        match found.last_mut() {
            Some(last) if log.get(i - 1, Field::Swing) == swing => last.ticks.end = i + 1,
            _ => found.push(Stretch { ticks: i..i + 1, foot: (swing[0] >= 0.0).then_some(swing[0] as usize) }),
        }
    }
    found
}

/// The limits of the program by cause; an unloaded foot is how a step looks, not a limit that is met.
fn saturations(model: &Model, limits: &[Limit]) -> Vec<Saturation> {
    let of = |cause: FirstCause, index: usize, own: &dyn Fn(LimitKind) -> bool| Saturation {
        cause,
        limits: (0..limits.len()).filter(|&limit| own(limits[limit].kind)).collect(),
        index,
    };
    let mut all = Vec::new();
    for (index, dof) in model.actuated().enumerate() {
        let joint = model.dofs[dof].name.clone();
        let torque = |kind| kind == LimitKind::Torque { dof };
        let acceleration = |kind| kind == LimitKind::Acceleration { dof };
        all.push(of(FirstCause::TorqueLimit { joint: joint.clone() }, index, &torque));
        all.push(of(FirstCause::TorqueRate { joint: joint.clone() }, index, &torque));
        all.push(of(FirstCause::JointLimit { joint: joint.clone() }, index, &acceleration));
        all.push(of(FirstCause::SpeedLimit { joint: joint.clone() }, index, &acceleration));
        all.push(of(FirstCause::AccelerationLimit { joint }, index, &acceleration));
    }
    for (index, point) in model.contacts.iter().enumerate() {
        let foot = point.name.clone();
        let force = |kind| matches!(kind, LimitKind::Force { contact, .. } if contact == index);
        let friction = |kind| matches!(kind, LimitKind::Friction { contact, .. } if contact == index);
        all.push(of(FirstCause::ForceLimit { foot: foot.clone() }, index, &force));
        all.push(of(FirstCause::Friction { foot }, index, &friction));
    }
    all
}
