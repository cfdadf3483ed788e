//! I/Q pairs that the converter takes by turns: records that are the host's, and no fault that swaps I and Q.

use super::faults::{Blocks, EACH, any, play};
use super::scene::{expected, frames, measure, plug, record, set_plan, status};
use host_tests::{echoes, sized};
use picket_dsp::config::{Config, Scene};
use picket_dsp::{Chirp, Iq, Mixing, Outcome, Shape, Verdict};
use picket_firmware::pico::N;
use picket_firmware::pico::words::Words;
use picket_host::pico::bench::Pico;
use picket_host::pico::converter::Converter;
use picket_simulator::{Receiver, Target};
use picket_wire::settings::{Drive, Settings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;

/// Pairs at the fastest rate, of one sideband.
fn settings(upper: bool) -> Settings {
    let settings = Settings::default();
    let band_hz = Some(if upper { (1e3, 125e3) } else { (-125e3, -1e3) });
    Settings { iq: true, config: Config { rate_hz: 250e3, band_hz, ..settings.config }, ..settings }
}

/// Blocks one after the other, each with a tone of its own: what both inputs have at each conversion, and the tones in bins.
fn stream(blocks: usize, upper: bool, seed: u64) -> (Vec<[i16; 2]>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let converter = Converter::default();
    let mut samples = Vec::with_capacity(2 * N * blocks);
    let mut tones = Vec::new();
    for _ in 0..blocks {
        let (bins, phase) = (rng.random_range(8.0..504.0), rng.random_range(0.0..TAU));
        let bins = if upper { bins } else { -bins };
        let amplitude = 10f64.powf(rng.random_range(2.0..3.2));
        let noise = Normal::new(0.0, rng.random_range(0.5..8.0)).unwrap();
        for n in 0..2 * N {
            let turn = TAU * bins * n as f64 / (2 * N) as f64 + phase;
            samples
                .push([turn.cos(), turn.sin()].map(|part| {
                    converter.code(2048.0 + amplitude * part + noise.sample(&mut rng))
                }));
        }
        tones.push(bins);
    }
    (samples, tones)
}

/// What the converter takes of both inputs: I, Q, I, Q.
fn taken(samples: &[[i16; 2]]) -> Vec<i16> {
    samples.iter().enumerate().map(|(n, both)| both[n % 2]).collect()
}

/// A board that measures pairs.
fn measuring(samples: &[[i16; 2]], upper: bool) -> Pico {
    let mut pico = plug();
    pico.power().unwrap();
    set_plan(&mut pico, settings(upper), |pico| {
        pico.both(samples).unwrap();
        pico.keep(2 * N).unwrap();
    });
    pico
}

/// Gapless at 250 kS/s of pairs, in both sidebands.
#[test]
fn every_record_of_pairs_is_the_hosts() {
    let blocks = sized(60, 2_500);
    for (upper, seed) in [(true, 61), (false, 62)] {
        let (samples, tones) = stream(blocks as usize, upper, seed);
        let mut pico = measuring(&samples, upper);
        pico.zero().unwrap();
        measure(&mut pico, blocks);
        let wanted = expected(&settings(upper), &taken(&samples));
        let records = frames(&pico.sent);
        for ((sequence, frame), number) in records.iter().zip(0..) {
            assert_eq!(*sequence, number, "lost before block {number}, seed {seed}");
            let block = number as usize % wanted.len();
            let pair = [frame, &wanted[block]].map(|frame| record(frame));
            assert!(*frame == wanted[block], "block {number} differs, seed {seed}: {pair:#?}");
            let tone = pair[0].unwrap().measurement.tone;
            let error = (tone.frequency.bins(N) - tones[block]).abs();
            assert!(error < 6.0 * f64::from(tone.sigma) * N as f64, "{tone:?}, seed {seed}");
            assert!(tone.verdict <= Verdict::Moving, "{tone:?}, seed {seed}");
        }
        assert!(records.len() as u64 >= blocks);
        let (figures, status) = (pico.figures().unwrap(), status(&mut pico));
        println!(
            "{} records of pairs byte for byte, load {:.1} %, longest {} us of 4096, seed {seed}",
            records.len(),
            100.0 * figures.load(),
            status.longest
        );
        assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0));
        assert!(status.longest < 3_600, "{status:?}");
        assert!(
            figures.load() <= 0.83 && figures.level <= 2 && figures.overruns == 0,
            "{figures:?}"
        );
    }
}

