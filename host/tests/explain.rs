//! `picket explain FILE --block K`: it tells the verdict of `picket analyze`, and names the test that led to it.

use crate::cli::{ANALYZE, file, fresh, lines, recorded, refused, run};
use picket_simulator::Scene;
use serde_json::Value;
use std::fs;

const EXPLAIN: &str = "explain";
const N: usize = 1024;
const BLOCKS: usize = 3;

/// A recording, its verdict, and the tests that must have fired.
struct Case {
    name: &'static str,
    iq: bool,
    /// Sources and receiver; a bin is 46.875 Hz.
    scene: &'static str,
    verdict: &'static str,
    fired: &'static [&'static str],
    effort: &'static str,
}

const CASES: [Case; 6] = [
    Case {
        name: "good",
        iq: false,
        scene: r#""sources": [{"tone": {"frequency_hz": 4701.5, "amplitude": 9000}}], "receiver": {"noise": {"rms": 90}}"#,
        verdict: "good",
        fired: &[],
        effort: "3",
    },
    Case {
        // Its frequency rises by a bin in every block.
        name: "moving",
        iq: false,
        scene: r#""sources": [{"tone": {"frequency_hz": 4701.5, "amplitude": 9000, "changes": [{"chirp": {"hz_per_s": 2197}}]}}],
            "receiver": {"noise": {"rms": 90}}"#,
        verdict: "moving",
        fired: &["line", "steady"],
        effort: "3",
    },
    Case {
        name: "two",
        iq: false,
        scene: r#""sources": [{"tone": {"frequency_hz": 4701.5, "amplitude": 9000}}, {"tone": {"frequency_hz": 4785.9, "amplitude": 6000}}],
            "receiver": {"noise": {"rms": 90}}"#,
        verdict: "unresolved",
        fired: &["unexplained-8", "share", "alone"],
        effort: "0",
    },
    Case {
        name: "image",
        iq: true,
        scene: r#""sources": [{"tone": {"frequency_hz": 4701.5, "amplitude": 9000}}],
            "receiver": {"iq": true, "dead": 1, "noise": {"rms": 90}}"#,
        verdict: "image",
        fired: &["image-share", "image-noise", "image"],
        effort: "3",
    },
    Case {
        name: "clipped",
        iq: false,
        scene: r#""sources": [{"tone": {"frequency_hz": 4701.5, "amplitude": 34000}}], "receiver": {"noise": {"rms": 90}}"#,
        verdict: "clipped",
        fired: &["clipped"],
        effort: "3",
    },
    Case {
        name: "noise",
        iq: false,
        scene: r#""receiver": {"noise": {"rms": 900}}"#,
        verdict: "weak",
        fired: &["floor", "detection"],
        effort: "3",
    },
];

/// The case's recording, in a file of this test's own.
fn recording(case: &Case, test: &str) -> String {
    let json = format!(r#"{{"rate_hz": 48000, "seconds": 0.064, {}}}"#, case.scene);
    recorded(&format!("explain-{test}-{}.wav", case.name), &Scene::from_json(&json).unwrap())
}

fn strings<'a>(value: &'a Value, key: &str) -> Vec<&'a str> {
    let list = value[key].as_array().into_iter().flatten();
    list.map(|item| item.as_str().unwrap()).collect()
}

#[test]
fn the_verdict_is_that_of_the_analysis_and_the_test_behind_it_is_named() {
    for case in &CASES {
        let path = recording(case, "verdict");
        for arithmetic in ["target", "target-fixed"] {
            let kind: &[&str] = if case.iq { &["--iq"] } else { &[] };
            let effort = ["--effort", case.effort];
            let common =
                [&[&*path, "--arith", arithmetic, "--json", "--n", "1024"], &effort[..], kind]
                    .concat();
            let answers = lines(ANALYZE, &common);
            // The last line is the summary.
            assert_eq!(answers.len(), BLOCKS + 1);
            for (block, answer) in answers.iter().take(BLOCKS).enumerate() {
                let number = block.to_string();
                let told = lines(EXPLAIN, &[&common[..], &["--block", &number]].concat());
                let [told] = &told[..] else { panic!("{told:?}") };
                let what = format!("{} by {arithmetic}, block {block}: {told}", case.name);
                // Every number of the answer, to the bit.
                for (key, value) in answer.as_object().unwrap() {
                    assert_eq!(&told[key], value, "{key} of {what}");
                }
                assert_eq!(told["verdict"], case.verdict, "{what}");
                let tests = told["tests"].as_array().unwrap();
                let fired: Vec<&Value> =
                    tests.iter().filter(|test| test["fired"] == true).collect();
                for wanted in case.fired {
                    assert!(fired.iter().any(|test| test["test"] == *wanted), "{wanted} in {what}");
                }
                if case.fired.is_empty() {
                    assert!(fired.is_empty(), "{what}");
                }
                // The rules that fired are the verdict and what applies besides.
                let names: Vec<&str> =
                    fired.iter().map(|test| test["followed"].as_str().unwrap()).collect();
                assert!(names.contains(&case.verdict) || case.verdict == "good", "{what}");
                for also in strings(told, "also") {
                    assert!(names.contains(&also), "{also} in {what}");
                }
                // A test beside its limit says what it did.
                for test in tests {
                    assert!(!test["about"].as_str().unwrap().is_empty(), "{test}");
                    assert!(!test["followed"].as_str().unwrap().is_empty(), "{test}");
                }
            }
        }
    }
}

#[test]
fn people_read_a_table_and_see_a_picture() {
    let path = recording(&CASES[1], "picture");
    let picture = fresh("explained.svg");
    let output = run(EXPLAIN, &[&path, "--block", "1", "--plot", &picture]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        text.starts_with("block 1: ") && text.contains("moving: The tone's frequency"),
        "{text}"
    );
    assert!(text.contains("consequence") && text.contains("joined in round 1"), "{text}");
    let picture = fs::read_to_string(picture).unwrap();
    for series in ["the fitted tone", "what the fit leaves", "noise beside the tone"] {
        assert!(picture.contains(series), "{series}");
    }
}

#[test]
fn what_cannot_be_explained_is_told_in_a_line() {
    let path = recording(&CASES[0], "refused");
    refused(EXPLAIN, &[&path, "--block", "3"], "3 blocks: give --block 0 to 2");
    refused(EXPLAIN, &[&path], "--block");
    refused(EXPLAIN, &["no-such-file.wav", "--block", "0"], "no-such-file.wav");
    refused(EXPLAIN, &[&path, "--block", "0", "--plot", "x.gif"], "name the picture .svg or .png");
    let silence = file("explain-silence.i16", &[0; 4 * N]);
    let headless = [&*silence, "--rate", "48e3", "--block", "0"];
    let output = run(EXPLAIN, &headless);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("no-signal"), "{text}");
    refused(EXPLAIN, &[&headless[..], &["--plot", "x.svg"]].concat(), "nothing was fitted");
}
