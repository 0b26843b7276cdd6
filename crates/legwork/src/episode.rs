//! One run: the only file that sees a controller and a physics at once.
//!
//! An [`Episode`] lets both act on each other, tick by tick, and writes a record of each tick. Controller, reference generator
//! and physics are those of the scenario, or one's own ([`Parts`]).

use legwork_qp::Status;
use legwork_rbd::Dynamics;

use crate::balance::{Measures, Meter, Moment};
use crate::channel::{Columns, Field, Record};
use crate::contract::Sensed;
use crate::control::{Controller, HoldController};
use crate::diagnosis::{self, Diagnosis, Fall};
use crate::error::Error;
use crate::feet::FeetMotion;
use crate::fit::fitted;
use crate::generator::{Generator, check_feet, check_model};
use crate::joint_limits::JointLimits;
use crate::log::Log;
use crate::metrics::{Measuring, Metrics};
use crate::momentum::{Condition, Fallback, Limit, Task};
use crate::record;
use crate::redundancy::free_joints;
use crate::robot::Robot;
use crate::scenario::{ControllerKind, PostureTracking, Scenario};
use crate::settings;
use crate::sim::audit::Audit;
use crate::sim::sensors::Sensors;
use crate::sim::{Health, Plant, model_error};
use crate::sink::{Hashes, Sink};
use crate::start::start_pose;
use crate::terrain::Terrain;

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It lasted its full time.
    Completed,
    /// The robot fell.
    Fell(Fall),
    /// It was interrupted from outside.
    Stopped,
}

/// How the programs went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgramCounts {
    /// Variables and rows of the program; none of a controller that solves none.
    pub size: [usize; 2],
    /// Programs solved.
    pub solves: u64,
    /// Ticks whose program was infeasible as it stood.
    pub infeasible: u64,
    /// The first of them: when [s], and what contradicted each other, sorted by its words.
    pub first_infeasible: Option<(f64, Vec<Condition>)>,
    /// Ticks that ended with a fallback.
    pub fallbacks: u64,
    /// Mean of the solver's iterations a tick.
    pub iterations_mean: f64,
    /// Most of them.
    pub iterations_max: u32,
}

/// How long things took; not part of the result's hash.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// Duration of each of the first [`MOST_TIMED`] control ticks [s]; without the dynamics of the state where the sensors are ideal, as the physics
    /// has them already. None where the run had no clock.
    pub ticks_s: Vec<f64>,
    /// Of the whole run [s].
    pub wall_s: f64,
}

impl Timing {
    /// The `share` quantile of the tick durations [µs].
    pub fn tick_quantile_us(&self, share: f64) -> f64 {
        let mut sorted = self.ticks_s.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        sorted.get((share * last as f64).round() as usize).map_or(0.0, |seconds| seconds * 1e6)
    }
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Run {
    /// What was run.
    pub scenario: Scenario,
    /// The robot as it is.
    pub model: Robot,
    /// The robot as the controller knows it; the same but for `simulation.model_error`.
    pub known: Robot,
    /// The controller's tasks, in the order of the log's columns of slack.
    pub tasks: Vec<Task>,
    /// The controller's limits, in the order of the log's columns of active ones.
    pub limits: Vec<Limit>,
    /// How it ended.
    pub outcome: Outcome,
    /// Why it fell, in a sentence: that of the diagnosis; none where it did not.
    pub reason: Option<String>,
    /// Why it fell: first cause and events; none where it did not.
    pub diagnosis: Option<Diagnosis>,
    /// One record a control tick.
    pub log: Log,
    /// The thesis's figures.
    pub metrics: Metrics,
    /// The physics' books; none of a physics that keeps none.
    pub audit: Option<Audit>,
    /// Limits that the model gives to joints and that they passed, in words.
    pub limits_passed: Vec<String>,
    /// Time simulated [s].
    pub simulated_s: f64,
    /// How the programs went.
    pub program: ProgramCounts,
    /// How long things took.
    pub timing: Timing,
    /// Hash of scenario, model and CoM samples.
    pub input_hash: u128,
    /// Hash of the log.
    pub result_hash: u128,
}

impl Run {
    /// Where the physics broke its own laws, in words; nothing where it did not, or where nothing watched it.
    pub fn violations(&self) -> Vec<String> {
        self.audit.as_ref().map_or_else(Vec::new, Audit::violations)
    }

