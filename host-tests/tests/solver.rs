//! The chirp solver: exact on the paper's rows, equal to weighted least squares, honest sigmas.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::{self, Ambiguity, Mixing, Scale, Shape};
use picket_dsp::solve::equations::{Chirp, Equations};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::{Tone, Verdict};
use picket_host::scenario::{self, Row};
use picket_simulator::Draw;
use proptest::prelude::*;

const N: usize = 1024;

/// The lidar's chirp, real or with either mixing, its rate, and its equations.
fn lidar(mixing: Option<Mixing>) -> (Chirp, f64, Equations) {
    let Scene::Chirp(chirp) = scenario::lidar().scene else { panic!("the lidar has a chirp") };
    let chirp = Chirp { mixing: mixing.unwrap_or_default(), ..chirp };
    let rate_hz = scenario::lidar().rate_hz;
    (chirp, rate_hz, chirp.equations(rate_hz, N, mixing.is_some()).unwrap())
}

fn equations() -> Equations {
    lidar(None).2
}

/// The beats of a target in the segments of a chirp, signed cycles per sample, from the phases of its records. The row is that of the chirp's
/// middle.
fn beats(chirp: &Chirp, rate_hz: f64, row: &Row) -> Vec<f64> {
    let scene = Scene::Chirp(*chirp);
    let config = Config { scene, ..Config::new(rate_hz, Codes::signed::<12>()) };
    let sensor = scenario::sensor::<Iq>(&config, N, 0.0, 1);
    let run = row.scene(&sensor, N, (1.0, 0.0), None).run(0).unwrap();
    let beat = |segment| run.truth(0, sensor.start_s(segment, N), N).frequency_hz / rate_hz;
    (0..sensor.segments()).map(beat).collect()
}

fn tone(cycles: f64, sigma: f32) -> Tone {
    Tone {
        frequency: Frequency::from_bins(0, cycles, 1).unwrap(),
        sigma,
        verdict: Verdict::Good,
        ..Tone::default()
    }
}

/// The three tones of a row, from the phases of its simulated records: magnitudes where the samples are real.
fn tones(row: &Row, mixing: Option<Mixing>, sigmas: [f32; 3]) -> [Tone; 3] {
    let (chirp, rate_hz, _) = lidar(mixing);
    let beats = beats(&chirp, rate_hz, row);
    std::array::from_fn(|i| {
        tone(if mixing.is_some() { beats[i] } else { beats[i].abs() }, sigmas[i])
    })
}

/// Real samples, and I/Q samples of both mixings.
const RECEIVERS: [Option<Mixing>; 3] = [None, Some(Mixing::TxConjRx), Some(Mixing::RxConjTx)];

fn close(got: fixed::types::I32F32, truth: f64) -> bool {
    (got.to_num::<f64>() - truth).abs() <= 1e-6 * truth.abs()
}

#[test]
fn every_row_of_both_signs_is_exact_without_noise() {
    let rows = scenario::table3();
    assert_eq!(rows.len(), 28);
    for row in rows {
        for mixing in RECEIVERS {
            let (.., equations) = lidar(mixing);
            let tones = tones(&row, mixing, [1e-6; 3]);
            let target = chirp::trapezoid(&tones, mixing.is_some(), &equations);
            assert!(close(target.range, row.range_m), "{row:?}: {target:?}");
            assert!(close(target.velocity.unwrap(), row.velocity_mps), "{row:?}: {target:?}");
            assert_eq!(target.verdict, Verdict::Good);
        }
    }
}

#[test]
fn a_triangle_reports_the_exchange() {
    for row in scenario::table3() {
        for mixing in RECEIVERS {
            // The ramps of a trapezoid are a triangle whose equations know of the time between them.
            let (.., equations) = lidar(mixing);
            let [up, _, down] = tones(&row, mixing, [1e-6; 3]);
            let target = chirp::triangle(&[up, down], mixing.is_some(), &equations);
            let right =
                |range, velocity| close(range, row.range_m) && close(velocity, row.velocity_mps);
            let first = right(target.range, target.velocity.unwrap());
            match target.ambiguity {
                Ambiguity::Several(candidates) => {
                    let one = candidates.iter().any(|c| right(c.range, c.velocity));
                    assert!(mixing.is_none() && one, "{row:?}: {target:?}");
                    assert_eq!((candidates.len(), target.verdict), (2, Verdict::Ambiguous));
                }
                ambiguity => {
                    assert!(mixing.is_some() && first, "{row:?}: {target:?}");
                    assert_eq!((ambiguity, target.verdict), (Ambiguity::None, Verdict::Good));
                }
            }
        }
    }
}

