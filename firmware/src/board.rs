//! The requirements of the instrument on a board. `docs/own-board.md` describes a board with only a timer and a serial port.

use crate::instrument::plan::Plan;
use crate::instrument::storage::Storage;
use crate::slot::Slot;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Blocks, Counters};
use picket_dsp::pipeline::Measurement;
use picket_wire::boot::{Causes, Clock};
use picket_wire::settings::Settings;
use picket_wire::settings_error::SettingsError;

/// A board whose blocks have `N` samples, in slots of `WORDS` words: `N` words, and a guard's words if the board has chirps.
///
/// Settings take effect by a restart, so there is only one way into operation. Every method returns
/// within bounded time.
pub trait Board<const N: usize, const WORDS: usize>: Sized {
    /// The name in the boot record: up to 16 letters of ASCII.
    const NAME: &'static str;
    /// The converter's codes, as found in a slot after [`Board::correct`].
    const CODES: Codes;
    /// The register words for checked settings.
    type Words;
    /// Flash, or whatever keeps settings over a restart; its default value is the access to it.
    type Storage: Storage + Default;

    /// The causes of the chip's reset. The instrument reads them once, before [`Board::start`].
    fn causes() -> Causes {
        Causes::default()
    }

    /// Sets up clocks, pins, a timer that never stops, the watchdog and the line to the host.
    /// `None` at the second call.
    fn start(settings: &Settings) -> Option<Self>;

    /// The plan and the register words for these settings, with the clock that a restart with them would give. The plan's codes are
    /// [`Board::CODES`].
    ///
    /// # Errors
    /// The settings cannot work on this board.
    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, Self::Words), SettingsError>;

    /// Starts the converter, once. Returns the main loop's end of the blocks; `None` at the second call.
    fn sample(
        &mut self,
        plan: &Plan<N>,
        words: &Self::Words,
    ) -> Option<Blocks<'static, Slot<WORDS>>>;

    /// Corrects the samples of a block in place, before it is measured, where the converter needs it.
    fn correct(&self, _: &mut Slot<WORDS>) {}

    /// Widens a measurement's sigma by the part of converter and clock in its error.
    fn widen(&self, _: &mut Measurement) {}

    /// The front end's counters so far.
    fn counters(&self) -> Counters;

    /// The source of the clock.
    fn clock(&self) -> Clock;

    /// Whether a better clock than [`Board::clock`] is there again, so that a restart would use it. The loop asks in every turn.
    fn clock_returned(&mut self) -> bool {
        false
    }

    /// The core's clock, Hz.
    fn core_hz(&self) -> u32;

    /// Ticks of [`Board::ticks_hz`] since the start, modulo 2^32.
    fn ticks(&self) -> u32;

    /// The rate of [`Board::ticks`], Hz.
    fn ticks_hz(&self) -> u32;

    /// Whether the line has room for this many bytes.
    fn has_room(&self, bytes: usize) -> bool;

    /// Sends a frame whole and returns true, or drops it and returns false. It never waits.
    fn send(&mut self, frame: &[u8]) -> bool;

    /// The next byte from the host; `None` if none waits.
    fn receive(&mut self) -> Option<u8>;

    /// Waits, within bounded time, until the line has sent everything. The instrument calls it
    /// before a restart.
    fn flush(&mut self);

    /// Stops the samples until [`Board::resume`], where writing to [`Board::Storage`] would hold the
    /// core for longer than the blocks can wait.
    fn pause(&mut self) {}

    /// Starts the samples after [`Board::pause`], at the start of a chirp. Samples that passed meanwhile are counted as lost.
    fn resume(&mut self) {}

    /// Whether the converter's gate was open at any time since the last call, so that blocks are due. Without a gate blocks always are due.
    fn gate_opened(&mut self) -> bool {
        true
    }

    /// Whether bytes wait on the line and none has left since the last call. A board that cannot know returns false.
    fn stalled(&mut self) -> bool {
        false
    }

    /// Sleeps until an interrupt, at most some tenths of a second: the loop feeds the watchdog. Returns at once if a block or a byte is
    /// waiting.
    fn sleep(&mut self, blocks: Option<&Blocks<'static, Slot<WORDS>>>);

    /// Feeds the watchdog, which bites four seconds after the last feed.
    fn feed(&mut self) {}

    /// Has the board try itself after the next restart, and returns true; false on a board that cannot.
    fn self_test(&mut self) -> bool {
        false
    }

    /// The CRC-32 of the program in flash; 0 if unknown.
    fn program() -> u32 {
        0
    }
}
