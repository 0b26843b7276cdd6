//! What a URDF is read as, and in which words it is refused or warned of: with line, link or joint, and key.

use legwork_rbd::{Base, Dynamics, Model, Shape};
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
fn files_are_read_in_the_encoding_that_they_tell() {
    let folder = std::env::temp_dir().join(format!("legwork-rbd-encodings-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("r.urdf");
    let robot = ROBOT.replace("knee", "Knöchel");
    let units = |mark: u16| std::iter::once(mark).chain(robot.encode_utf16()).collect::<Vec<u16>>();
    let latin = format!("<?xml version=\"1.0\" encoding='ISO-8859-1'?>\n{robot}");
    let cases: [Vec<u8>; 4] = [
        robot.clone().into_bytes(),
        units(0xfeff).into_iter().flat_map(u16::to_le_bytes).collect(),
        units(0xfeff).into_iter().flat_map(u16::to_be_bytes).collect(),
        // All its letters are those of Unicode below 256.
        latin.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect(),
    ];
    for bytes in cases {
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(Model::load(&path).unwrap().dofs[6].name, "Knöchel");
    }
    std::fs::write(&path, robot.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>()).unwrap();
    let message = Model::load(&path).unwrap_err().to_string();
    assert_eq!(message, format!("{}: not UTF-8 text: found UTF-16; save it as UTF-8", path.display()));
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

#[test]
fn what_other_readers_let_pass_is_mended_and_said() {
    warned(
        "  <link name=\"a\">",
        "  <link name=\"a\" name =\n 'c'>",
        &["line 2: a second name in one element is ignored"],
    );
    let prefix = "line 3: the prefix of drake:… is not declared; what has it is ignored";
    warned("<inertial>", "<drake:inertial/><drake:mass drake:of='9'/><inertial>", &[prefix]);
    let both = edited(&[("<mass", "<mass value=\"2\""), ("<dynamics", "<a:b c:d='1'/><dynamics")]);
    assert_eq!(read(&both).unwrap().warnings().len(), 3);
}

#[test]
fn all_that_is_wrong_is_told_at_once() {
    let wrong = [
        ("value=\"2\"", "value=\"two\""),
        (" izz=\"1\"", ""),
        ("0 1 0", "0 0 0"),
        ("0.5", "fast"),
        ("\"50\"", "\"-50\""),
    ];
    let message = read(&edited(&wrong)).unwrap_err();
    for line in [
        "r.urdf: 4 problems:",
        "  r.urdf:5: link \"a\": mass value is \"two\"; a number such as 0.5 is needed",
        "  r.urdf:6: link \"a\": inertia izz is missing",
        "  r.urdf:21: joint \"knee\": dynamics damping is \"fast\"; a number such as 0.5 is needed",
        "  r.urdf:15: joint \"knee\": axis is zero; give a direction, such as [0, -1, 0]",
    ] {
        assert!(message.lines().any(|found| found == line), "{message}");
    }
    let inertia = "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>";
    let message = read(&edited(&[("value=\"2\"", "value=\"two\""), (inertia, "")])).unwrap_err();
    assert!(message.contains("<inertia> is missing") && message.contains("mass value is \"two\""), "{message}");
    let files = Model::from_urdf(
        &edited(&[("value=\"2\"", "value=\"-2\"")]),
        "r.urdf",
        Some(("passive = [\"hip\"]\njoints.knee = { rest_deg = 5 }", "r.legwork.toml")),
        None,
    );
    let message = files.unwrap_err().to_string();
    assert!(
        message.contains("r.legwork.toml: passive: unknown joint") && message.contains("a rest position without"),
        "{message}"
    );
}

/// The robot with a third link that `attributes` of a second joint carry.
fn with_ankle(attributes: &str) -> String {
    let link = "<link name=\"c\"><inertial><origin xyz=\"0.1 0 -0.2\"/><mass value=\"1.5\"/>\
        <inertia ixx=\"0.2\" ixy=\"0\" ixz=\"0\" iyy=\"0.3\" iyz=\"0\" izz=\"0.25\"/></inertial></link>";
    let joint = format!(
        "<joint name=\"ankle\" {attributes}<origin xyz=\"0 0.1 -0.3\" rpy=\"0.2 0 0\"/><parent link=\"b\"/><child link=\"c\"/></joint>"
    );
    edited(&[("</robot>", &format!("{link}{joint}</robot>"))])
}

fn dynamics(model: &Model, q: &[f64], v: &[f64]) -> Dynamics {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q, v);
    dynamics
}

#[test]
fn a_joint_that_mimics_is_coupled_exactly() {
    let text =
        with_ankle("type=\"revolute\"><axis xyz=\"0 1 0\"/><mimic joint=\"knee\" multiplier=\"-2\" offset=\"0.3\"/>");
    let read =
        |side: &str| Model::from_urdf(&text, "r.urdf", Some((side, "r.legwork.toml")), Some(Base::Fixed)).unwrap();
    let (coupled, free, locked) = (read("mimic = \"coupled\""), read("mimic = \"free\""), read("mimic = \"locked\""));
    assert_eq!((coupled.nv(), free.nv(), locked.nv()), (1, 2, 1));
    let said = "a joint mimics another one, and each is coupled exactly, without a coordinate of its own (mimic = \"free\" or \"locked\" in the \
        side file changes that): \"ankle\" follows \"knee\" by -2";
    assert!(coupled.warnings().contains(&said.to_owned()), "{:?}", coupled.warnings());
    // With v = G q̇ the equation of motion is Gᵀ M G q̈ + Gᵀ h.
    let (q, v) = (0.4, 1.7);
    let one = dynamics(&coupled, &[q], &[v]);
    let two = dynamics(&free, &[q, 0.3 - 2.0 * q], &[v, -2.0 * v]);
    let g = nalgebra::DVector::from_vec(vec![1.0, -2.0]);
    assert!((one.mass_matrix[0] - (g.transpose() * &two.mass_matrix * &g)[0]).abs() < 1e-14);
    assert!((one.bias[0] - g.dot(&two.bias)).abs() < 1e-13);
    assert!((one.com - two.com).amax() < 1e-15 && (one.com_velocity - two.com_velocity).amax() < 1e-15);
    let still = dynamics(&locked, &[q], &[v]);
    let held = dynamics(&free, &[q, 0.3], &[v, 0.0]);
    assert!(
        (still.mass_matrix[0] - held.mass_matrix[(0, 0)]).abs() < 1e-14 && (still.bias[0] - held.bias[0]).abs() < 1e-13
    );
    // A fixed joint follows nothing.
    let fixed =
        Model::from_urdf(&with_ankle("type=\"fixed\"><mimic joint=\"knee\"/>"), "r.urdf", None, Some(Base::Fixed))
            .unwrap();
    assert_eq!(fixed.nv(), 1);
    assert_eq!(Model::from_toml(&coupled.to_toml(), "r.toml").unwrap().to_toml(), coupled.to_toml());
}

#[test]
fn a_planar_joint_slides_and_turns_in_the_plane_across_its_axis() {
    let model = read(&with_ankle("type=\"planar\"><axis xyz=\"0 0 2\"/>")).unwrap();
    assert_eq!(model.v_names(), ["knee", "ankle_x", "ankle_y", "ankle"]);
    let place = |q: [f64; 4]| {
        let moved = dynamics(&model, &q, &[0.0; 4]);
        let [b, c] = ["b", "c"].map(|body| moved.world_from_body[model.body_index(body).unwrap()]);
        (b.rotation.transpose() * (c.translation - b.translation), b.rotation.transpose() * c.rotation)
    };
    let (at_zero, axes) = place([0.0; 4]);
    let (moved, turned) = place([0.0, 0.25, -0.5, 0.7]);
    let expected = axes * nalgebra::Vector3::new(0.25, -0.5, 0.0);
    assert!((moved - at_zero - expected).amax() < 1e-15, "{moved}");
    let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), 0.7).into_inner();
    assert!((turned - axes * turn).amax() < 1e-15);
}