    /// The largest force on a contact point [N], where that is above `metrics.injurious_force_n`: a robot that stands on its feet may
    /// have hurt its wearer.
    pub fn injurious_force_n(&self) -> Option<f64> {
        let peak = self.metrics.grf_simulated_n?.peak;
        (peak > self.scenario.metrics.injurious_force_n).then_some(peak)
    }
}

/// What a run is made of where it is not what the scenario says.
#[derive(Debug, Default)]
pub struct Parts {
    /// Rows of the CoM file, where the scenario names one.
    pub samples: Vec<[f64; 3]>,
    /// A controller of one's own.
    pub controller: Option<Box<dyn Controller>>,
    /// A reference generator of one's own for the scenario's controller.
    pub generator: Option<Box<dyn Generator>>,
    /// A physics of one's own.
    pub plant: Option<Box<dyn Plant>>,
    /// Where the records go while the run goes on. Without it they stay in memory; with it the latest [`KEPT_S`] of them do.
    pub sink: Option<Box<dyn Sink>>,
    /// Tells the time [s], from wherever it counts, so that ticks are timed.
    pub clock: Option<fn() -> f64>,
}

/// Where a sink takes the records, those of the latest so many seconds stay in memory, or up to a quarter more: what the diagnosis of a
/// fall looks back at.
pub const KEPT_S: f64 = diagnosis::LOOKS_BACK_S;

/// So many ticks of a run are timed at most.
pub const MOST_TIMED: usize = 1_000_000;

/// A log of more records would not fit into memory.
const MOST_RECORDS: u64 = 4_000_000;

/// A run in progress, advanced tick by tick.
#[derive(Debug)]
pub struct Episode {
    scenario: Scenario,
    /// The robot as it is.
    model: Robot,
    /// The robot as the controller knows it.
    known: Robot,
    ground: Terrain,
    /// Which contact points its feet have.
    feet: FeetMotion,
    controller: Box<dyn Controller>,
    plant: Box<dyn Plant>,
    sink: Option<Box<dyn Sink>>,
    sensors: Sensors,
    joint_limits: JointLimits,
    truth: Sensed,
    told: Sensed,
    /// Dynamics of the true state, where the physics does not give them.
    dynamics: Option<Dynamics>,
    /// Dynamics of the state that the controller is told, where state or robot are not the true ones.
    estimated: Option<Dynamics>,
    columns: Columns,
    record: Vec<f64>,
    log: Log,
    meter: Meter,
    measuring: Measuring,
    /// The measures of balance in the record of the tick before.
    balance_before: Vec<f64>,
    input_hash: u128,
    result: record::Hasher,
    ticks: u64,
    tick: u64,
    fall: Option<Fall>,
    program: ProgramCounts,
    /// Time and constraints of the first infeasible program.
    first_infeasible: Option<f64>,
    conflict: Vec<Condition>,
    iterations: u64,
    clock: Option<fn() -> f64>,
    tick_times: Vec<f64>,
}

impl Episode {
    /// A run of `scenario` with the robot that the controller knows as `model`; `samples` are the rows of the CoM file, where
    /// the scenario names one.
    ///
    /// # Errors
    /// The start pose cannot be taken, a push names an unknown body, the CoM trajectory is not valid, or the model is
    /// none that the controller can drive.
    pub fn new(scenario: &Scenario, model: &Robot, samples: &[[f64; 3]]) -> Result<Self, Error> {
        Self::with(scenario, model, Parts { samples: samples.to_vec(), ..Parts::default() })
    }

