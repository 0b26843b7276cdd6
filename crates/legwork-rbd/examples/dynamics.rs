//! The dynamics of a robot's file in states that are given, for other programs to compare: see xtask/python.
//!
//! `dynamics FILE` writes a line of JSON: the robot's warnings and its coordinates with their numbers. Then each line of the input, a
//! list [q, v], gives a line: the mass matrix row by row, the bias, kinetic energy, and what springs and dampers do.

use std::error::Error;
use std::io::{BufRead, Write};
use std::path::PathBuf;

use legwork_rbd::{Dynamics, Model};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let path: PathBuf = std::env::args_os().nth(1).ok_or("usage: dynamics FILE")?.into();
    let (model, roles) = Model::load_with_roles(&path, None)?;
    let mut out = std::io::stdout().lock();
    let dof = |dof: &legwork_rbd::Dof| {
        let limit = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
        json!({
            "name": dof.name, "actuated": dof.actuated, "lower": limit(dof.lower), "upper": limit(dof.upper),
            "effort": limit(dof.effort_limit), "joint": model.bodies[dof.body].joint.type_name(),
        })
    };
    let head = json!({
        "name": model.name,
        "base": model.base,
        "mass": model.total_mass(),
        "dofs": model.dofs.iter().map(dof).collect::<Vec<_>>(),
        "q_names": model.q_names(),
        "neutral": model.neutral().as_slice(),
        "shapes": roles.geometry.len(),
        "bodies": model.bodies.iter().map(|body| &body.name).collect::<Vec<_>>(),
        "warnings": model.warnings(),
    });
    writeln!(out, "{head}")?;
    let mut dynamics = Dynamics::new(&model);
    for line in std::io::stdin().lock().lines() {
        let (q, v): (Vec<f64>, Vec<f64>) = serde_json::from_str(&line?)?;
        dynamics.update(&model, &q, &v);
        let positions: Vec<_> =
            dynamics.world_from_body.iter().map(|body| body.translation.as_slice().to_vec()).collect();
        let answer = json!({
            "mass_matrix": dynamics.mass_matrix.transpose().as_slice(),
            "bias": dynamics.bias.as_slice(),
            "passive": (&dynamics.damping + &dynamics.elastic).as_slice(),
            "kinetic_energy": dynamics.kinetic_energy,
            "positions": positions,
        });
        writeln!(out, "{answer}")?;
    }
    Ok(())
}
