//! The files that pass between the contenders: doubles, little-endian. A table begins with its number of columns, and goes
//! on row by row.

use std::io;
use std::path::Path;

/// Rows of doubles of one length.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(crate) columns: usize,
    pub(crate) values: Vec<f64>,
}

impl Table {
    pub(crate) fn new(columns: usize) -> Self {
        Self { columns, values: Vec::new() }
    }

    pub(crate) fn push(&mut self, row: impl IntoIterator<Item = f64>) {
        let before = self.values.len();
        self.values.extend(row);
        assert_eq!(self.values.len() - before, self.columns, "length of a row");
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns)
    }

    pub(crate) fn read(path: &Path) -> io::Result<Self> {
        let bytes = std::fs::read(path)?;
        let mut values: Vec<f64> =
            bytes.as_chunks().0.iter().map(|eight: &[u8; 8]| f64::from_le_bytes(*eight)).collect();
        if values.is_empty() {
            return Err(io::Error::new(io::ErrorKind::InvalidData, format!("{} is empty", path.display())));
        }
        let columns = values.remove(0) as usize;
        Ok(Self { columns, values })
    }

    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        let all = std::iter::once(self.columns as f64).chain(self.values.iter().copied());
        std::fs::write(path, all.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
    }
}

/// A contender's answer to one problem: how long it took [s], whether it calls it solved, its iterations, its answer.
pub(crate) fn answer(
    seconds: f64,
    solved: bool,
    iterations: u32,
    values: impl IntoIterator<Item = f64>,
) -> impl Iterator<Item = f64> {
    [seconds * 1e6, f64::from(u8::from(solved)), f64::from(iterations)].into_iter().chain(values)
}
