//! Targets of frames of chirps: range and velocity within their sigmas and near the bound, from the transmitter's phase.

use picket_claims::scenes::{Kind, amplitude, deviation};
use picket_claims::{Asked, Case, Event, Path, hold, hold_together};
use picket_dsp::Config;
use picket_simulator::Scene;
use picket_simulator::scene::{Change, Receiver, Shape, Source, Target, Vibration, Waveform};
use std::f64::consts::TAU;

use Kind::{Iq, Real};

const C: f64 = 299_792_458.0;

/// A radar: carrier in GHz, bandwidth in MHz of a record, the record in us, and the period in us.
#[derive(Clone, Copy, Debug)]
struct Radar {
    ghz: f64,
    mhz: f64,
    record_us: f64,
    period_us: f64,
}

const fn radar(ghz: f64, mhz: f64, record_us: f64, period_us: f64) -> Radar {
    Radar { ghz, mhz, record_us, period_us }
}

const RADARS: [Radar; 5] = [
    radar(77.0, 300.0, 100.0, 120.0),
    radar(24.0, 200.0, 250.0, 300.0),
    radar(60.0, 1000.0, 100.0, 150.0),
    radar(60.0, 4000.0, 100.0, 200.0),
    radar(122.0, 5000.0, 100.0, 150.0),
];

impl Radar {
    fn scene(&self, kind: Kind, n: usize, chirps: usize, targets: Vec<Target>) -> Scene {
        let (record_s, guard_s) = (1e-6 * self.record_us, 2e-6);
        let ramp_s = record_s + guard_s;
        let waveform = Waveform {
            shape: Shape::Sawtooth,
            carrier_hz: self.ghz * 1e9,
            bandwidth_hz: self.mhz * 1e6 * ramp_s / record_s,
            ramp_s,
            guard_s: Some(guard_s),
            period_s: 1e-6 * self.period_us,
            samples: n,
            ..Waveform::default()
        };
        let receiver = Receiver { iq: kind == Iq, ..Receiver::default() };
        let sources = targets.into_iter().map(Source::Target).collect();
        let seconds = waveform.period_s * (chirps as f64 + 1.0);
        let rate_hz = n as f64 / record_s;
        Scene { rate_hz, seconds, waveform: Some(waveform), sources, receiver, ..Scene::default() }
    }

    /// Half of the distance between aliases, m/s.
    fn half_alias(&self) -> f64 {
        C / (self.ghz * 1e9 + self.mhz * 0.5e6) / 4.0 / (1e-6 * self.period_us)
    }

    /// The sizes of a cell, m and m/s.
    fn cell(&self, chirps: usize) -> [f64; 2] {
        [C / (2e6 * self.mhz), 2.0 * self.half_alias() / chirps as f64]
    }

    /// A case that is told the unambiguous velocities.
    fn told(&self, case: Case) -> Case {
        let bound = 0.999 * self.half_alias();
        case.told(|config: &mut Config| config.velocity_mps = Some((-bound, bound)))
    }

    fn name(&self) -> String {
        format!(
            "{} GHz, {} MHz in {} us every {}",
            self.ghz, self.mhz, self.record_us, self.period_us
        )
    }
}

fn target(range_m: (f64, f64), velocity_mps: (f64, f64), amplitude: f64) -> Target {
    Target {
        range_m: (range_m.0..range_m.1).into(),
        velocity_mps: (velocity_mps.0..velocity_mps.1).into(),
        amplitude: Some(amplitude.into()),
        ..Target::default()
    }
}

/// One target anywhere, within the unambiguous velocities; `None` where it is too weak for every frame.
fn one_target(
    radar: &Radar,
    kind: Kind,
    (n, chirps): (usize, usize),
    snr_db: f64,
    claim: &str,
) -> Option<Case> {
    let gain = 10.0 * ((n * chirps) as f64).log10();
    if snr_db + gain < 17.0 {
        return None;
    }
    let amplitude = amplitude(snr_db);
    let [bin_m, _] = radar.cell(chirps);
    let share = if kind == Iq { 0.4 } else { 0.35 };
    let speed = 0.9 * radar.half_alias();
    let doppler = 2.0 * speed * radar.ghz * 1e9 / C * 1e-6 * radar.record_us;
    let ranges = ((4.0 + doppler) * bin_m, share * n as f64 * bin_m);
    let mut scene = radar.scene(kind, n, chirps, vec![target(ranges, (-speed, speed), amplitude)]);
    scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
    let label = format!("{claim}: {} {n} x {chirps}, {}, {snr_db} dB", kind.name(), radar.name());
    let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(24);
    let case = radar.told(case);
    let case = case.at_most(0.002, Event::Off(5.0)).at_least(0.98, Event::Good);
    let case = case.square(0.72, 1.33).asks(Asked::Square { quantity: 1, least: 0.72, most: 1.33 });
    let case = case.asks(Asked::OverBound { quantity: 0, most: 1.1 });
    Some(case.asks(Asked::OverBound { quantity: 1, most: 1.1 }).never(Event::More))
}

