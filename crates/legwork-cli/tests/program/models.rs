//! Robots that are none, in TOML and in URDF, and URDF that is merely unusual.

use crate::{Folder, MODEL};

/// Two links and a joint; `%` stands for more of the joint.
const URDF: &str = r#"<robot name="leg">
  <link name="trunk">
    <inertial><mass value="10"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://nowhere/trunk.stl"/></geometry></visual>
  </link>
  <link name="shank">
    <inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="knee" type="revolute">
    <parent link="trunk"/><child link="shank"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="100" velocity="10"/>
  </joint>
</robot>
"#;

fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn toml_models() {
    let folder = Folder::new("toml-models");
    for (from, to, words) in [
        ("mass_kg = 3.98", "mass_kg = -3.98", ["robot.toml:29: body \"right_shank\"", "is negative"]),
        ("mass_kg = 3.98", "mass_kg = nan # ", ["robot.toml:29: body \"right_shank\"", "a finite number is needed"]),
        ("mass_kg = 3.98", "mass_kg = \"3\" # ", ["robot.toml:31: invalid type: string \"3\"", "expected"]),
        ("mass_kg = 3.98", "mass_lb = 3.98", ["robot.toml:31: unknown field `mass_lb`", "`mass_kg`"]),
        ("inertia_kgm2 = 0.127", "inertia_kgm2 = -0.127", ["body \"right_shank\"", "not positive definite"]),
        (
            "lower_deg = 10.0",
            "lower_deg = 190.0",
            ["joint \"right_knee\": limits are crossed", "3.316126 rad (190.00 deg)"],
        ),
        ("parent = \"right_shank\"", "parent = \"left_shank\"", ["is in a loop of parents", "a robot is a tree"]),
        (
            "body = \"right_shank\"",
            "body = \"shank\"",
            ["contact \"right_foot\": unknown body \"shank\"", "right_shank"],
        ),
        ("type = \"revolute\"", "type = \"hinge\"", ["robot.toml:43: unknown variant `hinge`", "`revolute`"]),
    ] {
        folder.file("robot.toml", changed(MODEL, from, to));
        folder.refuses(2, &["inspect", "robot.toml"], &words);
        folder.refuses(2, &["run", "stand", "--set", "model=robot.toml"], &words);
    }
    // No body has it in space, where all three moments count.
    let box_of_air = "name = \"a\"\nbase = \"floating\"\nbodies = [{ name = \"b\", mass_kg = 1, \
                      inertia_kgm2 = { xx = 1, yy = 1, zz = 3 } }]\n";
    folder.file("robot.toml", box_of_air);
    let done = folder.legwork(&["inspect", "robot.toml"]).succeeds();
    assert!(done.out.contains("warning: body \"b\": no body has this inertia"), "{}", done.out);
}

#[test]
fn urdf_models() {
    let folder = Folder::new("urdf-models");
    let closing =
        "</joint>\n  <joint name=\"rod\" type=\"fixed\"><parent link=\"shank\"/><child link=\"trunk\"/></joint>";
    let twice =
        "</joint>\n  <joint name=\"rod\" type=\"fixed\"><parent link=\"trunk\"/><child link=\"shank\"/></joint>";
    for (from, to, words) in [
        ("</joint>", closing, ["a loop", "one root"]),
        ("</joint>", twice, ["robot.urdf:13: joint \"rod\"", "two parents"]),
        (
            "</joint>",
            "<mimic joint=\"hip\"/></joint>",
            ["robot.urdf:9: joint \"knee\"", "follows the unknown joint \"hip\""],
        ),
        (
            "lower=\"-1\"",
            "lower=\"2\"",
            ["robot.urdf:9: joint \"knee\": limits are crossed", "2.000000 rad (114.59 deg)"],
        ),
        ("value=\"2\"", "value=\"-2\"", ["robot.urdf:6: body \"shank\"", "is negative"]),
        ("ixx=\"0.1\"", "ixx=\"-3\"", ["robot.urdf:2: joint \"base\"", "moves no inertia about its axis"]),
        (
            "type=\"revolute\"",
            "type=\"screw\"",
            ["joint \"knee\"", "valid are fixed, revolute, continuous, planar, prismatic"],
        ),
    ] {
        folder.file("robot.urdf", changed(URDF, from, to));
        folder.refuses(2, &["inspect", "robot.urdf"], &words);
    }
}

