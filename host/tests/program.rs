//! The program under test: how it is run, and what it refuses. `crate::PROGRAM` is its file.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A file of this test's own.
pub fn file(name: &str, bytes: &[u8]) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

/// The name of a file or folder that is not there.
pub fn fresh(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    let _ = fs::remove_file(&path);
    path.to_str().unwrap().to_owned()
}

pub fn run(command: &str, arguments: &[&str]) -> Output {
    Command::new(crate::PROGRAM).arg(command).args(arguments).output().unwrap()
}

#[track_caller]
pub fn refused(command: &str, arguments: &[&str], says: &str) {
    let output = run(command, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    assert!(message.starts_with("error: ") && message.contains(says), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?} wrote {:?}", output.stdout);
}

#[track_caller]
pub fn lines(command: &str, arguments: &[&str]) -> Vec<serde_json::Value> {
    let output = run(command, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}
