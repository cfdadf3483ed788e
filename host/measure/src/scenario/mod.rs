//! What the demonstration measures: targets in front of a lidar, a turntable in front of a
//! velocimeter.

pub mod drive;
pub mod fan;
pub mod flow;
pub mod radar;
pub mod traffic;
pub mod vibration;
pub mod wind;

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Real, Record};
use picket_dsp::config::{Config, SPEED_OF_LIGHT, Scene};
use picket_dsp::{Chirp, Mixing, Shape};
use picket_simulator::{Receiver, Sensor, Speckle, Target};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// A truth to be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Metres; 0 for the turntable.
    pub range_m: f64,
    /// Metres per second, positive when approaching.
    pub velocity_mps: f64,
}

/// The errors that the papers allow themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bars {
    /// Metres.
    pub range_m: f64,
    /// Metres per second.
    pub velocity_mps: f64,
}

/// Distance in metres and speed in km/h, as in Table 3 of Ye et al. 2022 (1 to 112 m, 10 to 120 km/h). In the first five
/// the Doppler shift exceeds the range beat, where the paper's own solution fails.
const TABLE3: [(f64, f64); 14] = [
    (1.0, 10.0),
    (5.0, 20.0),
    (20.0, 60.0),
    (20.0, 90.0),
    (50.0, 120.0),
    (5.0, 5.0),
    (10.0, 10.0),
    (20.0, 20.0),
    (50.0, 60.0),
    (50.0, 90.0),
    (80.0, 30.0),
    (80.0, 120.0),
    (100.0, 60.0),
    (112.0, 90.0),
];

/// The lidar's accuracy by its paper: 5 cm and 0.16 km/h.
pub const LIDAR_BARS: Bars = Bars { range_m: 0.05, velocity_mps: 0.16 / 3.6 };

/// The velocimeter's by its paper: 2 mm/s.
pub const TURNTABLE_BARS: Bars = Bars { range_m: 0.0, velocity_mps: 2e-3 };

/// The lidar's waveform: 1550 nm, 1 GHz in 10 us, 250 MS/s, a trapezoid. Its records of 1024 samples lie in the middle of the
/// ramps, where the echo of 112 m, 187 samples late, is from the same ramp.
pub fn lidar() -> Config {
    const RATE_HZ: f64 = 250e6;
    const DURATION_S: f64 = 10e-6;
    Config {
        scene: Scene::Chirp(Chirp {
            shape: Shape::Trapezoid,
            wavelength_m: 1550e-9,
            bandwidth_hz: 1e9,
            duration_s: DURATION_S,
            guard_s: (DURATION_S - 1024.0 / RATE_HZ) / 2.0,
            ..Chirp::default()
        }),
        ..Config::new(RATE_HZ, Codes::signed::<12>())
    }
}

/// A laser that is not what its user takes it for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Laser {
    /// Width of its line at half of its height, Hz.
    pub linewidth_hz: f64,
    /// How far the middle of a ramp lies above the straight line, as a share of the bandwidth.
    pub sweep_error: f64,
}

impl Laser {
    /// What takes the lidar's records of `n` samples, by a configuration that takes the laser for a perfect one.
    pub fn sensor(self, config: &Config, n: usize) -> Sensor {
        let scene = match config.scene {
            Scene::Chirp(chirp) => {
                Scene::Chirp(Chirp { sweep_curvature: self.sweep_error, ..chirp })
            }
            other => other,
        };
        let mut sensor = sensor::<Real>(&Config { scene, ..*config }, n, 0.0);
        sensor.waveform.linewidth_hz = self.linewidth_hz;
        sensor
    }
}

/// The velocimeter: 1550 nm along the rim's motion, a sample each 0.1 us.
pub fn turntable() -> Config {
    Config {
        scene: Scene::Doppler { wavelength_m: 1550e-9, angle_rad: 0.0, mixing: Mixing::RxConjTx },
        ..Config::new(10e6, Codes::signed::<12>())
    }
}

/// The lidar's rows, each approaching and receding.
pub fn table3() -> Vec<Row> {
    let both = |(range_m, kmh): (f64, f64)| {
        [1.0, -1.0].map(|sign| Row { range_m, velocity_mps: sign * kmh / 3.6 })
    };
    TABLE3.into_iter().flat_map(both).collect()
}

/// The turntable's radius in metres.
pub const TURNTABLE_RADIUS_M: f64 = 0.16;

/// Rim speeds of the turntable, 10 to 210 turns a minute in both directions.
pub fn turntable_rows() -> Vec<Row> {
    let speed = |rpm: f64| rpm / 60.0 * TAU * TURNTABLE_RADIUS_M;
    (0..11)
        .map(|step| 10.0 + 20.0 * f64::from(step))
        .flat_map(|rpm| [speed(rpm), -speed(rpm)])
        .map(|velocity_mps| Row { range_m: 0.0, velocity_mps })
        .collect()
}

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

impl Row {
    /// Its target: where the row says at the moment to which the sensor's range refers, with any phase.
    pub fn target(&self, sensor: &Sensor, amplitude: f64, rng: &mut ChaCha8Rng) -> Target<'static> {
        let Row { range_m, velocity_mps } = *self;
        let begin_m = range_m + velocity_mps * sensor.middle_s();
        Target::moving(amplitude, begin_m, velocity_mps).turned(rng.random())
    }

    /// The row's target with a rough surface that passes below a spot of this diameter, in the sensor's only record.
    pub fn rough(
        &self,
        sensor: &Sensor,
        amplitude: f64,
        spot_m: f64,
        rng: &mut ChaCha8Rng,
    ) -> Target<'static> {
        let target = self.target(sensor, amplitude, rng);
        let span_s = (0.0, sensor.n as f64 / sensor.receiver.rate_hz);
        let normal = || rng.sample(StandardNormal);
        target.rough(Speckle::from_spot(span_s, self.velocity_mps.abs(), spot_m, normal))
    }

    /// The codes of a segment's record of its target alone.
    pub fn codes<R: Record>(
        &self,
        sensor: &Sensor,
        segment: usize,
        (amplitude, snr_db): (f64, f64),
        rng: &mut ChaCha8Rng,
    ) -> Vec<R::Sample> {
        let target = self.target(sensor, amplitude, rng);
        received::<R>(sensor, segment, target, snr_db, rng)
    }
}

/// The codes of a segment's record of one target, this many decibels above the noise.
pub fn received<R: Record>(
    sensor: &Sensor,
    segment: usize,
    target: Target,
    snr_db: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<R::Sample> {
    let receiver = sensor.receiver.with_snr(target.amplitude, snr_db);
    codes::<R>(&sensor.clone().received_by(receiver), &[target], (0, segment), rng)
}
