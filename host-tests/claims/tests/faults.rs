//! Records with one thing wrong, tones that are there for a part of a record, pairs that one converter takes by turns, and tones that are
//! measured otherwise than by a search: what may be used is as exact as its sigma says.

use picket_claims::scenes::{Kind, amplitude, beside, deviation, first, line, tones};
use picket_claims::{Asked, Case, Event, Path, hold, hold_together};
use picket_dsp::{Alternating, Arithmetic, Iq as IqRecord, Method, Verdict};
use picket_simulator::Scene;
use picket_simulator::Value;
use picket_simulator::scene::{Change, Density, Source, Tone};
use std::f64::consts::PI;

use Kind::{Iq, Real};

const N: usize = 1024;

/// A tone eight bins or more from both ends, of I/Q records on this side of 0 Hz, in a record that something disturbs.
fn disturbed(
    kind: Kind,
    side: f64,
    amplitude: f64,
    snr_db: f64,
    disturb: impl Fn(&mut Scene),
) -> Scene {
    let noise = deviation(amplitude, snr_db);
    let mut scene = tones(kind, N, [line(from(N, 8.0, side), amplitude)], noise);
    disturb(&mut scene);
    scene
}

/// Nearly all records may be used, and error over sigma is at most 1.15: less where sigma has in it what may be wrong besides. The noise
/// hides too much of a second tone that is no stronger: there it is 2.0 of real records, all of which are moving.
#[test]
fn what_is_usable_of_disturbed_records_is_within_its_sigma() {
    let mut rows = Vec::new();
    for (kind, side, trials) in [(Real, 1.0, 1000), (Iq, 1.0, 500), (Iq, -1.0, 500)] {
        for snr_db in [20.0, 40.0] {
            let usual = 0.6 * amplitude(snr_db);
            let disturbed =
                |disturb: &dyn Fn(&mut Scene)| disturbed(kind, side, usual, snr_db, disturb);
            let swings = |rate: f64| {
                let (depth, rate_hz) = (Value::from(0.2), Value::from(rate));
                let swing = Change::Am { depth, rate_hz };
                disturbed(&|scene| first(scene).changes.push(swing.clone()))
            };
            let second = disturbed(&|scene| {
                scene.sources.push(Source::Tone(beside(Value::either_way(0.7), -20.0)));
            });
            let beyond = 2047.0 * 10f64.powf(0.027 / 20.0);
            let clipped = self::disturbed(kind, side, beyond, snr_db, |_| ());
            let flicker = disturbed(&|scene| {
                scene.receiver.noise.shape = vec![Density::Flicker { power: 1.0.into() }];
            });
            for (name, scene, most) in [
                ("a second tone", second, if snr_db < 30.0 { 2.2f64 } else { 1.15 }),
                ("the converter's end", clipped, 1.15),
                ("a slow swing of the level", swings(0.3), 1.15),
                ("a swing of the level", swings(1.0), 1.15),
                ("flicker noise", flicker, 1.15),
            ] {
                let label =
                    format!("disturbed by {name}: {}, {snr_db} dB, side {side}", kind.name());
                let case = Case::new(label, scene, N).trials(trials).at_least(0.99, Event::Usable);
                rows.push(case.square(0.09, most * most));
            }
        }
    }
    for snr_db in [0.0, 20.0, 40.0] {
        for part in [0, 1] {
            for side in SIDES {
                let scene = disturbed(Iq, side, 0.6 * amplitude(snr_db), snr_db, |scene| {
                    scene.receiver.dead = Some(part);
                });
                let label = format!("part {part} is dead: {snr_db} dB, side {side}");
                let case = Case::new(label, scene, N).trials(500);
                rows.push(case.at_least(1.0, Event::Is(&[Verdict::Image])));
            }
        }
    }
    hold(rows);
}

