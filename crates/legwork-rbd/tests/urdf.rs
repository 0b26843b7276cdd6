//! What a URDF is read as, and in which words it is refused or warned of: with line, link or joint, and key.

use legwork_rbd::{Base, Model, Shape};
use nalgebra::Vector3;

const ROBOT: &str = r#"<robot name="r">
  <link name="a">
    <inertial>
      <origin xyz="0 0 0.1" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
  </link>
  <link name="b">
    <inertial>
      <mass value="3.5"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
  </link>
  <joint name="knee" type="revolute">
    <origin xyz="0 0 -0.4"/>
    <parent link="a"/>
    <child link="b"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="50" velocity="10"/>
    <dynamics damping="0.5"/>
  </joint>
</robot>
"#;

fn read(text: &str) -> Result<Model, String> {
    Model::from_urdf(text, "r.urdf", None, Some(Base::Fixed)).map_err(|error| error.to_string())
}

/// The robot with each `from` replaced by its `to` once.
#[track_caller]
fn edited(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(ROBOT.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

#[track_caller]
fn refused(from: &str, to: &str, message: &str) {
    assert_eq!(read(&edited(&[(from, to)])).unwrap_err(), format!("r.urdf:{message}"));
}

/// That the robot is still the same but for the warnings.
#[track_caller]
fn warned(from: &str, to: &str, warnings: &[&str]) {
    let model = read(&edited(&[(from, to)])).unwrap();
    assert_eq!(model.warnings(), warnings);
    assert_eq!(model.to_toml(), read(ROBOT).unwrap().to_toml());
}

#[test]
fn shapes_that_touch_are_handed_on_and_broken_ones_left_out() {
    let collision = |name: &str, shape: &str| {
        format!("<collision name=\"{name}\"><origin xyz=\"0 0 -0.1\"/><geometry>{shape}</geometry></collision>")
    };
    let shapes = [
        collision("sole", "<box size=\"0.2 0.1 0.04\"/>"),
        collision("ball", "<sphere radius=\"0.1\"/>"),
        collision("rod", "<cylinder radius=\"0.1\" length=\"0.5\"/>"),
        collision("broken", "<box size=\"0.2 0.1\"/>"),
        collision("picture", "<mesh filename=\"package://a/b.stl\"/>"),
        "<collision/><collision><geometry/></collision><visual><geometry><sphere/></geometry></visual>".to_owned(),
    ];
    let text = edited(&[("<link name=\"b\">", &format!("<link name=\"b\">{}", shapes.concat()))]);
    let (model, roles) = Model::from_urdf_with_roles(&text, "r.urdf", None, None).unwrap();
    assert!(model.warnings().is_empty(), "{:?}", model.warnings());
    let expected = [
        ("sole", Shape::Box { half_sizes: Vector3::new(0.1, 0.05, 0.02) }),
        ("ball", Shape::Sphere { radius: 0.1 }),
        ("rod", Shape::Cylinder { radius: 0.1, half_length: 0.25 }),
        ("picture", Shape::Mesh { file: "package://a/b.stl".to_owned(), scale: Vector3::repeat(1.0) }),
    ];
    let found: Vec<_> = roles.geometry.iter().map(|shape| (shape.name.as_str(), shape.shape.clone())).collect();
    assert_eq!(found, expected);
    assert!(
        roles.geometry.iter().all(|shape| shape.body == "b" && shape.collides && shape.placement.translation.z == -0.1)
    );
}

#[test]
fn numbers_are_refused_with_link_or_joint_and_key() {
    for (text, needed) in [
        ("2,5", "a number such as 0.5 is needed"),
        ("0x10", "a number such as 0.5 is needed"),
        ("${mass}", "a number such as 0.5 is needed"),
        ("", "a number such as 0.5 is needed"),
        ("1 2", "a number such as 0.5 is needed"),
        ("nan", "a number such as 0.5 is needed"),
        ("inf", "a finite number is needed"),
        ("1e400", "a finite number is needed"),
    ] {
        let edit = |key: &str| format!("{key}=\"{text}\"");
        refused("value=\"2\"", &edit("value"), &format!("5: link \"a\": mass value is {text:?}; {needed}"));
        refused("iyz=\"0\"", &edit("iyz"), &format!("6: link \"a\": inertia iyz is {text:?}; {needed}"));
        let damping = format!("21: joint \"knee\": dynamics damping is {text:?}; {needed}");
        refused("damping=\"0.5\"", &edit("damping"), &damping);
        // An infinite limit is none.
        if needed.contains("0.5") {
            for (key, given) in [("lower", "-1"), ("upper", "2"), ("effort", "50"), ("velocity", "10")] {
                let message = format!("20: joint \"knee\": limit {key} is {text:?}; {needed}");
                refused(&format!("{key}=\"{given}\""), &edit(key), &message);
            }
        }
    }
    for text in ["0 1", "0 1 0 0", "0 1,0 0", "0, 1, 0", "0 one 0", "0 nan 0", "0 1e400 0", ""] {
        let needed = "3 finite numbers with blanks between them are needed";
        let origin = format!("16: joint \"knee\": origin xyz is {text:?}; {needed}");
        refused("xyz=\"0 0 -0.4\"", &format!("xyz=\"{text}\""), &origin);
        let rpy = format!("4: link \"a\": origin rpy is {text:?}; {needed}");
        refused("rpy=\"0 0 0\"", &format!("rpy=\"{text}\""), &rpy);
        let axis = format!("19: joint \"knee\": axis xyz is {text:?}; {needed}");
        refused("xyz=\"0 1 0\"", &format!("xyz=\"{text}\""), &axis);
    }
    let zero = "15: joint \"knee\": axis is zero; give a direction, such as [0, -1, 0]";
    refused("xyz=\"0 1 0\"", "xyz=\"0 0 0\"", zero);
    // The line is that of the attribute, not of its element.
    refused(
        "value=\"2\"",
        "\n\n  value=\"two\"",
        "7: link \"a\": mass value is \"two\"; a number such as 0.5 is needed",
    );
}

#[test]
fn what_is_missing_or_given_twice_is_named() {
    refused("<link name=\"a\"", "<link", "2: robot: link name is missing");
    refused("<joint name=\"knee\"", "<joint", "15: robot: joint name is missing");
    refused(" type=\"revolute\"", "", "15: joint \"knee\": joint type is missing");
    refused("<parent link=\"a\"/>", "", "15: joint \"knee\": <parent> is missing in <joint>");
    refused("<child link=\"b\"/>", "", "15: joint \"knee\": <child> is missing in <joint>");
    refused("<parent link=\"a\"/>", "<parent/>", "17: joint \"knee\": parent link is missing");
    refused("<child link=\"b\"/>", "<child name=\"b\"/>", "18: joint \"knee\": child link is missing");
    refused("<axis xyz=\"0 1 0\"/>", "<axis/>", "19: joint \"knee\": axis xyz is missing");
    refused("<mass value=\"2\"/>", "<mass/>", "5: link \"a\": mass value is missing");
    refused("<mass value=\"2\"/>", "", "3: link \"a\": <mass> is missing in <inertial>");
    refused(" izz=\"1\"", "", "6: link \"a\": inertia izz is missing");
    let inertia = "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>";
    refused(inertia, "", "3: link \"a\": <inertia> is missing in <inertial>");
    refused("<inertial>", "<inertial/>\n<inertial>", "4: link \"a\": a second <inertial>; give one");
    refused("<mass", "<mass value=\"1\"/><mass", "5: link \"a\": a second <mass>; give one");
    for element in ["origin", "parent", "child", "axis", "limit", "dynamics"] {
        let first = format!("<{element} ");
        let edits = [("<joint", "<JOINT"), (&first, &format!("<{element}/>\n    {first}"))];
        // The origin of the link comes first.
        let text = edited(&edits[..1]);
        let (links, joint) = text.split_once("<JOINT").unwrap();
        let text = format!("{links}<joint{}", joint.replacen(edits[1].0, edits[1].1, 1));
        let line = 1 + text[..text.rfind(&first).unwrap()].matches('\n').count();
        assert_eq!(read(&text).unwrap_err(), format!("r.urdf:{line}: joint \"knee\": a second <{element}>; give one"));
    }
    let mimic = "<mimic joint=\"hip\"/><mimic joint=\"hip\"/><axis";
    refused("<axis", mimic, "19: joint \"knee\": a second <mimic>; give one");
    refused("<axis", "<mimic/><axis", "19: joint \"knee\": mimic joint is missing");
}

#[test]
fn text_that_is_no_urdf_is_refused_with_its_line() {
    refused(
        "  <link name=\"a\">",
        "  <link name=\"a\" name=\"c\">",
        "2: cannot be read as URDF: attribute 'name' at 2:18 is already defined",
    );
    refused("</link>", "</lnk>", "8: cannot be read as URDF: expected 'link' tag, not 'lnk' at 8:3");
    refused("<mass", "<mass &m;", "5: cannot be read as URDF: invalid name token at 5:13");
    refused(
        "<mass value=\"2\"",
        "<mass value=\"&m;\"",
        "5: cannot be read as URDF: unknown entity reference 'm' at 5:20",
    );
    refused("</robot>", "", " cannot be read as URDF: the text ends within an element");
    refused(
        "<robot name=\"r\">",
        "<robots name=\"r\">",
        "23: cannot be read as URDF: expected 'robots' tag, not 'robot' at 23:1",
    );
    let dtd = " holds a document type (<!DOCTYPE …>), which is not read; take it out";
    refused("<robot", "<!-- -->\n<!DOCTYPE robot [<!ENTITY m \"2\">]>\n<robot", &format!("2:{dtd}"));
    let xacro = " holds xacro macros; expand them first (xacro robot.xacro > robot.urdf)";
    refused("<inertial>", "<xacro:inertial/>", &format!("3:{xacro}"));
    let declared =
        [("<robot", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\""), ("<mass", "<xacro:if/>\n<mass")];
    assert_eq!(read(&edited(&declared)).unwrap_err(), format!("r.urdf:5:{xacro}"));
    let prefix = "3: the prefix of drake:… is not declared; add xmlns:drake=\"…\" to <robot>";
    refused("<inertial>", "<drake:inertial/>", prefix);
    let sdf = "<sdf>\n<robot/></sdf>";
    assert_eq!(read(sdf).unwrap_err(), "r.urdf:1: the outermost element is <sdf>; that of a URDF is <robot>");
    for nested in [100, 100_000] {
        let deep = format!("<robot name='r'>\n{}{}</robot>", "<a>".repeat(nested), "</a>".repeat(nested));
        let message = "r.urdf:2: elements are nested more than 100 deep, which no URDF needs";
        assert_eq!(read(&deep).unwrap_err(), message);
    }
}

#[test]
fn blanks_marks_and_line_ends_are_of_no_matter() {
    let plain = read(ROBOT).unwrap();
    assert_eq!(plain.warnings(), Vec::<String>::new());
    for text in [
        ROBOT.replace('\n', "\r\n"),
        format!("\u{feff}{ROBOT}"),
        format!("\u{feff}<?xml version=\"1.0\"?>{ROBOT}"),
        format!("\n <?xml version=\"1.0\"?>\n{ROBOT}"),
        format!("<!-- of a tool -->\n<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n{ROBOT}"),
        ROBOT.replace('"', "'"),
        ROBOT.replace("0 0 -0.4", "\t0\n 0\r\n\u{a0}-.4 "),
        ROBOT.replace("\"3.5\"", "\" +3.5e0\n\""),
        ROBOT.replace("\"2\"", "\"&#50;.\""),
        ROBOT.replace("<mass", "words <![CDATA[<mass value='9'/>]]> <!-- <mass value='9'/> --> <?tool?> <mass"),
    ] {
        assert_eq!(read(&text).unwrap(), plain, "{text}");
    }
    let late = format!("\n\n<?xml version=\"1.0\"?>\n{}", ROBOT.replace("\"3.5\"", "\"x\""));
    assert!(read(&late).unwrap_err().starts_with("r.urdf:14: link \"b\": mass value is \"x\""));
}

#[test]
fn files_in_utf_16_are_named() {
    let folder = std::env::temp_dir().join(format!("legwork-rbd-utf-16-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("r.urdf");
    let little: Vec<u8> = ROBOT.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = ROBOT.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for bytes in [
        little.clone(),
        [&[0xff, 0xfe], little.as_slice()].concat(),
        big.clone(),
        [&[0xfe, 0xff], big.as_slice()].concat(),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let message = Model::load(&path).unwrap_err().to_string();
        assert_eq!(message, format!("{}: not UTF-8 text: found UTF-16; save it as UTF-8", path.display()));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_has_no_meaning_is_warned_of() {
    let known = "known are origin, parent, child, axis, limit, dynamics, mimic, calibration";
    let ignored = format!("<safety_controller> in <joint> is ignored; {known}");
    warned(
        "<dynamics",
        "<safety_controller k_velocity=\"1\"/><dynamics",
        &[&format!("joint \"knee\" (line 21): {ignored}")],
    );
    let twice = "<safety_controller/><safety_controller/><dynamics";
    warned("<dynamics", twice, &[&format!("joint \"knee\" (line 21) and 1 more: {ignored}")]);
    let key = "joint \"knee\" (line 20): limit uper is ignored; known are lower, upper, effort, velocity";
    warned("<limit", "<limit uper=\"9\"", &[key]);
    let key = "joint \"knee\" (line 20): limit acceleration is ignored; known are lower, upper, effort, velocity";
    warned("<limit", "<limit acceleration=\"9\"", &[key]);
    let key = "link \"a\" (line 4): origin quat_xyzw is ignored; known are xyz, rpy";
    warned("rpy=\"0 0 0\"", "quat_xyzw=\"1 0 0 0\"", &[key]);
    let element = "link \"a\" (line 5): <density> in <inertial> is ignored; known are origin, mass, inertia";
    warned("<mass", "<density/><mass", &[element]);
    let element = "joint \"knee\" (line 19): <unit> in <axis> is ignored";
    warned("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"><unit/></axis>", &[element]);
    let element = "robot (line 2): <lnk> in <robot> is ignored; known are link, joint, material, gazebo, transmission, \
                   ros2_control, sensor, mujoco";
    warned("<link", "<lnk/><link", &[element]);
    let inertial =
        "link \"a\" (line 3): <inertail> in <link> is ignored; known are inertial, visual, collision, sensor, contact";
    let model = read(&ROBOT.replacen("<inertial>", "<inertail>", 1).replacen("</inertial>", "</inertail>", 1)).unwrap();
    assert_eq!(model.warnings(), [inertial]);
    assert_eq!(model.bodies[0].mass, 0.0);
    // Of extensions, pictures and controllers there is nothing to say.
    let silent = "<robot xmlns:drake=\"d\" version=\"1.0\" name=\"r\"><drake:joint name=\"knee\"/><gazebo/><material/>\
                  <transmission><joint name=\"knee\"/></transmission>";
    warned("<robot name=\"r\">", silent, &[]);
    warned("<parent", "<calibration rising=\"0\"/><drake:limit lower=\"5\" xmlns:drake=\"d\" /><parent", &[]);
    let shapes = "<inertial xmlns:drake=\"d\" drake:kind=\"x\">";
    let visual = "<visual><geometry><mesh/></geometry><material><texture filename=\"\"/><color rgba=\"0 0 0\"/></material></visual>";
    warned("<inertial>", &format!("{visual}{}<inertial>", visual.replace("visual", "collision")), &[]);
    warned("<inertial>", shapes, &[]);
}

#[test]
fn what_a_file_leaves_out_is_what_the_specification_says() {
    let bare = edited(&[
        ("<origin xyz=\"0 0 -0.4\"/>", ""),
        ("<axis xyz=\"0 1 0\"/>", ""),
        ("<dynamics damping=\"0.5\"/>", ""),
    ]);
    let model = read(&bare).unwrap();
    let (link, dof) = (&model.bodies[1], &model.dofs[0]);
    assert_eq!(link.placement, legwork_rbd::Placement::identity());
    assert_eq!(link.joint.axis().unwrap().as_slice(), [1.0, 0.0, 0.0]);
    assert_eq!((dof.damping, dof.lower, dof.upper, dof.effort_limit, dof.velocity_limit), (0.0, -1.0, 2.0, 50.0, 10.0));
    assert_eq!(read(ROBOT).unwrap().bodies[0].com.as_slice(), [0.0, 0.0, 0.1]);
}

/// Ends, effort limit and velocity limit of the knee with these attributes of `<limit>`, and the warnings.
fn limits(robot: &str, kind: &str, limit: &str, side: &str) -> ([f64; 4], Vec<String>) {
    let limit = if limit.is_empty() { String::new() } else { format!("<limit {limit}/>") };
    let text = edited(&[
        ("<robot", robot),
        ("revolute", kind),
        ("<limit lower=\"-1\" upper=\"2\" effort=\"50\" velocity=\"10\"/>", &limit),
    ]);
    let model = Model::from_urdf(&text, "r.urdf", Some((side, "r.legwork.toml")), None).unwrap();
    let dof = model.dofs.last().unwrap();
    ([dof.lower, dof.upper, dof.effort_limit, dof.velocity_limit], model.warnings())
}

#[test]
fn a_limit_that_is_missing_and_one_of_zero_are_told_apart() {
    const NONE: f64 = f64::INFINITY;
    let side = "base = \"fixed\"";
    let without = |what: &str| format!("joint \"knee\" has no {what} limits");
    let no_effort = "joint \"knee\" can give no effort: its effort limit is 0; leave it out for no limit".to_owned();
    let no_speed = "joint \"knee\": a velocity limit of 0 is taken as none".to_owned();
    let all = without("position, effort and velocity");
    for (kind, limit, side, found, warnings) in [
        ("revolute", "", side, [-NONE, NONE, NONE, NONE], vec![all.clone()]),
        ("prismatic", "", side, [-NONE, NONE, NONE, NONE], vec![all]),
        ("continuous", "", side, [-NONE, NONE, NONE, NONE], vec![]),
        ("continuous", "lower='-1' upper='1' effort='5' velocity='3'", side, [-NONE, NONE, 5.0, 3.0], vec![]),
        ("continuous", "effort='5'", side, [-NONE, NONE, 5.0, NONE], vec![without("velocity")]),
        ("revolute", "lower='-1' upper='1'", side, [-1.0, 1.0, NONE, NONE], vec![without("effort and velocity")]),
        ("revolute", "lower='-1' effort='5' velocity='3'", side, [-1.0, 0.0, 5.0, 3.0], vec![]),
        ("revolute", "upper='1' effort='5' velocity='3'", side, [0.0, 1.0, 5.0, 3.0], vec![]),
        ("revolute", "effort='5' velocity='3'", side, [-NONE, NONE, 5.0, 3.0], vec![without("position")]),
        (
            "revolute",
            "lower='0' upper='0' effort='5' velocity='3'",
            side,
            [-NONE, NONE, 5.0, 3.0],
            vec![without("position")],
        ),
        ("revolute", "lower='-inf' upper='inf' effort='inf' velocity='inf'", side, [-NONE, NONE, NONE, NONE], vec![]),
        (
            "revolute",
            "lower='-1' upper='1' effort='0' velocity='3'",
            side,
            [-1.0, 1.0, 0.0, 3.0],
            vec![no_effort.clone()],
        ),
        ("revolute", "lower='-1' upper='1' effort='5' velocity='0'", side, [-1.0, 1.0, 5.0, NONE], vec![no_speed]),
        // What the side file says counts, and a joint without a motor needs neither effort nor velocity.
        (
            "revolute",
            "",
            "base = \"fixed\"\npassive = [\"knee\"]",
            [-NONE, NONE, NONE, NONE],
            vec![without("position")],
        ),
        (
            "revolute",
            "effort='0'",
            "base = \"fixed\"\npassive = [\"knee\"]",
            [-NONE, NONE, 0.0, NONE],
            vec![without("position")],
        ),
        (
            "revolute",
            "lower='0' upper='0' effort='0' velocity='0'",
            "base = \"fixed\"\njoints.knee = { lower_rad = -1, upper_rad = 1, max_torque_nm = 7, max_velocity_radps = 8 }",
            [-1.0, 1.0, 7.0, 8.0],
            vec![],
        ),
        (
            "revolute",
            "",
            "base = \"fixed\"\njoints.knee = { max_torque_nm = 0 }",
            [-NONE, NONE, 0.0, NONE],
            vec![without("position and velocity"), no_effort],
        ),
    ] {
        assert_eq!(limits("<robot", kind, limit, side), (found, warnings), "{kind} {limit} {side}");
    }
    // Since version 1.2 an end that is left out is none.
    let (found, warnings) = limits("<robot version=\"1.2\"", "revolute", "lower='-1' effort='5' velocity='3'", side);
    assert_eq!((found, warnings), ([-1.0, NONE, 5.0, 3.0], vec![]));
}

#[test]
fn zero_limits_mean_the_same_in_toml() {
    let text = r#"
        name = "r"
        base = "fixed"
        [[bodies]]
        name = "a"
        [[bodies]]
        name = "b"
        parent = "a"
        mass_kg = 1
        inertia_kgm2 = { xx = 1, yy = 1, zz = 1 }
        joint = { name = "knee", type = "revolute", axis = [0, 1, 0], max_torque_nm = 0, max_velocity_radps = 0 }
    "#;
    let model = Model::from_toml(text, "r.toml").unwrap();
    assert_eq!((model.dofs[0].effort_limit, model.dofs[0].velocity_limit), (0.0, f64::INFINITY));
    let no_speed = "joint \"knee\": a velocity limit of 0 is taken as none";
    let no_effort = "joint \"knee\" can give no effort: its effort limit is 0; leave it out for no limit";
    assert_eq!(model.warnings(), [no_speed, no_effort]);
    let again = Model::from_toml(&model.to_toml(), "again.toml").unwrap();
    assert_eq!((again.to_toml(), again.dofs[0].effort_limit), (model.to_toml(), 0.0));
}

/// Since version 1.1 of the format: a quarter turn about z carries x to y.
#[test]
fn an_origin_may_be_turned_by_a_quaternion() {
    let quarter = "<origin xyz=\"0 0 -0.4\" quat_xyzw=\"0 0 1e200 1e200\"/>";
    let origin = "<origin xyz=\"0 0 -0.4\"/>";
    let version = ("<robot", "<robot version=\"1.1\"");
    let model = read(&edited(&[version, (origin, quarter)])).unwrap();
    assert_eq!(model.warnings(), Vec::<String>::new());
    let x = model.bodies[1].placement.rotation * nalgebra::Vector3::x();
    assert!((x - nalgebra::Vector3::y()).norm() < 1e-15, "{x}");
    let error = |to: &str| read(&edited(&[version, (origin, to)])).unwrap_err();
    let both = "r.urdf:16: joint \"knee\": origin rpy and quat_xyzw are both given; give one";
    assert_eq!(error("<origin rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\"/>"), both);
    let zero = "r.urdf:16: joint \"knee\": origin quat_xyzw is zero; give a rotation, such as \"0 0 0 1\"";
    assert_eq!(error("<origin quat_xyzw=\"0 0 0 0\"/>"), zero);
    let three = "r.urdf:16: joint \"knee\": origin quat_xyzw is \"0 0 1\"; 4 finite numbers with blanks between them are needed";
    assert_eq!(error("<origin quat_xyzw=\"0 0 1\"/>"), three);
}

/// Messages have at most a few hundred characters, whatever the file holds.
#[test]
fn messages_stay_short() {
    let links: String = (0..4000).map(|i| format!("<link name=\"link_{i}\"/>")).collect();
    let stray = format!(
        "<robot name=\"r\">{links}<joint name=\"j\" type=\"fixed\"><parent link=\"x\"/><child link=\"link_1\"/></joint></robot>"
    );
    let message = read(&stray).unwrap_err();
    let begin = "r.urdf:1: joint \"j\": unknown parent link \"x\"; valid are link_0, link_1, link_2, ";
    assert!(message.starts_with(begin) && message.ends_with("link_30, link_31 and 3968 more"), "{message}");
    let many_roots = format!("<robot name=\"r\">{links}</robot>");
    let message = read(&many_roots).unwrap_err();
    assert!(
        message.starts_with("r.urdf:1: body \"link_1\": 4000 bodies have no parent (link_0, link_1, "),
        "{message}"
    );
    assert!(message.ends_with(" and 3968 more); a robot has one root"), "{message}");
    let long = "x".repeat(100_000);
    for (from, to) in [
        ("\"a\"", format!("\"{long}\"")),
        ("value=\"2\"", format!("value=\"{long}\"")),
        ("<link", format!("<{long}/><link")),
        ("type=\"revolute\"", format!("type=\"{long}\"")),
        ("</robot>", format!("</{long}>")),
        ("<mass", format!("<{long}:mass/><mass")),
    ] {
        let text = match read(&edited(&[(from, &to)])) {
            Ok(model) => model.warnings().concat(),
            Err(message) => message,
        };
        assert!(text.chars().count() <= 600, "{} characters: {}", text.len(), &text[..600]);
    }
}

/// Neither is a body sought among all others, nor is there a matrix of the square of their number: that would be 7 GB.
#[test]
fn long_chains_are_read() {
    let mut text = String::from("<robot name=\"chain\"><link name=\"b0\"/>");
    for i in 1..30_000 {
        text += &format!(
            "<link name=\"b{i}\"><inertial><mass value=\"1\"/>\
             <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\
             <joint name=\"j{i}\" type=\"continuous\"><parent link=\"b{}\"/><child link=\"b{i}\"/></joint>",
            i - 1
        );
    }
    let model = read(&(text + "</robot>")).unwrap();
    assert_eq!((model.nv(), model.bodies.last().unwrap().parent), (29_999, Some(29_998)));
    let again = Model::from_toml(&model.to_toml(), "again.toml").unwrap();
    assert_eq!(again.bodies, model.bodies);
}
