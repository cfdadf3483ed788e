//! I/Q pairs that the converter takes by turns: records that are the host's, and no fault that swaps I and Q.

use super::faults::{Blocks, EACH, any, play};
use super::scene::{expected, frames, measure, plug, record, set_plan, status};
use host_tests::sized;
use picket_claims::scenes::{Kind, line, tones};
use picket_dsp::config::{Config, Scene};
use picket_dsp::{Chirp, Iq, Mixing, Outcome, Shape, Verdict};
use picket_firmware::pico::N;
use picket_firmware::pico::words::Words;
use picket_host::pico::bench::Pico;
use picket_host::pico::converter::Converter;
use picket_host::scenario;
use picket_simulator::Run;
use picket_simulator::scene::{Source, Tone};
use picket_wire::settings::{Drive, Settings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pairs at the fastest rate, of one sideband.
fn settings(upper: bool) -> Settings {
    let settings = Settings::default();
    let band_hz = Some(if upper { (1e3, 125e3) } else { (-125e3, -1e3) });
    Settings { iq: true, config: Config { rate_hz: 250e3, band_hz, ..settings.config }, ..settings }
}

/// Blocks one after the other, each with a tone of its own: what both inputs have at each conversion, and the tones in bins.
fn stream(blocks: usize, upper: bool, seed: u64) -> (Vec<[i16; 2]>, Vec<f64>) {
    let bins = if upper { 8.0..504.0 } else { -504.0..-8.0 };
    let tone = Tone { amplitude: Some((100.0..1600.0).into()), ..line(bins, 1.0) };
    let mut scene = tones(Kind::Iq, 2 * N, [tone], 0.0);
    (scene.seed, scene.receiver.offset) = (seed, [2048.0.into(), 2048.0.into()]);
    scene.receiver.noise.rms = Some((0.5..8.0).into());
    let (mut samples, mut tones) = (Vec::new(), Vec::new());
    for block in 0..blocks as u64 {
        let mut run = scene.run(block).unwrap();
        samples.extend(read(&mut run, 2 * N));
        tones.push(run.truth(0, 0.0, 2 * N).frequency_hz);
    }
    (samples, tones)
}

/// What the converter reads of a run's voltages.
fn read(run: &mut Run, n: usize) -> impl Iterator<Item = [i16; 2]> {
    let converter = Converter::default();
    run.voltages(0.0, n).into_iter().map(move |both| both.map(|part| converter.code(part)))
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
        let twice = Config { rate_hz: 2.0 * used.rate_hz, ..used };
        let radar = scenario::sensor::<Iq>(&twice, 2 * N, 0.0, 1);
        let target = Source::Target(scenario::echo(900.0, 15.0..250.0, -12.0..12.0));
        let mut scene = scenario::before(radar, vec![target], 30.0);
        scene.receiver.offset = [140.0.into(), (-90.0).into()];
        let (mut samples, mut truths) = (Vec::new(), Vec::new());
        for chirp in 0..blocks / 3 {
            samples.extend(scene.codes(chirp).unwrap());
            truths.push(scenario::place(&scene.run(chirp).unwrap().truth_of_lap(0, 0, 2 * N)));
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
    let n = 2 * N * blocks;
    let mut scene = tones(Kind::Iq, n, [line((100 * blocks + 37) as f64, 600.0)], 4.0);
    (scene.seed, scene.receiver.offset) = (seed, [2_900.0.into(), 1_200.0.into()]);
    read(&mut scene.run(0).unwrap(), n).collect()
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
