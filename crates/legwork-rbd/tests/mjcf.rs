//! What an MJCF is read as, in numbers that follow from it on paper, and in which words it is refused or warned of.
//! `xtask/python/mjcf.py` holds robots of other people against MuJoCo itself.

mod common;

use std::f64::consts::PI;

use common::{assert_close, crate_path};
use legwork_rbd::{Base, Body, Dynamics, Model, Roles, Shape};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// A leg on a floating trunk, with a bit of everything that is read.
const ROBOT: &str = include_str!("data/biped.xml");
const INCLUDED: &str = include_str!("data/biped_leg.xml");

fn read(text: &str) -> Result<Model, String> {
    read_with(text, None, None).map(|(model, _)| model)
}

fn read_with(text: &str, side: Option<&str>, base: Option<Base>) -> Result<(Model, Roles), String> {
    let files = [("biped_leg.xml", INCLUDED.as_bytes())];
    let side = side.map(|side| (side, "r.legwork.toml"));
    Model::from_mjcf_with_roles(text, "r.xml", side, base, &files).map_err(|error| error.to_string())
}

/// A file of one body on a hinge, with these elements in it and before it.
fn one(before: &str, body: &str) -> String {
    format!(
        "<mujoco>\n{before}\n<worldbody>\n<body name=\"b\">\n<joint name=\"j\"/>\n{body}\n</body>\n</worldbody>\n</mujoco>\n"
    )
}

#[track_caller]
fn body_of(before: &str, body: &str) -> Body {
    let model = read(&one(before, body)).unwrap();
    model.bodies[model.body_index("b").unwrap()].clone()
}

#[track_caller]
fn refused(text: &str, message: &str) {
    assert_eq!(read(text).unwrap_err(), message);
}

fn place(model: &Model, q: &[f64], body: &str) -> (Matrix3<f64>, Vector3<f64>) {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, q, &vec![0.0; model.nv()]);
    let place = dynamics.world_from_body[model.body_index(body).unwrap()];
    (place.rotation, place.translation)
}

#[test]
fn solids_have_the_mass_and_moments_of_closed_forms() {
    let (r, h, density) = (0.1, 0.3, 1000.0);
    let ball = density * 4.0 / 3.0 * PI * r * r * r;
    let rod = density * PI * r * r * 2.0 * h;
    let capsule = {
        let end = ball / 2.0;
        // Half a ball about its own centre, which is 3/8 r from its flat side.
        let own = 0.4 * end * r * r - end * (0.375 * r) * (0.375 * r);
        let across = rod * (r * r / 4.0 + h * h / 3.0) + 2.0 * (own + end * (h + 0.375 * r) * (h + 0.375 * r));
        (rod + ball, [across, across, rod * r * r / 2.0 + ball * 0.4 * r * r])
    };
    let brick = density * 8.0 * 0.1 * 0.2 * 0.3;
    let egg = density * 4.0 / 3.0 * PI * 0.1 * 0.2 * 0.3;
    let thirds = |mass: f64, part: f64| [0.13, 0.10, 0.05].map(|sum| mass * sum / part);
    for (geom, mass, moments) in [
        ("size=\"0.1\"", ball, [0.4 * ball * r * r; 3]),
        ("type=\"sphere\" size=\"0.1 7\" mass=\"2\"", 2.0, [0.4 * 2.0 * r * r; 3]),
        ("type=\"capsule\" size=\"0.1 0.3\"", capsule.0, capsule.1),
        (
            "type=\"cylinder\" size=\"0.1 0.3\"",
            rod,
            [rod * (r * r / 4.0 + h * h / 3.0), rod * (r * r / 4.0 + h * h / 3.0), rod * r * r / 2.0],
        ),
        ("type=\"box\" size=\"0.1 0.2 0.3\"", brick, thirds(brick, 3.0)),
        ("type=\"ellipsoid\" size=\"0.1 0.2 0.3\"", egg, thirds(egg, 5.0)),
        ("type=\"box\" size=\"0.1 0.2 0.3\" density=\"500\"", brick / 2.0, thirds(brick / 2.0, 3.0)),
    ] {
        let body = body_of("", &format!("<geom {geom} pos=\"1 2 3\"/>"));
        assert_close(geom, &[body.mass], &[mass], 1e-14);
        assert_close(geom, body.com.as_slice(), &[1.0, 2.0, 3.0], 0.0);
        let expected = Matrix3::from_diagonal(&Vector3::from(moments));
        assert_close(geom, body.inertia.as_slice(), expected.as_slice(), 1e-14);
    }
}

