//! The roles of a robot's parts: what is refused and what is warned of, what is written and read back, the torso's posture.

use std::path::PathBuf;

use legwork_contract::robot::Robot;
use legwork_rbd::{Base, Dynamics, Model};

const TOML: &str = include_str!("../../legwork-rbd/tests/data/double_pendulum.toml");
const URDF: &str = include_str!("../../legwork-rbd/tests/data/biped18.urdf");
const SIDE: &str = include_str!("../../legwork-rbd/tests/data/biped18.legwork.toml");

fn load(model: &str) -> Robot {
    Robot::load(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../models").join(model)).unwrap()
}

fn dynamics(model: &Model, q: &[f64]) -> Dynamics {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q, &vec![0.0; model.nv()]);
    dynamics
}

#[test]
fn roles_that_no_part_can_have_are_refused() {
    let error = |from: &str, to: &str| {
        assert!(TOML.contains(from), "{from}");
        let text = TOML.replacen(from, to, 1);
        // The dynamics do not care.
        assert_eq!(Model::from_toml(&text, "robot.toml").unwrap(), Model::from_toml(TOML, "robot.toml").unwrap());
        Robot::from_toml(&text, "robot.toml").unwrap_err().to_string()
    };
    let feet = |feet: &str| error("contacts = [", &format!("feet = {feet}\ncontacts = ["));
    assert_eq!(
        error("torso = \"upper\"", "torso = \"chest\""),
        "robot.toml: torso: unknown body \"chest\"; valid are stand, upper, lower"
    );
    assert_eq!(feet("[\"left\"]"), "robot.toml:8: contact \"tip\": unknown foot \"tip\"; valid are left");
    assert_eq!(feet("[\"tip\", \"left\"]"), "robot.toml: feet: \"left\" has no contact point");
    assert_eq!(feet("[\"tip\", \"tip\"]"), "robot.toml: feet: \"tip\" is given twice");

    let side = |side: &str| {
        Robot::from_urdf(URDF, "robot.urdf", Some((side, "robot.legwork.toml")), None).unwrap_err().to_string()
    };
    let chest = side("torso = \"chest\"");
    assert!(chest.starts_with("robot.legwork.toml: torso: unknown body \"chest\"; valid are pelvis, "), "{chest}");
    let virtual_body =
        Robot::from_toml_with_base(&TOML.replacen("\"upper\"", "\"base_x\"", 1), "r", Some(Base::Planar));
    assert!(virtual_body.unwrap_err().to_string().contains("torso: unknown body \"base_x\"; valid are stand, "));
}

#[test]
fn keys_that_no_robot_has_are_refused_as_by_the_model() {
    for (from, to) in [("torso =", "trunk ="), ("name = \"tip\"", "name = \"tip\", fot = \"tip\""), ("\"upper\"", "3")]
    {
        let text = TOML.replacen(from, to, 1);
        let error = Robot::from_toml(&text, "robot.toml").unwrap_err().to_string();
        assert_eq!(error, Model::from_toml(&text, "robot.toml").unwrap_err().to_string());
        assert!(["`torso`", "`foot`", "expected a string"].iter().any(|valid| error.contains(valid)), "{error}");
    }
}

#[test]
fn without_roles_the_root_is_the_torso_and_each_contact_point_a_foot() {
    let bare = Robot::from_urdf(URDF, "robot.urdf", None, None).unwrap();
    assert_eq!((bare.torso, bare.feet.len(), bare.foot_of.len()), (0, 0, 0));
    let pendulum =
        Robot::from_toml_with_base(&TOML.replace("torso = \"upper\"", ""), "p.toml", Some(Base::Planar)).unwrap();
    assert_eq!(pendulum.bodies[pendulum.torso].name, "stand");
    assert_eq!((&pendulum.feet[..], &pendulum.foot_of[..]), (&["tip".to_owned()][..], &[0][..]));
    assert_eq!(load("planar_humanoid.toml").feet, ["right_foot", "left_foot"]);
}

#[test]
fn robots_are_read_back() {
    let biped = Robot::from_urdf(URDF, "robot.urdf", Some((SIDE, "robot.legwork.toml")), None).unwrap();
    assert_eq!((&biped.bodies[biped.torso].name[..], &biped.foot_of[..]), ("trunk", &[0, 0, 1, 1][..]));
    let planar = load("planar_humanoid.toml");
    assert_eq!(planar, Robot::from_toml(&planar.to_toml(), "again.toml").unwrap());
    for robot in [biped, planar, load("planar_humanoid_feet.toml"), load("exo18.urdf")] {
        let again = Robot::from_toml(&robot.to_toml(), "again.toml").unwrap();
        let roles = |robot: &Robot| (robot.torso, robot.feet.clone(), robot.foot_of.clone());
        assert_eq!((roles(&robot), robot.to_toml()), (roles(&again), again.to_toml()));
        // Roles are part of what is told of a robot.
        let mut other = robot.clone();
        other.torso += 1;
        assert_ne!(robot.to_toml(), other.to_toml());
    }
}

