//! How the [`crate::metrics`] of a run are taken: sums over its records, one after the other, so that no record need be kept.

use crate::balance::Meter;
use crate::channel::{Columns, Field};
use crate::log::{Log, middle};
use crate::metrics::{JointUse, MeanPeak, Metrics};
use crate::robot::Robot;
use crate::scenario::{CommandedSpeed, MetricsSettings, Scenario};

/// A robot that is slower on the mean does not travel, and has no cost of transport [m/s].
const TRAVELS: f64 = 0.05;

/// Takes the metrics of a run from its records.
#[derive(Clone, Debug)]
pub struct Measuring {
    columns: Columns,
    settings: MetricsSettings,
    weight: f64,
    meter: Meter,
    /// The foot of each contact point.
    foot_of: Vec<usize>,
    joints: Vec<Joint>,
    /// Whether `metrics.from_s` has come.
    counts: bool,
    counted: Counted,
    /// Time of the latest step's trigger [s]; -1 before the first.
    stepped: f64,
    /// When the first push begins [s].
    push: Option<f64>,
    recovery: Option<Recovery>,
    steady: Option<Steady>,
    /// In the latest record.
    place: Place,
}

/// Time [s], and the centre of mass along x [m].
#[derive(Clone, Copy, Debug, Default)]
struct Place([f64; 2]);

impl Place {
    /// Displacement of the CoM over time up to `last` [m/s]; none without time.
    fn speed_to(self, last: Self) -> Option<f64> {
        let [time, way] = [0, 1].map(|k| last.0[k] - self.0[k]);
        (time > 0.0).then(|| way / time)
    }
}

/// What mean and peak are made of.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    sum: f64,
    count: u64,
    peak: f64,
}

impl Sums {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
        self.peak = self.peak.max(value);
    }

    /// None of nothing.
    fn pair(self) -> Option<MeanPeak> {
        (self.count > 0).then(|| MeanPeak { mean: self.sum / self.count as f64, peak: self.peak })
    }
}

/// An actuated joint: its name, and the columns of its applied torque and its speed.
#[derive(Clone, Debug)]
struct Joint {
    name: String,
    torque: usize,
    speed: usize,
}

/// Sums over the ticks that count: from `metrics.from_s` on, and before it comes all of them, for a run that ends before.
#[derive(Clone, Debug, Default)]
struct Counted {
    ticks: u64,
    begin: Place,
    com_error: Sums,
    com_error_vertical: Sums,
    feet_error: Sums,
    torso: Sums,
    torque: Sums,
    grf: Sums,
    grf_simulated: Sums,
    u2: Sums,
    swinging: u64,
    steps: u32,
    xcom_error: Sums,
    /// Ticks with a support, those with the XcoM outside of it, and those in which no number of steps is enough.
    supported: u64,
    outside: u64,
    uncapturable: u64,
    margin_min: Option<f64>,
    capture_steps: Option<u32>,
    cmp_offset: Sums,
    /// Squared torque, speed and power of each joint.
    joints: Vec<[Sums; 3]>,
}

/// How a robot recovers from the first push.
#[derive(Clone, Copy, Debug, Default)]
struct Recovery {
    /// Largest horizontal CoM error so far [m].
    distance: f64,
    /// Whether the CoM error is too large.
    out: bool,
    /// Time since the beginning of the push when it had been too large for the last time [s].
    time: f64,
}

/// The walk at a constant commanded speed.
#[derive(Clone, Copy, Debug)]
struct Steady {
    commanded: CommandedSpeed,
    begin: Option<Place>,
    com_error: Sums,
}

impl Steady {
    fn new(scenario: &Scenario) -> Option<Self> {
        let commanded = scenario.reference.commanded_speed().filter(|commanded| commanded.speed_mps != 0.0)?;
        Some(Self { commanded, begin: None, com_error: Sums::default() })
    }
}

impl Measuring {
    /// Before the first record of a run of `scenario` with `model`; a record has the `columns`.
    pub fn new(scenario: &Scenario, model: &Robot, columns: &Columns) -> Self {
        let joints = joints(columns);
        Self {
            settings: scenario.metrics.clone(),
            weight: model.total_mass() * model.gravity,
            meter: Meter::new(scenario, model),
            foot_of: model.foot_of.clone(),
            counts: false,
            counted: Counted { joints: vec![Default::default(); joints.len()], ..Counted::default() },
            joints,
            stepped: -1.0,
            push: first_push(scenario),
            recovery: None,
            steady: Steady::new(scenario),
            place: Place::default(),
            columns: columns.clone(),
        }
    }

    /// From the next record on the run is one of `scenario`. Another first push begins its recovery anew, and a walk whose commanded
    /// speed changes is at no constant one.
    pub fn change(&mut self, scenario: &Scenario, model: &Robot) {
        self.meter = Meter::new(scenario, model);
        let push = first_push(scenario);
        if self.push != push {
            (self.push, self.recovery) = (push, None);
        }
        let commanded = Steady::new(scenario).map(|steady| steady.commanded);
        self.steady = self.steady.filter(|steady| Some(steady.commanded) == commanded);
    }