/// 10, 30 and 50 dB at the peak, real and I/Q, either arithmetic.
#[test]
fn a_tone_for_a_part_of_a_record_is_within_five_sigma_or_not_usable() {
    let burst = |middle_s: std::ops::Range<f64>, deviation: f64| Change::Burst {
        middle_s: middle_s.into(),
        deviation_s: deviation.into(),
    };
    let on = |share: f64| Change::On { from_s: (0.0..1.0 - share).into(), for_s: share.into() };
    let swing = |cycles: f64| Change::Am { depth: 0.9.into(), rate_hz: cycles.into() };
    let decay = Change::Decay { time_s: 0.2.into(), from_s: 0.0.into() };
    for (name, change, peak) in [
        ("a burst of .1", burst(0.2..0.8, 0.1), 1.0),
        ("a burst of .2", burst(0.2..0.8, 0.2), 1.0),
        ("a burst of .35", burst(0.0..1.0, 0.35), 1.0),
        ("on for .25", on(0.25), 1.0),
        ("on for .5", on(0.5), 1.0),
        ("on for .75", on(0.75), 1.0),
        ("AM of .9, one cycle", swing(1.0), 1.9),
        ("AM of .9, two cycles", swing(2.0), 1.9),
        ("decay to 1/e in .2", decay, 1.0),
    ] {
        let mut rows = Vec::new();
        for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
            for snr_db in [10.0, 30.0, 50.0] {
                for kind in Kind::ALL {
                    let amplitude = amplitude(snr_db);
                    let tone = Tone {
                        changes: vec![change.clone()],
                        ..line(20.0..480.0, amplitude / peak)
                    };
                    let scene = tones(kind, N, [tone], deviation(amplitude, snr_db));
                    let label = format!("{name}: {}, {snr_db} dB, {arithmetic:?}", kind.name());
                    rows.push(Case::new(label, scene, N).arithmetic(arithmetic).trials(50));
                }
            }
        }
        let wrong = Asked::Share { of: Event::Wrong(5.0), least: 0.0, most: 0.03 };
        hold_together(&format!("{name}, all together"), rows, &[wrong]);
    }
}

/// The sides of 0 Hz.
const SIDES: [f64; 2] = [1.0, -1.0];

/// Pairs of a tone at any of these bins of one side, taken by turns: Q half a pair after I. Sought from `least` bins on.
fn by_turns(label: String, n: usize, bins: Value, side: f64, amplitude: f64, least: f64) -> Case {
    let mut scene = tones(Iq, n, [line(bins, amplitude)], 0.0);
    scene.receiver.q_late_s = (-0.5 / n as f64).into();
    let (low, high) = (least - 0.01, 0.5 * n as f64);
    let band = if side > 0.0 { (low, high) } else { (-high, -low) };
    let label = format!("{label}: {n} pairs, side {side}");
    Case::new(label, scene, n).by(Path::ByTurns).told(|config| config.band_hz = Some(band))
}

/// With so much noise, over the tone's level or in codes.
fn noisy(mut case: Case, rms: Option<f64>, snr_db: Option<Value>) -> Case {
    case.scene.receiver.noise.rms = rms.map(Value::from);
    case.scene.receiver.noise.snr_db = snr_db;
    case
}

/// From so many bins on, to as many before the end.
fn from(n: usize, least: f64, side: f64) -> Value {
    let most = 0.5 * n as f64 - least;
    if side > 0.0 { (least..most).into() } else { (-most..-least).into() }
}

/// All are good, but for one of a thousand in which noise looks like a change; none is six sigmas off, and all have their level.
fn right(case: Case) -> Case {
    let case = case.at_least(0.999, Event::Good).never(Event::Off(6.0));
    case.never(Event::LevelOff(0.03))
}

