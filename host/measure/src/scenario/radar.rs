//! Targets that move in front of a 24 GHz radar with I/Q records, as the boards take them.

use super::{Bars, Row};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_dsp::{Chirp, Mixing, Shape};

/// Both shapes from which one target's range and velocity are unique.
pub const SHAPES: [Shape; 2] = [Shape::Triangle, Shape::Trapezoid];

/// Carrier, Hz.
const CARRIER_HZ: f64 = 24e9;
/// Bandwidth of a ramp, Hz.
const BANDWIDTH_HZ: f64 = 200e6;
/// Sample rate, Hz.
const RATE_HZ: f64 = 250e3;
/// Samples of a record, and those left out before it.
const N: f64 = 1024.0;
const GUARD: f64 = 32.0;

/// Range in metres and speed in m/s: from a walker to a train. In the second and the fourth the Doppler shift exceeds the range
/// beat.
const TARGETS: [(f64, f64); 7] = [
    (30.0, 3.0),
    (5.0, 20.0),
    (60.0, 12.0),
    (10.0, 35.0),
    (120.0, 30.0),
    (180.0, 45.0),
    (250.0, 60.0),
];

/// A tenth of what the radar resolves: `c / 2 B` in range and `lambda / 2 T` in velocity.
pub const BARS: Bars = Bars {
    range_m: 0.1 * SPEED_OF_LIGHT / (2.0 * BANDWIDTH_HZ),
    velocity_mps: 0.1 * SPEED_OF_LIGHT / CARRIER_HZ / 2.0 * RATE_HZ / N,
};

/// The radar: 24 GHz, 200 MHz in 4.224 ms, 250 kS/s, with a guard of 32 samples before each record of 1024.
pub fn config(shape: Shape, mixing: Mixing) -> Config {
    Config {
        scene: Scene::Chirp(Chirp {
            shape,
            wavelength_m: SPEED_OF_LIGHT / CARRIER_HZ,
            bandwidth_hz: BANDWIDTH_HZ,
            duration_s: (N + GUARD) / RATE_HZ,
            guard_s: GUARD / RATE_HZ,
            mixing,
            ..Chirp::default()
        }),
        ..Config::new(RATE_HZ, Codes::signed::<12>())
    }
}

/// The targets, each approaching and receding.
pub fn rows() -> Vec<Row> {
    let both = |(range_m, speed): (f64, f64)| {
        [1.0, -1.0].map(|sign| Row { range_m, velocity_mps: sign * speed })
    };
    TARGETS.into_iter().flat_map(both).collect()
}
