//! What several test binaries share.

use legwork::episode::{self, Run};
use legwork::{library, scenario_file};

/// Runs a built-in scenario with `sets`.
pub(crate) fn run(name: &str, sets: &[&str]) -> Run {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = scenario_file::load(name, &sets).expect("a built-in scenario");
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    episode::run(&loaded.scenario, &model, &[], |_| false).expect("the scenario can start")
}
