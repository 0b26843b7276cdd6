//! What the program reads: files and pipes that end, up to a size, of text in UTF-8; and the messages about what is in them.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

use crate::{Done, Folder, MODEL};

const SCENARIO: &str = "extends = \"stand\"\nduration_s = 0.01\n";
const STUDY: &str = "scenarios = [\"stand\"]\ndesign = \"grid\"\nset.duration_s = 0.01\n\
                     [[factors]]\npath = \"ground.friction\"\nlist = [0.7, 0.8]\n";
const TUNING: &str = "budget = 4\n[[factors]]\npath = \"ground.frict\"\nlinear = { from = 0.5, to = 1.0 }\n\
                      [[cases]]\nscenario = \"stand\"\n[[held_out]]\nscenario = \"walk\"\n[[objective]]\nmetric = \"torque_nm.mean\"\n";
const SAMPLES: &str = "t_s,x_m,z_m\n0,0.27025,0.885\n1,0.3,0.885\n2,0.3,0.885\n";
const STATE: &str = "{\"q\": [0, 0, 0, 0, 0, 0, 0], \"v\": [0, 0, 0, 0, 0, 0, 0]}";

/// Calls with a file, FILE for its name, and the ending that it should have.
const CALLS: [(&str, &str); 11] = [
    ("run FILE", "toml"),
    ("show FILE", "toml"),
    ("bench FILE --seconds 0.1", "toml"),
    ("limits --walk FILE", "toml"),
    ("compare FILE", "toml"),
    ("study FILE", "toml"),
    ("tune FILE", "toml"),
    ("run walk --set reference.com.trajectory=file --set reference.com.file=FILE", "csv"),
    ("inspect FILE", "toml"),
    ("inspect FILE", "urdf"),
    ("inspect planar_humanoid --state FILE", "json"),
];

/// Refuses in each call what `name` leads to, a name without its ending.
fn refused(folder: &Folder, code: i32, name: &str, word: &str) {
    for (call, ending) in CALLS {
        let file = format!("{name}.{ending}");
        let call: Vec<&str> = call.split(' ').map(|word| if word == "FILE" { &file } else { word }).collect();
        let call: Vec<String> = call.into_iter().map(|word| word.replace("=FILE", &format!("={file}"))).collect();
        folder.refuses(code, &call.iter().map(String::as_str).collect::<Vec<_>>(), &[&file, word]);
    }
}

/// Gives a path under the name with every ending.
fn linked(folder: &Folder, path: &str, name: &str) {
    for ending in ["toml", "csv", "urdf", "json"] {
        symlink(path, folder.0.join(format!("{name}.{ending}"))).expect("it can be made");
    }
}

#[test]
fn devices_and_pipes_with_names_are_no_files() {
    let folder = Folder::new("devices");
    linked(&folder, "/dev/zero", "zero");
    refused(&folder, 1, "zero", "is a device; valid is a file, or a command's output as the shell's <(command)");
    // Its stdin is /dev/null.
    linked(&folder, "/dev/stdin", "stdin");
    refused(&folder, 1, "stdin", "is a device; valid is a file");
    linked(&folder, "/proc/self/mem", "memory");
    refused(&folder, 1, "memory", "cannot be read: ");
    assert!(Command::new("mkfifo").arg(folder.0.join("pipe")).status().expect("mkfifo is there").success());
    linked(&folder, "pipe", "pipe");
    refused(&folder, 1, "pipe", "is a named pipe; valid is a file");
}

#[test]
fn files_of_any_size_are_refused_at_once() {
    let folder = Folder::new("sparse");
    File::create(folder.0.join("sparse")).and_then(|file| file.set_len(10_000_000_000)).expect("no byte is written");
    linked(&folder, "sparse", "sparse");
    refused(&folder, 2, "sparse", "MB; that is the most that is read");
    folder.refuses(2, &["run", "sparse.toml"], &["sparse.toml: holds more than 32 MB; that is the most that is read"]);
}