/// What all of them show together.
const RIGHT: [Asked; 7] = [
    Asked::Share { of: Event::Off(5.0), least: 0.0, most: 0.002 },
    Asked::Share { of: Event::Good, least: 0.98, most: 1.0 },
    Asked::Square { quantity: 0, least: 0.72, most: 1.33 },
    Asked::Square { quantity: 1, least: 0.72, most: 1.33 },
    Asked::OverBound { quantity: 0, most: 1.1 },
    Asked::OverBound { quantity: 1, most: 1.1 },
    Asked::Share { of: Event::More, least: 0.0, most: 0.0 },
];

#[test]
fn a_frames_target_is_right_within_its_sigmas() {
    let mut rows = Vec::new();
    for radar in &RADARS {
        for kind in [Iq, Real] {
            for shape in [(256, 64), (128, 32), (512, 128)] {
                for snr_db in [-20.0, -10.0, 0.0, 10.0, 30.0] {
                    rows.extend(one_target(
                        radar,
                        kind,
                        shape,
                        snr_db,
                        "a frame's target is right",
                    ));
                }
            }
        }
    }
    hold_together("a frame's target is right, all together", rows, &RIGHT);
}

/// The same of frames of few and of many chirps, short and long.
#[test]
fn frames_of_every_shape_are_right_within_their_sigmas() {
    let mut rows = Vec::new();
    for radar in [&RADARS[0], &RADARS[3]] {
        for kind in [Iq, Real] {
            for n in [128, 256, 512, 1024] {
                for chirps in [8, 16, 64, 256] {
                    for snr_db in [-10.0, 10.0] {
                        let claim = "frames of every shape";
                        // As many samples of each shape.
                        let trials = ((1 << 17) / (n * chirps) as u64).clamp(2, 24);
                        let case = one_target(radar, kind, (n, chirps), snr_db, claim);
                        rows.extend(case.map(|case| case.trials(trials)));
                    }
                }
            }
        }
    }
    hold_together("frames of every shape, all together", rows, &RIGHT);
}

/// A target whose speed changes evenly has the velocity of the frame's middle, as one of constant speed.
#[test]
fn an_accelerating_target_is_right() {
    let (n, chirps) = (256, 64);
    let mut rows = Vec::new();
    for radar in [&RADARS[0], &RADARS[2]] {
        for kind in [Iq, Real] {
            // What the acceleration adds to the turn from the middle of the frame to its ends, turns.
            for turns in [0.01, 0.05, 0.15] {
                for snr_db in [-10.0, 10.0, 20.0] {
                    let amplitude = amplitude(snr_db);
                    let [bin_m, row_mps] = radar.cell(chirps);
                    let seconds = 1e-6 * radar.period_us * chirps as f64;
                    let change = 8.0 * turns * row_mps;
                    let (low, high) = (-9.3 * row_mps, -9.3 * row_mps + change);
                    let one = Target {
                        velocity_mps: vec![[0.0, low], [seconds, high]].into(),
                        ..target((20.0 * bin_m, 60.0 * bin_m), (0.0, 0.0), amplitude)
                    };
                    let mut scene = radar.scene(kind, n, chirps, vec![one]);
                    scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                    let label = format!(
                        "an accelerating target is right: {}, {}, {turns} turns, {snr_db} dB",
                        kind.name(),
                        radar.name()
                    );
                    let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(24);
                    rows.push(radar.told(case));
                }
            }
        }
    }
    hold_together("an accelerating target is right, all together", rows, &RIGHT);
}