/// The chirp of physics alone: 24 GHz, 30 m, 3 m/s. The wrong mixing puts the target behind the receiver.
#[test]
fn a_wrong_mixing_is_never_good() {
    for (shape, mixing) in [Shape::Triangle, Shape::Trapezoid]
        .into_iter()
        .flat_map(|shape| Mixing::ALL.map(|mixing| (shape, mixing)))
    {
        let solved = |set: Mixing| {
            let chirp =
                Chirp { shape, mixing, duration_s: 1.1e-3, guard_s: 0.04e-3, ..Chirp::default() };
            let equations = Chirp { mixing: set, ..chirp }.equations(1e6, N, true).unwrap();
            let beats = beats(&chirp, 1e6, &Row { range_m: 30.0, velocity_mps: 3.0 });
            let tone = |segment: usize| tone(beats[segment], 1e-6);
            if shape == Shape::Triangle {
                chirp::triangle(&[tone(0), tone(1)], true, &equations)
            } else {
                chirp::trapezoid(&[tone(0), tone(1), tone(2)], true, &equations)
            }
        };
        let other = Mixing::ALL.into_iter().find(|other| *other != mixing).unwrap();
        let (right, wrong) = (solved(mixing), solved(other));
        assert!(close(right.range, 30.0) && close(right.velocity.unwrap(), 3.0), "{right:?}");
        assert_eq!((right.verdict, right.ambiguity), (Verdict::Good, Ambiguity::None));
        assert!(wrong.range < 0 && wrong.verdict == Verdict::Unresolved, "{wrong:?}");
    }
}

#[test]
fn a_sawtooth_reports_the_coupling() {
    let target = chirp::sawtooth(&tone(0.1, 1e-5), false, &equations());
    assert_eq!(target.ambiguity, Ambiguity::Coupled);
    assert!(close(target.range, 0.1 * equations().range[0].fixed.to_num::<f64>()));
    assert_eq!((target.velocity, target.sigma_velocity), (None, f32::INFINITY));
    assert_eq!(target.verdict, Verdict::Ambiguous);
}

#[test]
fn beats_of_two_targets_are_unresolved() {
    let row = Row { range_m: 50.0, velocity_mps: 10.0 };
    let mut beats = tones(&row, None, [1e-5; 3]);
    beats[1] = tone(0.33, 1e-5);
    assert_eq!(chirp::trapezoid(&beats, false, &equations()).verdict, Verdict::Unresolved);
    beats[1].verdict = Verdict::Weak;
    assert_eq!(chirp::trapezoid(&beats, false, &equations()).verdict, Verdict::Weak);
}

#[test]
fn a_flat_beat_that_is_not_seen_is_a_slow_targets() {
    for mixing in RECEIVERS {
        for velocity_mps in [0.0, 0.001, 10.0] {
            let row = Row { range_m: 50.0, velocity_mps };
            let mut beats = tones(&row, mixing, [1e-5; 3]);
            let (.., equations) = lidar(mixing);
            beats[1] = Tone { verdict: Verdict::Weak, ..tone(0.33, 1e-3) };
            let target = chirp::trapezoid(&beats, mixing.is_some(), &equations);
            let wanted = if velocity_mps < 1.0 { Verdict::Good } else { Verdict::Weak };
            assert_eq!(target.verdict, wanted, "{mixing:?} {velocity_mps} m/s: {target:?}");
            if wanted == Verdict::Good {
                let off = (target.range.to_num::<f64>() - 50.0).abs();
                assert!(off < 5.0 * f64::from(target.sigma_range), "{target:?}");
            }
        }
    }
}

/// The textbook way: normal equations for each sign pattern, least weighted residual. Returns (fR, fD).
fn normal_equations(magnitudes: [f64; 3], sigmas: [f32; 3]) -> (f64, f64) {
    let w = sigmas.map(|s| 1.0 / f64::from(s).powi(2));
    let patterns = [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, -1.0]];
    let solve = |signs: &[f64; 3]| {
        let y: [f64; 3] = std::array::from_fn(|i| signs[i] * magnitudes[i]);
        let (m11, m12, m22) = (w[0] + w[2], w[2] - w[0], w[0] + w[1] + w[2]);
        let (r1, r2) = (w[0] * y[0] + w[2] * y[2], -w[0] * y[0] + w[1] * y[1] + w[2] * y[2]);
        let det = m11 * m22 - m12 * m12;
        let (range, doppler) = ((r1 * m22 - r2 * m12) / det, (m11 * r2 - m12 * r1) / det);
        let residual = w[0] * (y[0] - range + doppler).powi(2)
            + w[1] * (y[1] - doppler).powi(2)
            + w[2] * (y[2] - range - doppler).powi(2);
        (if range < 0.0 { f64::INFINITY } else { residual }, range, doppler)
    };
    let (_, range, doppler) =
        patterns.iter().map(solve).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    (range, doppler)
}

