//! Range and velocity from a trapezoid chirp: the lidar of Ye et al. 2022 before a target at 20 m that comes nearer at 60 km/h,
//! without noise. `cargo run --example chirp`.

use picket::{
    Chirp, Codes, Config, ConfigError, Outcome, Pipeline, Real, Scene, Segment, Shape, Stamp,
};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 250e6;
const WAVELENGTH_M: f64 = 1550e-9;
const BANDWIDTH_HZ: f64 = 1e9;
const DURATION_S: f64 = 10e-6;

fn main() -> Result<(), ConfigError> {
    let scene = Scene::Chirp(Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: WAVELENGTH_M,
        bandwidth_hz: BANDWIDTH_HZ,
        duration_s: DURATION_S,
        ..Chirp::default()
    });
    let config = Config { scene, ..Config::new(RATE_HZ, Codes::signed::<12>()) };
    let mut pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
    let (range_m, velocity_mps) = (20.0, 60.0 / 3.6);
    let beat = 2.0 * range_m / picket::config::SPEED_OF_LIGHT * BANDWIDTH_HZ / DURATION_S;
    let doppler = 2.0 * velocity_mps / WAVELENGTH_M;
    // Real samples show no sign: the solver finds it.
    let segments = [
        (Segment::Up, beat - doppler),
        (Segment::Flat, -doppler),
        (Segment::Down, -beat - doppler),
    ];
    for (sequence, (segment, hertz)) in (0..).zip(segments) {
        let samples: [i16; 1024] = std::array::from_fn(|n| {
            (1800.0 * (TAU * hertz / RATE_HZ * n as f64 + 0.4).cos()).round() as i16
        });
        let stamp = Stamp { sequence, segment, ..Stamp::default() };
        let measurement = pipeline.block(stamp, &samples);
        println!("{segment:?}: {}", measurement.tone);
        if let Outcome::Target(target) = measurement.result {
            let (range, velocity) = (target.range, target.velocity);
            println!("range {range:.4} ± {:.4} m", target.sigma_range);
            println!(
                "velocity {velocity:.4} ± {:.4} m/s, {}",
                target.sigma_velocity, target.verdict
            );
            assert!((range.to_num::<f64>() - range_m).abs() < 0.01);
            assert!((velocity.to_num::<f64>() - velocity_mps).abs() < 0.01);
        }
    }
    Ok(())
}
