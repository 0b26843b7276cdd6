//! The log of a run: one record a control tick, a column a number.

use std::ops::Range;

use legwork_rbd::Model;

use crate::control::Estimate;
use crate::feet::FootRows;
use crate::qp::Layout;
use crate::qp::layout::axis_name;
use crate::qp::tasks::momentum;

/// A group of columns that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Field {
    /// Time [s].
    Time,
    /// Joint positions [rad, m].
    Q,
    /// Joint velocities [rad/s, m/s].
    V,
    /// Torques asked for [Nm], an actuated joint each.
    Torque,
    /// Torques that acted in the step after the tick [Nm].
    TorqueApplied,
    /// Contact forces of the program [N], a contact after the other along the linear axes.
    Grf,
    /// Contact forces of the simulator in the control period after the tick [N].
    GrfSimulated,
    /// Centre of mass [m].
    Com,
    /// Its velocity [m/s].
    ComVelocity,
    /// Its reference: position, then velocity, then acceleration [m, m/s, m/s²].
    ComReference,
    /// Extrapolated centre of mass [m].
    Xcom,
    /// Torso angle [rad], then angular velocity [rad/s].
    Torso,
    /// Its reference: angle, angular velocity, angular acceleration.
    TorsoReference,
    /// Contact points [m].
    Feet,
    /// Reference of the right, then the left foot: position, velocity, acceleration [m, m/s, m/s²].
    FeetReference,
    /// The foot that swings: 0 right, 1 left, -1 none; then when its step was triggered [s], -1 without one.
    Swing,
    /// 1 where a contact point touches the ground.
    Touching,
    /// The planner's desired rate of the centroidal momentum [Nm, N].
    MomentumRateGoal,
    /// Joint accelerations of the program [rad/s², m/s²].
    Acceleration,
    /// What each task was missed by, desired minus achieved.
    Slack,
    /// -1 or 1 where a limit of the program is active at its lower or upper side.
    ActiveLimit,
    /// Acceleration that the braking distance (4.32) asks a joint for [rad/s²], else 0.
    Braking,
    /// Status of the program (0 optimal, 1 infeasible, 2 iteration limit, 3 not convex, 4 invalid), fallback (0 none,
    /// 1 joint limits yielded, 2 acceleration limits yielded, 3 hard tasks yielded, 4 torque held), iterations, programs
    /// solved.
    Program,
    /// Sweeps of the contact solver and its residual [N] in the last step.
    Contact,
    /// Kinetic and potential energy [J], then the error of the energy balance so far [J].
    Energy,
    /// Feet with soles only: centre of pressure that the reference asks for, XcoM's reference, as of the walker; where
    /// there is none, those that belong to the CoM's reference [m]. Then the measures of [`crate::balance`]: centre of
    /// pressure, zero-moment point, that of the momentum rate that the planner wants, centroidal moment pivot, margin of the
    /// XcoM to the base of support [m], each as in the tick before where there is none, and the number of steps to a stop,
    /// -1 where no number is enough. Forces and rates are means of the control period after the tick.
    Balance,
}

/// A named column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name, as in `q.right_knee`.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
}

/// Records of equal width.
#[derive(Clone, Debug)]
pub struct Log {
    columns: Vec<Column>,
    /// The columns of each field, in the order of [`Field`].
    fields: Vec<Range<usize>>,
    values: Vec<f64>,
    /// The foot of each contact point.
    foot_of: Vec<usize>,
}

impl Log {
    /// An empty log for `model` under a program of `layout`, with room for `records` records.
    pub fn new(model: &Model, layout: &Layout, records: usize) -> Self {
        let foot_of = model.contacts.iter().map(|contact| contact.foot).collect();
        let mut log = Self { columns: Vec::new(), fields: Vec::new(), values: Vec::new(), foot_of };
        for (field, columns) in schema(model, layout) {
            let start = log.columns.len();
            log.columns.extend(columns.into_iter().map(|(name, unit)| Column { name, unit }));
            assert_eq!(field as usize, log.fields.len(), "the schema has the order of the fields");
            log.fields.push(start..log.columns.len());
        }
        log.values.reserve_exact(records * log.columns.len());
        log
    }

    /// The columns, in the order of a record.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// Whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The columns of `field`.
    pub fn range(&self, field: Field) -> Range<usize> {
        self.fields[field as usize].clone()
    }

    /// The values of `field` in record `index`.
    pub fn get(&self, index: usize, field: Field) -> &[f64] {
        &self.record(index)[self.range(field)]
    }

