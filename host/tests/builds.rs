//! What a person sees of a build.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// A build that another one holds up says so: that one may take minutes.
#[test]
fn a_build_that_waits_says_so() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("builds");
    // Whichever way leads to WebAssembly here.
    let locks: Vec<File> = ["installed", "source"]
        .map(|way| {
            let place = folder.join("web/build").join(way);
            fs::create_dir_all(&place).unwrap();
            File::create(place.join("build.lock")).unwrap()
        })
        .into();
    locks.iter().for_each(|lock| lock.lock().unwrap());
    let mut child = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["web", "--build"])
        .env("CARGO_TARGET_DIR", &folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    // It ends by itself only if a tool is missing, and says which.
    let mut seen = Vec::new();
    for line in lines {
        seen.push(line);
        if seen.last().is_some_and(|line| line.contains("waiting for another picket")) {
            child.kill().unwrap();
        }
    }
    child.wait().unwrap();
    let waits = seen.iter().filter(|line| line.contains("waiting for another picket"));
    assert_eq!(waits.count(), 1, "{seen:?}");
}
