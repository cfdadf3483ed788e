//! Two seconds in front of a radar: a plate at 30 cm that swings by 10 um, five times a second.

use super::{codes, sensor};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_dsp::{Chirp, Shape};
use picket_simulator::{Sensor, Target};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The carrier in the middle of a ramp.
const CARRIER_HZ: f64 = 122e9;
const BANDWIDTH_HZ: f64 = 6e9;
const DURATION_S: f64 = 1.024e-3;
const RATE_HZ: f64 = 1e6;

/// From one ramp to the next, and ramps.
pub const CYCLE_S: f64 = 5e-3;
/// The number of ramps.
pub const CYCLES: usize = 400;

/// Where the plate rests, m.
pub const RANGE_M: f64 = 0.3;
/// How far it swings to each side, m.
pub const SWING_M: f64 = 10e-6;
/// How often, Hz.
pub const SWING_HZ: f64 = 5.0;

/// The echo in codes.
const AMPLITUDE: f64 = 400.0;

/// The wave's length in the middle of a ramp, m.
pub const fn wavelength_m() -> f64 {
    SPEED_OF_LIGHT / CARRIER_HZ
}

/// A 122 GHz radar with 6 GHz in a ramp of 1.024 ms, at 1 MS/s.
pub fn config() -> Config {
    Config {
        scene: Scene::Chirp(Chirp {
            shape: Shape::Sawtooth,
            wavelength_m: SPEED_OF_LIGHT / (CARRIER_HZ - 0.5 * BANDWIDTH_HZ),
            bandwidth_hz: BANDWIDTH_HZ,
            duration_s: DURATION_S,
            ..Chirp::default()
        }),
        ..Config::new(RATE_HZ, Codes::signed::<12>())
    }
}

/// How far the plate is from its rest at `t` seconds, m; farther from the radar counts.
pub fn swing_m(t: f64) -> f64 {
    SWING_M * (TAU * SWING_HZ * t).sin()
}

/// The radar as it is simulated, for records of `n` samples, with the plate `snr_db` above the noise.
pub fn radar(n: usize, snr_db: f64) -> Sensor {
    let sensor = sensor::<Real>(&config(), n, CYCLE_S);
    let receiver = sensor.receiver.with_snr(AMPLITUDE, snr_db);
    sensor.received_by(receiver)
}

/// The time in the middle of a ramp's record, s.
pub fn middle_s(radar: &Sensor, cycle: usize) -> f64 {
    cycle as f64 * CYCLE_S + radar.middle_s()
}

/// The bound of the plate's place in one ramp of the radar, m: `lambda / (4 pi sqrt(N SNR))`, with the rounding of the converter
/// in the noise.
pub fn bound_m(radar: &Sensor) -> f64 {
    let noise = radar.receiver.noise.hypot((1.0f64 / 12.0).sqrt());
    wavelength_m() / (2.0 * TAU) * noise / AMPLITUDE * (2.0 / radar.n as f64).sqrt()
}

/// The converter's codes of a ramp.
pub fn samples(radar: &Sensor, cycle: usize, rng: &mut ChaCha8Rng) -> Vec<i16> {
    let plate = Target::new(AMPLITUDE, |t| RANGE_M + swing_m(t));
    codes::<Real>(radar, &[plate], (cycle as u64, 0), rng)
}
