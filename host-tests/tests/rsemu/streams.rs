//! Blocks without a pause: none is lost, each is right to the bit.

use crate::board::{Emulated, Sectors, file};
use crate::settings::tone;
use host_tests::sized;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::Plan as Terms;
use picket_firmware::nucleo_f446re::N;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_host::rates;
use picket_wire::command::{Command, Refusal};
use picket_wire::settings::Settings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Codes of a converter: a tone over a table whose length has no factor in common with a block's.
pub fn table(amplitude: f64) -> Vec<u16> {
    let length = 8191;
    let code = |n: usize| {
        let angle = std::f64::consts::TAU * 1013.0 * n as f64 / length as f64;
        let noise = ((n * 7919) % 61) as f64 - 30.0;
        (2048.0 + amplitude * angle.sin() + noise).round().clamp(0.0, 4095.0) as u16
    };
    (0..length).map(code).collect()
}

/// The serial line's characters a second: as it is, so that it takes some records only, and three times as fast, so that it takes one of
/// each block.
const LINE: u32 = 92_160;
const FAST: u32 = 3 * LINE;

/// A board without power that was saved these settings, with these codes at its input.
pub fn fed(settings: &Settings, codes: &[u16]) -> Emulated {
    let mut board = Emulated::plug();
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    board.order(&format!("input 0 table {}", file(&bytes).display()));
    let mut sectors = Sectors::new();
    sectors.save(settings);
    board.load(&sectors);
    board
}

/// Blocks without a pause, each record right to the bit. Returns what the board says at the end.
fn stream(
    settings: &Settings,
    codes: &[u16],
    blocks: u64,
    line: u32,
) -> picket_wire::status::Status {
    let mut board = fed(settings, codes);
    board.order(&format!("line {line}"));
    let (mut board, boot) = board.power();
    assert!(boot.measuring);
    let speed = Speed::from_mhz(settings.core_mhz).unwrap();
    let (plan, _) = Words::plan::<N>(settings, &Tree::new(speed, Source::HsePll)).unwrap();
    let mut pipeline = Pipeline::<Real, N>::new(Terms::from_terms(*plan.plan).unwrap());
    let time = blocks as f64 * N as f64 / settings.config.rate_hz;
    let mut left = (time * 1e6) as u64;
    let mut seen = 0;
    while left > 0 {
        let piece = left.min(100_000);
        board.run(piece);
        left -= piece;
        for record in board.telemetry() {
            let stamp = record.measurement.stamp;
            let from = stamp.clock as usize;
            let samples = std::array::from_fn(|n| codes[(from + n) % codes.len()] as i16);
            let mut expected = pipeline.block(&stamp, &samples);
            settings.calibration.apply(&mut expected);
            assert_eq!(record.measurement, expected, "block {}", stamp.sequence);
            assert!(line == LINE || u64::from(stamp.sequence) == seen, "a block without a record");
            seen += 1;
        }
    }
    let status = board.status();
    println!(
        "{:.2} MS/s: {seen} records right of {} blocks, {} lost; awake {} permille, the longest block {} permille, {:.0} cycles",
        settings.config.rate_hz / 1e6,
        status.counters.blocks,
        status.counters.lost(),
        status.load,
        status.peak,
        // The timer has half of the core's rate.
        2.0 * f64::from(status.longest)
    );
    let blocks = u64::from(status.counters.blocks);
    // The last ones are under way.
    let least = if line == LINE { blocks / 2 } else { blocks - 4 };
    assert!(seen >= least, "{seen} of {blocks}");
    board.assert_rules();
    status
}

/// Codes of blocks one after the other, each with a tone of its own below bin 48 that moves by three bins beside a drift, which takes longest.
pub fn moving(blocks: usize) -> Vec<u16> {
    let mut rng = ChaCha8Rng::seed_from_u64(24);
    let block = |_| {
        let (bin, phase) = (rng.random_range(3.0..48.0), rng.random_range(0.0..TAU));
        let drift = rng.random_range(50.0..500.0);
        let mut noise: Vec<f64> = (0..N).map(|_| rng.random_range(-6.0..6.0)).collect();
        for (n, code) in noise.iter_mut().enumerate() {
            let time = n as f64 / N as f64;
            let tone = 1000.0 * (TAU * (bin + 1.5 * time) * time + phase).cos();
            *code += 2048.0 + tone + drift * (time - 0.5);
        }
        noise.into_iter().map(|code| code.round().clamp(0.0, 4095.0) as u16)
    };
    (0..blocks).flat_map(block).collect()
}

