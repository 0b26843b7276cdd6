//! A control tick and the physics steps after it allocate nothing, over a whole walk and push.
//!
//! In a binary of its own, since the counting allocator is global.

use legwork::episode::Episode;
use legwork::{library, scenario_file};

#[test]
fn no_allocation_in_tick_or_step() {
    for (name, sets) in [
        ("walk", vec![]),
        ("push", vec![]),
        ("push", vec!["controller.form=slack".to_owned(), "duration_s=1.5".to_owned()]),
        ("exo-sway", vec![]),
        ("exo-lift", vec![]),
        ("feet-walk", vec!["duration_s=3".to_owned()]),
        ("feet-walk", vec!["duration_s=1".to_owned(), "simulation.model_error=0.02".to_owned()]),
        ("push-baseline", vec![]), // falls, with programs that have no solution as they stand
        (
            "walk",
            vec![
                "simulation.sensors.delay_s=0.003".to_owned(),
                "simulation.sensors.velocity_noise=0.001".to_owned(),
                "simulation.actuators.delay_s=0.001".to_owned(),
                "controller.known_delay_s=0.004".to_owned(),
                "duration_s=1".to_owned(),
            ],
        ),
    ] {
        let loaded = scenario_file::load(name, &sets).expect("a built-in scenario");
        let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
        let mut episode = Episode::new(&loaded.scenario, &model, &[]).expect("it can start");
        let allocations =
            allocation_counter::measure(|| while episode.advance().expect("nothing that could fail") {}).count_total;
        // The name of a too fast joint in a fall is the one thing that may be allocated, once, at the end.
        let allowed = u64::from(name == "push-baseline") * 2;
        assert!(allocations <= allowed, "{name} {sets:?}: {allocations} allocations");
    }
}
