//! `claims.json`: what each test claims, and what was seen. `lab docs` writes docs/claims.md from it.
//!
//! The cases of a test that ask the same of one claim are a row: a claim is a label up to its colon, with an x for each number. A run holds the rows to be in the file;
//! what was seen is written, and never compared.

use crate::limit::{Asked, Judged};
use crate::table;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// A row.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// What is claimed.
    pub claim: String,
    /// What is asked of it.
    pub asked: String,
    /// Cases.
    pub cases: usize,
    /// Answers or trials.
    pub of: u64,
    /// Of a share how many; of other values the least and the largest.
    pub seen: Vec<f64>,
}

/// The rows of the tests that have run.
static RUN: Mutex<BTreeMap<String, Vec<Row>>> = Mutex::new(BTreeMap::new());

fn path() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../claims.json")
}

fn read() -> BTreeMap<String, Vec<Row>> {
    serde_json::from_str(&fs::read_to_string(path()).unwrap()).unwrap()
}

/// The claim of a label.
fn claim(label: &str) -> String {
    let is_of_number = |c: char| c.is_ascii_digit() || c == '.';
    let mut last = ' ';
    let shown = |c: char| {
        let goes_on = is_of_number(last) && is_of_number(c);
        last = c;
        (!goes_on).then_some(if is_of_number(c) { 'x' } else { c })
    };
    label.split(['|', ':']).next().unwrap_or(label).chars().filter_map(shown).collect()
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Adds what was seen of a case to a test's rows.
fn add(rows: &mut Vec<Row>, label: &str, asked: &Asked, judged: &Judged) {
    let claim = claim(label);
    let asked_of = asked.to_string();
    let is_it = |row: &&mut Row| row.claim == claim && row.asked == asked_of;
    let (share, value) = (matches!(asked, Asked::Share { .. }), three_digits(judged.value));
    let hits = (judged.value * judged.of as f64).round();
    match rows.iter_mut().find(is_it) {
        Some(row) => {
            row.cases += 1;
            row.of += judged.of;
            match row.seen.as_mut_slice() {
                [seen] => *seen += hits,
                [least, most] => (*least, *most) = (least.min(value), most.max(value)),
                _ => {}
            }
        }
        None => rows.push(Row {
            claim,
            asked: asked_of,
            cases: 1,
            of: judged.of,
            seen: if share { vec![hits] } else { vec![value; 2] },
        }),
    }
}

/// Panics unless the file has these rows of the test that runs. With `PICKET_WRITE_FIGURES` it writes them.
pub(crate) fn hold(seen: &[table::Row]) {
    // The harness names its threads as their tests.
    let thread = std::thread::current();
    let Some(test) = thread.name().filter(|name| name.contains("::")) else { return };
    let mut run = RUN.lock().unwrap_or_else(PoisonError::into_inner);
    let rows = run.entry(test.to_owned()).or_default();
    for (label, of) in seen {
        for (asked, judged) in of.iter().filter(|(asked, _)| asked.is_limited()) {
            add(rows, label, asked, judged);
        }
    }
    if std::env::var_os("PICKET_WRITE_FIGURES").is_some() {
        // Other processes may write, too.
        let file = File::open(path()).unwrap();
        file.lock().unwrap();
        let mut all = read();
        all.insert(test.to_owned(), rows.clone());
        let of_test = |(test, rows): (&String, &Vec<Row>)| {
            let rows: Vec<String> =
                rows.iter().map(|row| serde_json::to_string(row).unwrap()).collect();
            format!("  \"{test}\": [\n    {}\n  ]", rows.join(",\n    "))
        };
        let tests: Vec<String> =
            all.iter().filter(|(_, rows)| !rows.is_empty()).map(of_test).collect();
        return fs::write(path(), format!("{{\n{}\n}}\n", tests.join(",\n"))).unwrap();
    }
    let all = read();
    let stated = all.get(test).map_or(&[][..], Vec::as_slice);
    for row in rows.iter() {
        let is_it = |stated: &Row| {
            stated.claim == row.claim && stated.asked == row.asked && stated.cases >= row.cases
        };
        assert!(
            stated.iter().any(is_it),
            "{}, {}: not in host-tests/claims.json with {} cases: with PICKET_WRITE_FIGURES=1 PICKET_LONG=1 this test writes it, then `lab docs`",
            row.claim,
            row.asked,
            row.cases
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_has_no_numbers() {
        assert_eq!(
            claim("a swing of 0.5 bins in 60 blocks: real 1024|, 20 dB"),
            "a swing of x bins in x blocks"
        );
    }

    /// A test that is gone or has another name would leave its rows behind.
    #[test]
    fn every_row_is_of_a_test() {
        for test in read().keys() {
            let (file, name) = test.split_once("::").unwrap();
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/{file}.rs"));
            let text = fs::read_to_string(&path).unwrap();
            assert!(text.contains(&format!("fn {name}() {{")), "{test}");
        }
    }
}
