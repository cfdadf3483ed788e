//! Thirty seconds before the lidar of [`super::lidar`]: four cars that cross one another in range and in speed.

use super::beats;
use picket::solve::equations::Equations;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// From one chirp to the next.
pub const CYCLE_S: f64 = 0.05;
/// Chirps.
pub const CYCLES: usize = 600;

/// The most acceleration of a car, m/s^2.
pub const ACCELERATION: f64 = 10.0;

/// A car that swings to and fro: its middle and its reach in metres, its period in seconds, its phase in turns.
#[derive(Clone, Copy, Debug)]
pub struct Car {
    middle_m: f64,
    reach_m: f64,
    period_s: f64,
    begin: f64,
}

/// The cars of a seed: the same four, each somewhere else on its way.
pub fn cars(rng: &mut ChaCha8Rng) -> [Car; 4] {
    [(55.0, 40.0, 21.0), (70.0, 45.0, 17.0), (45.0, 30.0, 13.0), (80.0, 35.0, 15.0)].map(
        |(middle_m, reach_m, period_s)| {
            let begin = rng.random_range(0.0..1.0);
            Car { middle_m, reach_m, period_s, begin }
        },
    )
}

impl Car {
    /// Range in metres, and velocity in metres per second, positive when approaching.
    pub fn at(&self, t: f64) -> [f64; 2] {
        let (sin, cos) = (TAU * (t / self.period_s + self.begin)).sin_cos();
        [self.middle_m + self.reach_m * sin, -self.reach_m * TAU / self.period_s * cos]
    }

    /// Its beats [up, flat, down] in bins of a record of N samples, as real samples show them.
    pub fn beats<const N: usize>(&self, t: f64, equations: &Equations) -> [f64; 3] {
        let [range, velocity] = self.at(t);
        beats(range, velocity, equations).map(|cycles| cycles.abs() * N as f64)
    }

    /// The amplitude of its echo in codes: as one over the range.
    fn amplitude(&self, t: f64) -> f64 {
        (400.0 * 20.0 / self.at(t)[0]).min(450.0)
    }
}

/// The standard deviation of the noise in codes; a car at 20 m is `snr_db` above it.
pub fn noise(snr_db: f64) -> f64 {
    400.0 * (0.5 / 10f64.powf(snr_db / 10.0)).sqrt()
}

/// The converter's codes of one segment (0 up, 1 flat, 2 down) of the chirp at `t` seconds.
pub fn samples<const N: usize>(
    cars: &[Car; 4],
    t: f64,
    segment: usize,
    snr_db: f64,
    equations: &Equations,
    rng: &mut ChaCha8Rng,
) -> [i16; N] {
    let noise = noise(snr_db);
    let lines = cars.map(|car| {
        let turns = car.beats::<N>(t, equations)[segment] / N as f64;
        (turns, car.amplitude(t), rng.random_range(0.0..TAU))
    });
    std::array::from_fn(|n| {
        let echo: f64 =
            lines.iter().map(|(f, a, phase)| a * (TAU * f * n as f64 + phase).cos()).sum();
        (echo + noise * rng.sample::<f64, _>(StandardNormal)).round().clamp(-2048.0, 2047.0) as i16
    })
}
