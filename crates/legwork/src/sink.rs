//! Where the records of a run go, whatever it is: [`Sink`]. A [`Log`] keeps them in memory, [`crate::log_file`] writes them to a
//! file while the run goes on, and `()` drops them.

use std::fmt::Debug;

use crate::channel::Columns;
use crate::error::Error;
use crate::log::Log;

/// Takes the records of a run.
pub trait Sink: Debug + Send {
    /// Takes the next record, whose values are in the order of the `columns`, the same in each call.
    ///
    /// # Errors
    /// The record could not be put where it belongs; the run ends.
    fn record(&mut self, columns: &Columns, values: &[f64]) -> Result<(), Error>;

    /// There will be no more records.
    ///
    /// # Errors
    /// What is still to be written could not be.
    fn finish(&mut self, _hashes: &Hashes) -> Result<(), Error> {
        Ok(())
    }
}

/// What identifies a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hashes {
    /// Hash of scenario, model and CoM samples.
    pub input: u128,
    /// Hash of all records, and of the names of their columns.
    pub result: u128,
}

impl Sink for Log {
    fn record(&mut self, _columns: &Columns, values: &[f64]) -> Result<(), Error> {
        self.push(values);
        Ok(())
    }
}

impl Sink for () {
    fn record(&mut self, _columns: &Columns, _values: &[f64]) -> Result<(), Error> {
        Ok(())
    }
}