#[test]
fn between_two_points_a_capsule_has_half_their_distance() {
    // Its axis lies along y: the moment about y is the small one.
    let lying = body_of("", "<geom type=\"capsule\" fromto=\"0 -0.3 1 0 0.3 1\" size=\"0.1\"/>");
    let standing = body_of("", "<geom type=\"capsule\" size=\"0.1 0.3\"/>");
    assert_close("mass", &[lying.mass], &[standing.mass], 1e-15);
    assert_close("com", lying.com.as_slice(), &[0.0, 0.0, 1.0], 1e-15);
    let [across, along] = [standing.inertia[(0, 0)], standing.inertia[(2, 2)]];
    assert_close("inertia", lying.inertia.diagonal().as_slice(), &[across, along, across], 1e-14);
    let brick = body_of("", "<geom type=\"box\" fromto=\"0 0 0 0.6 0 0\" size=\"0.1\" mass=\"3\"/>");
    assert_close("box", brick.inertia.diagonal().as_slice(), &[0.02, 0.1, 0.1], 1e-14);
    assert_close("box", brick.com.as_slice(), &[0.3, 0.0, 0.0], 1e-15);
}

#[test]
fn several_shapes_are_summed_and_some_left_out() {
    let two = "<geom size=\"0.1\" mass=\"1\" pos=\"0.5 0 0\"/><geom size=\"0.1\" mass=\"3\" pos=\"-0.5 0 0\" group=\"3\"/>\
        <geom type=\"plane\" size=\"1 1 1\"/><geom size=\"9\" density=\"0\"/><geom size=\"9\" mass=\"0\"/>";
    let body = body_of("", two);
    assert_close("mass", &[body.mass], &[4.0], 1e-15);
    assert_close("com", body.com.as_slice(), &[-0.25, 0.0, 0.0], 1e-15);
    let (own, apart) = (0.4 * 4.0 * 0.01, 1.0 * 0.75 * 0.75 + 3.0 * 0.25 * 0.25);
    assert_close("I", body.inertia.diagonal().as_slice(), &[own, own + apart, own + apart], 1e-15);
    let body = body_of("<compiler inertiagrouprange=\"0 2\"/>", two);
    assert_close("groups", &[body.mass, body.com.x], &[1.0, 0.5], 1e-15);
}

#[test]
fn an_inertia_is_given_or_computed_as_the_compiler_says() {
    let both =
        "<geom size=\"0.1\" mass=\"5\"/><inertial pos=\"0 0 1\" mass=\"2\" diaginertia=\"1 2 2.5\" euler=\"90 0 0\"/>";
    for (compiler, mass, moments) in [
        ("", 2.0, [1.0, 2.5, 2.0]),
        ("inertiafromgeom=\"auto\"", 2.0, [1.0, 2.5, 2.0]),
        ("inertiafromgeom=\"false\"", 2.0, [1.0, 2.5, 2.0]),
        ("inertiafromgeom=\"true\"", 5.0, [0.02; 3]),
        ("boundmass=\"3\" boundinertia=\"1.5\"", 3.0, [1.5, 2.5, 2.0]),
        ("settotalmass=\"20\"", 20.0, [10.0, 25.0, 20.0]),
    ] {
        let body = body_of(&format!("<compiler {compiler}/>"), both);
        assert_close(compiler, &[body.mass], &[mass], 1e-15);
        assert_close(compiler, body.inertia.diagonal().as_slice(), &moments, 1e-14);
    }
    let full = body_of("", "<inertial pos=\"1 2 3\" mass=\"2\" fullinertia=\"3 4 5 0.1 0.2 0.3\"/>");
    assert_close("full", full.inertia.as_slice(), &[3.0, 0.1, 0.2, 0.1, 4.0, 0.3, 0.2, 0.3, 5.0], 0.0);
    assert_close("com", full.com.as_slice(), &[1.0, 2.0, 3.0], 0.0);
    let impossible = "<inertial pos=\"0 0 0\" mass=\"2\" diaginertia=\"1 1 4\"/>";
    let balanced = body_of("<compiler balanceinertia=\"true\"/>", impossible);
    assert_close("balanced", balanced.inertia.diagonal().as_slice(), &[2.0; 3], 1e-15);
    assert!(read(&one("", impossible)).unwrap().warnings().iter().any(|odd| odd.contains("no body has this inertia")));
    // None is given and there are no shapes: it has none.
    refused(&one("", ""), "r.xml: bodies: no body has mass");
    // The total is that of all bodies, of those too that stand still.
    let static_too = one("<compiler settotalmass=\"3\"/>", "<geom size=\"0.1\" mass=\"1\"/>")
        .replace("<worldbody>", "<worldbody><body name=\"rock\"><geom size=\"1\" mass=\"2\"/></body>");
    let model = read(&static_too).unwrap();
    assert_close("mass", &[model.total_mass()], &[1.0], 1e-15);
    let no_actuators = "the file has no actuators: every joint is driven, without a limit of effort";
    assert_eq!(model.warnings(), ["bodies of the world beside the robot are ignored: rock", no_actuators]);
}

