//! Scenarios that are none: each is refused in a sentence with its place and a way out.

use crate::{Folder, MODEL};

/// A scenario file is refused, in `run` and in `show`.
#[track_caller]
fn refuses(folder: &Folder, text: impl AsRef<[u8]>, words: &[&str]) {
    folder.file("my.toml", text);
    folder.refuses(2, &["run", "my.toml"], words);
    folder.refuses(2, &["show", "my.toml"], words);
}

#[test]
fn keys_types_and_ranges() {
    let folder = Folder::new("keys");
    for (text, words) in [
        ("seed = 1\nsped = 2\n", ["my.toml:2: sped: unknown", "did you mean seed?"]),
        ("duration_ms = 4000\n", ["my.toml:1: duration_ms: unknown", "did you mean duration_s?"]),
        ("[controller.limits]\ntorque_knm = 1\n", ["my.toml:2: controller.limits.torque_knm", "limits.torque_nm?"]),
        (
            "duration_s = \"long\"\n",
            ["my.toml:1: duration_s: found the text \"long\"", "a number from 0.001 to 1e6 [s]"],
        ),
        ("duration_s = nan\n", ["my.toml:1: duration_s: found nan", "a number from"]),
        ("simulation.period_s = 0\n", ["my.toml:1: simulation.period_s: found 0", "from 1e-5 to 0.1 [s]"]),
        ("simulation.period_s = -0.001\n", ["my.toml:1: simulation.period_s: found -0.001", "from 1e-5 to 0.1 [s]"]),
        ("\n[reference.com]\nspeed_mps = 100\n", ["my.toml:3: reference.com.speed_mps: found 100", "-5 to 5 [m/s]"]),
        ("[reference.step]\nmin_length_m = 2\n", ["my.toml:2: reference.step.min_length_m", "longer than the longest"]),
        ("pushes = [{ force_n = 1 }]\n", ["my.toml:1: pushes.0: start_s is missing", "force_n, start_s, duration_s"]),
        ("extends = 'wlak'\n", ["my.toml:1: extends", "did you mean walk?"]),
    ] {
        refuses(&folder, text, &words);
    }
}

#[test]
fn files_that_are_empty_cut_or_no_text() {
    let folder = Folder::new("damaged");
    refuses(&folder, "", &["my.toml: nothing in it", "legwork show stand"]);
    refuses(&folder, "# nothing\n", &["my.toml: nothing in it"]);
    refuses(&folder, "seed = 1\nname = \"wal", &["my.toml:2: not TOML"]);
    refuses(&folder, b"\x7fELF\xff\xfe\0\0", &["my.toml: not UTF-8 text"]);
    refuses(&folder, "\0\0\0\0", &["my.toml:1: not TOML"]);
    refuses(&folder, "a = ".to_owned() + &"[".repeat(100_000), &["my.toml:1: not TOML"]);
    refuses(&folder, format!("{} = 1\n", "k".repeat(100_000)), &["my.toml:1: kkk"]);
}

#[test]
fn files_that_cannot_be_read() {
    let folder = Folder::new("unread");
    for command in ["run", "show"] {
        folder.refuses(2, &[command, "psuh"], &["\"psuh\"; did you mean push?", "built-in: stand, walk, push"]);
        folder.refuses(2, &[command, ""], &["called \"\"", "built-in: stand"]);
        folder.refuses(1, &[command, "there/psuh.toml"], &["there/psuh.toml: ", "did you mean push?"]);
        folder.refuses(1, &[command, "."], &[".: is a folder, expected a file"]);
        folder.refuses(
            1,
            &[command, &format!("{}.toml", "n".repeat(5000))],
            &["neither a built-in scenario nor a file"],
        );
    }
}

