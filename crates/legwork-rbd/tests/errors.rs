//! Every refusal: what it says, where, and that nothing panics.

mod common;

use legwork_rbd::{Base, Model, ModelError};
use proptest::prelude::*;

const TOML: &str = include_str!("data/double_pendulum.toml");
const URDF: &str = include_str!("data/biped18.urdf");

/// Reads the pendulum with `from` replaced by `to` and returns the message.
#[track_caller]
fn toml_error(from: &str, to: &str) -> String {
    assert!(TOML.contains(from), "{from}");
    let error = Model::from_toml(&TOML.replacen(from, to, 1), "robot.toml").unwrap_err();
    assert!(!error.is_io());
    error.to_string()
}

#[track_caller]
fn urdf_error(from: &str, to: &str) -> String {
    assert!(URDF.contains(from), "{from}");
    Model::from_urdf(&URDF.replacen(from, to, 1), "robot.urdf", None, None).unwrap_err().to_string()
}

#[track_caller]
fn side_error(side: &str) -> String {
    Model::from_urdf(URDF, "robot.urdf", Some((side, "robot.legwork.toml")), None).unwrap_err().to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{message:?} does not say {part:?}");
    }
}

#[test]
fn numbers() {
    says(&toml_error("mass_kg = 1.3", "mass_kg = nan"), &["robot.toml:12: body \"upper\": mass_kg is NaN", "finite"]);
    says(&toml_error("mass_kg = 1.3", "mass_kg = inf"), &["mass_kg is inf"]);
    says(&toml_error("mass_kg = 1.3", "mass_kg = -1"), &["body \"upper\": mass -1 kg is negative"]);
    says(&toml_error("com_m = [0.0, 0.0, -0.2]", "com_m = [0.0, nan, -0.2]"), &["body \"lower\": com_m is NaN"]);
    says(&toml_error("xx = 0.05", "xx = nan"), &["body \"upper\": inertia_kgm2 is NaN"]);
    says(&toml_error("lower_rad = -2.5", "lower_rad = nan"), &["joint \"elbow\": lower_rad is NaN"]);
    says(&toml_error("position_m = [0.0, 0.0, -0.4]", "position_m = [0.0, 0.0, inf]"), &["contact \"tip\"", "inf"]);
    says(&toml_error("gravity_mps2 = 9.81", "gravity_mps2 = nan"), &["gravity_mps2: NaN"]);
    says(&toml_error("gravity_mps2 = 9.81", "gravity_mps2 = -9.81"), &["gravity_mps2: -9.81", "not negative"]);
    says(&toml_error("max_torque_nm = 30", "max_torque_nm = -30"), &["joint \"elbow\": effort limit -30"]);
    says(&toml_error("damping_nmspr = 0.2", "damping_nmspr = -0.2"), &["joint \"elbow\": damping -0.2 is negative"]);
    says(&toml_error("origin_m = [0.0, 0.0, -0.6]", "origin_m = [0.0, nan, 0]"), &["origin_m is NaN"]);
}

#[test]
fn masses_and_inertias() {
    let massless = TOML.replace("mass_kg = 0.7", "").replace("inertia_kgm2 = { xx = 0.02, yy = 0.02, zz = 0.001 }", "");
    let error = Model::from_toml(&massless, "robot.toml").unwrap_err().to_string();
    says(&error, &["robot.toml:30: joint \"elbow\": moves no mass", "\"lower\"", "fix the joint"]);
    says(
        &toml_error("{ xx = 0.05, yy = 0.05, zz = 0.002 }", "0.05"),
        &["body \"upper\"", "only a planar model", "xx, yy, zz"],
    );
    says(
        &toml_error("{ xx = 0.05, yy = 0.05, zz = 0.002 }", "{ xx = 0.05 }"),
        &["robot.toml:17", "missing field `yy`"],
    );
    says(
        &toml_error("{ xx = 0.05, yy = 0.05, zz = 0.002 }", "\"much\""),
        &["robot.toml:17", "a number (about y, planar models) or a table"],
    );
    let no_inertia =
        TOML.replace("com_m = [0.0, 0.0, -0.2]", "").replace("inertia_kgm2 = { xx = 0.02, yy = 0.02, zz = 0.001 }", "");
    let error = Model::from_toml(&no_inertia, "robot.toml").unwrap_err().to_string();
    says(&error, &["joint \"elbow\": moves no inertia about its axis"]);
}

