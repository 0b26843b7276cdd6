//! `legwork study`: files, folders, interruption, shards.

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::{Done, Folder};

/// A study of a fraction of a second, and the folder that it is in.
fn small(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.file(
        "small.toml",
        "scenarios = [\"walk\", \"push\"]\ndesign = \"one-at-a-time\"\n[set]\nduration_s = 0.7\n\
         [[factors]]\nname = \"torque\"\npath = \"controller.limits.torque_nm\"\nlist = [1, 150, 220]\nmarked = 220.0\n",
    );
    folder
}

#[test]
fn a_study_of_a_ground_that_gives_way_counted_as_if_nothing_were_wrong() {
    let folder = Folder::new("doubtful");
    folder.file(
        "soft.toml",
        "scenarios = [\"walk-spring-damper\", \"walk\"]\ndesign = \"grid\"\n[set]\nduration_s = 1.5\n\
         [[factors]]\npath = \"seed\"\nlist = [0, 1]\n",
    );
    let done = folder.legwork(&["study", "soft.toml", "--json"]).succeeds();
    let said =
        "warning: walk-spring-damper: 2 of 2 rollouts broke bounds of the simulation; the column violations says which";
    assert!(done.err.contains(said) && !done.err.contains("warning: walk:"), "{}", done.err);
    let result: Value = serde_json::from_str(&done.out).unwrap();
    let doubtful = [0, 1].map(|scenario: usize| result["scenarios"][scenario]["doubtful"].as_u64().unwrap());
    assert_eq!(doubtful, [2, 0]);
    let table = folder.text("legwork-soft/rollouts.csv");
    let rows: Vec<&str> = table.lines().filter(|line| line.contains("penetration of the ground")).collect();
    assert!(rows.len() == 2 && rows.iter().all(|row| row.contains("walk-spring-damper")), "{table}");
    assert!(folder.text("legwork-soft/report.html").contains("bounds broken"));
}

#[test]
fn a_study_leaves_tables_figures_and_a_page() {
    let folder = small("study");
    let [result] = &folder.json(&["study", "small.toml", "--json"])[..] else { panic!("one object a study") };
    assert_eq!((&result["study"], &result["rollouts"]), (&"small".into(), &8.into()));
    let walk = &result["scenarios"][0];
    assert_eq!((&walk["completed"], &walk["fell"], &walk["rollouts"]), (&3.into(), &1.into(), &4.into()));
    let levels = walk["sweeps"][0]["levels"].as_array().unwrap();
    assert_eq!((levels.len(), &levels[0]["level"], &levels[0]["ending"]), (3, &1.0.into(), &"fell".into()));
    assert!(levels[0]["fell_at_s"].as_f64().unwrap() < 0.7 && levels[2]["survived"] == Value::Bool(true));
    // The same figure as the scenario itself has.
    let run = folder.json(&["run", "walk", "--duration", "0.7", "--json"]);
    assert_eq!(levels[2]["metrics"]["torque_nm.mean"], run[0]["metrics"]["torque_nm"]["mean"]);

    let at = |name: &str| folder.text(&format!("legwork-small/{name}"));
    assert_eq!(serde_json::from_str::<Value>(&at("results.json")).unwrap(), *result);
    let csv = at("rollouts.csv");
    assert_eq!(csv.lines().count(), 9);
    assert!(csv.starts_with(
        "rollout,scenario,torque [Nm],ending,cause,reason,violations,input_hash,result_hash,survived,fell_at_s"
    ));
    let page = at("report.html");
    assert!(page.contains("</html>") && page.contains("Study: small") && !page.contains("NaN"));
    assert!(!page.contains("http://") && !page.contains("https://"), "the page loads nothing");
    let figures = ["torque-with-a-push.svg", "torque-without-a-push.svg"];
    for name in figures {
        assert!(at(&format!("figures/{name}")).ends_with("</svg>\n"), "{name}");
        assert!(page.contains("torque limit") || page.contains("torque"), "{name}");
    }
    // A second time nothing is run again, and the bytes stay.
    let chunk = folder.0.join("legwork-small/chunks/000000.jsonl");
    let before = fs::metadata(&chunk).unwrap().modified().unwrap();
    folder.legwork(&["study", "small.toml"]).succeeds();
    assert_eq!(fs::metadata(&chunk).unwrap().modified().unwrap(), before);
    assert_eq!(at("rollouts.csv"), csv);
    // What lies in the folder is a study that gives the same.
    folder.legwork(&["study", "legwork-small/study.toml", "--out", "again"]).succeeds();
    assert_eq!(folder.text("again/rollouts.csv"), csv);
}

