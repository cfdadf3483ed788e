//! The bounds of the loop: on answers to noise, on saves, on waits for blocks and bytes that are due, and on counters that a host has set
//! to 0.

use picket_dsp::acquire::frontend::Counters;
use picket_wire::telemetry::Health;

/// Bytes of the host that are read in a turn of the loop. A line of 921,600 baud brings no more while a block is measured, except where
/// several tones are sought.
pub const HEARD: usize = 256;

/// Damaged frames that are answered in a second; the others are only counted.
const A_SECOND: u32 = 16;

/// The number of damaged frames answered within the last second. Noise of two bytes a frame would get more answers than the line carries,
/// and leave the loop no time for anything else.
#[derive(Clone, Copy, Debug)]
pub struct Refusals {
    since: u32,
    told: u32,
}

impl Refusals {
    /// No answers before these ticks.
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

/// Saves in one go, by this program and the programs that it restarts.
const SAVES: u32 = 16;
/// Seconds until one more save is permitted. A page of flash endures 10,000 erasures: with a host that saves as often as permitted two
/// pages in turn then last 139 days, and longer than any instrument with a host that saves only at its setup.
const SECONDS_A_SAVE: u32 = 600;

/// The recent saves. Each wears a page of flash.
#[derive(Clone, Copy, Debug, Default)]
pub struct Saves {
    used: u32,
    seconds: u32,
}

impl Saves {
    /// Recent saves, of which `used` were made before this start.
    pub const fn new(used: u32) -> Self {
        Self { used, seconds: 0 }
    }

    /// The number of recent saves.
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

/// Seconds from a watchdog's last feed to its bite, on every board.
const WATCHDOG_S: u64 = 4;

/// The longest absence of blocks while the gate is open, or of bytes on their way out of a queue. The watchdog is fed only within it, so
/// the watchdog bites 5 s or two blocks after the last one, whichever is more.
#[derive(Clone, Copy, Debug)]
pub struct Deadline {
    /// The longest absence, ticks.
    limit: u64,
    /// The ticks at the last look, and whether something was due then.
    seen: u32,
    due: bool,
    /// The ticks that a block or byte has been due.
    waited: u64,
    /// The number of times that the gate has closed and nothing came.
    vain: u8,
}

impl Deadline {
    /// The deadline for blocks of `block` ticks, of `hz`, from these ticks on.
    pub const fn new(block: u64, ticks: u32, hz: u32) -> Self {
        let hz = hz as u64;
        let longest = block.saturating_mul(2).saturating_sub(hz.saturating_mul(WATCHDOG_S));
        let limit = if longest > hz { longest } else { hz };
        Self { limit, seen: ticks, due: false, waited: 0, vain: 0 }
    }

    /// Whether the deadline holds at these ticks; `due` says whether something was due since the last look, `came` whether it came.
    pub fn holds(&mut self, ticks: u32, due: bool, came: bool) -> bool {
        let passed = ticks.wrapping_sub(self.seen);
        self.vain = self.vain.saturating_add(u8::from(self.due && !due));
        (self.seen, self.due) = (ticks, due);
        if came {
            (self.waited, self.vain) = (0, 0);
        } else if due || self.vain > 1 {
            // A fault may cost one chirp. After the second in vain the time counts, so that rare pulses are enough.
            self.waited = self.waited.saturating_add(passed.into());
        }
        self.waited <= self.limit
    }
}

/// The losses up to a block since a host has set the counters to 0, when they stood at `zero`. A block that was filled before and waited
/// has none.
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
        // A frame that comes once in a while is always answered.
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

    /// The last feed in seconds after the start, where nothing comes and `due` says whether something should. A look is a tenth of a
    /// second.
    fn last_feed(block_s: f64, hz: u32, due: impl Fn(u32) -> bool) -> Option<f64> {
        let (start, look) = (u32::MAX - hz, hz / 10);
        let mut deadline = Deadline::new((block_s * f64::from(hz)) as u64, start, hz);
        let ends =
            |n: &u32| !deadline.holds(start.wrapping_add(n.wrapping_mul(look)), due(*n), false);
        (1..100_000).find(ends).map(|n| f64::from(n - 1) / 10.0)
    }

    /// A watchdog that takes 4 s, at rates of 1024 S/s to 0.5 S/s and both boards' ticks.
    #[test]
    fn the_bite_comes_five_seconds_or_two_blocks_after_the_last_block() {
        for hz in [1_000_000, 72_000_000, 90_000_000] {
            for block_s in [0.0, 0.002, 1.0, 2.4, 2.6, 3.0, 10.24, 1024.0, 2048.0] {
                let fed = last_feed(block_s, hz, |_| true).expect("it is fed for ever");
                let (bite, bound) = (fed + 4.0, f64::max(5.0, 2.0 * block_s));
                assert!(bite <= bound + 1e-6 && bite > bound - 0.2, "{hz} {block_s}: {bite}");
                // The fastest oscillator of a watchdog bites after 2.7 s, and the next block is in time.
                assert!(fed + 2.7 > block_s, "{hz} {block_s}: {fed}");
            }
        }
    }

    /// A gate that opens once in ten seconds, for less than a look.
    #[test]
    fn rare_chirps_in_vain_are_told_from_a_source_that_pauses() {
        let hz = 90_000_000;
        assert_eq!(last_feed(0.002, hz, |_| false), None);
        assert_eq!(last_feed(0.002, hz, |n| n == 100), None, "one chirp broken by a fault");
        let fed = last_feed(0.002, hz, |n| n.is_multiple_of(100)).expect("it is fed for ever");
        assert!((20.0..21.1).contains(&fed), "{fed}");
        // Each chirp brings a block a look later.
        let mut deadline = Deadline::new(180_000, 0, hz);
        let alive =
            |n: u32| deadline.holds(n.wrapping_mul(hz / 10), n.is_multiple_of(100), n % 100 == 1);
        assert!((1..10_000).all(alive));
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
