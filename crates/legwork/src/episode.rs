//! One run: the only file that sees both the controller and the simulator.

use std::time::Instant;

use legwork_qp::Status;
use legwork_rbd::{Dynamics, Model};

use crate::balance::{Meter, Moment};
use crate::control::{Controller, Estimate, check_model};
use crate::diagnosis::{self, Diagnosis, Fall};
use crate::error::Error;
use crate::log::{Field, Log};
use crate::metrics::{self, Metrics};
use crate::qp::tasks::momentum;
use crate::qp::{Condition, Layout};
use crate::scenario::Scenario;
use crate::sim::Simulator;
use crate::sim::audit::Audit;
use crate::sim::model_error;
use crate::sim::sensors::Sensors;
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
    /// Duration of each control tick [s]; without the dynamics of the state where the sensors are ideal, as the simulator
    /// has them already.
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
    pub model: Model,
    /// The robot as the controller knows it; the same but for `simulation.model_error`.
    pub known: Model,
    /// The program's layout, with the names of its limits.
    pub layout: Layout,
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
    /// The simulator's books.
    pub audit: Audit,
    /// How the programs went.
    pub program: ProgramCounts,
    /// How long things took.
    pub timing: Timing,
    /// Hash of scenario, model and CoM samples.
    pub input_hash: u128,
    /// Hash of the log.
    pub result_hash: u128,
}

/// A run in progress, advanced tick by tick.
#[derive(Clone, Debug)]
pub struct Episode {
    scenario: Scenario,
    /// The robot as it is.
    model: Model,
    /// The robot as the controller knows it.
    known: Model,
    controller: Controller,
    simulator: Simulator,
    sensors: Sensors,
    truth: Estimate,
    estimate: Estimate,
    /// Dynamics of the estimate, where state or robot are not the true ones.
    estimated: Option<Dynamics>,
    log: Log,
    /// Measures the balance of each tick, where the log has columns for it.
    meter: Option<Meter>,
    input_hash: u128,
    steps_per_tick: u64,
    ticks: u64,
    tick: u64,
    fall: Option<Fall>,
    program: ProgramCounts,
    /// Time and constraints of the first infeasible program.
    first_infeasible: Option<f64>,
    conflict: Vec<Condition>,
    iterations: u64,
    tick_times: Vec<f64>,
}

impl Episode {
    /// A run of `scenario` with the robot that the controller knows as `model`; `samples` are the rows of the CoM file, where
    /// the scenario names one.
    ///
    /// # Errors
    /// The start pose cannot be taken, a push names an unknown body, the CoM trajectory is not valid, or the model is
    /// none that the controller can drive.
    pub fn new(scenario: &Scenario, model: &Model, samples: &[[f64; 3]]) -> Result<Self, Error> {
        check_model(model, scenario.reference.generator)?;
        let ground = Terrain::of(scenario, model);
        let q = start_pose(scenario, model, &ground)?;
        let (known, error) = (model, scenario.simulation.model_error);
        let model = model_error::real(known, error, scenario.seed);
        let simulator = Simulator::new(scenario, &model, q.as_slice())?;
        let touching = (0..model.contacts.len()).map(|contact| simulator.touching(contact)).collect();
        let truth = Estimate {
            time: 0.0,
            q: simulator.q().to_vec(),
            v: simulator.v().to_vec(),
            touching,
            load: vec![0.0; model.contacts.len()],
        };
        let controller = Controller::new(scenario, known, samples, &truth)?;
        let period = scenario.controller.period_s;
        let ticks = (scenario.duration_s / period).round() as u64;
        let log = Log::new(&model, controller.layout(), ticks as usize);
        Ok(Self {
            sensors: Sensors::new(&scenario.simulation.sensors, &model, period, scenario.seed, &truth),
            meter: (!log.range(Field::Balance).is_empty()).then(|| Meter::new(scenario, &model)),
            log,
            input_hash: input_hash(scenario, known, samples),
            steps_per_tick: (period / scenario.simulation.period_s).round() as u64,
            ticks,
            tick: 0,
            fall: None,
            program: ProgramCounts::default(),
            first_infeasible: None,
            conflict: Vec::with_capacity(controller.layout().variables() + controller.layout().rows()),
            iterations: 0,
            tick_times: Vec::with_capacity(ticks as usize),
            estimate: truth.clone(),
            estimated: (!scenario.simulation.sensors.are_ideal() || error > 0.0).then(|| Dynamics::new(known)),
            truth,
            scenario: scenario.clone(),
            known: known.clone(),
            model,
            controller,
            simulator,
        })
    }