    /// As [`Episode::new`], with `parts` in place of what the scenario says.
    ///
    /// # Errors
    /// Those of [`Episode::new`]; a physics whose state is none of the robot's, or two channels of one name.
    pub fn with(scenario: &Scenario, model: &Robot, parts: Parts) -> Result<Self, Error> {
        let scenario = &fitted(scenario, model)?;
        check_joints(scenario, model)?;
        let momentum = parts.controller.is_none() && scenario.controller.kind == ControllerKind::Momentum;
        match parts.generator {
            None if momentum => check_model(model, scenario.reference.generator)?,
            // It sees two feet (Observation).
            Some(_) if parts.controller.is_none() => check_feet(model)?,
            _ => {}
        }
        let across = scenario.ground.cross_slope_deg;
        if model.is_planar() && across != 0.0 {
            let problem = format!("found {across}; valid is 0 for a planar robot");
            return Err(Error::invalid("ground.cross_slope_deg", problem));
        }
        let (known, error) = (model, scenario.simulation.model_error);
        let model = model_error::real(known, error, scenario.seed);
        let plant = match parts.plant {
            Some(plant) => plant,
            None => {
                let q = start_pose(scenario, known, &scenario.terrain(known))?;
                Box::new(scenario.simulator(&model, q.as_slice())?)
            }
        };
        let mut truth = Sensed::new(&model);
        plant.read(&mut truth);
        truth.check(&model)?;
        let mut dynamics = plant.dynamics().is_none().then(|| Dynamics::new(&model));
        if let Some(dynamics) = &mut dynamics {
            dynamics.update(&model, &truth.q, &truth.v);
        }
        let ground = scenario.terrain(&model);
        let robot = (&model, of_truth(&dynamics, plant.as_ref()));
        if let Some(fall) = diagnosis::fall(scenario, robot, &ground, &truth, true) {
            let problem = format!("the robot has fallen before it starts: {}", diagnosis::definition(&fall));
            return Err(Error::invalid("start", problem));
        }
        let controller = match (parts.controller, parts.generator) {
            (Some(controller), _) => controller,
            (None, Some(generator)) => Box::new(scenario.momentum_controller_after(known, generator)),
            (None, None) if scenario.controller.kind == ControllerKind::Hold => {
                Box::new(HoldController::new(&scenario.controller.hold, known, &truth)?)
            }
            (None, None) => Box::new(scenario.momentum_controller(known, &parts.samples, &truth)?),
        };
        let meter = Meter::new(scenario, &model);
        let columns = Columns::new(record::channels(&model, controller.as_ref(), plant.as_ref()))?;
        let period = scenario.controller.period_s;
        let ticks = (scenario.duration_s / period).round() as u64;
        if parts.sink.is_none() && ticks > MOST_RECORDS {
            let problem = format!(
                "found a run of {ticks} control periods, whose log does not fit into memory; valid are at most {MOST_RECORDS}, or a \
                 log that goes to a file while the run goes on"
            );
            return Err(Error::invalid("duration_s", problem));
        }
        let log = match parts.sink {
            Some(_) => Log::of_latest(columns.clone(), &model, (KEPT_S / period).ceil() as usize),
            None => Log::new(columns.clone(), &model, ticks as usize),
        };
        let ideal = scenario.simulation.sensors.are_ideal() && error == 0.0;
        Ok(Self {
            sensors: Sensors::new(&scenario.simulation.sensors, &model, period, scenario.seed, &truth),
            joint_limits: JointLimits::new(&model),
            dynamics,
            estimated: (!ideal).then(|| Dynamics::new(known)),
            record: vec![0.0; columns.width()],
            balance_before: vec![0.0; columns.range(Field::Balance).len()],
            meter,
            measuring: Measuring::new(scenario, &model, &columns),
            log,
            result: record::Hasher::new(&columns),
            columns,
            input_hash: input_hash(scenario, known, &parts.samples),
            ticks,
            tick: 0,
            fall: None,
            program: ProgramCounts::default(),
            first_infeasible: None,
            conflict: Vec::with_capacity(controller.program().map_or(0, |program| program.conflict.capacity())),
            iterations: 0,
            clock: parts.clock,
            tick_times: Vec::with_capacity(parts.clock.map_or(0, |_| MOST_TIMED.min(ticks as usize))),
            told: truth.clone(),
            truth,
            ground,
            feet: FeetMotion::new(&model),
            scenario: scenario.clone(),
            known: known.clone(),
            model,
            controller,
            plant,
            sink: parts.sink,
        })
    }

