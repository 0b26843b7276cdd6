//! The shipped scenarios give what they gave: bit by bit, on every machine.

mod common;

use std::collections::BTreeMap;

use legwork::library;

#[test]
fn every_shipped_scenario_has_its_recorded_result() {
    let recorded: BTreeMap<String, String> =
        toml::from_str(include_str!("data/results.toml")).expect("names and hashes");
    let found =
        library::scenario_names().map(|name| (name.to_owned(), format!("{:032x}", common::run(name, &[]).result_hash)));
    let found: BTreeMap<String, String> = found.collect();
    let differ: Vec<&String> =
        found.keys().chain(recorded.keys()).filter(|name| found.get(*name) != recorded.get(*name)).collect();
    assert!(differ.is_empty(), "other results than recorded: {differ:?}");
}
