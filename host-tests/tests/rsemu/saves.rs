//! Settings in flash: saved in every state, with the power lost at any moment.

use crate::board::{Emulated, Sectors};
use crate::settings::{DAC, chirp, tone};
use host_tests::sized;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::config::Scene;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_firmware::nucleo_f446re::N;
use picket_wire::boot::Origin;
use picket_wire::command::{Command, Request};
use picket_wire::settings::{Drive, Settings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The two sectors after a save, whatever the flash does to the core meanwhile.
#[test]
fn settings_are_saved_in_every_state() {
    for (name, settings) in [
        ("stopped", Settings { start: false, ..tone(500e3) }),
        ("measuring", tone(500e3)),
        ("slow", tone(100.0)),
    ] {
        // All of them only in the long form.
        let stalls: &[bool] = match (name, sized(0, 1)) {
            (_, 1) => &[false, true],
            ("stopped", _) => &[false],
            ("measuring", _) => &[true],
            _ => &[],
        };
        for &stall in stalls {
            let mut board = Emulated::plug();
            // The longest erasure (data sheet, table 48), and a short one.
            board.order(&format!("erase {}", sized(150, 2000)));
            board.order(&format!("stall {}", u8::from(stall)));
            let (mut board, _) = board.power();
            board.request(Command::SetSettings(settings, N)).unwrap();
            board.boot();
            let saved = board.request(Command::Save);
            assert_eq!(saved, Ok(vec![]), "{name}, stall {stall}");
            let resets: Vec<_> =
                board.resets.iter().filter(|(_, cause)| cause == "watchdog").collect();
            assert_eq!(resets, Vec::<&(u64, String)>::new(), "{name}, stall {stall}");
            let sectors = board.sectors();
            assert_eq!(
                sectors.settings().map(|s| s.config.rate_hz.round()),
                Some(settings.config.rate_hz),
                "{name}"
            );
        }
    }
}

/// The label of a block's segment, as the DAC's codes in it say.
pub fn played(codes: &[u16]) -> Segment {
    let (first, last) = (codes[0], codes[N - 1]);
    match first.cmp(&last) {
        std::cmp::Ordering::Less => Segment::Up,
        std::cmp::Ordering::Equal => Segment::Flat,
        std::cmp::Ordering::Greater => Segment::Down,
    }
}

#[test]
fn after_a_save_the_segments_are_right_and_the_loss_is_exact() {
    // Remainders of blocks and chirps.
    let erasures: &[u64] =
        if sized(0, 1) == 0 { &[98, 99] } else { &[97, 98, 99, 500, 1000, 2000] };
    for &erase_ms in erasures {
        let settings = chirp(500e3, Shape::Trapezoid, 32, DAC);
        let mut board = Emulated::plug();
        board.order(&format!("erase {erase_ms}"));
        let mut sectors = Sectors::new();
        sectors.save(&Settings { report_every: 2, ..settings });
        board.load(&sectors);
        let (mut board, _) = board.power();
        board.request(Command::SetSettings(settings, N)).unwrap();
        board.boot();
        board.order("input 0 dac");
        board.run(5_000);
        let begun = board.now;
        for _ in 0..3 {
            let (measurement, codes) = board.capture();
            assert_eq!(measurement.stamp.segment, played(&codes), "before, {erase_ms} ms");
        }
        let before = board.status();
        let sequence = board.capture().0.stamp.sequence;
        let at = board.now;
        board.request(Command::Save).unwrap();
        board.run(10_000);
        for _ in 0..4 {
            let (measurement, codes) = board.capture();
            assert_eq!(measurement.stamp.segment, played(&codes), "after, {erase_ms} ms");
        }
        let after = board.status();
        let (last, _) = board.capture();
        // Blocks of 1056 samples pass with the time, whoever looks; a chirp has three.
        let passed = f64::from(last.stamp.sequence - sequence);
        let expected = (board.now - at) as f64 * 1e-6 * 500e3 / 1056.0;
        assert!((passed - expected).abs() < 6.0, "{erase_ms} ms: {passed} {expected}");
        let lost = after.counters.lost() - before.counters.lost();
        let shortest = erase_ms as f64 * 1e-3 * 500e3 / 1056.0;
        assert!((f64::from(lost) - shortest).abs() < 8.0, "{erase_ms} ms: {lost} {shortest}");
        board.assert_rules();
        assert_eq!(after.counters.faults(), 0, "{after:?}");
        assert!(begun < at);
    }
}

/// What another program has saved is what the board starts with, and what it saves itself is used, too.
#[test]
fn settings_of_another_program_are_used() {
    let mut board = Emulated::plug();
    let earlier = chirp(500e3, Shape::Trapezoid, 32, DAC);
    let mut sectors = Sectors::new();
    sectors.save(&earlier);
    board.load(&sectors);
    let (mut board, boot) = board.power();
    assert_eq!((boot.origin, boot.unfit, boot.measuring), (Origin::Flash, false, true));
    let used = |board: &mut Emulated| {
        let body = board.request(Command::GetSettings).unwrap();
        let settings = Settings::from_bytes(&body).unwrap().0;
        let Scene::Chirp(chirp) = settings.config.scene else { panic!("a chirp") };
        (settings.guard, chirp.mixing, (chirp.guard_s * settings.config.rate_hz).round())
    };
    assert_eq!(used(&mut board), (32, Mixing::TxConjRx, 32.0));
    let mut other = earlier;
    if let Scene::Chirp(chirp) = &mut other.config.scene {
        chirp.mixing = Mixing::RxConjTx;
    }
    board.request(Command::SetSettings(other, N)).unwrap();
    board.boot();
    board.request(Command::Save).unwrap();
    let (mut board, boot) = board.power();
    assert_eq!(boot.origin, Origin::Flash);
    assert_eq!(used(&mut board), (32, Mixing::RxConjTx, 32.0));
}

/// Settings that the board cannot read are never others that it invents: it tries those saved before, and else it waits, says why and
/// keeps the page until a host saves.
#[test]
fn settings_that_cannot_be_read_are_told() {
    let board = Emulated::plug();
    let (mut board, boot) = board.power();
    assert_eq!((boot.origin, boot.measuring), (Origin::Default, true), "a new board");
    let rate_hz = |board: &mut Emulated| {
        let body = board.request(Command::GetSettings).unwrap();
        Settings::from_bytes(&body).unwrap().0.config.rate_hz.round()
    };
    // Another program's settings: of blocks of another length, and with further words.
    let mut sectors = Sectors::new();
    sectors.save(&tone(250e3));
    sectors.save_of(512, &tone(100e3));
    board.load(&sectors);
    let (mut board, boot) = board.power();
    assert_eq!((boot.origin, boot.measuring), (Origin::Flash, true), "those before");
    assert_eq!(rate_hz(&mut board), 250e3);
    sectors.save_of(512, &tone(50e3));
    board.load(&sectors);
    let (mut board, boot) = board.power();
    assert_eq!((boot.origin, boot.measuring, boot.unfit), (Origin::Unreadable, false, false));
    let flash = board.sectors();
    assert_eq!(flash.0, sectors.0, "the pages are as they were");
    let given = tone(500e3);
    board.request(Command::SetSettings(given, N)).unwrap();
    assert_eq!(board.boot().origin, Origin::Host);
    board.request(Command::Save).unwrap();
    let (mut board, boot) = board.power();
    assert_eq!((boot.origin, boot.measuring), (Origin::Flash, true));
    assert_eq!(rate_hz(&mut board), 500e3);
}

/// A state in which settings are saved, the old settings and the new ones.
fn states() -> [(&'static str, Settings, Settings); 4] {
    let dac = |rate_hz| Settings { slots: 8, ..chirp(rate_hz, Shape::Trapezoid, 32, DAC) };
    let stopped = |rate_hz| Settings { start: false, ..tone(rate_hz) };
    let external = |rate_hz| chirp(rate_hz, Shape::Trapezoid, 32, Drive::External);
    [
        ("measuring", dac(500e3), dac(250e3)),
        ("stopped", stopped(500e3), stopped(250e3)),
        // A guard without a chirp.
        ("unfit", Settings { guard: 40, ..tone(500e3) }, stopped(250e3)),
        ("without pulses", external(500e3), external(250e3)),
    ]
}

/// The power goes at moments spread over a save: then either the old settings or the new ones, and the board does by them what
/// it would have done.
#[test]
fn power_may_go_during_a_save() {
    let seed: u64 = 17;
    println!("seed {seed}");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let moments = sized(1, 64);
    for (state, old, new) in states() {
        let mut seen = [0, 0];
        for moment in 0..moments {
            // The order takes 0.2 ms on the line, the erasure 20 ms, the words 4.
            let at = 100 + (25_000 * moment + rng.random_range(0..25_000)) / moments;
            let mut board = Emulated::plug();
            board.order("erase 20");
            board.order("input 0 dac");
            let mut sectors = Sectors::new();
            sectors.save(&old);
            board.load(&sectors);
            let (mut board, boot) = board.power();
            assert_eq!(boot.unfit, state == "unfit");
            // What is not saved yet is in use until the next power-on.
            board.request(Command::SetSettings(new, N)).unwrap();
            board.boot();
            board.hear(&Request { tag: 9, command: Command::Save }.to_frame());
            board.run(at);
            let (mut board, boot) = board.power();
            let body = board.request(Command::GetSettings).unwrap();
            let used = Settings::from_bytes(&body).unwrap().0;
            let is_new = (used.config.rate_hz - 250e3).abs() < 1.0;
            seen[usize::from(is_new)] += 1;
            let label = format!("{state}, {at} us, {}", if is_new { "new" } else { "old" });
            let expected = if is_new { new } else { old };
            let unfit = state == "unfit" && !is_new;
            assert_eq!((boot.origin, boot.unfit), (Origin::Flash, unfit), "{label}: {boot:?}");
            assert_eq!(boot.measuring, expected.start && !unfit, "{label}");
            if state == "measuring" {
                follows(&mut board, expected.config.rate_hz, &label);
            } else {
                assert_eq!(board.status().counters.filled(), 0, "{label}");
            }
            assert_eq!(board.resets.len(), 1, "{label}");
            board.assert_rules();
        }
        println!("{state}: {} times the old settings, {} times the new", seen[0], seen[1]);
        assert!(moments < 9 || (seen[0] > 0 && seen[1] > 0), "{state}: {seen:?}");
    }
}

/// The board measures a trapezoid of 1056 samples a segment: each is labelled right, and the counters know every block.
fn follows(board: &mut Emulated, rate_hz: f64, label: &str) {
    // A status waits for what is on the line before it.
    board.run(60_000);
    let first = board.status().counters.filled();
    let from = board.now;
    for _ in 0..3 {
        let (measurement, codes) = board.capture();
        assert_eq!(measurement.stamp.segment, played(&codes), "{label}");
    }
    board.run(60_000);
    let counters = board.status().counters;
    let passed = (board.now - from) as f64 * 1e-6 * rate_hz / 1056.0;
    let filled = f64::from(counters.filled() - first);
    // The answers come up to a millisecond after the looks.
    assert!((filled - passed).abs() < 2.0, "{label}: {filled} {passed}");
    assert_eq!((counters.lost(), counters.faults()), (0, 0), "{label}: {counters:?}");
}
