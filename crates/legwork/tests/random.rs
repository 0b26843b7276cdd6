//! Scenarios thrown at random: always an outcome, never a panic, a hang or a NaN in the log.

use legwork::episode::{self, Outcome};
use legwork::settings::{SETTINGS, Valid};
use legwork::sim::settings::ContactModel;
use legwork::{library, scenario_file};
use proptest::prelude::*;

/// `path=value` for settings drawn from their valid ranges; `share` in 0..1 places the value.
fn assignment(index: usize, share: f64) -> Option<String> {
    let setting = &SETTINGS[index % SETTINGS.len()];
    if ["duration_s", "controller.period_s", "simulation.period_s", "model"].contains(&setting.path) {
        return None;
    }
    let path = setting.path.replace(".N.", ".0.");
    match setting.valid {
        Valid::Number { min, max } => {
            // Half of the draws near the default, half anywhere in the range.
            let default = setting.default().and_then(|value| value.as_float()).unwrap_or(0.0);
            let value =
                if share < 0.5 { default * (0.2 + 3.2 * share) } else { min + (max - min) * (2.0 * share - 1.0) };
            // Delays are whole multiples of a period.
            let value = if path.ends_with("delay_s") { (1e3 * value).round() / 1e3 } else { value };
            Some(format!("{path}={:e}", value.clamp(min, max)))
        }
        Valid::OneOf(choices) => Some(format!("{path}={}", choices[(share * choices.len() as f64) as usize])),
        Valid::Bool => Some(format!("{path}={}", share < 0.5)),
        Valid::Rows(_) if path == "reference.com.waypoints" => {
            Some(format!("{path}=[[0.1, {share}, {}], [0.4, 0.3, {}]]", 1.5 * share - 0.2, 1.2 - share))
        }
        _ => None,
    }
}

fn check(name: &str, sets: &[String]) -> Result<(), TestCaseError> {
    let Ok(loaded) = scenario_file::load(name, sets) else { return Ok(()) };
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    let run = match episode::run(&loaded.scenario, &model, &[], |_| false) {
        Ok(run) => run,
        Err(error) => {
            prop_assert!(!error.to_string().is_empty());
            return Ok(());
        }
    };
    for (i, record) in run.log.records().enumerate() {
        for (column, value) in run.log.columns().iter().zip(record) {
            prop_assert!(value.is_finite(), "{} is {value} in record {i} with {sets:?}", column.name);
        }
    }
    let limit = loaded.scenario.controller.limits.torque_nm;
    let peak = run.metrics.torque_nm.map_or(f64::INFINITY, |torque| torque.peak);
    prop_assert!(peak <= limit, "a torque of {peak} Nm over the limit of {limit} Nm");
    let audit = run.audit.as_ref().expect("the simulator keeps books");
    prop_assert!(
        audit.contact_sweeps < 2000,
        "{} solves for the contacts of a step with {sets:?}",
        audit.contact_sweeps
    );
    // With more friction than that, forces may have no bound where a foot is wedged in.
    let ground = &loaded.scenario.ground;
    if loaded.scenario.simulation.contact.model == ContactModel::Rigid && ground.friction < 3.0 {
        let residual = audit.contact_residual_n;
        prop_assert!(residual < 0.1, "the contacts' law is missed by {residual} N with {sets:?}");
    }
    match run.outcome {
        Outcome::Fell(_) => prop_assert!(run.reason.is_some_and(|reason| reason.starts_with("fell at "))),
        Outcome::Completed => prop_assert!(run.reason.is_none()),
        Outcome::Stopped => prop_assert!(false, "nobody stopped it"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, max_shrink_iters: 40, ..ProptestConfig::default() })]

    #[test]
    fn any_valid_scenario_has_an_outcome(
        name in prop::sample::select(vec!["walk", "push", "push-replan", "waypoints", "stand-push", "exo-lift", "exo-sway"]),
        draws in prop::collection::vec((0..1000_usize, 0.0..1.0f64), 0..8),
    ) {
        let mut sets: Vec<String> = draws.iter().filter_map(|&(index, share)| assignment(index, share)).collect();
        sets.push("duration_s=0.8".into());
        check(name, &sets)?;
    }
}

#[test]
fn a_way_point_below_the_ground_gave_a_log_of_nan() {
    let sets = ["reference.com.waypoints=[[0.5, 0.27, -0.5]]".to_owned()];
    let loaded = scenario_file::load("waypoints", &sets).expect("in range");
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    let error = episode::run(&loaded.scenario, &model, &[], |_| false).expect_err("it is no place for a CoM");
    assert!(error.to_string().contains("row 1: found z = -0.5 m"), "{error}");
}

#[test]
fn a_run_too_short_for_the_com_error_has_none() {
    let loaded = scenario_file::load("stand", &["duration_s=0.3".to_owned()]).expect("a built-in scenario");
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can start");
    assert_eq!((run.metrics.com_error_m, run.metrics.com_error_vertical_m), (None, None));
}

#[test]
fn an_absurd_scenario_falls_and_says_why() {
    let sets: Vec<String> =
        ["ground.friction=0.02", "pushes.0.force_n=5000", "controller.limits.torque_nm=1"].map(str::to_owned).to_vec();
    let loaded = scenario_file::load("push", &sets).expect("absurd, yet valid");
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can start");
    let reason = run.reason.expect("it falls");
    assert!(reason.starts_with("fell at "), "{reason}");
    assert!(reason.contains("torque") || reason.contains("friction"), "{reason}");
}