    /// Takes a record, its `values` in the order of the columns. Allocates nothing.
    pub fn take(&mut self, values: &[f64]) {
        let Self { columns, settings, counted, .. } = self;
        let get = |field| &values[columns.range(field)];
        let (time, com) = (get(Field::Time)[0], get(Field::Com));
        let error = com_error(com, get(Field::ComReference));
        let offset = |axis: usize| (com[axis] - get(Field::ComReference)[axis]).abs();
        let late = time >= settings.com_error_from_s - 1e-9;
        self.place = Place([time, com[0]]);
        if !self.counts && time >= settings.from_s - 1e-9 {
            self.counts = true;
            counted.clear();
            if let Some(Steady { begin, com_error, .. }) = &mut self.steady {
                (*begin, *com_error) = Default::default();
            }
        }
        if counted.ticks == 0 {
            counted.begin = self.place;
        }
        counted.ticks += 1;
        if let Some(error) = error.filter(|_| late) {
            counted.com_error.add(error);
            counted.com_error_vertical.add(offset(com.len() - 1));
        }
        counted.take_motion(get, &self.foot_of);
        counted.take_loads(get, com.len());
        counted.take_joints(values, &self.joints);
        counted.take_balance(get, &self.meter, late);
        if let [foot, since] = *get(Field::Swing) {
            counted.swinging += u64::from(foot >= 0.0);
            counted.steps += u32::from(since > self.stepped);
            self.stepped = self.stepped.max(since);
        }
        if let Some(steady) = self.steady.as_mut().filter(|steady| time >= steady.commanded.steady_from_s - 1e-9) {
            steady.begin.get_or_insert(self.place);
            if let Some(error) = error.filter(|_| late) {
                steady.com_error.add(error);
            }
        }
        let Some(error) = error else { return };
        if let Some(begin) = self.push.filter(|&begin| time >= begin) {
            let recovery = self.recovery.get_or_insert_default();
            recovery.distance = recovery.distance.max(offset(0));
            let out = error > settings.recovered_within_m;
            if recovery.out && !out {
                recovery.time = time - begin;
            }
            recovery.out = out;
        }
    }

    /// The metrics of the records so far; those of a run whose records lack what they are made of are none.
    pub fn finish(self) -> Metrics {
        let (counted, last) = (self.counted, self.place);
        if counted.ticks == 0 {
            return Metrics::default();
        }
        let joints = self.joints.into_iter().zip(&counted.joints).map(|(joint, sums)| joint.used(sums));
        let joints: Vec<JointUse> = joints.collect();
        let share = |part: u64, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        let swings = !self.columns.range(Field::Swing).is_empty();
        let mean_speed_mps = counted.begin.speed_to(last).unwrap_or(0.0);
        // ∫ Σ|τω| dt / (m g d), after Gabrielli & von Kármán 1950: both integrals over the time are means.
        let power: f64 = joints.iter().map(|joint| joint.power_mean_w).sum();
        let speed = mean_speed_mps.abs();
        Metrics {
            com_error_m: counted.com_error.pair(),
            com_error_vertical_m: counted.com_error_vertical.pair(),
            feet_error_m: counted.feet_error.pair(),
            torso_deviation_rad: counted.torso.pair(),
            torque_nm: counted.torque.pair(),
            grf_n: counted.grf.pair(),
            grf_simulated_n: counted.grf_simulated.pair(),
            u2_n2m2: counted.u2.pair(),
            single_support_fraction: share(counted.swinging, counted.ticks).filter(|_| swings),
            steps: swings.then_some(counted.steps),
            recovery_time_s: self.recovery.filter(|recovery| !recovery.out).map(|recovery| recovery.time),
            recovery_distance_m: self.recovery.map(|recovery| recovery.distance),
            mean_speed_mps,
            steady_speed_mps: self.steady.and_then(|steady| steady.begin?.speed_to(last)),
            steady_com_error_m: self.steady.and_then(|steady| Some(steady.com_error.pair()?.mean)),
            xcom_error_m: counted.xcom_error.pair(),
            xcom_margin_min_m: counted.margin_min,
            xcom_outside_fraction: share(counted.outside, counted.supported),
            cmp_offset_m: counted.cmp_offset.pair(),
            capture_steps: counted.capture_steps,
            uncapturable_fraction: share(counted.uncapturable, counted.supported).filter(|_| swings),
            cost_of_transport: (speed >= TRAVELS && !joints.is_empty()).then(|| power / (self.weight * speed)),
            joints,
        }
    }
}

