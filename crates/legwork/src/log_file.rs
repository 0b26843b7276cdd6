//! Logs in files: CSV or Parquet, by the file's ending, written at the end of a run or while it goes on.

use std::fmt::{self, Debug, Display, Formatter};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::channel::{Channel, Columns};
use crate::episode::Run;
use crate::error::Error;
use crate::sink::{Hashes, Sink};

/// The formats of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text with a header line.
    Csv,
    /// Columns of doubles with units and hashes in the metadata.
    Parquet,
}

impl Format {
    /// The format that the ending of `path` asks for.
    ///
    /// # Errors
    /// Another ending than `.csv` or `.parquet`.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            _ => Err(Error::invalid(
                path.display().to_string(),
                "a log ends in .csv or .parquet, which choose its format",
            )),
        }
    }
}

/// Writes the log of `run` to `path`, replacing what is there; see [`create`].
///
/// # Errors
/// Those of [`create`], or the file cannot be written.
pub fn write(run: &Run, path: &Path) -> Result<(), Error> {
    let mut sink = create(path, &run.scenario.name)?;
    for record in run.log.records() {
        sink.record(run.log.layout(), record)?;
    }
    sink.finish(&Hashes { input: run.input_hash, result: run.result_hash })
}

/// A file at `path` that takes the records of a run of the scenario of this name while it goes on, replacing what is there.
///
/// Column names are those of the run's channels; a CSV header carries the unit in brackets, as in `t [s]`.
///
/// # Errors
/// The ending is none of a log's, or the file cannot be created.
pub fn create(path: &Path, scenario: &str) -> Result<Box<dyn Sink>, Error> {
    let format = Format::of(path)?;
    let file = File::create(path).map_err(|error| Error::io(path, &error))?;
    let path = path.to_owned();
    Ok(match format {
        Format::Csv => {
            let writer = csv::Writer::from_writer(BufWriter::new(file));
            Box::new(Csv { path, writer, has_header: false })
        }
        Format::Parquet => {
            let scenario = scenario.to_owned();
            Box::new(Parquet { path, file: Some(file), scenario, writer: None, columns: Vec::new() })
        }
    })
}

fn failed(path: &Path, error: impl Display) -> Error {
    Error::Io { path: path.to_owned(), problem: error.to_string() }
}

#[derive(Debug)]
struct Csv {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
    has_header: bool,
}

impl Sink for Csv {
    fn record(&mut self, columns: &Columns, values: &[f64]) -> Result<(), Error> {
        if !self.has_header {
            let header = columns.channels().iter().map(|channel| match channel.unit {
                "" => channel.name.clone(),
                unit => format!("{} [{unit}]", channel.name),
            });
            self.writer.write_record(header).map_err(|error| failed(&self.path, error))?;
            self.has_header = true;
        }
        // The shortest text that reads back to the same bits.
        self.writer.write_record(values.iter().map(f64::to_string)).map_err(|error| failed(&self.path, error))
    }

    fn finish(&mut self, _hashes: &Hashes) -> Result<(), Error> {
        self.writer.flush().map_err(|error| failed(&self.path, error))
    }
}

/// So many records are written at once.
const ROWS: usize = 8192;

struct Parquet {
    path: PathBuf,
    /// Until the first record.
    file: Option<File>,
    scenario: String,
    /// From the first record on.
    writer: Option<SerializedFileWriter<BufWriter<File>>>,
    /// What is not yet written, a column after the other.
    columns: Vec<Vec<f64>>,
}

impl Debug for Parquet {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "Parquet({})", self.path.display())
    }
}

impl Parquet {
    fn begin(&mut self, columns: &Columns) -> Result<(), ParquetError> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let column = |channel: &Channel| {
            let column = Type::primitive_type_builder(&channel.name, PhysicalType::DOUBLE);
            column.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
        };
        let fields = columns.channels().iter().map(column).collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("log").with_fields(fields).build()?);
        let units = columns.channels().iter().filter(|channel| !channel.unit.is_empty());
        let mut metadata = vec![KeyValue::new("scenario".to_owned(), self.scenario.clone())];
        metadata.extend(units.map(|channel| KeyValue::new(format!("unit:{}", channel.name), channel.unit.to_owned())));
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
        let properties = properties.set_key_value_metadata(Some(metadata)).build();
        self.writer = Some(SerializedFileWriter::new(BufWriter::new(file), schema, Arc::new(properties))?);
        self.columns = vec![Vec::with_capacity(ROWS); columns.width()];
        Ok(())
    }

    fn flush(&mut self) -> Result<(), ParquetError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        if self.columns[0].is_empty() {
            return Ok(());
        }
        let mut rows = writer.next_row_group()?;
        for values in &mut self.columns {
            let mut column = rows.next_column()?.expect("as many columns as the schema has");
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
            values.clear();
        }
        rows.close()?;
        Ok(())
    }

    fn close(&mut self, hashes: &Hashes) -> Result<(), ParquetError> {
        self.flush()?;
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        for (key, hash) in [("input_hash", hashes.input), ("result_hash", hashes.result)] {
            writer.append_key_value_metadata(KeyValue::new(key.to_owned(), format!("{hash:032x}")));
        }
        writer.into_inner()?.flush()?;
        Ok(())
    }
}

impl Sink for Parquet {
    fn record(&mut self, columns: &Columns, values: &[f64]) -> Result<(), Error> {
        self.begin(columns).map_err(|error| failed(&self.path, error))?;
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(*value);
        }
        if self.columns[0].len() < ROWS {
            return Ok(());
        }
        self.flush().map_err(|error| failed(&self.path, error))
    }

    fn finish(&mut self, hashes: &Hashes) -> Result<(), Error> {
        self.close(hashes).map_err(|error| failed(&self.path, error))
    }
}
