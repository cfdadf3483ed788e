//! Velocity from the phases of a sequence of sawtooth chirps: within its sigma, and never the wrong one alone.

use crate::signal::*;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::solve::sequence::{LISTED, Sequence};
use picket_dsp::{Chirp, Codes, Config, Pipeline, Real, Shape, Stamp, Verdict};
use picket_simulator::Scene;
use picket_simulator::scene::{self, Noise, Receiver, Source, Target, Waveform};
use rayon::prelude::*;

const N: usize = 1024;
const RATE_HZ: f64 = 500e3;
/// Samples from chirp to chirp.
const PERIOD: u32 = 1100;

/// 24 GHz in the middle of the ramp.
fn chirp() -> Chirp {
    let (bandwidth_hz, duration_s) = (200e6, N as f64 / RATE_HZ);
    Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: SPEED_OF_LIGHT / (24e9 - 0.5 * bandwidth_hz),
        bandwidth_hz,
        duration_s,
        ..Chirp::default()
    }
}

/// A target before a radar that sends this chirp again and again.
fn scene(snr_db: f64, seed: u64) -> Scene {
    let chirp = chirp();
    let waveform = Waveform {
        shape: scene::Shape::Sawtooth,
        carrier_hz: SPEED_OF_LIGHT / chirp.wavelength_m,
        bandwidth_hz: chirp.bandwidth_hz,
        ramp_s: chirp.duration_s,
        period_s: f64::from(PERIOD) / RATE_HZ,
        guard_s: Some(0.0),
        samples: N,
        ..Waveform::default()
    };
    let target = Target {
        range_m: (15.0..80.0).into(),
        velocity_mps: (-4.0..4.0).into(),
        amplitude: Some(amplitude(snr_db).into()),
        ..Target::default()
    };
    let noise = Noise { snr_db: Some(snr_db.into()), ..Noise::default() };
    Scene {
        seed,
        rate_hz: RATE_HZ,
        seconds: 0.2,
        waveform: Some(waveform),
        sources: vec![Source::Target(target)],
        receiver: Receiver { noise, ..Receiver::default() },
        ..Scene::default()
    }
}

struct Seen {
    /// (error/sigma)^2 of the velocity and of the range, where it was among the listed.
    squares: Option<[f64; 2]>,
    alone: bool,
    good: bool,
}

/// What a sequence of so many chirps shows in the end.
fn seen(snr_db: f64, chirps: u64, seed: u64) -> Vec<Seen> {
    let scene = scene(snr_db, seed);
    let of_run = |trial| {
        let mut run = scene.run(trial).unwrap();
        let config = Config::new(RATE_HZ, Codes::signed::<12>());
        let mut pipeline = Pipeline::<Real, N>::new(config.plan().unwrap());
        let equations = chirp().equations(RATE_HZ, N, false).unwrap();
        let mut sequence = Sequence::new(&equations, PERIOD).unwrap();
        let mut targets = heapless::Vec::new();
        for lap in 0..chirps {
            let record = run.record(lap as usize, N);
            let samples = std::array::from_fn(|n| record[n][0]);
            let clock = lap * u64::from(PERIOD);
            let stamp = Stamp { clock, sequence: lap as u32, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &samples);
            let lines = pipeline.lines(&measurement, 1);
            let [phasor] = lines.as_slice() else { panic!("{} lines", lines.len()) };
            targets = sequence.push(&stamp, phasor);
        }
        let truth = run.truth(0, scene.start_s(chirps as usize - 1, N), N);
        let (away, velocity) = (truth.range_m.unwrap(), truth.velocity_mps.unwrap());
        let square = |error: f64, sigma: f32| (error / f64::from(sigma)).powi(2);
        let right = targets
            .iter()
            .find(|target| (target.velocity.unwrap().to_num::<f64>() - velocity).abs() < 1.0);
        Seen {
            squares: right.map(|target| {
                [
                    square(
                        target.velocity.unwrap().to_num::<f64>() - velocity,
                        target.sigma_velocity,
                    ),
                    square(target.range.to_num::<f64>() - away, target.sigma_range),
                ]
            }),
            alone: targets.len() == 1,
            good: targets.iter().any(|target| target.verdict == Verdict::Good),
        }
    };
    (0..host_tests::sized(300, 3000)).into_par_iter().map(of_run).collect()
}

#[test]
fn phases_give_the_velocity_and_the_ranges_movement_its_turns() {
    for (snr_db, chirps, least_alone) in
        [(20.0, 3, 0.0), (10.0, 4, 0.0), (0.0, 8, 0.0), (10.0, 32, 0.99), (20.0, 64, 0.99)]
    {
        let seen = seen(snr_db, chirps, 61);
        let listed = mean(seen.iter().map(|seen| f64::from(seen.squares.is_some())));
        let alone = mean(seen.iter().map(|seen| f64::from(seen.alone)));
        let squares: Vec<_> = seen.iter().filter_map(|seen| seen.squares).collect();
        let [velocity, range] = [0, 1].map(|i| mean(squares.iter().map(|squares| squares[i])));
        println!(
            "{snr_db} dB, {chirps} chirps, seed 61: listed {listed:.4}, alone {alone:.4}, (error/sigma)^2 {velocity:.3} (velocity), {range:.3} (range)"
        );
        assert!(seen.iter().all(|seen| seen.good == seen.alone), "an ambiguous one is called good");
        // Of eight that are tried the right one is always one, as far as the range's movement tells.
        assert!(listed >= 0.99 && alone >= least_alone && LISTED == 8);
        let error = 2.0 * (2.0 / squares.len() as f64).sqrt();
        for trust in [velocity, range] {
            assert!(trust * (1.0 + error) >= 0.85 && trust * (1.0 - error) <= 1.15);
        }
        // Alone, it is the right one.
        assert!(seen.iter().all(|seen| !seen.alone || seen.squares.is_some()));
    }
}
