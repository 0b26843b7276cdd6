//! A model in the formats of other people's programs: URDF for Pinocchio and TSID, MJCF for MuJoCo, and a list of coordinates
//! and contact points for the programs that read them.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use legwork::Robot;
use legwork::library::load_model;
use legwork_rbd::{Base, Body, Joint, Model};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Radius of the spheres that stand for contact points in MJCF [m]; the ground lies as much lower.
const CONTACT_RADIUS: f64 = 1e-3;
/// Distance from which on MuJoCo's soft contacts push [m]: with it they carry the robot's weight where ours, which is rigid,
/// has it stand. Chosen for the least difference of the velocities after a step.
const MARGIN: f64 = 5e-4;
/// Coefficient of friction of the ground in MJCF: that of the scenarios `push` and `exo-sway`.
fn friction(model: &Model) -> f64 {
    if model.is_planar() { 0.85 } else { 0.8 }
}

/// A built-in model or a file below the workspace.
pub(crate) fn load(name: &str) -> Result<Robot, Box<dyn Error>> {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    Ok(load_model(name, Some(&workspace))?)
}

/// Writes all three files.
pub(crate) fn write(name: &str, stem: &Path) -> Result<(), Box<dyn Error>> {
    let model = load(name)?;
    std::fs::write(stem.with_extension("urdf"), urdf(&model)?)?;
    std::fs::write(stem.with_extension("xml"), mjcf(&model)?)?;
    Ok(std::fs::write(stem.with_extension("txt"), list(&model)?)?)
}

/// `nc` and `nv`; `joint NAME ACTUATED EFFORT` for each coordinate but a floating base's; `contact LINK FOOT X Y Z` for each point.
fn list(model: &Robot) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(text, "torso {}", model.bodies[model.torso].name)?;
    for dof in model.dofs.iter().skip(floating_dofs(model)) {
        let effort = if dof.effort_limit.is_finite() { dof.effort_limit } else { 1e3 };
        writeln!(text, "joint {} {} {effort}", dof.name, u8::from(dof.actuated))?;
    }
    for (contact, foot) in model.contacts.iter().zip(&model.foot_of) {
        let body = &model.bodies[contact.body].name;
        writeln!(text, "contact {body} {foot} {}", numbers(&contact.position))?;
    }
    Ok(text)
}

fn floating_dofs(model: &Model) -> usize {
    if model.base == Base::Floating { 6 } else { 0 }
}

fn numbers(vector: &Vector3<f64>) -> String {
    format!("{:?} {:?} {:?}", vector.x, vector.y, vector.z)
}

/// Upper triangle, row by row. A planar model knows one inertia, about y; the others move nothing.
fn inertia(body: &Body, model: &Model) -> Matrix3<f64> {
    if model.is_planar() { Matrix3::from_diagonal_element(body.inertia[(1, 1)]) } else { body.inertia }
}

fn urdf(model: &Model) -> Result<String, std::fmt::Error> {
    let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", model.name);
    if model.base != Base::Floating {
        writeln!(text, "  <link name=\"world\"/>")?;
    }
    for body in &model.bodies {
        writeln!(text, "  <link name=\"{}\">", body.name)?;
        if body.mass > 0.0 {
            let i = inertia(body, model);
            writeln!(text, "    <inertial><origin xyz=\"{}\"/><mass value=\"{:?}\"/>", numbers(&body.com), body.mass)?;
            writeln!(
                text,
                "      <inertia ixx=\"{:?}\" ixy=\"{:?}\" ixz=\"{:?}\" iyy=\"{:?}\" iyz=\"{:?}\" izz=\"{:?}\"/></inertial>",
                i[(0, 0)],
                i[(0, 1)],
                i[(0, 2)],
                i[(1, 1)],
                i[(1, 2)],
                i[(2, 2)]
            )?;
        }
        writeln!(text, "  </link>")?;
    }
    for body in &model.bodies {
        if let Joint::Floating(_) = body.joint {
            continue;
        }
        let (kind, axis) = (body.joint.type_name(), body.joint.axis().unwrap_or(Vector3::x_axis()));
        let parent = body.parent.map_or("world", |parent| &model.bodies[parent].name);
        let (roll, pitch, yaw) = Rotation3::from_matrix_unchecked(body.placement.rotation).euler_angles();
        let (origin, axis) = (numbers(&body.placement.translation), numbers(&axis));
        let name = joint_name(body, model);
        writeln!(
            text,
            "  <joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{}\"/>",
            body.name
        )?;
        writeln!(text, "    <origin xyz=\"{origin}\" rpy=\"{roll:?} {pitch:?} {yaw:?}\"/><axis xyz=\"{axis}\"/>")?;
        if body.joint.nv() > 0 {
            let dof = &model.dofs[body.v_index];
            let finite = |value: f64| value.clamp(-1e3, 1e3);
            let (lower, upper) = (finite(dof.lower), finite(dof.upper));
            let (effort, speed) = (finite(dof.effort_limit), finite(dof.velocity_limit));
            writeln!(
                text,
                "    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\" velocity=\"{speed}\"/>"
            )?;
        }
        writeln!(text, "  </joint>")?;
    }
    text.push_str("</robot>\n");
    Ok(text)
}

