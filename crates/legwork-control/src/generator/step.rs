//! When and where the robot steps: the state machine of Figure 4.2.
//!
//! Both feet stand until the XcoM leaves the base of support by more than a margin; then the rear foot (in the
//! direction of the fall) swings, and once it touches the ground again after half the step time, its reference is
//! latched where it stands.

use nalgebra::Vector3;

use super::{
    ComTrajectory, Footing, Generator, Observation, PointReference, Reference, Surroundings, Swing, TurnReference,
    swing, xcom,
};
use crate::settings::{LeastStep, ReferenceSettings, Replan, StepSettings};
use legwork_contract::terrain::Terrain;

/// What the feet are doing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Both feet stand.
    DoubleSupport,
    /// One foot swings.
    Step {
        /// 0 right, 1 left.
        foot: usize,
        /// When it was triggered [s].
        since: f64,
        /// Where the foot's reference was then [m].
        from: Vector3<f64>,
        /// Planned displacement along x [m], signed.
        length: f64,
    },
}

/// The generator `steps`: the centre of mass follows its trajectory, and the step state machine moves the feet.
#[derive(Clone, Debug)]
pub struct Steps {
    com: ComTrajectory,
    torso_angle: f64,
    machine: StepMachine,
}

impl Steps {
    /// A generator with both feet standing where they are at the `start`, and the trajectory `com`.
    pub fn new(settings: &StepSettings, com: ComTrajectory, around: &Surroundings<'_>, start: &Observation) -> Self {
        let (ground, gravity) = (around.terrain.clone(), around.model.gravity);
        let machine = StepMachine::new(settings.clone(), ground, around.height_is_known, gravity, start);
        Self { com, torso_angle: around.torso_angle, machine }
    }
}

impl Generator for Steps {
    fn update(&mut self, seen: &Observation, reference: &mut Reference) {
        let (com, machine) = (self.com.at(seen.time), &mut self.machine);
        reference.chest.turn = TurnReference::pitch(self.torso_angle, 0.0, 0.0);
        machine.update(seen, &com);
        for (foot, goal) in reference.feet.iter_mut().enumerate() {
            goal.point = machine.foot(foot, seen.time);
        }
        reference.swing(match machine.phase() {
            Phase::DoubleSupport => None,
            Phase::Step { foot, since, .. } => Some(Swing { foot, since }),
        });
        // A foot whose step is over should stand: it is loaded to find the ground.
        if let Some(late) = reference.swing.filter(|swing| seen.time - swing.since > machine.settings.duration_s) {
            reference.footing[late.foot] = Footing::Stands;
        }
        reference.xcom = [machine.xcom(), 0.0];
        reference.follow(com, machine.gravity, &machine.ground);
    }

    fn change(&mut self, settings: &ReferenceSettings) {
        self.machine.settings = settings.step.clone();
    }
}

/// The step state machine.
#[derive(Clone, Debug)]
pub struct StepMachine {
    settings: StepSettings,
    ground: Terrain,
    ground_known: bool,
    gravity: f64,
    phase: Phase,
    standing: [Vector3<f64>; 2],
    xcom: f64,
}

impl StepMachine {
    /// A machine with both feet standing where they are in `start`; `gravity` [m/s²].
    ///
    /// Feet stand on `ground`. Where it is a guess (`ground_known` is false), they stand at the height that they have.
    pub fn new(settings: StepSettings, ground: Terrain, ground_known: bool, gravity: f64, start: &Observation) -> Self {
        let phase = Phase::DoubleSupport;
        let mut machine =
            Self { settings, ground, ground_known, gravity, phase, standing: start.feet, xcom: start.com.x };
        machine.standing = start.feet.map(|foot| machine.on_ground(foot));
        machine
    }

    /// Where a foot stands that touches the ground at `foot`.
    fn on_ground(&self, foot: Vector3<f64>) -> Vector3<f64> {
        let height = if self.ground_known { self.ground.height_at(foot.x, foot.y) } else { foot.z };
        Vector3::new(foot.x, foot.y, height)
    }

