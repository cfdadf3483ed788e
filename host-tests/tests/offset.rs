//! I/Q tones beside the channels' offsets: measured from 1.5 bins of 0 Hz on, taken at once or by turns, and never told nearer.

use crate::signal::*;
use host_tests::sized;
use picket_dsp::spectrum::engine::{Engine, F32, I32};
use picket_dsp::{Alternating, Codes, Config, Iq, Pipeline, Stamp, Tone, Usable, Verdict};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// Who takes a pair's Q.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Taken {
    AtOnce,
    /// Half a pair after I.
    ByTurns,
}

const AMPLITUDE: f64 = 300.0;

/// A tone at so many bins, beside an offset in codes in a direction of its own.
fn measured<const N: usize, const TWICE: usize>(
    taken: Taken,
    (bins, snr_db, offset): (f64, f64, f64),
    rng: &mut ChaCha8Rng,
) -> Tone {
    let (phase, way) = (rng.random_range(0.0..TAU), rng.random_range(0.0..TAU));
    let noise = sigma(AMPLITUDE, snr_db);
    let late = if taken == Taken::ByTurns { 0.5 } else { 0.0 };
    let mut pairs: [[i16; 2]; N] = std::array::from_fn(|n| {
        let turn = |n: f64| TAU * bins * n / N as f64 + phase;
        let parts = [turn(n as f64).cos(), turn(n as f64 + late).sin()];
        let offsets = [way.cos(), way.sin()];
        [0, 1].map(|i| {
            let noise = noise * rng.sample::<f64, _>(StandardNormal);
            quantise(AMPLITUDE * parts[i] + offset * offsets[i] + noise)
        })
    });
    let plan = Config { band_hz: Some((-0.45, 0.45)), ..Config::new(1.0, CODES) }.plan().unwrap();
    match taken {
        Taken::AtOnce => Pipeline::<Iq, N>::new(plan).block(&Stamp::default(), &pairs).tone,
        Taken::ByTurns => {
            Alternating::<N, TWICE>::new(plan).block(&Stamp::default(), &mut pairs).tone
        }
    }
}

fn beside_an_offset<const N: usize, const TWICE: usize>(taken: Taken, seed: u64) {
    for offset in [0.0, 20.0, 900.0] {
        for snr_db in [15.0, 30.0, 45.0] {
            let seen = trials(seed, sized(300, 10_000), |rng| {
                let bins = rng.random_range(0.3..12.0f64) * if rng.random() { 1.0 } else { -1.0 };
                (bins, measured::<N, TWICE>(taken, (bins, snr_db, offset), rng))
            });
            // Between both, noise decides.
            let near = seen.iter().filter(|(bins, _)| bins.abs() < 1.2);
            let told =
                near.filter(|(_, tone)| tone.verdict.usable() <= Usable::WithoutSign).count();
            let far: Vec<_> = seen.iter().filter(|(bins, _)| bins.abs() > 1.7).collect();
            let usable: Vec<f64> = far
                .iter()
                .filter(|(_, tone)| tone.verdict.usable() <= Usable::WithinSigma)
                .map(|(bins, tone)| {
                    (tone.frequency.bins(N) - bins) / (f64::from(tone.sigma) * N as f64)
                })
                .collect();
            let share = usable.len() as f64 / far.len() as f64;
            let rms = mean(usable.iter().map(|error| error * error)).sqrt();
            let worst = usable.iter().fold(0.0f64, |worst, error| worst.max(error.abs()));
            println!(
                "{taken:?} N {N}, offset {offset} codes, {snr_db} dB, seed {seed}: usable {share:.3}, rms {rms:.3}, worst {worst:.1}; {told} told beside 0 Hz"
            );
            assert_eq!(told, 0);
            assert!(share > 0.97 && worst < 5.0);
            let error = (0.5 / usable.len() as f64).sqrt();
            assert!((rms - 1.0).abs() < 0.08 + 3.0 * error, "{rms}");
        }
    }
}

#[test]
fn tones_beside_an_offset_are_right_or_near_edge() {
    beside_an_offset::<256, 512>(Taken::AtOnce, 951);
    beside_an_offset::<1024, 2048>(Taken::AtOnce, 952);
    beside_an_offset::<256, 512>(Taken::ByTurns, 953);
    beside_an_offset::<1024, 2048>(Taken::ByTurns, 954);
}

/// What every engine says of I/Q records of unsigned codes without a band: all but the tones beside 0 Hz are good, and none is at the
/// offset.
fn of_unsigned<E: Engine, const N: usize>(name: &str, away: f64) {
    let codes = Codes::unsigned::<12>();
    for (amplitude, snr_db) in [(3.0, 15.0), (30.0, 20.0), (900.0, 40.0)] {
        let seen = trials(961, sized(500, 10_000), |rng| {
            let half = N as f64 / 2.0;
            let bins = rng.random_range(2.0..half) * if rng.random() { 1.0 } else { -1.0 };
            let phase = rng.random_range(0.0..TAU);
            let noise = sigma(amplitude, snr_db);
            let middle = f64::from(codes.middle()) + away;
            let samples: [[i16; 2]; N] = std::array::from_fn(|n| {
                let (sin, cos) = (TAU * bins * n as f64 / N as f64 + phase).sin_cos();
                [cos, sin].map(|part| {
                    let noise = noise * rng.sample::<f64, _>(StandardNormal);
                    (middle + amplitude * part + noise).round() as i16
                })
            });
            let mut pipeline = Pipeline::<Iq, N, E>::new(Config::new(1.0, codes).plan().unwrap());
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let lines = pipeline.lines(&measurement, 4);
            let harmonic = pipeline.harmonic(&measurement, 1);
            let tones = lines.iter().map(|line| line.tone).chain(harmonic.map(|found| found.tone));
            let tones: Vec<Tone> = tones.chain([measurement.tone]).collect();
            (bins, lines.len(), tones)
        });
        let mut good = 0;
        for (bins, lines, tones) in &seen {
            good +=
                u32::from(*lines == 1 && tones.iter().all(|tone| tone.verdict == Verdict::Good));
            for tone in tones.iter().filter(|tone| tone.verdict.usable() <= Usable::WithinSigma) {
                let off = tone.frequency.cycles() - bins / N as f64;
                let sigmas = (off - off.round()).abs() / f64::from(tone.sigma);
                assert!(sigmas < 6.0, "{name} {N}: {tone} at {bins} bins");
            }
        }
        let share = f64::from(good) / seen.len() as f64;
        println!("{name} {N}, amplitude {amplitude}, {away} codes off the middle: {share:.4} good");
        assert!(share >= 0.99);
    }
}

#[test]
fn unsigned_codes_are_measured_alike_by_every_engine() {
    for away in [0.0, 20.0] {
        of_unsigned::<I32, 256>("I32", away);
        of_unsigned::<I32, 1024>("I32", away);
        of_unsigned::<F32, 256>("F32", away);
        of_unsigned::<F32, 1024>("F32", away);
    }
}
