//! No command replaces a file unasked.

use crate::program::{file, fresh, refused};
use std::fs;
use std::path::Path;

#[test]
fn a_file_that_exists_is_kept() {
    let folder = fresh("kept-report");
    fs::create_dir(&folder).unwrap();
    let kept = Path::new(&folder).join("report.html");
    fs::write(&kept, "older").unwrap();
    let svg = file("kept.svg", b"older");
    refused("bench", &["--plot", &svg], "exists: name another file, or replace it by --force");
    refused("report", &["--quick", "--out", &folder], "is not empty: name another folder");
    assert_eq!(
        (fs::read(&svg).unwrap(), fs::read(&kept).unwrap()),
        (b"older".into(), b"older".into())
    );
}
