//! A sink of one's own: it keeps the largest joint torque of a walk and nothing else.
//!
//! `cargo run --release --package legwork --example own_sink`

#![allow(clippy::print_stdout)]

use std::sync::{Arc, Mutex};

use legwork::channel::{Columns, Field};
use legwork::episode::{self, Parts};
use legwork::error::Error;
use legwork::scenario_file;
use legwork::sink::Sink;

#[derive(Debug)]
struct Largest(Arc<Mutex<f64>>);

impl Sink for Largest {
    fn record(&mut self, columns: &Columns, values: &[f64]) -> Result<(), Error> {
        let mut most = self.0.lock().expect("nobody panics with it");
        *most = values[columns.range(Field::Torque)].iter().fold(*most, |most, torque| most.max(torque.abs()));
        Ok(())
    }
}

fn main() -> Result<(), Error> {
    let loaded = scenario_file::load("walk", &[])?;
    let most = Arc::new(Mutex::new(0.0));
    let parts = Parts { sink: Some(Box::new(Largest(Arc::clone(&most)))), ..Parts::default() };
    let run = episode::run_with(&loaded.scenario, &loaded.model()?, parts, |_time| false)?;
    println!("{:?}; the largest joint torque was {:.1} Nm", run.outcome, most.lock().expect("nobody panics with it"));
    Ok(())
}
