//! What a robot of one's own is taken to be: feet, soles and torso, out of its tree and its shapes alone.

use legwork::adopt::{Lacking, Understanding, Wanted, understand};
use legwork::episode::{self, Outcome};
use legwork::{Robot, scenario_file};
use legwork_rbd::Model;
use nalgebra::Vector3;

const HUMANOID: &str = include_str!("../../../docs/robots/humanoid.urdf");
const PLANAR: &str = include_str!("../../../docs/robots/planar_biped.urdf");

fn taken(urdf: &str, wanted: &Wanted) -> Result<Understanding, Lacking> {
    let (model, roles) = Model::from_urdf_with_roles(urdf, "robot.urdf", None, None).expect("a robot");
    understand(&model, &roles, wanted, &|_| None, "robot.legwork.toml")
}

fn refused(urdf: &str, wanted: &Wanted) -> String {
    taken(urdf, wanted).expect_err("it cannot stand").error.to_string()
}

/// The robot with what the side file says that was found.
fn adopted(urdf: &str, planar: bool) -> Robot {
    let side = taken(urdf, &Wanted::default()).expect("it stands").side_file("robot.urdf", planar);
    Robot::from_urdf(urdf, "robot.urdf", Some((&side, "robot.legwork.toml")), None)
        .unwrap_or_else(|error| panic!("{error}\n{side}"))
}

#[track_caller]
fn corners(found: &Understanding, foot: usize, expected: &[[f64; 3]]) {
    let points = &found.feet[foot].points;
    let is_there = |corner: &[f64; 3]| points.iter().any(|point| (point - Vector3::from(*corner)).amax() < 1e-12);
    assert!(points.len() == expected.len() && expected.iter().all(is_there), "{points:?}");
}

#[test]
fn soles_are_the_lower_corners_of_boxes() {
    let found = taken(HUMANOID, &Wanted::default()).expect("it stands");
    assert_eq!((found.feet[0].link.as_str(), found.feet[1].link.as_str()), ("r_foot", "l_foot"));
    let sole = [[-0.08, -0.05, -0.1], [-0.08, 0.05, -0.1], [0.14, -0.05, -0.1], [0.14, 0.05, -0.1]];
    corners(&found, 0, &sole);
    corners(&found, 1, &sole);
    // 20 kg are heavier than a pelvis of 10 kg and a thigh of 6 kg.
    assert_eq!(found.torso, "chest");
    assert!(found.sideways.contains(&"waist".to_owned()) && !found.sideways.contains(&"r_knee".to_owned()));
}

#[test]
fn spheres_cylinders_and_turned_shapes_touch_where_they_are_lowest() {
    let boxed = "<geometry><box size=\"0.22 0.1 0.02\"/></geometry>";
    assert!(HUMANOID.contains(boxed));
    let ball = HUMANOID.replace(boxed, "<geometry><sphere radius=\"0.02\"/></geometry>");
    corners(&taken(&ball, &Wanted::default()).expect("it stands"), 0, &[[0.03, 0.0, -0.11]]);
    let origin = "<origin xyz=\"0.03 0 -0.09\"/>";
    let two = "<origin xyz=\"0.1 0 -0.09\"/><geometry><sphere radius=\"0.01\"/></geometry></collision>\
         <collision><origin xyz=\"-0.05 0 -0.085\"/><geometry><sphere radius=\"0.015\"/></geometry>";
    let balls = HUMANOID.replace(&format!("{origin}{boxed}"), two);
    corners(&taken(&balls, &Wanted::default()).expect("it stands"), 1, &[[0.1, 0.0, -0.1], [-0.05, 0.0, -0.1]]);
    // Lying along x it touches along a line 0.06 below its axis: the ends of its lowest edge.
    let lying = "<origin xyz=\"0.03 0 -0.04\" rpy=\"0 1.5707963267948966 0\"/><geometry><cylinder radius=\"0.06\" length=\"0.2\"/></geometry>";
    let found = taken(&HUMANOID.replace(&format!("{origin}{boxed}"), lying), &Wanted::default()).expect("it stands");
    let heights = found.feet[0].points.iter().map(|point| point.z);
    assert!(heights.clone().all(|z| (-0.1..=-0.09 + 1e-9).contains(&z)), "{:?}", found.feet[0].points);
    let ends: Vec<f64> = found.feet[0].points.iter().map(|point| point.x).collect();
    assert!(ends.iter().all(|x| (x - 0.03).abs() - 0.1 < 1e-9) && ends.len() == 4, "{ends:?}");
}