/// A chirp's echoes beat on both sides of 0 Hz, beside the inputs' offsets: records that are the host's, and the right targets.
#[test]
fn chirps_of_pairs_have_their_ranges_and_velocities() {
    let blocks = sized(30, 900);
    for mixing in Mixing::ALL {
        let scene = Scene::Chirp(Chirp {
            shape: Shape::Trapezoid,
            wavelength_m: 0.0125,
            bandwidth_hz: 200e6,
            duration_s: 1.0,
            mixing,
            ..Chirp::default()
        });
        let config = Config { band_hz: None, scene, ..settings(true).config };
        let settings =
            Settings { config, drive: Drive::Dac { low: 300, high: 3800 }, ..settings(true) };
        let (plan, _) = Words::plan(&settings).unwrap();
        let used = plan.settings.config;
        // Each conversion is half a pair after the one before.
        let radar =
            echoes::sensor::<Iq>(&Config { rate_hz: 2.0 * used.rate_hz, ..used }, 2 * N, 0.0);
        let receiver = Receiver { offset: [140.0, -90.0], ..radar.receiver.with_snr(900.0, 30.0) };
        let radar = radar.received_by(receiver);
        let mut rng = ChaCha8Rng::seed_from_u64(64);
        let (mut samples, mut truths) = (Vec::new(), Vec::new());
        for _ in 0..blocks / 3 {
            let (range_m, velocity_mps) =
                (rng.random_range(15.0..250.0), rng.random_range(-12.0..12.0));
            let target = Target::moving(900.0, range_m, velocity_mps).turned(rng.random());
            let targets = core::slice::from_ref(&target);
            for segment in 0..radar.segments() {
                samples.extend(echoes::codes::<Iq>(&radar, targets, (0, segment), &mut rng));
            }
            truths.push([target.range_m(radar.middle_s()), velocity_mps]);
        }
        let mut pico = plug();
        pico.power().unwrap();
        set_plan(&mut pico, settings, |pico| pico.both(&samples).unwrap());
        pico.zero().unwrap();
        measure(&mut pico, blocks);
        let wanted = expected(&settings, &taken(&samples));
        let records = frames(&pico.sent);
        let mut found = 0;
        for ((sequence, frame), number) in records.iter().zip(0..) {
            assert_eq!(*sequence, number, "lost before block {number}");
            let number = number as usize % wanted.len();
            assert!(*frame == wanted[number], "block {number} differs");
            let Outcome::Target(target) = record(frame).unwrap().measurement.result else {
                continue;
            };
            assert!(target.verdict <= Verdict::Moving, "block {number}: {target:?}");
            let [range_m, velocity_mps] = truths[number / 3];
            let off = |value: f64, truth: f64, sigma: f32| (value - truth).abs() / f64::from(sigma);
            let range = off(target.range.to_num(), range_m, target.sigma_range);
            let velocity =
                off(target.velocity.unwrap().to_num(), velocity_mps, target.sigma_velocity);
            assert!(range < 6.0 && velocity < 6.0, "{target:?} at {range_m} m, {velocity_mps} m/s");
            found += 1;
        }
        let load = 100.0 * pico.figures().unwrap().load();
        println!("{}: {found} targets, load {load:.1} %", mixing.name());
        assert!(found >= blocks / 3 - 1);
    }
}

/// Two tones of one frequency, I above the middle and Q below, so that each code tells its input: without a jump, since they come
/// again and again.
fn steady(blocks: usize, seed: u64) -> Vec<[i16; 2]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let step = TAU * (100 * blocks + 37) as f64 / (2 * N * blocks) as f64;
    let (converter, noise) = (Converter::default(), Normal::new(0.0, 4.0).unwrap());
    let each = (0..2 * N * blocks).map(|n| {
        let turn = step * n as f64;
        let parts = [(2_900.0, turn.cos()), (1_200.0, turn.sin())];
        parts.map(|(middle, part)| converter.code(middle + 600.0 * part + noise.sample(&mut rng)))
    });
    each.collect()
}

/// After every fault the first of a pair is I, and no record is of a mixed block.
#[test]
fn no_fault_swaps_i_and_q() {
    let mut rng = ChaCha8Rng::seed_from_u64(63);
    for seed in 0..sized(2, 25) {
        let faults = match seed {
            0 => EACH.map(|fault| (18_300.0, fault)).to_vec(),
            _ => {
                let mut faults = Vec::new();
                for _ in 0..sized(20, 40) {
                    faults.push((rng.random_range(8_000.0..18_000.0), any(&mut rng)));
                }
                faults
            }
        };
        let pico = measuring(&steady(300, seed), true);
        let blocks = Blocks { settings: settings(true), nanos: 4_096_000.0, conversions: 2 * N };
        let delivered = play((pico, blocks), &faults, seed);
        let starts = delivered.last().unwrap().starts - delivered[0].starts;
        assert!(starts > 0.0, "no fault started the samples anew, seed {seed}");
        for (number, block) in delivered.iter().enumerate() {
            let swapped = block.samples.as_chunks().0.iter().any(|&[i, q]| i < 2_048 || q >= 2_048);
            assert!(!swapped, "block {number}, seed {seed}");
        }
    }
}
