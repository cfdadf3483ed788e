//! A breaker of crash loops: abnormal ends in a row, each soon after its start, are counted over resets, and the board then starts stopped.

use picket_wire::boot::{Causes, LastEnd};

/// Abnormal ends in a row after which the board starts stopped.
pub const MOST: u32 = 3;
/// An end later than this is not part of a row.
pub const SECONDS: u32 = 60;

const MAGIC: u32 = 0x4352_5300;
/// Stands in place of the count once the program has run for long enough.
const SETTLED: u32 = 0xFF;

/// Abnormal ends in a row; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crashes(u32);

impl Crashes {
    /// The count at a start, from the word in kept memory and the end of the last program. A start by an order, by the button or by power
    /// begins again.
    pub const fn at_start(word: u32, causes: Causes, last: &LastEnd) -> Self {
        // A fault, an unexpected interrupt, a panic; or the watchdog.
        let crashed = matches!(last.kind, 1 | 2 | 4 | 5) || causes.0 & 8 != 0;
        let count = match word ^ MAGIC {
            _ if !crashed => 0,
            SETTLED => 0,
            before if before < MOST => before + 1,
            MOST => MOST,
            // Memory held another value.
            _ => 1,
        };
        Crashes(count)
    }

    /// Whether the board starts stopped.
    pub const fn halts(self) -> bool {
        self.0 >= MOST
    }

    /// The word for the next start.
    pub const fn word(self) -> u32 {
        MAGIC ^ self.0
    }

    /// The word after `seconds`, if it changes from there on. A board that was halted stays so until an order starts it.
    pub fn settles(self, seconds: u32) -> Option<u32> {
        (seconds == SECONDS && !self.halts()).then_some(MAGIC ^ SETTLED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const WATCHDOG: (Causes, u32) = (Causes(8), 0);
    const FAULT: (Causes, u32) = (Causes(4), 1);
    const INTERRUPT: (Causes, u32) = (Causes(4), 2);
    const PANIC: (Causes, u32) = (Causes(4), 4);

    /// A start after this end, and a run of `seconds`: returns whether it was halted, and the word then.
    fn lived(word: u32, (causes, kind): (Causes, u32), seconds: u32) -> (bool, u32) {
        let crashes = Crashes::at_start(word, causes, &LastEnd { kind, ..LastEnd::default() });
        let settled = (1..=seconds).filter_map(|second| crashes.settles(second)).next_back();
        (crashes.halts(), settled.unwrap_or(crashes.word()))
    }

    /// The starts that are halted, after power-on with this word in memory.
    fn halted(mut word: u32, lives: &[((Causes, u32), u32)]) -> Vec<bool> {
        let mut told = Vec::new();
        for &(end, seconds) in lives {
            let (halts, kept) = lived(word, end, seconds);
            told.push(halts);
            word = kept;
        }
        told
    }

    #[test]
    fn three_crashes_in_a_row_stop_the_board() {
        const POWER: (Causes, u32) = (Causes(1), 0);
        for garbage in [0, u32::MAX, 0x1234_5678, MAGIC ^ 77] {
            let row =
                [(POWER, 5), (WATCHDOG, 5), (FAULT, 59), (INTERRUPT, 5), (PANIC, 500), (FAULT, 5)];
            assert_eq!(halted(garbage, &row), [false, false, false, true, true, true]);
            // Without a known start, too.
            assert_eq!(halted(garbage, &row[1..4]), [false, false, true]);
        }
    }

    #[test]
    fn a_minute_an_order_the_button_and_power_begin_anew() {
        // An order, the button, power; and the failure of the external clock, after which the board goes on.
        for (causes, kind) in [(4, 0), (2, 0), (1, 0), (4, 3)] {
            let other = (Causes(causes), kind);
            let row = [(FAULT, 5), (FAULT, 5), (other, 5), (FAULT, 5), (FAULT, 5), (FAULT, 5)];
            assert_eq!(halted(0, &row), [false, false, false, false, false, true], "{other:?}");
            let after = [(FAULT, 5), (FAULT, 5), (FAULT, 5), (other, 5), (FAULT, 5)];
            assert_eq!(halted(0, &after), [false, false, true, false, false], "{other:?}");
        }
        let late = [(FAULT, 5), (FAULT, 60), (FAULT, 5), (FAULT, 5), (FAULT, 5), (FAULT, 5)];
        assert_eq!(halted(0, &late), [false, false, false, false, false, true]);
    }
}
