//! Thirty seconds in front of a radar: a car comes, brakes, stands and leaves; another comes towards it.

use super::{codes, sensor};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{Config, Following, SPEED_OF_LIGHT, Scene as Waveform};
use picket_dsp::{Chirp, Shape};
use picket_simulator::{Receiver, Sensor, Target};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// From one chirp to the next.
pub const CYCLE_S: f64 = 0.05;
/// Chirps.
pub const CYCLES: usize = 600;

/// When the signal is cut off: shorter than a track lives without it, and longer.
pub const DROPOUTS: [(f64, f64); 2] = [(15.0, 15.2), (22.0, 22.5)];

/// How much weaker the other car is, dB.
const OTHER_DB: f64 = 4.0;

/// The noise of a sample, in codes.
const NOISE: f64 = 60.0;

/// A 77 GHz radar with 303 MHz in 1.01 ms at 1.024 MS/s, that follows two tones in each segment. A record of 1 ms begins when the
/// echoes of the ramp before have passed.
pub fn config() -> Config {
    Config {
        scene: Waveform::Chirp(Chirp {
            shape: Shape::Trapezoid,
            wavelength_m: SPEED_OF_LIGHT / 77e9,
            bandwidth_hz: 303e6,
            duration_s: 1.01e-3,
            guard_s: 10e-6,
            ..Chirp::default()
        }),
        following: Following { rate_bins: 4.0, most: 2, ..Following::default() },
        ..Config::new(1.024e6, Codes::signed::<12>())
    }
}

/// What is in front of the radar at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Where the car is.
    pub range_m: f64,
    /// How fast it approaches.
    pub velocity_mps: f64,
    /// Its signal-to-noise ratio per sample; `None` while the signal is cut off.
    pub snr_db: Option<f64>,
    /// Range and velocity of the other car.
    pub other: Option<(f64, f64)>,
}

impl Scene {
    /// The scene at `t` seconds.
    pub fn at(t: f64) -> Self {
        // (until, acceleration away from the radar)
        const MANOEUVRES: [(f64, f64); 5] =
            [(4.0, 0.0), (8.0, 3.0), (13.0, 0.0), (19.0, 2.0), (f64::INFINITY, 0.0)];
        let (mut range_m, mut speed, mut from) = (100.0, -12.0, 0.0);
        for (until, acceleration) in MANOEUVRES {
            let duration = t.min(until) - from;
            if duration <= 0.0 {
                break;
            }
            range_m += speed * duration + acceleration * duration * duration / 2.0;
            speed += acceleration * duration;
            from = until;
        }
        let cut = DROPOUTS.iter().any(|(from, to)| (*from..*to).contains(&t));
        let other = (2.0..12.0).contains(&t).then(|| (other_m(t), -8.0));
        Scene {
            range_m,
            velocity_mps: -speed,
            snr_db: (!cut).then(|| 5.0 + 8.0 * (TAU * t / 11.0).sin()),
            other: other.filter(|_| !cut),
        }
    }

    /// The echoes of both cars.
    fn targets(&self, rng: &mut ChaCha8Rng) -> Vec<Target<'static>> {
        let Some(snr_db) = self.snr_db else {
            return Vec::new();
        };
        let amplitude = |snr_db: f64| NOISE * (2.0 * 10f64.powf(snr_db / 10.0)).sqrt();
        let car = Target::new(amplitude(snr_db), |t| Scene::at(t).range_m);
        let other = self.other.map(|_| Target::new(amplitude(snr_db - OTHER_DB), other_m));
        let cars = std::iter::once(car).chain(other);
        cars.map(|target| target.turned(rng.random())).collect()
    }
}

/// The range of the other car, m, at a time, s.
fn other_m(t: f64) -> f64 {
    20.0 + 8.0 * (t - 2.0)
}

/// The radar as it is simulated, for records of `n` samples.
pub fn radar(n: usize) -> Sensor {
    let sensor = sensor::<Real>(&config(), n, CYCLE_S);
    let receiver = Receiver { noise: NOISE, ..sensor.receiver };
    sensor.received_by(receiver)
}

/// The moment to which a chirp's ranges refer, s.
pub fn moment_s(radar: &Sensor, cycle: usize) -> f64 {
    cycle as f64 * CYCLE_S + radar.middle_s()
}

/// The converter's codes of a chirp's segment.
pub fn samples(radar: &Sensor, cycle: usize, segment: usize, rng: &mut ChaCha8Rng) -> Vec<i16> {
    let targets = Scene::at(moment_s(radar, cycle)).targets(rng);
    codes::<Real>(radar, &targets, (cycle as u64, segment), rng)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_car_comes_brakes_stands_and_leaves() {
        let at = |t: f64| (Scene::at(t).range_m, Scene::at(t).velocity_mps);
        assert_eq!(at(0.0), (100.0, 12.0));
        assert_eq!(at(4.0), (52.0, 12.0));
        assert_eq!(at(10.0), (28.0, 0.0));
        assert_eq!(at(19.0), (64.0, -12.0));
        assert_eq!(at(29.0), (184.0, -12.0));
        // They pass each other.
        let apart = |t: f64| Scene::at(t).range_m - Scene::at(t).other.unwrap().0;
        assert!(apart(3.0) > 0.0 && apart(7.0) < 0.0);
        assert_eq!((Scene::at(15.1).snr_db, Scene::at(22.3).other), (None, None));
    }
}
