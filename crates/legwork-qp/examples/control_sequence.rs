//! Programs as a controller poses them, a thousand a second, each solved from the working set of the one before.
//!
//! `cargo run --release -p legwork-qp --example control_sequence [recording]`; without a recording, made-up robots.

#[path = "../tests/common/mod.rs"]
mod common;

use std::io::{self, Write};
use std::time::Instant;

use common::families::{whole_body_direct, whole_body_slack, whole_body_spatial};
use common::recorded;
use legwork_qp::{Problem, Settings, Solver, Status};

fn main() -> io::Result<()> {
    let ticks = 0..3000;
    let family = |make: fn(u64, f64) -> Problem| ticks.clone().map(|k| make(2, 1e-3 * f64::from(k))).collect();
    if let Some(path) = std::env::args().nth(1) {
        return measure(&path, &recorded::decode(&std::fs::read(&path)?));
    }
    measure("planar biped, direct form", &Vec::<Problem>::from_iter::<Vec<_>>(family(whole_body_direct)))?;
    measure("planar biped, slack form", &Vec::<Problem>::from_iter::<Vec<_>>(family(whole_body_slack)))?;
    measure("spatial biped", &Vec::<Problem>::from_iter::<Vec<_>>(family(whole_body_spatial)))
}

fn measure(name: &str, programs: &[Problem]) -> io::Result<()> {
    let (n, m) = (programs[0].n(), programs[0].m());
    let mut out = io::stdout().lock();
    writeln!(out, "{name}: {n} variables, {m} rows, {} programs", programs.len())?;
    for warm_start in [true, false] {
        let mut solver = Solver::with_settings(n, m, Settings { warm_start, ..Settings::default() });
        let mut times = vec![f64::INFINITY; programs.len()];
        let (mut iterations, mut solved, mut worst) = (0, 0, 0.0_f64);
        // The best of five runs, as other programs use the machine too.
        for round in 0..5 {
            solver.forget();
            for (time, program) in times.iter_mut().zip(programs) {
                let start = Instant::now();
                let status = solver.solve(program);
                *time = time.min(1e6 * start.elapsed().as_secs_f64());
                if round == 0 && status == Status::Optimal {
                    solved += 1;
                    iterations += solver.iterations();
                    let kkt = program.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers());
                    worst = worst.max(kkt.worst_relative());
                }
            }
        }
        times.sort_by(f64::total_cmp);
        let at = |fraction: f64| times[((times.len() - 1) as f64 * fraction) as usize];
        writeln!(
            out,
            "  {}: median {:.2} µs, 99 % {:.2}, longest {:.2}; {solved} optimal, {:.3} iterations each, residuals <= {worst:.1e}",
            if warm_start { "warm" } else { "cold" },
            at(0.5),
            at(0.99),
            at(1.0),
            f64::from(iterations) / f64::from(solved.max(1)),
        )?;
    }
    Ok(())
}