/// What an echo that swings, or an amplifier at its end, adds to a frame is no `good` target, and the target itself stays right.
#[test]
fn what_a_louder_target_makes_is_no_target() {
    const FAULTS: [&str; 5] = ["level by 5 %", "level by 30 %", "phase", "amplifier", "two beyond"];
    let (n, chirps) = (256, 64);
    let [mut levels, mut phases, mut amplified] = [const { Vec::new() }; 3];
    for radar in [&RADARS[0], &RADARS[2]] {
        for kind in [Iq, Real] {
            for fault in FAULTS {
                for snr_db in [0.0, 10.0, 20.0] {
                    let amplitude = amplitude(snr_db);
                    let [bin_m, row_mps] = radar.cell(chirps);
                    let at = |bin: f64, row: f64| {
                        let of =
                            |place: f64, cell: f64| ((place - 2.0) * cell, (place + 2.0) * cell);
                        target(of(bin, bin_m), of(row, row_mps), amplitude)
                    };
                    // Turns of the swing in a frame, and how often in a second.
                    let per_frame = 5.3;
                    let rate_hz = per_frame / (1e-6 * radar.period_us * chirps as f64);
                    let am =
                        |depth: f64| Change::Am { depth: depth.into(), rate_hz: rate_hz.into() };
                    let mut targets = vec![at(34.0, -7.0)];
                    match fault {
                        "level by 5 %" => targets[0].changes = vec![am(0.05)],
                        "level by 30 %" => targets[0].changes = vec![am(0.3)],
                        "phase" => {
                            // A tenth of a radian.
                            let amplitude_m = 0.1 * C / (radar.ghz * 1e9) / (2.0 * TAU);
                            targets[0].vibration = vec![Vibration {
                                amplitude_m: amplitude_m.into(),
                                frequency_hz: rate_hz.into(),
                                phase_turns: (0.0..1.0).into(),
                            }];
                        }
                        "amplifier" => {}
                        _ => {
                            let level = Some((0.5 * amplitude).into());
                            targets.push(Target { amplitude: level, ..at(41.0, 5.0) });
                        }
                    }
                    let mut scene = radar.scene(kind, n, chirps, targets);
                    scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                    let rows = match fault {
                        "phase" => &mut phases,
                        "amplifier" | "two beyond" => {
                            scene.receiver.limit = Some(0.9 * amplitude);
                            &mut amplified
                        }
                        _ => &mut levels,
                    };
                    let label = format!(
                        "what a louder target makes: {fault}, {}, {}, {snr_db} dB",
                        kind.name(),
                        radar.name()
                    );
                    let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(24);
                    rows.push(radar.told(case));
                }
            }
        }
    }
    // What swings in the middle of the frame has that velocity, and the answer is the mean.
    let none = Asked::Share { of: Event::MoreGood, least: 0.0, most: 0.01 };
    let right = Asked::Share { of: Event::Off(5.0), least: 0.0, most: 0.002 };
    hold_together("what a swinging level makes, all together", levels, &[none, right]);
    hold_together("what a swinging place makes, all together", phases, &[none]);
    // Of two echoes some sums of a higher order stand alone in the band.
    let few = Asked::Share { of: Event::MoreGood, least: 0.0, most: 0.03 };
    hold_together("what an amplifier makes, all together", amplified, &[few, right]);
}

/// Targets at rest, which stand in one row, are not taken for what the louder ones of them make.
#[test]
fn targets_at_rest_are_not_what_others_make() {
    let (n, chirps) = (256, 64);
    let mut rows = Vec::new();
    for radar in &RADARS[..3] {
        for kind in [Iq, Real] {
            for snr_db in [0.0, 10.0, 20.0] {
                let [bin_m, _] = radar.cell(chirps);
                // Each within so many bins, down to 20 dB below the first.
                let amplitude = amplitude(snr_db) / 6.0;
                let targets = (0..6).map(|index| {
                    let bin = 12.0 + 17.0 * f64::from(index);
                    let at = target(
                        ((bin - 6.0) * bin_m, (bin + 6.0) * bin_m),
                        (0.0, 0.0),
                        if index == 0 { amplitude } else { 0.0 },
                    );
                    let level = (index > 0).then(|| (-20.0..0.0).into());
                    Target { level_db: level, amplitude: at.amplitude.filter(|_| index == 0), ..at }
                });
                let mut scene = radar.scene(kind, n, chirps, targets.collect());
                scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                let label =
                    format!("targets at rest: {}, {}, {snr_db} dB", kind.name(), radar.name());
                let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(24);
                rows.push(radar.told(case));
            }
        }
    }
    let together = [
        Asked::Share { of: Event::Good, least: 0.97, most: 1.0 },
        Asked::Share { of: Event::Off(5.0), least: 0.0, most: 0.002 },
    ];
    hold_together("targets at rest, all together", rows, &together);
}

