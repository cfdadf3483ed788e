//! A block that cannot be measured has a verdict, and the blocks after it are measured: omitted blocks are counted at the end,
//! with exit code 1.

use crate::cli::{ANALYZE, file, fresh, refused, run, spec};
use std::f64::consts::TAU;

/// Thirty blocks of 1024 samples of a tone at 800 Hz; `level` is the amplitude at a block, of full scale.
fn recording(name: &str, bits: u16, level: impl Fn(usize) -> f64) -> String {
    let path = fresh(name);
    let mut writer = hound::WavWriter::create(&path, spec(1, bits)).unwrap();
    let full = f64::from(1u32 << (bits - 1));
    for n in 0..30 * 1024 {
        let tone = level(n / 1024) * (TAU * 0.1 * n as f64).sin();
        writer.write_sample((full * tone) as i32).unwrap();
    }
    writer.finalize().unwrap();
    path
}

/// Rows, exit code and stderr.
fn analyzed(arguments: &[&str]) -> (Vec<serde_json::Value>, Option<i32>, String) {
    let output = run(ANALYZE, arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    let rows = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    (rows, output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn quiet_blocks_do_not_end_a_recording() {
    // 24 bits: a hundred-thousandth of full scale is a third of a 16-bit code.
    let quiet = |block| if (10..20).contains(&block) { 1e-5 } else { 0.5 };
    let path = recording("quiet.wav", 24, quiet);
    let options = [&*path, "--n", "1024", "--arith", "target", "--json"];
    let (rows, code, message) = analyzed(&options);
    let (summary, rows) = rows.split_last().unwrap();
    assert_eq!((rows.len(), code), (30, Some(1)), "{message}");
    assert_eq!((&summary["blocks"], &summary["left_out"]), (&30.into(), &10.into()));
    assert!(message.contains("10 of 30 blocks left out: samples are too small"), "{message}");
    for (number, row) in rows.iter().enumerate() {
        let verdict = if (10..20).contains(&number) { "no-signal" } else { "good" };
        assert_eq!(row["verdict"], verdict, "{row}");
        assert_eq!(row["frequency_hz"].is_null(), verdict == "no-signal", "{row}");
    }
    let (rows, code, message) = analyzed(&[&path, "--n", "1024", "--most", "1", "--json"]);
    assert_eq!((rows.len(), code), (20, Some(1)), "{message}");
    assert_eq!(rows[19]["block"], 29);
    let (rows, code, message) = analyzed(&[&path, "--n", "1024", "--accumulate", "5", "--json"]);
    assert_eq!((rows.len(), code), (4, Some(1)), "{message}");
    // Silence between bursts is none.
    let (_, code, message) = analyzed(&[&path, "--n", "1024", "--burst", "--json"]);
    assert_eq!((code, &*message), (Some(0), ""));
    // Where all is quiet the cure is told.
    let silence = recording("silence.wav", 24, |_| 1e-5);
    let options = [&*silence, "--n", "1024", "--arith", "target", "--scale", "1"];
    refused(ANALYZE, &options, "too small for integers: add --scale CODES");
}

#[test]
fn codes_beyond_the_rails_do_not_end_a_recording() {
    let path = recording("beyond.wav", 16, |block| if block == 3 { 0.07 } else { 0.03 });
    let options = ["--n", "1024", "--bits", "12", "--arith", "target", "--json"];
    let (rows, code, message) = analyzed(&[&[&*path][..], &options].concat());
    let (summary, rows) = rows.split_last().unwrap();
    assert_eq!((rows.len(), code), (30, Some(1)), "{message}");
    assert_eq!(summary["left_out"], 1);
    assert!(message.contains("1 of 30 blocks left out: samples exceed -2048..2047"), "{message}");
    for (number, row) in rows.iter().enumerate() {
        assert_eq!(row["verdict"], if number == 3 { "wrong-codes" } else { "good" }, "{row}");
    }
    for more in [&["--most", "1"][..], &["--accumulate", "5"], &["--burst"], &["--harmonics", "2"]]
    {
        let options = [&[&*path, "--n", "1024", "--bits", "12", "--json"], more].concat();
        let (_, code, message) = analyzed(&options);
        assert_eq!(code, Some(1), "{more:?}: {message}");
        assert!(message.contains("blocks left out: samples exceed"), "{more:?}: {message}");
    }
}

#[test]
fn a_record_that_is_none_does_not_end_a_file() {
    let tone: Vec<f64> = (0..64).map(|n| 1000.0 * (TAU * 0.1 * f64::from(n)).sin()).collect();
    let long = "x".repeat(5_000_000);
    let good = |id: &str| format!(r#"{{"id":"{id}","kind":"r","re":{tone:?}}}"#);
    let short = format!(r#"{{"id":"{long}","kind":"r","re":[1,2,3]}}"#);
    let other = format!(r#"{{"id":"{long}","kind":"{long}","re":[1,2,3]}}"#);
    let text = [good("a"), "not a record".into(), short, other, good("b")].join("\n");
    let path = file("records-left-out.json", text.as_bytes());
    let (rows, code, message) = analyzed(&[&path, "--rate", "8000", "--json"]);
    assert_eq!((rows.len(), code), (3, Some(1)), "{message}");
    assert_eq!((&rows[0]["id"], &rows[1]["id"]), (&"a".into(), &"b".into()));
    assert_eq!(rows[2]["skipped"], 3);
    assert_eq!(message.lines().count(), 1, "{message}");
    // An identifier of megabytes stays in its file.
    for line in text.lines().skip(2).take(2) {
        let path = file("long-id.json", line.as_bytes());
        let output = run(ANALYZE, &[&path, "--rate", "8000", "--json"]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(message.len() < 400, "{} bytes", message.len());
    }
}

/// What has no number is a gap for every way to read a block.
#[test]
fn a_missing_sample_is_a_gap_for_all() {
    let sample = |n: usize| (1000.0 * (TAU * 0.1 * n as f64).sin()).round();
    let text: String = (0..8 * 256)
        .map(|n| if n == 700 { "nan\n".into() } else { format!("{}\n", sample(n)) })
        .collect();
    let path = file("missing.csv", text.as_bytes());
    let of = |more: &[&str]| {
        let options = [&[&*path, "--rate", "8000", "--n", "256", "--json"], more].concat();
        analyzed(&options)
    };
    for more in [&[][..], &["--most", "1"], &["--track"]] {
        let (rows, _, message) = of(more);
        let row = rows.iter().find(|row| row["block"] == 2).unwrap();
        assert_eq!(row["verdict"], "gap", "{more:?}: {message}");
    }
    // Seven blocks are whole.
    let (rows, ..) = of(&["--accumulate", "7"]);
    assert_eq!(rows.len(), 1);
}
