//! A reference generator of one's own: the momentum controller squats after a reference that is written here.
//!
//! `cargo run --release --package legwork --example own_generator`

#![allow(clippy::print_stdout)]

use legwork::episode::{self, Parts};
use legwork::error::Error;
use legwork::generator::{Generator, Observation, Reference, TurnReference};
use legwork::nalgebra::Vector3;
use legwork::scenario_file;

#[derive(Debug, Default)]
struct Squat {
    /// What was seen in the first tick.
    start: Option<Observation>,
}

impl Generator for Squat {
    fn update(&mut self, seen: &Observation, reference: &mut Reference) {
        let start = *self.start.get_or_insert(*seen);
        // 4 cm up and down, twice in three seconds, beginning at rest.
        let (depth, rate) = (0.04, std::f64::consts::TAU * 2.0 / 3.0);
        let (sin, cos) = (rate * seen.time).sin_cos();
        let com = &mut reference.chest.point;
        com.position = start.com - Vector3::z() * (0.5 * depth * (1.0 - cos));
        com.velocity = -Vector3::z() * (0.5 * depth * rate * sin);
        com.acceleration = -Vector3::z() * (0.5 * depth * rate * rate * cos);
        for (foot, goal) in reference.feet.iter_mut().enumerate() {
            goal.point.position = start.feet[foot];
            goal.turn = TurnReference::pitch(start.pitch[foot][0], 0.0, 0.0);
        }
    }
}

fn main() -> Result<(), Error> {
    let loaded = scenario_file::load("exo-sway", &["duration_s=3".to_owned(), "pushes=[]".to_owned()])?;
    let parts = Parts { generator: Some(Box::new(Squat::default())), ..Parts::default() };
    let run = episode::run_with(&loaded.scenario, &loaded.model()?, parts, |_time| false)?;
    let heights = run.log.records().map(|record| record[run.log.range(legwork::log::Field::Com)][2]);
    let [low, high] = heights.fold([f64::INFINITY, 0.0], |[low, high], z| [z.min(low), z.max(high)]);
    println!("{:?}; the centre of mass moved between {low:.3} and {high:.3} m", run.outcome);
    Ok(())
}
