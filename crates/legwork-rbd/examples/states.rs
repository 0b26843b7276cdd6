//! What legwork makes of model files, for other people's code to be held against: a line of JSON for each file, with the model's
//! joints and the dynamics of a few states.
//!
//! `states [--side TOML] [--base fixed|planar|floating] FILE...`; the text TOML takes the place of the file beside a URDF.

#![allow(non_snake_case, clippy::print_stdout)]

use std::error::Error;
use std::path::Path;

use legwork_rbd::{Base, Dynamics, Frame, Model};
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// States of each file.
const STATES: u32 = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).peekable();
    let (mut side, mut base) = (None, None);
    while let Some(option) = arguments.next_if(|argument| argument.starts_with("--")) {
        let value = arguments.next().ok_or("an option without a value")?;
        match option.as_str() {
            "--side" => side = Some(value),
            "--base" => base = Some(serde_json::from_value(Value::String(value))?),
            _ => return Err(format!("{option}: unknown option; valid are --side and --base").into()),
        }
    }
    for file in arguments {
        let told = match read(&file, side.as_deref(), base) {
            Ok(model) => described(&model),
            Err(error) => json!({ "error": error.to_string() }),
        };
        println!("{}", json!({ "file": file, "model": told }));
    }
    Ok(())
}

fn read(file: &str, side: Option<&str>, base: Option<Base>) -> Result<Model, Box<dyn Error>> {
    match side {
        None => Ok(Model::load_with_base(Path::new(file), base)?),
        Some(side) => Ok(Model::from_urdf(&std::fs::read_to_string(file)?, file, Some((side, "side.toml")), base)?),
    }
}

fn described(model: &Model) -> Value {
    let joints = model.bodies.iter().filter(|body| body.follows.is_none()).map(|body| {
        json!({ "name": body.joint_name, "type": body.joint.type_name(), "q": body.q_index, "v": body.v_index, "body": body.name })
    });
    let mut random = Random(1);
    let states = (0..STATES).map(|_| state(model, &mut random));
    json!({
        "nq": model.nq(),
        "nv": model.nv(),
        "base": model.base,
        "mass": model.total_mass(),
        "joints": joints.collect::<Vec<_>>(),
        "warnings": model.warnings(),
        "states": states.collect::<Vec<_>>(),
    })
}

fn state(model: &Model, random: &mut Random) -> Value {
    let mut q: Vec<f64> = (0..model.nq()).map(|_| random.next()).collect();
    for body in model
        .bodies
        .iter()
        .filter(|body| body.follows.is_none() && ["ball", "floating"].contains(&body.joint.type_name()))
    {
        let quaternion = &mut q[body.q_index..body.q_index + 4];
        let norm = quaternion.iter().map(|value| value * value).sum::<f64>().sqrt();
        quaternion.iter_mut().for_each(|value| *value /= norm);
    }
    let v: Vec<f64> = (0..model.nv()).map(|_| random.next()).collect();
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, &q, &v);
    let mut J = DMatrix::zeros(model.angular_axes().len() + model.linear_axes().len(), model.nv());
    let mut jacobian = |body: usize| {
        let frame = Frame { name: String::new(), body, placement: legwork_rbd::Placement::identity() };
        dynamics.frame_jacobian(model, &frame, &mut J);
        json!({ "body": model.bodies[body].name, "rows": rows(&J) })
    };
    // Every fifth body, from the last one inward: tips of all limbs among them.
    let jacobians: Vec<Value> = (0..model.bodies.len()).rev().step_by(5).map(&mut jacobian).collect();
    json!({
        "q": q,
        "v": v,
        "mass_matrix": rows(&dynamics.mass_matrix),
        "bias": dynamics.bias.as_slice(),
        "gravity": dynamics.gravity.as_slice(),
        "com": dynamics.com.as_slice(),
        "momentum_matrix": rows(&dynamics.momentum_matrix),
        "jacobians": jacobians,
    })
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Numbers between -1 and 1, by the generator splitmix64.
struct Random(u64);

impl Random {
    #[allow(clippy::cast_precision_loss)]
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