#[test]
fn a_damaged_chunk_is_made_again() {
    let folder = small("damaged");
    folder.legwork(&["study", "small.toml"]).succeeds();
    let csv = folder.text("legwork-small/rollouts.csv");
    let name = "legwork-small/chunks/000003.jsonl";
    let text = folder.text(name);
    folder.file(name, text.replacen('7', "8", 1));
    let done = folder.legwork(&["study", "small.toml"]).succeeds();
    assert!(done.err.contains("warning: ") && done.err.contains("000003.jsonl"), "{}", done.err);
    assert_eq!((folder.text(name), folder.text("legwork-small/rollouts.csv")), (text, csv));
}

#[test]
fn figures_that_differ_by_rounding_had_indices() {
    let folder = Folder::new("rounding");
    let weights = ["joint_acceleration", "grf", "momentum", "feet", "torso", "braking", "foot_rotation"];
    let paths = weights.map(|weight| format!("\"controller.weights.{weight}\"")).join(", ");
    folder.file(
        "noise.toml",
        format!(
            "scenarios = [\"walk\"]\ndesign = \"saltelli\"\nsamples = 4\n\
             metrics = [\"torque_nm.mean\", \"u2_n2m2.mean\"]\n[set]\nduration_s = 0.7\n\
             [[factors]]\nname = \"all weights\"\npaths = [{paths}]\nrelative = true\nlinear = {{ from = 0.9, to = 1.1 }}\n\
             [[factors]]\npath = \"controller.planner.com_gain\"\nrelative = true\nlinear = {{ from = 0.9, to = 1.1 }}\n"
        ),
    );
    let noise = folder.text("noise.toml");
    let gain = noise.find("[[factors]]\npath").unwrap();
    let twice = format!("{}[[factors]]\npath = \"seed\"\nlist = [0, 1]\n", &noise[..gain]);
    folder.file("nothing.toml", twice);
    let done = folder.legwork(&["study", "nothing.toml"]).succeeds();
    for words in ["survived: the same in all rollouts\n", "torque_nm.mean: the same in all rollouts, ", " Nm\n"] {
        assert!(done.out.contains(words), "{words:?} is not in {}", done.out);
    }
    let result: Value = serde_json::from_str(&folder.text("legwork-nothing/results.json")).unwrap();
    for metric in &result["scenarios"][0]["metrics"].as_array().unwrap()[1..] {
        let [least, greatest] = ["least", "greatest"].map(|key| metric[key].as_f64().unwrap());
        assert!(least < greatest && greatest / least - 1.0 < 1e-10, "there is noise, and little: {metric}");
        assert_eq!(metric["sobol"]["shares"], Value::Null);
    }
    assert_eq!(result["scenarios"][0]["metrics"][1]["unit"], "Nm");
    assert!(folder.text("legwork-nothing/report.html").contains("The same in all rollouts: survived, torque_nm.mean"));
    // Beside a factor that matters, one that does not has nothing.
    let [result] = &folder.json(&["study", "noise.toml", "--json"])[..] else { panic!("one object") };
    let total = &result["scenarios"][0]["metrics"][1]["sobol"]["shares"]["total"];
    let [weights, gain] = [0, 1].map(|factor| total[factor]["value"].as_f64().unwrap());
    assert!(weights == 0.0 && gain > 0.1, "{total}");
}

