//! Whether the numbers that come with a frequency can be trusted: noise, sigma, detection, clipping and
//! verdicts. Records go through the whole pipeline, in the target's arithmetic.

use crate::signal::*;
use picket::acquire::sample::{Codes, Iq, Real, Stamp};
use picket::config::Config;
use picket::estimate::detection::Threshold;
use picket::estimate::measure::Arithmetic;
use picket::estimate::tone::Verdict;
use picket::pipeline::Pipeline;
use picket::spectrum::engine::{Engine, I32};
use picket::spectrum::peak::{Band, Search};
use rand::RngExt;
use rand_distr::Exp1;
use rayon::prelude::*;

/// trust.md 1 (noise) and 2 (sigma). Rounding to codes is noise too: a twelfth of a squared code.
fn noise_and_sigma<R: Kind, const N: usize>(sigma_codes: Option<f64>, snr_db: f64) {
    noise_and_sigma_by::<R, N, I32>(sigma_codes, snr_db);
}

/// The same by any engine.
pub fn noise_and_sigma_by<R: Kind, const N: usize, E: Engine>(
    sigma_codes: Option<f64>,
    snr_db: f64,
) {
    let amplitude = sigma_codes.map_or(amplitude(snr_db), |s| s * (2.0 * db(snr_db)).sqrt());
    let noise = sigma(amplitude, snr_db);
    let seed = (5000.0 + snr_db * 10.0) as u64;
    let seen = trials(seed, 3000, |rng| {
        let line = anywhere::<R, N>(rng, amplitude);
        let tone = measure_by::<R, N, E>(&R::record::<N>(rng, &[line], noise));
        let truth = 10.0 * (amplitude.powi(2) / 2.0 / (noise.powi(2) + 1.0 / 12.0)).log10();
        (
            f64::from(tone.snr_db()) - truth,
            error::<R, N>(&tone, line.bins),
            f64::from(tone.sigma) * N as f64,
        )
    });
    let count = seen.len() as f64;
    let bias = mean(seen.iter().map(|t| t.0));
    let variance = mean(seen.iter().map(|t| (t.0 - bias).powi(2)));
    let within = mean(seen.iter().map(|t| f64::from(t.0.abs() <= 1.0)));
    let good = seen.iter().filter(|t| t.1.abs() <= 1.5);
    let square = mean(good.clone().map(|t| (t.1 / t.2).powi(2)));
    let covered = mean(good.map(|t| f64::from(t.1.abs() <= 1.96 * t.2)));
    let kind = if R::IQ { "I/Q" } else { "real" };
    println!(
        "{kind} N {N} {snr_db:.1} dB, noise {noise:.1} codes, seed {seed}: SNR {bias:+.3} dB, sd {:.2}, \
         within 1 dB {within:.3}; (error/sigma)^2 {square:.3}, 95 % covers {covered:.3}",
        variance.sqrt()
    );
    let bins = 255.min(if R::IQ { N } else { N / 2 } - 1) as f64;
    let allowed = 1.2 * (75.4 / (N as f64 * db(snr_db)) + 37.0 / bins);
    assert!(bias.abs() - 2.0 * (variance / count).sqrt() <= 0.15);
    assert!(variance * (1.0 - 2.0 * (2.0 / count).sqrt()) <= allowed, "{variance} {allowed}");
    assert!(
        N < 1024
            || snr_db < 10.0
            || within + 2.0 * (within * (1.0 - within) / count).sqrt() >= 0.98
    );
    assert!((0.88..=1.15).contains(&square));
    let spread = 2.0 * (0.95 * 0.05 / count).sqrt();
    assert!((0.937 - spread..=0.960 + spread).contains(&covered));
}

