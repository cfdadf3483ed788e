//! Records of targets before a configuration's sensor, as the simulator's `Sensor` takes them.

use picket_dsp::Mixing;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_host::scenario::Row;
use picket_simulator::{Receiver, Sensor, Target};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// What takes the records of a configuration, `n` samples each: its wave, and a receiver without noise. Chirps begin `period_s`
/// seconds apart, or follow one another where that is less.
pub fn sensor<R: Record>(config: &Config, n: usize, period_s: f64) -> Sensor {
    let receiver =
        |mixing| Receiver { codes: config.codes, ..Receiver::ideal(config.rate_hz, R::IQ, mixing) };
    match config.scene {
        Scene::Chirp(chirp) => Sensor::chirp(&chirp, receiver(chirp.mixing), n, period_s),
        Scene::Doppler { wavelength_m, mixing, .. } => {
            Sensor::continuous(SPEED_OF_LIGHT / wavelength_m, receiver(mixing), n)
        }
        // A tone has no wave: its echo stands still.
        _ => Sensor::continuous(0.0, receiver(Mixing::default()), n),
    }
}

/// The converter's codes of what a sensor receives from targets in a segment of a lap.
pub fn codes<R: Record>(
    sensor: &Sensor,
    targets: &[Target],
    at: (u64, usize),
    rng: &mut ChaCha8Rng,
) -> Vec<R::Sample> {
    let record = sensor.record(targets, at, || rng.sample(StandardNormal));
    record.into_iter().map(R::from_parts).collect()
}

/// The target of a row: where the row says at the moment to which the sensor's range refers, with any phase.
pub fn target(row: &Row, sensor: &Sensor, amplitude: f64, rng: &mut ChaCha8Rng) -> Target<'static> {
    let Row { range_m, velocity_mps } = *row;
    let begin_m = range_m + velocity_mps * sensor.middle_s();
    Target::moving(amplitude, begin_m, velocity_mps).turned(rng.random())
}
