//! Every command that the documents show runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Commands that are not run here, with the reason.
const ELSEWHERE: [(&str, &str); 11] = [
    ("cargo xtask bench-peers", "installs other programs and takes minutes"),
    ("legwork reproduce", "run as a whole by tests/program/reproduce.rs"),
    ("legwork study screening", "half a minute; its file is read by another test"),
    ("legwork study interactions", "takes minutes; its file is read by another test, its design run small by others"),
    ("cargo run --release", "the program itself; without arguments it is run as `legwork`"),
    ("cargo install --path crates/legwork-cli", "builds what this test has built"),
    ("cargo xtask mutants", "installs cargo-mutants and takes hours"),
    ("cargo xtask test", "runs this test"),
    ("cargo xtask robots", "a part of cargo xtask test"),
    ("cargo xtask count-instructions", "a part of cargo xtask test"),
    ("cargo doc -p", "a part of cargo xtask test"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn documents() -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md"].map(|name| root().join(name)).into();
    for folder in [root().join("docs"), root().join("crates/legwork-rbd"), root().join("crates/legwork-qp")] {
        let files = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        found.extend(files.filter(|path| path.extension().is_some_and(|ending| ending == "md")));
    }
    found
}

/// The commands of a document, in order: lines of `sh` blocks, and what stands in backquotes and begins like one.
fn commands(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut block: Option<&str> = None;
    for line in text.lines() {
        if let Some(language) = line.strip_prefix("```") {
            block = if block.is_some() { None } else { Some(language) };
        } else if block == Some("sh") {
            found.push(line.split("  #").next().unwrap_or_default().trim().to_owned());
        } else if block.is_none() {
            let spans = line.split('`').skip(1).step_by(2);
            found.extend(spans.filter(|span| is_command(span)).map(str::to_owned));
        }
    }
    found.retain(|command| !command.is_empty());
    found
}

fn is_command(text: &str) -> bool {
    let known = ["run ", "list", "show ", "inspect ", "adopt ", "study ", "limits --", "compare --", "tune "]
        .iter()
        .any(|name| text.starts_with(&format!("legwork {name}")));
    // Names in capitals and dots stand for something.
    let general = text.split(' ').any(|word| word.contains("FILE") || word.contains("...") || word.starts_with("--"));
    text.starts_with("cargo ") || (known && !general)
}

#[test]
fn every_command_in_the_documents_runs() {
    let folder = std::env::temp_dir().join(format!("legwork-docs-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for the commands' files");
    let robots = folder.join("docs/robots");
    fs::create_dir_all(&robots).expect("a folder for the robots of docs/adopt.md");
    for entry in fs::read_dir(root().join("docs/robots")).expect("docs/robots") {
        let file = entry.expect("an entry").path();
        fs::copy(&file, robots.join(file.file_name().expect("a name"))).expect("a copy");
    }
    let program = Path::new(env!("CARGO_BIN_EXE_legwork"));
    let path =
        format!("{}:{}", program.parent().expect("a folder").display(), std::env::var("PATH").unwrap_or_default());
    let mut count = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).expect("a document");
        for command in commands(&text) {
            if let Some(example) = command.split("--example ").nth(1) {
                let name = example.split(' ').next().unwrap_or_default();
                let package = command.split("-p ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap_or_default();
                let file = root().join(format!("crates/{package}/examples/{name}"));
                assert!(
                    file.join("main.rs").is_file() || file.with_extension("rs").is_file(),
                    "{}: {command}: there is no such example",
                    document.display()
                );
                continue;
            }
            if ELSEWHERE.iter().any(|(known, _)| command.starts_with(known)) {
                continue;
            }
            count += 1;
            let output = Command::new("sh")
                .args(["-c", &command])
                .current_dir(&folder)
                .env("PATH", &path)
                .stdin(Stdio::null())
                .output()
                .expect("a shell");
            assert!(
                output.status.success(),
                "{}: {command}\n{}",
                document.display(),
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
    assert!(count >= 8, "only {count} commands found");
    let _ = fs::remove_dir_all(&folder);
}

/// The README's example of an own scenario.
#[test]
fn the_scenario_in_the_readme_runs() {
    let text = fs::read_to_string(root().join("README.md")).expect("README.md");
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let file = std::env::temp_dir().join(format!("legwork-readme-{}.toml", std::process::id()));
    fs::write(&file, example).expect("a folder for temporary files");
    let output = Command::new(env!("CARGO_BIN_EXE_legwork")).arg("run").arg(&file).output().expect("the program");
    let _ = fs::remove_file(&file);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("completed"), "the example should stand");
}

#[test]
fn links_between_the_documents_lead_somewhere() {
    for document in documents() {
        let text = fs::read_to_string(&document).expect("a document");
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.starts_with("http") || target.starts_with('#') {
                continue;
            }
            let target = target.split('#').next().unwrap_or_default();
            let path = document.parent().expect("a folder").join(target);
            assert!(path.exists(), "{}: {target} does not exist", document.display());
        }
    }
}
