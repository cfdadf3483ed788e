//! The sync input: a rise starts a chirp's samples, and nothing else does.

use super::chirp::in_place;
use super::faults::any;
use super::scene::{expected, frames, plug, record, set_plan, status};
use host_tests::sized;
use picket_claims::scenes::{self, Kind, line};
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_firmware::pico::N;
use picket_firmware::pico::words::Words;
use picket_host::device::Said;
use picket_host::pico::bench::Pico;
use picket_wire::command::Command;
use picket_wire::settings::{Drive, Settings};
use picket_wire::telemetry::Telemetry;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Chirps of an external source.
fn settings(shape: Shape, guard: u16, rate_hz: f64) -> Settings {
    let scene = Scene::Chirp(Chirp {
        shape,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 1.0,
        ..Chirp::default()
    });
    let config = Config { rate_hz, scene, ..Settings::default().config };
    Settings { config, guard, drive: Drive::External, ..Settings::default() }
}

/// The time of a chirp, us.
fn chirp(settings: &Settings) -> u64 {
    let (plan, words) = Words::plan(settings).unwrap();
    let blocks = plan.timing.segments.len() as u64;
    (blocks * u64::from(words.block_cycles())).div_ceil(48)
}

/// A board that waits for pulses.
fn waiting(settings: Settings, feed: impl FnOnce(&mut Pico)) -> Pico {
    let mut pico = plug();
    pico.power().unwrap();
    set_plan(&mut pico, settings, feed);
    pico
}

/// Samples of so many chirps, with a tone in each segment.
fn tones(settings: &Settings, chirps: usize, seed: u64) -> Vec<i16> {
    let (plan, words) = Words::plan(settings).unwrap();
    let mut scene = scenes::tones(Kind::Real, N, [line(20.0..480.0, 900.0)], 2.3);
    (scene.seed, scene.converter.unsigned) = (seed, true);
    let segments = 0..(chirps * plan.timing.segments.len()) as u64;
    let codes = |segment| scene.run(segment).unwrap().codes(0.0, words.transfers() as usize);
    segments.flat_map(codes).map(|[code, _]| code).collect()
}

/// Pulses at any distance: each record is the host's, each chirp has its samples and no more.
#[test]
fn every_record_after_a_pulse_is_the_hosts() {
    let chirps = sized(15, 300) as usize;
    let mut pairs = settings(Shape::Sawtooth, 0, 250e3);
    (pairs.iq, pairs.config.band_hz) = (true, Some((1e3, 125e3)));
    for (settings, seed) in [
        (settings(Shape::Trapezoid, 64, 500e3), 71),
        (settings(Shape::Sawtooth, 0, 500e3), 72),
        (settings(Shape::Triangle, 32, 300e3), 73),
        (pairs, 74),
    ] {
        let shape = settings.config.scene.segments();
        let samples = tones(&settings, chirps, seed);
        let mut pico = waiting(settings, |pico| pico.samples(&samples).unwrap());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        pico.run(20_000).unwrap();
        pico.order("delays").unwrap();
        let taken = pico.figures().unwrap().taken;
        for _ in 0..chirps {
            pico.order("rise").unwrap();
            // Now and then at once after the last one.
            let pause = if rng.random() { 3 } else { rng.random_range(3..4_000) };
            pico.run(chirp(&settings) + pause).unwrap();
        }
        pico.run(20_000).unwrap();
        let figures = pico.figures().unwrap();
        assert_eq!(figures.taken - taken, samples.len() as u64, "{shape:?}");
        let wanted = expected(&settings, &samples);
        let records = frames(&pico.sent);
        assert_eq!(records.len(), wanted.len(), "{shape:?}");
        for (((sequence, frame), wanted), number) in records.iter().zip(&wanted).zip(0..) {
            assert_eq!(*sequence, number, "{shape:?}, seed {seed}");
            assert!(frame == wanted, "{number}: {:#?}", [frame, wanted].map(|frame| record(frame)));
        }
        let counters = status(&mut pico).counters;
        assert_eq!((counters.lost(), counters.faults()), (0, 0), "{shape:?}");
        let delays = pico.order("delays").unwrap();
        println!("{shape:?}: {} records byte for byte, {delays:?} ns", records.len());
    }
}

