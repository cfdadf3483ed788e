//! Range and velocity of moving targets: right within their sigmas, for both mixings, real and I/Q, lidar and radar.

use picket_claims::scenes::{Kind, amplitude, deviation};
use picket_claims::{Asked, Case, Event, Path, hold, hold_together};
use picket_dsp::{Config, Mixing, Verdict};
use picket_simulator::scene::{self, Receiver, Shape, Source, Target, Waveform};
use picket_simulator::{Scene, Value};

use Kind::{Iq, Real};

const C: f64 = 299_792_458.0;

/// A waveform, its receiver's rate, and the ranges that its band holds at 60 m/s, m.
#[derive(Clone, Copy, Debug)]
struct Radar {
    carrier_hz: f64,
    bandwidth_hz: f64,
    ramp_s: f64,
    rate_hz: f64,
    ranges_m: (f64, f64),
}

/// A carrier in GHz, a bandwidth in MHz, a ramp in ms and a rate in MHz.
const fn radar(ghz: f64, mhz: f64, ms: f64, rate_mhz: f64, ranges_m: (f64, f64)) -> Radar {
    let (carrier_hz, bandwidth_hz) = (ghz * 1e9, mhz * 1e6);
    Radar { carrier_hz, bandwidth_hz, ramp_s: ms * 1e-3, rate_hz: rate_mhz * 1e6, ranges_m }
}

const RADARS: [Radar; 8] = [
    radar(24.0, 200.0, 1.1, 1.0, (10.0, 120.0)),
    radar(77.0, 300.0, 1.1, 1.0, (10.0, 120.0)),
    radar(77.0, 1000.0, 0.275, 4.0, (5.0, 60.0)),
    radar(122.0, 1000.0, 0.55, 2.0, (5.0, 60.0)),
    radar(122.0, 4000.0, 0.55, 4.0, (2.0, 25.0)),
    radar(24.0, 200.0, 4.2, 0.25, (20.0, 120.0)),
    radar(122.0, 4000.0, 4.2, 0.25, (2.0, 10.0)),
    Radar {
        carrier_hz: C / 1550e-9,
        bandwidth_hz: 1e9,
        ramp_s: 10e-6,
        rate_hz: 250e6,
        ranges_m: (20.0, 60.0),
    },
];

const MIXINGS: [scene::Mixing; 2] = [scene::Mixing::TxConjRx, scene::Mixing::RxConjTx];

impl Radar {
    /// Targets before it, with records of `n` samples at the end of each segment, `laps` times.
    fn scene(
        &self,
        kind: Kind,
        n: usize,
        shape: Shape,
        laps: usize,
        targets: Vec<Target>,
    ) -> Scene {
        let Radar { carrier_hz, bandwidth_hz, ramp_s, rate_hz, .. } = *self;
        let waveform = Waveform {
            shape,
            carrier_hz,
            bandwidth_hz,
            ramp_s,
            guard_s: Some(ramp_s - n as f64 / rate_hz),
            samples: n,
            ..Waveform::default()
        };
        let receiver = Receiver { iq: kind == Iq, ..Receiver::default() };
        let seconds = 3.0 * ramp_s * laps as f64;
        let sources = targets.into_iter().map(Source::Target).collect();
        Scene { rate_hz, seconds, waveform: Some(waveform), sources, receiver, ..Scene::default() }
    }

    /// How far the frequency of a beat rises within a record, bins. The range changes by V T and the beat follows it, and so does the Doppler
    /// shift by as much.
    fn bend(&self, n: usize, velocity_mps: f64) -> f64 {
        let record_s = n as f64 / self.rate_hz;
        4.0 * self.bandwidth_hz / self.ramp_s * record_s * record_s * velocity_mps.abs() / C
    }

    fn name(&self) -> String {
        format!(
            "{:.4e} Hz, {} MHz in {} ms",
            self.carrier_hz,
            self.bandwidth_hz / 1e6,
            self.ramp_s * 1e3
        )
    }
}

