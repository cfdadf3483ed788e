//! A fan that moves in front of a 24 GHz radar: a body, and three blades that turn.

use super::{Row, before, echo, sensor};
use picket_dsp::Mixing;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Iq;
use picket_dsp::config::{self, Config, SPEED_OF_LIGHT};
use picket_simulator::Scene;
use picket_simulator::scene::{Blades, Source};
use std::f64::consts::TAU;

const CARRIER_HZ: f64 = 24e9;
/// Sample rate, Hz.
pub const RATE_HZ: f64 = 20e3;

/// Blades, and turns a second: a blade passes 60 times a second.
const BLADES: usize = 3;
const TURNS_HZ: f64 = 20.0;
/// Where on a blade the wave is scattered, m, and the amplitude of each such place over that of the body.
const PLACES_M: [f64; 3] = [0.05, 0.10, 0.15];
const PLACE: f64 = 0.05;
/// The body's echo, codes: with all of the blades in phase, and noise of 20 dB, it does not clip.
const AMPLITUDE: f64 = 1000.0;
/// The body's distance, m.
const RANGE_M: f64 = 5.0;

/// Speeds of the body, m/s.
const SPEEDS_MPS: [f64; 12] = [0.5, 0.8, 1.1, 1.5, 2.0, 2.7, 3.7, 5.0, 6.7, 9.0, 12.0, 16.0];

/// 24 GHz, I/Q at 20 kS/s: 12 cm/s a bin of 1024 samples, in which the blades turn once.
pub fn config() -> Config {
    Config {
        scene: config::Scene::Doppler {
            wavelength_m: SPEED_OF_LIGHT / CARRIER_HZ,
            angle_rad: 0.0,
            mixing: Mixing::RxConjTx,
        },
        ..Config::new(RATE_HZ, Codes::signed::<12>())
    }
}

/// The body's speeds, each approaching and receding.
pub fn rows() -> Vec<Row> {
    let both =
        |speed: f64| [1.0, -1.0].map(|sign| Row { range_m: 0.0, velocity_mps: sign * speed });
    SPEEDS_MPS.into_iter().flat_map(both).collect()
}

/// How far to each side of the body's line the tips of the blades reach, Hz.
pub fn reach_hz() -> f64 {
    2.0 * TAU * TURNS_HZ * PLACES_M[PLACES_M.len() - 1] * CARRIER_HZ / SPEED_OF_LIGHT
}

/// The fan with its body at a row's speed, this many decibels above the noise, for a record of `n` samples.
pub fn scene(seed: u64, n: usize, row: &Row, snr_db: f64) -> Scene {
    let body = echo(AMPLITUDE, RANGE_M, row.velocity_mps);
    let blades = Blades {
        range_m: RANGE_M.into(),
        velocity_mps: row.velocity_mps.into(),
        blades: BLADES,
        turns_hz: TURNS_HZ.into(),
        places_m: PLACES_M.to_vec(),
        amplitude: Some((PLACE * AMPLITUDE).into()),
        level_db: None,
    };
    let sources = vec![Source::Target(body), Source::Blades(blades)];
    before(Scene { seed, ..sensor::<Iq>(&config(), n, 0.0, 1) }, sources, snr_db)
}
