//! Work on all cores, with results that do not depend on how many there are.
//!
//! A job that panics stops what runs beside it soon; what was finished is kept, and the panic goes on to the caller.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::store::{Store, Survey};
use legwork::error::Error;
use legwork::sim::batch::Batch;

/// Does `work` with so many threads, or with one a core where none is given: all that it runs by [`run_all`] and
/// [`run_chunks`].
///
/// # Errors
/// The number is zero, or the operating system grants no threads.
pub fn with_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> R + Send) -> Result<R, Error> {
    let refused = |problem: String| Error::invalid("threads", problem);
    let threads = match threads {
        Some(0) => return Err(refused("expected at least 1, found 0".to_owned())),
        // A pool of none is one of as many as there are cores.
        threads => threads.unwrap_or(0),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|error| refused(error.to_string()))?.install(work))
}

/// The results of `job(0)` to `job(count - 1)` in this order, whatever the threads did.
///
/// None where a job returned none, as one that was stopped does; what is not begun by then is left out.
pub fn run_all<T: Send>(count: usize, job: impl Fn(usize) -> Option<T> + Sync) -> Option<Vec<T>> {
    (0..count).into_par_iter().with_max_len(1).panic_fuse().map(&job).collect()
}

/// [`Batch::step`] on all cores: the same states and the same answer.
///
/// # Panics
/// Those of [`Batch::step`].
pub fn step_batch(batch: &mut Batch, torques: &[f64]) -> usize {
    let actuated = batch.actuated();
    assert_eq!(torques.len(), batch.robots().len() * actuated, "torques of all robots");
    let of = |index: usize| &torques[index * actuated..(index + 1) * actuated];
    // A step takes microseconds: pieces below this are not worth their handing over.
    let robots = batch.robots_mut().par_iter_mut().enumerate().with_min_len(16);
    robots.map(|(index, robot)| usize::from(robot.step(of(index)))).sum()
}

/// How far the work on a store got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Records of the store's shard that are written, by this run and earlier ones.
    pub done: u64,
    /// Records of the store's shard.
    pub total: u64,
}

impl Progress {
    /// Whether the work was stopped before all was done.
    pub fn is_stopped(self) -> bool {
        self.done < self.total
    }
}

/// Fills the chunks of `store` that are missing by its `survey` with the records `job(index)`.
///
/// `progress` is told after each record how many there are, with those of earlier runs; threads may tell it out of
/// order. When `stop` says so, and from then on, no record is begun, and a job that looks at the same flag may return
/// none. A chunk that is not whole then is not written.
///
/// # Errors
/// A chunk cannot be written, as on a full disk. The others are stopped soon; what is written stays.
pub fn run_chunks<T: Serialize + DeserializeOwned>(
    store: &Store,
    survey: &Survey,
    job: impl Fn(u64) -> Option<T> + Sync,
    progress: impl Fn(u64) + Sync,
    stop: impl Fn() -> bool + Sync,
) -> Result<Progress, Error> {
    let size = |chunk: u64| store.range(chunk).end - store.range(chunk).start;
    let total: u64 = store.own_chunks().map(size).sum();
    let earlier = total - survey.missing.iter().map(|&chunk| size(chunk)).sum::<u64>();
    let (written, computed) = (AtomicU64::new(earlier), AtomicU64::new(earlier));
    let record = |index: u64| {
        let record = if stop() { None } else { job(index) }?;
        progress(computed.fetch_add(1, Relaxed) + 1);
        Some(record)
    };
    // Chunks are taken one by one by whoever is free: the last of them, not a half of all, is what one may wait for.
    survey.missing.par_iter().with_max_len(1).panic_fuse().try_for_each(|&chunk| -> Result<(), Error> {
        let Some(records) = store.range(chunk).map(record).collect::<Option<Vec<T>>>() else {
            return Ok(());
        };
        store.write(chunk, &records)?;
        written.fetch_add(size(chunk), Relaxed);
        Ok(())
    })?;
    Ok(Progress { done: written.into_inner(), total })
}