#[test]
fn noise_and_sigma_are_right() {
    for snr_db in [10.0, 30.0, 60.0] {
        noise_and_sigma::<Real, 256>(None, snr_db);
        noise_and_sigma::<Real, 1024>(None, snr_db);
        noise_and_sigma::<Real, 4096>(None, snr_db);
        noise_and_sigma::<Iq, 256>(None, snr_db);
        noise_and_sigma::<Iq, 1024>(None, snr_db);
        noise_and_sigma::<Iq, 4096>(None, snr_db);
    }
    // From 2 dB above the threshold.
    noise_and_sigma::<Real, 256>(None, -2.6);
    noise_and_sigma::<Real, 1024>(None, -8.4);
    noise_and_sigma::<Real, 4096>(None, -14.2);
    noise_and_sigma::<Iq, 256>(None, -5.6);
    noise_and_sigma::<Iq, 1024>(None, -11.3);
    noise_and_sigma::<Iq, 4096>(None, -17.1);
    // Noise below a code.
    noise_and_sigma::<Real, 1024>(Some(0.3), 60.0);
    noise_and_sigma::<Real, 1024>(Some(0.3), 30.0);
    noise_and_sigma::<Real, 1024>(Some(0.3), 10.0);
}

/// Interferers outside the searched band, 10 dB stronger than the tone: they are lines, not noise.
fn interferers<R: Kind, const N: usize>(count: usize) {
    let (seed, tone_amplitude, snr_db) = (4711 + count as u64, 150.0, 0.0);
    let noise = sigma(tone_amplitude, snr_db);
    let n = N as f64;
    let band_hz = Some((n / 32.0, n / 8.0));
    let config = Config { rate_hz: n, band_hz, ..Config::default() };
    let plan = config.validate::<R>(N).unwrap();
    let seen = trials(seed, 2000, |rng| {
        let line = |rng: &mut rand_chacha::ChaCha8Rng, from: f64, to: f64, amplitude| Line {
            bins: n * rng.random_range(from..to),
            amplitude,
            phase: rng.random_range(0.0..std::f64::consts::TAU),
        };
        let mut lines = vec![line(rng, 0.04, 0.11, tone_amplitude)];
        lines.extend((0..count).map(|_| line(rng, 0.3, 0.48, 10f64.sqrt() * tone_amplitude)));
        let record = R::record::<N>(rng, &lines, noise);
        let tone = Pipeline::<R, N>::new(plan).block(Stamp::default(), &record).tone;
        let sigma = f64::from(tone.sigma) * n;
        (f64::from(tone.snr_db()) - snr_db, error::<R, N>(&tone, lines[0].bins) / sigma)
    });
    let bias = mean(seen.iter().map(|t| t.0));
    let square = mean(seen.iter().filter(|t| t.1.abs() < 10.0).map(|t| t.1.powi(2)));
    println!(
        "{count} interferers, I/Q {}, N {N}, seed {seed}: SNR {bias:+.3} dB, (error/sigma)^2 {square:.3}",
        R::IQ
    );
    assert!(seen.iter().all(|t| t.1.abs() < 10.0));
    // The bars of a tone alone.
    assert!(bias.abs() <= 0.15 && (0.88..=1.15).contains(&square), "{bias}, {square}");
}

#[test]
fn lines_outside_the_band_are_not_noise() {
    for count in [1, 2] {
        interferers::<Real, 1024>(count);
        interferers::<Real, 4096>(count);
        interferers::<Iq, 1024>(count);
    }
}

/// How often bins of noise pass for a tone, over the nominal probability, and its standard error.
fn false_alarms<const N: usize>(pfa: f64, blocks: u64) -> (f64, f64) {
    let (seed, band) = (77, Band::real(N));
    let threshold = Threshold::new(band.width(), pfa);
    let streams = 1000;
    let alarms: u64 = (0..streams)
        .into_par_iter()
        .map(|stream| {
            let mut rng = rng(seed, stream);
            let alarm = |_: &u64| {
                let mut search = Search::new(band);
                for _ in 0..band.width() {
                    search.push((rng.sample::<f64, _>(Exp1) * 1e9) as u64);
                }
                search.finish().is_some_and(|peak| threshold.detects(&peak))
            };
            (0..blocks / streams).filter(alarm).count() as u64
        })
        .sum();
    let expected = pfa * blocks as f64;
    let found = (alarms as f64 / expected, (alarms as f64).sqrt() / expected);
    println!(
        "N {N}, {blocks} blocks at {pfa:e}, seed {seed}: {:.3} +- {:.3} of nominal",
        found.0, found.1
    );
    found
}

