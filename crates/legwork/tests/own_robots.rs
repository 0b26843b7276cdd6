//! Robots of other people's: arms and a waist that no task needs, links with axes of any direction, soles that are links of their own.

use legwork::Robot;
use legwork::channel::Field;
use legwork::episode::{self, Outcome, Run};
use legwork::redundancy::free_joints;
use legwork::scenario_file;

const ARMS: &str = include_str!("data/robots/arms.urdf");
const ARMS_SIDE: &str = include_str!("data/robots/arms.legwork.toml");
const TURNED_ROOT: &str = include_str!("data/robots/turned_root.urdf");
const SOLE_FRAME: &str = include_str!("data/robots/sole_frame.urdf");

const SCENARIO: &str = r#"
extends = "exo-sway"
pushes = []
[start]
feet_width_m = 0.18
com_height_m = 0.85
[reference.stance]
sway_m = [0.01, 0.02, 0.0]
squat_m = 0.0
"#;

fn robot(urdf: &str, side: &str) -> Robot {
    Robot::from_urdf(urdf, "robot.urdf", Some((side, "robot.legwork.toml")), None).expect("a robot")
}

/// The robot with arms, whose chest is the torso of the side file, with another torso.
fn with_torso(urdf: &str, torso: &str) -> Robot {
    robot(urdf, &ARMS_SIDE.replace("\"chest\"", &format!("\"{torso}\"")))
}

fn run(model: &Robot, sets: &[&str]) -> Result<Run, legwork::error::Error> {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = scenario_file::parse(SCENARIO, "own.toml", None, &sets)?;
    episode::run(&loaded.scenario, model, &[], |_| false)
}

/// Position of a joint in a record [rad].
fn joint(run: &Run, index: usize, name: &str) -> f64 {
    let dof = run.model.dof_index(name).expect("it has this joint");
    run.log.get(index, Field::Q)[run.model.bodies[run.model.dofs[dof].body].q_index]
}

const FREE: [&str; 7] = ["waist", "r_shoulder", "r_abduct", "r_elbow", "l_shoulder", "l_abduct", "l_elbow"];

#[test]
fn arms_and_waist_are_free_and_legs_of_six_joints_are_not() {
    let names = |model: &Robot| free_joints(model).iter().map(|&dof| model.dofs[dof].name.clone()).collect::<Vec<_>>();
    let mut free = names(&robot(ARMS, ARMS_SIDE));
    free.sort();
    let mut expected = FREE.map(str::to_owned).to_vec();
    expected.sort();
    assert_eq!(free, expected);
    // With the pelvis as torso the waist leads to no foot, and is free still.
    assert_eq!(names(&with_torso(ARMS, "pelvis")).len(), 7);
    assert_eq!(names(&with_torso(SOLE_FRAME, "pelvis")), [""; 0]);
    // A seventh joint, say a second one above the knee: any of them can move while body and foot rest.
    let thigh = r#"<joint name="r_hip_yaw" type="revolute"><origin xyz="0 -0.09 0"/><parent link="pelvis"/>"#;
    assert!(SOLE_FRAME.contains(thigh));
    let more = r#"<link name="r_more"/><joint name="r_seventh" type="revolute"><origin xyz="0 -0.09 0"/><parent link="pelvis"/>
        <child link="r_more"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="200" velocity="20"/></joint>
        <joint name="r_hip_yaw" type="revolute"><origin xyz="0 0 0"/><parent link="r_more"/>"#;
    let seven = names(&with_torso(&SOLE_FRAME.replace(thigh, more), "pelvis"));
    assert!(seven.len() == 7 && seven.iter().all(|name| name.starts_with("r_")), "{seven:?}");
}

#[test]
fn arms_hang_still_where_nothing_asks_them_to_move() {
    let model = robot(ARMS, ARMS_SIDE);
    let still = run(&model, &["duration_s=20"]).expect("it starts");
    assert_eq!((&still.outcome, still.tasks.len()), (&Outcome::Completed, 4));
    for name in FREE {
        let drift =
            (0..still.log.len()).map(|i| (joint(&still, i, name) - joint(&still, 0, name)).abs()).fold(0.0, f64::max);
        assert!(drift < 1e-3, "{name} drifted by {drift} rad");
    }
    // That is the posture's doing.
    let loose = run(&model, &["duration_s=20", "controller.tracking.posture=off"]).expect("it starts");
    let drift = |name: &str| (joint(&loose, loose.log.len() - 1, name) - joint(&loose, 0, name)).abs();
    assert!(FREE.into_iter().any(|name| drift(name) > 0.05));
}