#[test]
fn what_a_study_sets_was_blamed_on_the_command_line() {
    let folder = Folder::new("study-set");
    let study = |scenarios: &str, set: &str| {
        format!(
            "scenarios = [{scenarios}]\ndesign = \"grid\"\n[set]\nduration_s = 1.1\n{set}\n[[factors]]\npath = \"seed\"\nlist = [0]\n"
        )
    };
    folder.file("friction.toml", study("\"walk\"", "ground.friction = 600"));
    folder.refuses(
        2,
        &["study", "friction.toml"],
        &["friction.toml:5: set.ground.friction: found 600; valid is a number from"],
    );
    folder.file("two.toml", study("\"push\", \"walk\"", "pushes.0.force_n = 600"));
    folder.refuses(
        2,
        &["study", "two.toml"],
        &["two.toml:5: set.pushes.0.force_n: in the scenario walk: pushes is empty"],
    );
    folder.refuses(
        2,
        &["study", "friction.toml", "--set", "ground.friction=700"],
        &["--set ground.friction: found 700"],
    );
    folder.file("pushes.toml", study("\"push\"", "pushes.0.force_n = 600"));
    folder.legwork(&["study", "pushes.toml"]).succeeds();
    let run = folder.json(&["run", "push", "--duration", "1.1", "--set", "pushes.0.force_n=600", "--json"]);
    let table = folder.text("legwork-pushes/rollouts.csv");
    assert!(table.contains(run[0]["result_hash"].as_str().unwrap()), "{table}");
    folder.legwork(&["study", "pushes.toml", "--set", "pushes.0.force_n=500", "--out", "less"]).succeeds();
    folder.legwork(&["study", "less/study.toml", "--out", "again"]).succeeds();
    assert_eq!(folder.text("less/rollouts.csv"), folder.text("again/rollouts.csv"));
    assert_ne!(folder.text("less/rollouts.csv"), table);
}

#[test]
fn a_merge_called_a_damaged_chunk_missing() {
    let folder = small("merge-damaged");
    for (shard, out) in [("1/2", "one"), ("2/2", "two")] {
        folder.legwork(&["study", "small.toml", "--shard", shard, "--out", out]).succeeds();
    }
    let name = "two/chunks/000003.jsonl";
    let sound = folder.text(name);
    folder.file(name, &sound[..sound.len() - 9]);
    let words = [
        "all: 1 of 8 chunks are damaged: two/chunks/000003.jsonl is damaged or cut short: its content does not match its checksum; \
         run their shards again, which makes them anew",
    ];
    folder.refuses(2, &["study", "merge", "one", "two", "--into", "all"], &words);
    folder.legwork(&["study", "small.toml", "--shard", "2/2", "--out", "two"]).succeeds();
    assert_eq!(folder.text(name), sound);
    fs::create_dir_all(folder.0.join("copy")).unwrap();
    for file in ["study.toml", "chunks/000003.jsonl"] {
        folder.file(&format!("copy/{file}"), folder.text(&format!("two/{file}")));
    }
    folder.file(name, "");
    let done = folder.legwork(&["study", "merge", "one", "two", "copy", "--into", "all"]).succeeds();
    assert!(done.err.starts_with(
        "warning: two/chunks/000003.jsonl: is cut short in its first line; another folder has it whole\n"
    ));
}