#[test]
fn every_way_to_give_a_rotation() {
    let turned = |angle: f64, axis: Vector3<f64>| {
        nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle).into_inner()
    };
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    let [a, b, c] = [10.0_f64, 20.0, 30.0].map(f64::to_radians);
    for (compiler, key, expected) in [
        ("", "quat=\"0 0 0 2\"", turned(PI, z)),
        ("", "axisangle=\"0 3 0 90\"", turned(PI / 2.0, y)),
        ("angle=\"radian\"", "axisangle=\"0 3 0 0.5\"", turned(0.5, y)),
        ("", "xyaxes=\"0 2 0 -1 5 0\"", turned(PI / 2.0, z)),
        ("", "zaxis=\"0 -3 0\"", turned(PI / 2.0, x)),
        ("", "zaxis=\"0 0 -1\"", turned(PI, x)),
        ("", "euler=\"10 20 30\"", turned(a, x) * turned(b, y) * turned(c, z)),
        ("eulerseq=\"zyx\"", "euler=\"10 20 30\"", turned(a, z) * turned(b, y) * turned(c, x)),
        ("eulerseq=\"XYZ\"", "euler=\"10 20 30\"", turned(c, z) * turned(b, y) * turned(a, x)),
        ("eulerseq=\"xYz\"", "euler=\"10 20 30\"", turned(b, y) * turned(a, x) * turned(c, z)),
        ("angle=\"radian\"", "euler=\"1 0 0\"", turned(1.0, x)),
    ] {
        let text = format!(
            "<mujoco><compiler {compiler}/><worldbody><body name=\"a\" {key}><body name=\"b\"><joint name=\"j\"/>\
             <geom size=\"0.1\"/></body></body></worldbody></mujoco>"
        );
        let model = read(&text).unwrap();
        assert_eq!(model.base, Base::Fixed);
        let (rotation, _) = place(&model, &[0.0], "b");
        assert_close(key, rotation.as_slice(), expected.as_slice(), 1e-14);
    }
    for (key, message) in [
        ("quat=\"0 0 0 0\"", "body quat is \"0 0 0 0\"; a rotation such as \"1 0 0 0\" is needed"),
        ("quat=\"1 0 0\"", "body quat is \"1 0 0\"; 4 finite numbers with blanks between them are needed"),
        ("xyaxes=\"1 0 0 2 0 0\"", "body xyaxes is \"1 0 0 2 0 0\"; two axes that are not parallel are needed"),
        ("zaxis=\"0 0 0\"", "body zaxis is \"0 0 0\"; an axis that is not zero is needed"),
        ("euler=\"0 0 x\"", "body euler is \"0 0 x\"; 3 finite numbers with blanks between them are needed"),
        ("quat=\"1 0 0 0\" euler=\"0 0 0\"", "quat, euler are given at once; give one rotation"),
    ] {
        let text = one("", "<geom size=\"1\"/>").replace("<body name=\"b\"", &format!("<body name=\"b\" {key}"));
        refused(&text, &format!("r.xml:4: b: {message}"));
    }
}

#[test]
fn joints_turn_about_their_anchors_and_begin_at_their_references() {
    // Out by 90 degrees about an anchor at (0, 0, 1): the origin of b goes to (-1, 0, 1) + (0.5, 0, 0).
    let text = "<mujoco><worldbody><body name=\"a\" pos=\"0.5 0 0\"><body name=\"b\" pos=\"0 0 0\">\
        <joint name=\"hinge\" axis=\"0 2 0\" pos=\"0 0 1\" ref=\"30\" range=\"-60 90\"/>\
        <joint name=\"slide\" type=\"slide\" axis=\"0 1 0\" pos=\"7 8 9\" ref=\"0.25\" range=\"-1 2\"/>\
        <geom size=\"0.1\" mass=\"2\"/></body></body></worldbody></mujoco>";
    let model = read(text).unwrap();
    let names: Vec<_> = model.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["a", "hinge", "b"]);
    assert_eq!(model.v_names(), ["hinge", "slide"]);
    assert!(model.warnings().iter().all(|warning| !warning.contains("hinge")), "{:?}", model.warnings());
    let (rotation, at) = place(&model, &[30_f64.to_radians(), 0.25], "b");
    assert_close("at the reference", at.as_slice(), &[0.5, 0.0, 0.0], 1e-15);
    assert_close("at the reference", rotation.as_slice(), Matrix3::<f64>::identity().as_slice(), 1e-15);
    let (rotation, at) = place(&model, &[120_f64.to_radians(), 0.35], "b");
    assert_close("turned", at.as_slice(), &[-0.5, 0.1, 1.0], 1e-14);
    assert_close("turned", (rotation * Vector3::z()).as_slice(), &[1.0, 0.0, 0.0], 1e-14);
    let [hinge, slide] = [&model.dofs[0], &model.dofs[1]];
    assert_close("hinge", &[hinge.lower, hinge.upper], &[-PI / 3.0, PI / 2.0], 1e-15);
    assert_close("slide", &[slide.lower, slide.upper], &[-1.0, 2.0], 0.0);
    // Beside its origin, the last joint carries the body by one more body without mass.
    let last = text.replace("type=\"slide\" axis=\"0 1 0\"", "axis=\"0 1 0\"");
    let model = read(&last).unwrap();
    let names: Vec<_> = model.bodies.iter().map(|body| (body.name.as_str(), body.joint.type_name())).collect();
    assert_eq!(names, [("a", "fixed"), ("hinge", "revolute"), ("slide", "revolute"), ("b", "fixed")]);
    assert_close("mass", &[model.bodies[3].mass, model.total_mass()], &[2.0, 2.0], 0.0);
}

