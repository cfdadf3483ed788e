//! Ranges by phase: the cycle is right where it is said to be sure, and among the candidates where it is not.

use picket_claims::scenes::{Kind, amplitude, deviation};
use picket_claims::{Asked, Case, Event, Path, hold_together, samples, told};
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::{Codes, Config, Outcome, Pipeline, Segment, Stamp};
use picket_simulator::scene::{Receiver, Shape, Source, Target, Waveform};
use picket_simulator::{Draw, Scene};

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

/// Sensors that are calibrated by a target at a distance that is known with an error, whose sweeps are known with one: twice the uncertainty
/// covers 95 % of the errors of the ranges by frequency and by phase.
#[test]
fn a_calibrations_errors_are_in_the_uncertainty() {
    const SENSORS: u64 = 1500;
    const RAMPS: usize = 4;
    let (known_m, sigma_m, sigma_slope_ppm) = (0.5, 5e-6, 20.0);
    println!("seeds: the numbers of the sensors, 0 to {SENSORS}");
    let ([mut sure, mut covered, mut covered_by_frequency], mut scatter) = ([0u64; 3], [0.0; 2]);
    for sensor in 0..SENSORS {
        let mut draw = Draw::new(64, sensor);
        let turns = draw.share();
        let slope = 1.0 + 1e-6 * sigma_slope_ppm * draw.normal();
        let cable_m = 0.1 * draw.normal();
        let true_known_m = known_m + sigma_m * draw.normal();
        let range_m = draw.between(6.0, 10.0);
        let told_of = scene((60.0, 5.0), Shape::Sawtooth, Iq, 1024);
        let chirp = told(&told_of).unwrap();
        let config = Config::new(told_of.rate_hz, Codes::signed::<12>());
        let mut pipeline = Box::new(Pipeline::<picket_dsp::Iq, 1024>::new(config.plan().unwrap()));
        let mut lines = |range_m: f64, ramps: usize, seed: u64| {
            let mut true_one = told_of.clone();
            (true_one.seed, true_one.seconds) = (seed, (ramps + 1) as f64 * 1.1e-3);
            true_one.receiver.noise.rms = Some(deviation(900.0, 15.0).into());
            let mut one = target((range_m, range_m), 0.0, 900.0);
            one.velocity_mps = 0.0.into();
            one.range_m = (range_m + cable_m).into();
            one.phase_turns = turns.into();
            true_one.sources = vec![Source::Target(one)];
            if let Some(waveform) = &mut true_one.waveform {
                waveform.bandwidth_hz *= slope;
            }
            let mut run = true_one.run(0).unwrap();
            let line = |index| {
                let samples = samples::<picket_dsp::Iq, 1024>(&mut run, index);
                let measurement = pipeline.block(&Stamp::default(), &samples);
                pipeline.lines(&measurement, 1)[0]
            };
            (0..ramps).map(line).collect::<Vec<_>>()
        };
        let rate_hz = told_of.rate_hz;
        let ranging = |known| PhaseRanging::new(&chirp, rate_hz, 1024, true, known).unwrap();
        let stated =
            Calibration { sigma_slope_ppm: sigma_slope_ppm as f32, ..Calibration::default() };
        let before = lines(true_known_m, RAMPS, 2 * sensor);
        let calibration = ranging(stated).calibrate_all(&before, known_m, sigma_m as f32).unwrap();
        let [line] = lines(range_m, 1, 2 * sensor + 1)[..] else { panic!("{sensor}") };
        let answer = ranging(calibration).at_rest(Segment::Up, &line);
        let Calibration { sigma_offset_m, .. } = calibration;
        let by_frequency = answer.sigma_by_frequency.hypot(sigma_offset_m);
        let by_frequency = by_frequency.hypot(1e-6 * sigma_slope_ppm as f32 * range_m as f32);
        let off = (answer.by_frequency.to_num::<f64>() - range_m) / f64::from(by_frequency);
        covered_by_frequency += u64::from(off.abs() < 2.0);
        scatter[0] += off * off;
        if answer.is_sure() {
            let off = (answer.range.to_num::<f64>() - range_m) / f64::from(answer.uncertainty);
            (sure, covered) = (sure + 1, covered + u64::from(off.abs() < 2.0));
            scatter[1] += off * off;
        }
    }
    let shares = [covered_by_frequency as f64 / SENSORS as f64, covered as f64 / sure as f64];
    println!(
        "within twice the uncertainty: range by frequency, by phase: {shares:.3?}; mean squares {:.2}, {:.2}; {sure} sure",
        scatter[0] / SENSORS as f64,
        scatter[1] / sure as f64
    );
    assert!(10 * sure > 9 * SENSORS, "{sure}");
    assert!(shares.iter().all(|share| (0.93..=0.97).contains(share)), "{shares:?}");
}

