//! Writing a log: CSV or Parquet, by the file's ending.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::episode::Run;
use crate::error::Error;
use crate::log::Log;

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

/// Writes the log of `run` to `path`, replacing what is there.
///
/// Column names are those of [`Log::columns`]; a CSV header carries the unit in brackets, as in `t [s]`.
///
/// # Errors
/// The ending is none of a log's, or the file cannot be written.
pub fn write(run: &Run, path: &Path) -> Result<(), Error> {
    let format = Format::of(path)?;
    let file = File::create(path).map_err(|error| Error::io(path, &error))?;
    let failed = |problem: String| Error::Io { path: path.to_owned(), problem };
    match format {
        Format::Csv => write_csv(&run.log, file).map_err(|error| failed(error.to_string())),
        Format::Parquet => write_parquet(run, file).map_err(|error| failed(error.to_string())),
    }
}

fn write_csv(log: &Log, file: File) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::new(file));
    writer.write_record(log.columns().iter().map(|column| {
        if column.unit.is_empty() { column.name.clone() } else { format!("{} [{}]", column.name, column.unit) }
    }))?;
    for record in log.records() {
        // The shortest text that reads back to the same bits.
        writer.write_record(record.iter().map(f64::to_string))?;
    }
    writer.flush()?;
    Ok(())
}

fn write_parquet(run: &Run, file: File) -> Result<(), parquet::errors::ParquetError> {
    let log = &run.log;
    let columns = log
        .columns()
        .iter()
        .map(|column| {
            let column = Type::primitive_type_builder(&column.name, PhysicalType::DOUBLE)
                .with_repetition(Repetition::REQUIRED)
                .build()?;
            Ok(Arc::new(column))
        })
        .collect::<Result<Vec<_>, parquet::errors::ParquetError>>()?;
    let schema = Arc::new(Type::group_type_builder("log").with_fields(columns).build()?);
    let units = log.columns().iter().filter(|column| !column.unit.is_empty());
    let mut metadata = vec![
        KeyValue::new("scenario".to_owned(), run.scenario.name.clone()),
        KeyValue::new("input_hash".to_owned(), format!("{:032x}", run.input_hash)),
        KeyValue::new("result_hash".to_owned(), format!("{:032x}", run.result_hash)),
    ];
    metadata.extend(units.map(|column| KeyValue::new(format!("unit:{}", column.name), column.unit.to_owned())));
    let properties =
        WriterProperties::builder().set_compression(Compression::SNAPPY).set_key_value_metadata(Some(metadata)).build();
    let mut writer = SerializedFileWriter::new(std::io::BufWriter::new(file), schema, Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    let mut index = 0;
    while let Some(mut column) = rows.next_column()? {
        let values: Vec<f64> = log.column(index).collect();
        column.typed::<DoubleType>().write_batch(&values, None, None)?;
        column.close()?;
        index += 1;
    }
    rows.close()?;
    let mut inner = writer.into_inner()?;
    inner.flush()?;
    Ok(())
}
