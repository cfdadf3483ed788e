//! What the demonstration measures: targets in front of a lidar, a turntable in front of a
//! velocimeter.

pub mod cars;
pub mod drive;
pub mod fan;
pub mod flow;
pub mod radar;
pub mod traffic;
pub mod vibration;
pub mod wind;

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::{self, Config, SPEED_OF_LIGHT};
use picket_dsp::{Chirp, Mixing, Shape};
use picket_simulator::scene::{Source, Target, Waveform};
use picket_simulator::{Run, Scene, Truth, Value};
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

impl Bars {
    /// That of the range (0), or of the velocity (1).
    pub const fn of(&self, what: usize) -> f64 {
        if what == 0 { self.range_m } else { self.velocity_mps }
    }
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
        scene: config::Scene::Chirp(Chirp {
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
    /// A sensor with this laser.
    pub fn of(self, sensor: Scene) -> Scene {
        let Laser { linewidth_hz, sweep_error: curvature } = self;
        let waveform = sensor.waveform.map(|wave| Waveform { linewidth_hz, curvature, ..wave });
        Scene { waveform, ..sensor }
    }
}

/// The velocimeter: 1550 nm along the rim's motion, a sample each 0.1 us.
pub fn turntable() -> Config {
    Config {
        scene: config::Scene::Doppler {
            wavelength_m: 1550e-9,
            angle_rad: 0.0,
            mixing: Mixing::RxConjTx,
        },
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

/// The sensor of a configuration, with nothing in front of it and without noise, for this many laps with a record of `n` samples in each segment. Chirps
/// begin `period_s` seconds apart, or follow one another where that is less.
pub fn sensor<R: Record>(config: &Config, n: usize, period_s: f64, laps: usize) -> Scene {
    let mut sensor = Scene { rate_hz: config.rate_hz, ..Scene::default() };
    let record_s = n as f64 / config.rate_hz;
    let (mixing, waveform, lap_s) = match config.scene {
        config::Scene::Chirp(chirp) => {
            let ramps_s = chirp.shape.segments().len() as f64 * chirp.duration_s;
            (chirp.mixing, Waveform::from_chirp(&chirp, n, period_s), ramps_s.max(period_s))
        }
        config::Scene::Doppler { wavelength_m, mixing, .. } => {
            let carrier_hz = SPEED_OF_LIGHT / wavelength_m;
            (mixing, Waveform { carrier_hz, ..Waveform::default() }, record_s)
        }
        _ => (Mixing::default(), Waveform::default(), record_s),
    };
    sensor.waveform = Some(waveform);
    sensor.seconds = laps as f64 * lap_s;
    sensor.receiver.iq = R::IQ;
    sensor.receiver.mixing = mixing.into();
    sensor.converter.unsigned = config.codes.rails().0 == 0;
    sensor
}

/// A target with an echo of this amplitude, codes.
pub fn echo(amplitude: f64, range_m: impl Into<Value>, velocity_mps: impl Into<Value>) -> Target {
    let (range_m, velocity_mps) = (range_m.into(), velocity_mps.into());
    Target { range_m, velocity_mps, amplitude: Some(amplitude.into()), ..Target::default() }
}

/// A sensor with these before it, the first of them this many decibels above the noise of a sample.
pub fn before(sensor: Scene, sources: Vec<Source>, snr_db: f64) -> Scene {
    let mut scene = Scene { sources, ..sensor };
    scene.receiver.noise.snr_db = Some(snr_db.into());
    scene
}

impl Row {
    /// A sensor's scene with its target: where the row says at the moment to which the sensor's range refers. Its surface is rough where a beam's
    /// spot has a diameter.
    pub fn scene(
        &self,
        sensor: &Scene,
        n: usize,
        (amplitude, snr_db): (f64, f64),
        spot_m: Option<f64>,
    ) -> Scene {
        let ends = [0, sensor.segments() - 1].map(|index| sensor.start_s(index, n));
        let middle_s =
            f64::midpoint(ends[0], ends[1]) + 0.5 * (n.max(1) - 1) as f64 / sensor.rate_hz;
        // A continuous wave does not know how far it has gone.
        let range_m = if self.range_m > 0.0 { self.range_m } else { 100.0 };
        let begin_m = range_m + self.velocity_mps * middle_s;
        let target = Target { spot_m, ..echo(amplitude, begin_m, self.velocity_mps) };
        before(sensor.clone(), vec![Source::Target(target)], snr_db)
    }
}

/// A record of a run as the pipeline takes it.
pub fn record<R: Record>(run: &mut Run, index: usize, n: usize) -> Vec<R::Sample> {
    run.record(index, n).into_iter().map(R::from_parts).collect()
}

/// Range and velocity of what is true.
pub fn place(truth: &Truth) -> [f64; 2] {
    [truth.range_m, truth.velocity_mps].map(|value| value.unwrap_or(f64::NAN))
}
