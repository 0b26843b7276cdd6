//! The log of a run in memory: one record a control tick, a column a number.

use std::ops::Range;

pub use crate::channel::{Channel, Columns, Field};
use crate::contract::{ContactSensed, Sensed};
use crate::robot::Robot;

/// Records of equal width.
#[derive(Clone, Debug)]
pub struct Log {
    columns: Columns,
    values: Vec<f64>,
    /// The foot of each contact point.
    foot_of: Vec<usize>,
    /// So many records are kept at the least, the latest; all where there is no such number.
    kept: Option<usize>,
}

impl Log {
    /// An empty log of `model`, with room for `records` records.
    pub fn new(columns: Columns, model: &Robot, records: usize) -> Self {
        let mut log = Self { columns, values: Vec::new(), foot_of: model.foot_of.clone(), kept: None };
        log.values.reserve_exact(records * log.columns.width());
        log
    }

    /// An empty log of `model` that forgets all but the latest `kept` records, or up to a quarter more.
    pub fn of_latest(columns: Columns, model: &Robot, kept: usize) -> Self {
        Self { kept: Some(kept), ..Self::new(columns, model, kept + kept / 4) }
    }

    /// Adds a record.
    pub fn push(&mut self, record: &[f64]) {
        let width = self.columns.width();
        if let Some(kept) = self.kept.filter(|kept| self.len() >= kept + kept / 4) {
            self.values.drain(..(self.len() - kept) * width);
        }
        self.values.extend_from_slice(record);
    }

    /// Where each field's columns stand in a record.
    pub fn layout(&self) -> &Columns {
        &self.columns
    }

    /// The columns, in the order of a record.
    pub fn columns(&self) -> &[Channel] {
        self.columns.channels()
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.values.len() / self.columns.width()
    }

    /// Whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The columns of `field`.
    pub fn range(&self, field: Field) -> Range<usize> {
        self.columns.range(field)
    }

    /// Whether there are columns of `field`: not every controller and physics gives all.
    pub fn has(&self, field: Field) -> bool {
        !self.range(field).is_empty()
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
        let width = self.columns.width();
        &self.values[index * width..(index + 1) * width]
    }

    /// All records.
    pub fn records(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        self.values.chunks_exact(self.columns.width())
    }

    /// Place of a foot in record `index`, the centre of its contact points, along the linear axes [m].
    pub fn foot(&self, index: usize, foot: usize) -> impl Iterator<Item = f64> + '_ {
        middle(self.get(index, Field::Feet), self.range(Field::Com).len(), &self.foot_of, foot)
    }

    /// What an ideal sensor tells the controller at record `index`; no load where the log has no forces of the physics.
    pub fn truth(&self, index: usize) -> Sensed {
        let axes = self.range(Field::Com).len();
        let load = |contact: usize| {
            let before = index.checked_sub(1)?;
            self.get(before, Field::GrfSimulated).get(contact * axes + axes - 1).copied()
        };
        let touching = self.get(index, Field::Touching).iter().enumerate();
        Sensed {
            time: self.time(index),
            q: self.get(index, Field::Q).to_vec(),
            v: self.get(index, Field::V).to_vec(),
            contacts: touching
                .map(|(contact, &flag)| ContactSensed { touching: flag != 0.0, load: load(contact).unwrap_or(0.0) })
                .collect(),
        }
    }

    /// The records from `time` [s] on.
    #[must_use]
    pub fn since(&self, time: f64) -> Self {
        let first = (0..self.len()).find(|&index| self.time(index) >= time - 1e-9).unwrap_or(self.len());
        let Self { columns, foot_of, kept, .. } = self;
        let values = self.values[first * columns.width()..].to_vec();
        Self { columns: columns.clone(), values, foot_of: foot_of.clone(), kept: *kept }
    }

    /// All values of the column at `index`.
    pub fn column(&self, index: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        self.records().map(move |record| record[index])
    }
}

/// The middle of the contact points of a foot, along `axes` axes: `points` one after the other, `foot_of` the foot of each.
pub(crate) fn middle<'a>(
    points: &'a [f64],
    axes: usize,
    foot_of: &'a [usize],
    foot: usize,
) -> impl Iterator<Item = f64> + 'a {
    let contacts = move || (0..foot_of.len()).filter(move |&contact| foot_of[contact] == foot);
    let share = 1.0 / contacts().count() as f64;
    (0..axes).map(move |axis| share * contacts().map(|contact| points[contact * axes + axis]).sum::<f64>())
}
