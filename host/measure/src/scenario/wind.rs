//! Wind in front of a coherent lidar whose beam goes round a cone, with echoes of aerosols below the noise of a sample.

use super::{before, echo, sensor};
use picket_dsp::Mixing;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Iq;
use picket_dsp::config::{self, Config};
use picket_simulator::Scene;
use picket_simulator::scene::{Change, Source, Target};
use std::f64::consts::TAU;

const WAVELENGTH_M: f64 = 1550e-9;
const RATE_HZ: f64 = 50e6;

/// Blocks of a sum.
pub const BLOCKS: u32 = 100;
/// Beams of a round.
pub const BEAMS: usize = 36;

/// The wind, m/s, and where it comes from, degrees from north over east.
pub const WIND_MPS: f64 = 10.0;
/// Where it comes from.
pub const FROM_DEG: f64 = 35.0;
/// Half of the cone's angle, degrees from the vertical.
const CONE_DEG: f64 = 30.0;

/// What crosses a beam of 5 cm makes its echo change in this many hertz: .03 bins. From block to block, a millisecond later, the echo is
/// that of other aerosols.
const SPECKLE_HZ: f64 = 1.5e3;
/// From one block to the next, s.
pub const BLOCK_S: f64 = 1e-3;
/// Noise and echo together, root mean square in each part, codes: what is above six times as much clips.
const LEVEL: f64 = 300.0;

/// 1550 nm, I/Q at 50 MS/s: 3.8 cm/s a bin, up to 19 m/s either way.
pub fn config() -> Config {
    Config {
        scene: config::Scene::Doppler {
            wavelength_m: WAVELENGTH_M,
            angle_rad: 0.0,
            mixing: Mixing::RxConjTx,
        },
        ..Config::new(RATE_HZ, Codes::signed::<12>())
    }
}

/// The direction of a beam, degrees from north over east.
pub fn azimuth_deg(beam: usize) -> f64 {
    beam as f64 * 360.0 / BEAMS as f64
}

/// How fast the air approaches along a beam, m/s.
pub fn along_mps(beam: usize) -> f64 {
    let turned = (azimuth_deg(beam) - FROM_DEG).to_radians();
    WIND_MPS * CONE_DEG.to_radians().sin() * turned.cos()
}

/// Speed in m/s and direction in degrees of the wind that has these speeds along the beams: by least squares, in which sine and cosine are
/// orthogonal over a round.
pub fn of_beams(along_mps: &[f64]) -> [f64; 2] {
    let scale = 2.0 / along_mps.len() as f64 / CONE_DEG.to_radians().sin();
    let (mut north, mut east) = (0.0, 0.0);
    for (beam, along) in along_mps.iter().enumerate() {
        let (sin, cos) = azimuth_deg(beam).to_radians().sin_cos();
        north += scale * along * cos;
        east += scale * along * sin;
    }
    [north.hypot(east), (east.atan2(north).to_degrees() + 360.0) % 360.0]
}

/// Metres per second in a bin of `n` samples.
pub const fn mps_per_bin(n: usize) -> f64 {
    RATE_HZ / n as f64 * WAVELENGTH_M / 2.0
}

/// The bound of the speed from a sum of blocks, m/s: that of a tone that has this mean signal-to-noise ratio in each, over the root of
/// their number.
pub fn bound_mps(n: usize, snr_db: f64) -> f64 {
    let in_bin = n as f64 * 10f64.powf(snr_db / 10.0);
    (6.0 / (TAU * TAU * f64::from(BLOCKS) * in_bin)).sqrt() * mps_per_bin(n)
}

/// The amplitude of an echo, root mean square, codes.
fn amplitude(snr_db: f64) -> f64 {
    let snr = 10f64.powf(snr_db / 10.0);
    LEVEL * (2.0 * snr / (1.0 + snr)).sqrt()
}

/// The air along a beam, this many decibels below the noise of a sample, while the blocks of a sum are taken.
pub fn scene(seed: u64, n: usize, beam: usize, snr_db: f64) -> Scene {
    let aerosols = vec![Change::Speckle { bandwidth_hz: SPECKLE_HZ.into() }];
    // The range does not matter: the wave is continuous.
    let air = Target { changes: aerosols, ..echo(amplitude(snr_db), 100.0, along_mps(beam)) };
    let seconds = f64::from(BLOCKS) * BLOCK_S;
    let sensor = Scene { seed, seconds, ..sensor::<Iq>(&config(), n, 0.0, 1) };
    before(sensor, vec![Source::Target(air)], snr_db)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wind_of_the_beams_is_the_wind() {
        let along: Vec<f64> = (0..BEAMS).map(along_mps).collect();
        let [speed, from] = of_beams(&along);
        assert!((speed - WIND_MPS).abs() < 1e-9 && (from - FROM_DEG).abs() < 1e-9);
        assert!(along.iter().copied().fold(0.0, f64::max) > 4.9);
    }
}
