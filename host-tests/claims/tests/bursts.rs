//! Bursts anywhere in a stream: found, measured to the bound of their envelope, and told from two at once.

use picket_claims::scenes::{Kind, deviation, line, tones};
use picket_claims::{Asked, Case, Event, Path, hold, hold_together};
use picket_dsp::acquire::burst::Counters;
use picket_dsp::{Burst, BurstProcessor, Codes, Config, Real, Validation};
use picket_simulator::scene::{Change, Noise, Particle, Particles, Receiver, Source, Tone};
use picket_simulator::{Scene, Value};
use rayon::prelude::*;

use Kind::Iq;

const N: usize = 1024;
/// Records of a stream. Six before a burst the detector learns the noise from.
const STREAM: usize = 9;

/// Particles whose envelope has this deviation in records where they move at 1 m/s, of these velocities and this frequency in cycles a record.
fn particles(deviation: f64, at: Vec<Particle>, hz_per_mps: f64, shift_hz: f64) -> Particles {
    Particles {
        radius_m: 2.0 * deviation,
        fringe_m: 1.0 / hz_per_mps,
        shift_hz,
        at,
        ..Particles::default()
    }
}

/// Any frequency of 70 to 440 cycles a record: what the speed adds to it is next to nothing of the speed.
fn anywhere(deviation: f64, at: Vec<Particle>, side: f64) -> Particles {
    let wide = particles(deviation, at, 18_500.0, side * 255.0 - 18_500.0);
    Particles { velocity_mps: (0.99..1.01).into(), ..wide }
}

/// A particle that comes at a time in records, so much weaker than the first.
fn at(middle_s: impl Into<Value>, level_db: impl Into<Value>) -> Particle {
    Particle { middle_s: middle_s.into(), level_db: level_db.into(), ..Particle::default() }
}

/// A stream of particles in noise of so many codes.
fn stream(kind: Kind, of: Particles, amplitude: f64, noise: f64) -> Scene {
    let of = Particles { amplitude: Some(amplitude.into()), ..of };
    let scene = tones(kind, N, [], noise);
    Scene { sources: vec![Source::Particles(of)], seconds: STREAM as f64, ..scene }
}

/// .05 to .35 records, 0 to 50 dB at the top.
#[test]
fn bursts_are_found_and_measured_to_the_bound_of_their_envelope() {
    let mut rows = Vec::new();
    for long in [0.05, 0.1, 0.2, 0.35] {
        for snr_db in [0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0] {
            for kind in Kind::ALL {
                let noise = deviation(1000.0, snr_db);
                // Four deviations of the noise and the burst do not clip.
                let scale = (2000.0 / (1300.0 + 4.0 * noise)).min(1.0);
                let side = if kind == Iq && rows.len() % 4 == 1 { -1.0 } else { 1.0 };
                let of = anywhere(long, vec![at(6.0..7.0, 0.0)], side);
                let scene =
                    stream(kind, Particles { pedestal: 0.3, ..of }, 1000.0 * scale, noise * scale);
                let label = format!("bursts of {long} records: {}, {snr_db} dB", kind.name());
                let case = Case::new(label, scene, N).by(Path::Bursts(STREAM)).trials(150);
                let case =
                    case.square(0.8, 1.25).asks(Asked::OverBound { quantity: 0, most: 1.25 });
                // Of a hundred bursts one is taken for two particles.
                rows.push(if snr_db > 5.0 { case.at_least(0.95, Event::Usable) } else { case });
            }
        }
    }
    hold(rows);
}