fn target(range_m: impl Into<Value>, velocity_mps: impl Into<Value>, amplitude: f64) -> Target {
    Target {
        range_m: range_m.into(),
        velocity_mps: velocity_mps.into(),
        amplitude: Some(amplitude.into()),
        ..Target::default()
    }
}

/// One target anywhere, up to a speed. Up to 20 times the amplitude's ratio to the noise a ramp's tone of 1024 samples is good; of others in
/// proportion to the root of their number. Beyond, its bend is not small any more and the answer is `moving`, with a sigma that is too
/// wide; and a line whose frequency rises by more than two bins is no line any more.
fn cells(kind: Kind, n: usize, shape: Shape, radars: &[Radar]) {
    let (mut rows, mut bent) = (Vec::new(), Vec::new());
    for radar in radars {
        for (speed, snr_db) in [(0.5, 0.0), (12.0, 20.0), (60.0, 0.0), (60.0, 40.0), (12.0, 40.0)] {
            for mixing in MIXINGS {
                let amplitude = amplitude(snr_db);
                let (near, far) = radar.ranges_m;
                let straight = radar.bend(n, speed)
                    * (n as f64 / 1024.0 * 10f64.powf(snr_db / 10.0)).sqrt()
                    < 20.0
                    && radar.bend(n, speed) < 2.0;
                let mut scene = radar.scene(
                    kind,
                    n,
                    shape,
                    1,
                    vec![target(near..far, -speed..speed, amplitude)],
                );
                scene.receiver.mixing = mixing;
                scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
                let label = format!(
                    "{shape:?} is right: {} {n}, {}, {speed} m/s, {snr_db} dB, {mixing:?}",
                    kind.name(),
                    radar.name()
                );
                let case = Case::new(label, scene, n).by(Path::Chirps(1)).trials(40);
                let case = case.at_most(0.002, Event::Wrong(5.0));
                if straight {
                    let case = case.at_least(0.95, Event::Good).square(0.72, 1.44);
                    rows.push(case.asks(Asked::Square { quantity: 1, least: 0.72, most: 1.44 }));
                } else {
                    bent.push(case);
                }
            }
        }
    }
    let label = format!("{shape:?} is right, all together: {} {n}", kind.name());
    // The mean of all is nearer to 1 than that of each.
    let together = [0, 1].map(|quantity| Asked::Square { quantity, least: 0.884, most: 1.124 });
    let good = Asked::Share { of: Event::Good, least: 0.95, most: 1.0 };
    let wrong = Asked::Share { of: Event::Wrong(5.0), least: 0.0, most: 0.002 };
    hold_together(&label, rows, &[together[0], together[1], good, wrong]);
    hold_together(&(label + ", bent"), bent, &[wrong]);
}

#[test]
fn chirps_are_right_within_their_sigmas() {
    cells(Iq, 1024, Shape::Trapezoid, &RADARS);
    cells(Real, 1024, Shape::Trapezoid, &RADARS);
    cells(Iq, 1024, Shape::Triangle, &RADARS);
    // A ramp has as many bins per metre as 1024 samples at the rates above give: a quarter and four times as many samples.
    let with = |factor: f64| RADARS.map(|radar| Radar { rate_hz: radar.rate_hz * factor, ..radar });
    cells(Iq, 256, Shape::Trapezoid, &with(0.25)[..1]);
    cells(Iq, 4096, Shape::Trapezoid, &with(4.0)[..2]);
    cells(Real, 4096, Shape::Trapezoid, &with(4.0)[..2]);
}

/// A real triangle fits two targets; one of them is the true one, within its sigma.
#[test]
fn one_of_a_real_triangles_targets_is_right() {
    let scene = |snr_db: f64| {
        let mut scene = RADARS[1].scene(
            Real,
            1024,
            Shape::Triangle,
            1,
            vec![target(10.0..110.0, -60.0..60.0, 400.0)],
        );
        scene.receiver.noise.rms = Some(deviation(400.0, snr_db).into());
        scene
    };
    let rows = [10.0, 20.0].map(|snr_db| {
        let case = Case::new(
            format!("a real triangle lists the right one: {snr_db} dB"),
            scene(snr_db),
            1024,
        );
        let case = case.by(Path::Chirps(1)).trials(300).at_most(0.0005, Event::Usable);
        case.at_most(0.001, Event::Unlisted(5.0)).at_least(0.95, Event::Is(&[Verdict::Ambiguous]))
    });
    hold(rows.into());
}

