//! The two formats: what is written is read back, and URDF and TOML mean the same.

mod common;

use common::assert_close;
use legwork_rbd::{Base, Dynamics, Fixed, Joint, Model};
use proptest::prelude::*;

const PENDULUM_TOML: &str = include_str!("data/double_pendulum.toml");
const PENDULUM_URDF: &str = r#"<robot name="double_pendulum">
  <link name="stand"/>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 -0.25" rpy="0 0 0"/>
      <mass value="1.3"/>
      <inertia ixx="0.05" iyy="0.05" izz="0.002" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual><geometry><mesh filename="package://nowhere/upper.stl"/></geometry></visual>
  </link>
  <link name="lower">
    <inertial>
      <!-- the inertia's axes are turned by a quarter: x of the file is z of the link -->
      <origin xyz="0 0 -0.2" rpy="0 1.5707963267948966 0"/>
      <mass value="0.7"/>
      <inertia ixx="0.001" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="shoulder" type="continuous">
    <parent link="stand"/>
    <child link="upper"/>
    <axis xyz="0 -3 0"/>
    <dynamics damping="0.1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0 0 -0.6"/>
    <parent link="upper"/>
    <child link="lower"/>
    <axis xyz="0 -1 0"/>
    <limit lower="-2.5" upper="2.5" effort="30" velocity="12.5"/>
    <dynamics damping="0.2"/>
  </joint>
</robot>
"#;
const PENDULUM_SIDE: &str = r#"
base = "fixed"
torso = "upper"
gravity_mps2 = 9.81
contacts = [{ name = "tip", body = "lower", position_m = [0.0, 0.0, -0.4] }]
"#;

fn assert_same_dynamics(a: &Model, b: &Model, seed: u64, tolerance: f64) {
    let mut random = common::Random(seed);
    let (q, v) = (random.q(a), random.v(a));
    let (mut left, mut right) = (Dynamics::new(a), Dynamics::new(b));
    left.update(a, &q, &v);
    right.update(b, &q, &v);
    assert_close("M", left.mass_matrix.as_slice(), right.mass_matrix.as_slice(), tolerance);
    assert_close("h", left.bias.as_slice(), right.bias.as_slice(), tolerance);
    assert_close("damping", left.damping.as_slice(), right.damping.as_slice(), tolerance);
    assert_close("J", left.contact_jacobian.as_slice(), right.contact_jacobian.as_slice(), tolerance);
    assert_close("contact bias", left.contact_bias.as_slice(), right.contact_bias.as_slice(), tolerance);
    for (left, right) in left.world_from_body.iter().zip(&right.world_from_body) {
        assert_close("orientation", left.rotation.as_slice(), right.rotation.as_slice(), tolerance);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_back(
        seed: u64,
        bodies in 1..9_usize,
        base in prop_oneof![Just(Base::Fixed), Just(Base::Planar), Just(Base::Floating)],
    ) {
        let tree = common::random_tree(seed, bodies, base);
        let (model, roles) = Model::from_toml_with_roles(&tree, "tree.toml", None).unwrap();
        prop_assert_eq!(&model, &Model::from_toml(&model.to_toml(), "alone.toml").unwrap());
        let text = model.to_toml_with_roles(&roles);
        let (again, same) = Model::from_toml_with_roles(&text, "again.toml", None).unwrap();
        prop_assert_eq!(&model, &again);
        prop_assert_eq!((&roles.torso, &roles.feet, &roles.foot), (&same.torso, &same.feet, &same.foot));
        prop_assert_eq!(text, again.to_toml_with_roles(&same));
    }
}

#[test]
fn own_models_are_read_back() {
    let planar = common::planar_humanoid();
    assert_eq!(planar, Model::from_toml(&planar.to_toml(), "again.toml").unwrap());
    assert_eq!(planar.warnings(), Vec::<String>::new());
    let biped = common::biped18();
    let again = Model::from_toml(&biped.to_toml(), "again.toml").unwrap();
    assert_eq!(biped.to_toml(), again.to_toml());
    assert_same_dynamics(&biped, &again, 1, 0.0);
    let pendulum = Model::from_toml(PENDULUM_TOML, "pendulum.toml").unwrap();
    assert_eq!(pendulum, Model::from_toml(&pendulum.to_toml(), "again.toml").unwrap());
    // A number that matters, changed in its last bit, changes the text
    let mut heavier = planar.clone();
    heavier.bodies[4].mass = heavier.bodies[4].mass.next_up();
    assert_ne!(planar.to_toml(), heavier.to_toml());
}

#[test]
fn a_fixed_robot_stands_where_its_file_says() {
    let text = PENDULUM_TOML.replace(
        "name = \"stand\"",
        "name = \"stand\"\njoint = { name = \"mount\", type = \"fixed\", origin_m = [1.0, 2.0, 3.0], origin_rpy_deg = [0, 0, 90] }",
    );
    let model = Model::from_toml(&text, "pendulum.toml").unwrap();
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &[std::f64::consts::FRAC_PI_2, 0.0], &[0.0, 0.0]);
    // Swung out along the stand's x, which is the world's y
    assert_close("tip", dynamics.contact_positions[0].as_slice(), &[1.0, 3.0, 3.0], 1e-14);
    assert_eq!(model, Model::from_toml(&model.to_toml(), "again.toml").unwrap());
}

