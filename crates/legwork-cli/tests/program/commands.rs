//! Command lines that are wrong.

use crate::Folder;

#[test]
fn settings() {
    let folder = Folder::new("settings");
    for (set, words) in [
        (
            "contoller.limits.torque_nm=1",
            ["--set contoller.limits.torque_nm: unknown", "did you mean controller.limits.torque_nm?"],
        ),
        ("ground.slope_rad=0.1", ["--set ground.slope_rad: unknown", "did you mean ground.slope_deg?"]),
        ("pushes.3.force_n=1", ["--set pushes.3.force_n: pushes holds 1 element", "valid is pushes.0"]),
        ("pushes.0.force_n=nan", ["--set pushes.0.force_n: found nan", "from -1e6 to 1e6 [N]"]),
        ("ground.friction", ["--set ground.friction: found no \"=\"", "path=value"]),
        ("", ["--set : found no \"=\"", "path=value"]),
        ("simulation.period_s=0", ["--set simulation.period_s: found 0", "from 1e-5 to 0.1 [s]"]),
        ("reference.com.speed_mps=100", ["--set reference.com.speed_mps: found 100", "from -5 to 5 [m/s]"]),
    ] {
        folder.refuses(2, &["run", "push", "--set", set], &words);
        folder.refuses(2, &["show", "push", "--set", set], &words);
    }
    let long = format!("{}=1", "x".repeat(100_000));
    folder.refuses(2, &["run", "push", "--set", &long], &["unknown; valid here: controller"]);
    // Of several scenarios, the one that cannot be changed so
    folder.refuses(2, &["run", "push", "walk", "--set", "pushes.0.force_n=1"], &["--set pushes.0.force_n of walk: "]);
}

/// A negative number was taken for an option, and every message spoke of `--set duration_s`.
#[test]
fn durations() {
    let folder = Folder::new("durations");
    for (given, found) in
        [("nan", "nan"), ("-1", "-1"), ("0", "0"), ("1e9", "1000000000.0"), ("inf", "inf"), ("4s", "the text \"4s\"")]
    {
        let message = format!("--duration: found {found}; valid is a number from 0.001 to 1e6 [s]");
        folder.refuses(2, &["run", "stand", "--duration", given], &[&message]);
    }
    let ticks = ["run", "stand", "--set", "controller.period_s=1e-5", "--set", "simulation.period_s=1e-5"];
    folder.refuses(2, &[&ticks[..], &["--duration", "3600"]].concat(), &["--duration: ", "valid are at most 4000000"]);
}

#[test]
fn words_that_are_no_command() {
    let folder = Folder::new("words");
    for (arguments, word) in [
        (&["walk"][..], "unrecognized subcommand 'walk'"),
        (&["run"], "<SCENARIO>"),
        (&["run", "walk", "--lgo", "x.csv"], "unexpected argument '--lgo'"),
        (&["inspect", "planar_humanoid", "--base", "flying"], "fixed, planar, floating"),
        (&["list", "robots"], "models, scenarios, studies, settings"),
    ] {
        let done = folder.legwork(arguments);
        assert_eq!((done.code, done.out.as_str()), (2, ""), "{arguments:?}");
        assert!(done.err.starts_with("error: ") && done.err.contains(word), "{}", done.err);
    }
}

#[test]
fn states() {
    let folder = Folder::new("states");
    let inspect = ["inspect", "planar_humanoid", "--state", "state.json"];
    folder.refuses(1, &inspect, &["state.json: no such file"]);
    folder.refuses(1, &["inspect", "planar_humanoid", "--state", "."], &[".: is a folder, expected a file"]);
    let zeros = "0, 0, 0, 0, 0, 0";
    for (content, words) in [
        (String::new(), ["state.json:1:", "a state is {\"q\": [7 numbers], \"v\": [7 numbers]}"]),
        ("\0\u{1}\u{2}".into(), ["state.json:1:", "not JSON"]),
        (format!("{{\"q\": [{zeros}, 0], \"v\": [{zeros}"), ["state.json:1:", "not JSON"]),
        (format!("{{\"q\": [{zeros}, NaN], \"v\": [{zeros}, 0]}}"), ["state.json:1:", "not JSON"]),
        (format!("{{\"q\": [{zeros}, 1e999], \"v\": [{zeros}, 0]}}"), ["state.json:1:", "number out of range"]),
        (
            format!("{{\"q\": [{zeros}, 1e99], \"v\": [{zeros}, 0]}}"),
            ["state.json: q[6]: found 1e99", "from -1e9 to 1e9"],
        ),
        (
            format!("{{\"q\": [{zeros}], \"v\": [{zeros}, 0]}}"),
            ["state.json: q: found 6 numbers", "7 are needed: base_x"],
        ),
        (format!("{{\"q\": [{zeros}, 0], \"v\": [0]}}"), ["state.json: v: found 1 numbers", "7 are needed: base_x"]),
        (format!("{{\"q\": [{zeros}, 0]}}"), ["state.json:1:", "missing field `v`"]),
        (format!("{{\"q\": [{zeros}, 0], \"vel\": [0]}}"), ["state.json:1:", "unknown field `vel`"]),
        (format!("{{\"q\": [{zeros}, \"x\"], \"v\": [0]}}"), ["state.json:1:", "invalid type: string \"x\""]),
    ] {
        folder.file("state.json", content);
        folder.refuses(2, &inspect, &words);
    }
    folder.file("state.json", b"{\"q\": \xff}");
    folder.refuses(2, &inspect, &["state.json: not UTF-8 text", "found the byte 0xff in line 1, column 7"]);

    let floating = "name = \"a\"\nbase = \"floating\"\nbodies = [{ name = \"b\", mass_kg = 1, \
                    inertia_kgm2 = { xx = 1, yy = 1, zz = 1 } }]\n";
    folder.file("robot.toml", floating);
    folder.file("state.json", "{\"q\": [2, 0, 0, 0, 0, 0, 0], \"v\": [0, 0, 0, 0, 0, 0]}");
    let words = ["state.json: q[0..4]: found a quaternion", "of norm 2; it must be 1"];
    folder.refuses(2, &["inspect", "robot.toml", "--state", "state.json"], &words);
}
