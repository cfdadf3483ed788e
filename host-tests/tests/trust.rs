//! Whether the numbers that come with a frequency can be trusted: noise, sigma, detection, clipping and
//! verdicts. Records go through the whole pipeline, in the target's arithmetic.

use crate::signal::*;
use host_tests::sized;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Stamp, Statistics};
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::spectrum::engine::{Engine, I32};
use picket_dsp::spectrum::peak::{Band, Search};
use picket_dsp::tone::Verdict;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::detection::Threshold;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::Exp1;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_4;

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
    // The ring beside the tone is as good as 50 real numbers, 34 where only one side of it is in the spectrum.
    let allowed = 1.2 * (75.4 / (N as f64 * db(snr_db)) + 37.0 / 25.0);
    assert!(bias.abs() - 2.0 * (variance / count).sqrt() <= 0.15);
    assert!(variance * (1.0 - 2.0 * (2.0 / count).sqrt()) <= allowed, "{variance} {allowed}");
    // One decibel is more than one standard deviation of that.
    assert!(N < 1024 || snr_db < 10.0 || within >= 0.68);
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

/// The good ones where noise decides whether a tone is found: at this many decibels a third, three quarters or nine tenths of them.
fn just_found<R: Kind, const N: usize>(snr_db: f64, count: u64) {
    let amplitude = amplitude(snr_db);
    let noise = sigma(amplitude, snr_db);
    let seed = (7000.0 + snr_db * 10.0) as u64;
    let seen = trials(seed, count, |rng| {
        let line = anywhere::<R, N>(rng, amplitude);
        let tone = measure::<R, N>(&R::record::<N>(rng, &[line], noise));
        let off = error::<R, N>(&tone, line.bins) / (f64::from(tone.sigma) * N as f64);
        (tone.verdict == Verdict::Good).then_some(off * off)
    });
    let good: Vec<f64> = seen.into_iter().flatten().collect();
    let square = mean(good.iter().copied());
    let kind = if R::IQ { "I/Q" } else { "real" };
    let share = good.len() as f64 / count as f64;
    println!(
        "{kind} N {N} {snr_db} dB, seed {seed}: {share:.3} of {count} good, (error/sigma)^2 {square:.3}"
    );
    let error = 2.0 * (2.0 / good.len() as f64).sqrt();
    assert!(square * (1.0 + error) >= 0.88 && square * (1.0 - error) <= 1.12, "{square}");
}

#[test]
fn a_tone_that_noise_lifts_over_the_threshold_has_its_sigma() {
    for snr_db in [-8.0, -6.0, -4.9] {
        just_found::<Real, 256>(snr_db, sized(4000, 40_000));
        just_found::<Iq, 256>(snr_db - 3.0, sized(4000, 40_000));
        just_found::<Real, 1024>(snr_db - 6.2, sized(3000, 30_000));
        just_found::<Iq, 1024>(snr_db - 9.2, sized(3000, 30_000));
        just_found::<Real, 4096>(snr_db - 12.2, sized(1000, 10_000));
        just_found::<Iq, 4096>(snr_db - 15.2, sized(1000, 10_000));
    }
}