/// Two particles within two deviations of each other, with frequencies that a turbulent flow of 10 % gives: flagged, or the tone is one of
/// theirs within five sigma.
#[test]
fn two_particles_at_once_are_flagged_or_right() {
    let mut rows = Vec::new();
    for long in [0.05, 0.1, 0.2] {
        for snr_db in [10.0, 20.0, 30.0, 40.0] {
            for (middle, hz) in
                [(6.07, 83.0), (6.29, 154.0), (6.48, 219.0), (6.71, 290.0), (6.92, 356.0)]
            {
                let other = Particle {
                    velocity_mps: Some((0.827..1.173).into()),
                    ..at(middle - 2.0 * long..middle + 2.0 * long, -14.0..0.0)
                };
                let both = vec![at(middle, 0.0), other];
                let of = Particles { pedestal: 0.0, ..particles(long, both, hz, 0.0) };
                let scene = stream(Kind::Real, of, 1000.0, deviation(1000.0, snr_db));
                let label =
                    format!("two particles at once: {long} records, {hz} bins, {snr_db} dB");
                let case = Case::new(label, scene, N).by(Path::Bursts(STREAM)).trials(30);
                rows.push(case.any_source());
            }
        }
    }
    let wrong = Asked::Share { of: Event::Wrong(5.0), least: 0.0, most: 0.03 };
    hold_together("two particles at once, all together", rows, &[wrong]);
}

/// A pulse that is on for .15 or .3 records, an ultrasonic echo that rises within .02 records and decays within .1, and a burst on a pedestal
/// of three times its fringes: each is one tone, and its sigma holds.
#[test]
fn pulses_of_other_envelopes_and_pedestals_are_valid() {
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        for snr_db in [6.0, 10.0, 20.0] {
            let noise = deviation(500.0, snr_db);
            for side in if kind == Iq { &[1.0, -1.0][..] } else { &[1.0] } {
                let ends = if *side > 0.0 { 70.0..440.0 } else { -440.0..-70.0 };
                let pulse = |level: f64, changes: Vec<Change>| Tone {
                    changes,
                    phase_turns: 0.0.into(),
                    ..line(ends.clone(), level)
                };
                let on = |from_s: Value, for_s: f64| Change::On { from_s, for_s: for_s.into() };
                let flat = |share: f64| {
                    vec![pulse(
                        500.0,
                        vec![on((6.0 - share / 2.0..7.0 - share / 2.0).into(), share)],
                    )]
                };
                // 1.6 (exp(-u) - exp(-6 u)), u the time in tenths of a record.
                let echo = |from_s: f64| {
                    let part = |time_s: f64, turns: f64| {
                        let (time_s, from) = (time_s.into(), Value::from(from_s));
                        let dies = Change::Decay { time_s, from_s: from.clone() };
                        let changes = vec![on(from, 1e9), dies];
                        Tone { phase_turns: turns.into(), ..pulse(800.0, changes) }
                    };
                    let other = part(0.1 / 6.0, 0.5);
                    vec![
                        part(0.1, 0.0),
                        Tone { frequency_hz: 0.0.into(), beside: Some(0), ..other },
                    ]
                };
                let pulses = [("flat .15", flat(0.15)), ("flat .3", flat(0.3))];
                let echoes = [6.07, 6.52, 6.83].map(|from_s| ("an echo", echo(from_s)));
                for (name, tone) in pulses.into_iter().chain(echoes) {
                    let scene = Scene { seconds: STREAM as f64, ..tones(kind, N, tone, noise) };
                    let label =
                        format!("{name} {}: {}, {snr_db} dB, side {side}", rows.len(), kind.name());
                    let case = Case::new(label, scene, N).by(Path::Bursts(STREAM)).trials(100);
                    let case = case.never(Event::Off(5.0)).square(0.09, 1.5);
                    rows.push(case.at_least(0.88, Event::Usable));
                }
            }
        }
    }
    for snr_db in [10.0, 20.0, 30.0] {
        let of = anywhere(0.08, vec![at(6.0..7.0, 0.0)], 1.0);
        let of = Particles { pedestal: 3.0, ..of };
        let scene = stream(Kind::Real, of, 400.0, deviation(500.0, snr_db));
        let case = Case::new(format!("a burst on a pedestal: {snr_db} dB"), scene, N);
        let case = case.by(Path::Bursts(STREAM)).trials(150).at_least(0.95, Event::Usable);
        rows.push(case.never(Event::Off(5.0)).square(0.3, 1.5));
    }
    hold(rows);
}

