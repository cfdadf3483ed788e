//! The NUCLEO's real image from power-on, on rsemu's model of the chip with converters of our own (`host-tests/rsemu`): what a
//! board would show at its first power-up.
//!
//! Each test has a short form. `PICKET_LONG=1 cargo test --test rsemu` runs the long ones.

#[path = "rsemu/board.rs"]
mod board;
#[path = "rsemu/brown_out.rs"]
mod brown_out;
#[path = "rsemu/chirps.rs"]
mod chirps;
#[path = "rsemu/latency.rs"]
mod latency;
#[path = "rsemu/line.rs"]
mod line;
#[path = "rsemu/logs.rs"]
mod logs;
#[path = "rsemu/saves.rs"]
mod saves;
#[path = "rsemu/self_test.rs"]
mod self_test;
#[path = "rsemu/settings.rs"]
mod settings;
#[path = "rsemu/source.rs"]
mod source;
#[path = "rsemu/streams.rs"]
mod streams;

use board::{Emulated, Sectors};
use host_tests::sized;
use picket_dsp::solve::chirp::Shape;
use picket_firmware::nucleo_f446re::N;
use picket_wire::boot::{Clock, Origin};
use picket_wire::command::Command;
use picket_wire::settings::{Drive, Settings};
use settings::{chirp, tone};

#[test]
fn it_starts_by_the_crystal_and_measures() {
    let (mut board, boot) = Emulated::start(&tone(500e3));
    assert_eq!((boot.clock, boot.core_hz), (Clock::External, 180_000_000));
    assert!(boot.measuring && boot.origin == Origin::Flash && !boot.unfit, "{boot:?}");
    board.run(20_000);
    assert!(!board.telemetry().is_empty());
    // APB1 a quarter, APB2 a half, by the multiplier (RM 6.3.3).
    assert_eq!(board.read(0x4002_3808), 0x940A);
    // CSSON.
    assert_eq!(board.read(0x4002_3800) >> 19 & 1, 1);
    board.assert_rules();
}

/// Settings that were not saved live until the second reset, and each start is told with its cause.
#[test]
fn it_restarts_twice_in_a_row() {
    let (mut board, _) = Emulated::start(&tone(500e3));
    board.request(Command::SetSettings(tone(250e3), N)).unwrap();
    let starts = [(Origin::Host, 250e3), (Origin::Flash, 500e3), (Origin::Flash, 500e3)];
    for (before, (origin, rate_hz)) in starts.into_iter().enumerate() {
        let boot = board.boot();
        assert_eq!(board.resets.len(), before + 1);
        assert_eq!((boot.causes.message(), boot.origin, boot.last.kind), ("software", origin, 0));
        assert!(boot.measuring && boot.clock == Clock::External, "{boot:?}");
        let body = board.request(Command::GetSettings).unwrap();
        let (settings, _) = Settings::from_bytes(&body).unwrap();
        assert!((settings.config.rate_hz - rate_hz).abs() < 1.0, "{settings:?}");
        board.request(Command::Reboot).unwrap();
    }
    board.assert_rules();
}

/// Without blocks nothing but the timer's interrupt wakes the core, and the watchdog must not bite.
#[test]
fn it_stays_up_without_blocks() {
    let stopped = Settings { start: false, ..tone(500e3) };
    let external = chirp(500e3, Shape::Trapezoid, 32, Drive::External);
    let unfit = Settings { guard: 40, ..tone(500e3) };
    for (name, settings) in
        [("stopped", stopped), ("unfit", unfit), ("external", external), ("100 S/s", tone(100.0))]
    {
        let mut board = Emulated::plug();
        // It sleeps nearly all the time.
        board.order("quantum 1000");
        let mut sectors = Sectors::new();
        sectors.save(&settings);
        board.load(&sectors);
        let (mut board, boot) = board.power();
        assert_eq!(boot.unfit, name == "unfit");
        board.run(sized(4, 60) * 1_000_000 + 500_000);
        assert_eq!(board.resets, [], "{name}");
    }
}

/// What fails behind the program's back.
#[derive(Clone, Copy, Debug)]
enum Dead {
    /// The converter's clock stands.
    Timer,
    /// The DMA controller has no clock, and its registers none either.
    Dma,
    /// The serial port sends nothing.
    Transmitter,
}

impl Dead {
    fn happen(self, board: &mut Emulated) {
        match self {
            // TIM3_CR1.
            Dead::Timer => board.write(0x4000_0400, 0),
            Dead::Dma => {
                // DMA2EN 22 of RCC_AHB1ENR.
                let clocks = board.read(0x4002_3830);
                board.write(0x4002_3830, clocks & !(1 << 22));
            }
            Dead::Transmitter => drop(board.order("transmitter 0")),
        }
    }
}

