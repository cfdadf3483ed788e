//! `picket explain FILE --block K`: it tells the verdict of `picket analyze`, and names the test that led to it.

use crate::cli::{ANALYZE, file, fresh, lines, refused, run};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;

const EXPLAIN: &str = "explain";
const N: usize = 1024;
const BLOCKS: usize = 3;
const RATE_HZ: u32 = 48_000;
const SEED: u64 = 39;

/// A recording, its verdict, and the tests that must have fired.
struct Case {
    name: &'static str,
    iq: bool,
    /// I and Q of the sample at this time in blocks, in codes.
    clean: fn(f64) -> [f64; 2],
    /// The noise of each part, in codes.
    noise: f64,
    verdict: &'static str,
    fired: &'static [&'static str],
}

/// A tone's parts at this many cycles.
fn turned(amplitude: f64, cycles: f64) -> [f64; 2] {
    let (sin, cos) = (TAU * cycles).sin_cos();
    [amplitude * cos, amplitude * sin]
}

const CASES: [Case; 6] = [
    Case {
        name: "good",
        iq: false,
        clean: |t| turned(9000.0, 100.3 * t),
        noise: 90.0,
        verdict: "good",
        fired: &[],
    },
    Case {
        // Its frequency rises by a bin in every block.
        name: "moving",
        iq: false,
        clean: |t| turned(9000.0, 100.3 * t + 0.5 * t.fract() * t.fract()),
        noise: 90.0,
        verdict: "moving",
        fired: &["moves", "steady"],
    },
    Case {
        name: "two",
        iq: false,
        clean: |t| {
            let [a, b] = [turned(9000.0, 100.3 * t), turned(6000.0, 102.1 * t + 0.2)];
            [a[0] + b[0], 0.0]
        },
        noise: 90.0,
        verdict: "unresolved",
        fired: &["unexplained-8", "share", "alone"],
    },
    Case {
        // Q is dead.
        name: "image",
        iq: true,
        clean: |t| [turned(9000.0, 100.3 * t)[0], 0.0],
        noise: 90.0,
        verdict: "image",
        fired: &["image-share", "image-noise", "image"],
    },
    Case {
        name: "clipped",
        iq: false,
        clean: |t| turned(34_000.0, 100.3 * t),
        noise: 90.0,
        verdict: "clipped",
        fired: &["clipped"],
    },
    Case {
        name: "noise",
        iq: false,
        clean: |_| [0.0; 2],
        noise: 900.0,
        verdict: "weak",
        fired: &["floor", "detection"],
    },
];

/// The case's recording, in a file of this test's own.
fn recording(case: &Case, test: &str) -> String {
    let spec = hound::WavSpec {
        channels: if case.iq { 2 } else { 1 },
        sample_rate: RATE_HZ,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let path = file(&format!("explain-{test}-{}.wav", case.name), &[]);
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for n in 0..BLOCKS * N {
        let parts = (case.clean)(n as f64 / N as f64);
        for clean in parts.into_iter().take(spec.channels.into()) {
            let normal: f64 = StandardNormal.sample(&mut rng);
            // A cast saturates, as a converter does.
            writer.write_sample((clean + case.noise * normal).round() as i16).unwrap();
        }
    }
    writer.finalize().unwrap();
    path
}

fn strings<'a>(value: &'a Value, key: &str) -> Vec<&'a str> {
    let list = value[key].as_array().into_iter().flatten();
    list.map(|item| item.as_str().unwrap()).collect()
}

#[test]
fn the_verdict_is_that_of_the_analysis_and_the_test_behind_it_is_named() {
    println!("seed {SEED}");
    for case in &CASES {
        let path = recording(case, "verdict");
        for arithmetic in ["target", "target-fixed"] {
            let kind: &[&str] = if case.iq { &["--iq"] } else { &[] };
            let common = [&[&*path, "--arith", arithmetic, "--json", "--n", "1024"], kind].concat();
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
    assert!(
        text.contains("what followed") && text.contains("it changes within the block"),
        "{text}"
    );
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
