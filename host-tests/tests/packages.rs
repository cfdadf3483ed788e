//! What a machine without a network cannot have is skipped; a lock file that is behind its package is no such thing.

use host_tests::had;
use picket_host::toolchain::ToolError;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A package, with this dependency and this lock file.
fn package(name: &str, dependency: &str, lock: &str) -> PathBuf {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&place);
    fs::create_dir_all(place.join("src")).unwrap();
    fs::write(place.join("src/lib.rs"), "").unwrap();
    let manifest =
        format!("[workspace]\n[package]\nname = \"{name}\"\n[dependencies]\n{dependency}");
    fs::write(place.join("Cargo.toml"), manifest).unwrap();
    if !lock.is_empty() {
        fs::write(place.join("Cargo.lock"), lock).unwrap();
    }
    place
}

/// What a cargo that must not ask the registry, and has never asked it, says of a package.
fn said(place: &Path) -> String {
    let mut command = Command::new(env!("CARGO"));
    command.args(["check", "--locked", "--offline"]).current_dir(place);
    let output = command.env("CARGO_HOME", place.join("home")).output().unwrap();
    assert!(!output.status.success());
    String::from_utf8(output.stderr).unwrap()
}

fn skipped(output: &str) -> bool {
    let had = || had::<()>(Err(ToolError::Build { bin: String::new(), output: output.into() }));
    std::panic::catch_unwind(|| had().is_none()).unwrap_or(false)
}

#[test]
fn packages_that_are_not_here_are_skipped_and_a_lock_file_that_is_behind_fails() {
    let absent = said(&package("absent", "libm = \"0.2\"", ""));
    assert!(skipped(&absent), "{absent}");
    let local = format!("local = {{ path = {:?} }}", package("local", "", ""));
    for (name, lock) in [
        ("unlocked", ""),
        ("behind", "version = 4\n[[package]]\nname = \"behind\"\nversion = \"0.0.0\"\n"),
    ] {
        let output = said(&package(name, &local, lock));
        assert!(output.contains("lock file") && !skipped(&output), "{output}");
    }
}