#[test]
fn pairs_by_turns_are_right_in_both_sidebands() {
    let mut rows = Vec::new();
    for side in SIDES {
        for n in [64, 128, 256, 512, 1024] {
            let case = by_turns("by turns".into(), n, from(n, 8.0, side), side, 1000.0, 3.0);
            let case = right(noisy(case, None, Some((14.0..50.0).into()))).trials(1000);
            let case = case.square(0.93 * 0.93, 1.06 * 1.06);
            rows.push(case.asks(Asked::OverBound { quantity: 0, most: 1.06 }));
        }
        // Noise of a code: what the delay of Q might leave at minus the frequency would be seen beside 0 Hz.
        let name = "by turns, strong and near the ends";
        let case = by_turns(name.into(), N, from(N, 4.0, side), side, 1000.0, 3.0);
        let mut case = right(noisy(case, None, Some((55.0..62.0).into()))).trials(500);
        case.scene.receiver.offset = [0; 2].map(|_| Value::from(-500.0..500.0));
        let case = case.square(0.81, 1.08 * 1.08);
        rows.push(case.asks(Asked::OverBound { quantity: 0, most: 1.08 }));
        let ends = [3.3 * side, 6.2 * side, 508.2 * side].into();
        let case = by_turns("by turns, at the ends".into(), N, ends, side, 1000.0, 3.0);
        rows.push(right(noisy(case, Some(1.0), None)).trials(60));
        // Nearer to the ends the tone's mirror image disturbs it.
        let end = (511.2 * side).into();
        let case = by_turns("by turns, too near the end".into(), N, end, side, 1000.0, 3.0);
        let case = noisy(case, Some(1.0), None).trials(30);
        rows.push(case.at_least(1.0, Event::Is(&[Verdict::NearEdge])));
        let case = by_turns("by turns, noise".into(), 256, 9.0.into(), side, 0.0, 3.0);
        rows.push(noisy(case, Some(50.0), None).trials(1000).never(Event::Found));
    }
    hold(rows);
}

/// The channels' offsets are one line, at 0 Hz: none is told near it, the others are right; also codes whose middle is half a code off.
#[test]
fn pairs_by_turns_beside_an_offset_are_right_or_refused() {
    let mut rows = Vec::new();
    for side in SIDES {
        for n in [256, 1024] {
            for offset in [0.0, 20.0, 900.0] {
                for snr_db in [15.0, 30.0, 45.0] {
                    for (near, low, high) in [(true, 0.3, 1.2), (false, 1.7, 12.0)] {
                        let bins = if side > 0.0 { low..high } else { -high..-low }.into();
                        let label = format!("by turns, offset {offset}, {snr_db} dB, {near}");
                        let case = by_turns(label, n, bins, side, 300.0, 0.0);
                        let ends = (-0.45 * n as f64, 0.45 * n as f64);
                        let case = case.told(|config| config.band_hz = Some(ends));
                        let mut case = noisy(case, None, Some(snr_db.into())).trials(100);
                        let (sin, cos) = (rows.len() as f64).sin_cos();
                        case.scene.receiver.offset = [cos, sin].map(|x| (offset * x).into());
                        rows.push(if near {
                            case.never(Event::Usable).never(Event::Is(&[Verdict::Image]))
                        } else {
                            let case = case.at_least(0.97, Event::Usable);
                            case.square(0.92 * 0.92, 1.08 * 1.08).never(Event::Off(5.0))
                        });
                    }
                }
            }
        }
        for unsigned in [false, true] {
            for whole in [false, true] {
                let name = format!("by turns, offsets, unsigned {unsigned}, whole band {whole}");
                let case = by_turns(name, N, (77.3 * side).into(), side, 300.0, 3.0);
                let mut scene = noisy(case.clone(), Some(1.0), None).scene;
                scene.receiver.offset = [900.0.into(), (-700.0).into()];
                scene.converter.unsigned = unsigned;
                let band = case.config.band_hz.filter(|_| !whole);
                let case = Case::new(case.label, scene, N).by(Path::ByTurns).trials(20);
                rows.push(right(case.told(|config| config.band_hz = band)));
            }
        }
    }
    hold(rows);
}

