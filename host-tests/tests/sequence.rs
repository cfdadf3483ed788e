//! Velocity from the phases of a sequence of sawtooth chirps: within its sigma, and never the wrong one alone.

use crate::signal::*;
use picket::config::SPEED_OF_LIGHT;
use picket::solve::chirp::Shape;
use picket::solve::equations::{Chirp, Equations};
use picket::solve::sequence::{LISTED, Sequence};
use picket::{Codes, Config, Pipeline, Real, Stamp, Verdict};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

const N: usize = 1024;
const RATE_HZ: f64 = 500e3;
/// Samples from chirp to chirp, m, Hz, s.
const PERIOD: u32 = 1100;
const WAVELENGTH_M: f64 = 0.0125;
const BANDWIDTH_HZ: f64 = 200e6;
const RAMP_S: f64 = N as f64 / RATE_HZ;
/// The wavelength is that of the ramp's middle.
const BOTTOM_HZ: f64 = SPEED_OF_LIGHT / WAVELENGTH_M - 0.5 * BANDWIDTH_HZ;

fn equations() -> Equations {
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: SPEED_OF_LIGHT / BOTTOM_HZ,
        bandwidth_hz: BANDWIDTH_HZ,
        duration_s: RAMP_S,
        ..Chirp::default()
    };
    chirp.equations(RATE_HZ, N, false).unwrap()
}

/// The beat of a chirp that begins at this sample, of a target that was `range_m` away at sample 0, in radians by sample.
fn beat(range_m: f64, velocity: f64, clock: u64) -> impl Fn(usize) -> f64 {
    let slope = BANDWIDTH_HZ / RAMP_S;
    move |n| {
        let away = range_m - velocity * (clock as f64 + n as f64) / RATE_HZ;
        let delay = 2.0 * away / SPEED_OF_LIGHT;
        let within = n as f64 / RATE_HZ;
        TAU * (BOTTOM_HZ * delay + slope * delay * within - 0.5 * slope * delay * delay)
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
    trials(seed, host_tests::sized(300, 3000), |rng| {
        let (range_m, velocity) = (rng.random_range(15.0..80.0), rng.random_range(-4.0..4.0));
        let config = Config::new(RATE_HZ, Codes::signed::<12>());
        let mut pipeline = Pipeline::<Real, N>::new(config.plan().unwrap());
        let mut sequence = Sequence::new(&equations(), PERIOD).unwrap();
        let amplitude = amplitude(snr_db);
        let noise = sigma(amplitude, snr_db);
        let mut targets = heapless::Vec::new();
        let mut middle = 0.0;
        for chirp in 0..chirps {
            let clock = chirp * u64::from(PERIOD);
            let angle = beat(range_m, velocity, clock);
            let samples = std::array::from_fn(|n| {
                quantise(
                    amplitude * (angle(n) + PI / 3.0).cos()
                        + noise * rng.sample::<f64, _>(StandardNormal),
                )
            });
            let stamp = Stamp { clock, sequence: chirp as u32, ..Stamp::default() };
            let measurement = pipeline.block(stamp, &samples);
            let lines = pipeline.lines(&measurement, 1);
            let [phasor] = lines.as_slice() else { panic!("{} lines", lines.len()) };
            targets = sequence.push(&stamp, phasor);
            middle = (clock as f64 + 0.5 * N as f64) / RATE_HZ;
        }
        let square = |error: f64, sigma: f32| (error / f64::from(sigma)).powi(2);
        let right =
            targets.iter().find(|target| (target.velocity.to_num::<f64>() - velocity).abs() < 1.0);
        Seen {
            squares: right.map(|target| {
                let away = range_m - velocity * middle;
                [
                    square(target.velocity.to_num::<f64>() - velocity, target.sigma_velocity),
                    square(target.range.to_num::<f64>() - away, target.sigma_range),
                ]
            }),
            alone: targets.len() == 1,
            good: targets.iter().any(|target| target.verdict == Verdict::Good),
        }
    })
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