/// What is not known of a sensor is told as a standard deviation of each, and drawn for each of many sensors: twice the uncertainty covers 95 %
/// of the errors.
#[test]
fn the_whole_error_covers_what_is_not_known() {
    const SENSORS: u64 = 1500;
    let known = Uncertainty {
        clock_ppm: 200.0,
        carrier_ppm: 20.0,
        slope_ppm: 300.0,
        angle_rad: 0.0,
        range_offset_m: 2e-3,
        phase_rad: 0.1,
    };
    println!("seeds: the numbers of the sensors, 0 to {SENSORS}");
    let mut covered = [0u64; 3];
    for sensor in 0..SENSORS {
        let mut draw = Draw::new(62, sensor);
        let mut part = |sigma: f32, unit: f64| f64::from(sigma) * unit * draw.normal();
        let clock = part(known.clock_ppm, 1.0);
        let carrier = 1.0 + part(known.carrier_ppm, 1e-6);
        let slope = 1.0 + part(known.slope_ppm, 1e-6);
        let offset_m = part(known.range_offset_m, 1.0);
        let phase = part(known.phase_rad, 1.0);
        let mut shared = Draw::new(63, sensor);
        let (range_m, velocity) = (shared.between(5.0, 30.0), shared.between(3.0, 15.0));
        let noise = Some(deviation(900.0, 20.0).into());
        // Range and velocity of a trapezoid by its frequencies; the range of a target at rest by its phase.
        for moves in [true, false] {
            let shape = if moves { Shape::Trapezoid } else { Shape::Sawtooth };
            let told_of = scene(if moves { (24.0, 0.2) } else { (24.0, 1.0) }, shape, Iq, 1024);
            let mut true_one = told_of.clone();
            true_one.seed = sensor;
            true_one.receiver.noise.rms = noise.clone();
            let speed = if moves { velocity } else { 0.0 };
            let mut one = target((range_m, range_m), 0.0, 900.0);
            one.velocity_mps = speed.into();
            one.range_m = (range_m + if moves { offset_m } else { 0.0 }).into();
            one.phase_turns = (phase / std::f64::consts::TAU).into();
            true_one.sources = vec![Source::Target(one)];
            if let Some(waveform) = &mut true_one.waveform {
                waveform.carrier_hz *= carrier;
                if moves {
                    waveform.bandwidth_hz *= slope;
                    true_one.converter.clock_ppm = clock;
                }
            }
            let chirp = told(&told_of).unwrap();
            let config = Config {
                scene: picket_dsp::Scene::Chirp(chirp),
                ..Config::new(told_of.rate_hz, Codes::signed::<12>())
            };
            let mut pipeline =
                Box::new(Pipeline::<picket_dsp::Iq, 1024>::new(config.plan().unwrap()));
            let mut run = true_one.run(0).unwrap();
            let mut found = None;
            for (index, &segment) in chirp.shape.segments().iter().enumerate() {
                let stamp = Stamp { segment, sequence: index as u32, ..Stamp::default() };
                let measurement =
                    pipeline.block(&stamp, &samples::<picket_dsp::Iq, 1024>(&mut run, index));
                if let (Outcome::Target(target), true) = (measurement.result, moves) {
                    let middle = run.truth_of_lap(0, 0, 1024);
                    found = Some((
                        known.of_target(&target, 0.0).total(),
                        target.range,
                        target.velocity,
                        middle,
                    ));
                } else if !moves {
                    let none = Calibration { sigma_phase_rad: 0.1, ..Calibration::default() };
                    let ranging =
                        PhaseRanging::new(&chirp, told_of.rate_hz, 1024, true, none).unwrap();
                    let answer = ranging.at_rest(Segment::Up, &pipeline.lines(&measurement, 1)[0]);
                    let wavelength_m = chirp.wavelength_m as f32;
                    let [range, _] = known.of_phase_range(&answer, wavelength_m).total();
                    covered[2] += u64::from(
                        (answer.range.to_num::<f64>() - range_m).abs() < 2.0 * f64::from(range),
                    );
                }
            }
            if let Some(([sigma, sigma_velocity], range, speed, truth)) = found {
                let off = range.to_num::<f64>() - (truth.range_m.unwrap() - offset_m);
                covered[0] += u64::from(off.abs() < 2.0 * f64::from(sigma));
                let off = speed.unwrap_or_default().to_num::<f64>() - velocity;
                covered[1] += u64::from(off.abs() < 2.0 * f64::from(sigma_velocity));
            }
        }
    }
    let shares = covered.map(|covered| covered as f64 / SENSORS as f64);
    println!("within twice the uncertainty: range, velocity, range by phase: {shares:?}");
    assert!(shares.iter().all(|share| (0.93..=0.97).contains(share)), "{shares:?}");
}