/// The program in a shell.
fn shell(folder: &Folder, line: &str) -> Done {
    let line = line.replace("legwork", env!("CARGO_BIN_EXE_legwork"));
    let mut shell = Command::new("bash");
    shell.args(["-c", &line]).current_dir(&folder.0).stdin(Stdio::null());
    Done::from(shell.output().expect("bash is there"))
}

#[test]
fn what_a_command_writes_is_read_as_a_file_is() {
    let folder = Folder::new("substitution");
    let files = [("s.toml", SCENARIO), ("study.toml", STUDY), ("com.csv", SAMPLES), ("state.json", STATE)];
    files.iter().for_each(|(name, text)| folder.file(name, text));
    let shown = shell(&folder, "legwork show <(cat s.toml)").succeeds().out;
    assert_eq!(shown.lines().count(), folder.legwork(&["show", "s.toml"]).succeeds().out.lines().count());
    assert!(shown.contains("\nduration_s = 0.01\n"), "{shown}");
    shell(&folder, "legwork run <(cat s.toml)").succeeds();
    shell(&folder, "cat s.toml | legwork run /dev/stdin").succeeds();
    shell(&folder, "legwork study <(cat study.toml) --out study").succeeds();
    let com = "--set reference.com.trajectory=file --set reference.com.file=";
    shell(&folder, &format!("legwork run walk --duration 0.01 {com}<(cat com.csv)")).succeeds();
    let given = shell(&folder, "legwork inspect planar_humanoid --json --state <(cat state.json)").succeeds().out;
    assert_eq!(given, folder.legwork(&["inspect", "planar_humanoid", "--json", "--state", "state.json"]).out);
    let endless = shell(&folder, "legwork run <(yes)");
    assert_eq!(endless.code, 2);
    assert!(endless.err.contains("holds more than 32 MB; that is the most that is read"), "{}", endless.err);
}

#[test]
fn a_byte_order_mark_does_no_harm_and_utf_16_is_told() {
    let folder = Folder::new("encodings");
    let marked = |name: &str, text: &str| folder.file(name, format!("\u{feff}{text}"));
    marked("s.toml", SCENARIO);
    folder.legwork(&["run", "s.toml"]).succeeds();
    marked("study.toml", STUDY);
    folder.legwork(&["study", "study.toml"]).succeeds();
    // It is read up to the slip in it.
    marked("tuning.toml", TUNING);
    folder.refuses(2, &["tune", "tuning.toml"], &["tuning.toml:2: factors.0: ground.frict: unknown"]);
    marked("com.csv", SAMPLES);
    let com = ["reference.com.trajectory=file", "reference.com.file=com.csv"];
    folder.legwork(&["run", "walk", "--duration", "0.01", "--set", com[0], "--set", com[1]]).succeeds();
    marked("state.json", STATE);
    folder.legwork(&["inspect", "planar_humanoid", "--state", "state.json"]).succeeds();
    marked("robot.toml", MODEL);
    folder.legwork(&["inspect", "robot.toml"]).succeeds();
    for ending in ["toml", "csv", "urdf", "json"] {
        let wide = SCENARIO.encode_utf16().flat_map(u16::to_le_bytes);
        // XML tells its encoding, by a mark too.
        let mark = [0xff, 0xfe].into_iter().filter(|_| ending != "urdf");
        folder.file(&format!("wide.{ending}"), mark.chain(wide).collect::<Vec<u8>>());
        folder.file(&format!("latin.{ending}"), b"# first line\n# H\xfcfte");
    }
    refused(&folder, 2, "wide", "not UTF-8 text: found UTF-16; save it as UTF-8");
    refused(&folder, 2, "latin", "not UTF-8 text: found the byte 0xfc in line 2, column 4");
}

