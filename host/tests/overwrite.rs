//! No command replaces a file unasked, or writes what it reads, or leaves half of a file.

use crate::cli::{file, fresh, spec, wav};
use crate::device::session;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const PICKET: &str = env!("CARGO_BIN_EXE_picket");

fn picket(arguments: &[&str]) -> Output {
    Command::new(PICKET).args(arguments).output().unwrap()
}

#[track_caller]
fn refused(arguments: &[&str], says: &str) {
    let output = picket(arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
    assert!(message.contains(says), "{arguments:?}: {message}");
}

#[test]
fn a_file_that_exists_is_kept() {
    let tone = wav("kept-tone.wav", spec(1, 16), 40 * 1024);
    let recording = file("kept-session.bin", &session());
    let [svg, bin] = ["kept.svg", "kept.bin"].map(|name| file(name, b"older"));
    let exists = "exists: name another file, or replace it by --force";
    let commands: [&[&str]; 13] = [
        &["analyze", &tone, "--plot", &svg],
        &["analyze", &tone, "--track", "--plot", &svg],
        &["explain", &tone, "--block", "0", "--plot", &svg],
        &["demo", "--scenario", "vibration", "--plot", &svg],
        &["demo", "--scenario", "drive", "--plot", &svg],
        &["demo", "--scenario", "traffic", "--plot", &svg],
        &["demo", "--scenario", "board", "--record", &bin],
        &["watch", "--replay", &recording, "--record", &bin],
        &["demo", "--plot", &svg],
        &["demo", "--scenario", "turntable", "--plot", &svg],
        &["demo", "--scenario", "ldv", "--plot", &svg],
        &["demo", "--scenario", "wind", "--plot", &svg],
        &["demo", "--scenario", "fan", "--plot", &svg],
    ];
    for command in commands {
        refused(command, exists);
    }
    // It is refused before a port is opened.
    refused(&["watch", "/nowhere/port", "--capture", "1", "--capture-to", &bin], exists);
    assert_eq!(
        (fs::read(&svg).unwrap(), fs::read(&bin).unwrap()),
        (b"older".into(), b"older".into())
    );
    for command in [commands[0], commands[1], commands[2], commands[6], commands[7]] {
        let to = command.last().unwrap();
        fs::write(to, "older").unwrap();
        let output = picket(&[command, &["--force"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(fs::read(to).unwrap().len() > 500, "{command:?}");
    }
    assert_eq!(fs::read(&bin).unwrap(), session());
}

#[test]
fn what_is_read_is_never_written() {
    let recording = file("both.bin", &session());
    let link = fresh("both-link.bin");
    std::os::unix::fs::symlink(&recording, &link).unwrap();
    for to in [&recording, &link] {
        refused(
            &["watch", "--replay", &recording, "--record", to, "--force"],
            "is what is read: name another file to write",
        );
    }
    let stdin = Command::new(PICKET)
        .args(["watch", "-", "--force", "--record", &recording])
        .stdin(fs::File::open(&recording).unwrap())
        .output()
        .unwrap();
    assert_eq!(stdin.status.code(), Some(2), "{}", String::from_utf8_lossy(&stdin.stderr));
    assert_eq!(fs::read(&recording).unwrap(), session());
    let both = fresh("both-new.bin");
    let two = ["--record", &both, "--capture", "1", "--capture-to", &both];
    refused(&[&["watch", "/nowhere/port"][..], &two].concat(), "are one file: name two");
    let text = "0\n1\n2\n1\n".repeat(1024);
    let samples = file("samples.svg", text.as_bytes());
    let plot = ["--format", "csv", "--rate", "9", "--force", "--plot", &samples];
    refused(&[&["analyze", &samples][..], &plot].concat(), "is what is read");
    assert_eq!(fs::read(&samples).unwrap(), text.as_bytes());
}

/// A disk that takes no byte: there is no file then, and not an empty one.
#[test]
fn a_full_disk_leaves_no_half_of_a_picture() {
    let tone = wav("full-tone.wav", spec(1, 16), 8192);
    for name in ["full.svg", "full.png"] {
        let folder = fresh("full");
        fs::create_dir(&folder).unwrap();
        let picture = Path::new(&folder).join(name);
        let output = Command::new("sh")
            .args(["-c", r#"trap "" XFSZ; ulimit -f 0; exec "$@""#, "sh", PICKET, "analyze", &tone])
            .arg("--plot")
            .arg(&picture)
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && message.contains(name), "{message}");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "{name}");
        fs::remove_dir(&folder).unwrap();
    }
}

/// Each run of the doctor has a report of its own.
#[test]
fn reports_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let doctor = |more: &[&str]| {
        let output = Command::new(PICKET)
            .args(["doctor", "/nowhere/port"])
            .args(more)
            .current_dir(&folder)
            .output()
            .unwrap();
        output.status.code()
    };
    let there = || fs::read_dir(&folder).unwrap().count();
    // No board holds a check, and the report says so.
    assert_eq!((doctor(&[]), there()), (Some(1), 2));
    let first = fs::read(folder.path().join("picket-doctor.json")).unwrap();
    assert_eq!((doctor(&[]), there()), (Some(1), 4));
    assert_eq!(fs::read(folder.path().join("picket-doctor.json")).unwrap(), first);
    assert!(folder.path().join("picket-doctor-2.txt").exists());
    assert_eq!((doctor(&["--force"]), there()), (Some(1), 4));
    assert_eq!((doctor(&["--report", "picket-doctor-2.json"]), there()), (Some(2), 4));
}
