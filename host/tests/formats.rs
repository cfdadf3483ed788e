//! Recordings in every format: the same answers, or one line that says what is wrong.

use crate::cli::{ANALYZE, file, lines, refused, spec, wav};
use std::fs;
use std::process::Command;

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
        for arithmetic in ["target", "target-fixed"] {
            let found = lines(ANALYZE, &[&path, "--arith", arithmetic, "--json"]);
            assert_eq!(found.len(), 2, "{name}");
            let frequency = found[0]["frequency_hz"].as_f64().unwrap();
            assert!((frequency - 800.0).abs() < 0.05, "{name} {arithmetic}: {frequency}");
            let snr_db = found[0]["snr_db"].as_f64().unwrap();
            assert!(snr_db > floor_db, "{name} {arithmetic}: {:?}", found[0]);
            // The rounding of a tone without noise is a comb of lines, which eight bits show.
            let verdict = found[0]["verdict"].as_str().unwrap();
            assert!(
                verdict == "good" || (bits == 8 && verdict == "unresolved"),
                "{name} {arithmetic}"
            );
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
    for arithmetic in ["target", "target-fixed"] {
        for line in &lines(ANALYZE, &[&half, "--arith", arithmetic, "--json"])[..4] {
            let number = |key: &str| line[key].as_f64().unwrap();
            // The noise beside the tone is less than the lines that its rounding makes elsewhere, and those beside it are lines of the fit.
            assert!((number("snr_db") - 43.9).abs() < 6.0, "{arithmetic}: {line}");
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
