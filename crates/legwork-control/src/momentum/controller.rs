//! The momentum controller: reference generator, motion reference planner and quadratic program in one tick.
//!
//! It sees what a real robot's controller would be given, a state estimate and contact flags, and returns torques
//! that are always finite and within their limits. Where the program has no solution as it stands, it gives way in
//! the order of [`Fallback`], and says so.

use legwork_contract::channel::{Channel, Field, Record};
use legwork_contract::contact::Surface;
use legwork_contract::contract::{Command, Sensed};
use legwork_contract::feet::{FeetMotion, Footing};
use legwork_contract::names;
use legwork_contract::robot::Robot;
use legwork_contract::terrain::Terrain;
use legwork_qp::{Problem, Solver, Status};
use legwork_rbd::Dynamics;

use super::tasks::{Seen, momentum};
use super::{Inputs, Layout, Limit, Relaxation, Solution, Task, bounds, layout};
use crate::contacts::Contacts;
use crate::controller::{Controller, Program};
use crate::generator::{Generator, Observation, Reference};
use crate::planner::MotionReferencePlanner;
use crate::prediction::Prediction;
use crate::settings::{ControllerSettings, ReferenceSettings, Tracking};

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

/// What one tick made, beside its [`Command`].
#[derive(Clone, Debug)]
pub struct Tick {
    /// How the program went.
    pub program: Program,
    /// The optimum.
    pub solution: Solution,
    /// For each of [`Layout::limits`]: -1 or 1 where its lower or upper side is active, else 0.
    pub active: Vec<i8>,
    /// For each actuated joint, the acceleration with which it has to brake for the end of its range (4.32) or its largest speed
    /// [rad/s²], else zero.
    pub braking: Vec<f64>,
}

/// The controller with its state.
#[derive(Debug)]
pub struct MomentumController {
    settings: ControllerSettings,
    model: Robot,
    terrain: Terrain,
    /// What is below each contact point.
    ground: Vec<Surface>,
    feet: FeetMotion,
    contacts: Contacts,
    generator: Box<dyn Generator>,
    reference: Reference,
    planner: MotionReferencePlanner,
    layout: Layout,
    problem: Problem,
    solver: Solver,
    stance: Vec<bool>,
    torque_before: Vec<f64>,
    /// Whether a program was solved in a tick so far: else no torques were before.
    has_solved: bool,
    prediction: Option<Prediction>,
    tick: Tick,
    command: Command,
}

impl MomentumController {
    /// A controller for `model` on the `terrain` that it believes in, which follows a `generator`.
    pub fn new(settings: &ControllerSettings, model: &Robot, terrain: &Terrain, generator: Box<dyn Generator>) -> Self {
        let layout = Layout::new(settings.form, settings, model);
        let actuated = layout.actuated.len();
        Self {
            planner: MotionReferencePlanner::new(settings, model),
            problem: Problem::new(layout.variables(), layout.rows()),
            solver: Solver::new(layout.variables(), layout.rows()),
            stance: vec![false; model.contacts.len()],
            torque_before: vec![0.0; actuated],
            has_solved: false,
            tick: Tick {
                program: Program::new([layout.variables(), layout.rows()]),
                solution: Solution::new(&layout),
                active: vec![0; layout.limits().len()],
                braking: vec![0.0; actuated],
            },
            command: Command { torque: vec![0.0; actuated] },
            prediction: Prediction::over(settings.known_delay_s, settings.period_s, model),
            settings: settings.clone(),
            model: model.clone(),
            ground: vec![*terrain.base(); model.contacts.len()],
            terrain: terrain.clone(),
            feet: FeetMotion::new(model),
            contacts: Contacts::new(model),
            generator,
            reference: Reference::default(),
            layout,
        }
    }

    /// As [`Controller::tick`], and tells `done` after each part, so that a caller with a clock can time them.
    pub fn tick_in_parts(&mut self, sensed: &Sensed, dynamics: &Dynamics, mut done: impl FnMut(Part)) -> &Tick {
        let seen = dynamics.com.iter().chain(dynamics.com_velocity.iter());
        if sensed.fits(&self.model) && seen.into_iter().all(|value| value.is_finite()) {
            match self.prediction.take() {
                Some(mut prediction) => {
                    let (sensed, dynamics) = prediction.ahead(&self.model, sensed);
                    self.work(sensed, dynamics, &mut done);
                    self.prediction = Some(prediction);
                }
                None => self.work(sensed, dynamics, &mut done),
            }
        } else {
            self.hold(Status::InvalidInput);
        }
        if let Some(prediction) = &mut self.prediction {
            prediction.follow(&self.tick.solution.qdd);
        }
        self.name_limits();
        self.command.torque.copy_from_slice(&self.tick.solution.tau);
        done(Part::Reading);
        &self.tick
    }

