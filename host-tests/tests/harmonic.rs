//! A fundamental from its harmonics: one line alone, and a recording. Its bound is in `claims/tests/faults.rs`.

use host_tests::data;
use picket_claims::samples;
use picket_claims::scenes::{Kind, line, tones};
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::{Codes, Config, Pipeline, Real, Stamp, Verdict};
use std::f64::consts::TAU;

const N: usize = 1024;

fn fundamental(samples: &[i16; N], band_hz: Option<(f64, f64)>) -> Option<Harmonic> {
    let config = Config { band_hz, ..Config::new(N as f64, Codes::signed::<12>()) };
    let mut pipeline = Pipeline::<Real, N>::new(config.plan().unwrap());
    let measurement = pipeline.block(&Stamp::default(), samples);
    pipeline.harmonic(&measurement, 5)
}

/// One line tells no order, unless the band leaves only one.
#[test]
fn one_line_is_no_series() {
    let verdict = |band_hz| {
        let scene = tones(Kind::Real, N, [line(100.3, 1000.0)], 10.0);
        let samples = samples::<Real, N>(&mut scene.run(0).unwrap(), 0);
        let found = fundamental(&samples, band_hz).unwrap();
        (found.tone.frequency.bins(N).round(), found.tone.verdict, found.orders)
    };
    assert_eq!(verdict(None), (100.0, Verdict::Unresolved, 1));
    assert_eq!(verdict(Some((90.0, 110.0))), (100.0, Verdict::Good, 1));
}

/// A stiff string: its partials are stretched, and plain multiples would put the fundamental tens of sigmas off.
#[test]
fn a_stiff_string_has_its_fundamental() {
    for stretch in [0.0, 2e-5, 1e-4, 2.5e-4] {
        for first in [21.37, 37.83, 60.21] {
            let partial = |order: f64| {
                let ratio = order * ((1.0 + stretch * order * order) / (1.0 + stretch)).sqrt();
                line(first * ratio, 400.0 / order.max(2.0))
            };
            let scene = tones(Kind::Real, N, [1.0, 2.0, 3.0, 4.0, 5.0].map(partial), 3.0);
            let samples = samples::<Real, N>(&mut scene.run(0).unwrap(), 0);
            let found = fundamental(&samples, Some((0.7 * first, 1.3 * first))).unwrap();
            let error = found.tone.frequency.bins(N) - first;
            assert!(
                error.abs() < 5.0 * f64::from(found.tone.sigma) * N as f64,
                "{first} {stretch}: {error}"
            );
            assert_eq!(
                (found.tone.verdict, found.orders),
                (Verdict::Good, 0b11111),
                "{first} {stretch}"
            );
        }
    }
}

/// Mains: blocks of 1.3 s follow the published track, each of whose points is a fit to 8 s under
/// Hann's window. That is a mean of the frequency with the weights of [`weight`], which a mean of the blocks' answers repeats.
#[test]
fn the_mains_are_followed() {
    let bytes = std::fs::read(data("mains50_092_ref.wav")).unwrap();
    let samples: Vec<i16> =
        bytes[44..].as_chunks().0.iter().map(|&pair| i16::from_le_bytes(pair)).collect();
    mains_track(&samples, &std::fs::read_to_string(data("mains50_092_ref_track.csv")).unwrap());
}

fn mains_track(samples: &[i16], track: &str) {
    const RATE: f64 = 400.0;
    const FRAME: usize = 3200;
    const M: usize = 512;
    const HOP: usize = 64;
    /// A block's own mean takes a part of the width: the variances add.
    const SHARPER: f64 = 1.0388;
    let band_hz = Some((45.0, 55.0));
    let config = Config { band_hz, ..Config::new(RATE, Codes::signed::<16>()) };
    let mut pipeline = Pipeline::<Real, M>::new(config.plan().unwrap());
    let mut squares = Vec::new();
    for line in track.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let Some(frame) = samples.get(numbers[0] as usize..).and_then(|s| s.get(..FRAME)) else {
            continue;
        };
        let (mut sum, mut all) = (0.0, 0.0);
        for (index, block) in frame.windows(M).step_by(HOP).enumerate() {
            let block: &[i16; M] = block.try_into().unwrap();
            let measurement = pipeline.block(&Stamp::default(), block);
            let found = pipeline.harmonic(&measurement, 3).unwrap();
            let from_middle = (index * HOP) as f64 + 0.5 * M as f64 - 0.5 * FRAME as f64;
            let weight = weight(SHARPER * from_middle / FRAME as f64);
            sum += weight * found.tone.hertz();
            all += weight;
        }
        squares.push((sum / all - numbers[1]).powi(2));
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("{} frames, rms difference from the track {:.4} mHz", squares.len(), 1e3 * rms);
    assert!(squares.len() >= 30 && rms < 1e-4);
}

/// How much the frequency at a time, in frames from the middle, counts in a least-squares fit under Hann's window: the integral of
/// its square times the time, from there to the end.
fn weight(t: f64) -> f64 {
    if t.abs() >= 0.5 {
        return 0.0;
    }
    let swing = |turns: f64, end: f64| {
        let b = TAU * turns;
        (end - (b * t).cos()) / (b * b) - t * (b * t).sin() / b
    };
    0.1875 * (0.25 - t * t) + 0.5 * swing(1.0, -1.0) + 0.125 * swing(2.0, 1.0)
}
