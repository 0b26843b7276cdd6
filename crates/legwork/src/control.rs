//! The controller: reference generator, motion reference planner and quadratic program in one tick.
//!
//! It sees what a real robot's controller would be given, a state estimate and contact flags, and returns torques
//! that are always finite and within their limits. Where the program has no solution as it stands, it gives way in
//! the order of [`Fallback`], and says so.

use legwork_qp::{Problem, Solver, Status};
use legwork_rbd::{Base, Dynamics, Model};

use crate::contact::Surface;
use crate::error::Error;
use crate::feet::{FeetMotion, Footing, Sole};
use crate::planner::MotionReferencePlanner;
use crate::qp::tasks::Seen;
use crate::qp::{self, Condition, Inputs, Layout, Limit, Relaxation, Solution, Task, bounds, layout};
use crate::reference::{ComTrajectory, Observation, Reference, ReferenceGenerator};
use crate::scenario::{ControllerSettings, Generator, Scenario, Tracking};
use crate::terrain::Terrain;
use crate::wearer;

/// Soles are level and alike to this [m].
const LEVEL_M: f64 = 1e-3;

/// What the controller is told of the robot.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Time [s].
    pub time: f64,
    /// Joint positions [rad, m].
    pub q: Vec<f64>,
    /// Joint velocities [rad/s, m/s].
    pub v: Vec<f64>,
    /// Which contact points touch the ground.
    pub touching: Vec<bool>,
    /// Vertical forces on them, the mean of the control period before [N].
    pub load: Vec<f64>,
}

/// What the controller did where the program had no solution as it stood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fallback {
    /// Nothing: the program was solved as it stands.
    #[default]
    None,
    /// The bounds on braking joints (4.32) became costs of weight `controller.weights.braking`.
    JointLimitsYield,
    /// The largest joint accelerations were no bounds either.
    AccelerationsYield,
    /// Hard tasks became costs of their weights as well.
    TasksYield,
    /// No solution at all: the torques of the tick before are held.
    HoldTorque,
}

impl Fallback {
    /// In the order in which they are tried.
    pub const ALL: [Self; 5] =
        [Self::None, Self::JointLimitsYield, Self::AccelerationsYield, Self::TasksYield, Self::HoldTorque];

    /// It in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::JointLimitsYield => "joint limits yielded",
            Self::AccelerationsYield => "acceleration limits yielded",
            Self::TasksYield => "hard tasks yielded",
            Self::HoldTorque => "torque held",
        }
    }
}

/// A part of a control tick, in the order in which they are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// References and goals.
    Reference,
    /// The program written down; once more for each fallback.
    Assembly,
    /// The program solved; once more for each fallback.
    Solve,
    /// The solution read, and which limits are active.
    Reading,
}

impl Part {
    /// In their order.
    pub const ALL: [Self; 4] = [Self::Reference, Self::Assembly, Self::Solve, Self::Reading];
}

/// The report of one tick.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Status of the program as it stood, before any fallback.
    pub status: Status,
    /// Where that is infeasible: what contradicts each other.
    pub conflict: Vec<Condition>,
    /// What was done where that had no solution.
    pub fallback: Fallback,
    /// Iterations of the solver, all attempts together.
    pub iterations: u32,
    /// Programs solved: one, or more with a fallback.
    pub solves: u32,
    /// The optimum; its `tau` are the torques to apply.
    pub solution: Solution,
    /// For each of [`Layout::limits`]: -1 or 1 where its lower or upper side is active, else 0.
    pub active: Vec<i8>,
    /// For each actuated joint, the acceleration that the braking distance (4.32) asks for [rad/s²], else zero.
    pub braking: Vec<f64>,
}

/// The controller with its state.
#[derive(Clone, Debug)]
pub struct Controller {
    settings: ControllerSettings,
    model: Model,
    terrain: Terrain,
    /// What is below each contact point.
    ground: Vec<Surface>,
    feet: FeetMotion,
    generator: ReferenceGenerator,
    planner: MotionReferencePlanner,
    layout: Layout,
    problem: Problem,
    solver: Solver,
    stance: Vec<bool>,
    torque_before: Vec<f64>,
    tick: Tick,
}

