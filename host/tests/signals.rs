//! `picket analyze FILE --burst` and `--accumulate M`: particles in a flow, and an echo below the noise.

use crate::cli::{ANALYZE, file, lines, refused, seed};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 200_000.0;

/// What the command prints, on stdout and on stderr.
fn printed(arguments: &[&str]) -> [String; 2] {
    let output = crate::cli::run(ANALYZE, arguments);
    [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
}

fn recording(name: &str, samples: &[f64]) -> String {
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: RATE_HZ as u32,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let path = file(name, &[]);
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for x in samples {
        writer.write_sample(x.round() as i16).unwrap();
    }
    writer.finalize().unwrap();
    path
}

fn noise(rng: &mut ChaCha8Rng, length: usize, sigma: f64) -> Vec<f64> {
    (0..length)
        .map(|_| {
            let normal: f64 = StandardNormal.sample(rng);
            sigma * normal
        })
        .collect()
}

/// Forty particles of 30 kHz with a deviation of 1 kHz, in the middle of every 4,000 samples.
#[test]
fn bursts_for_people_spreadsheets_and_programs() {
    const COUNT: usize = 40;
    let mut rng = ChaCha8Rng::seed_from_u64(seed(41));
    let mut samples = noise(&mut rng, 4000 * (COUNT + 1), 150.0);
    let mut truth = Vec::new();
    for burst in 0..COUNT {
        let normal: f64 = StandardNormal.sample(&mut rng);
        let (hertz, phase) = (30_000.0 + 1000.0 * normal, rng.random_range(0.0..TAU));
        let middle = 4000.0 * (burst as f64 + 1.0);
        truth.push((middle / RATE_HZ, hertz));
        for (n, x) in samples.iter_mut().enumerate() {
            let t = n as f64 - middle;
            let level = 5000.0 * (-t * t / (2.0 * 90.0 * 90.0)).exp();
            *x += level * (0.4 + (TAU * hertz / RATE_HZ * t + phase).cos());
        }
    }
    let path = recording("particles.wav", &samples);
    let all = lines(ANALYZE, &[&path, "--burst", "--json"]);
    let (summary, bursts) = all.split_last().unwrap();
    let valid: Vec<_> = bursts.iter().filter(|burst| burst["validation"] == "valid").collect();
    assert!(valid.len() >= COUNT - 2, "{} valid", valid.len());
    for burst in &valid {
        let number = |key: &str| burst[key].as_f64().unwrap();
        let near = |t: &&(f64, f64)| (t.0 - number("time_s")).abs() < 1e-3;
        let (_, hertz) = truth.iter().find(near).unwrap();
        assert!((number("frequency_hz") - hertz).abs() < 5.0 * number("sigma_hz"), "{burst}");
        let transit = 8f64.sqrt() * 90.0 / RATE_HZ;
        assert!((number("transit_s") / transit - 1.0).abs() < 0.1, "{burst}");
    }
    let mean = truth.iter().map(|t| t.1).sum::<f64>() / COUNT as f64;
    assert_eq!(summary["summary"], true);
    assert!((summary["mean_hz"].as_f64().unwrap() - mean).abs() < 150.0, "{summary} {mean}");
    assert!((500.0..1500.0).contains(&summary["rms_hz"].as_f64().unwrap()), "{summary}");

    let [text, _] = printed(&[&path, "--burst"]);
    assert!(text.contains("bursts valid") && text.contains("weighted with its transit time"));
    let [csv, _] = printed(&[&path, "--burst", "--csv", "--carrier-hz", "2e14"]);
    let mut rows = csv.lines();
    let columns = rows.next().unwrap().split(',').count();
    assert!(rows.next().is_some_and(|row| row.split(',').count() == columns), "{csv}");
}

/// -20 dB a sample: one block does not see it, a hundred do.
#[test]
fn an_echo_below_the_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(seed(42));
    let hertz = 41_234.5;
    let mut samples = noise(&mut rng, 1024 * 205, 1000.0);
    for block in samples.chunks_mut(1024) {
        let phase = rng.random_range(0.0..TAU);
        for (n, x) in block.iter_mut().enumerate() {
            *x += 0.02f64.sqrt() * 1000.0 * (TAU * hertz / RATE_HZ * n as f64 + phase).cos();
        }
    }
    let path = recording("echo.wav", &samples);
    let sums = lines(ANALYZE, &[&path, "--accumulate", "100", "--json"]);
    assert_eq!(sums.len(), 2);
    for sum in &sums {
        let number = |key: &str| sum[key].as_f64().unwrap();
        assert_eq!((&sum["verdict"], &sum["blocks"]), (&"good".into(), &100.into()), "{sum}");
        assert!((number("frequency_hz") - hertz).abs() < 5.0 * number("sigma_hz"), "{sum}");
        assert!((number("snr_db") + 20.0).abs() < 1.5, "{sum}");
    }
    let single = lines(ANALYZE, &[&path, "--json"]);
    let weak = single.iter().filter(|line| line["verdict"] == "weak").count();
    assert!(weak > 195, "{weak} weak");
    let [_, told] = printed(&[&path, "--accumulate", "100"]);
    assert!(told.contains("5 blocks at the end are left"), "{told}");
    refused(ANALYZE, &[&path, "--accumulate", "1000"], "fewer than --accumulate 1000");
    refused(ANALYZE, &[&path, "--accumulate", "0"], "0");
    refused(ANALYZE, &[&path, "--burst", "--n", "1000"], "choose 512 or 1024");
}
