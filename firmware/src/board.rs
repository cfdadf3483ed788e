//! What the instrument asks of a board. `docs/porting.md` shows one that has nothing but a timer and a serial port.

use crate::instrument::plan::Plan;
use crate::instrument::storage::Storage;
use crate::slot::Slot;
use picket::acquire::frontend::{Blocks, Counters};
use picket_wire::boot::{Causes, Clock};
use picket_wire::settings::Settings;
use picket_wire::settings_error::SettingsError;

/// A board whose blocks have `N` samples, in slots of `WORDS` words: `N`, and a guard's where it has chirps.
///
/// Settings take effect by a restart, so that there is one way only into operation. Every method returns within bounded time.
pub trait Board<const N: usize, const WORDS: usize>: Sized {
    /// The name that the boot record bears: up to 16 letters of ASCII.
    const NAME: &'static str;
    /// What settings become: the board's own words for its registers.
    type Words;
    /// Where settings outlive a restart.
    type Storage: Storage;

    /// Why the chip was reset. Asked once, before [`Board::start`].
    fn causes() -> Causes {
        Causes::default()
    }

    /// The place where settings are kept.
    fn storage() -> Self::Storage;

    /// Sets up clocks, pins, a timer that counts for ever, the watchdog and the line to the host. Once only: `None` when asked
    /// again.
    fn start(settings: &Settings) -> Option<Self>;

    /// What settings become, with the clock as it would be after a restart with them.
    ///
    /// # Errors
    /// They cannot work on this board.
    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, Self::Words), SettingsError>;

    /// Starts the converter; once only. Gives the main loop's end of the blocks.
    fn sample(
        &mut self,
        plan: &Plan<N>,
        words: &Self::Words,
    ) -> Option<Blocks<'static, Slot<WORDS>>>;

    /// What became of the blocks so far.
    fn counters(&self) -> Counters;

    /// Where the clock comes from.
    fn clock(&self) -> Clock;

    /// The core's clock, Hz.
    fn core_hz(&self) -> u32;

    /// Ticks of [`Board::ticks_hz`] since the start, modulo 2^32.
    fn ticks(&self) -> u32;

    /// What [`Board::ticks`] counts, Hz.
    fn ticks_hz(&self) -> u32;

    /// True where the line takes so many bytes.
    fn has_room(&self, bytes: usize) -> bool;

    /// Sends a frame whole, or not at all: false then. Does not wait.
    fn send(&mut self, frame: &[u8]) -> bool;

    /// The next byte from the host.
    fn receive(&mut self) -> Option<u8>;

    /// Waits for the line to take everything, but not for ever: before a restart.
    fn flush(&mut self);

    /// Sleeps until an interrupt, unless a block or a byte is waiting.
    fn sleep(&mut self, blocks: Option<&Blocks<'static, Slot<WORDS>>>);

    /// Feeds the watchdog.
    fn feed(&mut self) {}

    /// The checksum of the program in flash; 0 where it is not known.
    fn program() -> u32 {
        0
    }
}