/// With the other mixing every range is negative, and no chirp is good.
#[test]
fn a_wrong_mixing_is_seen_in_every_chirp() {
    let mut rows = Vec::new();
    for shape in [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth] {
        for (radar, speed) in [(&RADARS[0], 3.0), (&RADARS[1], 12.0), (&RADARS[7], 3.0)] {
            for (mixing, other) in MIXINGS.into_iter().zip([Mixing::RxConjTx, Mixing::TxConjRx]) {
                let mut scene =
                    radar.scene(Iq, 1024, shape, 1, vec![target(30.0..60.0, speed, 400.0)]);
                scene.receiver.mixing = mixing;
                scene.receiver.noise.rms = Some(deviation(400.0, 10.0).into());
                let label =
                    format!("a wrong mixing is seen: {shape:?}, {}, {mixing:?}", radar.name());
                let case = Case::new(label, scene, 1024).by(Path::Chirps(1)).trials(30);
                let case = case.told(|config: &mut Config| {
                    if let picket_dsp::Scene::Chirp(chirp) = &mut config.scene {
                        chirp.mixing = other;
                    }
                });
                rows.push(case.at_most(1e-4, Event::Usable));
            }
        }
    }
    hold(rows);
}

/// A ramp that is bent more than the library is told moves both beats as no target does: what is usable is right. Told, it is usable.
#[test]
fn a_bend_of_the_sweep_is_seen_or_told() {
    const CURVATURE: f64 = 0.002;
    let mut rows = Vec::new();
    for radar in RADARS[..4].iter().chain(&RADARS[7..]) {
        for shape in [Shape::Trapezoid, Shape::Triangle] {
            for snr_db in [-5.0, 0.0, 10.0, 20.0] {
                let (near, far) = radar.ranges_m;
                let mut scene =
                    radar.scene(Iq, 1024, shape, 1, vec![target(near..far, -12.0..12.0, 400.0)]);
                scene.waveform.as_mut().unwrap().curvature = CURVATURE;
                scene.receiver.noise.rms = Some(deviation(400.0, snr_db).into());
                let label =
                    format!("a bend of the sweep: {shape:?}, {}, {snr_db} dB", radar.name());
                let case =
                    Case::new(label.clone(), scene.clone(), 1024).by(Path::Chirps(1)).trials(60);
                // A lidar's ramp is too short, and its Doppler shift too large, for a rise to be seen.
                if radar.carrier_hz < 1e12 {
                    rows.push(case.at_most(0.005, Event::Wrong(5.0)));
                }
                let case = Case::new(label + ", told", scene, 1024).by(Path::Chirps(1)).trials(60);
                let case = case.told(|config| {
                    if let picket_dsp::Scene::Chirp(chirp) = &mut config.scene {
                        chirp.sweep_curvature = CURVATURE as _;
                    }
                });
                let case = case.at_most(0.002, Event::Wrong(5.0));
                // What bends too far within a record is not to be used.
                let bends = radar.bend(1024, 12.0) * 10f64.powf(snr_db / 20.0) > 20.0;
                rows.push(if bends { case } else { case.at_least(0.75, Event::Usable) });
            }
        }
    }
    hold(rows);
}

