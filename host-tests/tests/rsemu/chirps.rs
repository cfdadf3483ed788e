//! Chirps: the DAC's codes, the sync pins, and what an overrun or an underrun does to them.

use crate::board::Emulated;
use crate::saves::played;
use crate::settings::{DAC, chirp, words};
use host_tests::sized;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::config::{Config, Following};
use picket_dsp::solve::chirp::Shape;
use picket_firmware::nucleo_f446re::N;
use picket_wire::command::{Command, Request};
use picket_wire::settings::{Drive, Settings};

/// The DAC plays the table, each code once a chirp, at even distances.
#[test]
fn a_chirp_is_played_code_by_code() {
    // Above 1.5 MS/s only the image that follows tones keeps up.
    let all: &[(f64, u16)] = &[
        (500e3, 0),
        (1.5e6, 32),
        (100e3, 0),
        (100e3, 32),
        (500e3, 32),
        (1e6, 0),
        (1e6, 32),
        (1.5e6, 0),
        (1.8e6, 0),
        (1.8e6, 32),
        (2e6, 0),
        (2e6, 32),
        (2.4e6, 0),
        (2.4e6, 32),
    ];
    for &(rate, guard) in &all[..sized(2, all.len() as u64) as usize] {
        let core_mhz = if rate > 1.5e6 { 144 } else { 180 };
        let mut settings =
            Settings { core_mhz, report_every: 20, ..chirp(rate, Shape::Sawtooth, guard, DAC) };
        if rate > 1.5e6 {
            let following = Following { most: 1, refresh: 16, ..Following::default() };
            settings.config = Config { following, ..settings.config };
        }
        let (mut board, boot) = Emulated::start(&settings);
        assert!(boot.measuring, "{rate}, guard {guard}");
        let wave = words(&settings).waveform.unwrap();
        board.order("keep 1");
        board.run((5.0 * f64::from(1024 + guard) / rate * 1e6) as u64);
        let codes = board.pairs("codes");
        assert!(codes.len() > 4 * wave.len(), "{rate}, guard {guard}: {} codes", codes.len());
        let table: Vec<u32> = (0..wave.len()).map(|step| wave.code(step).into()).collect();
        let first = table.iter().position(|code| *code == codes[0].1).unwrap();
        for (n, (_, code)) in codes.iter().enumerate() {
            assert_eq!(*code, table[(first + n) % table.len()], "{rate}, guard {guard}, code {n}");
        }
        // A step lasts `hold` samples; the first bus has half of the timers' rate.
        let ticks = u64::from(wave.hold) * u64::from(words(&settings).sampling.period.ticks()) / 2;
        for pair in codes.windows(2) {
            assert!(
                (pair[1].0 - pair[0].0).abs_diff(ticks) <= 1,
                "{rate}, guard {guard}: {pair:?} {ticks}"
            );
        }
        assert_eq!(board.status().counters.faults(), 0);
        board.assert_rules();
        println!("{:.1} MS/s, guard {guard}: {} codes right", rate / 1e6, codes.len());
    }
}

/// Whenever the chirp stands the DAC holds its first code: while flash is erased, and when a host has stopped the board.
#[test]
fn the_dac_rests_at_the_first_code() {
    let settings = Settings { report_every: 9, ..chirp(500e3, Shape::Trapezoid, 32, DAC) };
    let mut board = Emulated::plug();
    board.order("erase 100");
    let (mut board, _) = board.power();
    board.request(Command::SetSettings(settings, N)).unwrap();
    board.boot();
    board.run(7_311);
    // EN 0 and TEN 2 of DAC_CR, and DAC_DOR1.
    let dac = |board: &mut Emulated| (board.read(0x4000_7400) & 5, board.read(0x4000_742C));
    assert_eq!(dac(&mut board).0, 5, "it plays");
    board.hear(&Request { tag: 9, command: Command::Save }.to_frame());
    for _ in 0..3 {
        board.run(20_000);
        assert_eq!(dac(&mut board), (1, 400), "while it saves");
    }
    board.run(100_000);
    assert_eq!(dac(&mut board).0, 5, "it plays again");
    board.request(Command::Stop).unwrap();
    assert!(!board.boot().measuring);
    assert_eq!(dac(&mut board), (1, 400), "stopped");
    board.assert_rules();
}