    /// Time of record `index` [s].
    pub fn time(&self, index: usize) -> f64 {
        self.get(index, Field::Time)[0]
    }

    /// Record `index`.
    pub fn record(&self, index: usize) -> &[f64] {
        let width = self.columns.len();
        &self.values[index * width..(index + 1) * width]
    }

    /// All records.
    pub fn records(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        self.values.chunks_exact(self.columns.len())
    }

    /// Place of a foot in record `index`, the centre of its contact points, along the linear axes [m].
    pub fn foot(&self, index: usize, foot: usize) -> impl Iterator<Item = f64> + '_ {
        let axes = self.range(Field::Com).len();
        let points = self.get(index, Field::Feet);
        let contacts = move || (0..self.foot_of.len()).filter(move |&contact| self.foot_of[contact] == foot);
        let share = 1.0 / contacts().count() as f64;
        (0..axes).map(move |axis| share * contacts().map(|contact| points[contact * axes + axis]).sum::<f64>())
    }

    /// What an ideal sensor tells the controller at record `index`.
    pub fn truth(&self, index: usize) -> Estimate {
        let axes = self.range(Field::Com).len();
        let load = |before: usize| self.get(before, Field::GrfSimulated).iter().skip(axes - 1).step_by(axes).copied();
        Estimate {
            time: self.time(index),
            q: self.get(index, Field::Q).to_vec(),
            v: self.get(index, Field::V).to_vec(),
            touching: self.get(index, Field::Touching).iter().map(|&flag| flag != 0.0).collect(),
            load: index.checked_sub(1).map_or_else(|| vec![0.0; self.foot_of.len()], |before| load(before).collect()),
        }
    }

    /// The records from `time` [s] on.
    #[must_use]
    pub fn since(&self, time: f64) -> Self {
        let first = (0..self.len()).find(|&index| self.time(index) >= time - 1e-9).unwrap_or(self.len());
        Self { values: self.values[first * self.columns.len()..].to_vec(), ..self.clone() }
    }

    /// All values of the column at `index`.
    pub fn column(&self, index: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        self.records().map(move |record| record[index])
    }

    /// Begins a record of zeros at the end and returns the function that fills one field of it.
    pub fn push(&mut self) -> Record<'_> {
        let start = self.values.len();
        self.values.resize(start + self.columns.len(), 0.0);
        Record { fields: &self.fields, values: &mut self.values[start..] }
    }

    /// The latest record, to be filled further.
    pub fn last_mut(&mut self) -> Record<'_> {
        let start = self.values.len() - self.columns.len();
        Record { fields: &self.fields, values: &mut self.values[start..] }
    }

    /// Hash of all columns and values, bit by bit.
    pub fn hash(&self) -> u128 {
        let mut hasher = xxhash_rust::xxh3::Xxh3::new();
        for column in &self.columns {
            hasher.update(column.name.as_bytes());
            hasher.update(&[0]);
        }
        for value in &self.values {
            hasher.update(&value.to_bits().to_le_bytes());
        }
        hasher.digest128()
    }
}

/// A record that is being filled.
#[derive(Debug)]
pub struct Record<'a> {
    fields: &'a [Range<usize>],
    values: &'a mut [f64],
}

impl Record<'_> {
    /// Fills `field` with `values`, of which there must be as many as columns.
    pub fn set(&mut self, field: Field, values: impl IntoIterator<Item = f64>) {
        self.each(field, values, |slot, value| *slot = value);
    }

    /// Adds `values` to what is in `field`.
    pub fn accumulate(&mut self, field: Field, values: impl IntoIterator<Item = f64>) {
        self.each(field, values, |slot, value| *slot += value);
    }

    fn each(&mut self, field: Field, values: impl IntoIterator<Item = f64>, write: impl Fn(&mut f64, f64)) {
        let range = self.fields[field as usize].clone();
        let mut slots = self.values[range].iter_mut();
        let mut values = values.into_iter();
        loop {
            match (slots.next(), values.next()) {
                (Some(slot), Some(value)) => write(slot, value),
                (None, None) => break,
                _ => unreachable!("{field:?} has another number of columns"),
            }
        }
    }
}