/// That of its coordinate, where it has one.
fn joint_name<'a>(body: &'a Body, model: &'a Model) -> &'a str {
    if body.joint.nv() == 1 { &model.dofs[body.v_index].name } else { &body.joint_name }
}

fn mjcf(model: &Model) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(text, "<mujoco model=\"{}\">", model.name)?;
    writeln!(text, "  <compiler angle=\"radian\" autolimits=\"false\"/>")?;
    writeln!(text, "  <option timestep=\"0.001\" gravity=\"0 0 {:?}\"/>", -model.gravity)?;
    writeln!(text, "  <worldbody>")?;
    writeln!(
        text,
        "    <geom name=\"ground\" type=\"plane\" size=\"0 0 1\" pos=\"0 0 {:?}\" contype=\"1\" conaffinity=\"0\" friction=\"{:?} 0 0\"/>",
        -CONTACT_RADIUS,
        friction(model)
    )?;
    let root = model.root();
    mjcf_body(model, root, &mut text)?;
    writeln!(text, "  </worldbody>\n  <actuator>")?;
    for dof in model.actuated() {
        writeln!(text, "    <motor joint=\"{}\"/>", model.dofs[dof].name)?;
    }
    writeln!(text, "  </actuator>\n</mujoco>")?;
    Ok(text)
}

fn mjcf_body(model: &Model, index: usize, text: &mut String) -> std::fmt::Result {
    let body = &model.bodies[index];
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(body.placement.rotation));
    let [x, y, z, w] = rotation.coords.into();
    let at = numbers(&body.placement.translation);
    writeln!(text, "<body name=\"{}\" pos=\"{at}\" quat=\"{w:?} {x:?} {y:?} {z:?}\">", body.name)?;
    let i = inertia(body, model);
    writeln!(
        text,
        "  <inertial pos=\"{}\" mass=\"{:?}\" fullinertia=\"{:?} {:?} {:?} {:?} {:?} {:?}\"/>",
        numbers(&body.com),
        body.mass,
        i[(0, 0)],
        i[(1, 1)],
        i[(2, 2)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 2)]
    )?;
    // The virtual bodies of a planar base become joints of its root link.
    for mover in &model.bodies[if index == model.root() { 0 } else { index }..=index] {
        let (kind, axis) = match &mover.joint {
            Joint::Fixed(_) => continue,
            Joint::Ball(_) => {
                writeln!(text, "  <joint name=\"{}\" type=\"ball\"/>", mover.joint_name)?;
                continue;
            }
            Joint::Floating(_) => {
                writeln!(text, "  <freejoint/>")?;
                continue;
            }
            Joint::Revolute(joint) => ("hinge", joint.axis),
            Joint::Prismatic(joint) => ("slide", joint.axis),
        };
        let (name, axis) = (joint_name(mover, model), numbers(&axis));
        let damping = model.dofs[mover.v_index].damping;
        writeln!(text, "  <joint name=\"{name}\" type=\"{kind}\" axis=\"{axis}\" damping=\"{damping:?}\"/>")?;
    }
    for contact in model.contacts.iter().filter(|contact| contact.body == index) {
        writeln!(
            text,
            "  <geom name=\"{}\" type=\"sphere\" size=\"{CONTACT_RADIUS}\" pos=\"{}\" mass=\"0\" contype=\"0\" conaffinity=\"1\" condim=\"3\" margin=\"{MARGIN}\" friction=\"{:?} 0 0\"/>",
            contact.name,
            numbers(&contact.position),
            friction(model)
        )?;
    }
    for child in (0..model.bodies.len()).filter(|&child| model.bodies[child].parent == Some(index)) {
        mjcf_body(model, child, text)?;
    }
    writeln!(text, "</body>")
}
