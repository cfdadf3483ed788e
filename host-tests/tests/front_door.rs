//! The library by the names at its root, as a stranger uses it: codes of every width, the wrong ones, slices of the wrong
//! length.

use crate::signal::rng;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::{Codes, Config, F32, I32, Iq, Method, Pipeline, Real, Record, Tone, Verdict};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 48e3;

/// A tone of this share of the range between the rails, 40 dB above its noise, as a converter with these codes delivers it.
fn samples<R: Record, const N: usize>(
    codes: Codes,
    share: f64,
    hertz: f64,
    rng: &mut ChaCha8Rng,
) -> [R::Sample; N] {
    let (low, high) = codes.rails();
    let (low, high) = (f64::from(low), f64::from(high));
    let (middle, amplitude) = ((low + high) / 2.0, share * (high - low) / 2.0);
    let (phase, sigma): (f64, f64) = (rng.random(), amplitude * (0.5e-4f64).sqrt());
    std::array::from_fn(|n| {
        let (sin, cos) = (TAU * (hertz / RATE_HZ * n as f64 + phase)).sin_cos();
        let part = |x: f64, noise: f64| {
            (middle + amplitude * x + sigma * noise).round().clamp(low, high) as i16
        };
        let noise = [rng.sample(StandardNormal), rng.sample(StandardNormal)];
        R::from_parts([part(cos, noise[0]), part(sin, noise[1])])
    })
}

fn codes_of_every_width() -> Vec<Codes> {
    let signed = (8..=16).map(|bits| Codes::from_bits(true, bits));
    let unsigned = (8..=15).map(|bits| Codes::from_bits(false, bits));
    // As of a converter that adds 13 conversions of 12 bits up.
    let sum = [Codes::between(0, 4095 * 7), Codes::between(-3000, 12_000)];
    signed.chain(unsigned).chain(sum).map(Option::unwrap).collect()
}

fn every_width<R: Record, const N: usize, E: Engine>() {
    for codes in codes_of_every_width() {
        let mut rng = rng(14, N as u64);
        let mut squares = 0.0;
        const TRIALS: usize = 40;
        for trial in 0..TRIALS {
            let hertz = 3001.0 + 411.7 * trial as f64;
            let samples = samples::<R, N>(codes, 0.9, hertz, &mut rng);
            // I/Q has the codes' offset at 0 Hz: the band begins above.
            let band_hz = R::IQ.then_some((1e3, 23e3));
            let config = Config { band_hz, ..Config::new(RATE_HZ, codes) };
            let mut pipeline = Pipeline::<R, N, E>::new(config.plan().unwrap());
            let tone = pipeline.record(&samples).unwrap().tone;
            assert_eq!(tone.verdict, Verdict::Good, "{codes:?} {hertz}: {tone}");
            let error = (tone.hertz() - hertz) / tone.sigma_hertz();
            assert!(error.abs() < 5.0, "{codes:?} {hertz}: {tone}");
            squares += error * error;
        }
        // Chi square of 40 degrees: 1e-6 on either side.
        let mean = squares / TRIALS as f64;
        assert!((0.28..2.5).contains(&mean), "{codes:?}: mean (error/sigma)^2 {mean}");
    }
}

#[test]
fn codes_of_8_to_16_bits() {
    println!("seed 14");
    every_width::<Real, 1024, I32>();
    // From bin 32 on: the offset of I/Q codes lies in bin 0, and the fit of a tone below bin 17 would read it.
    every_width::<Iq, 512, I32>();
    every_width::<Real, 1024, F32>();
}

#[test]
fn an_overdriven_converter_is_never_good() {
    println!("seed 15");
    for codes in codes_of_every_width() {
        let mut rng = rng(15, 0);
        let plan = Config::new(RATE_HZ, codes).plan().unwrap();
        let mut pipeline = Pipeline::<Real, 1024>::new(plan);
        for trial in 0..100 {
            let hertz = 2000.0 + 200.3 * f64::from(trial);
            let samples = samples::<Real, 1024>(codes, 1.3, hertz, &mut rng);
            let tone = pipeline.record(&samples).unwrap().tone;
            assert_ne!(tone.verdict, Verdict::Good, "{codes:?} {hertz}: {tone}");
        }
    }
}

#[test]
fn codes_that_the_converter_cannot_make_have_their_own_verdict() {
    println!("seed 16");
    let mut rng = rng(16, 0);
    let said = |stated: Codes, true_codes: Codes, share: f64, rng: &mut ChaCha8Rng| -> Tone {
        let samples = samples::<Real, 1024>(true_codes, share, 1234.57, rng);
        let plan = Config::new(RATE_HZ, stated).plan().unwrap();
        Pipeline::<Real, 1024>::new(plan).record(&samples).unwrap().tone
    };
    let pairs = [
        (Codes::signed::<12>(), Codes::signed::<16>()),
        (Codes::signed::<12>(), Codes::unsigned::<12>()),
        (Codes::unsigned::<12>(), Codes::signed::<12>()),
        (Codes::unsigned::<12>(), Codes::unsigned::<14>()),
    ];
    for (stated, truth) in pairs {
        let tone = said(stated, truth, 0.5, &mut rng);
        assert_eq!(tone.verdict, Verdict::WrongCodes, "{stated:?} for {truth:?}: {tone}");
    }
    // The right ones, at half scale: the frequency that a wrong reading missed by far.
    let tone = said(Codes::signed::<16>(), Codes::signed::<16>(), 0.5, &mut rng);
    assert_eq!(tone.verdict, Verdict::Good);
    assert!((tone.hertz() - 1234.57).abs() < 0.1, "{tone}");
}

#[test]
fn a_slice_of_another_length_is_refused_in_words() {
    let plan = Config::new(RATE_HZ, Codes::signed::<12>()).plan().unwrap();
    let mut pipeline = Pipeline::<Real, 1024>::new(plan);
    for length in [0, 1023, 1025] {
        let error = pipeline.record(&vec![0; length]).unwrap_err();
        assert_eq!((error.samples, error.wanted), (length, 1024));
        assert!(error.to_string().contains("1024"));
    }
}

#[test]
fn what_people_read() {
    println!("seed 17");
    let codes = Codes::signed::<12>();
    let samples = samples::<Real, 1024>(codes, 0.9, 1000.2, &mut rng(17, 0));
    let plan = Config::new(RATE_HZ, codes).plan().unwrap();
    let tone = Pipeline::<Real, 1024>::new(plan).record(&samples).unwrap().tone;
    let said = tone.to_string();
    // Hertz with two digits of sigma, and the verdict.
    let (hertz, rest) = said.split_once(" Hz ± ").unwrap();
    assert!((hertz.parse::<f64>().unwrap() - 1000.2).abs() < 0.1, "{said}");
    let (sigma, rest) = rest.split_once(" Hz, SNR ").unwrap();
    let digits = |x: &str| x.split_once('.').map_or(0, |(_, digits)| digits.len());
    assert_eq!(digits(hertz), digits(sigma));
    assert!((sigma.parse::<f64>().unwrap() / tone.sigma_hertz() - 1.0).abs() < 0.06);
    assert!(rest.ends_with(" dB, good"), "{said}");
    assert!(tone.frequency.to_string().starts_with("0.02083"), "{}", tone.frequency);
    // A tone that means nothing is told without a panic.
    assert!(Tone::default().to_string().ends_with("no-signal"));
    assert_eq!("z-rife".parse(), Ok(Method::ZRife));
    assert_eq!("zrife".parse::<Method>().unwrap_err().to_string().lines().count(), 1);
}