/// A code of the DAC that is not fetched in time ends its requests: the chain starts anew, and counts what was lost.
#[test]
fn an_underrun_of_the_dac_is_told_and_mended() {
    let settings = Settings { report_every: 9, ..chirp(500e3, Shape::Trapezoid, 32, DAC) };
    let (mut board, _) = Emulated::start(&settings);
    board.order("input 0 dac");
    for round in 1..=sized(2, 20) {
        board.run(7_000 + 311 * round);
        board.order("underrun");
        board.run(20_000);
        let counters = board.status().counters;
        assert_eq!((counters.dma_errors, counters.faults()), (round as u32, round as u32));
        // The rest of the chirp at most, and the block under way.
        assert!((1..=4 * round as u32).contains(&counters.broken), "{counters:?}");
        let (measurement, codes) = board.capture();
        assert_eq!(measurement.stamp.segment, played(&codes), "round {round}");
    }
    board.assert_rules();
}

/// After each overrun the next chirp is met at its first sample.
#[test]
fn an_external_chirp_is_met_anew_after_each_overrun() {
    let settings =
        Settings { report_every: 30, ..chirp(500e3, Shape::Trapezoid, 32, Drive::External) };
    let (mut board, _) = Emulated::start(&settings);
    // Ticks of the second bus since the pulse, 180 a sample.
    board.order("input 0 pulse 180");
    board.pulses(8_000);
    board.run(20_000);
    for round in 0..sized(4, 100) {
        // A chirp lasts 6.3 of the 8 ms: the overrun comes anywhere in it.
        board.run(8_000 + 731 * (round % 11));
        board.order("overrun");
        board.run(9_000);
        let (measurement, codes) = board.capture();
        let segment = match measurement.stamp.segment {
            Segment::Up => 0,
            Segment::Flat => 1,
            Segment::Down => 2,
            Segment::Continuous => panic!("a chirp"),
        };
        let first = 1056 * segment + 32;
        for (n, code) in codes.iter().enumerate() {
            // From the pulse to the first result pass a sample, and the conversion.
            let late = i64::from(*code) - (first + n as i64);
            assert!((0..=3).contains(&late), "round {round}, sample {n}: {late}");
        }
    }
    board.assert_rules();
}

/// TIM2_ARR.
const RELOAD: u32 = 0x4000_002C;

/// The gate takes the same samples if it opens or closes some ticks early or late, chirp after chirp: it closes in the middle between two
/// samples.
#[test]
fn a_gate_that_closes_early_or_late_takes_the_same_samples() {
    let settings =
        Settings { report_every: 3, ..chirp(500e3, Shape::Trapezoid, 32, Drive::External) };
    for wrong in [-60, -1, 1, 60] {
        let (mut board, _) = Emulated::start(&settings);
        let reload = board.read(RELOAD);
        assert_eq!(reload, 3 * 1056 * 180);
        board.write(RELOAD, reload.wrapping_add_signed(wrong));
        board.order("input 0 pulse 180");
        board.pulses(7_000);
        // Without the core's help the clock would be half a sample off after 90 chirps.
        for _ in 0..sized(3, 150) {
            board.run(7_000);
            let (measurement, codes) = board.capture();
            let first = 32 + 1056 * (measurement.stamp.segment as i64 - 1);
            for (n, code) in codes.iter().enumerate() {
                let late = i64::from(*code) - (first + n as i64);
                assert!((0..=2).contains(&late), "{wrong}, sample {n}: {late}");
            }
        }
        let counters = board.status().counters;
        assert_eq!((counters.lost(), counters.faults()), (0, 0), "{wrong}");
        board.assert_rules();
    }
}

/// A chirp that lacks a sample is a fault, and the next one is met at its first sample.
#[test]
fn a_chirp_without_all_its_samples_is_a_fault() {
    let settings =
        Settings { report_every: 30, ..chirp(500e3, Shape::Trapezoid, 32, Drive::External) };
    let (mut board, _) = Emulated::start(&settings);
    board.order("input 0 pulse 180");
    board.pulses(8_000);
    for round in 1..=sized(3, 30) {
        board.run(8_000 + 731 * (round % 8));
        board.order("miss");
        board.run(16_000);
        let counters = board.status().counters;
        assert_eq!((counters.dma_errors, counters.faults()), (round as u32, round as u32));
        let (measurement, codes) = board.capture();
        let first = 32 + 1056 * (measurement.stamp.segment as i64 - 1);
        let late = i64::from(codes[0]) - first;
        assert!((0..=2).contains(&late), "round {round}: {late}");
    }
    board.assert_rules();
}