#[test]
fn joints_and_limits() {
    says(
        &toml_error("lower_rad = -2.5", "lower_rad = 2.6"),
        &["robot.toml:30: joint \"elbow\": limits are crossed: lower 2.600000 rad (148.97 deg) is above upper"],
    );
    says(
        &toml_error("lower_rad = -2.5", "lower_rad = -2.5\nlower_deg = -100"),
        &["lower_deg and lower_rad are both given"],
    );
    says(&toml_error("axis = [0, -1, 0]", "axis = [0, 0, 0]"), &["joint \"shoulder\": axis is zero"]);
    says(&toml_error("axis = [0, -1, 0]", ""), &["joint \"shoulder\": axis is missing"]);
    says(
        &toml_error("type = \"revolute\"", "type = \"screw\""),
        &["robot.toml:20", "screw", "`fixed`, `revolute`, `prismatic`"],
    );
    says(
        &toml_error("lower_rad = -2.5", "lower_m = -2.5"),
        &["joint \"elbow\": lower_m has no meaning for a revolute joint", "lower_deg"],
    );
    says(
        &toml_error("damping_nmspr = 0.1", "origin_rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
        &["no rotation matrix"],
    );
    says(
        &toml_error("damping_nmspr = 0.1", "origin_rotation = [[1, 0, 0], [0, 1, 0], [0, 0, nan]]"),
        &["no rotation matrix"],
    );
    says(&toml_error("parent = \"stand\"", ""), &["\"upper\" has no parent"]);
    let placed = "name = \"stand\"\njoint = { name = \"m\", type = \"fixed\", origin_m = [1, 0, 0] }";
    let moving = TOML.replace("name = \"stand\"", placed).replace("\"fixed\"\ngravity", "\"floating\"\ngravity");
    says(
        &Model::from_toml(&moving, "robot.toml").unwrap_err().to_string(),
        &["joint \"m\"", "only with base = \"fixed\""],
    );
    says(
        &toml_error("contacts = [", "base_pitch = { lower_deg = -90 }\ncontacts = ["),
        &["base_pitch: limits of a planar base"],
    );
}

#[test]
fn springs_and_stops() {
    let joint = |keys: &str| toml_error("damping_nmspr = 0.1", keys);
    says(&joint("spring_nmpr = -1"), &["robot.toml:18: joint \"shoulder\": the spring's stiffness -1 is negative"]);
    says(&joint("spring_nmpr = inf"), &["joint \"shoulder\": spring_nmpr is inf"]);
    says(&joint("rest_deg = 5"), &["a rest position without a spring"]);
    says(&joint("spring_nmpr = 1\nrest_deg = 5\nrest_rad = 1"), &["rest_deg and rest_rad are both given"]);
    says(&joint("spring_npm = 1"), &["spring_npm has no meaning for a revolute joint; valid are", "spring_nmpr"]);
    says(&joint("stop_nmpr = 1"), &["a stop without an end of the range; give lower or upper"]);
    says(&joint("upper_deg = 9\nstop_nmpr = -1"), &["the stop's stiffness -1 is negative"]);
    says(&joint("upper_deg = 9\nstop_nmpr = 1\nstop_damping_nmspr = -1"), &["the stop's damping -1 is negative"]);
    says(&joint("upper_deg = 9\nstop_damping_nmspr = 1"), &["a stop's damping without its stiffness"]);
}

#[test]
fn names() {
    says(
        &toml_error("name = \"lower\"", "name = \"upper\""),
        &["robot.toml:24: body \"upper\": the name is given twice"],
    );
    says(&toml_error("name = \"elbow\"", "name = \"shoulder\""), &["joint \"shoulder\": the name is given twice"]);
    says(
        &toml_error("body = \"lower\"", "body = \"lowr\""),
        &["robot.toml:7: contact \"tip\": unknown body \"lowr\"; valid are stand, upper, lower"],
    );
    says(
        &toml_error("parent = \"upper\"", "parent = \"uper\""),
        &["body \"lower\": unknown parent \"uper\"; valid are"],
    );
    says(&toml_error("parent = \"stand\"", "parent = \"lower\""), &["loop of parents (upper, lower)"]);
    says(&toml_error("name = \"lower\"", "name = \"\""), &["a body's name: is empty"]);
    let twice = "contacts = [{ name = \"tip\", body = \"upper\", position_m = [0, 0, 0] }, ";
    says(&toml_error("contacts = [", twice), &["contact \"tip\": the name is given twice"]);
    let frame = |body: &str| toml_error("[[bodies]]", &format!("[[frames]]\n{body}\n[[bodies]]"));
    says(&frame("name = \"f\"\nbody = \"hand\""), &["robot.toml:9: frame \"f\": unknown body \"hand\"; valid are"]);
    says(&frame("name = \"upper\"\nbody = \"lower\""), &["frame \"upper\": the name is given twice"]);
    says(&frame("name = \" \"\nbody = \"lower\""), &["a frame's name: is empty"]);
    let both = "name = \"f\"\nbody = \"lower\"\nrpy_deg = [0, 0, 0]\nrotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]";
    says(&frame(both), &["frame \"f\": rpy_deg and rotation are both given"]);
    says(&frame("name = \"f\"\nbody = \"lower\"\nposition_m = [0, nan, 0]"), &["frame \"f\": position_m is NaN"]);
    let reserved =
        TOML.replace("name = \"elbow\"", "name = \"base_x\"").replace("\"fixed\"\ngravity", "\"planar\"\ngravity");
    says(
        &Model::from_toml(&reserved, "robot.toml").unwrap_err().to_string(),
        &["joint \"base_x\"", "base_x, base_z, base_pitch"],
    );
}

#[test]
fn planar_robots_stay_in_their_plane() {
    let planar = TOML.replace("\"fixed\"\ngravity", "\"planar\"\ngravity");
    let error = |from: &str, to: &str| {
        assert!(planar.contains(from));
        Model::from_toml(&planar.replacen(from, to, 1), "robot.toml").unwrap_err().to_string()
    };
    says(
        &error("axis = [0, -1, 0]", "axis = [0, -1, 0.1]"),
        &["joint \"shoulder\"", "not parallel to y", "base = \"floating\""],
    );
    says(
        &error("axis = [0, -1, 0]", "axis = [0, -1, 0]\norigin_rpy_deg = [10, 0, 0]"),
        &["joint \"shoulder\"", "not parallel to y"],
    );
    let slide = "type = \"prismatic\"\naxis = [0, -1, 0]";
    let sliding =
        planar.replace("damping_nmspr = 0.1", "").replacen("type = \"revolute\"\naxis = [0, -1, 0]", slide, 1);
    let error = Model::from_toml(&sliding, "robot.toml").unwrap_err().to_string();
    says(&error, &["joint \"shoulder\"", "not perpendicular to y", "base = \"floating\""]);
}

#[test]
fn broken_toml() {
    says(
        &Model::from_toml("", "robot.toml").unwrap_err().to_string(),
        &["robot.toml: is empty", "name, base and bodies"],
    );
    says(&Model::from_toml(" \n", "robot.toml").unwrap_err().to_string(), &["is empty"]);
    says(
        &toml_error("mass_kg = 1.3", "mass = 1.3"),
        &["robot.toml:15: unknown field `mass`, expected one of", "`mass_kg`"],
    );
    says(
        &toml_error("base = \"fixed\"", "base = \"flying\""),
        &["robot.toml:3: unknown variant `flying`", "`fixed`, `planar`", "`floating`"],
    );
    says(&toml_error("base = \"fixed\"", ""), &["missing field `base`"]);
    says(
        &toml_error("damping_nmspr = 0.1", "dampin_nmspr = 0.1"),
        &["robot.toml:22: unknown field `dampin_nmspr`, expected one of", "damping_nmspr"],
    );
    says(
        &toml_error("damping_nmspr = 0.1", "damping_nmspr = \"0.1\""),
        &["robot.toml:22: damping_nmspr: invalid type"],
    );
    says(&toml_error("name = \"elbow\"", ""), &["robot.toml:30: missing field `name`"]);
    says(&toml_error("mass_kg = 1.3", "mass_kg = \"1.3\""), &["robot.toml:15: invalid type: string"]);
    says(&toml_error("com_m = [0.0, 0.0, -0.25]", "com_m = [0.0, -0.25]"), &["robot.toml:16: invalid length 2"]);
    let no_bodies = "name = \"r\"\nbase = \"fixed\"\nbodies = []";
    says(&Model::from_toml(no_bodies, "robot.toml").unwrap_err().to_string(), &["bodies: none"]);
    let massless = "name = \"r\"\nbase = \"floating\"\nbodies = [{ name = \"b\" }]";
    says(&Model::from_toml(massless, "robot.toml").unwrap_err().to_string(), &["no body has mass"]);
    // Cut anywhere, the file is either refused or, cut between entries, another robot
    for end in 0..TOML.len() {
        if let Err(error) = Model::from_toml(&TOML[..end], "robot.toml") {
            assert!(error.to_string().starts_with("robot.toml"), "{error}");
        }
    }
}

#[test]
fn urdf_trees() {
    says(&Model::from_urdf("", "robot.urdf", None, None).unwrap_err().to_string(), &["robot.urdf: is empty"]);
    says(&Model::from_urdf("hello", "robot.urdf", None, None).unwrap_err().to_string(), &["no <robot>"]);
    says(
        &Model::from_urdf("<robot name='r'></robot>", "robot.urdf", None, None).unwrap_err().to_string(),
        &["robot: has no links"],
    );
    says(&urdf_error("</robot>", ""), &["cannot be read as URDF"]);
    says(&urdf_error("<link name=\"trunk\">", "<link name=\"trunk\"><xacro:x/>"), &["xacro"]);
    says(
        &urdf_error("<link name=\"trunk\">", "<link name=\"pelvis\">"),
        &["robot.urdf:11: link \"pelvis\": the name is given twice"],
    );
    says(
        &urdf_error("<child link=\"trunk\"/>", "<child link=\"trunc\"/>"),
        &["joint \"waist\": unknown child link \"trunc\"; valid are pelvis, trunk"],
    );
    says(
        &urdf_error("<parent link=\"pelvis\"/>", "<parent link=\"pelwis\"/>"),
        &["joint \"waist\": unknown parent link \"pelwis\""],
    );
    says(
        &urdf_error("<child link=\"trunk\"/>", "<child link=\"left_foot\"/>"),
        &["joint \"left_aie\": link \"left_foot\" has two parents, by this joint and by \"waist\""],
    );
    says(&urdf_error("<child link=\"trunk\"/>", "<child link=\"pelvis\"/>"), &["\"pelvis\"", "loop"]);
    says(&urdf_error("</robot>", "<link name=\"spare\"/></robot>"), &["2 bodies have no parent (pelvis, spare)"]);
    says(
        &urdf_error("joint name=\"waist\"", "joint name=\"left_haa\""),
        &["joint \"left_haa\": the name is given twice"],
    );
    let circle = "<robot name='r'><link name='a'/><link name='b'/>\
        <joint name='ab' type='fixed'><parent link='a'/><child link='b'/></joint>\
        <joint name='ba' type='fixed'><parent link='b'/><child link='a'/></joint></robot>";
    says(&Model::from_urdf(circle, "robot.urdf", None, None).unwrap_err().to_string(), &["every link is a child"]);
}

#[test]
fn urdf_joints_and_numbers() {
    for kind in ["screw", "Revolute", " fixed "] {
        let message =
            urdf_error("name=\"right_kfe\" type=\"revolute\"", &format!("name=\"right_kfe\" type=\"{kind}\""));
        let what = format!("joint \"right_kfe\": is of type {kind:?}");
        says(&message, &[&what, "valid are fixed, revolute, continuous, planar, prismatic"]);
    }
    let mimic =
        |joint: &str| urdf_error("<axis xyz=\"1 0 0\"/>", &format!("<axis xyz=\"1 0 0\"/><mimic joint={joint:?}/>"));
    says(&mimic("hip"), &["joint \"right_haa\": follows the unknown joint \"hip\"; valid are"]);
    says(&mimic("right_haa"), &["joint \"right_haa\": follows itself"]);
    says(&mimic("waist"), &["joint \"right_haa\": follows \"waist\", which has no coordinate"]);
    says(&urdf_error("<axis xyz=\"1 0 0\"/>", "<axis xyz=\"0 0 0\"/>"), &["joint \"right_haa\": axis is zero"]);
    says(&urdf_error("lower=\"-0.6\"", "lower=\"0.7\""), &["joint \"right_haa\": limits are crossed"]);
    says(&urdf_error("effort=\"160\"", "effort=\"-1\""), &["joint \"right_haa\": effort limit -1 is negative"]);
    says(&urdf_error("velocity=\"8\"", "velocity=\"-1\""), &["joint \"right_haa\": velocity limit -1 is negative"]);
    says(&urdf_error("<mass value=\"9.5\"/>", "<mass value=\"-9.5\"/>"), &["robot.urdf:4: body \"pelvis\": mass -9.5"]);
    let planar = Model::from_urdf(URDF, "robot.urdf", None, Some(Base::Planar)).unwrap_err().to_string();
    says(&planar, &["joint \"right_haa\": its axis is not parallel to y", "floating"]);
}

#[test]
fn side_files() {
    says(&side_error(""), &["robot.legwork.toml: is empty"]);
    says(&side_error("trunk = 1"), &["robot.legwork.toml:1: unknown field `trunk`", "`torso`"]);
    says(
        &side_error("actuated = [\"hip\"]"),
        &["robot.legwork.toml: actuated: unknown joint \"hip\"; valid are right_haa"],
    );
    says(&side_error("passive = [\"waist\"]"), &["passive: unknown joint \"waist\""]);
    says(&side_error("actuated = []\npassive = []"), &["both are given"]);
    says(&side_error("gravity_mps2 = inf"), &["robot.legwork.toml: gravity_mps2: inf"]);
    let contact = "\ncontacts = [{ name = \"c\", body = \"hand\", position_m = [0, 0, 0] }]";
    says(&side_error(contact), &["robot.legwork.toml:2: contact \"c\": unknown body \"hand\""]);
    says(
        &side_error("[joints.hip]\nspring_nmpr = 1"),
        &["robot.legwork.toml:1: joints: unknown joint \"hip\"; valid are right_haa"],
    );
    says(
        &side_error("joints.right_haa = { spring_nmpr = -1 }"),
        &["robot.legwork.toml:1: joint \"right_haa\": the spring's stiffness -1 is negative"],
    );
    says(&side_error("joints.right_haa = { spring = 1 }"), &["robot.legwork.toml:1: unknown field `spring`, expected"]);
    let crossed = "base = \"planar\"\nbase_pitch = { lower_deg = 10, upper_deg = -10 }";
    says(&side_error(crossed), &["base_pitch: limits are crossed"]);
}

#[test]
fn files_on_disk() {
    let folder = std::env::temp_dir().join(format!("legwork-rbd-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let load = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        Model::load(&path)
    };
    let missing = Model::load(&folder.join("none.toml")).unwrap_err();
    assert!(missing.is_io());
    says(&missing.to_string(), &["none.toml: no such file or folder"]);

    assert!(load("a.toml", TOML.as_bytes()).is_ok());
    assert!(load("a.TOML", TOML.as_bytes()).is_ok());
    let error = Model::load(&folder).unwrap_err();
    assert!(error.is_io());
    says(&error.to_string(), &["is a folder", "a.toml"]);
    let named = folder.join("folder.toml");
    std::fs::create_dir_all(&named).unwrap();
    assert!(matches!(Model::load(&named), Err(ModelError::Folder { .. })));

    let latin = load("latin.toml", b"name = \"Sch\xfctze\"").unwrap_err();
    assert!(!latin.is_io());
    says(&latin.to_string(), &["latin.toml: not UTF-8 text: found the byte 0xfc in line 1, column 12"]);
    says(&load("robot.sdf", b"").unwrap_err().to_string(), &["unknown kind of file", ".toml, .urdf, .xml and .mjcf"]);
    says(&load("robot", b"").unwrap_err().to_string(), &["unknown kind of file"]);
    assert!(!load("empty.urdf", b"").unwrap_err().is_io());

    // The file beside a URDF is read if it is there
    assert_eq!(load("b.urdf", URDF.as_bytes()).unwrap().nc(), 0);
    std::fs::write(folder.join("b.legwork.toml"), include_str!("data/biped18.legwork.toml")).unwrap();
    assert_eq!(Model::load(&folder.join("b.urdf")).unwrap().nc(), 4);
    std::fs::write(folder.join("b.legwork.toml"), "torso = 3").unwrap();
    says(&Model::load(&folder.join("b.urdf")).unwrap_err().to_string(), &["b.legwork.toml:1"]);
    let with_mark = [b"\xef\xbb\xbf", URDF.as_bytes()].concat();
    assert!(load("mark.urdf", &with_mark).is_ok());
    let with_mark = [b"\xef\xbb\xbf", TOML.as_bytes()].concat();
    assert!(load("mark.toml", &with_mark).is_ok());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn absurdly_deep_and_large_files() {
    let deep = format!("<robot name='r'>{}{}</robot>", "<a>".repeat(200_000), "</a>".repeat(200_000));
    says(&Model::from_urdf(&deep, "robot.urdf", None, None).unwrap_err().to_string(), &["robot.urdf", "nested"]);
    let deep = format!("name = {}{}", "[".repeat(200_000), "]".repeat(200_000));
    assert!(Model::from_toml(&deep, "robot.toml").is_err());
    says(&toml_error("com_m = [0.0, 0.0, -0.25]", "com_m = [0.0, 0.0, 1e200]"), &["joint \"shoulder\"", "too large"]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes are changed, pieces cut out or doubled: it may load or be refused, but neither panic nor hang.
    #[test]
    fn damaged_files_never_panic(
        urdf: bool,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..40_usize, 0..4_u8, any::<char>()), 1..4),
    ) {
        let mut text: Vec<char> = if urdf { URDF.chars().collect() } else { TOML.chars().collect() };
        for (at, length, kind, character) in edits {
            let at = at.index(text.len());
            let end = (at + length).min(text.len());
            match kind {
                0 => text[at] = character,
                1 => { text.drain(at..end); }
                2 => { let piece = text[at..end].to_vec(); text.splice(at..at, piece); }
                _ => text[at] = ['-', '9', 'e', '"', '<', '=', '0', '.'][length % 8],
            }
            if text.is_empty() { text.push(' '); }
        }
        let text: String = text.into_iter().collect();
        let result = if urdf {
            Model::from_urdf(&text, "robot.urdf", None, None)
        } else {
            Model::from_toml(&text, "robot.toml")
        };
        if let Err(error) = result {
            prop_assert!(error.to_string().starts_with("robot."), "{}", error);
        }
    }
}
