//! The computer's clock, for runs that are to be timed. Whoever has no such clock gives another one, or none.

use std::sync::OnceLock;
use std::time::Instant;

/// Time since it was asked for the first time [s].
pub fn system() -> f64 {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    BEGIN.get_or_init(Instant::now).elapsed().as_secs_f64()
}
