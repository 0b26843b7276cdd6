//! Work on all cores, with results in order.

use rayon::prelude::*;

/// The results of `job(0)` to `job(count - 1)` in this order, whatever the threads did; none where a job returned none,
/// as one that was stopped does.
pub fn run_all<T: Send>(count: usize, job: impl Fn(usize) -> Option<T> + Sync) -> Option<Vec<T>> {
    let job = &job;
    (0..count).into_par_iter().with_max_len(1).map(job).collect()
}