/// Two particles of one speed, whose bursts overlap: the sum of both is a tone whose phase turns in the middle. Three deviations apart and
/// from 20 dB on it is told; what is nearer or weaker looks like one particle of another speed.
#[test]
fn two_particles_of_one_speed() {
    let mut rows = Vec::new();
    for (apart, most) in [
        (1.0, [0.6, 0.35, 0.2]),
        (2.0, [0.45, 0.17, 0.06]),
        (3.0, [0.3, 0.03, 0.03]),
        (4.0, [0.03; 3]),
    ] {
        for (snr_db, most) in [10.0, 20.0, 30.0].into_iter().zip(most) {
            let middle = 6.0 + (0.31 * rows.len() as f64).fract();
            let both = vec![at(middle, 0.0), at(middle + apart * 0.08, -6.0..0.0)];
            let of = Particles { pedestal: 0.0, ..anywhere(0.08, both, 1.0) };
            let scene = stream(Kind::Real, of, 500.0, deviation(500.0, snr_db));
            let label = format!("two of one speed, {apart} deviations apart: {snr_db} dB");
            let case = Case::new(label, scene, N).by(Path::Bursts(STREAM)).trials(150);
            rows.push(case.at_most(most, Event::Wrong(5.0)));
        }
    }
    hold(rows);
}

/// At most one burst in 100,000 blocks of noise. docs/signals.md: noise triggers in about one record in fifty, of 1,024 real samples.
#[test]
fn noise_has_no_bursts() {
    let rows = [(Kind::Real, N, 200), (Kind::Real, 256, 400), (Iq, N, 100)];
    let rows = rows.map(|(kind, n, trials)| {
        let scene = Scene { seconds: 100.0, ..tones(kind, n, [], 200.0) };
        let case = Case::new(format!("noise has no bursts: {} {n}", kind.name()), scene, n);
        let case = case.by(Path::Bursts(100)).trials(trials).at_most(1e-3, Event::More);
        case.asks(Asked::Share { of: Event::Cut, least: 0.01, most: 0.04 })
    });
    hold(rows.into());
}

/// The bursts of codes that come in chunks, and the counters.
fn processed(codes: Codes, samples: &[i16], chunk: usize) -> (Vec<Burst>, Counters) {
    let plan = Config::new(1.0, codes).plan().unwrap();
    let mut processor = Box::new(BurstProcessor::<Real, N>::new(plan));
    let mut bursts = Vec::new();
    samples.chunks(chunk).for_each(|chunk| processor.push(chunk, |burst| bursts.push(*burst)));
    (bursts, *processor.counters())
}

fn codes(scene: &Scene, trial: u64) -> Vec<i16> {
    scene.codes(trial).unwrap().into_iter().map(|[i, _]| i).collect()
}

/// A scene whose seconds are samples.
fn samples(count: usize, sources: Vec<Source>, rms: f64) -> Scene {
    let noise = Noise { rms: Some(rms.into()), ..Noise::default() };
    let receiver = Receiver { noise, ..Receiver::default() };
    Scene { rate_hz: 1.0, seconds: count as f64, sources, receiver, ..Scene::default() }
}

/// A turbulent flow of 10 %: particles arrive as their number in the flow and their speed say, and the mean that weighs each by its transit
/// time is the flow's.
#[test]
fn the_mean_and_the_rms_of_a_turbulent_flow() {
    let (mean, turbulence) = (0.15, 0.1);
    let flow = Particles {
        turbulence_mps: turbulence,
        per_m: 1.0 / 6000.0,
        pedestal: 0.4,
        amplitude: Some(450.0.into()),
        sizes: 0.35,
        ..particles(80.0, Vec::new(), mean, 0.0)
    };
    let scene = samples(N * 1500, vec![Source::Particles(flow)], 30.0);
    let of_run = |trial| {
        let (bursts, counters) = processed(Codes::signed::<12>(), &codes(&scene, trial), 777);
        assert!(counters.lost < counters.bursts);
        let valid = bursts.into_iter().filter(|burst| burst.validation == Validation::Valid);
        let valid = valid.map(|b| [f64::from(b.deviation), b.tone.frequency.cycles() / mean]);
        valid.collect::<Vec<[f64; 2]>>()
    };
    let all: Vec<[f64; 2]> = (0..8).into_par_iter().flat_map_iter(of_run).collect();
    let weight: f64 = all.iter().map(|b| b[0]).sum();
    let mean = all.iter().map(|b| b[0] * b[1]).sum::<f64>() / weight;
    let rms = (all.iter().map(|b| b[0] * (b[1] - mean).powi(2)).sum::<f64>() / weight).sqrt();
    println!("{} bursts: mean {mean:.5}, rms {rms:.5}", all.len());
    // Chance adds 10 % over the root of the number of bursts, and the rms twice its own share.
    let chance = 3.0 / (all.len() as f64).sqrt();
    assert!((mean - 1.0).abs() < 0.003 + 0.1 * chance, "{mean}");
    assert!((rms / turbulence - 1.0).abs() < 0.03 + 0.7 * chance, "{rms}");
}

