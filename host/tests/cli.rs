//! Bad input through the real programs: one line on stderr that says what to do, exit code 2, nothing on stdout.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

const ANALYZE: &str = "analyze";
const SWEEP: &str = "sweep";

/// A file of this test's own.
fn file(name: &str, bytes: &[u8]) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

fn wav(name: &str, spec: hound::WavSpec, frames: usize) -> String {
    let path = file(name, &[]);
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for index in 0..frames * usize::from(spec.channels) {
        let x = (std::f64::consts::TAU * 0.1 * (index / usize::from(spec.channels)) as f64).cos();
        match spec.sample_format {
            hound::SampleFormat::Float => writer.write_sample((0.5 * x) as f32).unwrap(),
            hound::SampleFormat::Int => {
                let full = f64::from(1u32 << (spec.bits_per_sample - 1));
                writer.write_sample((0.5 * full * x) as i32).unwrap();
            }
        }
    }
    writer.finalize().unwrap();
    path
}

fn spec(channels: u16, bits: u16) -> hound::WavSpec {
    let sample_format =
        if bits == 33 { hound::SampleFormat::Float } else { hound::SampleFormat::Int };
    hound::WavSpec { channels, sample_rate: 8000, bits_per_sample: bits.min(32), sample_format }
}

fn run(command: &str, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_picket")).arg(command).args(arguments).output().unwrap()
}