/// Small errors of gain and phase leave good tones; large ones, or a dead channel, have their verdict.
#[test]
fn errors_of_the_channels_make_an_image() {
    let mut rows = Vec::new();
    for side in SIDES {
        let name = "by turns, small errors of the channels";
        let case = by_turns(name.into(), 512, from(512, 12.0, side), side, 1000.0, 3.0);
        let mut case = right(noisy(case, None, Some((20.0..40.0).into()))).trials(250);
        case.scene.receiver.gain_error = (-0.05..0.05).into();
        case.scene.receiver.quadrature_rad = (-0.05..0.05).into();
        rows.push(case.square(0.81, 1.21));
        for (gain, phase, image) in [
            (0.0, 0.0, true),
            (0.5, 0.0, true),
            (1.0, 0.5, true),
            (0.9, 0.0, false),
            (1.0, 0.1, false),
            // Turned the wrong way round, the stronger line is at minus the frequency.
            (1.0, PI + 0.1, false),
        ] {
            let bins: Value = if side > 0.0 {
                [4.5, 30.0, 333.3, 505.0].into()
            } else {
                [-480.2, -140.4, -9.3].into()
            };
            let band = if phase > 3.0 { -side } else { side };
            let label = format!("by turns, gain {gain}, phase {phase:.2}");
            let case = by_turns(label, N, bins, band, 1000.0, 3.0);
            let mut case = noisy(case, Some(3.0), None).trials(40);
            case.scene.receiver.gain_error = (gain - 1.0).into();
            case.scene.receiver.quadrature_rad = phase.into();
            let seen = Event::Is(&[Verdict::Image]);
            rows.push(if image { case.at_least(1.0, seen) } else { case.never(seen) });
        }
    }
    hold(rows);
}

/// What is said of I/Q records of unsigned codes without a band: a tone is one line, and none is at the offset. Of their
/// frequencies: a phase beside an offset that does not stand out of the tone's leakage has a share of it.
#[test]
fn unsigned_codes_have_no_line_at_their_middle() {
    let mut rows = Vec::new();
    for (amplitude, snr_db) in [(3.0, 15.0), (30.0, 20.0), (900.0, 40.0)] {
        for away in [0.0, 20.0] {
            for n in [256, 1024] {
                for side in SIDES {
                    for path in [Path::Lines(4), Path::Harmonic(1)] {
                        let noise = deviation(amplitude, snr_db);
                        let mut scene = tones(Iq, n, [line(from(n, 2.0, side), amplitude)], noise);
                        scene.converter.unsigned = true;
                        scene.receiver.offset = [away.into(), away.into()];
                        let label = format!(
                            "codes from 0, {away} off, {path:?}: {n}, {amplitude} codes, side {side}"
                        );
                        let case = Case::new(label, scene, n).by(path).trials(150);
                        let case = case.at_least(0.99, Event::Good).never(Event::FirstOff(6.0));
                        let case = match path {
                            Path::Lines(_) => case.at_least(0.99, Event::RightNumber),
                            _ => case,
                        };
                        let mut floats = case.clone().in_floats();
                        floats.label += ", floats";
                        rows.extend([case, floats]);
                    }
                }
            }
        }
    }
    hold(rows);
}

