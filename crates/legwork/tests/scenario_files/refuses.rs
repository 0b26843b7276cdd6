//! What is refused in a file.

use legwork::scenario_file::load;

use crate::{Folder, assert_says, read, refuses, sets};

#[test]
fn unknown_keys() {
    refuses("seed = 1\nsped = 2\n", "my.toml:2: sped", &["did you mean seed?", "valid here: controller, description"]);
    refuses("duration_ms = 4000\n", "my.toml:1: duration_ms", &["did you mean duration_s?"]);
    refuses("speed_mps = 1\n", "my.toml:1: speed_mps", &["did you mean reference.com.speed_mps?"]);
    refuses(
        "[ground]\n\nslope = 1\n",
        "my.toml:3: ground.slope",
        &["ground.slope_deg?", "friction, known, patches, profile, relief_known, slope_deg"],
    );
    refuses("[contoler.limits]\ntorque_nm = 1\n", "my.toml:1: contoler", &["did you mean controller?"]);
    refuses("controller.limit.torque_nm = 1\n", "my.toml:1: controller.limit", &["did you mean controller.limits?"]);
    refuses(
        "ground = { wet = true }\n",
        "my.toml:1: ground.wet",
        &["valid here: cross_slope_deg, friction, known, patches, profile, relief_known, slope_deg"],
    );
    refuses("\"a\\nb\" = 1\n", "my.toml:1: a\\nb", &["unknown; valid here"]);
}

#[test]
fn wrong_types() {
    refuses(
        "duration_s = \"long\"\n",
        "my.toml:1: duration_s",
        &["found the text \"long\"", "a number from 0.001 to 1e6 [s]"],
    );
    refuses("duration_s = true\n", "my.toml:1: duration_s", &["found true; valid is a number"]);
    refuses("duration_s = 2024-01-01\n", "my.toml:1: duration_s", &["found 2024-01-01"]);
    refuses("seed = 1.5\n", "my.toml:1: seed", &["found 1.5; valid is a whole number from 0 to 9223372036854775807"]);
    refuses("controller.form = 1\n", "my.toml:1: controller.form", &["found 1; valid is \"direct\" or \"slack\""]);
    refuses(
        "controller.form = 'both'\n",
        "my.toml:1: controller.form",
        &["found the text \"both\"; valid is \"direct\" or"],
    );
    refuses("ground.known = 'yes'\n", "my.toml:1: ground.known", &["found the text \"yes\"; valid is true or false"]);
    refuses("name = 1\n", "my.toml:1: name", &["found 1; valid is text"]);
    refuses("\n[duration_s]\nx = 1\n", "my.toml:2: duration_s", &["found a table; valid is a number"]);
    refuses(
        "ground = 3\n",
        "my.toml:1: ground",
        &[
            "found 3; valid is a table with the keys cross_slope_deg, friction, known, patches, profile, relief_known, slope_deg",
        ],
    );
    refuses("[[ground]]\nknown = true\n", "my.toml:1: ground", &["found a list; valid is a table"]);
    let rows = "reference.com.waypoints = [\n[0, 0, 0.9],\n[1, 0],\n]\n";
    refuses(
        rows,
        "my.toml:1: reference.com.waypoints",
        &["found 2 values in row 1", "[t_s, x_m, z_m] with t_s from 0"],
    );
}

#[test]
fn values_out_of_range() {
    for (text, place, words) in [
        ("duration_s = 0", "duration_s", "found 0; valid is a number from 0.001 to 1e6 [s]"),
        ("duration_s = nan", "duration_s", "found nan"),
        ("duration_s = inf", "duration_s", "found inf"),
        ("duration_s = 1e400", "duration_s", "found inf"),
        ("duration_s = 99999999999999999999", "duration_s", "found 1e20"),
        ("seed = -1", "seed", "found -1"),
        ("seed = 0xffffffffffffffff", "seed", "found inf"),
        ("simulation.period_s = 0", "simulation.period_s", "found 0; valid is a number from 1e-5 to 0.1 [s]"),
        ("simulation.period_s = -0.001", "simulation.period_s", "found -0.001"),
        ("reference.com.speed_mps = 100", "reference.com.speed_mps", "found 100; valid is a number from -5 to 5 [m/s]"),
        ("ground.slope_deg = 61", "ground.slope_deg", "from -60 to 60 [deg]"),
        ("ground.friction = -0.1", "ground.friction", "from 0 to 10"),
        ("controller.weights.grf = 0", "controller.weights.grf", "from 1e-12 to 1e12"),
        ("controller.weights.joint_acceleration = 0.0", "controller.weights.joint_acceleration", "found 0.0"),
        ("start.com_height_m = 50", "start.com_height_m", "from 0 to 5 [m]"),
        ("simulation.contact.max_sweeps = 0", "simulation.contact.max_sweeps", "a whole number from 1 to 100000"),
        ("fall.max_torso_angle_deg = 0", "fall.max_torso_angle_deg", "from 1 to 180 [deg]"),
        ("simulation.sensors.delay_s = 1.1", "simulation.sensors.delay_s", "from 0 to 1 [s]"),
    ] {
        refuses(&format!("{text}\n"), &format!("my.toml:1: {place}"), &[words]);
    }
}