/// At the rates that are said to hold whatever the signal is, none is lost where each block is one of those that take longest.
#[test]
fn tones_that_move_beside_a_drift_hold_a_slower_rate() {
    let [real, _] = rates::nucleo();
    let blocks = sized(100, 5_000);
    // As many as no two of them in the slots at the same time are the same.
    let codes = moving(61);
    for (effort, rate_hz) in real.always_hz {
        let settings = tone(rate_hz);
        let settings = Settings { effort: Some(effort), worst_case: true, ..settings };
        let status = stream(&settings, &codes, blocks, FAST);
        assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0), "{status:?}");
        // A block takes longer than it lasts where usual ones hold.
        let usual = 1000.0 * real.usual_hz / rate_hz;
        println!("{}: {} permille of {usual:.0}", effort.name(), status.peak);
        // The next rate that the timer makes is refused, and its reason tells what to do.
        let (mut board, _) = Emulated::start(&settings);
        let apart = (22.5e6 / rate_hz).round();
        // A conversion takes 15 of the converter's cycles, and 18 where each is triggered.
        let nearer = if apart > 18.0 { apart - 1.0 } else { 15.0 };
        let config = Config { rate_hz: 22.5e6 / nearer, ..settings.config };
        let faster = Settings { config, ..settings };
        let refused = board.request(Command::SetSettings(faster, N)).unwrap_err();
        assert_eq!(refused, Refusal::Settings([3, 3]));
        assert!(refused.to_string().contains("effort to 0"), "{refused}");
    }
}

#[test]
fn no_block_is_lost_at_one_and_a_half_million_samples_a_second() {
    let blocks = sized(100, 10_000);
    // Blocks that clip take longer: in one sample of twenty, and in nearly all.
    for (rate_hz, amplitude, share) in [(1.5e6, 900.0, 1), (750e3, 2100.0, 4), (750e3, 6000.0, 4)] {
        let settings = tone(rate_hz);
        let status = stream(&settings, &table(amplitude), blocks / share, FAST);
        assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0), "{status:?}");
        assert!(u64::from(status.counters.blocks) >= blocks / share - 2);
    }
}

/// What the settings allow is measured without a loss beside all records that the line takes, and what is faster is refused:
/// `sampling::BLOCK_CYCLES`.
#[test]
fn the_fastest_rate_that_is_not_refused_holds() {
    // 25 cycles of 36 MHz a sample: a block lasts 102,400 cycles of the core. One cycle less is refused.
    let settings = Settings { core_mhz: 144, ..tone(36e6 / 25.0) };
    let blocks = sized(150, 2_000);
    let status = stream(&settings, &table(900.0), blocks, LINE);
    assert_eq!((status.counters.lost(), status.counters.faults()), (0, 0), "{status:?}");
    let (mut board, _) = Emulated::start(&settings);
    for rate_hz in [36e6 / 24.0, 2.4e6] {
        let faster = Settings { core_mhz: 144, ..tone(rate_hz) };
        let refused = board.request(Command::SetSettings(faster, N));
        assert_eq!(refused, Err(Refusal::Settings([3, 2])));
    }
}

/// Both converters in step: the sign is right, from the start and after each overrun.
#[test]
fn pairs_are_right_after_each_overrun() {
    let mut settings = Settings { iq: true, report_every: 5, ..tone(500e3) };
    // Without its image, which the wrong sign would be.
    settings.config.band_hz = Some((1e4, 2.4e5));
    let mut board = Emulated::plug();
    let length = 8191;
    for (channel, turn) in [(0, 0.0), (1, -0.25)] {
        let angle = |n: usize| std::f64::consts::TAU * (1013.0 * n as f64 / length as f64 + turn);
        let codes = (0..length).map(|n| (2048.0 + 900.0 * angle(n).cos()).round() as u16);
        let bytes: Vec<u8> = codes.flat_map(u16::to_le_bytes).collect();
        board.order(&format!("input {channel} table {}", file(&bytes).display()));
    }
    let mut sectors = Sectors::new();
    sectors.save(&settings);
    board.load(&sectors);
    let (mut board, boot) = board.power();
    assert!(boot.measuring, "{boot:?}");
    let truth = 1013.0 / length as f64;
    for round in 0..=sized(2, 20) {
        board.run(30_000);
        assert_eq!(u64::from(board.status().counters.adc_overruns), round);
        let records = board.telemetry();
        assert!(records.len() > 1, "{} records", records.len());
        for record in records {
            let tone = record.measurement.tone;
            let off = tone.frequency.cycles() - truth;
            assert!(off.abs() < 5.0 * f64::from(tone.sigma), "round {round}: {tone:?}");
            assert!(tone.snr_db() > 40.0, "round {round}: {tone:?}");
        }
        board.run(311 * round);
        board.order("overrun");
    }
    board.assert_rules();
}
