//! What the demonstration measures: targets in front of a lidar, a turntable in front of a
//! velocimeter.

pub mod drive;
pub mod traffic;
pub mod vibration;

use picket::acquire::codes::Codes;
use picket::acquire::sample::Segment;
use picket::config::{Config, SPEED_OF_LIGHT, Scene};
use picket::solve::chirp::{Mixing, Scale, Shape};
use picket::solve::equations::{Chirp, Equations};
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

/// The lidar's waveform: 1550 nm, 1 GHz in 10 us, 250 MS/s, a trapezoid.
pub fn lidar() -> Config {
    Config {
        scene: Scene::Chirp(Chirp {
            shape: Shape::Trapezoid,
            wavelength_m: 1550e-9,
            bandwidth_hz: 1e9,
            duration_s: 10e-6,
            ..Chirp::default()
        }),
        ..Config::new(250e6, Codes::signed::<12>())
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

/// The segments of a lidar row and the beat of each, in signed cycles per sample.
pub fn lidar_beats(row: &Row, equations: &Equations) -> [(Segment, f64); 3] {
    let [up, flat, down] = beats(row.range_m, row.velocity_mps, equations);
    [(Segment::Up, up), (Segment::Flat, flat), (Segment::Down, down)]
}

/// The beats of the rising ramp, of the flat segment and of the falling ramp, in signed cycles per sample: what the equations solve.
pub fn beats(range_m: f64, velocity_mps: f64, equations: &Equations) -> [f64; 3] {
    let scales = |pair: [Scale; 2]| pair.map(|scale| scale.fixed.to_num::<f64>());
    let ([a, b], [c, d]) = (scales(equations.range), scales(equations.velocity));
    let range_m = range_m * (1.0 + 2.0 * velocity_mps / SPEED_OF_LIGHT);
    let determinant = a * d - b * c;
    let up = (d * range_m - b * velocity_mps) / determinant;
    let down = (a * velocity_mps - c * range_m) / determinant;
    let [flat, weight] = scales(equations.condition);
    [up, -(up + weight * down) / flat, down]
}
