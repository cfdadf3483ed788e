//! The recording that docs/board.md replays is what its command makes.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/session.bin");

#[test]
fn the_recording_is_what_its_command_makes() {
    let made = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("made.bin");
    let output = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["demo", "--scenario", "board", "--record"])
        .arg(&made)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        fs::read(&made).unwrap() == fs::read(FILE).unwrap(),
        "docs/session.bin is of another version: cargo picket demo --scenario board --record docs/session.bin"
    );
}

/// `--live` needs a terminal: into a pipe there are lines.
#[test]
fn live_into_a_pipe_is_lines() {
    let watch = |flags: &[&str]| {
        let arguments = ["watch", "--replay", FILE].iter().chain(flags);
        Command::new(env!("CARGO_BIN_EXE_picket")).args(arguments).output().unwrap()
    };
    let (live, lines) = (watch(&["--live"]), watch(&[]));
    assert!(live.status.success() && live.stdout == lines.stdout, "{live:?}");
}
