//! The channels of a record: what a controller, a physics and a run each write down in a tick, by name and kind.

use std::ops::Range;

use crate::error::Error;

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
    /// Acceleration with which a joint has to brake for the end of its range (4.32) or its largest speed [rad/s²], else 0.
    Braking,
    /// Status of the program (0 optimal, 1 infeasible, 2 iteration limit, 3 not convex, 4 invalid), fallback (0 none,
    /// 1 joint limits yielded, 2 acceleration limits yielded, 3 hard tasks yielded, 4 torque held), iterations, programs
    /// solved.
    Program,
    /// Sweeps of the contact solver and its residual [N] in the last step.
    Contact,
    /// Kinetic and potential energy [J]; where joints have springs or stops, also what those store.
    Energy,
    /// Error of the physics' energy balance so far [J].
    EnergyError,
    /// Feet with soles only: centre of pressure that the reference asks for, XcoM's reference, as of the walker; where
    /// there is none, those that belong to the CoM's reference [m]. Then the measures of balance: centre of
    /// pressure, zero-moment point, that of the momentum rate that the planner wants, centroidal moment pivot, margin of the
    /// XcoM to the base of support [m], each as in the tick before where there is none, and the number of steps to a stop,
    /// -1 where no number is enough; of a robot in space the same places along y after these. Forces and rates are means of the
    /// control period after the tick.
    Balance,
    /// Whatever else a controller writes down.
    OfController,
    /// Whatever else a physics writes down.
    OfPlant,
}

impl Field {
    /// In the order of a record.
    pub const ALL: [Self; 29] = [
        Self::Time,
        Self::Q,
        Self::V,
        Self::Torque,
        Self::TorqueApplied,
        Self::Grf,
        Self::GrfSimulated,
        Self::Com,
        Self::ComVelocity,
        Self::ComReference,
        Self::Xcom,
        Self::Torso,
        Self::TorsoReference,
        Self::Feet,
        Self::FeetReference,
        Self::Swing,
        Self::Touching,
        Self::MomentumRateGoal,
        Self::Acceleration,
        Self::Slack,
        Self::ActiveLimit,
        Self::Braking,
        Self::Program,
        Self::Contact,
        Self::Energy,
        Self::EnergyError,
        Self::Balance,
        Self::OfController,
        Self::OfPlant,
    ];
}

/// A number of each record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// What it is a part of.
    pub field: Field,
    /// Its name, different from all others of the run, as in `q.right_knee`.
    pub name: String,
    /// Its unit, or nothing.
    pub unit: &'static str,
}

impl Channel {
    /// Channels of one `field` by their names and units.
    pub fn all<N: Into<String>>(field: Field, names: impl IntoIterator<Item = (N, &'static str)>) -> Vec<Self> {
        names.into_iter().map(|(name, unit)| Self { field, name: name.into(), unit }).collect()
    }
}

/// Where the channels of each field stand in a record: by the order of [`Field`], within a field as they were given.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    channels: Vec<Channel>,
    fields: Vec<Range<usize>>,
}

impl Columns {
    /// The columns of `channels`.
    ///
    /// # Errors
    /// The name of a channel that two have.
    pub fn new(mut channels: Vec<Channel>) -> Result<Self, Error> {
        channels.sort_by_key(|channel| channel.field);
        let mut names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let problem = format!("found two channels of the name '{}'; valid are names that differ", pair[0]);
            return Err(Error::invalid("channels", problem));
        }
        let range = |field: Field| {
            let begin = channels.partition_point(|channel| channel.field < field);
            begin..channels.partition_point(|channel| channel.field <= field)
        };
        let fields = Field::ALL.into_iter().map(range).collect();
        Ok(Self { channels, fields })
    }

    /// The channels, in the order of a record.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Number of values of a record.
    pub fn width(&self) -> usize {
        self.channels.len()
    }

    /// The columns of `field`; empty where nothing gives it.
    pub fn range(&self, field: Field) -> Range<usize> {
        self.fields[field as usize].clone()
    }
}

/// A record that is being filled.
#[derive(Debug)]
pub struct Record<'a> {
    columns: &'a Columns,
    values: &'a mut [f64],
    /// The first field that was filled with fewer or more values than it has channels.
    misfit: Option<Field>,
}

impl<'a> Record<'a> {
    /// One whose `values` are in the order of `columns`.
    pub fn new(columns: &'a Columns, values: &'a mut [f64]) -> Self {
        Self { columns, values, misfit: None }
    }

    /// The values of `field`; none where nothing gives it.
    pub fn get(&self, field: Field) -> &[f64] {
        &self.values[self.columns.range(field)]
    }

    /// Fills `field`, if the run has it, with `values`: one for each of its channels, in their order. Another number of them
    /// is an error, which [`Record::check`] tells.
    pub fn set(&mut self, field: Field, values: impl IntoIterator<Item = f64>) {
        let mut slots = self.values[self.columns.range(field)].iter_mut();
        if slots.len() == 0 {
            return;
        }
        let mut values = values.into_iter();
        loop {
            match (slots.next(), values.next()) {
                (Some(slot), Some(value)) => *slot = value,
                (None, None) => break,
                _ => {
                    self.misfit.get_or_insert(field);
                    break;
                }
            }
        }
    }

    /// # Errors
    /// A field was filled with fewer or more values than it has channels.
    pub fn check(&self) -> Result<(), Error> {
        match self.misfit {
            None => Ok(()),
            Some(field) => {
                let channels = self.columns.range(field).len();
                let problem = format!("found another number of values than the {channels} channels of {field:?}");
                Err(Error::invalid("record", problem))
            }
        }
    }
}