impl Counted {
    /// Begins anew.
    fn clear(&mut self) {
        let mut joints = std::mem::take(&mut self.joints);
        joints.fill(Default::default());
        *self = Self { joints, ..Self::default() };
    }

    fn take_motion<'a>(&mut self, get: impl Fn(Field) -> &'a [f64], foot_of: &[usize]) {
        let axes = get(Field::Com).len();
        for (foot, reference) in get(Field::FeetReference).chunks_exact(3 * axes).enumerate() {
            let place = middle(get(Field::Feet), axes, foot_of, foot);
            self.feet_error.add(distance(place, reference[..axes].iter().copied()));
        }
        if let [reference, ..] = get(Field::TorsoReference) {
            self.torso.add((get(Field::Torso)[0] - reference).abs());
        }
    }

    fn take_loads<'a>(&mut self, get: impl Fn(Field) -> &'a [f64], axes: usize) {
        let torques = get(Field::Torque);
        torques.iter().for_each(|torque| self.torque.add(torque.abs()));
        if !torques.is_empty() {
            self.u2.add(torques.iter().map(|torque| torque * torque).sum());
        }
        get(Field::Grf).chunks_exact(axes).for_each(|force| self.grf.add(norm(force)));
        get(Field::GrfSimulated).chunks_exact(axes).for_each(|force| self.grf_simulated.add(norm(force)));
    }

    fn take_joints(&mut self, values: &[f64], joints: &[Joint]) {
        for ([squared, speeds, power], joint) in self.joints.iter_mut().zip(joints) {
            let (torque, speed) = (values[joint.torque], values[joint.speed]);
            squared.add(torque * torque);
            speeds.add(speed.abs());
            power.add((torque * speed).abs());
        }
    }

    /// The measures of balance, as `crate::balance` has them.
    fn take_balance<'a>(&mut self, get: impl Fn(Field) -> &'a [f64] + Copy, meter: &Meter, late: bool) {
        let measures = meter.of(get);
        if let (xcom @ [_, ..], Some(reference), true) = (get(Field::Xcom), meter.xcom_reference(get), late) {
            self.xcom_error.add(distance(xcom.iter().copied(), reference));
        }
        if let Some((cmp, cop)) = measures.cmp.zip(measures.cop) {
            self.cmp_offset.add(distance(cmp, cop));
        }
        let Some(margin) = measures.margin() else { return };
        self.supported += 1;
        self.outside += u64::from(margin < 0.0);
        self.margin_min = Some(self.margin_min.map_or(margin, |least| least.min(margin)));
        // What a step can catch depends on which foot swings.
        if !get(Field::Swing).is_empty() {
            let steps = measures.steps();
            self.uncapturable += u64::from(steps.is_none());
            self.capture_steps = self.capture_steps.max(steps);
        }
    }
}

/// The actuated joints, whose names are those of the torques' columns; none where the physics tells no torques.
fn joints(columns: &Columns) -> Vec<Joint> {
    let name = |column: usize| columns.channels()[column].name.split_once('.').map_or("", |(_, name)| name);
    let joint = |torque: usize| {
        let speed = columns.range(Field::V).find(|&speed| name(speed) == name(torque))?;
        Some(Joint { name: name(torque).to_owned(), torque, speed })
    };
    columns.range(Field::TorqueApplied).filter_map(joint).collect()
}

impl Joint {
    /// What the joint was used for, after Thesis 5.3.
    fn used(self, sums: &[Sums; 3]) -> JointUse {
        let [squared, speed, power] = sums.map(|sums| sums.pair().unwrap_or_default());
        JointUse {
            joint: self.name,
            torque_peak_nm: libm::sqrt(squared.peak),
            torque_rms_nm: libm::sqrt(squared.mean),
            speed_peak_radps: speed.peak,
            power_peak_w: power.peak,
            power_mean_w: power.mean,
        }
    }
}

/// The metrics of a `log` of `model`.
pub fn measure(scenario: &Scenario, model: &Robot, log: &Log) -> Metrics {
    let mut measuring = Measuring::new(scenario, model, log.layout());
    log.records().for_each(|record| measuring.take(record));
    measuring.finish()
}

/// When the first push of `scenario` begins [s].
fn first_push(scenario: &Scenario) -> Option<f64> {
    scenario.pushes.iter().map(|push| push.start_s).reduce(f64::min)
}

/// Distance of the CoM from its reference, which begins with a place [m]; none without a reference.
pub(crate) fn com_error(com: &[f64], reference: &[f64]) -> Option<f64> {
    Some(distance(com.iter().copied(), reference.get(..com.len())?.iter().copied()))
}

fn norm(vector: &[f64]) -> f64 {
    libm::sqrt(vector.iter().map(|value| value * value).sum())
}

fn distance(a: impl IntoIterator<Item = f64>, b: impl IntoIterator<Item = f64>) -> f64 {
    libm::sqrt(a.into_iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum())
}
