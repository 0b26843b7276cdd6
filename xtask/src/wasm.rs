//! Controller, simulator and run in WebAssembly: they compile without clock, files and threads, and in Node they have the
//! bits that they have natively. The module is `xtask/wasm`; what this needs and makes lies below `target/wasm`.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use crate::{Sum, cargo, root, say};

const TARGET: &str = "wasm32-unknown-unknown";

/// What is run on both sides.
const SCENARIOS: [&str; 2] = ["walk", "push"];

/// The check alone. With `--debian` Debian's compiler builds the module even where the usual one could.
pub(crate) fn run(arguments: &[String]) -> ExitCode {
    let mut sum = Sum::default();
    match arguments {
        [] => test(&mut sum),
        [option] if option == "--debian" => check(&mut sum, debian()),
        _ => {
            say("usage: cargo xtask wasm [--debian]");
            return ExitCode::from(2);
        }
    }
    if sum.is_passed() && sum.passed > 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Builds the module and compares its hashes with the native ones.
pub(crate) fn test(sum: &mut Sum) {
    check(sum, usual().or_else(debian));
}

fn check(sum: &mut Sum, compiler: Option<Compiler>) {
    let Some(compiler) = compiler else {
        return not_checked(
            sum,
            "no compiler for it here, and none could be installed (rustup target add, apt-get download)",
        );
    };
    if !has_node() {
        return not_checked(sum, "no Node here (install the package nodejs)");
    }
    let built = compiler.module();
    sum.count("controller, simulator and run compile for WebAssembly", built.is_some());
    let Some(module) = built else { return };
    let mut native = cargo(&["run", "--release", "--quiet", "--", "run", "--json"], &[]);
    let native = answer(native.args(SCENARIOS)).map(|text| hashes(&text)).unwrap_or_default();
    let mut node = Command::new("node");
    node.arg(root().join("xtask/wasm/run.mjs")).arg(module).args(SCENARIOS);
    let lines = answer(&mut node).unwrap_or_default();
    for (index, scenario) in SCENARIOS.iter().enumerate() {
        let native = native.get(index).map_or("no hash", String::as_str);
        let ours = lines.lines().find_map(|line| line.strip_prefix(&format!("{scenario} "))).unwrap_or("no run");
        say(&format!("{scenario}: {ours} in WebAssembly, {native} natively"));
        sum.count(&format!("{scenario} has the native result_hash in WebAssembly"), ours == native);
    }
}

/// Says that nothing is known; where all that is needed should be there, that is a failure.
fn not_checked(sum: &mut Sum, reason: &str) {
    say(&format!("WebAssembly not checked: {reason}"));
    if env::var_os("CI").is_some() {
        sum.count("WebAssembly", false);
    }
}

/// The values of `result_hash` in the program's JSON.
fn hashes(json: &str) -> Vec<String> {
    let after = json.split("\"result_hash\":").skip(1);
    after.filter_map(|rest| rest.split('"').nth(1)).map(str::to_owned).collect()
}

/// What `command` writes to stdout, where it succeeds.
fn answer(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Whether `program` with `arguments` succeeds, in silence.
fn succeeds(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Whether there is Node; it is installed only on the machines that do nothing but check.
fn has_node() -> bool {
    let there = || succeeds("node", &["--version"]);
    let install = || {
        succeeds("apt-get", &["update"])
            && succeeds("apt-get", &["install", "--yes", "--no-install-recommends", "nodejs"])
    };
    there() || (env::var_os("CI").is_some() && install() && there())
}

/// What the module is built with.
#[derive(Debug, Default)]
struct Compiler {
    /// What cargo is told besides.
    arguments: Vec<&'static str>,
    variables: Vec<(&'static str, String)>,
    /// Of what it builds, below `target/wasm`.
    folder: &'static str,
}

impl Compiler {
    /// The module's file.
    fn module(&self) -> Option<PathBuf> {
        let folder = folder().join(self.folder);
        let built = cargo(&["build", "--release", "--package", "legwork-wasm", "--target", TARGET], &[])
            .args(&self.arguments)
            .arg("--target-dir")
            .arg(&folder)
            // Code of the machine that builds is no use here, and neither are names of lines.
            .env_remove("RUSTFLAGS")
            .env("CARGO_PROFILE_RELEASE_DEBUG", "false")
            .envs(self.variables.iter().map(|(name, value)| (name, value)))
            .status()
            .is_ok_and(|status| status.success());
        built.then(|| folder.join(TARGET).join("release/legwork_wasm.wasm"))
    }
}

fn folder() -> PathBuf {
    root().join("target/wasm")
}

/// The compiler that builds everything else, where it has the target or rustup can add it.
fn usual() -> Option<Compiler> {
    let there = || {
        let libraries = answer(Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]));
        libraries.is_some_and(|path| Path::new(path.trim()).is_dir())
    };
    (there() || (succeeds("rustup", &["target", "add", TARGET]) && there()))
        .then(|| Compiler { folder: "usual", ..Compiler::default() })
}

/// Debian's compiler of its web browsers, unpacked and not installed, as it conflicts with others. It has no standard library
/// for the target, so that cargo builds one.
fn debian() -> Option<Compiler> {
    let folder = folder().join("debian");
    let done = folder.join("unpacked");
    if !done.is_file() {
        unpack(&folder)?;
        fs::write(&done, "").ok()?;
    }
    let binaries = folder.join("usr/bin");
    let linker = names(&binaries)?.into_iter().find(|name| name.starts_with("wasm-ld-"))?;
    let linker = binaries.join(linker);
    let libraries = folder.join("usr/lib/x86_64-linux-gnu");
    Some(Compiler {
        arguments: vec!["-Zbuild-std=std,panic_abort"],
        variables: vec![
            ("RUSTC_BOOTSTRAP", "1".into()),
            ("RUSTC", binaries.join("rustc").display().to_string()),
            ("LD_LIBRARY_PATH", libraries.display().to_string()),
            ("RUSTFLAGS", format!("-C linker={} -C linker-flavor=wasm-ld", linker.display())),
        ],
        folder: "by-debian",
    })
}

/// Unpacks the compiler, the source of its standard library, the newest linker, and the libraries that these need.
fn unpack(folder: &Path) -> Option<()> {
    let found =
        || answer(Command::new("apt-cache").args(["search", "--names-only", "^(rustc-web|rust-web-src|lld-[0-9]+)$"]));
    let newest = |found: &str| -> Option<String> {
        let versions =
            found.lines().filter_map(|line| line.strip_prefix("lld-")?.split(' ').next()?.parse::<u32>().ok());
        Some(format!("lld-{}", versions.max()?))
    };
    say("unpacking Debian's compiler for WebAssembly");
    // Where the lists cannot be renewed, those of before may do.
    let _ = succeeds("apt-get", &["update"]);
    let mut packages = vec!["rustc-web".to_owned(), "rust-web-src".to_owned(), newest(&found()?)?];
    let mut next = 0;
    while let Some(package) = packages.get(next) {
        let needs = answer(Command::new("apt-cache").args(["depends", "--important", package]))?;
        for need in needs.lines().filter_map(|line| line.trim().strip_prefix("Depends: ")) {
            if (need.starts_with("libstd-rust-web") || need.starts_with("libllvm"))
                && !packages.iter().any(|p| p == need)
            {
                packages.push(need.to_owned());
            }
        }
        next += 1;
    }
    let archives = folder.join("archives");
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(&archives).ok()?;
    answer(Command::new("apt-get").arg("download").args(&packages).current_dir(&archives))?;
    for archive in names(&archives)? {
        answer(Command::new("dpkg").arg("-x").arg(archives.join(archive)).arg(folder))?;
    }
    fs::remove_dir_all(&archives).ok()
}

/// The names of what lies in `folder`.
fn names(folder: &Path) -> Option<Vec<String>> {
    Some(fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect())
}

#[cfg(test)]
mod tests {
    use super::hashes;

    #[test]
    fn hashes_of_several_runs_are_read() {
        let json = r#"[{"result_hash": "0a1b", "n": 1}, {"result_hash":"2c"}]"#;
        assert_eq!(hashes(json), ["0a1b", "2c"]);
    }
}
