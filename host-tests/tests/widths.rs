//! What the widths of the Pico's codes (RP2040-E11) do to a frequency: before and after the table, on converters whose steps are
//! those of its curve, and on others.

use host_tests::figures::hold;
use host_tests::sized;
use picket_claims::scenes::{Kind, line, tones};
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::{Measurement, Pipeline};
use picket_dsp::tone::Verdict;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_firmware::pico::widths::{corrected, widen};
use picket_firmware::pico::{N, Pairs};
use picket_host::pico::converter::Converter;
use picket_simulator::Draw;
use picket_wire::settings::Settings;
use rayon::prelude::*;

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

fn config() -> Config {
    Config { arithmetic: Arithmetic::Fixed, ..Settings::default().config }
}

/// The tone of a record of these codes, in place for I/Q pairs by turns.
fn measured(kind: Kind, mut block: [[i16; 2]; N], bin: f64) -> Measurement {
    let config = config();
    if kind == Kind::Real {
        let block = block.map(|[code, _]| code);
        return Pipeline::<Real, N>::new(config.plan().unwrap()).block(&Stamp::default(), &block);
    }
    let side = [3.0, 512.0].map(|bin| bin / N as f64 * config.rate_hz);
    let band_hz = Some(if bin > 0.0 { (side[0], side[1]) } else { (-side[1], -side[0]) });
    let plan = Config { band_hz, ..config }.plan().unwrap();
    Pairs::new(plan).block(&Stamp::default(), &mut block)
}

/// The errors of so many tones, each at any frequency and phase, in noise of 1.2 codes: of real records, or of pairs by turns, whose Q lags by a
/// quarter of a turn, and half a pair.
fn errors(
    (name, kind, how): (&str, Kind, Handling),
    seed: u64,
    taken: impl Fn(u64) -> Taken + Sync,
) -> Errors {
    let trials = sized(4_000, 40_000);
    let each = |trial: u64| {
        let (amplitude, offset, converter) = taken(trial);
        // Real records have no sign.
        let lower = kind == Kind::Iq && trial % 2 == 1;
        let bins = if lower { -505.0..-5.0 } else { 5.0..505.0 };
        let mut scene = tones(kind, N, [line(bins, amplitude)], 1.2);
        (scene.seed, scene.receiver.offset) = (seed, [offset.into(), offset.into()]);
        scene.receiver.q_late_s = (-0.5 / N as f64).into();
        let mut run = scene.run(trial).unwrap();
        let bin = run.truth(0, 0.0, N).frequency_hz;
        let voltages = run.voltages(0.0, N);
        let code = |voltage: f64| {
            let code = converter.code(voltage);
            if how == Handling::Corrected { corrected(code) } else { code }
        };
        let block = std::array::from_fn(|n| voltages[n].map(code));
        let mut measurement = measured(kind, block, bin);
        if how != Handling::Raw {
            widen(&mut measurement, how == Handling::Corrected, kind == Kind::Iq);
        }
        let tone = measurement.tone;
        let error = tone.hertz() - bin / N as f64 * config().rate_hz;
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
        let errors = errors((name, Kind::Real, *how), 18, |_| (1900.0, 2048.0, converter.clone()));
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
        let errors = errors((name, Kind::Iq, how), 19, |_| (1900.0, 2048.0, converter.clone()));
        assert!(errors.worst_sigmas < [5.5, 6.5][sized(0, 1) as usize], "{}", errors.worst_sigmas);
        assert!((0.6..1.05).contains(&errors.rms_sigmas), "{}", errors.rms_sigmas);
    }
}

/// Tones of any size anywhere, each on a converter of its own, whose steps are up to a third beside the table.
#[test]
fn sigma_holds_on_any_converter() {
    for seed in 0..sized(1, 5) {
        let any = ("corrected, any", Kind::Real, Handling::Corrected);
        let errors = errors(any, 81 + seed, |trial| {
            let mut draw = Draw::new(81 + seed, trial);
            let amplitude = 2_000.0 * 10f64.powf(-draw.between(0.0, 1.5));
            let room = 2_040.0 - amplitude;
            let offset = 2_048.0 + draw.between(-room, room);
            let steps = std::array::from_fn(|_| draw.between(2.0 / 3.0, 4.0 / 3.0));
            (amplitude, offset, Converter::from_steps(steps))
        });
        assert!(errors.worst_sigmas < 5.5, "{}", errors.worst_sigmas);
        assert!((0.8..1.05).contains(&errors.rms_sigmas), "{}", errors.rms_sigmas);
    }
}
