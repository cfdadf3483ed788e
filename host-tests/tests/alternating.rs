//! I/Q pairs that one converter takes by turns, Q half a pair after I: without an image of their delay, and with a sign. That they are right
//! is in `claims/tests/faults.rs`.

use fixed::types::I32F32;
use picket_claims::samples;
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::{Ambiguity, Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::{Alternating, Codes, Iq, Measurement, Method, Outcome, Pipeline, Stamp, Verdict};
use picket_host::scenario;
use picket_simulator::Run;
use picket_simulator::scene::{Source, Target};
use std::f64::consts::TAU;

const CODES: Codes = Codes::signed::<12>();

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

/// The record of an echo: what one converter takes by turns, Q half a pair after I, or what two take at once.
fn run(config: &Config, target: &Target, by_turns: bool) -> Run {
    let sensor = scenario::sensor::<Iq>(config, 512, 0.0, 1);
    let mut scene = scenario::before(sensor, vec![Source::Target(target.clone())], 10.0);
    scene.receiver.q_late_s = if by_turns { -0.5 / config.rate_hz } else { 0.0 }.into();
    scene.run(913).unwrap()
}

/// A velocity has its sign, and beats of a chirp theirs.
#[test]
fn the_sign_reaches_the_solver() {
    for mixing in Mixing::ALL {
        let scene = Scene::Doppler { wavelength_m: 0.01, angle_rad: 0.0, mixing };
        let config = Config { scene, ..Config::new(1e3, CODES) };
        for wanted in [-0.59, 0.59] {
            let target = scenario::echo(900.0, 5.0, wanted);
            let mut pairs = samples::<Iq, 512>(&mut run(&config, &target, true), 0);
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
        let config = Config { scene: Scene::Chirp(chirp), ..config };
        let target = scenario::echo(900.0, 24.0, 0.25);
        let mut turns = Alternating::<512, 1024>::new(config.plan().unwrap());
        let mut at_once = Pipeline::<Iq, 512>::new(config.plan().unwrap());
        let timing = Timing { period: 520, segments: chirp.shape.segments() };
        let mut runs = [true, false].map(|by_turns| run(&config, &target, by_turns));
        let results = [0, 1].map(|number| {
            let stamp = timing.stamp(number, false);
            let [mut pairs, both] =
                runs.each_mut().map(|run| samples::<Iq, 512>(run, number as usize));
            [turns.block(&stamp, &mut pairs).result, at_once.block(&stamp, &both).result]
        });
        let [Outcome::Target(turns), Outcome::Target(at_once)] = results[1] else {
            panic!("no target")
        };
        println!("{turns:?}");
        let range_m = runs[0].truth_of_lap(0, 0, 512).range_m.unwrap();
        for seen in [turns, at_once] {
            assert_eq!((seen.ambiguity, seen.verdict), (Ambiguity::None, Verdict::Good));
            let off =
                |a: I32F32, b: f64, sigma: f32| (a.to_num::<f64>() - b).abs() / f64::from(sigma);
            assert!(off(seen.range, range_m, seen.sigma_range) < 6.0, "{seen:?}");
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
