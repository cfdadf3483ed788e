//! I/Q pairs that one converter takes by turns, Q half a pair after I: without an image of their delay, and with a sign. That they are right
//! is in `claims/tests/faults.rs`.

use crate::signal::*;
use fixed::types::I32F32;
use host_tests::echoes;
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

/// Pairs of a tone.
fn pairs<const N: usize>(bins: f64, amplitude: f64, start: f64) -> [[i16; 2]; N] {
    let turn = |n: f64| TAU * bins * n / N as f64 + start;
    std::array::from_fn(|n| {
        let [i, q] = [turn(n as f64).cos(), turn(n as f64 + 0.5).sin()];
        [i, q].map(|part| (amplitude * part).round() as i16)
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

/// Ideal channels, whole cycles: what lies at minus the frequency is the transform's own.
#[test]
fn ideal_channels_leave_no_image() {
    let mut worst = f64::NEG_INFINITY;
    for bins in [-500i32, -256, -101, -3, 3, 17, 255, 444] {
        let mut pairs = pairs::<1024>(f64::from(bins), 32_000.0, 0.4);
        let config = Config { codes: Codes::signed::<16>(), ..sideband(1024, bins > 0, 3.0) };
        let mut pipeline = Alternating::<1024, 2048>::new(config.plan().unwrap());
        pipeline.block(&Stamp::default(), &mut pairs);
        let power = |bins: i32| pipeline.spectrum().power(512 + bins) as f64;
        worst = worst.max(10.0 * (power(-bins) / power(bins)).log10());
    }
    println!("image at most {worst:.1} dB");
    assert!(worst < -90.0, "{worst}");
    // As if both were taken at once: docs/pico.md has it for the middle of a sideband.
    let pairs = pairs::<1024>(256.0, 30_000.0, 0.0);
    let mut pipeline =
        Pipeline::<Iq, 1024>::new(Config::new(1.0, Codes::signed::<16>()).plan().unwrap());
    pipeline.block(&Stamp::default(), &pairs);
    let power = |bins: i32| pipeline.spectrum().power(bins) as f64;
    let image = 10.0 * (power(-256) / power(256)).log10();
    assert!((image + 7.66).abs() < 0.01, "{image}");
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
    let mut pairs = pairs::<256>(-20.3, 900.0, 0.0);
    let usual = measure::<256, 512>(&sideband(256, false, 3.0), &mut pairs);
    let config = Config { method: Method::Autocorrelation, ..sideband(256, false, 3.0) };
    assert_eq!(measure::<256, 512>(&config, &mut pairs), usual);
}