#[test]
fn start_poses_that_cannot_be_taken() {
    let folder = Folder::new("poses");
    for (text, words) in [
        ("[start]\ncom_height_m = 2\n", ["my.toml:2: start.com_height_m: no pose has", "change start.com_height_m"]),
        ("[start]\n\nleft_foot_x_m = 3\n", ["my.toml:3: start.left_foot_x_m: no pose has", "the legs do not reach"]),
        (
            "start.com_height_m = 0.3\n",
            [
                "my.toml:1: start.com_height_m: the start pose puts right_knee at 216.8 deg",
                "above its upper limit of 175.0 deg",
            ],
        ),
        (
            "start.torso_angle_deg = 80\n",
            ["my.toml:1: start.torso_angle_deg: the start counts as a fall", "more than 60 deg"],
        ),
    ] {
        folder.file("my.toml", text);
        folder.refuses(2, &["run", "my.toml"], &words);
    }
    folder.refuses(2, &["run", "stand", "--set", "start.com_height_m=2"], &["--set start.com_height_m: no pose has"]);
    // A foot that hangs above the knee's reach of the ground
    let floating = MODEL.replace("position_m = [0.0, 0.0, 0.49875]", "position_m = [0.0, 0.0, -2.0]");
    assert_ne!(floating, MODEL);
    folder.file("floating.toml", floating);
    folder.refuses(2, &["run", "stand", "--set", "model=floating.toml"], &["start", "no pose has the feet at"]);
}

#[test]
fn models_and_bodies_that_a_scenario_names() {
    let folder = Folder::new("names");
    folder.file("my.toml", "seed = 1\nmodel = \"humanoid\"\n");
    folder.refuses(2, &["run", "my.toml"], &["my.toml:2: model: neither", "built-in: planar_humanoid"]);
    folder.file("my.toml", "model = \"there/robot.urdf\"\n");
    folder.refuses(1, &["run", "my.toml"], &["there/robot.urdf: no such file or folder"]);
    folder.file("my.toml", "[[pushes]]\nforce_n = 1\nstart_s = 0\nduration_s = 1\nat = \"head\"\n");
    folder.refuses(2, &["run", "my.toml"], &["my.toml:5: pushes.0.at: found \"head\"; valid are com, right_shank"]);
    folder.refuses(2, &["run", "push", "--set", "pushes.0.at=head"], &["--set pushes.0.at: found \"head\""]);
    folder.file("one-legged.toml", MODEL.replace("    { name = \"left_foot\"", "#"));
    folder.refuses(2, &["run", "stand", "--set", "model=one-legged.toml"], &["--set model: ", "1 contact points"]);
}

#[test]
fn trajectories_that_are_none() {
    let folder = Folder::new("trajectories");
    let scenario = |file: &str| format!("[reference.com]\ntrajectory = \"file\"\nfile = \"{file}\"\n");
    folder.file("my.toml", scenario("com.csv"));
    folder.refuses(1, &["run", "my.toml"], &["com.csv: no such file"]);
    for (content, words) in [
        ("", ["com.csv: the column t_s is missing", "needed are t_s, x_m, z_m"]),
        ("t_s,x_m\n0,0\n", ["com.csv: the column z_m is missing", "found t_s, x_m"]),
        ("t_s,x_m,z_m\n0,0,0.9\n", ["com.csv: found 1 rows", "at least 3"]),
        (
            "t_s,x_m,z_m\n0,0,0.9\n1,nan,0.9\n2,0,0.9\n",
            ["com.csv:3: x_m: found \"nan\"", "a number from -1000 to 1000"],
        ),
        ("t_s,x_m,z_m\n0,0,0.9\n1,0\n", ["com.csv:3: z_m: found \"\"", "a number from"]),
        ("t_s,x_m,z_m\n0,0,0.9\n2,0,0.9\n1,0,0.9\n", ["com.csv: row 3", "times must increase"]),
    ] {
        folder.file("com.csv", content);
        folder.refuses(2, &["run", "my.toml"], &words);
    }
    folder.file("com.csv", b"t_s,x_m,z_m\n\xff\xfe");
    folder.refuses(2, &["run", "my.toml"], &["com.csv: not UTF-8"]);
    folder.file("my.toml", scenario("."));
    folder.refuses(1, &["run", "my.toml"], &["is a folder, expected a file"]);
    folder.file("my.toml", "[reference.com]\ntrajectory = \"file\"\n");
    folder.refuses(2, &["run", "my.toml"], &["my.toml:2: reference.com.trajectory", "reference.com.file"]);
}

#[test]
fn a_file_that_no_trajectory_asked_for_was_read() {
    let folder = Folder::new("unasked");
    folder.file("my.toml", "reference.com.file = \"nowhere.csv\"\n");
    folder.legwork(&["run", "my.toml", "--duration", "0.01"]).succeeds();
}
