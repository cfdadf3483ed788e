//! I/Q pairs that one converter takes by turns, Q half a pair after I: right in both sidebands, with a sigma that holds, and without
//! an image of their delay.

use crate::signal::*;
use fixed::types::I32F32;
use host_tests::{echoes, sized};
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::{Ambiguity, Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::{Alternating, Codes, Iq, Measurement, Method, Outcome, Pipeline, Stamp, Verdict};
use picket_simulator::Target;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// What the channels do to the pairs.
#[derive(Clone, Copy, Debug)]
struct Channels {
    offset: [f64; 2],
    /// Q's gain, and its error of phase in radians.
    gain: f64,
    phase: f64,
}

const IDEAL: Channels = Channels { offset: [0.0; 2], gain: 1.0, phase: 0.0 };

/// Pairs of a tone in noise of `sigma` in each channel.
fn pairs<const N: usize>(
    rng: &mut ChaCha8Rng,
    line: Line,
    sigma: f64,
    channels: Channels,
) -> [[i16; 2]; N] {
    let Channels { offset, gain, phase } = channels;
    let turn = TAU * line.bins / N as f64;
    std::array::from_fn(|n| {
        let at = |n: f64| turn * n + line.phase;
        let i = line.amplitude * at(n as f64).cos();
        let q = gain * line.amplitude * (at(n as f64 + 0.5) + phase).sin();
        let mut noise = || sigma * rng.sample::<f64, _>(StandardNormal);
        [quantise(i + offset[0] + noise()), quantise(q + offset[1] + noise())]
    })
}

/// The plan of one sideband, from `least` bins on, at a rate of 1.
fn sideband(n: usize, upper: bool, least: f64) -> Config {
    let low = (least - 0.01) / n as f64;
    let band = if upper { (low, 0.5) } else { (-0.5, -low) };
    Config { band_hz: Some(band), ..Config::new(1.0, CODES) }
}

fn measure<const N: usize, const TWICE: usize>(
    config: &Config,
    pairs: &mut [[i16; 2]; N],
) -> Measurement {
    let before = *pairs;
    let measurement =
        Alternating::<N, TWICE>::new(config.plan().unwrap()).block(&Stamp::default(), pairs);
    assert_eq!(*pairs, before, "the codes are not what they were");
    measurement
}

/// A tone somewhere between `least` bins from 0 Hz and as many from the end, on either side.
fn somewhere(rng: &mut ChaCha8Rng, n: usize, amplitude: f64, least: f64) -> (Line, bool) {
    let (upper, bins) = (rng.random(), rng.random_range(least..n as f64 / 2.0 - least));
    let bins = if upper { bins } else { -bins };
    (Line { bins, amplitude, phase: rng.random_range(0.0..TAU) }, upper)
}

/// Error and sigma in bins, and the bound, of so many good tones at `least` bins or more from 0 Hz and from the end.
fn errors<const N: usize, const TWICE: usize>(
    seed: u64,
    count: u64,
    levels: [f64; 2],
    least: f64,
    channels: impl Fn(&mut ChaCha8Rng) -> Channels + Sync,
) -> Vec<[f64; 3]> {
    trials(seed, count, |rng| {
        let snr_db = rng.random_range(levels[0]..levels[1]);
        let (line, upper) = somewhere(rng, N, 1_000.0, least);
        let sigma = sigma(line.amplitude, snr_db);
        let channels = channels(rng);
        let mut pairs = pairs::<N>(rng, line, sigma, channels);
        let config = sideband(N, upper, least.min(3.0));
        let Measurement { clipped, tone, .. } = measure::<N, TWICE>(&config, &mut pairs);
        assert_eq!((clipped, tone.verdict), (0, Verdict::Good), "seed {seed}: {line:?} {tone:?}");
        // The sign is right, or the error is large.
        let error = tone.frequency.bins(N) - line.bins;
        let bound = bound_iq(N, line.amplitude, sigma.hypot(12f64.recip().sqrt()));
        let level = f64::from(tone.amplitude) / line.amplitude - 1.0;
        let noise = sigma * (2.0 / N as f64).sqrt() / line.amplitude;
        assert!(level.abs() < 6.0 * noise + 0.03, "seed {seed}: {line:?} {tone:?}");
        [error, f64::from(tone.sigma) * N as f64, bound]
    })
}

/// Root mean square of the errors in sigmas and in bounds, and the worst in sigmas.
fn ratios(errors: &[[f64; 3]]) -> [f64; 3] {
    let rms = |place: usize| {
        mean(errors.iter().map(|all| (all[0] / all[place]).powi(2)).collect::<Vec<_>>().into_iter())
            .sqrt()
    };
    let worst = errors.iter().map(|[error, sigma, _]| (error / sigma).abs()).fold(0.0, f64::max);
    [rms(1), rms(2), worst]
}

fn calibrated<const N: usize, const TWICE: usize>(seed: u64) {
    let errors = errors::<N, TWICE>(seed, sized(2_000, 40_000), [14.0, 50.0], 8.0, |_| IDEAL);
    let [sigmas, bounds, worst] = ratios(&errors);
    println!("{N} pairs: {sigmas:.3} sigmas, {bounds:.3} bounds, worst {worst:.1}, seed {seed}");
    assert!((0.93..1.06).contains(&sigmas) && bounds < 1.06, "{sigmas} {bounds}");
    assert!(worst < 6.0, "{worst}");
}

#[test]
fn sigma_holds_in_both_sidebands_from_64_to_1024_pairs() {
    calibrated::<64, 128>(901);
    calibrated::<128, 256>(902);
    calibrated::<256, 512>(903);
    calibrated::<512, 1024>(904);
    calibrated::<1024, 2048>(905);
}

/// Noise of a code: what the delay of Q might leave at minus the frequency would be seen beside 0 Hz.
#[test]
fn strong_tones_near_0_and_the_ends_are_right() {
    let errors =
        errors::<1024, 2048>(906, sized(1_000, 20_000), [55.0, 62.0], 4.0, |rng| Channels {
            offset: [rng.random_range(-500.0..500.0), rng.random_range(-500.0..500.0)],
            ..IDEAL
        });
    let [sigmas, bounds, worst] = ratios(&errors);
    println!("{sigmas:.3} sigmas, {bounds:.3} bounds, worst {worst:.1}");
    assert!((0.9..1.08).contains(&sigmas) && bounds < 1.08 && worst < 6.0);
    for bins in [3.3, -3.3, 6.0, -6.4, 508.2, -508.2] {
        let mut rng = rng(907, 0);
        let line = Line { bins, amplitude: 1_000.0, phase: 1.0 };
        let mut pairs = pairs::<1024>(&mut rng, line, 1.0, IDEAL);
        let tone = measure::<1024, 2048>(&sideband(1024, bins > 0.0, 3.0), &mut pairs).tone;
        assert_eq!(tone.verdict, Verdict::Good, "{line:?} {tone:?}");
        assert!((tone.frequency.bins(1024) - bins).abs() < 0.001, "{line:?} {tone:?}");
    }
    // Nearer to the ends the tone's mirror image disturbs it.
    for bins in [511.2, -511.2] {
        let line = Line { bins, amplitude: 1_000.0, phase: 1.0 };
        let mut pairs = pairs::<1024>(&mut rng(908, 0), line, 1.0, IDEAL);
        let tone = measure::<1024, 2048>(&sideband(1024, bins > 0.0, 3.0), &mut pairs).tone;
        assert_eq!(tone.verdict, Verdict::NearEdge, "{line:?} {tone:?}");
    }
}

/// Ideal channels, whole cycles: what lies at minus the frequency is the transform's own.
#[test]
fn ideal_channels_leave_no_image() {
    let mut worst = f64::NEG_INFINITY;
    for bins in [-500i32, -256, -101, -3, 3, 17, 255, 444] {
        let turn = |n: f64| TAU * f64::from(bins) * n / 1024.0 + 0.4;
        let mut pairs: [[i16; 2]; 1024] = std::array::from_fn(|n| {
            let [i, q] = [turn(n as f64).cos(), turn(n as f64 + 0.5).sin()];
            [i, q].map(|part| (32_000.0 * part).round() as i16)
        });
        let config = Config { codes: Codes::signed::<16>(), ..sideband(1024, bins > 0, 3.0) };
        let mut pipeline = Alternating::<1024, 2048>::new(config.plan().unwrap());
        pipeline.block(&Stamp::default(), &mut pairs);
        let power = |bins: i32| pipeline.spectrum().power(512 + bins) as f64;
        worst = worst.max(10.0 * (power(-bins) / power(bins)).log10());
    }
    println!("image at most {worst:.1} dB");
    assert!(worst < -90.0, "{worst}");
    // As if both were taken at once: docs/pico.md has it for the middle of a sideband.
    let turn = |n: f64| TAU * n / 4.0;
    let pairs: [[i16; 2]; 1024] = std::array::from_fn(|n| {
        [turn(n as f64).cos(), turn(n as f64 + 0.5).sin()].map(|part| (30_000.0 * part) as i16)
    });
    let mut pipeline =
        Pipeline::<Iq, 1024>::new(Config::new(1.0, Codes::signed::<16>()).plan().unwrap());
    pipeline.block(&Stamp::default(), &pairs);
    let power = |bins: i32| pipeline.spectrum().power(bins) as f64;
    let image = 10.0 * (power(-256) / power(256)).log10();
    assert!((image + 7.66).abs() < 0.01, "{image}");
}

/// The channels' offsets are one line, at 0 Hz.
#[test]
fn offsets_are_not_searched() {
    let channels = Channels { offset: [900.0, -700.0], ..IDEAL };
    let line = Line { bins: -77.3, amplitude: 300.0, phase: 2.0 };
    let mut pairs = pairs::<1024>(&mut rng(909, 0), line, 1.0, channels);
    // Also codes whose middle is half a code off.
    for (codes, middle) in [(CODES, 0), (Codes::unsigned::<12>(), 2048)] {
        pairs.iter_mut().flatten().for_each(|part| *part += middle);
        let whole = Config::new(1.0, codes);
        let lower = Config { codes, ..sideband(1024, false, 3.0) };
        for config in [whole, lower] {
            let tone = measure::<1024, 2048>(&config, &mut pairs).tone;
            assert_eq!(tone.verdict, Verdict::Good);
            assert!((tone.frequency.bins(1024) - line.bins).abs() < 0.001, "{tone:?}");
        }
    }
}

/// Small errors of gain and phase leave good tones; large ones, or a dead channel, have their verdict.
#[test]
fn errors_of_the_channels_make_an_image() {
    let errors = errors::<512, 1024>(910, sized(500, 10_000), [20.0, 40.0], 12.0, |rng| {
        let (gain, phase) = (rng.random_range(0.95..1.05), rng.random_range(-0.05..0.05));
        Channels { gain, phase, ..IDEAL }
    });
    let [sigmas, _, worst] = ratios(&errors);
    println!("gain within 5 %, phase within 3 degrees: {sigmas:.3} sigmas, worst {worst:.1}");
    assert!((0.9..1.1).contains(&sigmas) && worst < 6.0);
    for (gain, phase, image) in [
        (0.0, 0.0, true),
        (0.5, 0.0, true),
        (1.0, 0.5, true),
        (-1.0, 0.1, true),
        (0.9, 0.0, false),
        (1.0, 0.1, false),
    ] {
        for bins in [-480.2, -140.4, -9.3, 4.5, 30.0, 333.3, 505.0] {
            let line = Line { bins, amplitude: 1_000.0, phase: 0.3 };
            let channels = Channels { gain, phase, ..IDEAL };
            let mut pairs = pairs::<1024>(&mut rng(911, 0), line, 3.0, channels);
            // Turned the wrong way round, the stronger line is at minus the frequency.
            let upper = (bins > 0.0) != (gain < 0.0);
            let tone = measure::<1024, 2048>(&sideband(1024, upper, 3.0), &mut pairs).tone;
            let seen = tone.verdict == Verdict::Image;
            let wanted = image && gain >= 0.0;
            assert_eq!(seen, wanted, "{channels:?} {line:?} {tone:?}");
        }
    }
}

#[test]
fn noise_is_no_tone() {
    let seen = trials(912, sized(2_000, 50_000), |rng| {
        let line = Line { bins: 9.0, amplitude: 0.0, phase: 0.0 };
        let mut pairs = pairs::<256>(rng, line, 50.0, IDEAL);
        measure::<256, 512>(&sideband(256, true, 3.0), &mut pairs).tone.verdict
    });
    assert!(seen.iter().all(|verdict| *verdict >= Verdict::Weak));
}

/// What one converter takes by turns of an echo, Q half a pair after I, and what two take at once.
fn echoes<const N: usize>(
    scene: Scene,
    target: &Target,
    segment: usize,
    rng: &mut ChaCha8Rng,
) -> [[[i16; 2]; N]; 2] {
    let config = Config { scene, ..Config::new(2e3, CODES) };
    let twice = echoes::sensor::<Iq>(&config, 2 * N, 0.0);
    let twice = twice.clone().received_by(twice.receiver.with_snr(target.amplitude, 10.0));
    let targets = core::slice::from_ref(target);
    let record = twice.record(targets, (0, segment), || rng.sample(StandardNormal));
    let pairs = record.as_chunks::<2>().0;
    let by_turns = std::array::from_fn(|n| [pairs[n][0][0], pairs[n][1][1]]);
    [by_turns, std::array::from_fn(|n| pairs[n][0])]
}

/// A velocity has its sign, and beats of a chirp theirs.
#[test]
fn the_sign_reaches_the_solver() {
    for mixing in Mixing::ALL {
        let scene = Scene::Doppler { wavelength_m: 0.01, angle_rad: 0.0, mixing };
        for wanted in [-0.59, 0.59] {
            let target = Target::moving(900.0, 5.0, wanted);
            let [mut pairs, _] = echoes::<512>(scene, &target, 0, &mut rng(913, 0));
            let upper = (wanted > 0.0) == (mixing == Mixing::RxConjTx);
            let config = Config { scene, rate_hz: 1e3, ..sideband(512, upper, 3.0) };
            let config = Config { band_hz: None, ..config };
            let Outcome::Velocity(velocity) = measure::<512, 1024>(&config, &mut pairs).result
            else {
                panic!("no velocity");
            };
            let error = velocity.velocity.to_num::<f64>() - wanted;
            assert!(error.abs() < 6.0 * f64::from(velocity.sigma), "{velocity:?}");
        }
        // The beats of a triangle, all of one sign, which real samples would take for another target's.
        let chirp = Chirp {
            shape: Shape::Triangle,
            wavelength_m: 0.0125,
            bandwidth_hz: 50e6,
            duration_s: 0.52,
            guard_s: 0.004,
            mixing,
            ..Chirp::default()
        };
        let scene = Scene::Chirp(chirp);
        let config = Config { scene, ..Config::new(1e3, CODES) };
        let mut turns = Alternating::<512, 1024>::new(config.plan().unwrap());
        let mut at_once = Pipeline::<Iq, 512>::new(config.plan().unwrap());
        let timing = Timing { period: 520, segments: chirp.shape.segments() };
        let target = Target::moving(900.0, 24.0, 0.25);
        let mut targets = Vec::new();
        for number in 0..2 {
            let stamp = timing.stamp(number, false);
            let rng = &mut rng(914, number);
            let [mut pairs, both] = echoes::<512>(scene, &target, number as usize, rng);
            let first = turns.block(&stamp, &mut pairs);
            targets.push([first.result, at_once.block(&stamp, &both).result]);
        }
        let [Outcome::Target(turns), Outcome::Target(at_once)] = targets[1] else {
            panic!("no target")
        };
        println!("{turns:?}");
        let middle_s = echoes::sensor::<Iq>(&config, 512, 0.0).middle_s();
        for seen in [turns, at_once] {
            assert_eq!((seen.ambiguity, seen.verdict), (Ambiguity::None, Verdict::Good));
            let off =
                |a: I32F32, b: f64, sigma: f32| (a.to_num::<f64>() - b).abs() / f64::from(sigma);
            assert!(off(seen.range, target.range_m(middle_s), seen.sigma_range) < 6.0, "{seen:?}");
            assert!(off(seen.velocity.unwrap(), 0.25, seen.sigma_velocity) < 6.0, "{seen:?}");
        }
    }
}

#[test]
fn a_method_for_pairs_alone_becomes_least_squares() {
    assert!(!Alternating::<64, 128>::fits(Method::Autocorrelation));
    assert!(Alternating::<64, 128>::fits(Method::LeastSquares));
    let line = Line { bins: -20.3, amplitude: 900.0, phase: 0.0 };
    let mut pairs = pairs::<256>(&mut rng(916, 0), line, 2.0, IDEAL);
    let usual = measure::<256, 512>(&sideband(256, false, 3.0), &mut pairs);
    let config = Config { method: Method::Autocorrelation, ..sideband(256, false, 3.0) };
    assert_eq!(measure::<256, 512>(&config, &mut pairs), usual);
}