    /// What the feet are doing.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The extrapolated centre of mass as of the latest update [m].
    pub fn xcom(&self) -> f64 {
        self.xcom
    }

    /// Moves the state machine on; `com` is the CoM's reference.
    pub fn update(&mut self, observation: &Observation, com: &PointReference) {
        let height = com.position.z - self.ground.height_at(com.position.x, com.position.y);
        let omega = xcom::eigenfrequency(self.gravity, height);
        self.xcom = xcom::xcom(observation.com.x, observation.com_velocity.x, omega);

        if let Phase::Step { foot, since, from, length } = self.phase {
            let elapsed = observation.time - since;
            if elapsed >= 0.5 * self.settings.duration_s && observation.touching[foot] {
                self.standing[foot] = self.on_ground(observation.feet[foot]);
                self.phase = Phase::DoubleSupport;
            } else if self.settings.replan == Replan::InSwing {
                let left = (self.settings.duration_s - elapsed).max(0.0);
                let length = self.step_length(from.x, observation.feet[1 - foot].x, length.signum(), omega, left);
                self.phase = Phase::Step { foot, since, from, length };
            }
        }
        if self.phase == Phase::DoubleSupport {
            self.trigger(observation, com.velocity.x, omega);
        }
    }

    /// Starts a step when the XcoM has left the base of support far enough.
    fn trigger(&mut self, observation: &Observation, reference_speed: f64, omega: f64) {
        let feet = observation.feet;
        // The delay holds on the side that the reference moves to only: a push back is answered at once.
        let margin = (self.settings.delay_s * reference_speed.abs()).min(self.settings.max_delay_m);
        let ahead = if reference_speed > 0.0 { margin } else { 0.0 };
        let behind = if reference_speed < 0.0 { margin } else { 0.0 };
        let direction = if self.xcom > feet[0].x.max(feet[1].x) + ahead {
            1.0
        } else if self.xcom < feet[0].x.min(feet[1].x) - behind {
            -1.0
        } else {
            return;
        };
        // The rear foot in the direction of the fall steps.
        let foot = usize::from(direction * feet[1].x < direction * feet[0].x);
        let from = self.standing[foot];
        let length = self.step_length(from.x, feet[1 - foot].x, direction, omega, self.settings.duration_s);
        self.phase = Phase::Step { foot, since: observation.time, from, length };
    }

    /// Signed displacement of the foot: to the XcoM predicted for the end of the step, and somewhat further.
    fn step_length(&self, from: f64, stance: f64, direction: f64, omega: f64, time: f64) -> f64 {
        let target = xcom::predicted_xcom(self.xcom, stance, omega, time); // Thesis (2.5)
        let length = direction * (1.0 + self.settings.overshoot) * (target - from);
        let longest = self.settings.max_length_m;
        let least = match self.settings.min_length_is {
            LeastStep::Displacement => self.settings.min_length_m,
            LeastStep::BaseOfSupport => direction * (stance - from) + self.settings.min_length_m,
        };
        direction * length.max(least).min(longest)
    }

    /// Reference of a foot (0 right, 1 left) at `time` [s].
    pub fn foot(&self, foot: usize, time: f64) -> PointReference {
        match self.phase {
            Phase::Step { foot: swinging, since, from, length } if swinging == foot => {
                let duration = self.settings.duration_s;
                let t = (time - since).min(duration);
                let x = swing::forward(t, duration, length); // Thesis (4.1)
                let z = swing::upward(t, duration, self.settings.height_m); // Thesis (4.2)
                let over = time - since > duration; // late: wait at the target
                let slope = self.ground.base().steepness()[0];
                let along = |forward: f64, up: f64| Vector3::new(forward, 0.0, slope * forward + up);
                let moving = |value: Vector3<f64>| if over { Vector3::zeros() } else { value };
                PointReference {
                    position: from + along(x.value, z.value),
                    velocity: moving(along(x.rate, z.rate)),
                    acceleration: moving(along(x.acceleration, z.acceleration)),
                }
            }
            _ => PointReference { position: self.standing[foot], ..PointReference::default() },
        }
    }
}