    /// One control tick and the physics up to the next. Returns whether the run goes on. Allocates nothing, unless the sink does.
    ///
    /// # Errors
    /// The sink could not take the record, or the values that a controller or a physics gives for its channels are not as many.
    pub fn advance(&mut self) -> Result<bool, Error> {
        if self.tick >= self.ticks || self.fall.is_some() {
            return Ok(false);
        }
        self.sensors.read(&self.truth, &mut self.told);
        self.control();
        self.write_down()?;

        let before = self.has_balance().then(|| self.moment());
        let health = self.plant.apply(self.controller.command(), self.scenario.controller.period_s);
        self.look();
        self.joint_limits.watch(&self.model, &self.truth, self.controller.command());
        self.write_down_what_came_of_it(before)?;
        self.tick += 1;
        let robot = (&self.model, self.dynamics());
        self.fall = diagnosis::fall(&self.scenario, robot, &self.ground, &self.truth, health == Health::Sound);
        Ok(self.fall.is_none() && self.tick < self.ticks)
    }

    /// Takes the true state from the physics.
    fn look(&mut self) {
        self.plant.read(&mut self.truth);
        if let Some(dynamics) = &mut self.dynamics {
            dynamics.update(&self.model, &self.truth.q, &self.truth.v);
        }
    }

    /// The control tick.
    fn control(&mut self) {
        let begin = self.clock.map(|clock| clock());
        match &mut self.estimated {
            Some(dynamics) => {
                dynamics.update(&self.known, &self.told.q, &self.told.v);
                self.controller.tick(&self.told, dynamics);
            }
            // Those of the true state are those of what is told.
            None => {
                let dynamics = of_truth(&self.dynamics, self.plant.as_ref());
                self.controller.tick(&self.told, dynamics);
            }
        }
        if let (Some(begin), Some(clock)) = (begin, self.clock)
            && self.tick_times.len() < self.tick_times.capacity()
        {
            self.tick_times.push(clock() - begin);
        }
        let Some(tick) = self.controller.program() else { return };
        let program = &mut self.program;
        program.solves += u64::from(tick.solves);
        program.infeasible += u64::from(tick.status == Status::Infeasible);
        program.fallbacks += u64::from(tick.fallback != Fallback::None);
        program.iterations_max = program.iterations_max.max(tick.iterations);
        self.iterations += u64::from(tick.iterations);
        if tick.status == Status::Infeasible && self.first_infeasible.is_none() {
            self.first_infeasible = Some(self.truth.time);
            self.conflict.extend_from_slice(&tick.conflict);
        }
    }

    /// Begins the tick's record: the true state, the references, and what the controller made of them.
    fn write_down(&mut self) -> Result<(), Error> {
        self.record.fill(0.0);
        let dynamics = of_truth(&self.dynamics, self.plant.as_ref());
        let mut record = Record::new(&self.columns, &mut self.record);
        record::state(&mut record, &self.model, &self.truth, dynamics);
        record.set(Field::Torque, self.controller.command().torque.iter().copied());
        if let Some(reference) = self.controller.reference() {
            record::reference(&mut record, &self.model, &self.feet, dynamics, reference);
        }
        self.controller.record(&mut record);
        record.check()
    }

    /// Completes the tick's record with what the physics did, and with the measures of balance, of which some are of the motion
    /// since `before`.
    fn write_down_what_came_of_it(&mut self, before: Option<Moment>) -> Result<(), Error> {
        let mut record = Record::new(&self.columns, &mut self.record);
        self.plant.record(&mut record);
        record.check()?;
        if let Some(before) = before {
            self.write_down_balance(&before);
        }
        self.log.push(&self.record);
        self.measuring.take(&self.record);
        self.result.add(&self.record);
        match &mut self.sink {
            Some(sink) => sink.record(&self.columns, &self.record),
            None => Ok(()),
        }
    }

    fn has_balance(&self) -> bool {
        !self.balance_before.is_empty()
    }

    /// Place and momentum of the robot as a whole.
    fn moment(&self) -> Moment {
        Moment::new(self.truth.time, &self.model, self.dynamics(), &self.truth.v)
    }