/// Another chirp or a bound of the velocity decides what one chirp does not.
#[test]
fn an_exchange_is_decided_by_a_bound_or_by_the_next_chirp() {
    let mut rows = Vec::new();
    let radars = [
        (radar(24.0, 200.0, 1.1, 1.0, (10.0, 120.0)), 50.0),
        (radar(77.0, 300.0, 1.1, 1.0, (10.0, 100.0)), 20.0),
    ];
    for (radar, speed) in radars {
        let (near, far) = radar.ranges_m;
        for (how, laps) in [("a bound", 1), ("the next chirp", 2)] {
            let mut scene = radar.scene(
                Real,
                1024,
                Shape::Triangle,
                laps,
                vec![target(near..far, -speed..speed, 400.0)],
            );
            scene.receiver.noise.rms = Some(deviation(400.0, 20.0).into());
            let label = format!("an exchange is decided by {how}: {}", radar.name());
            let case = Case::new(label, scene, 1024).by(Path::Chirps(laps)).trials(100);
            let case = if laps == 1 {
                case.told(|config| config.velocity_mps = Some((-speed, speed)))
            } else {
                case
            };
            // The exchanged pair may keep to the bound, too.
            rows.push(
                case.at_most(1e-4, Event::Wrong(5.0))
                    .at_most(1e-4, Event::Unlisted(5.0))
                    .at_least(0.9, Event::Usable),
            );
        }
    }
    // usable.md's first row: 77 GHz, 300 MHz in 100 us: over all speeds that are allowed sigma is the error.
    let saw = radar(77.0, 300.0, 0.11, 10.0, (10.0, 60.0));
    let mut scene = saw.scene(Iq, 1024, Shape::Sawtooth, 1, vec![target(18.3, -5.0..5.0, 400.0)]);
    scene.receiver.noise.rms = Some(deviation(400.0, 20.0).into());
    let case =
        Case::new("a sawtooth's range needs a bound", scene.clone(), 1024).by(Path::Chirps(1));
    rows.push(case.trials(100).at_least(0.9999, Event::Is(&[Verdict::Ambiguous])));
    let case = Case::new("a sawtooth's range within a bound", scene, 1024).by(Path::Chirps(1));
    let case = case.told(|config| config.velocity_mps = Some((-5.0, 5.0))).trials(300);
    rows.push(case.at_least(0.9999, Event::Usable).square(0.8, 1.2));
    hold(rows);
}

/// 24 GHz, 200 MHz in 1.024 ms, 30 m and 3 m/s, at 20 dB.
#[test]
fn a_walker_at_thirty_metres_is_there() {
    let radar = radar(24.0, 200.0, 1.024, 1.0, (30.0, 30.0));
    let mut rows = Vec::new();
    for shape in [Shape::Trapezoid, Shape::Triangle] {
        for mixing in MIXINGS {
            let mut scene = radar.scene(Iq, 1024, shape, 1, vec![target(30.0, 3.0, 400.0)]);
            scene.receiver.mixing = mixing;
            scene.receiver.noise.rms = Some(deviation(400.0, 20.0).into());
            let case = Case::new(format!("a walker at 30 m: {shape:?}, {mixing:?}"), scene, 1024);
            let case = case.by(Path::Chirps(1)).trials(100).at_least(0.999, Event::Good);
            let case =
                case.square(0.9, 1.1).asks(Asked::Square { quantity: 1, least: 0.9, most: 1.1 });
            rows.push(case.at_least(0.99, Event::Within(3.0)));
        }
    }
    hold(rows);
}

