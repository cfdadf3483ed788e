//! The progress of the list: each of its items begins with a reset.

use crate::instrument::retained::Retained;

/// The state that one item leaves to the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// The item under way, or the next one.
    pub item: u32,
    /// Whether the item has begun.
    pub begun: bool,
    /// Whether each rate is watched for a moment only.
    pub quick: bool,
    /// Whether lines wait for a host that opens its port anew.
    pub reopened: bool,
    /// Whether the item shall be tried again.
    pub again: bool,
    /// Tries of the item so far.
    pub tries: u32,
    /// Items that held, and items that did not.
    pub outcomes: [u32; 2],
    /// The largest stack, bytes.
    pub stack: u32,
    /// The time after which the watchdog should bite, ms, by what the first item found of its oscillator.
    pub bites_ms: u32,
    /// The time without a feed of the watchdog, ms.
    pub starved_ms: u32,
}

const MAGIC: u32 = 0x5E1F_7E57;
const LENGTH: usize = 10;

#[unsafe(link_section = ".uninit.self_test")]
static KEPT: Retained<LENGTH> = Retained::new();

impl State {
    /// Leaves nothing: the next start is the instrument's.
    pub fn forget() {
        KEPT.keep(&[0; LENGTH]);
    }

    /// The state that the last item left; `None` after power-on.
    pub fn load() -> Option<Self> {
        let [sum, MAGIC, item, flags, tries, held, failed, stack, bites_ms, starved_ms] =
            KEPT.words()
        else {
            return None;
        };
        let [begun, quick, reopened, again] = [0, 1, 2, 3].map(|place| flags >> place & 1 != 0);
        let outcomes = [held, failed];
        let state = State {
            item,
            begun,
            quick,
            reopened,
            again,
            tries,
            outcomes,
            stack,
            bites_ms,
            starved_ms,
        };
        (state.words().first() == Some(&sum)).then_some(state)
    }

    /// Leaves this state to the next item.
    pub fn save(&self) {
        KEPT.keep(&self.words());
    }

    /// A sum, and the words behind it.
    fn words(&self) -> [u32; LENGTH] {
        let flags = [self.begun, self.quick, self.reopened, self.again];
        let flags = flags.iter().rev().fold(0, |word, flag| word << 1 | u32::from(*flag));
        let [held, failed] = self.outcomes;
        let State { item, tries, stack, bites_ms, starved_ms, .. } = *self;
        let mut words = [0, MAGIC, item, flags, tries, held, failed, stack, bites_ms, starved_ms];
        let [sum, body @ ..] = &mut words;
        *sum = body.iter().fold(0, |sum, word| sum.rotate_left(5).wrapping_add(*word) ^ MAGIC);
        words
    }
}
