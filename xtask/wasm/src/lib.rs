//! Runs of the built-in scenarios in WebAssembly, by numbers alone: nothing is passed in memory. `run.mjs` calls them in Node.

// An exported name could clash with another one in what is linked, which is why the attribute counts as unsafe. Here nothing
// else exports a name.
#![allow(unsafe_code)]

use std::cell::Cell;

use legwork::{episode, library, scenario_file};

thread_local! {
    static RESULT_HASH: Cell<u128> = const { Cell::new(0) };
}

/// The byte at `index` of the name of the built-in scenario `number`; 0 after its end, -1 where there is no such scenario.
#[unsafe(no_mangle)]
pub extern "C" fn name_byte(number: usize, index: usize) -> i32 {
    library::scenario_names()
        .nth(number)
        .map_or(-1, |name| name.as_bytes().get(index).map_or(0, |byte| i32::from(*byte)))
}

/// Runs the built-in scenario `number`; whether it ran.
#[unsafe(no_mangle)]
pub extern "C" fn run(number: usize) -> bool {
    let hash = library::scenario_names().nth(number).and_then(|name| {
        let loaded = scenario_file::load(name, &[]).ok()?;
        Some(episode::run(&loaded.scenario, &loaded.model().ok()?, &[], |_time| false).ok()?.result_hash)
    });
    RESULT_HASH.set(hash.unwrap_or_default());
    hash.is_some()
}

/// The bits from 32 `part` on of the latest run's `result_hash`.
#[unsafe(no_mangle)]
pub extern "C" fn result_hash(part: u32) -> u32 {
    (RESULT_HASH.get() >> (32 * part)) as u32
}