    fn write_down_balance(&mut self, before: &Moment) {
        let moment = self.moment();
        let dynamics = of_truth(&self.dynamics, self.plant.as_ref());
        let zmp = self.meter.zmp(&self.model, dynamics, before, &moment);
        let mut record = Record::new(&self.columns, &mut self.record);
        let measures = self.meter.of(|field| record.get(field));
        let [cop_reference, xcom_reference] = self
            .controller
            .reference()
            .map_or([[0.0; 2]; 2], |reference| [reference.cop_reference, reference.xcom_reference]);
        let before = &self.balance_before;
        let places = [Some(cop_reference), Some(xcom_reference), measures.cop, zmp, measures.wanted_zmp, measures.cmp];
        // In flight there are none: they stay what they were. In space the same along y come after those of all robots.
        let kept = |axis: usize| {
            places.iter().enumerate().map(move |(k, place)| place.map_or(before[8 * axis + k], |place| place[axis]))
        };
        let rest = [measures.margin().unwrap_or(before[6]), measures.steps().map_or(-1.0, f64::from)];
        let across = (before.len() > 8).then(|| kept(1)).into_iter().flatten();
        record.set(Field::Balance, kept(0).chain(rest).chain(across));
        self.balance_before.copy_from_slice(record.get(Field::Balance));
    }

    /// Gives a setting another value, which acts from the next tick on: `set("reference.walker.speed_mps", "0.8")`. The value is
    /// checked as in a file, and is part of the run's input hash. [`crate::settings::Setting::fixed`] tells which settings may not
    /// change while a run goes on.
    ///
    /// # Errors
    /// There is no such setting, it may not change, or its value is not valid; then nothing changes.
    pub fn set(&mut self, path: &str, value: &str) -> Result<(), Error> {
        let scenario = crate::scenario_file::change(&self.scenario, path, value)?;
        let ground = scenario.terrain(&self.model);
        self.plant.change(&scenario.simulation, &scenario.pushes, &ground)?;
        self.look();
        let settings = crate::wearer::controller(&scenario, &self.known);
        let believed = scenario.believed_terrain(&self.known);
        self.controller.change(&settings, &scenario.fitted_reference(&self.known), &believed);
        self.ground = ground;
        self.input_hash = record::changed(self.input_hash, self.tick, path, value);
        self.meter = Meter::new(&scenario, &self.model);
        self.measuring.change(&scenario, &self.model);
        self.scenario = scenario;
        Ok(())
    }

    /// Time simulated so far [s].
    pub fn time(&self) -> f64 {
        self.truth.time
    }

    /// The true state, and what the contact points truly feel.
    pub fn truth(&self) -> &Sensed {
        &self.truth
    }

    /// What the controller was told in the latest tick.
    pub fn told(&self) -> &Sensed {
        &self.told
    }

    /// Dynamics of the true robot in its present state.
    pub fn dynamics(&self) -> &Dynamics {
        of_truth(&self.dynamics, self.plant.as_ref())
    }

    /// The controller, with its latest command and reference, its tasks and limits.
    pub fn controller(&self) -> &dyn Controller {
        self.controller.as_ref()
    }

    /// The physics.
    pub fn plant(&self) -> &dyn Plant {
        self.plant.as_ref()
    }

    /// The measures of balance of the latest record; none before the first.
    pub fn balance(&self) -> Option<Measures> {
        self.log.len().checked_sub(1).map(|latest| self.meter.at(&self.log, latest))
    }

    /// The records so far; where a sink takes them, the latest.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// How the robot fell, if it did.
    pub fn fall(&self) -> Option<&Fall> {
        self.fall.as_ref()
    }