/// trust.md 3: powers of bins drawn directly.
#[test]
fn false_alarms_are_as_ordered() {
    for (share, _) in [
        false_alarms::<256>(1e-2, 1_000_000),
        false_alarms::<1024>(1e-2, 1_000_000),
        false_alarms::<256>(1e-3, 10_000_000),
    ] {
        assert!((0.9..=1.1).contains(&share));
    }
}

/// The default thresholds of trust.md 3, and the probability of detection it states.
#[test]
fn thresholds_and_detection() {
    for (n, expected) in [(256usize, 20.34f32), (1024, 20.46), (4096, 21.55)] {
        let bins = Band::real(n).width();
        let t = Threshold::new(bins, 1e-6).over(bins - 17);
        println!("N {n}: T = {t:.2}");
        assert!((t - expected).abs() < 0.06);
    }
    detected::<256>(-4.6);
    detected::<1024>(-10.7);
    detected::<4096>(-16.5);
}

fn detected<const N: usize>(snr_db: f64) {
    let amplitude = amplitude(snr_db);
    let seen = trials(9, 3000, |rng| {
        let line = anywhere::<Real, N>(rng, amplitude);
        measure::<Real, N>(&Real::record::<N>(rng, &[line], sigma(amplitude, snr_db))).verdict
    });
    let share = mean(seen.iter().map(|&v| f64::from(v < Verdict::Weak)));
    println!("N {N} {snr_db} dB, seed 9: {share:.3} detected");
    assert!((share - 0.9).abs() < 0.02, "{share}");
}

/// Noise alone, through converter and FFT: weak, but for the false alarms.
#[test]
fn noise_alone_is_weak() {
    let config = Config { false_alarm: 1e-2, ..Config::default() };
    let plan = config.validate::<Real>(256).unwrap();
    let seen = trials(10, 200_000, |rng| {
        let samples = Real::record::<256>(rng, &[], 30.0);
        Pipeline::<Real, 256>::new(plan).block(Stamp::default(), &samples).tone.verdict
    });
    let alarms = seen.iter().filter(|&&v| v < Verdict::Weak).count() as f64 / 2000.0;
    println!("seed 10: {alarms:.3} of nominal");
    assert!((0.93..=1.07).contains(&alarms));
}

/// trust.md 4: a share of the samples beyond the rails, by amplitude and DC offset.
fn clipping(share: f64, one_rail: bool, snr_db: f64, places: &[f64]) {
    // cos exceeds the rail for `share` of the time (half of it at each, when there are two).
    let edge = (std::f64::consts::PI * share / if one_rail { 1.0 } else { 2.0 }).cos();
    let amplitude = if one_rail { 1900.0 } else { 2047.0 / edge };
    let offset = if one_rail { 2047.0 - amplitude * edge } else { 0.0 };
    let noise = sigma(amplitude, snr_db);
    let seen = trials(12, 2000, |rng| {
        let mut line = anywhere::<Real, 1024>(rng, amplitude);
        if !places.is_empty() {
            line.bins = places[rng.random_range(0..places.len())] + rng.random_range(-0.5..0.5);
        }
        let dc = Line { bins: 0.0, amplitude: offset, phase: 0.0 };
        let tone = measure::<Real, 1024>(&Real::record::<1024>(rng, &[line, dc], noise));
        (tone.verdict, error::<Real, 1024>(&tone, line.bins), f64::from(tone.sigma) * 1024.0)
    });
    let clipped = mean(seen.iter().map(|t| f64::from(t.0 >= Verdict::Clipped)));
    let square = mean(seen.iter().map(|t| (t.1 / t.2).powi(2)));
    let covered = mean(seen.iter().map(|t| f64::from(t.1.abs() <= 2.0 * t.2)));
    let worst = seen.iter().map(|t| t.1.abs()).fold(0.0, f64::max);
    println!(
        "{:.0} % at {} rail(s), {snr_db} dB, near {places:?}, seed 12: flagged {clipped:.3}, largest error \
         {worst:.1e} bin, (error/sigma)^2 {square:.3}, 2 sigma cover {covered:.3}",
        share * 100.0,
        if one_rail { 1 } else { 2 }
    );
    // A tone at a simple fraction of the rate has few phases, which may all miss the rails.
    assert!(!places.is_empty() || clipped >= 0.99);
    assert!(square <= 1.15 && covered >= 0.94);
}