#[test]
fn the_start_pose_has_the_posture_that_is_asked_for() {
    let model = robot(ARMS, &format!("{ARMS_SIDE}\n[postures.ready]\n\"*_elbow\" = -0.4\nl_shoulder = 0.3\n"));
    let start = |sets: &[&str]| run(&model, &[&["duration_s=0.01"], sets].concat());
    let of = |run: &Run| FREE.map(|name| joint(run, 0, name));
    let neutral = of(&start(&[]).expect("it starts"));
    let zero_or_end = neutral.map(|angle| angle.abs() < 0.025);
    assert!(zero_or_end.iter().all(|&near| near), "{neutral:?}");
    let mut expected = neutral;
    (expected[3], expected[4], expected[6]) = (-0.4, 0.3, -0.4);
    let by_joint = "start.posture={ \"*_elbow\" = -0.4, l_shoulder = 0.3 }";
    for set in ["start.posture=ready", by_joint] {
        let found = of(&start(&[set]).expect("it starts"));
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6), "{set}: {found:?}");
    }
    let refusal = |set: &str| start(&[set]).expect_err("no such posture").to_string();
    let unknown = refusal("start.posture=sitting");
    assert!(unknown.contains("unknown posture \"sitting\"; valid are ready, neutral"), "{unknown}");
    let unknown = refusal("start.posture={ l_knie = 0.1 }");
    assert!(unknown.contains("no joint is called \"l_knie\"; valid are"), "{unknown}");
}

#[test]
fn joints_are_held_in_another_posture_than_that_of_the_start() {
    let model = robot(ARMS, ARMS_SIDE);
    let held = "controller.planner.posture={ l_elbow = -0.6, r_elbow = -0.3 }";
    let gains = "controller.planner.posture_gain={ r_elbow = 0.0, \"*\" = 45.0 }";
    let moved = run(&model, &["duration_s=4", held, gains]).expect("it starts");
    let last = moved.log.len() - 1;
    assert!((joint(&moved, last, "l_elbow") + 0.6).abs() < 1e-3, "{}", joint(&moved, last, "l_elbow"));
    // The one without a gain stays.
    assert!((joint(&moved, last, "r_elbow") - joint(&moved, 0, "r_elbow")).abs() < 0.05);
}

/// Turns of the root link against the body: about each axis by quarters, and about the vertical by any angle.
const TURNS: [[f64; 3]; 5] = [
    [0.0, 0.0, std::f64::consts::PI],
    [std::f64::consts::FRAC_PI_2, 0.0, 0.0],
    [0.0, -std::f64::consts::FRAC_PI_2, 0.0],
    [std::f64::consts::FRAC_PI_2, 0.0, -std::f64::consts::FRAC_PI_2],
    [0.0, 0.0, 0.7],
];

