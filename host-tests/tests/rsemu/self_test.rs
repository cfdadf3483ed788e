//! The board tries itself: what is wrong on the bench shows in its list. The whole list, as a person gets it, is in `host/tests/line.rs`.

use crate::board::Emulated;
use crate::settings::tone;
use host_tests::sized;
use picket_wire::boot::Origin;
use picket_wire::command::{Command, Request};
use picket_wire::settings::Settings;

/// A board on a bench, after these orders and with power.
fn on_bench(orders: &[&str]) -> Emulated {
    let mut board = Emulated::plug();
    orders.iter().for_each(|order| drop(board.order(order)));
    board.power().0
}

/// Tells a board to try itself, until a line has `word`: that line.
pub fn line(board: &mut Emulated, word: &str) -> String {
    begin(board);
    let end = board.now + 3_000_000;
    while board.now < end {
        board.run(20_000);
        let text = String::from_utf8_lossy(&board.sent).into_owned();
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        if let Some(line) =
            whole.lines().find(|line| line.contains(word) && line.starts_with("- ["))
        {
            return line.trim().into();
        }
    }
    panic!("{word}: {}", String::from_utf8_lossy(&board.sent));
}

/// Gives the order, and shortens the list.
fn begin(board: &mut Emulated) {
    board.sent.clear();
    board.hear(&Request { tag: 9, command: Command::SelfTest }.to_frame());
    while !String::from_utf8_lossy(&board.sent).contains("picket self-test") {
        board.run(5_000);
        // It listens for a moment before the first line.
        board.hear(b"q");
        assert!(board.now < 3_000_000, "it does not begin");
    }
}

#[test]
fn a_broken_wire_is_seen() {
    let line = line(&mut on_bench(&["input 0 none", "oscillator 1"]), "500 kS/s");
    assert!(line.starts_with("- [ ] WRONG: 500 kS/s: 8 blocks, 0 lost, 0 faults"), "{line}");
    assert!(line.ends_with("good in 0"), "{line}");
}

/// A clock of half the rate, which is not used, and one that does not come; in the long form a watchdog's oscillator that is too slow,
/// too.
#[test]
fn a_wrong_clock_is_seen() {
    let wrong = [
        ("hse 4000000", "the internal oscillator: the probe's 8 MHz are 4.000000 by it"),
        ("hse 0", "180 MHz from the internal oscillator"),
        ("lsi 10000", "the watchdog's 32 kHz 10.00"),
    ];
    for (order, told) in &wrong[..sized(2, 3) as usize] {
        let line = line(&mut on_bench(&[order, "oscillator 1"]), "clock of");
        assert!(line.starts_with("- [ ] WRONG: ") && line.contains(told), "{order}: {line}");
    }
}

/// Without power in the middle of the list, the board is an instrument again, with its settings.
#[test]
fn power_ends_the_list() {
    let saved = Settings { report_every: 7, ..tone(500e3) };
    let (mut board, _) = Emulated::start(&saved);
    begin(&mut board);
    board.run(50_000);
    let (_, boot) = board.power();
    assert_eq!((boot.origin, boot.measuring), (Origin::Flash, true));
}
