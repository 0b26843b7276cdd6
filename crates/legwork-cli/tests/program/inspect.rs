//! `inspect --state`: what it prints is what the library computes, and consistent in itself.

use legwork::library;
use legwork_rbd::{Dynamics, Model};
use serde_json::{Value, json};

use crate::Folder;

/// A trunk with two legs, each of a hip and a sliding shank; a contact point below each.
const URDF: &str = r#"<robot name="biped">
  <link name="trunk"><inertial><origin xyz="0.01 0 0.1" rpy="0 0 0"/>
    <mass value="10"/><inertia ixx="0.9" iyy="1" izz="0.8" ixy="0.01" ixz="0" iyz="0.02"/></inertial></link>
  <link name="right_leg"><inertial><origin xyz="0 0.01 -0.2"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left_leg"><inertial><origin xyz="0 -0.01 -0.2"/><mass value="2.5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="right_hip" type="revolute"><parent link="trunk"/><child link="right_leg"/>
    <origin xyz="0 -0.1 -0.2" rpy="0.1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1.5" effort="100" velocity="10"/><dynamics damping="0.1"/></joint>
  <joint name="left_slide" type="prismatic"><parent link="trunk"/><child link="left_leg"/>
    <origin xyz="0 0.1 -0.2"/><axis xyz="0 0 1"/><limit lower="-0.1" upper="0.2" effort="500" velocity="1"/></joint>
</robot>
"#;
const BESIDE: &str = r#"
contacts = [
    { name = "right_toe", body = "right_leg", position_m = [0.1, 0.0, -0.4] },
    { name = "left_toe", body = "left_leg", position_m = [0.1, 0.0, -0.4] },
]
joints.left_slide = { spring_npm = 300.0, rest_m = 0.01 }
frames = [{ name = "handle", body = "trunk", position_m = [0.0, 0.2, 0.3] }]
"#;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap_or_else(|| panic!("{number} is no number"))],
    }
}

#[track_caller]
fn close(what: &str, left: &[f64], right: &[f64]) {
    assert_eq!(left.len(), right.len(), "{what}");
    for (a, b) in left.iter().zip(right) {
        assert!((a - b).abs() <= 1e-11 * (1.0 + b.abs()), "{what}: {left:?} is not {right:?}");
    }
}

/// The rows of a matrix, which must have the shape given.
#[track_caller]
fn rows(value: &Value, shape: (usize, usize)) -> Vec<Vec<f64>> {
    let rows: Vec<_> = value.as_array().expect("rows").iter().map(numbers).collect();
    assert!(rows.len() == shape.0 && rows.iter().all(|row| row.len() == shape.1), "{value} has not shape {shape:?}");
    rows
}

fn times(matrix: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum()).collect()
}

/// Holds the object against the library and against itself.
fn check(object: &Value, model: &Model, q: &[f64], v: &[f64]) {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q, v);
    let (n, d, angular) = (model.nv(), model.linear_axes().len(), model.angular_axes().len());
    let transposed = |matrix: &nalgebra::DMatrix<f64>| matrix.transpose().as_slice().to_vec();
    let along =
        |point: &nalgebra::Vector3<f64>| model.linear_axes().iter().map(|axis| axis.dot(point)).collect::<Vec<_>>();

    let mass_matrix = rows(&object["mass_matrix"], (n, n));
    let momentum_matrix = rows(&object["centroidal_momentum_matrix"], (angular + d, n));
    close("M", &mass_matrix.concat(), &transposed(&dynamics.mass_matrix));
    close("h", &numbers(&object["bias"]), dynamics.bias.as_slice());
    close("G", &numbers(&object["gravity"]), dynamics.gravity.as_slice());
    close("damping", &numbers(&object["damping"]), dynamics.damping.as_slice());
    close("elastic", &numbers(&object["elastic"]), dynamics.elastic.as_slice());
    close("CoM", &numbers(&object["com"]), &along(&dynamics.com));
    close("A", &momentum_matrix.concat(), &transposed(&dynamics.momentum_matrix));
    close("dA v", &numbers(&object["centroidal_bias"]), dynamics.momentum_bias.as_slice());
    let contacts = object["contacts"].as_array().expect("a list");
    assert_eq!(contacts.len(), model.contacts.len());
    for (k, contact) in contacts.iter().enumerate() {
        assert_eq!(contact["name"], json!(model.contacts[k].name));
        close("p", &numbers(&contact["position"]), &along(&dynamics.contact_positions[k]));
        let jacobian = rows(&contact["jacobian"], (d, n));
        close("J", &jacobian.concat(), &transposed(&dynamics.contact_jacobian.rows(k * d, d).into_owned()));
        close("dJ v", &numbers(&contact["bias"]), &dynamics.contact_bias.as_slice()[k * d..(k + 1) * d]);
        close("J v", &numbers(&contact["velocity"]), &times(&jacobian, v));
    }
    let energy: f64 = times(&mass_matrix, v).iter().zip(v).map(|(a, b)| 0.5 * a * b).sum();
    close("kinetic energy", &numbers(&object["kinetic_energy"]), &[energy]);
    let mass = object["total_mass_kg"].as_f64().unwrap();
    let height = *numbers(&object["com"]).last().unwrap();
    close("potential energy", &numbers(&object["potential_energy"]), &[mass * 9.81 * height]);
    let momentum: Vec<f64> = numbers(&object["com_velocity"]).iter().map(|speed| mass * speed).collect();
    close("momentum", &times(&momentum_matrix, v)[angular..], &momentum);
    assert_eq!(object["q_names"].as_array().map(Vec::len), Some(model.nq()));
    assert_eq!(object["v_names"].as_array().map(Vec::len), Some(n));
    assert_eq!(object["momentum_rows"].as_array().map(Vec::len), Some(angular + d));
    assert_eq!(object["contact_rows"].as_array().map(Vec::len), Some(d));
}