#[test]
fn a_robot_without_two_feet_is_told_what_is_missing() {
    let barefoot = HUMANOID.replace("<collision>", "<visual>").replace("</collision>", "</visual>");
    let lacking = taken(&barefoot, &Wanted::default()).expect_err("nothing tells the soles");
    let problem = lacking.error.to_string();
    assert!(problem.contains("foot \"r_foot\"") && problem.contains("has no collision shape"), "{problem}");
    // The lines that it proposes are those of a side file.
    let robot = Robot::from_urdf(&barefoot, "robot.urdf", Some((&lacking.lines, "robot.legwork.toml")), None);
    assert_eq!(robot.expect("the lines are valid").feet, ["right", "left"]);
    let named = |feet: &[&str]| Wanted { feet: feet.iter().map(|&foot| foot.to_owned()).collect(), torso: None };
    assert!(refused(HUMANOID, &named(&["r_foot"])).contains("--feet: found 1 links; name two"));
    assert!(refused(HUMANOID, &named(&["r_foot", "foot"])).contains("unknown link \"foot\"; valid are"));
    assert!(refused(HUMANOID, &named(&["r_foot", "r_foot"])).contains("move together"));
    let found = taken(HUMANOID, &named(&["l_foot", "r_foot"])).expect("named");
    assert_eq!(found.feet[0].link, "r_foot");
    assert!(found.feet[0].because.contains("--feet"));
    let torso = Wanted { torso: Some("head".to_owned()), ..Wanted::default() };
    assert!(refused(HUMANOID, &torso).contains("torso: unknown link \"head\"; valid are pelvis, chest"));
    let arm = "<robot name=\"arm\"><link name=\"a\"/><link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" \
        iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/>\
        <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>";
    assert!(refused(arm, &Wanted::default()).contains("no last link has two driven joints above it"));
}

#[test]
fn four_level_feet_are_not_two() {
    // The planar biped with a second pair of legs behind the first.
    let legs = PLANAR.split_once("<link name=\"right_thigh\">").expect("legs").1.replace("</robot>", "");
    let more =
        format!("<link name=\"right_thigh\">{legs}").replace("right_", "hind_right_").replace("left_", "hind_left_");
    let four = PLANAR.replace("</robot>", &format!("{more}</robot>"));
    let problem = refused(&four, &Wanted::default());
    assert!(
        problem.contains("4 last links are level and the lowest") && problem.contains("hind_left_foot"),
        "{problem}"
    );
}

#[test]
fn an_adopted_humanoid_stands_and_sways() {
    let robot = adopted(HUMANOID, false);
    let text = Understanding::stand("robot.urdf", "humanoid", false);
    let loaded = scenario_file::parse(&text, "stand.toml", None, &[]).expect("a scenario");
    let run = episode::run(&loaded.scenario, &robot, &[], |_| false).expect("it starts");
    assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
}

/// Froude's number of a person who walks at 1 m/s on legs of 0.93 m, on legs of 0.74 m: 0.89 m/s.
#[test]
fn an_adopted_planar_biped_walks_at_the_speed_of_its_legs() {
    let robot = adopted(PLANAR, true);
    let text = Understanding::walk("robot.urdf", "biped");
    let loaded = scenario_file::parse(&text, "walk.toml", None, &[]).expect("a scenario");
    let run = episode::run(&loaded.scenario, &robot, &[], |_| false).expect("it starts");
    assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
    let (leg, person) = (0.34 + 0.34 + 0.06, 0.53 * 1.75);
    let speed = run.metrics.steady_speed_mps.expect("it walks");
    assert!((speed - f64::sqrt(leg / person)).abs() < 0.03, "{speed} m/s");
}

#[test]
fn a_humanoid_in_the_plane_keeps_the_joints_that_turn_about_y() {
    let robot = adopted(HUMANOID, true);
    let names: Vec<&str> = robot.actuated().map(|dof| robot.dofs[dof].name.as_str()).collect();
    assert_eq!(names.len(), 2 * 3 + 2 * 2, "{names:?}");
    assert!(robot.is_planar() && names.contains(&"l_elbow"));
}