#[track_caller]
fn refused(command: &str, arguments: &[&str], says: &str) {
    let output = run(command, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    assert!(message.starts_with("error: ") && message.contains(says), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?} wrote {:?}", output.stdout);
}

#[track_caller]
fn lines(command: &str, arguments: &[&str]) -> Vec<serde_json::Value> {
    let output = run(command, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn tracks_are_drawn_over_the_spectrogram() {
    let tone = wav("followed.wav", spec(1, 16), 40 * 1024);
    for name in ["tracks.svg", "tracks.png"] {
        let picture = file(name, &[]);
        let rows = lines(ANALYZE, &[&tone, "--track", "--json", "--plot", &picture]);
        assert_eq!(rows.last().unwrap()["summary"], true);
        let bytes = fs::read(&picture).unwrap();
        if name.ends_with("png") {
            assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 10_000);
            continue;
        }
        let text = String::from_utf8(bytes).unwrap();
        // The line's values are in the metadata, the spectrogram's cells behind it.
        assert!(text.contains("track 0: ") && text.contains("[0.192,"), "{}", &text[..400]);
        let frequency = rows[0]["frequency_hz"].as_f64().unwrap();
        assert!((frequency - 800.0).abs() < 0.01, "{frequency}");
        let cells = text.matches("<rect").count();
        assert!((40..4000).contains(&cells), "{cells}");
    }
    refused(ANALYZE, &[&tone, "--track", "--plot", "tracks.gif"], "name the picture .svg or .png");
    refused(ANALYZE, &[&tone, "--n", "64", "--plot", "tracks.svg"], "--track");
}

#[test]
fn files_that_cannot_be_read() {
    let none = file("none.bin", &[]);
    let odd = file("odd.bin", &[1, 2, 3]);
    let short = file("short.bin", &[1, 0, 2, 0]);
    let nameless = file("nameless", &[1, 0]);
    refused(ANALYZE, &["no-such-file.wav"], "no such file");
    refused(ANALYZE, &[&none, "--rate", "1000"], "holds no samples");
    refused(ANALYZE, &[&odd, "--rate", "1000"], "3 bytes");
    refused(ANALYZE, &[&short, "--rate", "1000"], "fewer than one record of 64");
    refused(ANALYZE, &[&short, "--rate", "1000", "--json"], "fewer than one record of 1024");
    refused(ANALYZE, &[&short, "--rate", "1000", "--iq", "--skip", "5", "--n", "16"], "fewer");
    refused(ANALYZE, &[&short], "--rate HZ");
    refused(ANALYZE, &[&short, "--rate", "0"], "positive");
    refused(ANALYZE, &[&short, "--rate", "-5"], "positive");
    refused(ANALYZE, &[&short, "--rate", "nan"], "positive");
    refused(ANALYZE, &[&nameless, "--rate", "1000"], "--format");
    refused(ANALYZE, &[env!("CARGO_TARGET_TMPDIR"), "--format", "i16", "--rate", "8"], "directory");
}

#[test]
fn wav_files_that_cannot_be_read() {
    let whole = wav("whole.wav", spec(1, 16), 2000);
    let bytes = fs::read(&whole).unwrap();
    let cut = file("cut.wav", &bytes[..bytes.len() / 2]);
    let head = file("head.wav", &bytes[..20]);
    let text = file("text.wav", b"this is no wav file, it is text, and long enough for a header");
    refused(ANALYZE, &[&cut], "truncated wav");
    refused(ANALYZE, &[&head], "not a readable wav");
    refused(ANALYZE, &[&text], "not a readable wav");
    refused(ANALYZE, &[&whole, "--n", "4096"], "2000 samples are fewer");
    refused(ANALYZE, &[&whole, "--iq"], "needs two channels, the file has 1");
    refused(ANALYZE, &[&wav("stereo.wav", spec(2, 16), 2000)], "add --iq");
    refused(ANALYZE, &[&wav("six.wav", spec(6, 16), 2000)], "6 channels");
    refused(ANALYZE, &[&wav("empty.wav", spec(1, 16), 0)], "holds no samples");
}

#[test]
fn text_files_that_cannot_be_read() {
    let csv = |name, text: &str| file(name, text.as_bytes());
    let rate = ["--rate", "1000", "--n", "16"];
    let with = |path: &str, says| {
        let arguments: Vec<&str> = [path].into_iter().chain(rate).collect();
        refused(ANALYZE, &arguments, says);
    };
    with(&csv("nan.csv", "a\n1\n2\nNaN\n4\n"), "line 4: NaN is not a sample");
    with(&csv("inf.csv", "1,2\n-inf,2\n"), "line 2: -inf is not a sample");
    with(&csv("word.csv", "1\n2\nthree\n"), "line 3: \"three\" is not a number");
    with(&csv("ragged.csv", "1,2\n3\n"), "line 2: 1 columns where the first line has 2");
    with(&csv("three.csv", "1,2,3\n"), "3 channels");
    with(&csv("header.csv", "i,q\n"), "holds no samples");
    with(&csv("empty.csv", ""), "holds no samples");
    let json = |name, text: &str| csv(name, text);
    with(&json("kind.jsonl", r#"{"id": 1, "kind": "x", "re": [1]}"#), "line 1: kind \"x\"");
    with(&json("not.jsonl", "{]"), "line 1: not a record");
    with(
        &json("uneven.jsonl", r#"{"kind": "c", "re": [1, 2], "im": [1]}"#),
        "2 values of re but 1",
    );
    with(&json("few.jsonl", r#"{"kind": "r", "re": [1, 2]}"#), "2 samples are fewer than 16");
}

#[test]
fn options_that_do_not_fit() {
    let good = wav("good.wav", spec(1, 16), 4096);
    refused(ANALYZE, &[&good, "--method", "fesa"], "fesa works on I/Q records only");
    refused(ANALYZE, &[&good, "--method", "fase"], "no method \"fase\"");
    refused(ANALYZE, &[&good, "--band", "5000:6000"], "band");
    refused(ANALYZE, &[&good, "--band", "300"], "LO:HI");
    refused(ANALYZE, &[&good, "--band", "100:200", "--method", "ml"], "leave --band out");
    refused(ANALYZE, &[&good, "--n", "1000", "--arith", "target"], "N = 1000");
    refused(ANALYZE, &[&good, "--n", "3"], "N = 3");
    refused(ANALYZE, &[&good, "--n", "0"], "at least 1");
    refused(ANALYZE, &[&good, "--k", "5"], "choose 4, 8 or 16");
    refused(ANALYZE, &[&good, "--method", "ml", "--arith", "f32"], "needs --arith f64");
    let fixed = [&good, "--arith", "target-fixed", "--method", "candan"];
    refused(ANALYZE, &fixed, "use least squares, rife or z-rife");
    refused(ANALYZE, &[&good, "--arith", "target", "--bits", "12"], "exceed");
    refused(ANALYZE, &[&good, "--wrong"], "--wrong");
    refused(ANALYZE, &[], "required");
    refused(SWEEP, &["--method", "least-squares"], "least-squares works on I/Q records only");
    refused(SWEEP, &["--snr-db", "loud"], "loud");
    refused(SWEEP, &["--n", "1000", "--arith", "target"], "N = 1000");
    refused(SWEEP, &["--trials", "0"], "at least 1");
    refused(SWEEP, &["--bits", "13"], "13");
    refused(SWEEP, &["--bin", "600"], "--bin 600");
}

/// The same tone, 0.1 of the rate, in every format: the same answer and the same scale.
#[test]
fn every_format_is_read() {
    for (name, bits, floor_db) in [
        ("8.wav", 8, 30.0),
        ("16.wav", 16, 70.0),
        ("24.wav", 24, 70.0),
        ("32.wav", 32, 70.0),
        ("float.wav", 33, 70.0),
    ] {
        let path = wav(name, spec(1, bits), 1500);
        for arithmetic in ["f64", "f32", "target", "target-fixed"] {
            let found = lines(ANALYZE, &[&path, "--arith", arithmetic, "--json"]);
            assert_eq!(found.len(), 2, "{name}");
            let frequency = found[0]["frequency_hz"].as_f64().unwrap();
            assert!((frequency - 800.0).abs() < 0.05, "{name} {arithmetic}: {frequency}");
            let snr_db = found[0]["snr_db"].as_f64().unwrap();
            // The target's own noise ends it at 95 dB.
            let floor_db = if arithmetic == "f64" { floor_db } else { f64::min(floor_db, 70.0) };
            assert!(snr_db > floor_db, "{name} {arithmetic}: {:?}", found[0]);
            assert_eq!(found[0]["verdict"], "good", "{name} {arithmetic}");
            assert_eq!(found[1]["summary"], true);
        }
    }
}

/// Eight bits: half of full scale is 64 codes, whose rounding leaves 44 dB. A tone beyond their rails clips.
#[test]
fn eight_bits() {
    let of = |name: &str, amplitude: f64| {
        let path = file(name, &[]);
        let mut writer = hound::WavWriter::create(&path, spec(1, 8)).unwrap();
        for index in 0..4096 {
            let x = amplitude * (std::f64::consts::TAU * 0.123_456 * f64::from(index)).cos();
            writer.write_sample(x.round().clamp(-128.0, 127.0) as i32).unwrap();
        }
        writer.finalize().unwrap();
        path
    };
    let (half, over) = (of("half.wav", 64.0), of("over.wav", 150.0));
    for arithmetic in ["f64", "f32", "target", "target-fixed"] {
        for line in &lines(ANALYZE, &[&half, "--arith", arithmetic, "--json"])[..4] {
            let number = |key: &str| line[key].as_f64().unwrap();
            assert!((number("snr_db") - 43.9).abs() < 1.5, "{arithmetic}: {line}");
            let error = number("frequency_hz") - 8000.0 * 0.123_456;
            assert!(error.abs() < 4.0 * number("sigma_hz"), "{arithmetic}: {line}");
            assert_eq!(line["verdict"], "good", "{arithmetic}");
        }
        for line in &lines(ANALYZE, &[&over, "--arith", arithmetic, "--json"])[..4] {
            assert_ne!(line["verdict"], "good", "{arithmetic}: {line}");
            let error = line["frequency_hz"].as_f64().unwrap() - 8000.0 * 0.123_456;
            assert!(error.abs() < 2.0 * line["sigma_hz"].as_f64().unwrap(), "{arithmetic}: {line}");
        }
    }
}

#[test]
fn iq_is_signed() {
    let tone = |n: usize| {
        let (sin, cos) = (-std::f64::consts::TAU * 0.2 * n as f64).sin_cos();
        [cos, sin].map(|x| (1000.0 * x).round())
    };
    let text: String = (0..256).map(tone).map(|[i, q]| format!("{i},{q}\n")).collect();
    let csv = file("backwards.csv", ("I,Q\n".to_owned() + &text).as_bytes());
    let found = lines(ANALYZE, &[&csv, "--rate", "1000", "--n", "256", "--json"]);
    assert!((found[0]["frequency_hz"].as_f64().unwrap() + 200.0).abs() < 1e-3, "{:?}", found[0]);
    assert!((found[0]["bins"].as_f64().unwrap() - 0.8 * 256.0).abs() < 1e-3);
    assert_eq!(found[0]["method"], "least-squares");
    let parts: Vec<[f64; 2]> = (0..256).map(tone).collect();
    let part = |index: usize| parts.iter().map(|x| x[index]).collect::<Vec<_>>();
    let record = serde_json::json!({"id": "g", "kind": "c", "re": part(0), "im": part(1)});
    let path = file("backwards.jsonl", record.to_string().as_bytes());
    let found = lines(ANALYZE, &[&path, "--method", "z-rife,fesa", "--json"]);
    assert_eq!(found.len(), 3);
    assert!(found[..2].iter().all(|line| line["id"] == "g"));
    assert!(found[..2].iter().all(|line| (line["bins"].as_f64().unwrap() - 204.8).abs() < 0.01));
}

#[test]
fn sweeps_in_json() {
    let flags = ["--method", "z-rife,rife", "--snr-db", "0,20", "--trials", "20", "--json"];
    let rows = lines(SWEEP, &flags);
    assert_eq!(rows.len(), 5);
    for key in "method kind n snr_db arith trials outliers rmse_bins rmse_se_bins mean_abs_bins bias_bins bound_bins ratio".split(' ') {
        assert!(!rows[0][key].is_null(), "{key}");
    }
    assert_eq!(rows[4]["summary"], true);
}

/// Wav files of programs that stream: they write a length that is not one. And from stdin.
#[test]
fn wavs_of_any_length_field() {
    let whole = wav("streamed.wav", spec(1, 16), 5000);
    let expected = lines(ANALYZE, &[&whole, "--n", "1024", "--json"]);
    assert_eq!(expected.len(), 5);
    let mut bytes = fs::read(&whole).unwrap();
    for length in [0u32, 0xFFFF_FFFF, 0x7FFF_F000, 0xFFFF_FFFE] {
        bytes[4..8].copy_from_slice(&length.to_le_bytes());
        bytes[40..44].copy_from_slice(&length.to_le_bytes());
        let streamed = file("any-length.wav", &bytes);
        assert_eq!(lines(ANALYZE, &[&streamed, "--n", "1024", "--json"]), expected, "{length:#x}");
        for name in ["-", "/dev/stdin"] {
            let mut child = Command::new(env!("CARGO_BIN_EXE_picket"))
                .args([ANALYZE, name, "--n", "1024", "--json"])
                .stdin(std::process::Stdio::piped())
                .stdout(std::process::Stdio::piped())
                .spawn()
                .unwrap();
            std::io::Write::write_all(&mut child.stdin.take().unwrap(), &bytes).unwrap();
            let text = String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap();
            let found: Vec<serde_json::Value> =
                text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
            assert_eq!(found, expected, "{name}, {length:#x}");
        }
    }
}

/// One channel of several, and one column beside a time.
#[test]
fn channels_and_columns() {
    let stereo = file("channels.wav", &[]);
    let mut writer = hound::WavWriter::create(&stereo, spec(2, 16)).unwrap();
    for n in 0..2048 {
        for f in [0.1, 0.2] {
            writer
                .write_sample((9000.0 * (std::f64::consts::TAU * f * f64::from(n)).sin()) as i16)
                .unwrap();
        }
    }
    writer.finalize().unwrap();
    let table: String = (0..2048)
        .map(|n| {
            let x = |f: f64| (std::f64::consts::TAU * f * f64::from(n)).sin();
            format!("{:.7},{:.4},{:.4}\n", f64::from(n) / 8000.0, x(0.1), x(0.2))
        })
        .collect();
    let scope =
        file("scope.csv", ("x-axis,1,2\nsecond,Volt,Volt\n".to_owned() + &table).as_bytes());
    for (path, options, hertz) in [
        (&stereo, ["--channel", "1"], 800.0),
        (&stereo, ["--channel", "2"], 1600.0),
        (&scope, ["--column", "2"], 800.0),
        (&scope, ["--column", "3"], 1600.0),
    ] {
        let found = lines(ANALYZE, &[path, options[0], options[1], "--n", "1024", "--json"]);
        let frequency = found[0]["frequency_hz"].as_f64().unwrap();
        assert!((frequency - hertz).abs() < 0.05, "{path} {options:?}: {frequency}");
    }
    refused(ANALYZE, &[&scope, "--n", "1024"], "columns 2 (Volt), 3 (Volt): choose by --column");
    refused(ANALYZE, &[&stereo, "--channel", "3"], "choose 1 to 2");
}

/// Headerless numbers and NumPy's arrays.
#[test]
fn other_numbers() {
    let x: Vec<f64> =
        (0..2048).map(|n| 0.5 * (0.2 * std::f64::consts::PI * f64::from(n)).cos()).collect();
    let of = |name: &str, bytes: Vec<u8>| file(name, &bytes);
    let npy = |kind: &str, shape: &str, data: Vec<u8>| {
        let header =
            format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}\n");
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &data]
            .concat()
    };
    let floats: Vec<u8> = x.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect();
    let doubles: Vec<u8> = x.iter().flat_map(|&x| (1e4 * x).to_le_bytes()).collect();
    let files = [
        of(
            "numbers.u16",
            x.iter().flat_map(|x| ((32768.0 + 32767.0 * x) as u16).to_le_bytes()).collect(),
        ),
        of(
            "numbers.i32",
            x.iter().flat_map(|x| ((2147483647.0 * x) as i32).to_le_bytes()).collect(),
        ),
        of("numbers.f32", floats),
        of("numbers.npy", npy("<f8", "2048,", doubles)),
    ];
    for path in &files {
        let found = lines(ANALYZE, &[path, "--rate", "8000", "--json"]);
        let frequency = found[0]["frequency_hz"].as_f64().unwrap();
        assert!(
            (frequency - 800.0).abs() < 0.05 && found[0]["verdict"] == "good",
            "{path}: {frequency}"
        );
    }
}

/// A file of both kinds: what a method cannot take is left out, said, and told by the exit code.
#[test]
fn records_that_a_method_cannot_take() {
    let part = |f: f64| -> Vec<f64> {
        (0..64).map(|n| (900.0 * (f * f64::from(n)).cos()).round()).collect()
    };
    let real = serde_json::json!({"id": "real", "kind": "r", "re": part(1.0)});
    let iq = serde_json::json!({"id": "iq", "kind": "c", "re": part(1.0), "im": part(1.3)});
    let both = file("both.jsonl", format!("{real}\n{iq}\n").as_bytes());
    let output = run(ANALYZE, &[&both, "--method", "fesa", "--json"]);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(
        errors.contains("record \"real\": left out: fesa works on I/Q records only"),
        "{errors}"
    );
    let text = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((rows.len(), &rows[0]["id"], &rows[1]["skipped"]), (2, &"iq".into(), &1.into()));
}

#[test]
fn a_look_and_its_picture() {
    let tone = wav("look.wav", spec(1, 16), 8192);
    for name in ["spectrum.svg", "spectrum.png"] {
        let picture = file(name, &[]);
        let output = run(ANALYZE, &[&tone, "--plot", &picture]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(
            output.status.success() && text.contains("rate      8000 Hz, real, 8192 samples"),
            "{text}"
        );
        assert!(
            text.contains("hum       none seen") && text.contains("try       picket analyze "),
            "{text}"
        );
        assert!(fs::read(&picture).unwrap().len() > 10_000);
    }
    let speeds = lines(ANALYZE, &[&tone, "--carrier-hz", "24e9", "--json"]);
    let speed = 800.0 * 299_792_458.0 / 24e9 / 2.0;
    assert!((speeds[0]["speed_mps"].as_f64().unwrap() - speed).abs() < 1e-4, "{}", speeds[0]);
}