/// Whatever stops the blocks or the line: the bite comes five seconds later, or two blocks' time after the last one, if that is more.
#[test]
fn the_watchdog_bites_when_what_is_due_stays_away() {
    let external = chirp(500e3, Shape::Trapezoid, 32, Drive::External);
    // A block lasts 4.1 s.
    let slow = tone(250.0);
    let mut wrong = Vec::new();
    for (settings, dead, bound) in [
        (tone(500e3), Dead::Timer, 5.0),
        (tone(500e3), Dead::Transmitter, 5.0),
        (external, Dead::Dma, 5.0),
        (slow, Dead::Dma, 2.0 * 1024.0 / 250.0),
    ] {
        let label = format!("{:?} at {} S/s, {dead:?}", settings.drive, settings.config.rate_hz);
        let (mut board, _) = Emulated::start(&settings);
        board.pulses(8_000);
        board.run(30_000);
        let from = board.now;
        dead.happen(&mut board);
        while board.resets.is_empty() && board.now < from + 14_000_000 {
            board.run(10_000);
        }
        let Some((at, cause)) = board.resets.first().cloned() else {
            wrong.push(format!("{label}: no bite"));
            continue;
        };
        let after = (at - from) as f64 / 1e6;
        println!("{label}: a bite after {after:.3} s");
        assert_eq!(cause, "watchdog", "{label}");
        if after < bound - 0.3 || after > bound + 0.02 {
            wrong.push(format!("{label}: after {after} s"));
        }
        board.order("transmitter 1");
        assert_eq!(board.boot().causes.message(), "watchdog", "{label}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A chirp whose samples stay away is a fault, after which the stream starts again with its timer: no bite is needed.
#[test]
fn a_timer_that_stops_between_an_external_sources_chirps_is_started_again() {
    let (mut board, _) = Emulated::start(&chirp(500e3, Shape::Trapezoid, 32, Drive::External));
    board.pulses(8_000);
    board.run(30_000);
    Dead::Timer.happen(&mut board);
    board.run(100_000);
    let before = board.status().counters;
    assert_eq!((before.faults(), before.broken), (1, 1), "{before:?}");
    board.run(400_000);
    let after = board.status().counters;
    assert_eq!(after.faults(), 1, "{after:?}");
    // Three blocks of each chirp.
    assert!((145..=155).contains(&(after.blocks - before.blocks)), "{before:?} {after:?}");
    assert!(board.resets.is_empty());
}

/// Three bites in a row, each within a minute: the board starts stopped, tells so, and an order starts it.
#[test]
fn a_crash_loop_ends_stopped() {
    let (mut board, boot) = Emulated::start(&tone(500e3));
    assert!(boot.measuring && !boot.halted, "{boot:?}");
    let crash = |board: &mut Emulated| {
        let bites = board.resets.len();
        Dead::Timer.happen(board);
        while board.resets.len() == bites {
            board.run(100_000);
            assert!(board.now < 60_000_000, "no bite");
        }
        board.boot()
    };
    for number in 1..=3 {
        let boot = crash(&mut board);
        assert_eq!((boot.causes.message(), boot.origin), ("watchdog", Origin::Flash));
        assert_eq!((boot.measuring, boot.halted), (number < 3, number == 3), "{boot:?}");
    }
    board.request(Command::Start).unwrap();
    let boot = board.boot();
    assert!(boot.measuring && !boot.halted, "{boot:?}");
    let boot = crash(&mut board);
    assert!(boot.measuring && !boot.halted, "{boot:?}");
}

/// A source that sends a chirp now and then, and ends: no bite.
#[test]
fn a_source_may_pause_as_long_as_it_likes() {
    let settings = chirp(500e3, Shape::Trapezoid, 32, Drive::External);
    let (mut board, _) = Emulated::start(&settings);
    board.pulses(1_000_000);
    board.run(3_000_000);
    let blocks = board.status().counters.blocks;
    assert!((6..=9).contains(&blocks), "{blocks}");
    board.write(0x4000_1000, 0);
    // The last chirp is broken, and none comes that would make it good.
    board.order("overrun");
    board.run(sized(6, 60) * 1_000_000);
    assert_eq!(board.resets, []);
}

/// The crystal's clock fails while the board measures: it goes on by its own, and tells.
#[test]
fn it_outlives_its_crystal() {
    let mut board = Emulated::plug();
    let codes: Vec<u8> = streams::table(900.0).into_iter().flat_map(u16::to_le_bytes).collect();
    board.order(&format!("input 0 table {}", board::file(&codes).display()));
    let mut sectors = Sectors::new();
    sectors.save(&tone(500e3));
    board.load(&sectors);
    let (mut board, _) = board.power();
    // The share of the frequency that sigma is.
    let share = |board: &mut Emulated| {
        board.telemetry();
        board.run(20_000);
        let records = board.telemetry();
        let record = records.last().unwrap();
        let (tone, basis) = (record.measurement.tone, record.basis.unwrap());
        assert_eq!(tone.verdict.name(), "good", "{tone:?}");
        (f64::from(tone.sigma) / tone.frequency.cycles(), basis)
    };
    let (exact, basis) = share(&mut board);
    assert!(exact < 1e-4 && basis.clock == Clock::External, "{exact} {basis:?}");
    board.order("hse 0");
    let boot = board.boot();
    assert_eq!((boot.clock, boot.core_hz, boot.measuring), (Clock::Internal, 180_000_000, true));
    assert_eq!((boot.causes.message(), boot.last.kind), ("software", 3));
    // Settings that were not saved are those that were: the end was no order.
    assert!(boot.origin == Origin::Flash && !boot.unfit, "{boot:?}");
    // The internal oscillator's 1 %, evenly spread.
    let (wide, basis) = share(&mut board);
    assert!((wide * 3f64.sqrt() - 0.01).abs() < 1e-5, "{wide}");
    assert_eq!((basis.clock, basis.settings), (Clock::Internal, boot.settings));
    assert_eq!(board.resets.len(), 1);
    board.assert_rules();
}

/// Once the crystal's clock is there again, the board starts anew by it, with the settings that it was given meanwhile.
#[test]
fn it_returns_to_its_crystal() {
    let (mut board, _) = Emulated::start(&tone(500e3));
    board.order("hse 0");
    assert_eq!(board.boot().clock, Clock::Internal);
    let given = Settings { report_every: 7, ..tone(200e3) };
    board.request(Command::SetSettings(given, N)).unwrap();
    let internal = board.boot();
    assert_eq!((internal.clock, internal.origin), (Clock::Internal, Origin::Host));
    board.run(2_500_000);
    assert_eq!(board.resets.len(), 2);
    board.order("hse 8000000");
    let boot = board.boot();
    assert_eq!((boot.clock, boot.core_hz, boot.measuring), (Clock::External, 180_000_000, true));
    assert_eq!((boot.settings, boot.last.kind), (internal.settings, 0));
    board.run(3_000_000);
    assert_eq!(board.resets.len(), 3);
    board.assert_rules();
}

/// A clock of another rate than the board's is not used, nor told as if it were.
#[test]
fn it_does_not_start_by_another_crystal() {
    for (hse_hz, clock) in [
        (4_000_000, Clock::Internal),
        (12_000_000, Clock::Internal),
        (7_400_000, Clock::Internal),
        (8_300_000, Clock::External),
    ] {
        let mut board = Emulated::plug();
        board.order(&format!("hse {hse_hz}"));
        let (mut board, boot) = board.power();
        assert_eq!(
            (boot.clock, boot.core_hz, boot.measuring),
            (clock, 180_000_000, true),
            "{hse_hz}"
        );
        board.assert_rules();
    }
}

/// The watchdog's oscillator is counted by the crystal: what changes is told by a restart. One that never was what its data sheet
/// says tells nothing.
#[test]
fn the_crystal_is_watched() {
    for (lsi_hz, divider, kind) in
        [(32_000, 1, 0), (20_000, 1, 0), (60_000, 4, 0), (32_000, 2, 3), (40_000, 3, 3)]
    {
        let mut board = Emulated::plug();
        let mut sectors = Sectors::new();
        sectors.save(&Settings { start: false, ..tone(500e3) });
        board.load(&sectors);
        board.order(&format!("lsi {lsi_hz}"));
        board.order("oscillator 1");
        let (mut board, boot) = board.power();
        assert_eq!(boot.clock, Clock::External);
        board.run(300_000);
        assert_eq!(board.resets, [], "{lsi_hz}");
        board.order(&format!("oscillator {divider}"));
        board.run(300_000);
        if kind > 0 {
            let boot = board.boot();
            assert_eq!((boot.causes.message(), boot.last.kind), ("software", kind));
            // From its reset on the oscillator is none that the crystal contradicts.
            board.run(1_000_000);
        }
        assert_eq!(board.resets.len() as u32, kind / 3, "{lsi_hz}: {:?}", board.resets);
    }
}