/// Chunks of any length have equal bursts; none goes across a gap; unsigned codes; a steady tone is long.
#[test]
fn chunks_gaps_and_what_is_no_burst() {
    let signed = Codes::signed::<12>();
    let middles = (1..10).map(|k| 5000.0 * f64::from(k));
    let all =
        middles.clone().map(|middle| Particle { turns: Some(0.16.into()), ..at(middle, 0.0) });
    let of = particles(100.0, all.collect(), 0.2, 0.0);
    let of = Particles { pedestal: 0.0, amplitude: Some(900.0.into()), ..of };
    let scene = samples(50_000, vec![Source::Particles(of)], 20.0);
    // A trial whose noise triggers nothing else, and of whose bursts none is taken for two.
    let samples_of = codes(&scene, 2);
    let (whole, counters) = processed(signed, &samples_of, samples_of.len());
    assert_eq!((whole.len(), counters.lost, counters.samples), (9, 0, 50_000));
    assert!(counters.bursts >= 9 && counters.dead < 9 * 1024);
    for (burst, middle) in whole.iter().zip(middles) {
        assert_eq!(burst.validation, Validation::Valid, "{burst:?}");
        assert!((burst.arrival - middle).abs() < 2.0, "{burst:?}");
        assert!((burst.deviation / 100.0 - 1.0).abs() < 0.03, "{burst:?}");
        assert!((burst.tone.amplitude / 900.0 - 1.0).abs() < 0.03, "{burst:?}");
    }
    for chunk in [1, 15, 16, 1000] {
        assert_eq!(processed(signed, &samples_of, chunk).0, whole, "chunks of {chunk}");
    }
    let valid = |mut bursts: Vec<Burst>| {
        bursts.retain(|burst| burst.validation == Validation::Valid);
        bursts
    };
    // That converter, with codes from 0 on.
    let mut unsigned = scene.clone();
    unsigned.converter.unsigned = true;
    let (bursts, _) = processed(Codes::unsigned::<12>(), &codes(&unsigned, 2), 50_000);
    assert_eq!(valid(bursts).len(), 9);
    // A gap in the middle of the fourth burst, of 3,003 samples.
    let plan = Config::new(1.0, signed).plan().unwrap();
    let mut processor = BurstProcessor::<Real, N>::new(plan);
    let mut bursts = Vec::new();
    processor.push(&samples_of[..20_000], |burst| bursts.push(*burst));
    processor.lost(3003);
    processor.push(&samples_of[23_003..], |burst| bursts.push(*burst));
    let bursts = valid(bursts);
    assert_eq!((bursts.len(), processor.counters().lost), (8, 1));
    for burst in &bursts {
        assert!(whole.iter().any(|other| (other.arrival - burst.arrival).abs() < 0.5));
    }
    // A tone that stays.
    let stays = Change::On { from_s: 8192.0.into(), for_s: 1e9.into() };
    let tone = Tone { changes: vec![stays], ..line(0.143, 800.0) };
    let scene = samples(108_192, vec![Source::Tone(tone)], 20.0);
    let (bursts, counters) = processed(signed, &codes(&scene, 2), 4096);
    assert!(bursts.is_empty(), "{bursts:?}");
    assert!(counters.long > 0);
}