#[test]
fn pushes_that_are_none() {
    let good = "[[pushes]]\nforce_n = 1\nstart_s = 0\nduration_s = 1\n";
    refuses(
        &format!("{good}[[pushes]]\nforce_n = 1\n"),
        "my.toml:5: pushes.1",
        &["start_s is missing; a push needs force_n, start_s, duration_s"],
    );
    refuses(
        &format!("{good}force = 1\n"),
        "my.toml:5: pushes.0.force",
        &["did you mean pushes.0.force_n?", "at, direction_deg"],
    );
    refuses(&format!("{good}{good}at = 1\n"), "my.toml:9: pushes.1.at", &["found 1; valid is text"]);
    refuses(
        &format!("{good}point_m = [1, 2]\n"),
        "my.toml:5: pushes.0.point_m",
        &["found 2 values; valid is [x, y, z]"],
    );
    refuses(
        "[[pushes]]\nforce_n = 2e6\nstart_s = 0\nduration_s = 1\n",
        "my.toml:2: pushes.0.force_n",
        &["found 2000000.0"],
    );
    refuses(
        "[pushes]\nforce_n = 1\n",
        "my.toml:1: pushes",
        &["found a table; valid is a list of tables, each headed [[pushes]]"],
    );
    refuses("pushes = [1]\n", "my.toml:1: pushes.0", &["found 1; valid is a table with the keys at"]);
    refuses("pushes = 'hard'\n", "my.toml:1: pushes", &["found the text \"hard\"; valid is a list"]);
}

#[test]
fn values_that_contradict_one_another() {
    refuses(
        "seed = 1\ncontroller.period_s = 0.0015\n",
        "my.toml:2: controller.period_s",
        &["1.5 times the physics period of 0.001 s", "whole multiple"],
    );
    refuses(
        "simulation.period_s = 0.003\n",
        "my.toml:1: simulation.period_s",
        &["the control period of 0.001 s", "whole multiple"],
    );
    refuses("controller.period_s = 0.0001\n", "my.toml:1: controller.period_s", &["whole multiple"]);
    refuses(
        "duration_s = 0.2\nsimulation.sensors.delay_s = 0.3\n",
        "my.toml:2: simulation.sensors.delay_s",
        &["0.3 s is not shorter than the run of 0.2 s"],
    );
    refuses(
        "simulation.actuators.delay_s = 0.3\nduration_s = 0.2\n",
        "my.toml:1: simulation.actuators.delay_s",
        &["delay of 0.3 s"],
    );
    refuses(
        "simulation.actuators.delay_s = 0.0004\n",
        "my.toml:1: simulation.actuators.delay_s",
        &["0.4 periods of 0.001 s", "whole multiple"],
    );
    refuses(
        "[reference.step]\nmin_length_m = 1.2\n",
        "my.toml:2: reference.step.min_length_m",
        &["1.2 m is longer than the longest of 1.05 m"],
    );
    refuses(
        "reference.com.trajectory = 'file'\n",
        "my.toml:1: reference.com.trajectory",
        &["needs a CSV file in reference.com.file"],
    );
    refuses(
        "reference.com.trajectory = 'waypoints'\n",
        "my.toml:1: reference.com.trajectory",
        &["needs rows [t_s, x_m, z_m]"],
    );
    let rows = "[reference.com]\ntrajectory = 'waypoints'\nwaypoints = [[1, 0, 0.9], [1, 0, 0.8]]\n";
    refuses(rows, "my.toml:3: reference.com.waypoints", &["row 1: 1 s comes after 1 s; valid are times that increase"]);
    refuses("fall.max_torso_angle_deg = 2\n", "my.toml:1: fall.max_torso_angle_deg", &["the start counts as a fall"]);
    refuses(
        "duration_s = 0.002\ncontroller.period_s = 0.01\n",
        "my.toml:1: duration_s",
        &["shorter than one control period"],
    );
    refuses(
        "name = \"a/b\"\n",
        "my.toml:1: name",
        &["found \"a/b\"; valid is a text that can be part of a file's name"],
    );
    refuses("name = \"\"\n", "my.toml:1: name", &["found \"\""]);
}

