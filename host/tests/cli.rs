//! Bad input through the real programs: one line on stderr that says what to do, exit code 2, nothing on stdout.

pub use crate::program::{file, fresh, lines, refused, run};
use picket_simulator::scene::{Converter, Scene, Source, Tone};
use std::fs;

pub const ANALYZE: &str = "analyze";

/// The seed of a test: `PICKET_TYPED_SEED`, or the test's own.
pub fn seed(own: u64) -> u64 {
    let seed = std::env::var("PICKET_TYPED_SEED").map_or(own, |text| text.parse().unwrap());
    println!("PICKET_TYPED_SEED={seed}");
    seed
}

/// A scene's recording, a WAV file of 16 bits.
pub fn recorded(name: &str, scene: &Scene) -> String {
    let channels = if scene.receiver.iq { 2 } else { 1 };
    let spec = hound::WavSpec { sample_rate: scene.rate_hz as u32, ..self::spec(channels, 16) };
    let converter = Converter { bits: 16, ..scene.converter.clone() };
    let scene = Scene { converter, ..scene.clone() };
    let path = file(name, &[]);
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for codes in scene.codes(0).unwrap() {
        for code in codes.into_iter().take(channels.into()) {
            writer.write_sample(code).unwrap();
        }
    }
    writer.finalize().unwrap();
    path
}

/// Tones of so many Hz, codes and turns at the first sample, in noise of so many codes, at 48 kHz.
pub fn tones(samples: usize, tones: &[(f64, f64, f64)], noise: f64) -> Scene {
    let source = |&(hertz, codes, turns): &(f64, f64, f64)| {
        Source::Tone(Tone {
            frequency_hz: hertz.into(),
            amplitude: Some(codes.into()),
            phase_turns: turns.into(),
            ..Tone::default()
        })
    };
    let sources = tones.iter().map(source).collect();
    let seconds = samples as f64 / 48e3;
    let mut scene = Scene { rate_hz: 48e3, seconds, sources, ..Scene::default() };
    scene.receiver.noise.rms = Some(noise.into());
    scene
}

pub fn wav(name: &str, spec: hound::WavSpec, frames: usize) -> String {
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

pub fn spec(channels: u16, bits: u16) -> hound::WavSpec {
    let sample_format =
        if bits == 33 { hound::SampleFormat::Float } else { hound::SampleFormat::Int };
    hound::WavSpec { channels, sample_rate: 8000, bits_per_sample: bits.min(32), sample_format }
}

#[test]
fn tracks_are_drawn_over_the_spectrogram() {
    let tone = wav("followed.wav", spec(1, 16), 40 * 1024);
    for name in ["tracks.svg", "tracks.png"] {
        let picture = fresh(name);
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
    refused(ANALYZE, &[&short, "--rate", "1000", "--iq", "--skip", "5", "--n", "64"], "fewer");
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
    let rate = ["--rate", "1000", "--n", "64"];
    let with = |path: &str, says| {
        let arguments: Vec<&str> = [path].into_iter().chain(rate).collect();
        refused(ANALYZE, &arguments, says);
    };
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
    with(&json("few.jsonl", r#"{"kind": "r", "re": [1, 2]}"#), "2 samples are fewer than 64");
}

#[test]
fn options_that_do_not_fit() {
    let good = wav("good.wav", spec(1, 16), 4096);
    refused(ANALYZE, &[&good, "--method", "fesa"], "fesa works on I/Q records only");
    refused(ANALYZE, &[&good, "--method", "fase"], "no method \"fase\"");
    refused(ANALYZE, &[&good, "--band", "5000:6000"], "band");
    refused(ANALYZE, &[&good, "--band", "300"], "LO:HI");
    // The two nearest lengths, in every mode.
    for mode in [&[][..], &["--track"], &["--most", "2"], &["--harmonics", "3"], &["--burst"]] {
        let arguments = [&[&*good, "--n", "1000"], mode].concat();
        refused(
            ANALYZE,
            &arguments,
            "N = 1000: blocks have 64, 128, ... 4096 samples, so choose 512 or 1024",
        );
    }
    refused(ANALYZE, &[&good, "--n", "1000", "--accumulate", "4"], "choose 512 or 1024");
    refused(
        ANALYZE,
        &[&good, "--n", "3"],
        "N = 3: blocks have 64, 128, ... 4096 samples, so choose 64",
    );
    refused(ANALYZE, &[&good, "--n", "5000"], "choose 4096");
    let record = serde_json::json!({"id": "odd", "kind": "r", "re": vec![900.0; 100]}).to_string();
    let odd = file("odd.jsonl", record.as_bytes());
    refused(
        ANALYZE,
        &[&odd],
        "record \"odd\": N = 100: blocks have 64, 128, ... 4096 samples, so choose 64 or 128",
    );
    refused(ANALYZE, &[&good, "--n", "0"], "at least 1");
    refused(ANALYZE, &[&good, "--k", "5"], "choose 4, 8 or 16");
    refused(ANALYZE, &[&good, "--method", "ml"], "lab sweep --arith f64");
    let fixed = [&good, "--arith", "target-fixed", "--method", "candan"];
    refused(ANALYZE, &fixed, "use least squares, rife or z-rife");
    refused(ANALYZE, &[&good, "--arith", "target", "--bits", "12"], "exceed");
    refused(ANALYZE, &[&good, "--wrong"], "--wrong");
    refused(ANALYZE, &[], "required");
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
    for name in ["answers.svg", "answers.png"] {
        let picture = fresh(name);
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
        // What is proposed held: its answers are drawn, not the spectrum.
        let drawn = fs::read(&picture).unwrap();
        let text = String::from_utf8_lossy(&drawn);
        assert!(if name.ends_with("svg") {
            text.contains("answers and sigma")
        } else {
            drawn.len() > 10_000
        });
    }
    let speeds = lines(ANALYZE, &[&tone, "--carrier-hz", "24e9", "--json"]);
    let speed = 800.0 * 299_792_458.0 / 24e9 / 2.0;
    assert!((speeds[0]["speed_mps"].as_f64().unwrap() - speed).abs() < 1e-4, "{}", speeds[0]);
}