#[test]
fn a_ball_joint_turns_its_body_about_its_anchor() {
    let text = "<mujoco><worldbody><body name=\"a\"><body name=\"b\" pos=\"1 0 0\">\
        <joint name=\"hip\" type=\"ball\" pos=\"0 0 1\" damping=\"0.5\" armature=\"0.2\" stiffness=\"3\"/>\
        <geom size=\"0.1\" mass=\"2\"/></body></body></worldbody></mujoco>";
    let model = read(text).unwrap();
    assert_eq!(model.q_names(), ["hip_qw", "hip_qx", "hip_qy", "hip_qz"]);
    assert_eq!(model.warnings()[0], "line 1: joint \"hip\": stiffness of a ball joint is ignored");
    // A quarter turn about y, so that what hung below the anchor is behind it.
    let half = PI / 4.0;
    let q = [half.cos(), 0.0, half.sin(), 0.0];
    assert_close("turned", place(&model, &q, "b").1.as_slice(), &[0.0, 0.0, 1.0], 1e-15);
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &q, &[0.0, 3.0, 0.0]);
    // About the anchor, at a distance of 1 m, and about the line to it.
    let (own, apart) = (0.4 * 2.0 * 0.01, 2.0);
    let expected = Matrix3::from_diagonal(&Vector3::new(own + apart + 0.2, own + apart + 0.2, own + 0.2));
    assert_close("M", dynamics.mass_matrix.as_slice(), expected.as_slice(), 1e-14);
    assert_close("damping", dynamics.damping.as_slice(), &[0.0, 1.5, 0.0], 1e-15);
    assert_close("energy", &[dynamics.kinetic_energy], &[0.5 * (own + apart + 0.2) * 9.0], 1e-14);
}

#[test]
fn defaults_come_from_the_nearest_class() {
    let text = r#"<mujoco>
      <compiler angle="radian"/>
      <default>
        <joint damping="1" armature="0.1"/>
        <geom type="capsule" size="0.1 0.2" density="0"/>
        <default class="leg">
          <joint damping="2"/>
          <default class="knee"><joint range="-1 2"/><geom size="0.3" mass="3"/></default>
        </default>
        <default class="arm"><joint type="slide" axis="1 0 0" armature="0.5"/></default>
      </default>
      <worldbody>
        <body name="trunk">
          <body name="a"><joint name="plain"/><geom mass="1"/></body>
          <body name="b" childclass="leg">
            <joint name="leg"/><geom class="knee"/>
            <frame childclass="knee"><body name="c"><joint name="knee" damping="9"/><geom/></body></frame>
            <body name="d" childclass="arm"><joint name="arm"/><joint name="main" class="main" axis="1 0 0"/><geom mass="1"/></body>
          </body>
        </body>
      </worldbody>
    </mujoco>"#;
    let (model, roles) = read_with(text, None, None).unwrap();
    let dof = |name: &str| model.dofs[model.dof_index(name).unwrap()].clone();
    let found = ["plain", "leg", "knee", "arm", "main"].map(|name| {
        let dof = dof(name);
        (dof.damping, dof.armature, dof.upper, dof.rotational)
    });
    let none = f64::INFINITY;
    let expected = [
        (1.0, 0.1, none, true),
        (2.0, 0.1, none, true),
        (9.0, 0.1, 2.0, true),
        (1.0, 0.5, none, false),
        (1.0, 0.1, none, true),
    ];
    assert_eq!(found, expected);
    // A class gives the numbers of a row that its element leaves out.
    let capsule = |radius| Shape::Capsule { radius, half_length: 0.2 };
    let shapes: Vec<_> =
        roles.geometry.iter().map(|geometry| (geometry.body.as_str(), geometry.shape.clone())).collect();
    assert_eq!(shapes, [("a", capsule(0.1)), ("b", capsule(0.3)), ("c", capsule(0.3)), ("d", capsule(0.1))]);
    let masses: Vec<_> = ["a", "b", "c", "d"].map(|body| model.bodies[model.body_index(body).unwrap()].mass).to_vec();
    assert_eq!(masses, [1.0, 3.0, 3.0, 1.0]);
}

