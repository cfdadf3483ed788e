//! What the widths of the Pico's codes (RP2040-E11) do to a frequency: before and after the table, on converters whose steps are
//! those of its curve, and on others.

use host_tests::figures::hold;
use host_tests::sized;
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::{Measurement, Pipeline};
use picket_dsp::tone::Verdict;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_firmware::pico::widths::{corrected, widen};
use picket_firmware::pico::{N, Pairs};
use picket_host::pico::converter::Converter;
use picket_wire::settings::Settings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A tone's amplitude and offset, and its converter.
type Taken = (f64, f64, Converter);

/// What is done with a converter's codes.
#[derive(Clone, Copy, PartialEq)]
enum Handling {
    /// Measured as they are, by the library alone.
    Raw,
    /// As with the setting `uncorrected`: sigma is widened.
    Uncorrected,
    /// Corrected.
    Corrected,
}

struct Errors {
    rms_millihertz: f64,
    rms_sigmas: f64,
    worst_sigmas: f64,
    good: f64,
    median_sigma: f64,
}

/// The tone of a real record, of these voltages at each sample.
fn real(voltage: &mut dyn FnMut(f64, f64) -> i16, bin: f64) -> Measurement {
    let config = config();
    let block: [i16; N] = std::array::from_fn(|n| voltage(TAU * bin * n as f64 / N as f64, 0.0));
    Pipeline::<Real, N>::new(config.plan().unwrap()).block(&Stamp::default(), &block)
}

/// The same of I/Q pairs by turns: Q lags by a quarter of a turn, and half a pair.
fn pairs(voltage: &mut dyn FnMut(f64, f64) -> i16, bin: f64) -> Measurement {
    let rate_hz = config().rate_hz;
    let side = [3.0, 512.0].map(|bin| bin / N as f64 * rate_hz);
    let band_hz = Some(if bin > 0.0 { (side[0], side[1]) } else { (-side[1], -side[0]) });
    let config = Config { band_hz, ..config() };
    let mut block: [[i16; 2]; N] = std::array::from_fn(|n| {
        let turn = |n: f64| TAU * bin * n / N as f64;
        [voltage(turn(n as f64), 0.0), voltage(turn(n as f64 + 0.5), -0.25 * TAU)]
    });
    Pairs::new(config.plan().unwrap()).block(&Stamp::default(), &mut block)
}

/// How a tone of so many bins is measured, by its voltage at a phase with a lag.
type Measured = fn(&mut dyn FnMut(f64, f64) -> i16, f64) -> Measurement;

fn config() -> Config {
    Config { arithmetic: Arithmetic::Fixed, ..Settings::default().config }
}

/// The errors of so many tones, each at any frequency and phase, in noise of 1.2 codes.
fn errors(name: &str, how: Handling, seed: u64, taken: impl Fn(u64) -> Taken + Sync) -> Errors {
    errors_of((real, false), name, how, seed, taken)
}

/// The same of another kind of record.
fn errors_of(
    (measured, signed): (Measured, bool),
    name: &str,
    how: Handling,
    seed: u64,
    taken: impl Fn(u64) -> Taken + Sync,
) -> Errors {
    let config = config();
    let trials = sized(4_000, 40_000);
    let each = |trial: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(1_000_000 * seed + trial);
        let (amplitude, offset, converter) = taken(trial);
        let (bin, phase) = (rng.random_range(5.0..505.0), rng.random_range(0.0..TAU));
        // Real records have no sign.
        let bin = if signed && trial % 2 == 1 { -bin } else { bin };
        let noise = Normal::new(0.0, 1.2).unwrap();
        let mut voltage = |turn: f64, lag: f64| {
            let tone = amplitude * (turn + phase + lag).cos();
            let code = converter.code(offset + tone + noise.sample(&mut rng));
            if how == Handling::Corrected { corrected(code) } else { code }
        };
        let mut measurement = measured(&mut voltage, bin);
        if how != Handling::Raw {
            widen(&mut measurement, how == Handling::Corrected, signed);
        }
        let tone = measurement.tone;
        let error = tone.hertz() - bin / N as f64 * config.rate_hz;
        (error, tone.sigma_hertz(), tone.verdict == Verdict::Good)
    };
    let all: Vec<(f64, f64, bool)> = (0..trials).into_par_iter().map(each).collect();
    let rms = |square: &dyn Fn(&(f64, f64, bool)) -> f64| {
        (all.iter().map(square).sum::<f64>() / all.len() as f64).sqrt()
    };
    let mut sigmas: Vec<f64> = all.iter().map(|(_, sigma, _)| 1e3 * sigma).collect();
    sigmas.sort_by(f64::total_cmp);
    let errors = Errors {
        rms_millihertz: rms(&|(error, ..)| (1e3 * error).powi(2)),
        rms_sigmas: rms(&|(error, sigma, _)| (error / sigma).powi(2)),
        worst_sigmas: all.iter().map(|(error, sigma, _)| (error / sigma).abs()).fold(0.0, f64::max),
        good: all.iter().filter(|(.., good)| *good).count() as f64 / all.len() as f64,
        median_sigma: sigmas[sigmas.len() / 2],
    };
    println!(
        "{name:30} rms {:6.2} mHz, {:.2} sigma, worst {:5.1} sigma, median sigma {:6.2} mHz, good {:.1} % of {trials}, seed {seed}",
        errors.rms_millihertz,
        errors.rms_sigmas,
        errors.worst_sigmas,
        errors.median_sigma,
        100.0 * errors.good
    );
    errors
}