#[test]
fn degrees_in_toml_are_radians_in_urdf() {
    let toml = PENDULUM_TOML
        .replace("damping_nmspr = 0.1", "damping_nmspr = 0.1\norigin_rpy_deg = [10, 20, 30]\nactuated = false");
    let toml = Model::from_toml(&toml, "p.toml").unwrap();
    assert_eq!(toml.actuated().collect::<Vec<_>>(), [1]);
    let rpy = [10.0_f64, 20.0, 30.0].map(f64::to_radians);
    let origin = format!("<origin rpy=\"{} {} {}\"/><child link=\"upper\"/>", rpy[0], rpy[1], rpy[2]);
    let urdf = PENDULUM_URDF.replace("<child link=\"upper\"/>", &origin);
    let urdf = Model::from_urdf(&urdf, "p.urdf", Some((PENDULUM_SIDE, "p.legwork.toml")), None).unwrap();
    assert_same_dynamics(&toml, &urdf, 3, 1e-14);
    assert_eq!(toml.bodies[1].placement, urdf.bodies[1].placement);
}

#[test]
fn bodies_may_come_before_their_parents() {
    let (head, bodies) = PENDULUM_TOML.split_once("[[bodies]]").unwrap();
    let mut parts: Vec<&str> = bodies.split("[[bodies]]").collect();
    parts.reverse();
    let text = format!("{head}[[bodies]]\n{}", parts.join("\n[[bodies]]\n"));
    let (model, reversed) =
        (Model::from_toml(PENDULUM_TOML, "a.toml").unwrap(), Model::from_toml(&text, "b.toml").unwrap());
    assert_eq!(model, reversed);
}

#[test]
fn urdf_and_toml_mean_the_same_pendulum() {
    let (toml, said) = Model::from_toml_with_roles(PENDULUM_TOML, "pendulum.toml", None).unwrap();
    let side = Some((PENDULUM_SIDE, "p.legwork.toml"));
    let (urdf, roles) = Model::from_urdf_with_roles(PENDULUM_URDF, "p.urdf", side, None).unwrap();
    assert_eq!((&roles.torso, &roles.feet, &roles.foot), (&said.torso, &said.feet, &said.foot));
    assert_eq!((urdf.base, &urdf.dofs), (toml.base, &toml.dofs));
    for (urdf, toml) in urdf.bodies.iter().zip(&toml.bodies) {
        assert_close("inertia", urdf.inertia.as_slice(), toml.inertia.as_slice(), 1e-16);
        assert_eq!((&urdf.name, urdf.parent, urdf.com), (&toml.name, toml.parent, toml.com));
    }
    assert_same_dynamics(&urdf, &toml, 2, 1e-14);
}

#[test]
fn base_may_be_overridden() {
    let path = common::crate_path("tests/data/double_pendulum.toml");
    let planar = Model::load_with_base(&path, Some(Base::Planar));
    // The stand, now the root link that moves, carries the others' mass
    let planar = planar.unwrap();
    assert_eq!((planar.nv(), planar.root()), (5, 2));
    assert!(planar.warnings().iter().any(|warning| warning.contains("\"stand\" has no mass")));
    let path = common::crate_path("tests/data/biped18.urdf");
    let fixed = Model::load_with_base(&path, Some(Base::Fixed)).unwrap();
    assert_eq!((fixed.nv(), fixed.nq(), fixed.is_planar()), (12, 12, false));
}