/// Rises while a chirp runs open no gate: the blocks of their chirps are lost, and counted before the next chirp's.
#[test]
fn pulses_in_vain_are_counted() {
    let settings =
        Settings { report_every: 1, ..chirp(500e3, Shape::Trapezoid, 32, Drive::External) };
    // A chirp lasts 6.336 ms: of so many pulses one opens the gate.
    for (period, of) in [(7_000, 1), (6_300, 2), (4_000, 2), (2_500, 3)] {
        let (mut board, _) = Emulated::start(&settings);
        board.pulses(period);
        board.run(5_000 * 8 * of);
        let records = board.telemetry();
        assert!(records.len() >= 12, "{period}: {}", records.len());
        for pair in records.windows(2) {
            let [one, next] = [&pair[0].measurement.stamp, &pair[1].measurement.stamp];
            let chirp_ends = next.segment == Segment::Up;
            let step = if chirp_ends { 3 * (of as u32 - 1) + 1 } else { 1 };
            assert_eq!(next.sequence - one.sequence, step, "{period}: {one:?} {next:?}");
            assert_eq!(next.gap, step > 1, "{period}");
        }
        let counters = board.status().counters;
        let expected = (of as u32 - 1) * counters.blocks;
        assert!(counters.missed.abs_diff(expected) <= 6, "{period}: {counters:?}");
        assert_eq!(counters.faults(), 0, "{period}");
        board.assert_rules();
    }
}

/// A flood of pulses costs a chirp some interrupts, not all of the core.
#[test]
fn a_flood_of_pulses_loses_no_block_of_the_chirps_that_are_taken() {
    let settings =
        Settings { report_every: 3, ..chirp(500e3, Shape::Trapezoid, 32, Drive::External) };
    let (mut board, _) = Emulated::start(&settings);
    // One every 4 us.
    board.pulses_of(1, 64, 128);
    board.run(sized(100_000, 1_000_000));
    let counters = board.status().counters;
    assert!(counters.blocks > 40, "{counters:?}");
    assert!(counters.missed >= counters.blocks, "{counters:?}");
    assert_eq!((counters.overruns, counters.late, counters.faults()), (0, 0, 0), "{counters:?}");
    board.assert_rules();
}

/// Pulses of 62 ns at the sync input are none; of 125 ns they are.
#[test]
fn a_spike_opens_no_gate() {
    let settings =
        Settings { report_every: 1, ..chirp(500e3, Shape::Sawtooth, 32, Drive::External) };
    for (width, opens) in [(2, false), (4, true)] {
        let (mut board, _) = Emulated::start(&settings);
        // One every 4 ms.
        board.pulses_of(1, width, 128_000);
        board.run(20_000);
        let counters = board.status().counters;
        assert_eq!(counters.blocks > 0, opens, "{width}: {counters:?}");
        assert_eq!((counters.lost(), counters.faults()), (0, 0), "{width}: {counters:?}");
    }
}

/// The sync output rises with the first sample of each chirp, and at no other time.
#[test]
fn the_sync_output_has_an_edge_a_chirp() {
    let settings = Settings { report_every: 9, ..chirp(500e3, Shape::Trapezoid, 32, DAC) };
    let (mut board, _) = Emulated::start(&settings);
    for round in 0..sized(4, 20) {
        board.pairs("edges");
        // The output is low for two thirds of a chirp, high for the first.
        board.run(1_700 + 1_310 * (round % 7));
        board.order("overrun");
        board.run(30_000);
        let edges = board.pairs("edges");
        // 90 MHz; a segment has 1056 samples of 180 ticks, a chirp three.
        let (segment, chirp) = (1056 * 180, 3 * 1056 * 180);
        let rises: Vec<u64> =
            edges.iter().filter(|(_, high)| *high == 1).map(|(at, _)| *at).collect();
        let falls: Vec<u64> =
            edges.iter().filter(|(_, high)| *high == 0).map(|(at, _)| *at).collect();
        let mut uneven = 0;
        for pair in rises.windows(2) {
            uneven += u32::from((pair[1] - pair[0]).abs_diff(chirp) > 90);
        }
        // The restart shifts the chirps once.
        assert!(uneven <= 1, "{edges:?}");
        for rise in &rises[1..] {
            if let Some(fall) = falls.iter().find(|fall| *fall > rise) {
                assert!((fall - rise).abs_diff(segment) <= 90, "{edges:?}");
            }
        }
    }
}