/// One carrier and a range that stands still, `fR - fD, -fD, -(fR + fD)`: a kilometre and a kilometre per second a cycle per sample.
fn one_carrier() -> Equations {
    let scales = |weights: [f64; 2]| weights.map(|weight| Scale::new(weight).unwrap());
    Equations {
        edge: 0.0,
        shape: Shape::Trapezoid,
        range: scales([500.0, -500.0]),
        velocity: scales([-500.0; 2]),
        condition: scales([-2.0, 1.0]),
        ..Equations::default()
    }
}

proptest! {
    #[test]
    fn equals_weighted_least_squares(
        range in 0.01f64..0.3,
        doppler in -0.2f64..0.2,
        errors in prop::array::uniform3(-3e-5f64..3e-5),
        sigmas in prop::array::uniform3(1e-6f32..1e-4),
    ) {
        let beats = [range - doppler, doppler, range + doppler];
        prop_assume!(beats.iter().all(|b| b.abs() > 2e-3 && b.abs() < 0.49));
        let magnitudes: [f64; 3] = std::array::from_fn(|i| (beats[i] + errors[i]).abs());
        let tones = std::array::from_fn(|i| tone(magnitudes[i], sigmas[i]));
        let target = chirp::trapezoid(&tones, false, &one_carrier());
        let (want_range, want_doppler) = normal_equations(magnitudes, sigmas);
        let got_range = target.range.to_num::<f64>() / 1e3;
        let got_doppler = target.velocity.unwrap().to_num::<f64>() / 1e3;
        let got_range = got_range * (1.0 + 2e3 * got_doppler / picket_dsp::config::SPEED_OF_LIGHT);
        // Two steps of the frequency's type, and f32's share of the correction.
        prop_assert!((got_range - want_range).abs() < 1e-9, "{got_range} {want_range}");
        prop_assert!((got_doppler - want_doppler).abs() < 1e-9, "{got_doppler} {want_doppler}");
    }
}

#[test]
fn sigmas_explain_the_errors() {
    println!("seed 11");
    let mut draw = Draw::new(11, 0);
    let row = Row { range_m: 50.0, velocity_mps: 10.0 };
    for sigmas in [[3e-5f32; 3], [1e-5, 4e-5, 2e-5]] {
        let trials = 20_000;
        let (mut range, mut velocity) = (0.0, 0.0);
        for _ in 0..trials {
            let mut beats = tones(&row, None, sigmas);
            for (beat, sigma) in beats.iter_mut().zip(sigmas) {
                *beat = tone(beat.frequency.cycles() + draw.normal() * f64::from(sigma), sigma);
            }
            let target = chirp::trapezoid(&beats, false, &equations());
            let square = |got: fixed::types::I32F32, truth: f64, sigma: f32| {
                ((got.to_num::<f64>() - truth) / f64::from(sigma)).powi(2)
            };
            range += square(target.range, row.range_m, target.sigma_range);
            velocity += square(target.velocity.unwrap(), row.velocity_mps, target.sigma_velocity);
        }
        // Mean of 20,000 squares of a unit normal: 1 +- 0.01.
        for mean in [range, velocity].map(|sum| sum / f64::from(trials)) {
            assert!((mean - 1.0).abs() < 0.04, "{sigmas:?}: {mean}");
        }
    }
}

#[test]
fn configuration_errors_are_found() {
    use picket_dsp::config::ConfigError;
    let good = scenario::lidar();
    let check = |config: Config| config.plan::<Real, N>().err();
    assert_eq!(check(good), None);
    assert_eq!(check(Config { rate_hz: 0.0, ..good }), Some(ConfigError::Rate));
    assert_eq!(check(Config { rate_hz: f64::NAN, ..good }), Some(ConfigError::Rate));
    assert_eq!(check(Config { band_hz: Some((1e6, 1e6)), ..good }), Some(ConfigError::Band));
    assert_eq!(check(Config { band_hz: Some((0.0, 126e6)), ..good }), Some(ConfigError::Band));
    assert_eq!(check(Config { band_hz: Some((1.0, 2.0)), ..good }), Some(ConfigError::Band));
    assert_eq!(check(Config { rate_hz: 90e6, ..good }), Some(ConfigError::Ramp));
    for bound in [(5.0, -5.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert_eq!(check(Config { velocity_mps: Some(bound), ..good }), Some(ConfigError::Bounds));
        assert_eq!(check(Config { range_m: Some(bound), ..good }), Some(ConfigError::Bounds));
    }
    let still = Scene::Doppler {
        wavelength_m: 1e-6,
        angle_rad: std::f64::consts::FRAC_PI_2,
        mixing: Mixing::RxConjTx,
    };
    assert_eq!(check(Config { scene: still, ..good }), Some(ConfigError::Scene));
    let wide = Scene::Doppler { wavelength_m: 1e6, angle_rad: 0.0, mixing: Mixing::RxConjTx };
    assert_eq!(check(Config { scene: wide, ..good }), Some(ConfigError::Scale));
}
