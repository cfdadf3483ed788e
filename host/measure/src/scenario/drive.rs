//! Thirty seconds in front of a radar: a car comes, brakes, stands and leaves; another comes towards it.

use super::{echo, sensor};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{Config, Following, SPEED_OF_LIGHT, Scene as Waveform};
use picket_dsp::{Chirp, Shape};
use picket_simulator::scene::{Change, Source, Target};
use picket_simulator::{Scene, Value};
use std::f64::consts::TAU;

/// From one chirp to the next.
pub const CYCLE_S: f64 = 0.05;
/// Chirps.
pub const CYCLES: usize = 600;

/// When the signal is cut off: shorter than a track lives without it, and longer.
const DROPOUTS: [(f64, f64); 2] = [(15.0, 15.2), (22.0, 22.5)];
/// What is left of it then, dB.
const CUT_DB: f64 = -300.0;
/// How much weaker the other car is, dB, and when it is there, s: from, and for so long.
const OTHER_DB: f64 = -4.0;
const OTHER_S: [f64; 2] = [2.0, 10.0];
/// The noise of a sample, in codes.
const NOISE: f64 = 60.0;

/// A 77 GHz radar with 303 MHz in 1.01 ms at 1.024 MS/s, that follows two tones in each segment. A record of 1 ms begins when the
/// echoes of the ramp before have passed.
pub fn config() -> Config {
    Config {
        scene: Waveform::Chirp(Chirp {
            shape: Shape::Trapezoid,
            wavelength_m: SPEED_OF_LIGHT / 77e9,
            bandwidth_hz: 303e6,
            duration_s: 1.01e-3,
            guard_s: 10e-6,
            ..Chirp::default()
        }),
        following: Following { rate_bins: 4.0, most: 2, ..Following::default() },
        ..Config::new(1.024e6, Codes::signed::<12>())
    }
}

/// The car's level over the noise in dB, over time: it swings, and is cut off.
fn level() -> Value {
    let level = |t: f64| 5.0 + 8.0 * (TAU * t / 11.0).sin();
    let cut = |t: f64| DROPOUTS.iter().any(|(from, to)| (*from..=*to).contains(&t));
    let steps = (0..=120).map(|step| 0.25 * f64::from(step)).filter(|t| !cut(*t));
    let mut points: Vec<[f64; 2]> = steps.map(|t| [t, level(t)]).collect();
    for (from, to) in DROPOUTS {
        let ends =
            [(from - 1e-6, level(from)), (from, CUT_DB), (to - 1e-6, CUT_DB), (to, level(to))];
        points.extend(ends.map(|(time, db)| [time, db]));
    }
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Value::Over(points)
}

/// The drive: both cars, for records of `n` samples.
pub fn scene(seed: u64, n: usize) -> Scene {
    // Twelve seconds pass until it stands, five of them at rest.
    let speeds = [[0.0, 12.0], [4.0, 12.0], [8.0, 0.0], [13.0, 0.0], [19.0, -12.0]];
    let changes = vec![Change::Level { db: level() }];
    let amplitude = NOISE * 2f64.sqrt();
    let car = echo(amplitude, 100.0, Value::Over(speeds.to_vec()));
    let [from_s, for_s] = OTHER_S.map(Value::from);
    let other = Target {
        amplitude: None,
        level_db: Some(OTHER_DB.into()),
        changes: [changes.clone(), vec![Change::On { from_s, for_s }]].concat(),
        ..echo(0.0, 4.0, -8.0)
    };
    let sources = vec![Source::Target(Target { changes, ..car }), Source::Target(other)];
    let mut scene = Scene { seed, sources, ..sensor::<Real>(&config(), n, CYCLE_S, CYCLES) };
    scene.receiver.noise.rms = Some(NOISE.into());
    scene
}

/// The signal-to-noise ratio of an echo; none while it is cut off.
pub fn snr_db(amplitude: f64) -> Option<f64> {
    let snr_db = 20.0 * (amplitude / (NOISE * 2f64.sqrt())).log10();
    (snr_db > -100.0).then_some(snr_db)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::place;

    #[test]
    fn the_car_comes_brakes_stands_and_leaves() {
        let run = scene(1, 1024).run(0).unwrap();
        let truth = |source: usize, t: f64| run.truth_of_lap(source, (t / CYCLE_S) as usize, 1024);
        let moment_s = truth(0, 0.0).time_s;
        for (t, range_m, velocity_mps) in [
            (0.0, 100.0, 12.0),
            (4.0, 52.0, 12.0),
            (10.0, 28.0, 0.0),
            (19.0, 64.0, -12.0),
            (29.0, 184.0, -12.0),
        ] {
            let [range, velocity] = place(&truth(0, t));
            assert!((range - (range_m - velocity_mps * moment_s)).abs() < 1e-3, "{t}: {range}");
            assert!((velocity - velocity_mps).abs() < 1e-2, "{t}: {velocity}");
        }
        // They pass each other.
        let apart = |t: f64| place(&truth(0, t))[0] - place(&truth(1, t))[0];
        assert!(apart(3.0) > 0.0 && apart(7.0) < 0.0);
        let snr = |source: usize, t: f64| snr_db(truth(source, t).amplitude);
        assert_eq!(
            (snr(0, 15.1), snr(1, 22.3), snr(1, 1.9), snr(1, 12.0)),
            (None, None, None, None)
        );
        assert!(
            (snr(0, 2.75).unwrap() - 13.0).abs() < 0.05
                && (snr(1, 2.75).unwrap() - 9.0).abs() < 0.05
        );
    }
}