    /// One control tick and the physics steps up to the next. Returns whether the run goes on. Allocates nothing.
    pub fn advance(&mut self) -> bool {
        if self.tick >= self.ticks || self.fall.is_some() {
            return false;
        }
        self.sense();
        let begin = Instant::now();
        match &mut self.estimated {
            Some(dynamics) => {
                dynamics.update(&self.known, &self.estimate.q, &self.estimate.v);
                self.controller.tick(&self.estimate, dynamics);
            }
            // The simulator has just computed them for the same state and robot.
            None => {
                self.controller.tick(&self.estimate, self.simulator.dynamics());
            }
        }
        self.tick_times.push(begin.elapsed().as_secs_f64());
        self.record();

        let before = self.meter.is_some().then(|| self.moment());
        let contacts = self.simulator.contact_forces().len();
        let share = 1.0 / self.steps_per_tick as f64;
        let mut sound = true;
        for _ in 0..self.steps_per_tick {
            sound = self.simulator.step(&self.controller.latest().solution.tau);
            if !sound {
                break;
            }
            let simulator = &self.simulator;
            let mut record = self.log.last_mut();
            record.accumulate(Field::GrfSimulated, (0..contacts).map(|k| share * simulator.contact_forces()[k]));
            record.set(Field::TorqueApplied, simulator.applied_torques().iter().copied());
            let report = simulator.contact_report();
            let period = self.scenario.simulation.period_s;
            record.set(Field::Contact, [f64::from(report.sweeps), report.residual / period]);
        }
        if let Some(before) = before {
            self.record_balance(&before);
        }
        self.tick += 1;
        self.fall = diagnosis::fall(&self.scenario, &self.model, &self.simulator, sound);
        self.fall.is_none() && self.tick < self.ticks
    }

    fn sense(&mut self) {
        self.truth.time = self.simulator.time();
        self.truth.q.copy_from_slice(self.simulator.q());
        self.truth.v.copy_from_slice(self.simulator.v());
        for contact in 0..self.truth.touching.len() {
            self.truth.touching[contact] = self.simulator.touching(contact);
        }
        if let Some(before) = self.log.len().checked_sub(1) {
            let axes = self.model.linear_axes().len();
            let forces = self.log.get(before, Field::GrfSimulated).iter().skip(axes - 1).step_by(axes);
            self.truth.load.iter_mut().zip(forces).for_each(|(load, force)| *load = *force);
        }
        self.sensors.read(&self.truth, &mut self.estimate);
    }