/// Tones of 1900 codes about the middle, as docs/pico.md has them.
#[test]
fn full_scale_tones_before_and_after_the_table() {
    let wrong = |a: f64, b: f64| Converter::from_steps([a, b, a, b]);
    let (less, more) = (2.0 / 3.0, 4.0 / 3.0);
    let rows = [
        ("an ideal converter", Handling::Raw, Converter::ideal()),
        ("as it is", Handling::Raw, Converter::default()),
        ("`uncorrected`", Handling::Uncorrected, Converter::default()),
        ("corrected, table right", Handling::Corrected, Converter::default()),
        ("corrected, steps a third less", Handling::Corrected, wrong(less, less)),
        ("corrected, steps a third more", Handling::Corrected, wrong(more, more)),
        ("corrected, by turns", Handling::Corrected, wrong(less, more)),
    ];
    let mut all = Vec::new();
    for (name, how, converter) in &rows {
        let errors = errors(name, *how, 18, |_| (1900.0, 2048.0, converter.clone()));
        all.push(errors);
    }
    let figures = |errors: &Errors| {
        [errors.rms_millihertz, errors.median_sigma, errors.rms_sigmas, errors.worst_sigmas]
    };
    // Those of the short form.
    for ((name, ..), errors) in rows.iter().zip(&all).filter(|_| sized(0, 1) == 0) {
        hold(&format!("pico, wide codes, {name}"), 0.01, &figures(errors));
    }
    let [ideal, before, _, right, others @ ..] = all.as_slice() else { panic!("seven rows") };
    assert!(before.rms_millihertz > 2.0 * ideal.rms_millihertz && before.worst_sigmas > 10.0);
    assert!(right.rms_millihertz < 1.1 * ideal.rms_millihertz);
    for errors in others.iter().chain([right]) {
        // In noise alone the worst of 4,000 is at four sigmas, and of 40,000 near five; one of so many has all its steps pulling together.
        assert!(errors.worst_sigmas < [5.5, 6.5][sized(0, 1) as usize], "{}", errors.worst_sigmas);
        assert!((0.8..1.05).contains(&errors.rms_sigmas), "{}", errors.rms_sigmas);
        // Sigma is no larger than need be where no line comes near.
        assert!(errors.median_sigma < 1.25 * ideal.median_sigma, "{}", errors.median_sigma);
    }
}

/// I/Q pairs by turns, in both sidebands: each channel crosses the wide codes, and their harmonics fold onto fewer tones than those of a
/// real record.
#[test]
fn sigma_holds_for_pairs_by_turns() {
    let wrong = |factor: f64| Converter::from_steps([factor; 4]);
    for (name, how, converter) in [
        ("pairs, an ideal converter", Handling::Raw, Converter::ideal()),
        ("pairs, `uncorrected`", Handling::Uncorrected, Converter::default()),
        ("pairs, table right", Handling::Corrected, Converter::default()),
        ("pairs, steps a third less", Handling::Corrected, wrong(2.0 / 3.0)),
        ("pairs, steps a third more", Handling::Corrected, wrong(4.0 / 3.0)),
    ] {
        let errors =
            errors_of((pairs, true), name, how, 19, |_| (1900.0, 2048.0, converter.clone()));
        assert!(errors.worst_sigmas < [5.5, 6.5][sized(0, 1) as usize], "{}", errors.worst_sigmas);
        assert!((0.6..1.05).contains(&errors.rms_sigmas), "{}", errors.rms_sigmas);
    }
}

/// Tones of any size anywhere, each on a converter of its own, whose steps are up to a third beside the table.
#[test]
fn sigma_holds_on_any_converter() {
    for seed in 0..sized(1, 5) {
        let errors = errors("corrected, any", Handling::Corrected, 81 + seed, |trial| {
            let mut rng = ChaCha8Rng::seed_from_u64(trial);
            let amplitude = 2_000.0 * 10f64.powf(-rng.random_range(0.0..1.5));
            let room = 2_040.0 - amplitude;
            let offset = 2_048.0 + rng.random_range(-room..room);
            let steps = std::array::from_fn(|_| rng.random_range(2.0 / 3.0..4.0 / 3.0));
            (amplitude, offset, Converter::from_steps(steps))
        });
        assert!(errors.worst_sigmas < 5.5, "{}", errors.worst_sigmas);
        assert!((0.8..1.05).contains(&errors.rms_sigmas), "{}", errors.rms_sigmas);
    }
}