impl Controller {
    /// A controller for `model` in `scenario`, which starts at `start`; `samples` are the rows of the CoM file.
    ///
    /// # Errors
    /// The model is not one that this controller can drive, or the CoM trajectory is not valid.
    pub fn new(scenario: &Scenario, model: &Model, samples: &[[f64; 3]], start: &Estimate) -> Result<Self, Error> {
        check_model(model, scenario.reference.generator)?;
        check_reach(scenario, model)?;
        let settings = wearer::controller(scenario, model);
        let terrain = Terrain::believed(scenario, model);
        let mut dynamics = Dynamics::new(model);
        dynamics.update(model, &start.q, &start.v);
        let mut feet = FeetMotion::new(model);
        feet.update(model, &dynamics);
        let com = ComTrajectory::new(&scenario.reference.com, samples, dynamics.com, &terrain)?;
        let generator = ReferenceGenerator::new(scenario, model, com, &terrain, &observe(&dynamics, &feet, start));
        let layout = Layout::new(settings.form, &settings, model);
        Ok(Self {
            planner: MotionReferencePlanner::new(&settings, model),
            problem: Problem::new(layout.variables(), layout.rows()),
            solver: Solver::new(layout.variables(), layout.rows()),
            stance: vec![false; model.contacts.len()],
            torque_before: vec![0.0; layout.actuated.len()],
            tick: Tick {
                status: Status::Optimal,
                conflict: Vec::with_capacity(layout.variables() + layout.rows()),
                fallback: Fallback::None,
                iterations: 0,
                solves: 0,
                solution: Solution::new(&layout),
                active: vec![0; layout.limits().len()],
                braking: vec![0.0; layout.actuated.len()],
            },
            settings,
            model: model.clone(),
            ground: vec![*terrain.base(); model.contacts.len()],
            terrain,
            feet,
            generator,
            layout,
        })
    }

    /// One control tick: torques for `estimate`, whose dynamics are in `dynamics`. Allocates nothing.
    pub fn tick(&mut self, estimate: &Estimate, dynamics: &Dynamics) -> &Tick {
        self.tick_in_parts(estimate, dynamics, |_part| {})
    }

    /// As [`Controller::tick`], and tells `done` after each part, so that a caller with a clock can time them.
    pub fn tick_in_parts(&mut self, estimate: &Estimate, dynamics: &Dynamics, mut done: impl FnMut(Part)) -> &Tick {
        self.refer(estimate, dynamics);
        self.planner.plan(&Seen {
            model: &self.model,
            dynamics,
            feet: &self.feet,
            q: &estimate.q,
            v: &estimate.v,
            reference: self.generator.reference(),
            settings: &self.settings.planner,
        });
        done(Part::Reference);
        self.solve(estimate, dynamics, &mut done);
        self.name_limits();
        done(Part::Reading);
        &self.tick
    }

    /// The reference, and which contacts may carry force.
    fn refer(&mut self, estimate: &Estimate, dynamics: &Dynamics) {
        self.feet.update(&self.model, dynamics);
        self.generator.update(&observe(dynamics, &self.feet, estimate));
        let footing = &self.generator.reference().footing;
        for (foot, footing) in footing.iter().enumerate().filter(|(_, footing)| footing.is_on_an_end()) {
            self.feet.place(&self.model, dynamics, foot, *footing);
        }
        if !self.terrain.is_plane() {
            let contacts = &self.model.contacts;
            self.terrain.below(&dynamics.contact_positions, |contact| contacts[contact].foot, &mut self.ground);
        }
        for (contact, point) in self.model.contacts.iter().enumerate() {
            self.stance[contact] = estimate.touching[contact]
                && match footing.get(point.foot) {
                    // The distance rule (4.10) alone lets the swing foot push until it has left the ground.
                    Some(Footing::Swings) => false,
                    Some(&footing) if footing.is_on_an_end() => {
                        self.feet.points(point.foot, footing).contains(&contact)
                    }
                    _ => true,
                };
        }
    }