/// A fundamental of 20 to 95 bins with harmonics up to order 5, the fundamental so much below them; the strongest so much above the noise:
/// on the bound of all of them, and never an octave off.
#[test]
fn no_octave_is_taken_for_the_fundamental() {
    for (kind, snr_db, weaker_db) in [
        (Real, 20.0, 20.0),
        (Iq, 20.0, 20.0),
        (Real, 0.0, 20.0),
        (Real, 10.0, 0.0),
        (Real, 40.0, 40.0),
    ] {
        let rows = [
            [-0.5, -3.0, -6.0, -1.0],
            [-6.0, -5.0, -4.0, -2.0],
            [-2.0, 0.0, -1.0, -5.5],
            [-4.0, -6.0, -0.3, -6.0],
            [0.0, 0.0, -3.5, -2.5],
        ]
        .map(|levels| {
            let harmonics = (2..).map(f64::from).zip(levels);
            let harmonics = harmonics.map(|(order, level_db)| [order, weaker_db + level_db]);
            let amplitude = 400.0 * 10f64.powf(-weaker_db / 20.0);
            let tone = Tone { harmonics: harmonics.collect(), ..line(20.0..95.0, amplitude) };
            let scene = tones(kind, N, [tone], deviation(400.0, snr_db));
            let label = format!(
                "a fundamental {weaker_db} dB weaker: {}, {snr_db} dB, {levels:?}",
                kind.name()
            );
            let case = Case::new(label, scene, N).by(Path::Harmonic(5)).trials(100);
            case.never(Event::Elsewhere).asks(Asked::OverBound { quantity: 0, most: 1.1 })
        });
        let label = format!("a fundamental {weaker_db} dB weaker, {} {snr_db} dB", kind.name());
        let square = Asked::Square { quantity: 0, least: 0.85, most: 1.15 };
        let bound = Asked::OverBound { quantity: 0, most: 1.1 };
        let good = Asked::Share { of: Event::Good, least: 0.99, most: 1.0 };
        hold_together(&label, rows.into(), &[square, bound, good]);
    }
}

/// The locked way: its error over the bound, and whether it knows. A constant offset does not show.
#[test]
fn a_tone_where_it_is_expected_is_within_a_fifth_of_the_bound() {
    let mut rows = Vec::new();
    for snr_db in [-5.0, 10.0, 30.0, 60.0] {
        for (low, high) in [(0.0, 0.5), (0.5, 1.0), (1.5, 2.0)] {
            let real = [8, 16, 24, 31, 32, 37, 64, 99, 300, 504].map(|bin| (Real, N, bin));
            let others = [(Iq, N, -200), (Real, 256, 60), (Real, 4096, 999)];
            for (kind, n, bin) in real.into_iter().chain(others) {
                for side in SIDES {
                    let ends = if side > 0.0 { (low, high) } else { (-high, -low) };
                    let bins = f64::from(bin) + ends.0..f64::from(bin) + ends.1;
                    let amplitude = amplitude(snr_db);
                    let noise = deviation(amplitude, snr_db);
                    let mut scene = tones(kind, n, [line(bins, amplitude)], noise);
                    scene.receiver.offset = [5.0.into(), (-3.0).into()];
                    let label =
                        format!("locked: {} {n}, {snr_db} dB, bin {bin} {ends:?}", kind.name());
                    let case = Case::new(label, scene, n).by(Path::Locked(bin)).trials(200);
                    let case = case.asks(Asked::OverBound { quantity: 0, most: 1.2 });
                    rows.push(case.never(Event::Elsewhere));
                }
            }
        }
    }
    let bound = Asked::OverBound { quantity: 0, most: 1.07 };
    let square = Asked::Square { quantity: 0, least: 0.95, most: 1.1 };
    hold_together("locked, all together", rows, &[bound, square]);
}

/// By every method, of pairs by turns whose tone is at an end of the band or beside it: no answer may be used that has no sigma.
#[test]
fn an_answer_without_a_sigma_is_not_usable() {
    let mut rows = Vec::new();
    for method in Method::ALL.iter().filter(|method| Alternating::<256, 512>::fits(**method)) {
        for side in SIDES {
            let bins = if side > 0.0 { 123.0..129.0 } else { -129.0..-123.0 };
            let label = format!("a sigma by {}", method.name());
            let case = by_turns(label, 256, bins.into(), side, 1000.0, 3.0);
            let case = noisy(case, None, Some((-10.0..60.0).into())).trials(300);
            let case = case.told(|config| {
                (config.band_hz, config.method) = (None, method.from_kind::<IqRecord>());
            });
            if case.config.plan::<IqRecord, 256>().is_ok() {
                rows.push(case.never(Event::Off(1e6)));
            }
        }
    }
    assert!(rows.len() > 10, "{}", rows.len());
    hold(rows);
}