/// Twice killed without a word, a study leaves nothing behind that the next run does not clear.
#[cfg(unix)]
#[test]
fn a_killed_study_goes_on_and_its_litter_is_cleared() {
    let folder = long("study-killed", 160, 2);
    for least in [3, 9] {
        let mut child =
            folder.command(&["study", "long.toml"]).stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
        wait_for(&folder, least);
        child.kill().unwrap();
        child.wait().unwrap();
    }
    // What a kill in the middle of writing leaves
    for name in
        ["chunks/.000070.unfinished.jsonl", ".rollouts.unfinished.csv", ".results.unfinished.json", ".lock-1-of-3"]
    {
        folder.file(&format!("legwork-long/{name}"), "half");
    }
    let done = folder.legwork(&["study", "long.toml"]).succeeds();
    assert!(done.err.starts_with("long: goes on; "), "{}", done.err);
    let mut found: Vec<_> =
        fs::read_dir(folder.0.join("legwork-long")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    found.sort();
    let expected = [
        ".lock",
        ".lock-start",
        "chunks",
        "figures",
        "report.html",
        "results.json",
        "rollouts.csv",
        "rollouts.parquet",
        "study.toml",
    ];
    assert_eq!(found, expected);
    assert!(fs::read_dir(folder.0.join(CHUNKS)).unwrap().all(|entry| whole(&entry.unwrap())));
    folder.legwork(&["study", "long.toml", "--out", "at-once"]).succeeds();
    assert_eq!(folder.text("legwork-long/rollouts.csv"), folder.text("at-once/rollouts.csv"));
}

#[test]
fn shards_give_what_one_run_gives() {
    let folder = small("shards");
    folder.legwork(&["study", "small.toml", "--out", "whole", "--threads", "1"]).succeeds();
    for (shard, out) in [("1/3", "one"), ("2/3", "two"), ("3/3", "two")] {
        let done = folder.legwork(&["study", "small.toml", "--shard", shard, "--out", out]).succeeds();
        assert!(done.out.is_empty() && done.err.contains("legwork study merge"), "{}", done.err);
    }
    let whole = folder.legwork(&["study", "merge", "one"]);
    assert!(whole.code == 2 && whole.err.contains("chunks are missing"), "{}", whole.err);
    let merged = folder.legwork(&["study", "merge", "one", "two", "--into", "all"]).succeeds();
    assert!(merged.out.contains("small: "), "{}", merged.out);
    for name in ["rollouts.csv", "rollouts.parquet", "results.json", "study.toml"] {
        let read = |folder_name: &str| fs::read(folder.0.join(folder_name).join(name)).unwrap();
        assert!(read("whole") == read("all"), "{name}");
    }
}

/// A study of minutes, stopped after some of it, keeps that and goes on from there.
#[test]
fn an_interrupted_study_goes_on() {
    let folder = long("study-interrupted", 600, 20);
    let mut command = folder.command(&["study", "long.toml"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for(&folder, 2);
    // Meanwhile nobody else may write there.
    folder.refuses(1, &["study", "long.toml"], &["legwork-long"]);
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let done = Done::from(child.wait_with_output().unwrap());
    assert_eq!((done.code, done.out.as_str()), (130, ""), "{}", done.err);
    assert!(done.err.contains("rollouts are kept in legwork-long, the same command goes on"), "{}", done.err);
    let kept = written(&folder);
    assert!((2..120).contains(&kept), "{kept}");
    assert!(!folder.0.join("legwork-long/report.html").exists());

    let mut command = folder.command(&["study", "long.toml"]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for(&folder, kept + 1);
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let done = Done::from(child.wait_with_output().unwrap());
    assert!(done.err.starts_with("long: goes on; "), "{}", done.err);
}

/// Where `long.toml` writes what it computed.
const CHUNKS: &str = "legwork-long/chunks";

/// A folder with a study of many rollouts that last so long [s].
fn long(name: &str, samples: u32, duration: u32) -> Folder {
    let folder = Folder::new(name);
    folder.file(
        "long.toml",
        format!(
            "scenarios = [\"stand\"]\ndesign = \"latin-hypercube\"\nsamples = {samples}\n[set]\nduration_s = {duration}\n\
             [[factors]]\npath = \"ground.friction\"\nlinear = {{ from = 0.5, to = 1.0 }}\n"
        ),
    );
    folder
}

/// How many chunks are there as a whole.
fn written(folder: &Folder) -> usize {
    fs::read_dir(folder.0.join(CHUNKS)).map_or(0, |entries| entries.filter(|e| whole(e.as_ref().unwrap())).count())
}

/// Waits until so many chunks are there.
fn wait_for(folder: &Folder, least: usize) {
    let begin = Instant::now();
    while written(folder) < least {
        assert!(begin.elapsed() < Duration::from_secs(120), "{} of {least} chunks were written", written(folder));
        sleep(Duration::from_millis(5));
    }
}

fn whole(entry: &fs::DirEntry) -> bool {
    let name = entry.file_name();
    name.to_string_lossy().ends_with(".jsonl") && !name.to_string_lossy().starts_with('.')
}

#[test]
fn wrong_calls_are_refused_before_anything_runs() {
    let folder = small("study-wrong");
    let good = folder.text("small.toml");
    folder.file("path.toml", good.replace("torque_nm", "torque"));
    folder.file("level.toml", good.replace("[1, 150", "[-1, 150"));
    folder.file("foreign/mine.txt", "");
    folder.file("file", "");
    folder.legwork(&["study", "small.toml", "--out", "other"]).succeeds();
    let refused: &[(i32, &[&str], &[&str])] = &[
        (
            2,
            &["study", "path.toml"],
            &["path.toml:5", "controller.limits.torque: unknown", "did you mean controller.limits.torque_nm?"],
        ),
        (2, &["study", "level.toml"], &["the level -1 is not one that walk can have", "valid is a number from"]),
        (2, &["study", "torque-limt"], &["did you mean torque-limit?", "built-in: "]),
        (1, &["study", "no/such.toml"], &["no/such.toml"]),
        (2, &["study", "small.toml", "small.toml"], &["two studies are called \"small\""]),
        (2, &["study", "small.toml", "--shard", "3/2"], &["3/2", "shards count from 1"]),
        (2, &["study", "small.toml", "--set", "seed=-1"], &["--set seed", "found -1"]),
        (2, &["study", "small.toml", "--set", "seed=1", "--out", "other"], &["other", "holds another study"]),
        (2, &["study", "small.toml", "--out", "foreign"], &["foreign", "holds files (mine.txt) and no study"]),
        (1, &["study", "small.toml", "--out", "file"], &["file: is a file, expected a folder"]),
        (1, &["study", "small.toml", "--out", "file/below"], &["file/below"]),
        (1, &["study", "merge", "nowhere"], &["nowhere"]),
        (2, &["study", "merge", "foreign"], &["foreign"]),
        (2, &["show", "interactions", "--set", "seed=1"], &["a study is shown as it is"]),
    ];
    for (code, arguments, words) in refused {
        folder.refuses(*code, arguments, words);
    }
    assert!(!folder.0.join("legwork-small").exists());
}

#[test]
fn studies_are_listed_and_shown_as_files_that_run() {
    let folder = Folder::new("study-list");
    let listed = &folder.json(&["list", "studies", "--json"])[0]["studies"];
    assert!(listed.as_array().unwrap().len() >= 9);
    for study in listed.as_array().unwrap() {
        assert!(study["rollouts"].as_u64().unwrap() > 9 && study["description"].is_string(), "{study}");
    }
    let text = folder.legwork(&["show", "torque-limit"]).succeeds().out;
    assert!(text.contains("name = \"torque-limit\"") && text.contains("# "));
    folder.file(
        "mine.toml",
        text.replace("list = [100, 120,", "list = [").replace("design", "set.duration_s = 0.3\ndesign"),
    );
    folder.legwork(&["study", "mine.toml", "--out", "mine"]).succeeds();
    assert!(folder.text("mine/study.toml").contains("duration_s = 0.3"));
}
