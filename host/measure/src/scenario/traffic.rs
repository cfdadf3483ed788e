//! Thirty seconds in front of the lidar of [`super::lidar`]: four cars whose ranges and speeds cross.

use super::{before, echo, lidar as config, sensor};
use picket_dsp::acquire::sample::Real;
use picket_simulator::Scene;
use picket_simulator::scene::{Source, Target, Vibration};

/// From one chirp to the next.
pub const CYCLE_S: f64 = 0.05;
/// Chirps.
pub const CYCLES: usize = 600;
/// The most acceleration of a car, m/s^2.
pub const ACCELERATION: f64 = 10.0;
/// Cars that swing to and fro: middle and reach in metres, period in seconds.
pub const CARS: [(f64, f64, f64); 4] =
    [(55.0, 40.0, 21.0), (70.0, 45.0, 17.0), (45.0, 30.0, 13.0), (80.0, 35.0, 15.0)];

/// One of [`CARS`], somewhere on its way.
pub fn car((middle_m, reach_m, period_s): (f64, f64, f64)) -> Source {
    let vibration = vec![Vibration {
        amplitude_m: reach_m.into(),
        frequency_hz: (1.0 / period_s).into(),
        phase_turns: (0.0..1.0).into(),
    }];
    let car = Target { vibration, surface: true, ..echo(400.0, middle_m, 0.0) };
    Source::Target(Target { amplitude_at_m: Some(20.0), ..car })
}

/// The cars of a seed, each somewhere else on its way, for records of `n` samples. One at 20 m is `snr_db` above the noise; its echo falls with
/// the range.
pub fn scene(seed: u64, n: usize, snr_db: f64) -> Scene {
    let sensor = Scene { seed, ..sensor::<Real>(&config(), n, CYCLE_S, CYCLES) };
    before(sensor, CARS.map(car).to_vec(), snr_db)
}
