//! Range and velocity from a trapezoid chirp: the lidar of Ye et al. 2022 before a target at 20 m that comes nearer at 60 km/h,
//! without noise. `cargo run --example chirp`.

use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::{
    Chirp, Codes, Config, ConfigError, Outcome, Pipeline, Real, Scene, Segment, Shape, Stamp,
};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 250e6;
const WAVELENGTH_M: f64 = 1550e-9;
const BANDWIDTH_HZ: f64 = 1e9;
/// Of each segment. Its first microsecond is not measured: the echo of the segment before is still under way.
const DURATION_S: f64 = 10e-6;
const GUARD_S: f64 = 1e-6;

/// What the transmitter's phase has turned beyond that of its lowest carrier, cycles: its frequency rises, stays and falls.
fn swept(t: f64) -> f64 {
    let ramp = |s: f64| BANDWIDTH_HZ / DURATION_S * s * s / 2.0;
    let segments = [
        ramp(t.min(DURATION_S)),
        BANDWIDTH_HZ * (t - DURATION_S).clamp(0.0, 2.0 * DURATION_S),
        -ramp((t - 2.0 * DURATION_S).max(0.0)),
    ];
    segments.iter().sum()
}

fn main() -> Result<(), ConfigError> {
    let scene = Scene::Chirp(Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: WAVELENGTH_M,
        bandwidth_hz: BANDWIDTH_HZ,
        duration_s: DURATION_S,
        guard_s: GUARD_S,
        ..Chirp::default()
    });
    let config = Config { scene, ..Config::new(RATE_HZ, Codes::signed::<12>()) };
    let mut pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
    let (range_m, velocity_mps) = (20.0, 60.0 / 3.6);
    // The range that is measured is the one in the middle of the chirp's records.
    let middle_s = DURATION_S + GUARD_S + 511.5 / RATE_HZ;
    // The beat: the phase that is sent, less the phase that comes back.
    let beat = |t: f64| {
        let delay = 2.0 * (range_m - velocity_mps * (t - middle_s)) / SPEED_OF_LIGHT;
        SPEED_OF_LIGHT / WAVELENGTH_M * delay + swept(t) - swept(t - delay)
    };
    for (sequence, segment) in (0..).zip([Segment::Up, Segment::Flat, Segment::Down]) {
        let begin_s = f64::from(sequence) * DURATION_S + GUARD_S;
        // Real samples show no sign: the solver finds it.
        let samples: [i16; 1024] = std::array::from_fn(|n| {
            (1800.0 * (TAU * beat(begin_s + n as f64 / RATE_HZ)).cos()).round() as i16
        });
        let stamp = Stamp { sequence, segment, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &samples);
        println!("{segment:?}: {}", measurement.tone);
        if let Outcome::Target(target) = measurement.result {
            let (range, velocity) = (target.range, target.velocity.unwrap_or_default());
            println!("range {range:.7} ± {:.7} m", target.sigma_range);
            println!(
                "velocity {velocity:.7} ± {:.7} m/s, {}",
                target.sigma_velocity, target.verdict
            );
            assert!((range.to_num::<f64>() - range_m).abs() < 5.0 * f64::from(target.sigma_range));
            let error = velocity.to_num::<f64>() - velocity_mps;
            assert!(error.abs() < 5.0 * f64::from(target.sigma_velocity));
        }
    }
    Ok(())
}