#[test]
fn side_file_names_motors() {
    let read =
        |side: &str| Model::from_urdf(PENDULUM_URDF, "p.urdf", Some((side, "p.legwork.toml")), Some(Base::Fixed));
    let names = |model: &Model| model.actuated().map(|j| model.dofs[j].name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&read("gravity_mps2 = 1.62").unwrap()), ["shoulder", "elbow"]);
    assert_eq!(names(&read("actuated = [\"elbow\"]").unwrap()), ["elbow"]);
    assert_eq!(names(&read("passive = [\"elbow\"]").unwrap()), ["shoulder"]);
    assert_close("gravity", &[read("gravity_mps2 = 1.62").unwrap().gravity], &[1.62], 0.0);
}

#[test]
fn springs_and_stops_come_from_either_format() {
    let keys = "spring_nmpr = 20\nrest_deg = 30\nstop_nmpr = 1000\nstop_damping_nmspr = 5";
    let text = PENDULUM_TOML.replace("damping_nmspr = 0.2", &format!("damping_nmspr = 0.2\n{keys}"));
    let toml = Model::from_toml(&text, "p.toml").unwrap();
    let side = format!("{PENDULUM_SIDE}\n[joints.elbow]\n{keys}");
    let urdf = Model::from_urdf(PENDULUM_URDF, "p.urdf", Some((&side, "p.legwork.toml")), None).unwrap();
    assert_eq!(toml.dofs, urdf.dofs);
    assert_eq!(toml, Model::from_toml(&toml.to_toml(), "again.toml").unwrap());

    // elbow: 0.5 rad beyond its end at 2.5 rad, on the way out, fast out, on the way back, fast back
    let mut dynamics = Dynamics::new(&toml);
    let mut at = |q: f64, v: f64| {
        dynamics.update(&toml, &[0.0, q], &[0.0, v]);
        (dynamics.elastic[1], dynamics.damping[1], dynamics.elastic_energy)
    };
    let rest = 30.0_f64.to_radians();
    let spring = |q: f64| (20.0 * (q - rest), 10.0 * (q - rest) * (q - rest));
    let (force, energy) = spring(2.0);
    assert_eq!(at(2.0, 1.0), (force, 0.2, energy));
    for sign in [1.0, -1.0] {
        let q = sign * 3.0;
        let (force, energy) = spring(q);
        for (v, stop_damping) in [(2.0, 10.0), (-2.0, -10.0), (-99.0, -495.0), (-101.0, -500.0)] {
            let (elastic, damping, stored) = at(q, sign * v);
            assert_close("elastic", &[elastic], &[force + sign * 500.0], 1e-15);
            assert_close("energy", &[stored], &[energy + 125.0], 1e-15);
            // The damper of the stop never makes it pull.
            assert_close("damping", &[damping], &[sign * (0.2 * v + stop_damping)], 1e-15);
        }
    }
}

#[test]
fn frames_and_links_are_found_by_name() {
    let side = "frames = [{ name = \"handle\", body = \"lower\", position_m = [0.1, 0, -0.4], rpy_deg = [0, 0, 90] }]";
    let side = Some((side, "p.legwork.toml"));
    let model = Model::from_urdf(PENDULUM_URDF, "p.urdf", side, Some(Base::Fixed)).unwrap();
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &[std::f64::consts::FRAC_PI_2, 0.0], &[0.0, 0.0]);
    // The arm points along x: what is ahead of it at zero is above it then, and y of the handle is −x of the arm
    let handle = dynamics.frame_pose(&model.frame("handle").unwrap());
    assert_close("handle", handle.translation.as_slice(), &[1.0, 0.0, 0.1], 1e-14);
    assert_close("its y axis", handle.rotation.column(1).as_slice(), &[0.0, 0.0, -1.0], 1e-14);
    let link = model.frame("lower").unwrap();
    assert_eq!(dynamics.frame_pose(&link), dynamics.world_from_body[link.body]);
    assert_eq!(model.frame("hand"), None);
}

