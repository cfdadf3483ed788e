//! Thirty seconds in front of the lidar of [`super::lidar`]: four cars that cross one another in range and in speed.

use super::{codes, lidar as config, sensor};
use picket_dsp::acquire::sample::Real;
use picket_simulator::{Sensor, Target};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
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

    /// Its echo at about `t` seconds.
    fn target(&self, t: f64) -> Target<'_> {
        Target::new(self.amplitude(t), |t| self.at(t)[0])
    }

    /// Its beats [up, flat, down] in bins of a record of the chirp `cycle`, as real samples show them.
    pub fn bins(&self, lidar: &Sensor, cycle: usize) -> [f64; 3] {
        let target = self.target(moment_s(lidar, cycle));
        let beat = |segment| lidar.beat(&target, (cycle as u64, segment)).abs();
        [0, 1, 2].map(|segment| beat(segment) * lidar.n as f64)
    }

    /// The amplitude of its echo in codes: as one over the range.
    fn amplitude(&self, t: f64) -> f64 {
        (400.0 * 20.0 / self.at(t)[0]).min(450.0)
    }
}

/// The lidar as it is simulated, for records of `n` samples; a car at 20 m is `snr_db` above its noise.
pub fn lidar(n: usize, snr_db: f64) -> Sensor {
    let sensor = sensor::<Real>(&config(), n, CYCLE_S);
    let receiver = sensor.receiver.with_snr(400.0, snr_db);
    sensor.received_by(receiver)
}

/// The moment to which a chirp's ranges refer, s.
pub fn moment_s(lidar: &Sensor, cycle: usize) -> f64 {
    cycle as f64 * CYCLE_S + lidar.middle_s()
}

/// The converter's codes of a segment (0 up, 1 flat, 2 down) of the chirp `cycle`.
pub fn samples(
    lidar: &Sensor,
    cars: &[Car; 4],
    cycle: usize,
    segment: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<i16> {
    let t = moment_s(lidar, cycle);
    let targets = cars.each_ref().map(|car| car.target(t).turned(rng.random()));
    codes::<Real>(lidar, &targets, (cycle as u64, segment), rng)
}
