//! A whole FMCW program: the words of a DMA controller, in chunks of any size, become the records of ramps, and these frames with targets.
//! Here a radar of 24 GHz before a car and a walker stands for the converter, and one chunk is lost. On a board the chunks come from
//! DMA, which the ramp's generator starts. `cargo run --example fmcw`.

use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::frame::{Cells, Frame, FrameConfig};
use picket_dsp::{Chirp, Codes, Config, Format, Framer, Pipeline, Real, Scene, Shape};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 500e3;
/// Samples of a record, and those of its ramp before it: the echo's delay and the filters' settling.
const N: usize = 256;
const GUARD: u32 = 32;
const RAMP: u32 = GUARD + N as u32;
const RAMP_S: f64 = RAMP as f64 / RATE_HZ;
const CARRIER_HZ: f64 = 24e9;
const BANDWIDTH_HZ: f64 = 200e6;
/// Chirps of a frame.
const CHIRPS: usize = 32;
/// Range at time 0, m, and velocity, m/s, positive when approaching.
const TARGETS: [(f64, f64); 2] = [(24.0, 4.0), (9.0, -1.2)];

/// A word of the converter: 12 bits from 0 on.
fn word(sample: u64, noise: &mut u32) -> u16 {
    let (time_s, within_s) = (sample as f64 / RATE_HZ, (sample % u64::from(RAMP)) as f64 / RATE_HZ);
    let mut code = 2048.0;
    for (range_m, velocity_mps) in TARGETS {
        let delay_s = 2.0 * (range_m - velocity_mps * time_s) / SPEED_OF_LIGHT;
        let beat =
            CARRIER_HZ * delay_s + BANDWIDTH_HZ / RAMP_S * delay_s * (within_s - 0.5 * delay_s);
        code += 200.0 * (TAU * beat).cos();
    }
    // The sum of twelve even numbers is nearly a normal one.
    for _ in 0..12 {
        *noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        code += 150.0 * (f64::from(*noise) / 4_294_967_296.0 - 0.5);
    }
    code.round() as u16
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: SPEED_OF_LIGHT / CARRIER_HZ,
        bandwidth_hz: BANDWIDTH_HZ,
        duration_s: RAMP_S,
        guard_s: f64::from(GUARD) / RATE_HZ,
        ..Chirp::default()
    };
    // Each chirp by itself, as for one target: `pipeline.block` has its range. Frames take its spectrum.
    let scene = Scene::Chirp(chirp);
    let config = Config { scene, ..Config::new(RATE_HZ, Codes::unsigned::<12>()) };
    let mut pipeline = Pipeline::<Real, N>::new(config.plan()?);
    // Velocities repeat each 10.8 m/s: the bounds say which.
    let frames = FrameConfig {
        velocity_mps: Some((-5.0, 5.0)),
        ..FrameConfig::new(chirp, RATE_HZ, N, false, CHIRPS, RAMP_S)
    };
    let plan = frames.plan()?;
    let mut cells = vec![[0i16; 2]; plan.cells()]; // a static array on a board: 16 KB
    let mut frame = Frame::new(plan, Cells::Narrow(&mut cells)).ok_or("too few cells")?;
    let mut framer = Framer::<Real, N>::new(Format::unsigned::<12>())
        .with_hop(RAMP)
        .with_guard(GUARD)
        .with_segments(Shape::Sawtooth.segments());
    let (mut clock, mut noise, mut found) = (0, 1, 0);
    for chunk in 0..100 {
        let words: Vec<u16> = (clock..clock + 300).map(|at| word(at, &mut noise)).collect();
        clock += 300;
        if chunk == 10 {
            framer.lost(300);
            continue;
        }
        framer.push(&words, |stamp, samples| {
            if stamp.gap {
                // A frame has no holes.
                frame.clear();
            }
            let measurement = pipeline.block(stamp, samples);
            if stamp.sequence == 0 {
                println!("one chirp: {}", measurement.tone);
            }
            if !frame.push(&pipeline.spectrum().view(), measurement.clipped) {
                return;
            }
            // The stamp is the last ramp's.
            let middle_s = (stamp.clock as f64 - (CHIRPS as f64 - 1.0) / 2.0 * f64::from(RAMP)
                + f64::from(GUARD)
                + 0.5 * (N as f64 - 1.0))
                / RATE_HZ;
            for seen in &frame.targets() {
                let target = &seen.target;
                let velocity = target.velocity.unwrap_or_default();
                println!(
                    "{middle_s:.3} s: {:.4} ± {:.4} m, {velocity:.4} ± {:.4} m/s, {}",
                    target.range, target.sigma_range, target.sigma_velocity, target.verdict
                );
                let right = TARGETS.iter().any(|&(range_m, velocity_mps)| {
                    let now_m = range_m - velocity_mps * middle_s;
                    (target.range.to_num::<f64>() - now_m).abs()
                        < 5.0 * f64::from(target.sigma_range)
                        && (velocity.to_num::<f64>() - velocity_mps).abs()
                            < 5.0 * f64::from(target.sigma_velocity)
                });
                assert!(right);
                found += 1;
            }
        });
    }
    // The 92 chirps behind the loss are two frames.
    assert_eq!(found, 4);
    Ok(())
}