#[test]
fn clipping_is_flagged_and_covered() {
    for snr_db in [30.0, 60.0] {
        for places in [&[][..], &[256.0, 255.0, 257.0, 341.0, 342.0, 340.0]] {
            clipping(0.05, false, snr_db, places);
            clipping(0.05, true, snr_db, places);
            clipping(0.2, false, snr_db, places);
            clipping(0.2, true, snr_db, places);
        }
    }
}

#[test]
fn each_verdict_where_it_belongs() {
    each_verdict(Arithmetic::Float);
    each_verdict(Arithmetic::Fixed);
}

fn each_verdict(arithmetic: Arithmetic) {
    let mut rng = rng(14, 0);
    let config = Config { arithmetic, ..Config::default() };
    let mut verdict = |bins: f64, amplitude: f64, gap: bool| {
        let line = Line { bins, amplitude, phase: 0.4 };
        let samples = Real::record::<1024>(&mut rng, &[line], 2.0);
        let plan = config.validate::<Real>(1024).unwrap();
        let stamp = Stamp { gap, ..Stamp::default() };
        Pipeline::<Real, 1024>::new(plan).block(stamp, &samples).tone.verdict
    };
    assert_eq!(verdict(100.3, 1000.0, false), Verdict::Good);
    assert_eq!(verdict(1.2, 1000.0, false), Verdict::NearEdge);
    assert_eq!(verdict(510.8, 1000.0, false), Verdict::NearEdge);
    assert_eq!(verdict(100.3, 2300.0, false), Verdict::Clipped);
    assert_eq!(verdict(100.3, 1000.0, true), Verdict::Gap);
    assert_eq!(verdict(100.3, 0.05, false), Verdict::Weak);
    assert_eq!(measure::<Real, 1024>(&[0; 1024]).verdict, Verdict::NoSignal);
    assert_eq!(measure::<Real, 1024>(&[5; 1024]).verdict, Verdict::NoSignal);
}

/// A recording of a 1 kHz generator through a sound card, 44100 samples a second; its first 4 seconds are
/// clean. About 7 % of the samples clip, so the frequency is given with the sigma of a clipped record.
#[test]
fn a_recorded_tone() {
    let Some(file) = host_tests::shared("data/tone_1kHz_pcm2900_i16_44100.bin") else { return };
    let bytes = std::fs::read(file).unwrap();
    let samples: Vec<i16> = bytes.as_chunks().0.iter().map(|&b| i16::from_le_bytes(b)).collect();
    let config = Config { rate_hz: 44100.0, codes: Codes::Signed16, ..Config::default() };
    let plan = config.validate::<Real>(4096).unwrap();
    let mut pipeline = Pipeline::<Real, 4096>::new(plan);
    let seen: Vec<_> = samples[..176_400]
        .as_chunks::<4096>()
        .0
        .iter()
        .map(|block| pipeline.block(Stamp::default(), block))
        .collect();
    let hertz: Vec<_> = seen.iter().map(|m| m.tone.frequency.hertz(44100.0)).collect();
    let middle = mean(hertz.iter().copied());
    let scatter = mean(hertz.iter().map(|f| (f - middle).powi(2))).sqrt();
    let sigma = mean(seen.iter().map(|m| f64::from(m.tone.sigma) * 44100.0));
    let clipped = mean(seen.iter().map(|m| f64::from(m.clipped) / 4096.0));
    println!(
        "{} blocks: {middle:.5} Hz, scatter {:.3} mHz, sigma {:.3} mHz, SNR {:.1} dB, clipped {:.1} %, {:?}",
        seen.len(),
        scatter * 1e3,
        sigma * 1e3,
        mean(seen.iter().map(|m| f64::from(m.tone.snr_db()))),
        clipped * 100.0,
        seen[0].tone.verdict
    );
    assert!(scatter <= 0.3e-3 && scatter <= sigma);
    assert!(seen.iter().all(|m| m.tone.verdict == Verdict::Clipped));
}
