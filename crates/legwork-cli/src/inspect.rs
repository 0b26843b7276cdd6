//! `legwork inspect`: a robot model as legwork understands it, and its dynamics in a state.

use std::path::Path;

use legwork::Robot;
use legwork::error::Error;
use legwork::library;
use legwork_rbd::words::{PLACE, PROBLEM, list, one_line};
use legwork_rbd::{Base, Dynamics, Joint, Model, file};
use nalgebra::{DMatrix, Vector3};
use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::args::InspectArgs;
use crate::output::{Failure, Output, folded};

/// A quaternion whose norm is further from one than this is refused.
const UNIT_TOLERANCE: f64 = 1e-6;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
}

pub(crate) fn inspect(options: &InspectArgs, output: &mut Output) -> Result<(), Failure> {
    let base = options.base.map(Base::from);
    let model = library::load_model_with_base(&options.model, None, base)?;
    let state = options.state.as_deref().map(|path| read_state(path, &model)).transpose()?;
    let mut object = model_json(&model);
    if let Some(state) = &state {
        object.extend(dynamics_json(&model, state));
    }
    if options.json {
        return output.line(Value::Object(object));
    }
    output.line(model_text(&model))?;
    if state.is_some() {
        for key in DYNAMICS_KEYS {
            output.line(keyed_text(key, &object[*key]))?;
        }
    }
    Ok(())
}

fn read_state(path: &Path, model: &Model) -> Result<State, Error> {
    let text = file::read_text(path, file::TEXT).map_err(|why| Error::unread(path, &why))?;
    let place = path.display().to_string();
    let state: State = serde_json::from_str(&text).map_err(|error| {
        let text = error.to_string();
        let what = if error.is_data() { "" } else { "not JSON: " };
        let found = text.split(" at line ").next().unwrap_or(&text);
        let valid = format!("a state is {{\"q\": [{} numbers], \"v\": [{} numbers]}}", model.nq(), model.nv());
        Error::invalid(format!("{place}:{}:{}", error.line(), error.column()), format!("{what}{found}; {valid}"))
    })?;
    for (key, found, names) in [("q", state.q.len(), model.q_names()), ("v", state.v.len(), model.v_names())] {
        if found != names.len() {
            let problem = format!("found {found} numbers; {} are needed: {}", names.len(), list(&names));
            return Err(Error::invalid(format!("{place}: {key}"), problem));
        }
    }
    for (key, values) in [("q", &state.q), ("v", &state.v)] {
        if let Some(index) = values.iter().position(|value| !value.is_finite() || value.abs() > 1e9) {
            let problem = format!("found {:?}; valid is a number from -1e9 to 1e9", values[index]);
            return Err(Error::invalid(format!("{place}: {key}[{index}]"), problem));
        }
    }
    for body in model.bodies.iter().filter(|body| matches!(body.joint, Joint::Floating(_))) {
        let norm = state.q[body.q_index..body.q_index + 4].iter().map(|value| value * value).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            let place = format!("{place}: q[{}..{}]", body.q_index, body.q_index + 4);
            return Err(Error::invalid(place, format!("found a quaternion (w, x, y, z) of norm {norm}; it must be 1")));
        }
    }
    Ok(state)
}

