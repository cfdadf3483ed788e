//! Unknown recordings, of any rate, format, level, with hum and clipping: what `picket analyze FILE` says to type finds the tone.

use crate::cli::seed;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const RECORDINGS: usize = 30;

/// What is in a recording.
#[derive(Debug)]
struct Truth {
    name: String,
    tone_hz: f64,
    rate_hz: f64,
    hum: bool,
    clipped: bool,
    /// What a person types of a file that does not tell it.
    options: Vec<String>,
}

fn wav(path: &Path, rate_hz: f64, bits: u16, values: &[f64]) {
    let float = bits == 33;
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: rate_hz as u32,
        bits_per_sample: bits.min(32),
        sample_format: if float { hound::SampleFormat::Float } else { hound::SampleFormat::Int },
    };
    let mut writer = hound::WavWriter::create(path, spec).unwrap();
    let full = f64::from(1u32 << (bits.min(32) - 1));
    for &x in values {
        if float {
            writer.write_sample(x as f32).unwrap();
        } else {
            writer.write_sample((full * x).round().clamp(-full, full - 1.0) as i32).unwrap();
        }
    }
    writer.finalize().unwrap();
}

fn npy(path: &Path, values: &[f64]) {
    let header =
        format!("{{'descr': '<i2', 'fortran_order': False, 'shape': ({},), }}\n", values.len());
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|x| ((32767.0 * x).round() as i16).to_le_bytes()));
    fs::write(path, bytes).unwrap();
}

/// A recording of its own, and what is in it.
fn make(folder: &Path, index: usize, rng: &mut ChaCha8Rng) -> Truth {
    let rates = [8000.0, 11_025.0, 22_050.0, 44_100.0, 48_000.0, 96_000.0, 192_000.0];
    let rate_hz = rates[rng.random_range(0..rates.len())];
    let samples = [3000, 6000, 20_000, 60_000][rng.random_range(0..4)];
    let tone_hz = rate_hz * rng.random_range(0.02..0.45);
    let level = 10f64.powf(rng.random_range(-40.0..0.0) / 20.0);
    let hum = rng.random_range(0..3) == 0 && f64::from(samples) / rate_hz > 0.12;
    let clipped = rng.random_range(0..4) == 0;
    let (mains, phase): (f64, f64) = ([50.0, 60.0][rng.random_range(0..2)], rng.random());
    let hum_level =
        if hum { level * 10f64.powf(rng.random_range(-10.0..10.0) / 20.0) } else { 0.0 };
    let noise = level * 10f64.powf(rng.random_range(-40.0..0.0) / 20.0);
    let offset = rng.random_range(-0.1..0.1) * level;
    let gain = if clipped {
        1.3 / (level + hum_level)
    } else {
        (0.6 / (level + hum_level + 4.0 * noise)).min(1.0)
    };
    let values: Vec<f64> = (0..samples)
        .map(|n| {
            let t = f64::from(n) / rate_hz;
            let normal: f64 = StandardNormal.sample(rng);
            let x = level * (TAU * (tone_hz * t + phase)).sin()
                + hum_level * (TAU * mains * t).sin()
                + 0.3 * hum_level * (TAU * 3.0 * mains * t).cos()
                + noise * normal
                + offset;
            (gain * x).clamp(-1.0, 1.0)
        })
        .collect();
    let kind = index % 8;
    let suffix = ["wav", "wav", "wav", "csv", "csv", "npy", "bin", "f32"][kind];
    let path = folder.join(format!("unknown-{index}.{suffix}"));
    let mut options = Vec::new();
    match kind {
        0 => wav(&path, rate_hz, 16, &values),
        1 => wav(&path, rate_hz, 24, &values),
        2 => wav(&path, rate_hz, 33, &values),
        3 => {
            let rows = values
                .iter()
                .zip(0..)
                .map(|(x, n)| format!("{:.9e},{:.5}\n", f64::from(n) / rate_hz, 2.0 * x));
            fs::write(&path, "Time (s),CH1 (V)\n".to_owned() + &rows.collect::<String>()).unwrap();
        }
        4 => {
            let rows = values.iter().zip(0..).map(|(x, n)| {
                format!("{:.9};{:.4}\n", f64::from(n) / rate_hz, 5.0 * x).replace('.', ",")
            });
            fs::write(&path, "Zeit;Spannung\n".to_owned() + &rows.collect::<String>()).unwrap();
        }
        5 => npy(&path, &values),
        6 => {
            // A microcontroller's codes: 12 bits from 0 on.
            let codes = values.iter().map(|x| (2048.0 + 2047.0 * x).round() as i16);
            fs::write(&path, codes.flat_map(i16::to_le_bytes).collect::<Vec<_>>()).unwrap();
        }
        _ => fs::write(
            &path,
            values.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect::<Vec<_>>(),
        )
        .unwrap(),
    }
    if kind >= 5 {
        options = vec!["--rate".into(), rate_hz.to_string()];
    }
    Truth {
        name: path.file_name().unwrap().to_str().unwrap().into(),
        tone_hz,
        rate_hz,
        hum,
        clipped,
        options,
    }
}

