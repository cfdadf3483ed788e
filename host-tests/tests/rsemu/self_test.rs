//! The image that goes through the board's list by itself: what is wrong on the bench shows in it. The whole list, as a person
//! gets it, is in `host/tests/line.rs`.

use crate::board::{Emulated, self_test};
use host_tests::sized;

/// A board that goes through its list from power-on, until a line has `word`: that line.
fn line(orders: &[&str], word: &str) -> String {
    let mut board = Emulated::plug_with(self_test());
    orders.iter().for_each(|order| drop(board.order(order)));
    board.order("power");
    while board.now < 2_000_000 {
        board.run(20_000);
        let text = String::from_utf8_lossy(&board.sent).into_owned();
        if board.now == 100_000 {
            board.hear(b"q");
        }
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        if let Some(line) = whole.lines().find(|line| line.contains(word)) {
            return line.trim().into();
        }
    }
    panic!("{word}: {}", String::from_utf8_lossy(&board.sent));
}

#[test]
fn a_broken_wire_is_seen() {
    let line = line(&["input 0 none", "oscillator 1"], "500 kS/s");
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
        let line = line(&[order, "oscillator 1"], "clock of");
        assert!(line.starts_with("- [ ] WRONG: ") && line.contains(told), "{order}: {line}");
    }
}
