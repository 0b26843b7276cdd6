//! Logs in files: CSV or Parquet, by the file's ending, written at the end of a run or while it goes on.

use std::fmt::{self, Debug, Display, Formatter};
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
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
            Box::new(Parquet {
                path,
                file: Some(file),
                scenario,
                writer: None,
                block: Vec::new(),
                aside: Aside::default(),
            })
        }
    })
}

/// The error of a Parquet file; that of the disk without the words around it.
fn refused(path: &Path, error: &ParquetError) -> Error {
    match error {
        ParquetError::External(source) => failed(path, source),
        other => failed(path, other),
    }
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
        // The shortest text that reads back to the same bits, and with a point: what looks whole would be read as an integer.
        self.writer
            .write_record(values.iter().map(|value| format!("{value:?}")))
            .map_err(|error| failed(&self.path, error))
    }

    fn finish(&mut self, _hashes: &Hashes) -> Result<(), Error> {
        self.writer.flush().map_err(|error| failed(&self.path, error))
    }
}

/// So many records are in memory before they are put aside.
const BLOCK: usize = 8192;

/// So many blocks make a row group. A writer remembers every group's columns until its end, so that there must be few.
const BLOCKS: usize = 32;

struct Parquet {
    path: PathBuf,
    /// Until the first record.
    file: Option<File>,
    scenario: String,
    /// From the first record on.
    writer: Option<SerializedFileWriter<BufWriter<File>>>,
    /// The latest records, a column after the other.
    block: Vec<Vec<f64>>,
    aside: Aside,
}

/// Blocks of the row group to be written next, in a file without a name: a group is written by columns.
#[derive(Default)]
struct Aside {
    file: Option<File>,
    blocks: usize,
}

impl Aside {
    /// Takes a full block, in the folder of the log at `path` where it may, and empties it.
    fn put(&mut self, block: &mut [Vec<f64>], path: &Path) -> io::Result<()> {
        let file = match self.file.take() {
            Some(file) => file,
            None => path
                .parent()
                .map_or_else(tempfile::tempfile, tempfile::tempfile_in)
                .or_else(|_| tempfile::tempfile())?,
        };
        let mut writer = BufWriter::new(self.file.insert(file));
        for column in block {
            for value in column.drain(..) {
                writer.write_all(&value.to_le_bytes())?;
            }
        }
        self.blocks += 1;
        writer.flush()
    }

    /// The values of a column of `width` in a block.
    fn get(&mut self, block: usize, column: usize, width: usize) -> io::Result<Vec<f64>> {
        let Some(file) = &mut self.file else { return Ok(Vec::new()) };
        let mut bytes = vec![0; BLOCK * size_of::<f64>()];
        file.seek(SeekFrom::Start(((block * width + column) * bytes.len()) as u64))?;
        file.read_exact(&mut bytes)?;
        Ok(bytes.as_chunks().0.iter().map(|value| f64::from_le_bytes(*value)).collect())
    }

    /// Forgets all blocks.
    fn clear(&mut self) -> io::Result<()> {
        self.blocks = 0;
        self.file.as_mut().map_or(Ok(()), Seek::rewind)
    }
}

impl Debug for Parquet {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "Parquet({})", self.path.display())
    }
}

impl Parquet {
    fn begin(&mut self, columns: &Columns) -> Result<(), ParquetError> {
        let Some(file) = self.file.take() else { return Ok(()) };
        if columns.width() == 0 {
            return Err(ParquetError::General("found no column; a log has one at least".to_owned()));
        }
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
        self.block = vec![Vec::with_capacity(BLOCK); columns.width()];
        Ok(())
    }

    /// Writes a row group of what was put aside and of the latest records.
    fn flush(&mut self) -> Result<(), ParquetError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        if self.aside.blocks == 0 && self.block[0].is_empty() {
            return Ok(());
        }
        let width = self.block.len();
        let mut rows = writer.next_row_group()?;
        for (index, latest) in self.block.iter_mut().enumerate() {
            let mut column = rows.next_column()?.expect("as many columns as the schema has");
            for block in 0..self.aside.blocks {
                column.typed::<DoubleType>().write_batch(&self.aside.get(block, index, width)?, None, None)?;
            }
            column.typed::<DoubleType>().write_batch(latest, None, None)?;
            column.close()?;
            latest.clear();
        }
        rows.close()?;
        Ok(self.aside.clear()?)
    }

    fn take(&mut self, columns: &Columns, values: &[f64]) -> Result<(), ParquetError> {
        self.begin(columns)?;
        for (column, value) in self.block.iter_mut().zip(values) {
            column.push(*value);
        }
        match self.block[0].len() {
            BLOCK if self.aside.blocks + 1 < BLOCKS => Ok(self.aside.put(&mut self.block, &self.path)?),
            BLOCK => self.flush(),
            _ => Ok(()),
        }
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
        self.take(columns, values).map_err(|error| refused(&self.path, &error))
    }

    fn finish(&mut self, hashes: &Hashes) -> Result<(), Error> {
        self.close(hashes).map_err(|error| refused(&self.path, &error))
    }
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};

    use super::*;
    use crate::channel::Field;

    #[test]
    fn a_long_log_has_few_row_groups_with_every_record_in_its_place() {
        let channels = ["t", "x"].map(|name| Channel { field: Field::Time, name: name.to_owned(), unit: "s" });
        let columns = Columns::new(channels.to_vec()).expect("names that differ");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.parquet");
        let count = 2 * BLOCKS * BLOCK + 3 * BLOCK + 5;
        let mut sink = create(&path, "long").expect("a file");
        for index in 0..count {
            sink.record(&columns, &[index as f64, -0.1 * index as f64]).expect("room on the disk");
        }
        sink.finish(&Hashes { input: 1, result: 2 }).expect("room on the disk");

        assert_eq!(folder.path().read_dir().expect("a folder").count(), 1, "what was put aside is gone");
        let reader = SerializedFileReader::new(File::open(&path).expect("a file")).expect("Parquet");
        assert_eq!(reader.num_row_groups(), 3);
        let rows = reader.get_row_iter(None).expect("rows").map(|row| row.expect("a row").into_columns());
        let mut seen = 0;
        for (index, row) in rows.enumerate() {
            let values: Vec<String> = row.iter().map(|(_, value)| value.to_string()).collect();
            let expected =
                [index as f64, -0.1 * index as f64].map(|value| parquet::record::Field::Double(value).to_string());
            assert_eq!(values, expected, "record {index}");
            seen += 1;
        }
        assert_eq!(seen, count);
    }
}
