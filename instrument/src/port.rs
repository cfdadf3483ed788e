//! The instrument's connection to its board.

use crate::plan::Plan;
use crate::slot::Slot;
use crate::storage::Storage;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Blocks, Counters};
use picket_dsp::pipeline::Measurement;
use picket_wire::boot::Clock;
use picket_wire::settings::Settings;
use picket_wire::settings_error::SettingsError;

/// The clocks of a board, once it has started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clocks {
    /// The source of the clock.
    pub source: Clock,
    /// The core's clock, Hz.
    pub core_hz: u32,
    /// The rate of [`Port::ticks`], Hz.
    pub ticks_hz: u32,
}

/// Where the memory of blocks comes back to.
pub trait Slots<const SLOT: usize> {
    /// Takes a block's memory back.
    fn release(&mut self, slot: Slot<SLOT>);
}

impl<const SLOT: usize> Slots<SLOT> for Blocks<'_, Slot<SLOT>> {
    fn release(&mut self, slot: Slot<SLOT>) {
        Blocks::release(self, slot);
    }
}

/// The board as the instrument sees it, where blocks have `N` samples in slots of `SLOT` words: `N` words, and a guard's words if the board
/// has chirps. Every method returns within bounded time.
pub trait Port<const N: usize, const SLOT: usize> {
    /// The name in the boot record: up to 16 letters of ASCII.
    const NAME: &'static str;
    /// The converter's codes, as found in a slot after [`Port::correct`].
    const CODES: Codes;
    /// The board's form of checked settings; `()` if there is none.
    type Words;
    /// Flash, or whatever keeps settings over a restart.
    type Storage: Storage;
    /// Where the memory of blocks comes back to.
    type Slots: Slots<SLOT>;

    /// The plan for these settings and their words on the board, with the clock that a restart with them would give. The plan's codes are
    /// [`Port::CODES`].
    ///
    /// # Errors
    /// The settings cannot work on this board. With [`Settings::worst_case`] a board refuses a rate at which its worst block takes longer
    /// than it lasts, and any rate if that block is unknown.
    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, Self::Words), SettingsError>;

    /// Corrects the samples of a block in place, before it is measured, where the converter needs it.
    fn correct(&self, _: &mut Slot<SLOT>) {}

    /// Widens a measurement's sigma by the part of converter and clock in its error.
    fn widen(&self, _: &mut Measurement) {}

    /// The front end's counters so far.
    fn counters(&self) -> Counters;

    /// Ticks of [`Clocks::ticks_hz`] since the start, modulo 2^32.
    fn ticks(&self) -> u32;

    /// Whether the line has room for this many bytes.
    fn has_room(&self, bytes: usize) -> bool;

    /// Takes a frame whole to be sent and returns true, or drops it and returns false. It never waits.
    fn send(&mut self, frame: &[u8]) -> bool;

    /// Stops the samples until [`Port::resume`], on boards where writing to the storage would hold the core for longer than the blocks can
    /// wait.
    fn pause(&mut self) {}

    /// Starts the samples after [`Port::pause`], at the start of a chirp. Samples that passed meanwhile are counted as lost.
    fn resume(&mut self) {}

    /// Whether the converter's gate was open at any time since the last call, so that blocks are due. Without a gate blocks always are due.
    fn gate_opened(&mut self) -> bool {
        true
    }

    /// Whether bytes wait on the line and none has left since the last call. A board that cannot know returns false.
    fn stalled(&mut self) -> bool {
        false
    }

    /// Feeds the watchdog, which bites four seconds after the last feed.
    fn feed(&mut self) {}

    /// Has the board try itself after the next restart, and returns true; false on a board that cannot.
    fn self_test(&mut self) -> bool {
        false
    }
}