#[test]
fn periods_need_not_be_exact_in_binary() {
    for (control, physics) in [(0.001, 0.00025), (0.003, 0.001), (0.01, 0.0001), (0.1, 1e-5), (0.0007, 0.0001)] {
        let text = format!("controller.period_s = {control}\nsimulation.period_s = {physics}\n");
        read(&text, &[]).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn what_is_not_toml() {
    refuses("seed = 1\nduration_s = \n", "my.toml:2", &["not TOML"]);
    refuses("seed = 1\nname = \"wal", "my.toml:2", &["not TOML"]);
    refuses("seed = 1\n[ground\n", "my.toml:2", &["not TOML"]);
    refuses("seed = 1\n\nseed = 2\n", "my.toml:3", &["not TOML: duplicate key"]);
    refuses("name: walk\n", "my.toml:1", &["not TOML"]);
    for empty in ["", "\n\n", "# only a comment\n"] {
        refuses(empty, "my.toml", &["nothing in it", "legwork show stand"]);
    }
}

#[test]
fn files_that_cannot_be_read() {
    let folder = Folder::new("unreadable");
    assert_says(load("wlak", &[]), "scenario", &["called \"wlak\"; did you mean walk? built-in: stand, walk, push"]);
    assert!(!load("wlak", &[]).expect_err("there is none").is_io());

    let missing = folder.0.join("walk.tml").display().to_string();
    assert_says(load(&missing, &[]), &missing, &["did you mean walk?", "built-in: stand"]);
    assert!(load(&missing, &[]).expect_err("there is none").is_io());

    let path = folder.0.display().to_string();
    assert_says(load(&path, &[]), &path, &["is a folder, expected a file"]);
    assert!(load(&path, &[]).expect_err("it is a folder").is_io());

    let binary = folder.file("binary.toml", b"seed = 1\n\xff\xfe");
    assert_says(load(&binary, &[]), &binary, &["not UTF-8 text: found the byte 0xff in line 2, column 1"]);
}

#[test]
fn extends_that_lead_nowhere() {
    refuses("seed = 1\nextends = 'wlak'\n", "my.toml:2: extends", &["did you mean walk?"]);
    refuses("extends = 3\n", "my.toml:1: extends", &["found 3; valid is the name of a built-in scenario or a file"]);
    refuses("extends = 'nowhere/base.toml'\n", "my.toml:1: extends", &["nowhere/base.toml"]);

    let folder = Folder::new("circle");
    let a = folder.file("a.toml", "extends = 'b.toml'\n");
    let b = folder.file("b.toml", "seed = 1\nextends = './a.toml'\n");
    assert_says(load(&a, &[]), &format!("{b}:2: extends"), &["in a circle", "a.toml -> ", "b.toml -> "]);
    let itself = folder.file("itself.toml", "extends = 'itself.toml'\n");
    assert_says(load(&itself, &[]), &format!("{itself}:1: extends"), &["in a circle"]);

    // A mistake in the base is told with the base's place, unless the last word puts it right.
    let base = folder.file("base.toml", "seed = 1\nduration_s = -1\n");
    let top = folder.file("top.toml", "extends = 'base.toml'\n");
    assert_says(load(&top, &[]), &format!("{base}:2: duration_s"), &["found -1"]);
    assert!(load(&top, &sets(&["duration_s=1"])).is_ok());
}

#[test]
fn a_row_of_scenarios_has_an_end() {
    let folder = Folder::new("row");
    let write = |k: usize, base: &str| folder.file(&format!("{k}.toml"), format!("extends = \"{base}\"\n").as_bytes());
    (1..300).for_each(|k| drop(write(k, &format!("{}.toml", k - 1))));
    let first = write(0, "walk");
    let path = |k: usize| first.replace("0.toml", &format!("{k}.toml"));
    assert!(load(&path(99), &[]).is_ok());
    assert_says(
        load(&path(299), &[]),
        &format!("{}:1: extends", path(199)),
        &["extend one another in a row of more than 100"],
    );
}
