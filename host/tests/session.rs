//! The recording that docs/board.md replays is what its command makes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

#[test]
fn the_recording_is_what_its_command_makes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let made = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("made.bin");
    let output = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["demo", "--scenario", "board", "--record"])
        .arg(&made)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        fs::read(&made).unwrap() == fs::read(root.join("docs/session.bin")).unwrap(),
        "docs/session.bin is of another version: cargo picket demo --scenario board --record docs/session.bin"
    );
}