#[test]
fn springs_limits_and_motors_of_joints() {
    let text = r#"<mujoco>
      <default><motor ctrlrange="-0.5 0.4" gear="100"/></default>
      <worldbody><body name="trunk"><freejoint/><geom size="0.2"/>
        <body name="b"><geom size="0.1"/>
          <joint name="motor" stiffness="20" springref="30" damping="2" armature="0.02" range="-10 20"/>
          <joint name="forced" axis="1 0 0" range="-10 20" limited="false"/>
          <joint name="servo" axis="0 1 0" limited="true" range="-90 90" stiffness="0" springref="30"/>
          <joint name="capped" type="slide" actuatorfrcrange="-7 7"/>
          <joint name="general" type="slide" axis="1 0 0"/>
          <joint name="free" type="slide" axis="0 1 0" frictionloss="0.3"/>
        </body></body></worldbody>
      <actuator>
        <motor joint="motor"/>
        <motor joint="forced" forcerange="-3 2" ctrllimited="false" gear="-2 1"/>
        <position joint="servo" kp="50" kv="1" forcerange="-12 12" gear="1"/><velocity joint="servo" kv="1" forcerange="-1 1" gear="2"/>
        <motor joint="capped"/>
        <general joint="general" gainprm="4" ctrlrange="-3 3" gear="2"/>
        <motor site="somewhere"/>
      </actuator>
    </mujoco>"#;
    let model = read(text).unwrap();
    assert_eq!(model.base, Base::Floating);
    let dof = |name: &str| model.dofs[model.dof_index(name).unwrap()].clone();
    let efforts = ["motor", "forced", "servo", "capped", "general", "free"]
        .map(|name| (dof(name).actuated, dof(name).effort_limit));
    let none = f64::INFINITY;
    assert_eq!(efforts, [(true, 50.0), (true, 6.0), (true, 14.0), (true, 7.0), (true, 24.0), (false, none)]);
    let motor = dof("motor");
    let degree = PI / 180.0;
    let found = [motor.stiffness, motor.rest, motor.damping, motor.armature, motor.lower, motor.upper];
    assert_close("motor", &found, &[20.0, 30.0 * degree, 2.0, 0.02, -10.0 * degree, 20.0 * degree], 1e-15);
    assert_eq!((dof("forced").upper, dof("servo").rest), (none, 0.0));
    assert_close("servo", &[dof("servo").upper], &[90.0 * degree], 1e-15);
    assert_eq!(
        model.warnings(),
        [
            "line 10: joint \"free\": Coulomb friction 0.3 is ignored",
            "line 18: actuator \"\" acts on no joint and is ignored: only motors of joints are read",
        ]
    );
}

#[test]
fn what_joins_the_robot_to_the_world_is_its_base() {
    let geom = "<geom size=\"0.1\" mass=\"1\"/>";
    let world = |bodies: &str| format!("<mujoco><worldbody><geom type=\"plane\"/>{bodies}</worldbody></mujoco>");
    let leg = format!("<body name=\"leg\"><joint name=\"hip\" axis=\"0 1 0\"/>{geom}</body>");
    let floating = world(&format!("<body name=\"trunk\" pos=\"0 0 1\"><freejoint name=\"root\"/>{geom}{leg}</body>"));
    let model = read(&floating).unwrap();
    assert_eq!((model.base, model.v_names()[6].as_str()), (Base::Floating, "hip"));
    let bolted = read_with(&floating, None, Some(Base::Fixed)).unwrap().0;
    assert_eq!((bolted.base, bolted.nv()), (Base::Fixed, 1));
    assert_close("pos", place(&bolted, &[0.0], "trunk").1.as_slice(), &[0.0, 0.0, 1.0], 0.0);

    let fixed =
        world(&format!("<body name=\"stand\" pos=\"0 0 2\">{geom}{leg}</body><body name=\"rock\">{geom}</body>"));
    let model = read(&fixed).unwrap();
    assert_eq!((model.base, model.bodies[0].name.as_str(), model.nv()), (Base::Fixed, "stand", 1));
    assert_eq!(model.warnings()[0], "bodies of the world beside the robot are ignored: rock");

    let planar = "<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\" ref=\"1\"/>\
        <joint name=\"y\" axis=\"0 1 0\"/>";
    let walker = world(&format!("<body name=\"trunk\" pos=\"0 0 1\">{planar}{geom}{leg}</body>"));
    let model = read(&walker).unwrap();
    assert_eq!((model.base, model.v_names()), (Base::Fixed, ["x", "z", "y", "hip"].map(str::to_owned).to_vec()));
    assert_close("pos", place(&model, &[0.5, 1.25, 0.0, 0.0], "trunk").1.as_slice(), &[0.5, 0.0, 1.25], 1e-15);
    assert!(model.warnings()[0].contains("with base = \"planar\" in a side file"), "{:?}", model.warnings());
    let planar = read_with(&walker, Some("base = \"planar\"\npassive = [\"hip\"]"), None).unwrap().0;
    assert_eq!((planar.base, planar.nv(), planar.dofs[3].actuated), (Base::Planar, 4, false));
    assert_eq!(planar.warnings(), ["the base takes the place of the joints x, z, y"]);

    let prop = format!("<body name=\"ball\"><freejoint/>{geom}</body>");
    let with_prop = floating.replace("</worldbody>", &format!("{prop}</worldbody>"));
    let model = read(&with_prop).unwrap();
    assert_eq!(
        (model.nv(), model.warnings()[0].as_str()),
        (7, "bodies of the world beside the robot are ignored: ball")
    );
    let second = floating
        .replace("</worldbody>", &format!("{}</worldbody>", leg.replace("hip", "other").replace("leg", "crane")));
    refused(
        &second,
        "r.xml:1: worldbody: several bodies of the world move (trunk, crane); leave one of them in the file",
    );
    let two = world(&format!("{leg}{}", leg.replace("hip", "other").replace("leg", "arm")));
    let model = read(&two).unwrap();
    assert_eq!((model.nv(), model.bodies[0].name.as_str()), (2, "world"));
    refused(&world(&format!("<body>{geom}</body>")), "r.xml: worldbody: no body has a joint, so nothing moves");
}

