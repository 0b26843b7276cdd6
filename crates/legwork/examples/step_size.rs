//! How the results depend on the physics time step. docs/simulator.md quotes the output of
//! `cargo run --release -p legwork --example step_size`.

use std::io::{self, Write};

use legwork::{episode, library, scenario_file};

fn main() -> io::Result<()> {
    let mut out = io::stdout().lock();
    for integrator in ["semi-implicit-euler", "midpoint"] {
        for name in ["walk", "push"] {
            writeln!(out, "{name}, {integrator}")?;
            writeln!(
                out,
                "  {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>12} {:>12} {:>12}",
                "step ms",
                "CoM mean",
                "CoM peak",
                "feet mean",
                "torque",
                "u2",
                "force",
                "energy J",
                "mom. mm/s",
                "depth mm"
            )?;
            // The control period stays 2 ms, so that only the physics changes.
            for physics in ["0.002", "0.001", "0.0005", "0.00025", "0.000125"] {
                let sets = [
                    "controller.period_s=0.002".to_owned(),
                    format!("simulation.period_s={physics}"),
                    format!("simulation.integrator={integrator}"),
                ];
                let scenario = scenario_file::load(name, &sets).expect("a valid scenario").scenario;
                let model = library::load_model(&scenario.model, None).expect("a built-in model");
                let run = episode::run(&scenario, &model, &[], |_| false).expect("it can start");
                let (m, audit) = (&run.metrics, run.audit.as_ref().expect("the simulator keeps books"));
                let [com_error, feet_error, torque, u2, force] =
                    [m.com_error_m, m.feet_error_m, m.torque_nm, m.u2_n2m2, m.grf_n].map(Option::unwrap_or_default);
                writeln!(
                    out,
                    "  {:>8} {:>10.5} {:>10.4} {:>10.6} {:>10.3} {:>10.0} {:>10.2} {:>12.5} {:>12.4} {:>12.4}{}",
                    scenario.simulation.period_s * 1e3,
                    com_error.mean,
                    com_error.peak,
                    feet_error.mean,
                    torque.mean,
                    u2.mean,
                    force.mean,
                    audit.energy_error_j,
                    audit.momentum_error_mps * 1e3,
                    audit.penetration_m * 1e3,
                    run.reason.map_or(String::new(), |reason| format!("  {reason}"))
                )?;
            }
        }
    }
    Ok(())
}
