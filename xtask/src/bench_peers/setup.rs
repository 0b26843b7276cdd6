//! Sets the peers up: packages from the Python package index into an environment of their own, their harnesses compiled.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use super::Places;
use crate::{say, succeeds};

/// How all harnesses are compiled.
pub(super) const FLAGS: [&str; 3] = ["-O3", "-DNDEBUG", "-w"];
/// Added where nothing is linked that a wheel ships, whose vectors are aligned for any processor.
pub(super) const NATIVE: &str = "-march=native";
/// What the package of Pinocchio asks of those who compile against it, with templates from its library as shipped.
const PINOCCHIO: [&str; 7] = [
    "-DPINOCCHIO_WITH_COLLISION",
    "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION",
    "-DPINOCCHIO_WITH_URDFDOM",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
];
const PINOCCHIO_LIBRARIES: [&str; 5] =
    ["pinocchio_default", "pinocchio_parsers", "urdfdom_model", "boost_filesystem", "boost_serialization"];

/// Another program: how to start it, or why it cannot be.
#[derive(Clone, Debug)]
pub(super) struct Peer {
    pub(super) name: &'static str,
    /// Program and first arguments.
    pub(super) command: Result<Vec<String>, String>,
}

/// Installs, downloads and compiles what is not there yet.
pub(super) fn set_up(places: &Places) -> Result<Vec<Peer>, String> {
    for tool in ["python3", "gcc", "g++"] {
        if !succeeds(Command::new(tool).arg("--version")) {
            return Err(format!("{tool} is needed and cannot be started"));
        }
    }
    for folder in ["data", "bin", "logs", "sources"] {
        let path = places.peers.join(folder);
        std::fs::create_dir_all(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    say("== setting up");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let build = ["build", "--release", "-p", "legwork", "--example", "peers"];
    if !succeeds(Command::new(cargo).args(build).current_dir(&places.root)) {
        return Err("our own side does not compile: cargo build --release -p legwork --example peers".to_owned());
    }
    environment(places)?;
    let libtsid = install_tsid(places);
    let sources = sources(places);
    let harness = |name, file: &str, packages: &[&str], flags: &[&str], libraries: &[&str]| {
        let compiled = sources.clone().and_then(|()| compile(places, file, packages, flags, libraries));
        Peer { name, command: compiled.map(|path| vec![path]) }
    };
    let python = places.peers.join("venv/bin/python").display().to_string();
    let osqp = places.root.join("bench/peers/qp_osqp.py").display().to_string();
    let tsid_libraries = [&["tsid", "eiquadprog"], &PINOCCHIO_LIBRARIES[..]].concat();
    let tsid = |name, file: &str, libraries: &[&str]| {
        let compiled = libtsid.clone().and_then(|()| compile(places, file, &[], &PINOCCHIO, libraries));
        Peer { name, command: compiled.map(|path| vec![path]) }
    };
    Ok(vec![
        harness("Pinocchio", "dynamics_pinocchio.cpp", &[], &PINOCCHIO, &PINOCCHIO_LIBRARIES),
        harness("DAQP", "qp_daqp.cpp", &["daqp"], &[NATIVE], &[]),
        harness("eiquadprog-fast", "qp_eiquadprog.cpp", &[], &[], &["eiquadprog"]),
        harness("quadprog", "qp_quadprog.cpp", &["quadprog"], &[NATIVE], &[]),
        harness("PIQP", "qp_piqp.cpp", &["piqp"], &[NATIVE], &[]),
        harness("ProxQP", "qp_proxqp.cpp", &[], &[NATIVE], &[]),
        Peer { name: "Clarabel", command: Ok(vec![ours(places), "clarabel".to_owned()]) },
        Peer { name: "OSQP", command: Ok(vec![python, osqp]) },
        Peer { name: "qpOASES", command: Err("the package index has no package of it".to_owned()) },
        tsid("TSID", "tick_tsid.cpp", &tsid_libraries),
        harness("MuJoCo", "contact_mujoco.c", &[], &[], &["mujoco"]),
        tsid("TSID + MuJoCo", "loop_tsid_mujoco.cpp", &[&tsid_libraries[..], &["mujoco"]].concat()),
    ])
}

/// Our example.
pub(super) fn ours(places: &Places) -> String {
    places.root.join("target/release/examples/peers").display().to_string()
}

/// Runs a command with its output in a file; where it fails, the last line that says so.
fn logged(places: &Places, log: &str, command: &mut Command) -> Result<(), String> {
    let path = places.peers.join("logs").join(log);
    let output = command.output().map_err(|error| format!("{log}: {error}"))?;
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let _ = std::fs::write(&path, &text);
    if output.status.success() {
        return Ok(());
    }
    let line = text.lines().find(|line| line.to_lowercase().contains("error")).unwrap_or("it failed");
    Err(format!("{}; all of it is in {}", line.trim(), path.display()))
}

fn environment(places: &Places) -> Result<(), String> {
    let venv = places.peers.join("venv");
    if !venv.join("bin/pip").exists() {
        logged(places, "venv", Command::new("python3").args(["-m", "venv"]).arg(&venv))?;
    }
    let requirements = places.root.join("bench/peers/requirements.txt");
    let mut pip = Command::new(venv.join("bin/pip"));
    logged(places, "packages", pip.args(["install", "--only-binary", ":all:", "-r"]).arg(requirements))
}

/// libtsid has no wheel: it is compiled in an environment of its own, which takes some minutes, and then kept.
fn install_tsid(places: &Places) -> Result<(), String> {
    let (venv, builder) = (places.peers.join("venv"), places.peers.join("venv-build"));
    if find(&prefix(places)?.join("lib"), "libtsid").is_some() {
        return Ok(());
    }
    say("libtsid is compiled, which takes some minutes");
    logged(places, "tsid-venv", Command::new("python3").args(["-m", "venv"]).arg(&builder))?;
    let wheels = places.peers.join("wheels");
    let mut wheel = Command::new(builder.join("bin/pip"));
    wheel.env("CMEEL_RUN_TESTS", "OFF").args(["wheel", "--no-deps", "-w"]).arg(&wheels).arg("libtsid==1.10.0");
    logged(places, "tsid-build", &mut wheel)?;
    let mut pip = Command::new(venv.join("bin/pip"));
    let file = find(&wheels, "libtsid").ok_or("pip wrote no wheel of libtsid")?;
    logged(places, "tsid-install", pip.args(["install", "--no-deps"]).arg(file))
}

/// The C and C++ sources of peers whose wheels have no interface for them.
fn sources(places: &Places) -> Result<(), String> {
    let folder = places.peers.join("sources");
    let list =
        std::fs::read_to_string(places.root.join("bench/peers/sources.txt")).map_err(|error| error.to_string())?;
    for package in list.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
        let (name, _) = package.split_once("==").ok_or("sources.txt: a line is no NAME==VERSION")?;
        if find(&folder, name).is_some() {
            continue;
        }
        let mut pip = Command::new(places.peers.join("venv/bin/pip"));
        pip.args(["download", "--no-deps", "--no-binary", name, "-d"]).arg(&folder).arg(package);
        logged(places, &format!("source-{name}"), &mut pip)?;
        let archive = find(&folder, name).ok_or_else(|| format!("pip wrote no archive of {name}"))?;
        let mut tar = Command::new("tar");
        logged(places, &format!("unpack-{name}"), tar.arg("xzf").arg(archive).arg("-C").arg(&folder))?;
    }
    Ok(())
}

/// The first entry of a folder, in order of names, that begins so; folders sort before their archives.
pub(super) fn find(folder: &Path, beginning: &str) -> Option<PathBuf> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    entries.sort();
    let begins = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(beginning));
    entries.into_iter().find(begins)
}

