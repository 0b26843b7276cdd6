//! Names and units of channels that several sides give for a robot: along its axes, of its joints, of its contact points.

use legwork_rbd::Model;

/// Names of channels with their units.
pub type Names = Vec<(String, &'static str)>;

/// `x`, `y`, `z` of the model's linear axes.
pub fn linear(model: &Model) -> impl Iterator<Item = char> + Clone {
    model.linear_axes().iter().map(|axis| ['x', 'y', 'z'][axis.imax()])
}

/// What the name of an angular row ends with: nothing in the plane, which has one.
pub fn angular(model: &Model) -> &'static [&'static str] {
    if model.is_planar() { &[""] } else { &["_x", "_y", "_z"] }
}

/// A vector along the linear axes: `com_x`, `com_z`.
pub fn vector(model: &Model, name: &str, unit: &'static str) -> Names {
    linear(model).map(|axis| (format!("{name}_{axis}"), unit)).collect()
}

/// A point's position, velocity and acceleration along the linear axes.
pub fn motion(model: &Model, name: &str) -> Names {
    let parts = [("", "m"), ("_velocity", "m/s"), ("_acceleration", "m/s2")];
    parts.into_iter().flat_map(|(suffix, unit)| vector(model, &format!("{name}{suffix}"), unit)).collect()
}

/// A vector a contact point: `grf.right_heel_x`.
pub fn contacts(model: &Model, name: &str, unit: &'static str) -> Names {
    model.contacts.iter().flat_map(|contact| vector(model, &format!("{name}.{}", contact.name), unit)).collect()
}

/// A number a velocity coordinate: `v.right_knee`.
pub fn dofs(model: &Model, name: &str, linear: &'static str, angular: &'static str) -> Names {
    let unit = |rotational: bool| if rotational { angular } else { linear };
    model.dofs.iter().map(|dof| (format!("{name}.{}", dof.name), unit(dof.rotational))).collect()
}

/// A number an actuated joint: `torque.right_knee`.
pub fn joints(model: &Model, name: &str, unit: &'static str) -> Names {
    model.actuated().map(|dof| (format!("{name}.{}", model.dofs[dof].name), unit)).collect()
}