/// A pulse that comes too early has no samples; its blocks are counted as lost, and the next record tells of a gap.
#[test]
fn pulses_in_vain_are_counted() {
    for (shape, guard) in [(Shape::Trapezoid, 64), (Shape::Sawtooth, 0)] {
        let settings = settings(shape, guard, 500e3);
        let samples = tones(&settings, 40, 74);
        let mut pico = waiting(settings, |pico| pico.samples(&samples).unwrap());
        let segments = settings.segments() as u32;
        let mut rng = ChaCha8Rng::seed_from_u64(74);
        // The place of each chirp among all pulses.
        let (mut pulses, mut places) = (0, Vec::new());
        for _ in 0..sized(20, 40) {
            places.push(pulses);
            pulses += 1;
            pico.order("rise").unwrap();
            let mut rest = chirp(&settings) + rng.random_range(3..3_000);
            for _ in 0..rng.random_range(0..3) {
                let early = rng.random_range(20..chirp(&settings) / 3);
                pico.run(early).unwrap();
                pico.order("rise").unwrap();
                (pulses, rest) = (pulses + 1, rest - early);
            }
            pico.run(rest).unwrap();
        }
        // One more chirp tells of the last ones.
        places.push(pulses);
        pico.order("rise").unwrap();
        pico.run(chirp(&settings) + 20_000).unwrap();
        let records: Vec<Telemetry> =
            frames(&pico.sent).iter().filter_map(|(_, frame)| record(frame)).collect();
        assert_eq!(records.len(), places.len() * segments as usize, "{shape:?}");
        for (count, record) in records.iter().enumerate() {
            let stamp = record.measurement.stamp;
            let (chirp, segment) = (count / segments as usize, count as u32 % segments);
            assert_eq!(stamp.sequence, places[chirp] * segments + segment, "{shape:?} {stamp:?}");
            let early = segment == 0 && chirp > 0 && places[chirp] > places[chirp - 1] + 1;
            assert_eq!(stamp.gap, early, "{shape:?} {stamp:?}");
        }
        let counters = status(&mut pico).counters;
        let vain = pulses + 1 - places.len() as u32;
        println!("{shape:?}: {vain} of {} pulses in vain", pulses + 1);
        assert!(vain > 5 && counters.faults() == 0, "{counters:?}");
        assert_eq!((counters.missed, counters.lost()), (vain * segments, vain * segments));
    }
}

/// Without pulses the board waits, says so each second, and takes the next one.
#[test]
fn a_board_without_pulses_waits() {
    let settings = settings(Shape::Triangle, 16, 500e3);
    let samples = tones(&settings, 2, 75);
    let mut pico = waiting(settings, |pico| pico.samples(&samples).unwrap());
    let resets = pico.resets.len();
    pico.take();
    pico.run(9_000_000).unwrap();
    assert_eq!(pico.resets.len(), resets, "the watchdog bit a board that waits");
    let told = pico.take().iter().filter(|said| matches!(said, Said::Status(_))).count();
    assert!((8..=10).contains(&told), "{told} statuses");
    assert!(frames(&pico.sent).is_empty());
    // A save stops the wait, and begins it again.
    assert_eq!(pico.request(Command::Save).unwrap(), Ok(vec![]));
    pico.order("rise").unwrap();
    pico.run(chirp(&settings) + 20_000).unwrap();
    assert_eq!(frames(&pico.sent).len(), 2);
    let counters = status(&mut pico).counters;
    assert_eq!((counters.blocks, counters.faults()), (2, 0), "{counters:?}");
}

/// Faults at any moment, pulses at any moment: each chirp that is sampled is sampled from its first sample on, in its slot's first place.
#[test]
fn faults_between_pulses_mix_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(76);
    for round in 0..sized(1, 10) {
        let settings = settings(Shape::Trapezoid, 64, 500e3);
        let (plan, _) = Words::plan(&settings).unwrap();
        let mut pico = waiting(settings, |pico| {
            pico.keep(N).unwrap();
            pico.order("count").unwrap();
        });
        for fault in 0..sized(25, 40) {
            for _ in 0..rng.random_range(1..4) {
                pico.order("rise").unwrap();
                pico.run(chirp(&settings) + rng.random_range(3..2_000)).unwrap();
            }
            pico.order("rise").unwrap();
            pico.run(rng.random_range(3..8_000)).unwrap();
            let (kind, duration) = any(&mut rng);
            pico.fault(kind, duration).unwrap();
            pico.run(duration as u64).unwrap();
            if fault == 12 {
                assert_eq!(pico.request(Command::Save).unwrap(), Ok(vec![]));
            }
            pico.run(9_000).unwrap();
        }
        pico.run(20_000).unwrap();
        let length = plan.length as i16;
        // An overrun leaves a hole in its block, and that block is dropped.
        let whole = |samples: &[i16]| {
            let first = samples[0];
            first % length == 64 && samples.iter().zip(first..).all(|(&code, at)| code == at)
        };
        let kept = pico.kept(N).unwrap();
        let wholes = kept.iter().filter(|block| whole(&block.samples)).count();
        let codes: Vec<i16> = (0..3 * length).collect();
        let records = in_place(&pico, &settings, &codes);
        let counters = status(&mut pico).counters;
        println!(
            "round {round}: {wholes} of {} blocks whole, {records} records, {counters:?}",
            kept.len()
        );
        assert!(counters.faults() > 0 && records > 100 && wholes >= records);
        assert!(kept.len() - wholes <= 2 * counters.adc_overruns as usize);
    }
}