/// Several targets, three cells apart in one direction at least.
#[test]
fn several_targets_of_a_frame_are_found() {
    let mut rows = Vec::new();
    let (n, chirps) = (256, 64);
    for radar in &RADARS[..3] {
        for kind in [Iq, Real] {
            for count in [2, 4, 6] {
                for snr_db in [0.0, 20.0] {
                    let amplitude = amplitude(snr_db) / count as f64;
                    let noise = deviation(amplitude, snr_db);
                    let [bin_m, row_mps] = radar.cell(chirps);
                    // Of two, one anywhere; the next one in the same range or with the same velocity.
                    let targets = (0..count).map(|index| {
                        let (bin, row) = match index % 3 {
                            0 => (30.0 + 4.0 * f64::from(index), -9.0),
                            1 => (30.0 + 4.0 * f64::from(index - 1), -9.0 + 4.0 * f64::from(index)),
                            _ => (30.0 + 4.0 * f64::from(index), -9.0),
                        };
                        // The Doppler shift moves the beat by no more than a few cells.
                        let at =
                            |place: f64, cell: f64| ((place - 0.5) * cell, (place + 0.5) * cell);
                        let level = amplitude * if index == 0 { 1.0 } else { 0.3 };
                        target(at(bin, bin_m), at(row, row_mps), level)
                    });
                    let mut scene = radar.scene(kind, n, chirps, targets.collect());
                    scene.receiver.noise.rms = Some(noise.into());
                    let label = format!(
                        "several targets are found: {} {n} x {chirps}, {count} targets, {}, {snr_db} dB",
                        kind.name(),
                        radar.name()
                    );
                    let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(12);
                    let case = radar.told(case);
                    rows.push(
                        case.at_least(0.97, Event::RightNumber).at_most(0.01, Event::Wrong(5.0)),
                    );
                }
            }
        }
    }
    let together = [
        Asked::Share { of: Event::RightNumber, least: 0.97, most: 1.0 },
        Asked::Share { of: Event::More, least: 0.0, most: 0.005 },
        Asked::Share { of: Event::Off(5.0), least: 0.0, most: 0.002 },
        Asked::Square { quantity: 0, least: 0.72, most: 1.33 },
        Asked::Square { quantity: 1, least: 0.72, most: 1.33 },
    ];
    hold_together("several targets are found, all together", rows, &together);
}

/// A slow target below clutter at rest that is 30 dB stronger, and a target at rest, are found beside the clutter's background, which was
/// recorded without them.
#[test]
fn targets_beside_a_background_are_right() {
    let (n, chirps) = (256, 64);
    let mut rows = Vec::new();
    for radar in [&RADARS[0], &RADARS[1]] {
        for kind in [Iq, Real] {
            // The turns from chirp to chirp in bins of the frame.
            for turns in [(0.0, 0.0), (0.3, 0.9), (1.0, 3.0)] {
                let (snr_db, strongest) = (-10.0, 0.5 * amplitude(20.0));
                let amplitude = strongest * 0.031_622_776_6;
                let [bin_m, row_mps] = radar.cell(chirps);
                let speed = |turns: f64| (turns * row_mps, (turns + 1e-3) * row_mps);
                let one = target(
                    (20.0 * bin_m, 60.0 * bin_m),
                    (speed(turns.0).0, speed(turns.1).1),
                    amplitude,
                );
                let clutter = [(24.3, 1.0), (41.6, 0.5), (52.1, 0.2)].map(|(bin, share)| Target {
                    range_m: (bin * bin_m).into(),
                    velocity_mps: 0.0.into(),
                    amplitude: Some((strongest * share).into()),
                    phase_turns: 0.0.into(),
                    ..Target::default()
                });
                let targets = [one].into_iter().chain(clutter).collect();
                let mut scene = radar.scene(kind, n, chirps, targets);
                scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                let label = format!(
                    "a target beside a background is right: {}, {}, {} to {} turns a frame",
                    kind.name(),
                    radar.name(),
                    turns.0,
                    turns.1
                );
                let case = Case::new(label, scene, n).by(Path::FrameBeside(chirps)).trials(30);
                let case = radar.told(case);
                rows.push(case.at_least(0.98, Event::Good).at_most(0.002, Event::Off(5.0)));
            }
        }
    }
    let together = [
        Asked::Share { of: Event::Off(5.0), least: 0.0, most: 0.002 },
        Asked::Share { of: Event::Good, least: 0.98, most: 1.0 },
        Asked::Square { quantity: 0, least: 0.72, most: 1.33 },
        Asked::Square { quantity: 1, least: 0.72, most: 1.33 },
        Asked::Share { of: Event::More, least: 0.0, most: 0.005 },
    ];
    hold_together("targets beside a background are right, all together", rows, &together);
}

