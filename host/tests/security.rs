//! SECURITY.md names where the library's `unsafe` is.

use crate::sources::{ROOT, files};
use std::fs;

const PAGE: &str = include_str!("../../SECURITY.md");

/// Whether code, not a comment or a lint's name, says it.
fn is_unsafe(text: &str) -> bool {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .any(|word| word == "unsafe")
}

#[test]
fn every_place_with_unsafe_is_named() {
    let mut named: Vec<&str> =
        PAGE.split('`').skip(1).step_by(2).filter(|name| name.starts_with("src/")).collect();
    let all = files("src");
    assert!(all.len() > 50 && named.len() > 4, "{named:?}");
    let mut used = Vec::new();
    for path in all {
        let text = fs::read_to_string(&path).unwrap();
        if !is_unsafe(&text) {
            continue;
        }
        let path = path.strip_prefix(ROOT).unwrap();
        let place = named.iter().find(|place| path.starts_with(place));
        used.push(*place.unwrap_or_else(|| panic!("SECURITY.md does not name {}", path.display())));
    }
    named.retain(|place| !used.contains(place));
    assert!(named.is_empty(), "nothing is unsafe any more in {named:?}");
}