#[test]
fn messages_stay_short_and_in_one_line_whatever_is_quoted() {
    let folder = Folder::new("long-messages");
    let (long, wild) = ("x".repeat(10_000_000), "a\\u001b[31m\\nb".repeat(1000));
    for text in [&long, &wild] {
        folder.file("s.toml", format!("extends = \"stand\"\nduration_s = \"{text}\"\n"));
        folder.refuses(
            2,
            &["run", "s.toml"],
            &["s.toml:2: duration_s: found the text \"", "valid is a number from 0.001"],
        );
        folder.file("s.toml", format!("extends = \"stand\"\n\"{text}\" = 1\n"));
        folder.refuses(
            2,
            &["run", "s.toml"],
            &["s.toml:2: ", "unknown; valid here: controller, description, duration_s"],
        );
        folder.file(
            "s.toml",
            format!("extends = \"stand\"\n[[pushes]]\nforce_n=1\nstart_s=0\nduration_s=1\nat = \"{text}\"\n"),
        );
        folder.refuses(2, &["run", "s.toml"], &["s.toml:6: pushes.0.at: found \"", "valid are com, right_shank"]);
        folder.file("s.toml", format!("extends = \"{text}\"\n"));
        folder.refuses(2, &["run", "s.toml"], &["s.toml:1: extends: "]);
        folder.file("study.toml", STUDY.replace("ground.friction", text));
        folder.refuses(2, &["study", "study.toml"], &["study.toml:4: factors, \"", "`legwork list settings` has all"]);
        folder.file("study.toml", format!("metrics = [\"{text}\"]\n{STUDY}"));
        folder.refuses(2, &["study", "study.toml"], &["study.toml:1: metrics: found \"", " more"]);
        folder.file("study.toml", format!("\"{text}\" = 1\n{STUDY}"));
        folder.refuses(2, &["study", "study.toml"], &["study.toml:1: ", "`factors`"]);
        folder.file("com.csv", format!("t_s,x_m,z_m\n0,0,\"{text}\"\n"));
        let com = ["reference.com.trajectory=file", "reference.com.file=com.csv"];
        let run = ["run", "walk", "--set", com[0], "--set", com[1]];
        folder.refuses(2, &run, &["com.csv:2: z_m: found \"", "valid is a number from -1000 to 1000"]);
        folder.file("com.csv", format!("{text},{}\n1,2\n", (0..5000).map(|k| format!("c{k},")).collect::<String>()));
        folder.refuses(2, &run, &["com.csv: the column t_s is missing; found ", " more; needed are t_s, x_m, z_m"]);
        folder.file("state.json", format!("{{\"{text}\": 1}}"));
        let inspect = ["inspect", "planar_humanoid", "--state", "state.json"];
        folder.refuses(2, &inspect, &["state.json:1:", "a state is {\"q\": [7 numbers], \"v\": [7 numbers]}"]);
    }
    let name = "n".repeat(4000);
    folder.refuses(1, &["run", &format!("{name}.toml")], &["nnn.toml: ", "neither a built-in scenario nor a file"]);
    folder.refuses(2, &["run", &name], &["scenario: neither a built-in scenario", "built-in: stand, walk"]);
    folder.refuses(2, &["run", "a\u{1b}[31m\nb"], &["called \"a\\u{1b}[31m\\nb\"; "]);
    folder.refuses(
        2,
        &["run", "walk", "--set", &format!("{name}=1")],
        &["--set nnn", "unknown; valid here: controller"],
    );
    folder.refuses(1, &["run", "walk", "--log", &format!("{name}.csv")], &["nnn.csv: cannot be written: "]);
    folder.refuses(2, &["list", "settings", &name], &["list: found \"nnn", "with which no name begins; valid are "]);
    let done = folder.legwork(&["bench", "--seconds", &name]);
    assert_eq!(done.code, 2);
    assert!(done.err.contains("valid is a number from 0.1 to 3600"), "{}", done.err);
    assert!(done.err.lines().all(|line| line.chars().count() <= 450), "{}", done.err);
}

#[test]
fn sixteen_thousand_pushes_are_read_shown_and_run() {
    let folder = Folder::new("many-pushes");
    let push = |k: u32| format!("[[pushes]]\nforce_n = {k}\nstart_s = {}\nduration_s = 0.1\n", 0.2 * f64::from(k));
    folder.file("many.toml", SCENARIO.to_owned() + &(0..16_000).map(push).collect::<String>());
    let shown = folder.legwork(&["show", "many.toml"]).succeeds().out;
    assert_eq!(shown.matches("[[pushes]]").count(), 16_000);
    fs::write(folder.0.join("shown.toml"), shown).expect("it can be written");
    let runs = folder.json(&["run", "many.toml", "shown.toml", "--json"]);
    assert_eq!(runs[0]["result_hash"], runs[1]["result_hash"]);
    let place = "many.toml:64000: pushes.15999.force_n";
    folder.file("many.toml", folder.text("many.toml").replace("force_n = 15999\n", "force_n = nan\n"));
    folder.refuses(2, &["run", "many.toml"], &[place, "found nan; valid is a number from"]);
}