#[test]
fn a_robot_moves_alike_whatever_the_axes_of_its_root_link() {
    let turned = |[x, y, z]: [f64; 3], torso: &str| {
        let before = "rpy=\"0 0 3.141592653589793\"";
        assert!(TURNED_ROOT.contains(before));
        let urdf = TURNED_ROOT.replace(before, &format!("rpy=\"{x} {y} {z}\""));
        run(&with_torso(&urdf, torso), &["duration_s=1.5"]).expect("it starts")
    };
    let straight = turned([0.0; 3], "back");
    let joints =
        |run: &Run| (0..run.log.len()).flat_map(|i| run.log.get(i, Field::Q)[7..].to_vec()).collect::<Vec<f64>>();
    for (turn, torso) in TURNS.into_iter().flat_map(|turn| ["back", "pelvis"].map(|torso| (turn, torso))) {
        let run = turned(turn, torso);
        assert_eq!(run.outcome, Outcome::Completed, "{turn:?}: {:?}", run.reason);
        let off = joints(&run).iter().zip(joints(&straight)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{turn:?} {torso}: {off}");
    }
}

#[test]
fn feet_stand_flat_whatever_the_axes_of_their_links() {
    // The same foot with its link rolled by a quarter: what was below is to the left.
    let (urdf, side) = (SOLE_FRAME, ARMS_SIDE.replace("\"chest\"", "\"pelvis\""));
    let straight = run(&robot(urdf, &side), &["duration_s=1"]).expect("it starts");
    let ankle = r#"<joint name="r_ankle_roll" type="revolute"><origin xyz="0 0 0"/>"#;
    let axis = r#"<child link="r_foot"/><axis xyz="1 0 0"/>"#;
    assert!(urdf.contains(ankle) && urdf.contains(axis));
    let urdf = urdf
        .replace(ankle, &ankle.replace("xyz=\"0 0 0\"", "xyz=\"0 0 0\" rpy=\"1.5707963267948966 0 0\""))
        .replace(
            r#"<link name="r_foot"><inertial><origin xyz="0.03 0 -0.05"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.005"/>"#,
            r#"<link name="r_foot"><inertial><origin xyz="0.03 -0.05 0"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.005" iyz="0" izz="0.01"/>"#,
        )
        .replace(
            r#"<joint name="r_sole_fix" type="fixed"><origin xyz="0 0 -0.1"/>"#,
            r#"<joint name="r_sole_fix" type="fixed"><origin xyz="0 -0.1 0" rpy="-1.5707963267948966 0 0"/>"#,
        );
    let mut side = side;
    for (x, y) in [("-0.08", "-0.05"), ("-0.08", "0.05"), ("0.14", "-0.05"), ("0.14", "0.05")] {
        let z = if y == "0.05" { "-0.05" } else { "0.05" };
        let before = format!("body = \"r_foot\", position_m = [{x}, {y}, -0.1]");
        assert!(side.contains(&before));
        side = side.replace(&before, &format!("body = \"r_foot\", position_m = [{x}, -0.1, {z}]"));
    }
    let rolled = run(&robot(&urdf, &side), &["duration_s=1"]).expect("it starts");
    assert_eq!(rolled.outcome, Outcome::Completed, "{:?}", rolled.reason);
    let last = rolled.log.len() - 1;
    for name in ["r_knee", "r_ankle_roll", "l_hip_pitch"] {
        assert!((joint(&rolled, last, name) - joint(&straight, last, name)).abs() < 1e-6, "{name}");
    }
}

#[test]
fn a_sole_that_is_a_link_of_its_own_is_part_of_the_foot() {
    for height in ["-0.1", "-0.13", "-0.02"] {
        let urdf = SOLE_FRAME.replace(
            "xyz=\"0 0 -0.1\"/><parent link=\"r_foot\"",
            &format!("xyz=\"0 0 {height}\"/><parent link=\"r_foot\""),
        );
        let run = run(&with_torso(&urdf, "pelvis"), &["duration_s=0.5"]).expect("it starts");
        assert_eq!(run.outcome, Outcome::Completed, "{height}: {:?}", run.reason);
    }
}

#[test]
fn which_way_a_robot_faces_can_be_said_and_is_doubted_where_its_heels_come_first() {
    let side = ARMS_SIDE.replace("\"chest\"", "\"pelvis\"");
    let model = robot(SOLE_FRAME, &side);
    assert_eq!(
        (model.faces().as_str(), model.warnings().len()),
        ("the robot faces along +x of its root link \"pelvis\"", 0)
    );
    let swapped = robot(SOLE_FRAME, &side.replace("feet = [\"right\", \"left\"]", "feet = [\"left\", \"right\"]"));
    let warnings = swapped.warnings().join("");
    assert!(
        warnings.starts_with("the robot faces along -x of its root link") && warnings.contains("heels"),
        "{warnings}"
    );
    let said = robot(SOLE_FRAME, &format!("forward = [-1.0, 0.0, 0.0]\n{side}"));
    assert!(said.faces().contains("-x"), "{}", said.faces());
    let again = Robot::from_toml(&said.to_toml(), "again.toml").expect("it was written");
    assert_eq!(again.facing(), said.facing());
}

#[test]
fn locked_joints_are_none() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("robot.urdf", ARMS), ("robot.legwork.toml", ARMS_SIDE), ("own.toml", SCENARIO)] {
        std::fs::write(folder.path().join(name), text).expect("it can be written");
    }
    let path = folder.path().join("own.toml").display().to_string();
    let load = |sets: &[&str]| {
        let model = format!("model={}", folder.path().join("robot.urdf").display());
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).chain([model]).collect();
        scenario_file::load(&path, &sets).expect("valid")
    };
    let loaded = load(&["locked=[\"*_elbow\", \"waist\"]", "start.posture={ l_elbow = -0.5 }", "duration_s=0.5"]);
    let model = loaded.model().expect("a robot");
    assert_eq!((model.nv(), free_joints(&model).len()), (22, 4));
    let run = episode::run(&loaded.scenario, &model, &[], |_| false).expect("it starts");
    assert_eq!(run.outcome, Outcome::Completed);
    let free = load(&[]).model().expect("a robot");
    assert!((model.total_mass() - free.total_mass()).abs() < 1e-12);
    let refusal = load(&["locked=[\"*_wrist_*\"]"]).model().expect_err("no such joint").to_string();
    assert!(refusal.contains("locked: no joint is called \"*_wrist_*\""), "{refusal}");
}

#[test]
fn a_fall_of_joints_that_no_task_held_is_called_so() {
    let model = robot(ARMS, ARMS_SIDE);
    let sets = [
        "duration_s=40",
        "controller.tracking.posture=off",
        "start.posture={ \"*_abduct\" = -1.5, \"*_shoulder\" = 1.5, \"*_elbow\" = -1.25, waist = 1.0 }",
        "reference.stance.sway_m=[0.02, 0.03, 0.0]",
        "reference.stance.squat_m=0.08",
        "reference.stance.period_s=1.0",
    ];
    let run = run(&model, &sets).expect("it starts");
    assert!(matches!(run.outcome, Outcome::Fell(_)), "it stands");
    let found = run.diagnosis.expect("it fell");
    assert_eq!(found.cause.label(), "loose-joint", "{}", found.sentence);
    let joint = found.cause.part().expect("it names a joint");
    assert!(FREE.contains(&joint), "{joint}");
    assert!(
        found.sentence.contains("no task held the") && found.sentence.contains("came to its stop at"),
        "{}",
        found.sentence
    );
    assert!(!found.sentence.contains("of lift given up"), "{}", found.sentence);
}