/// Two targets that are too near each other are not wrong.
#[test]
fn targets_in_one_cell_are_not_wrong() {
    let radar = RADARS[0];
    let (n, chirps) = (256, 64);
    let [bin_m, row_mps] = radar.cell(chirps);
    let rows = [0.4, 0.8, 1.2, 1.7].into_iter().map(|cells: f64| {
        let (snr_db, amplitude) = (10.0, 0.5 * amplitude(10.0));
        let at = |place: f64, cell: f64| (place * cell, (place + 0.01) * cell);
        let one = target(at(40.3, bin_m), at(-5.3, row_mps), amplitude);
        let other = target(at(40.3 + cells, bin_m), at(-5.3 + cells, row_mps), 0.5 * amplitude);
        let mut scene = radar.scene(Iq, n, chirps, vec![one, other]);
        scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
        let label = format!("targets in one cell are not wrong: {cells} cells");
        let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(60);
        let case = case.told(|config: &mut Config| config.velocity_mps = Some((-8.0, 8.0)));
        case.at_most(0.01, Event::Wrong(5.0))
    });
    hold(rows.collect());
}

/// Noise alone shows a target as often as it was asked.
#[test]
fn false_alarms_of_frames_are_as_asked() {
    let mut rows = Vec::new();
    for (kind, n, chirps) in [(Iq, 128, 32), (Real, 256, 16), (Iq, 64, 64)] {
        let mut scene = RADARS[0].scene(kind, n, chirps, vec![]);
        scene.receiver.noise.rms = Some(100.0.into());
        let label = format!("false alarms are as asked: {} {n} x {chirps}", kind.name());
        let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(600);
        let case = case.told(|config: &mut Config| {
            (config.velocity_mps, config.false_alarm) = (Some((-8.0, 8.0)), 0.1);
        });
        rows.push(case.asks(Asked::Share { of: Event::More, least: 0.05, most: 0.2 }));
    }
    hold(rows);
}

/// The power over the noise, after all sums, at which a detector that knows the noise finds nine of ten: the threshold lies where the
/// continuous map of noise exceeds it in a millionth of the frames.
fn found_at(cells: f64) -> f64 {
    let mut threshold = 20.0;
    for _ in 0..20 {
        threshold = (cells * std::f64::consts::FRAC_PI_3 * (threshold - 0.5) / 1e-6_f64).ln();
    }
    // The power of a line in noise has the mean p + 1 and the variance 2 p + 1.
    let mut power = threshold;
    for _ in 0..50 {
        power = threshold - 1.0 + 1.2816 * (2.0 * power + 1.0).sqrt();
    }
    power
}

/// Nine of ten targets are found half a decibel above that.
#[test]
fn weak_targets_of_frames_are_found() {
    let mut rows = Vec::new();
    for (kind, n, chirps) in [(Iq, 256, 64), (Real, 256, 64), (Iq, 128, 32)] {
        let bins = n / 2 - 1;
        let power = found_at((bins * chirps) as f64);
        // A real record of this ratio has half of its power at each frequency.
        let share = if kind == Iq { 1.0 } else { 0.5 };
        let snr_db = 10.0 * (power / (share * (n * chirps) as f64)).log10() + 0.5;
        let amplitude = amplitude(snr_db);
        let [bin_m, _] = RADARS[0].cell(chirps);
        let ranges = (12.0 * bin_m, 0.35 * n as f64 * bin_m);
        let mut scene =
            RADARS[0].scene(kind, n, chirps, vec![target(ranges, (-7.0, 7.0), amplitude)]);
        scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
        let label = format!("weak targets are found: {} {n} x {chirps}", kind.name());
        let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(200);
        let case = case.told(|config: &mut Config| config.velocity_mps = Some((-8.1, 8.1)));
        rows.push(case.at_least(0.9, Event::Found).at_most(0.002, Event::Wrong(5.0)));
    }
    hold(rows);
}

