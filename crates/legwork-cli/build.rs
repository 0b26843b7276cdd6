//! Tells the program by which compiler, and with which optimisation, it was made: `legwork bench` states both.

#![allow(clippy::print_stdout)]

use std::env;
use std::process::Command;

fn main() {
    let output = env::var_os("RUSTC").and_then(|rustc| Command::new(rustc).arg("--version").output().ok());
    let version = output.map_or_else(String::new, |output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=LEGWORK_RUSTC={version}");
    for name in ["TARGET", "OPT_LEVEL"] {
        println!("cargo::rustc-env=LEGWORK_{name}={}", env::var(name).unwrap_or_default());
    }
}