/// A robot, an experiment, a study and a tuning, each given to the commands of the others.
#[test]
fn a_file_of_another_kind_is_called_by_its_name() {
    let folder = Folder::new("other-kinds");
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect("a file of the repository");
    for (name, from) in [
        ("robot.toml", "models/planar_humanoid.toml"),
        ("exo.urdf", "models/exo18.urdf"),
        ("exo.legwork.toml", "models/exo18.legwork.toml"),
        ("mine.toml", "scenarios/push.toml"),
        ("study.toml", "studies/com-gain.toml"),
        ("tuning.toml", "tunings/feet.toml"),
    ] {
        folder.file(name, read(from));
    }
    let found = [
        ("robot.toml", "a robot model", "`legwork run SCENARIO --set model=robot.toml` simulates it"),
        ("exo.urdf", "a robot model", "`legwork run SCENARIO --set model=exo.urdf` simulates it"),
        (
            "exo.legwork.toml",
            "the side file of a robot's URDF or MJCF",
            "`legwork run SCENARIO --set model=exo.urdf` simulates it",
        ),
        ("mine.toml", "a scenario", "`legwork run mine.toml` runs it"),
        ("study.toml", "a study", "`legwork study study.toml` runs it"),
        ("tuning.toml", "a tuning", "`legwork tune tuning.toml` runs it"),
    ];
    for (command, wanted) in [("run", "a scenario"), ("show", "a scenario"), ("study", "a study"), ("tune", "a tuning")]
    {
        for (file, what, takes) in found.iter().filter(|(_, what, _)| *what != wanted) {
            folder.refuses(2, &[command, file], &[&format!("{file}: found {what}, expected {wanted}; {takes}")]);
        }
    }
    let robot = |file: &str| format!("model={file}");
    for (file, what, takes) in &found[3..] {
        let says = format!("{file}: found {what}, expected a robot model; {takes}");
        folder.refuses(2, &["inspect", file], &[&says]);
        folder.refuses(2, &["run", "walk", "--set", &robot(file)], &[&says]);
    }
    let side = "exo.legwork.toml: found the side file of a robot's URDF or MJCF, expected a robot model; \
                it is read with exo.urdf, which is to be named";
    folder.refuses(2, &["inspect", "exo.legwork.toml"], &[side]);
    folder.refuses(2, &["run", "exo-sway", "--set", &robot("exo.legwork.toml")], &[side]);
    // What it is that another file names.
    folder.file("based.toml", "extends = \"study.toml\"\n");
    folder.refuses(2, &["run", "based.toml"], &["study.toml: found a study, expected a scenario"]);
    folder.file("of-robots.toml", read("studies/com-gain.toml").replace("\"walk-baseline\"", "\"robot.toml\""));
    folder.refuses(2, &["study", "of-robots.toml"], &["robot.toml: found a robot model, expected a scenario"]);
    // What is built in.
    for (command, name, says) in [
        (
            "run",
            "exo18",
            "found a robot model, expected a scenario; `legwork run SCENARIO --set model=exo18` simulates it",
        ),
        ("run", "com-gain", "found a study, expected a scenario; `legwork study com-gain` runs it"),
        ("study", "thesis", "found a tuning, expected a study; `legwork tune thesis` runs it"),
        ("inspect", "walk", "found a scenario, expected a robot model; `legwork run walk` runs it"),
    ] {
        folder.refuses(2, &[command, name], &[says]);
    }
    // A slip in a file is none of its kind.
    folder.file("slip.toml", "duration_s = 1\nbase = \"floating\"\n");
    folder.refuses(2, &["run", "slip.toml"], &["slip.toml:2: base: unknown; valid here: controller"]);
}
