//! The data that survive a reset: the end of the last program, and the settings for the next one.

use super::checksum;
use super::crashes::Crashes;
use super::retained::Retained;
use cortex_m::peripheral::SCB;
pub use picket_instrument::words::{WORDS, words};
use picket_wire::boot::{Causes, LastEnd};

/// The data that one program hands to the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Handover {
    /// The end of the last program.
    pub last: LastEnd,
    /// Settings that the last program received through the serial port, for the next one to use.
    pub settings: Option<[u32; WORDS]>,
    /// Recent saves, see [`Saves`](super::bounds::Saves).
    pub saves: u32,
}

const MAGIC: u32 = 0x5049_434B;
/// Magic, last end, saves, a flag for settings, settings, CRC.
const LENGTH: usize = 1 + 4 + 1 + 1 + WORDS + 1;

#[unsafe(link_section = ".uninit.retained")]
static RETAINED: Retained<LENGTH> = Retained::new();

/// The word of [`Crashes`].
#[unsafe(link_section = ".uninit.crashes")]
static CRASHES: Retained<1> = Retained::new();

/// Counts the end of the last program, for this start.
pub fn count(causes: Causes, last: &LastEnd) -> Crashes {
    let [word] = CRASHES.words();
    let crashes = Crashes::at_start(word, causes, last);
    CRASHES.keep(&[crashes.word()]);
    crashes
}

/// Updates the count once the program has run for `seconds`.
pub fn lives(crashes: Crashes, seconds: u32) {
    if let Some(word) = crashes.settles(seconds) {
        CRASHES.keep(&[word]);
    }
}

impl Handover {
    /// Takes the data that the last program left; nothing after power-on.
    pub fn take() -> Self {
        let words = RETAINED.words();
        RETAINED.keep(&[0; LENGTH]);
        let Some((&crc, body)) = words.split_last() else { return Self::default() };
        let Some((&[MAGIC, kind, pc, a, b, saves, some], settings)) = body.split_first_chunk()
        else {
            return Self::default();
        };
        if crc != checksum::of_words(body.iter().copied()) {
            return Self::default();
        }
        let settings = settings.first_chunk().filter(|_| some != 0).copied();
        Handover { last: LastEnd { kind, pc, more: [a, b] }, settings, saves }
    }

    /// Leaves the data to the next program, and starts it by a reset.
    pub fn leave(self) -> ! {
        let LastEnd { kind, pc, more: [a, b] } = self.last;
        let head = [MAGIC, kind, pc, a, b, self.saves, u32::from(self.settings.is_some())];
        let body = head.into_iter().chain(self.settings.unwrap_or([0; WORDS]));
        let mut words = [0; LENGTH];
        words.iter_mut().zip(body).for_each(|(place, word)| *place = word);
        if let Some((last, body)) = words.split_last_mut() {
            *last = checksum::of_words(body.iter().copied());
        }
        RETAINED.keep(&words);
        SCB::sys_reset()
    }
}
