//! Tones that are wide by themselves, a laser's line and speckle: sigma covers them where their width is stated. The records are those of
//! a continuous wave before a moving surface.

use host_tests::sized;
use picket_dsp::accumulate::Accumulator;
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket_dsp::config::{Config, Following};
use picket_dsp::solve::track::State;
use picket_dsp::tracker::Tracker;
use picket_dsp::{Carrier, Codes, Mixing, Pipeline, Tone, Verdict};
use picket_simulator::{Receiver, Speckle, Target, Waveform};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

const SEED: u64 = 410;
const RATE_HZ: f64 = 1e6;
const CARRIER_HZ: f64 = 1.934e14;
/// Blocks after which a track has settled, and all.
const SETTLED: usize = 100;
const BLOCKS: usize = 200;

/// The records of a surface, one after the other, and the frequency of its tone in cycles per sample.
fn records<R: Record, const N: usize>(
    width: Carrier,
    (amplitude, snr_db): (f64, f64),
    blocks: usize,
    seed: u64,
) -> (Vec<Vec<R::Sample>>, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let cycles = rng.random_range(0.04..0.4);
    let velocity = cycles * RATE_HZ * picket_dsp::config::SPEED_OF_LIGHT / (2.0 * CARRIER_HZ);
    let mut target = Target::moving(amplitude, 10.0, velocity).turned(rng.random());
    target.linewidth_hz = width.linewidth_hz.into();
    let count = blocks * N;
    let mut normal = || rng.sample(StandardNormal);
    if width.envelope_hz > 0.0 {
        let end_s = count as f64 / RATE_HZ;
        target = target.rough(Speckle::new(0.0, end_s, width.envelope_hz.into(), &mut normal));
    }
    let receiver = Receiver::ideal(RATE_HZ, R::IQ, Mixing::RxConjTx).with_snr(amplitude, snr_db);
    let wave = Waveform::continuous(CARRIER_HZ);
    let codes = receiver.record(&wave, &[target], (0, 0.0), count, normal);
    let samples: Vec<R::Sample> = codes.into_iter().map(R::from_parts).collect();
    (samples.chunks(N).map(<[_]>::to_vec).collect(), cycles)
}

/// The error of a tone's frequency in its sigmas; `None` if it is not to be used.
fn off(tone: &Tone, cycles: f64) -> Option<f64> {
    let error = tone.frequency.cycles() - cycles;
    let usable = matches!(tone.verdict, Verdict::Good | Verdict::Moving);
    usable.then(|| (error - error.round()) / f64::from(tone.sigma))
}

/// The mean square of errors in sigmas, the share of those beyond five, and how many there are of `all`.
fn calibration(off: &[f64], all: usize) -> [f64; 3] {
    let count = off.len() as f64;
    let beyond = off.iter().filter(|x| x.abs() > 5.0).count() as f64;
    [off.iter().map(|x| x * x).sum::<f64>() / count, beyond / count, count / all as f64]
}

/// The calibration of blocks and of tracks, of surfaces of this width. `stated` is what the configuration says of it.
fn followed<R: Record, const N: usize>(
    width: Carrier,
    stated: Carrier,
    snr_db: f64,
) -> [[f64; 3]; 2] {
    let runs = sized(12, 60);
    let seen: Vec<[Vec<f64>; 2]> = (0..runs)
        .into_par_iter()
        .map(|run| {
            let (records, cycles) = records::<R, N>(width, (500.0, snr_db), BLOCKS, SEED + run);
            let config = Config {
                carrier: stated,
                following: Following { most: 1, ..Following::default() },
                ..Config::new(RATE_HZ, Codes::signed::<12>())
            };
            let mut tracker = Tracker::<R, N>::new(config.plan().unwrap());
            let (mut blocks, mut tracks) = (Vec::new(), Vec::new());
            for (block, record) in records.iter().enumerate() {
                let stamp = Stamp { sequence: block as u32, ..Stamp::default() };
                let record = record.as_slice().try_into().unwrap();
                let measurement = tracker.block(&stamp, record);
                blocks.extend(off(&measurement.tone, cycles));
                let held = tracker.tracks(Segment::Continuous).iter();
                let held = held.filter(|track| track.state == State::Held);
                if block >= SETTLED {
                    tracks.extend(held.filter_map(|track| off(&track.tone, cycles)));
                }
            }
            [blocks, tracks]
        })
        .collect();
    let all = [BLOCKS, BLOCKS - SETTLED].map(|blocks| blocks * runs as usize);
    [0, 1].map(|which| {
        let off: Vec<f64> = seen.iter().flat_map(|seen| seen[which].iter().copied()).collect();
        calibration(&off, all[which])
    })
}

/// Widths of so many bins of a record.
fn linewidth(bins: f64, n: usize) -> Carrier {
    Carrier { linewidth_hz: (bins * RATE_HZ / n as f64) as f32, ..Carrier::default() }
}

fn envelope(bins: f64, n: usize) -> Carrier {
    Carrier { envelope_hz: (bins * RATE_HZ / n as f64) as f32, ..Carrier::default() }
}

