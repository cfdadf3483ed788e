//! Half a minute in front of a radar of 77 GHz that sends frames of chirps: four cars that cross one another in range and in speed.

use super::traffic::car;
use super::{before, sensor};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Iq;
use picket_dsp::config::{self, Config, SPEED_OF_LIGHT};
use picket_dsp::frame::FrameConfig;
use picket_dsp::{Chirp, Shape};
use picket_simulator::Scene;

/// Samples of a chirp.
pub const N: usize = 256;
/// Chirps of a frame.
pub const CHIRPS: usize = 64;
/// From one chirp to the next.
pub const PERIOD_S: f64 = 55e-6;
/// Frames.
pub const FRAMES: usize = 100;
/// Chirps from one frame's first to the next one's: three tenths of a second.
pub const EVERY: usize = 5454;

const RATE_HZ: f64 = 5.12e6;

/// The radar: 150 MHz in a record of 50 us, so that a cell has a metre.
pub fn config() -> FrameConfig {
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: SPEED_OF_LIGHT / 77e9,
        bandwidth_hz: 153e6,
        duration_s: 51e-6,
        guard_s: 1e-6,
        ..Chirp::default()
    };
    FrameConfig {
        // No car is faster, and aliases are 35 m/s apart.
        velocity_mps: Some((-17.0, 17.0)),
        ..FrameConfig::new(chirp, RATE_HZ, N, true, CHIRPS, PERIOD_S)
    }
}

/// The codes of its converter.
pub fn codes() -> Codes {
    Codes::signed::<12>()
}

/// The cars of a seed, as [`super::traffic::scene`] has them.
pub fn scene(seed: u64, snr_db: f64) -> Scene {
    let FrameConfig { chirp, rate_hz, .. } = config();
    let config = Config { scene: config::Scene::Chirp(chirp), ..Config::new(rate_hz, codes()) };
    let sensor = Scene { seed, ..sensor::<Iq>(&config, N, PERIOD_S, FRAMES * EVERY) };
    before(sensor, super::traffic::CARS.map(car).to_vec(), snr_db)
}