/// All fields with the names and units of their columns.
fn schema(model: &Model, layout: &Layout) -> Vec<(Field, Vec<(String, &'static str)>)> {
    let axes: Vec<char> = (0..model.linear_axes().len()).map(|row| axis_name(model, row)).collect();
    let one = |name: &str, unit| vec![(name.to_owned(), unit)];
    let point = |name: &str, unit: &'static str| axes.iter().map(|axis| (format!("{name}_{axis}"), unit)).collect();
    let contacts = |name: &str, unit: &'static str| -> Vec<_> {
        let points = model.contacts.iter().map(|contact| format!("{name}.{}", contact.name));
        points
            .flat_map(|label| axes.iter().map(move |axis| (format!("{label}_{axis}"), unit)).collect::<Vec<_>>())
            .collect()
    };
    let motion = |name: &str| -> Vec<(String, &'static str)> {
        [("", "m"), ("_velocity", "m/s"), ("_acceleration", "m/s2")]
            .into_iter()
            .flat_map(|(suffix, unit)| point(&format!("{name}{suffix}"), unit) as Vec<_>)
            .collect()
    };
    let dofs = |name: &str, linear: &'static str, angular: &'static str| -> Vec<(String, &'static str)> {
        model
            .dofs
            .iter()
            .map(|dof| (format!("{name}.{}", dof.name), if dof.rotational { angular } else { linear }))
            .collect()
    };
    let joints = |name: &str, unit: &'static str| -> Vec<(String, &'static str)> {
        layout.actuated.iter().map(|&dof| (format!("{name}.{}", model.dofs[dof].name), unit)).collect()
    };
    let slack = layout.tasks().iter().flat_map(|task| task.columns(&format!("slack.{}", task.name)));
    let momentum = layout.task(momentum::NAME).map(|task| task.columns("momentum_rate_goal"));
    let feet = model.feet.iter().take(2).flat_map(|foot| motion(&format!("foot_reference.{foot}"))).collect();
    let positions = model.q_names().into_iter().enumerate().map(|(index, name)| {
        let rotational = model.nq() == model.nv() && model.dofs[index].rotational;
        (
            format!("q.{name}"),
            if rotational {
                "rad"
            } else if model.nq() == model.nv() {
                "m"
            } else {
                ""
            },
        )
    });
    let has_soles = FootRows::of(model).iter().any(|rows| !rows.angular.is_empty());
    let places = ["cop_reference", "xcom_reference", "cop", "zmp", "zmp_wanted", "cmp", "xcom_margin"];
    let mut balance = places.map(|name| (name.to_owned(), "m")).to_vec();
    balance.push(("capture_steps".into(), ""));
    let limits = layout.limits().iter().map(|limit| (limit.column(model), ""));
    vec![
        (Field::Time, one("t", "s")),
        (Field::Q, positions.collect()),
        (Field::V, dofs("v", "m/s", "rad/s")),
        (Field::Torque, joints("torque", "Nm")),
        (Field::TorqueApplied, joints("torque_applied", "Nm")),
        (Field::Grf, contacts("grf", "N")),
        (Field::GrfSimulated, contacts("grf_simulated", "N")),
        (Field::Com, point("com", "m")),
        (Field::ComVelocity, point("com_velocity", "m/s")),
        (Field::ComReference, motion("com_reference")),
        (Field::Xcom, one("xcom", "m")),
        (Field::Torso, vec![("torso".into(), "rad"), ("torso_velocity".into(), "rad/s")]),
        (
            Field::TorsoReference,
            vec![
                ("torso_reference".into(), "rad"),
                ("torso_reference_velocity".into(), "rad/s"),
                ("torso_reference_acceleration".into(), "rad/s2"),
            ],
        ),
        (Field::Feet, contacts("foot", "m")),
        (Field::FeetReference, feet),
        (Field::Swing, vec![("swing".into(), ""), ("swing_since".into(), "s")]),
        (Field::Touching, model.contacts.iter().map(|contact| (format!("touching.{}", contact.name), "")).collect()),
        (Field::MomentumRateGoal, momentum.unwrap_or_default()),
        (Field::Acceleration, dofs("acceleration", "m/s2", "rad/s2")),
        (Field::Slack, slack.collect()),
        (Field::ActiveLimit, limits.collect()),
        (Field::Braking, joints("braking", "rad/s2")),
        (
            Field::Program,
            ["qp.status", "qp.fallback", "qp.iterations", "qp.solves"].map(|name| (name.to_owned(), "")).to_vec(),
        ),
        (Field::Contact, vec![("contact.sweeps".into(), ""), ("contact.residual".into(), "N")]),
        (
            Field::Energy,
            vec![("energy.kinetic".into(), "J"), ("energy.potential".into(), "J"), ("energy.error".into(), "J")],
        ),
        (Field::Balance, if has_soles { balance } else { Vec::new() }),
    ]
}