fn cells<R: Record, const N: usize>(widths: &[Carrier], knows: bool) -> Vec<[[f64; 3]; 2]> {
    let mut all = Vec::new();
    for &width in widths {
        for snr_db in [10.0, 20.0, 30.0] {
            let stated = if knows { width } else { Carrier::default() };
            let seen = followed::<R, N>(width, stated, snr_db);
            let kind = if R::IQ { "I/Q" } else { "real" };
            let knows = if knows { "stated" } else { "learnt" };
            let bins = [width.linewidth_hz, width.envelope_hz]
                .map(|hz| f64::from(hz) * N as f64 / RATE_HZ);
            println!(
                "{kind} {N}, linewidth {:.3}, envelope {:.3} bins, {snr_db} dB, {knows}: blocks {:.2?}, tracks {:.2?} (mean (error/sigma)^2, beyond 5, usable)",
                bins[0], bins[1], seen[0], seen[1]
            );
            all.push(seen);
        }
    }
    all
}

/// The widths that docs/signals.md names: speckle of .07 to .7 bins (deviations of .03 to .3 bins), linewidths of .003 to .1 bins.
fn widths(n: usize) -> [Carrier; 7] {
    let [a, b, c] = [0.07, 0.24, 0.7].map(|bins| envelope(bins, n));
    let [d, e, f, g] = [0.003, 0.01, 0.03, 0.1].map(|bins| linewidth(bins, n));
    [a, b, c, d, e, f, g]
}

#[test]
fn a_stated_width_is_in_sigma() {
    println!("seed {SEED}");
    let mut all = cells::<Real, 1024>(&widths(1024), true);
    all.extend(cells::<Iq, 256>(&widths(256), true));
    for [[block, lies, _], [track, lost, _]] in all {
        assert!(lies <= 0.01 && block < 1.2, "{block} {lies}");
        assert!(lost <= 0.01 && (0.4..1.5).contains(&track), "{track} {lost}");
    }
}

/// What is not stated a track learns of a linewidth. A slow envelope it takes for motion.
#[test]
fn a_track_learns_a_linewidth() {
    println!("seed {SEED}");
    let mut all = cells::<Real, 1024>(&widths(1024)[3..], false);
    all.extend(cells::<Iq, 256>(&widths(256)[3..], false));
    for [_, [track, lost, _]] in all {
        assert!(lost <= 0.01 && (0.4..2.0).contains(&track), "{track} {lost}");
    }
}

fn summed<const N: usize>(width: Carrier, snr_db: f64) -> [f64; 3] {
    const M: usize = 16;
    let runs = sized(200, 2000);
    let off: Vec<f64> = (0..runs)
        .into_par_iter()
        .filter_map(|run| {
            let (records, cycles) = records::<Iq, N>(width, (200.0, snr_db), M, SEED + 1000 + run);
            let config = Config { carrier: width, ..Config::new(RATE_HZ, Codes::signed::<12>()) };
            let mut pipeline = Pipeline::<Iq, N>::new(config.plan().unwrap());
            let mut accumulator = Accumulator::<Iq, N>::new(M as u32);
            let sums = records.iter().enumerate().filter_map(|(block, record)| {
                let stamp = Stamp { sequence: block as u32, ..Stamp::default() };
                let measurement = pipeline.block(&stamp, record.as_slice().try_into().unwrap());
                accumulator.add(&measurement, &pipeline)
            });
            sums.last().and_then(|sum| off(&sum.tone, cycles))
        })
        .collect();
    calibration(&off, runs as usize)
}

#[test]
fn a_sum_of_blocks_knows_the_width() {
    println!("seed {SEED}");
    for width in widths(256) {
        for snr_db in [-5.0, 10.0] {
            let [mean, lies, usable] = summed::<256>(width, snr_db);
            println!("{width:?}, {snr_db} dB: {mean:.2}, {lies:.3} beyond 5, {usable:.2} usable");
            assert!(lies <= 0.01 && mean < 2.0 && usable > 0.9, "{width:?}");
        }
    }
}

/// `picket_dsp::carrier` names 1.06 times speed over diameter; the simulator draws scatterers in a spot.
#[test]
fn the_spot_has_the_bandwidth() {
    let (speed, diameter) = (2.0, 1e-3);
    let bandwidth = 1.06 * speed / diameter;
    let lag_s = 0.1 / bandwidth;
    let sums: Vec<[f64; 2]> = (0..4000u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut normal = || rng.sample(StandardNormal);
            let speckle = Speckle::from_spot((0.0, lag_s), speed, diameter, &mut normal);
            let [[a, b], [c, d]] = [speckle.at(0.0), speckle.at(lag_s)];
            [a * c + b * d, a * a + b * b]
        })
        .collect();
    let [cross, power] = [0, 1].map(|which| sums.iter().map(|x| x[which]).sum::<f64>());
    // exp(-2 pi^2 (b t / 2.355)^2).
    let expected = (-2.0 * (std::f64::consts::PI * 0.1 / 2.3548).powi(2)).exp();
    assert!((cross / power - expected).abs() < 0.01, "{} {expected}", cross / power);
}
