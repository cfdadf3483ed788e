//! The progress of the list: each of its items begins with a reset.

use crate::instrument::retained::Retained;

/// The state that one item leaves to the next.
#[derive(Clone, Copy, Default)]
pub struct State {
    /// The item under way, or the next one.
    pub item: u32,
    /// Whether the item has begun.
    pub begun: bool,
    /// Whether each rate is watched for a moment only.
    pub quick: bool,
    /// Items that held, and items that did not.
    pub outcomes: [u32; 2],
    /// The largest stack, bytes.
    pub stack: u32,
    /// The watchdog's oscillator, Hz.
    pub watchdog_hz: u32,
    /// The time without a feed of the watchdog, ms.
    pub starved_ms: u32,
}

const MAGIC: u32 = 0x5E1F_7E57;
const LENGTH: usize = 9;

#[unsafe(link_section = ".uninit.self_test")]
static KEPT: Retained<LENGTH> = Retained::new();

impl State {
    /// Leaves nothing: the next start is the instrument's.
    pub fn forget() {
        KEPT.keep(&[0; LENGTH]);
    }

    /// The state that the last item left; `None` after power-on.
    pub fn load() -> Option<Self> {
        let words = KEPT.words();
        let [magic, item, flags, held, failed, stack, watchdog_hz, starved_ms, sum] = words;
        let state = State {
            item,
            begun: flags & 1 != 0,
            quick: flags & 2 != 0,
            outcomes: [held, failed],
            stack,
            watchdog_hz,
            starved_ms,
        };
        (magic == MAGIC && sum == state.sum()).then_some(state)
    }

    /// Leaves this state to the next item.
    pub fn save(&self) {
        let [magic, rest @ ..] = self.words();
        let [item, flags, held, failed, stack, watchdog_hz, starved_ms] = rest;
        let sum = self.sum();
        KEPT.keep(&[magic, item, flags, held, failed, stack, watchdog_hz, starved_ms, sum]);
    }

    fn words(&self) -> [u32; LENGTH - 1] {
        let flags = u32::from(self.begun) | u32::from(self.quick) << 1;
        let [held, failed] = self.outcomes;
        let State { item, stack, watchdog_hz, starved_ms, .. } = *self;
        [MAGIC, item, flags, held, failed, stack, watchdog_hz, starved_ms]
    }

    fn sum(&self) -> u32 {
        self.words().iter().fold(0, |sum, word| sum.rotate_left(5).wrapping_add(*word) ^ MAGIC)
    }
}
