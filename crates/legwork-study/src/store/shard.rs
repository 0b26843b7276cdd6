//! How a study is cut: into chunks of records, and chunks into shards.

use std::fmt;
use std::ops::Range;

use legwork::error::Error;

/// A part of a study: every `of`-th chunk, from the `index`-th.
///
/// Shards count from 1, so that the last is `N/N`. With a job array of Slurm:
/// `--array=1-8` and `--shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    of: u64,
}

impl Shard {
    pub(super) const WHOLE: Self = Self { index: 1, of: 1 };

    /// Reads `2/8`, the second of eight shards.
    ///
    /// # Errors
    /// Anything else than two whole numbers, the first from 1 to the second.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let numbers = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        let refused = |problem: String| Err(Error::invalid(format!("shard {text:?}"), problem));
        match numbers {
            None => refused("expected I/N with two whole numbers, as 2/8 for the second of eight".to_owned()),
            Some((_, 0)) => refused("there is no part of nothing: expected I/N with N of at least 1".to_owned()),
            Some((index, of)) if (1..=of).contains(&index) => Ok(Self { index, of }),
            Some((index, of)) => refused(format!("shards count from 1, expected 1/{of} to {of}/{of}, found {index}")),
        }
    }

    pub(super) fn number_of_shards(self) -> u64 {
        self.of
    }

    pub(super) fn owns(self, chunk: u64) -> bool {
        chunk % self.of == self.index - 1
    }

    /// The chunks of this shard, of `chunks` in all.
    pub(super) fn of(self, chunks: u64) -> impl Iterator<Item = u64> {
        // Stepped by hand: the step of an iterator is a usize.
        std::iter::successors(Some(self.index - 1), move |chunk| chunk.checked_add(self.of))
            .take_while(move |&chunk| chunk < chunks)
    }

    /// The number of chunks of this shard, of `chunks` in all.
    pub(super) fn size(self, chunks: u64) -> u64 {
        (chunks + 1).saturating_sub(self.index).div_ceil(self.of)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.of)
    }
}

/// Records in a full chunk, of `total` in all: enough chunks for even work, and not too many files.
pub(super) fn chunk_size(total: u64) -> u64 {
    total.div_ceil(128).clamp(1, 64)
}

/// The indices of the records in `chunk` where a full one has `size`, of `total` records in all.
pub(super) fn range(chunk: u64, size: u64, total: u64) -> Range<u64> {
    chunk.saturating_mul(size).min(total)..(chunk + 1).saturating_mul(size).min(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_record_is_in_one_chunk_and_every_chunk_in_one_shard() {
        for total in [0, 1, 2, 127, 128, 129, 1000, 8191, 8192, 8193, 100_000] {
            let size = chunk_size(total);
            let chunks = total.div_ceil(size);
            let ranges: Vec<_> = (0..chunks).map(|chunk| range(chunk, size, total)).collect();
            assert!(ranges.iter().all(|range| (1..=64).contains(&(range.end - range.start))), "{total}: {ranges:?}");
            assert!(ranges.iter().flat_map(Range::clone).eq(0..total), "{total}");
            for of in [1, 2, 3, 7, 200] {
                let shards = (1..=of).map(|index| Shard { index, of });
                let mut owned: Vec<u64> = shards.clone().flat_map(|shard| shard.of(chunks)).collect();
                owned.sort_unstable();
                assert!(owned.into_iter().eq(0..chunks), "{total} in {of}");
                for shard in shards {
                    assert!(shard.of(chunks).all(|chunk| shard.owns(chunk)), "{shard}");
                    assert_eq!(shard.of(chunks).count() as u64, shard.size(chunks), "{shard}");
                }
            }
        }
    }

    #[test]
    fn a_shard_is_read_or_refused_with_what_is_expected() {
        assert_eq!(Shard::parse("2/8").unwrap().to_string(), "2/8");
        assert_eq!(Shard::parse("1/1").unwrap(), Shard::WHOLE);
        for (text, words) in [
            ("", "two whole numbers"),
            ("3", "two whole numbers"),
            ("1/2/3", "two whole numbers"),
            ("-1/3", "two whole numbers"),
            ("1.0/3", "two whole numbers"),
            ("0/0", "at least 1"),
            ("0/3", "from 1"),
            ("4/3", "1/3 to 3/3"),
        ] {
            let message = Shard::parse(text).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains(&format!("{text:?}")), "{message}");
        }
    }
}