    /// Goals for what is sensed, and the program.
    fn work(&mut self, sensed: &Sensed, dynamics: &Dynamics, done: &mut impl FnMut(Part)) {
        self.refer(sensed, dynamics);
        self.planner.plan(&Seen {
            model: &self.model,
            dynamics,
            feet: &self.feet,
            q: &sensed.q,
            v: &sensed.v,
            reference: &self.reference,
            settings: &self.settings.planner,
        });
        done(Part::Reference);
        self.solve(sensed, dynamics, done);
    }

    /// The reference, and which contacts may carry force.
    fn refer(&mut self, sensed: &Sensed, dynamics: &Dynamics) {
        self.feet.update(&self.model, dynamics);
        let seen = (dynamics, &self.feet);
        let world = (&self.model, &self.terrain);
        let asked = (&self.reference.footing[..], &self.tick.solution.rho[..]);
        self.contacts.update(self.settings.lift_height_m, world, sensed, seen, asked);
        let seen = Observation::new(sensed.time, dynamics, &self.feet, self.contacts.points());
        self.generator.update(&seen, &mut self.reference);
        let footing = &self.reference.footing;
        for (foot, footing) in footing.iter().enumerate().filter(|(_, footing)| footing.is_on_an_end()) {
            self.feet.place(&self.model, dynamics, foot, *footing);
        }
        if !self.terrain.is_plane() {
            let foot_of = &self.model.foot_of;
            self.terrain.below(&dynamics.contact_positions, |contact| foot_of[contact], &mut self.ground);
        }
        for (contact, &foot) in self.model.foot_of.iter().enumerate() {
            self.stance[contact] = self.contacts.points()[contact].touching
                && match footing.get(foot) {
                    // The distance rule (4.10) alone lets the swing foot push until it has left the ground.
                    Some(Footing::Swings) => false,
                    Some(&footing) if footing.is_on_an_end() => self.feet.points(foot, footing).contains(&contact),
                    _ => true,
                };
        }
    }

    /// The torques of the tick before, as what is sensed is no state of the robot.
    fn hold(&mut self, status: Status) {
        let program = &mut self.tick.program;
        program.begin();
        (program.status, program.fallback) = (status, Fallback::HoldTorque);
        self.tick.solution.hold_torque();
    }

    /// The program is built, solved and read, with the fallbacks where it has no solution as it stands.
    fn solve(&mut self, sensed: &Sensed, dynamics: &Dynamics, done: &mut impl FnMut(Part)) {
        let settings = &self.settings;
        self.torque_before.copy_from_slice(&self.tick.solution.tau);
        let mut inputs = Inputs {
            model: &self.model,
            dynamics,
            feet: &self.feet,
            q: &sensed.q,
            v: &sensed.v,
            aims: self.planner.aims(),
            stance: &self.stance,
            footing: &self.reference.footing,
            max_load: &self.reference.max_load,
            ground: &self.ground,
            weights: &settings.weights,
            limits: &settings.limits,
            torque_before: self.has_solved.then_some(&self.torque_before[..]),
            period: settings.period_s,
            relaxed: Relaxation::default(),
        };
        // Contacts that come back meet the limits that they met before.
        self.solver.select_mode(self.stance.iter().fold(0, |mode, &stands| mode << 1 | u64::from(stands)));
        self.has_solved = true;
        let tick = &mut self.tick;
        tick.program.begin();
        let hard_tasks = self.layout.tasks().iter().any(|task| task.how == Tracking::Equality);
        for (braking, &dof) in tick.braking.iter_mut().zip(&self.layout.actuated) {
            *braking = bounds::braking(&inputs, dof).unwrap_or(0.0);
        }
        let is_braking = tick.braking.iter().any(|&acceleration| acceleration != 0.0);
        for fallback in Fallback::ALL {
            tick.program.fallback = fallback;
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
            super::build(&self.layout, &inputs, &mut self.problem);
            done(Part::Assembly);
            let status = self.solver.solve(&self.problem);
            done(Part::Solve);
            tick.program.solves += 1;
            tick.program.iterations += self.solver.iterations();
            if fallback == Fallback::None {
                tick.program.status = status;
                let named = self.solver.conflict().filter_map(|conflict| self.layout.condition(conflict.constraint));
                tick.program.conflict.extend(named);
            }
            if status == Status::Optimal && self.solver.x().iter().all(|value| value.is_finite()) {
                super::read_solution(&self.layout, &inputs, self.solver.x(), &mut tick.solution);
                break;
            }
        }
    }

