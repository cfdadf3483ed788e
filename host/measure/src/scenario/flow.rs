//! A turbulent flow whose particles cross the fringes of a laser: a laser-Doppler velocimeter.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::Config;
use picket_simulator::Scene;
use picket_simulator::scene::{Particles, Source};

/// Fringes of 4 um, as of 532 nm at 7.6 degrees between the beams, where these are 200 um wide.
pub const FRINGE_M: f64 = 4e-6;
/// The radius of the beams.
pub const RADIUS_M: f64 = 100e-6;
/// A particle of the mean speed has 1 MHz, and an envelope whose standard deviation is an eighth of a record.
const RATE_HZ: f64 = 10e6;

/// The flow's mean velocity, m/s, and the standard deviation about it, a share of it.
pub const MEAN_MPS: f64 = 4.0;
/// The share.
pub const TURBULENCE: f64 = 0.1;
/// From one particle to the next, on average, s: eight records. The nearer they come, the more are taken for two, and the more of them are
/// slow, because these take longer: at four records the mean of the others is .1 % too high.
const APART_S: f64 = 800e-6;
/// From 20,000 particles the mean is known to .07 % of itself, and the deviation to .5 %.
const SECONDS: f64 = 20_000.0 * APART_S;

/// The photodiode's signal at 10 MS/s, in signed codes of 12 bits.
pub fn config() -> Config {
    Config::new(RATE_HZ, Codes::signed::<12>())
}

/// The flow, with a usual particle this many decibels above the noise of a sample at its top. One of three times the size does not clip.
pub fn scene(seed: u64, snr_db: f64) -> Scene {
    let particles = Particles {
        fringe_m: FRINGE_M,
        radius_m: RADIUS_M,
        visibility: 0.7,
        velocity_mps: MEAN_MPS.into(),
        turbulence_mps: TURBULENCE * MEAN_MPS,
        per_m: 1.0 / (APART_S * MEAN_MPS),
        amplitude: Some(250.0.into()),
        sizes: 0.4,
        ..Particles::default()
    };
    let sensor = Scene { seed, rate_hz: RATE_HZ, seconds: SECONDS, ..Scene::default() };
    super::before(sensor, vec![Source::Particles(particles)], snr_db)
}