/// What the tool prints in this folder, which must succeed.
pub fn picket(folder: &Path, arguments: &[String]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn what_a_look_proposes_finds_the_tone() {
    const SEED: u64 = 15;
    let seed = seed(SEED);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("unknown");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let (mut found, mut hums, mut clips) = (0, 0, 0);
    for index in 0..RECORDINGS {
        let truth = make(&folder, index, &mut rng);
        hums += usize::from(truth.hum);
        clips += usize::from(truth.clipped);
        let arguments =
            [vec!["analyze".into(), truth.name.clone()], truth.options.clone()].concat();
        let look = picket(&folder, &arguments);
        let proposed = look.lines().find_map(|line| line.strip_prefix("try       picket "));
        let Some(proposed) = proposed else {
            println!("nothing proposed: {truth:?}\n{look}");
            continue;
        };
        let arguments: Vec<String> =
            proposed.split(' ').map(str::to_owned).chain(["--json".into()]).collect();
        let lines = picket(&folder, &arguments);
        let answers =
            lines.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        let mut frequencies: Vec<f64> =
            answers.filter_map(|line| line["frequency_hz"].as_f64()).collect();
        frequencies.sort_by(f64::total_cmp);
        let n =
            arguments.windows(2).find(|pair| pair[0] == "--n").unwrap()[1].parse::<f64>().unwrap();
        let median = frequencies.get(frequencies.len() / 2).copied().unwrap_or(f64::NAN);
        // The tone, and not a neighbour: within a quarter of a bin.
        let near = (median - truth.tone_hz).abs() < 0.25 * truth.rate_hz / n;
        if near {
            found += 1;
        } else {
            println!("{median} Hz by {proposed}\nof {truth:?}\n{look}");
        }
    }
    println!(
        "{found} of {RECORDINGS} tones are found by what is proposed; {hums} with hum, {clips} clipped"
    );
    // Another seed may clip three of them.
    let few = if seed == SEED { 3 } else { 0 };
    assert!(hums > few && clips > few);
    assert!(found >= 28, "{found} of {RECORDINGS}");
}

/// The look at 6000 samples of a tone beside a hum, and the frequency that the proposed command finds.
fn beside_hum(name: &str, rate_hz: f64, tone_hz: f64, hum_hz: f64) -> (String, f64, f64) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("hum");
    fs::create_dir_all(&folder).unwrap();
    let value = |n: i32| {
        let sine = |hertz: f64| 0.3 * (TAU * hertz / rate_hz * f64::from(n)).sin();
        sine(tone_hz) + sine(hum_hz)
    };
    wav(&folder.join(name), rate_hz, 16, &(0..6000).map(value).collect::<Vec<_>>());
    let look = picket(&folder, &["analyze".into(), name.into()]);
    let proposed = look.lines().find_map(|line| line.strip_prefix("try       picket ")).unwrap();
    let words = proposed.split(' ').map(str::to_owned).chain(["--json".into()]);
    let answers = picket(&folder, &words.collect::<Vec<_>>());
    let first: serde_json::Value = serde_json::from_str(answers.lines().next().unwrap()).unwrap();
    let found_hz = first["frequency_hz"].as_f64().unwrap();
    (look, found_hz, first["sigma_hz"].as_f64().unwrap())
}

/// In an eighth of a second both mains are within reach of either line: the nearer one is meant.
#[test]
fn the_mains_are_told_apart() {
    for hum_hz in [50.0, 60.0] {
        let (look, found_hz, _) = beside_hum("mains.wav", 48_000.0, 13_847.0, hum_hz);
        assert!(look.contains(&format!("hum       {hum_hz} Hz is among the lines")), "{look}");
        assert!((found_hz - 13_847.0).abs() < 1.0, "{found_hz} Hz: {look}");
    }
}

/// The band that is proposed ends where the spectrum does, and half of 11,025 Hz is no whole number.
#[test]
fn the_proposed_band_is_within_the_spectrum() {
    let (look, found_hz, sigma_hz) = beside_hum("edge.wav", 11_025.0, 5100.0, 50.0);
    assert!(look.contains(":5512"), "{look}");
    assert!((found_hz - 5100.0).abs() < 3.0 * sigma_hz, "{found_hz} Hz: {look}");
}