    /// Writes the tick's record: the true state, the references and what the program made of them.
    fn record(&mut self) {
        let axes = self.model.linear_axes();
        let dynamics = self.simulator.dynamics();
        let reference = self.controller.reference();
        let tick = self.controller.latest();
        let places = |contacts: &[usize]| {
            let sum: nalgebra::Vector3<f64> = contacts.iter().map(|&contact| dynamics.contact_positions[contact]).sum();
            sum / contacts.len() as f64
        };
        // All of the log's feet are the middles of their contact points, also where the reference is of the toe.
        let feet = [0, 1].map(|foot| {
            let mut point = reference.feet[foot].point;
            if reference.footing[foot].is_on_an_end() {
                let motion = self.controller.feet();
                point.position += places(motion.contacts(foot)) - places(motion.points(foot, reference.footing[foot]));
            }
            point
        });
        let project = |vector: nalgebra::Vector3<f64>| axes.iter().map(move |axis| axis.dot(&vector));
        let motion = |point: &crate::reference::PointReference| {
            let (p, v, a) = (point.position, point.velocity, point.acceleration);
            project(p).chain(project(v)).chain(project(a))
        };

        let mut record = self.log.push();
        record.set(Field::Time, [self.truth.time]);
        record.set(Field::Q, self.truth.q.iter().copied());
        record.set(Field::V, self.truth.v.iter().copied());
        record.set(Field::Torque, tick.solution.tau.iter().copied());
        record.set(Field::Grf, tick.solution.rho.iter().copied());
        record.set(Field::Com, project(dynamics.com));
        record.set(Field::ComVelocity, project(dynamics.com_velocity));
        record.set(Field::ComReference, motion(&reference.chest.point));
        record.set(Field::Xcom, [self.controller.xcom()]);
        // About −y, which is the plane's only axis.
        let (row, sign) = if self.model.is_planar() { (0, 1.0) } else { (1, -1.0) };
        let turning = (0..self.truth.v.len()).map(|j| dynamics.torso_jacobian[(row, j)] * self.truth.v[j]).sum::<f64>();
        record.set(Field::Torso, [dynamics.torso_angle(&self.model), sign * turning]);
        let torso = &reference.chest.angle;
        record.set(Field::TorsoReference, [torso.angle, torso.velocity, torso.acceleration]);
        record.set(Field::Feet, dynamics.contact_positions.iter().flat_map(|point| project(*point)));
        record.set(Field::FeetReference, feet.iter().flat_map(motion));
        record.set(Field::Swing, self.controller.swing().map_or([-1.0, -1.0], |(foot, since)| [foot as f64, since]));
        record.set(Field::Touching, self.truth.touching.iter().map(|&touching| f64::from(u8::from(touching))));
        record.set(Field::MomentumRateGoal, self.controller.planner().goal(momentum::NAME).iter().copied());
        record.set(Field::Acceleration, tick.solution.qdd.iter().copied());
        record.set(Field::Slack, tick.solution.slack.iter().copied());
        record.set(Field::ActiveLimit, tick.active.iter().map(|&side| f64::from(side)));
        record.set(Field::Braking, tick.braking.iter().copied());
        let status = tick.status as u8;
        let numbers = [u32::from(status), tick.fallback as u32, tick.iterations, tick.solves];
        record.set(Field::Program, numbers.map(f64::from));
        let audit = self.simulator.audit();
        record.set(Field::Energy, [dynamics.kinetic_energy, dynamics.potential_energy, audit.energy_error_j]);

        let program = &mut self.program;
        program.solves += u64::from(tick.solves);
        program.infeasible += u64::from(tick.status == Status::Infeasible);
        program.fallbacks += u64::from(tick.fallback != crate::control::Fallback::None);
        program.iterations_max = program.iterations_max.max(tick.iterations);
        self.iterations += u64::from(tick.iterations);
        if tick.status == Status::Infeasible && self.first_infeasible.is_none() {
            self.first_infeasible = Some(self.truth.time);
            self.conflict.extend_from_slice(&tick.conflict);
        }
    }

    /// Place and momentum of the robot as a whole.
    fn moment(&self) -> Moment {
        Moment::new(self.simulator.time(), &self.model, self.simulator.dynamics(), self.simulator.v())
    }

    /// Completes the tick's record with the measures of balance, of which some are of the motion since `before`.
    fn record_balance(&mut self, before: &Moment) {
        let Some(meter) = &self.meter else { return };
        let zmp = meter.zmp(&self.model, self.simulator.dynamics(), before, &self.moment());
        let latest = self.log.len() - 1;
        let measures = meter.at(&self.log, latest);
        let [cop_reference, xcom_reference] = self.controller.balance();
        let found = [measures.cop, zmp, measures.wanted_zmp, measures.cmp, measures.margin()];
        // In flight there are none: they stay what they were.
        let kept = latest.checked_sub(1).map(|earlier| self.log.get(earlier, Field::Balance));
        let kept: [f64; 5] = std::array::from_fn(|k| found[k].unwrap_or_else(|| kept.map_or(0.0, |kept| kept[k + 2])));
        let steps = measures.steps().map_or(-1.0, f64::from);
        let places = [cop_reference, xcom_reference].into_iter().chain(kept);
        self.log.last_mut().set(Field::Balance, places.chain([steps]));
    }

