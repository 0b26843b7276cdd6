//! Tables of rollouts as CSV and Parquet, written row by row, so that memory does not grow with their number.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::files::Unfinished;
use legwork::error::Error;

/// What a cell holds; nothing is an empty cell, or a null in Parquet.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// True or false.
    Flag(bool),
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::Number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<Option<&str>> for Cell {
    fn from(text: Option<&str>) -> Self {
        text.map_or(Self::Empty, Self::from)
    }
}

/// What all cells of a column hold that are not empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers.
    Number,
    /// Texts.
    Text,
    /// True or false.
    Flag,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its unit, or nothing.
    pub unit: String,
    /// What it holds.
    pub kind: Kind,
}

impl Column {
    /// A column of numbers.
    pub fn number(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), kind: Kind::Number }
    }

    /// A column of texts.
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: String::new(), kind: Kind::Text }
    }
}

/// Rows kept in memory before they are written as a row group of Parquet.
const ROWS_IN_MEMORY: usize = 1024;

/// Writes a table as `NAME.csv` and `NAME.parquet` at once.
pub struct TableWriter {
    columns: Vec<Column>,
    csv: csv::Writer<BufWriter<File>>,
    parquet: SerializedFileWriter<BufWriter<File>>,
    rows: Vec<Vec<Cell>>,
    paths: [PathBuf; 2],
    files: [Unfinished; 2],
}

impl TableWriter {
    /// A table in `folder`; `metadata` goes into the Parquet file. What is there under these names is replaced.
    ///
    /// # Errors
    /// The files cannot be written.
    pub fn create(folder: &Path, name: &str, columns: Vec<Column>, metadata: &[(&str, String)]) -> Result<Self, Error> {
        let paths = ["csv", "parquet"].map(|ending| folder.join(format!("{name}.{ending}")));
        let files = [Unfinished::new(&paths[0])?, Unfinished::new(&paths[1])?];
        let open = |file: &Unfinished| {
            File::create(file.written()).map(BufWriter::new).map_err(|error| Error::io(file.written(), &error))
        };
        let mut csv = csv::Writer::from_writer(open(&files[0])?);
        let head = columns.iter().map(|column| match column.unit.as_str() {
            "" => column.name.clone(),
            unit => format!("{} [{unit}]", column.name),
        });
        csv.write_record(head).map_err(|error| failed(&paths[0], error))?;
        let parquet = parquet_writer(open(&files[1])?, &columns, metadata).map_err(|error| failed(&paths[1], error))?;
        Ok(Self { columns, csv, parquet, rows: Vec::with_capacity(ROWS_IN_MEMORY), paths, files })
    }

    /// Writes a row, which has a cell for each column.
    ///
    /// # Errors
    /// The files cannot be written.
    ///
    /// # Panics
    /// If the row has another number of cells than there are columns, or a cell of another kind than its column.
    pub fn row(&mut self, cells: Vec<Cell>) -> Result<(), Error> {
        assert_eq!(cells.len(), self.columns.len(), "a cell for each column");
        let texts = cells.iter().map(|cell| match cell {
            Cell::Empty => String::new(),
            // The shortest text that reads back to the same bits, and with a point: what looks whole would be read as an integer.
            Cell::Number(number) => format!("{number:?}"),
            Cell::Text(text) => text.clone(),
            Cell::Flag(flag) => flag.to_string(),
        });
        self.csv.write_record(texts).map_err(|error| failed(&self.paths[0], error))?;
        self.rows.push(cells);
        if self.rows.len() == ROWS_IN_MEMORY { self.write_rows() } else { Ok(()) }
    }

    fn write_rows(&mut self) -> Result<(), Error> {
        let rows = std::mem::take(&mut self.rows);
        write_row_group(&mut self.parquet, &rows).map_err(|error| failed(&self.paths[1], error))
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// The files cannot be written.
    pub fn finish(mut self) -> Result<(), Error> {
        self.csv.flush().map_err(|error| Error::io(&self.paths[0], &error))?;
        if !self.rows.is_empty() {
            self.write_rows()?;
        }
        let path = &self.paths[1];
        let mut file = self.parquet.into_inner().map_err(|error| failed(path, error))?;
        file.flush().map_err(|error| Error::io(path, &error))?;
        // What was there before is replaced only now, by what is whole.
        self.files.into_iter().try_for_each(Unfinished::finish)
    }
}

fn failed(path: &Path, error: impl ToString) -> Error {
    Error::Io { path: path.to_owned(), problem: error.to_string() }
}

type ParquetResult<T> = Result<T, parquet::errors::ParquetError>;

fn parquet_writer(
    file: BufWriter<File>,
    columns: &[Column],
    metadata: &[(&str, String)],
) -> ParquetResult<SerializedFileWriter<BufWriter<File>>> {
    let fields = columns.iter().map(|column| {
        let (kind, logical) = match column.kind {
            Kind::Number => (PhysicalType::DOUBLE, None),
            Kind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            Kind::Flag => (PhysicalType::BOOLEAN, None),
        };
        let field = Type::primitive_type_builder(&column.name, kind).with_logical_type(logical);
        Ok(Arc::new(field.with_repetition(Repetition::OPTIONAL).build()?))
    });
    let fields = fields.collect::<ParquetResult<Vec<_>>>()?;
    let schema = Arc::new(Type::group_type_builder("rollouts").with_fields(fields).build()?);
    let units = columns.iter().filter(|column| !column.unit.is_empty());
    let units = units.map(|column| KeyValue::new(format!("unit:{}", column.name), column.unit.clone()));
    let metadata = metadata.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).chain(units);
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata.collect()))
        .build();
    SerializedFileWriter::new(file, schema, Arc::new(properties))
}

fn write_row_group(writer: &mut SerializedFileWriter<BufWriter<File>>, rows: &[Vec<Cell>]) -> ParquetResult<()> {
    let mut group = writer.next_row_group()?;
    let mut index = 0;
    while let Some(mut column) = group.next_column()? {
        let cells = || rows.iter().map(|row| &row[index]);
        let present: Vec<i16> = cells().map(|cell| i16::from(*cell != Cell::Empty)).collect();
        match column.untyped() {
            ColumnWriter::DoubleColumnWriter(writer) => {
                let numbers = cells().filter(|cell| **cell != Cell::Empty).map(|cell| match cell {
                    Cell::Number(number) => *number,
                    other => unreachable!("{other:?} in a column of numbers"),
                });
                writer.write_batch(&numbers.collect::<Vec<_>>(), Some(&present), None)?;
            }
            ColumnWriter::ByteArrayColumnWriter(writer) => {
                let texts = cells().filter(|cell| **cell != Cell::Empty).map(|cell| match cell {
                    Cell::Text(text) => ByteArray::from(text.as_str()),
                    other => unreachable!("{other:?} in a column of texts"),
                });
                writer.write_batch(&texts.collect::<Vec<_>>(), Some(&present), None)?;
            }
            ColumnWriter::BoolColumnWriter(writer) => {
                let flags = cells().filter(|cell| **cell != Cell::Empty).map(|cell| match cell {
                    Cell::Flag(flag) => *flag,
                    other => unreachable!("{other:?} in a column of flags"),
                });
                writer.write_batch(&flags.collect::<Vec<_>>(), Some(&present), None)?;
            }
            _ => unreachable!("columns hold numbers, texts or flags"),
        }
        column.close()?;
        index += 1;
    }
    group.close()?;
    Ok(())
}