    /// Ends the run and takes its figures.
    ///
    /// # Errors
    /// The sink could not be finished.
    pub fn finish(mut self, wall_s: f64) -> Result<Run, Error> {
        let result_hash = self.result.digest();
        if let Some(sink) = &mut self.sink {
            sink.finish(&Hashes { input: self.input_hash, result: result_hash })?;
        }
        let outcome = match self.fall {
            Some(fall) => Outcome::Fell(fall),
            None if self.tick < self.ticks => Outcome::Stopped,
            None => Outcome::Completed,
        };
        let (tasks, limits) = (self.controller.tasks().to_vec(), self.controller.limits().to_vec());
        let diagnosis = match &outcome {
            Outcome::Fell(fall) => {
                Some(diagnosis::diagnose(&self.scenario, &self.model, fall, &self.log, (&tasks, &limits)))
            }
            Outcome::Completed | Outcome::Stopped => None,
        };
        let mut program = self.program;
        program.size = self.controller.program().map_or([0; 2], |program| program.size);
        program.first_infeasible = self.first_infeasible.map(|time| {
            let mut conflict = self.conflict;
            conflict.sort_by_cached_key(|condition| condition.in_words(&self.model));
            conflict.dedup();
            (time, conflict)
        });
        program.iterations_mean = self.iterations as f64 / self.tick.max(1) as f64;
        Ok(Run {
            metrics: self.measuring.finish(),
            audit: self.plant.audit().cloned(),
            limits_passed: self.joint_limits.in_words(&self.model),
            simulated_s: self.tick as f64 * self.scenario.controller.period_s,
            program,
            timing: Timing { ticks_s: self.tick_times, wall_s },
            input_hash: self.input_hash,
            result_hash,
            tasks,
            limits,
            scenario: self.scenario,
            model: self.model,
            known: self.known,
            outcome,
            reason: diagnosis.as_ref().map(|diagnosis| diagnosis.sentence.clone()),
            diagnosis,
            log: self.log,
        })
    }
}

/// Whether the settings by joint name joints of `model`.
fn check_joints(scenario: &Scenario, model: &Robot) -> Result<(), Error> {
    let controller = &scenario.controller;
    let checks = [
        ("controller.weights.posture", controller.weights.posture.check(model)),
        ("controller.planner.posture_gain", controller.planner.posture_gain.check(model)),
        ("controller.planner.posture", controller.planner.posture.positions(model).map(|_| ())),
    ];
    checks.into_iter().try_for_each(|(path, check)| check.map_err(|problem| Error::invalid(path, problem)))
}

/// Dynamics of the true state: the episode's `own`, or those of the `plant`.
fn of_truth<'a>(own: &'a Option<Dynamics>, plant: &'a dyn Plant) -> &'a Dynamics {
    own.as_ref().or(plant.dynamics()).expect("either has them")
}

/// Runs `scenario` with `model` to its end, or until `stop` says so; see [`Episode::new`].
///
/// # Errors
/// Those of [`Episode::new`].
pub fn run(
    scenario: &Scenario,
    model: &Robot,
    samples: &[[f64; 3]],
    stop: impl FnMut(f64) -> bool,
) -> Result<Run, Error> {
    run_with(scenario, model, Parts { samples: samples.to_vec(), ..Parts::default() }, stop)
}

/// As [`run`], with `parts` in place of what the scenario says.
///
/// # Errors
/// Those of [`Episode::with`], [`Episode::advance`] and [`Episode::finish`].
pub fn run_with(
    scenario: &Scenario,
    model: &Robot,
    parts: Parts,
    mut stop: impl FnMut(f64) -> bool,
) -> Result<Run, Error> {
    let clock = parts.clock;
    let begin = clock.map(|clock| clock());
    let mut episode = Episode::with(scenario, model, parts)?;
    while episode.advance()? && !stop(episode.time()) {}
    let wall_s = clock.zip(begin).map_or(0.0, |(clock, begin)| clock() - begin);
    episode.finish(wall_s)
}

/// Hash of everything that a run depends on, the settings that are in use among it: of what is in the files that a scenario names, not of where they lie.
pub fn input_hash(scenario: &Scenario, model: &Robot, samples: &[[f64; 3]]) -> u128 {
    let mut scenario = scenario.clone();
    for name in [&mut scenario.name, &mut scenario.description, &mut scenario.model] {
        name.clear();
    }
    scenario.reference.com.file.clear();
    let mut hasher = xxhash_rust::xxh3::Xxh3::new();
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    // Where nothing is free, nothing holds it.
    let posture = &mut scenario.controller.tracking.posture;
    if *posture == PostureTracking::Free && free_joints(model).is_empty() {
        *posture = PostureTracking::Off;
    }
    let mut tree = settings::in_use(&scenario);
    settings::remove_later(&mut tree);
    hasher.update(tree.to_string().as_bytes());
    hasher.update(model.to_toml().as_bytes());
    for value in samples.as_flattened() {
        hasher.update(&value.to_bits().to_le_bytes());
    }
    hasher.digest128()
}
