//! A fundamental from its harmonics: on the bound of all of them, and never an octave off.

use crate::signal::*;
use host_tests::data;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::{Codes, Config, Iq, Pipeline, Real, Stamp, Verdict};
use rand::RngExt;
use std::f64::consts::TAU;

const N: usize = 1024;

fn fundamental<R: Kind>(samples: &[R::Sample; N], band_hz: Option<(f64, f64)>) -> Option<Harmonic> {
    let config = Config { band_hz, ..Config::new(N as f64, Codes::signed::<12>()) };
    let mut pipeline = Pipeline::<R, N>::new(config.plan().unwrap());
    let measurement = pipeline.block(&Stamp::default(), samples);
    pipeline.harmonic(&measurement, 5)
}

/// A fundamental of 20 to 95 bins with harmonics up to order 5, the fundamental `weaker_db` below them; the strongest `snr_db`
/// above the noise.
fn series<R: Kind>(snr_db: f64, weaker_db: f64, count: u64, seed: u64) {
    let amplitude = 400.0;
    let noise = sigma(amplitude, snr_db);
    let seen = trials(seed, count, |rng| {
        let bins: f64 = rng.random_range(20.0..95.0);
        let lines: Vec<Line> = (1..=5)
            .map(|order| {
                let level = if order == 1 { -weaker_db } else { rng.random_range(-6.0..=0.0) };
                let amplitude = amplitude * 10f64.powf(level / 20.0);
                let bins = bins * f64::from(order);
                Line { bins, amplitude, phase: rng.random_range(0.0..TAU) }
            })
            .collect();
        let samples = R::record::<N>(rng, &lines, noise);
        let noise = noise.hypot((1.0f64 / 12.0).sqrt());
        let information: f64 = lines
            .iter()
            .zip(1..)
            .map(|(&line, order)| (f64::from(order) / R::bound(N, line, noise)).powi(2))
            .sum();
        let found = fundamental::<R>(&samples, None).unwrap();
        let error = found.tone.frequency.bins(N) - bins;
        let trust = error / (f64::from(found.tone.sigma) * N as f64);
        (error, error.powi(2) * information, trust.powi(2), found.tone.verdict == Verdict::Good)
    });
    let wrong = seen.iter().filter(|seen| seen.0.abs() > 1.0).count();
    let right: Vec<_> = seen.iter().filter(|seen| seen.0.abs() <= 1.0).collect();
    let rms = mean(right.iter().map(|seen| seen.1)).sqrt();
    let trust = mean(right.iter().map(|seen| seen.2));
    let good = mean(seen.iter().map(|seen| f64::from(seen.3)));
    println!(
        "{}, {snr_db} dB, fundamental {weaker_db} dB weaker, seed {seed}: {wrong} of {count} wrong, {rms:.3} x the joint bound, \
         (error/sigma)^2 {trust:.3}, good {good:.3}",
        if R::IQ { "I/Q" } else { "real" }
    );
    let error = 2.0 * (2.0 / count as f64).sqrt();
    assert_eq!(wrong, 0);
    assert!(rms * (1.0 - 0.5 * error) <= 1.1);
    assert!(trust * (1.0 + error) >= 0.85 && trust * (1.0 - error) <= 1.15);
    assert!(good >= 0.99);
}

/// 100,000 records in the long form.
#[test]
fn no_octave_is_taken_for_the_fundamental() {
    let count = host_tests::sized(500, 50_000);
    series::<Real>(20.0, 20.0, count, 41);
    series::<Iq>(20.0, 20.0, count, 41);
    for (snr_db, weaker_db) in [(0.0, 20.0), (10.0, 0.0), (40.0, 40.0)] {
        series::<Real>(snr_db, weaker_db, count.min(1000), 42);
    }
}

/// One line tells no order, unless the band leaves only one.
#[test]
fn one_line_is_no_series() {
    let verdict = |band_hz| {
        let line = Line { bins: 100.3, amplitude: 1000.0, phase: 1.0 };
        let samples = Real::record::<N>(&mut rng(43, 0), &[line], 10.0);
        let found = fundamental::<Real>(&samples, band_hz).unwrap();
        (found.tone.frequency.bins(N).round(), found.tone.verdict, found.orders)
    };
    assert_eq!(verdict(None), (100.0, Verdict::Unresolved, 1));
    assert_eq!(verdict(Some((90.0, 110.0))), (100.0, Verdict::Good, 1));
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
    let rms = mean(squares.iter().copied()).sqrt();
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