/// Beyond the unambiguous velocities the target's own way decides, or the aliases are listed.
#[test]
fn aliases_of_frames_are_decided_or_listed() {
    let (n, chirps) = (256, 64);
    let mut rows = Vec::new();
    for (radar, speed, decided) in
        [(RADARS[3], 30.0, true), (RADARS[4], 35.0, true), (RADARS[0], 20.0, false)]
    {
        for snr_db in [-15.0, 0.0] {
            let amplitude = amplitude(snr_db);
            let [bin_m, _] = radar.cell(chirps);
            let ranges = (30.0 * bin_m, 90.0 * bin_m);
            let mut scene =
                radar.scene(Iq, n, chirps, vec![target(ranges, (-speed, speed), amplitude)]);
            scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
            let label = format!("aliases are decided or listed: {}, {snr_db} dB", radar.name());
            let case = Case::new(label, scene, n).by(Path::Frame(chirps)).trials(40);
            let case = case.told(|config: &mut Config| config.velocity_mps = Some((-speed, speed)));
            let case = case.at_most(0.002, Event::Wrong(5.0)).at_most(0.002, Event::Unlisted(5.0));
            rows.push(if decided { case.at_least(0.95, Event::Good) } else { case });
        }
    }
    hold(rows);
}

/// A second frame of another period decides between the aliases.
#[test]
fn two_periods_decide_between_aliases() {
    let (n, chirps, radar) = (256, 64, RADARS[0]);
    let rows = [-10.0, 10.0].map(|snr_db| {
        let amplitude = amplitude(snr_db);
        let [bin_m, _] = radar.cell(chirps);
        let one = target((30.0 * bin_m, 90.0 * bin_m), (-38.0, 38.0), amplitude);
        let mut scene = radar.scene(Iq, n, chirps, vec![one]);
        scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
        let label = format!("two periods decide between aliases: {snr_db} dB");
        let case = Case::new(label, scene, n).by(Path::TwoFrames(chirps)).trials(40);
        let case = case.told(|config: &mut Config| config.velocity_mps = Some((-38.0, 38.0)));
        case.at_least(0.95, Event::Good).at_most(0.002, Event::Wrong(5.0))
    });
    hold(rows.into());
}

/// The phase of a frame's target, below the level of a single chirp and in motion.
#[test]
fn a_frames_range_by_phase_is_right() {
    let (n, chirps) = (256, 64);
    let mut rows = Vec::new();
    for radar in [RADARS[2], RADARS[3], RADARS[4]] {
        for (kind, snr_db) in [(Iq, 0.0), (Real, 0.0), (Iq, 20.0)] {
            let amplitude = amplitude(snr_db);
            let [bin_m, _] = radar.cell(chirps);
            let mut one = target((20.0 * bin_m, 90.0 * bin_m), (-2.0, 2.0), amplitude);
            one.phase_turns = 0.0.into();
            let mut scene = radar.scene(kind, n, chirps, vec![one]);
            scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
            let label = format!(
                "a frame's range by phase: {} {n} x {chirps}, {}, {snr_db} dB",
                kind.name(),
                radar.name()
            );
            let case = Case::new(label, scene, n).by(Path::FramePhase(chirps)).trials(60);
            let case = case.told(|config: &mut Config| config.velocity_mps = Some((-2.5, 2.5)));
            rows.push(case.at_most(0.002, Event::FirstOff(5.0)));
        }
    }
    let together = [
        Asked::Share { of: Event::OtherCycle, least: 0.0, most: 1e-4 },
        Asked::ByPhase { least: 0.81, most: 1.21 },
    ];
    hold_together("a frame's range by phase, all together", rows, &together);
}