#[test]
fn a_robot_in_two_files_with_a_side_file() {
    let side = "torso = \"trunk\"\nfeet = [\"foot\"]\ngravity_mps2 = 1.62\n[[contacts]]\nname = \"heel\"\nbody = \"foot\"\n\
        position_m = [-0.1, 0, -0.05]\n[joints.knee]\nmax_velocity_radps = 9";
    let (model, roles) = read_with(ROBOT, Some(side), None).unwrap();
    assert_eq!((model.name.as_str(), model.base, model.gravity), ("biped", Base::Floating, 1.62));
    assert_eq!(model.v_names()[6..], ["hip_x", "hip_y", "knee", "ankle"]);
    assert_eq!((roles.torso.as_deref(), roles.feet.as_deref()), (Some("trunk"), Some(["foot".to_owned()].as_slice())));
    assert_eq!(model.dofs[8].velocity_limit, 9.0);
    assert_eq!((model.contacts.len(), model.frame("imu").is_some(), model.frame("toe").is_some()), (1, true, true));
    let shapes: Vec<_> =
        roles.geometry.iter().map(|shape| (shape.name.as_str(), shape.body.as_str(), shape.collides)).collect();
    assert_eq!(
        shapes,
        [
            ("", "trunk", true),
            ("look", "trunk", false),
            ("thigh", "thigh", true),
            ("", "shin", true),
            ("sole", "foot", true)
        ]
    );
    let (corners, radius) = roles.geometry[4].hull().unwrap();
    assert_eq!((corners.len(), radius), (8, 0.0));
    let lowest = corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
    assert_close("sole", &[lowest], &[-0.07], 1e-15);
    assert_eq!(
        model.warnings(),
        [
            "<equality> (1 weld) is ignored: constraints between bodies or joints are not read",
            "<tendon> (1 fixed) is ignored: tendons are not read, nor their springs and dampers",
        ]
    );
    let again = Model::from_toml(&model.to_toml(), "again.toml").unwrap();
    assert_eq!(again.to_toml(), model.to_toml());
    // From the disk, with the file that it includes.
    let path = crate_path("tests/data/biped.xml");
    let (loaded, _) = Model::load_with_roles(&path, None).unwrap();
    assert_eq!((loaded.nv(), loaded.gravity, loaded.total_mass()), (10, 9.81, model.total_mass()));
}

