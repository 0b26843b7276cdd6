//! Measures `Dynamics::update`: `cargo run --release -p legwork-rbd --example time_update [model files]`.

#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use legwork_rbd::{Dynamics, Model, ModelError};

fn main() -> Result<(), ModelError> {
    let mut paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    if paths.is_empty() {
        paths.push(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../models/planar_humanoid.toml"));
    }
    for path in paths {
        let model = Model::load(&path)?;
        let mut dynamics = Dynamics::new(&model);
        let v: Vec<f64> = (0..model.nv()).map(|j| 0.1 * (j + 1) as f64).collect();
        let mut q = model.neutral();
        let mut next = q.clone();
        let mut best = f64::INFINITY;
        for _ in 0..50 {
            let start = Instant::now();
            for _ in 0..2000 {
                model.integrate(q.as_slice(), &v, 1e-3, next.as_mut_slice());
                std::mem::swap(&mut q, &mut next);
                dynamics.update(black_box(&model), black_box(q.as_slice()), black_box(&v));
                black_box(&dynamics);
            }
            best = best.min(start.elapsed().as_secs_f64() / 2000.0);
        }
        println!("{}: {} coordinates, {:.2} us", model.name, model.nv(), best * 1e6);
    }
    Ok(())
}