/// Interferers outside the searched band, 10 dB stronger than the tone: they are lines, not noise.
fn interferers<R: Kind, const N: usize>(count: usize) {
    let (seed, tone_amplitude, snr_db) = (4711 + count as u64, 150.0, 0.0);
    let noise = sigma(tone_amplitude, snr_db);
    let n = N as f64;
    let band_hz = Some((n / 32.0, n / 8.0));
    let config = Config { rate_hz: n, band_hz, ..Config::new(1.0, Codes::signed::<12>()) };
    let plan = config.plan::<R, N>().unwrap();
    let seen = trials(seed, 2000, |rng| {
        let line = |rng: &mut rand_chacha::ChaCha8Rng, from: f64, to: f64, amplitude| Line {
            bins: n * rng.random_range(from..to),
            amplitude,
            phase: rng.random_range(0.0..std::f64::consts::TAU),
        };
        let mut lines = vec![line(rng, 0.04, 0.11, tone_amplitude)];
        lines.extend((0..count).map(|_| line(rng, 0.3, 0.48, 10f64.sqrt() * tone_amplitude)));
        let record = R::record::<N>(rng, &lines, noise);
        let tone = Pipeline::<R, N>::new(plan).block(&Stamp::default(), &record).tone;
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
        false_alarms::<256>(1e-2, sized(300_000, 1_000_000)),
        false_alarms::<1024>(1e-2, sized(300_000, 1_000_000)),
        false_alarms::<256>(1e-3, sized(2_000_000, 10_000_000)),
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
    // By the power of its bin and the floor alone a tone would be found as often at -4.6, -10.7 and -16.5 dB.
    detected::<256>(-4.9);
    detected::<1024>(-11.2);
    detected::<4096>(-17.2);
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

/// Noise alone, through converter and FFT: weak, but for the false alarms that are asked.
#[test]
fn noise_alone_is_weak() {
    // Fewer blocks, because a longer record takes longer.
    let long = alarms::<Real, 4096>();
    assert!((0.8..=1.1).contains(&long), "{long}");
    let alarms = [
        alarms::<Real, 64>(),
        alarms::<Real, 256>(),
        alarms::<Real, 1024>(),
        alarms::<Iq, 64>(),
        alarms::<Iq, 256>(),
    ];
    let [_, real_256, ..] = alarms;
    assert!((0.93..=1.07).contains(&real_256));
    assert!(alarms.iter().all(|alarms| (0.9..=1.1).contains(alarms)), "{alarms:?}");
}

/// The false alarms over those asked, which are one in a hundred.
fn alarms<R: Kind, const N: usize>() -> f64 {
    let config = Config { false_alarm: 1e-2, ..Config::new(1.0, Codes::signed::<12>()) };
    let plan = config.plan::<R, N>().unwrap();
    // As long for each length.
    let count = 200_000 * 256 / N.max(256) as u64;
    let seen = trials(10, count, |rng| {
        let samples = R::record::<N>(rng, &[], 30.0);
        Pipeline::<R, N>::new(plan).block(&Stamp::default(), &samples).tone.verdict
    });
    let alarms = seen.iter().filter(|&&v| v < Verdict::Weak).count() as f64;
    let asked = count as f64 / 100.0;
    let (alarms, accuracy) = (alarms / asked, alarms.sqrt() / asked);
    println!("N {N}, {count} blocks, seed 10: {alarms:.3} +- {accuracy:.3} of nominal");
    alarms
}

/// How a record clips.
#[derive(Clone, Copy, Debug)]
struct Clipped {
    share: f64,
    /// One, with an offset, or two.
    rails: u32,
    snr_db: f64,
    /// Where harmonics fall onto the tone, else anywhere.
    worst: bool,
}

impl Clipped {
    /// Amplitude and offset of a part whose cosine is beyond the rails for that share of the time. A sample of two parts
    /// has two chances.
    fn amplitude<R: Kind>(&self) -> (f64, f64) {
        let share = if R::IQ { self.share / 2.0 } else { self.share };
        let edge = (std::f64::consts::PI * share / f64::from(self.rails)).cos();
        match self.rails {
            1 => (1900.0, 2047.0 - 1900.0 * edge),
            _ => (2047.0 / edge, 0.0),
        }
    }

    /// Within 1.5 bins of a simple fraction of the rate: a harmonic is nearer than 7.
    fn worst_bins<const N: usize>(rng: &mut ChaCha8Rng) -> f64 {
        let fractions = [1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 2.0 / 5.0];
        let beside = [-1.0, 0.0, 0.0, 1.0][rng.random_range(0..4)];
        fractions[rng.random_range(0..4)] * N as f64 + beside + rng.random_range(-0.5..0.5)
    }

    /// Error over sigma, and by how many dB noise is estimated too strong, of the records that clip by more than 1 %.
    fn seen<R: Kind, const N: usize>(&self, count: u64) -> Vec<(f64, f64)> {
        let (amplitude, offset) = self.amplitude::<R>();
        let noise = sigma(amplitude, self.snr_db);
        let power = (noise * noise + 1.0 / 12.0) * if R::IQ { 2.0 } else { 1.0 };
        let signal = amplitude * amplitude * if R::IQ { 1.0 } else { 0.5 };
        let seen = trials(12, count, |rng| {
            let mut line = anywhere::<R, N>(rng, amplitude);
            if self.worst {
                line.bins = Self::worst_bins::<N>(rng);
            }
            // A constant of both parts.
            let dc = Line { bins: 0.0, amplitude: offset * 2f64.sqrt(), phase: FRAC_PI_4 };
            let samples = R::record::<N>(rng, &[line, dc], noise);
            let clipped = Statistics::clipped::<R>(&samples, CODES);
            let tone = measure::<R, N>(&samples);
            let ratio = error::<R, N>(&tone, line.bins) / (f64::from(tone.sigma) * N as f64);
            let excess = 10.0 * (signal / power).log10() - f64::from(tone.snr_db());
            let clips = clipped as f64 > 0.01 * N as f64;
            assert!(!clips || tone.verdict >= Verdict::Clipped);
            clips.then_some((ratio, excess))
        });
        seen.into_iter().flatten().collect()
    }

    fn check<R: Kind, const N: usize>(&self, count: u64) {
        let seen = self.seen::<R, N>(count);
        let rms = mean(seen.iter().map(|t| t.0 * t.0)).sqrt();
        let beyond = mean(seen.iter().map(|t| f64::from(t.0.abs() > 3.0)));
        let excess = mean(seen.iter().map(|t| t.1));
        let kind = if R::IQ { "I/Q" } else { "real" };
        println!(
            "{kind} N {N} {self:?}, {} records of seed 12: error/sigma {rms:.3}, beyond 3 sigma {beyond:.4}, noise \
             {excess:+.2} dB",
            seen.len()
        );
        assert!(seen.len() as u64 > count / 2);
        assert!(beyond <= 0.01);
        assert!(rms <= 1.15);
        // A harmonic among the fit's own bins is taken for a second tone, and counts as noise besides.
        assert!(self.worst || rms >= 0.75);
        // The amplitude of a strongly clipped tone is too small, and with it the signal.
        assert!(self.share > 0.1 || self.worst || excess.abs() < 0.5, "{excess}");
    }
}

/// Of records that clip at one rail or both, by 1.5 to 40 % of the samples, at least 99 % are within 3 sigma, also where
/// harmonics fall onto the tone; elsewhere sigma is no more than the error asks for, too.
#[test]
fn clipping_is_flagged_and_explained() {
    for snr_db in [30.0, 60.0] {
        for (rails, worst) in [(1, false), (1, true), (2, false), (2, true)] {
            for share in [0.015, 0.05, 0.1, 0.2, 0.4] {
                let clipped = Clipped { share, rails, snr_db, worst };
                clipped.check::<Real, 256>(1000);
                clipped.check::<Real, 1024>(1000);
                clipped.check::<Real, 4096>(400);
                clipped.check::<Iq, 256>(1000);
                clipped.check::<Iq, 1024>(1000);
                clipped.check::<Iq, 4096>(400);
            }
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
    let config = Config { arithmetic, ..Config::new(1.0, Codes::signed::<12>()) };
    let mut verdict = |bins: f64, amplitude: f64, gap: bool| {
        let line = Line { bins, amplitude, phase: 0.4 };
        let samples = Real::record::<1024>(&mut rng, &[line], 2.0);
        let plan = config.plan::<Real, 1024>().unwrap();
        let stamp = Stamp { gap, ..Stamp::default() };
        Pipeline::<Real, 1024>::new(plan).block(&stamp, &samples).tone.verdict
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
/// clean. About 7 % of the samples clip, so noise and sigma come from the others.
#[test]
#[ignore = "needs a recording that is named: PICKET_TONE_1KHZ, see host-tests/data/README.md"]
fn named_a_recorded_tone_of_a_generator() {
    let bytes = std::fs::read(host_tests::tone_1khz()).unwrap();
    let samples: Vec<i16> = bytes.as_chunks().0.iter().map(|&b| i16::from_le_bytes(b)).collect();
    let config = Config {
        rate_hz: 44100.0,
        codes: Codes::signed::<16>(),
        ..Config::new(1.0, Codes::signed::<12>())
    };
    let plan = config.plan::<Real, 4096>().unwrap();
    let mut pipeline = Pipeline::<Real, 4096>::new(plan);
    let seen: Vec<_> = samples[..176_400]
        .as_chunks::<4096>()
        .0
        .iter()
        .map(|block| pipeline.block(&Stamp::default(), block))
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
    assert!(scatter <= 0.3e-3 && scatter <= sigma && sigma <= 3.0 * scatter);
    assert!(seen.iter().all(|m| m.tone.verdict == Verdict::Clipped));
}