fn site_packages(places: &Places) -> Result<PathBuf, String> {
    let python = find(&places.peers.join("venv/lib"), "python3").ok_or("the environment has no lib/python3*")?;
    Ok(python.join("site-packages"))
}

fn prefix(places: &Places) -> Result<PathBuf, String> {
    Ok(site_packages(places)?.join("cmeel.prefix"))
}

/// Compiles a harness, and the C sources that it needs, if it is older than its source or a header; returns its path.
fn compile(
    places: &Places,
    file: &str,
    packages: &[&str],
    flags: &[&str],
    libraries: &[&str],
) -> Result<String, String> {
    let source = places.root.join("bench/peers").join(file);
    let stem = source.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let binary = places.peers.join("bin").join(&stem);
    if changed(&binary) > headers(places).iter().chain([&source]).filter_map(|path| changed(path)).max() {
        return Ok(binary.display().to_string());
    }
    say(&format!("compiling {file}"));
    let prefix = prefix(places)?;
    let mujoco = site_packages(places)?.join("mujoco");
    let includes = [
        prefix.join("include"),
        // TSID still names the headers of Pinocchio 3.
        prefix.join("include/pinocchio/deprecated"),
        prefix.join("include/eigen3"),
        prefix.join("include/urdfdom"),
        prefix.join("include/urdfdom_headers"),
        mujoco.join("include"),
    ];
    let mut command = Command::new(if file.ends_with(".c") { "gcc" } else { "g++" });
    command.args(FLAGS).args(flags).arg(&source).arg("-o").arg(&binary);
    if file.ends_with(".cpp") {
        command.arg("-std=c++17");
    }
    for include in includes {
        command.arg("-I").arg(include);
    }
    for package in packages {
        let folder =
            find(&places.peers.join("sources"), package).ok_or_else(|| format!("{package} is not unpacked"))?;
        let (include, c) = match *package {
            "daqp" => (folder.join("csrc/include"), folder.join("csrc/src")),
            "piqp" => (folder.join("include"), folder.join("none")),
            _ => (folder.join("quadprog"), folder.join("quadprog")),
        };
        command.arg("-I").arg(include);
        command.args(objects(places, package, &c)?);
    }
    command.arg("-L").arg(prefix.join("lib")).arg(format!("-Wl,-rpath,{}", prefix.join("lib").display()));
    for library in libraries {
        if *library == "mujoco" {
            command.arg(find(&mujoco, "libmujoco").ok_or("the package mujoco holds no library")?);
            command.arg(format!("-Wl,-rpath,{}", mujoco.display()));
        } else {
            command.arg(format!("-l{library}"));
        }
    }
    command.arg("-lm");
    logged(places, &stem, &mut command)?;
    Ok(binary.display().to_string())
}

fn changed(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|data| data.modified()).ok()
}

/// What harnesses share.
fn headers(places: &Places) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(places.root.join("bench/peers")) else { return Vec::new() };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.extension().is_some_and(|extension| extension == "hpp")).collect()
}

/// Compiles the C files of a folder into one object each.
fn objects(places: &Places, package: &str, folder: &Path) -> Result<Vec<PathBuf>, String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(Vec::new()) };
    let mut objects = Vec::new();
    for source in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if source.extension().is_none_or(|extension| extension != "c") {
            continue;
        }
        let stem = source.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let object = places.peers.join("bin").join(format!("{package}-{stem}.o"));
        let mut gcc = Command::new("gcc");
        gcc.args(FLAGS).args([NATIVE, "-c"]).arg(&source).arg("-o").arg(&object);
        gcc.arg("-I").arg(folder.join("../include"));
        logged(places, &format!("{package}-{stem}"), &mut gcc)?;
        objects.push(object);
    }
    Ok(objects)
}
