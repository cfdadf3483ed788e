//! A line that is full, and one that brings noise without a pause: what a host asks is answered, and what is lost is counted.

use crate::board::Emulated;
use crate::settings::tone;
use host_tests::sized;
use picket_firmware::nucleo_f446re::N;
use picket_host::device::Said;
use picket_wire::command::Command;
use picket_wire::settings::Settings;
use picket_wire::status::Status;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The serial line's characters a second.
const LINE: u64 = 92_160;

/// A board whose records take all of the line: of 1,465 blocks a second it carries half.
fn full() -> Emulated {
    let (mut board, boot) = Emulated::start(&tone(1.5e6));
    assert!(boot.measuring, "{boot:?}");
    board.order(&format!("line {LINE}"));
    board.run(200_000);
    let status = board.status();
    assert!(status.dropped > 0, "the line has room for all: {status:?}");
    board
}

/// Asks, and asserts that the answer comes within so many us.
fn answered(board: &mut Emulated, command: Command, within: u64) -> Vec<u8> {
    let asked = board.now;
    let body = board.request(command).unwrap();
    let took = board.now - asked;
    assert!(took <= within, "{command:?} took {took} us");
    body
}

#[test]
fn a_full_line_carries_a_capture_and_every_answer() {
    let mut board = full();
    for _ in 0..sized(2, 20) {
        // All of a block within a second: 11 pieces, between records that wait for them.
        let asked = board.now;
        answered(&mut board, Command::Capture(1), 100_000);
        let mut held = 0;
        while held < 2 * N {
            held += board.expect(|said| match said {
                Said::Raw(raw) => Some(raw.bytes.len()),
                _ => None,
            });
        }
        assert!(board.now - asked < 1_000_000, "{} us", board.now - asked);
    }
    let mut settings = None;
    for _ in 0..8 {
        let body = answered(&mut board, Command::GetSettings, 100_000);
        assert!(settings.replace(body.clone()).is_none_or(|before| before == body));
    }
    // One restart an order, and each is answered.
    for restarts in 1..=3 {
        let every = Settings { report_every: 1 + restarts % 2, ..tone(1.5e6) };
        let body = answered(&mut board, Command::SetSettings(every, N), 100_000);
        assert_eq!(Settings::from_bytes(&body).unwrap().0.report_every, every.report_every);
        assert!(board.boot().measuring);
        board.run(200_000);
        assert_eq!(board.resets.len(), usize::from(restarts));
    }
    board.assert_rules();
}

/// Each kind of noise at the line's rate, stopped and measuring.
#[test]
fn noise_without_a_pause_costs_neither_a_reset_nor_an_answer() {
    let seed = 921;
    println!("seed {seed}");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for (start, noise) in [(false, 0), (true, 0), (true, 1)] {
        let settings = Settings { start, report_every: 20, ..tone(1.2e6) };
        let (mut board, boot) = Emulated::start(&settings);
        assert_eq!(boot.measuring, start);
        board.order(&format!("line {LINE}"));
        let body = answered(&mut board, Command::GetSettings, 100_000);
        let rate_hz = Settings::from_bytes(&body).unwrap().0.config.rate_hz;
        let (before, from) = (board.status(), board.now);
        for tenth in 0..sized(5, 600) {
            for _ in 0..20 {
                // Frames of a byte each, which earn a refusal each; and anything.
                let bytes: Vec<u8> = (0..LINE / 200)
                    .map(|n| if noise == 0 { 1 - (n % 2) as u8 } else { rng.random() })
                    .collect();
                board.hear(&bytes);
                board.run(5_000);
            }
            // Another host's order in the middle of it, behind a zero.
            if tenth % 5 == 0 {
                board.hear(&[0]);
                answered(&mut board, Command::GetSettings, 200_000);
            }
        }
        board.hear(&[0]);
        let (after, passed) = (board.status(), board.now - from);
        let Status { counters, refused, .. } = after;
        println!(
            "{:.1} s: {} blocks, {} lost, {refused} frames refused",
            passed as f64 * 1e-6,
            counters.blocks,
            counters.lost()
        );
        assert!(board.resets.is_empty(), "{:?}", board.resets);
        assert!(refused > before.refused, "nothing was refused");
        // Every block is delivered or counted as lost.
        let filled = f64::from(counters.filled() - before.counters.filled());
        let due = if start { passed as f64 * 1e-6 * rate_hz / N as f64 } else { 0.0 };
        assert!((filled - due).abs() <= 3.0, "{filled} of {due}");
        assert_eq!(counters.faults(), 0, "{after:?}");
        // At the usual image's fastest rates the loop has little time beside blocks and interrupts.
        let lost = f64::from(counters.lost() - before.counters.lost());
        assert!(lost <= 0.2 * due, "{lost} of {due}");
        board.assert_rules();
    }
}