fn inspected(folder: &Folder, model: &str, q: &[f64], v: &[f64]) -> Value {
    folder.file("state.json", json!({ "q": q, "v": v }).to_string());
    folder.json(&["inspect", model, "--state", "state.json", "--json"]).remove(0)
}

#[test]
fn the_planar_humanoid() {
    let folder = Folder::new("inspect-planar");
    let q = [0.1, 0.3, 0.2, 0.6, -0.3, -2.4, -0.7];
    let v = [0.5, -0.2, 1.0, -1.5, 0.7, 2.0, -0.4];
    let object = inspected(&folder, "planar_humanoid", &q, &v);
    check(&object, &library::load_model("planar_humanoid", None).unwrap(), &q, &v);
    assert_eq!(object["momentum_rows"], json!(["angular -y", "linear x", "linear z"]));
    assert_eq!(object["q_names"][3], "right_knee");
    let knee = json!({
        "name": "right_knee", "actuated": true, "rotational": true, "lower": 10f64.to_radians(), "upper": 175f64.to_radians(),
        "velocity_limit": null, "effort_limit": null, "damping": 0.0, "stiffness": 0.0, "rest": 0.0, "stop_stiffness": 0.0,
        "stop_damping": 0.0,
    });
    assert_eq!(object["dofs"][3], knee);
    assert_eq!((&object["base"], &object["torso"]), (&json!("planar"), &json!("torso")));
    assert_eq!(object["warnings"], json!([]));
}

#[test]
fn a_floating_urdf() {
    let folder = Folder::new("inspect-floating");
    folder.file("robot.urdf", URDF);
    folder.file("robot.legwork.toml", BESIDE);
    let (s, c) = 0.3f64.sin_cos();
    let q = [c, 0.6 * s, 0.0, 0.8 * s, 0.1, -0.2, 0.7, 0.4, 0.05];
    let v = [0.3, -0.6, 0.2, 0.5, 0.1, -0.4, 1.5, -0.8];
    let object = inspected(&folder, "robot.urdf", &q, &v);
    let model = library::load_model("robot.urdf", Some(&folder.0)).unwrap();
    check(&object, &model, &q, &v);
    assert_eq!(object["base"], "floating");
    assert_eq!(object["contact_rows"], json!(["linear x", "linear y", "linear z"]));
    let parents: Vec<_> = object["bodies"].as_array().unwrap().iter().map(|body| &body["parent"]).collect();
    assert_eq!(parents, [&Value::Null, &json!("trunk"), &json!("trunk")]);
    assert_eq!(object["bodies"][1]["joint_type"], "revolute");
    assert_eq!(object["dofs"][6]["effort_limit"], 100.0);
    close("spring", &numbers(&object["elastic"]), &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 300.0 * 0.04]);
    close("energy of the spring", &numbers(&object["elastic_energy"]), &[0.5 * 300.0 * 0.04 * 0.04]);
    assert_eq!((&object["frames"][0]["name"], &object["frames"][0]["body"]), (&json!("handle"), &json!("trunk")));
    let text = folder.legwork(&["inspect", "robot.urdf"]).succeeds().out;
    assert!(text.contains("spring of 300 N/m, at rest at 0.01 m"), "{text}");
    assert!(text.contains("handle") && text.contains("on trunk at (0, 0.2, 0.3) m"), "{text}");
}

#[test]
fn the_base_can_be_chosen() {
    let folder = Folder::new("inspect-base");
    folder.file("robot.urdf", URDF.replace(" rpy=\"0.1 0 0\"", ""));
    folder.file("robot.legwork.toml", BESIDE);
    for (base, coordinates) in [("fixed", 2), ("planar", 5), ("floating", 8)] {
        let object = folder.json(&["inspect", "robot.urdf", "--base", base, "--json"]).remove(0);
        assert_eq!(object["v_names"].as_array().map(Vec::len), Some(coordinates), "{base}");
        assert_eq!(object["base"], base);
        assert!(object.get("mass_matrix").is_none());
    }
}

#[test]
fn for_people_it_is_the_same_in_columns_that_fit() {
    let folder = Folder::new("inspect-text");
    folder.file("state.json", json!({ "q": [0, 0, 0, 1, 0, -1.5, -0.5], "v": [0, 0, 0, 0, 0, 0, 0] }).to_string());
    let out = folder.legwork(&["inspect", "planar_humanoid", "--state", "state.json"]).succeeds().out;
    for line in
        ["joints ", "contact points", "mass_matrix:", "centroidal_bias:", "  name: left_foot", "kinetic_energy: 0.0"]
    {
        assert!(out.lines().any(|found| found.starts_with(line)), "{line}: {out}");
    }
    for line in out.lines() {
        assert!(line.chars().count() <= 80 && line.trim_end() == line, "{line:?}");
    }
}