    /// Asks the walker for another speed from now on [m/s].
    ///
    /// # Errors
    /// No finite number, or a speed whose steps the legs do not reach, as in a scenario.
    pub fn command_speed(&mut self, speed: f64) -> Result<(), Error> {
        let mut asked = self.scenario.clone();
        (asked.reference.walker.speeds, asked.reference.walker.speed_mps) = (Vec::new(), speed);
        match crate::scenario_file::checks::walker_conflict(&asked) {
            _ if !speed.is_finite() => {
                Err(Error::invalid("reference.walker.speed_mps", format!("found {speed}; valid is a finite number")))
            }
            Some((_, problem)) => Err(Error::invalid("reference.walker.speed_mps", problem)),
            None => {
                self.controller.command_speed(speed);
                Ok(())
            }
        }
    }

    /// Time simulated so far [s].
    pub fn time(&self) -> f64 {
        self.simulator.time()
    }

    /// Ends the run and takes its figures.
    pub fn finish(self, wall_s: f64) -> Run {
        let outcome = match self.fall {
            Some(fall) => Outcome::Fell(fall),
            None if self.tick < self.ticks => Outcome::Stopped,
            None => Outcome::Completed,
        };
        let diagnosis = match &outcome {
            Outcome::Fell(fall) => {
                let layout = self.controller.layout();
                Some(diagnosis::diagnose(&self.scenario, &self.model, fall, &self.log, layout))
            }
            Outcome::Completed | Outcome::Stopped => None,
        };
        let mut program = self.program;
        program.first_infeasible = self.first_infeasible.map(|time| {
            let mut conflict = self.conflict;
            conflict.sort_by_cached_key(|condition| condition.in_words(&self.model));
            conflict.dedup();
            (time, conflict)
        });
        program.iterations_mean = self.iterations as f64 / self.tick.max(1) as f64;
        Run {
            metrics: metrics::measure(&self.scenario, &self.model, &self.log),
            audit: self.simulator.audit().clone(),
            program,
            timing: Timing { ticks_s: self.tick_times, wall_s },
            input_hash: self.input_hash,
            result_hash: self.log.hash(),
            layout: self.controller.layout().clone(),
            scenario: self.scenario,
            model: self.model,
            known: self.known,
            outcome,
            reason: diagnosis.as_ref().map(|diagnosis| diagnosis.sentence.clone()),
            diagnosis,
            log: self.log,
        }
    }
}

/// Runs `scenario` with `model` to its end, or until `stop` says so; see [`Episode::new`].
///
/// # Errors
/// Those of [`Episode::new`].
pub fn run(
    scenario: &Scenario,
    model: &Model,
    samples: &[[f64; 3]],
    mut stop: impl FnMut(f64) -> bool,
) -> Result<Run, Error> {
    let begin = Instant::now();
    let mut episode = Episode::new(scenario, model, samples)?;
    while episode.advance() && !stop(episode.time()) {}
    Ok(episode.finish(begin.elapsed().as_secs_f64()))
}

/// Hash of everything that a run depends on: of what is in the files that a scenario names, not of where they lie.
pub(crate) fn input_hash(scenario: &Scenario, model: &Model, samples: &[[f64; 3]]) -> u128 {
    let mut scenario = scenario.clone();
    for name in [&mut scenario.name, &mut scenario.description, &mut scenario.model] {
        name.clear();
    }
    scenario.reference.com.file.clear();
    let mut hasher = xxhash_rust::xxh3::Xxh3::new();
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    hasher.update(toml::to_string(&scenario).expect("a scenario is plain data").as_bytes());
    hasher.update(model.to_toml().as_bytes());
    for value in samples.as_flattened() {
        hasher.update(&value.to_bits().to_le_bytes());
    }
    hasher.digest128()
}