#[test]
fn a_floating_joint_below_a_link_without_mass_is_the_base() {
    let world = "<link name=\"world\"/><joint name=\"free\" type=\"floating\"><parent link=\"world\"/><child link=\"a\"/></joint></robot>";
    let text = edited(&[("</robot>", world)]);
    let model = Model::from_urdf(&text, "r.urdf", None, None).unwrap();
    let plain = Model::from_urdf(ROBOT, "r.urdf", None, None).unwrap();
    assert_eq!(model.to_toml(), plain.to_toml());
    assert!(
        model.warnings()[0].contains("joint \"free\" of type floating is taken as the robot's base"),
        "{:?}",
        model.warnings()
    );
    // On a base that is bolted down it is a joint as others are: the same dynamics with other names.
    let fixed = read(&text).unwrap();
    assert_eq!((fixed.nq(), fixed.nv()), (8, 7));
    let (q, v) = ([0.5, -0.5, 0.1, 0.7, 1.0, 2.0, 3.0, 0.4], [0.1, -0.2, 0.3, 0.4, -0.5, 0.6, 0.7]);
    assert!((dynamics(&fixed, &q, &v).bias.clone() - &dynamics(&plain, &q, &v).bias).amax() < 1e-12);
}

#[test]
fn an_inertia_that_no_body_has_is_kept_with_a_warning_or_repaired() {
    let thin = edited(&[("izz=\"1\"", "izz=\"2.5\"")]);
    let read = |side: &str| Model::from_urdf(&thin, "r.urdf", Some((side, "s.toml")), Some(Base::Fixed)).unwrap();
    let (kept, repaired) = (read("inertias = \"kept\""), read("inertias = \"repaired\""));
    let warning = "body \"a\": no body has this inertia: a principal moment of 2.500e0 kg m² is larger than the sum of the other two, \
        2.000e0; it is kept as it is (inertias = \"repaired\" changes it to the nearest that a body can have)";
    assert_eq!(kept.warnings(), [warning]);
    assert_eq!(kept.bodies[0].inertia, nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, 2.5)));
    // Σ = diag(1.25, 1.25, −0.25) loses its negative part: I = tr(Σ) 1 − Σ.
    let nearest = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.25, 1.25, 2.5));
    assert!((repaired.bodies[0].inertia - nearest).amax() < 1e-15, "{}", repaired.bodies[0].inertia);
    assert!(repaired.warnings()[0].contains("it is changed to the nearest"), "{:?}", repaired.warnings());
    // A negative moment about the joint's axis that the link's distance from it makes up for, and one that nothing does.
    let negative = |value: &str| {
        edited(&[
            (
                "iyy=\"1\" iyz=\"0\" izz=\"1\"/>\n    </inertial>\n  </link>\n  <joint",
                &format!("iyy=\"{value}\" iyz=\"0\" izz=\"1\"/>\n    </inertial>\n  </link>\n  <joint"),
            ),
            ("<mass value=\"3.5\"", "<origin xyz=\"1 0 0\"/><mass value=\"3.5\""),
        ])
    };
    assert!(self::read(&negative("-1")).is_ok());
    let message = self::read(&negative("-4")).unwrap_err();
    assert!(message.contains("joint \"knee\": moves no inertia about its axis"), "{message}");
    let dummy = edited(&[("<mass value=\"2\"", "<mass value=\"0\"")]);
    let warnings = self::read(&dummy).unwrap().warnings();
    assert!(warnings[0].starts_with("body \"a\": has an inertia but no mass; it is kept"), "{warnings:?}");
}