    /// Which limits are active.
    fn name_limits(&mut self) {
        let tick = &mut self.tick;
        tick.active.fill(0);
        if tick.program.fallback == Fallback::HoldTorque {
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

    /// The report of the latest tick.
    pub fn latest(&self) -> &Tick {
        &self.tick
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

    /// What the task `name` was missed by in the latest tick, in its rows; empty where there is no such task.
    pub fn slack(&self, name: &str) -> &[f64] {
        self.layout.task(name).map_or(&[], |task| &self.tick.solution.slack[task.rows.clone()])
    }

    /// The program's layout.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }
}

impl Controller for MomentumController {
    fn tick(&mut self, sensed: &Sensed, dynamics: &Dynamics) -> &Command {
        self.tick_in_parts(sensed, dynamics, |_part| {});
        &self.command
    }

    fn command(&self) -> &Command {
        &self.command
    }

    fn reference(&self) -> Option<&Reference> {
        Some(&self.reference)
    }

    fn program(&self) -> Option<&Program> {
        Some(&self.tick.program)
    }

    fn tasks(&self) -> &[Task] {
        self.layout.tasks()
    }

    fn limits(&self) -> &[Limit] {
        self.layout.limits()
    }

    fn active(&self) -> &[i8] {
        &self.tick.active
    }

    fn channels(&self) -> Vec<Channel> {
        let model = &self.model;
        let slack = self.layout.tasks().iter().flat_map(|task| task.columns(&format!("slack.{}", task.name)));
        let momentum = self.layout.task(momentum::NAME).map(|task| task.columns("momentum_rate_goal"));
        let limits = self.layout.limits().iter().map(|limit| (limit.column(model), ""));
        [
            Channel::all(Field::Grf, names::contacts(model, "grf", "N")),
            Channel::all(Field::MomentumRateGoal, momentum.unwrap_or_default()),
            Channel::all(Field::Acceleration, names::dofs(model, "acceleration", "m/s2", "rad/s2")),
            Channel::all(Field::Slack, slack),
            Channel::all(Field::ActiveLimit, limits),
            Channel::all(Field::Braking, names::joints(model, "braking", "rad/s2")),
            Channel::all(
                Field::Program,
                ["qp.status", "qp.fallback", "qp.iterations", "qp.solves"].map(|name| (name, "")),
            ),
        ]
        .concat()
    }

    fn record(&self, record: &mut Record<'_>) {
        let Tick { program, solution, active, braking } = &self.tick;
        record.set(Field::Grf, solution.rho.iter().copied());
        record.set(Field::MomentumRateGoal, self.planner.goal(momentum::NAME).iter().copied());
        record.set(Field::Acceleration, solution.qdd.iter().copied());
        record.set(Field::Slack, solution.slack.iter().copied());
        record.set(Field::ActiveLimit, active.iter().map(|&side| f64::from(side)));
        record.set(Field::Braking, braking.iter().copied());
        let numbers = [u32::from(program.status as u8), program.fallback as u32, program.iterations, program.solves];
        record.set(Field::Program, numbers.map(f64::from));
    }

    fn change(&mut self, settings: &ControllerSettings, reference: &ReferenceSettings, terrain: &Terrain) {
        // The program's form and tasks, and with them the columns of the log, are those that it was made with.
        let (form, tracking) = (self.settings.form, self.settings.tracking.clone());
        self.settings = ControllerSettings { form, tracking, ..settings.clone() };
        self.generator.change(reference);
        self.ground.fill(*terrain.base());
        self.terrain = terrain.clone();
    }
}
