//! Thirty seconds before a radar: a car comes, brakes, stands and leaves; another comes towards it.

use super::beats;
use picket::acquire::codes::Codes;
use picket::config::{Config, Following, SPEED_OF_LIGHT, Scene as Waveform};
use picket::solve::chirp::Shape;
use picket::solve::equations::{Chirp, Equations};
use std::f64::consts::TAU;

/// From one chirp to the next.
pub const CYCLE_S: f64 = 0.05;
/// Chirps.
pub const CYCLES: usize = 600;

/// When the signal is cut off: shorter than a track lives without it, and longer.
pub const DROPOUTS: [(f64, f64); 2] = [(15.0, 15.2), (22.0, 22.5)];

/// How much weaker the other car is, dB.
const OTHER_DB: f64 = 4.0;

/// A 77 GHz radar with 300 MHz in 1 ms at 1.024 MS/s, that follows two tones in each segment.
pub fn config() -> Config {
    Config {
        scene: Waveform::Chirp(Chirp {
            shape: Shape::Trapezoid,
            wavelength_m: SPEED_OF_LIGHT / 77e9,
            bandwidth_hz: 300e6,
            duration_s: 1e-3,
            ..Chirp::default()
        }),
        // A car's braking moves its beat by some hundredths of a bin from one chirp's rate to the next.
        following: Following {
            acceleration_bins: 0.03,
            rate_bins: 4.0,
            most: 2,
            ..Following::default()
        },
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
        let other = (2.0..12.0).contains(&t).then(|| (20.0 + 8.0 * (t - 2.0), -8.0));
        Scene {
            range_m,
            velocity_mps: -speed,
            snr_db: (!cut).then(|| 5.0 + 8.0 * (TAU * t / 11.0).sin()),
            other: other.filter(|_| !cut),
        }
    }

    /// The beats of each segment in signed cycles per sample, with their signal-to-noise ratio.
    pub fn beats(&self, equations: &Equations) -> [Vec<(f64, f64)>; 3] {
        let mut segments = [const { Vec::new() }; 3];
        let Some(snr_db) = self.snr_db else {
            return segments;
        };
        let car = (self.range_m, self.velocity_mps, snr_db);
        let other = self.other.map(|(range_m, speed)| (range_m, speed, snr_db - OTHER_DB));
        for (range_m, speed, snr_db) in std::iter::once(car).chain(other) {
            let beats = beats(range_m, speed, equations);
            for (segment, beat) in segments.iter_mut().zip(beats) {
                segment.push((beat, snr_db));
            }
        }
        segments
    }
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