/// What is asked of two targets is that none is answered that is not there; of one that it is answered as before.
#[test]
fn two_targets_make_no_ghost() {
    let radars = [
        (radar(24.0, 200.0, 1.1, 1.0, (10.0, 120.0)), 50.0),
        (radar(77.0, 300.0, 1.1, 1.0, (10.0, 100.0)), 20.0),
        (radar(122.0, 1000.0, 0.55, 2.0, (5.0, 60.0)), 50.0),
        (RADARS[7], 20.0),
        (radar(122.0, 4000.0, 0.55, 4.0, (3.0, 20.0)), 8.0),
    ];
    let mut rows = Vec::new();
    for (radar, speed) in &radars {
        let (near, far) = radar.ranges_m;
        let cell_m = C / 2.0 / radar.bandwidth_hz;
        for (kind, shape) in [
            (Iq, Shape::Triangle),
            (Iq, Shape::Trapezoid),
            (Real, Shape::Trapezoid),
            (Real, Shape::Triangle),
        ] {
            for snr_db in [10.0, 20.0, 30.0, 40.0] {
                for level_db in [0.0, -3.0, -6.0] {
                    let middle = f64::midpoint(near, far);
                    // Half a cell to 20 cells beside, and at any other range.
                    let beside = (20.0 * cell_m).min(0.3 * (far - near));
                    let first = target(middle - beside..middle, -speed..*speed, 400.0);
                    let mut second = target(middle..middle + beside, -speed..*speed, 1.0);
                    (second.amplitude, second.level_db) = (None, Some(level_db.into()));
                    let mut scene = radar.scene(kind, 1024, shape, 1, vec![first, second]);
                    scene.receiver.mixing = MIXINGS[usize::from(snr_db == 20.0 || snr_db == 40.0)];
                    scene.receiver.noise.rms = Some(deviation(400.0, snr_db).into());
                    let label = format!(
                        "two targets: {} {shape:?}, {}, {snr_db} dB, {level_db} dB",
                        kind.name(),
                        radar.name()
                    );
                    let case = Case::new(label, scene, 1024).by(Path::Chirps(1)).trials(20);
                    let case = case.any_source().at_most(0.002, Event::Wrong(5.0));
                    rows.push(case);
                }
            }
        }
        for shape in [Shape::Trapezoid, Shape::Triangle] {
            for snr_db in [10.0, 20.0, 30.0, 40.0] {
                let mut scene =
                    radar.scene(Iq, 1024, shape, 1, vec![target(near..far, -speed..*speed, 400.0)]);
                scene.receiver.noise.rms = Some(deviation(400.0, snr_db).into());
                let label =
                    format!("one target is answered: {shape:?}, {}, {snr_db} dB", radar.name());
                let case = Case::new(label, scene, 1024).by(Path::Chirps(1)).trials(60);
                rows.push(case.at_most(0.01, Event::Refused).at_most(1e-4, Event::Wrong(5.0)));
            }
        }
    }
    hold(rows);
}

/// Velocity from the phases of sawtooth chirps: the right one is listed, within its sigmas, and alone it is right. As far as the range's movement
/// tells the turns, it is alone. A car at 77 GHz, whose beats move within each chirp, has an answer, too.
#[test]
fn a_sequence_of_chirps_has_a_velocity() {
    let slow = radar(23.9, 200.0, 2.048, 0.5, (15.0, 80.0));
    let fast = radar(77.0, 300.0, 0.11, 10.0, (15.0, 60.0));
    let mut rows = Vec::new();
    for (radar, kind, period_s, speed, snr_db, chirps, trials, alone) in [
        (slow, Real, 2.2e-3, 4.0, 20.0, 3, 300, 0.0),
        (slow, Real, 2.2e-3, 4.0, 10.0, 4, 300, 0.0),
        (slow, Real, 2.2e-3, 4.0, 0.0, 8, 300, 0.0),
        (slow, Real, 2.2e-3, 4.0, 10.0, 32, 300, 0.99),
        (slow, Real, 2.2e-3, 4.0, 20.0, 64, 300, 0.99),
        (fast, Iq, 0.0, 50.0, 40.0, 64, 40, 0.5),
    ] {
        let (near, far) = radar.ranges_m;
        let amplitude = amplitude(snr_db);
        let targets = vec![target(near..far, -speed..speed, amplitude)];
        let mut scene = radar.scene(kind, 1024, Shape::Sawtooth, chirps, targets);
        scene.waveform.as_mut().unwrap().period_s = period_s;
        scene.receiver.noise.rms = Some(deviation(amplitude, snr_db).into());
        let label =
            |what| format!("a sequence: {chirps} chirps, {}, {snr_db} dB|{what}", radar.name());
        let case = |what| {
            let case = Case::new(label(what), scene.clone(), 1024);
            case.by(Path::Sequence(chirps as u32)).trials(trials)
        };
        let listed = case("listed").whatever_the_verdict().at_least(0.99, Event::Within(6.0));
        rows.push(if period_s > 0.0 {
            listed.square(0.85, 1.15).asks(Asked::Square { quantity: 1, least: 0.85, most: 1.15 })
        } else {
            listed
        });
        rows.push(case("alone").at_least(alone, Event::Usable).never(Event::Wrong(6.0)));
    }
    hold(rows);
}