#[test]
fn urdf_defaults_and_warnings() {
    let model = Model::from_urdf(PENDULUM_URDF, "p.urdf", None, None).unwrap();
    assert_eq!((model.base, model.nc()), (Base::Floating, 0));
    assert_eq!(model.warnings(), ["body \"stand\" has no mass"]);
    let text = PENDULUM_URDF
        .replace("type=\"continuous\"", "type=\"revolute\"")
        .replace("damping=\"0.2\"", "damping=\"0.2\" friction=\"0.3\"");
    let warnings = Model::from_urdf(&text, "p.urdf", None, Some(Base::Fixed)).unwrap().warnings();
    assert_eq!(
        warnings,
        [
            "joint \"shoulder\" has no position, effort and velocity limits",
            "joint \"elbow\": Coulomb friction 0.3 is ignored"
        ]
    );
    let biped = common::biped18();
    assert_eq!(biped.warnings(), ["body \"right_sole\" has no mass", "body \"left_sole\" has no mass"]);
    assert_eq!(biped.bodies[biped.body_index("trunk").unwrap()].joint, Joint::Fixed(Fixed));
    let knee = &biped.dofs[biped.dof_index("right_kfe").unwrap()];
    assert_eq!((knee.lower, knee.upper, knee.effort_limit, knee.velocity_limit), (0.0, 2.3, 220.0, 12.0));
}

/// What xacro, Gazebo and CAD exporters leave in a file.
#[test]
fn urdf_as_found_in_the_wild() {
    let plain = Model::from_urdf(PENDULUM_URDF, "p.urdf", None, Some(Base::Fixed)).unwrap();
    let text = PENDULUM_URDF
        .replace(
            "<robot name=\"double_pendulum\">",
            "<?xml version=\"1.0\" ?>\n<!-- autogenerated by xacro <xacro:include filename=\"x\"/> <link name=\"old\"> -->\n\
             <robot name=\"double_pendulum\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n\
             <material name=\"grey\"><color rgba=\"0.5 0.5 0.5 1\"/></material>",
        )
        .replace(
            "</robot>",
            "<gazebo reference=\"upper\"><mu1>0.2</mu1></gazebo>\n\
             <transmission name=\"t\"><type>simple</type><joint name=\"elbow\"/><actuator name=\"m\"/></transmission>\n\
             </robot>",
        )
        .replace(
            "<visual><geometry><mesh filename=\"package://nowhere/upper.stl\"/></geometry></visual>",
            "<visual name=\"v\"><origin rpy=\"0 0 0\" xyz=\"0 0 0\"/><geometry><cylinder length=\"0.5\" radius=\"0.1\"/></geometry>\
             <material name=\"grey\"/></visual><collision><geometry><box size=\"1 1 1\"/></geometry></collision>\
             <visual><geometry><sphere radius=\"0.1\"/></geometry></visual>",
        );
    let wild = Model::from_urdf(&text, "p.urdf", None, Some(Base::Fixed)).unwrap();
    assert_eq!(plain, wild);
    let windows = text.replace('\n', "\r\n");
    assert_eq!(plain, Model::from_urdf(&windows, "p.urdf", None, Some(Base::Fixed)).unwrap());
}

#[test]
fn oddities_are_warned_of() {
    let warnings = |from: &str, to: &str| {
        assert!(PENDULUM_TOML.contains(from));
        Model::from_toml(&PENDULUM_TOML.replace(from, to), "p.toml").unwrap().warnings()
    };
    let one = |from: &str, to: &str, part: &str| {
        let warnings = warnings(from, to);
        assert!(warnings.len() == 1 && warnings[0].contains(part), "{warnings:?}");
    };
    one("{ xx = 0.02, yy = 0.02, zz = 0.001 }", "{ xx = 0.02, yy = 0.02100001, zz = 0.001 }", "sum of the other two");
    one("lower_rad = -2.5", "lower_rad = 2.5", "locked");
    one("lower_rad = -2.5\nupper_rad = 2.5", "lower_rad = 20\nupper_rad = 90", "are they degrees?");
    one("lower_rad = -2.5\nupper_rad = 2.5", "lower_rad = -90\nupper_rad = 90", "are they degrees?");
    let point = warnings("inertia_kgm2 = { xx = 0.05, yy = 0.05, zz = 0.002 }", "");
    assert_eq!(point, ["body \"upper\" has mass but no inertia: a point mass"]);
}

#[test]
fn a_spring_and_a_stop_of_one_stiffness_are_two() {
    let mut model = Model::from_toml(PENDULUM_TOML, "p.toml").unwrap();
    for (spring, stop) in [(0.0, 0.0), (5.0, 0.0), (0.0, 5.0), (5.0, 5.0)] {
        (model.dofs[0].stiffness, model.dofs[0].stop_stiffness) = (spring, stop);
        assert_eq!(model.is_elastic(), spring + stop > 0.0, "{spring}, {stop}");
    }
}
