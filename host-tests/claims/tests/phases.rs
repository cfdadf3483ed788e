//! Ranges by phase: the cycle is right where it is said to be sure, and among the candidates where it is not.

use picket_claims::scenes::{Kind, amplitude, deviation};
use picket_claims::{Asked, Case, Event, Path, hold_together};
use picket_simulator::Scene;
use picket_simulator::scene::{Receiver, Shape, Source, Target, Waveform};

use Kind::{Iq, Real};

const C: f64 = 299_792_458.0;

/// Carrier and bandwidth, GHz.
const RADARS: [(f64, f64); 5] = [(24.0, 0.2), (24.0, 1.0), (60.0, 5.0), (77.0, 4.0), (122.0, 7.0)];

/// Ratios of signal to noise per sample.
const LEVELS_DB: [f64; 6] = [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0];

/// A radar whose ramp goes through the bandwidth in a record of a millisecond, after a tenth of that.
fn scene((ghz, bandwidth_ghz): (f64, f64), shape: Shape, kind: Kind, n: usize) -> Scene {
    let (record_s, guard_s) = (1e-3, 0.1e-3);
    let ramp_s = record_s + guard_s;
    let rate_hz = n as f64 / record_s;
    let waveform = Waveform {
        shape,
        carrier_hz: ghz * 1e9,
        bandwidth_hz: bandwidth_ghz * 1e9 * ramp_s / record_s,
        ramp_s,
        guard_s: Some(guard_s),
        samples: n,
        ..Waveform::default()
    };
    let receiver = Receiver { iq: kind == Iq, ..Receiver::default() };
    Scene { rate_hz, seconds: 3.0 * ramp_s, waveform: Some(waveform), receiver, ..Scene::default() }
}

fn target(ranges_m: (f64, f64), speed: f64, amplitude: f64) -> Target {
    Target {
        range_m: (ranges_m.0..ranges_m.1).into(),
        velocity_mps: (-speed..speed).into(),
        amplitude: Some(amplitude.into()),
        phase_turns: 0.0.into(),
        ..Target::default()
    }
}

/// The distance from one cycle to the next over the bound of the range by frequency.
fn apart((ghz, bandwidth_ghz): (f64, f64), kind: Kind, n: usize, snr_db: f64) -> f64 {
    let share = if kind == Iq { 0.151_981_78 } else { 0.303_963_55 };
    let bins = (share / (n as f64 * 10f64.powf(snr_db / 10.0))).sqrt();
    bandwidth_ghz / (ghz + 0.5 * bandwidth_ghz) / bins
}

/// Bounds by which 95 % of the records have odds of 1e4 by Student's distribution with 40 degrees of freedom: an error of 1.96 sigma leaves
/// the neighbour that far behind, also where sigma is estimated a tenth too large.
const ALLOWS: f64 = 8.0;

#[test]
fn a_sure_cycle_is_right_and_others_are_listed() {
    let mut rows = Vec::new();
    for radar in RADARS {
        for kind in Kind::ALL {
            for n in [256, 1024, 4096] {
                for snr_db in LEVELS_DB {
                    let amplitude = amplitude(snr_db);
                    let bin_m = C / (2e9 * radar.1);
                    let ranges_m = (4.0 * bin_m, 0.4 * bin_m * n as f64);
                    let mut scene = scene(radar, Shape::Sawtooth, kind, n);
                    scene.sources = vec![Source::Target(target(ranges_m, 0.0, amplitude))];
                    scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                    let label = format!(
                        "a cycle is right or listed: {} {n}, {} GHz, {} GHz, {snr_db} dB",
                        kind.name(),
                        radar.0,
                        radar.1
                    );
                    let case = Case::new(label, scene, n).by(Path::Phase).trials(200);
                    let case = case.at_most(0.002, Event::FirstOff(5.0));
                    let allowed = apart(radar, kind, n, snr_db) > ALLOWS;
                    rows.push(if allowed {
                        let case = case.at_least(0.95, Event::Sure);
                        case.asks(Asked::ByPhase { least: 0.81, most: 1.21 })
                    } else {
                        case
                    });
                }
            }
        }
    }
    let together = [
        Asked::Share { of: Event::OtherCycle, least: 0.0, most: 1e-4 },
        Asked::Share { of: Event::NotAmong(5.0), least: 0.0, most: 1e-3 },
        Asked::ByPhase { least: 0.81, most: 1.21 },
    ];
    hold_together("a cycle is right or listed, all together", rows, &together);
}

/// Both ramps of a target that moves.
#[test]
fn a_moving_targets_cycle_is_right() {
    let mut rows = Vec::new();
    for radar in RADARS {
        for kind in [Iq, Real] {
            for (speed, snr_db) in [(0.1, 20.0), (2.0, 10.0), (20.0, 20.0), (20.0, 30.0)] {
                let amplitude = amplitude(snr_db);
                let n = 1024;
                let bin_m = C / (2e9 * radar.1);
                let mut scene = scene(radar, Shape::Trapezoid, kind, n);
                let shift = 2.0 * speed * radar.0 * 1e9 / C * 1e-3 + 8.0;
                let ranges_m = (shift * bin_m, 0.3 * bin_m * n as f64);
                scene.sources = vec![Source::Target(target(ranges_m, speed, amplitude))];
                scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                let label = format!(
                    "a moving target's cycle is right: {} {n}, {} GHz, {} GHz, {speed} m/s, {snr_db} dB",
                    kind.name(),
                    radar.0,
                    radar.1
                );
                let case = Case::new(label, scene, n).by(Path::Phase).trials(100);
                rows.push(case.at_most(0.002, Event::FirstOff(5.0)));
            }
        }
    }
    let together = [
        Asked::Share { of: Event::OtherCycle, least: 0.0, most: 1e-4 },
        Asked::Share { of: Event::NotAmong(5.0), least: 0.0, most: 1e-3 },
        Asked::ByPhase { least: 0.81, most: 1.21 },
    ];
    hold_together("a moving target's cycle is right, all together", rows, &together);
}

/// A second echo of a tenth of the amplitude, 0.7 to 3 cells off.
#[test]
fn a_second_echo_costs_odds_and_not_truth() {
    let mut rows = Vec::new();
    for radar in RADARS {
        for snr_db in [0.0, 10.0, 20.0, 30.0] {
            for cells in [0.7, 1.0, 1.5, 2.0, 3.0] {
                let (amplitude, n) = (0.9 * amplitude(snr_db), 1024);
                let bin_m = C / (2e9 * radar.1);
                let mut scene = scene(radar, Shape::Sawtooth, Iq, n);
                let near_m = 40.3 * bin_m;
                let one = target((near_m, near_m * 1.0001), 0.0, amplitude);
                let far_m = near_m + cells * bin_m;
                let other = Target {
                    phase_turns: (0.0..1.0).into(),
                    ..target((far_m, far_m * 1.0001), 0.0, 0.1 * amplitude)
                };
                scene.sources = vec![Source::Target(one), Source::Target(other)];
                scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                let label = format!(
                    "a second echo costs no truth: {} GHz, {} GHz, {cells} cells, {snr_db} dB",
                    radar.0, radar.1
                );
                let case = Case::new(label, scene, n).by(Path::Phase).trials(100);
                rows.push(case.at_most(0.01, Event::Wrong(5.0)));
            }
        }
    }
    let together = [Asked::Share { of: Event::FirstOff(5.0), least: 0.0, most: 0.01 }];
    hold_together("a second echo costs no truth, all together", rows, &together);
}
