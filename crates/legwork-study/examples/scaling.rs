//! How a study scales with threads: the same rollouts on one thread, on two, and so on, in turns.
//!
//! `cargo run --release -p legwork --example scaling -- [rollouts] [rounds]`

use std::io::{self, Write};
use std::time::Instant;

use legwork_study::parallel::{run_all, with_threads};
use legwork_study::{Base, rollout};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let rollouts: usize = arguments.next().map_or(Ok(48), |text| text.parse())?;
    let rounds: usize = arguments.next().map_or(Ok(5), |text| text.parse())?;
    let cores = std::thread::available_parallelism()?.get();
    let base = Base::load("walk", &[])?;
    let once = |threads: usize| {
        let begin = Instant::now();
        let work = || run_all(rollouts, |_| rollout::run(base.variant(), || false));
        with_threads(Some(threads), work).map(|done| (done.map_or(0, |all| all.len()), begin.elapsed().as_secs_f64()))
    };
    let mut times = vec![Vec::new(); cores];
    for _ in 0..rounds {
        for (index, times) in times.iter_mut().enumerate() {
            let (done, seconds) = once(index + 1)?;
            assert_eq!(done, rollouts);
            times.push(seconds);
        }
    }
    let medians: Vec<f64> = times.iter_mut().map(|times| median(times)).collect();
    let simulated = rollouts as f64 * base.variant().scenario.duration_s;
    let mut out = io::stdout();
    writeln!(out, "{rollouts} walks of {} s, medians of {rounds} rounds", base.variant().scenario.duration_s)?;
    writeln!(out, "threads  seconds  rollouts/s  times real time  speed-up")?;
    for (index, seconds) in medians.iter().enumerate() {
        let (rate, real_time, ratio) = (rollouts as f64 / seconds, simulated / seconds, medians[0] / seconds);
        writeln!(out, "{:>7}{seconds:>9.2}{rate:>12.1}{real_time:>17.0}{ratio:>10.2}", index + 1)?;
    }
    Ok(())
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