#[test]
fn files_that_are_empty_cut_or_no_text() {
    let folder = Folder::new("damaged-models");
    for name in ["robot.toml", "robot.urdf"] {
        folder.file(name, "");
        folder.refuses(2, &["inspect", name], &[&format!("{name}: is empty"), "should hold"]);
        folder.file(name, b"\x89PNG\r\n\x1a\n\xff\xfe");
        folder.refuses(
            2,
            &["inspect", name],
            &[&format!("{name}: not UTF-8 text: found the byte 0x89 in line 1, column 1")],
        );
        folder.file(name, "words, words, words");
        folder.refuses(2, &["inspect", name], &[name]);
    }
    for end in [1, 60, 300, 500, URDF.len() - 10] {
        folder.file("robot.urdf", &URDF[..end]);
        folder.refuses(2, &["inspect", "robot.urdf"], &["robot.urdf: "]);
    }
    for end in [MODEL.find("base =").unwrap(), MODEL.find("mass_kg").unwrap() + 4, MODEL.rfind("axis =").unwrap() + 9] {
        folder.file("robot.toml", &MODEL[..end]);
        folder.refuses(2, &["inspect", "robot.toml"], &["robot.toml:"]);
    }
    folder.file("robot.obj", "v 0 0 0");
    folder.refuses(
        2,
        &["inspect", "robot.obj"],
        &["robot.obj: unknown kind of file; valid are .toml, .urdf, .xml and .mjcf"],
    );
}

#[test]
fn models_that_cannot_be_read() {
    let folder = Folder::new("unread-models");
    folder.file("robots/b.urdf", URDF);
    folder.file("robots/a.toml", MODEL);
    folder.refuses(2, &["inspect", "planar"], &["neither a built-in model nor a file", "built-in: planar_humanoid"]);
    folder.refuses(2, &["inspect", ""], &["called \"\"", "built-in: planar_humanoid"]);
    folder.refuses(1, &["inspect", "robot.urdf"], &["robot.urdf: no such file or folder"]);
    folder.refuses(1, &["inspect", "robots"], &["robots: is a folder", "a.toml, b.urdf"]);
    folder.refuses(
        1,
        &["inspect", &format!("{}.urdf", "n".repeat(5000))],
        &["n.urdf: cannot be read: File name too long"],
    );
}

#[test]
fn shapes_are_not_needed() {
    let folder = Folder::new("shapes");
    folder.file("robot.urdf", URDF);
    let model = &folder.json(&["inspect", "robot.urdf", "--json"])[0];
    assert_eq!((model["base"].as_str(), model["total_mass_kg"].as_f64()), (Some("floating"), Some(12.0)));
}

#[test]
fn what_is_odd_but_possible_is_a_warning() {
    let folder = Folder::new("odd");
    folder.file("robot.urdf", changed(URDF, "lower=\"-1\" upper=\"1\"", "lower=\"90\" upper=\"180\""));
    let done = folder.legwork(&["inspect", "robot.urdf"]).succeeds();
    assert!(done.out.contains("warning: joint \"knee\" can be nowhere near zero"), "{}", done.out);
    let warnings = &folder.json(&["inspect", "robot.urdf", "--json"])[0]["warnings"];
    assert!(warnings[0].as_str().is_some_and(|text| text.contains("are they degrees?")), "{warnings}");
    folder.file(
        "robot.urdf",
        changed(
            URDF,
            "<mass value=\"2\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>",
            "<mass value=\"0\"/><inertia ixx=\"0\" iyy=\"0\" izz=\"0\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>",
        ),
    );
    let done = folder.legwork(&["inspect", "robot.urdf"]).succeeds();
    assert!(done.out.contains("warning: joint \"knee\" moves no mass and is locked"), "{}", done.out);
}