#[test]
fn what_a_file_holds_decides_what_it_is_read_as() {
    let folder = std::env::temp_dir().join(format!("legwork-mjcf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).unwrap();
        Model::load(&folder.join(name)).map_err(|error| error.to_string())
    };
    let robot = one("", "<geom size=\"0.1\"/>");
    for name in ["a.xml", "b.mjcf", "C.XML"] {
        assert_eq!(file(name, &robot).unwrap().v_names(), ["j"]);
    }
    let urdf = std::fs::read_to_string(crate_path("tests/data/biped18.urdf")).unwrap();
    assert_eq!(file("d.xml", &urdf).unwrap().nv(), 18);
    assert!(file("e.mjcf", &urdf).unwrap_err().ends_with("e.mjcf: no <mujoco> element; this is not MJCF"));
    std::fs::write(folder.join("a.legwork.toml"), "gravity_mps2 = 1.62\npassive = [\"j\"]").unwrap();
    let model = Model::load(&folder.join("a.xml")).unwrap();
    assert_eq!((model.gravity, model.actuated().count()), (1.62, 0));
    std::fs::write(folder.join("a.legwork.toml"), "passive = [\"k\"]").unwrap();
    let refused = Model::load(&folder.join("a.xml")).unwrap_err().to_string();
    assert!(refused.ends_with("a.legwork.toml: passive: unknown joint \"k\"; valid are j"), "{refused}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn files_that_are_missing_or_included_twice_are_named() {
    let gone = ROBOT.replace("biped_leg.xml", "gone.xml");
    refused(&gone, "r.xml:26: include: file \"gone.xml\": no such file or folder");
    let twice = ROBOT.replace(
        "<include file=\"biped_leg.xml\"/>",
        "<include file=\"biped_leg.xml\"/><include file=\"biped_leg.xml\"/>",
    );
    refused(&twice, "r.xml:26: include: file \"biped_leg.xml\" is included twice; a file may be included once");
    let itself =
        Model::from_mjcf(ROBOT, "r.xml", None, None, &[("biped_leg.xml", ROBOT.as_bytes())]).unwrap_err().to_string();
    assert!(itself.contains("included twice"), "{itself}");
    let bad = INCLUDED.replace("range=\"-140 0\"", "range=\"-140\"");
    let bad =
        Model::from_mjcf(ROBOT, "dir/r.xml", None, None, &[("biped_leg.xml", bad.as_bytes())]).unwrap_err().to_string();
    let needed = "joint range is \"-140\"; 2 finite numbers with blanks between them are needed";
    assert_eq!(bad, format!("dir/biped_leg.xml:8: knee: {needed}"));
    // A line of another file is not taken for one of the model's own.
    let heavy = INCLUDED.replace("name=\"knee\"", "name=\"knee\" armature=\"-1\" frictionloss=\"1\"");
    let files = [("biped_leg.xml", heavy.as_bytes())];
    let negative = Model::from_mjcf(ROBOT, "r.xml", None, None, &files).unwrap_err().to_string();
    assert_eq!(negative, "r.xml: joint \"knee\": armature -1 is negative");
    let friction = heavy.replace("armature=\"-1\"", "");
    let files = [("biped_leg.xml", friction.as_bytes())];
    let warnings = Model::from_mjcf(ROBOT, "r.xml", None, None, &files).unwrap().warnings();
    assert_eq!(warnings[0], "biped_leg.xml, line 7: joint \"knee\": Coulomb friction 1 is ignored");
    let mesh = "<asset><mesh name=\"m\" file=\"m.stl\" scale=\"2 2 2\"/></asset>";
    let body = "<geom type=\"mesh\" mesh=\"m\"/>";
    refused(&one(mesh, body), "r.xml:2: mesh: file \"m.stl\": no such file or folder");
    refused(&one(mesh, &body.replace("\"m\"", "\"n\"")), "r.xml:6: b: unknown mesh \"n\"; valid are m");
    // A tetrahedron with edges of 1 along the axes, twice as large: 8/6 m³ at 2/4 m.
    let text = "solid t\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\n\
        vertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendsolid t\n";
    let model = Model::from_mjcf(&one(mesh, body), "r.xml", None, None, &[("m.stl", text.as_bytes())]).unwrap();
    let body = &model.bodies[model.body_index("b").unwrap()];
    assert_close("mass", &[body.mass], &[8000.0 / 6.0], 1e-14);
    assert_close("com", body.com.as_slice(), &[0.5; 3], 1e-14);
    // Second moments of it about its centre: 3/80 m a² each, −1/80 m a² mixed.
    let (own, mixed) = (body.mass * 4.0 * 6.0 / 80.0, body.mass * 4.0 / 80.0);
    assert_close("I", &body.inertia.as_slice()[..3], &[own, mixed, mixed], 1e-13);
    // With an inertia of its own, a body needs no mesh.
    assert!(
        read(&one(mesh, "<geom type=\"mesh\" mesh=\"m\"/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>"))
            .is_ok()
    );
}

#[test]
fn what_is_wrong_is_refused_with_its_place() {
    let ball = "<geom size=\"0.1\"/>";
    let with = |from: &str, to: &str| one("", ball).replace(from, to);
    refused("", "r.xml: is empty; it should hold a <mujoco> with a <worldbody>");
    refused("<robot/>", "r.xml: no <mujoco> element; this is not MJCF");
    refused("<a><mujoco/></a>", "r.xml:1: the outermost element is <a>; that of a MJCF is <mujoco>");
    refused("<mujoco>", "r.xml: cannot be read as MJCF: the text ends within an element");
    refused("<mujoco/>", "r.xml: worldbody: no body has a joint, so nothing moves");
    let compiler = |key: &str| one(&format!("<compiler {key}/>"), ball);
    refused(&compiler("angle=\"deg\""), "r.xml:2: compiler: compiler angle is \"deg\"; valid are degree, radian");
    refused(
        &compiler("coordinate=\"global\""),
        "r.xml:2: compiler: compiler coordinate is \"global\"; global coordinates are no longer read by anyone; save the file \
         with local ones by MuJoCo 2.3.3",
    );
    refused(
        &compiler("eulerseq=\"xy\""),
        "r.xml:2: compiler: compiler eulerseq is \"xy\"; three of x, y, z, X, Y, Z are needed, such as \"xyz\"",
    );
    refused(
        &one("<option gravity=\"0 9.81 0\"/>", ball),
        "r.xml:2: option: option gravity is \"0 9.81 0\"; gravity along -z is needed, such as \"0 0 -9.81\"",
    );
    refused(
        &with("<joint name=\"j\"/>", "<joint name=\"j\" type=\"screw\"/>"),
        "r.xml:5: j: joint type is \"screw\"; valid are free, ball, slide and hinge",
    );
    refused(
        &with("<joint name=\"j\"/>", "<joint name=\"j\" axis=\"0 0 0\"/>"),
        "r.xml:5: joint \"j\": axis is zero; give a direction, such as [0, -1, 0]",
    );
    refused(
        &with("<joint name=\"j\"/>", "<joint name=\"j\" limited=\"yes\"/>"),
        "r.xml:5: j: joint limited is \"yes\"; valid are true, false and auto",
    );
    refused(
        &with("<joint name=\"j\"/>", "<joint name=\"j\" damping=\"nan\"/>"),
        "r.xml:5: j: joint damping is \"nan\"; at most 3 finite numbers with blanks between them are needed",
    );
    refused(
        &with("<joint name=\"j\"/>", "<joint name=\"j\" armature=\"-1\"/>"),
        "r.xml:5: joint \"j\": armature -1 is negative",
    );
    refused(
        &with("<joint name=\"j\"/>", "<joint name=\"j\" class=\"x\"/>"),
        "r.xml:5: j: unknown class \"x\"; valid are main",
    );
    refused(
        &with(ball, "<geom type=\"ball\"/>"),
        "r.xml:6: b: geom type is \"ball\"; valid are plane, hfield, sphere, capsule, ellipsoid, cylinder, box, mesh, sdf",
    );
    refused(
        &with(ball, "<geom type=\"capsule\" size=\"0.1\"/>"),
        "r.xml:6: b: geom size is too short or not positive; 2 positive numbers are needed",
    );
    refused(
        &with(ball, "<geom fromto=\"0 0 0 0 0 1\" size=\"0.1\"/>"),
        "r.xml:6: b: fromto is for a capsule, cylinder, ellipsoid or box",
    );
    refused(
        &with(ball, "<geom type=\"capsule\" fromto=\"1 1 1 1 1 1\" size=\"0.1\"/>"),
        "r.xml:6: b: fromto: both points are the same",
    );
    refused(&with(ball, "<inertial pos=\"0 0 0\"/>"), "r.xml:6: b: inertial mass is missing");
    refused(&with(ball, "<inertial mass=\"1\"/>"), "r.xml:6: b: inertial pos is missing");
    refused(
        &with(ball, "<replicate count=\"2\"/>"),
        "r.xml:6: b: <replicate> within a body is not supported; write out what it stands for",
    );
    refused(
        &with("</mujoco>", "<actuator><motor joint=\"k\"/></actuator></mujoco>"),
        "r.xml:9: actuator: unknown joint \"k\"; valid are j",
    );
    refused(
        &with("</body>", "</body><body name=\"b\"><joint name=\"k\"/></body>"),
        "r.xml:7: body \"b\": the name is given twice; body names must differ",
    );
    refused(
        &with(ball, "<geom size=\"0.1\"/><body><joint name=\"j\"/><geom size=\"1\"/></body>"),
        "r.xml:6: joint \"j\": the name is given twice; joint names must differ",
    );
    let warned = read(&with(ball, "<geom size=\"0.1\" masss=\"3\"/><goem/>")).unwrap().warnings();
    assert!(
        warned[0].starts_with("b (line 6): <goem> in <body> is ignored; known are include, body, frame, "),
        "{warned:?}"
    );
    assert!(warned[1].starts_with("b (line 6): geom masss is ignored; known are name, class, "), "{warned:?}");
}

#[test]
fn comments_may_hold_what_xml_forbids_there() {
    let text = one("<!-- ----- -- a -- <geom> ü -->", "<geom size=\"0.1\"/><!---->");
    assert_eq!(read(&text).unwrap().nv(), 1);
    let text = text.replace("size=\"0.1\"", "size=\"x\"");
    refused(&text, "r.xml:6: b: geom size is \"x\"; at most 3 finite numbers with blanks between them are needed");
}

#[test]
fn long_chains_load_and_absurd_ones_are_refused() {
    let chain = |n: usize| {
        let open: String =
            (0..n).map(|_| "<body pos=\"0 0 0.1\"><joint axis=\"0 1 0\"/><geom size=\"0.1\"/>").collect();
        format!("<mujoco><worldbody>{open}{}</worldbody></mujoco>", "</body>".repeat(n))
    };
    let model = read(&chain(900)).unwrap();
    assert_eq!(
        (model.nv(), model.dofs[899].name.as_str(), model.bodies[900].name.as_str()),
        (900, "joint_899", "body_900")
    );
    assert!(read(&chain(100_000)).unwrap_err().contains("nested more than 1000 deep"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes are changed, pieces cut out or doubled: it may load or be refused, but neither panic nor hang.
    #[test]
    fn damaged_files_never_panic(
        included: bool,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..40_usize, 0..4_u8, any::<char>()), 1..4),
    ) {
        let mut text: Vec<char> = if included { INCLUDED } else { ROBOT }.chars().collect();
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
        let (own, leg) = if included { (ROBOT, text.as_str()) } else { (text.as_str(), INCLUDED) };
        if let Err(error) = Model::from_mjcf(own, "r.xml", None, None, &[("biped_leg.xml", leg.as_bytes())]) {
            let message = error.to_string();
            prop_assert!(message.starts_with("r.xml") || message.starts_with("biped_leg.xml"), "{}", message);
        }
    }
}
