//! What the loop bounds: answers to noise, saves, and counters that a host has set to 0.

use picket::acquire::frontend::Counters;
use picket_wire::telemetry::Health;

/// Bytes of the host that are heard in a turn of the loop. A line of 921,600 baud brings no more while a block is
/// measured, but where several tones are sought.
pub const HEARD: usize = 256;

/// Damaged frames that are answered in a second; the others are only counted.
const A_SECOND: u32 = 16;

/// How many damaged frames were answered within the last second. Noise of two bytes a frame would have
/// more answers than the line takes, and the loop time for nothing else.
#[derive(Clone, Copy, Debug)]
pub struct Refusals {
    since: u32,
    told: u32,
}

impl Refusals {
    /// None before these ticks.
    pub const fn new(ticks: u32) -> Self {
        Self { since: ticks, told: 0 }
    }

    /// Whether a damaged frame at these ticks, of `hz`, is answered.
    pub fn answers(&mut self, ticks: u32, hz: u32) -> bool {
        if ticks.wrapping_sub(self.since) >= hz {
            *self = Self::new(ticks);
        }
        let answers = self.told < A_SECOND;
        self.told = self.told.saturating_add(1);
        answers
    }
}

/// Saves at once, by this program and those that it restarts.
const SAVES: u32 = 16;
/// Seconds until one more is permitted. A page of flash stands 10,000 erasures: two pages by turns then last 139 days of a host that
/// saves as often as it may, and longer than anybody's instrument of one that saves as it is set up.
const SECONDS_A_SAVE: u32 = 600;

/// The saves that were made of late. Each wears a page of flash.
#[derive(Clone, Copy, Debug, Default)]
pub struct Saves {
    used: u32,
    seconds: u32,
}

impl Saves {
    /// So many were made before this start.
    pub const fn new(used: u32) -> Self {
        Self { used, seconds: 0 }
    }

    /// How many were made of late.
    pub const fn used(&self) -> u32 {
        self.used
    }

    /// A second has passed.
    pub fn second(&mut self) {
        self.seconds = self.seconds.saturating_add(1);
        if self.seconds >= SECONDS_A_SAVE {
            *self = Self::new(self.used.saturating_sub(1));
        }
    }

    /// Counts one more, if it is permitted.
    pub fn permit(&mut self) -> bool {
        let permitted = self.used < SAVES;
        self.used = self.used.saturating_add(permitted.into());
        permitted
    }
}

/// What was lost up to a block since a host has set the counters to 0, when they stood at `zero`. By a block that was
/// filled before, and waited, nothing.
pub fn health(counters: &Counters, zero: &Counters) -> Health {
    let newer = counters.filled().wrapping_sub(zero.filled());
    if *zero != Counters::default() && newer.wrapping_sub(1) > u32::MAX / 2 {
        return Health::default();
    }
    let since = counters.since(zero);
    Health { lost: since.lost(), faults: since.faults() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two seconds of noise at the line's rate, whose ticks wrap.
    #[test]
    fn noise_is_answered_a_bounded_number_of_times_a_second() {
        let (hz, start) = (90_000_000_u32, u32::MAX - 50_000_000);
        let mut refusals = Refusals::new(start);
        let frames = 2 * 46_080;
        let at = |frame: u32| start.wrapping_add(frame * (hz / 46_080));
        let answered = (0..frames).filter(|&frame| refusals.answers(at(frame), hz)).count();
        assert!((17..=48).contains(&answered), "{answered}");
        // What comes once in a while is always answered.
        let once = |n: u32| start.wrapping_add(n.wrapping_mul(hz));
        assert!((3..100).all(|n| refusals.answers(once(n), hz)));
    }

    /// A host that saves as often as it may, and restarts the board each time, for a day.
    #[test]
    fn saves_are_few_whoever_asks() {
        let (mut saves, mut made) = (Saves::default(), 0);
        for second in 0..86_400 {
            made += u32::from(saves.permit());
            saves.second();
            if second % 3 == 0 {
                saves = Saves::new(saves.used());
            }
        }
        assert_eq!(made, 16);
        for _ in 0..86_400 {
            made += u32::from(saves.permit());
            saves.second();
        }
        assert_eq!(made, 16 + 86_400 / 600);
    }

    /// A block that waited while the counters were set to 0 once had lost 4,294,967,295.
    #[test]
    fn a_block_from_before_has_lost_nothing() {
        let block = Counters { blocks: 10, missed: 4, spurious: 1, ..Counters::default() };
        assert_eq!(health(&block, &Counters::default()), Health { lost: 4, faults: 1 });
        let zero = Counters { missed: 5, overruns: 2, spurious: 3, ..block };
        assert_eq!(health(&block, &zero), Health::default());
        assert_eq!(health(&zero, &zero), Health::default());
        let later = Counters { blocks: 11, missed: 8, ..zero };
        assert_eq!(health(&later, &zero), Health { lost: 3, faults: 0 });
        // The counts may wrap between the two.
        let zero = Counters { blocks: u32::MAX - 1, ..zero };
        let later = Counters { blocks: 3, missed: 6, ..zero };
        assert_eq!(health(&later, &zero), Health { lost: 1, faults: 0 });
        let before = Counters { blocks: u32::MAX - 3, ..zero };
        assert_eq!(health(&before, &zero), Health::default());
    }
}