#[test]
fn urdf_of_the_planar_humanoid_is_the_planar_humanoid() {
    let toml = load("planar_humanoid.toml");
    let mut links = String::new();
    let mut joints = String::new();
    for body in &toml.bodies[toml.root()..] {
        links += &format!(
            "<link name='{}'><inertial><origin xyz='0 0 {}'/><mass value='{}'/>\
             <inertia ixx='{i}' iyy='{i}' izz='{i}' ixy='0' ixz='0' iyz='0'/></inertial></link>\n",
            body.name,
            body.com.z,
            body.mass,
            i = body.inertia[(1, 1)]
        );
        if body.name != "right_shank" {
            let dof = &toml.dofs[body.v_index];
            joints += &format!(
                "<joint name='{}' type='revolute'><origin xyz='0 0 {}'/><parent link='{}'/><child link='{}'/>\
                 <axis xyz='0 -1 0'/><limit lower='{}' upper='{}' effort='inf' velocity='inf'/></joint>\n",
                body.joint_name,
                body.placement.translation.z,
                toml.bodies[body.parent.unwrap()].name,
                body.name,
                dof.lower,
                dof.upper
            );
        }
    }
    let text = format!("<robot name='planar_humanoid'>{links}{joints}</robot>");
    let side = r#"
        torso = "torso"
        base_pitch = { lower_deg = -175.0, upper_deg = 175.0 }
        contacts = [
            { name = "right_foot", body = "right_shank", position_m = [0.0, 0.0, -0.237867] },
            { name = "left_foot", body = "left_shank", position_m = [0.0, 0.0, 0.49875] },
        ]
    "#;
    let urdf = Robot::from_urdf(&text, "h.urdf", Some((side, "h.legwork.toml")), Some(Base::Planar)).unwrap();
    assert_eq!(urdf.to_toml(), toml.to_toml());
    // The same file on a floating base has 6 + 4 coordinates
    let floating = Robot::from_urdf(&text, "h.urdf", Some((side, "h.legwork.toml")), None).unwrap();
    assert_eq!((floating.base, floating.nv(), floating.nq()), (Base::Floating, 10, 11));
}

#[test]
fn a_foot_in_two_pieces_is_warned_of() {
    let split = "contacts = [{ name = \"a\", foot = \"f\", body = \"upper\", position_m = [0, 0, 0] }, { name = \"b\", foot = \"f\", body";
    let text = TOML.replace("contacts = [{ name = \"tip\", body", split);
    let warnings = Robot::from_toml(&text, "robot.toml").unwrap().warnings();
    assert_eq!(warnings, ["the contact points of \"f\" are on different bodies"]);
    let heavy = text.replace("inertia_kgm2 = { xx = 0.05, yy = 0.05, zz = 0.002 }", "");
    let warnings = Robot::from_toml(&heavy, "robot.toml").unwrap().warnings();
    assert!(warnings.len() == 2 && warnings[0].contains("a point mass"), "{warnings:?}");
}

#[test]
fn the_torso_is_turned_by_the_joints_that_lead_to_it() {
    let robot = load("planar_humanoid.toml");
    for q in [[0.1, 0.9, -0.8, 1.0, -0.3, -2.2, -0.9], [0.0, 1.0, 3.0, 2.5, -0.1, 0.0, 1.0]] {
        // Beyond π it goes on.
        assert_eq!(robot.torso_angle(&dynamics(&robot, &q), &q), q[2] + q[3] + q[4]);
    }
    // About +y, and about −y by an axis that is turned over.
    let text =
        TOML.replacen("axis = [0, -1, 0]", "axis = [0, 1, 0]", 1).replace("torso = \"upper\"", "torso = \"lower\"");
    let text = text.replace("origin_m = [0.0, 0.0, -0.6]", "origin_m = [0.0, 0.0, -0.6]\norigin_rpy_deg = [180, 0, 0]");
    let arm = Robot::from_toml_with_base(&text, "arm.toml", Some(Base::Planar)).unwrap();
    let q = [0.3, 0.2, 0.5, 0.25, 2.0];
    assert_eq!(arm.torso_angle(&dynamics(&arm, &q), &q), 0.5 - 0.25 - 2.0);
}

#[test]
fn in_space_the_torso_is_turned_by_its_elevation() {
    let robot = load("exo18.urdf");
    let mut q = robot.neutral();
    for angle in [0.4_f64, -1.2] {
        let (sin, cos) = (-0.5 * angle).sin_cos();
        (q[0], q[2]) = (cos, sin);
        let dynamics = dynamics(&robot, q.as_slice());
        assert!((robot.torso_angle(&dynamics, q.as_slice()) - angle).abs() < 1e-14);
        assert!((dynamics.world_from_body[robot.torso].rotation[(2, 0)] - angle.sin()).abs() < 1e-14);
    }
}