    /// The program is built, solved and read, with the fallbacks where it has no solution as it stands.
    fn solve(&mut self, estimate: &Estimate, dynamics: &Dynamics, done: &mut impl FnMut(Part)) {
        let settings = &self.settings;
        self.torque_before.copy_from_slice(&self.tick.solution.tau);
        let mut inputs = Inputs {
            model: &self.model,
            dynamics,
            feet: &self.feet,
            q: &estimate.q,
            v: &estimate.v,
            aims: self.planner.aims(),
            stance: &self.stance,
            footing: &self.generator.reference().footing,
            max_load: &self.generator.reference().max_load,
            ground: &self.ground,
            weights: &settings.weights,
            limits: &settings.limits,
            // Each tick solves at least one program.
            torque_before: (self.tick.solves > 0).then_some(&self.torque_before[..]),
            period: settings.period_s,
            relaxed: Relaxation::default(),
        };
        // Contacts that come back meet the limits that they met before.
        self.solver.select_mode(self.stance.iter().fold(0, |mode, &stands| mode << 1 | u64::from(stands)));
        let tick = &mut self.tick;
        tick.conflict.clear();
        tick.iterations = 0;
        tick.solves = 0;
        let hard_tasks = self.layout.tasks().iter().any(|task| task.how == Tracking::Equality);
        for (braking, &dof) in tick.braking.iter_mut().zip(&self.layout.actuated) {
            *braking = bounds::braking(&inputs, dof).unwrap_or(0.0);
        }
        let is_braking = tick.braking.iter().any(|&acceleration| acceleration != 0.0);
        for fallback in Fallback::ALL {
            tick.fallback = fallback;
            inputs.relaxed = Relaxation {
                joint_limits: fallback >= Fallback::JointLimitsYield,
                accelerations: fallback >= Fallback::AccelerationsYield,
                tasks: fallback >= Fallback::TasksYield,
            };
            match fallback {
                Fallback::JointLimitsYield if !is_braking => continue,
                Fallback::TasksYield if !hard_tasks => continue,
                Fallback::HoldTorque => {
                    tick.solution.hold_torque();
                    break;
                }
                _ => {}
            }
            qp::build(&self.layout, &inputs, &mut self.problem);
            done(Part::Assembly);
            let status = self.solver.solve(&self.problem);
            done(Part::Solve);
            tick.solves += 1;
            tick.iterations += self.solver.iterations();
            if fallback == Fallback::None {
                tick.status = status;
                let named = self.solver.conflict().filter_map(|conflict| self.layout.condition(conflict.constraint));
                tick.conflict.extend(named);
            }
            if status == Status::Optimal && self.solver.x().iter().all(|value| value.is_finite()) {
                qp::read_solution(&self.layout, &inputs, self.solver.x(), &mut tick.solution);
                break;
            }
        }
    }

    /// Which limits are active.
    fn name_limits(&mut self) {
        let tick = &mut self.tick;
        tick.active.fill(0);
        if tick.fallback == Fallback::HoldTorque {
            return;
        }
        for active in self.solver.working_set() {
            let Some(index) = self.layout.limit(active.constraint) else { continue };
            // Without contact the force is zero, which is no limit that is met.
            if self.layout.limits()[index].kind.contact().is_none_or(|contact| self.stance[contact]) {
                tick.active[index] = layout::side_sign(active.side);
            }
        }
    }

    /// Asks for another walking speed from now on [m/s]; see [`ReferenceGenerator::command_speed`].
    pub fn command_speed(&mut self, speed: f64) {
        self.generator.command_speed(speed);
    }

    /// The report of the latest tick.
    pub fn latest(&self) -> &Tick {
        &self.tick
    }

    /// The reference of the latest tick.
    pub fn reference(&self) -> &Reference {
        self.generator.reference()
    }

    /// The foot that swings (0 right, 1 left) and since when [s], if one does.
    pub fn swing(&self) -> Option<(usize, f64)> {
        self.generator.swing()
    }

    /// The extrapolated centre of mass along x, as of the latest tick [m].
    pub fn xcom(&self) -> f64 {
        self.generator.xcom()
    }

    /// Where the centre of pressure and the extrapolated centre of mass should be along x [m].
    pub fn balance(&self) -> [f64; 2] {
        self.generator.balance()
    }

    /// The feet, as of the latest tick.
    pub fn feet(&self) -> &FeetMotion {
        &self.feet
    }

    /// The program of the latest tick, as the solver got it last.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The motion reference planner with its latest goals.
    pub fn planner(&self) -> &MotionReferencePlanner {
        &self.planner
    }

    /// The ground below each contact point, as the controller knows it.
    pub fn ground(&self) -> &[Surface] {
        &self.ground
    }

    /// The tasks, in the order of their rows.
    pub fn tasks(&self) -> &[Task] {
        self.layout.tasks()
    }

    /// The limits that can be active, in the order of [`Tick::active`].
    pub fn limits(&self) -> &[Limit] {
        self.layout.limits()
    }

    /// What the task `name` was missed by in the latest tick, in its rows; empty where there is no such task.
    pub fn slack(&self, name: &str) -> &[f64] {
        self.layout.task(name).map_or(&[], |task| &self.tick.solution.slack[task.rows.clone()])
    }

    /// The program's layout, with its tasks and limits.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }
}

