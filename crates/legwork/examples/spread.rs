//! How much the thesis's figures depend on the exact values of the fitted parameters.
//!
//! Every setting whose source is "fitted", and the torso's mass, centre of mass and inertia, are multiplied by
//! 1 + 2 % of a normal deviate, all at once; the walk and the push are run with each draw. docs/parameters.md quotes
//! the output of `cargo run --release -p legwork --example spread`.

use std::io::{self, Write};

use legwork::Robot;
use legwork::episode::{self, Outcome, Run};
use legwork::metrics::FIGURES;
use legwork::settings::{SETTINGS, Setting, Valid};
use legwork::{library, scenario_file};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

const DRAWS: u64 = 200;
const DEVIATION: f64 = 0.02;
const SHOWN: [&str; 12] = [
    "com_error_m.mean",
    "com_error_m.peak",
    "com_error_vertical_m.peak",
    "feet_error_m.mean",
    "feet_error_m.peak",
    "torso_deviation_rad.peak",
    "torque_nm.mean",
    "grf_n.mean",
    "u2_n2m2.mean",
    "single_support_fraction",
    "recovery_time_s",
    "recovery_distance_m",
];

fn main() -> io::Result<()> {
    let share: f64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(DEVIATION);
    let mut out = io::stdout().lock();
    for name in ["walk", "push", "push-replan", "walk-support", "push-support"] {
        let runs: Vec<Option<Run>> = (0..DRAWS).map(|draw| perturbed(name, draw, share)).collect();
        let good: Vec<&Run> = runs.iter().flatten().filter(|run| recovered(run)).collect();
        writeln!(out, "{name}: {} of {DRAWS} stood (and recovered, where pushed), {share} of spread", good.len())?;
        for figure in FIGURES.iter().filter(|figure| SHOWN.contains(&figure.name.as_str())) {
            let mut values: Vec<f64> = good.iter().filter_map(|run| figure.of(&run.metrics)).collect();
            if name.starts_with("walk") && figure.name.starts_with("recovery") {
                continue;
            }
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values.get((share * (values.len() as f64 - 1.0)).round() as usize).copied();
            let [low, middle, high] = [0.05, 0.5, 0.95].map(|share| at(share).unwrap_or(f64::NAN));
            let label = format!("{} [{}]", figure.label, figure.unit);
            writeln!(out, "  {label:<28} 5 % {low:>10.4}   median {middle:>10.4}   95 % {high:>10.4}")?;
        }
    }
    Ok(())
}

fn recovered(run: &Run) -> bool {
    let metrics = &run.metrics;
    run.outcome == Outcome::Completed && (metrics.recovery_distance_m.is_none() || metrics.recovery_time_s.is_some())
}

/// The scenario with every fitted value moved; none where the start pose is out of reach.
fn perturbed(name: &str, draw: u64, share: f64) -> Option<Run> {
    let mut random = Pcg64Mcg::seed_from_u64(draw);
    let mut factor = || {
        let normal: f64 = StandardNormal.sample(&mut random);
        1.0 + share * normal
    };
    let base = scenario_file::load(name, &[]).expect("a built-in scenario").scenario;
    let values = toml::Value::try_from(&base).expect("a scenario is plain data");
    let fitted = SETTINGS.iter().filter(|setting| setting.source == "fitted" && is_number(setting));
    let sets: Vec<String> = fitted
        .map(|setting| {
            let value = setting.path.split('.').try_fold(&values, |table, key| table.get(key));
            let value = value.and_then(toml::Value::as_float).expect("a number");
            format!("{}={:?}", setting.path, value * factor())
        })
        .collect();
    let scenario = scenario_file::load(name, &sets).ok()?.scenario;
    let mut model = library::load_model(&scenario.model, None).expect("a built-in model");
    move_torso(&mut model, &mut factor);
    episode::run(&scenario, &model, &[], |_| false).ok()
}

fn is_number(setting: &Setting) -> bool {
    matches!(setting.valid, Valid::Number { .. })
}

/// The torso's mass, centre of mass and inertia are fitted as well.
fn move_torso(model: &mut Robot, factor: &mut impl FnMut() -> f64) {
    let torso = model.torso;
    let body = &mut model.bodies[torso];
    body.mass *= factor();
    body.com *= factor();
    body.inertia *= factor();
}
