//! Two seconds in front of a radar: a plate at 30 cm that swings by 10 um, five times a second.

use super::{before, echo, sensor};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{self, Config, SPEED_OF_LIGHT};
use picket_dsp::{Chirp, Shape};
use picket_simulator::Scene;
use picket_simulator::scene::{Source, Target, Vibration};
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
        scene: config::Scene::Chirp(Chirp {
            shape: Shape::Sawtooth,
            wavelength_m: SPEED_OF_LIGHT / (CARRIER_HZ - 0.5 * BANDWIDTH_HZ),
            bandwidth_hz: BANDWIDTH_HZ,
            duration_s: DURATION_S,
            ..Chirp::default()
        }),
        ..Config::new(RATE_HZ, Codes::signed::<12>())
    }
}

/// The plate `snr_db` above the noise, for records of `n` samples.
pub fn scene(seed: u64, n: usize, snr_db: f64) -> Scene {
    let vibration = vec![Vibration {
        amplitude_m: SWING_M.into(),
        frequency_hz: SWING_HZ.into(),
        phase_turns: 0.0.into(),
    }];
    let plate = Target { vibration, ..echo(AMPLITUDE, RANGE_M, 0.0) };
    let sensor = Scene { seed, ..sensor::<Real>(&config(), n, CYCLE_S, CYCLES) };
    before(sensor, vec![Source::Target(plate)], snr_db)
}

/// The bound of the plate's place in one ramp of `n` samples, m: `lambda / (4 pi sqrt(N SNR))`, with the rounding of the converter
/// in the noise.
pub fn bound_m(n: usize, snr_db: f64) -> f64 {
    let noise =
        (AMPLITUDE / (2.0 * 10f64.powf(snr_db / 10.0)).sqrt()).hypot((1.0f64 / 12.0).sqrt());
    wavelength_m() / (2.0 * TAU) * noise / AMPLITUDE * (2.0 / n as f64).sqrt()
}