fn model_json(model: &Robot) -> Map<String, Value> {
    let finite = |value: f64| value.is_finite().then_some(value);
    let bodies: Vec<Value> = model
        .bodies
        .iter()
        .map(|body| {
            json!({
                "name": body.name,
                "parent": body.parent.map(|parent| model.bodies[parent].name.clone()),
                "joint": body.joint_name,
                "joint_type": body.joint.type_name(),
                "mass_kg": body.mass,
                "com_m": vector(&body.com),
                "inertia_kgm2": (0..3).map(|i| vector(&body.inertia.row(i).transpose())).collect::<Vec<_>>(),
            })
        })
        .collect();
    let dofs: Vec<Value> = model
        .dofs
        .iter()
        .map(|dof| {
            json!({
                "name": dof.name,
                "actuated": dof.actuated,
                "rotational": dof.rotational,
                "lower": finite(dof.lower),
                "upper": finite(dof.upper),
                "velocity_limit": finite(dof.velocity_limit),
                "effort_limit": finite(dof.effort_limit),
                "damping": dof.damping,
                "stiffness": dof.stiffness,
                "rest": dof.rest,
                "stop_stiffness": dof.stop_stiffness,
                "stop_damping": dof.stop_damping,
            })
        })
        .collect();
    let contacts: Vec<Value> = model
        .contacts
        .iter()
        .zip(&model.foot_of)
        .map(|(contact, &foot)| {
            json!({
                "name": contact.name,
                "body": model.bodies[contact.body].name,
                "foot": model.feet[foot],
                "position_m": vector(&contact.position),
            })
        })
        .collect();
    let frames: Vec<Value> = model
        .frames
        .iter()
        .map(|frame| {
            json!({
                "name": frame.name,
                "body": model.bodies[frame.body].name,
                "position_m": vector(&frame.placement.translation),
                "rotation": (0..3).map(|i| vector(&frame.placement.rotation.row(i).transpose())).collect::<Vec<_>>(),
            })
        })
        .collect();
    let object = json!({
        "name": model.name,
        "base": format!("{:?}", model.base).to_lowercase(),
        "gravity_mps2": model.gravity,
        "total_mass_kg": model.total_mass(),
        "torso": model.bodies[model.torso].name,
        "q_names": model.q_names(),
        "v_names": model.v_names(),
        "momentum_rows": row_names("angular", model.angular_axes()).chain(row_names("linear", model.linear_axes())).collect::<Vec<_>>(),
        "contact_rows": row_names("linear", model.linear_axes()).collect::<Vec<_>>(),
        "bodies": bodies,
        "dofs": dofs,
        "contact_points": contacts,
        "frames": frames,
        "warnings": model.warnings(),
    });
    match object {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// The keys that a state adds, in the order of printing.
const DYNAMICS_KEYS: &[&str] = &[
    "mass_matrix",
    "bias",
    "gravity",
    "damping",
    "elastic",
    "com",
    "com_velocity",
    "centroidal_momentum_matrix",
    "centroidal_bias",
    "contacts",
    "kinetic_energy",
    "potential_energy",
    "elastic_energy",
];

fn dynamics_json(model: &Model, state: &State) -> Map<String, Value> {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, &state.q, &state.v);
    let axes = model.linear_axes();
    let d = axes.len();
    let project = |value: &Vector3<f64>| axes.iter().map(|axis| axis.dot(value)).collect::<Vec<_>>();
    let contacts: Vec<Value> = model
        .contacts
        .iter()
        .enumerate()
        .map(|(index, contact)| {
            let rows = index * d..(index + 1) * d;
            json!({
                "name": contact.name,
                "position": project(&dynamics.contact_positions[index]),
                "velocity": project(&dynamics.contact_velocities[index]),
                "jacobian": matrix(&dynamics.contact_jacobian.rows(rows.start, d).into_owned()),
                "bias": dynamics.contact_bias.as_slice()[rows].to_vec(),
            })
        })
        .collect();
    let values = [
        matrix(&dynamics.mass_matrix),
        json!(dynamics.bias.as_slice()),
        json!(dynamics.gravity.as_slice()),
        json!(dynamics.damping.as_slice()),
        json!(dynamics.elastic.as_slice()),
        json!(project(&dynamics.com)),
        json!(project(&dynamics.com_velocity)),
        matrix(&dynamics.momentum_matrix),
        json!(dynamics.momentum_bias.as_slice()),
        Value::Array(contacts),
        json!(dynamics.kinetic_energy),
        json!(dynamics.potential_energy),
        json!(dynamics.elastic_energy),
    ];
    DYNAMICS_KEYS.iter().map(|key| (*key).to_owned()).zip(values).collect()
}

fn matrix(matrix: &DMatrix<f64>) -> Value {
    matrix.row_iter().map(|row| json!(row.iter().collect::<Vec<_>>())).collect()
}

fn vector(value: &Vector3<f64>) -> [f64; 3] {
    [value.x, value.y, value.z]
}

fn row_names<'a>(kind: &'a str, axes: &'a [Vector3<f64>]) -> impl Iterator<Item = String> + 'a {
    axes.iter().map(move |axis| {
        let name = ["x", "y", "z"][axis.iamax()];
        format!("{kind} {}{name}", if axis[axis.iamax()] < 0.0 { "-" } else { "" })
    })
}

pub(crate) fn model_text(model: &Robot) -> String {
    let headline = format!(
        "{}: {} base, {} degrees of freedom ({} actuated), {:.3} kg, gravity {} m/s²",
        model.name,
        format!("{:?}", model.base).to_lowercase(),
        model.nv(),
        model.actuated().count(),
        model.total_mass(),
        model.gravity
    );
    let mut text = folded(&headline, 2) + "\n\nbodies\n";
    for (index, depth) in depth_first(model) {
        let body = &model.bodies[index];
        let name = format!("{}{}", "  ".repeat(depth), body.name);
        text += &format!("  {name:<36} {:>9.3} kg   by {} ({})\n", body.mass, body.joint_name, body.joint.type_name());
    }
    text += &format!("\n{:<24}{:>12}{:>12}{:>11}{:>9}\n", "joints", "lower", "upper", "max effort", "damping");
    for dof in &model.dofs {
        let position = |value: f64| match dof.rotational {
            _ if !value.is_finite() => "free".to_owned(),
            true => format!("{:.1} deg", value.to_degrees()),
            false => format!("{value:.3} m"),
        };
        let effort = match dof.effort_limit {
            limit if !limit.is_finite() => "-".to_owned(),
            limit => format!("{limit} {}", if dof.rotational { "Nm" } else { "N" }),
        };
        text += &format!(
            "  {:<22}{:>12}{:>12}{effort:>11}{:>9}{}\n",
            dof.name,
            position(dof.lower),
            position(dof.upper),
            dof.damping,
            if dof.actuated { "" } else { "  passive" }
        );
        if dof.is_elastic() {
            let unit = if dof.rotational { "Nm/rad" } else { "N/m" };
            let rest =
                if dof.rotational { format!("{:.1} deg", dof.rest.to_degrees()) } else { format!("{} m", dof.rest) };
            let spring =
                (dof.stiffness != 0.0).then(|| format!("spring of {} {unit}, at rest at {rest}", dof.stiffness));
            let rate = if dof.rotational { "Nm s/rad" } else { "N s/m" };
            let stops = (dof.stop_stiffness != 0.0)
                .then(|| format!("stops of {} {unit} and {} {rate}", dof.stop_stiffness, dof.stop_damping));
            text += &format!("    {}\n", spring.into_iter().chain(stops).collect::<Vec<_>>().join("; "));
        }
    }
    text += "\ncontact points\n";
    for (contact, &foot) in model.contacts.iter().zip(&model.foot_of) {
        let p = contact.position;
        let body = &model.bodies[contact.body].name;
        let line =
            format!("  {:<22} on {body} at ({}, {}, {}) m, foot {}", contact.name, p.x, p.y, p.z, model.feet[foot]);
        text += &(folded(&line, 25) + "\n");
    }
    if model.contacts.is_empty() {
        text += "  none\n";
    }
    if !model.frames.is_empty() {
        text += "\nframes\n";
    }
    for frame in &model.frames {
        let p = frame.placement.translation;
        text +=
            &format!("  {:<22} on {} at ({}, {}, {}) m\n", frame.name, model.bodies[frame.body].name, p.x, p.y, p.z);
    }
    for warning in model.warnings() {
        text += &format!("\n{}", folded(&format!("warning: {}", one_line(&warning, PLACE + PROBLEM)), 2));
    }
    text
}

/// The bodies, each before what it carries, with how many carry it.
fn depth_first(model: &Model) -> Vec<(usize, usize)> {
    let (mut order, mut next) = (Vec::new(), Vec::new());
    let carried =
        |by: Option<usize>| (0..model.bodies.len()).rev().filter(move |&body| model.bodies[body].parent == by);
    next.extend(carried(None).map(|body| (body, 0)));
    while let Some((body, depth)) = next.pop() {
        order.push((body, depth));
        next.extend(carried(Some(body)).map(|carried| (carried, depth + 1)));
    }
    order
}

/// Rows of numbers in columns, objects key by key.
fn value_text(value: &Value) -> String {
    let lines = |parts: Vec<String>| parts.join("\n");
    match value {
        Value::Array(numbers) if numbers.iter().all(Value::is_number) => numbers
            .iter()
            .filter_map(Value::as_f64)
            // Without the sign of a zero
            .map(|number| format!("{:>11.4}", (number * 1e4).round() / 1e4 + 0.0))
            .collect(),
        Value::Array(items) => lines(items.iter().map(value_text).collect()),
        Value::Object(object) => {
            lines(object.iter().map(|(key, value)| format!("  {}", keyed_text(key, value))).collect())
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn keyed_text(key: &str, value: &Value) -> String {
    let between = if value.is_array() { "\n" } else { " " };
    format!("{key}:{between}{}", value_text(value))
}