/// What the reference generator sees; a foot touches the ground if one of its contact points does.
fn observe(dynamics: &Dynamics, feet: &FeetMotion, estimate: &Estimate) -> Observation {
    let sum = |contacts: &[usize]| contacts.iter().map(|&contact| estimate.load[contact]).sum();
    Observation {
        time: estimate.time,
        com: dynamics.com,
        com_velocity: dynamics.com_velocity,
        feet: [0, 1].map(|foot| feet.position[foot]),
        pitch: [0, 1].map(|foot| {
            let ahead = feet.rotation[foot].column(0);
            [libm::atan2(ahead.z, ahead.x), -feet.angular_velocity[foot].y]
        }),
        touching: [0, 1].map(|foot| feet.contacts(foot).iter().any(|&contact| estimate.touching[contact])),
        load: [0, 1].map(|foot| sum(feet.contacts(foot))),
        end_load: [0, 1].map(|foot| feet.ends(foot).each_ref().map(|end| sum(end))),
    }
}

/// Whether the feet's joints are above their soles and between heel and toe.
fn has_ankles(model: &Model) -> bool {
    let sole = Sole::of(model);
    sole.heel < 0.0 && sole.toe > 0.0 && sole.ankle > 0.0
}

/// What is wrong with the soles on which the walker is to stand: each is level, below its ankle, and the other's like.
fn uneven_soles(model: &Model) -> Option<String> {
    let sole = Sole::of(model);
    for contact in &model.contacts {
        let [x, z] = [contact.position.x, contact.position.z];
        if z >= 0.0 || (z + sole.ankle).abs() > LEVEL_M {
            return Some(format!(
                "contact point '{}' is at z = {z} m from its ankle; the walker's soles are level, here at z = {} m, below the ankle",
                contact.name, -sole.ankle
            ));
        }
        if x < sole.heel - LEVEL_M || x > sole.toe + LEVEL_M {
            return Some(format!(
                "contact point '{}' is at x = {x} m from its ankle; both of the walker's soles go from {} to {} m, as that of the first foot",
                contact.name, sole.heel, sole.toe
            ));
        }
    }
    None
}

/// The walker's legs reach the ground from wherever its schedule has the centre of mass.
fn check_reach(scenario: &Scenario, model: &Model) -> Result<(), Error> {
    if scenario.reference.generator != Generator::Walker {
        return Ok(());
    }
    let walker = scenario.reference.walker.for_stature(scenario.wearer.stature());
    let ankle = Sole::of(model).ankle;
    for (row, &[speed, _, height, ..]) in walker.schedule.iter().enumerate() {
        if walker.farthest_ahead(speed, ankle, walker.longest_drop_m) == 0.0 {
            let problem = format!(
                "row {row}: with the centre of mass {height} m high no leg of leg_m = {} m reaches the ground; valid is a lower \
                 one or a longer leg",
                walker.leg_m
            );
            return Err(Error::invalid("reference.walker.schedule", problem));
        }
    }
    Ok(())
}

/// Two feet, right before left; the thesis's steps want a planar robot with point feet.
pub(crate) fn check_model(model: &Model, generator: Generator) -> Result<(), Error> {
    let points = |foot: usize| model.contacts.iter().filter(|contact| contact.foot == foot).count();
    let two_feet = model.feet.len() == 2 && points(0) > 0 && points(1) > 0;
    let one_body_each =
        model.contacts.iter().all(|a| model.contacts.iter().all(|b| a.foot != b.foot || a.body == b.body));
    let (valid, needs) = match generator {
        Generator::Steps => (
            model.is_planar() && two_feet && model.contacts.len() == 2,
            "the generator \"steps\" needs a planar base and two feet with one contact point each, right before left",
        ),
        Generator::Stance => (
            model.base != Base::Fixed && two_feet && one_body_each,
            "the generator \"stance\" needs a planar or floating base and two feet, right before left, each with its \
             contact points on one body",
        ),
        Generator::Walker => (
            model.is_planar() && two_feet && one_body_each && points(0) > 1 && points(1) > 1 && has_ankles(model),
            "the generator \"walker\" needs a planar base and two feet, right before left, each with a heel and a toe on \
             one body, the heel behind and the toe before the ankle and both below it",
        ),
    };
    if valid {
        return match uneven_soles(model) {
            Some(problem) if generator == Generator::Walker => {
                Err(Error::invalid("model", format!("the model '{}': {problem}", model.name)))
            }
            _ => Ok(()),
        };
    }
    let found = format!(
        "the model '{}' has base {} and {} contact points on {} feet",
        model.name,
        format!("{:?}", model.base).to_lowercase(),
        model.contacts.len(),
        model.feet.len()
    );
    Err(Error::invalid("model", format!("{found}; {needs}")))
}
